use picket_claims::scenes::*;
use picket_dsp::tone::observer::Observer;
use picket_dsp::model::Answer;
use picket_dsp::*;
use picket_simulator::scene::*;
use picket_simulator::Value;
use std::cell::Cell;
use std::collections::BTreeMap;
#[derive(Default)]
struct O(Cell<Option<Answer>>);
impl Observer for O { fn joint(&self, a: &Answer) { self.0.set(Some(*a)); } }
const N: usize = 1024;
fn main() {
    let rate: f64 = std::env::args().nth(1).map_or(0.3, |a| a.parse().unwrap());
    let snr: f64 = std::env::args().nth(2).map_or(40.0, |a| a.parse().unwrap());
    let a = 0.6 * amplitude(snr);
    let mut scene = tones(Kind::Iq, N, [line(Value::from(100.0..400.0), a)], deviation(a, snr));
    first(&mut scene).changes.push(Change::Am { depth: Value::from(0.2), rate_hz: Value::from(rate) });
    let plan = picket_dsp::Config::new(N as f64, Codes::signed::<12>()).plan::<Iq, N>().unwrap();
    let mut pipeline = Box::new(Pipeline::<Iq, N, I32>::new(plan));
    let mut all: BTreeMap<String, (usize, f64, f64)> = BTreeMap::new();
    for number in 0..1000 {
        let mut run = scene.run(number).unwrap();
        let codes = run.record(0, N);
        let samples: [_; N] = std::array::from_fn(|n| Iq::from_parts(codes[n]));
        let o = O::default();
        let (_, tone, _) = pipeline.explain(&Stamp::default(), &samples, &o);
        let truth = run.truth(0, scene.start_s(0, N), N);
        let off = tone.frequency.bins(N) - truth.frequency_hz * N as f64 / scene.rate_hz;
        let z = off / (f64::from(tone.sigma) * N as f64);
        let key = match o.0.get() { Some(a) => format!("{:?} moves {} unres {}", a.kept, a.moves, a.unresolved), None => "none".into() };
        let e = all.entry(key).or_default();
        e.0 += 1; e.1 += z * z; e.2 = e.2.max(z.abs());
    }
    for (k, (n, zz, most)) in all { println!("{k}: {n}, z2 {:.2}, max {most:.1}", zz / n as f64); }
}

//! Signals that the search for the worst block varies: numbers, from which a record of codes follows.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use std::fmt;

/// The numbers of a signal: those of [`Signal::NAMES`].
const GENES: usize = 41;

/// A signal: numbers from 0 to 1, each of which one of its parts is scaled by, and the seed of its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    genes: [f64; GENES],
    seed: u64,
}

impl Signal {
    /// What the numbers stand for. A part whose first number is below a half is not there.
    const NAMES: [&str; GENES] = [
        "bin",
        "low",
        "amplitude",
        "phase",
        "noise",
        "colour",
        "drift",
        "drift's size",
        "bend",
        "hum",
        "hum's bin",
        "hum's size",
        "chirp",
        "chirp's bins",
        "AM",
        "AM's rate",
        "AM's depth",
        "FM",
        "FM's rate",
        "FM's bins",
        "wander",
        "wander's size",
        "second line",
        "its bin",
        "its size",
        "third line",
        "its bin",
        "its size",
        "impulses",
        "gain",
        "burst",
        "burst's middle",
        "burst's width",
        "decay",
        "decay's time",
        "settling",
        "settling's time",
        "offset",
        "offset's angle",
        "dead bits",
        "wrapped",
    ];

    /// Any signal.
    pub fn random(rng: &mut ChaCha8Rng) -> Self {
        Self { genes: std::array::from_fn(|_| rng.random()), seed: rng.random() }
    }

    /// A child of two signals: each number of the one or the other, some of them changed, now and then with other noise.
    pub fn child(rng: &mut ChaCha8Rng, one: &Self, other: &Self) -> Self {
        let mixed = rng.random_bool(0.4);
        let genes = std::array::from_fn(|index| {
            let parent = if mixed && rng.random() { other } else { one };
            let (gene, step): (f64, f64) = (parent.genes[index], rng.sample(StandardNormal));
            match rng.random_range(0..20) {
                0 => rng.random(),
                1..=3 => (gene + 0.05 * step).clamp(0.0, 1.0),
                4..=5 => (gene + 0.002 * step).clamp(0.0, 1.0),
                _ => gene,
            }
        });
        Self { genes, seed: if rng.random_bool(0.3) { rng.random() } else { one.seed } }
    }

    /// The record of `n` samples of these codes. The Q part of an I/Q sample is a quarter turn behind, with noise of its own.
    pub fn record<R: Record>(&self, n: usize, codes: Codes) -> Vec<R::Sample> {
        let (lowest, highest) = codes.rails();
        let full = f64::from(highest);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let [
            bin,
            low,
            amplitude,
            phase,
            noise,
            colour,
            drift,
            drift_size,
            bend,
            hum,
            hum_bin,
            hum_size,
            chirp,
            chirp_bins,
            am,
            am_rate,
            am_depth,
            fm,
            fm_rate,
            fm_bins,
            wander,
            wander_size,
            second,
            second_bin,
            second_size,
            third,
            third_bin,
            third_size,
            impulses,
            gain,
            burst,
            burst_middle,
            burst_width,
            decay,
            decay_time,
            settling,
            settling_time,
            offset,
            offset_angle,
            dead_bits,
            wrapped,
        ] = self.genes;
        let half = n as f64 / 2.0;
        let part = |there: f64, size: f64| if there < 0.5 { 0.0 } else { size };
        // Half of the signals are in the lowest 48 bins, down to 0 Hz.
        let bin = if low < 0.5 { 48.0f64.min(half) * bin } else { half * bin };
        let amplitude = full * decades(amplitude, 3.5);
        let turn = TAU * phase;
        let chirp = part(chirp, (chirp_bins - 0.5).powi(3) * 64.0);
        let (am, am_rate) = (part(am, am_depth), 8.0 * am_rate);
        let (fm, fm_rate) = (part(fm, 8.0 * fm_bins.powi(3)), 8.0 * fm_rate);
        let wander = part(wander, decades(wander_size, 4.0));
        let sigma = full * decades(noise, 5.0);
        let pole = 1.9 * (colour - 0.5);
        let drift = part(drift, full * (2.0 * drift_size - 1.0).powi(3));
        let hum = part(hum, full * decades(hum_size, 3.5));
        let lines = [(second, second_bin, second_size), (third, third_bin, third_size)].map(
            |(there, at, size)| {
                // Half of the further lines are beside the first.
                let at = if at < 0.5 { bin + 32.0 * (at - 0.25) } else { half * 2.0 * (at - 0.5) };
                (at, part(there, amplitude * decades(size, 3.0)))
            },
        );
        let width = 2.0 * decades(burst_width, 3.0);
        let decay = part(decay, 1.0 / (2.0 * decades(decay_time, 3.0)));
        let settling = part(settling, full * (2.0 * settling - 1.0));
        let settling_time = decades(settling_time, 3.0);
        // Also above the echo.
        let offset = part(offset, full * (2.0 * offset - 1.0).powi(2));
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let (mut states, mut walk) = ([0.0; 2], 0.0);
        let mut values: Vec<[f64; 2]> = (0..n)
            .map(|index| {
                let time = index as f64 / n as f64;
                walk += wander * normal() / (n as f64).sqrt();
                let turned = TAU * (bin + chirp * (time - 1.0)) * time + turn + walk;
                let modulated = if fm_rate > 0.0 {
                    fm / fm_rate.max(0.1) * (TAU * fm_rate * time).sin()
                } else {
                    0.0
                };
                let envelope = 1.0 + am * (TAU * am_rate * time).cos();
                let away = if burst < 0.5 { 0.0 } else { (time - burst_middle) / width };
                let envelope = envelope * (-0.5 * away * away - decay * time).exp();
                let slow = drift * (time - 0.5 + 4.0 * (bend - 0.5) * (time - 0.5).powi(2));
                let slow = slow + hum * (TAU * 6.0 * hum_bin * time).sin();
                let slow = slow + settling * (-time / settling_time).exp();
                let mut part = |state: &mut f64, back: f64| {
                    *state = pole * *state + sigma * normal();
                    let tone = amplitude * envelope * (turned + modulated - back).cos();
                    let beside: f64 =
                        lines.iter().map(|(at, size)| size * (TAU * at * time - back).cos()).sum();
                    let still = offset * (TAU * offset_angle - back).cos();
                    tone + beside + slow + still + *state
                };
                let [i, q] = &mut states;
                [part(i, 0.0), if R::IQ { part(q, TAU / 4.0) } else { 0.0 }]
            })
            .collect();
        let hits = part(impulses, 16.0 * (impulses - 0.5)) as usize;
        for _ in 0..hits {
            // Anywhere, and as large as the record is at the most.
            let at = (normal().abs() * half) as usize;
            if let Some(value) = values.get_mut(at) {
                value[0] += full * (0.5 * normal()).clamp(-1.0, 1.0);
            }
        }
        // Up to eight times too much, down to a code or two.
        let gain =
            if gain > 0.8 { 1.0 + 35.0 * (gain - 0.8) } else { 1.0f64.min(gain / 0.4).powi(4) };
        // Up to five low bits stand still. Codes that wrap are those of an adder without saturation.
        let step = f64::from(1i32 << part(dead_bits, 10.0 * (dead_bits - 0.5)) as u32);
        let (low, high) = (f64::from(lowest), f64::from(highest));
        let code = |x: f64| {
            let whole = (gain * x / step).round() * step;
            let held = if wrapped < 0.9 {
                whole
            } else {
                (whole - low).rem_euclid(2.0 * full + 2.0) + low
            };
            held.clamp(low, high) as i16
        };
        values.iter().map(|parts| R::from_parts(parts.map(code))).collect()
    }
}

/// From 1 down by this many decades.
fn decades(gene: f64, count: f64) -> f64 {
    10f64.powf(-count * (1.0 - gene))
}

impl fmt::Display for Signal {
    /// The numbers, and the seed of the noise.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, gene) in Self::NAMES.iter().zip(self.genes) {
            write!(f, "{name} {gene:.4}, ")?;
        }
        write!(f, "seed {}", self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::sample::{Iq, Real};

    const CODES: Codes = Codes::signed::<16>();

    /// The generator leaves no kind of record out: the lowest bins, rails, next to nothing, and what changes within a record.
    #[test]
    fn signals_are_of_every_kind() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let records: Vec<_> = (0..2000)
            .map(|_| Signal::random(&mut rng))
            .map(|signal| signal.record::<Real>(256, Codes::signed::<12>()))
            .collect();
        let (low, high) = Codes::signed::<12>().rails();
        let share = |test: &dyn Fn(&[i16]) -> bool| {
            records.iter().filter(|record| test(record)).count() as f64 / records.len() as f64
        };
        let span = |record: &[i16]| record.iter().max().unwrap() - record.iter().min().unwrap();
        let crossings =
            |record: &[i16]| record.windows(2).filter(|x| (x[0] < 0) != (x[1] < 0)).count();
        let clipped = |record: &[i16]| record.iter().any(|x| [low, high].contains(x));
        assert!((0.05..0.5).contains(&share(&clipped)), "{}", share(&clipped));
        assert!(share(&|record| span(record) <= 2) > 0.03);
        assert!(share(&|record| span(record) > 20 && crossings(record) <= 8) > 0.03);
        assert!(share(&|record| span(record) > 20 && crossings(record) > 128) > 0.03);
    }

    #[test]
    fn a_record_is_the_same_for_the_same_signal() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let [one, other] = [(); 2].map(|()| Signal::random(&mut rng));
        assert_eq!(one.record::<Iq>(64, CODES), one.clone().record::<Iq>(64, CODES));
        let child = Signal::child(&mut rng, &one, &other);
        assert!(child.genes.iter().all(|gene| (0.0..=1.0).contains(gene)), "{child}");
    }
}

//! Every estimator but least squares against the reference's golden records, in three arithmetics.
//!
//! The records are integer ADC codes. `f64` must give the reference's answer within 1e-9 bin (the host's
//! iterative references within 1e-6). `f32` and the target's arithmetic (integer FFT, then integers or
//! `f32`) are measured by the Cramer-Rao bound. The bound's noise is the noise added and that of
//! rounding to codes, 1/12 per part: so it has a value for noise-free records as well, where it is
//! the error that a user of these codes must expect anyway. The target is held to the bound at 60 dB
//! at most: at the 74 dB of a noise-free full-scale record the twiddle factors of the FFT, 16 bits
//! wide, err more than the codes do.

use crate::vectors::{Case, golden};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Data, Iq, Real, Record};
use picket_dsp::math::scalar::Scalar;
use picket_dsp::methods::autocorrelation::best_lag;
use picket_dsp::methods::registry::Method;
use picket_dsp::methods::samples::Raw;
use picket_dsp::methods::snr;
use picket_dsp::solve::chirp::{self, Scale, Shape};
use picket_dsp::solve::equations::Equations;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_dsp::spectrum::peak::{self, Band};
use picket_dsp::tone::fit::Reach;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::sigma::bound_bins;
use picket_dsp::tone::{Tone, Verdict};
use picket_host::arithmetic::whole;
use picket_host::estimator::{Estimator, parse};
use picket_host::reference::Reference;
use picket_host::simulate::Kind;
use picket_lab::exact::{Numbers, frequencies};
use picket_transform::{Transform, num_complex::Complex};
use std::collections::BTreeMap;

/// The reference's names, and ours. Least squares, of which the reference takes a fixed number of steps, has a
/// test of its own.
const NAMES: &[(&str, &str)] = &[
    ("rife", "rife"),
    ("zrife", "z-rife"),
    ("aprife", "a-p-rife"),
    ("irife", "i-rife"),
    ("dtrife", "dual-threshold-rife"),
    ("quinn1", "quinn1"),
    ("quinn2", "quinn2"),
    ("jacobsen", "jacobsen"),
    ("candan13", "candan"),
    ("macleod", "macleod"),
    ("parab_log", "parabolic"),
    ("am2", "aboutanios-mulgrew"),
    ("haqse", "haqse"),
    ("aa_n3", "autocorrelation"),
    ("iaa", "improved-autocorrelation"),
    ("fesa", "fesa"),
    ("fesa_2n3", "fesa-corrected"),
    ("hann_grandke", "grandke"),
];

/// The references of the host; on real records the reference's likelihood is called nlls.
const REFERENCES: &[(&str, &str)] =
    &[("kay", "kay"), ("fitz", "fitz"), ("ml", "ml"), ("nlls", "ml")];

/// The offset in one kind of float on the bins of an exact transform.
fn float<T: Scalar, R: Record>(
    method: Method,
    spectrum: &[Complex<f64>],
    samples: &[R::Sample],
    peak: i32,
) -> f64 {
    let narrow = |x: Complex<f64>| Complex::new(T::new(x.re), T::new(x.im));
    let bins = Bins::<T, R, Rectangular>::gather(samples.len(), peak, |k| narrow(spectrum[k]));
    let power = |k: i32| T::new(spectrum[k as usize].norm_sqr());
    method.offset(&bins, &Raw::<R>(samples), power).unwrap().wide()
}

/// Sums of squared errors, and the worst, in bounds.
#[derive(Default)]
struct Errors {
    squares: f64,
    count: f64,
    worst: f64,
}

impl Errors {
    fn push(&mut self, error: f64) {
        self.squares += error * error;
        self.count += 1.0;
        self.worst = self.worst.max(error.abs());
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

#[derive(Default)]
struct Table {
    double: f64,
    single: Errors,
    target: Errors,
}

fn wrap(error: f64, n: usize) -> f64 {
    let n = n as f64;
    (error + n / 2.0).rem_euclid(n) - n / 2.0
}

/// The noise of a case over its tone, both in power. Rounding adds 1/12 to the power of each part:
/// `amp^2 / (2/12)` and `(amp^2 / 2) / (1/12)` alike.
fn noise(case: &Case) -> f64 {
    1.0 / (6.0 * case.amp * case.amp) + case.snr_db.map_or(0.0, |db| 10f64.powf(-db / 10.0))
}

fn check<R: Record, const N: usize>(
    case: &Case,
    samples: &[R::Sample; N],
    tables: &mut BTreeMap<(bool, &str), Table>,
) {
    let mut exact: Vec<Complex<f64>> = samples
        .iter()
        .map(|&s| R::parts(s))
        .map(|[i, q]| Complex::new(i.into(), q.into()))
        .collect();
    f64::forward(N).process(&mut exact);
    let mut integer = Spectrum::<R, N>::new();
    integer.transform(samples, Codes::signed::<12>());
    let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
    assert_eq!(peak::find(&integer.view(), band).unwrap().bin, case.km, "{}: peak", case.id);
    if let Some(db) = case.snr13_db {
        let ratio = snr::parseval(N, case.km, |k| exact[k as usize].norm_sqr());
        assert!((10.0 * ratio.log10() - db).abs() < 1e-6, "{}: Parseval's ratio", case.id);
    }
    let noise = noise(case);
    let [bound, target_bound] =
        [noise, noise.max(1e-6)].map(|noise| f64::from(bound_bins(R::IQ, N, (1.0 / noise) as f32)));
    for &(theirs, name) in NAMES {
        let Some(&Some(expected)) = case.expect_bins.get(theirs) else {
            continue;
        };
        let method = Method::from_name(name).unwrap();
        let table = tables.entry((R::IQ, name)).or_default();
        let error = |offset: f64| wrap(f64::from(case.km) + offset - expected, N);
        let double = error(float::<f64, R>(method, &exact, samples, case.km));
        table.double = table.double.max(double.abs());
        table.single.push(error(float::<f32, R>(method, &exact, samples, case.km)) / bound);
        let target =
            method.offset_target(&integer.view(), Data::of::<R>(samples), case.km).unwrap();
        table.target.push(error(target.to_num()) / target_bound);
    }
    for &(theirs, name) in REFERENCES {
        let Some(&Some(expected)) = case.expect_bins.get(theirs) else {
            continue;
        };
        let found = Reference::from_name(name).unwrap().codes::<R>(samples).unwrap();
        let error = wrap(found - expected, N);
        assert!(error.abs() < 1e-6, "{} {name}: {error:e} bin", case.id);
    }
}

#[test]
fn every_estimator_on_every_record() {
    let golden = golden();
    let mut tables = BTreeMap::new();
    for case in &golden.cases {
        match (case.kind.as_str(), case.n) {
            ("r", 64) => check::<Real, 64>(case, &case.samples::<Real, 64>(), &mut tables),
            ("r", 256) => check::<Real, 256>(case, &case.samples::<Real, 256>(), &mut tables),
            ("c", 64) => check::<Iq, 64>(case, &case.samples::<Iq, 64>(), &mut tables),
            ("c", 256) => check::<Iq, 256>(case, &case.samples::<Iq, 256>(), &mut tables),
            (kind, n) => panic!("{}: no such record: {kind} {n}", case.id),
        }
    }
    println!("method                   iq     f64 bin  f32 worst  target rms  worst (in bounds)");
    for ((iq, name), t) in &tables {
        println!(
            "{name:24} {iq:5} {:9.1e} {:9.4} {:9.3} {:9.3}",
            t.double,
            t.single.worst,
            t.target.rms(),
            t.target.worst
        );
    }
    for ((iq, name), t) in &tables {
        assert_eq!(t.target.count, 30.0, "{name}, iq {iq}: records");
        assert!(t.double < 1e-9, "{name}, iq {iq}: {:e} bin in f64", t.double);
        assert!(t.single.worst < 0.05, "{name}, iq {iq}: {} bounds in f32", t.single.worst);
        assert!(t.target.worst < 0.4, "{name}, iq {iq}: {} bounds on the target", t.target.worst);
        assert!(t.target.rms() < 0.1, "{name}, iq {iq}: {} bounds rms", t.target.rms());
    }
    for &(_, name) in NAMES {
        assert!(tables.keys().any(|&(_, seen)| seen == name), "no record tries {name}");
    }
}

fn exact<R: Kind>(case: &Case, estimators: &[Estimator]) -> Vec<f64> {
    let plan = whole::<R>(case.n, Codes::signed::<12>()).unwrap();
    let mut exact = frequencies::<R>(Numbers::F64, case.n, plan).unwrap();
    exact.frequencies(&case.values(), estimators)
}

/// Every method on the golden records by the exact transform that sweeps use. Least squares, which here takes its own start and as many
/// steps as it needs, is within a twentieth of the bound of the reference's three (I/Q: two) steps.
#[test]
fn every_estimator_on_an_exact_transform() {
    let golden = golden();
    for iq in [false, true] {
        let cases: Vec<&Case> = golden.cases.iter().filter(|case| case.iq() == iq).collect();
        let own =
            if iq { [("lsi16_2", "least-squares")] } else { [("rlsi16_3", "least-squares-real")] };
        let named = NAMES.iter().chain(REFERENCES).chain(&own);
        let names: Vec<_> = named
            .filter(|(theirs, _)| {
                cases.iter().all(|case| case.expect_bins.get(*theirs).is_some_and(Option::is_some))
            })
            .collect();
        let methods: Vec<&str> = names.iter().map(|(_, name)| *name).collect();
        let estimators = parse(&methods.join(","), Reach::Sixteen).unwrap();
        for case in &cases {
            let found =
                if iq { exact::<Iq>(case, &estimators) } else { exact::<Real>(case, &estimators) };
            for (bins, (theirs, name)) in found.into_iter().zip(&names) {
                let error = wrap(bins - case.expect_bins[*theirs].unwrap(), case.n);
                let snr = (1.0 / noise(case)) as f32;
                let bound = bound_bins(iq, case.n, snr);
                let allowed = match *name {
                    "kay" | "fitz" | "ml" => 1e-6,
                    "least-squares" | "least-squares-real" => 0.05 * f64::from(bound),
                    _ => 1e-9,
                };
                assert!(error.abs() < allowed, "{} {name}: {error:e} bin", case.id);
            }
        }
        println!("iq {iq}: {} records by {}", cases.len(), methods.join(" "));
    }
}

#[test]
fn the_best_lag_is_eq_9() {
    let golden = golden();
    for lag in &golden.m_opt {
        assert_eq!(best_lag(lag.snr, lag.n), lag.m, "snr {}, n {}", lag.snr, lag.n);
        assert_eq!(best_lag(lag.snr as f32, lag.n), lag.m, "snr {}, n {} in f32", lag.snr, lag.n);
    }
}

/// The waveform of Table 3: 1550 nm, 1 GHz in 10 us, 250 MS/s.
#[test]
fn the_solver_on_every_vector() {
    let golden = golden();
    let rate = 250e6;
    let range = rate * 299_792_458.0 * 10e-6 / (2.0 * 1e9);
    let velocity = rate * 1550e-9 / 2.0;
    let scales = |weights: [f64; 2]| weights.map(|weight| Scale::new(weight).unwrap());
    // The vectors have one carrier, and a range that stands still: `fR - fD, -fD, -(fR + fD)`.
    let equations = Equations {
        edge: 0.0,
        shape: Shape::Trapezoid,
        range: scales([0.5 * range, -0.5 * range]),
        velocity: scales([-0.5 * velocity; 2]),
        condition: scales([-2.0, 1.0]),
        ..Equations::default()
    };
    for beats in &golden.solver {
        let tones = [beats.f1_hz, beats.f2_hz, beats.f3_hz].map(|hz| Tone {
            frequency: Frequency::from_bins(0, hz / rate, 1).unwrap(),
            sigma: 1e-6,
            snr: 1.0,
            amplitude: 1.0,
            verdict: Verdict::Good,
            rate_hz: rate,
            ..Tone::default()
        });
        let target = chirp::trapezoid(&tones, false, &equations);
        let (range, velocity) =
            (target.range.to_num::<f64>(), target.velocity.unwrap().to_num::<f64>());
        assert!((range / beats.L_m - 1.0).abs() < 1e-6, "{range} m, not {}", beats.L_m);
        assert!((velocity / beats.V_mps - 1.0).abs() < 1e-6, "{velocity} m/s, not {}", beats.V_mps);
    }
}

//! From a record to answers in a choice of arithmetic: floats of either width on an exact
//! transform, or the target's integers. The estimators are the core's in every case.

mod explained;
mod floats;
mod target;

pub use explained::{Explained, Fitted, Note};

use crate::estimator::Estimator;
use crate::recording::Sample;
use crate::simulate::Kind;
use floats::Floats;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::plan::Terms;
use picket_dsp::spectrum::fft::twiddle::{MAX_LENGTH, supported};
use picket_dsp::tone::{Verdict, Verdicts};
use picket_dsp::tone::{arithmetic, measure};
use picket_transform::num_complex::Complex;
use std::fmt::Debug;
use target::Target;

/// Runs `$body` with `$kind` standing for the kind of record that a flag names.
#[macro_export]
macro_rules! with_kind {
    ($iq:expr, $kind:ident => $body:expr) => {
        if $iq {
            type $kind = picket_dsp::acquire::sample::Iq;
            $body
        } else {
            type $kind = picket_dsp::acquire::sample::Real;
            $body
        }
    };
}

/// In which numbers a record is worked on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Arithmetic {
    /// 64-bit floats throughout.
    #[default]
    F64,
    /// 32-bit floats throughout.
    F32,
    /// The firmware's: integer FFT, then integers (rife, z-rife) or 32-bit floats over a few bins.
    Target,
    /// The firmware's on cores without an FPU: integers also in the sums of least squares.
    TargetFixed,
}

impl Arithmetic {
    /// What the user types.
    pub const fn name(self) -> &'static str {
        match self {
            Arithmetic::F64 => "f64",
            Arithmetic::F32 => "f32",
            Arithmetic::Target => "target",
            Arithmetic::TargetFixed => "target-fixed",
        }
    }

    /// True where samples are the converter's codes.
    pub const fn integer(self) -> bool {
        matches!(self, Arithmetic::Target | Arithmetic::TargetFixed)
    }

    /// The core's arithmetic between the integer FFT and the answer.
    const fn after_the_fft(self) -> arithmetic::Arithmetic {
        match self {
            Arithmetic::TargetFixed => arithmetic::Arithmetic::Fixed,
            _ => arithmetic::Arithmetic::Float,
        }
    }

    /// An error, in one line, if `estimator` has no form in this arithmetic.
    pub fn check(self, estimator: Estimator) -> Result<(), String> {
        let name = estimator.name();
        match (self, estimator) {
            (Arithmetic::F64, _) => Ok(()),
            (_, Estimator::Host(_)) => {
                Err(format!("{name} is a reference of the host: it needs --arith f64"))
            }
            (Arithmetic::TargetFixed, Estimator::Core { method, .. })
                if !IN_INTEGERS.contains(&method) =>
            {
                Err(format!(
                    "{name} has no form in integers: use least squares, rife or z-rife, or --arith target"
                ))
            }
            _ => Ok(()),
        }
    }
}

/// The methods whose loops over bins have a form in integers.
const IN_INTEGERS: [Method; 4] =
    [Method::Rife, Method::ZRife, Method::LeastSquares, Method::LeastSquaresReal];

/// What a record showed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The frequency in bins: 0..N for I/Q records, 0..N/2 for real ones.
    pub bins: f64,
    /// One standard deviation of it, in bins.
    pub sigma_bins: f64,
    /// Signal-to-noise ratio per sample in dB.
    pub snr_db: f64,
    /// Whether it may be used.
    pub verdict: Verdict,
    /// What applies besides.
    pub also: Verdicts,
}

impl Estimate {
    pub(crate) const NOTHING: Estimate = Estimate {
        bins: f64::NAN,
        sigma_bins: f64::NAN,
        snr_db: f64::NAN,
        verdict: Verdict::NoSignal,
        also: Verdicts::NONE,
    };
}

/// Works on records of one length and kind.
pub trait Engine: Debug + Send {
    /// The frequency of a record in bins by every method, and nothing else; NaN without a signal.
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64>;
    /// Every method's answer with what a reader needs to trust it. `gap` where samples are missing
    /// before the record.
    fn measure(
        &mut self,
        record: &[Complex<f64>],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate>;
    /// [`Engine::measure`] of a recording's samples.
    fn measure_samples(
        &mut self,
        samples: &[Sample],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        let record: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        self.measure(&record, estimators, gap)
    }
    /// One method's answer with every test behind its verdict.
    fn explain(&mut self, record: &[Complex<f64>], estimator: Estimator) -> Explained;
}

/// The shortest record.
pub const SHORTEST: usize = 16;
/// The longest record.
pub const LONGEST: usize = 1 << 22;

/// An engine for records of kind `R` and `n` samples. Every estimator must be right for the kind and
/// the arithmetic.
pub fn engine<R: Kind>(
    arithmetic: Arithmetic,
    n: usize,
    plan: Terms,
) -> Result<Box<dyn Engine>, String> {
    build(R::IQ, arithmetic, n, plan)
}

/// [`engine`], not generic: all kinds and lengths are compiled here, once, and not by every caller.
fn build(
    iq: bool,
    arithmetic: Arithmetic,
    n: usize,
    plan: Terms,
) -> Result<Box<dyn Engine>, String> {
    if !(SHORTEST..=LONGEST).contains(&n) {
        return Err(format!("N = {n}: choose {SHORTEST} to {LONGEST} samples"));
    }
    if arithmetic.integer() && !supported(n) {
        return Err(format!(
            "N = {n}: the target's FFT takes 64, 128, ... {MAX_LENGTH}: choose one or --arith f64"
        ));
    }
    let options = measure::Options { arithmetic: arithmetic.after_the_fft(), ..plan.options };
    let plan = Terms { options, ..plan };
    Ok(with_kind!(iq, R => match (arithmetic, n) {
        (Arithmetic::F64, _) => Box::new(Floats::<f64, R>::new(n, plan)),
        (Arithmetic::F32, _) => Box::new(Floats::<f32, R>::new(n, plan)),
        (_, 64) => Target::<R, 64>::boxed(plan)?,
        (_, 128) => Target::<R, 128>::boxed(plan)?,
        (_, 256) => Target::<R, 256>::boxed(plan)?,
        (_, 512) => Target::<R, 512>::boxed(plan)?,
        (_, 1024) => Target::<R, 1024>::boxed(plan)?,
        (_, 2048) => Target::<R, 2048>::boxed(plan)?,
        _ => Target::<R, 4096>::boxed(plan)?,
    }))
}

/// A frequency in the range that estimates are given in.
fn within<R: Record>(bins: f64, n: usize) -> f64 {
    if R::IQ { bins.rem_euclid(n as f64) } else { bins }
}

/// A search of the whole band of a record, for codes of this width.
pub fn whole<R: Record>(n: usize, codes: Codes) -> Result<Terms, String> {
    Config::new(1.0, codes).terms::<R>(n).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::parse;
    use crate::simulate::{Line, Signal, generator};
    use picket_dsp::acquire::sample::{Iq, Real};
    use picket_dsp::tone::fit::Reach;

    fn answers<R: Kind>(arithmetic: Arithmetic, trial: u64) -> Vec<Estimate> {
        // Seed 3: 40 dB of noise, bound 2e-4 bins.
        let record = Signal::tone(100.3, 1500.0, 40.0).record::<R>(1024, &mut generator(3, trial));
        let best = Estimator::best(R::IQ, Reach::Sixteen).name();
        let third = if arithmetic == Arithmetic::TargetFixed { "rife" } else { "candan" };
        let methods = parse(&format!("{best},z-rife,{third}"), Reach::Sixteen).unwrap();
        let plan = whole::<R>(1024, Codes::signed::<12>()).unwrap();
        let mut engine = engine::<R>(arithmetic, 1024, plan).unwrap();
        let quick = engine.frequencies(&record, &methods);
        let full = engine.measure(&record, &methods, false);
        assert!(
            quick.iter().zip(&full).all(|(q, f)| (q - f.bins).abs() < 1e-6),
            "{quick:?} {full:?}"
        );
        full
    }

    #[test]
    fn every_arithmetic_finds_the_tone() {
        use Arithmetic::*;
        for arithmetic in [F64, F32, Target, TargetFixed] {
            for iq in [false, true] {
                // The ratio of one record scatters by .9 dB.
                let (mut mean_db, mut sigmas) = (0.0, Vec::new());
                for trial in 0..16 {
                    let answers = with_kind!(iq, R => answers::<R>(arithmetic, trial));
                    for answer in &answers {
                        assert!((answer.bins - 100.3).abs() < 2e-3, "{arithmetic:?} {answers:?}");
                        assert_eq!(answer.verdict, Verdict::Good);
                    }
                    mean_db += answers[0].snr_db / 16.0;
                    sigmas.push(answers[0].sigma_bins);
                }
                assert!((mean_db - 40.0).abs() < 1.0, "{arithmetic:?} {mean_db}");
                // A first look that noise exceeds widens some.
                sigmas.sort_by(f64::total_cmp);
                assert!((1e-4..3e-4).contains(&sigmas[8]), "{arithmetic:?} {sigmas:?}");
            }
        }
    }

    /// Every verdict that one record can have, alike in every arithmetic.
    #[test]
    fn verdicts_agree() {
        use Arithmetic::*;
        let plan = whole::<Real>(1024, Codes::signed::<12>()).unwrap();
        let best = [Estimator::best(false, Reach::Sixteen)];
        let of = |bins: f64, amplitude: f64, gap: bool, second: f64| {
            let mut signal = Signal::tone(bins, amplitude, 40.0);
            signal.lines[0].phase = Some(0.4);
            let line = Line { bins: bins + 1.5, amplitude: second, phase: Some(1.0) };
            signal.lines.push(line);
            let record = signal.record::<Real>(1024, &mut generator(5, 0));
            [F64, F32, Target, TargetFixed].map(|arithmetic| {
                let mut engine = engine::<Real>(arithmetic, 1024, plan).unwrap();
                engine.measure(&record, &best, gap)[0].verdict
            })
        };
        assert_eq!(of(100.3, 1000.0, false, 0.0), [Verdict::Good; 4]);
        assert_eq!(of(1.2, 1000.0, false, 0.0), [Verdict::NearEdge; 4]);
        assert_eq!(of(100.3, 2300.0, false, 0.0), [Verdict::Clipped; 4]);
        assert_eq!(of(100.3, 1000.0, false, 500.0), [Verdict::Unresolved; 4]);
        assert_eq!(of(100.3, 1000.0, true, 0.0), [Verdict::Gap; 4]);
    }

    /// A tone of which the rails cut some part, at lengths of every form: each accepted one is measured, and is measured right.
    #[test]
    fn every_length_measures_a_clipped_tone() {
        let of = |n: usize, iq: bool, arithmetic: Arithmetic| {
            // Seed 45: one in twelve samples is at a rail. The tone is no simple fraction of the rate.
            let (bins, seed) = (0.1234 * n as f64, n as u64);
            let mut generator = generator(45, seed);
            with_kind!(iq, R => {
                let record = Signal::tone(bins, 2065.0, 40.0).record::<R>(n, &mut generator);
                let plan = whole::<R>(n, Codes::signed::<12>()).unwrap();
                let mut engine = engine::<R>(arithmetic, n, plan).unwrap();
                let found = engine.measure(&record, &[Estimator::best(iq, Reach::Sixteen)], false);
                (found[0], (found[0].bins - bins) / found[0].sigma_bins)
            })
        };
        let odd = [2047, 3000, 4095, 5000, 6144, 8192, 10_000, 32_768, 40_000, 65_536, 100_000];
        for (iq, arithmetic) in [(false, Arithmetic::F64), (true, Arithmetic::F32)] {
            let (mut count, mut sum, mut refused) = (0, 0.0, 0);
            for n in (SHORTEST..1100).chain(odd) {
                let (found, deviations) = of(n, iq, arithmetic);
                // Shorter records have too few bins for a verdict.
                if n < 64 {
                    continue;
                }
                // One record in a thousand is refused: by chance it looks like two lines.
                refused += i32::from(found.verdict == Verdict::Unresolved);
                let clips = matches!(found.verdict, Verdict::Clipped | Verdict::Unresolved);
                assert!(clips, "{n} {iq}: {found:?}");
                assert!(deviations.abs() < 5.0, "{n} {iq}: {deviations} sigma, {found:?}");
                count += 1;
                sum += deviations * deviations;
            }
            let rms = (sum / f64::from(count)).sqrt();
            println!("I/Q {iq}: rms {rms}, {refused} of {count} refused");
            assert!(refused <= 5, "I/Q {iq}: {refused} of {count} refused");
            assert!((0.6..1.1).contains(&rms), "I/Q {iq}: rms of error over sigma {rms}");
        }
    }

    #[test]
    fn what_cannot_be_done_is_said() {
        let plan = whole::<Real>(1000, Codes::signed::<12>()).unwrap();
        assert!(engine::<Real>(Arithmetic::F64, 1000, plan).is_ok());
        assert!(engine::<Real>(Arithmetic::Target, 1000, plan).is_err());
        assert!(engine::<Real>(Arithmetic::F64, 3, plan).is_err());
        let fesa = Estimator::from_name("fesa", Reach::Sixteen).unwrap();
        assert!(fesa.check::<Real>().is_err() && fesa.check::<Iq>().is_ok());
        assert!(Arithmetic::TargetFixed.check(fesa).is_err());
        assert!(Estimator::from_name("fase", Reach::Sixteen).is_err());
    }
}

//! From a record to answers as boards give them, in the library's choice of arithmetic.

mod explained;
mod target;

pub use explained::{Explained, Fitted, Note};

use crate::estimator::Estimator;
use crate::recording::Sample;
use crate::simulate::Kind;
use crate::{length, with_record};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::plan::Terms;
use picket_dsp::tone::arithmetic;
use picket_dsp::tone::options::Options;
use picket_dsp::tone::{Verdict, Verdicts};
use picket_transform::num_complex::Complex;
use std::fmt::Debug;
use target::Target;

/// The arithmetic after the integer transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Arithmetic {
    /// That of cores with an FPU: 32-bit floats over a few bins.
    #[default]
    Target,
    /// That of cores without one: integers in the sums of least squares.
    TargetFixed,
}

impl Arithmetic {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Target, Self::TargetFixed];

    /// What the user types.
    pub const fn name(self) -> &'static str {
        match self {
            Arithmetic::Target => "target",
            Arithmetic::TargetFixed => "target-fixed",
        }
    }

    /// The library's name of it.
    const fn of_library(self) -> arithmetic::Arithmetic {
        match self {
            Arithmetic::Target => arithmetic::Arithmetic::Float,
            Arithmetic::TargetFixed => arithmetic::Arithmetic::Fixed,
        }
    }

    /// An error, in one line, if `estimator` has no form in this arithmetic.
    pub fn check(self, estimator: Estimator) -> Result<(), String> {
        let name = estimator.name();
        match (self, estimator) {
            (_, Estimator::Host(_)) => Err(format!(
                "{name} is a reference in 64-bit floats: cargo lab sweep --arith f64 has it"
            )),
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

/// Finds frequencies in records of one length and kind.
pub trait Frequencies: Debug + Send {
    /// The frequency of a record in bins by every method, and nothing else; NaN without a signal.
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64>;
}

/// Measures records of one length and kind.
pub trait Engine: Frequencies {
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

/// An engine for records of kind `R` and `n` samples. Every estimator must be right for the kind and
/// the arithmetic.
///
/// # Errors
/// There is no such length.
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
    length::check(n)?;
    let options = Options { arithmetic: arithmetic.of_library(), ..plan.options };
    let plan = Terms { options, ..plan };
    with_record!(iq, n, R, N => Target::<R, N>::boxed(plan))
}

/// A frequency in the range that estimates are given in.
pub fn within<R: Record>(bins: f64, n: usize) -> f64 {
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
    use crate::with_kind;
    use picket_dsp::acquire::sample::{Iq, Real};
    use picket_dsp::tone::effort::Effort;
    use picket_dsp::tone::fit::Reach;

    fn answers<R: Kind>(arithmetic: Arithmetic, trial: u64) -> Vec<Estimate> {
        // Seed 3: 40 dB of noise, bound 2e-4 bins.
        let record = Signal::tone(100.3, 1500.0, 40.0).record::<R>(1024, &mut generator(3, trial));
        let best = Estimator::best(R::IQ, Reach::Sixteen).name();
        let third = if arithmetic == Arithmetic::TargetFixed { "rife" } else { "candan" };
        let methods = parse(&format!("{best},z-rife,{third}"), Reach::Sixteen).unwrap();
        let plan = whole::<R>(1024, Codes::signed::<12>()).unwrap();
        // A frequency alone is the first look's.
        let options = Options { effort: Effort::LOOK, ..plan.options };
        let mut engine = engine::<R>(arithmetic, 1024, Terms { options, ..plan }).unwrap();
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
        for arithmetic in Arithmetic::ALL {
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
        let plan = whole::<Real>(1024, Codes::signed::<12>()).unwrap();
        let best = [Estimator::best(false, Reach::Sixteen)];
        let of = |bins: f64, amplitude: f64, gap: bool, second: f64| {
            let mut signal = Signal::tone(bins, amplitude, 40.0);
            signal.lines[0].phase = Some(0.4);
            let line = Line { bins: bins + 1.5, amplitude: second, phase: Some(1.0) };
            signal.lines.push(line);
            let record = signal.record::<Real>(1024, &mut generator(5, 0));
            Arithmetic::ALL.map(|arithmetic| {
                let mut engine = engine::<Real>(arithmetic, 1024, plan).unwrap();
                engine.measure(&record, &best, gap)[0].verdict
            })
        };
        assert_eq!(of(100.3, 1000.0, false, 0.0), [Verdict::Good; 2]);
        assert_eq!(of(1.2, 1000.0, false, 0.0), [Verdict::NearEdge; 2]);
        assert_eq!(of(100.3, 2300.0, false, 0.0), [Verdict::Clipped; 2]);
        // So near a line looks like a change.
        assert_eq!(of(100.3, 1000.0, false, 500.0), [Verdict::Moving; 2]);
        assert_eq!(of(100.3, 1000.0, true, 0.0), [Verdict::Gap; 2]);
    }

    /// A tone that the rails clip in part, at every length: each is measured, and measured right.
    #[test]
    fn every_length_measures_a_clipped_tone() {
        let of = |n: usize, iq: bool, arithmetic: Arithmetic, trial: u64| {
            // Seed 45: one in twelve samples is at a rail. The tone is no simple fraction of the rate.
            let mut generator = generator(45, trial);
            let bins = 0.1234 * n as f64;
            with_kind!(iq, R => {
                let record = Signal::tone(bins, 2065.0, 40.0).record::<R>(n, &mut generator);
                let plan = whole::<R>(n, Codes::signed::<12>()).unwrap();
                let mut engine = engine::<R>(arithmetic, n, plan).unwrap();
                let found = engine.measure(&record, &[Estimator::best(iq, Reach::Sixteen)], false);
                (found[0], (found[0].bins - bins) / found[0].sigma_bins)
            })
        };
        for (iq, arithmetic) in [(false, Arithmetic::Target), (true, Arithmetic::TargetFixed)] {
            let (mut count, mut sum, mut refused) = (0, 0.0, 0);
            for (n, trial) in
                length::LENGTHS.into_iter().flat_map(|n| (0..150).map(move |t| (n, t)))
            {
                let (found, deviations) = of(n, iq, arithmetic, trial);
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
        assert!(engine::<Real>(Arithmetic::Target, 1000, plan).is_err());
        let fesa = Estimator::from_name("fesa", Reach::Sixteen).unwrap();
        assert!(fesa.check::<Real>().is_err() && fesa.check::<Iq>().is_ok());
        assert!(Arithmetic::TargetFixed.check(fesa).is_err());
        assert!(Estimator::from_name("fase", Reach::Sixteen).is_err());
    }
}

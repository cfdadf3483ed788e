//! From a record to answers in a choice of arithmetic: floats of either width on an exact
//! transform, or the target's integers. The estimators are the core's in every case.

use crate::estimator::{Estimator, reached};
use crate::simulate::{Kind, codes};
use fixed::types::I2F30;
use picket::acquire::sample::{Codes, Record, Stamp, Statistics};
use picket::config::{Config, Plan};
use picket::estimate::least_squares::{Course, Reach, fit};
use picket::estimate::measure::Options;
use picket::estimate::method::Method;
use picket::estimate::tone::Verdict;
use picket::estimate::uncertainty::{CLIPPED, bound_bins, sigma_bins};
use picket::pipeline::Pipeline;
use picket::scalar::Scalar;
use picket::spectrum::bins::{Bins, Rectangular};
use picket::spectrum::fft::twiddle::supported;
use picket::spectrum::peak::{self, Band, Peak, Search};
use picket::spectrum::{Spectrum, fft};
use picket_transform::{Fft, Transform, num_complex::Complex};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;

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
    /// Integers from samples to answer (rife and z-rife).
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

    /// An error, in one line, if `estimator` has no form in this arithmetic.
    pub fn check(self, estimator: Estimator) -> Result<(), String> {
        let name = estimator.name();
        match (self, estimator) {
            (
                Arithmetic::F32 | Arithmetic::Target | Arithmetic::TargetFixed,
                Estimator::Host(_),
            ) => Err(format!("{name} is a reference of the host: it needs --arith f64")),
            (
                Arithmetic::TargetFixed,
                Estimator::Core { method: Method::Rife | Method::ZRife, .. },
            ) => Ok(()),
            (Arithmetic::TargetFixed, _) => Err(format!(
                "{name} has no form in integers throughout: use rife or z-rife, or --arith target"
            )),
            _ => Ok(()),
        }
    }
}

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
}

impl Estimate {
    const NOTHING: Estimate = Estimate {
        bins: f64::NAN,
        sigma_bins: f64::NAN,
        snr_db: f64::NAN,
        verdict: Verdict::NoSignal,
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
    plan: Plan,
) -> Result<Box<dyn Engine>, String> {
    if !(SHORTEST..=LONGEST).contains(&n) {
        return Err(format!("N = {n}: choose {SHORTEST} to {LONGEST} samples"));
    }
    if !arithmetic.integer() {
        return Ok(match arithmetic {
            Arithmetic::F32 => Box::new(Floats::<f32, R>::new(n, plan)),
            _ => Box::new(Floats::<f64, R>::new(n, plan)),
        });
    }
    if !supported(n) {
        return Err(format!(
            "N = {n}: the target's FFT takes 64, 128, ... {}: choose one or --arith f64",
            fft::twiddle::MAX_LENGTH
        ));
    }
    Ok(match n {
        64 => Box::new(Target::<R, 64>::new(plan)),
        128 => Box::new(Target::<R, 128>::new(plan)),
        256 => Box::new(Target::<R, 256>::new(plan)),
        512 => Box::new(Target::<R, 512>::new(plan)),
        1024 => Box::new(Target::<R, 1024>::new(plan)),
        2048 => Box::new(Target::<R, 2048>::new(plan)),
        _ => Box::new(Target::<R, 4096>::new(plan)),
    })
}

/// An exact transform in floats.
struct Floats<T: Transform, R> {
    n: usize,
    plan: Plan,
    fft: Arc<dyn Fft<T>>,
    scratch: Vec<Complex<T>>,
    samples: Vec<Complex<T>>,
    spectrum: Vec<Complex<T>>,
    powers: Vec<T>,
    kind: PhantomData<R>,
}

impl<T: Transform, R> Debug for Floats<T, R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Floats({}, {:?})", self.n, self.plan)
    }
}

impl<T: Scalar + Transform, R: Record> Floats<T, R> {
    fn new(n: usize, plan: Plan) -> Self {
        let fft = T::forward(n);
        let scratch = vec![Complex::new(T::zero(), T::zero()); fft.get_inplace_scratch_len()];
        Floats {
            n,
            plan,
            fft,
            scratch,
            samples: Vec::new(),
            spectrum: Vec::new(),
            powers: Vec::new(),
            kind: PhantomData,
        }
    }

    fn transform(&mut self, record: &[Complex<f64>]) {
        self.samples.clear();
        self.samples.extend(record.iter().map(|x| Complex::new(T::of(x.re), T::of(x.im))));
        self.spectrum.clone_from(&self.samples);
        self.fft.process_with_scratch(&mut self.spectrum, &mut self.scratch);
        self.powers.clear();
        self.powers.extend(self.spectrum.iter().map(|x| x.norm_sqr()));
    }

    /// The core's search, on powers scaled to the integers it takes.
    fn peak(&self) -> Option<(Peak, f64)> {
        let Band { low, high } = self.plan.band;
        let power = |k: i32| self.powers[k.rem_euclid(self.n as i32) as usize].wide();
        let most = (low..=high).map(power).fold(0.0, f64::max);
        let unit = most / (1u64 << 40) as f64;
        if !(unit > 0.0 && unit.is_finite()) {
            return None;
        }
        let mut search = Search::new(self.plan.band);
        (low..=high).for_each(|k| search.push((power(k) / unit) as u64));
        search.finish().map(|peak| (peak, unit))
    }

    fn bins(&self, peak: i32) -> Bins<T, R, Rectangular> {
        Bins::gather(self.n, peak, |k| self.spectrum[k])
    }

    fn frequency(
        &self,
        record: &[Complex<f64>],
        estimator: Estimator,
        peak: i32,
        bins: &Bins<T, R, Rectangular>,
    ) -> f64 {
        let found = match estimator {
            Estimator::Core { method, reach } => {
                Estimator::offset(method, reach, bins, &self.samples, &self.powers)
                    .map(|offset| f64::from(peak) + offset.wide())
            }
            Estimator::Host(reference) if R::IQ => reference.iq(record),
            Estimator::Host(reference) => {
                reference.real(&record.iter().map(|x| x.re).collect::<Vec<_>>())
            }
        };
        found.map_or(f64::NAN, |f| within::<R>(f, self.n))
    }

    fn verdict(&self, peak: &Peak, bins: Option<&f64>, clipped: u32, gap: bool) -> Verdict {
        let nyquist = self.n as f64 / 2.0;
        let edge = |f: &f64| *f < 1.5 || *f > nyquist - 1.5;
        if !self.plan.options.threshold.detects(peak) {
            Verdict::Weak
        } else if gap {
            Verdict::Gap
        } else if clipped as f32 / self.n as f32 > CLIPPED {
            Verdict::Clipped
        } else if !R::IQ && bins.is_some_and(edge) {
            Verdict::NearEdge
        } else {
            Verdict::Good
        }
    }

    /// The amplitude's square and the noise power per sample, in squared codes, and sigma in bins if the fit tells
    /// it. The fitted tone is taken out of the record; what is left in the band is noise.
    fn powers(&mut self, peak: &Peak, unit: f64) -> (f64, f64, Option<f64>) {
        let n = self.n as f64;
        let bins = self.bins(peak.bin);
        let Some(fit) = fit(&bins, Reach::Sixteen, Course::Usual) else {
            let share = if R::IQ { n } else { n / 2.0 };
            let amplitude2 = peak.power[1] as f64 * unit / (share * share);
            return (amplitude2, peak.floor as f64 * unit / f64::from(peak.floor_bins) / n, None);
        };
        let tone = fit.tone::<R>(self.n);
        let tone = Complex::new(tone.re.wide(), tone.im.wide());
        let cycles = (f64::from(peak.bin) + fit.offset.wide()) / n;
        for (k, (rest, sample)) in self.spectrum.iter_mut().zip(&self.samples).enumerate() {
            let at = tone * f64::unit((cycles * k as f64).fract());
            *rest = Complex::new(
                T::of(sample.re.wide() - at.re),
                if R::IQ { T::of(sample.im.wide() - at.im) } else { T::zero() },
            );
        }
        self.fft.process_with_scratch(&mut self.spectrum, &mut self.scratch);
        let Band { low, high } = self.plan.band;
        let dc_free = (low..=high).map(|k| k.rem_euclid(self.n as i32) as usize).filter(|&k| k > 0);
        let (sum, count) = dc_free
            .map(|k| self.spectrum[k].norm_sqr().wide())
            .fold((0.0, 0.0), |(s, c), p| (s + p, c + 1.0));
        // The fit took three parameters of two-part bins out of the noise.
        let noise = sum / f64::max(count - 1.5, 1.0) / n;
        let sigma = sigma_bins(&fit, self.n, T::of(noise)).wide();
        (fit.amplitude_squared::<R>(self.n).wide(), noise, Some(sigma))
    }
}

/// A frequency in the range that estimates are given in.
fn within<R: Record>(bins: f64, n: usize) -> f64 {
    if R::IQ { bins.rem_euclid(n as f64) } else { bins }
}

impl<T: Scalar + Transform, R: Kind> Engine for Floats<T, R> {
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64> {
        self.transform(record);
        let Some((peak, _)) = self.peak() else {
            return vec![f64::NAN; estimators.len()];
        };
        let bins = self.bins(peak.bin);
        estimators.iter().map(|&e| self.frequency(record, e, peak.bin, &bins)).collect()
    }

    fn measure(
        &mut self,
        record: &[Complex<f64>],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        self.transform(record);
        let Some((peak, unit)) = self.peak() else {
            return vec![Estimate::NOTHING; estimators.len()];
        };
        let bins = self.bins(peak.bin);
        let found: Vec<f64> =
            estimators.iter().map(|&e| self.frequency(record, e, peak.bin, &bins)).collect();
        let (amplitude2, noise, sigma) = self.powers(&peak, unit);
        let snr = amplitude2 * if R::IQ { 1.0 } else { 0.5 } / noise;
        let bound = f64::from(bound_bins::<R>(self.n, snr as f32));
        let clipped = Statistics::of::<R>(&codes::<R>(record), self.plan.codes).clipped;
        let verdict = self.verdict(&peak, found.first(), clipped, gap);
        let sigma_of = |estimator: &Estimator| match (estimator, sigma) {
            (
                Estimator::Core { method: Method::LeastSquares | Method::LeastSquaresReal, .. },
                Some(sigma),
            ) => sigma,
            _ => f64::from(estimator.about().efficiency) * bound,
        };
        estimators
            .iter()
            .zip(found)
            .map(|(estimator, bins)| Estimate {
                bins,
                sigma_bins: sigma_of(estimator),
                snr_db: 10.0 * snr.log10(),
                verdict,
            })
            .collect()
    }
}

/// The firmware's way: the core's spectrum and pipeline.
#[derive(Debug)]
struct Target<R: Record, const N: usize> {
    plan: Plan,
    spectrum: Box<Spectrum<R, N>>,
    sequence: u32,
}

impl<R: Kind, const N: usize> Target<R, N> {
    fn new(plan: Plan) -> Self {
        Target { plan, spectrum: Box::new(Spectrum::new()), sequence: 0 }
    }

    fn offset(&self, estimator: Estimator, samples: &[R::Sample; N], peak: i32) -> f64 {
        let Estimator::Core { method, reach } = estimator else {
            return f64::NAN;
        };
        let bins = Bins::<f32, R, Rectangular>::of(&self.spectrum, peak);
        let offset = match reached(method, reach, &bins) {
            Some(offset) => offset.map(I2F30::saturating_from_num),
            None => method.offset_target(&self.spectrum, samples, peak),
        };
        offset.map_or(f64::NAN, |offset| offset.to_num())
    }
}

/// The record as an array; what is missing reads zero.
fn block<R: Kind, const N: usize>(record: &[Complex<f64>]) -> [R::Sample; N] {
    let mut samples = codes::<R>(record).into_iter();
    std::array::from_fn(|_| samples.next().unwrap_or_default())
}

impl<R: Kind, const N: usize> Engine for Target<R, N> {
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64> {
        let samples = block::<R, N>(record);
        self.spectrum.transform(&samples, self.plan.codes);
        let Some(peak) = peak::find(&self.spectrum, self.plan.band) else {
            return vec![f64::NAN; estimators.len()];
        };
        let frequency =
            |&e| within::<R>(f64::from(peak.bin) + self.offset(e, &samples, peak.bin), N);
        estimators.iter().map(frequency).collect()
    }

    fn measure(
        &mut self,
        record: &[Complex<f64>],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        let samples = block::<R, N>(record);
        let stamp = Stamp { sequence: self.sequence, gap, ..Stamp::default() };
        self.sequence = self.sequence.wrapping_add(1);
        let measure = |&estimator: &Estimator| {
            let Estimator::Core { method, reach } = estimator else {
                return Estimate::NOTHING;
            };
            let options = Options { method, reach, ..self.plan.options };
            let plan = Plan { options, ..self.plan };
            let mut pipeline = Box::new(Pipeline::<R, N>::new(plan));
            let tone = pipeline.block(stamp, &samples).tone;
            Estimate {
                bins: within::<R>(tone.frequency.bins(N), N),
                sigma_bins: f64::from(tone.sigma) * N as f64,
                snr_db: f64::from(tone.snr_db()),
                verdict: tone.verdict,
            }
        };
        estimators.iter().map(measure).collect()
    }
}

/// A search of the whole band of a record, for codes of this width.
pub fn whole<R: Record>(n: usize, codes: Codes) -> Result<Plan, String> {
    Config { codes, ..Config::default() }.validate::<R>(n).map_err(|error| error.to_string())
}

/// Runs `$body` with `$kind` standing for the kind of record that a flag names.
#[macro_export]
macro_rules! with_kind {
    ($iq:expr, $kind:ident => $body:expr) => {
        if $iq {
            type $kind = picket::acquire::sample::Iq;
            $body
        } else {
            type $kind = picket::acquire::sample::Real;
            $body
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::parse;
    use crate::simulate::{Signal, generator};
    use picket::acquire::sample::{Iq, Real};

    fn answers<R: Kind>(arithmetic: Arithmetic) -> Vec<Estimate> {
        // Seed 3: 40 dB of noise, bound 2e-4 bins.
        let record = Signal::tone(100.3, 1500.0, 40.0).record::<R>(1024, &mut generator(3, 0));
        let best = Estimator::best(R::IQ, Reach::Sixteen).name();
        let methods = parse(&format!("{best},z-rife,candan"), Reach::Sixteen).unwrap();
        let plan = whole::<R>(1024, Codes::Signed12).unwrap();
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
        for arithmetic in [Arithmetic::F64, Arithmetic::F32, Arithmetic::Target] {
            for answers in [answers::<Real>(arithmetic), answers::<Iq>(arithmetic)] {
                for answer in &answers {
                    assert!((answer.bins - 100.3).abs() < 2e-3, "{arithmetic:?} {answers:?}");
                    assert_eq!(answer.verdict, Verdict::Good);
                }
                if !arithmetic.integer() {
                    assert!((answers[0].snr_db - 40.0).abs() < 1.0, "{answers:?}");
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_done_is_said() {
        let plan = whole::<Real>(1000, Codes::Signed12).unwrap();
        assert!(engine::<Real>(Arithmetic::F64, 1000, plan).is_ok());
        assert!(engine::<Real>(Arithmetic::Target, 1000, plan).is_err());
        assert!(engine::<Real>(Arithmetic::F64, 3, plan).is_err());
        let fesa = Estimator::from_name("fesa", Reach::Sixteen).unwrap();
        assert!(fesa.check::<Real>().is_err() && fesa.check::<Iq>().is_ok());
        assert!(Arithmetic::TargetFixed.check(fesa).is_err());
        assert!(Estimator::from_name("fase", Reach::Sixteen).is_err());
    }
}

//! From a block of samples to a target. Firmware and tools measure their blocks by the types here.

mod alternating;
mod burst_processor;
mod frequency_only;
mod measured;
mod ramps;

pub use alternating::Alternating;
pub use burst_processor::BurstProcessor;
pub use frequency_only::{FrequencyOnly, Unjudged};

pub(crate) use measured::Measured;
pub(crate) use ramps::Ramps;

use crate::acquire::burst::Cut;
use crate::acquire::sample::{Data, Record, Stamp, Statistics};
use crate::burst::{self, Burst};
use crate::math::scalar::Scalar as _;
use crate::plan::{Plan, Solver, Terms};
use crate::solve::chirp::Target;
use crate::solve::doppler::{self, Velocity};
use crate::solve::uncertainty::{Total, Uncertainty};
use crate::spectrum::Spectrum;
use crate::spectrum::engine::{Engine, I32};
use crate::tone::evidence::Evidence;
use crate::tone::fit::fit_near;
use crate::tone::harmonic::Harmonic;
use crate::tone::lines::MOST;
use crate::tone::observer::Observer;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::{FrequencyDrift, Tone};
use heapless::Vec;

/// The result of one block, with the target if the block completed a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Measurement {
    /// Where and when the block was taken.
    pub stamp: Stamp,
    /// Samples that touch a rail.
    pub clipped: u32,
    /// The strongest tone.
    pub tone: Tone,
    /// The velocity or target computed from the tone(s).
    pub result: Outcome,
}

impl Measurement {
    /// The whole error of the tone and of what follows from it, by what is not known of the sensor. `angle_rad` is the angle between beam and
    /// motion for which a velocity was solved.
    pub fn total(&self, known: &Uncertainty, angle_rad: f32) -> Total {
        let clock = 1e-6 * known.clock_ppm * self.tone.frequency.cycles_f32();
        let frequency = (self.tone.sigma * self.tone.sigma + clock * clock).root();
        let (ranged, target) = match self.result {
            Outcome::None => (false, Target::default()),
            Outcome::Target(target) => (true, target),
            Outcome::Velocity(Velocity { velocity, sigma, .. }) => {
                let velocity = Some(velocity);
                (false, Target { velocity, sigma_velocity: sigma, ..Target::default() })
            }
        };
        let [range, velocity] = known.of_target(&target, angle_rad).total();
        Total { frequency, range: if ranged { range } else { 0.0 }, velocity }
    }
}

/// The result of a measurement beyond its tone.
///
/// ```
/// use picket_dsp::{Codes, Config, Mixing, Outcome, Pipeline, Real, Scene};
///
/// // A radar at 24.125 GHz: the echo of 1.5 m/s is shifted by 2 v / wavelength, 241.4 Hz.
/// let (wavelength_m, angle_rad, mixing) = (299_792_458.0 / 24.125e9, 0.0, Mixing::RxConjTx);
/// let scene = Scene::Doppler { wavelength_m, angle_rad, mixing };
/// let config = Config { scene, ..Config::new(8000.0, Codes::signed::<12>()) };
/// let mut pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
/// let turn = 2.0 * 1.5 / wavelength_m / 8000.0 * std::f64::consts::TAU;
/// let samples: [i16; 1024] = std::array::from_fn(|n| (500.0 * (turn * n as f64).sin()) as i16);
/// let Outcome::Velocity(answer) = pipeline.record(&samples)?.result else { panic!("not the scene") };
/// let error = answer.velocity.to_num::<f32>() - 1.5;
/// assert!(error.abs() < 3.0 * answer.sigma, "{answer:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Outcome {
    /// Nothing more: the scene is a tone, or the chirp is incomplete.
    #[default]
    None,
    /// A velocity.
    Velocity(Velocity),
    /// A range and a velocity.
    Target(Target),
}

impl Outcome {
    /// Whether a usable result has finite sigmas, like [`Tone::is_consistent`]; a velocity that is not known has none.
    pub const fn is_consistent(&self) -> bool {
        match self {
            Outcome::None => true,
            Outcome::Velocity(v) => v.verdict.admits(v.sigma),
            Outcome::Target(t) => {
                let known = t.velocity.is_some();
                t.verdict.admits(t.sigma_range) && (!known || t.verdict.admits(t.sigma_velocity))
            }
        }
    }
}

/// Turns ADC samples into measurements. The pipeline owns its work memory: `4 N` bytes for real records, `8 N` for I/Q.
///
/// ```
/// use picket_dsp::{Codes, Config, Iq, Pipeline, Stamp};
///
/// let config = Config::new(1e6, Codes::signed::<16>());
/// let mut pipeline = Pipeline::<Iq, 512>::new(config.plan()?);
/// // I and Q of a tone at -123,456 Hz.
/// let pair = |turn: f64| [turn.cos(), turn.sin()].map(|part| (2e4 * part).round() as i16);
/// let samples = std::array::from_fn(|n| pair(-0.123456 * std::f64::consts::TAU * n as f64));
/// let measurement = pipeline.block(&Stamp::default(), &samples);
/// let tone = measurement.tone;
/// assert!((tone.hertz() + 123_456.0).abs() < 3.0 * tone.sigma_hertz(), "{tone}");
/// assert_eq!(measurement.clipped, 0);
/// # Ok::<(), picket_dsp::ConfigError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Pipeline<R: Record, const N: usize, E: Engine = I32> {
    plan: Plan<R, N>,
    spectrum: Spectrum<R, N, E>,
    ramps: Ramps,
}

impl<R: Record, const N: usize, E: Engine> Pipeline<R, N, E> {
    /// A pipeline that follows `plan`.
    pub const fn new(plan: Plan<R, N>) -> Self {
        Self { plan, spectrum: Spectrum::new(), ramps: Ramps::new() }
    }

    /// Follows another plan from the next block on.
    pub fn set_plan(&mut self, plan: Plan<R, N>) {
        self.plan.take(plan);
        self.ramps.forget();
    }

    /// Measures one block. Cost: one transform, one search, one fit and one estimate of the noise; where the line is not a steady tone, up to
    /// two more fits, see [`Effort`](crate::tone::effort::Effort).
    pub fn block(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> Measurement {
        self.transform(samples);
        let Self { plan, spectrum, ramps } = self;
        Measured { view: spectrum.view(), fit_near: fit_near::<R>(), terms: plan }.block(
            stamp,
            Data::of::<R>(samples),
            ramps,
        )
    }

    /// Measures the tone of one block and counts the samples that touch a rail. The method runs no solver, so a program whose scene is a
    /// tone needs nothing else.
    #[inline]
    pub fn tone(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> (u32, Tone) {
        self.transform(samples);
        self.measured().tone(stamp, Data::of::<R>(samples))
    }

    /// Measures the tone of one block like [`Pipeline::tone`], and reports every test behind the verdict to `observer`.
    pub fn explain(
        &mut self,
        stamp: &Stamp,
        samples: &[R::Sample; N],
        observer: &dyn Observer,
    ) -> (u32, Tone, Evidence) {
        self.transform(samples);
        self.measured().explained(stamp, Data::of::<R>(samples), observer)
    }

    #[inline]
    fn transform(&mut self, samples: &[R::Sample; N]) {
        self.spectrum.transform(samples, self.plan.codes);
    }

    /// The terms, and the beats of the chirp so far.
    pub(crate) fn solver(&mut self) -> (&Terms, &mut Ramps) {
        (&self.plan, &mut self.ramps)
    }

    /// The last block.
    #[inline]
    pub(crate) fn measured(&self) -> Measured<'_> {
        Measured { view: self.spectrum.view(), fit_near: fit_near::<R>(), terms: &self.plan }
    }

    /// Measures one record, which must be the first of a chirp or outside of any chirp.
    ///
    /// # Errors
    /// The slice does not hold exactly `N` samples. An
    /// [`Framer`](crate::acquire::framer::Framer) makes records of a stream of any length.
    pub fn record(&mut self, samples: &[R::Sample]) -> Result<Measurement, LengthError> {
        match samples.try_into() {
            Ok(samples) => Ok(self.block(&Stamp::default(), samples)),
            Err(_) => Err(LengthError { samples: samples.len(), wanted: N }),
        }
    }

    /// Transforms a block without measuring it, for [`Pipeline::spectrum`]: a chirp of a frame. Returns the samples that touch a rail.
    pub fn look(&mut self, samples: &[R::Sample; N]) -> u32 {
        self.transform(samples);
        Statistics::clipped(Data::of::<R>(samples), self.plan.codes)
    }

    /// The plan in use.
    pub const fn plan(&self) -> &Plan<R, N> {
        &self.plan
    }

    /// The spectrum of the last block.
    pub const fn spectrum(&self) -> &Spectrum<R, N, E> {
        &self.spectrum
    }

    /// The rise of the frequency of the last block's tone within the record, for a tone that is [`Verdict::Moving`](crate::Verdict::Moving); `None` for any other.
    /// `measurement` is the last block's.
    ///
    /// Cost: the fit and the noise once more.
    pub fn rise(&self, measurement: &Measurement) -> Option<FrequencyDrift> {
        self.measured().rise(measurement)
    }

    /// The tones of the last block with their phases, at most `most` and
    /// [`MOST`]: the strongest first. `measurement` is the last block's; its own tone is among them.
    ///
    /// Lines that the front end or the transform makes of a stronger one are left out, see [`crate::tone::lines`]. With `most = 1` the
    /// result is the phase of the block's tone.
    pub fn lines(&self, measurement: &Measurement, most: usize) -> Vec<ToneWithPhase, MOST> {
        self.measured().lines(measurement, most)
    }

    /// The fundamental of the last block from its harmonics up to `order`, at most [`HIGHEST`](crate::tone::harmonic::HIGHEST).
    /// `measurement` is the last block's. The plan's band limits the fundamental; harmonics are sought everywhere.
    pub fn harmonic(&self, measurement: &Measurement, order: u32) -> Option<Harmonic> {
        self.measured().harmonic(measurement, order)
    }

    /// Measures the burst in the record that a [`BurstDetector`](crate::acquire::burst::BurstDetector) cut around it: its frequency with
    /// its envelope as the weight, to the bound for this envelope, and whether one particle made it. Cost: two to six transforms, and some
    /// hundred operations of 32-bit floats for each of 64 points, in software on a core without an FPU.
    pub fn burst(&mut self, cut: &Cut<R, N>) -> Burst {
        burst::measure::measure(&mut self.spectrum, &self.plan, cut)
    }

    /// The outcome of a tone from another source than the blocks themselves (a burst, a sum): a velocity where the scene is a Doppler
    /// shift, else nothing more.
    pub fn outcome(&self, tone: &Tone) -> Outcome {
        outcome(&self.plan.solver, tone)
    }
}

fn outcome(solver: &Solver, tone: &Tone) -> Outcome {
    match *solver {
        Solver::Doppler(scale) => Outcome::Velocity(doppler::velocity(tone, scale)),
        _ => Outcome::None,
    }
}

/// The slice's length differs from the record's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LengthError {
    /// The samples in the slice.
    pub samples: usize,
    /// The samples of a record.
    pub wanted: usize,
}

impl core::fmt::Display for LengthError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { samples, wanted } = self;
        write!(
            f,
            "a record has {wanted} samples, not {samples}: a framer makes records of a stream"
        )
    }
}

impl core::error::Error for LengthError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::burst::Trigger;
    use crate::{Accumulator, Alternating, BurstProcessor, Codes, Format, Framer, FrequencyOnly};
    use crate::{Iq, Real, Tracker};
    use std::format;

    /// What holds thousands of samples, bins or sums prints its state, not them.
    #[test]
    fn no_debug_output_prints_a_buffer() {
        let plan = Plan::<Real, 1024>::tone(48e3, Codes::signed::<12>());
        let pairs = Plan::<Iq, 1024>::tone(48e3, Codes::signed::<12>());
        let mut bursts = BurstProcessor::new(plan);
        bursts.set_plan(plan, Trigger { hold_off: 77, ..Trigger::default() });
        let mut sum = Accumulator::<Real, 1024>::new(3);
        let mut pipeline = Pipeline::<Real, 1024>::new(plan);
        let block = pipeline.block(&Stamp::default(), &[5; 1024]);
        assert_eq!(sum.add(&block, &pipeline), None);
        for (text, state) in [
            (format!("{pipeline:?}"), "rate_hz: 48000.0"),
            (format!("{:?}", Tracker::new(plan)), "rate_hz: 48000.0"),
            (format!("{bursts:?}"), "hold_off: 77"),
            (format!("{sum:?}"), "blocks: 1,"),
            (format!("{:?}", Alternating::<1024, 2048>::new(pairs)), "n: 2048"),
            (format!("{:?}", FrequencyOnly::<Real, 1024>::new()), "exponent: 0"),
            (format!("{:?}", Framer::<Real, 1024>::new(Format::signed::<16>())), "filled: 0"),
        ] {
            assert!(text.contains(state), "{text}");
            assert!(text.len() < 3000, "{}: {text}", text.len());
        }
    }
}

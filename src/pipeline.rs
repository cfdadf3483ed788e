//! From a block of samples to a target. Firmware and tools measure their blocks by the types here.

mod alternating;
mod frequency_only;

pub use alternating::Alternating;
pub use frequency_only::{FrequencyOnly, Unjudged};

use crate::acquire::burst::Cut;
use crate::acquire::sample::{Record, Stamp};
use crate::burst::{self, Burst};
use crate::list::first;
use crate::math::scalar::Scalar as _;
use crate::plan::{Plan, Solver, Terms};
use crate::solve::chirp::{self, Shape, Target};
use crate::solve::doppler::{self, Velocity};
use crate::solve::equations::Equations;
use crate::solve::hypotheses::{Last, Line, solve};
use crate::solve::segments::{Segments, TRAPEZOID, TRIANGLE};
use crate::spectrum::engine::{Engine, I32};
use crate::spectrum::peak::{Band, Peak, SKIRT};
use crate::spectrum::{Size, Spectrum};
use crate::tone::arithmetic::Arithmetic;
use crate::tone::detection::{Relaxation, Threshold};
use crate::tone::evidence::Evidence;
use crate::tone::frequency::Frequency;
use crate::tone::harmonic::{Harmonic, harmonic};
use crate::tone::lines::{DRIFT, MOST, lines};
use crate::tone::measure::{Options, block, rise, weigh};
use crate::tone::observer::Observer;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::{FrequencyDrift, Tone, Verdict};
use core::f32::consts::{FRAC_1_PI, FRAC_2_PI};
use heapless::Vec;

/// The result of one block, with the target if the block completed a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

    /// Measures one block. Cost: one transform, one search, one fit and one estimate of the noise; where the line is no steady tone, up to
    /// two more fits, see [`Effort`](crate::tone::effort::Effort).
    pub fn block(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> Measurement {
        let mut others = u64::MAX;
        let (clipped, mut tone, evidence) = block(
            &mut self.spectrum,
            samples,
            stamp,
            &self.plan,
            |_, peak| others = peak.floor,
            (),
        );
        tone.conclude(&evidence);
        let result = Outcome::None;
        let mut measurement = Measurement { stamp: *stamp, clipped, tone, result };
        measurement.result = if self.plan.pairs() {
            let drift = evidence.drift.filter(|_| tone.verdict <= Verdict::Moving);
            let lines = self.beats(&measurement, drift, others);
            self.ramps.solve(&self.plan.solver, stamp, &lines, R::IQ)
        } else {
            self.solve(stamp, tone)
        };
        measurement
    }

    /// Measures the tone of one block and counts the samples that touch a rail. The method runs no solver, so a program whose scene is a
    /// tone needs nothing else.
    #[inline]
    pub fn tone(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> (u32, Tone) {
        self.tone_with(stamp, samples, |_, _| {})
    }

    /// Measures the tone of one block like [`Pipeline::tone`], and reports every test behind the verdict to `observer`.
    pub fn explain(
        &mut self,
        stamp: &Stamp,
        samples: &[R::Sample; N],
        observer: impl Observer,
    ) -> (u32, Tone, Evidence) {
        let (clipped, mut tone, evidence) =
            block(&mut self.spectrum, samples, stamp, &self.plan, |_, _| {}, observer);
        tone.conclude(&evidence);
        (clipped, tone, evidence)
    }

    /// The tone of a spectrum, with a hook that may edit the spectrum once the peak is found.
    #[inline(always)]
    fn tone_with(
        &mut self,
        stamp: &Stamp,
        samples: &[R::Sample; N],
        mend: impl FnOnce(&mut Spectrum<R, N, E>, &Peak),
    ) -> (u32, Tone) {
        let (clipped, mut tone, evidence) =
            block(&mut self.spectrum, samples, stamp, &self.plan, mend, ());
        tone.conclude(&evidence);
        (clipped, tone)
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

    /// The plan in use.
    pub const fn plan(&self) -> &Plan<R, N> {
        &self.plan
    }

    /// The spectrum of the last block.
    pub const fn spectrum(&self) -> &Spectrum<R, N, E> {
        &self.spectrum
    }

    /// The rise of the frequency of the last block's tone within the record, for a tone that is [`Verdict::Moving`]; `None` for any other.
    /// `measurement` is the last block's.
    ///
    /// Cost: the fit and the noise once more.
    pub fn rise(&self, measurement: &Measurement) -> Option<FrequencyDrift> {
        let tone = &measurement.tone;
        if tone.verdict != Verdict::Moving {
            return None;
        }
        let peak = libm::rint(tone.frequency.bins(N)) as i32;
        rise(&self.spectrum, peak, &self.plan.options)
    }

    /// The tone at another peak of the last block, tested against `threshold`.
    pub(crate) fn measure(
        &self,
        stamp: &Stamp,
        samples: &[R::Sample; N],
        clipped: u32,
        peak: &Peak,
        threshold: Threshold,
    ) -> Tone {
        let options = Options { threshold, ..self.plan.options };
        let Terms { codes, band, rate_hz, .. } = *self.plan;
        let (mut tone, mut evidence) =
            weigh(&self.spectrum, samples, peak, codes, clipped, stamp, &options, ());
        evidence.outside = evidence.found && tone.is_outside(band, N);
        tone.conclude(&evidence);
        Tone { rate_hz, ..tone }
    }

    /// The tones of the last block with their phases, at most `most` and
    /// [`MOST`]: the strongest first. `measurement` is the last block's; its own tone is among them.
    ///
    /// Lines that the front end or the transform makes of a stronger one are left out, see [`crate::tone::lines`]. With `most = 1` the
    /// result is the phase of the block's tone.
    pub fn lines(&self, measurement: &Measurement, most: usize) -> Vec<ToneWithPhase, MOST> {
        let Measurement { ref stamp, clipped, ref tone, .. } = *measurement;
        let Terms { band, ref options, rate_hz, .. } = *self.plan;
        let mut phasors = lines(&self.spectrum, tone, band, clipped, stamp, options, most);
        for phasor in &mut phasors {
            phasor.tone.rate_hz = rate_hz;
            phasor.tone.keep_to_codes_of(tone);
        }
        phasors
    }

    /// The fundamental of the last block from its harmonics up to `order`, at most [`HIGHEST`](crate::tone::harmonic::HIGHEST).
    /// `measurement` is the last block's. The plan's band limits the fundamental; harmonics are sought everywhere.
    pub fn harmonic(&self, measurement: &Measurement, order: u32) -> Option<Harmonic> {
        let Measurement { ref stamp, clipped, ref tone, .. } = *measurement;
        let Terms { band, ref options, rate_hz, .. } = *self.plan;
        let mut harmonic = harmonic(&self.spectrum, tone, band, clipped, stamp, options, order)?;
        harmonic.tone.rate_hz = rate_hz;
        harmonic.tone.keep_to_codes_of(tone);
        Some(harmonic)
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
        match self.plan.solver {
            Solver::Doppler(scale) => Outcome::Velocity(doppler::velocity(tone, scale)),
            _ => Outcome::None,
        }
    }

    /// The velocity or target computed from a tone.
    pub(crate) fn solve(&mut self, stamp: &Stamp, tone: Tone) -> Outcome {
        self.ramps.solve(&self.plan.solver, stamp, &[Line::from(tone)], R::IQ)
    }

    /// The lines of the last block that a target's beats may be, the strongest first: `drift` is the rise of a usable tone, `others`
    /// the power of the bins beside the strongest.
    #[inline(never)]
    fn beats(
        &self,
        measurement: &Measurement,
        drift: Option<FrequencyDrift>,
        others: u64,
    ) -> Vec<Line, MOST> {
        let tone = measurement.tone;
        // The measured tone is the better one if it is alone.
        let alone = || first([Line { tone, drift }].into_iter());
        if tone.verdict > Verdict::Weak || self.is_alone(&tone, others) {
            return alone();
        }
        // Lines are sought in floats, which take fifty blocks' time without an FPU.
        if let Arithmetic::Fixed = self.plan.options.arithmetic.available() {
            let verdict = tone.verdict.max(Verdict::Unresolved);
            return first([Line { tone: Tone { verdict, ..tone }, drift }].into_iter());
        }
        let mut lines = self.lines(measurement, MOST);
        let most = lines.first().map_or(0.0, |line| line.tone.amplitude);
        lines.retain(|line| line.tone.amplitude >= COMPARABLE * most);
        if let [_, _, ..] = lines.as_slice() {
            return first(lines.iter().map(|line| Line::from(line.tone)));
        }
        alone()
    }

    /// Whether a tone of the last block is the only line of [`COMPARABLE`] strength, by bins that are read in integers: the search for
    /// lines in floats takes as long as the block. A line within the skirt of the tone would show in its fit.
    fn is_alone(&self, tone: &Tone, others: u64) -> bool {
        if tone.verdict > Verdict::Moving || !self.plan.options.effort.is_one_tone() {
            return false;
        }
        let size = Size { n: N, iq: R::IQ };
        let peak = libm::rintf(tone.frequency.cycles_f32() * N as f32) as i32;
        // Half a bin off its bins a line has 2/pi of its height, less the leakage of the tone.
        const LEAST: f32 = COMPARABLE * FRAC_2_PI - FRAC_1_PI / (SKIRT as f32 + 0.5);
        // Nor is a bin a line that does not stand out of the noise: the floor of a search has this many degrees of freedom.
        const DOF: f32 = 80.0;
        let bins = if R::IQ { N } else { N / 2 } as f32;
        let height = bins * tone.amplitude * f32::two_to(-self.spectrum.exponent());
        let above = self.plan.options.threshold.beside(DOF, Relaxation::NOTHING);
        let share = (LEAST * LEAST).max(above / (tone.snr * bins));
        let least = (share * (height * height)) as u64;
        let near = |k: i32| size.apart(k, peak) <= SKIRT || R::IQ && size.apart(k, 0) < DRIFT;
        let quiet = |k: i32| near(k) || self.spectrum.power(k) < least;
        let partner = (N / 2) as i32 - peak;
        // The sum lacks the skirt of a real tone's partner.
        if others < least && (R::IQ || (partner - SKIRT..=partner + SKIRT).all(quiet)) {
            return true;
        }
        const ROW: i32 = 16;
        let Band { low, high, .. } = self.plan.band;
        let low = if R::IQ { low } else { low.max(DRIFT) };
        (low..=high).step_by(ROW as usize).all(|first| {
            let last = high.min(first + ROW - 1);
            self.spectrum.is_below(least, first, (last - first + 1) as usize)
                || (first..=last).all(quiet)
        })
    }
}

/// The least amplitude of a line beside the strongest, as a ratio: -10 dB. A weaker one is not the strongest target's on another ramp, far
/// beyond the spread of levels.
const COMPARABLE: f32 = 0.316;

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

/// Collects the tones of one chirp.
#[derive(Clone, Debug)]
struct Ramps {
    beats: [Vec<Beat, MOST>; 3],
    /// The rise of each segment's line, if it has only one.
    drifts: [Option<FrequencyDrift>; 3],
    segments: Segments,
    last: Last,
    /// The sample clock at this chirp's rising ramp, and at the last chirp's falling one.
    begin: u64,
    clock: Option<u64>,
}

/// The part of a line that a solver reads.
#[derive(Clone, Copy, Debug)]
struct Beat {
    frequency: Frequency,
    sigma: f32,
    snr: f32,
    amplitude: f32,
    verdict: Verdict,
}

impl Beat {
    const fn from_line(line: &Line) -> Self {
        let Tone { frequency, sigma, snr, amplitude, verdict, .. } = line.tone;
        Self { frequency, sigma, snr, amplitude, verdict }
    }

    const fn line(&self, drift: Option<FrequencyDrift>) -> Line {
        let Self { frequency, sigma, snr, amplitude, verdict } = *self;
        let tone = Tone { frequency, sigma, snr, amplitude, verdict, ..Tone::ZERO };
        Line { tone, drift }
    }
}

impl Ramps {
    const fn new() -> Self {
        let beats = [const { Vec::new() }; 3];
        Self {
            beats,
            drifts: [None; 3],
            segments: Segments::new(),
            last: Last::new(),
            begin: 0,
            clock: None,
        }
    }

    /// The next block starts a chirp that no other precedes.
    fn forget(&mut self) {
        self.segments.forget();
        self.last.forget();
        self.clock = None;
    }

    /// The velocity or target computed from a block's lines, the strongest first; `signed` says that their frequencies have the right
    /// signs.
    #[inline]
    fn solve(&mut self, solver: &Solver, stamp: &Stamp, lines: &[Line], signed: bool) -> Outcome {
        let Some(Line { tone, .. }) = lines.first() else { return Outcome::None };
        match *solver {
            Solver::None => Outcome::None,
            Solver::Doppler(scale) => Outcome::Velocity(doppler::velocity(tone, scale)),
            Solver::Chirp(ref equations) => match equations.shape {
                Shape::Sawtooth => Outcome::Target(chirp::sawtooth(tone, signed, equations)),
                Shape::Triangle => self.pair(stamp, lines, TRIANGLE, signed, equations),
                Shape::Trapezoid => self.pair(stamp, lines, TRAPEZOID, signed, equations),
            },
        }
    }

    /// Takes a segment's lines; the falling ramp completes a chirp and gives its target.
    #[inline(never)]
    fn pair(
        &mut self,
        stamp: &Stamp,
        lines: &[Line],
        wanted: u8,
        signed: bool,
        equations: &Equations,
    ) -> Outcome {
        let Some(index) = self.segments.push(stamp) else { return Outcome::None };
        if index == 0 {
            self.begin = stamp.clock;
        }
        if let (Some(beats), Some(drift)) = (self.beats.get_mut(index), self.drifts.get_mut(index))
        {
            *beats = first(lines.iter().map(Beat::from_line));
            *drift = lines.first().and_then(|line| line.drift);
        }
        if !self.segments.complete(stamp.segment, wanted) {
            return Outcome::None;
        }
        let mut drifts = self.drifts.into_iter();
        let lines = self.beats.each_ref().map(|beats| {
            let drift = drifts.next().flatten();
            first(beats.iter().map(|beat| beat.line(drift)))
        });
        // Some clocks do not count the guard: the time between the ramps, which is known, is their unit.
        let ramps = stamp.clock.checked_sub(self.begin).filter(|&samples| samples > 0);
        let passed = self.clock.and_then(|clock| stamp.clock.checked_sub(clock));
        let passed = passed.filter(|&samples| samples > 0);
        let time_s = ramps.zip(passed);
        let time_s = time_s.map(|(ramps, passed)| equations.apart * (passed as f32 / ramps as f32));
        self.clock = Some(stamp.clock);
        let last = Some((&mut self.last, time_s));
        Outcome::Target(solve(&lines, 0, signed, equations, last))
    }
}

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

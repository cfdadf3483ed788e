//! A block's measurement, compiled once for all kinds and lengths of records.

use super::{Measurement, Outcome, ramps::Ramps};
use crate::acquire::sample::{Data, Stamp, Statistics};
use crate::list::first;
use crate::math::scalar::Scalar as _;
use crate::plan::Terms;
use crate::solve::hypothesis::Line;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::{self, Band, Peak, SKIRT};
use crate::spectrum::view::View;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::evidence::Evidence;
use crate::tone::fit::FitNear;
use crate::tone::harmonic::{Harmonic, harmonic};
use crate::tone::lines::{DRIFT, MOST, lines};
use crate::tone::measure::{NO_TONE, rise, with_evidence};
use crate::tone::observer::{Observer, Tap};
use crate::tone::options::Options;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::threshold::{Relaxation, Threshold};
use crate::tone::{FrequencyDrift, Tone, Verdict};
use core::f32::consts::{FRAC_1_PI, FRAC_2_PI};
use heapless::Vec;

/// The least amplitude of a line beside the strongest, as a ratio: -10 dB. A weaker one is not the strongest target's on another ramp, far
/// beyond the spread of levels.
const COMPARABLE: f32 = 0.316;

/// A block whose samples are transformed: what the measurement reads.
#[derive(Clone, Copy, Debug)]
struct Block<'a> {
    /// The samples.
    data: Data<'a>,
    /// The fit for this kind of record.
    fit_near: FitNear,
    /// Samples that touch a rail.
    clipped: u32,
    /// The strongest line of the band, if there is one.
    peak: Option<Peak>,
    /// Where and when the block was taken.
    stamp: &'a Stamp,
    /// The plan.
    terms: &'a Terms,
}

impl Block<'_> {
    /// Measures the block, and leaves the verdict to the caller: returns the tone, so far good, and the evidence.
    fn measured(&self, view: &View) -> (Tone, Evidence) {
        self.measured_by(view, ())
    }

    /// [`Block::measured`] with every test reported to `observer`.
    fn explained(&self, view: &View, observer: &dyn Observer) -> (Tone, Evidence) {
        self.measured_by(view, observer)
    }

    #[inline(always)]
    fn measured_by(&self, view: &View, observer: impl Tap) -> (Tone, Evidence) {
        let &Self { data, fit_near, clipped, ref peak, stamp, terms } = self;
        let &Terms { codes, band, rate_hz, ref options, .. } = terms;
        let (mut tone, mut evidence) = match peak {
            Some(peak) => {
                with_evidence(view, fit_near, data, peak, codes, clipped, stamp, options, observer)
            }
            None => NO_TONE,
        };
        evidence.outside = evidence.found && tone.is_outside(band, view.layout.n);
        tone.rate_hz = rate_hz;
        (tone, evidence)
    }
}

/// A transformed block and its plan.
#[derive(Clone, Copy)]
pub(crate) struct Measured<'a> {
    pub view: View<'a>,
    pub fit_near: FitNear,
    pub terms: &'a Terms,
}

impl<'a> Measured<'a> {
    /// The block as the measurement of its tone reads it.
    #[inline(always)]
    fn read<'b>(&self, stamp: &'b Stamp, data: Data<'b>) -> Block<'b>
    where
        'a: 'b,
    {
        self.read_at(stamp, data, peak::find(&self.view, self.terms.band))
    }

    /// The block with a peak that is found already.
    #[inline(always)]
    fn read_at<'b>(&self, stamp: &'b Stamp, data: Data<'b>, peak: Option<Peak>) -> Block<'b>
    where
        'a: 'b,
    {
        let Self { fit_near, terms, .. } = *self;
        let clipped = Statistics::clipped(data, terms.codes);
        Block { data, fit_near, clipped, peak, stamp, terms }
    }

    /// The verdict of the whole record.
    #[inline(always)]
    fn conclude(
        &self,
        block: &Block,
        (mut tone, mut evidence): (Tone, Evidence),
    ) -> (Tone, Evidence) {
        if block.clipped > 0 {
            evidence.beyond = Statistics::beyond(block.data, self.terms.codes);
        }
        tone.conclude(&evidence);
        (tone, evidence)
    }

    /// [`Pipeline::block`](super::Pipeline::block).
    pub fn block(&self, stamp: &Stamp, data: Data, ramps: &mut Ramps) -> Measurement {
        let block = self.read(stamp, data);
        let (tone, evidence) = self.conclude(&block, block.measured(&self.view));
        let (clipped, result) = (block.clipped, Outcome::None);
        let mut measurement = Measurement { stamp: *stamp, clipped, tone, result };
        let signed = self.view.layout.iq;
        measurement.result = if self.terms.pairs() {
            let drift = evidence.drift.filter(|_| tone.verdict <= Verdict::Moving);
            let others = block.peak.map_or(u64::MAX, |peak| peak.floor);
            let alone = evidence.joined == 0 && self.is_alone(&tone, others);
            let lines = self.beats(&measurement, drift, alone);
            ramps.solve(&self.terms.solver, stamp, &lines, signed)
        } else {
            ramps.solve(&self.terms.solver, stamp, &[Line::from(tone)], signed)
        };
        measurement
    }

    /// [`Pipeline::tone`](super::Pipeline::tone).
    pub fn tone(&self, stamp: &Stamp, data: Data) -> (u32, Tone) {
        self.concluded(&self.read(stamp, data))
    }

    /// The tone at a peak that was found before the spectrum was edited.
    pub fn tone_at(&self, stamp: &Stamp, data: Data, peak: Option<Peak>) -> (u32, Tone) {
        self.concluded(&self.read_at(stamp, data, peak))
    }

    fn concluded(&self, block: &Block) -> (u32, Tone) {
        let (tone, _) = self.conclude(block, block.measured(&self.view));
        (block.clipped, tone)
    }

    /// [`Pipeline::explain`](super::Pipeline::explain).
    pub fn explained(
        &self,
        stamp: &Stamp,
        data: Data,
        observer: &dyn Observer,
    ) -> (u32, Tone, Evidence) {
        let block = self.read(stamp, data);
        let (tone, evidence) = self.conclude(&block, block.explained(&self.view, observer));
        (block.clipped, tone, evidence)
    }

    /// The tone at another peak, tested against `threshold`.
    pub fn at(
        &self,
        stamp: &Stamp,
        data: Data,
        clipped: u32,
        peak: &Peak,
        threshold: Threshold,
    ) -> Tone {
        let terms = Terms { options: Options { threshold, ..self.terms.options }, ..*self.terms };
        let block = Block {
            data,
            fit_near: self.fit_near,
            clipped,
            peak: Some(*peak),
            stamp,
            terms: &terms,
        };
        let (mut tone, evidence) = block.measured(&self.view);
        tone.conclude(&evidence);
        tone
    }

    /// [`Pipeline::rise`](super::Pipeline::rise).
    pub fn rise(&self, measurement: &Measurement) -> Option<FrequencyDrift> {
        let tone = &measurement.tone;
        if tone.verdict != Verdict::Moving {
            return None;
        }
        let peak = libm::rint(tone.frequency.bins(self.view.layout.n)) as i32;
        rise(&self.view, peak, &self.terms.options)
    }

    /// [`Pipeline::lines`](super::Pipeline::lines).
    pub fn lines(&self, measurement: &Measurement, most: usize) -> Vec<ToneWithPhase, MOST> {
        let Measurement { ref stamp, clipped, ref tone, .. } = *measurement;
        let Terms { band, ref options, rate_hz, .. } = *self.terms;
        let mut phasors = lines(&self.view, tone, band, clipped, stamp, options, most);
        for phasor in &mut phasors {
            phasor.tone.rate_hz = rate_hz;
            phasor.tone.keep_to_codes_of(tone);
        }
        phasors
    }

    /// [`Pipeline::harmonic`](super::Pipeline::harmonic).
    pub fn harmonic(&self, measurement: &Measurement, order: u32) -> Option<Harmonic> {
        let Measurement { ref stamp, clipped, ref tone, .. } = *measurement;
        let Terms { band, ref options, rate_hz, .. } = *self.terms;
        let mut harmonic = harmonic(&self.view, tone, band, clipped, stamp, options, order)?;
        harmonic.tone.rate_hz = rate_hz;
        harmonic.tone.keep_to_codes_of(tone);
        Some(harmonic)
    }

    /// The lines of the last block that a target's beats may be, the strongest first: `drift` is the rise of a usable tone, `is_alone`
    /// says that there is no other.
    #[inline(never)]
    fn beats(
        &self,
        measurement: &Measurement,
        drift: Option<FrequencyDrift>,
        is_alone: bool,
    ) -> Vec<Line, MOST> {
        let tone = measurement.tone;
        // The measured tone is the better one if it is alone.
        let alone = || first([Line { tone, drift }].into_iter());
        if tone.verdict > Verdict::Weak || is_alone {
            return alone();
        }
        // Lines are sought in floats, which take fifty blocks' time without an FPU.
        if let Arithmetic::Fixed = self.terms.options.arithmetic.available() {
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
        if tone.verdict > Verdict::Moving {
            return false;
        }
        let layout = self.view.layout;
        let &Layout { n, iq, .. } = layout;
        let peak = libm::rintf(tone.frequency.cycles_f32() * n as f32) as i32;
        // Half a bin off its bins a line has 2/pi of its height, less the leakage of the tone.
        const LEAST: f32 = COMPARABLE * FRAC_2_PI - FRAC_1_PI / (SKIRT as f32 + 0.5);
        // Nor is a bin a line that does not stand out of the noise: the floor of a search has this many degrees of freedom.
        const DOF: f32 = 80.0;
        let bins = if iq { n } else { n / 2 } as f32;
        let height = bins * tone.amplitude * f32::two_to(-self.view.exponent);
        let above = self.terms.options.threshold.beside(DOF, Relaxation::NOTHING);
        let share = (LEAST * LEAST).max(above / (tone.snr * bins));
        let least = (share * (height * height)) as u64;
        let near = |k: i32| layout.apart(k, peak) <= SKIRT || iq && layout.apart(k, 0) < DRIFT;
        let quiet = |k: i32| near(k) || self.view.power(k) < least;
        let partner = (n / 2) as i32 - peak;
        // The sum lacks the skirt of a real tone's partner.
        if others < least && (iq || (partner - SKIRT..=partner + SKIRT).all(quiet)) {
            return true;
        }
        const ROW: i32 = 16;
        let Band { low, high, .. } = self.terms.band;
        let low = if iq { low } else { low.max(DRIFT) };
        (low..=high).step_by(ROW as usize).all(|first| {
            let last = high.min(first + ROW - 1);
            self.view.is_below(least, first, (last - first + 1) as usize)
                || (first..=last).all(quiet)
        })
    }
}

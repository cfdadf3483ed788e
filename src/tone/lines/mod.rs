//! All the lines of a record that are tones, each with its phase: up to [`MOST`].
//!
//! The first tone is the pipeline's own. Each further tone is sought in the second differences of the bins, which are Hann's window: a
//! tone's leakage falls by 18 dB an octave there, and models of the tones found need to be subtracted only near them. A candidate exceeds
//! the floor of its own neighbourhood. Then tones are fitted anew to nine bins, each less the models of the others, until the residual of
//! one in the bins of another does not change. In the end each tone is fitted once more: to 17 bins, or to 33 if it shares the 17 with
//! another.
//!
//! A line that is not a target of its own is refused:
//!
//! - It does not exceed the noise beside it at the plan's false-alarm rate, with all models subtracted.
//! - It is the skirt of a tone that moves.
//! - It is a harmonic that the front end makes of a stronger tone: at 2 to 5 times its frequency,
//!   folded, and [`HARMONIC`] weaker.
//! - It is the image that an I/Q front end makes: at minus the frequency of a stronger tone, and
//!   [`IMAGE`] weaker. Stronger images give both tones the verdict `Image`.
//! - It is a step of the converter: weaker than half a code where no noise blurs the steps.
//! - It is an artefact of the transform: [`ARTEFACT`] weaker than the strongest.

mod fit;
mod floor;
mod leak;
mod refusal;
mod report;
mod rest;

use super::evidence::Evidence;
use super::line_class::FitTest;
use super::noise::ring::LocalNoise;
use super::options::Options;
use super::phasor::ToneWithPhase;
use crate::acquire::sample::Stamp;
use crate::list::{first, remove};
use crate::math::scalar::Scalar as _;
use crate::spectrum::peak::Band;
use crate::spectrum::{layout::Layout, view::View};
use crate::tone::fit::FitStart;
use crate::tone::{Reasons, Tone, Verdict};
use floor::{Blocks, Candidate};
use heapless::Vec;
use leak::{LEAKS, Leak};
pub use refusal::{ARTEFACT, HARMONIC, IMAGE};
use report::{noise_power, phase_of, place};
use rest::{Found, Rest};

/// The most tones a record is searched for.
pub const MOST: usize = 4;

/// Room for the tones and for lines that a front end makes of them, which are subtracted as well.
pub(super) const ROOM: usize = 2 * MOST;

/// Bins beside a tone in which no other is sought.
const BESIDE: i32 = 1;

/// No further tone is sought below this bin, where a drift lies.
pub(crate) const DRIFT: i32 = 4;

/// Bins around a tone whose second differences change when another is found.
const CLOSE: i32 = 4;

/// The most searches of a record.
const SEARCHES: usize = 10;

/// Hidden bins, in which nothing is sought, around one bin.
#[derive(Clone, Copy)]
struct Hidden {
    bin: i32,
    width: i32,
}

/// The properties of a line beside its fit.
#[derive(Clone, Copy)]
struct Mark {
    /// Whether the line is a tone of its own, and not made of a stronger one.
    own: bool,
    /// Whether the line has to be fitted anew.
    due: bool,
    /// The noise power in a bin near the line.
    noise: f32,
    /// The distance up to which the line leaks into second differences of bins.
    reach: i32,
}

/// The tones of a record while they are sought.
pub(super) struct Hunt<'a> {
    layout: &'static Layout,
    rest: Rest<'a>,
    options: &'a Options,
    clipped: f32,
    /// Whether the record is of a ramp, on which a target's motion bends the phase.
    bends: bool,
    /// Whether harmonics and images are reported as well.
    every: bool,
    /// The mark of each line found.
    marks: Vec<Mark, ROOM>,
    hidden: Vec<Hidden, SEARCHES>,
    leaks: Vec<Leak, { 2 * ROOM }>,
    blocks: Blocks,
    /// The noise and the class of each line, when all lines are found.
    judged: Vec<(LocalNoise, FitTest), ROOM>,
}

/// The tones of a record with their phases, the strongest first: `most` tones, at most [`MOST`]. `tone` is the tone that was measured in
/// this spectrum; it is among the result.
///
/// Sigma of each tone comes from the joint fit.
pub fn lines(
    view: &View,
    tone: &Tone,
    band: Band,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    most: usize,
) -> Vec<ToneWithPhase, MOST> {
    let good = tone.verdict == Verdict::Good;
    let alone = if good { phase_of(view, tone, options, stamp.segment.bends()) } else { None };
    if let Some((phasor, true)) = alone
        && most <= 1
    {
        return first([phasor].into_iter());
    }
    let mut hunt = Hunt::new(view, clipped, stamp, options);
    if !hunt.start(tone, band) {
        return Vec::new();
    }
    // What a tone alone does not leave is sought, or it would be in the phase.
    let least = if alone.is_some() { MOST } else { 1 };
    hunt.seek(most.clamp(least, MOST));
    if let (1, Some((phasor, _))) = (hunt.rest.found.len(), alone) {
        return first([phasor].into_iter());
    }
    let mut phasors = hunt.phasors(stamp);
    as_measured(view.layout.n, &mut phasors, tone);
    for ToneWithPhase { tone, .. } in &mut phasors {
        let outside = tone.is_outside(band, view.layout.n);
        tone.conclude(&Evidence { outside, ..Evidence::new(tone.said()) });
    }
    strongest_first(&mut phasors);
    phasors.truncate(most.max(1));
    phasors
}

/// Carries the reasons of the measured tone over to its line. If the record has only this tone, the first measurement is the better one;
/// the same holds for one of several tones whose line looks worse with the others subtracted. Otherwise the reasons that the other lines
/// caused are dropped, and only these.
fn as_measured(n: usize, phasors: &mut [ToneWithPhase], tone: &Tone) {
    let is_measured = |phasor: &&mut ToneWithPhase| {
        phasor.tone.frequency.beyond(tone.frequency).abs() * (n as f32) < 1.0
    };
    let only = phasors.len() == 1;
    /// Verdicts that come from a line's fit, and that lines beside it may have caused.
    const OF_LINE: [Verdict; 3] = [Verdict::Moving, Verdict::Unresolved, Verdict::Weak];
    let others = OF_LINE.into_iter().fold(tone.said(), Reasons::without);
    for phasor in phasors.iter_mut().filter(is_measured) {
        let said = phasor.tone.verdict;
        if only || OF_LINE.contains(&said) && tone.verdict < said {
            phasor.tone = *tone;
        }
        phasor.tone.conclude(&Evidence::new(phasor.tone.said().union(others)));
    }
}

/// Orders tones by their amplitude.
fn strongest_first(phasors: &mut [ToneWithPhase]) {
    // By insertion: there are at most four.
    for end in 1..phasors.len() {
        for place in (1..=end).rev() {
            if let Some([before, here]) = phasors.get_mut(place - 1..=place)
                && here.tone.amplitude > before.tone.amplitude
            {
                core::mem::swap(before, here);
            }
        }
    }
}

/// Every line of a record that exceeds the noise, harmonics and images included: up to [`ROOM`], with what was left of the spectrum.
pub(super) fn every_line<'a>(
    view: &'a View<'a>,
    tone: &Tone,
    clipped: u32,
    stamp: &Stamp,
    options: &'a Options,
) -> Option<(Hunt<'a>, Vec<ToneWithPhase, ROOM>)> {
    let Layout { n, iq, .. } = *view.layout;
    let band = if iq { Band::iq(n) } else { Band::real(n) };
    let mut hunt = Hunt::new(view, clipped, stamp, options);
    if !hunt.start(tone, band) {
        return None;
    }
    hunt.every = true;
    hunt.seek(ROOM);
    let mut phasors = hunt.phasors(stamp);
    as_measured(view.layout.n, &mut phasors, tone);
    Some((hunt, phasors))
}

impl<'a> Hunt<'a> {
    #[inline(always)] // a large object is made in its place
    fn new(view: &'a View<'a>, clipped: u32, stamp: &Stamp, options: &'a Options) -> Self {
        let layout = view.layout;
        Self {
            layout,
            rest: Rest { view, layout, unit: f32::two_to(view.exponent), found: Vec::new() },
            options,
            clipped: clipped as f32 / layout.n as f32,
            bends: stamp.segment.bends(),
            every: false,
            marks: Vec::new(),
            hidden: Vec::new(),
            leaks: Vec::new(),
            blocks: Blocks::new(),
            judged: Vec::new(),
        }
    }

    /// The number of samples, and whether they are I/Q.
    pub(super) fn size(&self) -> (usize, bool) {
        (self.layout.n, self.layout.iq)
    }

    /// The power of half the second difference around a bin less all lines; `None` near the ends, where a drift lies.
    pub(super) fn alone(&self, bin: i32) -> Option<f32> {
        let n = self.layout.n as i32;
        let bin = if self.layout.iq { bin.checked_rem_euclid(n)? } else { bin };
        let end = if self.layout.iq { n } else { n / 2 };
        (DRIFT..=end - DRIFT).contains(&bin).then(|| self.power(bin))
    }

    /// Begins with the tone that was measured; false if there is none.
    fn start(&mut self, tone: &Tone, band: Band) -> bool {
        let Some((peak, offset)) = place(self.layout, tone) else { return false };
        if tone.verdict == Verdict::NoSignal {
            return false;
        }
        self.blocks.start(self.layout, band);
        // A peak at DC is not a tone that could be fitted, but there may be others.
        let noise = noise_power(self.layout, tone) * self.layout.n as f32;
        let mark = Mark { own: true, due: false, noise, reach: LEAKS };
        if self.add(peak, FitStart::From(offset, 1), mark) {
            self.leak();
        }
        true
    }

    /// The tones as fitted now.
    fn phasors<const COUNT: usize>(&mut self, stamp: &Stamp) -> Vec<ToneWithPhase, COUNT> {
        if self.judged.is_empty() {
            self.judge_all();
        }
        first((0..self.rest.found.len()).filter_map(|index| self.phasor(index, stamp)))
    }

    /// Looks for tones until there are `most`, or until none is left. Whether a line exceeds the noise is known only when all others are
    /// subtracted.
    fn seek(&mut self, most: usize) {
        for _ in 0..SEARCHES {
            let own = self.marks.iter().filter(|mark| mark.own).count();
            let full = own >= most || self.rest.found.is_full();
            let Some(candidate) = (if full { None } else { self.search() }) else {
                if self.refuse() {
                    continue;
                }
                return;
            };
            let Candidate { bin, floor } = candidate;
            if self.is_drift(bin) || self.is_skirt(bin) {
                continue;
            }
            // Half the second differences of white noise have 3/2 of a bin's power.
            let reach = Leak::reach(self.power(bin), floor);
            let mark = Mark { own: true, due: false, noise: floor / 1.5, reach };
            if !self.add(bin, FitStart::Usual, mark) {
                self.hide(bin, BESIDE);
                continue;
            }
            self.settle();
            self.renewed();
            if self.is_remainder() {
                self.drop(self.rest.found.len() - 1);
            } else {
                self.disown();
            }
        }
        for _ in 0..ROOM {
            if !self.refuse() {
                break;
            }
        }
    }

    /// Marks the differences around the newest line as changed, and a few around the others.
    fn renewed(&mut self) {
        let newest = self.rest.found.len().wrapping_sub(1);
        for (index, (found, mark)) in self.rest.found.iter().zip(&self.marks).enumerate() {
            let reach = if index == newest { mark.reach } else { CLOSE };
            self.blocks.touch(self.layout, found.peak, reach);
        }
    }

    /// Marks the newest line if a front end made it of another.
    fn disown(&mut self) {
        let target = self.rest.found.last().is_none_or(|newest| self.is_target(newest));
        if let Some(mark) = self.marks.last_mut() {
            mark.own = self.every || target;
        }
    }

    /// Judges all lines, and removes the last further line that does not exceed the noise. Returns whether there is one.
    fn refuse(&mut self) -> bool {
        self.judged.clear();
        if self.rest.found.len() < 2 {
            return false;
        }
        self.judge_all();
        let mut further = self.rest.found.iter().zip(&self.judged).enumerate().skip(1).rev();
        let wrong = further.find(|(_, (found, (beside, _)))| !self.stands_out(found, beside));
        let Some((index, _)) = wrong else { return false };
        self.drop(index);
        true
    }

    /// Removes a line.
    fn drop(&mut self, index: usize) {
        let Some(&Found { peak, .. }) = self.rest.found.get(index) else { return };
        self.tell(index, None);
        remove(&mut self.rest.found, index);
        remove(&mut self.marks, index);
        self.hide(peak, BESIDE);
        self.blocks.touch(self.layout, peak, LEAKS);
        self.settle();
    }

    fn hide(&mut self, bin: i32, width: i32) {
        self.blocks.touch(self.layout, bin, width);
        // A full list ends the search soon.
        let _ = self.hidden.push(Hidden { bin, width });
    }

    fn is_hidden(&self, k: i32) -> bool {
        self.rest.nearest(k) <= BESIDE
            || self.hidden.iter().any(|hidden| self.layout.apart(k, hidden.bin) <= hidden.width)
            || self.layout.iq && self.layout.apart(k, 0) < DRIFT
    }
}

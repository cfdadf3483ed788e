//! All the lines of a record that are tones, each with its phase: up to [`MOST`].
//!
//! The first tone is the pipeline's own. Each further one is sought in the second differences of the
//! bins, which are Hann's window: a tone's leakage falls by 18 dB an octave there, and models of the
//! tones found need to be subtracted only near them. A candidate exceeds the floor of its own
//! neighbourhood. Then all tones are fitted anew, each to bins less the models of the others, until
//! none moves ([`super::several`]).
//!
//! A line that is no target of its own is refused:
//!
//! - It does not exceed the noise beside it at the plan's false-alarm rate, with all models subtracted.
//! - It is the skirt of a tone that moves.
//! - It is a harmonic that the front end makes of a stronger tone: at 2 to 5 times its frequency,
//!   folded, and [`HARMONIC`] weaker.
//! - It is the image that an I/Q front end makes: at minus the frequency of a stronger tone, and
//!   [`IMAGE`] weaker. Stronger images give both tones the verdict `Image`.
//! - It is a step of the converter: weaker than half a code where no noise blurs the steps.
//! - It is what the transform leaves: [`TRANSFORM`] weaker than the strongest.

mod fit;
mod floor;
mod leak;
mod refusal;
mod report;

use super::least_squares::Reach;
use super::measure::Options;
use super::phasor::Phasor;
use super::several::{Found, MOST, Rest, first, remove};
use super::tone::{Tone, Verdict};
use crate::acquire::sample::{Record, Stamp};
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::peak::Band;
use floor::{BLOCKS, Block};
use heapless::Vec;
use leak::Leak;
pub use refusal::{HARMONIC, IMAGE, TRANSFORM};

/// Room for the tones and for lines that a front end makes of them, which are subtracted, too.
pub(super) const ROOM: usize = 2 * MOST;

/// Bins beside a tone in which no other is sought.
const BESIDE: i32 = 1;

/// No further tone is sought below this bin, where a drift is.
const DRIFT: i32 = 4;

/// The most searches of a record.
const SEARCHES: usize = 10;

/// Bins in which nothing is sought, around one of them.
#[derive(Clone, Copy)]
struct Hidden {
    bin: i32,
    width: i32,
}

/// The tones of a record while they are sought.
struct Hunt<'a, R: Record, const N: usize, E: Engine> {
    rest: Rest<'a, R, N, E, ROOM>,
    options: &'a Options,
    band: Band,
    clipped: f32,
    /// Whether lines that are made of others count, too.
    every: bool,
    /// Which of the lines found are tones of their own, and not made of a stronger one.
    own: Vec<bool, ROOM>,
    hidden: Vec<Hidden, SEARCHES>,
    leaks: Vec<Leak, ROOM>,
    /// Those of the last search.
    blocks: Vec<Block, BLOCKS>,
}

/// The tones of a record with their phases, the strongest first as they were found: `most` of them,
/// at most [`MOST`]. `tone` is the one that was measured in this spectrum.
///
/// Sigma of each tone is that of the joint fit.
pub fn lines<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    tone: &Tone,
    band: Band,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    most: usize,
) -> Vec<Phasor, MOST> {
    let Some(mut hunt) = Hunt::start(spectrum, tone, band, clipped, options) else {
        return Vec::new();
    };
    if most > 1 {
        hunt.seek(most.min(MOST));
    }
    let mut phasors = hunt.phasors(stamp);
    // The only tone is known better by what measured it.
    if let [phasor] = phasors.as_mut_slice()
        && phasor.tone.frequency.beyond(tone.frequency).abs() * (N as f32) < 1.0
    {
        phasor.tone = *tone;
    }
    phasors
}

/// Every line of a record that stands out of the noise, also those that are made of another: up to
/// [`ROOM`].
pub(super) fn every_line<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    tone: &Tone,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
) -> Vec<Phasor, ROOM> {
    let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
    let Some(mut hunt) = Hunt::start(spectrum, tone, band, clipped, options) else {
        return Vec::new();
    };
    hunt.every = true;
    hunt.seek(ROOM);
    hunt.phasors(stamp)
}

impl<'a, R: Record, const N: usize, E: Engine> Hunt<'a, R, N, E> {
    /// Begins with the tone that was measured; `None` if there is none.
    fn start(
        spectrum: &'a Spectrum<R, N, E>,
        tone: &Tone,
        band: Band,
        clipped: u32,
        options: &'a Options,
    ) -> Option<Self> {
        let unit = libm::ldexpf(1.0, spectrum.exponent());
        let clipped = clipped as f32 / N as f32;
        let rest = Rest { spectrum, unit, found: Vec::new() };
        let (hidden, leaks) = (Vec::new(), Vec::new());
        let mut hunt = Self {
            rest,
            options,
            band,
            clipped,
            every: false,
            own: Vec::new(),
            hidden,
            leaks,
            blocks: Vec::new(),
        };
        let turn = if R::IQ { N as i32 } else { i32::MAX };
        let peak = (libm::rint(tone.frequency.bins(N)) as i32).checked_rem_euclid(turn)?;
        if tone.verdict == Verdict::NoSignal {
            return None;
        }
        // A peak at DC is no tone that could be fitted, but there may be others.
        if hunt.alone(peak) {
            hunt.leak();
        }
        Some(hunt)
    }

    /// The tones as they are now.
    fn phasors<const COUNT: usize>(&self, stamp: &Stamp) -> Vec<Phasor, COUNT> {
        first((0..self.rest.found.len()).filter_map(|index| self.phasor(index, stamp)))
    }

    /// Looks for tones until there are `most`, or no more. What does not stand out of the noise is
    /// known only when all others are subtracted.
    fn seek(&mut self, most: usize) {
        for _ in 0..SEARCHES {
            let own = self.own.iter().filter(|own| **own).count();
            let full = own >= most || self.rest.found.is_full();
            let Some(bin) = (if full { None } else { self.search() }) else {
                self.settle(self.options.reach);
                if self.refuse() {
                    continue;
                }
                return;
            };
            if self.is_drift(bin) || self.is_skirt(bin) {
                continue;
            }
            if !self.add(bin) {
                self.hide(bin, BESIDE);
                continue;
            }
            self.settle(Reach::Four);
            self.disown();
        }
        for _ in 0..ROOM {
            if !self.refuse() {
                break;
            }
        }
    }

    /// Adds a line; false if no bins can be fitted.
    fn add(&mut self, bin: i32) -> bool {
        self.rest.add(bin) && self.own.push(true).is_ok()
    }

    /// Marks the newest line if it is made of another.
    fn disown(&mut self) {
        let target = self.rest.found.last().is_none_or(|newest| self.is_target(newest));
        if let Some(own) = self.own.last_mut() {
            *own = self.every || target;
        }
    }

    /// Takes out the last further tone that does not stand out of the noise, if there is one.
    fn refuse(&mut self) -> bool {
        let mut further = self.rest.found.iter().enumerate().skip(1).rev();
        let wrong = further.find(|(_, found)| !self.stands_out(found, &self.beside(found.peak)));
        let Some((index, &Found { peak, .. })) = wrong else { return false };
        remove(&mut self.rest.found, index);
        remove(&mut self.own, index);
        self.hide(peak, BESIDE);
        self.settle(self.options.reach);
        true
    }

    /// Takes the leakage of the tones as they are now.
    fn leak(&mut self) {
        self.leaks = first(self.rest.found.iter().map(Leak::of::<R, N>));
    }

    fn hide(&mut self, bin: i32, width: i32) {
        // A full list ends the search soon.
        let _ = self.hidden.push(Hidden { bin, width });
    }

    fn is_hidden(&self, k: i32) -> bool {
        self.rest.nearest(k) <= BESIDE
            || self.hidden.iter().any(|hidden| apart::<R, N>(k, hidden.bin) <= hidden.width)
            || R::IQ && apart::<R, N>(k, 0) < DRIFT
    }
}

/// Bins from one to another, round the circle for I/Q.
fn apart<R: Record, const N: usize>(a: i32, b: i32) -> i32 {
    let (apart, n) = (a.wrapping_sub(b), N as i32);
    if !R::IQ {
        return apart.abs();
    }
    let apart = apart.checked_rem_euclid(n).unwrap_or(0);
    apart.min(n - apart)
}

//! Weak echoes: the spectra of M blocks added without their phases (non-coherent integration).
//!
//! A line below the noise of one block stands out from the sum of many, because the noise scatters less around its mean: the threshold falls
//! by 5 dB for ten times as many blocks, somewhat more for few. This is how a coherent wind lidar works, and any sensor whose echo is
//! weak and has a new phase in each block.
//!
//! ```
//! use picket_dsp::{Accumulator, Codes, Config, Pipeline, Real, Verdict};
//! # use picket_dsp::Stamp;
//! # let mut state = 1u32;
//! # let mut noise = || { (0..12).map(|_| { state = state.wrapping_mul(1664525).wrapping_add(1013904223); f64::from(state >> 8) / 16777216.0 - 0.5 }).sum::<f64>() };
//!
//! let config = Config::new(1e6, Codes::signed::<12>());
//! let mut pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
//! let mut sum = Accumulator::<Real, 1024>::new(100);
//! # let mut found = None;
//! # for block in 0..100 {
//! # let samples: [i16; 1024] = std::array::from_fn(|n| (0.15 * 200.0 * (1.234 * n as f64 + 7.0 * f64::from(block)).cos() + 200.0 * noise()) as i16);
//! # let stamp = Stamp { sequence: block, ..Stamp::default() };
//! // for each block:
//! let measurement = pipeline.block(&stamp, &samples);
//! if let Some(accumulated) = sum.add(&measurement, &pipeline) {
//!     println!("{}", accumulated.tone); // after 100 blocks
//! #     found = Some(accumulated.tone);
//! }
//! # }
//! # let tone = found.unwrap();
//! # assert_eq!(tone.verdict, Verdict::Good, "{tone}");
//! # assert!((tone.frequency.cycles() - 1.234 / std::f64::consts::TAU).abs() < 5.0 * f64::from(tone.sigma));
//! # Ok::<(), picket_dsp::ConfigError>(())
//! ```
//!
//! # What is added
//!
//! Powers alone show the place of a line, but a line near the middle of its bin leaves little in the others: its frequency errs by 4 to 16
//! times the bound. The products of neighbouring bins hold the missing information. With the record's middle as the origin of time, a line
//! of amplitude `a` at `f` bins makes bins `W_k = a D(f - k)` with the real kernel `D(u) = sin(pi u) / (N sin(pi u / N))`, so over M blocks
//! of any phases
//!
//! ```text
//! E sum Re(conj(W_i) W_j) = M |a|^2 D(f - i) D(f - j) + M P [i = j]
//! ```
//!
//! The sums are kept for j - i = 0 to 3 and all i: each bin has the sums for a fit to the bins around it, wherever a line turns out to be.
//! Line and frequency are fitted to the sums by least squares.
//!
//! # Drift
//!
//! A line that moves between blocks smears. Where the rate is known (a chirp's own drift, a platform's acceleration), each block's bins are
//! moved back by this drift before they are added, by the interpolation that the kernel gives: [`Accumulator::with_drift`].

mod detection;
mod fit;
mod moved;
mod sums;

use crate::acquire::sample::{Cells, Record, Segment};
use crate::frequency::Frequency;
use crate::pipeline::{Measurement, Pipeline};
use crate::plan::Terms;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::integer::{self, Point};
use crate::spectrum::layout::Layout;
use crate::spectrum::view::View;
use crate::tone::sigma::CLIPPED;
use crate::tone::threshold::FALSE_ALARM;
use crate::tone::verdict::Reasons;
use crate::tone::{Tone, Verdict};
use detection::Peak;
use moved::Moved;
use sums::{Adder, Scale, Sums};

/// The most blocks of a sum.
pub const MOST_BLOCKS: u32 = 1 << 16;

/// The result of a sum of blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Accumulated {
    /// The strongest line. Its amplitude is the root of the mean square over the blocks, its signal-to-noise ratio is per sample. With a
    /// drift its frequency belongs to the middle between the first and the last block.
    pub tone: Tone,
    /// The natural logarithm of the probability that noise alone shows such a line anywhere in the band.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::number"))]
    pub ln_chance: f32,
    /// The blocks that were added.
    pub blocks: u32,
}

/// A probability of a false alarm, held to its range: 1e-30 where it is NaN.
const fn held(probability: f64) -> f64 {
    probability.max(1e-30).min(0.5)
}

/// Adds blocks and measures the strongest line of their sum.
///
/// Its memory is `8 N` bytes for real records and `16 N` for I/Q, however many blocks are added: four numbers of 32 bits a bin,
/// which share one exponent.
///
/// A chirp has an accumulator for each segment, see [`Accumulator::for_segment`].
///
/// ```
/// use picket_dsp::{Accumulated, Accumulator, Codes, Pipeline, Plan, Real, Stamp, Verdict};
///
/// let mut pipeline = Pipeline::<Real, 256>::new(Plan::tone(1e6, Codes::signed::<12>()));
/// let mut sum = Accumulator::<Real, 256>::new(100);
/// let mut state = 1u32;
/// let mut sample = |n: usize| {
///     state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     (f64::from(state >> 8) / f64::from(1 << 16) - 128.0 + 20.0 * (1.234 * n as f64).sin()) as i16
/// };
/// // A tone 14 dB below the noise: no block shows it, a hundred together do.
/// for sequence in 0..100 {
///     let stamp = Stamp { sequence, ..Stamp::default() };
///     let block = pipeline.block(&stamp, &std::array::from_fn(&mut sample));
///     assert_eq!(block.tone.verdict, Verdict::Weak);
///     let Some(Accumulated { tone, .. }) = sum.add(&block, &pipeline) else { continue };
///     assert_eq!((sequence, tone.verdict), (99, Verdict::Good));
///     let error = tone.hertz() - 1.234 / std::f64::consts::TAU * 1e6;
///     assert!(error.abs() < 3.0 * tone.sigma_hertz(), "{tone}");
/// }
/// # assert_eq!(sum.added(), 0);
/// ```
#[derive(Clone)]
pub struct Accumulator<R: Record, const N: usize> {
    /// The sums, see [`Sums`].
    near: R::Cells<i32, N>,
    far: R::Cells<i32, N>,
    progress: Progress,
}

/// What an accumulator adds, and its progress. Compiled once for all kinds and lengths of records.
#[derive(Clone, Copy, Debug)]
struct Progress {
    scale: Scale,
    /// The blocks of a sum.
    blocks: u32,
    /// The segment whose blocks are added, if blocks of other segments are ignored.
    segment: Segment,
    of_segment: bool,
    /// The line's move in bins from block to block.
    drift: f32,
    false_alarm: f64,
    /// The number of the sum's first block.
    first: u32,
    /// Blocks with more clipped samples than a tone may have.
    clipped: u32,
}

/// Without the sums themselves.
impl<R: Record, const N: usize> core::fmt::Debug for Accumulator<R, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Accumulator").field("progress", &self.progress).finish_non_exhaustive()
    }
}

impl<R: Record, const N: usize> Accumulator<R, N> {
    /// A placeholder of zeros that waits for [`Accumulator::set_plan`]: for static memory.
    pub const IDLE: Self = Self {
        near: <R::Cells<i32, N> as Cells<i32>>::ZERO,
        far: <R::Cells<i32, N> as Cells<i32>>::ZERO,
        progress: Progress {
            scale: Scale::NOTHING,
            blocks: 0,
            segment: Segment::Continuous,
            of_segment: false,
            drift: 0.0,
            false_alarm: 0.0,
            first: 0,
            clipped: 0,
        },
    };

    /// An accumulator for sums of `blocks` blocks, held to 1..=[`MOST_BLOCKS`].
    pub const fn new(blocks: u32) -> Self {
        let blocks = if blocks == 0 { 1 } else { blocks };
        let blocks = if blocks > MOST_BLOCKS { MOST_BLOCKS } else { blocks };
        let mut sum = Self::IDLE;
        (sum.progress.blocks, sum.progress.false_alarm) = (blocks, FALSE_ALARM);
        sum
    }

    /// Adds only the blocks of one segment of a chirp, and ignores the others.
    #[must_use]
    pub const fn for_segment(mut self, segment: Segment) -> Self {
        (self.progress.segment, self.progress.of_segment) = (segment, true);
        self
    }

    /// Sets the line's move in bins from one block to the next, by the blocks' numbers. Each block of a sum is moved back. A drift that is
    /// not finite is 0. Cost: 52 products of 64 bits a bin.
    #[must_use]
    pub fn with_drift(mut self, bins_per_block: f32) -> Self {
        self.progress.drift = if bins_per_block.is_finite() { bins_per_block } else { 0.0 };
        self
    }

    /// Sets the probability for each sum that noise alone passes for a tone, held to 1e-30..=0.5; the default is 1e-6.
    #[must_use]
    pub const fn with_false_alarm(mut self, probability: f64) -> Self {
        self.progress.false_alarm = held(probability);
        self
    }

    /// Begins again with these blocks in a sum, this move of the line in bins from block to block, and this probability of a false alarm:
    /// each held to its range.
    pub fn set_plan(&mut self, blocks: u32, drift_bins: f32, false_alarm: f64) {
        self.progress.blocks = blocks.clamp(1, MOST_BLOCKS);
        self.progress.drift = if drift_bins.is_finite() { drift_bins } else { 0.0 };
        self.progress.false_alarm = held(false_alarm);
        self.clear();
    }

    /// The blocks of a sum.
    pub const fn blocks(&self) -> u32 {
        self.progress.blocks
    }

    /// The number of blocks in the sum in progress.
    pub const fn added(&self) -> u32 {
        self.progress.scale.blocks
    }

    /// Forgets the sum in progress.
    pub fn clear(&mut self) {
        self.progress.clear(self.near.points_mut(), self.far.points_mut());
    }

    /// Adds the block that `pipeline` measured last, and returns the result if it completes a sum.
    ///
    /// A gap between blocks does no harm: the phases are not compared. Cost: a search over all bins, and eight products of
    /// 32 bits a bin; the result costs a look at each bin and one fit.
    pub fn add<E: Engine>(
        &mut self,
        measurement: &Measurement,
        pipeline: &Pipeline<R, N, E>,
    ) -> Option<Accumulated> {
        let view = pipeline.spectrum().view();
        let Self { near, far, progress } = self;
        progress.add(measurement, &view, pipeline.plan(), near.points_mut(), far.points_mut())
    }

    /// The result of the blocks added so far. `terms` belong to the pipeline's plan.
    pub fn result(&self, terms: &Terms) -> Accumulated {
        let Self { near, far, progress } = self;
        let (layout, scale) = (Layout::of::<R, N>(), progress.scale);
        let sums = Sums { layout, near: near.points(), far: far.points(), scale };
        progress.result(&sums, terms)
    }
}

impl Progress {
    /// Adds a block to the sums if it belongs to them, and returns the result if that completes them.
    fn add(
        &mut self,
        measurement: &Measurement,
        view: &View,
        terms: &Terms,
        near: &mut [Point],
        far: &mut [Point],
    ) -> Option<Accumulated> {
        let stamp = &measurement.stamp;
        if self.of_segment && self.segment != stamp.segment {
            return None;
        }
        if self.scale.blocks == 0 {
            self.first = stamp.sequence;
        }
        let n = view.layout.n;
        let share = measurement.clipped as f32 / n as f32;
        self.clipped = self.clipped.wrapping_add(u32::from(share > CLIPPED));
        // The middle of the sum, where blocks follow each other, stays where it is.
        let middle = 0.5 * self.blocks.wrapping_sub(1) as f32;
        let number = stamp.sequence.wrapping_sub(self.first);
        let moved = Moved::new(self.drift * (number as f32 - middle), n);
        Adder { near, far, scale: &mut self.scale }.add(view, moved.as_ref());
        if self.scale.blocks < self.blocks {
            return None;
        }
        let sums = Sums { layout: view.layout, near, far, scale: self.scale };
        let result = self.result(&sums, terms);
        self.clear(near, far);
        Some(result)
    }

    fn clear(&mut self, near: &mut [Point], far: &mut [Point]) {
        near.fill([0; 2]);
        far.fill([0; 2]);
        (self.scale, self.clipped) = (Scale::NOTHING, 0);
    }

    fn result(&self, sums: &Sums, terms: &Terms) -> Accumulated {
        let Layout { n, iq, .. } = *sums.layout;
        let false_alarm = self.false_alarm;
        let blocks = sums.scale.blocks;
        let nothing = Tone { verdict: Verdict::NoSignal, rate_hz: terms.rate_hz, ..Tone::ZERO };
        let nothing = Accumulated { tone: nothing, ln_chance: 0.0, blocks };
        let Some(place) = Peak::strongest(sums, terms.band) else {
            return nothing;
        };
        let Some(fit) = fit::fit(sums, &place) else {
            return nothing;
        };
        let ln_chance = place.ln_chance(blocks, terms.band.width());
        let Some(frequency) = Frequency::from_bins(place.bin, fit.offset, n) else {
            return nothing;
        };
        let mut reasons = Reasons::NONE;
        if f64::from(ln_chance) > libm::log(false_alarm) {
            reasons = reasons.with(Verdict::Weak);
        }
        let bins = frequency.bins(n).abs();
        // A real line has its image at both ends, an I/Q line the offset at 0 Hz.
        let end = if iq { bins } else { bins.min(n as f64 / 2.0 - bins) };
        if end < 1.5 || !terms.band.holds(frequency, n) {
            reasons = reasons.with(Verdict::NearEdge);
        }
        if fit.wide {
            reasons = reasons.with(Verdict::Moving);
        }
        if self.clipped > 0 {
            reasons = reasons.with(Verdict::Clipped);
        }
        // The engine's rounding moves a line equally in each block, the carrier's width differently.
        let engine = integer::error(n, iq);
        let width = terms.options.width.of_sum(blocks.max(1));
        let variance = f64::from(fit.variance + engine * engine + width);
        let line = fit.power * place.noise * sums.unit() * sums.unit();
        let n = n as f32;
        let (snr, amplitude) = if iq {
            (fit.power / n, libm::sqrtf(line) / n)
        } else {
            (2.0 * fit.power / n, 2.0 * libm::sqrtf(line) / n)
        };
        let sigma = libm::sqrt(variance) as f32 / n;
        let reasons = reasons.with_sigma(sigma);
        let tone =
            Tone { frequency, sigma, snr, amplitude, ..Tone::with_reasons(reasons, terms.rate_hz) };
        Accumulated { tone, ln_chance, blocks }
    }
}

//! What the samples that touch no rail say of a tone.
//!
//! A rail takes from a sample what the tone has beyond it. That makes harmonics, which fold all over the spectrum and near simple
//! fractions of the rate onto the tone itself. How far they move a frequency depends on everything about the record; but nobody
//! needs to know the harmonics, for between the rails nothing is missing. One Gauss-Newton step over these samples
//! alone, from a fit to the whole record, ends where the tone is:
//!
//! ```text
//! x[n] - A cos p[n]  ~  m + a cos p + b sin p - pi A d w sin p        p[n] the fitted phase, w = -1..1 over the record
//! ```
//!
//! by least squares for a constant m, for a, b and the distance d in bins. Nothing is assumed of the rails, of an
//! offset or of the share that is missing. A quadrature part is a real record of its own, a quarter turn behind.
//!
//! Noise decides about samples near a rail: those that it leaves between the rails lean away from them. So a sample counts
//! only if the one a [`Return`] on, whose noise is another, is further from the rails than noise goes.
//!
//! The loop runs in integers, for cores without an FPU: phases turn in Q30, residuals are in sixteenths of a code. In each of 32 blocks
//! w is constant as a weight, which costs nothing but a thousandth of the information.

use super::frequency::Frequency;
use super::least_squares::Fit;
use super::least_squares::fixed::{product, quantised};
use super::noise::whole_fixed::{Turn, turned};
use super::returns::{Part, Return};
use super::within;
use crate::acquire::codes::Codes;
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use core::ops::Range;
use num_complex::Complex;

/// Blocks of a record. The blocks of very long ones are shorter, for a phase loses bits as it turns.
const BLOCKS: usize = 32;
const LONGEST: usize = 1024;

/// How many standard deviations noise goes.
const DEVIATIONS: f32 = 4.0;

/// An offset has no more bins than this: further off no clipped tone was ever seen, not even of those of which a few phases are
/// left, and they at the rails.
const FARTHEST: f32 = 0.25;

/// What the samples between the rails say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unclipped {
    /// Noise power per sample (I/Q: of both parts together), in squared codes.
    pub noise: f32,
    /// How far the tone is from the frequency that was asked about, in bins.
    pub offset: f32,
    /// How well they pin it: the noise power divided by this is the variance of the offset in bins^2.
    pub information: f32,
}

impl Unclipped {
    /// Asks about a `tone` (its complex amplitude at the first sample) at a `frequency`, as found in the whole record; `None`
    /// where the rails leave too little.
    ///
    /// Cost: one pass (I/Q: for each part), and that of [`Return`].
    pub fn of<R: Record>(
        samples: &[R::Sample],
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
    ) -> Option<Self> {
        Self::of_parts(Part::first::<R>(samples), codes, frequency, tone)
    }

    /// The same about a fit, once for all kinds and lengths of records.
    #[inline(never)]
    pub(super) fn of_fit(part: Part, codes: Codes, peak: i32, fit: &Fit<f32>) -> Option<Self> {
        let frequency = Frequency::of_bins(peak, fit.offset, part.length)?;
        Self::of_parts(part, codes, frequency, fit.tone_of(part.second().is_some(), part.length))
    }

    fn of_parts(
        part: Part,
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
    ) -> Option<Self> {
        let again = Return::of(frequency, part.length);
        let mut noise = again.noise(part, codes)?;
        let search = Search { codes, lag: again.lag, frequency, noise };
        let mut found = search.part(part, tone);
        if let Some(other) = part.second() {
            found = found.and(search.part(other, Complex::new(tone.im, -tone.re)));
            // Of both parts.
            noise = noise + noise;
            found.information = found.information + found.information;
        }
        let Found { offset, information } = found;
        Some(Self { noise, offset: within(offset, FARTHEST), information })
    }

    /// The noise power per sample that disturbs the tone, from what a fit leaves in its own bins (see
    /// [`residual`](super::measure::residual)) and the share of clipped samples, which have no noise and lessen that.
    ///
    /// A front end that limits is noisier near its rails, and at other frequencies than the tone's: then the noise of all samples is too
    /// much. Where a harmonic is among the fit's bins, their rest is.
    pub fn near(&self, residual: f32, clipped: f32) -> f32 {
        self.noise.min(residual / (1.0 - clipped))
    }

    /// One standard deviation, in bins, of the frequency that was asked about, of which noise of this power alone would make
    /// `sigma` in a whole record.
    ///
    /// The offset is known, but not taken away: it is what a reader must reckon with.
    pub fn widened(&self, sigma: f32, noise: f32) -> f32 {
        let variance = (sigma * sigma).max(noise / self.information);
        (variance + self.offset * self.offset).root()
    }
}

/// An offset, and how well it is known: noise power of a part divided by the information is its variance.
#[derive(Clone, Copy)]
struct Found {
    offset: f32,
    information: f32,
}

impl Found {
    /// Both together.
    fn and(self, other: Self) -> Self {
        let information = self.information + other.information;
        let sum = self.offset * self.information + other.offset * other.information;
        Self { offset: sum / information, information }
    }
}

/// What the parts of a record have in common.
struct Search {
    codes: Codes,
    lag: usize,
    frequency: Frequency,
    /// Noise power of a part.
    noise: f32,
}

impl Search {
    #[allow(clippy::manual_clamp)] // `clamp` checks its bounds
    #[inline(never)]
    fn part(&self, part: Part, tone: Complex<f32>) -> Found {
        let amplitude = tone.norm_sqr().root().max(1.0);
        let length = (part.length / BLOCKS).min(LONGEST).max(1);
        let step = self.frequency.0.to_bits();
        let model = Model {
            forward: turn_of(step),
            amplitude: quantised(amplitude, 6),
            rails: self.codes.rails(),
            margin: self.margin(),
        };
        let forward = turn_of(step.wrapping_mul(length as i32));
        let mut turn = q30(tone / amplitude);
        let mut equations = Equations::default();
        let (mut start, per) = (0, 1.0 / part.length.max(1) as f32);
        while start < part.length {
            let end = (start + length).min(part.length);
            // A return on, or before at the end of the record.
            let before = end + self.lag > part.length;
            let away = if before { self.lag.wrapping_neg() } else { self.lag };
            let sums = model.sums(part, start..end, away, turn);
            equations.add(&sums, (start + end) as f32 * per - 1.0);
            turn = turned(turn, forward);
            start = end;
        }
        equations.solved(amplitude)
    }

    /// How far noise goes, in codes; not so far that nothing is left.
    fn margin(&self) -> i16 {
        let (low, high) = self.codes.rails();
        let most = (i32::from(high) - i32::from(low)) >> 3;
        ((DEVIATIONS * self.noise.root()) as i32).min(most) as i16
    }
}

fn turn_of(steps: i32) -> Turn {
    q30(f32::unit(steps as f32 * (1.0 / 4_294_967_296.0)))
}

fn q30(z: Complex<f32>) -> Turn {
    [quantised(z.re, 30), quantised(z.im, 30)]
}

/// What a loop over samples needs to know.
struct Model {
    /// The tone's turn from sample to sample.
    forward: Turn,
    /// In sixty-fourths of a code.
    amplitude: i32,
    rails: (i16, i16),
    margin: i16,
}

/// Sums over the samples of a block that count, with c = cos p and s = sin p in Q15 and the residual r in sixteenths.
#[derive(Default)]
struct Sums {
    count: i32,
    c: i32,
    s: i32,
    cc: i64,
    cs: i64,
    r: i32,
    rc: i64,
    rs: i64,
}

impl Model {
    #[inline(always)]
    fn sums(&self, part: Part, block: Range<usize>, away: usize, start: Turn) -> Sums {
        let (low, high) = self.rails;
        let (lowest, highest) = (low.saturating_add(self.margin), high.saturating_sub(self.margin));
        let mut sums = Sums::default();
        let mut turn = start;
        for n in block {
            let (Some(y), Some(other)) = (part.at(n), part.at(n.wrapping_add(away))) else { break };
            if low < y && y < high && lowest < other && other < highest {
                // Sixty-fourths times Q30, less 32 bits.
                let model = (product(self.amplitude, turn[0]) >> 32) as i32;
                sums.add((i32::from(y) << 4).wrapping_sub(model), turn.map(|x| x >> 15));
            }
            turn = turned(turn, self.forward);
        }
        sums
    }
}

impl Sums {
    // Blocks are so short that nothing overflows: at most 1024 samples of 22 bits.
    #[inline(always)]
    fn add(&mut self, r: i32, [c, s]: [i32; 2]) {
        self.count = self.count.wrapping_add(1);
        self.c = self.c.wrapping_add(c);
        self.s = self.s.wrapping_add(s);
        self.cc = self.cc.wrapping_add(product(c, c));
        self.cs = self.cs.wrapping_add(product(c, s));
        self.r = self.r.wrapping_add(r);
        self.rc = self.rc.wrapping_add(product(r, c));
        self.rs = self.rs.wrapping_add(product(r, s));
    }
}

/// The normal equations for m, a, b and -pi A d: of their symmetric matrix what begins on the diagonal, and then the right side.
#[derive(Default)]
struct Equations {
    rows: [[f32; 5]; 4],
}

impl Equations {
    /// Adds a block whose middle is at `w`.
    fn add(&mut self, sums: &Sums, w: f32) {
        const UNIT: f32 = 1.0 / 32768.0;
        const CODE: f32 = 1.0 / 16.0;
        let n = sums.count as f32;
        let [c, s] = [sums.c, sums.s].map(|sum| sum as f32 * UNIT);
        let [cc, cs] = [sums.cc, sums.cs].map(|sum| (sum >> 15) as i32 as f32 * UNIT);
        let r = sums.r as f32 * CODE;
        let [rc, rs] = [sums.rc, sums.rs].map(|sum| (sum >> 15) as i32 as f32 * CODE);
        let ss = n - cc;
        let block = [
            [n, c, s, w * s, r],
            [cc, cs, w * cs, rc, 0.0],
            [ss, w * ss, rs, 0.0, 0.0],
            [w * w * ss, w * rs, 0.0, 0.0, 0.0],
        ];
        for (row, more) in self.rows.iter_mut().zip(&block) {
            row.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
    }

    /// By elimination; the last unknown is the first to be known.
    fn solved(mut self, amplitude: f32) -> Found {
        /// Where less is left of a pivot nobody knows.
        const LEAST: f32 = 1e-3;
        let mut rows = self.rows.as_mut_slice();
        while let Some((first, rest)) = rows.split_first_mut() {
            let [pivot, tail @ ..] = first;
            *pivot = pivot.max(LEAST);
            let mut tail = tail.as_slice();
            for row in rest.iter_mut() {
                let factor = tail.first().map_or(0.0, |head| head / *pivot);
                row.iter_mut().zip(tail).for_each(|(cell, x)| *cell -= factor * x);
                tail = tail.get(1..).unwrap_or(&[]);
            }
            rows = rest;
        }
        let [_, [cc, cs, wcs, rc, _], [ss, wss, rs, ..], [wwss, wrs, ..]] = self.rows;
        let d = wrs / wwss;
        let b = (rs - wss * d) / ss;
        let a = (rc - cs * b - wcs * d) / cc;
        // The tone without the rails is stronger.
        let slope = core::f32::consts::PI * (amplitude + a).max(amplitude);
        Found { offset: -d / slope, information: wwss * slope * slope }
    }
}

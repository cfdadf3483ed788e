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
//! The loop runs in integers, for cores without an FPU. The record is cut into blocks. The tone's phase starts anew in
//! each, so one table of cosines and sines serves them all, and a block's sums are turned by its first phase. Where no
//! sample is left out, the sums of the tone alone are those of the table. In each block w is constant as a weight, which
//! costs nothing but a thousandth of the information.

use super::frequency::Frequency;
use super::least_squares::Fit;
use super::least_squares::fixed::quantised;
use super::noise_fixed::Turn;
use super::returns::{Between, Part, Return};
use super::within;
use crate::acquire::codes::Codes;
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use num_complex::Complex;

/// Blocks of a record, at most.
const BLOCKS: usize = 32;

/// Samples of a block, at least, for shorter ones take longer.
const SHORTEST: usize = 8;

/// Samples of a block, at most: those of a record of 4096.
const LONGEST: usize = 128;

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
    #[inline(never)]
    fn part(&self, part: Part, tone: Complex<f32>) -> Found {
        let amplitude = tone.norm_sqr().root().max(1.0);
        let length = (part.length / BLOCKS).clamp(SHORTEST, LONGEST);
        let step = self.frequency.0.to_bits();
        let table = Table::of(turn_of(step), length);
        let forward = turn_of(step.wrapping_mul(length as i32));
        let rails = self.rails();
        let mut turn = q30(tone / amplitude);
        let mut equations = Equations::default();
        let per = 1.0 / part.length.max(1) as f32;
        for start in (0..part.length).step_by(length) {
            let end = (start + length).min(part.length);
            // A return on, or before at the end of the record.
            let before = end + self.lag > part.length;
            let other = if before { start.saturating_sub(self.lag) } else { start + self.lag };
            let (samples, others) = (part.from(start), part.from(other));
            let sums = if part.stride() == 1 {
                table.sums::<1>(samples, others, &rails)
            } else {
                table.sums::<2>(samples, others, &rails)
            };
            let start_turn = Complex::new(turn[0] as f32, turn[1] as f32) * (1.0 / ONE);
            equations.add(&sums.turned(start_turn), amplitude, (start + end) as f32 * per - 1.0);
            turn = advanced(turn, forward);
        }
        equations.solved(amplitude)
    }

    /// The codes between the rails, and those that noise does not take to a rail; if it takes all, some are left.
    fn rails(&self) -> [Between; 2] {
        let (low, high) = self.codes.rails();
        let most = (i32::from(high) - i32::from(low)) >> 3;
        let margin = ((DEVIATIONS * self.noise.root()) as i32).min(most) as i16;
        [(low, high), (low.saturating_add(margin), high.saturating_sub(margin))].map(Between::of)
    }
}

/// 1 in Q30.
const ONE: f32 = 1_073_741_824.0;

fn turn_of(steps: i32) -> Turn {
    q30(f32::unit(steps as f32 * (1.0 / 4_294_967_296.0)))
}

fn q30(z: Complex<f32>) -> Turn {
    [quantised(z.re, 30), quantised(z.im, 30)]
}

/// A turn by another; the last two bits are lost.
#[inline(always)]
fn advanced([a, b]: Turn, [c, d]: Turn) -> Turn {
    let upper = |x: i32, y: i32| ((i64::from(x) * i64::from(y)) >> 32) as i32;
    [(upper(a, c) - upper(b, d)) << 2, (upper(a, d) + upper(b, c)) << 2]
}

/// Cosine and sine of a tone in a block that it enters with phase 0, in Q15, and their sums.
struct Table {
    turns: [[i16; 2]; LONGEST],
    sums: Sums,
}

impl Table {
    fn of(forward: Turn, length: usize) -> Self {
        let mut table = Self { turns: [[0; 2]; LONGEST], sums: Sums::default() };
        let mut turn = [1 << 30, 0];
        for place in table.turns.iter_mut().take(length) {
            *place = turn.map(|x| ((x + (1 << 14)) >> 15).min(32767) as i16);
            table.sums.take(*place);
            turn = advanced(turn, forward);
        }
        table
    }

    /// The sums over the samples of a block that count, those whose other has one, too. They are
    /// `STRIDE` numbers apart.
    #[inline(never)] // its loop needs all registers
    fn sums<const STRIDE: usize>(
        &self,
        samples: &[i16],
        others: &[i16],
        [inside, far_inside]: &[Between; 2],
    ) -> Sums {
        let Sums { mut count, mut c, mut s, mut cc, mut cs, mut y, mut yc, mut ys } = self.sums;
        let turns = self.turns.get(..count as usize).unwrap_or_default();
        let pairs = samples.chunks(STRIDE).zip(others.chunks(STRIDE));
        for (&[cosine, sine], (sample, other)) in turns.iter().zip(pairs) {
            let (Some(&sample), Some(&other)) = (sample.first(), other.first()) else { break };
            let (cosine, sine) = (i32::from(cosine), i32::from(sine));
            if inside.holds(sample) && far_inside.holds(other) {
                let sample = i32::from(sample);
                y = y.wrapping_add(sample);
                yc = yc.wrapping_add(rounded(sample.wrapping_mul(cosine)));
                ys = ys.wrapping_add(rounded(sample.wrapping_mul(sine)));
            } else {
                count = count.wrapping_sub(1);
                c = c.wrapping_sub(cosine);
                s = s.wrapping_sub(sine);
                cc = cc.wrapping_sub(rounded(cosine.wrapping_mul(cosine)));
                cs = cs.wrapping_sub(rounded(cosine.wrapping_mul(sine)));
            }
        }
        Sums { count, c, s, cc, cs, y, yc, ys }
    }
}

/// A product without its lowest bits, so that those of a block add up in 32.
#[inline(always)]
fn rounded(product: i32) -> i32 {
    product.wrapping_add(1 << (DROPPED - 1)) >> DROPPED
}

const DROPPED: u32 = LONGEST.trailing_zeros();

/// A product that was rounded is in units of this, with a factor in Q15 or with two.
const UNIT: f32 = 1.0 / 32768.0;
const PRODUCT: f32 = LONGEST as f32 * UNIT;

/// Sums over the samples y of a block, with c and s the cosine and sine of the tone's phase in Q15.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: i32,
    c: i32,
    s: i32,
    cc: i32,
    cs: i32,
    y: i32,
    yc: i32,
    ys: i32,
}

impl Sums {
    /// Adds the tone at a sample.
    fn take(&mut self, [c, s]: [i16; 2]) {
        let [c, s] = [c, s].map(i32::from);
        self.count = self.count.wrapping_add(1);
        self.c = self.c.wrapping_add(c);
        self.s = self.s.wrapping_add(s);
        self.cc = self.cc.wrapping_add(rounded(c.wrapping_mul(c)));
        self.cs = self.cs.wrapping_add(rounded(c.wrapping_mul(s)));
    }

    /// The sums for a tone that enters the block with this phase.
    fn turned(&self, phase: Complex<f32>) -> Turned {
        let half = 0.5 * self.count as f32;
        let first = Complex::new(self.c as f32, self.s as f32) * phase;
        let [cc, cs] = [self.cc, self.cs].map(|sum| sum as f32 * (PRODUCT * UNIT));
        let second = Complex::new(cc - half, cs) * (phase * phase);
        let y = Complex::new(self.yc as f32, self.ys as f32) * phase;
        Turned {
            count: self.count as f32,
            c: first.re * UNIT,
            s: first.im * UNIT,
            cc: half + second.re,
            cs: second.im,
            y: self.y as f32,
            yc: y.re * PRODUCT,
            ys: y.im * PRODUCT,
        }
    }
}

/// [`Sums`] for the tone's own phase.
struct Turned {
    count: f32,
    c: f32,
    s: f32,
    cc: f32,
    cs: f32,
    y: f32,
    yc: f32,
    ys: f32,
}

/// The normal equations for m, a, b and -pi A d: of their symmetric matrix what begins on the diagonal, and then the right side.
#[derive(Default)]
struct Equations {
    rows: [[f32; 5]; 4],
}

impl Equations {
    /// Adds a block whose middle is at `w`.
    fn add(&mut self, sums: &Turned, amplitude: f32, w: f32) {
        let &Turned { count: n, c, s, cc, cs, y, yc, ys } = sums;
        let (r, rc, rs) = (y - amplitude * c, yc - amplitude * cc, ys - amplitude * cs);
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

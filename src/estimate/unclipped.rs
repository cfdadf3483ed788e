//! A tone's frequency from the samples that touch no rail.
//!
//! A rail cuts off the part of the tone beyond it. That makes harmonics, which fold all over the
//! spectrum. Near simple fractions of the rate they fold onto the tone itself. How far they move
//! its frequency depends on everything about the record. But the harmonics need not be known,
//! because between the rails nothing is missing. So a fit to the whole record is followed by one
//! Gauss-Newton step over these samples alone:
//!
//! ```text
//! x[n] - A cos p[n]  ~  m + a cos p + b sin p - pi A d w sin p        p[n] the fitted phase, w = -1..1 over the record
//! ```
//!
//! by least squares for a constant m, for a, b and the distance d in bins. The step assumes
//! nothing about the rails, an offset or the share that is missing. A quadrature part is a real
//! record of its own, a quarter turn behind.
//!
//! Noise selects the samples near a rail: those that it leaves between the rails lean away from
//! them. So a sample counts only if the sample one [`Lag`] on, whose noise is independent, is
//! farther from the rails than noise goes.
//!
//! The loop runs in integers, for cores without an FPU. The record is cut into blocks. The tone's
//! phase starts anew in each block, so one table of cosines and sines serves them all, and a
//! block's sums are turned by its first phase. In a block that leaves no sample out the sums of
//! the tone alone are those of the table. Within a block the weight w is constant, which costs less
//! than a hundredth of the information. Of a long record only the outer blocks are read, because a
//! sample tells as much about the frequency as the square of its distance from the middle.

use super::carrier::{Carrier, LONGEST, Turned, advanced};
use super::frequency::Frequency;
use super::lag::Lag;
use super::least_squares::Fit;
use super::least_squares::fixed::quantised;
use super::noise::whole_fixed::Turn;
use super::part::Part;
use super::within;
use crate::acquire::codes::{Between, Codes};
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use num_complex::Complex;

/// The most blocks of a record that is read whole.
const BLOCKS: usize = 32;

/// The fewest samples of a block: shorter blocks cost more.
const SHORTEST: usize = 8;

/// Of a record of this length or a longer one, only blocks whose middle is at least this far from the record's
/// middle, where its ends are at 1, are read: a quarter of the record has six tenths of the information about the
/// frequency. Such blocks are a sixteenth of the record, but not shorter than this.
const LONG: usize = 512;
const OUTER: f32 = 0.75;
const LONG_BLOCKS: usize = 16;
const LONG_SHORTEST: usize = 64;

/// Noise stays within this many standard deviations.
const DEVIATIONS: f32 = 4.0;

/// The largest offset, bins. No clipped tone was seen farther off, even if only a few phases are
/// left and lie at the rails.
const FARTHEST: f32 = 0.25;

/// The result of the samples between the rails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unclipped {
    /// Noise power per sample (I/Q: of both parts together), in squared codes.
    pub noise: f32,
    /// The distance of the tone from the stated frequency, in bins.
    pub offset: f32,
    /// The information about the offset: the noise power divided by it is the variance of the
    /// offset in bins^2.
    pub information: f32,
    /// The share of the whole record's information that was left unread.
    pub missed: f32,
}

impl Unclipped {
    /// Fits the tone near a `frequency`, with the complex amplitude `tone` at the first sample,
    /// both as found in the whole record. `None` if the rails leave too few samples.
    ///
    /// Cost: one pass over the outer quarter of the record (I/Q: for each part), over all of it below 512
    /// samples, and that of [`Lag`].
    pub fn of<R: Record>(
        samples: &[R::Sample],
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
    ) -> Option<Self> {
        Self::of_parts(Part::first::<R>(samples), codes, frequency, tone, false)
    }

    /// [`Unclipped::of`] by its definition in portable code. Tests compare kernels with it.
    pub fn of_portably<R: Record>(
        samples: &[R::Sample],
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
    ) -> Option<Self> {
        Self::of_parts(Part::first::<R>(samples), codes, frequency, tone, true)
    }

    /// The same from a fit, compiled once for all kinds and lengths of records.
    #[inline(never)]
    pub(super) fn of_fit(part: Part, codes: Codes, peak: i32, fit: &Fit<f32>) -> Option<Self> {
        let frequency = Frequency::of_bins(peak, fit.offset, part.length)?;
        Self::of_parts(
            part,
            codes,
            frequency,
            fit.tone_of(part.second().is_some(), part.length),
            false,
        )
    }

    fn of_parts(
        part: Part,
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
        portably: bool,
    ) -> Option<Self> {
        let again = Lag::of(frequency, part.length);
        let mut noise = again.noise(part, codes)?;
        let search = Search { codes, lag: again.samples, frequency, noise, portably };
        let mut found = search.part(part, tone);
        if let Some(other) = part.second() {
            found = found.and(search.part(other, Complex::new(tone.im, -tone.re)));
            // The noise of both parts.
            noise = noise + noise;
            found.information = found.information + found.information;
        }
        let Found { offset, information } = found;
        let missed = if part.length < LONG { 0.0 } else { OUTER * OUTER * OUTER };
        Some(Self { noise, offset: within(offset, FARTHEST), information, missed })
    }

    /// The noise power per sample that disturbs the tone. It follows from the power that a fit
    /// leaves in its own bins (see [`residual`](super::measure::residual)) and from the share of
    /// clipped samples, which have no noise and lessen that power.
    ///
    /// A front end that limits is noisier near its rails, and at other frequencies than the
    /// tone's: then the noise of all samples is too much. If a harmonic is among the fit's bins,
    /// their residual is too much.
    pub fn near(&self, residual: f32, clipped: f32) -> f32 {
        self.noise.min(residual / (1.0 - clipped))
    }

    /// One standard deviation, in bins, of the stated frequency; noise of this power alone would
    /// make `sigma` in a whole record.
    ///
    /// The offset is known, but the frequency is not corrected by it. So it is part of the error.
    pub fn widened(&self, sigma: f32, noise: f32) -> f32 {
        let own = noise / self.information;
        // What was read scatters about what all of it would have told, which scatters by the rest.
        let scatter = self.missed * own;
        let variance = (sigma * sigma).max(own - scatter);
        (variance + (self.offset * self.offset - scatter).max(0.0)).root()
    }
}

/// An offset and its information: the noise power of a part divided by it is the offset's
/// variance.
#[derive(Clone, Copy)]
struct Found {
    offset: f32,
    information: f32,
}

impl Found {
    /// The result of two parts.
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
    /// The noise power of a part.
    noise: f32,
    /// Whether the portable definition runs in place of the kernel.
    portably: bool,
}

impl Search {
    #[inline(never)]
    fn part(&self, part: Part, tone: Complex<f32>) -> Found {
        let amplitude = tone.norm_sqr().root().max(1.0);
        let length = if part.length < LONG {
            (part.length / BLOCKS).max(SHORTEST)
        } else {
            (part.length / LONG_BLOCKS).clamp(LONG_SHORTEST, LONGEST)
        };
        let unread = if part.length < LONG { 0 } else { (OUTER * part.length as f32) as usize };
        let step = self.frequency.0.to_bits();
        let mut carrier = Carrier::empty();
        carrier.fill(turn_of(step), length);
        let forward = turn_of(step.wrapping_mul(length as i32));
        let rails = self.rails();
        let mut turn = q30(tone / amplitude);
        let mut equations = Equations::default();
        let per = 1.0 / part.length.max(1) as f32;
        let mut start = 0;
        while start < part.length {
            let end = (start + length).min(part.length);
            let off = (start + end).abs_diff(part.length);
            if off < unread {
                turn = advanced(turn, forward);
                start = end;
                continue;
            }
            let w = (start + end) as f32 * per - 1.0;
            // One lag on, or one lag back at the end of the record.
            let before = end + self.lag > part.length;
            let other = if before { start.saturating_sub(self.lag) } else { start + self.lag };
            let (samples, others) = (part.from(start), part.from(other));
            let sums = match (part.stride(), self.portably) {
                (1, false) => carrier.sums(samples, others, &rails),
                (1, true) => carrier.sums_portably::<1>(samples, others, 0, &rails),
                _ => carrier.sums_portably::<2>(samples, others, part.which(), &rails),
            };
            let phase = Complex::new(turn[0] as f32, turn[1] as f32) * (1.0 / ONE);
            let sums = sums.turned(phase);
            equations.add(&sums, amplitude, w);
            turn = advanced(turn, forward);
            start = end;
        }
        equations.solved(amplitude)
    }

    /// The codes between the rails, and those that noise does not move to a rail. If noise could
    /// move all, some remain.
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

/// The normal equations for m, a, b and -pi A d: sums of products of 1, c, s, w s and the rest r of
/// a sample.
#[derive(Default)]
struct Equations {
    n: f32,
    c: f32,
    s: f32,
    ws: f32,
    r: f32,
    cc: f32,
    cs: f32,
    wcs: f32,
    rc: f32,
    ss: f32,
    wss: f32,
    rs: f32,
    wwss: f32,
    wrs: f32,
}

impl Equations {
    /// Adds a block whose middle is at `w`.
    fn add(&mut self, sums: &Turned, amplitude: f32, w: f32) {
        let &Turned { count: n, c, s, cc, cs, y, yc, ys } = sums;
        let (ss, rs) = (n - cc, ys - amplitude * cs);
        let wss = w * ss;
        self.n += n;
        self.c += c;
        self.s += s;
        self.ws += w * s;
        self.r += y - amplitude * c;
        self.cc += cc;
        self.cs += cs;
        self.wcs += w * cs;
        self.rc += yc - amplitude * cc;
        self.ss += ss;
        self.wss += wss;
        self.rs += rs;
        self.wwss += w * wss;
        self.wrs += w * rs;
    }

    /// Solves the equations by elimination of m, a and b.
    fn solved(mut self, amplitude: f32) -> Found {
        /// With a smaller pivot the unknown is not determined.
        const LEAST: f32 = 1e-3;
        let inverse = 1.0 / self.n.max(LEAST);
        let (by_c, by_s, by_ws) = (self.c * inverse, self.s * inverse, self.ws * inverse);
        let cc = (self.cc - by_c * self.c).max(LEAST);
        self.cs -= by_c * self.s;
        self.wcs -= by_c * self.ws;
        self.rc -= by_c * self.r;
        self.ss -= by_s * self.s;
        self.wss -= by_s * self.ws;
        self.rs -= by_s * self.r;
        self.wwss -= by_ws * self.ws;
        self.wrs -= by_ws * self.r;
        let inverse = 1.0 / cc;
        let (by_cs, by_wcs) = (self.cs * inverse, self.wcs * inverse);
        let ss = (self.ss - by_cs * self.cs).max(LEAST);
        self.wss -= by_cs * self.wcs;
        self.rs -= by_cs * self.rc;
        self.wwss -= by_wcs * self.wcs;
        self.wrs -= by_wcs * self.rc;
        let by_wss = self.wss / ss;
        let wwss = (self.wwss - by_wss * self.wss).max(LEAST);
        let d = (self.wrs - by_wss * self.rs) / wwss;
        let b = (self.rs - self.wss * d) / ss;
        let a = (self.rc - self.cs * b - self.wcs * d) * inverse;
        // Without the rails the tone is stronger.
        let slope = core::f32::consts::PI * (amplitude + a).max(amplitude);
        Found { offset: -d / slope, information: wwss * slope * slope }
    }
}

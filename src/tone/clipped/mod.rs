//! A tone's frequency from the samples that touch no rail.
//!
//! A rail cuts off the part of the tone beyond it. The cut makes harmonics, which fold all over the spectrum. Near simple fractions of the
//! rate they fold onto the tone itself, and the shift of its frequency depends on everything about the record. But the harmonics need not
//! be known, because between the rails nothing is missing. So a fit to the whole record is followed by one Gauss-Newton step over the
//! samples between the rails alone:
//!
//! ```text
//! x[n] - A cos p[n]  ~  m + a cos p + b sin p - pi A d w sin p        p[n] the fitted phase, w = -1..1 over the record
//! ```
//!
//! by least squares for a constant m, for a, b and the distance d in bins. The step assumes nothing about the rails, an offset or the
//! missing share. A quadrature part is a real record of its own, a quarter turn behind.
//!
//! Noise selects the samples near a rail: samples that noise leaves between the rails lean away from them. So a sample counts only if the
//! sample one [`Lag`] on, whose noise is independent, is farther from the rails than noise reaches.
//!
//! All sums are integers, for cores without an FPU; floats only solve the last three equations. The record is cut into blocks. The tone's
//! phase starts anew in each block, so one table of cosines and sines serves all blocks, and a block's sums are turned by its first phase.
//! In a block that leaves no sample out the sums of the tone alone are the table's own sums. Within a block the weight w is constant, which
//! costs less than a hundredth of the information. Of a long record only the ends are read, because a sample's information about the
//! frequency is the square of its distance from the middle.

mod carrier;
#[cfg(dsp)]
mod carrier_dsp;
mod equations;
pub mod lag;
pub(super) mod part;
mod turn;

use super::within;
use crate::acquire::codes::{Between, Codes};
use crate::acquire::sample::Data;
use crate::frequency::Frequency;
use crate::math::scalar::Scalar;
use crate::tone::fit::Fit;
use crate::tone::fit::fixed::quantised;
use carrier::{Carrier, LONGEST};
use equations::{Equations, Found};
use fixed::types::I2F30;
use heapless::Vec;
use lag::Lag;
use num_complex::Complex;
use part::Part;
use turn::{Turn, turned};

/// A record is cut into this many blocks, but not into shorter ones: they cost more.
const BLOCKS: usize = 16;
const SHORTEST: usize = 8;

/// Of a record of this length or a longer one, only blocks at both ends are read: 5 samples in 64 of a record of up to 1024, which have
/// four tenths of the information about the frequency, half as many again of longer ones. Longer records know the frequency better, so
/// harmonics that fold onto the tone matter more to them.
const LONG: usize = 512;

/// The most blocks at each end, reached by a record of 4096. The sums have room for no more.
const MOST: usize = 6;

/// A board's lengths are powers of two; a host has others, and longer ones.
const ANY: bool = !cfg!(target_os = "none");

/// The samples that are read: the number at each end, and the number in a block, a multiple of eight.
fn read(length: usize) -> (usize, usize) {
    let whole = |block: usize| if ANY { block & !(SHORTEST - 1) } else { block };
    if length < LONG {
        let (half, block) = (length / 2, whole(length / BLOCKS).max(SHORTEST));
        return (if ANY { half - half % block } else { half }, block);
    }
    let (block, blocks) = (whole(5 * length / 64).min(LONGEST), (3 * length / 2048).max(1));
    (block * if ANY { blocks.min(MOST) } else { blocks }, block)
}

/// `x / length` in steps of 2^-`bits`, without a division where the length is a power of two.
fn share(x: i32, bits: u32, length: usize) -> i32 {
    let log = length.trailing_zeros();
    if !ANY || length.is_power_of_two() && log < 15 {
        return (x << bits) >> log;
    }
    (x as f32 * f32::two_to(bits as i32) / length as f32) as i32
}

/// Noise stays within this many standard deviations.
const DEVIATIONS: f32 = 4.0;

/// The largest offset seen in simulation, bins, even if only a few phases are left and lie at the rails.
const FARTHEST: f32 = 0.25;

/// The result of the samples between the rails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CensoredFit {
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

impl CensoredFit {
    /// Fits the tone near a `frequency`, with the complex amplitude `tone` at the first sample, both as found in the whole record. `None`
    /// if the rails leave too few samples.
    ///
    /// Cost: one pass over a sixth of the record, at its ends (I/Q: for each part), over all of it below 512 samples, and the cost of
    /// [`Lag`].
    pub fn from_record(
        data: Data,
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
    ) -> Option<Self> {
        Self::from_parts(Part::first(data), codes, frequency, (tone, 0), false)
    }

    /// [`CensoredFit::from_record`] by its definition in portable code. Tests compare kernels with it.
    pub fn from_record_portably(
        data: Data,
        codes: Codes,
        frequency: Frequency,
        tone: Complex<f32>,
    ) -> Option<Self> {
        Self::from_parts(Part::first(data), codes, frequency, (tone, 0), true)
    }

    /// The censored fit after a fit to the bins, compiled once for all kinds and lengths of records.
    #[inline(never)]
    pub(super) fn from_fit(part: Part, codes: Codes, peak: i32, fit: &Fit<f32>) -> Option<Self> {
        let offset = I2F30::from_bits(quantised(fit.offset, 30));
        let frequency = Frequency::from_fixed(peak, offset, part.length);
        let line = fit.line_of(part.second().is_some(), part.length);
        Self::from_parts(part, codes, frequency, line, false)
    }

    /// The censored fit of a tone that is turned on by an angle.
    fn from_parts(
        part: Part,
        codes: Codes,
        frequency: Frequency,
        (tone, angle): (Complex<f32>, i32),
        portably: bool,
    ) -> Option<Self> {
        let again = Lag::from_frequency(frequency, part.length);
        let mut noise = again.noise(part, codes)?;
        let amplitude = tone.norm_sqr().root().max(1.0);
        let scale = turn::ONE as f32 / amplitude;
        let phase = turned(turn::from_angle(angle), [tone.re, tone.im].map(|x| (x * scale) as i32));
        let search = Search {
            rails: rails(codes, noise),
            lag: again.samples,
            step: frequency.0.to_bits(),
            amplitude: amplitude.min(65_535.0) as i32,
            portably,
        };
        let mut found = search.part(part, phase);
        if let Some(other) = part.second() {
            let [cos, sin] = phase;
            found = found.and(search.part(other, [sin, -cos]));
            // The noise of both parts.
            noise = noise + noise;
            found.information = found.information + found.information;
        }
        let Found { offset, information } = found;
        // The information grows with the square of the distance from the middle.
        let (read, _) = read(part.length);
        let unread = share((part.length - 2 * read) as i32, 10, part.length);
        let missed = (unread * unread * unread) as f32 * (1.0 / turn::ONE as f32);
        Some(Self { noise, offset: within(offset, FARTHEST), information, missed })
    }

    /// The noise power per sample that disturbs the tone. It follows from the power that a fit leaves in its own bins (see
    /// `residual`) and from the share of clipped samples, which have no noise and lessen the residual.
    ///
    /// A front end that limits is noisier near its rails, and at other frequencies than the tone's: then the noise of all samples is too
    /// high. If a harmonic is among the fit's bins, their residual is too high.
    pub fn near(&self, residual: f32, clipped: f32) -> f32 {
        self.noise.min(residual / (1.0 - clipped))
    }

    /// One standard deviation, in bins, of the stated frequency; noise of this power alone would make `sigma` in a whole record.
    ///
    /// The offset is known, but the frequency is not corrected by the offset. So the offset is part of the error.
    pub fn widened(&self, sigma: f32, noise: f32) -> f32 {
        let own = noise / self.information;
        // The estimate from the samples read scatters about the estimate from all, with the variance of the rest.
        let scatter = self.missed * own;
        let variance = (sigma * sigma).max(own - scatter);
        // A quarter of the scatter comes off the offset: with all of it off, a scatter opposite to an error would hide the error.
        (variance + (self.offset * self.offset - 0.25 * scatter).max(0.0)).root()
    }
}

/// The constants that the parts of a record share.
struct Search {
    /// The codes between the rails, and the codes that noise does not move to a rail.
    rails: [Between; 2],
    lag: usize,
    /// The frequency, in steps of 2^-32 turns.
    step: i32,
    /// The amplitude in codes.
    amplitude: i32,
    /// Whether the portable definition runs in place of the kernel.
    portably: bool,
}

impl Search {
    /// The result of one part, for the tone with this phase at the first sample.
    #[inline(never)]
    fn part(&self, part: Part, first: Turn) -> Found {
        let length = part.length;
        let (read, block) = read(length);
        let carrier = Carrier::new(turn::from_angle(self.step), block);
        let mut equations = Equations::new(self.amplitude);
        let (mut own, mut apart) = (Vec::<i16, LONGEST>::new(), Vec::<i16, LONGEST>::new());
        let mut start = 0;
        while start < length {
            let end = start + block;
            // One lag on, or one lag back at the end of the record.
            let before = end + self.lag > length;
            let other = if before { start.saturating_sub(self.lag) } else { start + self.lag };
            let (samples, others) = (part.from(start, &mut own), part.from(other, &mut apart));
            let sums = if self.portably {
                carrier.sums_portably(samples, others, &self.rails)
            } else {
                carrier.sums(samples, others, &self.rails)
            };
            let phase = turned(turn::from_angle(self.step.wrapping_mul(start as i32)), first);
            let middle = (start + end) as i32 - length as i32;
            equations.add(&sums.turned(phase), share(middle, 16, length));
            start = if end == read { length - read } else { end };
        }
        equations.solved()
    }
}

/// The codes between the rails, and the codes that noise does not move to a rail. If noise could move all, some remain.
fn rails(codes: Codes, noise: f32) -> [Between; 2] {
    let (low, high) = codes.rails();
    let most = (i32::from(high) - i32::from(low)) >> 3;
    let margin = ((DEVIATIONS * noise.root()) as i32).min(most) as i16;
    [(low, high), (low.saturating_add(margin), high.saturating_sub(margin))].map(Between::new)
}

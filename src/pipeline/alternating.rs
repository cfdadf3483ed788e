//! I/Q pairs that one converter takes in turn: I, Q, I, Q, at equal distances.
//!
//! In such pairs the Q comes half a pair late. If they are measured as simultaneous, a tone of `f` cycles per pair has an image of
//! `tan(pi f / 2)` of the tone at minus its frequency. Turning each bin of Q back by its delay is right only for a tone with a whole number
//! of cycles.
//!
//! Here each sample keeps its own time. With the signs `+ - - +`, which begin again every second pair,
//! the 2 N samples are
//!
//! ```text
//! I(0)  -Q(1/2)  -I(1)  Q(3/2)  ... = Re z(n/2) exp(j pi n / 2),  n = 0 .. 2 N - 1
//! ```
//!
//! of `z = I + j Q`, with times in pairs: a real record at twice the rate of the pairs, in which all frequencies are half that rate higher.
//! Frequencies of -1/2 to 1/2 cycle per pair lie between 0 and half of the double rate, without an image, and a [`Pipeline`] for real
//! records measures them. The frequency of the pairs is the real record's less half their rate; its sign is right, and a phase keeps its
//! direction.
//!
//! - **Offset.** A code is negated about the middle between the rails: `low + high - code`, exact, and a rail stays a rail. For rails at 0
//!   and 4095 the middle is 2047.5, half a code below [`Codes::middle`](crate::acquire::codes::Codes::middle). The middle falls into the
//!   real record's bin 0, which is never read. The channels' offsets from it fall into one bin, the bin of 0 Hz, like the offsets of any
//!   I/Q record. This bin is not searched, and a tone is measured without it: it gets the value that the tone leaves there. Within 1.5 bins
//!   of 0 Hz a tone is [`Verdict::NearEdge`].
//! - **Errors of gain and phase** make an image as in any I/Q record. An image that is stronger than -20 dB, such as a dead channel's, has
//!   the verdict [`Verdict::Image`].
//! - **Both ends** of the spectrum behave as in a real record: within 1.5 bins of plus or minus half the rate of the pairs a tone is
//!   [`Verdict::NearEdge`].
//! - Frequencies come in steps of 2^-31 cycle per pair.

use super::{Measurement, Pipeline};
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Data, Iq, Real, Stamp};
use crate::frequency::Frequency;
use crate::math::scalar::Scalar;
use crate::methods::registry::Method;
use crate::plan::{Plan, Terms};
use crate::solve::hypothesis::Line;
use crate::spectrum::Spectrum;
use crate::spectrum::peak::{self, Band, Peak};
use crate::tone::evidence::Evidence;
use crate::tone::threshold::{Relaxation, Threshold};
use crate::tone::{Tone, Verdict};
use fixed::types::I0F32;
use num_complex::Complex;

/// A pipeline for `N` pairs that are taken in turn, which are `TWICE = 2 N` real samples.
///
/// ```
/// use picket_dsp::pipeline::Alternating;
/// use picket_dsp::{Codes, Iq, Plan, Stamp};
///
/// let mut pipeline = Alternating::<256, 512>::new(Plan::<Iq, 256>::tone(1e3, Codes::signed::<12>()));
/// let turn = |pairs: f64| (1000.0 * (std::f64::consts::TAU * -0.2 * pairs).cos()) as i16;
/// // Q is I a quarter of a turn later, and is taken half a pair later.
/// let mut pairs = std::array::from_fn(|n| [turn(n as f64), turn(n as f64 + 0.5 + 1.25)]);
/// let tone = pipeline.block(&Stamp::default(), &mut pairs).tone;
/// assert!((tone.hertz() + 200.0).abs() < 0.01);
/// ```
#[derive(Clone, Debug)]
pub struct Alternating<const N: usize, const TWICE: usize> {
    pipeline: Pipeline<Real, TWICE>,
}

impl<const N: usize, const TWICE: usize> Alternating<N, TWICE> {
    /// A placeholder of zeros that gets its plan later, like [`Plan::IDLE`].
    pub const IDLE: Self = Self { pipeline: Pipeline::new(Plan::IDLE) };

    /// A pipeline that follows `plan`. A method that [does not fit](Self::fits) becomes least squares.
    pub fn new(plan: Plan<Iq, N>) -> Self {
        Self { pipeline: Pipeline::new(Self::real(&plan)) }
    }

    /// Follows another plan from the next block on.
    pub fn set_plan(&mut self, plan: Plan<Iq, N>) {
        self.pipeline.set_plan(Self::real(&plan));
    }

    /// The real record's spectrum of the last block. The pairs' bin `k` is its bin `k + N/2`.
    pub const fn spectrum(&self) -> &Spectrum<Real, TWICE> {
        self.pipeline.spectrum()
    }

    /// Whether a method works on pairs that are taken in turn: it must work on real records.
    pub const fn fits(method: Method) -> bool {
        method.from_kind::<Real>().fits::<Real>()
    }

    /// The plan of the real record.
    fn real(plan: &Plan<Iq, N>) -> Plan<Real, TWICE> {
        const { assert!(TWICE == 2 * N, "N pairs are 2 N samples") };
        let mut terms = Terms { n: TWICE as u32, iq: false, ..**plan };
        terms.band = raised(terms.band, N as i32);
        let method = terms.options.method;
        let method = if Self::fits(method) { method } else { Method::LeastSquares };
        terms.options.method = method.from_kind::<Real>();
        // The terms are for these records.
        Plan::from_terms(terms).unwrap_or(Plan::IDLE)
    }

    /// Measures one block of pairs. The method negates half of the codes in their place, and turns them back.
    ///
    /// [`Measurement::clipped`] counts samples, of which a pair has two. Cost: one real transform of twice as many samples as there are
    /// pairs, one search, one fit.
    pub fn block(&mut self, stamp: &Stamp, pairs: &mut [[i16; 2]; N]) -> Measurement {
        let codes = self.pipeline.plan.codes;
        turn(pairs, codes);
        let (clipped, tone) = self.tone(stamp, pairs.as_flattened());
        turn(pairs, codes);
        let Terms { solver, .. } = &*self.pipeline.plan;
        let result = self.pipeline.ramps.solve(solver, stamp, &[Line::from(tone)], true);
        Measurement { stamp: *stamp, clipped, tone, result }
    }

    /// The tone of the pairs, from their real record.
    fn tone(&mut self, stamp: &Stamp, samples: &[i16]) -> (u32, Tone) {
        // The length is right.
        let Ok(samples) = samples.try_into() else { return Default::default() };
        self.pipeline.transform(samples);
        let peak = peak::find(&self.pipeline.spectrum.view(), self.pipeline.plan.band);
        if let Some(peak) = &peak {
            without_offset(&mut self.pipeline.spectrum, peak);
        }
        let (clipped, tone) =
            self.pipeline.measured().tone_at(stamp, Data::of::<Real>(samples), peak);
        if tone.verdict == Verdict::NoSignal {
            return (clipped, tone);
        }
        let mut pairs =
            Tone { frequency: lowered(tone.frequency), sigma: 2.0 * tone.sigma, ..tone };
        let image = self.mirrored(&tone);
        let edge_bins = pairs.frequency.bins(N).abs() as f32;
        let sigma = pairs.sigma;
        pairs.conclude(&Evidence { image, edge_bins, sigma, ..Evidence::new(tone.said()) });
        (clipped, pairs)
    }

    /// Whether there is a line at minus the tone's frequency of -20 dB or more.
    fn mirrored(&self, tone: &Tone) -> bool {
        /// Amplitude of the image over the tone's; half-way between two bins a line loses 3.9 dB.
        const SHARE: f32 = 0.1 * 0.64;
        /// Pairs' bins from 0 Hz, and from half the rate, where the two lines leak into each other.
        const NEAREST: i32 = 3;
        /// Minimum degrees of freedom of the noise around a tone.
        const DOF: f32 = 32.0;
        let n = N as i32;
        let from_dc = nearest(tone.frequency, TWICE).wrapping_sub(n / 2);
        let far = from_dc.abs();
        if far <= NEAREST || far >= n / 2 - NEAREST {
            return false;
        }
        let spectrum = self.spectrum();
        let image = n / 2 - from_dc;
        let most = [-1, 0, 1].map(|i| spectrum.power(image.wrapping_add(i))).into_iter().max();
        let unit = f32::two_to(spectrum.exponent());
        let line = tone.amplitude * N as f32;
        let ratio = most.unwrap_or(0) as f32 * (unit * unit) / (line * line);
        // The tone's own leakage at its maximum.
        let leak = core::f32::consts::FRAC_1_PI / ((2 * far) as f32 - 1.5);
        let share = SHARE + leak;
        // Three bins of noise exceed this in a block of a million.
        let chance = const { Threshold::new(3, 1e-6) };
        ratio > share * share
            && chance.detects_beside(ratio * tone.snr * N as f32, DOF, Relaxation::NOTHING)
    }
}

/// Removes the channels' offsets from the bin of 0 Hz: a tone's bins are `C / (f - k)`, so the bin's two neighbours give the value that the
/// tone at `peak` leaves there.
fn without_offset<const N: usize>(spectrum: &mut Spectrum<Real, N>, peak: &Peak) {
    let middle = N as i32 / 4;
    let bins = |around: i32| {
        [-1, 0, 1].map(|i| {
            let Complex { re, im } = spectrum.bin(around.wrapping_add(i));
            Complex::new(re as f32, im as f32)
        })
    };
    let away = peak.bin.wrapping_sub(middle);
    // Beside 0 Hz the offset is one of the peak's own three bins.
    if away.abs() <= 1 {
        return;
    }
    let [before, at, after] = bins(peak.bin);
    // Jacobsen's offset; an invalid one counts as 0.
    let offset = ((before - after) / (at + at - before - after)).re;
    let offset = if offset.abs() < 0.6 { offset } else { 0.0 };
    let far = away as f32 + offset;
    let [below, _, above] = bins(middle);
    let left = (below * (far + 1.0) + above * (far - 1.0)) / (far + far);
    // Casts saturate.
    spectrum.put_quarter(Complex::new(left.re as i32, left.im as i32));
}

/// Negates the second and the third of every four samples about the middle between the rails. A second call restores the codes.
fn turn(pairs: &mut [[i16; 2]], codes: Codes) {
    let (low, high) = codes.rails();
    // Between the rails the difference fits, however the sum wraps round.
    let sum = low.wrapping_add(high);
    for four in pairs.as_flattened_mut().as_chunks_mut::<4>().0 {
        let [_, q, i, _] = four;
        (*q, *i) = (sum.wrapping_sub(*q), sum.wrapping_sub(*i));
    }
}

/// A band of pairs in the real record: half the rate of the pairs higher, with the channels' offsets.
fn raised(band: Band, n: i32) -> Band {
    let whole = Band { offset: n / 2, ..Band::real(2 * n as usize) };
    let [low, high] = [band.low, band.high].map(|bin| bin.wrapping_add(n / 2));
    // Numbers above half the rate are negative frequencies: the band is the whole spectrum.
    if low < 0 || high > n {
        return whole;
    }
    let [low, high] = [low, high].map(|bin| bin.clamp(whole.low, whole.high));
    Band { low, high, ..whole }
}

/// A frequency of the real record as one of the pairs, round the circle: `2 f - 1/2`.
fn lowered(Frequency(real): Frequency) -> Frequency {
    Frequency(I0F32::from_bits(real.to_bits().wrapping_mul(2).wrapping_add(i32::MIN)))
}

/// The bin nearest to a frequency, in a record of `n` samples.
const fn nearest(Frequency(frequency): Frequency, n: usize) -> i32 {
    // Half a bin, so that the shift rounds.
    ((frequency.to_bits() as i64 * n as i64 + (1 << 31)) >> 32) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_turn_about_the_middle_and_back() {
        for codes in [Codes::unsigned::<12>(), Codes::signed::<16>(), Codes::unsigned::<15>()] {
            let (low, high) = codes.rails();
            let before = [[low, low], [high, high], [low + 5, high - 7], [high, low]];
            let mut pairs = before;
            turn(&mut pairs, codes);
            assert_eq!(pairs, [[low, high], [low, high], [low + 5, low + 7], [low, low]]);
            turn(&mut pairs, codes);
            assert_eq!(pairs, before);
        }
    }

    #[test]
    fn the_real_record_is_half_the_rate_higher() {
        for bin in [1, 212, 511, 512, 513, 1023] {
            let real = Frequency::from_bins(bin, 0.25f32, 2048).unwrap();
            assert_eq!(lowered(real).bins(1024), f64::from(bin - 512) + 0.25);
            assert_eq!(nearest(real, 2048), bin);
        }
        assert_eq!(nearest(Frequency::from_bins(9, -0.4f32, 128).unwrap(), 128), 9);
    }

    #[test]
    fn a_band_keeps_to_its_sideband() {
        let of = |low, high| {
            let Band { low, high, offset } = raised(Band::new(low, high), 1024);
            assert_eq!(offset, 512);
            (low, high)
        };
        assert_eq!(of(3, 400), (515, 912));
        assert_eq!(of(-400, -3), (112, 509));
        assert_eq!(of(-512, 512), (1, 1023));
        // The whole circle, from 0 on.
        assert_eq!(of(0, 1023), (1, 1023));
    }
}

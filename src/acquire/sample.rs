//! The converter's output: records and the blocks that carry them.

use super::codes::{Between, Codes};
use num_complex::Complex;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Real {}
    impl Sealed for super::Iq {}
}

/// A kind of record: [`Real`] samples or [`Iq`] pairs.
///
/// The two are different types because not every estimator takes both: the autocorrelation family
/// is wrong by 0.2 to 0.5 bin on real samples and does not take them.
pub trait Record: sealed::Sealed + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// One sample: `i16`, or an `[i, q]` pair.
    type Sample: Copy + Default + core::fmt::Debug + Send + Sync + 'static;
    /// Work memory to transform `N` samples: one number for each number of the record.
    type Cells<T: Part, const N: usize>: Cells<T>;
    /// True for I/Q records.
    const IQ: bool;
    /// The sample whose parts are 0.
    const ZERO: Self::Sample;
    /// The sample with these parts; a real sample ignores the quadrature part.
    fn from_parts(parts: [i16; 2]) -> Self::Sample;
    /// The parts of a sample: in phase and quadrature. The quadrature part of a real sample is 0.
    fn parts(sample: Self::Sample) -> [i16; 2];
    /// A whole record as the complex points that the FFT transforms: the pairs of an I/Q record, or
    /// the `N/2` pairs of neighbours in a real record of `N` samples.
    fn pairs(samples: &[Self::Sample]) -> &[[i16; 2]];
    /// [`Record::pairs`], for writing.
    fn pairs_mut(samples: &mut [Self::Sample]) -> &mut [[i16; 2]];
    /// The record that [`Record::pairs`] gives these points of.
    fn samples(pairs: &[[i16; 2]]) -> &[Self::Sample];
}

/// Real samples, from one converter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Real;

/// Complex samples, from two converters in quadrature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Iq;

impl Record for Real {
    type Sample = i16;
    type Cells<T: Part, const N: usize> = [T; N];
    const IQ: bool = false;
    const ZERO: i16 = 0;
    #[inline]
    fn from_parts([value, _]: [i16; 2]) -> i16 {
        value
    }
    #[inline]
    fn parts(sample: i16) -> [i16; 2] {
        [sample, 0]
    }
    fn pairs(samples: &[i16]) -> &[[i16; 2]] {
        samples.as_chunks().0
    }
    fn pairs_mut(samples: &mut [i16]) -> &mut [[i16; 2]] {
        samples.as_chunks_mut().0
    }
    fn samples(pairs: &[[i16; 2]]) -> &[i16] {
        pairs.as_flattened()
    }
}

impl Record for Iq {
    type Sample = [i16; 2];
    type Cells<T: Part, const N: usize> = [[T; 2]; N];
    const IQ: bool = true;
    const ZERO: [i16; 2] = [0; 2];
    #[inline]
    fn from_parts(parts: [i16; 2]) -> [i16; 2] {
        parts
    }
    #[inline]
    fn parts(sample: [i16; 2]) -> [i16; 2] {
        sample
    }
    fn pairs(samples: &[[i16; 2]]) -> &[[i16; 2]] {
        samples
    }
    fn pairs_mut(samples: &mut [[i16; 2]]) -> &mut [[i16; 2]] {
        samples
    }
    fn samples(pairs: &[[i16; 2]]) -> &[[i16; 2]] {
        pairs
    }
}

/// The samples of a record of either kind: code that takes them is compiled once for both.
#[derive(Clone, Copy, Debug)]
pub struct Data<'a> {
    /// [`Record::pairs`].
    pub pairs: &'a [[i16; 2]],
    /// Whether the samples are I/Q pairs.
    pub iq: bool,
}

impl<'a> Data<'a> {
    /// The samples of a record of kind `R`, an even number of them.
    #[inline]
    pub fn of<R: Record>(samples: &'a [R::Sample]) -> Self {
        Self { pairs: R::pairs(samples), iq: R::IQ }
    }

    /// All parts, in their order.
    #[inline]
    pub fn parts(&self) -> &'a [i16] {
        self.pairs.as_flattened()
    }
}

/// A number that a transform stores: one part of a complex point.
pub trait Part: Copy + PartialEq + core::fmt::Debug + Send + Sync + 'static {
    /// Zero.
    const ZERO: Self;
}

impl Part for i32 {
    const ZERO: Self = 0;
}

impl Part for f32 {
    const ZERO: Self = 0.0;
}

/// Work memory seen as complex points, `[re, im]`.
pub trait Cells<T>: Clone + core::fmt::Debug + Send + Sync + 'static {
    /// All zero.
    const ZERO: Self;
    /// The points.
    fn points(&self) -> &[[T; 2]];
    /// The points, for writing.
    fn points_mut(&mut self) -> &mut [[T; 2]];
}

impl<T: Part, const N: usize> Cells<T> for [T; N] {
    const ZERO: Self = [T::ZERO; N];
    fn points(&self) -> &[[T; 2]] {
        self.as_chunks().0
    }
    fn points_mut(&mut self) -> &mut [[T; 2]] {
        self.as_chunks_mut().0
    }
}

impl<T: Part, const N: usize> Cells<T> for [[T; 2]; N] {
    const ZERO: Self = [[T::ZERO; 2]; N];
    fn points(&self) -> &[[T; 2]] {
        self
    }
    fn points_mut(&mut self) -> &mut [[T; 2]] {
        self
    }
}

/// The segment of the waveform in which a block was taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Segment {
    /// No chirp: a continuous wave, as in a Doppler velocimeter.
    #[default]
    Continuous = 0,
    /// Rising frequency.
    Up = 1,
    /// Constant frequency between the ramps.
    Flat = 2,
    /// Falling frequency.
    Down = 3,
}

impl Segment {
    /// Whether a target's motion bends the phase of its beat: on a ramp, where the beat follows the range. The bend is symmetric about the
    /// record's middle and does not change the frequency there.
    pub const fn bends(self) -> bool {
        matches!(self, Segment::Up | Segment::Down)
    }

    /// The segment with this number on the wire; `None` for an unknown number.
    pub const fn from_u8(code: u8) -> Option<Self> {
        match code {
            0 => Some(Segment::Continuous),
            1 => Some(Segment::Up),
            2 => Some(Segment::Flat),
            3 => Some(Segment::Down),
            _ => None,
        }
    }
}

/// Where and when a block was taken. The stamp travels with the samples from the interrupt to the
/// telemetry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stamp {
    /// The number of the block, modulo 2^32. Every block that the converter fills counts, also a
    /// lost one, so a hole in the sequence is a loss.
    pub sequence: u32,
    /// The sample clock at the block's first sample: samples since the start.
    pub clock: u64,
    /// The segment of the waveform.
    pub segment: Segment,
    /// Whether samples are missing between the previous delivered block and this one.
    pub gap: bool,
}

/// Statistics of the samples before any transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Statistics {
    /// Samples with a part that touches a rail.
    pub clipped: u32,
    /// Sums of the parts, I and Q, in codes: the DC offset times the number of samples.
    pub sum: [i64; 2],
    /// The smallest and the largest part, in codes.
    pub extremes: [i16; 2],
}

impl Statistics {
    /// Statistics of `samples`. Cost: one pass, about six operations a sample.
    pub fn from_samples(data: Data, codes: Codes) -> Self {
        let (low, high) = codes.rails();
        let touches = |part: i16| part <= low || part >= high;
        let mut seen = Statistics { clipped: 0, sum: [0; 2], extremes: [i16::MAX, i16::MIN] };
        for &[a, b] in data.pairs {
            let [i, q] = [a, b].map(i64::from);
            if data.iq {
                seen.clipped += u32::from(touches(a) || touches(b));
                seen.sum = [seen.sum[0] + i, seen.sum[1] + q];
            } else {
                seen.clipped += u32::from(touches(a)) + u32::from(touches(b));
                seen.sum[0] += i + q;
            }
            seen.extremes = [seen.extremes[0].min(a).min(b), seen.extremes[1].max(a).max(b)];
        }
        seen
    }

    /// [`Statistics::clipped`] alone. Cost: one pass. A core with the DSP extension takes two samples at a time, some two instructions
    /// each, and a second pass if real samples touch a rail.
    #[inline(never)] // once in an image, not for each use of a block
    pub fn clipped(data: Data, codes: Codes) -> u32 {
        #[cfg(any(dsp, short_products))]
        let (low, high) = codes.rails();
        // The loop loads several words at once. They must be aligned, or the core faults.
        #[cfg(dsp)]
        if data.pairs.as_ptr().cast::<u32>().is_aligned() {
            let parts = crate::spectrum::fft::kernel_dsp::touching(data.pairs, low, high);
            if !data.iq || parts == 0 {
                return parts;
            }
        }
        #[cfg(short_products)]
        if all_inside(data.pairs, low, high) {
            return 0;
        }
        let inside = Between::new(codes.rails());
        let outside = |part: i16| u32::from(!inside.holds(part));
        let mut count = 0u32;
        if data.iq {
            for &[i, q] in data.pairs {
                count = count.wrapping_add(outside(i) | outside(q));
            }
        } else {
            for &part in data.parts() {
                count = count.wrapping_add(outside(part));
            }
        }
        count
    }

    /// Samples with a part beyond the rails: codes that the converter cannot make. The caller counts them only if some sample touches a
    /// rail. Cost: that of [`Statistics::clipped`].
    pub fn beyond(data: Data, codes: Codes) -> u32 {
        #[cfg(all(target_arch = "arm", not(dsp)))]
        if none_beyond(data.pairs, codes.rails()) {
            return 0;
        }
        // No sample lies beyond codes of 16 bits.
        codes.wider().map_or(0, |wider| Self::clipped(data, wider))
    }

    /// The mean as a complex number, in codes; `samples` is the number of samples.
    pub fn mean(&self, samples: usize) -> Complex<f32> {
        let n = samples.max(1) as f32;
        Complex::new(self.sum[0] as f32 / n, self.sum[1] as f32 / n)
    }
}

/// Whether all parts lie between the rails, for rails at 0 and at a power of two less one: neither a
/// part less 1 nor a part plus 1 then has a bit beyond them. Two parts at a time. False for other
/// rails, or if the parts are not aligned to words.
#[cfg(any(short_products, test))]
fn all_inside(pairs: &[[i16; 2]], low: i16, high: i16) -> bool {
    let around = |word: u32| word.wrapping_sub(ONES) | word.wrapping_add(ONES);
    low == 0 && high > 0 && none_has(pairs, !high, around)
}

/// Whether no part lies beyond the rails. If the lower rail is 0, no part then has a bit beyond the upper one; if it is minus the upper
/// rail less 1, the bits from there on are all equal. False where [`all_inside`] is false.
#[cfg(any(all(target_arch = "arm", not(dsp)), test))]
fn none_beyond(pairs: &[[i16; 2]], (low, high): (i16, i16)) -> bool {
    // Codes from 0 on need no comparison.
    let (known, bits, signed) =
        if low == 0 { (high > 0, !high, 0) } else { (low == !high, low << 1, u32::MAX) };
    known && none_has(pairs, bits, |word| word ^ (word << 1 & signed))
}

/// A 1 in each half of a word.
#[cfg(any(all(target_arch = "arm", not(dsp)), test))]
const ONES: u32 = 0x1_0001;

/// Whether no word of two parts has one of the upper `bits` in a half, once `of` was applied to it.
#[cfg(any(all(target_arch = "arm", not(dsp)), test))]
#[inline(always)]
fn none_has(pairs: &[[i16; 2]], bits: i16, of: impl Fn(u32) -> u32) -> bool {
    // SAFETY: any bits are a valid word.
    let (before, words, after) = unsafe { pairs.align_to::<u32>() };
    let whole = before.is_empty() && after.is_empty();
    if !whole || !bits.unsigned_abs().is_power_of_two() {
        return false;
    }
    // Eight at a time, since a turn of the loop costs as much as a word: a record is a multiple of eight, and other slices take the loop
    // below.
    let (eights, rest) = words.as_chunks::<8>();
    let seen =
        eights.iter().fold(0, |seen, eight| eight.iter().fold(seen, |seen, &word| seen | of(word)));
    if !rest.is_empty() {
        return false;
    }
    seen & (u32::from(bits as u16) * ONES) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pair of parts near a rail, at every place of a record.
    #[test]
    fn a_part_at_a_rail_is_seen_among_two() {
        let codes = Codes::unsigned::<12>();
        let (low, high) = codes.rails();
        let parts = [
            i16::MIN,
            -2049,
            -2048,
            -1,
            0,
            1,
            2,
            2047,
            2048,
            4093,
            4094,
            4095,
            4096,
            8191,
            i16::MAX,
        ];
        for place in 0..20 {
            for [a, b] in parts.iter().flat_map(|&a| parts.map(|b| [a, b])) {
                // Aligned as a meter's record is.
                let mut words = [0x0800_0800u32; 24];
                words[place] = u32::from(a as u16) | u32::from(b as u16) << 16;
                let parts: [[i16; 2]; 24] = words.map(|word| [word as i16, (word >> 16) as i16]);
                // SAFETY: a word is two parts, which lie in memory in the order in which they are read here.
                let pairs = unsafe { &*words.as_ptr().cast::<[[i16; 2]; 24]>() };
                assert_eq!(*pairs, parts);
                let data = Data::of::<Real>(pairs.as_flattened());
                let clipped = Statistics::from_samples(data, codes).clipped;
                assert_eq!(all_inside(pairs, low, high), clipped == 0, "{place}: {a} {b}");
                assert_eq!(Statistics::clipped(data, codes), clipped);
                for codes in [codes, Codes::signed::<12>(), Codes::signed::<15>()] {
                    let (low, high) = codes.rails();
                    let beyond = pairs.as_flattened().iter().any(|x| !(low..=high).contains(x));
                    assert_eq!(none_beyond(&pairs[..], (low, high)), !beyond, "{place}: {a} {b}");
                }
            }
        }
        assert!(!all_inside(&[[5, 5]], -2048, 2047));
        assert!(!none_beyond(&[[5, 5]], (-3000, 2047)));
    }
}

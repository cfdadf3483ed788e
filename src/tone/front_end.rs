//! Two faults of a digital front end, detected in the whole record: codes that wrap, and samples of a word that change places.
//!
//! Both make lines as strong as the tone, far from it. The strongest line may then be a false one, with nothing wrong beside it.
//!
//! **Codes that wrap.** A tone beyond the rails comes back at the other end, and its harmonics fold into many lines. Honest tones that fit
//! between the rails have little power where there are several: for amplitudes `1` and `a`, on a range of `-R..R` which the tones fill, the
//! mean square of a sample is `R^2 (1 + a^2) / 2 (1 + a)^2`, a quarter of `R^2` for two equal tones. A record wraps if at most 1 % of its
//! samples touch a rail and its mean square is larger. Tones of which one is locked to three times another have more power below the same
//! crest; that is rare, and needs a record that fills the range. A square wave has more power, too, but its two levels do not reach both
//! rails, as codes that wrap do.
//!
//! **Samples that change places.** Both samples of a word are exchanged if a transfer has the wrong order of half-words. A tone of `w`
//! radians a sample becomes, with its neighbours exchanged,
//!
//! ```text
//! cos(w (k + (-1)^k))  =  cos(w k) cos(w)  -  (-1)^k sin(w k) sin(w)
//! ```
//!
//! so that a line of `sin(w)` arises at half the rate less the frequency. From an eighth of the rate to three eighths this line is the
//! stronger one. Its phase and size follow from the other line: with `Y` the bins, `Y[N/2 - k] = +-j cot(w) Y[k]*`. Nearer to a quarter of
//! the rate the noise hides the weaker line, and nothing shows the exchange.

use super::observer::Tap;
use super::statistic::{Statistic, Test};
use crate::acquire::codes::Codes;
use crate::acquire::sample::Data;
use crate::math::products;
use crate::math::scalar::Scalar as _;
use crate::spectrum::engine::RESIDUE;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::Peak;
use crate::spectrum::view::View;
#[cfg(doc)]
use crate::tone::evidence::EDGE_BINS;
use crate::tone::fit::{Fit, Model};
use core::mem::MaybeUninit;
use num_complex::Complex;

/// The other bins of a record that wraps have at least this share of the tone's power: one sample of 256 that wraps is off by the whole
/// range `2R`, and has 8/256 of the power `R^2 / 2` of a tone that fills the range.
const OTHERS: f32 = 1.0 / 32.0;

/// The least power of a third line over the tone's, and its square root. Each of the third, fifth and seventh harmonic of codes that
/// wrap by 0.1 dB has a fifth of the tone's power or more.
const THIRD: f32 = 0.02;
const ROOT_THIRD: f32 = 0.141_421_36;

/// The crests of tones lie beyond the rails by this factor of power where 1 % of the samples touch the rails. Next to a crest a record of
/// amplitudes `a` is `S - sum(a x^2) / 2`, with `S` their sum and `x` the phases, which are anywhere in a cube of edge `2 pi`. With `r` the
/// rail, the two ends of the range have 1 % of the cube where, for two tones, `S (1 - r)` is `0.01 pi sqrt(a1 a2)`, at most 1.6 % of `S`.
/// For three tones it is `(0.03 pi^2 sqrt(a1 a2 a3))^(2/3) / 2`, 5.4 % of `S` where the weakest has the share [`THIRD`] and the others are
/// alike.
///
/// The residual of two tones may be noise, a tenth of the power at 10 dB; for three tones the lines are counted. Codes that wrap have at
/// least 1.17 times the power of three tones, up to 6 dB beyond the rails.
const TWO: f32 = 1.032 * 1.1;
const THREE: f32 = 1.11;

/// The bins that are counted have at least this share of the power: of the 127 bins of a record of 256 samples, the 34 bins within 8 of the
/// peak and of its mirror are not counted. These have up to one and a half times their part.
const COUNTED: f32 = 0.6;

/// More lines than this are a fault, and counting stops there.
pub const TOLD: u32 = 2;

/// Bins that are read at a time.
const WINDOW: usize = 16;

/// At most this many windows are read, those passed over not counted. Three lines are in three windows, the bins that share points with a
/// line's bins are in three others, and weaker lines are in some more. A signal that fills this many windows is shaped noise.
const READ: u32 = 16;

/// Bins between two lines.
pub const APART: u32 = 2;

/// A clean record exceeds this limit at the place of an exchanged line once in 25,000 times, by Student's distribution with the 50 degrees
/// of freedom of the noise. Half of the tones are where the test counts: so it takes a fifth of the permitted false-alarm rate of one in
/// 10,000.
const SEEN: f32 = 4.5;

/// [`SEEN`] deviations of one real number, over the noise power of a bin: three bins exceed this power together, and one of them a fifth of
/// it.
const LEAST: f32 = 0.5 * SEEN * SEEN / 5.0;

/// Six numbers of noise, each of mean square 1, have a larger sum in one record of a thousand: the quantile of chi-square.
const REST: f32 = 22.5;

/// The share of the power by which the model of the exchanged line may be wrong: the tone, the other line and the mirror images of both
/// leak into the bins by `1 / pi` over their distance each, which is a quarter of the shortest record of 64 samples. The square of the
/// leakage is `(4 / 16 pi)^2`.
const MODEL: f32 = 0.006_33;

/// The share of a line that the integer transform leaves.
const TRANSFORM: f32 = RESIDUE as f32;

/// The faults that the search of a record leaves possible.
#[derive(Clone, Copy, Debug)]
pub struct QuickTest {
    /// There are other lines, or noise of equal power.
    pub others: bool,
    /// There is a line where exchanged samples would put one.
    pub exchanged: bool,
}

impl QuickTest {
    /// Looks at the search's sums, and at one bin of a real record whose tone is between an eighth of the rate and three eighths: all in
    /// integers, so that most records end here. Every fault that [`FullTest`] would find passes, unless noise hides it. `unit` is the unit
    /// of the bins, `noise` the power per sample.
    #[inline]
    pub fn from_search(view: &View, peak: &Peak, codes: Codes, [unit, noise]: [f32; 2]) -> Self {
        let [below, power, above] = peak.power;
        let line = below.wrapping_add(power).wrapping_add(above);
        // `OTHERS`: three bins have 0.85 to 1 of the line.
        let others = peak.floor > line >> 5 && line.wrapping_add(peak.floor) > full(view, codes);
        let Layout { n, iq, .. } = *view.layout;
        let exchanged = !iq
            && exchange(n, peak.bin).is_some_and(|[place, apart]| {
                // The line of an exchange has `cot^2(w)` of the power, and the cotangent is larger than the angle `pi apart / N`: a fifth of
                // its square is enough. Below 2^63 / N^2 times 2 (N / 3)^2.
                let square = u64::from(apart.unsigned_abs().pow(2));
                let least = (power >> (2 * view.layout.bits())).wrapping_mul(2 * square);
                let mut places = MaybeUninit::uninit();
                let bin = view.window::<1>(place, &mut places);
                let there = bin.first().map_or(0, |&bin| products::power(bin));
                there > least && there as f32 * (unit * unit) > LEAST * (noise * n as f32)
            });
        Self { others, exchanged }
    }

    /// Whether neither fault is possible.
    #[inline]
    pub const fn is_clear(self) -> bool {
        !self.others && !self.exchanged
    }
}

/// The least power of a line's three bins and of the others, in stored units, for a record that [`FullTest::wraps`] rejects.
///
/// The least power that three tones may have is 0.24 of the square of half the range, see [`most`], and at least half of it is in the bins.
/// A line of amplitude `A` has the power `(A N / 2)^2` in its bins, `(A N)^2` in an I/Q record, and its three bins have 0.85 of that power.
#[inline]
fn full(view: &View, codes: Codes) -> u64 {
    let (low, high) = codes.rails();
    let range = u64::from(i32::from(high).abs_diff(i32::from(low)).wrapping_add(1));
    // Stored units are 2^exponent codes.
    let shares = if view.layout.iq { 6 } else { 8 };
    let shift = 2 * (view.layout.bits() as i32 - view.exponent) - shares;
    let square = 3 * (range * range);
    if shift < 0 {
        square.wrapping_shr(shift.unsigned_abs())
    } else {
        square.wrapping_shl(shift.unsigned_abs())
    }
}

/// The bin to which an exchange moves the line of a tone at bin `peak`, and the tone's distance from there, if the exchanged line is the
/// stronger one: from an eighth of the rate to three eighths. A sixteenth beyond these limits the other line is weaker by 1.7 dB, and noise
/// does not reverse the order. About a quarter of the rate both are one line.
#[inline]
fn exchange(n: usize, peak: i32) -> Option<[i32; 2]> {
    let n = n as i32;
    let place = (n / 2).wrapping_sub(peak);
    let apart = place.wrapping_sub(peak);
    (apart != 0 && apart.wrapping_abs() < n / 4 + n / 32).then_some([place, apart])
}

/// Whether the lines of a record are those of a faulty front end, by all tests of this module. `unit` is the unit of the bins, `noise` the
/// power per sample beside the tone.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one place calls it")]
pub(super) fn has_fault(
    view: &View,
    data: Data,
    peak: &Peak,
    codes: Codes,
    unit: f32,
    fit: &Fit<f32>,
    noise: f32,
    observer: impl Tap,
) -> bool {
    let others = || peak.floor as f32 * (unit * unit);
    observer.hear(|| other_lines(others(), fit));
    let possible = QuickTest::from_search(view, peak, codes, [unit, noise]);
    if possible.is_clear() {
        return false;
    }
    let test = FullTest {
        n: view.layout.n,
        iq: view.layout.iq,
        peak: peak.bin,
        fit,
        noise,
        others: others(),
        pairs: data.pairs,
        codes,
        bin: &|k| in_codes(view.bin(k), unit),
        // A cast saturates.
        lines: &|least| lines(view, peak.bin, (least / (unit * unit)) as u64),
    };
    test.is_faulty(possible, observer)
}

/// Whether a record has more power than as many tones between the rails can have. Codes that wrap make lines all over the band, so no signal
/// beside a tone explains them.
#[inline(never)]
pub(super) fn is_full(
    view: &View,
    data: Data,
    peak: &Peak,
    codes: Codes,
    unit: f32,
    fit: &Fit<f32>,
) -> bool {
    let Layout { n, iq, .. } = *view.layout;
    let line = fit.line.norm_sqr();
    let share = peak.floor as f32 * (unit * unit) / line - leakage(iq, fit.offset);
    let range = range(codes);
    let seen = 0.5 * fit.amplitude_squared(iq, n) * (1.0 + share);
    if share < OTHERS || seen < COUNTED * bound(share, TOLD) * (range * range) {
        return false;
    }
    let others = lines(view, peak.bin, (THIRD * line / (unit * unit)) as u64);
    // Where crests of four tones just reach the rails, two and three may be beyond.
    let most = [TWO, TWO, THREE].get(others as usize).unwrap_or(&1.0);
    mean_square(data.pairs) > most * bound(share, others.saturating_sub(1)) * (range * range)
        && reaches(data.pairs, codes)
}

/// The variance in squared bins of a tone of `bins` in `data` by the edges of two levels; 0 of any other wave. A wave of two levels changes
/// somewhere between two samples. So at both ends of the record the time of a change is uncertain by the interval between samples.
#[inline(never)]
pub(super) fn edges(data: Data, bins: f32, n: usize) -> f32 {
    /// The mean square of a wave of two levels over the square of half their distance is 1, that of a tone a half.
    const LEVELS: f32 = 0.75;
    /// The variance of two times that are anywhere within an interval.
    const INTERVALS: f32 = 2.0 / 12.0;
    let [mut least, mut most] = [i16::MAX, i16::MIN];
    for &part in data.pairs.iter().flatten() {
        (least, most) = (least.min(part), most.max(part));
    }
    let half = 0.5 * (i32::from(most) - i32::from(least)) as f32;
    if mean_square(data.pairs) < LEVELS * half * half {
        return 0.0;
    }
    let share = bins / n as f32;
    INTERVALS * share * share
}

/// A bin in codes.
fn in_codes(Complex { re, im }: Complex<i32>, unit: f32) -> Complex<f32> {
    Complex::new(re as f32 * unit, im as f32 * unit)
}

/// The test of the band's other bins, which have the power `others` in squared codes.
pub fn other_lines(others: f32, fit: &Fit<f32>) -> Test {
    Test { statistic: Statistic::OtherLines, value: others / fit.line.norm_sqr(), limit: OTHERS }
}

/// The record and its tone, for the tests that decide.
#[derive(Clone, Copy)]
pub struct FullTest<'a> {
    /// Samples of the record.
    pub n: usize,
    /// Whether the samples are I/Q.
    pub iq: bool,
    /// The tone's bin.
    pub peak: i32,
    /// The fit to the tone.
    pub fit: &'a Fit<f32>,
    /// The noise power per sample beside the tone.
    pub noise: f32,
    /// The power of the band's other bins, without the peak's skirt, in squared codes.
    pub others: f32,
    /// The samples, see [`Data`].
    pub pairs: &'a [[i16; 2]],
    /// The converter's codes.
    pub codes: Codes,
    /// The record's bins in codes. Both readers are behind a pointer, so that all kinds and lengths of records share one body.
    pub bin: &'a dyn Fn(i32) -> Complex<f32>,
    /// The number of lines with more than a given power, see [`lines`].
    pub lines: &'a dyn Fn(f32) -> u32,
}

impl FullTest<'_> {
    /// Whether the record looks as a faulty front end makes it, for the faults that are possible. Cost: three bins for exchanged samples; a
    /// pass over the samples where the range is filled and other bins have a thirty-second of the tone's power, and a pass over the bins
    /// where there is more power than three tones can have.
    #[inline(never)]
    pub fn is_faulty(&self, possible: QuickTest, observer: impl Tap) -> bool {
        let line = self.fit.line.norm_sqr();
        let share = self.others / line - leakage(self.iq, self.fit.offset);
        let wraps = possible.others
            && share > OTHERS
            && self.is_full(share)
            && self.wraps(share, THIRD * line, observer);
        wraps || !self.iq && possible.exchanged && self.is_exchanged(observer)
    }

    /// Whether the bins alone have nearly the power that three tones may have: only then are the samples read.
    fn is_full(&self, share: f32) -> bool {
        let range = range(self.codes);
        let squared = if self.iq {
            self.fit.amplitude_squared(true, self.n)
        } else {
            self.fit.amplitude_squared(false, self.n)
        };
        let power = 0.5 * squared * (1.0 + share);
        power > COUNTED * most(share)[1] * (range * range)
    }

    /// Whether the samples have more power than tones between the rails can have; the weakest tone that counts has the power `least`.
    #[inline(never)]
    fn wraps(&self, share: f32, least: f32, observer: impl Tap) -> bool {
        let range = range(self.codes);
        let power = mean_square(self.pairs) / (range * range);
        let [two, three] = most(share);
        // Few records have the power that is worth another pass.
        if power > two.min(three) && !reaches(self.pairs, self.codes) {
            return false;
        }
        if observer.exceeds(Statistic::TwoTones, power / two, 1.0) {
            return true;
        }
        observer.exceeds(Statistic::ThreeTones, power / three, 1.0)
            && observer.exceeds(Statistic::Lines, (self.lines)(least) as f32, TOLD as f32)
    }

    /// Whether another line has the size and phase of the tone before an exchange.
    #[inline(never)]
    fn is_exchanged(&self, observer: impl Tap) -> bool {
        let Some([place, _]) = exchange(self.n, self.peak) else {
            return false;
        };
        let n = self.n as i32;
        let Complex { re: cos, im: sin } =
            f32::unit((self.peak as f32 + self.fit.offset) / n as f32);
        let cotangent = cos / sin;
        let model = Model::new(self.fit, self.peak, n);
        // Power of the expected line, its product with the line that is there, and power of the latter.
        let (mut expected, mut both, mut there) = (0.0, 0.0, 0.0);
        for i in -1..=1 {
            let k = place.wrapping_sub(i);
            let other = (self.bin)(k) - model.bin(false, k);
            let own = model.bin(false, self.peak.wrapping_add(i));
            expected += own.norm_sqr();
            both += other.re * own.im + other.im * own.re;
            there += other.norm_sqr();
        }
        (expected, both) = (expected * (cotangent * cotangent), (both * cotangent).abs());
        // The noise of one real number.
        let noise = 0.5 * self.noise * n as f32 + TRANSFORM * self.fit.line.norm_sqr();
        let deviations = both / (expected * noise).root();
        let rest = (there - 2.0 * both + expected).max(0.0) / noise;
        let limit = REST + MODEL * expected / noise;
        observer.exceeds(Statistic::Exchanged, deviations, SEEN)
            && !observer.exceeds(Statistic::ExchangedRest, rest, limit)
    }
}

/// The largest share of its power that a tone at this offset has beyond its skirt: `sin^2(pi d) / pi^2` of the sum of `1/m^2` over bins `m`
/// away, from 8.5 on, on both sides. Next to an end of a real record there is one side, but the mirror image adds its amplitude, the most
/// where the tone is [`EDGE_BINS`] from the end: `1/8.5 + 1/11.5 + ln(11.5/8.5) / 1.5`.
fn leakage(iq: bool, offset: f32) -> f32 {
    let most = if iq { 2.0 / 8.5 } else { 0.406 };
    let sine = f32::unit(0.5 * offset).im * core::f32::consts::FRAC_1_PI;
    most * (sine * sine)
}

/// Half the range of the codes.
fn range(codes: Codes) -> f32 {
    let (low, high) = codes.rails();
    0.5 * (i32::from(high) - i32::from(low) + 1) as f32
}

/// The most power of two and of three tones between the rails, over the square of half the range, with what lies beyond the rails;
/// `share` is the power of all tones but the strongest over the power of the strongest.
fn most(share: f32) -> [f32; 2] {
    [TWO * bound(share, 0), THREE * bound(share, 1)]
}

/// The power of tones whose crests reach the rails, over the square of half the range: the strongest tone, `weak` tones of the
/// power [`THIRD`], and one with the rest of the `share`.
fn bound(share: f32, weak: u32) -> f32 {
    // No tone is stronger than the strongest.
    let share = share.min(1.0);
    let weak = weak as f32;
    let crest = 1.0 + weak * ROOT_THIRD + (share - weak * THIRD).max(0.0).root();
    0.5 * (1.0 + share) / (crest * crest)
}

/// Whether samples lie within a thirty-second of the range of both rails: those of a tone beyond one do, which come back at the other. The
/// two levels of a square wave fill a range that they do not reach.
fn reaches(pairs: &[[i16; 2]], codes: Codes) -> bool {
    let (low, high) = codes.rails();
    let near = (i32::from(high) - i32::from(low) + 1) >> 5;
    let [mut least, mut most] = [high, low];
    for &part in pairs.iter().flatten() {
        (least, most) = (least.min(part), most.max(part));
    }
    i32::from(least) - i32::from(low) <= near && i32::from(high) - i32::from(most) <= near
}

/// The mean square of the parts, each less its mean, of at most 4096 pairs.
fn mean_square(pairs: &[[i16; 2]]) -> f32 {
    let pairs = pairs.get(..4096).unwrap_or(pairs);
    let (mut squares, mut sums) = (0i64, [0i64; 2]);
    for &[a, b] in pairs {
        let (a, b) = (i32::from(a), i32::from(b));
        squares += i64::from(a * a) + i64::from(b * b);
        sums = [sums[0] + i64::from(a), sums[1] + i64::from(b)];
    }
    // Below 2^56.
    let count = pairs.len() as i64;
    let centred = count * squares - sums[0] * sums[0] - sums[1] * sums[1];
    centred as f32 / (2.0 * (count * count) as f32)
}

/// Counts the lines in a sequence of bins: a line is two neighbours that have more than `least` together, [`APART`] bins from the last
/// line.
#[derive(Clone, Copy, Debug)]
pub struct Lines<P> {
    least: P,
    before: P,
    quiet: u32,
    /// Lines counted so far.
    pub count: u32,
}

impl<P: Copy + Default + PartialOrd + core::ops::Add<Output = P>> Lines<P> {
    /// A count of no lines so far.
    pub fn new(least: P) -> Self {
        Self { least, before: P::default(), quiet: APART, count: 0 }
    }

    /// Whether the next line begins with a bin that has more than half of the line's power: no bin before has this power.
    #[inline]
    fn is_quiet(&self) -> bool {
        self.before + self.before <= self.least
    }

    /// Passes over this many bins, if none of them nor the next one has half of a line's power.
    #[inline]
    fn pass(&mut self, count: u32) {
        (self.quiet, self.before) = (self.quiet.saturating_add(count), P::default());
    }

    /// Takes the power of the next bin.
    #[inline]
    pub fn see(&mut self, power: P) {
        if self.before + power > self.least {
            self.count = self.count.wrapping_add(u32::from(self.quiet >= APART));
            self.quiet = 0;
        } else {
            self.quiet = self.quiet.saturating_add(1);
        }
        self.before = power;
    }
}

/// The bins in which lines are counted, as the first and their number, and the excess of the count: a circle is cut at the peak, which then
/// appears at both ends.
pub const fn counted(iq: bool, n: usize, peak: i32) -> ([i32; 2], u32) {
    let n = n as i32;
    if iq { ([peak, n], 1) } else { ([1, n / 2 - 1], 0) }
}

/// The lines whose power exceeds `least` in stored units, wherever they are between two bins; not many more than [`TOLD`] are counted.
#[inline(never)]
pub fn lines(view: &View, peak: i32, least: u64) -> u32 {
    let Layout { n, iq, .. } = *view.layout;
    let ([mut k, left], cut) = counted(iq, n, peak);
    let mut left = left as usize;
    let mut lines = Lines::new(least);
    let mut places = [MaybeUninit::uninit(); WINDOW];
    let mut read = 0;
    while left > 0 && read < READ && lines.count <= TOLD.wrapping_add(cut) {
        let count = left.min(WINDOW);
        // The bin after these may make a line together with the last.
        let seen = left.min(WINDOW + 1);
        if lines.is_quiet() && view.is_below(least >> 1, k, seen) {
            lines.pass(count as u32);
            k = k.wrapping_add(count as i32);
            left = left.saturating_sub(count);
            continue;
        }
        read += 1;
        let window = view.fill(k, places.get_mut(..count).unwrap_or_default());
        for &bin in window {
            // Where an offset is, there is no line.
            let offset = iq && (k == 0 || k == n as i32);
            lines.see(if offset { 0 } else { products::power(bin) });
            k = k.wrapping_add(1);
        }
        left = left.saturating_sub(count);
    }
    lines.count.saturating_sub(cut)
}

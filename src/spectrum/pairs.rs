//! A band of a real spectrum, in pairs of bins, for a faster search than [`Search`](super::peak::Search), which defines the result: skip
//! this module unless you change it.
//!
//! Bins k and M-k come from two points, and the powers of both pairs have the same sum (see [`super::scan`]). So where a band holds both
//! bins, it is searched by pairs, outwards from the middle, and only the pairs that may hold the strongest bin are split. Where the band
//! holds one of the bins, that bin is split by itself, whatever the other one holds.
//!
//! The floor sums points in this way, too: points that share a pair with the peak's skirt are left out, and the mirror of the skirt with
//! them. A band that would lose half of its bins so has the mirror's bins split by themselves, too.

use super::fft::integer::Point;
use super::scan::{Scan, Skirt, over};
use core::mem::MaybeUninit;
use core::ops::{Range, RangeInclusive};

/// Bins that are split in a row.
const ROW: usize = 32;

/// A band of the bins 1..M of a real record of M points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pairs {
    /// The number of points.
    length: usize,
    /// The first bin of the band.
    low: usize,
    /// The last bin of the band.
    high: usize,
    /// The outermost of the lower bins whose pairs the band holds; the middle if the band holds no pairs, and one more if it lacks the
    /// middle.
    outermost: usize,
}

impl Pairs {
    /// The pairs of a band of bins; `None` if the band has bins that come from one point alone.
    pub const fn new(length: usize, bins: &RangeInclusive<usize>) -> Option<Self> {
        let (low, high, middle) = (*bins.start(), *bins.end(), length / 2);
        if low < 1 || high < low || high >= length {
            return None;
        }
        if low > middle || high < middle {
            return Some(Self { length, low, high, outermost: middle + 1 });
        }
        let outermost = if low > length - high { low } else { length - high };
        Some(Self { length, low, high, outermost })
    }

    const fn middle(&self) -> usize {
        self.length / 2
    }

    /// The outermost lower bin of the pairs, or the middle; `None` if the band lacks the middle.
    pub const fn outermost(&self) -> Option<usize> {
        if self.outermost > self.middle() { None } else { Some(self.outermost) }
    }

    /// The bins below all pairs, and the bins above them.
    pub fn alone(&self) -> [Range<usize>; 2] {
        let Self { length, low, high, outermost } = *self;
        let end = high.wrapping_add(1);
        match self.outermost() {
            Some(_) => [low..outermost, length.wrapping_sub(outermost).wrapping_add(1)..end],
            None if high < self.middle() => [low..end, end..end],
            None => [low..low, low..end],
        }
    }

    /// The strongest bin of the band: `scan` has the strongest of the pairs; `alone` scans a range of bins.
    #[inline(always)]
    pub fn with_alone(&self, scan: Option<Scan>, alone: impl Fn(Range<usize>) -> Scan) -> Scan {
        let [below, above] = self.alone();
        let inner = scan.unwrap_or(Scan::from(above.start));
        let upwards = if below.is_empty() { inner } else { alone(below).then(inner) };
        if above.is_empty() { upwards } else { upwards.then(alone(above)) }
    }

    /// The power of the points that share a pair with the strongest bin's skirt, `reach` bins on each side, for the floor to leave out.
    /// `add` adds the powers of points to a sum, `alone` scans a range of bins.
    #[inline(always)]
    pub fn beside<P>(
        &self,
        scan: Scan,
        reach: usize,
        points: &[P],
        add: impl Fn(u64, &[P]) -> u64,
        alone: impl Fn(Range<usize>) -> Scan,
    ) -> Scan {
        let mut skirt = Skirt { power: 0, points: 0 };
        let bin = scan.bin as usize;
        let near = bin.saturating_sub(reach).max(self.low)
            ..bin.saturating_add(reach).min(self.high).wrapping_add(1);
        for single in self.alone() {
            let within = common(&near, &single);
            if !within.is_empty() {
                skirt.points = skirt.points.wrapping_add(within.len() as u32);
                skirt.power = skirt.power.wrapping_add(alone(within).total);
            }
        }
        let outer = self.outermost..self.length.wrapping_sub(self.outermost).wrapping_add(1);
        let paired = common(&near, &outer);
        if paired.is_empty() {
            return Scan { skirt: Some(skirt), ..scan };
        }
        let mirror = self.mirror(&paired);
        let meet = paired.start <= mirror.end && mirror.start <= paired.end;
        let spans = if meet {
            [paired.start.min(mirror.start)..paired.end.max(mirror.end), 0..0]
        } else {
            [paired.clone(), mirror.clone()]
        };
        for span in spans {
            let span = points.get(span).unwrap_or_default();
            skirt.points = skirt.points.wrapping_add(span.len() as u32);
            skirt.power = add(skirt.power, span);
        }
        let width = self.high.wrapping_sub(self.low).wrapping_add(1);
        if 2 * skirt.points as usize > width {
            // The part of the mirror that is not skirt.
            let rests =
                [mirror.start..mirror.end.min(near.start), mirror.start.max(near.end)..mirror.end];
            for rest in rests.into_iter().filter(|rest| !rest.is_empty()) {
                skirt.points = skirt.points.saturating_sub(rest.len() as u32);
                skirt.power = skirt.power.saturating_sub(alone(rest).total);
            }
        }
        Scan { skirt: Some(skirt), ..scan }
    }

    /// The mirror of a range of bins.
    fn mirror(&self, bins: &Range<usize>) -> Range<usize> {
        let end = self.length.wrapping_add(1);
        end.wrapping_sub(bins.end)..end.wrapping_sub(bins.start)
    }
}

fn common(one: &Range<usize>, other: &Range<usize>) -> Range<usize> {
    one.start.max(other.start)..one.end.min(other.end)
}

/// Scans a range of bins, each split by itself: `row` returns the bins from one on, one for each place.
#[inline(always)]
pub(super) fn alone(
    bins: Range<usize>,
    row: impl for<'a> Fn(usize, &'a mut [MaybeUninit<Point>]) -> &'a [Point],
) -> Scan {
    let mut places = [MaybeUninit::uninit(); ROW];
    let (mut scan, mut next) = (Scan::from(bins.start), bins.start);
    while next < bins.end {
        let count = bins.end.wrapping_sub(next).min(ROW);
        let row = row(next, places.get_mut(..count).unwrap_or_default());
        scan = scan.then(over(row, next, core::convert::identity));
        next = next.wrapping_add(count);
    }
    scan
}

#[cfg(test)]
mod tests {
    use super::super::fft::integer::{split, window};
    use super::super::fft::twiddle;
    use super::super::peak::{Band, Search};
    use super::super::scan;
    use super::super::view::REACH;
    use super::*;
    use crate::math::products::power;
    use std::println;
    use std::vec::Vec;

    fn search<const M: usize>(points: &[Point], bins: RangeInclusive<usize>) -> Scan {
        let table = twiddle::splits(2 * M);
        let pairs = Pairs::new(M, &bins).unwrap();
        let single = |bins| alone(bins, |first, places| window(points, table, first, places));
        let inner = pairs.outermost().map(|last| scan::real(points, table, last));
        let found = pairs.with_alone(inner, single);
        pairs.beside(found, REACH, points, scan::power_sum, single)
    }

    /// Compares a band with the streaming search over its bins, each split.
    fn compare<const M: usize>(points: &[Point], bins: RangeInclusive<usize>) {
        let (low, high) = (*bins.start(), *bins.end());
        let name = std::format!("{M} points, bins {low}..={high}");
        let found = search::<M>(points, bins.clone());
        let each: Vec<u64> =
            (0..M).map(|k| power(split(points, twiddle::splits(2 * M), k))).collect();
        let mut search = Search::new(Band::new(low as i32, high as i32));
        bins.clone().for_each(|k| search.push(each[k]));
        let Some(peak) = search.finish() else {
            assert_eq!(found.power, 0, "{name}");
            return;
        };
        assert_eq!((found.bin, found.power), (peak.bin, peak.power[1]), "{name}");
        // The floor has at least half of the band, or all bins that are not skirt.
        let skirt = found.skirt.unwrap();
        let floor_bins = (high - low + 1) as u32 - skirt.points;
        assert!(floor_bins == peak.floor_bins || 2 * floor_bins as usize > high - low, "{name}");
        // The floor is the power of these bins, except for the rounding of a split (see `scan`).
        let pairs = Pairs::new(M, &bins).unwrap();
        let inner = pairs.outermost().map_or(0..0, |last| last..M + 1 - last);
        let near = |k: usize| k.abs_diff(peak.bin as usize) <= REACH;
        let mirrored = |k: usize| inner.contains(&k) && near(M - k);
        let left_out = |k: usize| near(k) || (floor_bins < peak.floor_bins && mirrored(k));
        assert_eq!(bins.clone().filter(|&k| !left_out(k)).count() as u32, floor_bins, "{name}");
        let floor: u64 = bins.filter(|&k| !left_out(k)).map(|k| each[k]).sum();
        let total: u64 = each.iter().sum();
        let rounding = (total >> 12) + ((M as u64) << 20);
        let got = found.total.saturating_sub(skirt.power);
        assert!(got.abs_diff(floor) <= rounding, "{name}: {got}, not {floor}");
    }

    fn random(seed: &mut u32) -> u32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *seed >> 8
    }

    fn noise<const M: usize>(seed: &mut u32, size: u32) -> Vec<Point> {
        let mut part = || (random(seed) % (2 * size + 1)) as i32 - size as i32;
        (0..M).map(|_| [part(), part()]).collect()
    }

    fn every_band<const M: usize>(stride: usize) {
        let mut seed = M as u32;
        for size in [0, 1, 3, 1 << 10, 1 << 20] {
            let points = noise::<M>(&mut seed, size);
            for low in (1..M).step_by(stride) {
                for high in (low..M).step_by(stride) {
                    compare::<M>(&points, low..=high);
                }
            }
        }
    }

    #[test]
    fn a_band_is_searched_as_bin_by_bin() {
        println!("seeds: the lengths");
        every_band::<32>(1);
        every_band::<64>(1);
        every_band::<128>(3);
        every_band::<512>(29);
    }

    /// Each bin is in exactly one of the parts.
    #[test]
    fn every_bin_is_alone_or_in_a_pair() {
        for (low, high) in (1..64).flat_map(|low| (low..64).map(move |high| (low, high))) {
            let pairs = Pairs::new(64, &(low..=high)).unwrap();
            let inner = pairs.outermost().map_or(0..0, |last| last..65 - last);
            let [below, above] = pairs.alone();
            let all: Vec<usize> = below.chain(inner).chain(above).collect();
            assert_eq!(all, (low..=high).collect::<Vec<_>>(), "{low}..={high}");
        }
        assert_eq!(Pairs::new(64, &(0..=9)), None);
        assert_eq!(Pairs::new(64, &(9..=64)), None);
    }

    /// A line outside of a band does not show in the band's floor, though it shares points with the band's bins.
    #[test]
    fn a_strong_line_outside_is_no_part_of_the_floor() {
        let (mut points, mut seed) = (noise::<512>(&mut 5, 1 << 10), 7u32);
        let quiet = search::<512>(&points, 20..=511);
        // X[k] of 1.2e9 and no X[M-k], for k = 9: see `scan::tests`.
        let (k, size) = (9, 1.2e9);
        let turn = f64::from(random(&mut seed)) * 1e-6;
        let (re, im) = (size * turn.cos(), size * turn.sin());
        let (sin, cos) = (core::f64::consts::PI * k as f64 / 512.0).sin_cos();
        let half = |x: f64, y: f64| [(x / 2.0).round() as i32, (y / 2.0).round() as i32];
        points[k] = half(re * (1.0 - sin) - im * cos, re * cos + im * (1.0 - sin));
        points[512 - k] = half(re * (1.0 + sin) + im * cos, re * cos - im * (1.0 + sin));
        let loud = search::<512>(&points, 20..=511);
        // A factor of 16 bits leaves -96 dB of the line.
        let leak = (size * size * 2f64.powi(-31)) as u64;
        assert!(loud.total.abs_diff(quiet.total) < leak, "{} {}", loud.total, quiet.total);
    }
}

//! The search over a spectrum of a real record, from the points of its transform. The search splits only the bins that may be the
//! strongest, by factors of 16 bits at every length, and stores none of them. [`Search`](super::peak::Search) defines the result: skip this
//! module unless you change it.
//!
//! # The bound
//!
//! Bins `X = X[k]` and `Y = X[M-k]` are split from points `p = Z[k]` and `q = Z[M-k]`. The split is a rotation, so the powers of both bins
//! and of both points have the same sum, which needs no factor:
//!
//! ```text
//! |X|^2 + |Y|^2 = |p|^2 + |q|^2 = S
//! ```
//!
//! If S is less than the strongest power so far, neither bin can be stronger. A computed bin differs from X: its factor is wrong by at most
//! 1.2 2^-15, and turns a difference of at most sqrt(2 S), halved; its four roundings add at most 2.5 to each part, 3.6 in all. So its
//! power is below
//!
//! ```text
//! (sqrt S (1 + 1.2 2^-15.5) + 3.6)^2 <= S (1 + 0.95 2^-13) + 2^18
//! ```
//!
//! and a pair with `S < best - best 2^-13 - 2^21` (`worth`) cannot hold a computed bin of power
//! `best`. In the same way the stronger computed bin of a pair has at least `worth(S / 2)`.

use super::fft::integer::{Point, split_pair};
use super::fft::twiddle::Packed;
use crate::math::products::{plus_power, power};

/// The result of a scan over bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Scan {
    /// The strongest bin; of equals the lowest.
    pub bin: i32,
    /// The power of the strongest bin, in stored units.
    pub power: u64,
    /// The sum of the powers of all bins.
    pub total: u64,
    /// The part of `total` about the strongest bin, where the sum is over points instead of bins.
    pub skirt: Option<Skirt>,
}

/// The points that hold a peak's skirt. Each pair of points holds two bins, so the mirror of the
/// skirt is left out of the noise floor with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Skirt {
    /// The sum of the points' powers.
    pub power: u64,
    /// The number of points.
    pub points: u32,
}

impl Scan {
    /// A scan of bins from `bin` on that has seen no bin yet.
    pub(super) const fn from(bin: usize) -> Self {
        Self { bin: bin as i32, power: 0, total: 0, skirt: None }
    }

    /// Takes the next bin in ascending order.
    // The page's module calls it, and the other three functions with this attribute: 9 KB less to load.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(super) fn see(&mut self, bin: usize, power: u64) {
        self.total = self.total.wrapping_add(power);
        if power > self.power {
            (self.power, self.bin) = (power, bin as i32);
        }
    }

    /// This scan followed by a scan of the bins above it.
    pub(super) const fn then(self, above: Self) -> Self {
        let total = self.total.wrapping_add(above.total);
        let stronger = if above.power > self.power { above } else { self };
        Self { total, ..stronger }
    }

    /// A rise is rare, and `cold` tells the compiler so. Otherwise the compiler would carry the maximum through every turn of the loop.
    #[cold]
    #[inline(never)]
    fn rise(&mut self, power: u64, bin: usize) {
        (self.power, self.bin) = (power, bin as i32);
    }
}

/// Scans stored bins, the first of which is bin `first`; `point` converts one to integers. A bin
/// below 0 is two's complement, so the count may pass from the largest number to 0.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(super) fn over<P: Copy>(bins: &[P], first: usize, point: impl Fn(P) -> Point) -> Scan {
    let (mut scan, mut total) = (Scan::from(first), 0u64);
    for (k, &bin) in bins.iter().enumerate() {
        let power = power(point(bin));
        total = total.wrapping_add(power);
        if power > scan.power {
            scan.rise(power, first.wrapping_add(k));
        }
    }
    Scan { total, ..scan }
}

/// `sum` plus the powers of these points.
pub(super) fn power_sum(sum: u64, points: &[Point]) -> u64 {
    points.iter().fold(sum, |sum, &x| plus_power(sum, x))
}

/// The stride of the first look, in pairs of points.
pub(super) const SPARSE: usize = 16;

/// The least sum of a pair's powers at which one of its bins may have the power `best`; 1 if any may,
/// so that silence is not split.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(super) const fn worth(best: u64) -> u64 {
    let least = best.saturating_sub((best >> 13) + (1 << 21));
    if least == 0 { 1 } else { least }
}

/// A lower bound of the strongest bin's power, not far below it: some bin of the strongest pair has at least half of the pair's power. The
/// function looks at every [`SPARSE`]-th pair, down to bin `outermost`.
#[cfg_attr(short_products, allow(dead_code))]
#[inline]
pub(super) fn sure(points: &[Point], outermost: usize) -> u64 {
    // The first points of the chunks, from bin `outermost` to the middle and from its mirror down to the middle.
    let chunks = points.as_chunks::<SPARSE>().0;
    let (first, middle) = (outermost.max(1).div_ceil(SPARSE), chunks.len() / 2);
    let lower = chunks.get(first..middle).unwrap_or_default();
    let upper = chunks.get(middle + 1..(chunks.len() + 1).saturating_sub(first));
    let pairs = lower.iter().zip(upper.unwrap_or_default().iter().rev());
    let sums = pairs.map(|(&[p, ..], &[q, ..])| power(p).wrapping_add(power(q)));
    worth(sums.fold(0, u64::max) >> 1).wrapping_sub(1)
}

/// Scans bins `outermost`..=M-`outermost` of a real record from the M points of its transform; `table` is
/// [`super::fft::twiddle::splits`].
///
/// Bins k and M-k come from one pair of points, so the scan goes outwards from the middle. A lower
/// bin is then below all bins so far and wins a tie; an upper bin is above all bins so far and must
/// be stronger. The powers of one record sum to less than 2^63 (Parseval's theorem with the FFT's
/// growth bound).
#[cfg_attr(any(dsp, short_products), allow(dead_code))]
#[inline(never)] // its loop needs all registers
pub fn real(points: &[Point], table: &[Packed], outermost: usize) -> Scan {
    let (length, middle) = (points.len(), points.len() / 2);
    let mut scan = Scan::from(middle);
    let lowest = outermost.max(1).min(middle);
    let parts = points.split_at_checked(middle).zip(table.get(lowest..middle));
    let Some(((below, [centre, above @ ..]), table)) = parts else {
        return scan;
    };
    let mut total = power(*centre);
    scan.power = total.max(sure(points, outermost));
    let mut least = worth(scan.power);
    let below = below.get(lowest..).unwrap_or_default().iter().rev();
    let pairs = below.zip(above).zip(table.iter().rev());
    for (away, ((&p, &q), &w)) in (1..).zip(pairs) {
        let sum = power(p).wrapping_add(power(q));
        total = total.wrapping_add(sum);
        if sum >= least {
            scan.split(middle.wrapping_sub(away), length, split_pair(p, q, w));
            least = worth(scan.power);
        }
    }
    Scan { total, ..scan }
}

impl Scan {
    /// Takes the bins `lower` and `length - lower` of a pair of points. The upper bin's place is computed only here: the loops have no
    /// register for it.
    #[cold]
    #[inline(never)]
    pub(super) fn split(&mut self, lower: usize, length: usize, bins: [Point; 2]) {
        let [x, y] = bins.map(power);
        if x >= self.power {
            (self.power, self.bin) = (x, lower as i32);
        }
        if y > self.power {
            (self.power, self.bin) = (y, length.wrapping_sub(lower) as i32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fft::twiddle;
    use super::*;
    use crate::spectrum::peak::{Band, Search};
    use std::println;
    use std::vec::Vec;

    /// The strongest bin of all, each split.
    fn by_bins<const M: usize>(points: &[Point]) -> Option<(i32, u64)> {
        let mut search = Search::new(Band::real(2 * M));
        for k in 1..M {
            let bin = super::super::fft::integer::split(points, twiddle::splits(2 * M), k);
            search.push(power(bin));
        }
        search.finish().map(|peak| (peak.bin, peak.power[1]))
    }

    fn compare<const M: usize>(points: &[Point]) {
        let scan = real(points, twiddle::splits(2 * M), 1);
        let total = points[1..].iter().map(|&x| power(x)).sum::<u64>();
        assert_eq!(scan.total, total);
        match by_bins::<M>(points) {
            Some((bin, power)) => assert_eq!((scan.bin, scan.power), (bin, power)),
            None => assert_eq!(scan.power, 0),
        }
    }

    struct Random(u32);

    impl Random {
        fn draw(&mut self) -> u32 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            self.0 >> 8
        }

        fn within(&mut self, size: u32) -> i32 {
            (self.draw() % (2 * size + 1)) as i32 - size as i32
        }
    }

    #[test]
    fn a_scan_finds_what_the_streaming_search_finds() {
        println!("seed 1");
        let mut random = Random(1);
        // Small values make many equal powers.
        for size in [0, 1, 2, 3, 40, 1 << 10, 1 << 20, 1 << 23] {
            for _ in 0..200 {
                let points: Vec<Point> =
                    (0..128).map(|_| [random.within(size), random.within(size)]).collect();
                compare::<128>(&points);
            }
        }
    }

    /// All power of a pair is in one bin, where the bound is tightest, and several bins are nearly equal in power.
    #[test]
    fn no_rounding_hides_the_strongest_bin() {
        println!("seed 2");
        let mut random = Random(2);
        for size in [3.0, 100.0, 1e4, 1e6, 1e8, 1.2e9] {
            for _ in 0..2000 {
                let mut points = [[0i32; 2]; 512];
                for _ in 0..6 {
                    let k = 1 + random.draw() as usize % 511;
                    let near = 1.0 + f64::from(random.within(1000)) * 1e-8;
                    let turn = f64::from(random.draw()) * core::f64::consts::TAU / 16_777_216.0;
                    let (re, im) = (size * near * turn.cos(), size * near * turn.sin());
                    // X = (s - j d w)/2 with s = p + q*, d = p - q*, and no bin at M - k, gives
                    // p = X (1 + j w*)/2 and q = X* (1 - j w)*/2.
                    let angle = core::f64::consts::PI * k as f64 / 512.0;
                    let (sin, cos) = angle.sin_cos();
                    let half =
                        |x: f64, y: f64| [(x / 2.0).round() as i32, (y / 2.0).round() as i32];
                    points[k] = half(re * (1.0 - sin) - im * cos, re * cos + im * (1.0 - sin));
                    points[512 - k] =
                        half(re * (1.0 + sin) + im * cos, re * cos - im * (1.0 + sin));
                }
                compare::<512>(&points);
            }
        }
    }

    /// The count of bins once went past the largest number where a band ends below 0 Hz.
    #[test]
    fn bins_below_zero_are_counted() {
        let points = [[1, 0], [5, 0], [2, 0], [1, 1]];
        for first in [-9i32, -4, -3, -2, -1, 0] {
            let scan = over(&points, first as usize, core::convert::identity);
            assert_eq!((scan.bin, scan.power, scan.total), (first + 1, 25, 32), "{first}");
        }
    }
}

//! The search over the whole spectrum of a real record. It splits each bin from the transform,
//! compares and sums its power, and drops it. The spectrum is never stored, which saves its memory
//! and the stores.

use super::fft::integer::{Point, split_pair};
use super::fft::twiddle::Packed;
use crate::math::products::power;

/// The result of a scan over bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scan {
    /// The strongest bin; of equals the lowest.
    pub bin: i32,
    /// Its power, in stored units.
    pub power: u64,
    /// The sum of the powers of all bins.
    pub total: u64,
}

impl Scan {
    /// A scan of bins from `bin` on that has seen none yet.
    pub(super) const fn from(bin: usize) -> Self {
        Self { bin: bin as i32, power: 0, total: 0 }
    }

    /// Takes the next bin in ascending order.
    #[inline(always)]
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

    /// A rise is rare, and `cold` tells the compiler so. It would otherwise carry the maximum
    /// through every turn of the loop.
    #[cold]
    #[inline(never)]
    fn rise(&mut self, power: u64, bin: usize) {
        (self.power, self.bin) = (power, bin as i32);
    }
}

/// Scans stored bins, the first of which is bin `first`; `point` converts one to integers.
#[inline(always)]
pub(super) fn over<P: Copy>(bins: &[P], first: usize, point: impl Fn(P) -> Point) -> Scan {
    let (mut scan, mut total) = (Scan::from(first), 0u64);
    for (&bin, k) in bins.iter().zip(first..) {
        let power = power(point(bin));
        total = total.wrapping_add(power);
        if power > scan.power {
            scan.rise(power, k);
        }
    }
    Scan { total, ..scan }
}

/// Scans bins 1..M of a real record from the M points of its transform; `table` is
/// [`super::fft::twiddle::splits`].
///
/// Bins k and M-k come from one pair of points, so the scan goes outwards from the middle. A lower
/// bin is then below all bins so far and wins a tie; an upper bin is above all bins so far and must
/// be stronger. The powers of one record sum to less than 2^63 (Parseval's theorem with the FFT's
/// growth bound).
#[cfg_attr(dsp, allow(dead_code))]
#[inline(never)] // its loop needs all registers
pub fn real<const M: usize>(points: &[Point], table: &[Packed]) -> Scan {
    let middle = M / 2;
    let mut scan = Scan { bin: middle as i32, power: 0, total: 0 };
    // The compiler knows an array's length, so it checks no index below.
    let (Ok(points), Some(table)) = (<&[Point; M]>::try_from(points), table.get(..middle)) else {
        return scan;
    };
    scan.power = points.get(middle).map_or(0, |&x| power(x));
    let mut total = scan.power;
    for away in 1..middle {
        let pair = points.get(middle - away).zip(points.get(middle + away));
        let Some(((&p, &q), &w)) = pair.zip(table.get(middle - away)) else {
            return scan;
        };
        let [x, y] = split_pair(p, q, w).map(power);
        total = total.wrapping_add(x).wrapping_add(y);
        if x >= scan.power {
            scan.rise(x, middle - away);
        }
        if y > scan.power {
            scan.rise(y, middle + away);
        }
    }
    Scan { total, ..scan }
}

#[cfg(test)]
mod tests {
    use super::super::fft::twiddle;
    use super::*;
    use crate::spectrum::peak::{Band, Search};

    #[test]
    fn a_scan_finds_what_the_streaming_search_finds() {
        let mut state = 1u32;
        for size in [1u32, 2, 3, 1 << 10, 1 << 27] {
            for _ in 0..200 {
                // Small values make many equal powers.
                let points: std::vec::Vec<Point> = (0..64)
                    .map(|_| {
                        [0; 2].map(|_: i32| {
                            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                            ((state >> 1) % (2 * size + 1)) as i32 - size as i32
                        })
                    })
                    .collect();
                let table = twiddle::splits(128);
                let scanned = real::<64>(&points, table);
                let mut search = Search::new(Band::real(128));
                let mut total = 0;
                for k in 1..64 {
                    let power = power(super::super::fft::integer::split(&points, table, k));
                    search.push(power);
                    total += power;
                }
                let peak = search.finish();
                assert_eq!(scanned.total, total);
                assert_eq!(peak.map_or(0, |p| p.power[1]), scanned.power);
                assert!(peak.is_none_or(|p| p.bin == scanned.bin), "{peak:?} {scanned:?}");
            }
        }
    }
}

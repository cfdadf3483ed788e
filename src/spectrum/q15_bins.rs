//! Bins of the 16-bit engine (see [`super::fft::q15`]): single bins and the search over all of
//! them.

use super::engine::REACH;
use super::fft::integer::{Pair, Point, filled, split_pair};
use super::fft::q15::FRACTION;
use super::fft::twiddle::Packed;
use super::pairs::{Pairs, alone};
use super::scan::{SPARSE, Scan};

/// A power in units of bins is the power of stored points shifted up by this many bits.
pub(super) const SQUARES: u32 = 2 * FRACTION;

/// The power of a stored point in units of bins.
#[inline(always)]
pub(super) fn wide_power(point: Pair) -> u64 {
    u64::from(power(point) as u32) << SQUARES
}

/// `sum` plus the powers of these points in units of bins.
pub(super) fn power_sum(sum: u64, points: &[Pair]) -> u64 {
    points.iter().fold(sum, |sum, &point| sum.wrapping_add(wide_power(point)))
}

/// The search's result for a band, after the scan of its pairs. `add` is [`power_sum`].
#[inline(never)]
pub(super) fn found(
    pairs: Pairs,
    scan: Option<Scan>,
    points: &[Pair],
    table: &[Packed],
    add: fn(u64, &[Pair]) -> u64,
) -> Scan {
    let alone = |bins| {
        alone(bins, |first, places| filled(places, (first..).map(|k| split(points, table, k))))
    };
    pairs.beside(pairs.with_alone(scan, alone), REACH, points, add, alone)
}

/// A stored point in units of bins.
#[inline(always)]
pub fn wide([re, im]: Pair) -> Point {
    [i32::from(re) << FRACTION, i32::from(im) << FRACTION]
}

/// Bin `k`, 0..=M, of a real record. `points` are the M points of its transform as pairs, `table`
/// is [`twiddle::splits`](super::fft::twiddle::splits).
pub fn split(points: &[Pair], table: &[Packed], k: usize) -> Point {
    let (length, middle) = (points.len(), points.len() / 2);
    let at = |k: usize| points.get(k).copied().map_or([0; 2], wide);
    let mirror = length.wrapping_sub(k);
    let factor = |k: usize| table.get(k).copied().unwrap_or(0);
    if k == 0 || mirror == 0 {
        // Bins 0 and N/2 are real.
        let [re, im] = at(0);
        [if k == 0 { re + im } else { re - im }, 0]
    } else if k == middle {
        // Bin N/4 needs no product: X = conj Z.
        let [re, im] = at(k);
        [re, -im]
    } else if k < middle {
        split_pair(at(k), at(mirror), factor(k))[0]
    } else {
        split_pair(at(mirror), at(k), factor(mirror))[1]
    }
}

/// Scans bins `outermost`..=M-`outermost` of a real record from the M points of its transform.
///
/// Two points `p = Z[k]` and `q = Z[M-k]` give the powers of bins k and M-k without the bins:
///
/// ```text
/// A = |p|^2   B = |q|^2   D = Im p q      |X|^2 = (A + B)/2 +- ((A - B) sin - 2 D cos)/2
/// ```
///
/// The two powers sum to A + B. If the sum is below the strongest bin so far, neither bin can be stronger, and the pair is done. Most pairs
/// end there, the more because the first look at every eighth pair gives a bound. The scan goes outwards from the middle, like
/// [`super::scan::real`].
pub fn scan<const M: usize>(points: &[Pair], table: &[Packed], outermost: usize) -> Scan {
    let middle = M / 2;
    // The compiler knows an array's length, so it checks no index below.
    let (Ok(points), Some(table)) = (<&[Pair; M]>::try_from(points), table.get(..middle)) else {
        return Scan::from(middle);
    };
    let centre = points.get(middle).map_or(0, |&p| power(p));
    let (mut bin, mut total) = (middle, u64::from(centre as u32));
    let mut best = centre.max(sure::<M>(points, outermost));
    for away in 1..=middle.saturating_sub(outermost.max(1)) {
        let (lower, upper) = (middle - away, middle + away);
        let Some((&p, &q)) = points.get(lower).zip(points.get(upper)) else {
            break;
        };
        let (a, b) = (power(p), power(q));
        let sum = a.wrapping_add(b);
        total = total.wrapping_add(u64::from(sum as u32));
        if sum < best {
            continue;
        }
        let lean = lean(a.wrapping_sub(b), cross(p, q), table.get(lower).copied().unwrap_or(0));
        let [x, y] = [(sum >> 1).wrapping_add(lean), (sum >> 1).wrapping_sub(lean)];
        if x >= best {
            (best, bin) = (x, lower);
        }
        if y > best {
            (best, bin) = (y, upper);
        }
    }
    scanned(bin, best, total)
}

/// A lower bound of the strongest bin's power, not far below it: the stronger bin of a pair has at least half of the pair's power.
fn sure<const M: usize>(points: &[Pair; M], outermost: usize) -> i32 {
    let mut most = 0;
    let first = outermost.max(1).div_ceil(SPARSE) * SPARSE;
    for lower in (first..M / 2).step_by(SPARSE) {
        if let Some((&p, &q)) = points.get(lower).zip(points.get(M - lower)) {
            most = power(p).wrapping_add(power(q)).max(most);
        }
    }
    (most >> 1) - 1
}

/// A scan of the powers of stored points, converted to units of bins.
pub(super) const fn scanned(bin: usize, best: i32, total: u64) -> Scan {
    Scan { power: (best as u64) << SQUARES, total: total << SQUARES, ..Scan::from(bin) }
}

/// `((B - A) sin + 2 D cos) / 2`, with the factor packed as `-cos | -sin << 16`.
#[inline(always)]
fn lean(difference: i32, cross: i32, w: Packed) -> i32 {
    let upper = |x: i32, w: i32| ((i64::from(x) * i64::from(w)) >> 16) as i32;
    let sine = upper(difference, w as i32 >> 16);
    sine.wrapping_sub(upper(cross, i32::from(w as i16)) << 1)
}

/// `|p|^2`
#[inline(always)]
pub(super) fn power([re, im]: Pair) -> i32 {
    let square = |x: i16| i32::from(x) * i32::from(x);
    square(re).wrapping_add(square(im))
}

/// `Im p q`
#[inline(always)]
fn cross(p: Pair, q: Pair) -> i32 {
    let product = |x: i16, y: i16| i32::from(x) * i32::from(y);
    product(p[0], q[1]).wrapping_add(product(p[1], q[0]))
}

/// Scans stored bins, the first of which is bin `first`.
pub fn over(bins: &[Pair], first: usize) -> Scan {
    let mut scan = Scan::from(first);
    for (&bin, k) in bins.iter().zip(first..) {
        scan.see(k, u64::from(power(bin) as u32));
    }
    Scan { power: scan.power << SQUARES, total: scan.total << SQUARES, ..scan }
}

//! The bins of a spectrum that is moved by a part of a bin.

use crate::math::scalar::Scalar as _;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::Layout;
use crate::spectrum::view::View;
use core::mem::MaybeUninit;

/// Bins on each side that the interpolation reads. The bins beyond hold at most 3 % of a line's power, half a bin off.
const SIDE: i32 = 6;
const TAPS: usize = 2 * SIDE as usize + 1;

/// `X(k + whole + part)` from the bins around.
///
/// With the record's middle as the origin of time, `W(k + d) = sum over j of D(d - j) W_(k + j)`, and `W_k = X_k exp(j pi k (N - 1) / N)`.
/// The factor of k is left to the caller, the factor of j is in the taps.
pub(super) struct Moved {
    whole: i32,
    /// The taps in Q15.
    taps: [[i32; 2]; TAPS],
}

impl Moved {
    /// The move by `bins`; `None` if it is too small to matter.
    pub fn new(bins: f32, n: usize) -> Option<Self> {
        /// The share of a line's width by which the sum becomes wider.
        const LEAST: f32 = 1.0 / 64.0;
        if bins.abs() < LEAST {
            return None;
        }
        let length = n.max(1) as f32;
        let nearest = libm::rintf(bins);
        let part = bins - nearest;
        let sine = f32::unit(0.5 * part).im;
        let mut taps = [[0; 2]; TAPS];
        for (tap, j) in taps.iter_mut().zip(-SIDE..) {
            // D(part - j) (-1)^j: the sine of pi (part - j) has the same sign.
            let below = length * f32::unit(0.5 * (part - j as f32) / length).im;
            let size = if j == 0 && part.abs() < 1e-3 { 1.0 } else { sine / below };
            let turn = f32::unit(-0.5 * j as f32 / length);
            *tap = [size * turn.re, size * turn.im].map(|x| libm::rintf(32768.0 * x) as i32);
        }
        // A record has at most N bins: the remainder keeps the index small. The cast saturates, and the remainder of integers, unlike the
        // one of floats, cannot panic.
        let whole = (nearest as i64).checked_rem(n.max(1) as i64).unwrap_or(0) as i32;
        Some(Self { whole, taps })
    }

    /// Bin k of the moved spectrum, in stored units.
    pub fn bin(&self, view: &View, k: i32) -> Point {
        let Layout { n, iq, .. } = *view.layout;
        let centre = k.wrapping_add(self.whole);
        // A real record has no bins beyond the ends.
        if !iq && !(0..=n as i32 / 2).contains(&centre) {
            return [0; 2];
        }
        let mut places = [const { MaybeUninit::uninit() }; TAPS];
        let bins = view.fill(centre.wrapping_sub(SIDE), &mut places);
        let mut sums = [0i64; 2];
        for ((&[re, im], &[cos, sin]), at) in bins.iter().zip(&self.taps).zip(centre - SIDE..) {
            // A constant offset does not move, and is left out.
            if view.layout.wrapped(at) == 0 {
                continue;
            }
            let [re, im, cos, sin] = [re, im, cos, sin].map(i64::from);
            sums[0] = sums[0].wrapping_add(re * cos - im * sin);
            sums[1] = sums[1].wrapping_add(re * sin + im * cos);
        }
        sums.map(|sum| (sum >> 15).clamp(-(1 << 30), 1 << 30) as i32)
    }
}

//! The sums over blocks: powers, and products of neighbouring bins.

use super::moved::Moved;
use crate::acquire::sample::{Cells as _, Record};
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::peak::Band;
use core::mem::MaybeUninit;

/// The largest distance of two bins whose products are added.
pub(super) const LAGS: usize = 3;

/// Bins read at a time, and the bins above them for their products.
const CHUNK: usize = 16;
const WINDOW: usize = CHUNK + LAGS;

/// A bin's part is rounded to a number below two to this power.
const PART_BITS: u32 = 14;

/// From here on the sums are halved. A power is below 2^29, so no sum reaches 2^31.
const FULL: u32 = 1 << 30;

/// Sums over blocks, for each bin i: `sum Re(conj(X_i) X_j)` for j - i = 0, 1, 2, 3.
#[derive(Clone)]
pub(super) struct Sums<R: Record, const N: usize> {
    /// Powers, and products with the next bin.
    near: R::Cells<i32, N>,
    /// Products with the second and with the third bin.
    far: R::Cells<i32, N>,
    /// The blocks added.
    pub blocks: u32,
    /// A part of a bin times `2^exponent` is in codes.
    exponent: i32,
    /// The number of bits by which products are shifted down before they are added.
    down: u32,
}

/// Without the sums themselves.
impl<R: Record, const N: usize> core::fmt::Debug for Sums<R, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Sums").field("blocks", &self.blocks).finish_non_exhaustive()
    }
}

impl<R: Record, const N: usize> Sums<R, N> {
    pub const fn new() -> Self {
        use crate::acquire::sample::Cells;
        Self { near: R::Cells::ZERO, far: R::Cells::ZERO, blocks: 0, exponent: 0, down: 0 }
    }

    pub fn clear(&mut self) {
        for cells in [&mut self.near, &mut self.far] {
            cells.points_mut().fill([0; 2]);
        }
        (self.blocks, self.exponent, self.down) = (0, 0, 0);
    }

    /// The bins that hold sums: all but the bin of a constant offset, and Nyquist of a real record.
    pub const fn bins() -> Band {
        if R::IQ { Band::new(1, N as i32 - 1) } else { Band::real(N) }
    }

    /// The index of bin k, for any k of an I/Q record; `None` for bins without sums.
    fn index(k: i32) -> Option<usize> {
        let k = if R::IQ { k.rem_euclid(N as i32) } else { k };
        let Band { low, high, .. } = Self::bins();
        (low <= k && k <= high).then_some(k as usize)
    }

    /// The sum of the powers of bin k; 0 for bins without sums.
    pub fn power(&self, k: i32) -> u32 {
        let point = Self::index(k).and_then(|k| self.near.points().get(k));
        point.map_or(0, |near| near[0].unsigned_abs())
    }

    /// The sum of the products of bins k and `k + lag`, a lag of 0 to 3; 0 for bins without sums.
    pub fn product(&self, k: i32, lag: usize) -> i32 {
        let (Some(k), Some(_)) = (Self::index(k), Self::index(k.wrapping_add(lag as i32))) else {
            return 0;
        };
        let cells = if lag < 2 { &self.near } else { &self.far };
        let [even, odd] = cells.points().get(k).copied().unwrap_or_default();
        if lag & 1 == 0 { even } else { odd }
    }

    /// The amplitude in codes whose square is a mean over the blocks of one unit of the sums.
    pub fn unit(&self) -> f32 {
        let blocks = self.blocks.max(1) as f32;
        libm::sqrtf(libm::ldexpf(1.0, self.down as i32) / blocks) * libm::ldexpf(1.0, self.exponent)
    }

    /// Adds the products of a spectrum's bins, moved by `moved`.
    pub fn add<E: Engine>(&mut self, spectrum: &Spectrum<R, N, E>, moved: Option<&Moved>) {
        let bins = Self::bins();
        self.fit_in(spectrum.search(bins).power, spectrum.exponent());
        // Not below 0: an exponent grows with the bins of the loudest block.
        let shift = self.exponent.wrapping_sub(spectrum.exponent()).clamp(0, 31) as u32;
        let half = (1i32 << shift) >> 1;
        let rounded = |part: i32| part.saturating_add(half) >> shift;
        let mut window = [[0i32; 2]; WINDOW];
        let mut top = 0;
        let (down, up) = (self.down & 31, (1i32 << (self.down & 31)) >> 1);
        let mut k = bins.low;
        while k <= bins.high {
            match moved {
                None => {
                    let mut places = [const { MaybeUninit::uninit() }; WINDOW];
                    let read = spectrum.fill(k, &mut places);
                    for (place, &[re, im]) in window.iter_mut().zip(read) {
                        *place = [rounded(re), rounded(im)];
                    }
                }
                Some(moved) => {
                    for (place, at) in window.iter_mut().zip(k..) {
                        let [re, im] = moved.bin(spectrum, at);
                        *place = [rounded(re), rounded(im)];
                    }
                }
            }
            // Bins without sums must not saturate the sums: an offset, and the mirror of a real spectrum.
            for (place, at) in window.iter_mut().zip(k..) {
                if Self::index(at).is_none() {
                    *place = [0; 2];
                }
            }
            let first = k as usize;
            let near = self.near.points_mut().get_mut(first..).unwrap_or_default();
            let far = self.far.points_mut().get_mut(first..).unwrap_or_default();
            for ((near, far), bins) in near.iter_mut().zip(far).zip(window.array_windows()) {
                let &[a, b, c, d] = bins;
                let term = |b: Point| {
                    let product = a[0].wrapping_mul(b[0]).wrapping_add(a[1].wrapping_mul(b[1]));
                    product.wrapping_add(up) >> down
                };
                near[0] = near[0].wrapping_add(term(a));
                near[1] = near[1].wrapping_add(term(b));
                far[0] = far[0].wrapping_add(term(c));
                far[1] = far[1].wrapping_add(term(d));
                top |= near[0].unsigned_abs();
            }
            k = k.wrapping_add(CHUNK as i32);
        }
        self.blocks = self.blocks.wrapping_add(1);
        if top >= FULL {
            self.halve(1);
            self.down = self.down.wrapping_add(1).min(31);
        }
    }

    /// Sets the exponent by the first block, and raises it for a block whose strongest bin has too much power.
    fn fit_in(&mut self, power: u64, exponent: i32) {
        // Neither part exceeds the root of the power.
        let bits = 64u32.wrapping_sub(power.leading_zeros()).div_ceil(2);
        let needed = exponent.wrapping_add(bits.saturating_sub(PART_BITS) as i32);
        if self.blocks == 0 {
            // The next blocks may be louder: one spare bit.
            self.exponent = needed.wrapping_add(1);
        } else if needed > self.exponent {
            let more = needed.wrapping_sub(self.exponent).clamp(1, 31) as u32;
            // The sums are sums of squares.
            self.halve(more.saturating_mul(2));
            self.exponent = needed;
        }
    }

    /// Divides all sums by two to the power `times`, rounded.
    #[cold]
    fn halve(&mut self, times: u32) {
        let times = times.min(31);
        let half = (1i32 << times) >> 1;
        for cells in [&mut self.near, &mut self.far] {
            for part in cells.points_mut().as_flattened_mut() {
                *part = part.saturating_add(half) >> times;
            }
        }
    }
}

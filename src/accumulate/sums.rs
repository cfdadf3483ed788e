//! The sums over blocks: powers, and products of neighbouring bins.

use super::moved::Moved;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::Band;
use crate::spectrum::view::View;
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

/// The scale of sums.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// The blocks added.
    pub blocks: u32,
    /// A part of a bin times `2^exponent` is in codes.
    exponent: i32,
    /// The number of bits by which products are shifted down before they are added.
    down: u32,
}

impl Scale {
    pub const NOTHING: Self = Self { blocks: 0, exponent: 0, down: 0 };
}

/// Sums over blocks, for each bin i: `sum Re(conj(X_i) X_j)` for j - i = 0, 1, 2, 3.
#[derive(Clone, Copy)]
pub(super) struct Sums<'a> {
    pub layout: &'static Layout,
    /// Powers, and products with the next bin.
    pub near: &'a [Point],
    /// Products with the second and with the third bin.
    pub far: &'a [Point],
    pub scale: Scale,
}

/// The bins that hold sums: all but the bin of a constant offset, and Nyquist of a real record.
pub(super) const fn bins(layout: &Layout) -> Band {
    if layout.iq { Band::new(1, layout.n as i32 - 1) } else { Band::real(layout.n) }
}

/// The index of bin k, for any k of an I/Q record; `None` for bins without sums.
fn index(layout: &Layout, k: i32) -> Option<usize> {
    let k = if layout.iq { layout.wrapped(k) as i32 } else { k };
    let Band { low, high, .. } = bins(layout);
    (low <= k && k <= high).then_some(k as usize)
}

impl Sums<'_> {
    /// The sum of the powers of bin k; 0 for bins without sums.
    pub fn power(&self, k: i32) -> u32 {
        let point = index(self.layout, k).and_then(|k| self.near.get(k));
        point.map_or(0, |near| near[0].unsigned_abs())
    }

    /// The sum of the products of bins k and `k + lag`, a lag of 0 to 3; 0 for bins without sums.
    pub fn product(&self, k: i32, lag: usize) -> i32 {
        let index = |k| index(self.layout, k);
        let (Some(k), Some(_)) = (index(k), index(k.wrapping_add(lag as i32))) else {
            return 0;
        };
        let cells = if lag < 2 { self.near } else { self.far };
        let [even, odd] = cells.get(k).copied().unwrap_or_default();
        if lag & 1 == 0 { even } else { odd }
    }

    /// The amplitude in codes whose square is a mean over the blocks of one unit of the sums.
    pub fn unit(&self) -> f32 {
        let Scale { blocks, exponent, down } = self.scale;
        let blocks = blocks.max(1) as f32;
        libm::sqrtf(libm::ldexpf(1.0, down as i32) / blocks) * libm::ldexpf(1.0, exponent)
    }
}

/// Sums to add to.
pub(super) struct Adder<'a> {
    pub near: &'a mut [Point],
    pub far: &'a mut [Point],
    pub scale: &'a mut Scale,
}

impl Adder<'_> {
    /// Adds the products of a spectrum's bins, moved by `moved`.
    pub fn add(&mut self, view: &View, moved: Option<&Moved>) {
        let layout = view.layout;
        let bins = bins(layout);
        self.fit_in(view.search(bins).power, view.exponent);
        // Not below 0: an exponent grows with the bins of the loudest block.
        let shift = self.scale.exponent.wrapping_sub(view.exponent).clamp(0, 31) as u32;
        let half = (1i32 << shift) >> 1;
        let rounded = |part: i32| part.saturating_add(half) >> shift;
        let mut window = [[0i32; 2]; WINDOW];
        let mut top = 0;
        let (down, up) = (self.scale.down & 31, (1i32 << (self.scale.down & 31)) >> 1);
        let mut k = bins.low;
        while k <= bins.high {
            match moved {
                None => {
                    let mut places = [const { MaybeUninit::uninit() }; WINDOW];
                    let read = view.fill(k, &mut places);
                    for (place, &[re, im]) in window.iter_mut().zip(read) {
                        *place = [rounded(re), rounded(im)];
                    }
                }
                Some(moved) => {
                    for (place, at) in window.iter_mut().zip(k..) {
                        let [re, im] = moved.bin(view, at);
                        *place = [rounded(re), rounded(im)];
                    }
                }
            }
            // Bins without sums must not saturate the sums: an offset, and the mirror of a real spectrum.
            for (place, at) in window.iter_mut().zip(k..) {
                if index(layout, at).is_none() {
                    *place = [0; 2];
                }
            }
            let first = k as usize;
            let near = self.near.get_mut(first..).unwrap_or_default();
            let far = self.far.get_mut(first..).unwrap_or_default();
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
        self.scale.blocks = self.scale.blocks.wrapping_add(1);
        if top >= FULL {
            self.halve(1);
            self.scale.down = self.scale.down.wrapping_add(1).min(31);
        }
    }

    /// Sets the exponent by the first block, and raises it for a block whose strongest bin has too much power.
    fn fit_in(&mut self, power: u64, exponent: i32) {
        // Neither part exceeds the root of the power.
        let bits = 64u32.wrapping_sub(power.leading_zeros()).div_ceil(2);
        let needed = exponent.wrapping_add(bits.saturating_sub(PART_BITS) as i32);
        if self.scale.blocks == 0 {
            // The next blocks may be louder: one spare bit.
            self.scale.exponent = needed.wrapping_add(1);
        } else if needed > self.scale.exponent {
            let more = needed.wrapping_sub(self.scale.exponent).clamp(1, 31) as u32;
            // The sums are sums of squares.
            self.halve(more.saturating_mul(2));
            self.scale.exponent = needed;
        }
    }

    /// Divides all sums by two to the power `times`, rounded.
    #[cold]
    fn halve(&mut self, times: u32) {
        let times = times.min(31);
        let half = (1i32 << times) >> 1;
        for cells in [&mut *self.near, &mut *self.far] {
            for part in cells.as_flattened_mut() {
                *part = part.saturating_add(half) >> times;
            }
        }
    }
}

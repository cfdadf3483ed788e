//! The sums of [`super::super::rest`] in integers of 16 bits, whose products are one instruction
//! on every core.

use super::trigonometry::{cosine, sinc};
use super::{inverse, nearest, shifted, square, zeros};
use crate::math::scalar::Scalar as _;
use crate::tone::fit::rest::{NEAR, Rest};
use core::f64::consts::{FRAC_1_PI, FRAC_PI_4, PI};
use num_complex::Complex;

/// The residual in the bins near the peak, as [`super`] stores bins.
pub(super) struct Near {
    centre: [i32; 2],
    /// By distance from the peak, the lower side first.
    sides: [[[i32; 2]; 2]; NEAR],
}

/// Bits of a scaled residual, and of a function's values.
const WIDTH: u32 = 13;
const SHAPE: u32 = 14;

impl Near {
    pub fn new(centre: [i32; 2]) -> Self {
        Self { centre, sides: [[[0; 2]; 2]; NEAR] }
    }

    /// Takes the residual i bins from the peak.
    #[inline(always)]
    pub fn take(&mut self, i: i32, left: [i32; 2]) {
        let place = i.unsigned_abs().wrapping_sub(1) as usize;
        if let Some([below, above]) = self.sides.get_mut(place) {
            *(if i < 0 { below } else { above }) = left;
        }
    }

    /// The residual's projections for a tone at the offset d, in Q30, and bins whose unit is `2^unit` codes. `turned` is the length's
    /// logarithm if the bins have the turn by half a sample, see [`super::super::rest`].
    pub fn rest(&self, d: i32, unit: i32, turned: Option<u32>) -> Rest<f32> {
        let all = self.sides.iter().flatten().flatten().chain(&self.centre);
        let bits = all.fold(1, |bits, &part| bits | part.unsigned_abs() as i32) as u32;
        let down = (32 - zeros(bits)).saturating_sub(WIDTH) & 31;
        let narrow = |x: [i32; 2]| x.map(|part| part >> down);
        let functions = Functions::new(d);
        let centre = narrow(self.centre);
        let mut sums = functions.at_centre().map(|shape| centre.map(|part| part * shape));
        let mut all = centre;
        let mut powers = [square(self.centre[0]).wrapping_add(square(self.centre[1])), 0, 0];
        let [two, four, eight] = &mut powers;
        let mut each = |i: i32, left: [i32; 2], power: &mut i64| {
            *power = power.wrapping_add(square(left[0])).wrapping_add(square(left[1]));
            let left = narrow(left);
            for (sum, part) in all.iter_mut().zip(left) {
                *sum = sum.wrapping_add(part);
            }
            for (sum, shape) in sums.iter_mut().zip(functions.beside(i)) {
                for (sum, part) in sum.iter_mut().zip(left) {
                    *sum = sum.wrapping_add(part.wrapping_mul(shape));
                }
            }
        };
        for (&[below, above], i) in self.sides.iter().zip(1..) {
            let power = match i {
                ..=2 => &mut *two,
                3..=4 => &mut *four,
                _ => &mut *eight,
            };
            each(-i, below, power);
            each(i, above, power);
        }
        if let Some(bits) = turned {
            sums = functions.turned_back(sums, all, bits);
        }
        let codes = f32::two_to(2 * unit);
        let [two, four, eight] = powers;
        let four = two.wrapping_add(four);
        let within = [two, four, four.wrapping_add(eight)].map(|power| power as f32 * codes);
        let scale = f32::two_to(unit + down as i32 - SHAPE as i32);
        let along = sums.map(|[re, im]| Complex::new(re as f32 * scale, im as f32 * scale));
        let cosine = functions.cosine * functions.cosine;
        let cosine_squared = cosine as f32 * (1.0 / (1u32 << (2 * SHAPE)) as f32);
        Rest { within, along, cosine_squared }
    }
}

/// The functions of one offset.
struct Functions {
    /// The offset in Q26.
    d: i32,
    /// Sine and cosine of pi d, with [`SHAPE`] fractional bits.
    sine: i32,
    cosine: i32,
}

/// The reciprocal of each, in Q28.
const fn inverted([a, b, c]: [f64; 3]) -> [i32; 3] {
    [nearest(1.0 / a, 28), nearest(1.0 / b, 28), nearest(1.0 / c, 28)]
}

impl Functions {
    fn new(d: i32) -> Self {
        // A quarter of the angle, doubled twice.
        let x = shifted::<30>(const { nearest(FRAC_PI_4, 30) }, d);
        let z = shifted::<30>(x, x);
        let (cos, sin) = (cosine(z), shifted::<30>(x, sinc(z)));
        let half = [(shifted::<30>(cos, cos) << 1).wrapping_sub(1 << 30), shifted::<29>(sin, cos)];
        let [cos, sin] = half.map(|part| part >> 1);
        let sine = shifted::<29>(sin, cos) << 1;
        let cosine = (shifted::<29>(cos, cos) << 1).wrapping_sub(1 << 29);
        let down = 29 - SHAPE;
        Self { d: d >> 4, sine: sine >> down, cosine: cosine >> down }
    }

    /// The functions of the peak's own bin: j_p = x^p g_p, and g_1 = 5 g_2 - x^2 g_3.
    fn at_centre(&self) -> [i32; 3] {
        let x = shifted::<28>(const { nearest(PI, 28) }, self.d);
        let z = shifted::<26>(x, x);
        let series = |[a, b, c]: [i32; 3]| {
            let one = 1 << 26;
            let last = one - shifted::<28>(c, z);
            let middle = one - shifted::<28>(b, shifted::<26>(z, last));
            one - shifted::<28>(a, shifted::<26>(z, middle))
        };
        let g3 = shifted::<28>(
            const { nearest(1.0 / 105.0, 28) },
            series(const { inverted([18.0, 44.0, 78.0]) }),
        );
        let g2 = shifted::<28>(
            const { nearest(1.0 / 15.0, 28) },
            series(const { inverted([14.0, 36.0, 66.0]) }),
        );
        let g1 = 5 * g2 - shifted::<26>(z, g3);
        let cube = shifted::<26>(z, x);
        [shifted::<26>(x, g1), shifted::<26>(z, g2), shifted::<26>(g3, cube)]
            .map(|value| value >> (26 - SHAPE))
    }

    /// The sums of a record of `2^bits` samples without the turn by half a sample; `all` is the sum of the residual.
    fn turned_back(&self, sums: [[i32; 2]; 3], all: [i32; 2], bits: u32) -> [[i32; 2]; 3] {
        let share = |x: i32| x >> (bits & 31);
        let [first, second, third] = sums;
        // j (re + j im) = -im + j re
        let quarter =
            |sum: [i32; 2], [re, im]: [i32; 2]| [sum[0].wrapping_sub(im), sum[1].wrapping_add(re)];
        // Two bits less: the seventeen residuals of an impulse are alike.
        let times = |x: i32| all.map(|part| share((part >> 2).wrapping_mul(x)) << 2);
        let (cosine, sine) = (times(self.cosine), times(self.sine));
        let pair =
            |of: fn(i32, i32) -> i32, a: [i32; 2], b: [i32; 2]| [of(a[0], b[0]), of(a[1], b[1])];
        [
            quarter(first, cosine.map(i32::wrapping_neg)),
            quarter(second, pair(|a, b| (3 * a).wrapping_sub(b), first.map(share), sine)),
            quarter(third, pair(|a, b| (5 * a).wrapping_add(b), second.map(share), cosine)),
        ]
    }

    /// The functions of the bin i bins from the peak, without alternating signs.
    #[inline(always)]
    fn beside(&self, i: i32) -> [i32; 3] {
        let y = reciprocal(self.d, i);
        let zeroth = (self.sine * y) >> SHAPE;
        let first = ((zeroth - self.cosine) * y) >> SHAPE;
        let second = ((3 * first * y) >> SHAPE) - zeroth;
        let third = ((5 * second * y) >> SHAPE) - first;
        [first, second, third]
    }
}

/// `1 / (pi (d - i))` with [`SHAPE`] fractional bits for d in Q26, |d - i| below 16 and not below 1/2.
#[inline(always)]
fn reciprocal(d: i32, i: i32) -> i32 {
    let x = d.wrapping_sub(i << 26);
    let size = x.unsigned_abs().max(1 << 25).min(i32::MAX as u32);
    let room = zeros(size).wrapping_sub(1) & 31;
    // size = m / 2^room, and rough(m) = 2^46 / m: 1/(d - i) is rough(m) over 2^(20 - room).
    let inverse = inverse::rough(size << room) as i32;
    let y = (inverse.wrapping_mul(const { nearest(FRAC_1_PI, 14) })) >> 20u32.saturating_sub(room);
    if x < 0 { -y } else { y }
}

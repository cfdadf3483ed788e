//! Least squares over the bins of a [`Zoom`]: measures a tone whose approximate frequency is known, at a tenth of the cost of a whole
//! measurement.
//!
//! With c the centre bin, the tone at bin c + d, i counted from the centre, and the angles
//!
//! ```text
//! x_i = pi (d - i) / 32      z_i = pi (2 c + d + i) / 32      h(u) = sin(pi u / 32) / sin(pi u / N)
//! ```
//!
//! the boxcar of the decimation and the image of a real tone make exactly
//!
//! ```text
//! Y[c + i] exp(-j pi (i/32 + c/N)) = (a + j b) / sin x_i + r (a - j b) / sin z_i        r = h(2 c + d) / h(d)
//! ```
//!
//! Hence the real parts are a multiple of `1/sin x + r/sin z` and the imaginary parts a multiple of `1/sin x - r/sin z`: two linear
//! parameters and d, as in the fit to a whole spectrum. I/Q records have no image, r = 0. Without the image in the model the error at 60 dB
//! would be 60 times the bound. The fit reads thirteen bins around the strongest, without the bin that holds the constant offset.
//!
//! This fit is this project's own.

use super::fit::descent::Descent;
use super::fit::normal::{Products, Step};
use super::noise::ROUNDING;
use crate::math::series::{circle, cosine, line_shape, sinc};
use crate::spectrum::fft::twiddle::sin_cos;
use crate::spectrum::layout::Layout;
use crate::spectrum::zoom::{POINTS, Zoom};
use num_complex::Complex;

/// Bins on each side of the strongest.
const REACH: i32 = 6;

/// The tone is searched this many bins to each side of the expected place.
const WITHIN: i32 = 2;

/// The largest distance of the expected place from the centre, in bins.
const FARTHEST: i32 = 5;

/// The largest distance from the centre that the fit reads.
const WIDEST: i32 = FARTHEST + WITHIN + REACH;

/// Near a multiple of 32, within this many bins, the multiple itself is the centre.
const BLIND: i32 = 4;

/// The index of the strongest bin among the bins that the fit reads.
const MIDDLE: usize = REACH as usize;

/// The number of bins that the fit reads.
const CELLS: usize = 2 * REACH as usize + 1;

/// The most evaluations; the move, in bins, after which another always follows; and the largest share of the variance that the square of
/// the last move may have. After a Gauss-Newton step the error is at most the square of the error before.
const STEPS: u32 = 4;
/// The farthest that the tone lies from the strongest bin, bins.
const NEAR: f32 = 0.75;
const SETTLED: f32 = 0.1;
const SHARE: f32 = 0.04;

/// The image is computed anew for a tone farther than this from the offset of the last computation, in bins.
const FAR: f32 = 0.02;

/// At a bin the shapes are 0/0. Nearer than this, in bins, they are not evaluated.
const NEAREST: f32 = 1e-6;

/// The angle of one bin.
const BIN: f32 = core::f32::consts::PI / POINTS as f32;

/// The constants of a centre.
#[derive(Clone, Debug)]
pub struct Place {
    centre: i32,
    n: i32,
    iq: bool,
    /// The distance from the centre to the bin of the constant offset, unless that bin is the centre.
    blind: i32,
    /// Cosine and sine of 2 pi c / N.
    turn: Complex<f32>,
    /// `exp(-j pi (i/32 + c/N))`, i from [`Place::FIRST`].
    back: [Complex<f32>; 2 * WIDEST as usize + 1],
}

/// The best centre for a tone at `bins`; `None` too near DC or Nyquist of a real record.
///
/// A constant offset falls into the bins that are multiples of 32, wherever the centre is. But if the centre is such a multiple, the boxcar
/// does not pass the offset at all.
pub fn centre(bins: f32, &Layout { n, iq, .. }: &Layout) -> Option<i32> {
    /// Bins from DC and Nyquist within which the zoom does not reach.
    const EDGE: f32 = 8.0;
    if !(iq || (EDGE..=n as f32 / 2.0 - EDGE).contains(&bins)) {
        return None;
    }
    let nearest = libm::rintf(bins) as i32;
    let points = POINTS as i32;
    let multiple = (nearest + points / 2).div_euclid(points) * points;
    Some(if (nearest - multiple).abs() <= BLIND { multiple } else { nearest })
}

/// A tone found in a zoom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The distance of the tone from the centre, in bins.
    pub offset: f32,
    /// The information: the noise power of a bin divided by twice this is the variance in bins^2.
    pub information: f32,
    /// The square of the amplitude in codes.
    pub amplitude_squared: f32,
    /// The power of the bins that the tone explains, in squared codes.
    pub explained: f32,
    /// The residual power; [`Found::dof`] has its degrees of freedom.
    pub residual: f32,
    /// Degrees of freedom of [`Found::residual`].
    pub dof: u32,
}

/// The bins of the fit, rotated.
struct Cells {
    /// The strongest bin, as a distance from the centre.
    peak: i32,
    z: [Complex<f32>; CELLS],
    /// 1, or 0 for the bin that is left out.
    weights: &'static [f32; CELLS],
}

/// The sums of one of the two parts: of the shape, of its slope, and of the bins less a first height of the tone.
#[derive(Clone, Copy, Default)]
struct Sums {
    height: f32,
    pp: f32,
    ps: f32,
    ss: f32,
    py: f32,
    sy: f32,
    yy: f32,
}

impl Sums {
    fn new(height: f32) -> Self {
        Self { height, ..Self::default() }
    }

    fn add(&mut self, p: f32, s: f32, z: f32) {
        let y = z - self.height * p;
        self.pp += p * p;
        self.ps += p * s;
        self.ss += s * s;
        self.py += p * y;
        self.sy += s * y;
        self.yy += y * y;
    }
}

impl Place {
    /// The first bin beside the centre.
    const FIRST: i32 = -WIDEST;

    /// A centre bin of records of this kind and length. Cost: 28 sines.
    pub fn new(centre: i32, &Layout { n, iq, .. }: &Layout) -> Self {
        let n = n.max(POINTS) as i32;
        let mut back = [Complex::new(0.0, 0.0); 2 * WIDEST as usize + 1];
        for (turn, i) in back.iter_mut().zip(Self::FIRST..) {
            // -pi (i/32 + c/N) as a fraction of 2 N.
            let k = (i * (n / POINTS as i32)).wrapping_add(centre);
            *turn = circle(k.wrapping_neg(), 2 * n);
        }
        let half = POINTS as i32 / 2;
        let blind = half - centre.wrapping_add(half).rem_euclid(POINTS as i32);
        let blind = if blind == 0 { i32::MAX } else { blind };
        Self { centre, n, iq, blind, turn: circle(centre, n), back }
    }

    /// Whether a tone at `bins` can be followed from this centre.
    pub fn reaches(&self, bins: f32) -> bool {
        (bins - self.centre as f32).abs() <= FARTHEST as f32 - 0.5
    }

    /// The strongest tone near `expected`, a distance from the centre of at most 5 bins; `None` if
    /// there is nothing at all. Cost: some 900 operations, half of them again if a second
    /// evaluation is needed.
    pub fn fit(&self, zoom: &Zoom, expected: f32) -> Option<Found> {
        let expected = (libm::rintf(expected) as i32).clamp(-FARTHEST, FARTHEST);
        let mut cells = Cells {
            peak: self.strongest(zoom, expected)?,
            z: [Complex::new(0.0, 0.0); CELLS],
            weights: &ALL,
        };
        self.read(zoom, &mut cells)?;
        let all = core::ptr::eq(cells.weights, &ALL);
        let dof = if all { 2 * CELLS - 3 } else { 2 * CELLS - 5 };
        let mut image = self.image(&cells, cells.start());
        let descent = Descent {
            start: cells.start(),
            steps: STEPS,
            longest: 2.0 * NEAR,
            limits: [-NEAR, NEAR],
            further: false,
        };
        let end = descent.to_the_end(|offset| {
            if (offset - image.from).abs() > FAR {
                image = self.image(&cells, offset);
            }
            let (step, explained, residual) = cells.step(self.iq, offset, &image);
            let forward = step.forward(1.0);
            let moved = forward * forward;
            let left = (residual - moved * step.information).max(0.0);
            // The error of the next place is at most the square of this move.
            let settled = moved * moved * (dof as f32 * step.information) <= SHARE * left;
            let enough = if settled { SETTLED } else { 0.0 };
            (forward, enough, (offset, step, explained, left))
        });
        let (offset, (before, step, explained, residual)) = (end.at, end.last);
        let line = step.line_at(offset - before);
        let d = offset + cells.peak as f32;
        let (x, y) = (BIN * offset, core::f32::consts::PI / self.n as f32 * d);
        let v = BIN * d;
        // (a + j b) times D / h: D = sin(pi d) / sin(pi d / 32) from the strongest bin, h of the boxcar.
        let shape = POINTS as f32 * line_shape(offset) / sinc(x * x);
        let boxcar = (self.n as f32 / POINTS as f32) * sinc(v * v) / sinc(y * y);
        let scale = (if self.iq { 1.0 } else { 2.0 }) / (shape * boxcar);
        let unit = zoom.unit();
        let power = unit * unit;
        Some(Found {
            offset: d,
            information: step.information * power,
            amplitude_squared: line.norm_sqr() * (scale * scale * power),
            explained: explained * power,
            residual: residual * power,
            dof: dof as u32,
        })
    }

    /// The strongest bin near the expected one.
    fn strongest(&self, zoom: &Zoom, expected: i32) -> Option<i32> {
        let (mut most, mut peak) = (0.0, None);
        for step in 0..2 * WITHIN + 1 {
            let i = expected - WITHIN + step;
            let [re, im] = zoom.bin(self.centre.wrapping_add(i)).map(|part| part as f32);
            let power = if i == self.blind { 0.0 } else { re * re + im * im };
            if power > most {
                (most, peak) = (power, Some(i));
            }
        }
        peak
    }

    /// Fills in the bins around the strongest one.
    fn read(&self, zoom: &Zoom, cells: &mut Cells) -> Option<()> {
        let first = cells.peak - REACH;
        let (_, back) = self.back.split_at_checked(usize::try_from(first - Self::FIRST).ok()?)?;
        let back = back.first_chunk::<CELLS>()?;
        let mut k = self.centre.wrapping_add(first);
        for (z, turn) in cells.z.iter_mut().zip(back) {
            let [re, im] = zoom.bin(k).map(|part| part as f32);
            *z = Complex::new(re, im) * turn;
            k = k.wrapping_add(1);
        }
        // A bin before the first one wraps to a large index, so both ends are outside.
        let blind = self.blind.wrapping_sub(first) as usize;
        if let (Some(z), Some(but_one)) = (cells.z.get_mut(blind), BUT_ONE.get(blind)) {
            *z = Complex::new(0.0, 0.0);
            cells.weights = but_one;
        }
        Some(())
    }

    /// The image of a tone at `offset` from the strongest bin: `r = h(2 c + d) / h(d)` and its slope over d. Without the slope the steps
    /// would still end at the right offset, but too slowly near bin 16.
    fn image(&self, cells: &Cells, offset: f32) -> Image {
        let twice = self.centre.wrapping_mul(2);
        let parts = parts_at(twice.wrapping_add(2 * cells.peak - REACH));
        if self.iq {
            return Image { parts, ratio: 0.0, drift: 0.0, from: offset };
        }
        let d = offset + cells.peak as f32;
        let x = BIN * d;
        let (sin_x, cos_x) = (x * sinc(x * x), cosine(x * x));
        let [[sin_c, cos_c]] = *parts_at::<1>(twice);
        // Sine and cosine of the image's angle, for the boxcar's numerator and its denominator.
        let (sin_w, cos_w) = (sin_x * cos_c + cos_x * sin_c, cos_x * cos_c - sin_x * sin_c);
        let fine = core::f32::consts::PI / self.n as f32;
        let y = fine * d;
        let (sin_y, cos_y) = (y * sinc(y * y), cosine(y * y));
        let wide = self.turn.im * cos_y + self.turn.re * sin_y;
        let wide_slope = fine * (self.turn.re * cos_y - self.turn.im * sin_y);
        let boxcar = self.n as f32 / POINTS as f32 * sinc(x * x) / sinc(y * y);
        // The boxcar's slope, relatively: the first term of its series.
        let droop = (fine * y - BIN * x) * (1.0 / 3.0);
        let inverse = 1.0 / (wide * boxcar);
        let slope = BIN * cos_w - sin_w * (wide_slope / wide + droop);
        Image { parts, ratio: sin_w * inverse, drift: slope * inverse, from: offset }
    }
}

/// The image's part of the model.
struct Image {
    /// Sine and cosine of `pi (2 c + p + i) / 32` for the bins i of the fit, p the strongest.
    parts: &'static [[f32; 2]; CELLS],
    ratio: f32,
    drift: f32,
    /// The offset for which ratio and drift were computed.
    from: f32,
}

impl Cells {
    /// The normal equations (`fit::normal`) at an offset from the strongest bin, the power that the tone explains, and the power that is left. Shapes are scaled by sin x of
    /// that bin, which has the shape 1.
    fn step(&self, iq: bool, offset: f32, image: &Image) -> (Step<f32>, f32, f32) {
        let away = if offset.abs() < NEAREST { NEAREST } else { offset };
        let x = BIN * away;
        let (sin, cos) = (x * sinc(x * x), cosine(x * x));
        let ratio = image.ratio + image.drift * (offset - image.from);
        let (height, tilt, drift) = (ratio * sin, ratio * BIN, image.drift * sin);
        // Relative to the strongest bin, so that the sums are of small numbers.
        let (middle, [sin_i, cos_i]) = (self.z[MIDDLE], image.parts[MIDDLE]);
        let q = if iq { 0.0 } else { height / (sin * cos_i + cos * sin_i) };
        let (mut re, mut im) = (Sums::new(middle.re / (1.0 + q)), Sums::new(middle.im / (1.0 - q)));
        let places = OWN.iter().zip(image.parts).zip(self.weights);
        for (z, ((own, &[sin_i, cos_i]), &weight)) in self.z.iter().zip(places) {
            // One over sin x_i.
            let inverse = weight / (sin * own.cos - cos * own.sin);
            let (p, slope) = (sin * inverse, own.slope * inverse * inverse);
            if iq {
                re.add(p, slope, z.re);
                im.add(p, slope, z.im);
                continue;
            }
            // One over sin z_i.
            let inverse = weight / (sin * cos_i + cos * sin_i);
            let (q, bend) = (height * inverse, (tilt * sin_i * inverse + drift) * inverse);
            re.add(p + q, slope + bend, z.re);
            im.add(p - q, slope - bend, z.im);
        }
        let products = Products {
            g11: re.pp,
            g12: 0.0,
            g22: im.pp,
            r: [re.py, im.py],
            b11: re.ps,
            b12: 0.0,
            b21: 0.0,
            b22: im.ps,
            d11: re.ss,
            d12: 0.0,
            d22: im.ss,
            q: [re.sy, im.sy],
        };
        let step = products.step_beyond(Complex::new(re.height, im.height));
        let Complex { re: a, im: b } = step.line;
        let explained = a * a * re.pp + b * b * im.pp;
        let residual = re.yy + im.yy - (a - re.height) * re.py - (b - im.height) * im.py;
        (step, explained, residual)
    }

    /// The start: Jacobsen's ratio, which is exact for a tone without an image in long records.
    fn start(&self) -> f32 {
        let [_, _, _, _, _, below, peak, above, ..] = self.z;
        let sum = peak + peak - below - above;
        ((below - above) * sum.conj()).re / sum.norm_sqr()
    }
}

/// The noise power per sample in a fit's residual: a rough value, with some 23 degrees of freedom.
pub fn noise(iq: bool, found: &Found, n: usize) -> f32 {
    let parts = if iq { 2.0 } else { 1.0 };
    let floor = ROUNDING as f32 * parts;
    (2.0 * found.residual / (found.dof.max(1) as f32 * n as f32)).max(floor)
}

/// The effect of a bin's distance from the strongest on the tone's shape.
#[derive(Clone, Copy)]
struct Own {
    /// Sine and cosine of `pi j / 32`.
    sin: f32,
    cos: f32,
    /// `-pi/32 sin(pi j / 32)`
    slope: f32,
}

/// The effects for every bin of a fit.
static OWN: [Own; CELLS] = own();

#[allow(clippy::indexing_slicing)]
const fn own() -> [Own; CELLS] {
    let parts = parts::<CELLS>(-REACH);
    let mut table = [Own { sin: 0.0, cos: 0.0, slope: 0.0 }; CELLS];
    let mut j = 0;
    while j < CELLS {
        let [sin, cos] = parts[j];
        table[j] = Own { sin, cos, slope: -BIN * sin };
        j += 1;
    }
    table
}

/// Weights with which all bins of a fit count.
static ALL: [f32; CELLS] = [1.0; CELLS];

/// Weights without one bin, by its index.
static BUT_ONE: [[f32; CELLS]; CELLS] = but_one();

#[allow(clippy::indexing_slicing)]
const fn but_one() -> [[f32; CELLS]; CELLS] {
    let mut table = [[1.0; CELLS]; CELLS];
    let mut j = 0;
    while j < CELLS {
        table[j][j] = 0.0;
        j += 1;
    }
    table
}

/// Sine and cosine of `pi j / 32`, for j of a whole turn and the bins of a fit beyond.
static PARTS: [[f32; 2]; 2 * POINTS + CELLS] = parts::<{ 2 * POINTS + CELLS }>(0);

/// Sines and cosines from `first` on.
fn parts_at<const COUNT: usize>(first: i32) -> &'static [[f32; 2]; COUNT] {
    let parts = PARTS.get(first as usize % (2 * POINTS)..).and_then(|parts| parts.first_chunk());
    // There are enough for every place and count.
    parts.unwrap_or(&[[0.0; 2]; COUNT])
}

// Const functions cannot use `get_mut`. An index out of range would not compile.
#[allow(clippy::indexing_slicing)]
const fn parts<const COUNT: usize>(first: i32) -> [[f32; 2]; COUNT] {
    let mut table = [[0.0; 2]; COUNT];
    let turn = 2 * POINTS as i32;
    let mut j = 0;
    while j < COUNT {
        let place = (first + j as i32).rem_euclid(turn) as usize;
        let (sin, cos) = sin_cos(place, 2 * POINTS);
        // The sine of half a turn is zero and not 1e-16, because the fit tests for zero.
        table[j] = [
            if place.is_multiple_of(POINTS) { 0.0 } else { sin as f32 },
            if place % POINTS == POINTS / 2 { 0.0 } else { cos as f32 },
        ];
        j += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::{Iq, Real, Record};
    use crate::math::scalar::Scalar;
    use crate::spectrum::zoom::Oscillator;

    /// Offset and amplitude of a noiseless tone of 16 bits. The converter's rounding and the Q15
    /// factors limit the error.
    fn check<R: Record, const N: usize>(centre: i32, offset: f64) {
        let amplitude = 30000.0;
        let samples = core::array::from_fn(|n| {
            let turns = (f64::from(centre) + offset) * n as f64 / N as f64 + 0.21;
            let z = f64::unit(turns.fract()) * amplitude;
            R::from_parts([z.re.round() as i16, z.im.round() as i16])
        });
        let layout = Layout::of::<R, N>();
        let zoom = Oscillator::new(centre, layout).zoom::<R, N>(&samples);
        let found = Place::new(centre, layout).fit(&zoom, 0.0).unwrap();
        let error = f64::from(found.offset) - offset;
        assert!(error.abs() < 3e-4, "N {N}, centre {centre}, offset {offset}: {error:e}");
        let ratio = f64::from(found.amplitude_squared).sqrt() / amplitude;
        assert!((ratio - 1.0).abs() < 3e-4, "N {N}, centre {centre}, offset {offset}: {ratio}");
    }

    #[test]
    fn the_model_is_exact() {
        for step in -20..=20 {
            let offset = f64::from(step) / 10.0 + 0.013;
            for centre in [9, 20, 23] {
                check::<Real, 64>(centre, offset);
            }
            for centre in [12, 16, 24, 100, 101, 250, 500] {
                check::<Real, 1024>(centre, offset);
                check::<Iq, 1024>(-centre, offset);
            }
            check::<Real, 4096>(1300, offset);
        }
        check::<Real, 1024>(100, 0.0);
        check::<Real, 1024>(112, 1.0);
    }
}

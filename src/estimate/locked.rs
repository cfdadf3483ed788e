//! Least squares over the bins of a [`Zoom`]: a tone whose place is known, at a tenth of the cost.
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
//! so the real parts are a multiple of `1/sin x + r/sin z` and the imaginary parts of `1/sin x - r/sin z`: two
//! linear parameters and d, as in the fit of the full way. I/Q records have no image, r = 0. Without the image the error at
//! 60 dB would be 60 times the bound. Thirteen bins about the strongest; the one that holds the constant offset is
//! left out.
//!
//! This fit is this project's own.

use super::least_squares::{circle, cosine, line_shape, sinc};
use super::noise;
use crate::acquire::sample::Record;
use crate::spectrum::zoom::{POINTS, Zoom};
use num_complex::Complex;

/// Bins on each side of the strongest.
const REACH: i32 = 6;

/// The tone is looked for so many bins to each side of where it is expected.
const WITHIN: i32 = 2;

/// The farthest from the centre that it may be expected, in bins.
const FARTHEST: i32 = 5;

/// The largest distance from the centre that the fit reads.
const WIDEST: i32 = FARTHEST + WITHIN + REACH;

/// Within so many bins of a multiple of 32, that is the centre.
const BLIND: i32 = 4;

/// Steps of Gauss and Newton at most, and the move after which no further one is made, in bins.
const STEPS: usize = 3;
const SETTLED: f32 = 0.02;

/// The angle of one bin.
const BIN: f32 = core::f32::consts::PI / POINTS as f32;

/// What is known of a centre before any record.
#[derive(Clone, Debug)]
pub struct Place {
    centre: i32,
    n: i32,
    /// Cosine and sine of 2 pi c / N.
    turn: Complex<f32>,
    /// `exp(-j pi (i/32 + c/N))`, i from [`Place::FIRST`].
    back: [Complex<f32>; 2 * WIDEST as usize + 1],
}

/// The centre from which a tone at `bins` is best seen; `None` too near to DC or Nyquist of a real record.
///
/// A constant offset falls into the bins that are multiples of 32, wherever the centre is; but from a centre that is such a
/// multiple the boxcar does not see it at all.
pub fn centre<R: Record>(bins: f32, n: usize) -> Option<i32> {
    const EDGE: f32 = 8.0;
    if !(R::IQ || (EDGE..=n as f32 / 2.0 - EDGE).contains(&bins)) {
        return None;
    }
    let nearest = libm::rintf(bins) as i32;
    let points = POINTS as i32;
    let multiple = (nearest + points / 2).div_euclid(points) * points;
    Some(if (nearest - multiple).abs() <= BLIND { multiple } else { nearest })
}

/// A tone, found in a zoom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Its distance from the centre, in bins.
    pub offset: f32,
    /// How well the bins pin it: the noise power of a bin divided by twice this is the variance in bins^2.
    pub information: f32,
    /// The square of the amplitude in codes.
    pub amplitude_squared: f32,
    /// The power of the bins that the tone explains, in squared codes.
    pub explained: f32,
    /// The power it does not, and how many real numbers that has.
    pub residual: f32,
    /// See [`Found::residual`].
    pub freedom: u32,
}

/// A bin that enters the fit: its distance from the centre and its value, turned.
#[derive(Clone, Copy)]
struct Cell {
    i: i32,
    z: Complex<f32>,
}

/// The sums of one of the two parts.
#[derive(Clone, Copy, Default)]
struct Sums {
    pp: f32,
    ps: f32,
    ss: f32,
    py: f32,
    sy: f32,
}

impl Sums {
    fn add(&mut self, p: f32, s: f32, y: f32) {
        self.pp += p * p;
        self.ps += p * s;
        self.ss += s * s;
        self.py += p * y;
        self.sy += s * y;
    }

    /// The linear parameter, its share of the gradient, and of the information.
    fn solve(&self) -> (f32, f32, f32) {
        let (a, lean) = (self.py / self.pp, self.ps / self.pp);
        (a, a * (self.sy - lean * self.py), a * a * (self.ss - lean * self.ps))
    }
}

impl Place {
    const FIRST: i32 = -WIDEST;

    /// A centre bin of records of `n` samples. Cost: 28 sines.
    pub fn new(centre: i32, n: usize) -> Self {
        let n = n.max(POINTS) as i32;
        let mut back = [Complex::new(0.0, 0.0); 2 * WIDEST as usize + 1];
        for (turn, i) in back.iter_mut().zip(Self::FIRST..) {
            // -pi (i/32 + c/N) as a fraction of 2 N.
            let k = (i * (n / POINTS as i32)).wrapping_add(centre);
            *turn = circle(k.wrapping_neg(), 2 * n);
        }
        Self { centre, n, turn: circle(centre, n), back }
    }

    /// Whether a tone at `bins` can be followed from this centre.
    pub fn reaches(&self, bins: f32) -> bool {
        (bins - self.centre as f32).abs() <= FARTHEST as f32 - 0.5
    }

    /// The strongest tone near `expected`, its distance from the centre in bins (at most 5); `None` where there is
    /// nothing at all.
    pub fn fit<R: Record>(&self, zoom: &Zoom, expected: f32) -> Option<Found> {
        let unit = zoom.unit();
        let expected = (libm::rintf(expected) as i32).clamp(-FARTHEST, FARTHEST);
        let cell = |i: i32| {
            let index = usize::try_from(i - Self::FIRST).ok()?;
            // The bin of the constant offset.
            let points = POINTS as i32;
            if self.centre % points != 0 && (self.centre + i) % points == 0 {
                return None;
            }
            let y = zoom.bin(self.centre + i);
            let y = Complex::new(y.re as f32 * unit, y.im as f32 * unit);
            Some(Cell { i, z: y * self.back.get(index)? })
        };
        let mut peak: Option<Cell> = None;
        for found in (expected - WITHIN..=expected + WITHIN).filter_map(cell) {
            if peak.is_none_or(|peak| found.z.norm_sqr() > peak.z.norm_sqr()) {
                peak = Some(found);
            }
        }
        let peak = peak.filter(|peak| peak.z.norm_sqr() > 0.0)?;
        let mut cells = heapless::Vec::<Cell, { 2 * REACH as usize + 1 }>::new();
        for found in (peak.i - REACH..=peak.i + REACH).filter_map(cell) {
            // There is room for all.
            let _ = cells.push(found);
        }
        let mut d = start(&peak, cell(peak.i - 1), cell(peak.i + 1));
        let mut step = self.step::<R>(&cells, peak.i, d);
        for _ in 0..STEPS {
            let next = near(d + step.forward, peak.i);
            let moved = next - d;
            d = next;
            step = self.step::<R>(&cells, peak.i, d);
            if moved.abs() <= SETTLED {
                break;
            }
        }
        // The power of one linear parameter is its share of the data.
        let explained = step.explained;
        let total: f32 = cells.iter().map(|cell| cell.z.norm_sqr()).sum();
        let offset = d - peak.i as f32;
        let (x, y) = (BIN * offset, core::f32::consts::PI / self.n as f32 * d);
        let v = BIN * d;
        // (a + j b) times D / h: D = sin(pi d) / sin(pi d / 32) from the strongest bin, h of the boxcar.
        let shape = POINTS as f32 * line_shape(offset) / sinc(x * x);
        let boxcar = (self.n as f32 / POINTS as f32) * sinc(v * v) / sinc(y * y);
        let scale = (if R::IQ { 1.0 } else { 2.0 }) / (shape * boxcar);
        Some(Found {
            offset: d,
            information: step.information,
            amplitude_squared: step.line.norm_sqr() * scale * scale,
            explained,
            residual: (total - explained).max(0.0),
            freedom: (2 * cells.len() as u32).saturating_sub(3),
        })
    }

    /// The normal equations at d. Shapes are scaled by sin x at the peak bin, so that they are 1 there; their
    /// slopes are less the part that this scale makes, which the fit takes out anyway.
    fn step<R: Record>(&self, cells: &[Cell], peak: i32, d: f32) -> Step {
        let x = BIN * d;
        let (sin_d, cos_d) = (x * sinc(x * x), cosine(x * x));
        let at = |j: i32| (sine(j), sine(j + POINTS as i32 / 2));
        let turned = |j: i32| {
            let (sin, cos) = at(j);
            sin_d * cos + cos_d * sin
        };
        let first = turned(-peak);
        let twice = self.centre.wrapping_mul(2);
        let [ratio, drift] = if R::IQ { [0.0; 2] } else { self.ratio(d) };
        let (mut re, mut im) = (Sums::default(), Sums::default());
        for &Cell { i, z } in cells {
            let inverse = 1.0 / turned(-i);
            let (p, slope) = if i == peak {
                (1.0, 0.0)
            } else {
                (first * inverse, BIN * at(peak - i).0 * inverse * inverse)
            };
            let (mut q, mut bend) = (0.0, 0.0);
            if !R::IQ {
                let apart = twice + i + peak;
                if apart % POINTS as i32 == 0 {
                    // The image's own bin: the same angle, or half turns more.
                    let sign = if apart % (2 * POINTS as i32) == 0 { 1.0 } else { -1.0 };
                    (q, bend) = (sign * ratio, sign * drift);
                } else {
                    let inverse = 1.0 / turned(twice + i);
                    q = ratio * first * inverse;
                    bend = (ratio * BIN * at(apart).0 * inverse + drift * first) * inverse;
                }
            }
            re.add(p + q, slope + bend, z.re);
            im.add(p - q, slope - bend, z.im);
        }
        let (a, ga, ia) = re.solve();
        let (b, gb, ib) = im.solve();
        let information = ia + ib;
        Step {
            forward: (ga + gb) / information,
            information,
            line: Complex::new(a, b),
            explained: a * re.py + b * im.py,
        }
    }

    /// r = h(2 c + d) / h(d), and its slope over d. Without the slope the steps would still end at the right
    /// place, but near bin 16 too slowly.
    fn ratio(&self, d: f32) -> [f32; 2] {
        let x = BIN * d;
        let (sin_x, cos_x) = (x * sinc(x * x), cosine(x * x));
        let twice = self.centre.wrapping_mul(2);
        let (sin_c, cos_c) = (sine(twice), sine(twice.wrapping_add(POINTS as i32 / 2)));
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
        [sin_w * inverse, slope * inverse]
    }
}

/// One evaluation at an offset.
struct Step {
    forward: f32,
    information: f32,
    line: Complex<f32>,
    explained: f32,
}

/// Where to begin: Jacobsen's ratio, exact for a tone without an image in wide records.
fn start(peak: &Cell, below: Option<Cell>, above: Option<Cell>) -> f32 {
    let centre = peak.i as f32;
    let (Some(below), Some(above)) = (below, above) else {
        return centre;
    };
    let sum = peak.z + peak.z - below.z - above.z;
    let ratio = (below.z - above.z) * sum.conj();
    near(centre + ratio.re / sum.norm_sqr(), peak.i)
}

/// Within 0.75 bin of the peak; the peak itself where `d` is not a number.
fn near(d: f32, peak: i32) -> f32 {
    let centre = peak as f32;
    if d.is_nan() { centre } else { d.max(centre - 0.75).min(centre + 0.75) }
}

/// The noise power per sample that a fit leaves: a rough one, of some 23 numbers.
pub fn noise<R: Record>(found: &Found, n: usize) -> f32 {
    let parts = if R::IQ { 2.0 } else { 1.0 };
    let floor = noise::ROUNDING as f32 * parts;
    (2.0 * found.residual / (found.freedom.max(1) as f32 * n as f32)).max(floor)
}

/// `sin(pi j / 32)`.
fn sine(j: i32) -> f32 {
    SINES.get(j.rem_euclid(2 * POINTS as i32) as usize).copied().unwrap_or(0.0)
}

const SINES: [f32; 2 * POINTS] = sines();

// Const functions cannot use `get_mut`; an index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn sines() -> [f32; 2 * POINTS] {
    let mut table = [0.0; 2 * POINTS];
    let mut j = 0;
    while j < 2 * POINTS {
        // The sine of half a turn is zero and not 1e-16: the fit asks.
        if !j.is_multiple_of(POINTS) {
            table[j] = crate::spectrum::fft::twiddle::sin_cos(j, 2 * POINTS).0 as f32;
        }
        j += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::{Codes, Iq, Real};
    use crate::scalar::Scalar;
    use crate::spectrum::zoom::Oscillator;

    /// Offset and amplitude of a noiseless tone of 16 bits: what is left is the converter's rounding and the Q15
    /// factors.
    fn check<R: Record, const N: usize>(centre: i32, offset: f64) {
        let amplitude = 30000.0;
        let samples = core::array::from_fn(|n| {
            let turns = (f64::from(centre) + offset) * n as f64 / N as f64 + 0.21;
            let z = f64::unit(turns.fract()) * amplitude;
            R::of_parts([z.re.round() as i16, z.im.round() as i16])
        });
        let zoom = Oscillator::new(centre, N).zoom::<R, N>(&samples, Codes::Signed16);
        let found = Place::new(centre, N).fit::<R>(&zoom, 0.0).unwrap();
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

//! The fit of a tone into whose bins a line farther off leaks.
//!
//! A fit to sixteen bins on each side follows the leakage. In the few bins nearest the tone leakage is nearly a
//! straight line, `a + b k`. So with a tone `d` bins above the peak bin p,
//!
//! ```text
//! X[p+k] = c q + a + b k      q = d / (d - k)      q' = dq/dd = -k / (d - k)^2
//! ```
//!
//! a, b and c complex unknowns. Less their own mean and slope over the bins, X, q and q' follow the same equation
//! without a and b, and Gauss-Newton fits d. To five bins this is the best fit under Hann's window: that is what
//! second differences are.
//!
//! The sums take bins k and -k together, as halves of their sum and difference. With `r = 1 / (d^2 - k^2)`
//!
//! ```text
//! q: d^2 r, d k r      q': -2 d k^2 r^2, k r (1 - 2 d^2 r)
//! ```
//!
//! Without leakage the error is 1.3 times the Cramer-Rao bound with nine bins, and 1.75 times with five.

use super::{Fit, OFFSET_LIMIT, STEP_LIMIT, limit};
use crate::math::scalar::Scalar as _;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::neighbourhood::Neighbourhood;
use num_complex::Complex;

/// The bins of both fits on each side of the peak.
const REACH: usize = 4;
const NEAREST: usize = 2;

/// A residual is taken for noise within this many of its own standard deviations: noise alone exceeds the limit in three blocks of a
/// hundred.
const SPREAD: f32 = 3.5;

/// If the residual is not noise-like, accept the five-bin fit only if its sigma is this many times smaller.
const UNCLEAN: f32 = 10.0;

/// The result of a fit.
#[derive(Clone, Copy)]
pub(crate) struct Leaked {
    /// The tone's distance from the peak bin, in bins.
    pub offset: f32,
    /// The power that the fit leaves, as the noise power of a sample in squared codes.
    pub left: f32,
    /// The information about the offset, for a noise power of 1 per sample.
    information: f32,
    /// Degrees of freedom of the residual.
    dof: f32,
}

impl Leaked {
    /// One standard deviation of the offset, for this noise power per sample.
    pub fn sigma(&self, noise: f32) -> f32 {
        (0.5 * noise.max(self.left) / self.information).root()
    }

    fn is_clean(&self, noise: f32) -> bool {
        self.left < (1.0 + SPREAD / self.dof.root()) * noise
    }
}

/// The nine bins nearest a tone, in stored units.
pub(crate) struct Nearest {
    points: [Point; 2 * REACH + 1],
    /// The noise power per sample for a power of 1 in stored units.
    unit: f32,
}

impl Nearest {
    /// Takes the bins around a peak.
    pub fn from_neighbourhood(near: &Neighbourhood) -> Self {
        let unit = f32::two_to(2 * near.exponent - near.n.trailing_zeros() as i32);
        Self { points: near.within(REACH).first_chunk().copied().unwrap_or_default(), unit }
    }

    /// Fits a tone to the nine bins, from another fit's offset; `None` if there is no signal.
    ///
    /// Cost: some 500 operations, of them 20 divisions.
    pub fn nine(&self, start: f32) -> Option<Leaked> {
        fit_points(&self.points, self.unit, start, 2)
    }

    /// Returns the nine- or five-bin fit if its sigma is below `sigma`, the full fit's.
    fn better(&self, nine: Leaked, noise: f32, sigma: f32) -> Option<Leaked> {
        if nine.is_clean(noise) && nine.sigma(noise) < sigma {
            return Some(nine);
        }
        let points = self.points.get(REACH - NEAREST..=REACH + NEAREST)?;
        let five = fit_points(points, self.unit, nine.offset, 1)?;
        // Another line 1 to 3 bins off can leave little in five bins by chance. A wider fit then leaves more.
        let least = if five.is_clean(noise) { 1.0 } else { UNCLEAN };
        (five.sigma(noise) * least < sigma).then_some(five)
    }
}

/// The leakage near a tone, as known before the nearest bins decide.
#[derive(Clone, Copy, Default)]
pub(crate) struct Leakage {
    /// The fit to nine bins, if there was one.
    pub nine: Option<Leaked>,
    /// The noise has an edge here, and no line explains the edge.
    pub on_an_edge: bool,
    /// The noise power of the louder side.
    pub loud: f32,
}

impl Leakage {
    /// Returns sigma, and sets the offset in `fit`, of a tone with lines beside it, if the nearest bins are more exact than the fit to all
    /// bins, whose sigma is `sigma`.
    #[inline(never)]
    pub fn refined(&self, nearest: &Nearest, noise: f32, fit: &mut Fit<f32>, sigma: f32) -> f32 {
        let Some(nine) = self.nine.or_else(|| nearest.nine(fit.offset)) else {
            return sigma;
        };
        // At an edge the tone's noise may be as loud as the louder side.
        let noise = if self.on_an_edge { noise.max(nine.left.min(self.loud)) } else { noise };
        let Some(better) = nearest.better(nine, noise, sigma) else {
            return sigma;
        };
        let sigma = better.sigma(noise);
        // Within one sigma the fit to all bins is the better one.
        if (better.offset - fit.offset).abs() > sigma {
            fit.offset = better.offset;
        }
        sigma
    }
}

#[inline(never)]
fn fit_points(points: &[Point], unit: f32, start: f32, steps: u32) -> Option<Leaked> {
    let bins = Bins::from_points(points)?;
    let mut offset = limit(start, OFFSET_LIMIT);
    let mut step = bins.step(offset);
    for _ in 1..steps {
        offset = limit(offset + step.forward, OFFSET_LIMIT);
        step = bins.step(offset);
    }
    // Degrees of freedom: the real numbers of the bins less the real unknowns, which are three complex ones and the offset.
    let dof = bins.count + bins.count - 7.0;
    (step.information > 0.0).then(|| Leaked {
        offset: limit(offset + step.forward, OFFSET_LIMIT),
        left: 2.0 * bins.residual(offset, &step) / dof * unit,
        information: step.information * unit,
        dof,
    })
}

/// The bins, less their mean and slope.
struct Bins {
    centre: Complex<f32>,
    /// Sum and difference of the bins k above and below, from k = 1 on.
    pairs: [[Complex<f32>; 2]; REACH],
    reach: usize,
    /// The number of bins, and the sum of `k^2` over them.
    count: f32,
    squares: f32,
}

/// One evaluation of the normal equations.
struct Step {
    /// The step in bins.
    forward: f32,
    information: f32,
    line: Complex<f32>,
    /// The part of q' along q.
    share: f32,
    /// Mean and slope of q, and of q'.
    straight: [[f32; 2]; 2],
}

/// Halves of sum and difference of q in the bins k above and below, and of q'.
fn shapes(d: f32, k: f32) -> [[f32; 2]; 2] {
    let square = d * d;
    let r = 1.0 / (square - k * k);
    let (even, kr) = (square * r, k * r);
    [[even, d * kr], [-2.0 * d * kr * kr, kr * (1.0 - even - even)]]
}

impl Bins {
    fn from_points(points: &[Point]) -> Option<Self> {
        let bin = |&[re, im]: &Point| Complex::new(re as f32, im as f32);
        let (below, rest) = points.split_at_checked(points.len() / 2)?;
        let (centre, above) = rest.split_first()?;
        let mut bins = Bins {
            centre: bin(centre),
            pairs: [[Complex::new(0.0, 0.0); 2]; REACH],
            reach: below.len(),
            count: points.len() as f32,
            squares: 0.0,
        };
        let (mut mean, mut slope) = (bins.centre, Complex::new(0.0, 0.0));
        let beside = above.iter().zip(below.iter().rev());
        for ((pair, (above, below)), k) in bins.pairs.iter_mut().zip(beside).zip(1..) {
            let (above, below, k) = (bin(above), bin(below), k as f32);
            *pair = [above + below, above - below];
            mean += above + below;
            slope += (above - below) * k;
            bins.squares += k * k + k * k;
        }
        let mean = mean / bins.count;
        let slope = slope / bins.squares;
        bins.centre -= mean;
        for (pair, k) in bins.pairs.iter_mut().zip(1..) {
            let [even, odd] = pair;
            *even -= mean + mean;
            *odd -= (slope + slope) * k as f32;
        }
        Some(bins)
    }

    /// The pairs with their distances.
    fn pairs(&self) -> impl Iterator<Item = (&[Complex<f32>; 2], f32)> {
        self.pairs.iter().take(self.reach).zip(1..).map(|(pair, k)| (pair, k as f32))
    }

    fn step(&self, d: f32) -> Step {
        // Of q q, q q' and q' q'; means and slopes of both; of X q and X q'.
        let (mut aa, mut bb, mut dd) = (0.0, 0.0, 0.0);
        let mut straight = [[0.5, 0.0], [0.0, 0.0]];
        let (mut along, mut across) = (self.centre, Complex::new(0.0, 0.0));
        for ([even, odd], k) in self.pairs() {
            let shapes = shapes(d, k);
            let [[a, b], [u, v]] = shapes;
            aa += a * a + b * b;
            bb += a * u + b * v;
            dd += u * u + v * v;
            for ([mean, slope], [even, odd]) in straight.iter_mut().zip(shapes) {
                *mean += even;
                *slope += k * odd;
            }
            along += even * a + odd * b;
            across += even * u + odd * v;
        }
        let [[am, at], [um, ut]] = straight;
        let (of_mean, of_slope) = (2.0 / self.count, 2.0 / self.squares);
        let aa = 1.0 + 2.0 * (aa - of_mean * am * am - of_slope * at * at);
        let bb = 2.0 * (bb - of_mean * am * um - of_slope * at * ut);
        let dd = 2.0 * (dd - of_mean * um * um - of_slope * ut * ut);
        let share = bb / aa;
        let line = along / aa;
        let information = line.norm_sqr() * (dd - share * bb);
        let forward = (line.conj() * (across - along * share)).re / information;
        Step {
            forward: limit(forward, STEP_LIMIT),
            information,
            line,
            share,
            straight: straight.map(|[mean, slope]| [mean * of_mean, slope * of_slope]),
        }
    }

    /// The residual power after a step from `d`.
    fn residual(&self, d: f32, step: &Step) -> f32 {
        let slopes = step.forward;
        let values = 1.0 - slopes * step.share;
        let both =
            |[[a, b], [u, v]]: [[f32; 2]; 2]| [values * a + slopes * u, values * b + slopes * v];
        let [mean, slope] = both(step.straight);
        let left = (self.centre - step.line * (values - mean)).norm_sqr();
        let twice = step.line + step.line;
        let pairs = self.pairs().map(|([even, odd], k)| {
            let [a, b] = both(shapes(d, k));
            (even - twice * (a - mean)).norm_sqr() + (odd - twice * (b - slope * k)).norm_sqr()
        });
        left + 0.5 * pairs.sum::<f32>()
    }
}

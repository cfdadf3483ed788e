//! Estimators too expensive or too unusual for a microcontroller, in `f64` on the host: Kay's, Fitz's and
//! maximum likelihood, the yardsticks the others are held against.

use picket_dsp::acquire::sample::Record;
use picket_dsp::math::scalar::Scalar;
use picket_dsp::methods::registry::{About, Needs, Records, Unfit, Window};
use picket_transform::{Transform, num_complex::Complex};
use std::f64::consts::TAU;

type Complex64 = Complex<f64>;

/// A method of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// [`kay`].
    Kay,
    /// [`fitz`].
    Fitz,
    /// [`ml_iq`] and [`ml_real`].
    Ml,
}

impl Reference {
    /// Every one.
    pub const ALL: &'static [Reference] = &[Reference::Kay, Reference::Fitz, Reference::Ml];

    /// Its description, as the core's registry has one of each method.
    pub const fn about(self) -> About {
        let (name, records, efficiency, doc) = match self {
            Reference::Kay => {
                ("kay", Records::Iq, 1.0, "Kay: weighted phase steps; unusable below 10 dB (host)")
            }
            Reference::Fitz => {
                ("fitz", Records::Iq, 1.02, "Fitz: weighted phases of N/2 autocorrelations (host)")
            }
            Reference::Ml => {
                ("ml", Records::Both, 1.0, "maximum likelihood: padded FFT, then Newton (host)")
            }
        };
        About {
            name,
            family: "reference",
            records,
            needs: Needs::Samples,
            window: Window::Rectangular,
            efficiency,
            doc,
        }
    }

    /// The one with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|reference| reference.about().name == name)
    }

    /// Whether it is right for records of kind `R`.
    pub const fn fits<R: Record>(self) -> bool {
        self.about().records.include::<R>()
    }

    /// The frequency of an I/Q record in bins, `0..N`.
    pub fn iq(self, samples: &[Complex64]) -> Result<f64, Unfit> {
        match self {
            Reference::Kay => Ok(kay(samples)),
            Reference::Fitz => Ok(fitz(samples)),
            Reference::Ml => Ok(ml_iq(samples)),
        }
    }

    /// The frequency of a real record in bins, `0..N/2`.
    pub fn real(self, samples: &[f64]) -> Result<f64, Unfit> {
        match self {
            Reference::Ml => Ok(ml_real(samples)),
            _ => Err(Unfit),
        }
    }

    /// The frequency of a record of the converter's codes, in bins.
    pub fn codes<R: Record>(self, samples: &[R::Sample]) -> Result<f64, Unfit> {
        let parts = samples.iter().map(|&sample| R::parts(sample).map(f64::from));
        if R::IQ {
            self.iq(&parts.map(|[re, im]| Complex::new(re, im)).collect::<Vec<_>>())
        } else {
            self.real(&parts.map(|[re, _]| re).collect::<Vec<_>>())
        }
    }
}

/// Kay's weighted phase averager (Kay 1989, eq 16), in bins. Valid above about 10 dB only: below, single phase
/// steps wrap.
pub fn kay(samples: &[Complex64]) -> f64 {
    let n = samples.len() as f64;
    let sum: f64 = samples
        .windows(2)
        .enumerate()
        .map(|(k, pair)| {
            let from_middle = (k as f64 - (n / 2.0 - 1.0)) / (n / 2.0);
            let weight = 1.5 * n / (n * n - 1.0) * (1.0 - from_middle * from_middle);
            weight * f64::angle(pair[1] * pair[0].conj())
        })
        .sum();
    (n / TAU * sum).rem_euclid(n)
}

/// Fitz's estimator (Fitz 1994) with `N/2` lags, taken about the strongest bin so that no phase
/// wraps, in bins.
pub fn fitz(samples: &[Complex64]) -> f64 {
    let n = samples.len();
    let peak = strongest(samples, 1, 0, n);
    let lags = n / 2;
    // Padded to twice the length, the circular correlation is the linear one.
    let mut correlation = padded(samples, 2);
    correlation.iter_mut().for_each(|x| *x = Complex::new(x.norm_sqr(), 0.0));
    f64::inverse(2 * n).process(&mut correlation);
    let sum: f64 = (1..=lags)
        .map(|lag| {
            let turns = (peak as usize * lag % n) as f64 / n as f64;
            lag as f64 * f64::angle(correlation[lag] * f64::unit(-turns))
        })
        .sum();
    let (n, j) = (n as f64, lags as f64);
    (peak + n * 6.0 / (TAU * j * (j + 1.0) * (2.0 * j + 1.0)) * sum).rem_euclid(n)
}

/// The maximum of the periodogram (Rife and Boorstyn 1974), which is maximum likelihood for one complex
/// tone: the strongest point of a four times padded FFT, then Newton's method; in bins.
pub fn ml_iq(samples: &[Complex64]) -> f64 {
    let n = samples.len() as f64;
    let mut f = strongest(samples, 4, 0, 4 * samples.len());
    for _ in 0..20 {
        let [c0, c1, c2] = moments(samples, f);
        let s = TAU / n;
        let (first, second) = (Complex::new(0.0, -s) * c1, c2 * (-s * s));
        let slope = 2.0 * (first * c0.conj()).re;
        let bend = 2.0 * ((second * c0.conj()).re + first.norm_sqr());
        let step = if bend < 0.0 { -slope / bend } else { 0.1 * slope.signum() };
        f += step.clamp(-0.25, 0.25);
        if step.abs() < 1e-12 {
            break;
        }
    }
    f.rem_euclid(n)
}

/// The transform at `f` bins and its first two moments about the record's middle.
fn moments(samples: &[Complex64], f: f64) -> [Complex64; 3] {
    let n = samples.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mut sums = [Complex::new(0.0, 0.0); 3];
    for (k, x) in samples.iter().enumerate() {
        let k = k as f64;
        let y = x * f64::unit(-(f * k / n).fract());
        sums[0] += y;
        sums[1] += y * (k - middle);
        sums[2] += y * ((k - middle) * (k - middle));
    }
    sums
}

/// Maximum likelihood for one real tone without DC: the strongest point of a four times padded FFT (half a
/// bin from either end), then Gauss-Newton on `A cos + B sin`; in bins.
pub fn ml_real(samples: &[f64]) -> f64 {
    let n = samples.len();
    let complex: Vec<_> = samples.iter().map(|&x| Complex::new(x, 0.0)).collect();
    let mut f = strongest(&complex, 4, 2, 2 * n - 1);
    for _ in 0..20 {
        let step = gauss_newton(samples, f).clamp(-0.3, 0.3);
        f += step;
        if step.abs() < 1e-10 {
            break;
        }
    }
    f
}

/// One step: the residual, which is at right angles to cosine and sine, on the part of the derivative
/// that is so too.
fn gauss_newton(samples: &[f64], f: f64) -> f64 {
    let n = samples.len() as f64;
    let middle = 0.5 * (n - 1.0);
    // [time from the middle, cosine, sine, sample]
    let points: Vec<[f64; 4]> = samples
        .iter()
        .enumerate()
        .map(|(k, &x)| {
            let t = k as f64 - middle;
            let phasor = f64::unit(f * t / n);
            [t, phasor.re, phasor.im, x]
        })
        .collect();
    let cosine = |p: &[f64; 4]| p[1];
    let sine = |p: &[f64; 4]| p[2];
    let sample = |p: &[f64; 4]| p[3];
    let (cc, ss) = (dot(&points, cosine, cosine), dot(&points, sine, sine));
    let cs = dot(&points, cosine, sine);
    let determinant = cc * ss - cs * cs;
    let solve = |c: f64, s: f64| [(c * ss - s * cs) / determinant, (s * cc - c * cs) / determinant];
    let [a, b] = solve(dot(&points, sample, cosine), dot(&points, sample, sine));
    let derivative = |p: &[f64; 4]| TAU / n * p[0] * (b * p[1] - a * p[2]);
    let residual = |p: &[f64; 4]| p[3] - a * p[1] - b * p[2];
    let (dc, ds) = (dot(&points, derivative, cosine), dot(&points, derivative, sine));
    let [u, v] = solve(dc, ds);
    let own = dot(&points, derivative, derivative) - u * dc - v * ds;
    if own > 0.0 { dot(&points, derivative, residual) / own } else { 0.0 }
}

fn dot(
    points: &[[f64; 4]],
    left: impl Fn(&[f64; 4]) -> f64,
    right: impl Fn(&[f64; 4]) -> f64,
) -> f64 {
    points.iter().map(|p| left(p) * right(p)).sum()
}

/// The strongest of the points `from..to` of an FFT padded to `pad` times the record, in bins.
fn strongest(samples: &[Complex64], pad: usize, from: usize, to: usize) -> f64 {
    let spectrum = padded(samples, pad);
    let powers = spectrum.iter().map(|x| x.norm_sqr()).enumerate().take(to).skip(from);
    let best = powers.fold((from, -1.0), |best, point| if point.1 > best.1 { point } else { best });
    best.0 as f64 / pad as f64
}

/// The transform of a record followed by zeros to `pad` times its length.
fn padded(samples: &[Complex64], pad: usize) -> Vec<Complex64> {
    let mut x = samples.to_vec();
    x.resize(pad * samples.len(), Complex::new(0.0, 0.0));
    f64::forward(x.len()).process(&mut x);
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::sample::{Iq, Real};

    #[test]
    fn a_clean_tone_is_found_exactly() {
        let (n, f) = (128, 20.3);
        let iq: Vec<_> = (0..n).map(|k| f64::unit(f * k as f64 / n as f64)).collect();
        for &reference in Reference::ALL {
            let got = reference.iq(&iq).unwrap();
            assert!((got - f).abs() < 1e-9, "{}: {got}", reference.about().name);
        }
        let real: Vec<_> = iq.iter().map(|x| 5.0 * x.re).collect();
        assert!((Reference::Ml.real(&real).unwrap() - f).abs() < 1e-9);
        assert_eq!(Reference::Kay.real(&real), Err(Unfit));
        assert!(Reference::Ml.fits::<Real>() && !Reference::Fitz.fits::<Real>());
        assert!(Reference::Kay.fits::<Iq>());
    }
}

//! Random processes that bend a carrier: a phase that wanders, and the speckle of a rough surface.

use core::f64::consts::PI;

/// A Wiener process between two times, in cycles or in whatever its deviation has, at any time in between. The phase of an oscillator whose
/// line is Lorentzian and `w` wide at half of its height walks by `sqrt(2 pi w)` radians with the root of the time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wander {
    from_s: f64,
    step_s: f64,
    /// Its values, a step apart.
    walked: Vec<f64>,
    /// How far it is beside the straight line from each value to the next, normal numbers.
    beside: Vec<f64>,
}

impl Wander {
    /// Between two times, in steps of a sample. Its standard deviation grows by `deviation` with the root of the time in seconds.
    pub fn new(
        span_s: (f64, f64),
        rate_hz: f64,
        deviation: f64,
        mut normal: impl FnMut() -> f64,
    ) -> Self {
        let count = libm::ceil((span_s.1 - span_s.0) * rate_hz) as usize + 2;
        let (step_s, mut place) = (1.0 / rate_hz, 0.0);
        let step = deviation * libm::sqrt(step_s);
        let (mut walked, mut beside) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for _ in 0..count {
            walked.push(place);
            place += step * normal();
            beside.push(step * normal());
        }
        Wander { from_s: span_s.0, step_s, walked, beside }
    }

    /// Its value at a time. Between two steps it is a Brownian bridge, whose variance is that of the walk.
    pub fn at(&self, time_s: f64) -> f64 {
        let place = ((time_s - self.from_s) / self.step_s).max(0.0);
        let (whole, share) = (place as usize, place - libm::floor(place));
        let value =
            |index: usize| self.walked.get(index).or(self.walked.last()).copied().unwrap_or(0.0);
        let bridge =
            self.beside.get(whole).copied().unwrap_or(0.0) * libm::sqrt(share * (1.0 - share));
        value(whole) + share * (value(whole + 1) - value(whole)) + bridge
    }
}

/// The complex envelope of an echo from a rough surface that moves across a Gaussian beam: the sum of many scatterers, each of which is
/// lit while it crosses. Its mean power is 1, its spectrum Gaussian.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Speckle {
    /// When the first scatterer is in the middle of the beam, and the time from one to the next.
    first: f64,
    spacing: f64,
    /// What each scatters.
    scatterers: Vec<[f64; 2]>,
}

/// Scatterers in a standard deviation of the beam: this many that the mean power is the same at all times, to 1e-16.
const DENSITY: f64 = 2.0;
/// Standard deviations of the beam from its middle at which nothing of a scatterer is left: 1e-8 of its amplitude.
const REACH: f64 = 6.0;

impl Speckle {
    /// Speckle of a surface that crosses a spot, between two times in seconds. The diameter is that at which the spot's light is down by
    /// `exp(-2)`. `normal` draws normal numbers.
    ///
    /// A scatterer at the distance `x` from the middle of a spot of radius `r` has the amplitude `exp(-2 (x / r)^2)` on the light's way out and
    /// back. So the bandwidth is `4 sqrt(ln 2) / pi`, or 1.06, times the speed over the diameter.
    pub fn from_spot(
        span_s: (f64, f64),
        speed_mps: f64,
        diameter_m: f64,
        normal: impl FnMut() -> f64,
    ) -> Self {
        let ratio = 4.0 * libm::sqrt(core::f64::consts::LN_2) / PI;
        Self::new(span_s.0, span_s.1, ratio * speed_mps / diameter_m, normal)
    }

    /// Speckle between two times, of a bandwidth that is the full width at half of the spectrum's height. `normal` draws normal numbers.
    pub fn new(from: f64, to: f64, bandwidth: f64, mut normal: impl FnMut() -> f64) -> Self {
        // exp(-t^2 / 2 s^2) has the power spectrum exp(-(2 pi s f)^2).
        let deviation = libm::sqrt(core::f64::consts::LN_2) / (PI * bandwidth);
        let spacing = deviation / DENSITY;
        let count = libm::ceil((to - from) / spacing + 2.0 * REACH * DENSITY) as usize + 1;
        // At any time the squares of the kernels add up to the root of pi times the density. There are two parts.
        let scale = 1.0 / libm::sqrt(2.0 * libm::sqrt(PI) * DENSITY);
        let scatterers = (0..count).map(|_| [scale * normal(), scale * normal()]).collect();
        Self { first: from - REACH * deviation, spacing, scatterers }
    }

    /// The envelope at a time.
    pub fn at(&self, time: f64) -> [f64; 2] {
        let place = (time - self.first) / self.spacing;
        let nearest = libm::round(place).max(0.0) as usize;
        let reach = (REACH * DENSITY) as usize;
        let from = nearest.saturating_sub(reach);
        let mut sum = [0.0; 2];
        for (index, [re, im]) in self.scatterers.iter().enumerate().skip(from).take(2 * reach + 1) {
            let x = (place - index as f64) / DENSITY;
            let light = libm::exp(-0.5 * (x * x));
            sum[0] += re * light;
            sum[1] += im * light;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    /// Its autocorrelation is that of a Gaussian line of the stated width, at any time.
    #[test]
    fn speckle_has_the_width_that_is_stated() {
        let (bandwidth, lag, count) = (0.3, 0.8, 40_000);
        let mut draw = Draw::new(1, 0);
        let mut sums = [0.0; 4];
        for _ in 0..count {
            let speckle = Speckle::new(2.0, 5.0, bandwidth, || draw.normal());
            for (sum, time) in sums.iter_mut().zip([2.0, 3.3, 5.0]) {
                let [re, im] = speckle.at(time);
                *sum += re * re + im * im;
            }
            let (a, b) = (speckle.at(2.7), speckle.at(2.7 + lag));
            sums[3] += a[0] * b[0] + a[1] * b[1];
        }
        let means = sums.map(|sum| sum / f64::from(count));
        // exp(-(pi b lag)^2 / (4 ln 2)): the transform of a Gaussian of this width at half of its height.
        let stated = libm::exp(-(PI * bandwidth * lag).powi(2) / (4.0 * core::f64::consts::LN_2));
        // Powers scatter by their mean: .5 %, one sigma.
        for (mean, stated) in means.into_iter().zip([1.0, 1.0, 1.0, stated]) {
            assert!((mean - stated).abs() < 0.02, "{mean}, not {stated}");
        }
    }

    /// The bandwidth of a spot is 1.06 times speed over diameter.
    #[test]
    fn the_spot_has_the_bandwidth() {
        let (speed, diameter) = (2.0, 1e-3);
        let lag_s = 0.1 * diameter / (1.06 * speed);
        let mut draw = Draw::new(1, 0);
        let mut sums = [0.0; 2];
        for _ in 0..4000 {
            let speckle = Speckle::from_spot((0.0, lag_s), speed, diameter, || draw.normal());
            let [[a, b], [c, d]] = [speckle.at(0.0), speckle.at(lag_s)];
            sums = [sums[0] + a * c + b * d, sums[1] + a * a + b * b];
        }
        // exp(-2 pi^2 (b t / 2.355)^2).
        let expected = libm::exp(-2.0 * (PI * 0.1 / 2.3548).powi(2));
        assert!((sums[0] / sums[1] - expected).abs() < 0.01, "{sums:?} {expected}");
    }
}

//! The image of an I/Q tone at minus its frequency. A front end makes one if its Q is late, weak
//! or dead.

use super::noise::Noise;
use super::observer::Tap;
use super::residual::residual;
use super::statistic::{Statistic, Test};
use super::threshold::{Relaxation, Threshold};
use crate::math::products;
use crate::spectrum::neighbourhood::{Neighbourhood, has_ring};
use crate::tone::fit::{Fit, Model};
use num_complex::Complex;

/// Whether an I/Q record has a stronger line at minus the tone's frequency than a front end should make. The limit is -20 dB of the tone,
/// or half of the image that a real tone at `peak` leaves if Q is a sample late, whichever is less. The latter is the cotangent of half the
/// angle from sample to sample: the nearer the tone to half the rate, the smaller.
pub(super) fn mirrored(
    near: &Neighbourhood,
    fit: &Fit<f32>,
    noise: &Noise,
    observer: impl Tap,
) -> bool {
    let Neighbourhood { n, peak, .. } = *near;
    let Some(least) = Least::new(n, peak, fit) else {
        return false;
    };
    let unit = near.unit();
    let most = near.image.into_iter().map(products::power).max().unwrap_or(0);
    if least.near > FAR && (most as f32) * (unit * unit) < 0.5 * least.power {
        least.hear((most as f32) * (unit * unit), fit, observer);
        return false;
    }
    let model = Model::new(fit, peak, n as i32);
    least.is_exceeded(n, fit, noise, observer, |k| {
        let at = usize::try_from(k.wrapping_add(peak).wrapping_add(1)).unwrap_or(usize::MAX);
        let [re, im] = near.image.get(at).copied().unwrap_or_default();
        (Complex::new(re as f32, im as f32) * unit - model.bin(true, k)).norm_sqr()
    })
}

/// Half-way between two bins a line loses 3.9 dB.
const SCALLOPED: f32 = 0.4;
const SHARE: f32 = 0.01;
/// Nearer to DC the two lines leak into each other.
const NEAREST: i32 = 2;
/// At this distance from DC the leakage is a tenth of the limit's share.
const FAR: i32 = 16;

/// The limits that an image must exceed.
struct Least {
    /// The image's bins.
    places: [i32; 3],
    /// The tone's distance from DC or half the rate, bins.
    near: i32,
    /// Whether a late Q makes less than [`SHARE`].
    is_late: bool,
    power: f32,
}

impl Least {
    #[inline(always)] // the length is a constant
    fn new(n: usize, peak: i32, fit: &Fit<f32>) -> Option<Self> {
        let n = n as i32;
        let half = n / 2;
        let from_dc = (peak.wrapping_add(half).checked_rem_euclid(n)? - half).abs();
        let near = from_dc.min(half - from_dc);
        if near <= NEAREST {
            return None;
        }
        // Near half the rate the cotangent is nearly the complement of the angle.
        let angle = core::f32::consts::PI / n as f32 * (half - from_dc) as f32;
        let late = 0.5 * angle * angle;
        Some(Self {
            places: [-1, 0, 1].map(|i: i32| i.wrapping_sub(peak)),
            near,
            is_late: late < SHARE,
            power: fit.line.norm_sqr() * SHARE.min(late) * SCALLOPED,
        })
    }

    #[inline(always)]
    fn is_exceeded(
        &self,
        n: usize,
        fit: &Fit<f32>,
        noise: &Noise,
        observer: impl Tap,
        rest: impl Fn(i32) -> f32,
    ) -> bool {
        // The noise of a short record has the image in it; the fit's own bins have the image only where it is near.
        let noise = if has_ring(n, true) {
            *noise
        } else {
            Noise { power: noise.power.min(residual(fit, n)), dof: fit.dof as f32 }
        };
        let places = self.places.into_iter().filter(|k| k.checked_rem(n as i32) != Some(0));
        let other = places.map(rest).fold(0.0, f32::max);
        // Three bins of noise exceed this in a block of a million, or of a thousand where tones are
        // rare.
        let chance = if self.is_late {
            const { Threshold::new(3, 1e-3) }
        } else {
            const { Threshold::new(3, 1e-6) }
        };
        self.hear(other, fit, observer);
        let over_noise = || {
            let limit = chance.beside(noise.dof, Relaxation::NOTHING);
            observer.exceeds(Statistic::ImageNoise, other / (noise.power * n as f32), limit)
        };
        other > self.power && over_noise()
    }

    /// Reports the power of the strongest bin at the image's place.
    fn hear(&self, power: f32, fit: &Fit<f32>, observer: impl Tap) {
        let (statistic, line) = (Statistic::ImageShare, fit.line.norm_sqr());
        observer.hear(|| Test { statistic, value: power / line, limit: self.power / line });
    }
}

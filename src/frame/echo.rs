//! The echo of one target in the cells.

use super::plan::FramePlan;
use crate::math::scalar::Scalar as _;
use crate::math::series::{circle, sinc};
use core::f32::consts::{FRAC_PI_4, PI};
use num_complex::Complex;

/// A target's echo. Frequencies belong to the middle of the frame and of its chirps, and are split into whole bins and a rest, so that a
/// float holds them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Echo {
    /// The beat: bins of a chirp.
    pub peak: i32,
    pub offset: f32,
    /// The turn from chirp to chirp in bins of the frame; `chirps` of them are a whole turn.
    pub row: i32,
    pub turn: f32,
    /// Further whole turns from chirp to chirp.
    pub alias: i32,
    /// The level and the phase in the middle of frame and chirp, codes.
    pub amplitude: Complex<f32>,
    /// Bins by which the beat moves from chirp to chirp, and by which it rises within a chirp.
    pub walk: f32,
    pub bend: f32,
    /// The turn's rise over the frame by an acceleration: the phase in turns is `curve (x^2 - 1/12)` beside that of the turn, x from -1/2
    /// to 1/2. It changes neither the mean phase nor the mean turn.
    pub curve: f32,
}

/// The phase of an echo from chirp to chirp, for the amplitude 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Phases {
    phase: Complex<f32>,
    step: Complex<f32>,
    twist: Complex<f32>,
}

impl Phases {
    /// The phase of the next chirp.
    pub fn next(&mut self) -> Complex<f32> {
        let now = self.phase;
        self.phase *= self.step;
        self.step *= self.twist;
        now
    }
}

impl Echo {
    /// Turns from chirp to chirp.
    pub fn turns(&self, plan: &FramePlan) -> f32 {
        self.alias as f32 + (self.row as f32 + self.turn) / plan.chirps as f32
    }

    /// [`Echo::offset`] in the middle of the frame: that of the fit is the mean over the chirps.
    pub fn middle(&self, plan: &FramePlan) -> f32 {
        // A turn is half a wavelength, by which the beat moves as by a walk of one turn.
        self.offset - self.curve / 12.0 * (plan.walk * plan.velocity.float)
    }

    /// Sets the effect of the velocity on the beat.
    pub fn move_on(&mut self, plan: &FramePlan) {
        let velocity = self.turns(plan) * plan.velocity.float;
        // The velocity gained from chirp to chirp, whose Doppler shift moves the beat, too.
        let chirps = plan.chirps as f32;
        let gain = 2.0 * self.curve / (chirps * chirps) * plan.velocity.float;
        self.walk = plan.walk * velocity - gain / plan.shift.float * plan.n as f32;
        self.bend = plan.bend * velocity;
        // A bend that leaves less than -85 dB of the echo.
        if self.bend.abs() < 2e-4 {
            self.bend = 0.0;
        }
    }

    /// The phases of the chirps relative to the middle's.
    pub fn phases(&self, plan: &FramePlan) -> Phases {
        let (chirps, number) = (plan.chirps as i32, plan.chirps as f32);
        let step = circle::<f32>(self.row, chirps) * f32::unit(self.turn / number);
        let phase = circle::<f32>(-self.row * (chirps - 1), 2 * chirps)
            * f32::unit(-0.5 * self.turn * (number - 1.0) / number);
        let straight = Phases { phase, step, twist: Complex::new(1.0, 0.0) };
        if self.curve == 0.0 {
            return straight;
        }
        let Phases { phase, step, twist } = self.curves(plan);
        Phases { phase: straight.phase * phase, step: straight.step * step, twist }
    }

    /// The part of the curve in [`Echo::phases`].
    pub fn curves(&self, plan: &FramePlan) -> Phases {
        let chirps = plan.chirps as f32;
        let first = -0.5 * (chirps - 1.0) / chirps;
        Phases {
            phase: f32::unit(self.curve * (first * first - 1.0 / 12.0)),
            step: f32::unit(self.curve * (2.0 * first + 1.0 / chirps) / chirps),
            twist: f32::unit(2.0 * self.curve / (chirps * chirps)),
        }
    }

    /// The echo's share in a bin of a chirp at this distance from the middle, for the amplitude 1 and without the turn over the chirps.
    pub fn line(&self, plan: &FramePlan, bin: i32, place: f32) -> Complex<f32> {
        kernel(plan.n, bin.wrapping_sub(self.peak), self.offset + self.walk * place, self.bend)
    }

    /// The echo's mirror image there, of a real record; its amplitude is conjugated.
    pub fn image(&self, plan: &FramePlan, bin: i32, place: f32) -> Complex<f32> {
        kernel(plan.n, bin.wrapping_add(self.peak), -self.offset - self.walk * place, -self.bend)
    }
}

/// An echo's share in one bin over the chirps, where its beat walks little: a parabola through the first, the middle and the last chirp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    middle: Complex<f32>,
    slope: Complex<f32>,
    bend: Complex<f32>,
}

impl Share {
    /// Up to this walk within a frame, bins, a parabola is right to 74 dB.
    const MOST: f32 = 0.1;

    /// Of `line` or `image`; `None` for a beat that walks farther.
    pub fn new(echo: &Echo, plan: &FramePlan, value: impl Fn(f32) -> Complex<f32>) -> Option<Self> {
        let chirps = plan.chirps as f32;
        if echo.walk.abs() * chirps > Self::MOST {
            return None;
        }
        let end = 0.5 * (chirps - 1.0);
        let [first, middle, last] = [-end, 0.0, end].map(value);
        let slope = (last - first) / (2.0 * end);
        let bend = (last + first - middle * 2.0) / (2.0 * end * end);
        Some(Self { middle, slope, bend })
    }

    /// The share in a chirp at this distance from the middle.
    pub fn at(&self, place: f32) -> Complex<f32> {
        self.middle + (self.slope + self.bend * place) * place
    }
}

/// A bin of a tone of amplitude 1 and phase 0 in the middle of `n` samples, `i` bins from the tone's peak, from which the tone is `offset`
/// bins. The bin's phase belongs to the middle as well. The frequency rises by `bend` bins within the record:
///
/// ```text
/// sum exp(j (2 pi u x + pi bend x^2)),   x = -1/2 .. 1/2,   u = offset - i
/// ```
pub(super) fn kernel(n: usize, i: i32, offset: f32, bend: f32) -> Complex<f32> {
    let n = n as f32;
    let u = offset - i as f32;
    let sine = if i & 1 == 0 { f32::unit(0.5 * offset).im } else { -f32::unit(0.5 * offset).im };
    let y = PI * u / n;
    let straight = if u.abs() < 1e-3 {
        n
    } else if y.abs() <= FRAC_PI_4 {
        sine / (y * sinc(y * y))
    } else {
        sine / f32::unit(0.5 * u / n).im
    };
    if bend == 0.0 {
        return Complex::new(straight, 0.0);
    }
    let x = PI * u;
    let square = x * x;
    // The integrals of x^2 and x^4 times the cosine.
    let (second, fourth) = if u.abs() < 0.6 {
        (
            1.0 / 12.0 - square * (1.0 / 40.0 - square * (1.0 / 672.0 - square / 25_920.0)),
            1.0 / 80.0 - square * (1.0 / 224.0 - square / 3_456.0),
        )
    } else {
        let cosine =
            if i & 1 == 0 { f32::unit(0.5 * offset).re } else { -f32::unit(0.5 * offset).re };
        let y = 1.0 / x;
        let second = 0.25 * y * (sine + 2.0 * y * (cosine - sine * y));
        (
            second,
            0.0625
                * y
                * (sine + 4.0 * y * (cosine - y * (3.0 * sine + 6.0 * y * (cosine - sine * y)))),
        )
    };
    let b = PI * bend;
    Complex::new(straight - 0.5 * b * b * n * fourth, b * n * second)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum that defines it.
    #[test]
    fn bins_of_a_bent_tone() {
        let n = 256;
        for bend in [0.0f32, 0.1, 0.3, -0.3] {
            for offset in [-0.5f32, -0.2, 0.0, 0.4, 2.7] {
                for i in -20..=20 {
                    let u = f64::from(offset) - f64::from(i);
                    let sum: Complex<f64> = (0..n)
                        .map(|k| {
                            let x = (f64::from(k) - 0.5 * f64::from(n - 1)) / f64::from(n);
                            f64::unit(u * x + 0.5 * f64::from(bend) * x * x)
                        })
                        .sum();
                    let found = kernel(n as usize, i, offset, bend);
                    let off = Complex::new(f64::from(found.re), f64::from(found.im)) - sum;
                    // The third order is left out.
                    let least = 2e-3
                        + 0.05 * f64::from(bend.abs()).powi(3) * 256.0
                        + 4e-3 * f64::from(bend.abs());
                    assert!(off.norm_sqr().sqrt() < least, "{bend} {offset} {i}: {off} {found}");
                }
            }
        }
    }
}

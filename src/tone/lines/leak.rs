//! The leakage of tones into the second differences of bins, which are Hann's window.
//!
//! With c a tone's line and d its offset, half the second difference around a bin x bins from the tone is `c sin(pi d) / (pi x (x^2 - 1))`,
//! which falls by 18 dB an octave (see [`super::super::noise::ring`]). So a tone reaches at most [`LEAKS`] bins, and a weak tone fewer.

use super::super::noise::own::{EACH, Stretch};
use super::rest::Found;
use super::{Hunt, ROOM};
use crate::list::first;
use crate::math::scalar::Scalar as _;
use crate::math::series::line_shape;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::Layout;
use crate::tone::fit::Fit;
use core::mem::MaybeUninit;
use heapless::Vec;
use num_complex::Complex;

/// A tone leaks into second differences up to this many bins away: beyond by less than -100 dB.
pub(super) const LEAKS: i32 = 32;

/// A weak tone's leakage is below the noise beyond this distance.
const LEAST: i32 = 8;

/// The most differences that are taken at once.
pub(super) const CHUNK: usize = 32;

/// A tone is taken to be at least this far off its bin: exactly on the bin, its leakage there would be 0/0.
const LEAST_OFFSET: f32 = 1e-4;

/// The leakage of a tone, or of a real tone's image, into second differences of bins.
#[derive(Clone, Copy)]
pub(super) struct Leak {
    /// The tone's own bin.
    pub tone: i32,
    peak: i32,
    offset: f32,
    /// `line sin(pi d) / pi`.
    value: Complex<f32>,
    reach: i32,
}

/// Half the second difference of three bins, whose parts leave headroom for the sum.
#[inline]
pub(super) fn bent([a, b]: Point, [c, d]: Point, [e, f]: Point) -> Point {
    let part = |before: i32, here: i32, after: i32| {
        (before >> 1).wrapping_add(after >> 1).wrapping_sub(here)
    };
    [part(a, c, e), part(b, d, f)]
}

impl Leak {
    pub fn from_fit(layout: &'static Layout, found: &Found, reach: i32) -> Self {
        let Fit { offset, line, .. } = found.fit;
        let offset = if offset.abs() < LEAST_OFFSET { LEAST_OFFSET } else { offset };
        // A real line and an I/Q line are turned by different angles.
        let angle = if layout.iq { offset * core::f32::consts::PI / layout.n as f32 } else { 0.0 };
        let value = line * Complex::new(1.0, angle) * (offset * line_shape(offset));
        Self { tone: found.peak, peak: found.peak, offset, value, reach }
    }

    /// The distance up to which the leakage of a tone whose strongest difference has this power exceeds a tenth of the power `floor`.
    pub fn reach(power: f32, floor: f32) -> i32 {
        let (mut reach, most) = (LEAST, power / floor);
        let sixth = |x: i32| (x * x * x) as f32 * (x * x * x) as f32;
        while reach < LEAKS && sixth(reach) < most {
            reach += reach / 4;
        }
        reach.min(LEAKS)
    }

    /// The image of a real tone, if it reaches the spectrum.
    pub fn image(&self, layout: &'static Layout) -> Option<Self> {
        let (n, peak) = (layout.n as i32, self.peak);
        let low = peak < n / 4;
        let near = if low { peak } else { n / 2 - peak };
        (!layout.iq && near <= LEAKS).then_some(Self {
            tone: peak,
            peak: if low { -peak } else { n - peak },
            offset: -self.offset,
            value: -self.value.conj(),
            reach: LEAKS,
        })
    }

    /// Bins from `first` to the tone, the short way.
    fn from(&self, layout: &'static Layout, first: i32) -> i32 {
        let (n, apart) = (layout.n as i32, self.peak.wrapping_sub(first));
        if layout.iq {
            return (apart + n / 2).checked_rem_euclid(n).unwrap_or(0) - n / 2;
        }
        apart
    }

    /// Whether the leakage reaches any of the `count` bins from `first` on.
    pub fn reaches(&self, layout: &'static Layout, first: i32, count: i32) -> bool {
        let half = count / 2;
        self.from(layout, first + half).abs() <= self.reach + half
    }

    /// Subtracts the leakage from the differences around the bins from `first` on.
    fn take(&self, layout: &'static Layout, first: i32, differences: &mut [Complex<f32>]) {
        let mut x = self.from(layout, first) as f32 + self.offset;
        let Complex { re, im } = self.value;
        for difference in differences {
            let tail = 1.0 / (x * (x * x - 1.0));
            difference.re -= re * tail;
            difference.im -= im * tail;
            x -= 1.0;
        }
    }
}

/// A leak at its distance from a bin, in units of `1 / scale` codes.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    away: i32,
    offset: f32,
    value: Complex<f32>,
    reach: i32,
}

impl Seen {
    /// Subtracts the leakage from the differences of a stretch whose first difference is this many bins from the bin.
    pub fn take(&self, first: i32, stretch: &mut Stretch) {
        /// From the first difference of a stretch to the middle.
        const HALF: i32 = EACH as i32 - 1;
        let away = self.away - first;
        if (away - HALF).abs() > self.reach + HALF {
            return;
        }
        let mut x = away as f32 + self.offset;
        for [re, im] in stretch {
            let tail = 1.0 / (x * (x * x - 1.0));
            *re -= self.value.re * tail;
            *im -= self.value.im * tail;
            x -= 2.0;
        }
    }
}

impl Hunt<'_> {
    /// The leakage of all tones but the one at this bin into the differences up to `reach` from the bin.
    pub(super) fn others_near(&self, peak: i32, reach: i32) -> Vec<Seen, { 2 * ROOM }> {
        let scale = f32::two_to(-self.rest.view.exponent);
        let others = self.leaks.iter().filter(|leak| leak.tone != peak);
        let near = others.filter(|leak| leak.reaches(self.layout, peak - reach, 2 * reach + 1));
        first(near.map(|leak| {
            let &Leak { offset, value, reach, .. } = leak;
            Seen { away: leak.from(self.layout, peak), offset, value: value * scale, reach }
        }))
    }

    /// The bins that are needed for `count` second differences from `first` on.
    pub(super) fn near<'p>(
        &self,
        first: i32,
        count: usize,
        places: &'p mut [MaybeUninit<Point>],
    ) -> &'p [Point] {
        self.rest.view.fill(first - 1, places.get_mut(..count + 2).unwrap_or_default())
    }

    /// Subtracts the tones' leakage from half the second differences around the bins from `first` on: `c sin(pi d) / (pi x (x^2 - 1))`, see
    /// [`super::noise::ring`].
    pub(super) fn less_leaks(&self, first: i32, differences: &mut [Complex<f32>]) {
        for leak in &self.leaks {
            if leak.reaches(self.layout, first, differences.len() as i32) {
                leak.take(self.layout, first, differences);
            }
        }
    }

    /// Half the second differences of neighbouring points, in codes.
    pub(super) fn bend<const ROOM: usize>(
        &self,
        points: &[Point],
        differences: &mut Vec<Complex<f32>, ROOM>,
    ) {
        differences.clear();
        let unit = self.rest.unit;
        let [Some(&before), Some(&here)] = [points.first(), points.get(1)] else { return };
        let (mut before, mut here) = (before, here);
        for &after in points.get(2..).unwrap_or_default() {
            let [re, im] = bent(before, here, after);
            if differences.push(Complex::new(re as f32 * unit, im as f32 * unit)).is_err() {
                return;
            }
            (before, here) = (here, after);
        }
    }

    /// The power of the difference around bin `k`.
    pub(super) fn power(&self, k: i32) -> f32 {
        let mut differences = Vec::<_, 1>::new();
        self.bend(self.near(k, 1, &mut [MaybeUninit::uninit(); 3]), &mut differences);
        self.less_leaks(k, &mut differences);
        differences.first().map_or(0.0, Complex::norm_sqr)
    }

    /// Computes the leakage of the tones as fitted now.
    pub(super) fn leak(&mut self) {
        self.leaks.clear();
        for (found, mark) in self.rest.found.iter().zip(&self.marks) {
            let leak = Leak::from_fit(self.layout, found, mark.reach);
            // There is room for two leaks of each tone.
            let _ = self.leaks.push(leak);
            if let Some(image) = leak.image(self.layout) {
                let _ = self.leaks.push(image);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::fit::Model;

    /// The power of a difference falls with the sixth power of its distance.
    #[test]
    fn a_stronger_tone_reaches_farther() {
        for (away, reach) in [(1.0f32, 8), (7.9, 8), (9.0, 10), (14.0, 15), (20.0, 22), (99.0, 32)]
        {
            assert_eq!(Leak::reach(away.powi(6), 1.0), reach, "{away}");
        }
    }

    /// Half the second differences of a line that is exactly on its bin: the whole line there, half of it beside, nothing else.
    #[test]
    fn a_tone_just_on_its_bin_leaks_into_that_alone() {
        let (zero, line) = (Complex::new(0.0, 0.0), Complex::new(1000.0, 0.0));
        let fit = Fit {
            offset: 0.0,
            line,
            information: 1.0,
            peak: line,
            lever: zero,
            residual: 0.0,
            dof: 31,
            rest: crate::tone::fit::Rest::none(),
        };
        let found = Found { peak: 100, fit, model: Model::new(&fit, 100, 1024) };
        let mut differences = [zero; 9];
        let layout = Layout::of::<crate::Real, 1024>();
        Leak::from_fit(layout, &found, LEAKS).take(layout, 96, &mut differences);
        for (k, difference) in (96..).zip(differences) {
            let expected = [1000.0, -500.0, 0.0, 0.0, 0.0][usize::abs_diff(k, 100)];
            // The distance loses digits so near a bin.
            assert!((difference.re - expected).abs() < 2.0, "{k}: {difference}");
        }
    }
}

//! The user's settings. One check turns them into a plan, and nothing after that check can fail.

use crate::acquire::codes::Codes;
use crate::acquire::sample::{Record, Segment};
use crate::carrier::{Carrier, Width};
pub use crate::error::ConfigError;
use crate::math::scalar::cosine;
use crate::methods::registry::Method;
use crate::plan::{Plan, Solver, Terms};
use crate::solve::bounds::Bounds;
use crate::solve::chirp::{Mixing, Scale};
use crate::solve::equations::{Chirp, Equations};
use crate::solve::motion::{CALM, gain};
use crate::solve::track::Tracking;
use crate::solve::tracks::APART;
pub use crate::solve::waveform::SPEED_OF_LIGHT;
use crate::spectrum::neighbourhood::has_ring;
use crate::spectrum::peak::Band;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::effort::Effort;
use crate::tone::fit::Reach;
use crate::tone::lines::MOST;
use crate::tone::options::Options;
use crate::tone::threshold::{FALSE_ALARM, Threshold};
use core::ops::RangeInclusive;

/// The source of the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, rename_all = "snake_case"))]
pub enum Scene {
    /// A tone and no more: the answer is a frequency.
    #[default]
    Tone,
    /// Light, radio or sound scattered by a moving target: the answer is a velocity.
    Doppler {
        /// Wavelength in metres.
        wavelength_m: f64,
        /// Angle between beam and motion, radians; below a right angle.
        angle_rad: f64,
        /// The signal that the receiver conjugates. It matters for I/Q records alone; the default is [`Mixing::RxConjTx`], by which a
        /// positive shift approaches.
        #[cfg_attr(feature = "serde", serde(default = "crate::stored::usual_mixing"))]
        mixing: Mixing,
    },
    /// A frequency-modulated continuous wave: the answer is a range and a velocity.
    Chirp(Chirp),
}

impl Scene {
    /// The segments of a chirp, in order; empty for the other scenes.
    pub const fn segments(&self) -> &'static [Segment] {
        match self {
            Scene::Tone | Scene::Doppler { .. } => &[],
            Scene::Chirp(Chirp { shape, .. }) => shape.segments(),
        }
    }
}

/// The user's settings. [`Config::plan`] checks them and turns them into a [`Plan`].
///
/// ```
/// use picket_dsp::{Codes, Config, ConfigError, Mixing, Pipeline, Real, Scene};
///
/// // An infrared beam on a moving target: 14 bits at 2 MS/s, and 50 to 800 kHz to search.
/// let (wavelength_m, angle_rad, mixing) = (1550e-9, 0.0, Mixing::RxConjTx);
/// let config = Config {
///     scene: Scene::Doppler { wavelength_m, angle_rad, mixing },
///     band_hz: Some((50e3, 800e3)),
///     ..Config::new(2e6, Codes::signed::<14>())
/// };
/// let pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
/// assert_eq!(pipeline.plan().rate_hz, 2e6);
/// // What cannot work is an error: here a band beyond half of the rate.
/// let wrong = Config { band_hz: Some((50e3, 1.2e6)), ..config };
/// assert_eq!(wrong.plan::<Real, 1024>(), Err(ConfigError::Band));
/// # Ok::<(), ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Config {
    /// Sample rate, 1e-6 to 1e12 Hz.
    pub rate_hz: f64,
    /// The converter's codes.
    pub codes: Codes,
    /// The band to search, `(low, high)` in Hz, both ends included; `None` for the whole spectrum.
    /// An I/Q band may be negative.
    #[cfg_attr(feature = "serde", serde(default))]
    pub band_hz: Option<(f64, f64)>,
    /// The ranges that a chirp's target may have, `(low, high)` in metres; `None` if nothing is known of them.
    #[cfg_attr(feature = "serde", serde(default))]
    pub range_m: Option<(f64, f64)>,
    /// The velocities that a chirp's target may have, `(low, high)` in m/s, positive when approaching; `None` if nothing is known of them.
    /// A bound decides where the waveform leaves several targets: without it a sawtooth's range is [`Verdict::Ambiguous`], and so is the
    /// first chirp of a triangle with real samples.
    ///
    /// [`Verdict::Ambiguous`]: crate::Verdict::Ambiguous
    #[cfg_attr(feature = "serde", serde(default))]
    pub velocity_mps: Option<(f64, f64)>,
    /// The method of estimation. Least squares has two forms, one for each kind of record; either
    /// name selects the form that fits the record.
    #[cfg_attr(feature = "serde", serde(default))]
    pub method: Method,
    /// The number of bins on each side that least squares reads.
    #[cfg_attr(feature = "serde", serde(default))]
    pub reach: Reach,
    /// The arithmetic of least squares.
    #[cfg_attr(feature = "serde", serde(default))]
    pub arithmetic: Arithmetic,
    /// The effort spent on a line that is not a steady tone.
    #[cfg_attr(feature = "serde", serde(default))]
    pub effort: Effort,
    /// Probability that noise alone passes for a tone, for each block: above 0, at most 0.5.
    #[cfg_attr(feature = "serde", serde(default = "crate::stored::usual_false_alarm"))]
    pub false_alarm: f64,
    /// The source of the samples.
    #[cfg_attr(feature = "serde", serde(default))]
    pub scene: Scene,
    /// The way in which a [`crate::tracker::Tracker`] follows tones: [`Following::default`] follows one.
    #[cfg_attr(feature = "serde", serde(default = "crate::stored::none_followed"))]
    pub following: Following,
    /// The width of the tone itself.
    #[cfg_attr(feature = "serde", serde(default))]
    pub carrier: Carrier,
}

/// The parameters of following tones from block to block. How a target moves is learnt, see [`crate::solve::track`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Following {
    /// Sigma of a new target's rate, bins per block, 1e-6 to 4096.
    pub rate_bins: f32,
    /// The most tones followed at once: 0 to 4. With 0, as in [`Following::NONE`], a tracker is a pipeline.
    pub most: u8,
    /// Locked tracking (see [`crate::tone::zoomed`]): one block in `refresh` is searched whole,
    /// and the others are measured only where the tone is expected. With 0 or 1, or with more than
    /// one tone to follow, every block is searched.
    pub refresh: u8,
}

impl Default for Following {
    fn default() -> Self {
        Self { most: 1, ..Self::NONE }
    }
}

impl Following {
    /// No tone is followed.
    pub const NONE: Self = Self { rate_bins: 2.0, most: 0, refresh: 0 };
}

impl Config {
    /// A configuration for this rate in Hz and these codes: one tone anywhere, by least squares with [`Reach::Sixteen`] in the core's own
    /// arithmetic, at the effort of its core, with one false alarm in a million blocks of noise, no solver, and no tone followed.
    pub fn new(rate_hz: f64, codes: Codes) -> Self {
        Self {
            rate_hz,
            codes,
            band_hz: None,
            range_m: None,
            velocity_mps: None,
            method: Method::default(),
            reach: Reach::default(),
            arithmetic: Arithmetic::default(),
            effort: Effort::default(),
            false_alarm: FALSE_ALARM,
            scene: Scene::Tone,
            following: Following::NONE,
            carrier: Carrier::default(),
        }
    }
}

impl Config {
    /// Checks the whole configuration for records of kind `R` and `N` samples.
    ///
    /// # Errors
    /// A value is out of its range, or contradicts another.
    pub fn plan<R: Record, const N: usize>(&self) -> Result<Plan<R, N>, ConfigError> {
        Plan::from_terms(self.terms::<R>(N)?)
    }

    /// The terms of a plan whose length is known only at run time: at most 2^22 samples. Lengths other than 64, 128, ... 4096 need a
    /// transform of the caller's own.
    ///
    /// # Errors
    /// The errors of [`Config::plan`], and a length out of this range.
    pub fn terms<R: Record>(&self, n: usize) -> Result<Terms, ConfigError> {
        if !(1..=1 << 22).contains(&n) {
            return Err(ConfigError::Length);
        }
        if !RATES_HZ.contains(&self.rate_hz) {
            return Err(ConfigError::Rate);
        }
        let method = self.method.from_kind::<R>();
        if !method.fits::<R>() {
            return Err(ConfigError::Method);
        }
        self.terms_of(n, R::IQ, method)
    }

    /// The terms of either kind of record. A program that measures both holds this function once.
    #[inline(never)]
    fn terms_of(&self, n: usize, iq: bool, method: Method) -> Result<Terms, ConfigError> {
        if !(self.false_alarm > 0.0 && self.false_alarm <= 0.5) {
            return Err(ConfigError::FalseAlarm);
        }
        let band = self.band(n, iq)?;
        let width = self.carrier.width(n, self.rate_hz).ok_or(ConfigError::Carrier)?;
        let threshold = Threshold::new(band.width(), self.false_alarm);
        let threshold = if has_ring(n, iq) { threshold.with_another() } else { threshold };
        Ok(Terms {
            n: n as u32,
            iq,
            rate_hz: self.rate_hz,
            codes: self.codes,
            band,
            options: Options {
                method,
                reach: self.reach,
                arithmetic: self.arithmetic,
                threshold,
                effort: self.effort,
                width,
            },
            solver: self.solver(n, iq)?,
            tracking: self.tracking(n, iq, &threshold, &width)?,
        })
    }

    fn tracking(
        &self,
        n: usize,
        iq: bool,
        threshold: &Threshold,
        width: &Width,
    ) -> Result<Tracking, ConfigError> {
        let Following { rate_bins, most, refresh } = self.following;
        // The square of a rate is a variance, which must neither overflow nor vanish.
        if !((1e-6..=4096.0).contains(&rate_bins) && usize::from(most) <= MOST) {
            return Err(ConfigError::Following);
        }
        let bin = 1.0 / n.max(1) as f32;
        Ok(Tracking {
            rate: rate_bins * bin,
            signed: iq,
            // A real tone has half of its power in its bin, the other half in the mirror image's.
            evident: threshold.least_power() * bin * if iq { 1.0 } else { 2.0 },
            apart: APART * bin,
            envelope: width.followed(gain(CALM)) * bin * bin,
            stated: 2.0 * width.envelope * bin * bin,
            most: usize::from(most),
            refresh,
        })
    }

    fn band(&self, n: usize, iq: bool) -> Result<Band, ConfigError> {
        let whole = if iq { Band::iq(n) } else { Band::real(n) };
        let Some((low, high)) = self.band_hz else {
            return Ok(whole);
        };
        let half = self.rate_hz / 2.0;
        let least = if iq { -half } else { 0.0 };
        if !(low >= least && low < high && high <= half) {
            return Err(ConfigError::Band);
        }
        let bin = n as f64 / self.rate_hz;
        let band = Band::new(libm::ceil(low * bin) as i32, libm::floor(high * bin) as i32);
        let band =
            if iq { band } else { Band::new(band.low.max(whole.low), band.high.min(whole.high)) };
        if band.width() == 0 {
            return Err(ConfigError::Band);
        }
        Ok(band)
    }

    fn solver(&self, n: usize, iq: bool) -> Result<Solver, ConfigError> {
        match self.scene {
            Scene::Tone => Ok(Solver::None),
            Scene::Doppler { wavelength_m, angle_rad, mixing } => {
                let cos = beam_cosine(wavelength_m, angle_rad)?;
                // An approaching target shortens the delay.
                let sign = if iq { -f64::from(mixing.sign()) } else { 1.0 };
                let scale = Scale::new(sign * self.rate_hz * wavelength_m / (2.0 * cos));
                Ok(Solver::Doppler(scale.ok_or(ConfigError::Scale)?))
            }
            Scene::Chirp(ref chirp) => {
                let equations = chirp.equations(self.rate_hz, n, iq)?;
                let bounds = Bounds::new(self.range_m, self.velocity_mps);
                let bounds = bounds.ok_or(ConfigError::Bounds)?;
                Ok(Solver::Chirp(Equations { bounds, ..equations }))
            }
        }
    }
}

/// The cosine of the angle between beam and motion, of a Doppler scene that can be.
pub(crate) fn beam_cosine(wavelength_m: f64, angle_rad: f64) -> Result<f64, ConfigError> {
    // The cosine of at most a right angle, by half the angle: a library's cosine of any angle takes 3 KB on a core without a double FPU.
    let acute = angle_rad.abs() <= core::f64::consts::FRAC_PI_2;
    let half = cosine(0.25 * angle_rad * angle_rad);
    let cos = 2.0 * half * half - 1.0;
    let right = positive(wavelength_m) && acute && cos > 1e-6;
    if right { Ok(cos) } else { Err(ConfigError::Scene) }
}

/// Rates for which no scale of frequencies, ranges or velocities overflows.
const RATES_HZ: RangeInclusive<f64> = 1e-6..=1e12;

fn positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::{Iq, Real};

    /// Bands of rates near the ends of a float once overflowed, and gave more bins than there are.
    #[test]
    fn a_band_never_holds_more_than_the_spectrum() {
        for rate_hz in [1e-300, 1e-291, 1e-6, 1.0, 1e12, 1e300, f64::MAX, f64::NAN, -1.0] {
            let half = rate_hz / 2.0;
            for band_hz in [None, Some((-half, half)), Some((0.0, half)), Some((0.3 * half, half))]
            {
                let config = Config { band_hz, ..Config::new(rate_hz, Codes::signed::<12>()) };
                if let Ok(terms) = config.terms::<Iq>(1024) {
                    assert!((1..=1025).contains(&terms.band.width()), "{rate_hz} {band_hz:?}");
                }
                if let Ok(terms) = config.terms::<Real>(1024) {
                    assert!((1..=511).contains(&terms.band.width()), "{rate_hz} {band_hz:?}");
                }
            }
        }
        let slow = Config::new(1e-291, Codes::signed::<12>());
        assert_eq!(slow.terms::<Iq>(1024), Err(ConfigError::Rate));
    }

    /// A velocity without a step once had a sigma of NaN.
    #[test]
    fn a_scale_below_the_least_step_is_refused() {
        let of = |wavelength_m| {
            let mixing = Mixing::RxConjTx;
            let scene = Scene::Doppler { wavelength_m, angle_rad: 0.0, mixing };
            let config = Config { scene, ..Config::new(1e3, Codes::signed::<12>()) };
            config.terms::<Real>(1024).map(|_| ())
        };
        assert_eq!(of(1e-12), Ok(()));
        for wavelength_m in [1e-14, 1e-60, 1e8] {
            assert_eq!(of(wavelength_m), Err(ConfigError::Scale), "{wavelength_m}");
        }
    }

    /// By the library's cosine, which takes any angle.
    #[test]
    fn a_beam_across_the_motion_has_the_velocity_of_its_angle() {
        let of = |angle_rad: f64| {
            let mixing = Mixing::RxConjTx;
            let scene = Scene::Doppler { wavelength_m: 1e-3, angle_rad, mixing };
            let config = Config { scene, ..Config::new(1e3, Codes::signed::<12>()) };
            config.terms::<Real>(1024).map(|terms| terms.solver)
        };
        for step in -157..=157 {
            let angle = f64::from(step) / 100.0;
            let exact = 1.0 / (2.0 * libm::cos(angle));
            let Ok(Solver::Doppler(scale)) = of(angle) else { panic!("{angle}") };
            let found = scale.fixed.to_num::<f64>();
            // In steps of 2^-32, by a cosine within 4e-15.
            let error = 3e-10 + 4e-15 / libm::cos(angle) * exact;
            assert!((found - exact).abs() < error, "{angle}: {found}, {exact}");
        }
        for angle in [core::f64::consts::FRAC_PI_2, 1.571, -1.6, 3.1, 7.0, f64::NAN, f64::INFINITY]
        {
            assert_eq!(of(angle), Err(ConfigError::Scene), "{angle}");
        }
    }

    #[test]
    fn following_is_refused_where_a_variance_would_overflow() {
        let config = Config::new(1e3, Codes::signed::<12>());
        let with = |rate_bins| {
            let following = Following { rate_bins, ..Following::default() };
            Config { following, ..config }.terms::<Real>(1024).map(|_| ())
        };
        assert_eq!(with(2.0), Ok(()));
        for rate in [1e30, 1e-30, 0.0, -1.0, f32::NAN] {
            assert_eq!(with(rate), Err(ConfigError::Following));
        }
    }
}

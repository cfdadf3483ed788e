//! The plan of a frame: its chirps, its band, and the numbers that follow from the waveform.

use super::echo::Echo;
use super::fit::REACH;
use crate::error::ConfigError;
use crate::solve::bounds::Bounds;
use crate::solve::equations::Chirp;
use crate::solve::waveform::{SPEED_OF_LIGHT, Scale, Shape};
use crate::spectrum::fft::twiddle::supported;
use core::ops::RangeInclusive;

/// The fewest and the most chirps of a frame.
pub const CHIRPS: RangeInclusive<usize> = 8..=256;

/// A velocity is on its bound within this share of the way to the next alias.
pub(super) const ON_BOUND: f32 = 0.01;

/// The most aliases that bounds of the velocity may hold.
pub const ALIASES: usize = 31;

/// The aliases that are weighed without bounds of the velocity: the slowest and its neighbours.
pub const FREE_ALIASES: usize = 3;

/// The most aliases that are weighed: one on each end.
pub(super) const MOST_ALIASES: usize = ALIASES + 1;

/// The user's settings of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameConfig {
    /// The waveform: a sawtooth.
    pub chirp: Chirp,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Samples of a chirp's record: 64, 128, ... 4096.
    pub n: usize,
    /// Whether the records are I/Q.
    pub iq: bool,
    /// Chirps in a frame: 8, 16, ... 256.
    pub chirps: usize,
    /// From one chirp to the next, s; at least the ramp.
    pub period_s: f64,
    /// The bins that are kept of each chirp, both ends included; of an I/Q record they may be negative. `None` for all bins with a range from
    /// 0 up.
    pub bins: Option<(i32, i32)>,
    /// The probability that noise alone shows a target, for each frame: above 0, at most 0.5.
    pub false_alarm: f64,
    /// The ranges that a target may have, m.
    pub range_m: Option<(f64, f64)>,
    /// The velocities that a target may have, m/s; positive when approaching. Without them a velocity is `ambiguous` unless the target's own
    /// movement during the frame decides between the aliases.
    pub velocity_mps: Option<(f64, f64)>,
}

impl FrameConfig {
    /// Frames of `chirps` chirps of `n` samples: all bins, one false alarm in a million frames, no bounds.
    pub fn new(
        chirp: Chirp,
        rate_hz: f64,
        n: usize,
        iq: bool,
        chirps: usize,
        period_s: f64,
    ) -> Self {
        let (bins, range_m, velocity_mps) = (None, None, None);
        Self {
            chirp,
            rate_hz,
            n,
            iq,
            chirps,
            period_s,
            bins,
            false_alarm: 1e-6,
            range_m,
            velocity_mps,
        }
    }

    /// Keeps the bins of a band, Hz, as far as a record has them.
    pub fn in_band(self, (low, high): (f64, f64)) -> Self {
        let bin = |hz: f64| hz / self.rate_hz * self.n as f64;
        let half = self.n as i32 / 2;
        let least = if self.iq { -half } else { 1 };
        let (first, last) = (libm::floor(bin(low)) as i32, libm::ceil(bin(high)) as i32);
        Self { bins: Some((least.max(first), (half - 1).min(last))), ..self }
    }

    /// Keeps the bins of [`FrameConfig::range_m`] alone, and beside them those that the fit of an echo reads. All bins without such ranges.
    ///
    /// # Errors
    /// Those of [`FrameConfig::plan`].
    pub fn in_ranges(self) -> Result<Self, ConfigError> {
        let all = Self { bins: None, ..self };
        let plan = all.plan()?;
        let Some((near, far)) = self.range_m else { return Ok(all) };
        let bounded = plan.bounds.limit_velocity();
        let half = 0.5 * plan.alias_mps();
        let velocities = if bounded { plan.bounds.velocity } else { [-half, half] };
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for range in [near, far] {
            for velocity in velocities {
                let cycles = range as f32 / plan.range.float - velocity / plan.shift.float;
                let bin = cycles * self.n as f32;
                (low, high) = (low.min(bin), high.max(bin));
            }
        }
        let (least, most) = (plan.first, plan.first + plan.bins as i32 - 1);
        let first = (libm::floorf(low) as i32).saturating_sub(REACH);
        let last = (libm::ceilf(high) as i32).saturating_add(REACH);
        Ok(Self { bins: Some((first.max(least), last.min(most))), ..all })
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// The errors of [`Chirp::equations`]; [`ConfigError::Frame`] for another number of chirps, a period shorter than the ramp, or a waveform
    /// that is no sawtooth; [`ConfigError::Bounds`] also for bounds that hold more than 31 aliases; [`ConfigError::Band`], and [`ConfigError::FalseAlarm`] as for a
    /// [`Config`](crate::Config).
    pub fn plan(&self) -> Result<FramePlan, ConfigError> {
        let Self { ref chirp, rate_hz, n, iq, chirps, period_s, false_alarm, .. } = *self;
        if !supported(n) {
            return Err(ConfigError::Length);
        }
        let usable = CHIRPS.contains(&chirps) && chirps.is_power_of_two();
        // A rounded period may fall short of the ramp by half a sample.
        let fits = (period_s - chirp.duration_s) * rate_hz > -0.5 && period_s.is_finite();
        if !(usable && fits && chirp.shape == Shape::Sawtooth) {
            return Err(ConfigError::Frame);
        }
        if !(false_alarm > 0.0 && false_alarm <= 0.5) {
            return Err(ConfigError::FalseAlarm);
        }
        let bounds = Bounds::new(self.range_m, self.velocity_mps).ok_or(ConfigError::Bounds)?;
        let equations = chirp.equations(rate_hz, n, iq)?;
        let sign = if iq { f64::from(chirp.mixing.sign()) } else { 1.0 };
        let half = n as i32 / 2;
        let whole = match (iq, sign > 0.0) {
            (false, _) | (true, true) => (1, half - 1),
            (true, false) => (1 - half, -1),
        };
        let (first, last) = self.bins.unwrap_or(whole);
        let least = if iq { -half } else { 1 };
        if !(least <= first && first < last && last < half) {
            return Err(ConfigError::Band);
        }
        let per_metre = 2.0 / SPEED_OF_LIGHT;
        let record_s = n as f64 / rate_hz;
        let middle_s = chirp.guard_s + 0.5 * (record_s - 1.0 / rate_hz);
        let middle = chirp.ramp(middle_s / chirp.duration_s);
        let scale = |per: f64| Scale::new(per).ok_or(ConfigError::Scale);
        // The beat's phase turns by -s V (2 / c) f from chirp to chirp.
        let velocity = scale(-sign / (per_metre * middle.carrier_hz * period_s))?;
        let walk = -sign * per_metre * middle.slope * period_s * record_s;
        let [slowest, fastest] = bounds.velocity;
        if bounds.limit_velocity() && (fastest - slowest) / velocity.float.abs() > ALIASES as f32 {
            return Err(ConfigError::Bounds);
        }
        Ok(FramePlan {
            n,
            iq,
            chirps,
            first,
            bins: (last - first) as usize + 1,
            rate_hz,
            false_alarm: false_alarm as f32,
            bounds,
            range: equations.range[0],
            velocity,
            shift: scale(sign * rate_hz / (per_metre * middle.carrier_hz))?,
            walk: walk as f32,
            bend: (-sign * 2.0 * per_metre * middle.slope * record_s * record_s) as f32,
            lower: (per_metre * middle.slope / middle.carrier_hz) as f32,
        })
    }
}

/// Checked settings of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePlan {
    pub(super) n: usize,
    pub(super) iq: bool,
    pub(super) chirps: usize,
    /// The first bin that is kept, and their number.
    pub(super) first: i32,
    pub(super) bins: usize,
    pub(super) rate_hz: f64,
    pub(super) false_alarm: f32,
    pub(super) bounds: Bounds,
    /// Metres for a cycle per sample.
    pub(super) range: Scale,
    /// Metres per second for a turn a chirp.
    pub(super) velocity: Scale,
    /// Metres per second for a cycle per sample of the Doppler shift within a chirp, positive if approaching lowers the beat.
    pub(super) shift: Scale,
    /// Bins by which the beat moves from chirp to chirp, for a metre per second.
    pub(super) walk: f32,
    /// Bins by which the beat rises within a chirp, for a metre per second.
    pub(super) bend: f32,
    /// The share by which an echo's carrier is lower, for a metre of range.
    pub(super) lower: f32,
}

impl FramePlan {
    /// The cells of a frame: one for each kept bin of each chirp. 64 chirps of 128 bins are 32 KB in cells of 16 bits.
    pub const fn cells(&self) -> usize {
        self.bins * self.chirps
    }

    /// The bins that are kept of each chirp.
    pub const fn bins(&self) -> usize {
        self.bins
    }

    /// The chirps of a frame.
    pub const fn chirps(&self) -> usize {
        self.chirps
    }

    /// From one alias of a velocity to the next, m/s: half a wavelength in a period.
    pub const fn alias_mps(&self) -> f32 {
        self.velocity.float.abs()
    }

    /// The samples of a chirp's record.
    pub const fn record(&self) -> usize {
        self.n
    }

    /// The first bin that is kept.
    pub const fn first(&self) -> i32 {
        self.first
    }

    /// The range, m, and the velocity, m/s, of a place in the map: a beat in bins, and the turns from chirp to chirp in units of 1/M. From
    /// -M/2 to M/2 it is the slowest alias.
    pub fn cell(&self, bin: f32, row: f32) -> [f32; 2] {
        let velocity = row / self.chirps as f32 * self.velocity.float;
        let beat = bin / self.n as f32 + velocity / self.shift.float;
        [beat * self.range.float, velocity]
    }

    /// The first and the last alias of an echo whose velocity is within the bounds; one on each side of the slowest where there are no bounds.
    pub(super) fn aliases(&self, echo: &Echo) -> [i32; 2] {
        let turns = echo.turns(self) - echo.alias as f32;
        let slowest = -libm::roundf(turns) as i32;
        if !self.bounds.limit_velocity() {
            let beside = FREE_ALIASES as i32 / 2;
            return [slowest - beside, slowest + beside];
        }
        let [a, b] = self.bounds.velocity.map(|end| end / self.velocity.float - turns);
        // A velocity on the bound is within it.
        let first = libm::ceilf(a.min(b) - ON_BOUND).max(-1e6) as i32;
        let last = libm::floorf(a.max(b) + ON_BOUND).min(1e6) as i32;
        // Bounds that are narrower than the way to the next alias may hold none: the target is unresolved in the end.
        if first > last {
            [first, first]
        } else {
            [first, last.min(first + MOST_ALIASES as i32 - 1)]
        }
    }

    /// The distance of a chirp from the frame's middle, chirps.
    pub(super) fn place(&self, chirp: usize) -> f32 {
        chirp as f32 - 0.5 * (self.chirps as f32 - 1.0)
    }
}

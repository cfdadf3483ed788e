//! What is known of a radar whose chirps were recorded, and how they lie in the recording and in frames: for the tool and for the page.

use crate::length;
use crate::recording::Recording;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::frame::{ALIASES, CHIRPS, FREE_ALIASES, FrameConfig, FramePlan};
use picket_dsp::tone::effort::Effort;
use picket_dsp::{Chirp, Mixing, Shape};

/// What is known of the radar.
#[derive(Clone, Copy, Debug)]
pub struct Radar {
    /// The ramps.
    pub shape: Shape,
    /// The carrier, Hz.
    pub carrier_hz: f64,
    /// What a ramp sweeps, Hz.
    pub bandwidth_hz: f64,
    /// How long, s.
    pub chirp_s: f64,
    /// The signal that the receiver conjugates.
    pub mixing: Mixing,
    /// The velocities that targets may have, m/s.
    pub velocity_mps: Option<(f64, f64)>,
    /// The effort for lines that are not steady tones.
    pub effort: Effort,
    /// The probability of a false alarm in a frame, where it is told.
    pub false_alarm: Option<f64>,
}

/// How the records lie in the ramps, in samples.
#[derive(Clone, Copy, Debug)]
pub struct Ramps {
    /// Samples of a record.
    pub n: usize,
    /// From one ramp's first sample in the recording to the next one's.
    pub hop: usize,
    /// Samples that are left out before each record.
    pub skip: usize,
}

/// How the chirps of a recording lie in frames.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Chirps of a frame.
    pub chirps: usize,
    /// Chirps between pauses; what does not fill a frame before a pause is left out.
    pub together: u64,
    /// From one chirp to the next, s.
    pub period_s: f64,
}

impl Radar {
    /// The metres that a hertz of beat is.
    pub fn metres_per_hertz(&self) -> f64 {
        SPEED_OF_LIGHT * self.chirp_s / (2.0 * self.bandwidth_hz)
    }

    /// A record is the end of its ramp, whose beginning settles; of records of their own it is their end.
    ///
    /// # Errors
    /// The ramps are shorter than a record, or do not repeat after a whole number of samples; an array whose axes nobody told looks
    /// transposed.
    pub fn ramps(
        &self,
        recording: &Recording,
        n: Option<usize>,
        period_s: Option<f64>,
        knows_axes: bool,
    ) -> Result<Ramps, String> {
        let rate_hz = recording.rate_hz();
        let ramp = (self.chirp_s * rate_hz).round() as usize;
        let row = recording.row().and_then(|row| usize::try_from(row).ok());
        if !knows_axes {
            self.check_axes(recording, ramp)?;
        }
        let hop = match (row, period_s) {
            (Some(row), _) => row,
            (None, None) => ramp,
            (None, Some(period_s)) => {
                let samples = period_s * rate_hz;
                if (samples - samples.round()).abs() > 1e-3 || samples < 1.0 {
                    return Err(format!(
                        "a period of {period_s} s has {samples:.3} samples at {rate_hz} Hz: chirps that begin between samples are no frame"
                    ));
                }
                samples.round() as usize
            }
        };
        let within = ramp.min(hop);
        let longest = || length::LENGTHS.into_iter().rev().find(|&n| n <= within);
        let n = n.or_else(longest).filter(|&n| n <= within).ok_or_else(|| {
            format!("a ramp of {} s has {ramp} samples at {rate_hz} Hz: give a longer --chirp-s, or --n 64", self.chirp_s)
        })?;
        length::check(n)?;
        Ok(Ramps { n, hop, skip: within - n })
    }

    /// Whether an array whose axes nobody told is another way round: as many chirps as a ramp has samples, and records that are much
    /// shorter than the ramp, or longer.
    fn check_axes(&self, recording: &Recording, ramp: usize) -> Result<(), String> {
        let sides = (recording.row(), recording.frame(), recording.axes());
        let (Some(samples), Some(chirps), Some(axes)) = sides else { return Ok(()) };
        let share = |side: u64| side as f64 / ramp as f64;
        let fills = |side: u64| (0.75..=1.0).contains(&share(side));
        if !fills(chirps) || (0.5..=1.0).contains(&share(samples)) {
            return Ok(());
        }
        let other = axes.exchanged();
        Err(format!(
            "a ramp of {} s has {ramp} samples at {} Hz, and the array {samples} times {chirps}: transposed, --axes {other}, or as it is, --axes {axes}",
            self.chirp_s,
            recording.rate_hz()
        ))
    }

    /// Whether the time from one chirp's start to the next's is known, with which velocities go.
    ///
    /// # Errors
    /// It is not told, and an array does not have it.
    pub fn check_period(&self, recording: &Recording, period_s: Option<f64>) -> Result<(), String> {
        if period_s.is_some() || recording.row().is_none() {
            return Ok(());
        }
        Err(format!(
            "an array does not say how long its chirps pause, and velocities need the time from one's start to the next's: add --period-s, {} s if they do not pause",
            self.chirp_s
        ))
    }

    /// The waveform, whose records begin where they lie in the recording's ramps or where that is told, with this curvature of its sweep.
    pub fn chirp(
        &self,
        rate_hz: f64,
        ramps: &Ramps,
        guard_s: Option<f64>,
        curvature: f64,
    ) -> Chirp {
        Chirp {
            shape: self.shape,
            wavelength_m: SPEED_OF_LIGHT / self.carrier_hz,
            bandwidth_hz: self.bandwidth_hz,
            duration_s: self.chirp_s,
            guard_s: guard_s.unwrap_or(ramps.skip as f64 / rate_hz),
            sweep_curvature: curvature,
            mixing: self.mixing,
        }
    }

    /// The frames in a recording: of an array those that its sides count, of another one those that are told. `None` where each chirp is to
    /// be measured by itself.
    pub fn layout(
        &self,
        recording: &Recording,
        chirps: Option<usize>,
        period_s: Option<f64>,
    ) -> Option<Layout> {
        let there = recording.frame().filter(|there| *there > 0);
        let rows = recording.row().and_then(|row| Some(recording.length()? / row.max(1)));
        let all = there.or(rows).unwrap_or(0);
        let fits = (all as usize).min(*CHIRPS.end()).checked_ilog2().map_or(0, |power| 1 << power);
        let chirps = chirps.unwrap_or(fits);
        if self.shape != Shape::Sawtooth || !CHIRPS.contains(&chirps) {
            return None;
        }
        Some(Layout {
            chirps,
            together: there.unwrap_or(u64::MAX),
            period_s: period_s.unwrap_or(self.chirp_s),
        })
    }

    /// The plan of its frames: of records of so many samples, I/Q or not, with the bins that are kept and the ranges that targets may have.
    ///
    /// # Errors
    /// In one line, what does not fit.
    pub fn plan(
        &self,
        rate_hz: f64,
        (n, iq): (usize, bool),
        chirp: &Chirp,
        layout: &Layout,
        band_hz: Option<(f64, f64)>,
        range_m: Option<(f64, f64)>,
    ) -> Result<FramePlan, String> {
        let usual = FrameConfig::new(*chirp, rate_hz, n, iq, layout.chirps, layout.period_s);
        let usual = band_hz.map_or(usual, |band| usual.in_band(band));
        let config = FrameConfig {
            false_alarm: self.false_alarm.unwrap_or(usual.false_alarm),
            range_m,
            velocity_mps: self.velocity_mps,
            ..usual
        };
        let alias_mps = layout.alias_mps(chirp);
        if let Some((low, high)) = config.velocity_mps
            && high - low > ALIASES as f64 * alias_mps
        {
            let held = (high - low) / alias_mps;
            return Err(format!(
                "these velocities hold {held:.0} aliases, and at most {ALIASES} are weighed: narrow --velocity-mps, or shorten the period"
            ));
        }
        config.plan().map_err(|error| error.to_string())
    }
}

impl Layout {
    /// From one alias of a velocity to the next: half a wavelength in a period.
    fn alias_mps(&self, chirp: &Chirp) -> f64 {
        0.5 * chirp.wavelength_m / self.period_s
    }

    /// What the numbers rest on, in a line; whether the period, the place in the ramp and the velocities are told.
    pub fn assumed(
        &self,
        recording: &Recording,
        ramps: &Ramps,
        chirp: &Chirp,
        [period, guard, velocity]: [bool; 3],
    ) -> String {
        let period = match period {
            true => "",
            false => {
                ", which is the ramp without a pause, and velocities go with it (--period-s says otherwise)"
            }
        };
        let aliases = match velocity {
            true => String::new(),
            false => format!(
                "; velocities are weighed at {FREE_ALIASES} aliases, {:.4} m/s apart, and odds are among these (--velocity-mps says otherwise)",
                self.alias_mps(chirp)
            ),
        };
        let guard = if guard { "" } else { " (--guard-s says otherwise)" };
        let left = match self.together % self.chirps as u64 {
            left @ 1.. if self.together < u64::MAX => format!(", the last {left} are left out"),
            _ => String::new(),
        };
        format!(
            "{}{} chirps a frame{left}; one each {:.6} us{period}; {} samples of a chirp, from {:.3} us into its ramp{guard}{aliases}",
            recording.assumed().map_or(String::new(), |assumed| assumed + "; "),
            self.chirps,
            1e6 * self.period_s,
            ramps.n,
            1e6 * chirp.guard_s,
        )
    }
}

//! The carrier of a Doppler radar: the speed of a shift.

use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::solve::chirp::Mixing;
use serde::Serialize;

/// What is known of a Doppler radar.
#[derive(Clone, Copy, Debug)]
pub struct Carrier {
    /// The carrier, Hz.
    pub hz: f64,
    /// Which of its two signals it conjugates. Real recordings do not show it.
    pub mixing: Mixing,
}

/// A speed along the beam. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Speed {
    /// The speed, positive when approaching; real recordings do not show its sign.
    pub speed_mps: f64,
    /// One standard deviation of it.
    pub sigma_speed_mps: Option<f64>,
}

impl Carrier {
    /// The speed of a shift.
    pub fn speed(&self, shift_hz: f64, sigma_hz: Option<f64>, iq: bool) -> Speed {
        let per_hertz = SPEED_OF_LIGHT / self.hz / 2.0;
        // An approaching target shortens the delay.
        let sign = if iq { -f64::from(self.mixing.sign()) } else { 1.0 };
        Speed {
            speed_mps: sign * shift_hz * per_hertz,
            sigma_speed_mps: sigma_hz.map(|sigma| sigma * per_hertz),
        }
    }
}

/// What stands above the last two columns of comma-separated values.
pub const CSV: &str = ",speed_mps,sigma_speed_mps";

/// What stands above two columns for people.
pub const TEXT: &str = "   speed m/s      sigma";

impl Speed {
    /// The last two of comma-separated values; nothing without a carrier.
    pub fn csv(speed: Option<Self>) -> String {
        let Some(Speed { speed_mps, sigma_speed_mps }) = speed else { return String::new() };
        let sigma = sigma_speed_mps.map_or(String::new(), |sigma| sigma.to_string());
        format!(",{speed_mps},{sigma}")
    }

    /// Two columns for people; nothing without a carrier.
    pub fn text(speed: Option<Self>) -> String {
        let Some(Speed { speed_mps, sigma_speed_mps }) = speed else { return String::new() };
        let sigma = sigma_speed_mps.map_or("-".into(), |sigma| format!("{sigma:.4}"));
        format!(" {speed_mps:>11.4} {sigma:>10}")
    }
}

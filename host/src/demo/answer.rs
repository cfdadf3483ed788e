//! What a demonstration measured of a target, and its form for machines.

use super::{DemoError, said};
use picket_dsp::Target;
use serde::Serialize;

/// A measured target.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Answer {
    /// Metres.
    pub range_m: f64,
    /// Metres per second, positive when approaching.
    pub velocity_mps: f64,
    /// One standard deviation.
    pub sigma_range_m: f64,
    /// One standard deviation.
    pub sigma_velocity_mps: f64,
    /// Whether it may be used.
    pub verdict: &'static str,
}

impl From<&Target> for Answer {
    fn from(target: &Target) -> Self {
        Answer {
            range_m: target.range.to_num(),
            velocity_mps: target.velocity.map_or(f64::NAN, |velocity| velocity.to_num()),
            sigma_range_m: target.sigma_range.into(),
            sigma_velocity_mps: target.sigma_velocity.into(),
            verdict: target.verdict.name(),
        }
    }
}

/// Prints a JSON line for each row, and one for all of them.
pub fn lines(rows: &[impl Serialize], summary: &impl Serialize) -> Result<(), DemoError> {
    for row in rows {
        outln!("{}", serde_json::to_string(row).map_err(said)?);
    }
    outln!("{}", serde_json::to_string(summary).map_err(said)?);
    Ok(())
}

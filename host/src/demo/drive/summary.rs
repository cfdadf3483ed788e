//! How near chirps alone and tracks came to the truth.

use super::{NEAR_M, NEAR_MPS, Row};
use crate::demo::answer::Answer;
use crate::scenario::drive::Scene;
use picket_dsp::tone::Verdict;
use serde::Serialize;

/// The drive as a whole.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Chirps.
    pub chirps: usize,
    /// Chirps in which the target was tracked.
    pub tracked: usize,
    /// Single answers with the verdict good that are more than two metres or 1 m/s off.
    pub single_wrong: usize,
    /// Tracked answers, of either car, with the verdict good that are as far from both.
    pub tracked_wrong: usize,
    /// Root mean square over the chirps where both are good and right.
    pub single_rms_range_m: f64,
    /// Root mean square of the tracks' range errors over these chirps.
    pub tracked_rms_range_m: f64,
    /// Root mean square of the single chirps' velocity errors.
    pub single_rms_velocity_mps: f64,
    /// Root mean square of the tracks' velocity errors.
    pub tracked_rms_velocity_mps: f64,
    /// The numbers of the target's tracks, in their order: a new one after each loss.
    pub numbers: Vec<u16>,
}

impl Summary {
    /// Of all chirps.
    pub fn of(rows: &[Row]) -> Self {
        let good = |answer: &Option<Answer>| answer.filter(|a| a.verdict == Verdict::Good.name());
        let at = |answer: &Answer, range_m: f64, velocity_mps: f64| {
            (answer.range_m - range_m).abs() < NEAR_M
                && (answer.velocity_mps - velocity_mps).abs() < NEAR_MPS
        };
        let right =
            |row: &Row, answer: &Answer| at(answer, row.truth_range_m, row.truth_velocity_mps);
        // A track outlives what it follows by some chirps, and says that it coasts then.
        let either = |row: &Row, answer: &Answer| {
            let other = Scene::at(row.time_s).other;
            right(row, answer) || other.is_some_and(|(range, speed)| at(answer, range, speed))
        };
        let single_wrong =
            rows.iter().filter(|row| good(&row.single).is_some_and(|a| !either(row, &a)));
        let tracked_wrong = rows.iter().flat_map(|row| row.targets.iter().map(move |t| (row, t.1)));
        let tracked_wrong =
            tracked_wrong.filter(|(row, a)| good(&Some(*a)).is_some_and(|a| !either(row, &a)));
        let mut squares = [0.0; 4];
        let mut count = 0.0;
        let mut numbers = Vec::new();
        for row in rows {
            if let Some(tracked) = row.tracked
                && let Some((number, _)) =
                    row.targets.iter().find(|t| t.1.range_m == tracked.range_m)
                && !numbers.contains(number)
            {
                numbers.push(*number);
            }
            let (Some(single), Some(tracked)) = (good(&row.single), good(&row.tracked)) else {
                continue;
            };
            if !right(row, &single) || !right(row, &tracked) {
                continue;
            }
            let errors = [
                single.range_m - row.truth_range_m,
                tracked.range_m - row.truth_range_m,
                single.velocity_mps - row.truth_velocity_mps,
                tracked.velocity_mps - row.truth_velocity_mps,
            ];
            squares.iter_mut().zip(errors).for_each(|(square, error)| *square += error * error);
            count += 1.0;
        }
        let [single_range, tracked_range, single_velocity, tracked_velocity] =
            squares.map(|square| (square / f64::max(count, 1.0)).sqrt());
        Summary {
            summary: true,
            chirps: rows.len(),
            tracked: rows.iter().filter(|row| row.tracked.is_some()).count(),
            single_wrong: single_wrong.count(),
            tracked_wrong: tracked_wrong.count(),
            single_rms_range_m: single_range,
            tracked_rms_range_m: tracked_range,
            single_rms_velocity_mps: single_velocity,
            tracked_rms_velocity_mps: tracked_velocity,
            numbers,
        }
    }
}

//! The errors of a table's rows as a picture: over the range, or over the speed.

use super::drive::save_both;
use super::options::Scenario;
use super::table::{Result as Row, Summary};
use super::{DemoError, said};
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use std::path::Path;

/// What the axes of an error are, the unit, and which error, truth and sigma of a row are shown.
struct Shown {
    name: &'static str,
    title: &'static str,
    x: Axis,
    y: &'static str,
    /// The axis' units in one metre or one metre per second.
    scale: f64,
    truth: fn(&Row) -> f64,
    error: fn(&Row) -> Option<(f64, f64)>,
    bar: f64,
}

impl Shown {
    fn chart(&self, summary: &Summary) -> Chart {
        let of = |wanted: bool| -> Vec<(f64, f64, f64)> {
            let rows = summary.results.iter().filter(|row| row.is_usable() == wanted);
            let seen = rows.filter_map(|row| Some(((self.truth)(row), (self.error)(row)?)));
            seen.map(|(at, (error, sigma))| (at, self.scale * error, self.scale * sigma)).collect()
        };
        let bar = self.scale * self.bar;
        // An answer that cannot be used may be off by any number: it does not stretch the axis.
        let usable = of(true);
        let most = usable.iter().map(|(_, error, sigma)| error.abs() + sigma).fold(bar, f64::max);
        let series = |label, colour, seen: &[(f64, f64, f64)]| {
            Series::new(label, Style::Points, colour, seen.iter().map(|s| (s.0, s.1)))
                .with_errors(seen.iter().map(|s| s.2))
        };
        let limit = |label, at: f64| {
            let ends = [(self.x.range.0, at), (self.x.range.1, at)];
            Series::new(label, Style::Dashed, 1, ends)
        };
        Chart {
            name: self.name,
            title: self.title.into(),
            x: self.x.clone(),
            y: Axis::linear(self.y, -1.2 * most, 1.2 * most),
            series: vec![
                series("not usable ± sigma", 6, &of(false)),
                series("usable ± sigma", 0, &usable),
                limit("+ the paper's accuracy", bar),
                limit("- the paper's accuracy", -bar),
            ],
        }
    }
}

fn velocity(row: &Row) -> Option<(f64, f64)> {
    Some((row.errors()?.1, row.answer?.sigma_velocity_mps))
}

/// Draws the lidar's errors over the range, those of its velocities beside it; the turntable's over the speed.
pub fn draw(
    summary: &Summary,
    scenario: Scenario,
    file: &Path,
    output: Output,
) -> Result<(), DemoError> {
    let bars = summary.bars;
    if scenario == Scenario::Turntable {
        let turntable = Shown {
            name: "turntable",
            title: "A turntable before a velocimeter: error of the rim's speed",
            x: Axis::linear("speed of the rim, m/s", -4.0, 4.0),
            y: "error, mm/s",
            scale: 1e3,
            truth: |row| row.truth.velocity_mps,
            error: velocity,
            bar: bars.velocity_mps,
        };
        return turntable.chart(summary).save(file, output).map_err(said);
    }
    let ranges = Shown {
        name: "lidar-range",
        title: "Targets before a lidar: error of the range",
        x: Axis::linear("range, m", 0.0, 120.0),
        y: "error, cm",
        scale: 100.0,
        truth: |row| row.truth.range_m,
        error: |row| Some((row.errors()?.0, row.answer?.sigma_range_m)),
        bar: bars.range_m,
    };
    let velocities = Shown {
        name: "lidar-velocity",
        title: "Targets before a lidar: error of the velocity",
        y: "error, km/h",
        scale: 3.6,
        error: velocity,
        bar: bars.velocity_mps,
        x: ranges.x.clone(),
        ..ranges
    };
    save_both(&ranges.chart(summary), &velocities.chart(summary), file, output)
}

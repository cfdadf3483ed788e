//! Truth beside measurement: the rows, their errors, and whether they lie inside the papers' bars.

use crate::scenario::{Bars, Row};
use comfy_table::{Cell, CellAlignment, Color, LineStyle, Table, TableStyle};
use picket_dsp::tone::Verdict;
use picket_dsp::{Mixing, Shape, Usable};
use serde::Serialize;
use std::io::IsTerminal;

/// What the firmware answered for a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Metres; 0 for the turntable.
    pub range_m: f64,
    /// Metres per second.
    pub velocity_mps: f64,
    /// One standard deviation, metres.
    pub sigma_range_m: f64,
    /// One standard deviation, metres per second.
    pub sigma_velocity_mps: f64,
    /// May it be used?
    pub verdict: Verdict,
}

/// A row and its answer, if a record of it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Result {
    /// The truth.
    pub truth: Row,
    /// The chirp's shape, where the table has several.
    pub shape: Option<Shape>,
    /// The measurement.
    pub answer: Option<Answer>,
}

impl Result {
    /// Errors in metres and metres per second.
    pub fn errors(&self) -> Option<(f64, f64)> {
        let answer = self.answer?;
        Some((answer.range_m - self.truth.range_m, answer.velocity_mps - self.truth.velocity_mps))
    }

    /// Whether it was answered, and the answer may be used within sigma.
    pub fn is_usable(&self) -> bool {
        self.answer.is_some_and(|answer| answer.verdict.usable() <= Usable::WithinSigma)
    }

    /// True where both errors are inside the bars. A row without an answer is outside.
    pub fn inside(&self, bars: &Bars) -> bool {
        self.errors().is_some_and(|(range, velocity)| {
            range.abs() <= bars.range_m && velocity.abs() <= bars.velocity_mps
        })
    }
}

/// A table of results and what it must keep to.
#[derive(Clone, Debug)]
pub struct Summary {
    /// All rows, in order.
    pub results: Vec<Result>,
    /// The papers' accuracy.
    pub bars: Bars,
    /// The method's name.
    pub method: String,
    /// Which signal the receiver conjugates, where there is a choice.
    pub mixing: Option<Mixing>,
    /// What bends the phase within a block, for people: then the table has the errors of usable answers, too.
    pub bent: Option<String>,
}

/// The errors of the answers that may be used within sigma, root mean square. The keys are those of the JSON line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UsableErrors {
    /// Their number.
    pub usable: usize,
    /// Of the ranges.
    pub usable_rms_range_m: f64,
    /// Of the velocities.
    pub usable_rms_velocity_mps: f64,
    /// Of the ranges over their sigmas.
    pub range_sigmas: f64,
    /// Of the velocities over their sigmas.
    pub velocity_sigmas: f64,
}

#[derive(Serialize)]
struct JsonRow<'a> {
    row: usize,
    truth_range_m: f64,
    truth_velocity_mps: f64,
    range_m: Option<f64>,
    velocity_mps: Option<f64>,
    sigma_range_m: Option<f64>,
    sigma_velocity_mps: Option<f64>,
    verdict: &'static str,
    inside: bool,
    method: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mixing: Option<&'static str>,
}

#[derive(Serialize)]
struct JsonSummary<'a> {
    summary: bool,
    rows: usize,
    inside: usize,
    rms_range_m: f64,
    worst_range_m: f64,
    rms_velocity_mps: f64,
    worst_velocity_mps: f64,
    bar_range_m: f64,
    bar_velocity_mps: f64,
    #[serde(flatten)]
    usable: UsableErrors,
    method: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    mixing: Option<&'static str>,
}

impl Summary {
    /// How many rows are inside the bars.
    pub fn inside(&self) -> usize {
        self.results.iter().filter(|result| result.inside(&self.bars)).count()
    }

    /// Root mean square and largest magnitude of an error over the rows that have an answer.
    fn spread(&self, pick: impl Fn((f64, f64)) -> f64) -> (f64, f64) {
        let errors: Vec<f64> = self.results.iter().filter_map(Result::errors).map(pick).collect();
        let square: f64 = errors.iter().map(|e| e * e).sum();
        let worst = errors.iter().fold(0.0f64, |worst, e| worst.max(e.abs()));
        ((square / errors.len().max(1) as f64).sqrt(), worst)
    }

    /// The errors of the answers that may be used within sigma.
    pub fn usable(&self) -> UsableErrors {
        let usable = self.results.iter().filter_map(|result| {
            let answer = result.answer.filter(|_| result.is_usable())?;
            let (range, velocity) = result.errors()?;
            Some([
                range,
                velocity,
                range / answer.sigma_range_m,
                velocity / answer.sigma_velocity_mps,
            ])
        });
        let usable: Vec<[f64; 4]> = usable.collect();
        let [usable_rms_range_m, usable_rms_velocity_mps, range_sigmas, velocity_sigmas] =
            [0, 1, 2, 3].map(|i| {
                // A velocimeter has no range, and no sigma of it.
                let squares = usable.iter().map(|of| of[i] * of[i]).filter(|s| s.is_finite());
                (squares.sum::<f64>() / usable.len().max(1) as f64).sqrt()
            });
        UsableErrors {
            usable: usable.len(),
            usable_rms_range_m,
            usable_rms_velocity_mps,
            range_sigmas,
            velocity_sigmas,
        }
    }

    /// What stands below the table where something bends the phase: what it is, and the errors of usable answers, as `errors` tells
    /// them.
    fn bent_lines(&self, errors: impl Fn(&UsableErrors) -> String) -> String {
        let usable = self.usable();
        let count = format!("{} of {} usable within sigma", usable.usable, self.results.len());
        self.bent
            .as_ref()
            .map_or_else(String::new, |bent| format!("{bent}: {count}\n{}\n", errors(&usable)))
    }

    /// One object a line, the summary last.
    pub fn json(&self) -> serde_json::Result<String> {
        let mut lines = String::new();
        for (index, result) in self.results.iter().enumerate() {
            let answer = result.answer;
            let row = JsonRow {
                row: index + 1,
                truth_range_m: result.truth.range_m,
                truth_velocity_mps: result.truth.velocity_mps,
                range_m: answer.map(|a| a.range_m),
                velocity_mps: answer.map(|a| a.velocity_mps),
                sigma_range_m: answer.map(|a| a.sigma_range_m),
                sigma_velocity_mps: answer.map(|a| a.sigma_velocity_mps),
                verdict: answer.map_or(Verdict::NoSignal, |a| a.verdict).name(),
                inside: result.inside(&self.bars),
                method: &self.method,
                shape: result.shape.map(name),
                mixing: self.mixing.map(Mixing::name),
            };
            lines += &serde_json::to_string(&row)?;
            lines.push('\n');
        }
        let (rms_range_m, worst_range_m) = self.spread(|e| e.0);
        let (rms_velocity_mps, worst_velocity_mps) = self.spread(|e| e.1);
        lines += &serde_json::to_string(&JsonSummary {
            summary: true,
            rows: self.results.len(),
            inside: self.inside(),
            rms_range_m,
            worst_range_m,
            rms_velocity_mps,
            worst_velocity_mps,
            bar_range_m: self.bars.range_m,
            bar_velocity_mps: self.bars.velocity_mps,
            usable: self.usable(),
            method: &self.method,
            mixing: self.mixing.map(Mixing::name),
        })?;
        lines.push('\n');
        Ok(lines)
    }

    /// For people: a table of ranges in metres and speeds in km/h.
    pub fn lidar_text(&self) -> String {
        let head =
            ["row", "true L m", "true V km/h", "L m", "V km/h", "dL cm", "dV km/h", "verdict"];
        let mut table = table(&head);
        for (index, result) in self.results.iter().enumerate() {
            let mut cells = vec![
                (index + 1).to_string(),
                format!("{:.0}", result.truth.range_m),
                format!("{:+.0}", result.truth.velocity_mps * 3.6),
            ];
            match (result.answer, result.errors()) {
                (Some(a), Some((range, velocity))) => cells.extend([
                    format!("{:.3} ± {:.3}", a.range_m, a.sigma_range_m),
                    format!("{:+.3} ± {:.3}", a.velocity_mps * 3.6, a.sigma_velocity_mps * 3.6),
                    format!("{:+.2}", range * 100.0),
                    format!("{:+.3}", velocity * 3.6),
                    a.verdict.name().to_string(),
                ]),
                _ => cells.push("no record".to_string()),
            }
            self.add(&mut table, cells, result);
        }
        let (rms_range, worst_range) = self.spread(|e| e.0);
        let (rms_velocity, worst_velocity) = self.spread(|e| e.1);
        format!(
            "{table}\n\n{}\n  range     rms {:.2} cm, worst {:.2} cm       (the paper: at most {:.0} cm)\n  \
             velocity  rms {:.3} km/h, worst {:.3} km/h (the paper: at most {:.2} km/h)\n{}",
            self.verdict_line(),
            rms_range * 100.0,
            worst_range * 100.0,
            self.bars.range_m * 100.0,
            rms_velocity * 3.6,
            worst_velocity * 3.6,
            self.bars.velocity_mps * 3.6,
            self.bent_lines(|usable| format!(
                "  range     rms {:.2} cm, error over sigma {:.2}\n  velocity  rms {:.3} km/h, error over sigma {:.2}",
                usable.usable_rms_range_m * 100.0,
                usable.range_sigmas,
                usable.usable_rms_velocity_mps * 3.6,
                usable.velocity_sigmas
            )),
        )
    }

    /// For people: a table of ranges in metres and velocities in m/s, by shape.
    pub fn radar_text(&self) -> String {
        let head = [
            "row",
            "shape",
            "true L m",
            "true V m/s",
            "L m",
            "V m/s",
            "dL cm",
            "dV m/s",
            "verdict",
        ];
        let mut table = table(&head);
        for (index, result) in self.results.iter().enumerate() {
            let mut cells = vec![
                (index + 1).to_string(),
                result.shape.map(name).unwrap_or_default().to_string(),
                format!("{:.0}", result.truth.range_m),
                format!("{:+.0}", result.truth.velocity_mps),
            ];
            match (result.answer, result.errors()) {
                (Some(a), Some((range, velocity))) => cells.extend([
                    format!("{:.3} ± {:.3}", a.range_m, a.sigma_range_m),
                    format!("{:+.3} ± {:.3}", a.velocity_mps, a.sigma_velocity_mps),
                    format!("{:+.2}", range * 100.0),
                    format!("{velocity:+.3}"),
                    a.verdict.name().to_string(),
                ]),
                _ => cells.push("no record".to_string()),
            }
            self.add(&mut table, cells, result);
        }
        let (rms_range, worst_range) = self.spread(|e| e.0);
        let (rms_velocity, worst_velocity) = self.spread(|e| e.1);
        format!(
            "{table}\n\n{}\n  range     rms {:.2} cm, worst {:.2} cm       (the bar, a tenth of the resolution: {:.1} cm)\n  \
             velocity  rms {:.3} m/s, worst {:.3} m/s   (the bar, a tenth of the resolution: {:.3} m/s)\n",
            self.verdict_line(),
            rms_range * 100.0,
            worst_range * 100.0,
            self.bars.range_m * 100.0,
            rms_velocity,
            worst_velocity,
            self.bars.velocity_mps,
        )
    }

    /// For people: a table of speeds in mm/s.
    pub fn turntable_text(&self) -> String {
        let mut table = table(&["row", "true V mm/s", "V mm/s", "dV mm/s", "verdict"]);
        for (index, result) in self.results.iter().enumerate() {
            let truth = format!("{:+.3}", result.truth.velocity_mps * 1e3);
            let mut cells = vec![(index + 1).to_string(), truth];
            match (result.answer, result.errors()) {
                (Some(a), Some((_, error))) => cells.extend([
                    format!("{:+.3} ± {:.3}", a.velocity_mps * 1e3, a.sigma_velocity_mps * 1e3),
                    format!("{:+.3}", error * 1e3),
                    a.verdict.name().to_string(),
                ]),
                _ => cells.push("no record".to_string()),
            }
            self.add(&mut table, cells, result);
        }
        let (rms, worst) = self.spread(|e| e.1);
        format!(
            "{table}\n\n{}\n  velocity  rms {:.3} mm/s, worst {:.3} mm/s (the paper: below {:.0} mm/s)\n{}",
            self.verdict_line(),
            rms * 1e3,
            worst * 1e3,
            self.bars.velocity_mps * 1e3,
            self.bent_lines(|usable| format!(
                "  velocity  rms {:.3} mm/s, error over sigma {:.2}",
                usable.usable_rms_velocity_mps * 1e3,
                usable.velocity_sigmas
            )),
        )
    }

    fn verdict_line(&self) -> String {
        format!("{} of {} rows inside, by {}", self.inside(), self.results.len(), self.method)
    }

    fn add(&self, table: &mut Table, cells: Vec<String>, result: &Result) {
        let outside = !result.inside(&self.bars) && std::io::stdout().is_terminal();
        table.add_row(cells.into_iter().map(|text| {
            let cell = Cell::new(text).set_alignment(CellAlignment::Right);
            if outside { cell.fg(Color::Red) } else { cell }
        }));
    }
}

/// The name of a shape.
fn name(shape: Shape) -> &'static str {
    match shape {
        Shape::Trapezoid => "trapezoid",
        Shape::Triangle => "triangle",
        Shape::Sawtooth => "sawtooth",
    }
}

/// An empty table with right-aligned heads and few lines.
pub fn table(heads: &[&str]) -> Table {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule));
    table.set_header(heads.iter().map(|h| Cell::new(h).set_alignment(CellAlignment::Right)));
    table
}

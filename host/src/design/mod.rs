//! `picket design`: what a rate, a length and a level give, and which of them a wanted sigma or span needs.

mod budget;
pub mod sheet;

use crate::cli;
use clap::Args;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle};
use picket_dsp::Shape;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_measure::analyze::ramp::shape;
use picket_measure::analyze::told;
use picket_measure::length;
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::{Value, json};
use sheet::{Design, Question, Row, Trouble};
use std::process::ExitCode;

/// Finds sample rate and block length for a sensor, or shows what given ones reach: resolution, span, sigma, updates and load.
#[derive(Args, Debug)]
pub struct Options {
    /// Carrier of the radar or laser, as in 24.125G
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, required_unless_present = "wavelength_m", conflicts_with = "wavelength_m")]
    carrier_hz: Option<f64>,
    /// Its wavelength instead, as in 1550e-9
    #[arg(long, value_name = "M", value_parser = cli::positive)]
    wavelength_m: Option<f64>,
    /// Samples per second [default: as many as --velocity-mps or --range-m need]
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz)]
    rate: Option<f64>,
    /// Samples in a block [default: all lengths]
    #[arg(long, value_parser = length)]
    n: Option<usize>,
    /// Signal-to-noise ratio per sample, dB
    #[arg(long, value_name = "DB", default_value_t = 20.0, allow_negative_numbers = true, value_parser = cli::number)]
    snr_db: f64,
    /// The samples are I/Q pairs
    #[arg(long)]
    iq: bool,
    /// Bandwidth of a chirp; adds ranges
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, requires = "chirp_s")]
    bandwidth_hz: Option<f64>,
    /// Duration of its ramp
    #[arg(long, value_name = "S", value_parser = cli::positive, requires = "bandwidth_hz")]
    chirp_s: Option<f64>,
    /// Shape of the ramps in the settings: trapezoid, triangle or sawtooth
    #[arg(long, value_name = "SHAPE", value_parser = shape(), default_value = "trapezoid", requires = "bandwidth_hz")]
    shape: Shape,
    /// The fastest target
    #[arg(long, value_name = "M/S", value_parser = cli::positive)]
    velocity_mps: Option<f64>,
    /// The farthest target of a chirp
    #[arg(long, value_name = "M", value_parser = cli::positive, requires = "bandwidth_hz")]
    range_m: Option<f64>,
    /// Wanted sigma of the velocity; selects the shortest block that reaches it
    #[arg(long, value_name = "M/S", value_parser = cli::positive)]
    sigma_mps: Option<f64>,
    /// Wanted sigma of the range
    #[arg(long, value_name = "M", value_parser = cli::positive, requires = "bandwidth_hz")]
    sigma_m: Option<f64>,
    /// Errors of the sensor, one standard deviation each, as in clock_ppm=20,slope_ppm=100: prints the whole error of the fastest or farthest
    /// target, source by source
    #[arg(long, value_name = "NAME=SIGMA,...", value_parser = told::uncertainty)]
    uncertainty: Option<Uncertainty>,
    /// Prints one JSON object per length, and one with the settings
    #[arg(long)]
    json: bool,
}

fn length(text: &str) -> Result<usize, String> {
    let n = text.parse().map_err(|_| "choose 64, 128, ... 4096")?;
    length::check(n).map(|()| n)
}

impl Options {
    fn question(&self) -> Question {
        let carrier = self.carrier_hz.map(|hz| SPEED_OF_LIGHT / hz);
        Question {
            // The command line has one of them.
            wavelength_m: carrier.or(self.wavelength_m).unwrap_or(f64::NAN),
            rate_hz: self.rate,
            n: self.n,
            snr_db: self.snr_db,
            iq: self.iq,
            chirp: self.bandwidth_hz.zip(self.chirp_s),
            shape: self.shape,
            velocity_mps: self.velocity_mps,
            range_m: self.range_m,
            sigma_mps: self.sigma_mps,
            sigma_m: self.sigma_m,
        }
    }
}

/// A row as a JSON line.
struct Line<'a>(&'a Row);

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("n", &self.0.n)?;
        for (key, number) in self.0.fields() {
            if let Some(number) = number {
                map.serialize_entry(key, &number)?;
            }
        }
        map.end()
    }
}

/// Prints the design.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let design = Design::of(options.question()).map_err(|trouble| match trouble {
        Trouble::NoRate => {
            "give --rate, or --velocity-mps of the fastest target, or --range-m of the farthest"
                .to_owned()
        }
        Trouble::Slow { .. } => {
            let rate = options.rate.unwrap_or_default();
            format!("--rate {rate}: {trouble}")
        }
        _ => trouble.to_string(),
    })?;
    if options.json {
        for row in &design.rows {
            cli::print_line(&serde_json::to_string(&Line(row)).unwrap_or_default());
        }
    } else {
        cli::print(&text(&design));
    }
    let known = options.uncertainty.as_ref();
    let place = [options.range_m, options.velocity_mps];
    if let Some(whole) = known.and_then(|known| budget::Whole::of(&design, known, place)) {
        match options.json {
            true => cli::print_line(&whole.json().to_string()),
            false => cli::print(&whole.text()),
        }
    }
    if let Some(settings) = design.settings() {
        let value = || serde_json::from_str::<Value>(&settings).unwrap_or_default();
        match options.json {
            true => cli::print_line(&json!({"summary": true, "settings": value()}).to_string()),
            false => cli::print_line(&format!("settings  {settings}")),
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn text(design: &Design) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule));
    table.set_content_arrangement(ContentArrangement::Disabled);
    let head = design.head();
    let columns = head.len();
    table.set_header(head);
    for row in &design.rows {
        table.add_row(row.cells());
    }
    for column in 0..columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{}\n\n{table}\n", design.sentences().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The loads of every length, by the cycles that a reader of JSON finds in the budget.
    #[test]
    fn loads_are_those_of_the_budget() {
        let budget: Value =
            serde_json::from_str(include_str!("../../../host-tests/budget.json")).unwrap();
        let cycles = |pointer: &str| budget.pointer(pointer).and_then(Value::as_f64);
        let question = Question {
            wavelength_m: 0.0125,
            rate_hz: Some(10e3),
            snr_db: 10.0,
            ..Question::default()
        };
        let design = Design::of(question).unwrap();
        assert_eq!(design.rows.len(), length::LENGTHS.len());
        for row in &design.rows {
            let n = row.n;
            let m4f = cycles(&format!("/engines/picket-i32/cycles/{n}/measurement"));
            let m0 = cycles("/portable_cycles/M0/measurement").filter(|_| n == 1024);
            let load = |cycles: f64, core_hz: f64| cycles / (n as f64 / 10e3 * core_hz);
            assert_eq!(row.load_m4f, m4f.map(|cycles| load(cycles, 180e6)), "{n}");
            assert_eq!(row.load_m0, m0.map(|cycles| load(cycles, 125e6)), "{n}");
        }
        assert_eq!(design.rows.iter().filter(|row| row.load_m4f.is_some()).count(), 3);
    }
}

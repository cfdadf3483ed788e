//! `picket explain`: why a block's verdict is what it is.

mod causes;
mod frames;
mod picture;
pub mod rows;

use crate::analyze::input::Input;
use crate::analyze::ramp::Chirps;
use crate::analyze::told::Told;
use crate::analyze::{self, Answer, Explanation};
use crate::cli;
use crate::output::Output;
use clap::Args;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle};
pub use rows::Row;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::path::PathBuf;
use std::process::ExitCode;

/// Explains the verdict on one block of a recording: every test with its value, its limit and its result; or of one frame of chirps: what
/// bounds each of its targets.
#[derive(Args, Debug)]
pub struct Options {
    #[command(flatten)]
    input: Input,
    /// The block, counted from 0, as `picket analyze` counts with the same options
    #[arg(long, value_name = "NUMBER", required_unless_present = "frame")]
    block: Option<u64>,
    /// The frame of chirps, counted from 0, with the options of a radar: --chirp-s, --bandwidth-hz, --carrier-hz
    #[arg(long, value_name = "NUMBER", requires = "chirp_s", conflicts_with_all = ["block", "plot"])]
    frame: Option<u64>,
    #[command(flatten)]
    chirps: Chirps,
    #[command(flatten)]
    told: Told,
    /// Draws the bins around the peak, the fit and its residual into this file, SVG or PNG by its name
    #[arg(long, value_name = "FILE", value_parser = cli::picture)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// What the command prints as JSON: the keys of an analysis' answer, and the tests.
#[derive(Debug, Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    answer: &'a Answer,
    usable: &'static str,
    reason: &'static str,
    tests: &'a [Row],
}

/// Reads the block, measures it as `picket analyze` does, and prints why its verdict is what it is.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    if let Some(picture) = &options.plot {
        options.output.check(picture, &[&options.input.file])?;
    }
    if let Some(frame) = options.frame {
        return frames::run(options, frame);
    }
    if options.chirps.chirp_s.is_some() {
        return Err(
            "--chirp-s goes with --frame: --block explains a block of samples as it is".into()
        );
    }
    let analysis = options.input.analysis()?;
    let block = options.block.unwrap_or_default();
    let explanation = analyze::explain(&options.input.file, &analysis, block)?;
    let rows = rows(&explanation);
    if let Some(picture) = &options.plot {
        picture::draw(&explanation, analysis.codes, picture, options.output)?;
    }
    let Explanation { answer, explained, .. } = &explanation;
    let verdict = explained.estimate.verdict;
    if options.json {
        let report = Report {
            answer,
            usable: verdict.usable().name(),
            reason: verdict.reason(),
            tests: &rows,
        };
        cli::print_line(&serde_json::to_string(&report).unwrap_or_default());
    } else {
        cli::print(&text(&explanation, &rows));
    }
    Ok(ExitCode::SUCCESS)
}

/// The tests behind the verdict, in the order in which they were made, and then those of the verdict itself.
pub fn rows(explanation: &Explanation) -> Vec<Row> {
    let Explanation { explained, samples, .. } = explanation;
    let mut rows = rows::from_notes(&explained.notes);
    rows.extend(explained.joint.iter().flat_map(causes::rows));
    rows.extend(rows::from_evidence(&explained.evidence, samples.len()));
    rows
}

impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_struct("Row", 8)?;
        object.serialize_field("test", self.test)?;
        object.serialize_field("about", self.about)?;
        match self.fit {
            Some(fit) => object.serialize_field("fit", fit)?,
            None => object.skip_field("fit")?,
        }
        object.serialize_field("value", &self.value)?;
        object.serialize_field("limit", &self.limit)?;
        object.serialize_field("unit", self.unit)?;
        object.serialize_field("fired", &self.fired)?;
        object.serialize_field("followed", &self.followed)?;
        object.end()
    }
}

fn text(explanation: &Explanation, rows: &[Row]) -> String {
    let Explanation { answer, explained, .. } = explanation;
    let verdict = explained.estimate.verdict;
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.6}"));
    let (value, sigma, unit) = match answer.frequency_hz {
        Some(_) => (answer.frequency_hz, answer.sigma_hz, "Hz"),
        None => (answer.bins, answer.sigma_bins, "bins"),
    };
    let also: String = answer.also.iter().map(|also| format!(", {also}")).collect();
    let mut text = format!(
        "block {}: {} {unit} ± {} {unit}, SNR {} dB, {}{also}\n{}: {} Usable: {}.\n\n",
        answer.block,
        number(value),
        number(sigma),
        answer.snr_db.map_or("-".to_owned(), |x| format!("{x:.1}")),
        verdict,
        verdict,
        verdict.reason(),
        verdict.usable(),
    );
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule));
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["test", "what is compared", "value", "limit", "", "outcome", "consequence"]);
    for column in [2, 3] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.2}"));
    for row in rows {
        let test = row.fit.map_or(row.test.to_owned(), |fit| format!("{} ({fit} fit)", row.test));
        table.add_row([
            test.as_str(),
            row.about,
            &number(row.value),
            &number(row.limit),
            row.unit,
            row.outcome(),
            &row.followed,
        ]);
    }
    for line in table.to_string().lines() {
        text += line.trim_end();
        text.push('\n');
    }
    text
}

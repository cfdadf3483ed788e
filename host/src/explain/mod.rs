//! `picket explain`: why a block's verdict is what it is.

mod picture;
mod words;

use crate::analyze::input::Input;
use crate::analyze::{self, Answer, Explanation};
use crate::arithmetic::Note;
use crate::cli;
use crate::output::Output;
use clap::Args;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle};
use picket::Verdict;
use picket::tone::evidence::{EDGE_BINS, Evidence, WHOLE_SPECTRUM};
use picket::tone::judge::Line;
use picket::tone::observer::Step;
use picket::tone::sigma::CLIPPED;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Explains the verdict on one block of a recording: every test with its value, its limit and what followed.
#[derive(Args, Debug)]
pub struct Options {
    #[command(flatten)]
    input: Input,
    /// The block, counted from 0 as `picket analyze` counts them with the same options
    #[arg(long, value_name = "NUMBER")]
    block: u64,
    /// Draws the bins around the peak, the fit and what it leaves into this file, SVG or PNG by its name
    #[arg(long, value_name = "FILE", value_parser = cli::picture)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
    /// One JSON object
    #[arg(long)]
    json: bool,
}

/// One test, as people and programs read it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub test: &'static str,
    /// What is compared, in a sentence.
    pub about: &'static str,
    /// The fit whose line is judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<&'static str>,
    /// The value.
    pub value: Option<f64>,
    /// Its limit.
    pub limit: Option<f64>,
    /// What both are in.
    pub unit: &'static str,
    /// Whether the test says something against the tone.
    pub fired: bool,
    /// Whether it can: another only tells which tests are made, or what a sum is made of.
    #[serde(skip)]
    pub decides: bool,
    /// What followed.
    pub followed: String,
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
    let analysis = options.input.analysis()?;
    let explanation = analyze::explain(&options.input.file, &analysis, options.block)?;
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
    let explained = &explanation.explained;
    let (mut rows, mut fit) = (Vec::new(), None);
    for note in &explained.notes {
        match note {
            Note::Begin(step) => fit = Some(of_step(*step)),
            Note::Test(test) => rows.push(words::row(test, fit)),
            Note::Judged(judgement, taken) => {
                let line = match judgement.line {
                    Line::Steady => "one steady tone",
                    Line::Moving => "one tone that changes: moving",
                    Line::Unresolved => "more than one tone: unresolved",
                };
                let taken = if *taken { "" } else { "; not better, so this fit is dropped" };
                rows.push(Row {
                    test: "line",
                    about: "variance over that of the noise alone",
                    fit,
                    value: Some(judgement.widening.into()),
                    limit: None,
                    unit: "",
                    fired: judgement.line != Line::Steady,
                    decides: true,
                    followed: format!("{line}{taken}"),
                });
                fit = None;
            }
        }
    }
    rows.extend(of_evidence(&explained.evidence, explanation.samples.len()));
    rows
}

const fn of_step(step: Step) -> &'static str {
    match step {
        Step::Usual => "usual",
        Step::Further => "more steps",
        Step::BesideDrift => "beside a drift",
    }
}

/// The rules of the verdict itself, with what they are about in the order of [`Evidence::rules`].
fn of_evidence(evidence: &Evidence, n: usize) -> Vec<Row> {
    let n = n as f64;
    let sigma = Some((f64::from(evidence.sigma) * n, f64::from(WHOLE_SPECTRUM) * n));
    let edge = Some((f64::from(evidence.edge_bins), f64::from(EDGE_BINS)));
    let clipped = Some((f64::from(evidence.clipped) * 100.0, f64::from(CLIPPED) * 100.0));
    let about = [
        ("found", "there is a peak in the band, and a fit to it", None, ""),
        ("detection", "the line is told from noise", None, ""),
        ("sigma", "sigma is less than the whole spectrum", sigma, "bins"),
        ("steady", "the line does not change within the block", None, ""),
        ("alone", "the line is a single tone", None, ""),
        ("image", "no strong line at minus the frequency", None, ""),
        ("edge", "distance from DC or Nyquist, at least", edge, "bins"),
        ("band", "the frequency is within the band", None, ""),
        ("clipped", "share of the samples that touch a rail", clipped, "%"),
        ("codes", "samples beyond the stated rails", Some((evidence.beyond.into(), 0.0)), ""),
        ("gap", "no samples are missing before the block", None, ""),
    ];
    let finite = |x: f64| x.is_finite().then_some(x);
    let row =
        |((test, about, value, unit), (fired, verdict)): ((_, _, Option<(f64, f64)>, _), _)| {
            let verdict: Verdict = verdict;
            Row {
                test,
                about,
                fit: None,
                value: value.and_then(|(value, _)| finite(value)),
                limit: value.and_then(|(_, limit)| finite(limit)),
                unit,
                fired,
                decides: true,
                followed: if fired { verdict.name() } else { "-" }.to_owned(),
            }
        };
    about.into_iter().zip(evidence.rules()).map(row).collect()
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
    table.set_header([
        "test",
        "what is compared",
        "value",
        "limit",
        "",
        "outcome",
        "what followed",
    ]);
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
            match (row.decides, row.fired) {
                (false, _) => "-",
                (true, true) => "fired",
                (true, false) => "passed",
            },
            &row.followed,
        ]);
    }
    for line in table.to_string().lines() {
        text += line.trim_end();
        text.push('\n');
    }
    text
}

//! The campaign as a command: its options, and what it prints.

use super::{Campaign, Cell, Truth};
use crate::analyze::input;
use crate::impair::{GROUPS, Impairment, help};
use crate::simulate::Kind;
use crate::{cli, progress};
use clap::Args;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle};
use picket_dsp::tone::effort::Effort;
use std::process::ExitCode;

/// Signal-to-noise ratios by default, dB.
pub const SNR_DB: [f64; 3] = [10.0, 30.0, 50.0];
/// Records of each by default.
pub const TRIALS: usize = 300;

/// What stands below the table.
const LEGEND: &str = "\
right          % said to be usable within sigma (good, moving, clipped, gap), and within 5 sigma of the truth
overconfident  % said to be usable within sigma, and off by more than 5
flagged        % any other verdict; false flag: of them those within 5 sigma
RMSE and error/sigma leave out answers off by more than 1.5 bins; z2 is the mean of (error/sigma)^2 of all good ones.
The bound is that of a pure tone in white noise as dense as the noise is at the tone.";

/// Options of a sweep that belong to impairments.
#[derive(Args, Clone, Debug)]
pub struct Flags {
    /// Instead of pure tones: records with something wrong, and what the verdicts say of them. Names apart by commas, severities
    /// behind a colon: chirp, chirp:0.3, second-tone:offset=0.5/1,level-db=-20; two in one record joined by a plus: chirp+hum; "all" for every one, "signals" for every
    /// unsteady tone, "front-end" for every digital fault, "list" explains them.
    #[arg(long, value_name = "NAMES", conflicts_with_all = ["bin", "delta", "delta_points", "dc"])]
    pub impair: Option<String>,
    /// Bins between which the impaired tone lies, anywhere; else those where the impairment matters
    #[arg(long, value_name = "LO:HI", allow_hyphen_values = true, requires = "impair", value_parser = range)]
    pub bins: Option<(f64, f64)>,
    /// Which frequency is the true one where it changes within the block
    #[arg(long, value_enum, default_value = "mean", requires = "impair")]
    pub truth: Truth,
    /// How closely a line that is not a steady tone is looked at: look, one or full
    #[arg(long, value_name = "EFFORT", default_value = Effort::default().name(), value_parser = input::effort, requires = "impair")]
    pub effort: Effort,
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let ends =
        text.split_once(':').and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    ends.filter(|(low, high): &(f64, f64)| low.is_finite() && high.is_finite() && low <= high)
        .ok_or_else(|| "give two bins, low end first: 4:10".into())
}

/// The impairments that records of kind `R` can have. One that is asked for by name and cannot be is an error.
pub fn chosen<R: Kind>(names: &str) -> Result<Vec<Impairment>, String> {
    let mut chosen = Impairment::parse(names)?;
    if names.split(',').any(|name| GROUPS.iter().any(|group| group.0 == name.trim())) {
        chosen.retain(Impairment::fits::<R>);
    }
    let cure = if R::IQ {
        "is of real records only: leave --kind complex out"
    } else {
        "is of I/Q records only: add --kind complex"
    };
    match chosen.iter().find(|impairment| !impairment.fits::<R>()) {
        Some(unfit) => Err(format!("{} {cure}", unfit.name())),
        None => Ok(chosen),
    }
}

/// Runs the campaign and prints it: a table, or one JSON object a line.
pub fn run<R: Kind>(
    names: &str,
    campaign: &Campaign,
    snr_db: &[f64],
    json: bool,
) -> Result<ExitCode, String> {
    if names.trim() == "list" {
        cli::print_line(&format!("{}\n{LEGEND}", help().trim_end()));
        return Ok(ExitCode::SUCCESS);
    }
    let impairments = chosen::<R>(names)?;
    let most = campaign.n as f64 / 2.0;
    let least = if R::IQ { -most } else { 0.0 };
    if let Some((low, high)) = campaign.bins.filter(|(low, high)| *low < least || *high > most) {
        return Err(format!("--bins {low}:{high}: choose from {least} to {most}"));
    }
    let ratios = |impairment: &Impairment| if impairment.noisy() { snr_db.len() } else { 1 };
    let cells: usize = impairments.iter().map(ratios).sum();
    let bar = progress::bar((cells * campaign.trials) as u64, "records");
    let mut all = Vec::new();
    for impairment in &impairments {
        for &snr_db in snr_db.iter().take(ratios(impairment)) {
            let new = campaign.run::<R>(impairment, snr_db, &bar)?;
            if json {
                for cell in &new {
                    cli::print_line(
                        &serde_json::to_string(cell).map_err(|error| error.to_string())?,
                    );
                }
            }
            all.extend(new);
        }
    }
    bar.finish_and_clear();
    if json {
        let summary = serde_json::json!({
            "summary": true, "cells": all.len(), "seed": campaign.seed, "n": campaign.n,
            "trials": cells * campaign.trials,
        });
        cli::print_line(&summary.to_string());
        return Ok(ExitCode::SUCCESS);
    }
    cli::print_line(&table(&all).to_string());
    cli::print_line(&format!(
        "{} samples, {}, {}, {} records of each, seed {}",
        campaign.n,
        R::NAME,
        campaign.arithmetic.name(),
        campaign.trials,
        campaign.seed
    ));
    cli::print_line(LEGEND);
    Ok(ExitCode::SUCCESS)
}

fn table(cells: &[Cell]) -> Table {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule));
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header([
        "impairment",
        "severity",
        "method",
        "SNR dB",
        "right",
        "flagged",
        "overconfident",
        "false flag",
        "RMSE bins",
        "RMSE/bound",
        "rms e/sigma",
        "z2",
        "verdicts",
    ]);
    let number = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
    let mut before = (String::new(), String::new());
    for cell in cells {
        let this = (cell.impair.clone(), cell.severity.clone());
        let said = if this == before { Default::default() } else { this.clone() };
        before = this;
        let share = |share: f64| format!("{:.1}", 100.0 * share);
        let verdicts: Vec<String> =
            cell.verdicts.iter().map(|(verdict, count)| format!("{verdict} {count}")).collect();
        table.add_row([
            said.0,
            said.1,
            cell.method.to_owned(),
            cell.snr_db.map_or("none".into(), |db| db.to_string()),
            share(cell.right_share),
            share(cell.flagged_share),
            share(cell.overconfident_share),
            share(cell.false_flag_share),
            cell.rmse_bins.map_or("-".into(), |rmse| format!("{rmse:.2e}")),
            number(cell.ratio),
            number(cell.rms_z),
            number(cell.z2_good),
            verdicts.join(", "),
        ]);
    }
    for column in table.column_iter_mut().skip(3).take(9) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

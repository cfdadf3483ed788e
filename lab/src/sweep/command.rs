//! `lab sweep`: the errors of methods over many simulated records.

use super::{Offsets, Row, Sweep};
use crate::arithmetic::Arithmetic;
use crate::campaign::{self, Campaign};
use crate::estimator::{self, Estimator};
use crate::exact::Numbers;
use crate::simulate::{Kind, Width};
use crate::{cli, progress};
use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use picket_dsp::acquire::codes::Codes;
use std::process::ExitCode;

/// Measures methods on simulated records: RMSE, bias, outliers, and the ratio to the Cramer-Rao bound.
#[derive(Args, Debug)]
#[command(after_help = estimator::help_with_references())]
pub struct Options {
    /// Methods, separated by commas (listed below)
    #[arg(long)]
    method: Option<String>,
    /// Kind of record
    #[arg(long, value_enum, default_value = "real")]
    kind: Samples,
    /// Samples in a record
    #[arg(long, default_value_t = 1024, value_parser = cli::count::<{ 1 << 20 }>)]
    n: usize,
    /// Signal-to-noise ratios in dB, separated by commas; inf for no noise
    /// [default: -10,0,20,40; with --impair 10,30,50]
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    snr_db: Option<Vec<f64>>,
    /// Points across one bin, from -0.5 to +0.5
    #[arg(long, default_value_t = 15, value_parser = cli::count::<10_000>)]
    delta_points: usize,
    /// Instead of points: "uniform" for an offset of its own in each trial, or one offset in bins
    #[arg(long, allow_hyphen_values = true)]
    delta: Option<String>,
    /// Records at each point [default: 2000; with --impair 300]
    #[arg(long, value_parser = cli::count::<10_000_000>)]
    trials: Option<usize>,
    /// Width of the converter's codes
    #[arg(long, value_enum, default_value = "12")]
    bits: Bits,
    /// Amplitude in codes; else the largest at which four sigma of noise do not clip
    #[arg(long)]
    amplitude: Option<f64>,
    /// Constant offset in codes
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    dc: f64,
    /// Bin that the points lie around; else N/16
    #[arg(long)]
    bin: Option<f64>,
    /// Bins on each side that least squares reads: 4, 8 or 16
    #[arg(long, default_value_t = 16)]
    k: usize,
    /// Seed of the generator
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// f64 or f32: floats on an exact transform of any length; target or target-fixed: the library's [default: f64; with --impair target]
    #[arg(long, value_name = "NUMBERS", value_parser = Numbers::from_name)]
    arith: Option<Numbers>,
    /// One JSON object a line
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    impaired: campaign::command::Flags,
}

impl Options {
    /// Pure tones' default or that of impairments.
    fn usual<T>(&self, given: Option<T>, pure: T, impaired: T) -> T {
        given.unwrap_or(if self.impaired.impair.is_some() { impaired } else { pure })
    }

    fn snr_db(&self) -> Vec<f64> {
        self.usual(
            self.snr_db.clone(),
            vec![-10.0, 0.0, 20.0, 40.0],
            campaign::command::SNR_DB.into(),
        )
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Samples {
    /// Real samples
    Real,
    /// I/Q pairs
    Complex,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Bits {
    /// Signed 12-bit codes
    #[value(name = "12")]
    Twelve,
    /// Signed 16-bit codes
    #[value(name = "16")]
    Sixteen,
    /// Neither rounded nor clipped
    Float,
}

/// Simulates and prints the errors.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    with_kind!(options.kind == Samples::Complex, R => run_kind::<R>(options))
}

fn run_kind<R: Kind>(options: &Options) -> Result<ExitCode, String> {
    let sweep = plan::<R>(options)?;
    let all_snr_db = options.snr_db();
    if let Some(names) = &options.impaired.impair {
        let Numbers::Library(arithmetic) = sweep.numbers else {
            return Err("--impair is of verdicts, which the library has: add --arith target".into());
        };
        let campaign = Campaign {
            estimators: sweep.estimators,
            arithmetic,
            effort: options.impaired.effort,
            n: sweep.n,
            trials: sweep.trials,
            width: sweep.width,
            amplitude: sweep.amplitude,
            bins: options.impaired.bins,
            truth: options.impaired.truth,
            seed: sweep.seed,
        };
        return campaign::command::run::<R>(names, &campaign, &all_snr_db, options.json);
    }
    // What is kept of each trial is a few numbers for each method.
    if sweep.trials * sweep.offsets.points() > 100_000_000 {
        return Err(
            "more than 100,000,000 records at each SNR: fewer --trials or --delta-points do".into(),
        );
    }
    let trials = sweep.trials * sweep.offsets.points() * all_snr_db.len();
    let bar = progress::bar(trials as u64, "trials");
    let mut rows = Vec::new();
    for &snr_db in &all_snr_db {
        let new = sweep.run::<R>(snr_db, &bar)?;
        if options.json {
            for row in &new {
                cli::print_line(&serde_json::to_string(row).map_err(|error| error.to_string())?);
            }
        }
        rows.extend(new);
    }
    bar.finish_and_clear();
    if options.json {
        let summary = serde_json::json!({
            "summary": true, "rows": rows.len(), "seed": options.seed, "n": sweep.n,
            "bin": sweep.bin, "offset_points": sweep.offsets.points(), "trials": trials,
        });
        cli::print_line(&summary.to_string());
    } else {
        cli::print_line(&table(&rows).to_string());
        cli::print_line(&format!(
            "{} samples, {}, bin {}, seed {}. Errors in bins; beyond 1.5 an outlier, left out. +- one standard error.",
            sweep.n,
            R::NAME,
            sweep.bin,
            sweep.seed
        ));
    }
    Ok(ExitCode::SUCCESS)
}

fn plan<R: Kind>(options: &Options) -> Result<Sweep, String> {
    let reach = estimator::reach(options.k)?;
    let estimators = match &options.method {
        Some(names) => estimator::parse(names, reach)?,
        None => vec![Estimator::best(R::IQ, reach)],
    };
    let library = Numbers::Library(Arithmetic::Target);
    let numbers = options.usual(options.arith, Numbers::F64, library);
    for estimator in &estimators {
        estimator.check::<R>()?;
        numbers.check(*estimator)?;
    }
    let n = options.n;
    let bin = options.bin.unwrap_or((n / 16) as f64);
    let most = if R::IQ { n as f64 - 1.0 } else { n as f64 / 2.0 };
    if !(0.0..=most).contains(&bin) {
        return Err(format!("--bin {bin}: choose 0 to {most}"));
    }
    let trials = options.usual(options.trials, 2000, campaign::command::TRIALS);
    let all_snr_db = options.snr_db();
    if all_snr_db.is_empty() {
        return Err("--snr-db needs at least one".into());
    }
    if let Some(snr_db) = all_snr_db.iter().find(|x| x.is_nan() || **x == f64::NEG_INFINITY) {
        return Err(format!("--snr-db {snr_db}: give decibels, or inf for no noise"));
    }
    if options.amplitude.is_some_and(|a| !(a > 0.0 && a.is_finite())) || !options.dc.is_finite() {
        return Err("--amplitude and --dc are numbers of codes, the amplitude positive".into());
    }
    let width = match options.bits {
        Bits::Twelve => Width::Codes(Codes::signed::<12>()),
        Bits::Sixteen => Width::Codes(Codes::signed::<16>()),
        Bits::Float => Width::Float,
    };
    Ok(Sweep {
        estimators,
        numbers,
        n,
        bin,
        offsets: offsets(options)?,
        trials,
        width,
        amplitude: options.amplitude,
        dc: options.dc,
        seed: options.seed,
    })
}

fn offsets(options: &Options) -> Result<Offsets, String> {
    match options.delta.as_deref() {
        None => Ok(Offsets::Points(options.delta_points)),
        Some("uniform") => Ok(Offsets::Uniform),
        Some(text) => match text.parse::<f64>() {
            Ok(delta) if delta.abs() <= 0.5 => Ok(Offsets::Fixed(delta)),
            _ => Err(format!("--delta {text}: give \"uniform\" or an offset from -0.5 to 0.5")),
        },
    }
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header([
        "method",
        "SNR dB",
        "trials",
        "outliers",
        "RMSE",
        "mean |e|",
        "bias",
        "bound",
        "RMSE/bound",
    ]);
    for row in rows {
        let with_error = |value: f64, error: f64| format!("{value:.3e} +- {error:.0e}");
        table.add_row([
            row.method.to_owned(),
            row.snr_db.map_or("none".into(), |db| db.to_string()),
            row.trials.to_string(),
            row.outliers.to_string(),
            with_error(row.rmse_bins, row.rmse_se_bins),
            with_error(row.mean_abs_bins, row.mean_abs_se_bins),
            with_error(row.bias_bins, row.bias_se_bins),
            format!("{:.3e}", row.bound_bins),
            match (row.ratio, row.ratio_se) {
                (Some(ratio), Some(error)) => format!("{ratio:.3} +- {error:.3}"),
                _ => "-".into(),
            },
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

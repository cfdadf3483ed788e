//! `lab report`: the figures of both papers and our own, computed again.

use crate::output::Output;
use crate::{cli, report};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Computes the figures and tables of both papers and Picket's own: one HTML page, and every picture as SVG and PNG.
/// The exit code is 1 if a figure is outside its bar.
#[derive(Args, Debug)]
pub struct Options {
    /// Few trials: rough figures in seconds
    #[arg(long)]
    quick: bool,
    /// Folder of the page and the pictures, an empty one [default: target/report, which is written again]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
    /// Seed of the noise
    #[arg(long, default_value_t = report::SEED)]
    seed: u64,
    /// Each figure and its bar, one JSON object a line
    #[arg(long)]
    json: bool,
}

/// Writes the report.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let own = Output { force: options.output.force || options.out.is_none() };
    let folder = options.out.clone().unwrap_or_else(|| "target/report".into());
    let checks = report::write(&folder, own, options.quick, options.seed)?;
    let held = checks.iter().filter(|check| check.holds).count();
    let page = folder.join("report.html");
    if options.json {
        for check in &checks {
            cli::print_line(&serde_json::to_string(check).map_err(|error| error.to_string())?);
        }
        let summary = serde_json::json!({
            "summary": true, "figures": checks.len(), "hold": held, "seed": options.seed, "page": page,
        });
        cli::print_line(&summary.to_string());
    } else {
        for check in checks.iter().filter(|check| !check.holds) {
            let report::lab::Check { figure, measured, error, low, high, .. } = check;
            cli::print_line(&format!(
                "outside: {figure}: {measured:.4} ± {error:.4}, bar {low:.4} to {high:.4}"
            ));
        }
        cli::print_line(&format!(
            "{held} of {} figures within their bars: {}",
            checks.len(),
            page.display()
        ));
    }
    Ok(if held == checks.len() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

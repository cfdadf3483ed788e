//! The lidar's rows with many seeds: how large errors are, and whether gross ones are flagged.

use super::feed::N;
use super::options::Options;
use super::shown::{keys, table};
use super::table::{self as targets, Summary, Task, heading};
use super::{DemoError, said};
use crate::scenario::Laser;
use picket_dsp::acquire::sample::Real;
use picket_dsp::methods::registry::Method;
use picket_dsp::plan::Solver;
use picket_dsp::tone::Verdict;
use serde::Serialize;
use std::process::ExitCode;

/// A beat that is off by more bins than this was not the target's: the error is gross.
const GROSS_BINS: f64 = 1.5;

/// The errors of many targets. The keys are those of the JSON line.
#[derive(Clone, Debug, Serialize)]
pub struct Spread {
    /// The method.
    pub method: String,
    /// Targets measured.
    pub targets: usize,
    /// Targets without an answer, or off by more than 1.5 bins in range or velocity.
    pub gross: usize,
    /// Gross ones whose verdict is not good.
    pub flagged_by_verdict: usize,
    /// Gross ones whose verdict is not good or whose error is within five sigma.
    pub flagged: usize,
    /// Root mean square of the range's error, gross ones left out.
    pub rms_range_m: f64,
    /// Root mean square of the velocity's error, gross ones left out.
    pub rms_velocity_mps: f64,
    /// The mean of (error / sigma)^2 of the range, gross ones left out.
    pub trust_range: f64,
}

impl Spread {
    /// The spread of the first `targets` results.
    pub fn of(summary: &Summary, targets: usize) -> Self {
        let (range_bar, velocity_bar) = gross_bars();
        let mut spread = Spread {
            method: summary.method.clone(),
            targets,
            gross: 0,
            flagged_by_verdict: 0,
            flagged: 0,
            rms_range_m: 0.0,
            rms_velocity_mps: 0.0,
            trust_range: 0.0,
        };
        for result in summary.results.iter().take(targets) {
            let (Some(answer), Some([range, velocity])) = (result.answer, result.errors()) else {
                spread.gross += 1;
                continue;
            };
            if range.abs() <= range_bar && velocity.abs() <= velocity_bar {
                spread.rms_range_m += range * range;
                spread.rms_velocity_mps += velocity * velocity;
                spread.trust_range += (range / answer.sigma_range_m).powi(2);
                continue;
            }
            let said = answer.verdict != Verdict::Good;
            let covered = range.abs() <= 5.0 * answer.sigma_range_m
                && velocity.abs() <= 5.0 * answer.sigma_velocity_mps;
            spread.gross += 1;
            spread.flagged_by_verdict += usize::from(said);
            spread.flagged += usize::from(said || covered);
        }
        let count = (targets - spread.gross).max(1) as f64;
        spread.rms_range_m = (spread.rms_range_m / count).sqrt();
        spread.rms_velocity_mps = (spread.rms_velocity_mps / count).sqrt();
        spread.trust_range /= count;
        spread
    }
}

/// 1.5 bins of the lidar in metres and in metres per second.
fn gross_bars() -> (f64, f64) {
    let plan = crate::scenario::lidar().plan::<Real, N>();
    match plan.map(|plan| plan.solver) {
        Ok(Solver::Chirp(equations)) => {
            let bins = |scale: picket_dsp::solve::chirp::Scale| {
                GROSS_BINS / N as f64 * 2.0 * scale.float.abs() as f64
            };
            (bins(equations.range[0]), bins(equations.velocity[0]))
        }
        _ => (0.0, 0.0),
    }
}

/// Sends the blocks of `picket demo` through the firmware's pipeline on this machine: the
/// answers have the same bits.
pub fn on_host(method: Method, snr_db: f64, seed: u64, seeds: u64) -> Result<Summary, DemoError> {
    let task = Task::lidar(Some(method), Laser::default())?;
    Ok(task.summary(&task.on_host(snr_db, seed, seeds)?, seeds))
}

/// Measures, and prints a line for each method.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let spread = |method| {
        let options = Options { method, ..options.clone() };
        targets::lidar(&options).map(|summary| Spread::of(&summary, summary.results.len()))
    };
    let mut spreads = vec![spread(options.method)?];
    if options.versus.is_some() {
        spreads.push(spread(options.versus)?);
    }
    if options.json {
        for spread in &spreads {
            outln!("{}", serde_json::to_string(spread).map_err(said)?);
        }
        outln!("{}", summary(&spreads, options));
    } else {
        out!("{}", text(&spreads, options));
    }
    Ok(ExitCode::SUCCESS)
}

fn ratios(spreads: &[Spread]) -> Option<[f64; 2]> {
    let [ours, theirs] = spreads else { return None };
    let range = ours.rms_range_m / theirs.rms_range_m;
    Some([range, ours.rms_velocity_mps / theirs.rms_velocity_mps])
}

fn summary(spreads: &[Spread], options: &Options) -> serde_json::Value {
    let ratios = ratios(spreads);
    serde_json::json!({
        "summary": true, "seeds": options.seeds, "snr_db": options.snr_db(),
        "ratio_range": ratios.map(|r| r[0]), "ratio_velocity": ratios.map(|r| r[1]),
    })
}

/// For people: a line for each method, and the ratio of two.
pub fn text(spreads: &[Spread], options: &Options) -> String {
    let last = options.seed.wrapping_add(options.seeds - 1);
    let head = format!("{} to {last}", heading(options));
    let row = |spread: &Spread| {
        let Spread { method, targets, gross, flagged, rms_range_m, rms_velocity_mps, .. } = spread;
        let share = 100.0 * *gross as f64 / *targets as f64;
        keys! {
            method, targets, rms_range_m, rms_velocity_mps, gross: format!("{gross} ({share:.2} %)"),
            flagged: format!("{flagged} of {gross}"),
        }
    };
    let rows: Vec<_> = spreads.iter().map(row).collect();
    let rows = table(
        &rows,
        "method: method | targets: targets | rms L cm: 100 rms_range_m .3 | rms V km/h: 3.6 rms_velocity_mps .4 | gross: gross | \
         flagged: flagged",
        |_| false,
    );
    let ratio = ratios(spreads).map_or(String::new(), |[range, velocity]| {
        format!("ratio of the rms errors: range {range:.3}, velocity {velocity:.3}\n")
    });
    format!(
        "{head}\n\n{rows}\n\n{ratio}gross: off by more than 1.5 bins, left out of the rms; flagged: not called good, or within 5 sigma\n"
    )
}

//! Tables that this machine computes.

use super::figures::{Budget, head, row, whole};
use super::{Table, recordings};
use crate::demo::options::Options;
use crate::demo::seeds::{Spread, on_host, text};
use crate::report::SEED;
use crate::report::lab::Lab;
use crate::report::over_snr::{README_METHODS, readme_sweep};
use crate::toolchain::workspace;
use clap::Parser;
use indicatif::ProgressBar;
use picket_dsp::acquire::sample::Real;
use picket_dsp::methods::registry::Method;

pub(super) const TABLES: &[Table] = &[
    Table::new("docs/precision.md", "floors", floors),
    Table::new("docs/precision.md", "seeds", seeds),
    Table::new("docs/precision.md", "recordings", of_recordings),
    Table::new("docs/precision.md", "locked", locked),
    Table::new("docs/concepts.md", "sensors", sensors),
    Table::new("docs/c.md", "memory", memory),
];

/// Errors over the bound at the ends of the picture over the signal-to-noise ratio.
fn floors(_: &Table) -> Result<Vec<String>, String> {
    let lab = Lab { quick: false, seed: SEED, bar: ProgressBar::hidden() };
    let sweep = readme_sweep(&lab, README_METHODS)?;
    let mut rows: Vec<Vec<String>> =
        README_METHODS.split(',').map(|name| vec![name.to_owned()]).collect();
    for snr_db in [0.0, 20.0, 40.0, 60.0] {
        let seen = lab.run::<Real>(&sweep, snr_db)?;
        for (row, seen) in rows.iter_mut().zip(seen) {
            row.push(seen.ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")));
        }
    }
    let head = head("| error over the bound, bin 5 of 1024 | 0 dB | 20 dB | 40 dB | 60 dB |");
    Ok([head, rows.into_iter().map(row).collect()].concat())
}

/// The lidar in noise by the pipeline on this machine: the firmware's answers have the same bits.
fn seeds(_: &Table) -> Result<Vec<String>, String> {
    let command = "cargo picket demo --snr-db -10 --seeds 50 --versus z-rife";
    let options = Options::try_parse_from(command.split_whitespace().skip(2));
    let options = options.map_err(|error| error.to_string())?;
    let spread = |method| {
        let summary = on_host(method, options.snr_db(), options.seed, options.seeds);
        summary
            .map(|summary| Spread::of(&summary, summary.results.len()))
            .map_err(|error| error.to_string())
    };
    let spreads = [spread(Method::LeastSquaresReal)?, spread(Method::ZRife)?];
    let said = text(&spreads, &options);
    let lines = said.trim_end().lines().map(|line| line.trim_end().to_owned());
    let lines = ["```console".to_owned(), format!("$ {command}")].into_iter().chain(lines);
    Ok(lines.chain(["```".to_owned()]).collect())
}

fn of_recordings(_: &Table) -> Result<Vec<String>, String> {
    let head = head("| recording, figure | options | reference | method and figure |");
    let rows = recordings::all()?;
    Ok([head, rows.iter().map(recordings::Shown::line).collect()].concat())
}

/// What a block takes where its tone is expected.
fn locked(_: &Table) -> Result<Vec<String>, String> {
    let budget = Budget::read()?;
    let mut lines = head("| a block of 1024 on an emulated Cortex-M4F | instructions, mean |");
    for (what, stage) in [
        ("the cheaper estimate near the expected frequency", "lock"),
        ("with the search for clipped samples and the filter", "locked"),
        ("a whole measurement", "whole"),
    ] {
        let figure = budget.at(&format!("/locked/{stage}"))?;
        lines.push(row([what.to_owned(), super::figures::rounded(figure)]));
    }
    Ok(lines)
}

/// Three digits, with commas.
fn digits(figure: f64) -> String {
    let power = figure.abs().log10().floor() as i32;
    match 2 - power {
        decimals @ 1.. => format!("{figure:.*}", decimals as usize),
        decimals => {
            let unit = 10f64.powi(-decimals);
            whole((figure / unit).round() * unit)
        }
    }
}

/// What `picket design` tells of these sensors.
fn sensors(_: &Table) -> Result<Vec<String>, String> {
    let mut lines = head(
        "| sensor: fastest target | wave | velocity m/s | Doppler Hz | rate Hz | N | block ms | bin m/s | sigma m/s |",
    );
    for (what, wave, velocity, n) in [
        ("HB100: a walker", "--carrier-hz 10.525G", "2", "128"),
        ("HB100: a cyclist", "--carrier-hz 10.525G", "10", "256"),
        ("CDM324: a walker", "--carrier-hz 24.125G", "2", "128"),
        ("CDM324: a car in town", "--carrier-hz 24.125G", "15", "512"),
        ("CDM324: a thrown ball", "--carrier-hz 24.125G", "40", "512"),
        ("77 GHz: a car", "--carrier-hz 77G", "50", "1024"),
        ("ultrasound of 40 kHz in air: a hand", "--wavelength-m 8.575e-3", "1", "256"),
        ("two laser beams, fringes of 3.73 um: a flow", "--wavelength-m 7.458e-6", "0.15", "512"),
        ("laser of 1550 nm: a turntable", "--wavelength-m 1550e-9", "1", "1024"),
    ] {
        let arguments =
            format!("design {wave} --velocity-mps {velocity} --n {n} --snr-db 10 --json");
        let text = super::typed::said(&arguments)?;
        let told: Result<Vec<serde_json::Value>, _> =
            text.lines().map(serde_json::from_str).collect();
        let told = told.map_err(|error| error.to_string())?;
        let [first, second, ..] = told.as_slice() else {
            return Err(format!("{arguments}: {text}"));
        };
        let number = |key: &str| first[key].as_f64().unwrap_or(f64::NAN);
        let speed: f64 = velocity.parse().map_err(|_| velocity.to_owned())?;
        let doppler_hz = number("bin_hz") * speed / number("resolution_mps");
        let rate_hz = second["settings"]["rate_hz"].as_f64().unwrap_or(f64::NAN);
        let figures = [number("block_s") * 1e3, number("resolution_mps"), number("sigma_mps")];
        let cells = [what.to_owned(), format!("`{wave}`"), velocity.to_owned(), digits(doppler_hz)];
        let cells = cells.into_iter().chain([digits(rate_hz), n.to_owned()]);
        lines.push(row(cells.chain(figures.map(digits))));
    }
    Ok(lines)
}

/// The memory that `picket.h` declares.
fn memory(_: &Table) -> Result<Vec<String>, String> {
    let header = std::fs::read_to_string(workspace().join("c/include/picket.h"));
    let header = header.map_err(|error| format!("picket.h: {error}"))?;
    let declared = |rest: &str| -> Option<(String, u32, f64)> {
        let (bytes, rest) = rest.split_once(" * (N) * (PARTS) + ")?;
        let (fixed, rest) = rest.split_once(") / 8];")?;
        let name = rest.split_once("} ")?.1.split(';').next()?;
        Some((name.to_owned(), bytes.parse().ok()?, fixed.parse().ok()?))
    };
    let mut lines = head("| object | memory, real records | memory, I/Q |");
    for rest in header.split("uint64_t state[(").skip(1) {
        let (name, bytes, fixed) =
            declared(rest).ok_or("picket.h declares its memory otherwise")?;
        let object = match name.as_str() {
            "KIND" => "pipeline",
            "KIND##_tracker" => "tracker",
            "KIND##_accumulator" => "accumulator",
            "KIND##_bursts" => "burst processor",
            other => return Err(format!("{other} has no name on the page")),
        };
        let fixed = whole(fixed);
        let pair = format!("{} bytes a pair and {fixed} B", 2 * bytes);
        lines.push(row([object.to_owned(), format!("{bytes} bytes a sample and {fixed} B"), pair]));
    }
    Ok(lines)
}

//! The figures of docs/precision.md, and the README's picture, come from commands: here they are made again.

use clap::Parser;
use indicatif::ProgressBar;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::methods::registry::Method;
use picket_host::demo::options::Options;
use picket_host::demo::seeds::{Spread, on_host, text};
use picket_lab::report::SEED;
use picket_lab::report::lab::Lab;
use picket_lab::report::over_snr::{README_METHODS, readme_sweep};
use serde_json::Value;

const PRECISION: &str = include_str!("../../docs/precision.md");
const PLOT: &str = include_str!("../../docs/over-snr.svg");

/// The seeds at -10 dB, in the pipeline on this machine: the firmware's answers have the same bits.
#[test]
fn seeds_at_minus_ten_decibels() {
    let command = "cargo picket demo --snr-db -10 --seeds 50 --versus z-rife";
    let options = Options::parse_from(command.split_whitespace().skip(2));
    let spread = |method| {
        let summary = on_host(method, options.snr_db(), options.seed, options.seeds).unwrap();
        Spread::of(&summary, summary.results.len())
    };
    let spreads = [spread(Method::LeastSquaresReal), spread(options.versus.unwrap())];
    let said = text(&spreads, &options);
    println!("{said}{spreads:?}");
    assert!(PRECISION.contains(&format!("$ {command}\n{said}")), "the page does not say:\n{said}");
    let [ours, theirs] = &spreads;
    for ratio in
        [ours.rms_range_m / theirs.rms_range_m, ours.rms_velocity_mps / theirs.rms_velocity_mps]
    {
        // Of single tones at any offset alike it would be 1.03 over 1.39. A trapezoid weighs its three tones by their sigmas, and Z-Rife's are no
        // less than their distance from least squares: its worse tones count less.
        assert!((0.74..0.87).contains(&ratio), "{ratio}");
    }
    assert!(ours.gross * 100 <= ours.targets, "{ours:?}");
    // 1400 squares of a normal number: 4 % of spread.
    assert!((0.85..1.15).contains(&ours.trust_range), "{ours:?}");
}

/// Points of the README's picture, from the same seed, are those drawn.
#[test]
fn points_of_the_plot() {
    let start = PLOT.find("<metadata>").unwrap() + "<metadata>".len();
    let values = &PLOT[start..PLOT.find("</metadata>").unwrap()];
    let drawn: Value = serde_json::from_str(&values.replace("&quot;", "\"")).unwrap();
    let lab = Lab { quick: false, seed: SEED, bar: ProgressBar::hidden() };
    let at = |label: &str, snr_db: f64| {
        let points = drawn[label].as_array().unwrap();
        let point = points.iter().find(|point| point[0] == snr_db).unwrap();
        point[1].as_f64().unwrap()
    };
    for snr_db in [0.0, 60.0] {
        let real = lab.run::<Real>(&readme_sweep(&lab, README_METHODS).unwrap(), snr_db).unwrap();
        let iq = lab.run::<Iq>(&readme_sweep(&lab, "fesa").unwrap(), snr_db).unwrap();
        let names = ["ours: least squares", "Z-Rife", "Quinn, second", "HAQSE", "FESA, on I/Q"];
        for (row, name) in real.iter().chain(&iq).zip(names) {
            println!("{name} at {snr_db} dB: {:e}, drawn {:e}", row.rmse_bins, at(name, snr_db));
            assert!((row.rmse_bins / at(name, snr_db) - 1.0).abs() < 1e-9, "{name}");
        }
        assert!((real[0].bound_bins / at("bound, real", snr_db) - 1.0).abs() < 1e-9);
        if snr_db == 60.0 {
            let [ours, z_rife] = [0, 1].map(|index: usize| real[index].ratio.unwrap());
            let said = format!("Z-Rife ends at {z_rife:.0} times the bound, ours at {ours:.2}");
            assert!(PRECISION.contains(&said), "the page does not say: {said}");
        }
    }
}

/// The README names the oldest compiler that the packages promise, the job `oldest` of the CI compiles with it.
#[test]
fn the_oldest_compiler() {
    let readme = include_str!("../../README.md");
    let said = format!("for Rust {} and later", env!("CARGO_PKG_RUST_VERSION"));
    assert_eq!(readme.matches(&said).count(), 1, "the README does not say: {said}");
}

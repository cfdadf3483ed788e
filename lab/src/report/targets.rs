//! The lidar paper's Table 3: range and velocity.

use super::lab::{Check, Lab, Section, Table, plus_minus, share};
use super::lidar::N;
use crate::demo::seeds::{Spread, on_host};
use crate::scenario::{self, LIDAR_BARS, Row, sensor, table3};
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::methods::registry::Method;
use picket_simulator::Scene;

/// Sweeps that [`targets`] runs.
pub const TARGETS: u64 = 4;

/// Table 3: targets, by the firmware's arithmetic on the host.
pub fn targets(lab: &Lab) -> Result<Section, String> {
    let seeds = lab.trials(100, 4) as u64;
    let mut table = Table::new([
        "SNR dB, method",
        "targets",
        "inside the paper's bars %",
        "rms range cm",
        "rms velocity km/h",
        "gross errors",
    ]);
    table.row(["the paper (experiment)", "-", "100", "at most 5", "at most 0.16", "-"]);
    let mut checks = Vec::new();
    for snr_db in [-5.0, -10.0] {
        for method in [Method::ZRife, Method::LeastSquaresReal] {
            let summary = on_host(method, snr_db, lab.seed, seeds).map_err(|e| e.to_string())?;
            let spread = Spread::of(&summary, summary.results.len());
            // The square of a normal number scatters by √2 of its mean.
            let counted = (spread.targets - spread.gross) as f64;
            let rms = |value: f64| plus_minus(value, value / (2.0 * counted).sqrt());
            let inside = summary.inside() as f64 / summary.results.len() as f64;
            table.row([
                format!("{snr_db}, {}", method.name()),
                spread.targets.to_string(),
                share(summary.inside(), summary.results.len()),
                rms(spread.rms_range_m * 100.0),
                rms(spread.rms_velocity_mps * 3.6),
                spread.gross.to_string(),
            ]);
            lab.bar.inc(1);
            let least = if snr_db > -7.0 { 0.999 } else { 0.97 };
            let error = (least * (1.0 - least) / summary.results.len() as f64).sqrt();
            checks.push(Check::between(
                format!(
                    "share of targets inside 5 cm and 0.16 km/h, {snr_db} dB, {}",
                    method.name()
                ),
                inside,
                error,
                least,
                1.0,
            ));
        }
    }
    let mut wrong = Table::new([
        "range m",
        "speed km/h",
        "range by eqs 1 and 2, m",
        "speed by eqs 1 and 2, km/h",
    ]);
    let sensor = sensor::<Real>(&scenario::lidar(), N, 0.0, 1);
    for row in table3().iter().filter(|row| row.velocity_mps > 0.0) {
        let (range, speed) = by_magnitudes(&sensor, row)?;
        if (range - row.range_m).abs() > LIDAR_BARS.range_m {
            let cells = [row.range_m, row.velocity_mps * 3.6, range, speed * 3.6];
            wrong.row(cells.map(|x| format!("{x:.2}")));
        }
    }
    checks.push(Check::between(
        "rows of Table 3 that eqs 1 and 2 get wrong",
        wrong.rows.len() as f64,
        0.0,
        5.0,
        5.0,
    ));
    Ok(Section {
        title: "Lidar paper, Table 3: range and velocity",
        text: vec![
            format!(
                "The paper's waveform (1550 nm, 1 GHz in 10 µs, 250 MS/s, N = {N} real 12-bit samples a ramp), 14 targets, \
                 each approaching and receding, {seeds} seeds, in the firmware's arithmetic. Gross: off by more than 1.5 \
                 bins (0.55 m or 1.0 km/h); the rms figures leave them out."
            ),
            "Eqs 1 and 2 take the beats' magnitudes, which is wrong wherever the Doppler shift exceeds the range beat; \
             the rows below of the paper's own table cannot come out of its own equations. Picket tries the four sign \
             patterns. In the table's last row 120.05 must be 112.05."
                .into(),
        ],
        tables: vec![table, wrong],
        checks,
        ..Section::default()
    })
}

/// Range and velocity as eqs 1 and 2 have it, from the magnitudes of a target's beats on both ramps.
fn by_magnitudes(sensor: &Scene, row: &Row) -> Result<(f64, f64), String> {
    let run = row.scene(sensor, N, (1.0, 0.0), None).run(0)?;
    let beat = |segment| run.truth(0, sensor.start_s(segment, N), N).frequency_hz.abs();
    let [up, down] = [0, 2].map(beat);
    Ok((SPEED_OF_LIGHT * 10e-6 * (up + down) / (4.0 * 1e9), 1550e-9 * (down - up) / 4.0))
}

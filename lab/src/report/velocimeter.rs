//! The Doppler paper: Yang et al. 2011, doi:10.3724/SP.J.1146.2010.01373.

use super::lab::{Check, Lab, Section, Table, plus_minus};
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::{TURNTABLE_BARS, TURNTABLE_RADIUS_M, turntable_rows};
use crate::simulate::Width;
use crate::sweep::{Offsets, Row, Sweep};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Iq;
use picket_dsp::methods::autocorrelation::best_lag;
use std::f64::consts::PI;

fn ratio_of(db: f64) -> f64 {
    10f64.powf(db / 10.0)
}

/// The autocorrelation's variance over the bound's, at lag `share` of the record: eqs 7 and 10, for any lag.
fn lag_variance(share: f64, snr: f64) -> f64 {
    let rest = 1.0 - share;
    (share.min(rest) + rest / (2.0 * snr)) / (6.0 * share * share * rest * rest)
}

/// The variance at the lag of eq 9.
fn best_variance(snr: f64) -> f64 {
    const FINE: usize = 1 << 20;
    lag_variance(best_lag(snr, FINE) as f64 / FINE as f64, snr)
}

/// Quinn's variance over the bound's at an offset: eq 5, of which the paper says that it is a ratio of RMSEs.
fn quinn_variance(delta: f64) -> f64 {
    let d = delta.abs().max(1e-6);
    let (d2, d4) = (d * d, d.powi(4));
    PI.powi(4) * d2 * (d2 - 1.0).powi(2) * (3.0 * d4 + 1.0)
        / (6.0 * (3.0 * d4 + 6.0 * d2 + 1.0) * (PI * d).sin().powi(2))
}

/// The signal-to-noise ratio in dB where the autocorrelation's `curve`, which falls, meets `level`.
fn crossing(level: f64, curve: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut low, mut high) = (-20.0, 60.0);
    if curve(ratio_of(high)) > level || curve(ratio_of(low)) < level {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if curve(ratio_of(middle)) > level { low = middle } else { high = middle }
    }
    Some(low)
}

/// The offset at which Quinn's estimator is as good as the autocorrelation at a very high ratio.
fn equal_offset() -> f64 {
    let level = best_variance(1e9);
    let (mut low, mut high) = (0.0, 0.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if quinn_variance(middle) > level { low = middle } else { high = middle }
    }
    low
}

/// Sweeps that [`crossings`] runs.
pub const CROSSINGS: u64 = CROSSING_DB.len() as u64;
const CROSSING_DB: [f64; 8] = [-5.0, -2.0, 0.0, 2.5, 5.0, 10.0, 15.0, 20.0];

/// Figure 1: where the autocorrelation becomes better than Quinn's estimator.
pub fn crossings(lab: &Lab) -> Result<Section, String> {
    let sweep = lab.sweep("improved-autocorrelation", lab.trials(6000, 300))?;
    let (mut measured, mut errors) = (Vec::new(), Vec::new());
    let mut checks = Vec::new();
    for snr_db in CROSSING_DB {
        let row = lab.run::<Iq>(&sweep, snr_db)?.remove(0);
        let (ratio, error) = row.over_bound();
        measured.push((snr_db, ratio));
        errors.push(error);
        if snr_db >= 0.0 {
            let formula = best_variance(ratio_of(snr_db)).sqrt();
            let figure =
                format!("improved autocorrelation, RMSE / bound at {snr_db} dB against eq 7");
            checks.push(Check::near(figure, ratio, error, formula, 0.03));
        }
    }
    let decibels = || (-10..=50).map(|i| f64::from(i) * 0.5);
    let theory = decibels().map(|db| (db, best_variance(ratio_of(db)).sqrt()));
    let right = decibels().map(|db| (db, lag_variance(2.0 / 3.0, ratio_of(db)).sqrt()));
    let mut series = vec![
        Series::new("improved autocorrelation (eq 7, 9)", Style::Line, 0, theory),
        Series::new("the same, measured", Style::Points, 0, measured).with_errors(errors),
        Series::new("lag 2N/3", Style::Line, 2, right),
    ];
    let mut table = Table::new([
        "Quinn at offset",
        "paper: crossing dB",
        "eqs 5 and 10 as printed dB",
        "like with like dB",
    ]);
    let stated = [
        (0.0, Some(-3.1), Some(2.43)),
        (0.2, Some(0.1), Some(5.56)),
        (0.3, None, Some(10.97)),
        (0.4, Some(16.9), None),
    ];
    for (index, (delta, printed, right)) in stated.into_iter().enumerate() {
        let level = quinn_variance(delta);
        let slip = crossing(level, |snr| best_variance(snr).sqrt());
        let like = crossing(level, best_variance);
        let text = |x: Option<f64>| x.map_or("never".into(), |x: f64| format!("{x:.2}"));
        let paper = printed.map_or("-".into(), |x: f64| x.to_string());
        table.row([delta.to_string(), paper, text(slip), text(like)]);
        if let (Some(printed), Some(slip)) = (printed, slip) {
            let figure = format!("crossing at offset {delta} as printed, dB");
            checks.push(Check::between(figure, slip, 0.0, printed - 0.1, printed + 0.1));
        }
        match (right, like) {
            (Some(right), Some(like)) => {
                let figure = format!("crossing at offset {delta} like with like, dB");
                checks.push(Check::between(figure, like, 0.0, right - 0.02, right + 0.02));
            }
            (right, like) => {
                let same = f64::from(u8::from(right.is_none() == like.is_none()));
                checks.push(Check::between(
                    format!("no crossing at offset {delta}"),
                    same,
                    0.0,
                    1.0,
                    1.0,
                ));
            }
        }
        let level = level.sqrt();
        let line = [(-5.0, level), (25.0, level)];
        series.push(Series::new(format!("Quinn, offset {delta}"), Style::Dashed, 3 + index, line));
    }
    let equal = equal_offset();
    checks.push(Check::between(
        "offset of equal quality at high ratios",
        equal,
        0.0,
        0.3553,
        0.3555,
    ));
    Ok(Section {
        title: "Doppler paper, Figure 1: Quinn or autocorrelation?",
        text: vec![
            format!(
                "RMSE over the bound, N = 1024. Eq 5 is a ratio of variances; the paper compares it with eq 10, a ratio of \
                 RMSEs, and finds crossings at -3.1, 0.1 and 16.9 dB. Like with like they are those of the last column, and \
                 at high ratios Quinn's estimator is the better one beyond an offset of {equal:.4}."
            ),
            "Eq 7 holds for lags up to N/2 only; for any lag m the sum has min(m, N-m) terms, and m = 2N/3 is best at every \
             ratio until phases wrap (below -8 dB at N = 1024). Eq 10 at SNR = 0.5 is too small by √2. (The paper's own \
             curves were not at hand; the crossings are from its text.)"
                .into(),
        ],
        charts: vec![Chart {
            name: "doppler-figure-1",
            title: "Autocorrelation against Quinn's estimator: RMSE over the bound".into(),
            x: Axis::linear("signal-to-noise ratio, dB", -5.0, 25.0),
            y: Axis::linear("RMSE / bound", 0.9, 2.0),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

/// Sweeps that [`three_ratios`] runs.
pub const THREE_RATIOS: u64 = 3 * 11;
const METHODS: &str = "quinn2,improved-autocorrelation,fesa,fesa-corrected,least-squares";

/// Figure 3: errors across a bin at three signal-to-noise ratios.
pub fn three_ratios(lab: &Lab) -> Result<Section, String> {
    let mut charts = Vec::new();
    let mut table = Table::new(
        ["SNR dB".to_owned()]
            .into_iter()
            .chain(METHODS.split(',').map(|m| format!("{m}: RMSE / bound"))),
    );
    let mut checks = Vec::new();
    for (name, snr_db, most) in [
        ("doppler-figure-3-low", -5.0, 2.5),
        ("doppler-figure-3-middle", 5.0, 1.6),
        ("doppler-figure-3-high", 20.0, 1.5),
    ] {
        let offsets: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0 - 0.5).collect();
        let at = |&delta: &f64| {
            let plan = lab.sweep(METHODS, lab.trials(3000, 100))?;
            lab.run::<Iq>(&Sweep { offsets: Offsets::Fixed(delta), ..plan }, snr_db)
        };
        let rows: Vec<Vec<Row>> = offsets.iter().map(at).collect::<Result<_, _>>()?;
        let series = METHODS.split(',').enumerate().map(|(index, method)| {
            let over = || rows.iter().map(|rows| rows[index].over_bound());
            let points = offsets.iter().zip(over()).map(|(&delta, (ratio, _))| (delta, ratio));
            let errors = over().map(|(_, error)| error);
            Series::new(method, Style::Marked, index, points).with_errors(errors)
        });
        // A mean square over the inner points and half of either end: the offset is uniform.
        let mut cells = vec![snr_db.to_string()];
        for index in 0..METHODS.split(',').count() {
            let weight = |point: usize| if point == 0 || point == 10 { 0.05 } else { 0.1 };
            let weighted = |f: fn(&Row) -> f64| {
                rows.iter().enumerate().map(|(p, rows)| weight(p) * f(&rows[index])).sum::<f64>()
            };
            let mean = weighted(|row| row.over_bound().0.powi(2)).sqrt();
            let error = rows[5][index].ratio_se.unwrap_or(0.0) / 10f64.sqrt();
            cells.push(plus_minus(mean, error));
            if index == 4 {
                let figure = format!("least squares, RMSE / bound, {snr_db} dB");
                checks.push(Check::near(figure, mean, error, 1.01, 0.03));
            }
        }
        table.row(cells);
        charts.push(Chart {
            name,
            title: format!("RMSE over the bound across one bin, {snr_db} dB"),
            x: Axis::linear("offset from the bin, bins", -0.5, 0.5),
            y: Axis::linear("RMSE / bound", 0.9, most),
            series: series.collect(),
        });
    }
    Ok(Section {
        title: "Doppler paper, Figure 3: across one bin at three ratios",
        text: vec![format!(
            "One ratio for each regime of FESA as printed: below -3.1 dB it always takes Quinn's estimator, up to 16.9 dB \
             Quinn's from offset 0.2 on, above from 0.4 on. Complex tones, N = 1024, {} records a point, the ratio estimated by \
             eqs 11 to 13 with the bins further than N/4 from the peak as noise (eq 13 does not say which). At the lowest ratio both forms of FESA are Quinn's estimator: three curves are one. The paper's choice \
             of the three ratios, and its curves, were not at hand.",
            lab.trials(3000, 100)
        )],
        charts,
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

/// Sweeps that [`turntable`] runs.
pub const TURNTABLE: u64 = 2 * 11;

/// Figure 5: the rim of a turntable.
pub fn turntable(lab: &Lab) -> Result<Section, String> {
    // 1550 nm along the motion, a sample each 0.1 µs.
    let mps_per_bin = 10e6 / 1024.0 * 1550e-9 / 2.0;
    let speeds: Vec<f64> =
        turntable_rows().iter().map(|row| row.velocity_mps).filter(|v| *v > 0.0).collect();
    let methods = ["fesa", "least-squares"];
    let mut table = Table::new([
        "SNR dB",
        "method",
        "paper mm/s",
        "measured mm/s",
        "worst speed's mm/s",
        "outliers",
    ]);
    let mut series = Vec::new();
    let mut checks = Vec::new();
    for (level, (snr_db, stated)) in [(-12.0, 0.44), (0.0, 0.11)].into_iter().enumerate() {
        let at = |&speed: &f64| {
            let plan = lab.sweep(&methods.join(","), lab.trials(2000, 100))?;
            let sweep = Sweep {
                numbers: crate::exact::Numbers::Library(crate::arithmetic::Arithmetic::Target),
                width: Width::Codes(Codes::signed::<12>()),
                offsets: Offsets::Fixed(0.0),
                bin: speed / mps_per_bin,
                ..plan
            };
            lab.run::<Iq>(&sweep, snr_db)
        };
        let rows: Vec<Vec<Row>> = speeds.iter().map(at).collect::<Result<_, _>>()?;
        for (index, method) in methods.into_iter().enumerate() {
            let of = |row: &Vec<Row>| row[index].rmse_bins * mps_per_bin * 1e3;
            let error = |row: &Vec<Row>| row[index].rmse_se_bins * mps_per_bin * 1e3;
            let count = rows.len() as f64;
            let rms = (rows.iter().map(|row| of(row).powi(2)).sum::<f64>() / count).sqrt();
            let se = rows.iter().map(|row| error(row).powi(2)).sum::<f64>().sqrt() / count;
            let worst = rows.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
            let (worst, worst_error) =
                worst.map_or((f64::NAN, f64::NAN), |row| (of(row), error(row)));
            let outliers: u64 = rows.iter().map(|row| row[index].outliers).sum();
            table.row([
                snr_db.to_string(),
                method.into(),
                "below 2".into(),
                plus_minus(rms, se),
                plus_minus(worst, worst_error),
                outliers.to_string(),
            ]);
            if method == "fesa" {
                checks.push(Check::near(
                    format!("turntable, FESA, {snr_db} dB, mm/s"),
                    rms,
                    se,
                    stated,
                    0.06,
                ));
            }
            checks.push(Check::between(
                format!("turntable, {method}, {snr_db} dB, worst speed's RMSE, mm/s"),
                worst,
                worst_error,
                0.0,
                TURNTABLE_BARS.velocity_mps * 1e3,
            ));
            let points = speeds.iter().zip(&rows).map(|(speed, row)| (*speed, of(row)));
            let label = format!("{method}, {snr_db} dB");
            let errors = rows.iter().map(error);
            let points = Series::new(label, Style::Marked, 2 * level + index, points);
            series.push(points.with_errors(errors));
        }
    }
    Ok(Section {
        title: "Doppler paper, Figure 5: the turntable",
        text: vec![format!(
            "A rim of {} mm (the paper prints nm), 1550 nm along its motion, I/Q at 10 MS/s, N = 1024, 12-bit codes, the \
             firmware's arithmetic. The paper reports less than 2 mm/s from its experiment, where the rim's own motion adds to \
             the noise; estimation alone leaves what is shown here.",
            TURNTABLE_RADIUS_M * 1e3
        )],
        charts: vec![Chart {
            name: "doppler-figure-5",
            title: "Turntable: error of the rim's speed".into(),
            x: Axis::linear("speed of the rim, m/s", 0.0, 4.0),
            y: Axis::log("RMSE, mm/s", 0.05, 2.0),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

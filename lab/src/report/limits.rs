//! Where methods end: at the bound, at the outlier threshold, at the image floor, at the converter's codes.

use super::lab::{Check, Lab, Section, Table, plus_minus};
use crate::estimator::parse;
use crate::exact::Numbers;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::reference::Reference;
use crate::simulate::{Width, generator};
use crate::sweep::{Row, Sweep};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::methods::registry::Method;
use picket_dsp::tone::fit::Reach;
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The signal-to-noise ratios of [`STATED`].
pub const LEVELS_DB: [f64; 7] = [-10.0, -5.0, 0.0, 10.0, 20.0, 40.0, 60.0];

/// RMSE over the bound by an independent implementation in another language, N = 1024, complex, offset uniform; good to
/// 1 % and rounded as shown. 0: no figure (Kay's 5.5 at 10 dB comes of a phase step that wraps once in thousands of
/// records, of which a run may see none or several).
pub const STATED: &[(&str, [f64; 7])] = &[
    ("rife", [3.54, 3.76, 4.22, 5.32, 6.59, 11.4, 19.9]),
    ("z-rife", [1.36, 1.36, 1.28, 1.29, 1.28, 1.27, 1.25]),
    ("a-p-rife", [1.40, 1.38, 1.31, 1.29, 1.29, 1.27, 1.25]),
    ("i-rife", [1.04, 1.06, 1.03, 1.03, 1.03, 1.01, 1.03]),
    ("dual-threshold-rife", [1.11, 1.08, 1.03, 1.03, 1.03, 1.01, 1.03]),
    ("quinn1", [1.35, 1.31, 1.27, 1.28, 1.28, 1.27, 1.26]),
    ("quinn2", [1.17, 1.18, 1.14, 1.14, 1.14, 1.13, 1.13]),
    ("jacobsen", [1.53, 1.55, 1.53, 1.54, 1.52, 1.51, 1.53]),
    ("candan", [1.53, 1.55, 1.53, 1.54, 1.52, 1.51, 1.53]),
    ("macleod", [1.17, 1.19, 1.15, 1.15, 1.15, 1.14, 1.15]),
    ("parabolic", [3.9, 6.2, 10.0, 32.0, 100.0, 999.0, 10038.0]),
    ("aboutanios-mulgrew", [1.01, 1.03, 1.00, 1.00, 1.00, 0.99, 1.00]),
    ("haqse", [1.00, 1.02, 1.00, 0.99, 1.00, 0.98, 0.99]),
    ("autocorrelation", [3.8, 2.2, 1.5, 1.11, 1.07, 1.04, 1.06]),
    ("improved-autocorrelation", [3.1, 1.9, 1.4, 1.10, 1.07, 1.05, 1.06]),
    ("fesa", [1.17, 1.17, 1.23, 1.09, 1.06, 1.04, 1.05]),
    ("fesa-corrected", [1.17, 1.17, 1.16, 1.07, 1.05, 1.05, 1.04]),
    ("kay", [0.0, 0.0, 0.0, 0.0, 1.00, 0.98, 0.99]),
    ("fitz", [1.03, 1.05, 1.01, 1.02, 1.02, 1.00, 1.01]),
    ("ml", [1.00, 1.02, 1.00, 0.99, 1.00, 0.98, 0.99]),
    ("least-squares", [1.01, 1.03, 1.01, 1.00, 1.00, 0.99, 1.00]),
];

/// Sweeps that [`ratios`] runs.
pub const RATIOS: u64 = LEVELS_DB.len() as u64;

/// Every method over the bound.
pub fn ratios(lab: &Lab) -> Result<Section, String> {
    let iq = Method::ALL.iter().filter(|method| method.fits::<Iq>()).map(|method| method.name());
    let names: Vec<&str> = iq.chain(Reference::ALL.iter().map(|r| r.about().name)).collect();
    let sweep = lab.sweep(&names.join(","), lab.trials(4000, 150))?;
    let mut columns = Vec::new();
    for (level, snr_db) in LEVELS_DB.into_iter().enumerate() {
        columns.push(
            lab.run::<Iq>(&Sweep { seed: lab.seed + level as u64, ..sweep.clone() }, snr_db)?,
        );
    }
    let head = ["method".to_owned()].into_iter().chain(LEVELS_DB.map(|db| format!("{db} dB")));
    let mut table = Table::new(head);
    let mut checks = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let stated = STATED.iter().find(|row| row.0 == *name);
        let mut cells = vec![(*name).to_owned()];
        for (level, column) in columns.iter().enumerate() {
            let row = &column[index];
            let (ratio, error) = row.over_bound();
            let figure = stated.map_or(0.0, |row| row.1[level]);
            let (snr_db, measured) = (LEVELS_DB[level], plus_minus(ratio, error));
            if figure > 0.0 {
                cells.push(format!("{measured} ({figure})"));
                // Rife's few wrong directions make its error: a short run sees none, and knows of none.
                if lab.quick && *name == "rife" && snr_db > 20.0 {
                    continue;
                }
                let digit = if figure < 2.0 { 0.005 / figure } else { 0.015 };
                let text = format!("{name}, RMSE / bound at {snr_db} dB");
                checks.push(Check::near(text, ratio, error, figure, 0.01 + digit));
            } else {
                cells.push(measured);
            }
        }
        table.row(cells);
    }
    Ok(Section {
        title: "Every method over the Cramér-Rao bound",
        text: vec![format!(
            "Complex tones, N = 1024, offset uniform, 64-bit floats, {} records a column; in brackets the same by an independent \
             implementation. Kay's method is unusable below some 10 dB. The two under Hann's window pay for it with \
             resolution and earn it where other lines leak in.",
            lab.trials(4000, 150)
        )],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

/// dB at which one record in 10^2, 10^3 and 10^4 is an outlier.
const THRESHOLDS: [(usize, [f64; 3]); 5] = [
    (256, [-10.2, -8.7, -7.6]),
    (512, [-12.9, -11.6, -10.4]),
    (1024, [-15.7, -14.4, -13.3]),
    (2048, [-18.4, -17.2, -16.2]),
    (4096, [-21.2, -20.0, -19.1]),
];

/// Sweeps that [`outliers`] runs.
pub const OUTLIERS: u64 = 5 + 1;

/// The probability that the largest bin is not the tone's or next to it, complex, offset uniform. The bins about the tone
/// are drawn; that one of the many others exceeds them has a formula. With its standard error.
fn outlier_probability(n: usize, snr_db: f64, trials: usize, seed: u64) -> (f64, f64) {
    const AROUND: i32 = 8;
    let power = n as f64 * 10f64.powf(snr_db / 10.0);
    let others = n as f64 - f64::from(2 * AROUND + 1);
    let one = |trial: usize| {
        let mut rng = generator(seed, trial as u64);
        let delta: f64 = rng.random_range(-0.5..0.5);
        let (mut near, mut far) = (0.0f64, 0.0f64);
        for i in -AROUND..=AROUND {
            let u = delta - f64::from(i);
            let sinc = if u.abs() < 1e-9 {
                1.0
            } else {
                (PI * u).sin() / (n as f64 * (PI * u / n as f64).sin())
            };
            let mut part = || rng.sample::<f64, _>(StandardNormal) / 2f64.sqrt();
            let bin = (power.sqrt() * sinc + part()).powi(2) + part().powi(2);
            let most = if i.abs() <= 1 { &mut near } else { &mut far };
            *most = most.max(bin);
        }
        if far > near { 1.0 } else { -(others * (-(-near).exp()).ln_1p()).exp_m1() }
    };
    let drawn: Vec<f64> = (0..trials).into_par_iter().map(one).collect();
    let mean = |power: i32| drawn.iter().map(|p| p.powi(power)).sum::<f64>() / trials as f64;
    (mean(1), ((mean(2) - mean(1) * mean(1)).max(0.0) / trials as f64).sqrt())
}

/// From which signal-to-noise ratio on the peak is the tone.
pub fn outliers(lab: &Lab) -> Result<Section, String> {
    let trials = lab.trials(40_000, 4000);
    let mut table =
        Table::new(["N (complex; real: 2N)", "1 in 100, dB", "1 in 1000, dB", "1 in 10000, dB"]);
    let mut series = Vec::new();
    let mut checks = Vec::new();
    for (index, (n, stated)) in THRESHOLDS.into_iter().enumerate() {
        let from = stated[0] - 4.0;
        let curve: Vec<(f64, (f64, f64))> = (0..=18)
            .map(|step| from + 0.5 * f64::from(step))
            .map(|db| (db, outlier_probability(n, db, trials, lab.seed)))
            .collect();
        lab.bar.inc(1);
        let mut cells = vec![n.to_string()];
        for (share, stated) in [1e-2, 1e-3, 1e-4].into_iter().zip(stated) {
            let (found, error) = where_it_falls_below(&curve, share);
            cells.push(format!("{} ({stated})", plus_minus(found, error)));
            let figure = format!("outliers, N = {n}, {share:e}: at dB");
            checks.push(Check::between(figure, found, error, stated - 0.2, stated + 0.2));
        }
        table.row(cells);
        let points = curve.iter().map(|&(db, (share, _))| (db, share));
        let errors = curve.iter().map(|&(_, (_, error))| error);
        let line = Series::new(format!("N = {n}"), Style::Line, index, points);
        series.push(line.with_errors(errors));
    }
    // The whole way, from samples, at one point.
    let sweep = lab.sweep("least-squares", lab.trials(40_000, 2000))?;
    let rows = lab.run::<Iq>(&Sweep { n: 256, bin: 64.0, ..sweep }, -10.2)?;
    let share = rows[0].outliers as f64 / rows[0].trials as f64;
    let error = (0.01 / rows[0].trials as f64).sqrt();
    checks.push(Check::near(
        "outliers of whole records, N = 256, -10.2 dB",
        share,
        error,
        0.01,
        0.15,
    ));
    let whole = Series::new("whole records", Style::Points, 0, [(-10.2, share)]);
    series.push(whole.with_errors([error]));
    Ok(Section {
        title: "Outliers: where the largest bin is not the tone",
        text: vec![
            "No method that starts from the largest bin works below its threshold; detection, not estimation, is then the \
             limit. A real record of N samples is a complex one of N/2. Offset uniform; in brackets the same by an \
             independent implementation."
                .into(),
        ],
        charts: vec![Chart {
            name: "outliers",
            title: "Probability of an outlier (more than 1.5 bins off), complex records".into(),
            x: Axis::linear("signal-to-noise ratio, dB", -26.0, -5.0),
            y: Axis::log("probability", 1e-5, 1.0),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

/// Where a falling curve of values with standard errors passes a level, by straight lines between the points' logarithms; with its
/// standard error.
fn where_it_falls_below(curve: &[(f64, (f64, f64))], level: f64) -> (f64, f64) {
    let step = curve.windows(2).find(|w| w[0].1.0 >= level && w[1].1.0 < level);
    step.map_or((f64::NAN, f64::NAN), |w| {
        let [(from, (high, high_error)), (to, (low, low_error))] = [w[0], w[1]];
        let slope = (low / high).ln() / (to - from);
        let error = (high_error / high).max(low_error / low) / slope.abs();
        (from + (level / high).ln() / slope, error)
    })
}

/// Sweeps that [`image_floors`] runs.
pub const IMAGE_FLOORS: u64 = FLOOR_BINS.len() as u64 + 3;
const FLOOR_BINS: [f64; 8] = [3.0, 5.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0];
const FLOOR_METHODS: &str = "z-rife,quinn2,haqse,candan,least-squares-real";

/// Floors in bins at bins 5 and 256 without noise, then RMSE over the bound of 12-bit codes at bin 5 and 30 dB, bin 5 and
/// 60 dB, bin 256 and 60 dB, of an independent implementation.
const FLOORS: [(&str, [f64; 5]); 4] = [
    ("z-rife", [1.4e-2, 4e-4, 23.6, 756.0, 22.6]),
    ("quinn2", [1.2e-2, 3.5e-4, 20.7, 665.0, 19.5]),
    ("haqse", [1.6e-2, 4.7e-4, 27.6, 880.0, 26.3]),
    ("candan", [1.9e-3, 1.7e-6, 3.5, 103.0, 1.54]),
];

/// What the mirror image of a real tone costs.
pub fn image_floors(lab: &Lab) -> Result<Section, String> {
    let sweep = lab.sweep(FLOOR_METHODS, lab.trials(2000, 300))?;
    let mut clean = Vec::new();
    for bin in FLOOR_BINS {
        clean.push(lab.run::<Real>(&Sweep { bin, ..sweep.clone() }, f64::INFINITY)?);
    }
    let mut noisy = Vec::new();
    for (bin, snr_db) in [(5.0, 30.0), (5.0, 60.0), (256.0, 60.0)] {
        let width = Width::Codes(Codes::signed::<12>());
        noisy.push(lab.run::<Real>(&Sweep { bin, width, ..sweep.clone() }, snr_db)?);
    }
    let mut table = Table::new([
        "method",
        "floor at bin 5, bins",
        "floor at bin 256, bins",
        "30 dB, bin 5: RMSE / bound",
        "60 dB, bin 5: RMSE / bound",
        "60 dB, bin 256: RMSE / bound",
    ]);
    let mut series = Vec::new();
    let mut checks = Vec::new();
    for (index, name) in FLOOR_METHODS.split(',').enumerate() {
        let floors = [&clean[1][index], &clean[7][index]];
        let floors = floors.map(|row: &Row| (row.rmse_bins, row.rmse_se_bins));
        let noisy = [0, 1, 2].map(|i: usize| &noisy[i][index]);
        let ratios = noisy.map(Row::over_bound);
        let measured: Vec<(f64, f64)> = floors.into_iter().chain(ratios).collect();
        let stated = FLOORS.iter().find(|row| row.0 == name);
        let cell = |(place, &(value, error)): (usize, &(f64, f64))| {
            let value = match place {
                0 | 1 => format!("{value:.1e} ± {error:.0e}"),
                _ => plus_minus(value, error),
            };
            stated.map_or(value.clone(), |row| format!("{value} ({})", row.1[place]))
        };
        table.row([name.to_owned()].into_iter().chain(measured.iter().enumerate().map(cell)));
        let what = [
            "floor at bin 5",
            "floor at bin 256",
            "30 dB, bin 5",
            "60 dB, bin 5",
            "60 dB, bin 256",
        ];
        for (place, &(value, error)) in measured.iter().enumerate() {
            let figure = format!("{name}, real samples, {}", what[place]);
            checks.push(match stated {
                Some(row) => Check::near(figure, value, error, row.1[place], 0.06),
                None if place < 2 => Check::between(figure, value, 0.0, 0.0, 1e-9),
                None => Check::between(figure, value, error, 0.97, 1.05),
            });
        }
        let points =
            FLOOR_BINS.into_iter().zip(&clean).map(|(bin, rows)| (bin, rows[index].rmse_bins));
        let errors = clean.iter().map(|rows| rows[index].rmse_se_bins);
        series.push(Series::new(name, Style::Marked, index, points).with_errors(errors));
    }
    Ok(Section {
        title: "Real samples: the floor of the mirror image",
        text: vec![
            "A real tone has an image at the negative frequency whose leakage a method for complex tones takes for part of the \
             line. The papers do not mention it. RMSE without noise over random phases and offsets, N = 1024; then 12-bit \
             codes; in brackets an independent implementation. Least squares has the image in its model: what is left is \
             rounding of 64-bit floats."
                .into(),
        ],
        charts: vec![Chart {
            name: "image-floors",
            title: "Error without noise on real samples, N = 1024".into(),
            x: Axis::log("bin of the tone", 3.0, 256.0),
            y: Axis::log("RMSE, bins", 1e-17, 1.0),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

/// Sweeps that [`fixed_point`] runs.
pub const FIXED_POINT: u64 = 4 * 4;

/// What the firmware's integers cost.
pub fn fixed_point(lab: &Lab) -> Result<Section, String> {
    let head = ["amplitude in codes, SNR".to_owned()].into_iter();
    let mut table =
        Table::new(head.chain(Numbers::ALL.map(|a| format!("{}: RMSE / bound", a.name()))));
    let mut checks = Vec::new();
    for (amplitude, snr_db) in
        [(None, 60.0), (Some(256.0), 40.0), (Some(64.0), 20.0), (Some(4.0), 10.0)]
    {
        let plan = lab.sweep("least-squares-real", lab.trials(8000, 600))?;
        let mut ratios = Vec::new();
        for numbers in Numbers::ALL {
            let sweep = Sweep {
                numbers,
                amplitude,
                estimators: parse("least-squares-real", Reach::Eight)?,
                width: Width::Codes(Codes::signed::<12>()),
                ..plan.clone()
            };
            let row = lab.run::<Real>(&sweep, snr_db)?.remove(0);
            // Rounding to codes is noise too.
            let full = crate::sweep::full_amplitude(sweep.width, snr_db);
            let tone = amplitude.unwrap_or(full).powi(2) / 2.0;
            let noise = tone / 10f64.powf(snr_db / 10.0);
            let with_rounding = ((noise + 1.0 / 12.0) / noise).sqrt();
            let of = |x: Option<f64>| x.unwrap_or(f64::NAN) / with_rounding;
            ratios.push((of(row.ratio), of(row.ratio_se)));
        }
        let what = amplitude.map_or("full scale".into(), |a: f64| a.to_string());
        let name = format!("{what}, {snr_db} dB");
        let cells = ratios.iter().map(|&(ratio, error)| plus_minus(ratio, error));
        table.row([name.clone()].into_iter().chain(cells));
        let exact = ratios[0].0;
        for (numbers, (ratio, error)) in Numbers::ALL.into_iter().zip(&ratios).skip(1) {
            // Both have equal records: the quotient's own error is far below either's.
            let figure = format!("{} over f64, {name}", numbers.name());
            checks.push(Check::between(figure, ratio / exact, 0.1 * error, 0.98, 1.02));
        }
    }
    Ok(Section {
        title: "What the firmware's integers cost",
        text: vec![format!(
            "Least squares over 17 bins on real 12-bit samples, N = 1024, {} records a row; the bound counts rounding to codes as \
             noise. target: integer FFT, then 32-bit floats, as on cores with an FPU. target-fixed: integers in every loop over \
             bins, as on cores without.",
            lab.trials(8000, 600)
        )],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

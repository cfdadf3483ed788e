//! The lidar paper: Ye et al. 2022, doi:10.3788/IRLA20220222.

use super::lab::{Check, Lab, Section, Table, plus_minus};
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::simulate::{Kind, Signal, Width, generator};
use crate::sweep::{Offsets, Row, Sweep};
use picket_dsp::acquire::sample::{Iq, Real};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;

/// Samples in a record.
pub(super) const N: usize = 1024;
/// Hertz in a bin of the paper's simulation.
const BIN_HZ: f64 = 250e6 / N as f64;
/// Points across a bin.
const POINTS: usize = 15;

/// The paper's Table 2 at -10 dB, in hertz: mean error and RMSE of Rife and Z-Rife. (Z-Rife's mean error from the
/// abstract: 69.6 % below Rife's.)
const TABLE_2: [(&str, f64, f64); 2] =
    [("rife", 35598.0, 37258.0), ("z-rife", 35598.0 * (1.0 - 0.696), 18371.0)];

/// Sweeps that [`across_a_bin`] runs.
pub const ACROSS_A_BIN: u64 = 2 * POINTS as u64 + SHOTS as u64;
/// Runs of fifteen single shots.
const SHOTS: usize = 20;

/// The transform of a record.
pub(super) fn transform(record: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let mut spectrum = record.to_vec();
    f64::forward(spectrum.len()).process(&mut spectrum);
    spectrum
}

/// Figure 2: magnitudes and phase angles about the peak, which is all that Rife and Z-Rife look at.
pub fn spectrum(_: &Lab) -> Result<Section, String> {
    let bins = 64.2;
    let mut signal = Signal::tone(bins, 1.0, f64::INFINITY);
    signal.width = Width::Float;
    signal.lines[0].phase = Some(0.5);
    let spectrum = transform(&signal.record::<Iq>(N, &mut generator(0, 0)));
    let around = 60..=68usize;
    let peak = spectrum[64];
    let magnitude = around.clone().map(|k| (k as f64, spectrum[k].norm() / peak.norm()));
    let angle = |k: usize| (spectrum[k] * peak.conj()).arg().abs() / std::f64::consts::PI;
    let angles: Vec<(f64, f64)> = around.map(|k| (k as f64, angle(k))).collect();
    let [left, right] = [63, 65].map(angle);
    Ok(Section {
        title: "Lidar paper, Figure 2: what the bins about a line show",
        text: vec![
            format!(
                "A complex tone at bin {bins}, N = {N}, without noise. Magnitude alone tells the direction by which \
                 neighbour is larger; near a bin both are small and noise decides. The phase tells it however small \
                 they are: the neighbour on the tone's own side has the opposite phase. That is the idea of Z-Rife \
                 (eqs 15 and 16); here it is one real part, Re{{(X- - X+) conj(X0)}}."
            ),
            "Eq 10 compares phase differences without wrapping them into ±π. Taken literally it errs by 3 to 900 \
             times the bound; it must be wrapped. Eqs 4 and 7 carry a factor 1/2 that a complex tone does not have. \
             (The paper's own curves were not at hand: this is the same quantity, computed.)"
                .into(),
        ],
        charts: vec![Chart {
            name: "lidar-figure-2",
            title: format!("Bins about a tone at {bins}: magnitude, and phase against the peak's"),
            x: Axis::linear("bin", 60.0, 68.0),
            y: Axis::linear("magnitude / peak;  |phase| / π", 0.0, 1.1),
            series: vec![
                Series::new("magnitude", Style::Marked, 0, magnitude),
                Series::new("|phase angle| / π", Style::Points, 1, angles),
            ],
        }],
        tables: Vec::new(),
        checks: vec![
            Check::between("phase of the neighbour away from the tone, |angle| / π", left, 0.0, 0.0, 0.1),
            Check::between("phase of the neighbour towards the tone, |angle| / π", right, 0.0, 0.9, 1.0),
        ],
        ..Section::default()
    })
}

/// RMSE and mean error over all points, each with its standard error, from one row for each point.
fn pooled(rows: &[&Row]) -> [(f64, f64); 2] {
    let count = rows.len() as f64;
    let square = rows.iter().map(|r| r.rmse_bins.powi(2)).sum::<f64>() / count;
    let variance = rows.iter().map(|r| (2.0 * r.rmse_bins * r.rmse_se_bins).powi(2)).sum::<f64>();
    let rmse = square.sqrt();
    let mean = rows.iter().map(|r| r.mean_abs_bins).sum::<f64>() / count;
    let mean_variance = rows.iter().map(|r| r.mean_abs_se_bins.powi(2)).sum::<f64>();
    let hertz = |value: f64, error: f64| (value * BIN_HZ, error * BIN_HZ);
    [hertz(rmse, variance.sqrt() / count / (2.0 * rmse)), hertz(mean, mean_variance.sqrt() / count)]
}

fn points<R: Kind>(lab: &Lab, methods: &str) -> Result<Vec<Vec<Row>>, String> {
    let at = |point: usize| {
        let delta = point as f64 / (POINTS - 1) as f64 - 0.5;
        let plan = lab.sweep(methods, lab.trials(2000, 100))?;
        let seed = lab.seed + 100 + point as u64;
        lab.run::<R>(&Sweep { offsets: Offsets::Fixed(delta), seed, ..plan }, -10.0)
    };
    (0..POINTS).map(at).collect()
}

/// Figure 4 and Table 2: errors at points across a bin.
pub fn across_a_bin(lab: &Lab) -> Result<Section, String> {
    let real = points::<Real>(lab, "rife,z-rife,least-squares-real")?;
    let iq = points::<Iq>(lab, "rife,z-rife,least-squares")?;
    let column = |rows: &[Vec<Row>], index: usize| -> Vec<Row> {
        rows.iter().map(|point| point[index].clone()).collect()
    };
    let mut table = Table::new([
        "method, samples",
        "paper: mean error Hz",
        "paper: RMSE Hz",
        "measured: mean error Hz",
        "measured: RMSE Hz",
        "outliers",
    ]);
    let mut checks = Vec::new();
    let mut series = Vec::new();
    let bars: [[(f64, f64); 3]; 2] = [
        [(41500.0, 45000.0), (17400.0, 18700.0), (0.0, 14150.0)],
        [(30500.0, 33000.0), (12250.0, 12850.0), (0.0, 9850.0)],
    ];
    for ((rows, kind), bars) in [(&real, "real"), (&iq, "I/Q")].into_iter().zip(bars) {
        for (index, (low, high)) in bars.into_iter().enumerate() {
            let rows = column(rows, index);
            let name = rows[0].method;
            let [(rmse, error), (mean, mean_error)] = pooled(&rows.iter().collect::<Vec<_>>());
            let outliers: u64 = rows.iter().map(|row| row.outliers).sum();
            let printed = TABLE_2.iter().find(|row| row.0 == name && kind == "real");
            let paper = |pick: fn(&(&str, f64, f64)) -> f64| {
                printed.map_or("-".into(), |row| format!("{:.0}", pick(row)))
            };
            table.row([
                format!("{name}, {kind}"),
                paper(|row| row.1),
                paper(|row| row.2),
                format!("{mean:.0} ± {mean_error:.0}"),
                format!("{rmse:.0} ± {error:.0}"),
                outliers.to_string(),
            ]);
            checks.push(Check::between(
                format!("RMSE of {name}, {kind}, Hz"),
                rmse,
                error,
                low,
                high,
            ));
            if kind == "real" {
                let at = |(point, row): (usize, &Row)| {
                    (point as f64 / (POINTS - 1) as f64 - 0.5, row.rmse_bins * BIN_HZ / 1e3)
                };
                let points: Vec<_> = rows.iter().enumerate().map(at).collect();
                let errors = rows.iter().map(|row| row.rmse_se_bins * BIN_HZ / 1e3);
                series.push(Series::new(name, Style::Marked, index, points).with_errors(errors));
            }
        }
    }
    let bound = real[0][0].bound_bins * BIN_HZ / 1e3;
    series.push(Series::new("bound", Style::Dashed, 6, [(-0.5, bound), (0.5, bound)]));
    let [(low, low_error), (high, high_error), (closest, _)] = single_shots(lab)?;
    checks.push(Check::between(
        "Rife, fifteen single shots: 2.5 % of RMSEs below, kHz",
        low,
        low_error,
        15.0,
        23.0,
    ));
    checks.push(Check::between(
        "Rife, fifteen single shots: 2.5 % of RMSEs above, kHz",
        high,
        high_error,
        58.0,
        78.0,
    ));
    checks.push(Check::between(
        "Rife: largest mean error / RMSE of fifteen shots",
        closest,
        0.0,
        0.4,
        0.955,
    ));
    Ok(Section {
        title: "Lidar paper, Figure 4 and Table 2: across one bin",
        text: vec![
            format!(
                "250 MS/s, N = {N}, about 15.625 MHz (bin 64), -10 dB, {POINTS} points from -0.5 to +0.5 bin, {} records \
                 each. The paper's Z-Rife figure is that of a real tone.",
                lab.trials(2000, 100)
            ),
            format!(
                "The paper took one shot at each point. Of the RMSEs of fifteen single shots 95 % lie between {} and {} kHz in {} \
                 runs here, and the paper's 37.3 kHz for Rife is one of them. Its mean error of 35.6 kHz \
                 beside that RMSE (a ratio of 0.955) did not occur: the largest ratio was {closest:.2}.",
                plus_minus(low, low_error),
                plus_minus(high, high_error),
                lab.trials(1000, 200)
            ),
        ],
        charts: vec![Chart {
            name: "lidar-figure-4",
            title: "RMSE across one bin: real samples, -10 dB".into(),
            x: Axis::linear("offset from the bin, bins", -0.5, 0.5),
            y: Axis::linear("RMSE, kHz", 0.0, 80.0),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

/// Of runs of fifteen single shots of Rife, each with its standard error: the RMSE that 2.5 % stay below and the one that 2.5 %
/// exceed, in kHz; the largest ratio of mean error to RMSE, which has none.
fn single_shots(lab: &Lab) -> Result<[(f64, f64); 3], String> {
    let runs = lab.trials(1000, 200);
    let plan = lab.sweep("rife", 1)?;
    let mut seen: Vec<(f64, f64)> = Vec::new();
    for part in 0..SHOTS {
        let each = runs / SHOTS;
        for run in 0..each {
            let seed = lab.seed + 1000 + (part * each + run) as u64;
            let offsets = Offsets::Points(POINTS);
            let rows = Sweep { offsets, seed, ..plan.clone() }
                .run::<Real>(-10.0, &indicatif::ProgressBar::hidden())?;
            seen.push((rows[0].rmse_bins * BIN_HZ, rows[0].mean_abs_bins / rows[0].rmse_bins));
        }
        lab.bar.inc(1);
    }
    let closest = seen.iter().map(|s| s.1).fold(0.0, f64::max);
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: f64| seen[((seen.len() - 1) as f64 * share.clamp(0.0, 1.0)) as usize].0;
    // The number of runs below a share of all has a binomial's deviation.
    let share = |share: f64| {
        let spread = (share * (1.0 - share) / seen.len() as f64).sqrt();
        (at(share) / 1e3, (at(share + spread) - at(share - spread)) / 2e3)
    };
    Ok([share(0.025), share(0.975), (closest, 0.0)])
}

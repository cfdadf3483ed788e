//! The README's picture: ours and the others over the signal-to-noise ratio on real samples.

use super::lab::{Check, Lab, Section, Table, plus_minus};
use crate::arithmetic::Arithmetic;
use crate::exact::Numbers;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::simulate::Width;
use crate::sweep::{Row, Sweep};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};

/// Sweeps that [`over_snr`] runs.
pub const OVER_SNR: u64 = 2 * SNR_DB.len() as u64;
const SNR_DB: [f64; 13] =
    [-12.0, -10.0, -8.0, -5.0, 0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0];
/// The methods of the README's picture, on real samples.
pub const README_METHODS: &str = "least-squares-real,z-rife,quinn2,haqse";

/// The sweep behind a point of the README's picture, real samples.
pub fn readme_sweep(lab: &Lab, methods: &str) -> Result<Sweep, String> {
    let plan = lab.sweep(methods, lab.trials(4000, 150))?;
    let width = Width::Codes(Codes::signed::<12>());
    Ok(Sweep { numbers: Numbers::Library(Arithmetic::Target), width, bin: 5.0, ..plan })
}

/// The picture of the README: ours and the others over the signal-to-noise ratio on real samples.
pub fn over_snr(lab: &Lab) -> Result<Section, String> {
    let mut real = Vec::new();
    let mut iq = Vec::new();
    for snr_db in SNR_DB {
        real.push(lab.run::<Real>(&readme_sweep(lab, README_METHODS)?, snr_db)?);
        iq.push(lab.run::<Iq>(&readme_sweep(lab, "fesa")?, snr_db)?);
    }
    let over = |rows: &[Vec<Row>], pick: &dyn Fn(&[Row]) -> f64| -> Vec<(f64, f64)> {
        SNR_DB.into_iter().zip(rows).map(|(db, rows)| (db, pick(rows))).collect()
    };
    let name = ["ours: least squares", "Z-Rife", "Quinn, second", "HAQSE"];
    let mut series: Vec<Series> = (0..4)
        .map(|index| {
            let points = over(&real, &|rows| rows[index].rmse_bins);
            let errors = real.iter().map(|rows| rows[index].rmse_se_bins);
            Series::new(name[index], Style::Marked, index, points).with_errors(errors)
        })
        .collect();
    let fesa = over(&iq, &|rows| rows[0].rmse_bins);
    let errors = iq.iter().map(|rows| rows[0].rmse_se_bins);
    series.push(Series::new("FESA, on I/Q", Style::Marked, 4, fesa).with_errors(errors));
    series.push(Series::new(
        "bound, real",
        Style::Dashed,
        6,
        over(&real, &|rows| rows[0].bound_bins),
    ));
    series.push(Series::new("bound, I/Q", Style::Dashed, 7, over(&iq, &|rows| rows[0].bound_bins)));
    let head = ["SNR dB"].into_iter().chain(name).chain(["FESA, on I/Q"]);
    let mut table =
        Table::new(head.map(|name| {
            if name == "SNR dB" { name.into() } else { format!("{name}: RMSE / bound") }
        }));
    let mut checks = Vec::new();
    for ((snr_db, real), iq) in SNR_DB.into_iter().zip(&real).zip(&iq) {
        let cells = real.iter().chain(iq).map(|row| {
            let (ratio, error) = row.over_bound();
            plus_minus(ratio, error)
        });
        table.row([snr_db.to_string()].into_iter().chain(cells));
        let (ratio, error) = real[0].over_bound();
        if snr_db >= -8.0 {
            let figure = format!("ours on real samples at bin 5, {snr_db} dB, RMSE / bound");
            checks.push(Check::between(figure, ratio, error, 0.97, 1.06));
        }
    }
    Ok(Section {
        title: "Ours and the others over the signal-to-noise ratio",
        text: vec![format!(
            "Real 12-bit samples, N = 1024, a tone about bin 5 with any offset and phase, the firmware's arithmetic, {} records a \
             point. FESA cannot work on real samples and is shown on I/Q, where the bound is lower by √2. Outliers are left \
             out; the threshold is near -12 dB.",
            lab.trials(4000, 150)
        )],
        charts: vec![Chart {
            name: "over-snr",
            title: "Real 12-bit samples, N = 1024, tone near bin 5".into(),
            x: Axis::linear("signal-to-noise ratio, dB", -12.0, 60.0),
            y: Axis::log("RMSE, bins", 1e-5, 0.3),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

//! The Doppler paper's turntable with what its experiment had: a rough rim, whose speckle bends the echo.

use super::lab::{Check, Lab, Section, Table, plus_minus};
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::{Row, TURNTABLE_BARS, record, sensor, turntable, turntable_rows};
use picket_dsp::acquire::sample::Iq;
use picket_dsp::config::Config;
use picket_dsp::pipeline::Outcome;
use picket_dsp::{Carrier, Pipeline, Stamp, Usable};
use picket_simulator::Scene;

/// Samples in a record.
const N: usize = 1024;
/// Diameters of the beam's spot, where its light is down by `exp(-2)`, m. The paper tells none.
const SPOTS_M: [f64; 3] = [0.5e-3, 1e-3, 2e-3];
/// The rims that [`rough`] measures.
pub const ROUGH: u64 = 11 * SPOTS_M.len() as u64;
/// Signal-to-noise ratio of a sample, dB, and the amplitude of the echo, codes: speckle is up to three times as strong.
const SNR_DB: f64 = 0.0;
const AMPLITUDE: f64 = 200.0;

/// What the records of a rim show.
#[derive(Default)]
struct Rim {
    records: usize,
    usable: usize,
    beyond: usize,
    /// Of the usable ones, squared m/s and squared sigmas.
    squares: f64,
    chi2: f64,
}

impl Rim {
    /// Measures records of a rim of this speed below a spot, by a carrier whose envelope is stated.
    fn of(
        sensor: &Scene,
        row: &Row,
        spot_m: f64,
        trials: usize,
        seed: u64,
    ) -> Result<Self, String> {
        let envelope_hz = (1.06 * row.velocity_mps.abs() / spot_m) as f32;
        let carrier = Carrier { envelope_hz, ..Carrier::default() };
        let plan = Config { carrier, ..turntable() }.plan::<Iq, N>();
        let mut pipeline =
            Box::new(Pipeline::<Iq, N>::new(plan.map_err(|error| error.to_string())?));
        let mut rim = Rim::default();
        let scene = row.scene(sensor, N, (AMPLITUDE, SNR_DB), Some(spot_m));
        let scene = Scene { seed, ..scene };
        for trial in 0..trials {
            let mut run = scene.run(trial as u64)?;
            let samples = record::<Iq>(&mut run, 0, N);
            let Some(samples) = samples.as_array() else { return Err("no whole record".into()) };
            rim.records += 1;
            let Outcome::Velocity(velocity) = pipeline.block(&Stamp::default(), samples).result
            else {
                return Err("no velocity".into());
            };
            if velocity.verdict.usable() > Usable::WithinSigma {
                continue;
            }
            let error = velocity.velocity.to_num::<f64>() - row.velocity_mps;
            let sigmas = error / f64::from(velocity.sigma);
            rim.usable += 1;
            rim.beyond += usize::from(sigmas.abs() > 5.0);
            rim.squares += error * error;
            rim.chi2 += sigmas * sigmas;
        }
        Ok(rim)
    }

    fn and(self, other: &Self) -> Self {
        Rim {
            records: self.records + other.records,
            usable: self.usable + other.usable,
            beyond: self.beyond + other.beyond,
            squares: self.squares + other.squares,
            chi2: self.chi2 + other.chi2,
        }
    }

    fn rms_mms(&self) -> f64 {
        1e3 * (self.squares / self.usable as f64).sqrt()
    }

    /// The errors are those of speckle: their squares scatter by more than normal numbers'.
    fn error_mms(&self) -> f64 {
        self.rms_mms() / (self.usable as f64).sqrt()
    }
}

/// Figure 5 with a rough rim.
pub fn rough(lab: &Lab) -> Result<Section, String> {
    let sensor = sensor::<Iq>(&turntable(), N, 0.0, 1);
    let rows: Vec<Row> =
        turntable_rows().into_iter().filter(|row| row.velocity_mps > 0.0).collect();
    let mut table = Table::new([
        "spot mm",
        "paper mm/s",
        "measured mm/s",
        "fastest rim's mm/s",
        "usable %",
        "of them beyond 5 sigma %",
        "mean (error / sigma)^2",
    ]);
    let (mut series, mut checks) = (Vec::new(), Vec::new());
    for (index, spot_m) in SPOTS_M.into_iter().enumerate() {
        let trials = lab.trials(400, 60);
        let measured = |row: &Row| {
            lab.bar.inc(1);
            Rim::of(&sensor, row, spot_m, trials, lab.seed)
        };
        let rims: Vec<Rim> = rows.iter().map(measured).collect::<Result<_, _>>()?;
        let all = rims.iter().fold(Rim::default(), Rim::and);
        let fastest = rims.last().map_or(f64::NAN, Rim::rms_mms);
        let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
        let (usable, beyond) = (share(all.usable, all.records), share(all.beyond, all.usable));
        let chi2 = all.chi2 / all.usable as f64;
        let millimetres = 1e3 * spot_m;
        table.row([
            millimetres.to_string(),
            "below 2".into(),
            plus_minus(all.rms_mms(), all.error_mms()),
            plus_minus(fastest, rims.last().map_or(f64::NAN, Rim::error_mms)),
            format!("{usable:.0}"),
            format!("{beyond:.2}"),
            format!("{chi2:.2}"),
        ]);
        let name = format!("rough rim below a spot of {millimetres} mm");
        if spot_m >= 1e-3 {
            let most = 1e3 * TURNTABLE_BARS.velocity_mps;
            let figure = format!("{name}, mm/s");
            checks.push(Check::between(figure, all.rms_mms(), all.error_mms(), 0.0, most));
        }
        let figure = format!("{name}, usable and beyond 5 sigma, %");
        // One block in a hundred is what the stated envelope promises.
        let error = share(1, all.usable) * (0.01 * all.usable as f64).sqrt();
        checks.push(Check::between(figure, beyond, error, 0.0, 1.0));
        let points = rows.iter().zip(&rims).map(|(row, rim)| (row.velocity_mps, rim.rms_mms()));
        let points = Series::new(format!("spot of {millimetres} mm"), Style::Marked, index, points);
        series.push(points.with_errors(rims.iter().map(Rim::error_mms)));
    }
    let paper = [0.0, 4.0].map(|speed| (speed, 1e3 * TURNTABLE_BARS.velocity_mps));
    series.push(Series::new("the paper's experiment: below", Style::Dashed, 7, paper));
    Ok(Section {
        title: "Doppler paper, Figure 5: the turntable's rim is rough",
        text: vec![
            "The same turntable at 0 dB with a rim that scatters: grains pass below the spot of the beam, so the echo's amplitude and phase \
             change within a time of diameter over speed. Its bandwidth, 1.06 times speed over diameter, is stated as the carrier's envelope, \
             and each block is measured by least squares in the firmware's arithmetic. The paper tells no diameter; with a spot of 1 mm or \
             more the usable blocks keep to the 2 mm/s that it reports."
                .into(),
        ],
        charts: vec![Chart {
            name: "doppler-figure-5-rough",
            title: "Turntable with a rough rim: error of usable blocks".into(),
            x: Axis::linear("speed of the rim, m/s", 0.0, 4.0),
            y: Axis::log("RMSE, mm/s", 0.05, 5.0),
            series,
        }],
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

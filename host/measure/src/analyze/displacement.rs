//! The way of the strongest target by its phase, from block to block or from chirp to chirp, and what swings in it.

use super::Style;
use super::carrier::Carrier;
use super::cut::{self, Cut};
use super::moved::{Moved, SWINGS, Swing, WayRecord, Ways};
use super::radar::Radar;
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::cli::print_line;
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::{views, with_record};
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::{Config, SPEED_OF_LIGHT};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::tone::lines::MOST;
use picket_dsp::{Scene, Shape, Verdict};
use picket_transform::num_complex::Complex;
use picket_wire::view;
use serde_json::json;
use std::path::Path;

/// What is known of the sensor.
#[derive(Clone, Copy, Debug)]
pub enum Sensor {
    /// A continuous wave of this carrier, Hz.
    Wave(Carrier),
    /// Sawtooth chirps.
    Chirps(Radar),
}

/// Follows the target through `file`.
///
/// # Errors
/// The recording cannot be read, or the sensor does not show a way.
pub fn run(
    file: &Path,
    cut: &Cut,
    n: Option<usize>,
    (sensor, told): (&Sensor, &Told),
    sink: &mut dyn FnMut(&Moved),
) -> Result<(Tally, Vec<Swing>), String> {
    let (recording, n, hop, skip, chirp) = match sensor {
        Sensor::Wave(_) => (cut.open(file)?, cut.n, cut.hop, cut.skip, None),
        Sensor::Chirps(radar) => {
            if radar.shape != Shape::Sawtooth {
                return Err("--displacement takes --shape sawtooth, or no --chirp-s".into());
            }
            let recording = Recording::open(file, cut.read).map_err(super::text)?;
            let ramps = radar.ramps(&recording, n, told.period_s, cut.read.axes.is_some())?;
            cut::assumed(file, &recording);
            let chirp = radar.chirp(recording.rate_hz(), &ramps, told.guard_s, told.curvature);
            (recording, ramps.n, ramps.hop, cut.skip + ramps.skip as u64, Some(chirp))
        }
    };
    if !recording.knows_rate() {
        return Err("a way needs the sample rate: add --rate HZ".into());
    }
    let rate_hz = recording.rate_hz();
    let (scene, period_s) = match (sensor, chirp) {
        (_, Some(chirp)) => (Scene::Chirp(chirp), told.period_s.unwrap_or(hop as f64 / rate_hz)),
        (Sensor::Wave(Carrier { hz, mixing }), None)
        | (Sensor::Chirps(Radar { carrier_hz: hz, mixing, .. }), None) => {
            if !recording.iq() {
                eprintln!("real samples of a continuous wave do not show the direction of a way");
            }
            let wavelength_m = SPEED_OF_LIGHT / hz;
            let scene = Scene::Doppler { wavelength_m, angle_rad: 0.0, mixing: *mixing };
            (scene, hop as f64 / rate_hz)
        }
    };
    let together = recording.frame().unwrap_or(u64::MAX);
    let ways = Ways::new(&scene, rate_hz, (n, recording.iq()), (period_s, together));
    let (mut ways, mut all) = (ways.map_err(super::text)?, Vec::new());
    let mut keep = |moved: &Moved| {
        all.push(*moved);
        sink(moved);
    };
    let how = (cut, hop, skip);
    let tally = with_record!(recording.iq(), n, R, N => follow::<R, N>(recording, how, &mut ways, &mut keep))?;
    let swings = ways.record(&all).map_or(Ok(Vec::new()), |record| swings(&record))?;
    Ok((tally, swings))
}

fn follow<R: Kind, const N: usize>(
    recording: Recording,
    (cut, hop, skip): (&Cut, usize, u64),
    ways: &mut Ways,
    sink: &mut dyn FnMut(&Moved),
) -> Result<Tally, String> {
    let rate_hz = recording.rate_hz();
    let config = Config {
        band_hz: cut.band_hz,
        reach: cut.reach,
        carrier: cut.width,
        ..Config::new(rate_hz, cut.codes)
    };
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(super::text)?));
    let mut blocks = recording.blocks(N, hop, skip);
    let mut tally = Tally::default();
    while let Some((clock, samples)) = blocks.next_block().map_err(super::text)? {
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        let sequence = tally.blocks as u32;
        tally.add(unfit);
        let line = unfit.is_none().then(|| {
            let stamp = Stamp { sequence, clock, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &record::<R, N>(&values));
            pipeline.lines(&measurement, MOST).first().copied()
        });
        if let Some(moved) = ways.push(clock, blocks.gap(), line.flatten().as_ref()) {
            sink(&moved);
        }
    }
    tally.check(cut.codes)?;
    Ok(tally)
}

/// What swings in a way.
fn swings(record: &WayRecord) -> Result<Vec<Swing>, String> {
    with_record!(false, record.codes.len(), R, N => lines::<R, N>(record))
}

fn lines<R: Kind, const N: usize>(record: &WayRecord) -> Result<Vec<Swing>, String> {
    let plan = record.config().plan::<R, N>().map_err(super::text)?;
    let mut pipeline = Box::new(Pipeline::<R, N>::new(plan));
    let mut codes = record.codes.iter();
    let samples = std::array::from_fn(|_| R::from_parts([*codes.next().unwrap_or(&0), 0]));
    let measurement = pipeline.block(&Stamp::default(), &samples);
    Ok(record.swings(&pipeline.lines(&measurement, SWINGS)))
}

/// Prints what stands above the ways.
pub fn print_heading(style: Style) {
    match style {
        Style::Json => {}
        Style::Csv => print_line("block,time_s,displacement_m,sigma_displacement_m,start,verdict"),
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>14} {:>10} {:>6}  verdict",
            "block", "time s", "way um", "sigma um", "start"
        )),
    }
}

/// Prints a block's way.
pub fn print(found: &Moved, style: Style) {
    let Moved { block, time_s, moved } = found;
    let view = view::Displacement::from_moved(moved);
    match style {
        Style::Json => {
            let mut all = json!({ "block": block, "time_s": time_s });
            for (name, value) in views::object(&view) {
                all[name] = value;
            }
            print_line(&all.to_string());
        }
        Style::Csv => {
            let cells: Vec<String> = views::cells(&view, "").into_iter().map(|it| it.1).collect();
            print_line(&format!("{block},{time_s},{}", cells.join(",")));
        }
        Style::Text => print_line(&format!(
            "{block:>8} {time_s:>11.4} {:>14.4} {:>10.4} {:>6}  {}",
            1e6 * view.displacement_m,
            1e6 * view.sigma_displacement_m,
            view.start,
            moved.verdict.name()
        )),
    }
}

/// Prints a swing.
pub fn print_swing(swing: &Swing, style: Style) {
    let tone = &swing.line.tone;
    let ([amplitude, sigma], [speed, sigma_speed]) = (swing.amplitude_m, swing.velocity_mps);
    match style {
        Style::Csv => {}
        Style::Json => print_line(
            &json!({
                "swing": true, "frequency_hz": tone.hertz(), "sigma_hz": tone.sigma_hertz(), "amplitude_m": amplitude,
                "sigma_amplitude_m": sigma, "velocity_mps": speed, "sigma_velocity_mps": sigma_speed, "verdict": tone.verdict.name(),
                "also": tone.also.iter().map(Verdict::name).collect::<Vec<_>>(),
            })
            .to_string(),
        ),
        Style::Text => print_line(&format!(
            "swings {:.4} +- {:.4} um at {:.5} +- {:.5} Hz: {:.3} +- {:.3} um/s, {}",
            1e6 * amplitude,
            1e6 * sigma,
            tone.hertz(),
            tone.sigma_hertz(),
            1e6 * speed,
            1e6 * sigma_speed,
            tone.verdict.name()
        )),
    }
}

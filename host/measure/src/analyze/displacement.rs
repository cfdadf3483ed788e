//! The way of the strongest target by its phase, from block to block or from chirp to chirp, and what swings in it.

use super::Style;
use super::carrier::Carrier;
use super::cut::{self, Cut};
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
use picket_dsp::solve::displacement::{Displacement, Unwrapper};
use picket_dsp::tone::lines::MOST;
use picket_dsp::{Codes, Scene, Shape, ToneWithPhase, Usable, Verdict};
use picket_transform::num_complex::Complex;
use picket_wire::view;
use serde_json::json;
use std::f64::consts::TAU;
use std::path::Path;

/// From chirp to chirp a target turns the phase by less than this share of a turn.
const MOST_TURNS: f32 = 0.25;

/// What is known of the sensor.
#[derive(Clone, Copy, Debug)]
pub enum Sensor {
    /// A continuous wave of this carrier, Hz.
    Wave(Carrier),
    /// Sawtooth chirps.
    Chirps(Radar),
}

/// Where a target is in a block, beside where it was at the start.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// The block's or the chirp's number.
    pub block: u64,
    /// The time of its middle, s.
    pub time_s: f64,
    /// Its way.
    pub moved: Displacement,
}

/// A swing of the target.
#[derive(Clone, Copy, Debug)]
pub struct Swing {
    /// Its line in the spectrum of the way.
    pub line: ToneWithPhase,
    /// To each side, m, with one standard deviation.
    pub amplitude_m: [f64; 2],
    /// The amplitude of its velocity, m/s, with one standard deviation.
    pub velocity_mps: [f64; 2],
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
    let unwrapper = Unwrapper::of_scene(&scene, rate_hz, n, recording.iq(), MOST_TURNS);
    let unwrapper = unwrapper.map_err(super::text)?;
    let (mut ways, mut all) = (Ways { unwrapper, period_s, together }, Vec::new());
    let mut keep = |moved: &Moved| {
        all.push(*moved);
        sink(moved);
    };
    let how = (cut, hop, skip);
    let tally = with_record!(recording.iq(), n, R, N => follow::<R, N>(recording, how, &mut ways, &mut keep))?;
    Ok((tally, swings(&all, 1.0 / period_s)?))
}

/// What the blocks' phases are followed by.
struct Ways {
    unwrapper: Unwrapper,
    period_s: f64,
    /// Chirps between pauses of unknown length.
    together: u64,
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
    let (mut number, mut tally, mut lost) = (0u64, Tally::default(), false);
    while let Some((clock, samples)) = blocks.next_block().map_err(super::text)? {
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        tally.add(unfit);
        lost |=
            blocks.gap() || unfit.is_some() || number > 0 && number.is_multiple_of(ways.together);
        let block = number;
        number += 1;
        if unfit.is_some() {
            continue;
        }
        let stamp = Stamp { sequence: block as u32, clock, gap: lost, ..Stamp::default() };
        let measurement = pipeline.block(&Stamp { gap: false, ..stamp }, &record::<R, N>(&values));
        let Some(line) = pipeline.lines(&measurement, MOST).first().copied() else {
            lost = true;
            continue;
        };
        lost = false;
        let moved = ways.unwrapper.push(&stamp, &line);
        sink(&Moved { block, time_s: (block as f64 + 0.5) * ways.period_s, moved });
    }
    tally.check(cut.codes)?;
    Ok(tally)
}

/// The lengths of a way whose spectrum is looked at.
const LENGTHS: [usize; 7] = [4096, 2048, 1024, 512, 256, 128, 64];

/// What swings in the longest stretch without a new start.
fn swings(all: &[Moved], rate_hz: f64) -> Result<Vec<Swing>, String> {
    let usable = |it: &Moved| it.moved.verdict.usable() <= Usable::WithinSigma;
    let together = |a: &Moved, b: &Moved| {
        usable(a) && usable(b) && a.moved.start == b.moved.start && a.block + 1 == b.block
    };
    let longest = all.chunk_by(together).max_by_key(|part| part.len()).unwrap_or_default();
    let Some(n) = LENGTHS.into_iter().find(|n| *n <= longest.len()) else { return Ok(Vec::new()) };
    let way: Vec<f64> = longest.iter().take(n).map(|it| it.moved.metres.to_num()).collect();
    let rest = beside_a_line(&way);
    let most = rest.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if most == 0.0 {
        return Ok(Vec::new());
    }
    let metres = most / 30_000.0;
    let words: Vec<Complex<f64>> = rest.iter().map(|x| Complex::new(x / metres, 0.0)).collect();
    with_record!(false, n, R, N => lines::<R, N>(&words, rate_hz, metres))
}

/// The lines of a record whose codes are so many metres.
fn lines<R: Kind, const N: usize>(
    words: &[Complex<f64>],
    rate_hz: f64,
    metres: f64,
) -> Result<Vec<Swing>, String> {
    let config = Config::new(rate_hz, Codes::signed::<16>());
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(super::text)?));
    let measurement = pipeline.block(&Stamp::default(), &record::<R, N>(words));
    let swing = |line: ToneWithPhase| {
        let amplitude_m = f64::from(line.tone.amplitude) * metres;
        // The relative error of an amplitude is that of the phase.
        let sigma_m = amplitude_m * f64::from(line.sigma_phase);
        let turn = TAU * line.tone.hertz();
        let velocity_mps = [turn * amplitude_m, turn * sigma_m];
        Swing { line, amplitude_m: [amplitude_m, sigma_m], velocity_mps }
    };
    let found = pipeline.lines(&measurement, 4).into_iter().map(swing);
    Ok(found.filter(|swing| swing.line.tone.verdict.usable() < Usable::No).collect())
}

/// What is left of numbers beside their straight line.
fn beside_a_line(all: &[f64]) -> Vec<f64> {
    let count = all.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = all.iter().sum::<f64>() / count;
    let places = || (0..all.len()).map(|place| place as f64 - middle);
    let square: f64 = places().map(|place| place * place).sum();
    let slope = places().zip(all).map(|(place, x)| place * x).sum::<f64>() / square;
    places().zip(all).map(|(place, x)| x - mean - slope * place).collect()
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

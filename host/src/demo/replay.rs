//! A recording through the firmware: a line for each block.

use super::feed::play;
use super::options::{Board, Options};
use super::{DemoError, pico, said};
use crate::band;
use crate::device::Said;
use crate::recording::{self, Recording};
use crate::simulate::Kind;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_dsp::pipeline::Outcome;
use picket_measure::length;
use picket_wire::telemetry::Telemetry;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// A measured block in SI units.
#[derive(Serialize)]
struct Line {
    block: u32,
    /// The middle of the block.
    time_s: f64,
    frequency_hz: f64,
    sigma_hz: f64,
    snr_db: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed_mps: Option<f64>,
    verdict: &'static str,
}

/// Replays `file` and prints a line for each block.
pub fn run(file: &Path, options: &Options) -> Result<ExitCode, DemoError> {
    length::check(options.n).map_err(said)?;
    let read = recording::Options { rate_hz: options.rate, iq: options.iq, ..Default::default() };
    let recording = Recording::open(file, read).map_err(said)?;
    if options.iq { replay::<Iq>(recording, options) } else { replay::<Real>(recording, options) }
}

fn replay<R: Kind>(recording: Recording, options: &Options) -> Result<ExitCode, DemoError> {
    if !recording.knows_rate() {
        return Err(said("the recording has no sample rate: add --rate HZ"));
    }
    let rate_hz = recording.rate_hz();
    let config = config(rate_hz, options)?;
    band::holds_a_bin(options.band, rate_hz, options.n, R::IQ).map_err(said)?;
    config.terms::<R>(options.n).map_err(said)?;
    let length = recording.length().ok_or_else(|| said("replay reads wav and int16 files"))?;
    let blocks = u32::try_from(length / options.n as u64).map_err(|_| said("too many blocks"))?;
    if options.board == Board::Pico {
        return on_pico(recording, config, options);
    }
    let mut source = recording.blocks(options.n, options.n, 0);
    // Without any the source says why.
    let block = (0..blocks.max(1)).map(|_| {
        let block = source.next_block().map_err(said)?;
        let (_, samples) = block.ok_or_else(|| said("the recording ended early"))?;
        Ok(samples.iter().map(|s| R::from_parts(s.code())).collect())
    });
    let mut arrived = 0;
    let listener = play::<R>("frontend_qemu", (config, options.n), block, options, |bar, said| {
        let Said::Telemetry(record) = said else { return };
        let line = Line::of(&record, rate_hz, options);
        bar.suspend(|| {
            if arrived == 0 && !options.json {
                outln!("{}", heading(options));
            }
            print_line(&line, options);
        });
        arrived += 1;
    })?;
    if arrived != blocks || listener.missing + listener.bad > 0 {
        return Err(said(format!("{arrived} of {blocks} blocks arrived")));
    }
    Ok(ExitCode::SUCCESS)
}

/// The largest sample of the recording comes to this distance from the middle of the Pico's codes.
const PEAK: f64 = 1900.0;

/// A real recording before the Pico's converter, which has twelve bits: its amplifier makes use of them.
fn on_pico(recording: Recording, config: Config, options: &Options) -> Result<ExitCode, DemoError> {
    let rate_hz = config.rate_hz;
    let mut samples: Vec<f64> = Vec::new();
    let mut source = recording.blocks(options.n, options.n, 0);
    while let Some((_, block)) = source.next_block().map_err(said)? {
        samples.extend(block.iter().map(|sample| f64::from(sample.code()[0])));
    }
    let peak = samples.iter().fold(1.0f64, |peak, sample| peak.max(sample.abs()));
    samples.iter_mut().for_each(|sample| *sample *= PEAK / peak);
    let records = pico::records(config, &samples)?;
    if !options.json {
        outln!("{}", heading(options));
    }
    for record in &records {
        print_line(&Line::of(record, rate_hz, options), options);
    }
    Ok(ExitCode::SUCCESS)
}

fn config(rate_hz: f64, options: &Options) -> Result<Config, DemoError> {
    let scene = match options.carrier_hz {
        None => Scene::Tone,
        Some(carrier) if carrier > 0.0 => Scene::Doppler {
            wavelength_m: SPEED_OF_LIGHT / carrier,
            angle_rad: 0.0,
            mixing: picket_dsp::Mixing::RxConjTx,
        },
        Some(carrier) => {
            return Err(said(format!("--carrier-hz {carrier}: give a positive frequency")));
        }
    };
    let defaults = Config::new(1.0, Codes::signed::<12>());
    Ok(Config {
        rate_hz,
        codes: Codes::signed::<16>(),
        band_hz: options.band,
        scene,
        method: options.method.unwrap_or(defaults.method),
        ..defaults
    })
}

fn heading(options: &Options) -> String {
    let speed = if options.carrier_hz.is_some() { "  speed m/s" } else { "" };
    format!("block  time s  frequency Hz     sigma Hz  SNR dB{speed}  verdict")
}

impl Line {
    fn of(record: &Telemetry, rate_hz: f64, options: &Options) -> Self {
        let measurement = &record.measurement;
        let tone = &measurement.tone;
        let middle = measurement.stamp.clock as f64 + options.n as f64 / 2.0;
        Line {
            block: measurement.stamp.sequence,
            time_s: middle / rate_hz,
            frequency_hz: tone.frequency.hertz(rate_hz),
            sigma_hz: f64::from(tone.sigma) * rate_hz,
            snr_db: tone.snr_db().into(),
            speed_mps: match measurement.result {
                Outcome::Velocity(velocity) => Some(velocity.velocity.to_num()),
                _ => None,
            },
            verdict: tone.verdict.name(),
        }
    }
}

fn print_line(line: &Line, options: &Options) {
    if options.json {
        match serde_json::to_string(line) {
            Ok(text) => outln!("{text}"),
            Err(error) => eprintln!("error: {error}"),
        }
        return;
    }
    let speed = line.speed_mps.map_or(String::new(), |speed| format!("  {speed:9.4}"));
    outln!(
        "{:5}  {:6.2}  {:12.4}  {:11.4}  {:6.1}{speed}  {}",
        line.block,
        line.time_s,
        line.frequency_hz,
        line.sigma_hz,
        line.snr_db,
        line.verdict
    );
}

//! A session as the board would send it: its measurements are by the firmware's pipeline on this machine.

use super::options::Options;
use super::{DemoError, said};
use crate::scenario::{record, sensor};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Iq;
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::Plan;
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_firmware::instrument;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_simulator::scene;
use picket_wire::boot::{Boot, Causes, Clock, Name};
use picket_wire::command::Answer;
use picket_wire::settings::{Drive, Settings};
use picket_wire::status::Status;
use picket_wire::telemetry::{Health, Telemetry};
use std::process::ExitCode;

/// Samples in a block, as the image has them.
const N: usize = 1024;
/// Segments, three a chirp.
const SEGMENTS: u64 = 30;
/// The echo, codes, and how far it is above the noise, dB.
const AMPLITUDE: f64 = 900.0;
const SNR_DB: f64 = 20.0;
/// The converters' offsets, codes.
const OFFSET: [f64; 2] = [37.0, -21.0];
/// Where the target is when the session begins, m, and how fast it comes nearer, m/s.
const RANGE_M: f64 = 90.0;
const VELOCITY_MPS: f64 = 14.0;

/// Writes the session.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let Some(file) = &options.record else {
        return Err(said(
            "a session is bytes: add --record FILE, which picket watch --replay FILE shows",
        ));
    };
    options.output.check(file, &[]).map_err(said)?;
    let bytes = session(options.seed).map_err(said)?;
    options.output.write(file, &bytes).map_err(said)?;
    let name = file.display();
    outln!(
        "{name}: {SEGMENTS} records in the board's frames: picket watch --replay {name} shows them"
    );
    Ok(ExitCode::SUCCESS)
}

/// Start, settings, ten chirps of three segments, a status: a target that comes nearer, [`SNR_DB`] above the noise.
fn session(seed: u64) -> Result<Vec<u8>, String> {
    let scene = Scene::Chirp(Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 0.0,
        ..Chirp::default()
    });
    let codes = Codes::unsigned::<12>();
    let band_hz = Some((-120e3, 120e3));
    let config = Config { scene, band_hz, ..Config::new(250e3, codes) };
    let drive = Drive::Dac { low: 400, high: 3600 };
    let settings = Settings { iq: true, config, guard: 32, drive, ..Settings::default() };
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    let refused =
        |error: &dyn std::fmt::Debug| format!("the board refuses the settings: {error:?}");
    let (instrument, _): (instrument::plan::Plan<N>, _) =
        Words::plan(&settings, &tree).map_err(|error| refused(&error))?;
    let boot = Boot {
        n: N as u32,
        core_hz: 180_000_000,
        measuring: true,
        causes: Causes(1),
        board: Name::new("nucleo-f446re"),
        clock: Clock::External,
        ..Boot::default()
    };
    let answer = Answer { tag: 1, command: 4 }.reply(&instrument.settings.to_bytes(N));
    let mut bytes = [boot.to_frame().to_vec(), answer.to_vec()].concat();
    let plan = Plan::from_terms(*instrument.plan).map_err(|error| refused(&error))?;
    let mut pipeline = Box::new(Pipeline::<Iq, N>::new(plan));
    let mut scene = sensor::<Iq>(&instrument.settings.config, N, 0.0, SEGMENTS as usize / 3);
    scene.seed = seed;
    scene.sources = vec![scene::Source::Target(scene::Target {
        range_m: RANGE_M.into(),
        velocity_mps: VELOCITY_MPS.into(),
        amplitude: Some(AMPLITUDE.into()),
        ..scene::Target::default()
    })];
    scene.receiver.noise.snr_db = Some(SNR_DB.into());
    scene.receiver.offset = OFFSET.map(Into::into);
    let mut run = scene.run(0)?;
    for number in 0..SEGMENTS {
        let samples = record::<Iq>(&mut run, number as usize, N);
        let stamp = instrument.timing.stamp(number, false);
        let Some(samples) = samples.as_array() else { return Err("a block is not whole".into()) };
        let measurement = pipeline.block(&stamp, samples);
        let method = instrument.plan.options.method;
        let record = Telemetry {
            measurement,
            method,
            health: Health::default(),
            basis: None,
            uncertainty: None,
        };
        bytes.extend(record.to_frame());
    }
    bytes.extend(Status { load: 310, ..Status::default() }.to_frame());
    Ok(bytes)
}

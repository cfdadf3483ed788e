//! The recording that docs/board.md replays: what the board would say, its measurements by the firmware's pipeline on this machine.

use picket::acquire::codes::Codes;
use picket::acquire::sample::Iq;
use picket::config::{Config, Scene};
use picket::pipeline::Pipeline;
use picket::plan::Plan;
use picket::solve::chirp::Shape;
use picket_firmware::instrument;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_host::simulate::{Signal, Width, generator};
use picket_wire::boot::{Boot, Causes, Clock, Name};
use picket_wire::command::Answer;
use picket_wire::settings::{Drive, Settings};
use picket_wire::status::Status;
use picket_wire::telemetry::{Health, Telemetry};
use std::fs;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/session.bin");
const N: usize = 1024;
const SEED: u64 = 1;

/// Start, settings, ten chirps of three segments, a status: a target that comes nearer, 30 dB above the noise.
fn session() -> Vec<u8> {
    let scene = Scene::Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 0.0,
    };
    let codes = Codes::unsigned::<12>();
    let config = Config {
        rate_hz: 250e3,
        scene,
        codes,
        band_hz: Some((2e3, 120e3)),
        ..Config::new(1.0, Codes::signed::<12>())
    };
    let drive = Drive::Dac { low: 400, high: 3600 };
    let settings = Settings { iq: true, config, guard: 32, drive, ..Settings::default() };
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    let (instrument, _): (instrument::plan::Plan<N>, _) = Words::plan(&settings, &tree).unwrap();
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
    let plan = Plan::of_terms(*instrument.plan).unwrap();
    let mut pipeline = Box::new(Pipeline::<Iq, N>::new(plan));
    for number in 0..30 {
        let (range, doppler) = (120.0, 45.5);
        let bins = [range - doppler, doppler, range + doppler][number as usize % 3];
        let signal = Signal {
            dc: [2048.0; 2],
            width: Width::Codes(codes),
            ..Signal::tone(bins, 900.0, 30.0)
        };
        let samples = signal.codes::<Iq>(N, &mut generator(SEED, number));
        let stamp = instrument.timing.stamp(number, false);
        let measurement = pipeline.block(stamp, samples.as_array().unwrap());
        let method = instrument.plan.options.method;
        let record = Telemetry { measurement, method, health: Health::default() };
        bytes.extend(record.to_frame());
    }
    bytes.extend(Status { load: 310, ..Status::default() }.to_frame());
    bytes
}

/// `PICKET_WRITE_SESSION=1 cargo test -p picket-host session` writes it anew.
#[test]
fn the_recording_is_what_the_pipeline_answers() {
    println!("seed {SEED}");
    if std::env::var_os("PICKET_WRITE_SESSION").is_some() {
        fs::write(FILE, session()).unwrap();
    }
    assert!(fs::read(FILE).unwrap() == session(), "docs/session.bin is of another version");
}

/// `--live` needs a terminal: into a pipe there are lines.
#[test]
fn live_into_a_pipe_is_lines() {
    let watch = |flags: &[&str]| {
        let arguments = ["watch", "--replay", FILE].iter().chain(flags);
        std::process::Command::new(env!("CARGO_BIN_EXE_picket")).args(arguments).output().unwrap()
    };
    let (live, lines) = (watch(&["--live"]), watch(&[]));
    assert!(live.status.success() && live.stdout == lines.stdout, "{live:?}");
}

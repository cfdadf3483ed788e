//! `picket calibrate --range` on recordings of simulated radars, and before a played board.

use crate::cli::{ANALYZE, file, fresh, lines};
use crate::device::{PICKET, ended, path, patient, plug, start, text};
use crate::survey::npy;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, Scene};
use picket_dsp::frame::{Cells, Frame, FrameConfig};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::I32;
use picket_dsp::{Chirp, Codes, Real, Shape};
use picket_simulator::Run;
use picket_wire::boot::{Boot, Clock};
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::command::{Answer, Command as Order, Request};
use picket_wire::frame::Reader;
use picket_wire::lines::Lines;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use picket_wire::telemetry::{Health, Telemetry};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::io::{Read, Write};
use std::process::{Command, Output};
use std::sync::mpsc;
use std::time::Duration;

const N: usize = 1024;
const RATE: f64 = 2e6;
const RAMP_S: f64 = 0.528e-3;
/// A ramp each 1.1 ms.
const PERIOD: u64 = 2200;

/// A radar at 60 GHz in front of a target.
#[derive(Clone, Copy)]
struct Bench {
    range_m: f64,
    velocity_mps: f64,
    /// A second target at 3 m, of this amplitude.
    other: f64,
    snr_db: f64,
    /// By how much the sweep is steeper than stated.
    slope_ppm: f64,
    ramps: usize,
    seed: u64,
}

const BENCH: Bench = Bench {
    range_m: 1.0,
    velocity_mps: 0.0,
    other: 0.0,
    snr_db: 20.0,
    slope_ppm: 0.0,
    ramps: 32,
    seed: 1,
};

/// The beat's phase at 0 m, turns.
const TURNS: f64 = 0.3;

impl Bench {
    fn run(&self) -> Run {
        let target = |range_m: f64, velocity_mps: f64, amplitude: f64| json!({"target": {"range_m": range_m, "velocity_mps": velocity_mps, "amplitude": amplitude, "phase_turns": TURNS}});
        let mut sources = vec![target(self.range_m, self.velocity_mps, 300.0)];
        if self.other > 0.0 {
            sources.push(target(3.0, 0.0, self.other));
        }
        let scene = json!({
            "seed": self.seed, "rate_hz": RATE, "seconds": (self.ramps + 1) as f64 * 1.1e-3,
            "waveform": {"shape": "sawtooth", "carrier_hz": 60e9, "bandwidth_hz": 3.09e9 * (1.0 + 1e-6 * self.slope_ppm),
                "ramp_s": RAMP_S, "guard_s": 16e-6, "period_s": 1.1e-3, "samples": N},
            "sources": sources,
            "receiver": {"noise": {"snr_db": self.snr_db}},
        });
        serde_json::from_value::<picket_simulator::Scene>(scene).unwrap().run(0).unwrap()
    }

    fn samples(&self) -> Vec<[i16; N]> {
        let mut run = self.run();
        let record = |index| {
            let codes = run.record(index, N);
            std::array::from_fn(|n| codes[n][0])
        };
        (0..self.ramps).map(record).collect()
    }

    /// What a board with these settings says of its blocks.
    fn records(&self, settings: &Settings) -> Vec<u8> {
        let config = Config::new(RATE, Codes::signed::<12>());
        let mut pipeline = Box::new(Pipeline::<Real, N>::new(config.plan().unwrap()));
        let mut bytes = Vec::new();
        for (sequence, samples) in (0..).zip(self.samples()) {
            let clock = PERIOD * u64::from(sequence);
            let stamp = Stamp { sequence, clock, segment: Segment::Up, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &samples);
            let (method, health) = (Method::LeastSquaresReal, Health::default());
            let record = Telemetry { measurement, method, health, basis: None, uncertainty: None };
            bytes.extend(record.to_frame());
            if settings.most > 1 {
                let lines = pipeline.lines(&measurement, settings.most.into());
                bytes.extend(Lines::from_tones(&stamp, lines).to_frame());
            }
        }
        bytes
    }

    /// What `picket watch --record` keeps of it.
    fn recording(&self) -> Vec<u8> {
        recording(&settings(), &self.records(&settings()))
    }
}

fn chirp() -> Chirp {
    Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: 299_792_458.0 / 60e9,
        bandwidth_hz: 3.09e9,
        duration_s: RAMP_S,
        guard_s: 16e-6,
        ..Chirp::default()
    }
}

fn settings() -> Settings {
    let scene = Scene::Chirp(chirp());
    let config = Config { scene, ..Config::new(RATE, Codes::signed::<12>()) };
    Settings { config, drive: Drive::External, guard: 32, most: 2, ..Settings::default() }
}

fn recording(settings: &Settings, records: &[u8]) -> Vec<u8> {
    let boot = Boot { n: N as u32, clock: Clock::External, measuring: true, ..Boot::default() };
    let answer = Answer { tag: 1, command: 4 }.reply(&settings.to_bytes(N)).to_vec();
    [boot.to_frame().to_vec(), answer, records.to_vec()].concat()
}

fn calibrate(name: &str, bytes: &[u8], options: &[&str]) -> Output {
    let recording = file(name, bytes);
    let mut picket = Command::new(PICKET);
    picket.args(["calibrate", "--replay", &recording]).args(options).output().unwrap()
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} of {value}"))
}

fn object(name: &str, bytes: &[u8], options: &[&str]) -> Value {
    let output = calibrate(name, bytes, &[options, &["--json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A reflector at a known range gives the phase at 0 m, by which `analyze` finds another one's range to micrometres.
#[test]
fn a_known_range_gives_the_phase_at_zero() {
    let to = fresh("range.json");
    let options = ["--range", "1.000:1e-6", "--to", &to, "--celsius", "21.5"];
    let found = object("range.bin", &BENCH.recording(), &options);
    assert_eq!((&found["ramps"], &found["saved"]), (&json!(32), &json!(false)), "{found}");
    let off = number(&found, "phase_rad") / TAU - TURNS;
    let sigma = number(&found, "sigma_phase_rad") / TAU;
    assert!(off.abs() < 5.0 * sigma && sigma < 2e-3, "{found}");
    let offset = number(&found, "offset_m");
    assert!(offset.abs() < 5.0 * number(&found, "sigma_offset_m"), "{found}");
    assert!((number(&found, "range_offset_m") + offset).abs() < 1e-6, "{found}");
    assert!(found["unix_s"].is_null() && found["celsius"] == 21.5, "{found}");

    let other = Bench { range_m: 2.345678, seed: 2, ..BENCH };
    let data = other.samples().concat().into_iter().flat_map(i16::to_le_bytes).collect();
    let array = file("other-range.npy", &npy("<i2", "32, 1024", data));
    let radar = [
        "--rate",
        "2M",
        "--chirp-s",
        "528e-6",
        "--guard-s",
        "16e-6",
        "--period-s",
        "1.1e-3",
        "--bandwidth-hz",
        "3.09G",
        "--carrier-hz",
        "60G",
    ];
    let by = ["--velocity-mps=-0.5:0.5", "--phase", "--calibration", &to, "--json"];
    let all = lines(ANALYZE, &[&[&array[..]], &radar[..], &by[..]].concat());
    let phase = &all[0]["phase"];
    let error = number(phase, "range_m") - 2.345678;
    assert!(phase["sure"] == true && error.abs() < 5e-6, "{phase}");
    // The recording itself by `analyze`: one calibration.
    let data = BENCH.samples().concat().into_iter().flat_map(i16::to_le_bytes).collect();
    let array = file("known-range.npy", &npy("<i2", "32, 1024", data));
    let same = lines(
        ANALYZE,
        &[&[&array[..]], &radar[..], &["--bits", "12", "--known-m", "1.000:1e-6", "--json"]]
            .concat(),
    );
    // A board that tells as many tones as `analyze` seeks.
    let four = Settings { most: 4, ..settings() };
    let found = object("four.bin", &recording(&four, &BENCH.records(&four)), &options[..2]);
    for name in ["phase_rad", "sigma_phase_rad", "offset_m", "sigma_offset_m", "ramps"] {
        assert_eq!(same[0][name], found[name], "{name}: {} {found}", same[0]);
    }
}

/// A second distance gives the slope of a sweep that is steeper than stated, and the offset of a cable.
#[test]
fn two_known_ranges_give_the_slope() {
    const SEEDS: u64 = 24;
    println!("seeds: 1 to {SEEDS}");
    const CABLE_M: f64 = 0.05;
    let mut squares = [0.0; 2];
    for seed in 1..=SEEDS {
        let bench = Bench { slope_ppm: 400.0, ramps: 16, seed, snr_db: 30.0, ..BENCH };
        let to = fresh("first.json");
        let near = Bench { range_m: 0.8 + CABLE_M, ..bench }.recording();
        object("near.bin", &near, &["--range", "0.8:1e-6", "--to", &to]);
        let far = Bench { range_m: 2.5 + CABLE_M, seed: 1000 + seed, ..bench }.recording();
        let found = object("far.bin", &far, &["--range", "2.5:1e-6", "--first", &to]);
        let slope = (number(&found, "slope_ppm") - 400.0) / number(&found, "sigma_slope_ppm");
        let offset = (number(&found, "offset_m") - CABLE_M) / number(&found, "sigma_offset_m");
        assert!(slope.abs() < 5.0 && offset.abs() < 5.0, "{found}");
        squares = [squares[0] + slope * slope, squares[1] + offset * offset];
        let right = 1.0 / (1.0 + 1e-6 * number(&found, "slope_ppm"));
        assert!((number(&found, "range_slope") - right).abs() < 1e-7, "{found}");
        if seed == 1 {
            // Two distances are not the first of two.
            let both = fresh("both.json");
            object("far.bin", &far, &["--range", "2.5:1e-6", "--first", &to, "--to", &both]);
            let again = calibrate("far.bin", &far, &["--range", "2.5", "--first", &both]);
            assert!(text(&again.stderr).contains("two distances already"));
            let near = calibrate("far.bin", &far, &["--range", "0.80001", "--first", &to]);
            assert!(text(&near.stderr).contains("too close to tell the slope"));
            let told = calibrate("far.bin", &far, &["--range", "2.5:1e-6", "--first", &to]);
            assert!(text(&told.stdout).contains("steeper than stated by 4"));
        }
    }
    let spread = squares.map(|sum| (sum / SEEDS as f64).sqrt());
    println!("rms of error / sigma of slope and offset: {spread:.2?}");
    assert!(spread.iter().all(|spread| (0.6..1.5).contains(spread)), "{spread:?}");
}

/// A board that gathers frames: each target has a phase.
#[test]
fn a_boards_frames_calibrate_too() {
    let framed = Settings {
        mode: Mode::Frames { chirps: 16, period_s: Some(1.1e-3) },
        most: 1,
        ..settings()
    };
    let frames = FrameConfig::new(chirp(), RATE, N, false, 16, 1.1e-3);
    let plan = FrameConfig { velocity_mps: Some((-0.5, 0.5)), ..frames }.plan().unwrap();
    let mut cells = vec![[0i32; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Wide(&mut cells)).unwrap();
    let mut spectrum = Box::new(Spectrum::<Real, N, I32>::new());
    let mut bytes = Vec::new();
    for (number, chirps) in (0..).zip(Bench { other: 60.0, ..BENCH }.samples().chunks(16)) {
        frame.clear();
        for samples in chirps {
            spectrum.transform(samples, Codes::signed::<12>());
            frame.push(&spectrum.view(), 0);
        }
        let targets = frame.targets();
        let clock = 16 * PERIOD * u64::from(number);
        let stamp = Stamp { sequence: 16 * number, clock, ..Stamp::default() };
        let (rate_hz, period_s) = (RATE, 1.1e-3);
        let head = ChirpFrame {
            number,
            stamp,
            chirps: 16,
            targets: targets.len() as u8,
            rate_hz,
            period_s,
            ..ChirpFrame::default()
        };
        bytes.extend(head.to_frame());
        for (place, found) in (0..).zip(targets) {
            bytes.extend(Found { frame: number, place, found }.to_frame());
        }
    }
    let found = object("frames.bin", &recording(&framed, &bytes), &["--range", "1.000:1e-6"]);
    let off = number(&found, "phase_rad") / TAU - TURNS;
    let sigma = number(&found, "sigma_phase_rad") / TAU;
    assert!(found["ramps"] == 2 && off.abs() < 5.0 * sigma && sigma < 3e-3, "{found}");
}

#[test]
fn each_failure_is_a_line_with_its_cure() {
    let of = |settings: Settings| recording(&settings, &BENCH.records(&settings));
    let usual = settings();
    let tone = Config { scene: Scene::Tone, ..usual.config };
    let two = [BENCH.records(&usual), Bench { range_m: 2.0, ..BENCH }.records(&usual)].concat();
    for (bytes, line) in [
        (b"nothing of a board".to_vec(), "no frame of a board is in it"),
        (BENCH.records(&usual), "lacks the board's settings: record"),
        (of(Settings { start: false, ..usual }), "stopped: start it by picket watch PORT --start"),
        (of(Settings { config: tone, ..usual }), "measures no chirps: set scene to \"chirp\""),
        (of(Settings { most: 1, ..usual }), "has no phases: set most to 2"),
        (recording(&usual, &[]), "no record came in 0.0 s, and a block lasts 0.001 s"),
        (Bench { velocity_mps: 0.05, ..BENCH }.recording(), "the target must rest"),
        (Bench { snr_db: -30.0, ..BENCH }.recording(), "none of 32 rising ramps can be used, most"),
        (recording(&usual, &two), "m in some records and at "),
    ] {
        let output = calibrate("failure-range.bin", &bytes, &["--range", "1"]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {message}{}", text(&output.stdout));
        assert!(message.lines().count() == 1 && output.stdout.is_empty(), "{message}");
        assert!(message.contains(line), "{line}: {message}");
    }
    let told = |options: &[&str]| {
        let output = calibrate("options-range.bin", &BENCH.recording(), options);
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr)
    };
    let there = file("there.json", b"{}");
    assert!(told(&["--range", "x"]).contains("give metres"));
    assert!(told(&["--range", "1", "--reference", "50k"]).contains("--reference"));
    assert!(told(&["--range", "1", "--to", &there]).contains("--force"));
    assert!(told(&["--range", "1", "--first", &there]).contains("no calibration"));
    assert!(told(&["--range", "1", "--save"]).contains("--save"));
    assert!(told(&["--reference", "50k", "--to", "x.json"]).contains("--"));
}

/// A target that moves by micrometres widens sigma, and that is told.
#[test]
fn a_little_motion_widens_sigma() {
    let bench = Bench { velocity_mps: 1e-3, snr_db: 40.0, ..BENCH };
    let found = object("little.bin", &bench.recording(), &["--range", "1"]);
    let still =
        object("still.bin", &Bench { velocity_mps: 0.0, ..bench }.recording(), &["--range", "1"]);
    let sigma = |found: &Value| number(found, "sigma_phase_rad");
    assert!(sigma(&found) > 10.0 * sigma(&still), "{found} {still}");
    let told = calibrate("little.bin", &bench.recording(), &["--range", "1"]);
    assert!(text(&told.stdout).contains("moves a little"), "{}", text(&told.stdout));
}

/// A board that takes settings by a restart. It tells each order, and ends with its port.
fn board(mut port: serialport::TTYPort, tell: mpsc::Sender<Order>) {
    use serialport::SerialPort;
    let mut line = patient(&port);
    port.set_timeout(Duration::from_millis(5)).unwrap();
    std::thread::spawn(move || {
        let uncertainty = Some(Uncertainty { clock_ppm: 20.0, ..Uncertainty::default() });
        let mut settings = Settings { most: 1, uncertainty, ..settings() };
        let said = |settings: &Settings| Bench { ramps: 4, ..BENCH }.records(settings);
        let (mut reader, mut records, mut idle) = (Reader::default(), said(&settings), 0);
        while idle < 12_000 {
            let mut bytes = [0; 256];
            let count = port.read(&mut bytes).unwrap_or(0);
            idle = if count > 0 { 0 } else { idle + 1 };
            for &byte in &bytes[..count] {
                let Some(Ok(frame)) = reader.push(byte) else { continue };
                let Ok(request) = Request::from_frame(&frame) else { continue };
                if let Order::SetSettings(wanted, _) = request.command {
                    settings = wanted;
                    records = said(&settings);
                }
                let body = match request.command {
                    Order::GetSettings | Order::SetSettings(..) => settings.to_bytes(N).to_vec(),
                    _ => Vec::new(),
                };
                let _ = line.write_all(&request.answer().reply(&body));
                if matches!(request.command, Order::SetSettings(..)) {
                    let boot = Boot { n: N as u32, measuring: true, ..Boot::default() };
                    let _ = line.write_all(&boot.to_frame());
                }
                let _ = tell.send(request.command);
            }
            if line.write_all(&records).is_err() {
                return;
            }
        }
    });
}

/// The board is asked for phases while it is measured, has its own settings again, and keeps the correction where that is asked for.
#[test]
fn the_board_is_asked_for_phases_and_keeps_the_correction() {
    let name = path("port-calibrate-range");
    let (ours, _theirs) = plug(&name);
    let (tell, orders) = mpsc::channel();
    board(ours, tell);
    let port = name.to_str().unwrap();
    let sent = || -> Vec<Order> {
        let changes = |order: &Order| matches!(order, Order::SetSettings(..) | Order::Save);
        orders.try_iter().filter(changes).collect()
    };
    let to = fresh("board-range.json");
    let options = ["calibrate", port, "--range", "1.0:1e-6", "--seconds", "0.5"];
    let output = ended(start(&[&options[..], &["--to", &to]].concat()));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("--save sets the offset"), "{}", text(&output.stdout));
    let kept: Value = serde_json::from_str(&std::fs::read_to_string(&to).unwrap()).unwrap();
    assert!(number(&kept, "unix_s") > 1.7e9, "{kept}");
    let off = number(&kept, "phase_rad") / TAU - TURNS;
    assert!(off.abs() < 5.0 * number(&kept, "sigma_phase_rad") / TAU, "{kept}");
    let all = sent();
    let [Order::SetSettings(phases, _), Order::SetSettings(back, _)] = all[..] else {
        panic!("{all:?}")
    };
    assert_eq!((phases.most, back.most), (2, 1));
    assert_eq!(back.calibration, Calibration::default());

    let output = ended(start(&[&options[..], &["--save"]].concat()));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).ends_with("set and saved\n"), "{}", text(&output.stdout));
    let all = sent();
    let [Order::SetSettings(..), Order::SetSettings(saved, _), Order::Save] = all[..] else {
        panic!("{all:?}")
    };
    assert_eq!((saved.most, saved.calibration.range_slope), (1, 1.0));
    assert!(
        saved.calibration.range_offset_m.abs() < 1e-3 && saved.calibration.range_offset_m != 0.0
    );
    let whole = saved.uncertainty.unwrap();
    assert!(whole.clock_ppm == 20.0 && whole.slope_ppm == 0.0, "{whole:?}");
    assert!(whole.phase_rad > 0.0 && whole.range_offset_m > 0.0, "{whole:?}");
}

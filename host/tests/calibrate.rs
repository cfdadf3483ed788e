//! `picket calibrate` on recordings whose clock is known, and before a played board.

use crate::cli::file;
use crate::device::{PICKET, Running, ended, path, patient, plug, start, text};
use fixed::types::{I0F32, I32F32};
use picket_dsp::Target;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::{Config, Scene};
use picket_dsp::frame::FrameTarget;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Measurement;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::{Tone, Verdict};
use picket_simulator::Draw;
use picket_wire::boot::{Boot, Clock};
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::command::{Answer, Command as Order, Request};
use picket_wire::frame::Reader;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use picket_wire::telemetry::{Health, Telemetry};
use std::fs::{File, read_to_string};
use std::io::{Read, Write};
use std::process::{Command, Output, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// The reference, Hz, and the rate of the board's timers by a crystal without error, Hz.
const REFERENCE: f64 = 50e3;
const RATE: f64 = 500e3;
/// What a record says of its error, cycles per sample: 10 ppm of the reference.
const SIGMA: f32 = 1e-6;

/// A board before the reference.
#[derive(Clone, Copy)]
pub struct Bench {
    seed: u64,
    /// By how much its clock is fast, and by how much it believes so.
    true_ppm: f64,
    believed_ppm: f32,
    /// How many times as wide as their sigmas its records scatter.
    scatter: f64,
    records: u32,
    verdict: Verdict,
}

pub const BENCH: Bench = Bench {
    seed: 1,
    true_ppm: 12.5,
    believed_ppm: 0.0,
    scatter: 1.0,
    records: 400,
    verdict: Verdict::Good,
};

impl Bench {
    fn settings(&self) -> Settings {
        let calibration = Calibration { clock_ppm: self.believed_ppm, ..Calibration::default() };
        let rate_hz = calibration.true_hz(RATE);
        let config = Config { rate_hz, ..Settings::default().config };
        Settings { config, calibration, ..Settings::default() }
    }

    fn records(&self) -> Vec<u8> {
        let mut draw = Draw::new(self.seed, 0);
        let cycles = REFERENCE / (RATE * (1.0 + 1e-6 * self.true_ppm));
        let mut bytes = Vec::new();
        for sequence in 0..self.records {
            let read = cycles + self.scatter * f64::from(SIGMA) * draw.normal();
            let tone = Tone {
                frequency: Frequency(I0F32::from_num(read)),
                sigma: SIGMA,
                snr: 1000.0,
                amplitude: 900.0,
                verdict: self.verdict,
                rate_hz: self.settings().config.rate_hz,
                ..Tone::default()
            };
            let stamp = Stamp { sequence, clock: 1024 * u64::from(sequence), ..Stamp::default() };
            let measurement = Measurement { stamp, tone, ..Measurement::default() };
            let (method, health) = (Method::LeastSquaresReal, Health::default());
            bytes.extend(
                Telemetry { measurement, method, health, basis: None, uncertainty: None }
                    .to_frame(),
            );
        }
        bytes
    }

    /// What `picket watch --record` keeps of it.
    pub fn recording(&self) -> Vec<u8> {
        recording(Clock::External, &self.settings(), &self.records())
    }
}

fn boot(clock: Clock) -> Vec<u8> {
    Boot { n: 1024, clock, measuring: true, ..Boot::default() }.to_frame().to_vec()
}

fn recording(clock: Clock, settings: &Settings, records: &[u8]) -> Vec<u8> {
    let answer = Answer { tag: 1, command: 4 }.reply(&settings.to_bytes(1024)).to_vec();
    [boot(clock), answer, records.to_vec()].concat()
}

fn calibrate(name: &str, bytes: &[u8], options: &[&str]) -> Output {
    let recording = file(name, bytes);
    let mut picket = Command::new(PICKET);
    picket.args(["calibrate", "--replay", &recording]).args(options).output().unwrap()
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap()
}

/// The answer as JSON.
fn json(name: &str, bytes: &[u8]) -> serde_json::Value {
    let output = calibrate(name, bytes, &["--reference", "50k", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_clocks_error_is_found_within_sigma() {
    const SEEDS: u64 = 24;
    let mut squares = 0.0;
    for seed in 0..SEEDS {
        // Slow and fast clocks, and boards that were calibrated before, rightly or not.
        let true_ppm = 50.0 * (seed as f64 / 4.0 - 3.0);
        let believed_ppm = [0.0, true_ppm as f32, -300.0, 25.0][seed as usize % 4];
        let bench = Bench { seed, true_ppm, believed_ppm, ..BENCH };
        let found = json("calibrated.bin", &bench.recording());
        let [ppm, sigma] = [number(&found["clock_ppm"]), number(&found["sigma_ppm"])];
        assert!((sigma / (10.0 / 20.0) - 1.0).abs() < 1e-3, "{found}");
        let deviation = (ppm - true_ppm) / sigma;
        assert!(deviation.abs() < 4.0, "{true_ppm}: {found}");
        squares += deviation * deviation;
        assert_eq!(found["scatter_agrees"], true, "{found}");
        assert_eq!((&found["records"], &found["left_out"]), (&400.into(), &0.into()));
        assert_eq!(found["clock_ppm_before"], f64::from(believed_ppm));
        assert_eq!((&found["clock"], &found["saved"]), (&"external".into(), &false.into()));
    }
    let spread = (squares / SEEDS as f64).sqrt();
    assert!((0.6..1.5).contains(&spread), "{spread}");
}

#[test]
fn records_that_scatter_otherwise_than_they_say_are_told() {
    let wide = json("wide.bin", &Bench { scatter: 3.0, ..BENCH }.recording());
    assert_eq!(wide["scatter_agrees"], false);
    assert!((number(&wide["scatter"]) / 3.0 - 1.0).abs() < 0.15, "{wide}");
    assert!((number(&wide["sigma_ppm"]) / 1.5 - 1.0).abs() < 0.15, "{wide}");
    assert!((number(&wide["clock_ppm"]) - 12.5).abs() < 4.0 * 1.5, "{wide}");
    let lines = |scatter| {
        let bench = Bench { scatter, ..BENCH };
        let output = calibrate("scatter.bin", &bench.recording(), &["--reference", "50000"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let told = lines(3.0);
    assert!(told.contains("as wide as their sigmas, and the sigma above is widened"), "{told}");
    let told = lines(0.1);
    assert!(told.contains("0.10 times as wide as their sigmas, which are too wide"), "{told}");
    let told = lines(1.0);
    assert!(told.contains("their scatter agrees with their sigmas"), "{told}");
    assert!(told.starts_with("400 records in 0.8 s: 49999."), "{told}");
    assert!(told.contains("clock_ppm 0 before, 12."), "{told}");
}

/// Other settings hold from a start on, `--seconds` ends what is read, and a stray tone is left out.
#[test]
fn what_does_not_belong_is_left_out() {
    let before = Bench { true_ppm: 500.0, ..BENCH };
    let after = Bench { records: 500, ..BENCH };
    let bytes = [before.recording(), after.recording()].concat();
    let options = ["--reference", "50k", "--json", "--seconds", "0.5"];
    let output = calibrate("again.bin", &bytes, &options);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["records"], 245, "{found}");
    assert!((number(&found["clock_ppm"]) - 12.5).abs() < 4.0, "{found}");
    let stray = Bench { true_ppm: 1e5, records: 9, ..BENCH }.records();
    let weak = Bench { verdict: Verdict::Weak, records: 7, ..BENCH }.records();
    let found = json("stray.bin", &[BENCH.recording(), stray, weak].concat());
    assert_eq!((&found["records"], &found["left_out"]), (&400.into(), &16.into()), "{found}");
}

#[test]
fn each_failure_is_a_line_with_its_cure() {
    let told = |bytes: &[u8], reference: &str| {
        let output = calibrate("failure.bin", bytes, &["--reference", reference]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.lines().count() == 1 && output.stdout.is_empty(), "{message}");
        message
    };
    let of = |settings: Settings| recording(Clock::External, &settings, &BENCH.records());
    let usual = BENCH.settings();
    let config = usual.config;
    let scene = Scene::Chirp(Chirp { bandwidth_hz: 2e8, wavelength_m: 0.0125, ..Chirp::default() });
    let chirp = Config { scene, ..config };
    let drive = Drive::Dac { low: 250, high: 3845 };
    let far = Bench { true_ppm: 1500.0, ..BENCH };
    let internal = recording(Clock::Internal, &usual, &far.records());
    let weak = Bench { verdict: Verdict::Weak, ..BENCH };
    for (bytes, reference, line) in [
        (b"nothing of a board".to_vec(), "50k", "no frame of a board is in it"),
        (
            [boot(Clock::External), BENCH.records()].concat(),
            "50k",
            "lacks the board's settings: record",
        ),
        (
            of(Settings { start: false, ..usual }),
            "50k",
            "stopped: start it by picket watch PORT --start",
        ),
        (of(Settings { config: chirp, drive, ..usual }), "50k", "chirps: set scene to \"tone\""),
        (
            of(Settings { mode: Mode::Bursts(Trigger::default()), ..usual }),
            "50k",
            "bursts: set mode to \"blocks\"",
        ),
        (
            of(Settings { config: Config { band_hz: Some((1e3, 2e3)), ..config }, ..usual }),
            "50k",
            "searches 1000 to 2000 Hz, which excludes the reference of 50000 Hz: set band_hz",
        ),
        (BENCH.recording(), "250k", "not below half the board's 500000 samples a second"),
        (far.recording(), "50k", "a clock_ppm of 1500 is more than the allowed 1000; is it"),
        (internal, "50k", "its internal oscillator (1 %), so repair its external clock"),
        (BENCH.recording(), "60k", "reads 49999."),
        (weak.recording(), "50k", "none of 400 records can be used, most are weak (The line is"),
        (
            recording(Clock::External, &usual, &[]),
            "50k",
            "no record came in 0.0 s, and a block lasts 0.002 s",
        ),
    ] {
        let message = told(&bytes, reference);
        assert!(message.contains(line), "{line}: {message}");
    }
    let run = |options: &[&str]| {
        let mut picket = Command::new(PICKET);
        let output = picket.arg("calibrate").args(options).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr)
    };
    let recording = file("unsaved.bin", &BENCH.recording());
    assert!(run(&["--replay", &recording]).contains("--reference"));
    assert!(run(&["--replay", &recording, "--reference", "50k", "--save"]).contains("--save"));
    assert!(run(&["/nowhere/port", "--reference", "50k"]).contains("/nowhere/port"));
    let listed = run(&["--reference", "50k"]);
    assert!(
        listed.contains("name the port: picket calibrate ") || listed.contains("no serial port")
    );
}

/// An internal oscillator that is near by chance is no calibration that lasts.
#[test]
fn an_internal_oscillator_is_told() {
    let bytes = recording(Clock::Internal, &BENCH.settings(), &BENCH.records());
    let output = calibrate("internal.bin", &bytes, &["--reference", "50k"]);
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("changes with temperature"), "{}", text(&output.stderr));
    // Its records' sigma covers the oscillator: the scatter tells that of the mean.
    assert!(text(&output.stdout).contains("± 0.5"), "{}", text(&output.stdout));
    assert!(!text(&output.stdout).contains("scatter"), "{}", text(&output.stdout));
}

/// A board that takes settings by a restart. It tells each order, and ends with its port.
fn board(mut port: serialport::TTYPort, tell: mpsc::Sender<Order>) {
    use serialport::SerialPort;
    let mut line = patient(&port);
    port.set_timeout(Duration::from_millis(5)).unwrap();
    std::thread::spawn(move || {
        let bench = Bench { records: 20, ..BENCH };
        let (mut reader, mut settings) = (Reader::default(), bench.settings());
        let (mut seed, mut idle) = (0, 0);
        while idle < 12_000 {
            let mut bytes = [0; 256];
            let count = port.read(&mut bytes).unwrap_or(0);
            idle = if count > 0 { 0 } else { idle + 1 };
            for &byte in &bytes[..count] {
                let Some(Ok(frame)) = reader.push(byte) else { continue };
                let Ok(request) = Request::from_frame(&frame) else { continue };
                let body = match request.command {
                    Order::GetSettings => settings.to_bytes(1024).to_vec(),
                    Order::SetSettings(wanted, _) => {
                        settings = wanted;
                        settings.to_bytes(1024).to_vec()
                    }
                    _ => Vec::new(),
                };
                let _ = line.write_all(&request.answer().reply(&body));
                if matches!(request.command, Order::SetSettings(..)) {
                    let _ = line.write_all(&boot(Clock::External));
                }
                let _ = tell.send(request.command);
            }
            seed += 1;
            if line.write_all(&Bench { seed, ..bench }.records()).is_err() {
                return;
            }
        }
    });
}

#[test]
fn the_board_is_sent_the_correction_and_keeps_it() {
    let name = path("port-calibrate");
    let (ours, _theirs) = plug(&name);
    let (tell, orders) = mpsc::channel();
    board(ours, tell);
    let port = name.to_str().unwrap();
    let options = ["calibrate", port, "--reference", "50k", "--seconds", "0.5"];
    let output = ended(start(&options));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("--save sets it"), "{}", text(&output.stdout));
    let changes = |order: &Order| matches!(order, Order::SetSettings(..) | Order::Save);
    assert!(!orders.try_iter().any(|order| changes(&order)));
    let output = ended(start(&[&options[..], &["--save"]].concat()));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).ends_with("set and saved\n"), "{}", text(&output.stdout));
    let orders: Vec<Order> = orders.try_iter().filter(changes).collect();
    let [Order::SetSettings(settings, 1024), Order::Save] = orders[..] else {
        panic!("{orders:?}")
    };
    let ppm = f64::from(settings.calibration.clock_ppm);
    assert!((ppm - 12.5).abs() < 4.0, "{ppm}");
    // The timers count as before: the rate is the nominal one with the correction.
    assert!((settings.config.rate_hz / (RATE * (1.0 + 1e-6 * ppm)) - 1.0).abs() < 1e-12);
    let expected = Settings { calibration: settings.calibration, ..BENCH.settings() };
    let config = Config { rate_hz: settings.config.rate_hz, ..expected.config };
    assert_eq!(settings, Settings { config, ..expected });
}

/// A board that sends a record each 5 ms, whose sample clock has this ratio to the stated one. It tells each order, and ends with its port.
fn clocked(mut port: serialport::TTYPort, ratio: f64, tell: mpsc::Sender<Order>) {
    use serialport::SerialPort;
    let mut line = patient(&port);
    port.set_timeout(Duration::from_millis(5)).unwrap();
    std::thread::spawn(move || {
        let (mut reader, mut settings) = (Reader::default(), BENCH.settings());
        let begun = Instant::now();
        for sequence in 0..24_000 {
            let mut bytes = [0; 256];
            let count = port.read(&mut bytes).unwrap_or(0);
            for &byte in &bytes[..count] {
                let Some(Ok(frame)) = reader.push(byte) else { continue };
                let Ok(request) = Request::from_frame(&frame) else { continue };
                if let Order::SetSettings(wanted, _) = request.command {
                    settings = wanted;
                }
                let body = match request.command {
                    Order::GetSettings | Order::SetSettings(..) => settings.to_bytes(1024).to_vec(),
                    _ => Vec::new(),
                };
                let _ = line.write_all(&request.answer().reply(&body));
                let _ = tell.send(request.command);
            }
            let tone = Tone { rate_hz: settings.config.rate_hz, ..Tone::default() };
            let clock = (begun.elapsed().as_secs_f64() * RATE * ratio) as u64;
            let stamp = Stamp { sequence, clock, ..Stamp::default() };
            let measurement = Measurement { stamp, tone, ..Measurement::default() };
            let (method, health) = (Method::LeastSquaresReal, Health::default());
            let record = Telemetry { measurement, method, health, basis: None, uncertainty: None };
            if line.write_all(&record.to_frame()).is_err() {
                return;
            }
        }
    });
}

/// A board that sends a frame of chirps with one target each 20 ms, whose sample clock has 80 % of the stated rate.
fn framed(mut port: serialport::TTYPort) {
    use serialport::SerialPort;
    let mut line = patient(&port);
    port.set_timeout(Duration::from_millis(20)).unwrap();
    std::thread::spawn(move || {
        let uncertainty = Some(Uncertainty { slope_ppm: 100.0, ..Uncertainty::default() });
        let (mode, drive) =
            (Mode::Frames { chirps: 16, period_s: None }, Drive::Dac { low: 250, high: 3845 });
        let settings = Settings { mode, drive, uncertainty, ..BENCH.settings() };
        let mut reader = Reader::default();
        let begun = Instant::now();
        for number in 0..6_000 {
            let mut bytes = [0; 256];
            let count = port.read(&mut bytes).unwrap_or(0);
            for &byte in &bytes[..count] {
                let Some(Ok(frame)) = reader.push(byte) else { continue };
                let Ok(request) = Request::from_frame(&frame) else { continue };
                let body = match request.command {
                    Order::GetSettings => settings.to_bytes(1024).to_vec(),
                    _ => Vec::new(),
                };
                let _ = line.write_all(&request.answer().reply(&body));
            }
            let clock = (begun.elapsed().as_secs_f64() * RATE * 0.8) as u64;
            let stamp = Stamp { sequence: 16 * number, clock, ..Stamp::default() };
            let (targets, rate_hz, period_s) = (1, RATE, 1e-3);
            let head = ChirpFrame {
                number,
                stamp,
                chirps: 16,
                targets,
                rate_hz,
                period_s,
                ..ChirpFrame::default()
            };
            let target = Target {
                range: I32F32::from_num(10),
                velocity: Some(I32F32::from_num(1)),
                sigma_range: 1e-3,
                sigma_velocity: 1e-3,
                ..Target::default()
            };
            let found = FrameTarget { target, ..FrameTarget::default() };
            let found = Found { frame: number, place: 0, found };
            if line.write_all(&[&head.to_frame()[..], &found.to_frame()].concat()).is_err() {
                return;
            }
        }
    });
}

/// A board's frames tell a wrong rate too, and each target has its whole error.
#[test]
fn a_boards_frames_have_a_checked_rate_and_the_whole_error() {
    let run = |name: &str, style: &[&str]| {
        let name = path(name);
        let (ours, _theirs) = plug(&name);
        framed(ours);
        let name = name.to_str().unwrap().to_owned();
        // A file takes all rows, where a pipe is full after some.
        let rows = format!("{name}.rows");
        let mut command = Command::new(PICKET);
        command.args(["watch", &name, "--count", "400"]).args(style).stdin(Stdio::null());
        command.stdout(File::create(&rows).unwrap()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        assert!(child.wait().unwrap().success());
        read_to_string(rows).unwrap()
    };
    let (table, printed) = std::thread::scope(|scope| {
        let table = scope.spawn(|| run("frames-table", &[]));
        let printed = run("frames-jsonl", &["--jsonl"]);
        (table.join().unwrap(), printed)
    });
    let lines: Vec<serde_json::Value> =
        printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let told = lines.iter().position(|line| line["rate_check"] == "wrong").unwrap();
    assert!(number(&lines[told]["seconds"]) < 5.0, "{}", lines[told]);
    let targets = || lines.iter().enumerate().filter(|(_, line)| !line["range_m"].is_null());
    assert!(targets().count() > 300);
    for (at, line) in targets() {
        let says =
            line["also"].as_array().is_some_and(|all| all.iter().any(|it| it == "wrong-rate"));
        assert_eq!(says, at > told, "{line}");
    }
    // The settings came before the last ones: 10 m of 100 ppm.
    let (_, last) = targets().next_back().unwrap();
    assert!((number(&last["budget"]["slope_range_m"]) - 1e-3).abs() < 1e-6, "{last}");
    assert!((number(&last["budget"]["uncertainty_range_m"]) - 2f64.sqrt() * 1e-3).abs() < 1e-6);
    assert!(table.contains("+- all") && table.contains(", wrong-rate"), "{table}");
}

/// `picket watch` compares the board's clock with this machine's: a wrong rate is told and not stored, a small error is stored.
#[test]
fn the_clock_is_compared_with_this_machines() {
    let begin = |name: &str, ratio: f64, options: &[&str]| {
        let name = path(name);
        let (ours, theirs) = plug(&name);
        let (tell, told) = mpsc::channel();
        let name = name.to_str().unwrap().to_owned();
        // A file takes all rows, where a pipe is full after some.
        let rows = File::create(format!("{name}.jsonl")).unwrap();
        let mut command = Command::new(PICKET);
        command.args(["watch", &name, "--jsonl"]).args(options).stdin(Stdio::null());
        let running = Running(command.stdout(rows).stderr(Stdio::piped()).spawn().unwrap());
        clocked(ours, ratio, tell);
        (running, told, theirs)
    };
    let wrong = begin("clock-wrong", 0.8, &["--count", "1100"]);
    let unsaved = begin("clock-unsaved", 0.8, &["--save-clock"]);
    let saved = begin("clock-saved", 1.0 + 12.5e-6, &["--save-clock"]);

    let ended = |mut running: Running| {
        let begun = Instant::now();
        while running.0.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < Duration::from_secs(60), "it does not end");
            std::thread::sleep(Duration::from_millis(5));
        }
        let mut message = String::new();
        running.0.stderr.take().unwrap().read_to_string(&mut message).unwrap();
        (running.0.wait().unwrap().code(), message)
    };
    let (code, message) = ended(wrong.0);
    assert_eq!(code, Some(0), "{message}");
    let printed = read_to_string(path("clock-wrong.jsonl")).unwrap();
    let lines: Vec<serde_json::Value> =
        printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let check: Vec<_> = lines.iter().filter(|line| !line["rate_check"].is_null()).collect();
    assert!(check.len() == 1 && check[0]["rate_check"] == "wrong", "{check:?}");
    assert!((number(&check[0]["rate_error_ppm"]) + 2e5).abs() < 2e3, "{check:?}");
    assert!(number(&check[0]["seconds"]) < 5.0 && check[0]["clock_ppm"].is_null(), "{check:?}");
    // Each answer after that says so, none before.
    let told = lines.iter().position(|line| !line["rate_check"].is_null()).unwrap();
    for (at, line) in lines.iter().enumerate().filter(|(_, line)| !line["sequence"].is_null()) {
        let says =
            line["also"].as_array().is_some_and(|all| all.iter().any(|it| it == "wrong-rate"));
        assert_eq!(says, at > told, "{line}");
    }
    let summary = lines.last().unwrap();
    assert!((number(&summary["rate_error_ppm"]) + 2e5).abs() < 2e3, "{summary}");

    let (code, message) = ended(unsaved.0);
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("--save-clock: nothing is stored: the sample rate is wrong"));
    assert!(!unsaved.1.try_iter().any(|order| matches!(order, Order::SetSettings(..))));

    let (code, message) = ended(saved.0);
    assert_eq!(code, Some(0), "{message}");
    let orders: Vec<Order> = saved.1.try_iter().collect();
    let set = orders.iter().find_map(|order| match order {
        Order::SetSettings(settings, n) => Some((settings.calibration.clock_ppm, *n)),
        _ => None,
    });
    let (ppm, n) = set.unwrap();
    assert!((ppm - 12.5).abs() < 5.0 && n == 1024, "{ppm} {n}");
    assert_eq!(orders.last(), Some(&Order::Save));
}

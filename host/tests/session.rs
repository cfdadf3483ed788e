//! The recording that docs/board.md replays is what its command makes.

use fixed::types::{I0F32, I32F32};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::frame::FrameTarget;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Measurement;
use picket_dsp::solve::chirp::Target;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict};
use picket_wire::boot::Clock;
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::frame::{self, Kind};
use picket_wire::lines::Lines;
use picket_wire::telemetry::{Basis, Health, Telemetry};
use std::fs;
use std::path::PathBuf;
use std::process::Command;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/session.bin");

#[test]
fn the_recording_is_what_its_command_makes() {
    let made = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("made.bin");
    let output = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["demo", "--scenario", "board", "--force", "--record"])
        .arg(&made)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        fs::read(&made).unwrap() == fs::read(FILE).unwrap(),
        "docs/session.bin is of another version: cargo picket demo --scenario board --record docs/session.bin --force"
    );
}

/// `--live` needs a terminal: into a pipe there are lines.
#[test]
fn live_into_a_pipe_is_lines() {
    let watch = |flags: &[&str]| {
        let arguments = ["watch", "--replay", FILE].iter().chain(flags);
        Command::new(env!("CARGO_BIN_EXE_picket")).args(arguments).output().unwrap()
    };
    let (live, lines) = (watch(&["--live"]), watch(&[]));
    assert!(live.status.success() && live.stdout == lines.stdout, "{live:?}");
}

/// A row of comma-separated values has the verdict of the target beside the tone's, as an object of JSON has.
#[test]
fn the_targets_verdict_is_in_every_format() {
    let watch = |flag: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_picket"));
        let output = command.args(["watch", "--replay", FILE, flag]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let json = watch("--jsonl");
    let json = json.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let json: Vec<String> = json
        .filter(|line| !line["method"].is_null())
        .map(|line| line["outcome_verdict"].as_str().unwrap_or_default().to_owned())
        .collect();
    let csv = watch("--csv");
    let mut rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heads = rows.next().unwrap();
    let place = heads.iter().position(|head| *head == "outcome_verdict").unwrap();
    let csv: Vec<&str> = rows.map(|row| row[place]).collect();
    assert_eq!(csv, json);
    assert!(csv.iter().filter(|verdict| **verdict == "good").count() > 5, "{csv:?}");
}

/// A recording of another time is told by its version.
#[test]
fn records_of_another_version_are_told() {
    let record = Telemetry {
        measurement: Measurement::default(),
        method: Method::default(),
        health: Health::default(),
        basis: None,
        uncertainty: None,
    };
    let mut bytes = record.to_bytes();
    bytes[0] = 2;
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("version-2.bin");
    fs::write(&file, frame::encode(Kind::Telemetry, &bytes).unwrap()).unwrap();
    let watch = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["watch", "--replay"])
        .arg(&file)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&watch.stderr).into_owned();
    assert_eq!(watch.status.code(), Some(2), "{said}");
    assert!(said.contains("version 2, this program knows version 1"), "{said}");
}

/// A recording of blocks with two tones each: a row below its block's for people, a line each for programs, and for the
/// reader of docs/protocol.md.
#[test]
fn the_tones_of_a_block_are_shown() {
    let mut bytes = Vec::new();
    for sequence in 0..3 {
        let stamp = Stamp { sequence, clock: 1024 * u64::from(sequence), ..Stamp::default() };
        let tone = |bin: f64, amplitude: f32| Tone {
            frequency: Frequency(I0F32::from_num(bin / 1024.0)),
            sigma: 1e-6,
            snr: 100.0,
            amplitude,
            verdict: Verdict::Good,
            ..Tone::default()
        };
        let phasors =
            [(100.25, 900.0, 1.5), (200.5, 300.0, -0.25)].map(|(bin, amplitude, phase)| {
                ToneWithPhase { tone: tone(bin, amplitude), phase, sigma_phase: 0.01 }
            });
        let measurement = Measurement { stamp, tone: phasors[0].tone, ..Measurement::default() };
        let (method, health) = (Method::LeastSquaresReal, Health::default());
        // Earlier programs tell no settings.
        let basis = Basis { settings: 0x00C0_FFEE, clock: Clock::Internal, effort: 1 };
        let basis = (sequence > 0).then_some(basis);
        bytes
            .extend(Telemetry { measurement, method, health, basis, uncertainty: None }.to_frame());
        bytes.extend(Lines::from_tones(&stamp, phasors.into_iter().collect()).to_frame());
    }
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("tones.bin");
    fs::write(&file, bytes).unwrap();
    let watch = |flags: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_picket"));
        let output =
            command.args(["watch", "--rate", "1024000", "--replay"]).arg(&file).args(flags);
        String::from_utf8(output.output().unwrap().stdout).unwrap()
    };
    let table = watch(&[]);
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 1 + 3 * 3 + 1, "{table}");
    assert!(rows[3].contains("line 2") && rows[3].contains("200500.0000"), "{table}");
    assert!(rows[3].contains("phase  -0.2500 ± 0.0100 rad  good"), "{table}");
    assert!(rows[10].contains("0 bad frames"), "{table}");
    let json = watch(&["--jsonl"]);
    let json = json.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let (lines, rows): (Vec<_>, Vec<_>) = json.partition(|line| !line["line"].is_null());
    let told =
        |row: &serde_json::Value| ["settings", "clock", "effort"].map(|key| row[key].clone());
    assert!(told(&rows[0]).iter().all(serde_json::Value::is_null), "{}", rows[0]);
    assert_eq!(told(&rows[1]), ["00c0ffee", "internal", "1"].map(serde_json::Value::from));
    let lines: Vec<_> = lines.into_iter().filter(|line| line["line"] == 2).collect();
    assert_eq!(lines.len(), 3);
    assert_eq!(lines[1]["sequence"], 1);
    assert_eq!(lines[1]["frequency_hz"], 200_500.0);
    assert_eq!(lines[1]["phase_rad"], -0.25);
    assert_eq!(lines[1]["verdict"], "good");
    let csv = watch(&["--csv"]);
    let columns: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert!(columns[..10].iter().all(|row| row.len() == columns[0].len()), "{csv}");
    let place = |name: &str| columns[0].iter().position(|column| *column == name).unwrap();
    assert_eq!(columns[3][place("line")], "2");
    assert_eq!(columns[3][place("frequency_hz")], "200500");
    assert_eq!(columns[3][place("verdict")], "good");
    assert_eq!(columns[3][place("phase_rad")], "-0.25");
    let page =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/protocol.md")).unwrap();
    let program = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let schema = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/schema.json");
    let output = Command::new("python3").args(["-c", program, schema]).arg(&file).output();
    let output = output.expect("apt-get install python3");
    let theirs = String::from_utf8(output.stdout).unwrap();
    let theirs: Vec<&str> = theirs.lines().collect();
    assert_eq!(theirs.len(), 9, "{theirs:?}");
    let fields: Vec<&str> = theirs[2].split(' ').collect();
    let number = |at: usize| fields[at].parse::<f64>().unwrap();
    assert_eq!(fields[0], "line");
    assert!((number(1) - 200.5 / 1024.0).abs() < 1e-9 && number(3) == -0.25, "{theirs:?}");
}

/// A recording of frames of chirps: a line for each target, and for programs one for each frame before its targets. A target whose frame was
/// lost on the way is left out.
#[test]
fn the_targets_of_a_frame_are_shown() {
    let target = |frame: u32, place: u8, range_m: f64, velocity_mps: f64, verdict: Verdict| {
        let target = Target {
            range: I32F32::from_num(range_m),
            velocity: Some(I32F32::from_num(velocity_mps)),
            sigma_range: 0.01,
            sigma_velocity: 0.02,
            verdict,
            ..Target::default()
        };
        let tone = Tone { sigma: 1e-6, snr: 100.0, verdict, rate_hz: 5e5, ..Tone::default() };
        let line = ToneWithPhase { tone, phase: 0.5, sigma_phase: 0.01 };
        let found = FrameTarget { target, covariance: 1e-5, line, ln_chance: -40.0 };
        Found { frame, place, found }
    };
    let frame = |number: u32, targets: u8| ChirpFrame {
        number,
        stamp: Stamp {
            sequence: 100 * number,
            clock: 108_800 * u64::from(number),
            segment: Segment::Up,
            gap: false,
        },
        chirps: 64,
        passed: 36,
        clipped: 5,
        targets,
        search_s: 0.25,
        rate_hz: 5e5,
        period_s: 2.176e-3,
        health: Health { lost: 3, faults: 0 },
        basis: None,
    };
    let bytes = [
        frame(0, 2).to_frame(),
        target(0, 0, 12.5, -3.25, Verdict::Good).to_frame(),
        target(0, 1, 4.25, 1.5, Verdict::Clipped).to_frame(),
        // Its frame, of number 1, is lost.
        target(1, 0, 99.0, 0.0, Verdict::Good).to_frame(),
        frame(2, 0).to_frame(),
        frame(3, 1).to_frame(),
        target(3, 0, 12.0, -3.25, Verdict::Good).to_frame(),
    ]
    .concat();
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("chirp-frames.bin");
    fs::write(&file, bytes).unwrap();
    let watch = |flags: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_picket"));
        let output = command.args(["watch", "--replay"]).arg(&file).args(flags).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let table = watch(&[]);
    let rows: Vec<Vec<&str>> =
        table.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(rows[0][..3], ["frame", "range", "m"], "{table}");
    let expected = [
        (1, [0.0, 12.5, 0.01, -3.25, 0.02, 20.0], "good"),
        (2, [0.0, 4.25, 0.01, 1.5, 0.02, 20.0], "clipped"),
        (4, [3.0, 12.0, 0.01, -3.25, 0.02, 20.0], "good"),
    ];
    for (row, numbers, verdict) in expected {
        let (last, before) = rows[row].split_last().unwrap();
        let before: Vec<f64> = before.iter().map(|word| word.parse().unwrap()).collect();
        assert_eq!((&before[..], *last), (&numbers[..], verdict), "{table}");
    }
    assert_eq!(rows[3], ["2", "no", "target"], "{table}");
    let json = watch(&["--jsonl"]);
    let json = json.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let json: Vec<serde_json::Value> = json.filter(|line| !line["frame"].is_null()).collect();
    let (frames, targets): (Vec<_>, Vec<_>) =
        json.iter().partition(|line| line["chirp_frame"] == true);
    let of = |lines: &[&serde_json::Value], key: &str| {
        lines.iter().map(|line| line[key].as_f64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(
        (of(&frames, "frame"), of(&targets, "frame")),
        (vec![0.0, 2.0, 3.0], vec![0.0, 0.0, 3.0])
    );
    assert_eq!(
        (of(&frames, "passed"), of(&frames, "targets")),
        (vec![36.0; 3], vec![2.0, 0.0, 1.0])
    );
    assert_eq!((of(&frames, "time_s")[2], of(&frames, "lost")[0]), (0.6528, 3.0));
    assert_eq!(of(&targets, "range_m"), [12.5, 4.25, 12.0]);
    assert_eq!(of(&targets, "velocity_mps"), [-3.25, 1.5, -3.25]);
    assert_eq!(
        (of(&targets, "chirp"), &targets[1]["verdict"]),
        (vec![0.0, 0.0, 300.0], &"clipped".into())
    );
    let csv = watch(&["--csv"]);
    let columns: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let place = |name: &str| columns[0].iter().position(|column| *column == name).unwrap();
    assert_eq!(columns[2][place("range_m")].parse::<f64>(), Ok(4.25));
    assert_eq!((columns.len(), columns[2][place("verdict")]), (4, "clipped"), "{csv}");
    let plot = watch(&["--teleplot"]);
    assert!(plot.contains(">targets:2\n") && plot.contains(">target_2_m:4.25\n"), "{plot}");
}

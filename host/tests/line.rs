//! `picket watch` and `picket doctor` with the boards' real images, which run on emulators of their chips, and a pseudo terminal
//! between them.

#[path = "../../host-tests/tests/rsemu/board.rs"]
#[allow(dead_code)]
mod board;
#[path = "../../host-tests/tests/rsemu/source.rs"]
mod source;

use board::Emulated;
use picket_dsp::config::Config;
use picket_host::pico::{self, bench::Pico};
use picket_wire::settings::Settings;
use serialport::{SerialPort, TTYPort};
use std::fs;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Runs `picket watch` on a board until it ends.
fn watch(board: &mut Emulated, port: &mut TTYPort, name: &str, arguments: &[&str]) -> Output {
    let begun = Instant::now();
    loop {
        let output = picket(board, port, &[&["watch", name], arguments].concat(), 60);
        // On a busy machine the board's seconds are longer than the tool's, which asks for eight of its own.
        let unanswered =
            String::from_utf8_lossy(&output.stderr).contains("times without an answer");
        if !unanswered || begun.elapsed() > Duration::from_secs(60) {
            return output;
        }
    }
}

/// An emulated board.
trait Board {
    /// Takes bytes of the host.
    fn hear(&mut self, bytes: &[u8]);

    /// Lets time pass, us, and gives the bytes that the board sent meanwhile.
    fn passes(&mut self, microseconds: u64) -> Vec<u8>;
}

impl Board for Emulated {
    fn hear(&mut self, bytes: &[u8]) {
        Emulated::hear(self, bytes);
    }

    fn passes(&mut self, microseconds: u64) -> Vec<u8> {
        self.sent.clear();
        self.run(microseconds);
        std::mem::take(&mut self.sent)
    }
}

impl Board for Pico {
    fn hear(&mut self, bytes: &[u8]) {
        Pico::hear(self, bytes).unwrap();
    }

    fn passes(&mut self, microseconds: u64) -> Vec<u8> {
        self.sent.clear();
        self.run(microseconds).unwrap();
        std::mem::take(&mut self.sent)
    }
}

/// Runs `picket` until it ends. The board's time passes from its first byte on, at most as fast as the host's.
fn picket(board: &mut impl Board, port: &mut TTYPort, arguments: &[&str], limit_s: u64) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let mut heard = false;
    while running(&mut child) {
        assert!(begun.elapsed() < Duration::from_secs(limit_s), "{arguments:?}: it does not end");
        let mut bytes = [0; 512];
        if let Ok(count @ 1..) = port.read(&mut bytes) {
            board.hear(&bytes[..count]);
            heard = true;
        }
        if !heard {
            continue;
        }
        let said = board.passes(2_000);
        // Nobody reads any more when it ends.
        let _ = port.write_all(&said);
    }
    child.wait_with_output().unwrap()
}

fn running(child: &mut Child) -> bool {
    child.try_wait().unwrap().is_none()
}

/// What is printed can be sent back, settings are kept over the restart that they cause, and orders are repeated until the
/// board, deaf meanwhile, has answered.
#[test]
fn settings_go_round() {
    let long = std::env::var_os("PICKET_LONG").is_some();
    for (start, rounds) in [(true, if long { 100 } else { 2 }), (false, if long { 100 } else { 1 })]
    {
        let settings = Settings { start, ..Settings::default() };
        let (mut board, _) = Emulated::start(&settings);
        let (mut ours, theirs) = TTYPort::pair().unwrap();
        ours.set_timeout(Duration::from_millis(1)).unwrap();
        let name = theirs.name().unwrap();
        let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("round-{start}.json"));
        let mut rate = 500e3;
        for round in 0..rounds {
            let got = watch(&mut board, &mut ours, &name, &["--get-settings"]);
            let (out, err) =
                (String::from_utf8(got.stdout).unwrap(), String::from_utf8(got.stderr).unwrap());
            assert!(got.status.success(), "{err}");
            let mut json: serde_json::Value =
                serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"));
            assert!((json["rate_hz"].as_f64().unwrap() - rate).abs() < 1.0, "round {round}: {out}");
            rate = [250e3, 500e3][round % 2];
            json["rate_hz"] = rate.into();
            fs::write(&file, json.to_string()).unwrap();
            let path = file.to_str().unwrap();
            let set = watch(&mut board, &mut ours, &name, &["--set-settings", path, "--save"]);
            let told = String::from_utf8(set.stderr).unwrap();
            assert!(set.status.success() && told.contains("--save: done"), "round {round}: {told}");
            let kept = board.sectors().settings().unwrap();
            assert!((kept.config.rate_hz - rate).abs() < 1.0 && kept.start == start, "{kept:?}");
        }
        assert!(board.resets.iter().all(|(_, cause)| cause == "software"), "{:?}", board.resets);
        println!("{rounds} round trips, measuring: {start}");
    }
}

/// The board goes through its list, and a person gets it to paste into a report.
#[test]
fn the_self_test_prints_its_list() {
    let mut board = Emulated::plug();
    let (mut ours, theirs) = TTYPort::pair().unwrap();
    ours.set_timeout(Duration::from_millis(1)).unwrap();
    let name = theirs.name().unwrap();
    // Settings that somebody has saved stay.
    let saved = Settings { report_every: 7, ..Settings::default() };
    let mut sectors = board::Sectors::new();
    sectors.save(&saved);
    board.load(&sectors);
    for order in ["erase 150", "input 0 dac", "oscillator 1"] {
        board.order(order);
    }
    let (mut board, _) = board.power();
    let report = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("doctor-self-test.json");
    let file = report.to_str().unwrap();
    let arguments = ["doctor", &name, "--self-test", "--quick", "--emulated", "--seconds", "2"];
    let arguments = [&arguments[..], &["--report", file, "--force"]].concat();
    let listened = picket(&mut board, &mut ours, &arguments, 500);
    let (out, err) =
        (String::from_utf8(listened.stdout).unwrap(), String::from_utf8(listened.stderr).unwrap());
    println!("{out}{err}");
    let (_, list) = out.split_once("picket self-test ").unwrap_or_else(|| panic!("{out}{err}"));
    let lines: Vec<&str> = list.lines().collect();
    assert!(lines[0].ends_with("started by software"), "{}", lines[0]);
    for (line, wanted) in lines[1..].iter().zip([
        "clock of 180 MHz from the crystal: the probe's 8 MHz are 8.000000 by it, the watchdog's 32 kHz 32.00",
        "clock of 144 MHz from the crystal",
        "option word 0fffaae1: a reset below 2.7 V is set",
        "cycles of a block: ",
        "noise at A0 at 180 MHz, codes: with prefetch 0.000, without 0.000, with ADCDC1 0.000",
        "noise at A0 at 144 MHz, codes: with prefetch 0.000, without 0.000, with ADCDC1 0.000, with ADCxDC2 0.000",
        "500 kS/s: 8 blocks, 0 lost, 0 faults",
        "10 kS/s: 8 blocks, 0 lost, 0 faults",
        "100 kS/s: 8 blocks, 0 lost, 0 faults",
        "1500 kS/s: 8 blocks, 0 lost, 0 faults",
        "1200 kS/s: 8 blocks, 0 lost, 0 faults",
        "chirp of A2 at A0, in step: 8 blocks, 0 lost, 0 faults",
        "settings saved in 15",
        "settings loaded after a reset",
        "watchdog: it bites after ",
        "stack: ",
    ]) {
        assert!(line.starts_with(&format!("- [x] {wanted}")), "{wanted}: {line}");
    }
    let stack: u32 = lines[16].split(' ').find_map(|word| word.parse().ok()).unwrap();
    assert!((4_000..30_000).contains(&stack), "{}", lines[16]);
    assert_eq!(lines[17], "result: 16 of 16 hold");
    assert_eq!(lines.len(), 18);
    let written = fs::read_to_string(report.with_extension("txt")).unwrap();
    assert!(lines.iter().skip(1).all(|line| written.contains(line)), "{written}");
    assert_eq!(board.resets.iter().filter(|(_, cause)| cause == "watchdog").count(), 1);
    assert_eq!(board.sectors().settings().map(|settings| settings.report_every), Some(7));
    // It is an instrument again.
    assert!(board.boot().measuring);
    board.assert_rules();
}

/// Runs the checks on a board, and gives those that do not hold and the report.
fn doctor(board: &mut impl Board, name: &str) -> (Vec<String>, serde_json::Value) {
    let (mut ours, theirs) = TTYPort::pair().unwrap();
    ours.set_timeout(Duration::from_millis(1)).unwrap();
    let report = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("doctor-{name}.json"));
    let port = theirs.name().unwrap();
    let file = report.to_str().unwrap();
    let arguments = ["doctor", &port, "--emulated", "--seconds", "2", "--report", file, "--force"];
    let output = picket(board, &mut ours, &arguments, 240);
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    println!("{out}{err}");
    let json = fs::read_to_string(&report).unwrap_or_else(|error| panic!("{error}: {out}{err}"));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let checks = json["checks"].as_array().unwrap();
    assert_eq!(checks.len(), 10);
    let failed = checks.iter().filter(|check| check["holds"] == false);
    let failed: Vec<String> =
        failed.map(|check| check["name"].as_str().unwrap().to_owned()).collect();
    assert_eq!(output.status.code(), Some(i32::from(!failed.is_empty())), "{out}{err}");
    let list = fs::read_to_string(report.with_extension("txt")).unwrap();
    assert!(out.lines().all(|line| list.contains(line)), "{list}");
    (failed, json)
}

/// Codes of a sine at 100 bins of 1024.
fn sine() -> Vec<u16> {
    let code = |n: usize| {
        let turns = (100 * n % 1024) as f64 / 1024.0;
        (2048.5 + 900.0 * (std::f64::consts::TAU * turns).sin()) as u16
    };
    (0..1024).map(code).collect()
}

#[test]
fn a_sound_nucleo_passes_its_ten_checks_and_a_bad_one_says_why() {
    let config = Config { rate_hz: 50e3, ..Settings::default().config };
    let settings = Settings { config, ..Settings::default() };
    let (mut board, _) = Emulated::start(&settings);
    let codes: Vec<u8> = sine().into_iter().flat_map(u16::to_le_bytes).collect();
    board.order(&format!("input 0 table {}", board::file(&codes).display()));
    let (failed, report) = doctor(&mut board, "nucleo");
    assert!(failed.is_empty(), "{failed:?}");
    assert_eq!(report["boot"]["board"], "nucleo-f446re");
    assert_eq!(report["block"].as_array().unwrap().len(), 1024);
    assert!((report["settings"]["rate_hz"].as_f64().unwrap() - 50e3).abs() < 1.0);
    // The crystal fails, and nothing drives the input.
    board.order("input 0 none");
    board.order("hse 0");
    board.boot();
    let (failed, _) = doctor(&mut board, "nucleo-bad");
    assert_eq!(failed, ["start", "clock", "input"]);
}

#[test]
fn a_sound_pico_passes_its_ten_checks() {
    let image = pico::usb_image().unwrap_or_else(|error| panic!("{error}"));
    let mut pico = Pico::plug(&pico::binary(&image).unwrap()).unwrap();
    let samples: Vec<i16> = sine().into_iter().map(|code| code as i16).collect();
    pico.samples(&samples).unwrap();
    pico.power().unwrap();
    let (failed, report) = doctor(&mut pico, "pico");
    assert!(failed.is_empty(), "{failed:?}");
    assert_eq!(report["boot"]["board"], "pico");
}

/// The list that a Pico goes through by itself reaches a person, too; `host-tests/tests/pico/self_test.rs` has its items.
#[test]
fn a_pico_tries_itself() {
    let image = pico::usb_image().unwrap_or_else(|error| panic!("{error}"));
    let mut pico = Pico::plug(&pico::binary(&image).unwrap()).unwrap();
    pico.order("jumper").unwrap();
    pico.power().unwrap();
    let (mut ours, theirs) = TTYPort::pair().unwrap();
    ours.set_timeout(Duration::from_millis(1)).unwrap();
    let report = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("doctor-pico-itself.json");
    let (name, file) = (theirs.name().unwrap(), report.to_str().unwrap());
    let arguments = ["doctor", &name, "--self-test", "--quick", "--emulated", "--seconds", "2"];
    let arguments = [&arguments[..], &["--report", file, "--force"]].concat();
    let output = picket(&mut pico, &mut ours, &arguments, 500);
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    println!("{out}{err}");
    let list = fs::read_to_string(report.with_extension("txt")).unwrap();
    for text in [&out, &list] {
        assert!(text.contains("picket self-test ") && text.contains("250 kS/s: 8 blocks"));
        assert!(text.contains("result: 13 of 13 hold") && !text.contains("WRONG"), "{text}{err}");
    }
}

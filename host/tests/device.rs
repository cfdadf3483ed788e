//! `cargo picket watch` and `cargo picket flash` as a user runs them, with a device that is only bytes.

use crate::cli::fresh;
use nix::fcntl::{FcntlArg, FdFlag, fcntl};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::{Tone, Verdict};
use picket_host::flash::BUDGET;
use picket_wire::boot::Boot;
use picket_wire::command::{Answer, Command as Order, Refusal, Request};
use picket_wire::frame::Reader;
use picket_wire::settings::Settings;
use picket_wire::status::{Raw, Status};
use picket_wire::telemetry::{Health, Telemetry};
use serialport::{SerialPort, TTYPort};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub const PICKET: &str = env!("CARGO_BIN_EXE_picket");

pub fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// A tone of an eighth of the rate.
fn record(sequence: u32) -> Vec<u8> {
    let stamp = Stamp { sequence, clock: u64::from(sequence) * 1024, ..Stamp::default() };
    let frequency = Frequency::from_bins(128, 0.0_f32, 1024).unwrap();
    let tone = Tone {
        frequency,
        sigma: 1e-6,
        snr: 1000.0,
        amplitude: 900.0,
        verdict: Verdict::Good,
        rate_hz: 500e3,
        ..Tone::default()
    };
    let measurement = Measurement { stamp, clipped: 0, tone, result: Outcome::None };
    let health = Health { lost: 3, faults: 1 };
    Telemetry {
        measurement,
        method: Method::LeastSquaresReal,
        health,
        basis: None,
        uncertainty: None,
    }
    .to_frame()
    .to_vec()
}

/// What a device says: its start, its settings, measurements 0 to 9 without 4 and 5, damage, a status.
pub fn session() -> Vec<u8> {
    let boot = Boot { n: 1024, core_hz: 180_000_000, measuring: true, ..Boot::default() };
    let answer = Answer { tag: 1, command: 4 }.reply(&Settings::default().to_bytes(1024));
    let mut bytes = [boot.to_frame().to_vec(), answer.to_vec()].concat();
    for sequence in [0, 1, 2, 3, 6, 7, 8, 9] {
        bytes.extend(record(sequence));
    }
    bytes.extend([1, 2, 3, 4, 0]);
    bytes.extend(Status { load: 512, ..Status::default() }.to_frame());
    bytes
}

fn run(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(PICKET)
        .arg("watch")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A command that was refused does not read.
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn jsonl_has_the_fields_and_counts_what_is_missing() {
    let recorded = PathBuf::from(fresh("session.bin"));
    let output = run(&["-", "--jsonl", "--record", recorded.to_str().unwrap()], &session());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines: Vec<serde_json::Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let [records @ .., status, summary] = &lines[..] else { panic!("{lines:?}") };
    assert_eq!(records.len(), 8);
    // The settings told the rate: 500 kS/s.
    assert_eq!(records[0]["frequency_hz"], 62_500.0);
    assert_eq!(records[7]["sequence"], 9);
    assert_eq!(records[7]["missing"], 2);
    assert!((records[7]["time_s"].as_f64().unwrap() - 9.0 * 1024.0 / 500e3).abs() < 1e-12);
    assert!((records[0]["snr_db"].as_f64().unwrap() - 30.0).abs() < 1e-9);
    assert_eq!((&records[0]["verdict"], &records[0]["lost"]), (&"good".into(), &3.into()));
    assert_eq!(status["load_permille"], 512);
    assert_eq!((&summary["summary"], &summary["missing"]), (&true.into(), &2.into()));
    assert_eq!((&summary["records"], &summary["bad_frames"]), (&8.into(), &1.into()));
    // What was recorded is every byte, and replays alike.
    assert_eq!(fs::read(&recorded).unwrap(), session());
    let again = run(&["--replay", recorded.to_str().unwrap(), "--jsonl"], &[]);
    assert_eq!(text(&again.stdout), text(&output.stdout));
}

#[test]
fn table_csv_and_teleplot() {
    let table = text(&run(&["-"], &session()).stdout);
    assert!(
        table.lines().any(|line| line.contains("62500.0000") && line.contains("good")),
        "{table}"
    );
    assert!(table.contains("180 MHz from") && table.contains("8 records, 2 blocks"), "{table}");
    let csv = text(&run(&["-", "--csv"], &session()).stdout);
    let columns = |line: &str| line.split(',').count();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 9, "{csv}");
    assert!(lines.iter().all(|line| columns(line) == columns(lines[0])), "{csv}");
    let teleplot = text(&run(&["-", "--teleplot"], &session()).stdout);
    assert!(teleplot.lines().all(|line| line.starts_with('>')), "{teleplot}");
    assert_eq!(teleplot.lines().filter(|line| *line == ">frequency_hz:62500").count(), 8);
}

#[test]
fn what_is_wrong_is_told_in_a_line() {
    for (arguments, says) in [
        (&["/nowhere/port"][..], "/nowhere/port"),
        (&["--replay", "/nowhere/file"], "/nowhere/file"),
        (&["-", "--stop"], "commands need a port"),
        (&["-", "--replay", "x"], "--help"),
        (&["-", "--csv", "--jsonl"], "--help"),
        (&["-", "--capture", "3"], "--help"),
    ] {
        let output = run(arguments, &[]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.lines().count() == 1 && message.contains(says), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
    }
}

/// A serial port of which the test has the other end, under a name that outlives it.
pub fn plug(name: &Path) -> (TTYPort, TTYPort) {
    let (mut ours, theirs) = TTYPort::pair().unwrap();
    ours.set_timeout(Duration::from_secs(60)).unwrap();
    // The program must not inherit our end, or the port never goes away.
    for end in [ours.as_raw_fd(), theirs.as_raw_fd()] {
        fcntl(end, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).unwrap();
    }
    let _ = fs::remove_file(name);
    symlink(theirs.name().unwrap(), name).unwrap();
    (ours, theirs)
}

pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn unplugging_and_plugging_in_again_is_survived() {
    let name = path("port");
    let (mut ours, theirs) = plug(&name);
    let mut child = Running(
        Command::new(PICKET)
            .arg("watch")
            .args([name.to_str().unwrap(), "--jsonl", "--rate", "500000", "--count", "2"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let mut lines = BufReader::new(child.0.stdout.take().unwrap()).lines();
    let mut told = BufReader::new(child.0.stderr.take().unwrap()).lines().map(|line| line.unwrap());
    let mut asked = [0; 8];
    ours.read_exact(&mut asked).unwrap();
    assert_eq!(asked[0], 0, "it asks who is there");
    ours.write_all(&record(0)).unwrap();
    assert!(lines.next().unwrap().unwrap().contains("\"sequence\":0"));
    fs::remove_file(&name).unwrap();
    // Its end here stayed open only so that the port is one before the program opens it.
    drop((ours, theirs));
    assert!(told.any(|line| line.contains("is gone; waiting for it")));
    let (mut ours, _theirs) = plug(&name);
    ours.read_exact(&mut asked).unwrap();
    ours.write_all(&record(5)).unwrap();
    let line = lines.next().unwrap().unwrap();
    assert!(line.contains("\"sequence\":5") && line.contains("\"missing\":4"), "{line}");
    assert!(told.any(|line| line.contains("is back")));
}

#[test]
fn flash_builds_within_the_budget_and_stops_before_the_probe() {
    let output = Command::new(PICKET).args(["flash", "--dry-run"]).output().unwrap();
    let said = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let words: Vec<&str> = said.split_whitespace().collect();
    let after = |word: &str| -> u64 {
        let at = words.iter().position(|w| *w == word).unwrap();
        words[at + 1].parse().unwrap()
    };
    assert!(after("flash") <= BUDGET.flash && after("flash") > 10_000, "{said}");
    // A stack of 6 KB comes on top, which tests/nucleo.rs measures.
    assert!(after("RAM") <= BUDGET.ram, "{said}");
    let binary = said.lines().nth(1).unwrap();
    let bytes = fs::read(binary).unwrap();
    // A vector table: the stack's start in RAM, the reset handler in flash.
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(word(0), 0x2002_0000);
    assert_eq!(word(4) & 0xFFF0_0001, 0x0800_0001);
}

pub fn start(arguments: &[&str]) -> Running {
    let mut command = Command::new(PICKET);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    Running(command.spawn().unwrap())
}

/// What a program has printed, and how it ended; it must end within a minute.
pub fn ended(mut running: Running) -> Output {
    let begun = Instant::now();
    while running.0.try_wait().unwrap().is_none() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    running.0.stdout.take().unwrap().read_to_end(&mut stdout).unwrap();
    running.0.stderr.take().unwrap().read_to_end(&mut stderr).unwrap();
    Output { status: running.0.wait().unwrap(), stdout, stderr }
}

pub fn signal(running: &Running, signal: Signal) {
    kill(Pid::from_raw(running.0.id() as i32), signal).unwrap();
}

#[test]
fn a_full_disk_is_told() {
    let output = run(&["-", "--record", "/dev/full"], &session());
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("/dev/full: No space left on device")
            && message.contains("0 bytes are kept"),
        "{message}"
    );
    let recording = path("to-a-full-disk.bin");
    fs::write(&recording, session()).unwrap();
    let replay = ["watch", "--csv", "--replay", recording.to_str().unwrap()];
    for arguments in [&replay[..], &["simulate", "--help"], &["man"], &["help"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = Command::new(PICKET).args(arguments).stdout(full).output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert!(
            message.contains("stdout: No space left") && message.contains("0 lines"),
            "{message}"
        );
    }
}

/// The end of a port for writing: a program that is slow to read is waited for.
pub fn patient(port: &TTYPort) -> TTYPort {
    let mut line = port.try_clone_native().unwrap();
    fcntl(line.as_raw_fd(), FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).unwrap();
    line.set_timeout(Duration::from_secs(60)).unwrap();
    line
}

/// Plays a board on the other end of a port: `answer` has each order, and gives what the board says.
fn board(mut port: TTYPort, mut answer: impl FnMut(Request) -> Vec<u8> + Send + 'static) {
    let mut line = patient(&port);
    port.set_timeout(Duration::from_millis(20)).unwrap();
    std::thread::spawn(move || {
        let (mut reader, mut sequence) = (Reader::default(), 0);
        loop {
            let mut bytes = [0; 256];
            let count = match port.read(&mut bytes) {
                Ok(count) => count,
                Err(error) if error.kind() == std::io::ErrorKind::TimedOut => 0,
                Err(_) => return,
            };
            for &byte in &bytes[..count] {
                let Some(Ok(frame)) = reader.push(byte) else { continue };
                let Ok(request) = Request::from_frame(&frame) else { continue };
                let _ = line.write_all(&answer(request));
            }
            // It measures all the while.
            sequence += 1;
            if line.write_all(&record(sequence)).is_err() {
                return;
            }
        }
    });
}

#[test]
fn settings_alone_are_on_stdout_while_it_measures() {
    let name = path("port-settings");
    let (ours, _theirs) = plug(&name);
    board(ours, |request| match request.command {
        Order::GetSettings => request.answer().reply(&Settings::default().to_bytes(1024)).to_vec(),
        _ => request.answer().reply(&[]).to_vec(),
    });
    let output = ended(start(&["watch", name.to_str().unwrap(), "--get-settings"]));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let settings: serde_json::Value = serde_json::from_str(&text(&output.stdout)).unwrap();
    assert_eq!(settings["rate_hz"], 500e3);
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

/// New settings start the board again: it is deaf meanwhile, and the order to keep them is sent again.
#[test]
fn settings_are_kept_though_the_board_starts_anew() {
    let (name, file) = (path("port-save"), path("settings.json"));
    fs::write(&file, r#"{"rate_hz": 250000}"#).unwrap();
    let (ours, _theirs) = plug(&name);
    let (mut set, mut deaf) = (false, 0);
    let (saved, was_saved) = std::sync::mpsc::channel();
    board(ours, move |request| {
        if deaf > 0 {
            deaf -= 1;
            return Vec::new();
        }
        match request.command {
            Order::SetSettings(settings, n) => {
                // The next two orders come while it starts.
                (set, deaf) = (true, 2);
                let boot = Boot { n: 1024, measuring: true, ..Boot::default() };
                [request.answer().reply(&settings.to_bytes(n)).to_vec(), boot.to_frame().to_vec()]
                    .concat()
            }
            Order::Save => {
                saved.send(set).unwrap();
                request.answer().reply(&[]).to_vec()
            }
            _ => request.answer().reply(&Settings::default().to_bytes(1024)).to_vec(),
        }
    });
    let arguments =
        ["watch", name.to_str().unwrap(), "--set-settings", file.to_str().unwrap(), "--save"];
    let output = ended(start(&arguments));
    let message = text(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert!(was_saved.try_recv().unwrap(), "saved before it was set");
    assert!(
        message.contains("--set-settings: done") && message.contains("--save: done"),
        "{message}"
    );
}

/// After two seconds, and no sooner.
#[test]
fn silence_and_noise_are_told() {
    for (name, noise, says) in [
        ("port-silent", &b""[..], "it says nothing"),
        ("port-noise", &b"hello, I am a modem\r\n"[..], "21 bytes came, and no frame"),
    ] {
        let name = path(name);
        let (mut ours, _theirs) = plug(&name);
        let mut running = start(&["watch", name.to_str().unwrap()]);
        ours.read_exact(&mut [0; 8]).unwrap();
        ours.write_all(noise).unwrap();
        let begun = Instant::now();
        let mut line = String::new();
        BufReader::new(running.0.stderr.as_mut().unwrap()).read_line(&mut line).unwrap();
        assert!(line.starts_with("waiting for the device") && line.contains(says), "{line}");
        let waited = begun.elapsed().as_secs_f64();
        assert!(waited > 1.5, "{waited} s");
    }
}

/// A wrong port, or a wrong rate of bits: whoever orders something is told after three seconds, and the program ends.
#[test]
fn orders_that_no_board_hears_end() {
    for (name, noise, says) in [
        ("port-deaf", &b""[..], "it says nothing"),
        (
            "port-modem",
            &b"\xf8\x00\x80\xff\x00AT+OK\r\n"[..],
            "bytes came, and no frame; is it the board's port?",
        ),
    ] {
        let name = path(name);
        let (mut ours, _theirs) = plug(&name);
        let begun = Instant::now();
        let running = start(&["watch", name.to_str().unwrap(), "--get-settings"]);
        ours.read_exact(&mut [0; 8]).unwrap();
        ours.write_all(noise).unwrap();
        let output = ended(running);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.lines().count() == 1 && message.contains(says), "{message}");
        // An order is repeated before.
        let waited = begun.elapsed().as_secs_f64();
        assert!(waited > 2.5, "{waited} s");
    }
}

/// Without an order it waits longer, for a board that is being switched on, and not for ever.
#[test]
fn a_port_that_stays_silent_is_given_up() {
    let name = path("port-for-ever");
    let (_ours, _theirs) = plug(&name);
    let output = ended(start(&["watch", name.to_str().unwrap(), "--jsonl"]));
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    let [waiting, gives_up] = message.lines().collect::<Vec<_>>()[..] else { panic!("{message}") };
    assert!(waiting.starts_with("waiting for the device"), "{message}");
    assert!(gives_up.starts_with("error: asked 8 times: it says nothing"), "{message}");
}

/// A board that is heard and does not hear.
#[test]
fn an_order_without_an_answer_ends() {
    let name = path("port-one-way");
    let (ours, _theirs) = plug(&name);
    board(ours, |_| Vec::new());
    let output = ended(start(&["watch", name.to_str().unwrap(), "--stop"]));
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("sent 8 times without an answer"), "{message}");
}

/// The first command arrives damaged: the board says so, and the command comes again at once.
#[test]
fn a_damaged_command_is_sent_again() {
    let again = |attempt: u32| {
        let name = path(&format!("port-damaged-{attempt}"));
        let (ours, _theirs) = plug(&name);
        let mut first: Option<Instant> = None;
        let (tell, told) = std::sync::mpsc::channel();
        board(ours, move |request| match first {
            None => {
                first = Some(Instant::now());
                Answer::default().refusal(Refusal::Damaged).to_vec()
            }
            Some(first) => {
                tell.send(first.elapsed()).unwrap();
                let settings = Settings::default().to_bytes(1024);
                request.answer().reply(&settings).to_vec()
            }
        });
        let output = ended(start(&["watch", name.to_str().unwrap(), "--get-settings"]));
        assert!(output.status.success(), "{}", text(&output.stderr));
        told.recv().unwrap()
    };
    // An order that was not answered is repeated after a second. A busy machine may take as long now and then, and not always.
    let fastest = (0..20).map(again).find(|after| *after < Duration::from_millis(900));
    assert!(fastest.is_some(), "it waits as if it had heard nothing");
}

/// Blocks as a board sends them, of samples that all are their block's number. The line loses the pieces that `lost` names.
fn blocks(sequences: std::ops::Range<u32>, lost: impl Fn(u32, u16) -> bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    for sequence in sequences {
        for offset in (0..2048).step_by(Raw::PIECE) {
            let length = Raw::PIECE.min(2048 - offset);
            let bytes_of_it = std::iter::repeat_n(sequence as u8, length).collect();
            let raw = Raw { sequence, offset: offset as u16, bytes: bytes_of_it };
            if !lost(sequence, raw.offset) {
                bytes.extend(raw.to_frame());
            }
        }
    }
    bytes
}

/// A piece of a capture is lost: its block is asked for again, and the file has as many blocks as were wanted.
#[test]
fn a_lost_piece_of_a_capture_is_asked_for_again() {
    let (name, file) = (path("port-hole"), PathBuf::from(fresh("hole.i16")));
    let (ours, _theirs) = plug(&name);
    let mut next = 0;
    board(ours, move |request| match request.command {
        Order::GetSettings => request.answer().reply(&Settings::default().to_bytes(1024)).to_vec(),
        Order::Capture(count) => {
            let from = next;
            next += u32::from(count);
            // A piece in the middle, and a whole block at the end.
            let lost = |sequence, offset| (sequence, offset) == (1, 384) || sequence == 3;
            [request.answer().reply(&[]).to_vec(), blocks(from..next, lost)].concat()
        }
        _ => request.answer().reply(&[]).to_vec(),
    });
    let (port, to) = (name.to_str().unwrap(), file.to_str().unwrap());
    let output = ended(start(&["watch", port, "--capture", "4", "--capture-to", to]));
    let message = text(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert!(message.contains("2 of 4 blocks did not come whole"), "{message}");
    let captured = fs::read(&file).unwrap();
    let sequences: Vec<u8> = captured.chunks(2048).map(|block| block[0]).collect();
    assert_eq!((captured.len(), &sequences[..]), (4 * 2048, &[0, 2, 4, 5][..]));
    assert!(captured.chunks(2048).all(|block| block.iter().all(|&byte| byte == block[0])));
}

/// A line that loses a piece of every block: the capture ends, and says what came.
#[test]
fn a_capture_that_never_comes_whole_ends() {
    let (name, file) = (path("port-holes"), PathBuf::from(fresh("holes.i16")));
    let (ours, _theirs) = plug(&name);
    board(ours, |request| match request.command {
        Order::GetSettings => request.answer().reply(&Settings::default().to_bytes(1024)).to_vec(),
        Order::Capture(count) => {
            let pieces = blocks(0..count.into(), |_, offset| offset == 192);
            [request.answer().reply(&[]).to_vec(), pieces].concat()
        }
        _ => request.answer().reply(&[]).to_vec(),
    });
    let (port, to) = (name.to_str().unwrap(), file.to_str().unwrap());
    let output = ended(start(&["watch", port, "--capture", "2", "--capture-to", to]));
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("--capture: 0 of 2 blocks came whole"), "{message}");
}

#[test]
fn one_measurement_is_one_row() {
    for style in ["--csv", "--jsonl"] {
        let output = run(&["-", style, "--count", "1"], &session());
        let rows = text(&output.stdout).lines().filter(|line| line.contains("good")).count();
        assert_eq!(rows, 1, "{}", text(&output.stdout));
    }
    let table = text(&run(&["-", "--count", "1"], &session()).stdout);
    assert_eq!(table.lines().filter(|line| line.contains("good")).count(), 1, "{table}");
}

/// Whoever runs the tests may be allowed everything: then nobody types it.
#[test]
fn a_port_that_one_may_not_open_is_told_with_its_cure() {
    const NOBODY: u32 = 65_534;
    let (_ours, theirs) = TTYPort::pair().unwrap();
    let name = theirs.name().unwrap();
    fs::set_permissions(&name, fs::Permissions::from_mode(0o000)).unwrap();
    // Nobody may not enter every folder: a copy lies where anybody may start it.
    let folder = tempfile::Builder::new().prefix("picket").tempdir().unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
    let copy = folder.path().join("picket");
    fs::copy(PICKET, &copy).unwrap();
    let mut watch = Command::new(&copy);
    if fs::metadata(&name).unwrap().uid() == 0 {
        watch.uid(NOBODY).gid(NOBODY);
    }
    let output = watch.args(["watch", &name]).current_dir("/").output().unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.starts_with(&format!("error: {name}: you may not open it: ")), "{message}");
    assert!(message.contains("dialout") && message.lines().count() == 1, "{message}");
}

#[test]
fn what_udev_needs_is_printed() {
    let output = run(&["--install-udev"], &[]);
    let rule = text(&output.stdout);
    assert!(
        output.status.success() && rule.contains("SUBSYSTEM==\"tty\", ATTRS{idVendor}==\"0483\""),
        "{rule}"
    );
}

#[test]
fn without_a_port_the_ports_are_listed() {
    let output = run(&[], &[]);
    let message = text(&output.stderr);
    let last = message.lines().last().unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        last.contains("name the port: picket watch ") || last.contains("plug the board in"),
        "{message}"
    );
}

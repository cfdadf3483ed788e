//! Every record's own rate drives what is shown of it, whatever the settings said: restart, partial recording, settings changed
//! by another host and a port opened again, in the table, csv, JSON and Teleplot's lines. What `--live` draws is tested beside it,
//! and the page in its package.

use crate::cli::file;
use crate::device::{PICKET, Running, path, patient, plug, start, text};
use crate::scenes::{RATES, SCENES, Scene, boot};
use picket_wire::command::{Command as Order, Request};
use picket_wire::frame::Reader;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

/// What is shown of bytes.
fn shown(name: &str, bytes: &[u8], style: &[&str]) -> String {
    let recording = file(name, bytes);
    let mut watch = Command::new(PICKET);
    let output = watch.args(["watch", "--replay", &recording]).args(style).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// Every frequency in hertz, and every time in seconds with its clock, in lines of JSON.
fn numbers(json: &str) -> Vec<(f64, Option<f64>)> {
    let rows = json.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let hertz = |row: &serde_json::Value| row["frequency_hz"].as_f64();
    let clock = |row: &serde_json::Value| Some(row["time_s"].as_f64()? * row["rate_hz"].as_f64()?);
    rows.filter_map(|row| Some((hertz(&row)?, clock(&row)))).collect()
}

#[test]
fn a_records_own_rate_is_shown() {
    for scene in SCENES.into_iter().filter(|scene| *scene != Scene::Reopened) {
        let [before, after] = scene.bytes();
        let bytes = [before, after].concat();
        // Of each rate so many blocks.
        let first = if scene == Scene::Partial { 0 } else { 3 };
        let expected: Vec<f64> =
            RATES.into_iter().zip([first, 3]).flat_map(|(rate, n)| vec![rate / 10.0; n]).collect();
        let name = format!("rates-{scene:?}.bin");
        // A record, two lines, a fundamental and a track a block.
        let json = numbers(&shown(&name, &bytes, &["--jsonl"]));
        let each: Vec<f64> = expected.iter().flat_map(|&hertz| [hertz; 5]).collect();
        let hertz: Vec<f64> = json.iter().map(|row| row.0.round()).collect();
        assert_eq!(hertz, each, "{scene:?}");
        let clocks: Vec<f64> = json.iter().filter_map(|row| Some(row.1?.round())).collect();
        let last = &clocks[clocks.len() - 3..];
        assert_eq!(last, [1024.0, 2048.0, 3072.0], "{scene:?}");
        let table = shown(&name, &bytes, &[]);
        let cells = table.lines().filter_map(|line| {
            let mut cells = line.split_whitespace().skip(2);
            cells.next()?.parse::<f64>().ok().filter(|hertz| *hertz > 1e3)
        });
        // Records and, below them, lines and fundamentals.
        let cells: Vec<f64> = cells.map(f64::round).collect();
        let of_records: Vec<f64> = cells.iter().copied().step_by(3).collect();
        assert_eq!(of_records, expected, "{scene:?}: {table}");
        assert!(!table.contains("cycles"), "{table}");
        for (style, column) in [("--csv", 4), ("--teleplot", 0)] {
            let lines = shown(&name, &bytes, &[style]);
            let hertz = lines.lines().filter_map(|line| match column {
                0 => line.strip_prefix(">frequency_hz:")?.parse::<f64>().ok(),
                _ => line.split(',').nth(column)?.parse().ok(),
            });
            let hertz: Vec<f64> = hertz.map(f64::round).collect();
            let per_block = hertz.len() / expected.len();
            let of_records: Vec<f64> = hertz.into_iter().step_by(per_block).collect();
            assert_eq!(of_records, expected, "{scene:?}: {lines}");
        }
    }
}

/// No record tells a rate, no settings do: the heading says that frequencies are in cycles per sample.
#[test]
fn without_a_rate_the_heading_says_so() {
    let [_, after] = Scene::Elsewhere.bytes();
    // The rate is the last field of a record's payload.
    let mut listener = picket_host::device::Listener::default();
    let bytes: Vec<u8> = listener
        .read(&after)
        .into_iter()
        .filter_map(|said| match said {
            picket_host::device::Said::Telemetry(mut record) => {
                record.measurement.tone.rate_hz = 0.0;
                Some(record.to_frame().to_vec())
            }
            _ => None,
        })
        .flatten()
        .collect();
    let table = shown("rateless.bin", &bytes, &[]);
    assert!(table.contains("cycles/sample") && !table.contains("frequency Hz"), "{table}");
    assert!(table.contains(" 0.100000000 ") && table.contains("1.00e-6"), "{table}");
    let json = shown("rateless.bin", &bytes, &["--jsonl"]);
    assert!(numbers(&json).is_empty() && json.contains("\"time_s\":null"), "{json}");
    // Only then the user's word is taken.
    let told = numbers(&shown("rateless.bin", &bytes, &["--jsonl", "--rate", "20k"]));
    assert!(told.len() == 3 && told.iter().all(|row| row.0.round() == 2000.0), "{told:?}");
    let [_, after] = Scene::Elsewhere.bytes();
    let told = numbers(&shown("rated.bin", &after, &["--jsonl", "--rate", "20k"]));
    assert!(told.iter().all(|row| row.0.round() == 10_000.0), "{told:?}");
}

/// Answers orders on a port, and tells each.
fn answering(
    mut port: serialport::TTYPort,
    rate_hz: f64,
    after: Vec<u8>,
    tell: mpsc::Sender<Order>,
) -> Answering {
    use serialport::SerialPort;
    let mut line = patient(&port);
    port.set_timeout(Duration::from_millis(20)).unwrap();
    let ends = Arc::new(AtomicBool::new(false));
    let ended = ends.clone();
    let thread = std::thread::spawn(move || {
        let (mut reader, mut after) = (Reader::default(), Some(after));
        loop {
            let told = ended.load(Ordering::Relaxed);
            let mut bytes = [0; 256];
            let count = port.read(&mut bytes).unwrap_or(0);
            // What was sent before the end is read.
            if told && count == 0 {
                break;
            }
            for &byte in &bytes[..count] {
                let Some(Ok(frame)) = reader.push(byte) else { continue };
                let Ok(request) = Request::from_frame(&frame) else { continue };
                let settings = request.command == Order::GetSettings;
                let body = if settings { crate::scenes::settings(rate_hz) } else { Vec::new() };
                line.write_all(&request.answer().reply(&body)).unwrap();
                let _ = tell.send(request.command);
                if let Some(after) = after.take_if(|_| settings) {
                    line.write_all(&after).unwrap();
                }
            }
        }
        port
    });
    Answering { ends, thread }
}

/// A board that answers until it is told to end.
struct Answering {
    ends: Arc<AtomicBool>,
    thread: std::thread::JoinHandle<serialport::TTYPort>,
}

impl Answering {
    /// Its end of the port.
    fn end(self) -> serialport::TTYPort {
        self.ends.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

fn asked(orders: &mpsc::Receiver<Order>) -> usize {
    orders.try_iter().filter(|order| *order == Order::GetSettings).count()
}

/// A board that restarts, or whose records tell of another rate, is asked for its settings again; so is one whose port is opened
/// again, and its records have their own rate before the answer.
#[test]
fn the_settings_are_asked_for_again() {
    for scene in [Scene::Restart, Scene::Elsewhere] {
        let name = path(&format!("port-rates-{scene:?}"));
        let (ours, _theirs) = plug(&name);
        let (tell, orders) = mpsc::channel();
        let [_, after] = scene.bytes();
        // Its first rate is seen in a record, too.
        let [_, first] = Scene::Partial.bytes();
        let said = [first, Scene::Restart.bytes()[0].clone(), after].concat();
        let board = answering(ours, RATES[0], said, tell);
        let running = start(&["watch", name.to_str().unwrap(), "--jsonl", "--count", "9"]);
        let rows = ended(running);
        let hertz: Vec<f64> =
            numbers(&rows).into_iter().filter(|row| row.1.is_some()).map(|row| row.0).collect();
        assert_eq!(hertz.last().unwrap().round(), 10_000.0, "{scene:?}: {rows}");
        drop(board.end());
        assert!(asked(&orders) >= 2, "{scene:?}: it is asked once");
    }
    let name = path("port-rates-again");
    let [before, after] = Scene::Reopened.bytes();
    let (ours, theirs) = plug(&name);
    let (tell, orders) = mpsc::channel();
    let board = answering(ours, RATES[0], before, tell.clone());
    let mut running = start(&["watch", name.to_str().unwrap(), "--jsonl"]);
    let mut lines = BufReader::new(running.0.stdout.take().unwrap()).lines();
    let mut next = |count: usize| -> Vec<f64> {
        let rows = lines.by_ref().map(|line| line.unwrap());
        let records = rows.filter(|row| row.contains("\"time_s\":"));
        let hertz = records.take(count).map(|row| numbers(&row)[0].0.round());
        hertz.collect()
    };
    assert_eq!(next(3), [25_000.0; 3]);
    std::fs::remove_file(&name).unwrap();
    drop((board.end(), theirs));
    assert!(asked(&orders) >= 1);
    let stderr = BufReader::new(running.0.stderr.take().unwrap());
    let mut told = stderr.lines().map(|line| line.unwrap());
    assert!(told.any(|line| line.contains("is gone; waiting for it")));
    let (ours, _theirs) = plug(&name);
    // Its answer is of the old rate still: a record is believed.
    let _board = answering(ours, RATES[0], after, tell);
    assert_eq!(next(3), [10_000.0; 3]);
    assert!(asked(&orders) >= 1, "it is not asked again");
}

/// What a program prints until it ends.
fn ended(mut running: Running) -> String {
    let mut said = String::new();
    running.0.stdout.take().unwrap().read_to_string(&mut said).unwrap();
    running.0.wait().unwrap();
    said
}

/// The frames of a board's start are no record.
#[test]
fn a_start_alone_shows_nothing_in_hertz() {
    let json = shown("rates-boot.bin", &boot(), &["--jsonl"]);
    assert!(numbers(&json).is_empty(), "{json}");
}

//! `picket analyze FILE --most 1..4`: the tones of each block, as a person, a spreadsheet and a program read them.

use crate::cli::{self, ANALYZE, fresh, lines, recorded, refused, run, seed};
use picket_simulator::Scene;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

const RATE_HZ: f64 = 48_000.0;
const N: usize = 1024;
const BLOCKS: usize = 8;
/// In codes, of each part.
const NOISE: f64 = 20.0;

/// Frequency in Hz, amplitude in codes, phase at the first sample in turns.
type Tone = (f64, f64, f64);
/// The strongest first.
const TONES: [Tone; 4] = [
    (3000.3, 8000.0, 0.06),
    (9876.5, 3000.0, 0.19),
    (5321.0, 1000.0, -0.32),
    (15_432.1, 350.0, 0.4),
];

/// The tones of a kind of recording: I/Q has one that turns backwards.
fn tones(count: usize, iq: bool) -> Vec<Tone> {
    let turned =
        |(place, (f, a, phase)): (usize, Tone)| (if iq && place == 1 { -f } else { f }, a, phase);
    TONES.into_iter().take(count).enumerate().map(turned).collect()
}

fn recording(name: &str, tones: &[Tone], iq: bool, noise: f64) -> String {
    let mut scene = Scene { seed: seed(4), ..cli::tones(BLOCKS * N, tones, noise) };
    scene.receiver.iq = iq;
    recorded(name, &scene)
}

/// The command's arguments: the recording, its kind, and the most tones.
fn arguments<'a>(path: &'a str, iq: bool, most: &'a str, others: &[&'a str]) -> Vec<&'a str> {
    let kind: &[&str] = if iq { &["--iq"] } else { &[] };
    [&[path][..], kind, &["--most", most], others].concat()
}

/// The tones of all blocks, by JSON.
fn found(path: &str, iq: bool, most: usize) -> Vec<Value> {
    lines(ANALYZE, &arguments(path, iq, &most.to_string(), &["--json"]))
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("no {key} in {row}"))
}

/// Every tone is in every block, the strongest first, and right: frequency and phase within five sigma. Where no tone is left over all are
/// good, and amplitudes within five times the noise's part in them.
#[test]
fn as_many_tones_as_there_are() {
    for (iq, count) in [(false, 1), (false, 4), (true, 1), (true, 4)] {
        let tones = tones(count, iq);
        let path = recording(&format!("tones-{count}-{iq}.wav"), &tones, iq, NOISE);
        for most in 1..=4 {
            let rows = found(&path, iq, most);
            let expected = most.min(count);
            assert_eq!(rows.len(), BLOCKS * expected, "{count} tones, I/Q {iq}, --most {most}");
            for (place, row) in rows.iter().enumerate() {
                let (block, tone) = (place / expected, place % expected);
                assert_eq!((&row["block"], &row["tone"]), (&block.into(), &(tone + 1).into()));
                let (hertz, amplitude, phase) = tones[tone];
                let middle_s = (block * N + N / 2) as f64 / RATE_HZ;
                assert!((number(row, "time_s") - middle_s).abs() < 1e-9, "{row}");
                let off_hz = number(row, "frequency_hz") - hertz;
                assert!(off_hz.abs() < 5.0 * number(row, "sigma_hz"), "{off_hz} Hz: {row}");
                let turn = TAU * (hertz * middle_s + phase);
                let off = (number(row, "phase_rad") - turn + PI).rem_euclid(TAU) - PI;
                assert!(off.abs() < 5.0 * number(row, "sigma_phase_rad"), "{off} rad: {row}");
                if most < count {
                    continue;
                }
                assert_eq!(row["verdict"], "good", "{row}");
                // A noise of sigma leaves sigma times the root of 2/N in an amplitude; that of I/Q less.
                let bar = 5.0 * NOISE * (2.0 / N as f64).sqrt();
                assert!((number(row, "amplitude") - amplitude).abs() < bar, "{row}");
            }
        }
    }
}

/// A tracked tone is a speed with its sigma; which way it goes, the mixing tells for I/Q.
#[test]
fn a_tracked_tone_is_a_speed() {
    for iq in [false, true] {
        let path = recording(&format!("tones-speed-{iq}.wav"), &tones(1, iq), iq, NOISE);
        for (mixing, sign) in [("rx-conj-tx", 1.0), ("tx-conj-rx", if iq { -1.0 } else { 1.0 })] {
            let track = ["--track", "--carrier-hz", "24e9", "--mixing", mixing];
            let rows =
                lines(ANALYZE, &arguments(&path, iq, "1", &[&track[..], &["--json"]].concat()));
            let (seen, trails): (Vec<_>, Vec<_>) =
                rows.iter().partition(|row| row["summary"] != true);
            assert!(seen.len() > BLOCKS / 2 && trails.len() == 1, "{rows:?}");
            let per_hertz = 299_792_458.0 / 24e9 / 2.0;
            for row in seen {
                let speed = sign * number(row, "frequency_hz") * per_hertz;
                assert!((number(row, "speed_mps") - speed).abs() < 1e-9, "{row}");
                let sigma = number(row, "sigma_hz") * per_hertz;
                assert!((number(row, "sigma_speed_mps") - sigma).abs() < 1e-12, "{row}");
                let off = (speed - sign * TONES[0].0 * per_hertz).abs();
                assert!(off < 5.0 * sigma, "{off} m/s: {row}");
            }
            let text = run(ANALYZE, &arguments(&path, iq, "1", &track)).stdout;
            let text = columns(&String::from_utf8(text).unwrap());
            assert_eq!(
                text[0].join(" "),
                "block time s track frequency Hz sigma Hz rate Hz/s misses speed m/s sigma verdict"
            );
            let csv = run(ANALYZE, &arguments(&path, iq, "1", &[&track[..], &["--csv"]].concat()));
            let csv = String::from_utf8(csv.stdout).unwrap();
            let mut table = csv::Reader::from_reader(csv.as_bytes());
            assert_eq!(table.headers().unwrap().iter().next_back(), Some("sigma_speed_mps"));
            assert!(table.records().all(|record| record.unwrap().len() == 12));
        }
    }
}

/// The heading's columns and the rows, without the verdict.
fn columns(text: &str) -> Vec<Vec<String>> {
    text.lines().map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

/// Text and csv say what JSON says; text rounds it.
#[test]
fn people_and_spreadsheets_read_the_same() {
    const KEYS: [&str; 9] = [
        "block",
        "time_s",
        "tone",
        "frequency_hz",
        "sigma_hz",
        "snr_db",
        "amplitude",
        "phase_rad",
        "sigma_phase_rad",
    ];
    for iq in [false, true] {
        let path = recording(&format!("tones-read-{iq}.wav"), &tones(4, iq), iq, NOISE);
        for carrier in [&[][..], &["--carrier-hz", "24e9"]] {
            let output = |style: &[&str]| {
                let output = run(ANALYZE, &arguments(&path, iq, "3", &[carrier, style].concat()));
                assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
                String::from_utf8(output.stdout).unwrap()
            };
            let json = output(&["--json"]);
            let rows: Vec<Value> =
                json.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
            assert_eq!(rows.len(), 3 * BLOCKS);
            let table = output(&["--csv"]);
            let mut table = csv::Reader::from_reader(table.as_bytes());
            let speeds: &[&str] =
                if carrier.is_empty() { &[] } else { &["speed_mps", "sigma_speed_mps"] };
            let heads = [&KEYS[..], &["verdict"], speeds].concat();
            assert_eq!(table.headers().unwrap(), &csv::StringRecord::from(heads.clone()));
            let records: Vec<csv::StringRecord> =
                table.records().map(|record| record.unwrap()).collect();
            assert_eq!(records.len(), rows.len());
            let text = columns(&output(&[]));
            assert_eq!(text.len(), 1 + rows.len());
            let keys = [&KEYS[..], speeds].concat();
            for ((row, record), words) in rows.iter().zip(&records).zip(&text[1..]) {
                for (head, cell) in heads.iter().zip(record) {
                    match row[*head].as_str() {
                        Some(word) => assert_eq!(cell, word),
                        None => assert_eq!(cell.parse::<f64>().unwrap(), number(row, head)),
                    }
                }
                assert_eq!(words.len(), keys.len() + 1, "{words:?}");
                assert_eq!(words[keys.len()], row["verdict"].as_str().unwrap());
                for (key, word) in keys.iter().zip(words) {
                    let digits = word.split_once('.').map_or(0, |(_, digits)| digits.len());
                    let off = word.parse::<f64>().unwrap() - number(row, key);
                    assert!(
                        off.abs() <= 0.5001 * 0.1f64.powi(digits as i32),
                        "{key} {word}: {row}"
                    );
                }
            }
        }
    }
}

/// One fundamental a block from harmonics that are ten times as strong: right within five sigma, no octave, and by JSON, spreadsheet and
/// text alike. A band keeps the octaves out where order 1 is missing, too.
#[test]
fn a_fundamental_is_found_by_its_harmonics() {
    let series: Vec<Tone> = [(1.0, 300.0), (2.0, 3000.0), (3.0, 2500.0), (4.0, 900.0)]
        .map(|(order, amplitude)| (611.7 * order, amplitude, order))
        .to_vec();
    for (iq, missing) in [(false, 0), (true, 0), (false, 1)] {
        let path = recording(&format!("series-{iq}-{missing}.wav"), &series[missing..], iq, NOISE);
        let kind: &[&str] = if iq { &["--iq"] } else { &[] };
        let arguments = [&[path.as_str()], kind, &["--harmonics", "6"]].concat();
        let rows = lines(ANALYZE, &[&arguments[..], &["--json"]].concat());
        assert_eq!(rows.len(), BLOCKS);
        for row in &rows {
            let off_hz = number(row, "frequency_hz") - 611.7;
            assert!(off_hz.abs() < 5.0 * number(row, "sigma_hz"), "{off_hz} Hz: {row}");
            // A line of order 1 would tell four times as little as that of order 4.
            assert!(number(row, "sigma_hz") < 0.1, "{row}");
            // What stronger lines mix to, as the third less the second, may be left out.
            let orders = row["orders"].as_array().unwrap();
            assert!(orders.ends_with(&[2.into(), 3.into(), 4.into()]), "{row}");
            assert_eq!(row["verdict"], "good", "{row}");
        }
        let output = |style: &[&str]| {
            let output = run(ANALYZE, &[&arguments[..], style].concat());
            assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
            String::from_utf8(output.stdout).unwrap()
        };
        let table = output(&["--csv"]);
        let mut table = csv::Reader::from_reader(table.as_bytes());
        for (record, row) in table.records().zip(&rows) {
            let record = record.unwrap();
            assert_eq!(record[2].parse::<f64>().unwrap(), number(row, "frequency_hz"));
            assert!(record[5].ends_with("2 3 4") && &record[6] == "good", "{record:?}");
        }
        let text = output(&[]);
        assert_eq!(text.lines().count(), 1 + BLOCKS);
        assert!(text.lines().nth(1).unwrap().ends_with("2, 3, 4"), "{text}");
    }
}

/// In noise no tone is good. Without any signal there is no tone at all: the table is empty, and a line says so.
#[test]
fn no_tone_is_told() {
    for iq in [false, true] {
        let noise = recording(&format!("tones-noise-{iq}.wav"), &[], iq, NOISE);
        for row in found(&noise, iq, 4) {
            assert_ne!(row["verdict"], "good", "{row}");
        }
        let silence = recording(&format!("tones-silence-{iq}.wav"), &[], iq, 0.0);
        for (style, heading) in [(&[][..], 1), (&["--csv"], 1), (&["--json"], 0)] {
            for (track, says) in [
                (&[][..], "no tone in 8 blocks\n"),
                (&["--track"], "no tone was held in 8 blocks\n"),
            ] {
                let output = run(ANALYZE, &arguments(&silence, iq, "4", &[style, track].concat()));
                assert!(output.status.success(), "{output:?}");
                assert_eq!(String::from_utf8_lossy(&output.stderr), says);
                let text = String::from_utf8(output.stdout).unwrap();
                assert_eq!(text.lines().count(), heading, "{text}");
                assert!(heading == 0 || text.contains("verdict"), "{text}");
            }
        }
    }
}

/// The picture has a line for each tone that is followed.
#[test]
fn as_many_tracks_as_are_asked_for() {
    for iq in [false, true] {
        let path = recording(&format!("tones-tracks-{iq}.wav"), &tones(4, iq), iq, NOISE);
        for most in 1..=4 {
            let picture = fresh(&format!("tones-{iq}.svg"));
            let words = ["--track", "--json", "--plot", &picture];
            let most = most.to_string();
            let rows = lines(ANALYZE, &arguments(&path, iq, &most, &words));
            let trails: Vec<f64> = rows
                .iter()
                .filter(|row| row["summary"] == true)
                .map(|row| number(row, "to_hz"))
                .collect();
            assert_eq!(trails.len().to_string(), most);
            for (hertz, ..) in tones(trails.len(), iq) {
                assert!(
                    trails.iter().any(|trail| (trail - hertz).abs() < 0.2),
                    "{hertz}: {trails:?}"
                );
            }
            let text = std::fs::read_to_string(&picture).unwrap();
            // In the legend's words.
            let drawn = (0..4).filter(|track| text.contains(&format!("track {track}: ")));
            assert_eq!(drawn.count(), trails.len());
        }
        refused(ANALYZE, &arguments(&path, iq, "2", &["--plot", "x.svg"]), "add --track");
    }
    let words = ["-", "--rate", "8000", "--format", "i16", "--track", "--plot", "x.svg"];
    refused(ANALYZE, &words, "give a file, not -");
}

//! Recordings as people have them: loggers' tables, dumps of a debugger, arrays of chirps. Each is a scene of the simulator, written as
//! the owner's program would write it; both the description and the measurement must be right.

use crate::cli::{ANALYZE, file, lines, refused, run};
use crate::survey::npy;
use picket_simulator::{Draw, Scene};
use serde_json::json;
use std::f64::consts::TAU;

const TONE_HZ: f64 = 41.37;
/// The scene is sampled so fast that a time between two of its samples is one of them.
const FINE_HZ: f64 = 200e3;

/// A tone at any time, s.
struct Signal {
    fine: Vec<f64>,
    draw: Draw,
}

impl Signal {
    fn new(seconds: f64) -> Self {
        let scene = json!({"seed": 61, "rate_hz": FINE_HZ, "seconds": seconds,
            "sources": [{"tone": {"frequency_hz": TONE_HZ, "amplitude": 0.3}}],
            "receiver": {"noise": {"rms": 0.01}}});
        let mut run = serde_json::from_value::<Scene>(scene).unwrap().run(0).unwrap();
        let samples = run.voltages(0.0, (seconds * FINE_HZ) as usize);
        Signal { fine: samples.into_iter().map(|[x, _]| x).collect(), draw: Draw::new(61, 1) }
    }

    fn volts(&self, time_s: f64) -> f64 {
        self.fine[(time_s * FINE_HZ).round() as usize]
    }

    /// A converter's code of 12 bits from 0 on.
    fn code(&self, time_s: f64) -> u16 {
        (2048.0 + 2047.0 * self.volts(time_s)).round() as u16
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.draw.between(-0.5, 0.5)).sum()
    }

    /// A table of times, as `time` writes them, and codes.
    fn table(&self, head: &str, times: &[f64], time: impl Fn(f64) -> String) -> String {
        let row = |t: &f64| format!("{},{}\n", time(*t), self.code(*t));
        head.to_owned() + &times.iter().map(row).collect::<String>()
    }
}

/// Even times, s.
fn even(count: usize, rate_hz: f64) -> Vec<f64> {
    (0..count).map(|k| k as f64 / rate_hz).collect()
}

fn look(path: &str, more: &[&str]) -> String {
    let output = run(ANALYZE, &[&[path], more].concat());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{path}: {}", String::from_utf8_lossy(&output.stderr));
    text
}

/// The errors of the answers that may be used in their uncertainties, and the verdicts of all.
fn measured(path: &str, more: &[&str], truth_hz: f64) -> (Vec<f64>, Vec<String>) {
    let all = lines(ANALYZE, &[&[path, "--json"], more].concat());
    let blocks: Vec<_> = all.iter().filter(|line| line["summary"].is_null()).collect();
    let usable =
        |line: &&&serde_json::Value| ["good", "moving"].iter().any(|it| line["verdict"] == *it);
    let number = |line: &serde_json::Value, key: &str| line[key].as_f64();
    let error = |line: &&serde_json::Value| {
        let hz = number(line, "frequency_hz").or(number(line, "cycles_per_sample")).unwrap();
        let sigma = number(line, "uncertainty_hz").or(number(line, "sigma_hz"));
        let sigma = sigma.or(number(line, "sigma_cycles_per_sample")).unwrap();
        (hz.abs() - truth_hz).abs() / sigma
    };
    let errors = blocks.iter().filter(usable).map(error).collect();
    (errors, blocks.iter().map(|line| line["verdict"].as_str().unwrap().to_owned()).collect())
}

/// All answers are usable and within five uncertainties.
#[track_caller]
fn right(path: &str, more: &[&str], truth_hz: f64) {
    let (errors, verdicts) = measured(path, more, truth_hz);
    assert!(!errors.is_empty() && errors.len() == verdicts.len(), "{path}: {verdicts:?}");
    assert!(errors.iter().all(|error| *error < 5.0), "{path}: {errors:?}");
}

/// The rate that a look states, and its sigma.
fn rate(look: &str) -> (f64, f64) {
    let line = look.lines().find_map(|line| line.strip_prefix("rate      ")).unwrap();
    let mut words = line.split([' ', ',']).filter_map(|word| word.parse().ok());
    (words.next().unwrap(), if line.contains("+-") { words.next().unwrap() } else { 0.0 })
}

#[test]
fn uneven_times_are_measured_or_refused() {
    let mut signal = Signal::new(8.0);
    // A loop that waits: each step adds its own delay.
    let mut walk = vec![0.001];
    while walk.len() < 4096 {
        let step = 0.0013 + 0.0002 * signal.normal();
        walk.push(walk[walk.len() - 1] + step);
    }
    let path =
        file("walk.csv", signal.table("time,volt\n", &walk, |t| format!("{t:.6}")).as_bytes());
    let text = look(&path, &[]);
    assert!(text.contains("not even in time") && !text.contains("try       picket"), "{text}");
    for n in ["256", "1024"] {
        let output = run(ANALYZE, &[&path, "--n", n, "--json"]);
        if output.status.success() {
            let (errors, _) = measured(&path, &["--n", n], TONE_HZ);
            assert!(errors.iter().all(|error| *error < 5.0), "{errors:?}");
        } else {
            let told = String::from_utf8_lossy(&output.stderr);
            assert!(told.contains("not even in time") && told.contains("--rate"), "{told}");
        }
    }
    // A timer whose times are read some microseconds late.
    let late: Vec<f64> =
        even(4096, 1000.0).iter().map(|t| t + 1e-5 * (3.0 + signal.normal())).collect();
    let micros = |t: f64| (4.0 * (t * 1e6 / 4.0).round()).to_string();
    let path = file("late.csv", signal.table("micros,adc\n", &late, micros).as_bytes());
    let (hz, sigma_hz) = rate(&look(&path, &[]));
    assert!((hz - 1000.0).abs() < 5.0 * sigma_hz && sigma_hz < 0.01, "{hz} {sigma_hz}");
    right(&path, &["--n", "1024"], TONE_HZ);
    // Shuffled, a column is no time.
    let mut mixed = late;
    (1..mixed.len()).for_each(|k| mixed.swap(k, signal.draw.below(k + 1)));
    let path =
        file("mixed.csv", signal.table("time,adc\n", &mixed, |t| format!("{t:.6}")).as_bytes());
    refused(ANALYZE, &[&path], "--rate");
}

#[test]
fn rates_come_from_the_whole_column() {
    let signal = Signal::new(14.0);
    let ms = |t: f64| format!("{:.3}", (t * 1000.0).floor() / 1000.0);
    let path = file("rounded.csv", signal.table("time,adc\n", &even(8192, 857.3), ms).as_bytes());
    let (hz, sigma_hz) = rate(&look(&path, &[]));
    assert!((hz - 857.3).abs() < 5.0 * sigma_hz && sigma_hz < 0.01, "{hz} {sigma_hz}");
    right(&path, &["--n", "2048"], TONE_HZ);
    // A logger that becomes slower.
    let slow: Vec<f64> = even(3000, 1000.0)
        .into_iter()
        .chain((0..3300).map(|k| 3.0 + f64::from(k) / 950.0))
        .collect();
    let path = file(
        "slower.csv",
        signal.table("time_ms,adc\n", &slow, |t| (t * 1e3).round().to_string()).as_bytes(),
    );
    let text = look(&path, &[]);
    assert!(text.contains("its rate changes") && (rate(&text).0 - 950.0).abs() < 0.1, "{text}");
    for part in ["1", "2"] {
        right(&path, &["--part", part, "--n", "512"], TONE_HZ);
    }
    refused(ANALYZE, &[&path, "--part", "3"], "2 parts");
    // One that pauses.
    let pause: Vec<f64> = even(4096, 1000.0)
        .into_iter()
        .chain((0..4096).map(|k| 6.5 + f64::from(k) / 1000.0))
        .collect();
    let path =
        file("pause.csv", signal.table("time,adc\n", &pause, |t| format!("{t:.3}")).as_bytes());
    let (errors, verdicts) = measured(&path, &["--n", "1024"], TONE_HZ);
    assert!(
        errors.len() >= 6 && errors.iter().all(|error| *error < 5.0),
        "{errors:?} {verdicts:?}"
    );
    assert!(verdicts.iter().any(|verdict| verdict == "gap"), "{verdicts:?}");
    let text = look(&path, &[]);
    assert!(text.contains("pause") && rate(&text).0 == 1000.0, "{text}");
}

#[test]
fn units_by_name_or_plausibility() {
    let signal = Signal::new(4.2);
    let times = even(2048, 1000.0);
    let in_units =
        |per_second: f64, start: f64| move |t: f64| (start + (t * per_second).round()).to_string();
    for (name, head, per_second, start) in [
        ("micros", "micros,adc\n", 1e6, 37_012.0),
        ("microseconds", "microseconds,adc\n", 1e6, 0.0),
        ("usec", "Time (usec),adc\n", 1e6, 12.0),
        ("ms", "Time(ms),CH1(mV)\n", 1e3, 0.0),
        ("stamp", "timestamp,v\n", 1e3, 3312.0),
        ("epoch", "timestamp,v\n", 1e3, 1.79e12),
        ("ts", "ts,v\n", 1e3, 1.79e12),
        ("bare", "", 1e6, 5.0),
    ] {
        let mut text = signal.table(head, &times, in_units(per_second, start));
        if head.is_empty() {
            text = text.replace(',', "\t");
        }
        let path = file(&format!("unit-{name}.csv"), text.as_bytes());
        let text = look(&path, &[]);
        assert!((rate(&text).0 - 1000.0).abs() < 0.1, "{name}: {text}");
        // What no name says is said.
        assert_eq!(
            text.contains("taken as"),
            ["stamp", "epoch", "ts", "bare"].contains(&name),
            "{name}: {text}"
        );
        right(&path, &["--n", "512"], TONE_HZ);
    }
    // A value, a tab, and millis().
    let rows: String = times
        .iter()
        .map(|t| format!("{}\t{}\n", signal.code(*t), (t * 1e3).round() + 9.0))
        .collect();
    right(&file("millis.txt", rows.as_bytes()), &["--n", "512"], TONE_HZ);
    // Ten milliseconds, or ten microseconds: only the owner knows.
    let rows = signal.table("timestamp,v\n", &even(400, 100.0), |t| (t * 1e3).round().to_string());
    let text = look(&file("which.csv", rows.as_bytes()), &[]);
    assert!(text.contains("--rate 100 for") && text.contains("--rate 100000 for"), "{text}");
    // Arduino's serial monitor.
    let rows: String =
        times.iter().map(|t| format!("12:34:{:06.3} -> {}\n", 5.0 + t, signal.code(*t))).collect();
    right(&file("monitor.txt", rows.as_bytes()), &["--n", "512"], TONE_HZ);
}

/// The converter's width means the same in every format.
#[test]
fn codes_of_twelve_bits() {
    let signal = Signal::new(4.2);
    let codes: Vec<u16> = even(4096, 1000.0).iter().map(|t| signal.code(*t)).collect();
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    let words: Vec<u8> = codes.iter().flat_map(|code| u32::from(*code).to_le_bytes()).collect();
    let text: String = codes.iter().map(|code| format!("{code}\n")).collect();
    let files = [
        file("codes.u16", &bytes),
        file("codes.i16", &bytes),
        file("codes.csv", text.as_bytes()),
        file("codes.npy", &npy("<u2", "4096,", bytes.clone())),
        file("codes.i32", &words),
    ];
    let options = ["--bits", "12", "--unsigned", "--rate", "1000", "--n", "1024", "--json"];
    let first = lines(ANALYZE, &[&[&files[0][..]], &options[..]].concat());
    for path in &files {
        right(path, &options[..7], TONE_HZ);
        assert_eq!(lines(ANALYZE, &[&[&path[..]], &options[..]].concat()), first, "{path}");
    }
    refused(ANALYZE, &[&files[0], "--bits", "11"], "choose 8");
}

/// What looks like something else is said before any number, and what to add is right.
#[test]
fn dumps_that_look_like_something_else() {
    let signal = Signal::new(17.0);
    let code = |k: u32, scale: f64| (2047.0 * scale * signal.volts(f64::from(k) / 1000.0)) as i16;
    let words: Vec<u8> = (0..4096)
        .flat_map(|k| u32::from(signal.code(f64::from(k) / 1000.0)).to_le_bytes())
        .collect();
    let turns: Vec<u8> = (0..4096)
        .flat_map(|k| [code(k, 1.0), code(4 * k, 0.7) + 300])
        .flat_map(i16::to_le_bytes)
        .collect();
    // A quarter of a period is the other part.
    let part = |k: u32, q: bool| {
        let late = if q { 0.25 / TONE_HZ } else { 0.0 };
        (3000.0 * signal.volts(f64::from(k) / 1000.0 + 0.25 - late)) as i16
    };
    let fours: Vec<u8> = (0..2048)
        .flat_map(|k| {
            [part(2 * k, false), part(2 * k + 1, false), part(2 * k, true), part(2 * k + 1, true)]
        })
        .flat_map(i16::to_le_bytes)
        .collect();
    for (name, bytes, told, cure) in [
        ("words.bin", words, "32-bit words", &["--format", "i32"][..]),
        ("turns.bin", turns, "two channels", &["--channels", "2", "--channel", "1"]),
        ("fours.bin", fours, "I I Q Q", &["--format", "iiqq"]),
    ] {
        let path = file(name, &bytes);
        refused(ANALYZE, &[&path], told);
        refused(ANALYZE, &[&path, "--n", "1024", "--rate", "1000"], told);
        right(&path, &[cure, &["--rate", "1000", "--n", "1024"]].concat(), TONE_HZ);
        // Who insists is believed.
        look(&path, &["--format", "i16"]);
    }
}

/// Texts of debuggers and of programs: numbers are found, and one row of thousands is one channel.
#[test]
fn texts_of_debuggers_and_programs() {
    let signal = Signal::new(4.2);
    let codes: Vec<u16> = even(2048, 1000.0).iter().map(|t| signal.code(*t)).collect();
    let list = codes.iter().map(u16::to_string).collect::<Vec<_>>();
    let hex = codes.iter().map(|code| format!("0x{code:04x}")).collect::<Vec<_>>();
    for (name, text) in [
        ("details.txt", format!("\tDetails:{{{}}}", list.join(", "))),
        ("gdb.txt", format!("$1 = {{{}}}\n", list.join(", "))),
        ("array.c", format!("const uint16_t adc[2048] = {{\n{}\n}};\n", hex.join(",\n"))),
        ("list.py", format!("adc = [{}]\n", list.join(", "))),
        ("row.csv", list.join(",")),
        ("named.txt", list.iter().map(|code| format!("A0:{code}\n")).collect()),
        ("items.txt", list.iter().zip(0..).map(|(code, k)| format!("[{k}] = {code}\n")).collect()),
        ("list.json", format!("{{\"fs\": 1000, \"adc\": [{}]}}\n", list.join(","))),
    ] {
        right(&file(name, text.as_bytes()), &["--rate", "1000", "--n", "512"], TONE_HZ);
    }
    let cut = format!("$1 = {{{}...}}\n", list[..200].join(", "));
    refused(ANALYZE, &[&file("cut.txt", cut.as_bytes())], "left numbers out");
}

/// Chirps, frames and receivers in one array.
#[test]
fn arrays_of_chirps() {
    let cycles = 0.1037;
    let scene = json!({"seed": 62, "rate_hz": 1.0, "seconds": 256.0 * 24.0,
        "sources": [{"tone": {"frequency_hz": cycles, "amplitude": 0.3, "phase_turns": 0.1}}],
        "receiver": {"iq": true, "noise": {"rms": 0.003}}});
    let mut run = serde_json::from_value::<Scene>(scene).unwrap().run(0).unwrap();
    // Between chirps some samples are lost, so that no phase goes on.
    let chirps: Vec<Vec<[f64; 2]>> =
        (0..20).map(|k| run.voltages(f64::from(k) * 300.3, 256)).collect();
    let bytes = |parts: usize| -> Vec<u8> {
        chirps
            .iter()
            .flatten()
            .flat_map(|x| x[..parts].to_vec())
            .flat_map(|x| (x as f32).to_le_bytes())
            .collect()
    };
    let text: String = chirps
        .iter()
        .map(|chirp| {
            chirp.iter().map(|x| format!("{:.5}", x[0])).collect::<Vec<_>>().join(",") + "\n"
        })
        .collect();
    for (name, data, said, more) in [
        ("chirps.npy", npy("<f4", "20, 256", bytes(1)), "chirp,sample", &[][..]),
        ("complex.npy", npy("<c8", "20, 256", bytes(2)), "chirp,sample", &[]),
        ("cube.npy", npy("<c8", "5, 4, 256", bytes(2)), "chirp,rx,sample", &[]),
        ("cube.npy", npy("<c8", "5, 4, 256", bytes(2)), "chirp,rx,sample", &["--channel", "3"]),
        (
            "frames.npy",
            npy("<c8", "5, 4, 256", bytes(2)),
            "frame,chirp,sample",
            &["--axes", "frame,chirp,sample"],
        ),
        ("pairs.npy", npy("<f4", "20, 256, 2", bytes(2)), "chirp,sample,iq", &[]),
        ("matrix.csv", text.into_bytes(), "record of its own", &[]),
    ] {
        let path = file(name, &data);
        let text = look(&path, more);
        assert!(text.contains(said) && text.contains("try       picket"), "{name}: {text}");
        let (errors, verdicts) = measured(&path, more, cycles);
        let records = if said.contains("rx") { 5 } else { 20 };
        assert!(verdicts.len() == records && errors.len() + 1 >= records, "{name}: {verdicts:?}");
        assert!(errors.iter().all(|error| *error < 5.0), "{name}: {errors:?}");
    }
    let path = file("cube.npy", &npy("<c8", "5, 4, 256", bytes(2)));
    refused(ANALYZE, &[&path, "--axes", "chirp,sample"], "5, 4, 256");
    refused(ANALYZE, &[&path, "--channel", "5"], "choose 1 to 4");
    // The radar of OmniPreSense writes I and Q line by line.
    let list = |chirp: &Vec<[f64; 2]>, part: usize| {
        chirp.iter().map(|x| (2048.0 + 2000.0 * x[part]).round()).collect::<Vec<_>>()
    };
    let rows: String = chirps
        .iter()
        .map(|chirp| {
            format!(
                "{{\"sample_time\":\"9.5\"}}\n{}\n{}\n",
                json!({"I": list(chirp, 0)}),
                json!({"Q": list(chirp, 1)})
            )
        })
        .collect();
    let path = file("ops243.json", rows.as_bytes());
    let (errors, verdicts) = measured(&path, &[], cycles);
    assert!(
        verdicts.len() == 20 && errors.len() >= 19 && errors.iter().all(|error| *error < 5.0),
        "{verdicts:?} {errors:?}"
    );
    // A logger writes an object a sample.
    let tone = samples(
        &json!({"seed": 4, "rate_hz": 1000.0, "seconds": 4.0, "receiver": {"noise": {"snr_db": 30}},
        "sources": [{"tone": {"frequency_hz": 60.37, "amplitude": 0.5}}]}),
    );
    let objects = tone.iter().enumerate().map(|(n, x)| {
        json!({"t": 1000 * n, "pin": "A0", "value": {"adc": (2048.0 + 2000.0 * x[0]).round()}})
    });
    let objects: Vec<String> = objects.map(|it| it.to_string()).collect();
    for (name, text) in
        [("logger.jsonl", objects.join("\n")), ("logger.json", format!("[{}]", objects.join(",")))]
    {
        let path = file(name, text.as_bytes());
        assert!(look(&path, &[]).contains("microseconds"), "{name}");
        let (errors, verdicts) = measured(&path, &["--n", "1024"], 60.37);
        assert!(verdicts.len() == 3 && errors.len() == 3, "{name}: {verdicts:?}");
        assert!(errors.iter().all(|error| *error < 5.0), "{name}: {errors:?}");
    }
}

#[test]
fn silence_and_files_of_other_kinds() {
    let text = look(&file("zeros.i16", &[0; 8192]), &[]);
    assert!(text.contains("kind      silence") && !text.contains("try "), "{text}");
    refused(
        ANALYZE,
        &[&file("sheet.xlsx", b"PK\x03\x04\x14\0\0\0\0\0[Content_Types].xml xl/workbook.xml")],
        "save the sheet as CSV",
    );
    refused(ANALYZE, &[&file("table.csv.gz", b"\x1f\x8b\x08\0aaaa")], "gunzip");
    refused(ANALYZE, &[&file("cut.h5", b"\x89HDF\r\n\x1a\n\0\0\0\0")], "HDF5");
}

/// Any length of anything: bounded memory, and one line.
#[cfg(unix)]
#[test]
fn long_files_and_odd_names() {
    use std::fs::File;
    for (name, bytes) in [
        ("long.h5", 100u64 << 30),
        ("long.npz", 100 << 30),
        ("long.csv", 2 << 30),
        ("long.json", 2 << 30),
    ] {
        let path =
            file(name, if name.ends_with("h5") { b"\x89HDF\r\n\x1a\n" } else { b"PK\x03\x04" });
        File::options().write(true).open(&path).unwrap().set_len(bytes).unwrap();
        let output = run(ANALYZE, &[&path]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && told.lines().count() == 1, "{name}: {told}");
        std::fs::remove_file(&path).unwrap();
    }
    let signal = Signal::new(4.2);
    let table =
        signal.table("micros,adc\n", &even(2048, 1000.0), |t| (t * 1e6).round().to_string());
    // Cut anywhere, and in a file whose name breaks lines.
    for end in [9, 11, 12, 4000, table.len() - 3] {
        let path = file("a\nb.csv", &table.as_bytes()[..end]);
        let output = run(ANALYZE, &[&path, "--n", "64"]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(
            matches!(output.status.code(), Some(0 | 2)) && told.lines().count() <= 1,
            "{end}: {told}"
        );
    }
    let short: String = (0..1_000_000).map(|k| format!("{}\n", k % 7)).collect();
    look(&file("short.txt", short.as_bytes()), &[]);
}

/// What a look proposes for a file, and the errors of its answers in their uncertainties.
#[track_caller]
fn proposed(path: &str, more: &[&str], truth_hz: f64) -> (String, Vec<f64>) {
    let text = look(path, more);
    let line = text.lines().find_map(|line| line.strip_prefix("try       picket analyze "));
    let line = line.unwrap_or_else(|| panic!("nothing is proposed: {text}"));
    let words: Vec<&str> = line.split(' ').skip(1).collect();
    let (errors, _) = measured(path, &words, truth_hz);
    assert!(!errors.is_empty(), "no answer can be used: {text}");
    (text, errors)
}

/// Samples of a scene in volts.
fn samples(scene: &serde_json::Value) -> Vec<[f64; 2]> {
    let scene: Scene = serde_json::from_value(scene.clone()).unwrap();
    let count = (scene.rate_hz * scene.seconds).round() as usize;
    scene.run(0).unwrap().voltages(0.0, count)
}

fn words(codes: impl IntoIterator<Item = f64>) -> Vec<u8> {
    codes.into_iter().flat_map(|x| (x.round() as i16).to_le_bytes()).collect()
}

/// A proposal answers the line that it is for.
#[test]
fn proposals_answer_their_line() {
    // An editor fades the last ten milliseconds out.
    let clean = samples(&json!({"rate_hz": 44100, "seconds": 0.38,
        "sources": [{"tone": {"frequency_hz": 262, "amplitude": 0.5}}], "receiver": {"noise": {"rms": 1e-5}}}));
    let fade =
        |(k, x): (usize, &[f64; 2])| 32767.0 * x[0] * ((clean.len() - k) as f64 / 441.0).min(1.0);
    let path = file("faded.i16", &words(clean.iter().enumerate().map(fade)));
    let (text, errors) = proposed(&path, &["--rate", "44100"], 262.0);
    assert!(
        errors.iter().filter(|error| **error < 5.0).count() * 10 >= 9 * errors.len(),
        "{text} {errors:?}"
    );
    // A generator of 3,642 turns a minute is not the mains.
    let near = samples(&json!({"seed": 3, "rate_hz": 1000, "seconds": 8.2,
        "sources": [{"tone": {"frequency_hz": 60.7, "amplitude": 0.03}}], "receiver": {"noise": {"snr_db": 20}}}));
    let path = file("generator.i16", &words(near.iter().map(|x| 32767.0 * x[0])));
    let (text, errors) = proposed(&path, &["--rate", "1000"], 60.7);
    assert!(
        errors.iter().all(|error| *error < 5.0) && !text.contains("is among the lines"),
        "{text}"
    );
    // A few cycles in the whole recording.
    for cycles in [2.4, 3.3, 4.4] {
        let hz = cycles / 4.096;
        let slow = samples(&json!({"seed": 4, "rate_hz": 1000, "seconds": 4.096,
            "sources": [{"tone": {"frequency_hz": hz, "amplitude": 0.05}}], "receiver": {"noise": {"snr_db": 20}}}));
        let path = file("slow.i16", &words(slow.iter().map(|x| 32767.0 * x[0])));
        let (text, errors) = proposed(&path, &["--rate", "1000"], hz);
        assert!(errors.iter().all(|error| *error < 5.0), "{cycles}: {text} {errors:?}");
    }
}

/// A hall sensor's square wave is measured, whatever its rails.
#[test]
fn square_waves() {
    let square = samples(
        &json!({"seed": 5, "rate_hz": 48000, "seconds": 0.5, "receiver": {"oversampling": 8, "noise": {"rms": 1e-3}},
        "sources": [{"tone": {"frequency_hz": 333.3, "amplitude": 0.45, "form": "square", "phase_turns": 0.13}}]}),
    );
    let codes: Vec<f64> = square.iter().map(|x| 1970.0 + 4095.0 * x[0]).collect();
    let path = file("hall.i16", &words(codes.iter().map(|x| x.clamp(0.0, 4095.0))));
    let (text, errors) = proposed(&path, &["--rate", "48000"], 333.3);
    assert!(
        errors.iter().filter(|error| **error < 5.0).count() * 10 >= 9 * errors.len(),
        "{text} {errors:?}"
    );
    let volts: String = square.iter().map(|x| format!("{:.3}\n", 1.65 + 3.0 * x[0])).collect();
    let path = file("hall.csv", volts.as_bytes());
    let (text, errors) = proposed(&path, &["--rate", "48000"], 333.3);
    assert!(
        errors.iter().filter(|error| **error < 5.0).count() * 10 >= 9 * errors.len(),
        "{text} {errors:?}"
    );
}

/// All orders of a comparator's output, of which those beyond half the rate fold beside the others. No answer may be used and is off, and
/// most of a wave whose orders have bins of their own may be used.
#[test]
fn a_square_wave_by_its_harmonics() {
    let waves = [(333.3, 0.5, 8), (1000.37, 0.5, 3), (812.5, 0.23, 0), (4801.0, 0.4, 7)];
    for (hz, high, least) in waves {
        let mut signal = Signal::new(0.01);
        let mut square = |n: u32| {
            let turn = (hz / 48e3 * f64::from(n) + 0.137).rem_euclid(1.0);
            let level = if turn < high { 3000.0 } else { 1000.0 };
            level + 5.0 * signal.normal()
        };
        let codes: Vec<f64> = (0..30 * 2048).map(&mut square).collect();
        let path = file("comparator.i16", &words(codes));
        for n in ["1024", "2048"] {
            let kind = ["--rate", "48000", "--bits", "12", "--unsigned", "--n", n];
            let (errors, verdicts) =
                measured(&path, &[&kind[..], &["--harmonics", "9"]].concat(), hz);
            assert!(errors.iter().all(|error| *error < 5.0), "{hz} Hz, {n}: {errors:?}");
            assert!(10 * errors.len() >= least * verdicts.len(), "{hz} Hz, {n}: {verdicts:?}");
        }
    }
}

/// Three cycles are a steady tone, and so is a tone in a fifth of a recording.
#[test]
fn kinds_of_short_and_of_empty_recordings() {
    let mut signal = Signal::new(0.01);
    let mut tone = |count: u32, from: u32, to: u32, cycles: f64| {
        let sample = |n: u32| {
            let level = if (from..to).contains(&n) { 3000.0 } else { 0.0 };
            level * (TAU * cycles * f64::from(n) + 0.4).sin() + 30.0 * signal.normal()
        };
        words((0..count).map(sample))
    };
    let path = file("slow.i16", &tone(4096, 0, 4096, 3.3 / 4096.0));
    let (text, errors) = proposed(&path, &["--rate", "4096"], 3.3);
    assert!(text.contains("kind      steady") && errors.iter().all(|it| *it < 5.0), "{text}");
    let path = file("stretch.i16", &tone(300_000, 200_000, 260_000, 950.0 / 22_050.0));
    let text = look(&path, &["--rate", "22050"]);
    assert!(text.contains("kind      steady") && text.contains("it stands from 9."), "{text}");
}

/// A tone that accelerates, I/Q that loses samples, a car in a recording that is mostly empty.
#[test]
fn lengths_are_chosen_by_what_they_say() {
    let faster = samples(
        &json!({"seed": 6, "rate_hz": 44100, "seconds": 2, "receiver": {"noise": {"snr_db": 26}},
        "sources": [{"tone": {"frequency_hz": 900, "amplitude": 0.3, "changes": [{"chirp": {"hz_per_s": 1500}}]}}]}),
    );
    let path = file("faster.i16", &words(faster.iter().map(|x| 32767.0 * x[0])));
    let text = look(&path, &["--rate", "44100"]);
    let n = text.split("--n ").nth(1).and_then(|rest| rest.split([' ', '\n']).next()).unwrap();
    let sigmas = lines(ANALYZE, &[&path, "--rate", "44100", "--n", n, "--json"]);
    let mut sigmas: Vec<f64> = sigmas.iter().filter_map(|line| line["sigma_hz"].as_f64()).collect();
    sigmas.sort_by(f64::total_cmp);
    assert!(sigmas[sigmas.len() / 2] < 0.3, "{n}: {text} {:?}", sigmas[sigmas.len() / 2]);
    // Four samples in each 484 do not arrive.
    let hz = 3217.3;
    let whole = samples(
        &json!({"seed": 7, "rate_hz": 50e3, "seconds": 3, "receiver": {"iq": true, "noise": {"snr_db": 25}},
        "sources": [{"tone": {"frequency_hz": hz, "amplitude": 0.3}}]}),
    );
    let kept = whole.iter().enumerate().filter(|(k, _)| k % 484 >= 4).flat_map(|(_, x)| *x);
    let path = file("lost.cs16", &words(kept.map(|x| 32767.0 * x)));
    let text = look(&path, &["--rate", "50000"]);
    if text.contains("try       picket") {
        let (text, errors) = proposed(&path, &["--rate", "50000"], hz);
        assert!(
            errors.iter().filter(|error| **error < 5.0).count() * 10 >= 9 * errors.len(),
            "{text} {errors:?}"
        );
    }
    // 14 s, of which a car takes five.
    let car = json!({"range_m": 300, "velocity_mps": 13.41, "amplitude": 0.1, "changes": [{"on": {"from_s": 4.5, "for_s": 5}}]});
    let passes = samples(
        &json!({"seed": 8, "rate_hz": 8000, "seconds": 14, "waveform": {"carrier_hz": 10.525e9},
        "sources": [{"target": car}], "receiver": {"noise": {"rms": 0.03}}}),
    );
    let path = file("passes.i16", &words(passes.iter().map(|x| 32767.0 * x[0])));
    let shift = 2.0 * 13.41 * 10.525e9 / 299_792_458.0;
    let (text, errors) = proposed(&path, &["--rate", "8000"], shift);
    assert!(
        errors.iter().filter(|error| **error < 5.0).count() * 10 >= 9 * errors.len(),
        "{text} {errors:?}"
    );
}

/// Metres and metres per second from recordings of chirps.
#[test]
fn ranges_from_chirps() {
    for (shape, bounds, velocity) in [("sawtooth", Some("-1:1"), 0.0), ("triangle", None, 3.0)] {
        let waveform =
            json!({"shape": shape, "carrier_hz": 24e9, "bandwidth_hz": 200e6, "ramp_s": 5e-3});
        let chirps = samples(
            &json!({"seed": 9, "rate_hz": 200e3, "seconds": 0.4, "waveform": waveform, "receiver": {"iq": true, "noise": {"snr_db": 20}},
            "sources": [{"target": {"range_m": 12.34, "velocity_mps": velocity, "amplitude": 0.2}}]}),
        );
        let path =
            file(&format!("{shape}.cs16"), &words(chirps.iter().flatten().map(|x| 32767.0 * x)));
        let ramps = [
            "--rate",
            "200k",
            "--chirp-s",
            "5e-3",
            "--bandwidth-hz",
            "200M",
            "--carrier-hz",
            "24G",
            "--shape",
            shape,
            "--json",
        ];
        let mixing = ["--mixing", "tx-conj-rx"];
        let bounds = bounds.map_or(vec![], |bounds| vec!["--velocity-mps", bounds]);
        let all = lines(ANALYZE, &[&[&path[..]], &ramps[..], &mixing[..], &bounds].concat());
        assert!(all.len() >= 30, "{shape}: {} chirps", all.len());
        for line in &all[1..] {
            let number = |key: &str| line[key].as_f64().unwrap();
            let range = 12.34 - velocity * number("time_s");
            assert!(
                (number("range_m") - range).abs() < 6.0 * number("sigma_range_m") + 0.02,
                "{shape}: {line}"
            );
            assert_eq!(line["verdict"], "good", "{shape}: {line}");
            if shape == "triangle" {
                assert!(
                    (number("velocity_mps") - velocity).abs() < 6.0 * number("sigma_velocity_mps"),
                    "{line}"
                );
            }
        }
    }
    refused(ANALYZE, &["no-such.wav", "--chirp-s", "1e-3"], "--bandwidth-hz");
}

/// Continuous recordings of chirps whose period nobody told: found by themselves, or by a trigger in another channel.
#[test]
fn ramps_are_found() {
    // Samples from the recording's beginning to the first ramp, and pauses, which rest at the carrier's start.
    let ramp = "--rate 200k --chirp-s 5e-3 --bandwidth-hz 200M --carrier-hz 24G";
    let ramp: Vec<&str> = ramp.split(' ').collect();
    let kinds = [(137, 5e-3, "iq"), (1, 5.5e-3, "iq"), (611, 5e-3, "real"), (700, 5.0021e-3, "iq")];
    for (late, period_s, kind) in kinds {
        let iq = kind == "iq";
        let waveform = json!({"shape": "sawtooth", "carrier_hz": 24e9, "bandwidth_hz": 200e6, "ramp_s": 5e-3, "period_s": period_s});
        let chirps = samples(
            &json!({"seed": 9, "rate_hz": 200e3, "seconds": 0.4, "waveform": waveform, "receiver": {"iq": iq, "noise": {"snr_db": 20}},
            "sources": [{"target": {"range_m": 12.34, "velocity_mps": 0.0, "amplitude": 0.2}},
                {"target": {"range_m": 31.7, "velocity_mps": 0.0, "amplitude": 0.02}}]}),
        );
        let cut = &chirps[late..];
        let values = cut.iter().flat_map(|x| x[..if iq { 2 } else { 1 }].to_vec());
        let name = if iq { "late.cs16" } else { "late.i16" };
        let path = file(name, &words(values.map(|x| 32767.0 * x)));
        let more = ["--velocity-mps=-1:1", "--find-ramps", "--json"];
        let all = lines(ANALYZE, &[&[&path[..]], &ramp[..], &more[..]].concat());
        let count = (0.4 / period_s) as usize - 2;
        assert!(all.len() >= count, "{late} {period_s}: {} chirps", all.len());
        for line in &all {
            let number = |key: &str| line[key].as_f64().unwrap();
            assert_eq!(line["verdict"], "good", "{late} {period_s}: {line}");
            let off = (number("range_m") - 12.34).abs();
            assert!(off < 6.0 * number("sigma_range_m"), "{late} {period_s}: {line}");
        }
        // A pulse of some samples in the second channel, at the beginning of each ramp.
        let pulse = |n: usize| ((n as f64 / 200e3).rem_euclid(period_s) < 1e-4) as u8 as f64;
        let rows = cut.iter().enumerate();
        let rows: String =
            rows.map(|(n, x)| format!("{:.5},{:.2}\n", x[0], 3.3 * pulse(n + late))).collect();
        let path = file("trigger.csv", rows.as_bytes());
        let more = ["--velocity-mps=-1:1", "--channel", "1", "--trigger", "2", "--json"];
        let all = lines(ANALYZE, &[&[&path[..]], &ramp[..], &more[..]].concat());
        assert!(all.len() >= count, "{late} {period_s}: {} chirps by pulses", all.len());
        for line in &all {
            let number = |key: &str| line[key].as_f64().unwrap();
            let off = (number("range_m") - 12.34).abs();
            assert!(off < 6.0 * number("sigma_range_m"), "{late} {period_s}: {line}");
        }
        refused(
            ANALYZE,
            &[&[&path[..]], &ramp[..], &["--channel", "2", "--trigger", "1"]].concat(),
            "is no trigger",
        );
    }
    // A triangle's pulses come with its rising ramps.
    let triangle = ["--shape", "triangle"];
    let waveform =
        json!({"shape": "triangle", "carrier_hz": 24e9, "bandwidth_hz": 200e6, "ramp_s": 5e-3});
    let chirps = samples(
        &json!({"seed": 5, "rate_hz": 200e3, "seconds": 0.4, "waveform": waveform, "receiver": {"noise": {"snr_db": 20}},
        "sources": [{"target": {"range_m": 12.34, "velocity_mps": 0.7, "amplitude": 0.2}}]}),
    );
    let rows = chirps[1731..].iter().enumerate().map(|(n, x)| {
        format!("{:.5},{:.2}\n", x[0], if (n + 1731) % 2000 < 20 { 3.3 } else { 0.0 })
    });
    let path = file("triangle.csv", rows.collect::<String>().as_bytes());
    let more = ["--velocity-mps=-2:2", "--channel", "1", "--trigger", "2", "--json"];
    let all = lines(ANALYZE, &[&[&path[..]], &ramp[..], &triangle, &more].concat());
    assert!(all.len() >= 38, "{} triangles", all.len());
    for line in &all {
        let number = |key: &str| line[key].as_f64().unwrap();
        assert_eq!(line["verdict"], "good", "{line}");
        let off = (number("velocity_mps") - 0.7).abs();
        assert!(off < 6.0 * number("sigma_velocity_mps"), "{line}");
        // The range is that of a moment in the triangle.
        let start = 12.34 - 0.7 * (number("time_s") + 1731.0 / 200e3);
        let off = (number("range_m") - start).abs();
        assert!(off < 6.0 * number("sigma_range_m") + 0.7 * 10e-3, "{line}");
    }
    // A tone has no ramps, nor has noise.
    for amplitude in [0.0, 0.2] {
        let none = samples(
            &json!({"seed": 3, "rate_hz": 200e3, "seconds": 0.4, "receiver": {"noise": {"rms": 0.02}},
            "sources": [{"tone": {"frequency_hz": 3291.0, "amplitude": amplitude}}]}),
        );
        let path = file("none.i16", &words(none.iter().map(|x| 32767.0 * x[0])));
        refused(
            ANALYZE,
            &[&[&path[..], "--find-ramps"], &ramp[..]].concat(),
            "no ramps that repeat",
        );
    }
    let path = file("none.i16", &words((0..80_000).map(|n| f64::from(n % 50))));
    let all = [&[&path[..], "--find-ramps"], &ramp[..], &triangle].concat();
    refused(ANALYZE, &all, "look alike");
}

/// The clock of a converter that samples 37 millionths too fast.
#[test]
fn the_clock_by_a_known_tone() {
    let fast = 48_000.0 * (1.0 + 37e-6);
    let tone = samples(
        &json!({"seed": 10, "rate_hz": fast, "seconds": 2, "receiver": {"noise": {"snr_db": 40}},
        "sources": [{"tone": {"frequency_hz": 1000, "amplitude": 0.3}}]}),
    );
    let path = file("known.i16", &words(tone.iter().map(|x| 32767.0 * x[0])));
    let all =
        lines(ANALYZE, &[&path, "--rate", "48000", "--reference", "1000", "--n", "4096", "--json"]);
    let line = all.iter().find(|line| !line["clock_ppm"].is_null()).unwrap();
    let number = |key: &str| line[key].as_f64().unwrap();
    let (ppm, sigma) = (number("clock_ppm"), number("sigma_clock_ppm"));
    assert!((ppm - 37.0).abs() < 5.0 * sigma && sigma < 1.0, "{line}");
    let output = run(ANALYZE, &[&path, "--rate", "96000", "--reference", "1000", "--n", "4096"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && told.contains("the reference"), "{told}");
}

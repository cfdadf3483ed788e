//! The live page: in a browser as a person uses it, and its module beside the library on this machine.

mod inputs;

use host_tests::needed;
use inputs::{inputs, session};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier as Linewidth;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::tone::fit::Reach;
use picket_dsp::{Config, Effort, Mixing, Pipeline, Real, Shape, Stamp};
use picket_host::analyze::carrier::Carrier;
use picket_host::analyze::chirps::{self, Finding};
use picket_host::analyze::cut::Cut;
use picket_host::analyze::displacement::{self, Sensor};
use picket_host::analyze::moved::Moved;
use picket_host::analyze::radar::Radar;
use picket_host::analyze::told::Told;
use picket_host::analyze::{self, Analysis};
use picket_host::arithmetic::Arithmetic;
use picket_host::design::sheet::{self, Design, Question};
use picket_host::device::{Listener, Said};
use picket_host::explain;
use picket_host::recording::{Converter, Format, Options, Recording};
use picket_host::watch::line::Row;
use picket_host::web::{FILES, MODULES, Site, browser};
use picket_web::check;
use picket_wire::command::{Command, Request};
use picket_wire::frame::Reader;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

const RATE_HZ: f64 = 48e3;

/// One after the other: what is timed wants the machine, and the page is put together once.
static TURN: Mutex<()> = Mutex::new(());

fn turn() -> MutexGuard<'static, ()> {
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// `--arith target`, of a file that the page was given.
fn analysis(file: &Path) -> Analysis {
    let wav = file.extension().is_some_and(|e| e == "wav");
    let iq = file.to_string_lossy().contains("iq");
    Analysis {
        read: Options { rate_hz: (!wav).then_some(RATE_HZ), iq, ..Options::default() },
        ..Analysis::new(Codes::signed::<16>(), Arithmetic::Target)
    }
}

/// What `picket analyze FILE --arith target --json` prints, one value a line.
fn analyzed(file: &Path, analysis: &Analysis) -> Vec<Value> {
    let mut lines = Vec::new();
    let sink = |answer| lines.push(serde_json::to_value(answer).unwrap());
    let summary = analyze::run(file, analysis, sink, |_| ()).unwrap();
    lines.push(serde_json::to_value(summary).unwrap());
    lines
}

/// Alike: numbers to the bit.
fn assert_alike(ours: &Value, theirs: &Value) {
    let (Value::Object(ours), Value::Object(theirs)) = (ours, theirs) else {
        panic!("{ours} {theirs}")
    };
    for (name, value) in theirs {
        let same = match (ours[name].as_f64(), value.as_f64()) {
            (Some(ours), Some(theirs)) => ours.to_bits() == theirs.to_bits(),
            _ => ours[name] == *value,
        };
        assert!(same, "{name}: {} is not {value}", ours[name]);
    }
}

fn number(text: &str) -> f64 {
    let plain = text.replace('\u{2212}', "-");
    plain.trim_start_matches(['\u{b1}', ' ']).split(' ').next().unwrap().parse().expect(text)
}

/// The errors of a scene's readings in units of their sigmas, of the quantity with this name and unit.
fn errors(readings: &Value, name: &str, unit: &str) -> Vec<f64> {
    let readings = readings.as_array().unwrap().iter();
    readings
        .map(|said| {
            let figures = said["figures"].as_array().unwrap();
            let figure = figures.iter().find(|figure| figure["name"] == name).unwrap();
            let truth = said["truth"].as_str().unwrap().trim_start_matches("Truth ");
            let truth =
                truth.split(", ").find(|part| part.contains(&format!(" {unit} ("))).unwrap();
            let part = |part: &str| number(figure[part].as_str().unwrap());
            (part("value") - number(truth)) / part("sigma")
        })
        .collect()
}

fn clean(said: &Value) {
    assert_eq!(said["errors"], Value::Array(vec![]), "{said}");
}

fn word<'a>(said: &'a Value, name: &str) -> &'a str {
    said[name].as_str().unwrap_or_default()
}

fn scenes(said: &Value) {
    let first = said["first"].as_f64().unwrap();
    let ratio = said["ratio"].as_f64().unwrap();
    println!(
        "first figures after {first:.0} ms; a frame's work takes {ratio:.2} of a sixtieth of a second at N = 1024"
    );
    assert!(ratio > 0.0, "the frames are timed");
    let seen = &said["seen"];
    for (scene, name, unit) in [
        ("chirp", "Range", "m"),
        ("chirp", "Velocity", "m/s"),
        ("doppler", "Velocity", "m/s"),
        ("tone", "Frequency", "Hz"),
    ] {
        let errors = errors(&seen[scene], name, unit);
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        println!("{scene}, {name}: {} readings, rms {rms:.2} sigma, {errors:.2?}", errors.len());
        // Eight to sixteen normal numbers, and two digits of sigma.
        assert!(errors.len() >= 6 && errors.iter().all(|e| e.abs() < 5.0), "{scene}: {errors:?}");
        assert!((0.2..2.2).contains(&rms), "{scene}, {name}: {rms}");
        for reading in seen[scene].as_array().unwrap() {
            assert_eq!(word(reading, "word"), "good", "{reading}");
        }
    }
    assert_eq!(word(&said["clipped"], "word"), "clipped");
    assert!(word(&said["clipped"], "reason").contains("lower the gain"));
    assert!(["weak", "no-signal"].contains(&word(&said["weak"], "word")), "{said}");
}

fn hands(said: &Value) {
    for pair in said["widths"].as_array().unwrap() {
        assert!(pair[1].as_f64().unwrap() <= 390.0, "wider than a phone: {pair}");
    }
    let chosen: Vec<_> = said["widths"].as_array().unwrap().iter().map(|pair| &pair[0]).collect();
    assert_eq!(chosen, ["2File", "3Microphone", "4Board", "5Design", "1Simulated"]);
    let tops: Vec<f64> =
        said["tops"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert!(tops.is_sorted(), "answer, sliders, charts: {tops:?}");
    assert_eq!(said["held"][0], said["held"][1], "it was paused");
    assert_ne!(said["held"][1], said["moved"], "it goes on");
    assert_eq!(said["nameless"], Value::Array(vec![]), "controls without a name");
    assert!(said["labels"].as_u64().unwrap() >= 20, "labels are text of the page: {said}");
    assert_eq!(said["png"], "89504e470d0a1a0a");
    assert_eq!(said["ground"], "rgb(14, 18, 22)", "it is dark");
}

/// Without a mouse, and without eyes.
fn access(said: &Value) {
    let found = said["found"].as_array().unwrap();
    for looked in found {
        assert!(looked["rules"].as_u64().unwrap() > 10, "{looked}");
        assert_eq!(looked["violations"], Value::Array(vec![]), "{looked}");
    }
    println!("axe finds nothing in {} looks", found.len());
    assert_eq!(found.len(), 2 * 12, "{said}");
    assert!(said["order"].as_u64().unwrap() > 0, "the reason comes first: {said}");
    let [value, name, word] = [0, 1, 2].map(|place| &said["digits"][place]);
    assert!(value == name && value != word, "the digits are grey: {said}");
    let walked: Vec<Vec<&str>> = said["walked"].as_array().unwrap().iter().map(cells).collect();
    let tabs = ["design", "scene", "file", "microphone", "board", "design", "scene"]
        .map(|tab| format!("tab-{tab}"));
    assert_eq!(
        walked,
        tabs.each_ref().map(|tab| [tab.as_str(); 2]),
        "focused and chosen, one of them by Tab: {said}"
    );
    assert!(said["walked"].as_array().unwrap().iter().all(|walked| walked[2] == 1), "{said}");
    for chart in said["charts"].as_array().unwrap() {
        assert!(chart[0] == "img" && chart[1].as_str().unwrap().len() > 20, "{chart}");
    }
    let told = said["told"].as_array().unwrap();
    let times: Vec<f64> = told.iter().map(|told| told[0].as_f64().unwrap()).collect();
    let gaps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    println!("{} sentences are read out, {gaps:.0?} ms apart", told.len());
    // On the whole: a busy machine is late with one, and the next one is nearer.
    let apart = gaps.iter().sum::<f64>() / gaps.len() as f64;
    assert!(told.len() > 3 && apart > 900.0, "{told:?}");
    let read = |words: &str| told.iter().any(|told| told[1].as_str().unwrap().contains(words));
    assert!(read("good: Range") && read("Not usable, "), "{told:?}");
    for begins in said["begins"].as_array().unwrap() {
        assert_eq!(begins[1], true, "out of view on a phone: {begins}");
    }
}

fn nothing_hinders(said: &Value) {
    for looked in said["found"].as_array().unwrap() {
        assert_eq!(looked["violations"], Value::Array(vec![]), "{looked}");
    }
}

/// Bursts: right within their sigmas where they are valid.
fn bursts(said: &Value) {
    nothing_hinders(said);
    assert_eq!(said["instrument"], false, "{said}");
    assert!(word(said, "told").contains("validation"), "{said}");
    assert_eq!(word(&said["after"], "word"), "good", "{said}");
    let seen = said["seen"].as_array().unwrap();
    let validation = |said: &Value| {
        let figures = said["figures"].as_array().unwrap();
        let mut names = figures.iter().map(|figure| word(figure, "name"));
        names.find_map(|name| Some(name.strip_prefix("Burst, ")?.to_owned())).unwrap()
    };
    let valid =
        seen.iter().filter(|said| validation(said) == "valid" && !word(said, "truth").is_empty());
    let valid = Value::Array(valid.cloned().collect());
    let errors = errors(&valid, "Velocity", "m/s");
    println!("bursts: {} readings, {} of them valid, {errors:.2?}", seen.len(), errors.len());
    assert!(errors.len() >= 4, "{said}");
    let far = errors.iter().filter(|error| error.abs() > 5.0).count();
    // Of 535 valid bursts of that flow two are two particles that nearly agree.
    assert!(far <= 1, "{errors:?}");
}

/// Of every length a block is right within its sigmas.
fn lengths(said: &Value) {
    assert_eq!(said["offered"], serde_json::json!(sheet::LENGTHS), "{said}");
    for (scene, name, unit) in [("chirp", "Range", "m"), ("tone", "Frequency", "Hz")] {
        let errors = errors(&said["seen"][scene], name, unit);
        println!("{scene} by every length: {errors:.2?}");
        assert_eq!(errors.len(), sheet::LENGTHS.len());
        assert!(errors.iter().all(|error| error.abs() < 5.0), "{said}");
    }
}

/// A tone that no block shows is that of a hundred, right within its sigma; chirps are refused with the reason.
fn sums(said: &Value) {
    nothing_hinders(said);
    let usable = |word: &str| word == "good";
    assert!(!usable(word(&said["alone"], "word")), "{said}");
    assert_eq!(word(&said["sum"], "word"), "good", "{said}");
    let errors = errors(&Value::Array(vec![said["sum"].clone()]), "Frequency", "Hz");
    println!("sums: {errors:.2?} sigmas off");
    assert!(errors.len() == 1 && errors[0].abs() < 5.0, "{errors:?} {said}");
    assert!(word(said, "told").contains("judged as a whole"), "{said}");
    assert!(word(&said["chirp"], "notice").contains("sums are of a tone"), "{said}");
}

/// The sheet of rates and lengths: each answer is the library's on this machine, to the digits shown.
fn design(said: &Value) {
    nothing_hinders(said);
    for width in said["widths"].as_array().unwrap() {
        assert!(width[1].as_u64() <= width[0].as_u64(), "wider than the window: {width}");
    }
    assert_eq!(word(&said["after"], "word"), "good", "{said}");
    assert!(said["sigma"].as_f64().unwrap() <= 390.0, "sigma is out of view on a phone: {said}");
    let asked = said["asked"].as_array().unwrap();
    let radar = Question {
        wavelength_m: SPEED_OF_LIGHT / 24.125e9,
        velocity_mps: Some(10.0),
        snr_db: 10.0,
        sigma_mps: Some(0.01),
        ..Question::default()
    };
    let one = Question { sigma_mps: None, snr_db: -5.0, n: Some(1024), iq: true, ..radar };
    let laser =
        Question { wavelength_m: 1550e-9, velocity_mps: Some(0.1), n: None, iq: false, ..one };
    let chirp = Question {
        wavelength_m: SPEED_OF_LIGHT / 24e9,
        velocity_mps: None,
        rate_hz: Some(200e3),
        chirp: Some((200e6, 5e-3)),
        snr_db: 12.0,
        sigma_m: Some(0.01),
        ..laser
    };
    let questions = [radar, Question { sigma_mps: Some(0.002), ..radar }, one, laser, chirp];
    for (shown, question) in asked.iter().zip(questions) {
        let design = Design::of(question).unwrap();
        assert_eq!(word(shown, "wrong"), "", "{shown}");
        assert_eq!(word(shown, "settings"), design.settings().unwrap_or_default());
        assert_eq!(cells(&shown["head"]), design.head());
        let rows: Vec<Vec<&str>> = shown["rows"].as_array().unwrap().iter().map(cells).collect();
        assert_eq!(rows, design.rows.iter().map(sheet::Row::cells).collect::<Vec<_>>());
        assert_eq!(shown["chosen"].as_i64(), Some(design.chosen.map_or(-1, |row| row as i64)));
        let sentences = design.sentences().into_iter().map(|line| format!("{line}."));
        assert_eq!(cells(&shown["sentences"]), sentences.collect::<Vec<_>>());
        assert!(word(shown, "picture").contains("the bin falls from "), "{shown}");
        println!("{question:?}: {} rows", rows.len());
    }
    assert!(word(&asked[4], "title").contains("range, m,"), "{}", asked[4]);
    let told = ["bandwidth", "rate", "samples per second", "No block of 4096", "carrier"];
    assert_eq!(asked.len(), questions.len() + told.len());
    for (shown, words) in asked[questions.len()..].iter().zip(told) {
        assert!(word(shown, "wrong").contains(words), "{shown}");
        assert_eq!(shown["rows"], Value::Array(vec![]), "{shown}");
    }
}

/// The tests behind a verdict, as `picket explain` prints them.
fn explained(said: &Value, folder: &Path) {
    assert_eq!(said["held"][0], said["held"][1], "it holds still: {said}");
    assert_ne!(said["held"][1], said["moved"], "it goes on: {said}");
    assert_eq!(cells(&said["focus"]), ["why", "verdict"]);
    for looked in said["found"].as_array().unwrap() {
        assert_eq!(looked["violations"], Value::Array(vec![]), "{looked}");
    }
    let answer = word(&said["chirp"], "answer");
    assert!(answer.contains(", rising ramp: ") && answer.contains("Usable: yes."), "{answer}");
    assert!(said["chirp"]["tests"].as_array().unwrap().len() > 11, "{said}");
    assert!(word(said, "notice").contains("no block to explain"), "{said}");
    for shown in said["files"].as_array().unwrap() {
        let file = folder.join(word(shown, "file"));
        let analysis = analysis(&file);
        let mut blocks = 0;
        analyze::run(&file, &analysis, |_| blocks += 1, |_| ()).unwrap();
        let explanation = analyze::explain(&file, &analysis, blocks - 1).unwrap();
        let verdict = explanation.explained.estimate.verdict;
        let answer = word(shown, "answer");
        let begin = format!("Block {}:", blocks - 1);
        let end = format!("{verdict}. {} Usable: {}.", verdict.reason(), verdict.usable());
        assert!(answer.starts_with(&begin) && answer.ends_with(&end), "{answer}");
        let rows = explain::rows(&explanation);
        let tests = shown["tests"].as_array().unwrap();
        println!("{}: {verdict} by {} tests", word(shown, "file"), rows.len());
        assert_eq!(tests.len(), rows.len(), "{shown}");
        for (test, row) in tests.iter().zip(&rows) {
            let [about, name, value, limit, followed] = cells(test)[..] else { panic!("{test}") };
            assert_eq!(about, row.about);
            let fit = row.fit.map(|fit| format!(" ({fit} fit)")).unwrap_or_default();
            assert_eq!(name, format!("{}{fit}", row.test));
            for (shown, value) in [(value, row.value), (limit, row.limit)] {
                let value = value.map(|x| format!("{x:.2} {}", row.unit).replace('-', "\u{2212}"));
                let value = value.unwrap_or_default();
                // A zero has no sign on the page.
                assert!(value.ends_with(shown) || value.trim() == shown, "{shown} {value}");
            }
            assert!(row.followed == "-" || followed.ends_with(&row.followed), "{followed}");
            assert!(row.outcome() == "-" || followed.contains(row.outcome()), "{followed}");
        }
    }
}

/// A file's name is text, whatever it says.
fn strange(said: &Value) {
    assert_eq!(said["struck"], false, "{said}");
    assert_eq!(said["images"][0], said["images"][1], "{said}");
    let title = word(said, "title");
    let seen = said["seen"].as_array().unwrap();
    assert!(seen[0][0].as_str().unwrap().starts_with(title), "{said}");
    // What is wrong with such a file names it.
    for notice in [&seen[1][1], &seen[2][1]] {
        assert!(notice.as_str().unwrap().contains(title), "{said}");
    }
}

fn file(said: &Value, folder: &Path) {
    let file = folder.join(word(said, "file"));
    as_analyzed(said, &file, &analysis(&file));
}

/// Of two channels those that were chosen, at a rate that the file does not tell.
fn choice(said: &Value, folder: &Path) {
    assert!(word(said, "wrong").contains("two channels: choose one under Channel"), "{said}");
    assert!(said["rate"].is_u64() || word(said, "told") == "48000, as the file says", "{said}");
    let file = folder.join(word(said, "file"));
    let channel = |name: &str| said[name].as_u64().map(|channel| channel as usize);
    let channel = channel("channel").map(|first| (first, channel("q")));
    let rate_hz = said["rate"].as_f64();
    let read = Options { channel, rate_hz, ..Options::default() };
    as_analyzed(said, &file, &Analysis { read, ..analysis(&file) });
}

/// A cube of chirps: its targets as `analyze` has them, true of the scene, and the map with them.
fn frames(said: &Value, folder: &Path) {
    nothing_hinders(said);
    assert!(word(said, "asked").contains("records of 256 samples"), "{said}");
    assert_eq!(word(&said["before"]["figures"][0], "unit"), "cycles per sample", "{said}");
    let radar = Radar {
        shape: Shape::Sawtooth,
        carrier_hz: 77e9,
        bandwidth_hz: 306e6,
        chirp_s: 102e-6,
        mixing: Mixing::TxConjRx,
        velocity_mps: Some((-8.0, 8.0)),
        effort: Effort::default(),
        false_alarm: None,
    };
    let told = Told { period_s: Some(120e-6), guard_s: Some(2e-6), ..Told::default() };
    let cut = Cut {
        read: Options { rate_hz: Some(2.56e6), ..Options::default() },
        n: 256,
        hop: 256,
        skip: 0,
        band_hz: None,
        codes: Codes::signed::<16>(),
        reach: Reach::default(),
        width: Linewidth { linewidth_hz: 0.0, envelope_hz: 0.0 },
    };
    let mut theirs = Vec::new();
    let mut sink = |found: &Finding| {
        if let Finding::Frame(found) = found {
            theirs.push((**found).clone());
        }
    };
    chirps::run(&folder.join("cube.npy"), &cut, None, &radar, &told, &mut sink).unwrap();
    let ours: Vec<Value> =
        word(said, "json").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((ours.len(), theirs.len()), (4, 4), "{said}");
    let run = inputs::radar();
    for (index, (line, found)) in ours.iter().zip(&theirs).enumerate() {
        let number = |key: &str| line[key].as_f64().unwrap();
        let target = &found.found.target;
        assert_eq!((number("frame"), number("chirp")), (found.frame as f64, found.chirp as f64));
        assert_eq!(word(line, "verdict"), target.verdict.name());
        let velocity: f64 = target.velocity.unwrap().to_num();
        for (key, value) in [
            ("range_m", target.range.to_num::<f64>()),
            ("velocity_mps", velocity),
            ("sigma_range_m", target.sigma_range.into()),
            ("sigma_velocity_mps", target.sigma_velocity.into()),
        ] {
            assert_eq!(number(key).to_bits(), value.to_bits(), "{key}: {line}");
        }
        let first = found.chirp as usize;
        let ends = [first, first + 63].map(|chirp| run.scene().start_s(chirp, inputs::RECORD));
        let middle_s = f64::midpoint(ends[0], ends[1]) + 0.5 * 255.0 / 2.56e6;
        let truth = run.truth(index % 2, middle_s, 1);
        let off = [
            (number("range_m") - truth.range_m.unwrap()) / number("sigma_range_m"),
            (number("velocity_mps") - truth.velocity_mps.unwrap()) / number("sigma_velocity_mps"),
        ];
        println!("frame {}: {off:.2?} sigmas off", found.frame);
        assert!(off.iter().all(|off| off.abs() < 5.0), "{off:?} {line}");
    }
    let seen = &said["seen"];
    assert!(word(seen, "file").ends_with("4 targets measured"), "{seen}");
    assert!(word(seen, "map").contains("2 targets"), "{seen}");
    assert!(word(seen, "key").contains("times as large"), "sigma is less than a pixel: {seen}");
    assert_eq!(seen["spectrum"], false, "{seen}");
    let labels = cells(&seen["labels"]);
    assert!(["1", "2"].iter().all(|number| labels.contains(number)), "{labels:?}");
    assert!(
        labels.iter().any(|it| it.ends_with(" m")) && labels.iter().any(|it| it.ends_with(" m/s"))
    );
    let rows = seen["targets"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for (row, line) in rows.iter().zip(&ours[2..]) {
        for (place, key) in [(1, "range_m"), (2, "velocity_mps")] {
            let [shown, sigma] = cell(row, place)[..] else { panic!("{row}") };
            assert!((shown - line[key].as_f64().unwrap()).abs() < 0.06 * sigma, "{row} {line}");
        }
        assert!(row[4].as_str().unwrap().ends_with("good") && row[5] == "none", "{row}");
    }
    assert!(word(said, "told").contains("judged as a whole"), "{said}");
    beside(said, &ours);
    let aliases = said["aliases"]["targets"].as_array().unwrap();
    let open = aliases.iter().filter(|row| row[4].as_str().unwrap().ends_with("ambiguous"));
    assert!(open.clone().count() > 0, "{said}");
    assert!(open.clone().all(|row| row[5].as_str().unwrap().contains(" %)")), "{said}");
    assert!(said["width"].as_f64().unwrap() <= 390.0, "{said}");
    assert_eq!(word(&said["after"], "word"), "good", "{said}");
}

/// Without the background of a scene in which nothing stands still the same targets are there; another file is measured as it is.
fn beside(said: &Value, whole: &[Value]) {
    let beside = &said["beside"];
    let told = word(beside, "background");
    assert!(told.starts_with("Less the background of frame 1, "), "{told}");
    assert!(told.contains("Noise alone would have 1.6 %"), "{told}");
    let ours: Vec<Value> =
        word(beside, "json").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(ours.len(), whole.len(), "{said}");
    for (beside, whole) in ours.iter().zip(whole) {
        for (key, sigma) in [("range_m", "sigma_range_m"), ("velocity_mps", "sigma_velocity_mps")] {
            let [value, before, sigma] =
                [&beside[key], &whole[key], &whole[sigma]].map(|it| it.as_f64().unwrap());
            assert!((value - before).abs() < sigma, "{key}: {beside} {whole}");
        }
    }
    assert_ne!(ours, whole, "something was subtracted");
    for plain in [&said["seen"], &said["whole"], &said["aliases"]] {
        assert_eq!((word(plain, "background"), &plain["button"]), ("", &true.into()), "{plain}");
    }
}

/// A file that does not tell its rate or its codes: as `analyze` measures it, in cycles per sample where no rate is typed.
fn bare(said: &Value, folder: &Path) {
    nothing_hinders(said);
    let field = |name: &str| said["fields"][name].as_f64();
    let (rate_hz, bits) = (field("file_rate_hz"), field("bits").unwrap_or(16.0));
    let [asked, title] = [0, 3].map(|place| said["asked"][place].as_str().unwrap());
    assert_eq!(asked.contains("does not tell its sample rate"), rate_hz.is_none(), "{said}");
    assert_eq!(title.contains("cycles per sample"), rate_hz.is_none(), "{said}");
    assert!(said["asked"][1] == true && said["asked"][2] == true, "beside the answer: {said}");
    // With a carrier the answer and the charts are speeds.
    let carrier =
        field("carrier_hz").map(|ghz| Carrier { hz: ghz * 1e9, mixing: Mixing::RxConjTx });
    let unit = match (carrier, rate_hz) {
        (Some(_), _) => "m/s",
        (None, Some(_)) => "Hz",
        (None, None) => "cycles per sample",
    };
    assert_eq!(word(&said["figures"][0], "unit"), unit, "{said}");
    let label = said["asked"][4].as_str().unwrap();
    assert!(
        label.chars().last().is_some_and(|last| last.is_numeric()) == unit.starts_with("cycles"),
        "{label}"
    );
    assert_eq!(label.ends_with("m/s"), carrier.is_some(), "{label}");
    let file = folder.join(word(said, "file"));
    let (bits, unsigned) = (bits.abs() as u32, bits < 0.0);
    let read = Options {
        rate_hz,
        converter: Some(Converter { bits, unsigned }),
        format: field("format").map(|_| Format::F32),
        ..Options::default()
    };
    let codes = Codes::from_bits(!unsigned, bits).unwrap();
    as_analyzed(said, &file, &Analysis { read, codes, carrier, ..analysis(&file) });
}

/// The displacement is that of `analyze --displacement` to the bit, and what swings in it to the digits shown.
fn displaced(said: &Value, folder: &Path) {
    nothing_hinders(said);
    // The tick and the chart: before there is a carrier, with it, once ticked, and of sums.
    let offered = serde_json::json!([[false, false], [true, false], [true, true], [false, false]]);
    assert_eq!(said["offered"], offered, "{said}");
    assert_eq!(word(said, "title"), "Displacement");
    assert!(word(said, "chart").starts_with("Displacement, "), "{said}");
    assert!(said["width"].as_f64().unwrap() <= 390.0, "{said}");
    let file = folder.join(word(said, "file"));
    let read = Options { rate_hz: Some(RATE_HZ), iq: true, ..Options::default() };
    let cut = Cut {
        read,
        n: 1024,
        hop: 1024,
        skip: 0,
        band_hz: None,
        codes: Codes::signed::<16>(),
        reach: Reach::default(),
        width: Linewidth { linewidth_hz: 0.0, envelope_hz: 0.0 },
    };
    let sensor = Sensor::Wave(Carrier { hz: 24e9, mixing: Mixing::RxConjTx });
    let mut theirs = Vec::new();
    let mut sink = |moved: &Moved| theirs.push(*moved);
    let told = Told::default();
    let (_, swings) = displacement::run(&file, &cut, None, (&sensor, &told), &mut sink).unwrap();
    let mut lines = word(said, "csv").lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let column = |row: &[&str], name: &str| {
        row[names.iter().position(|&own| own == name).unwrap()].to_owned()
    };
    let there = rows.iter().filter(|row| !column(row, "displacement_m").is_empty());
    let there: Vec<_> = there.collect();
    // Six blocks are silent; behind them it starts anew.
    assert_eq!((rows.len(), there.len(), theirs.len()), (200, 194, 194));
    for (row, Moved { block, moved, .. }) in there.iter().zip(&theirs) {
        let number = |name: &str| column(row, name).parse::<f64>().unwrap();
        assert_eq!(number("block"), *block as f64);
        for (name, value) in [
            ("displacement_m", moved.metres.to_num::<f64>()),
            ("sigma_displacement_m", moved.sigma.into()),
            ("displacement_start", moved.start.into()),
        ] {
            assert_eq!(number(name).to_bits(), value.to_bits(), "{name} of {block}");
        }
        assert_eq!(column(row, "displacement_verdict"), moved.verdict.name());
    }
    let starts: BTreeSet<u32> = theirs.iter().map(|it| it.moved.start).collect();
    assert_eq!(starts.len(), 2, "{starts:?}");
    let shown = said["swings"].as_array().unwrap();
    assert_eq!((shown.len(), swings.len()), (2, 2), "{said}");
    for ((row, swing), truth) in shown.iter().zip(&swings).zip([[5.0, 50.0], [11.0, 20.0]]) {
        let tone = &swing.line.tone;
        let micro = |pair: [f64; 2]| pair.map(|x| 1e6 * x);
        for (place, [value, sigma]) in [
            [tone.hertz(), tone.sigma_hertz()],
            micro(swing.amplitude_m),
            micro(swing.velocity_mps),
        ]
        .into_iter()
        .enumerate()
        {
            let [shown, spread] = cell(row, place)[..] else { panic!("{row}") };
            assert!((shown - value).abs() < 0.06 * sigma, "{shown} is not {value}");
            assert!((spread / sigma - 1.0).abs() < 0.06, "{spread} is not {sigma}");
            let truth = [truth[0], truth[1], truth[1] * std::f64::consts::TAU * truth[0]][place];
            // A block's mean phase has less of a swing than its middle.
            println!("swing: {value} +- {sigma}, {truth} true");
            assert!((value - truth).abs() < 5.0 * sigma + 0.1 * truth, "{row}");
        }
        assert!(row[3].as_str().unwrap().ends_with(tone.verdict.name()), "{row}");
    }
}

fn as_analyzed(said: &Value, file: &Path, analysis: &Analysis) {
    assert_eq!(word(said, "notice"), "", "{said}");
    let lines = word(said, "json").lines().map(|line| serde_json::from_str(line).unwrap());
    let ours: Vec<Value> = lines.collect();
    let theirs = analyzed(file, analysis);
    println!("{}: {} blocks", word(said, "file"), ours.len() - 1);
    assert!(theirs.len() > 15);
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(&theirs).for_each(|(ours, theirs)| assert_alike(ours, theirs));
}

/// The numbers of a cell, "12.34 \u{b1} 0.05".
fn cell(row: &Value, index: usize) -> Vec<f64> {
    row[index].as_str().unwrap().split(" \u{b1} ").map(number).collect()
}

/// All tones of a block: within their sigmas, and those of a recording's block as the library has them.
fn several(said: &Value, folder: &Path) {
    assert_eq!(said["alone"], Value::Array(vec![]), "one tone needs no table: {said}");
    let seen = said["seen"].as_array().unwrap();
    assert!(seen.len() > 4, "{said}");
    let mut squares = Vec::new();
    for rows in seen {
        assert_eq!(rows.as_array().unwrap().len(), 2, "{rows}");
        for (row, truth) in rows.as_array().unwrap().iter().zip([1000.3, 1400.3]) {
            let [hertz, sigma] = cell(row, 0)[..] else { panic!("{row}") };
            assert!((hertz - truth).abs() < 5.0 * sigma, "{row}");
            assert!(row[3].as_str().unwrap().ends_with(" good"), "{row}");
            squares.push(((hertz - truth) / sigma).powi(2));
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("several tones: {} readings, rms {rms:.2} sigma", squares.len());
    assert!((0.2..2.2).contains(&rms), "{rms}");

    let options = Options::default();
    let recording = Recording::open(&folder.join("good-tone.wav"), options).unwrap();
    let mut blocks = recording.blocks(1024, 1024, 0);
    let config = Config::new(RATE_HZ, Codes::signed::<16>());
    let mut pipeline = Pipeline::<Real, 1024>::new(config.plan().unwrap());
    let mut last = None;
    while let Some((_, samples)) = blocks.next_block().unwrap() {
        last = Some(std::array::from_fn(|n| samples[n].code()[0]));
    }
    let measurement = pipeline.block(&Stamp::default(), &last.unwrap());
    let lines = pipeline.lines(&measurement, 2);
    let shown = said["file"].as_array().unwrap();
    assert_eq!(shown.len(), lines.len(), "{said}");
    for (row, phasor) in shown.iter().zip(&lines) {
        // The page shows two digits of a sigma.
        let near = |index: usize, value: f64, sigma: f64| {
            let [shown, spread] = cell(row, index)[..] else { panic!("{row}") };
            assert!((shown - value).abs() < 0.06 * sigma, "{shown} is not {value}");
            assert!((spread / sigma - 1.0).abs() < 0.06, "{spread} is not {sigma}");
        };
        near(0, phasor.tone.hertz(), phasor.tone.sigma_hertz());
        near(2, phasor.phase.into(), phasor.sigma_phase.into());
        let level = 20.0 * (f64::from(phasor.tone.amplitude) / 32767.5).log10();
        assert!((number(row[1].as_str().unwrap()) - level).abs() < 0.051, "{row}");
        assert!(row[3].as_str().unwrap().ends_with(phasor.tone.verdict.name()), "{row}");
    }
}

/// A file that comes late takes no other source's place.
fn hasty(said: &Value) {
    assert!(word(said, "shown").starts_with("good-tone.wav: "), "{said}");
    assert_eq!(word(said, "notice"), "", "{said}");
    assert_ne!(said["counts"][0], said["counts"][1], "the scene goes on: {said}");
}

fn bad(said: &Value) {
    let sentence = match word(said, "file") {
        "bad-silence.wav" => {
            assert_eq!(word(said, "word"), "no-signal");
            return assert_eq!(word(said, "reason"), "There is nothing in the band.");
        }
        "bad-truncated.wav" => "is cut off: its header announces 200000 bytes",
        "bad-stranger.wav" => "is not a readable wav file",
        "bad-empty.wav" => "holds no samples",
        "bad-short.wav" => "300 samples are fewer than a block of 1024",
        "bad-name.xyz" => "neither its name nor its first bytes",
        "bad-chunk.wav" => "is not a readable wav file",
        other => panic!("{other}"),
    };
    assert!(word(said, "notice").contains(sentence), "{said}");
}

/// The targets of a board's frames, as the board told them.
fn framed(said: &Value) {
    nothing_hinders(said);
    let (_, told) = inputs::told();
    let none = word(said, "session") == "frames-none.bin";
    let shown = if none { 3 } else { 2 };
    let ours: Vec<Value> =
        word(said, "json").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let theirs: Vec<_> =
        told.iter().flat_map(|(frame, found)| found.iter().map(move |it| (frame, it))).collect();
    assert_eq!((ours.len(), theirs.len()), (4, 4), "{said}");
    for (line, (frame, found)) in ours.iter().zip(&theirs) {
        let number = |key: &str| line[key].as_f64().unwrap();
        let target = &found.found.target;
        assert_eq!(number("frame"), f64::from(frame.number));
        assert_eq!(number("chirp"), f64::from(frame.stamp.sequence));
        assert_eq!(word(line, "verdict"), target.verdict.name());
        for (key, value) in [
            ("range_m", target.range.to_num::<f64>()),
            ("velocity_mps", target.velocity.unwrap().to_num()),
            ("sigma_range_m", target.sigma_range.into()),
            ("sigma_velocity_mps", target.sigma_velocity.into()),
        ] {
            assert_eq!(number(key).to_bits(), value.to_bits(), "{key}: {line}");
        }
    }
    let seen = &said["seen"];
    assert_eq!(word(seen, "title"), format!("Range and velocity, frame {}", shown - 1), "{said}");
    assert_eq!(seen["button"], false, "the board keeps its powers: {seen}");
    assert_eq!(seen["spectrum"], false, "{seen}");
    let known = word(said, "known");
    assert!(known.contains("64 chirps after 64 in no frame, searched in 7 ms"), "{known}");
    assert!(known.contains("256 samples, I/Q, at 2560 kHz"), "{known}");
    let counter = |name: &str| word(&said["counters"], name);
    assert_eq!(["targets", "good", "gaps", "lost"].map(counter), ["4", "100 %", "1", "0"]);
    let rows = seen["targets"].as_array().unwrap();
    if none {
        assert!(rows.is_empty() && word(said, "word") == "no target", "{said}");
        return;
    }
    assert_eq!((rows.len(), word(said, "word")), (2, "good"), "{said}");
    assert!(word(seen, "map").contains("2 targets"), "{seen}");
    let labels = cells(&seen["labels"]);
    assert!(["1", "2"].iter().all(|number| labels.contains(number)), "{labels:?}");
    for (row, line) in rows.iter().zip(&ours[2..]) {
        for (place, key) in [(1, "range_m"), (2, "velocity_mps")] {
            let [value, sigma] = cell(row, place)[..] else { panic!("{row}") };
            assert!((value - line[key].as_f64().unwrap()).abs() < 0.06 * sigma, "{row} {line}");
        }
    }
}

fn cells(row: &Value) -> Vec<&str> {
    row.as_array().unwrap().iter().filter_map(Value::as_str).collect()
}

fn board(said: &Value) {
    assert_eq!(said["baud"], 921_600);
    // What was asked of it: who it is, its settings, a block.
    let mut reader = Reader::default();
    let written =
        said["written"].as_array().unwrap().iter().map(|byte| byte.as_u64().unwrap() as u8);
    let frames = written.filter_map(|byte| Some(reader.push(byte)?.unwrap()));
    let orders: Vec<Command> =
        frames.map(|frame| Request::from_frame(&frame).unwrap().command).collect();
    assert_eq!(orders, [Command::Identify, Command::GetSettings, Command::Capture(1)]);
    if word(said, "session") == "stranger.bin" {
        return assert!(word(said, "known").contains("660 bytes came, and no frame"), "{said}");
    }
    let tones: Vec<Vec<&str>> = said["tones"].as_array().unwrap().iter().map(cells).collect();
    assert_eq!(
        tones,
        [
            [
                "25000.00 \u{b1} 0.50",
                "\u{2212}6.2 dB",
                "\u{2212}1.250 \u{b1} 0.020",
                "\u{2713} good"
            ],
            [
                "\u{2212}50000.00 \u{b1} 0.50",
                "\u{2212}26.2 dB",
                "\u{2212}1.250 \u{b1} 0.020",
                "\u{2197} moving"
            ],
        ]
    );
    let counter = |name: &str| word(&said["counters"], name);
    let counts = ["blocks", "missing", "bad frames", "raw blocks", "lost"].map(counter);
    assert_eq!(counts, ["28", "2", "1", "1", "0"], "{said}");
    let known = word(said, "known");
    for words in [
        "nucleo-f446re",
        "1024 samples, I/Q, at 250 kHz",
        "trapezoid of 200 MHz",
        "31.0 %",
        "50.0000 Hz \u{b1} 0.0100 Hz, good",
    ] {
        assert!(known.contains(words), "{known}");
    }
    let mut listener = Listener::default();
    let mut rows = Vec::new();
    for said in session().into_iter().filter_map(|byte| listener.push(byte)).collect::<Vec<_>>() {
        if let Said::Telemetry(record) = said {
            rows.push(
                Row::from_record(&record, Some(record.measurement.tone.rate_hz), &listener).json(),
            );
        }
    }
    let mut lines = word(said, "csv").lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let ours: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(ours.len(), rows.len());
    for (ours, theirs) in ours.iter().zip(&rows) {
        let theirs: Value = serde_json::from_str(theirs).unwrap();
        let column = |name: &str| ours[names.iter().position(|&own| own == name).unwrap()];
        // Decibels are a logarithm of the platform's, which may differ in its last bit.
        let decibels = column("snr_db").parse::<f64>().unwrap();
        assert!((decibels - theirs["snr_db"].as_f64().unwrap()).abs() < 1e-12, "{ours:?}");
        for name in ["time_s", "frequency_hz", "sigma_hz", "range_m", "velocity_mps"] {
            let theirs = theirs[name].as_f64().map(f64::to_bits);
            assert_eq!(column(name).parse().ok().map(f64::to_bits), theirs, "{name} of {ours:?}");
        }
        for name in ["amplitude_codes", "sigma_range_m", "sigma_velocity_mps"] {
            let theirs = theirs[name].as_f64().map(|x| (x as f32).to_bits());
            let ours = column(name).parse::<f64>().ok().map(|x| (x as f32).to_bits());
            assert_eq!(ours, theirs, "{name}");
        }
        assert_eq!(column("verdict"), theirs["verdict"]);
    }
}

/// What the page says of each file and drive, and that it wrote the one to the other.
fn written(said: &Value) {
    nothing_hinders(said);
    assert_eq!((&said["closed"], &said["same"]), (&Value::Bool(true), &Value::Bool(true)));
    assert_eq!(said["before"], serde_json::json!(["INFO_UF2.TXT"]));
    let told: Vec<&str> =
        said["said"].as_array().unwrap().iter().map(|told| told.as_str().unwrap()).collect();
    let wanted = [
        "This is no .uf2 file",
        "Block 0 of 1 is out of its place",
        "This file is for another chip",
        "Block 1 of this file is no UF2 block",
        "No drive was chosen",
        "The browser refuses this drive: hold BOOTSEL",
        "This is no Pico's drive",
        "This drive belongs to another board",
        "2 KB are written: the board restarts",
        "2 KB are written, and the drive went away",
        "This browser cannot write to a drive: hold BOOTSEL",
    ];
    assert_eq!(told.len(), wanted.len(), "{told:#?}");
    for (told, wanted) in told.iter().zip(wanted) {
        assert!(told.starts_with(wanted), "{told}, not {wanted}");
    }
}

#[test]
fn the_page_in_a_browser() {
    let _turn = turn();
    let site = needed(Site::build());
    let served = site.serve(0).unwrap();
    let folder = inputs();
    let begun = std::time::Instant::now();
    let arguments = [served.address().into(), folder.clone().into_os_string()];
    let arguments = arguments.each_ref().map(|argument: &std::ffi::OsString| argument.as_os_str());
    let output = needed(browser::script("page.mjs", &arguments));
    println!("the browser took {:.1} s", begun.elapsed().as_secs_f64());
    let mut names = Vec::new();
    for line in output.lines() {
        let said: Value = serde_json::from_str(line).unwrap();
        clean(&said);
        let name = word(&said, "name").to_owned();
        match name.as_str() {
            "scenes" => scenes(&said),
            "hands" => hands(&said),
            "access" => access(&said),
            "bursts" => bursts(&said),
            "sums" => sums(&said),
            "lengths" => lengths(&said),
            "design" => design(&said),
            "explained" => explained(&said, &folder),
            "strange" => strange(&said),
            "file" => file(&said, &folder),
            "choice" => choice(&said, &folder),
            "bare" => bare(&said, &folder),
            "displaced" => displaced(&said, &folder),
            "frames" => frames(&said, &folder),
            "framed" => framed(&said),
            "bad" => bad(&said),
            "board" => board(&said),
            "after" => assert_eq!(word(&said, "word"), "good", "{said}"),
            "hasty" => hasty(&said),
            "several" => several(&said, &folder),
            "written" => written(&said),
            "microphone" => assert_ne!(said["counters"]["blocks"], "0"),
            other => panic!("{other}"),
        }
        names.push(name);
    }
    names.sort();
    names.dedup();
    assert_eq!(
        names,
        [
            "access",
            "after",
            "bad",
            "bare",
            "board",
            "bursts",
            "choice",
            "design",
            "displaced",
            "explained",
            "file",
            "framed",
            "frames",
            "hands",
            "hasty",
            "lengths",
            "microphone",
            "scenes",
            "several",
            "strange",
            "sums",
            "written"
        ]
    );
}

#[test]
fn the_page_is_small() {
    let _turn = turn();
    let site = needed(Site::build());
    let size = |name: &str| fs::metadata(site.folder().join(name)).unwrap().len();
    let modules = MODULES.map(|(name, _)| size(name));
    let page = FILES.iter().map(|(name, _)| size(name)).chain(modules).sum::<u64>();
    println!("picket.wasm and tones.wasm {modules:?} bytes, the page in all {page}");
    assert!(modules.iter().all(|&module| module <= 792_000), "{modules:?} bytes");
    assert!(page <= 1_395_000, "{page} bytes");
}

/// What it measures of random blocks, and the samples of a scene that has of all. Seed 0x2545_F491_4F6C_DD1D, as `check` has it.
#[test]
fn the_module_gives_the_same_bits() {
    const BLOCKS: u32 = 100_000;
    let _turn = turn();
    let site = needed(Site::build());
    let node = needed(browser::node());
    let script = picket_host::toolchain::workspace().join("web/browser/bits.mjs");
    let child = std::process::Command::new(node)
        .arg(script)
        .arg("-")
        .arg(site.folder())
        .arg(BLOCKS.to_string())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let ours = [false, true].map(|fixed| check::checksum(fixed, BLOCKS));
    println!("{ours:x?}");
    for seen in ours {
        // Of each kind enough, and not all alike.
        assert!(seen.blocks >= BLOCKS && seen.good > BLOCKS / 3 && seen.good < BLOCKS, "{seen:?}");
    }
    let output = child.wait_with_output().unwrap();
    let theirs = String::from_utf8(output.stdout).unwrap();
    let [float, fixed] = ours.map(|seen| seen.checksum);
    let scene = check::scene_checksum().unwrap();
    // No part of it is still, and it reaches both rails.
    let codes = check::scene().codes(0).unwrap();
    for part in [0, 1] {
        let seen: BTreeSet<i16> = codes.iter().map(|code| code[part]).collect();
        assert!(seen.len() > 900 && seen.contains(&-512) && seen.contains(&511), "{}", seen.len());
    }
    assert_eq!(theirs, format!("{float:016x}\n{fixed:016x}\n{scene:016x}\n"));
}

/// What is kept of the plotting library is what its authors published: uPlot 1.6.32 on npm.
#[test]
fn the_plotting_library_is_the_published_one() {
    let folder = picket_host::toolchain::workspace().join("web/page/vendor");
    let crc = crc::Crc::<u64>::new(&crc::CRC_64_XZ);
    for (name, sum) in
        [("uPlot.iife.min.js", 0x9624_9dda_bb01_2db4), ("uPlot.min.css", 0xa568_b25f_742d_22b1)]
    {
        assert_eq!(crc.checksum(&fs::read(folder.join(name)).unwrap()), sum, "{name}");
    }
}

//! Arrays of chirps: targets of frames, ranges by phase and ways, beside the truth of the scene.

use crate::cli::{ANALYZE, file, lines, refused, run};
use crate::survey::npy;
use picket_simulator::{Run, Scene};
use serde_json::{Value, json};

const N: usize = 256;

/// A radar at 77 GHz: 300 MHz in a record of 100 us, a chirp each 120 us.
const RADAR: [&str; 10] = [
    "--rate",
    "2.56M",
    "--chirp-s",
    "102e-6",
    "--bandwidth-hz",
    "306M",
    "--carrier-hz",
    "77G",
    "--guard-s",
    "2e-6",
];

/// Records of a scene in front of the radar, and their run.
fn scene(chirps: usize, snr_db: f64, iq: bool, sources: Value) -> Run {
    curved(chirps, snr_db, iq, sources, 0.0)
}

/// The same by ramps that are not straight.
fn curved(chirps: usize, snr_db: f64, iq: bool, sources: Value, curvature: f64) -> Run {
    let scene = json!({
        "seed": 62, "rate_hz": 2.56e6, "seconds": (chirps + 1) as f64 * 120e-6,
        "waveform": {"shape": "sawtooth", "carrier_hz": 77e9, "bandwidth_hz": 306e6, "ramp_s": 102e-6, "guard_s": 2e-6,
            "period_s": 120e-6, "samples": N, "curvature": curvature},
        "sources": sources,
        "receiver": {"iq": iq, "noise": {"snr_db": snr_db}},
    });
    serde_json::from_value::<Scene>(scene).unwrap().run(0).unwrap()
}

/// The records as an array of NumPy's, and its file.
fn array(name: &str, run: &mut Run, shape: &str, chirps: usize) -> String {
    let iq = run.scene().receiver.iq;
    let parts = if iq { 2 } else { 1 };
    let words = (0..chirps).flat_map(|index| run.record(index, N));
    let data = words.flat_map(|pair| pair[..parts].to_vec()).flat_map(i16::to_le_bytes).collect();
    let shape = if iq { format!("{shape}, {N}, 2") } else { format!("{shape}, {N}") };
    file(name, &npy("<i2", &shape, data))
}

fn target(range_m: f64, velocity_mps: f64, amplitude: f64) -> Value {
    json!({"target": {"range_m": range_m, "velocity_mps": velocity_mps, "amplitude": amplitude, "phase_turns": 0}})
}

fn number(line: &Value, key: &str) -> f64 {
    line[key].as_f64().unwrap_or_else(|| panic!("{key} of {line}"))
}

/// The middle of a frame of 64 chirps.
fn middle_s(run: &Run, first: usize) -> f64 {
    let ends = [first, first + 63].map(|index| run.scene().start_s(index, N));
    f64::midpoint(ends[0], ends[1]) + 0.5 * (N - 1) as f64 / 2.56e6
}

/// Three frames, two targets in each, real and I/Q, at levels that no chirp shows.
#[test]
fn targets_of_frames() {
    for iq in [true, false] {
        let sources = json!([target(18.0, 3.0, 60.0), target(24.0, -5.0, 30.0)]);
        let mut run = scene(192, -8.0, iq, sources);
        let path = array(&format!("frames-{iq}.npy"), &mut run, "3, 64", 192);
        let more =
            ["--period-s", "120e-6", "--velocity-mps=-8:8", "--mixing", "tx-conj-rx", "--json"];
        let all = lines(ANALYZE, &[&[&path[..]], &RADAR[..], &more[..]].concat());
        assert_eq!(all.len(), 6, "{all:?}");
        for (index, line) in all.iter().enumerate() {
            assert_eq!(
                (&line["frame"], &line["verdict"]),
                (&json!(index / 2), &json!("good")),
                "{line}"
            );
            let truth = run.truth(index % 2, middle_s(&run, 64 * (index / 2)), 1);
            let range =
                (number(line, "range_m") - truth.range_m.unwrap()) / number(line, "sigma_range_m");
            let velocity = (number(line, "velocity_mps") - truth.velocity_mps.unwrap())
                / number(line, "sigma_velocity_mps");
            assert!(range.abs() < 5.0 && velocity.abs() < 5.0, "{range} {velocity}: {line}");
            assert!(
                (number(line, "snr_db") + 8.0 + 6.0 * (index % 2) as f64).abs() < 2.0,
                "{line}"
            );
        }
        // The same numbers for people and as a table.
        let csv = run_text(
            &[&[&path[..]], &RADAR[..], &more[..3], &["--mixing", "tx-conj-rx", "--csv"]].concat(),
        );
        let mut rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let heads = rows.next().unwrap();
        let rows: Vec<_> = rows.collect();
        assert!(rows.len() == 6 && rows.iter().all(|row| row.len() == heads.len()), "{csv}");
        let column = heads.iter().position(|head| *head == "range_m").unwrap();
        assert_eq!(rows[0][column].parse::<f64>().unwrap(), number(&all[0], "range_m"));
    }
}

/// What a clipped echo shows beside itself is no target, and nothing is good.
#[test]
fn a_clipped_frame_says_so() {
    let mut run = scene(64, 25.0, true, json!([target(18.0, 3.0, 900.0)]));
    let parts: Vec<i16> = (0..64).flat_map(|index| run.record(index, N)).flatten().collect();
    let data = |most: i16| {
        parts.iter().flat_map(|&x| x.clamp(-most - 1, most).to_le_bytes()).collect::<Vec<u8>>()
    };
    for (most, bits, verdict) in [(511, "10", "clipped"), (2047, "12", "good")] {
        let path = file(&format!("clipped-{bits}.npy"), &npy("<i2", "64, 256, 2", data(most)));
        let more =
            ["--period-s", "120e-6", "--velocity-mps=-8:8", "--mixing", "tx-conj-rx", "--json"];
        let all = lines(ANALYZE, &[&[&path[..]], &RADAR[..], &more, &["--bits", bits]].concat());
        assert!(!all.is_empty(), "{bits} bits");
        // A harmonic may be unresolved, too.
        let says = |line: &Value| {
            let also = line["also"].as_array();
            line["verdict"] == verdict || also.is_some_and(|also| also.contains(&json!(verdict)))
        };
        assert!(all[0]["verdict"] == verdict && all.iter().all(says), "{bits} bits: {all:?}");
    }
}

fn run_text(arguments: &[&str]) -> String {
    run_of(ANALYZE, arguments)
}

fn run_of(command: &str, arguments: &[&str]) -> String {
    let output = run(command, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Without bounds the aliases of a velocity are told, and the truth is one of them; what was assumed stands in one line.
#[test]
fn aliases_and_what_was_assumed() {
    let mut run = scene(64, -22.0, true, json!([target(18.0, 11.0, 30.0)]));
    let path = array("alias.npy", &mut run, "64", 64);
    let more = ["--period-s", "120e-6", "--mixing", "tx-conj-rx"];
    let arguments = [&[&path[..]], &RADAR[..], &more[..]].concat();
    let all = lines(ANALYZE, &[&arguments[..], &["--json"]].concat());
    assert_eq!((all.len(), &all[0]["verdict"]), (1, &json!("ambiguous")), "{all:?}");
    let candidates = all[0]["candidates"].as_array().unwrap();
    let near = |it: &&Value| (number(it, "velocity_mps") - 11.0).abs() < 0.1;
    let odds: f64 = candidates.iter().map(|it| number(it, "odds")).sum();
    assert!(candidates.iter().any(|it| near(&it)) && (odds - 1.0).abs() < 1e-3, "{candidates:?}");
    let output = super::cli::run(ANALYZE, &arguments);
    let (text, said) =
        [output.stdout, output.stderr].map(|it| String::from_utf8(it).unwrap()).into();
    assert!(said.lines().count() == 1 && said.contains("64 chirps a frame"), "{said}");
    assert!(text.lines().filter(|line| line.trim().starts_with("or ")).count() > 1, "{text}");
    // Each chirp by itself.
    let alone = lines(ANALYZE, &[&arguments[..], &["--chirps", "1", "--json"]].concat());
    assert_eq!(alone.len(), 64);
    assert!(
        (number(&alone[63], "time_s") - number(&alone[0], "time_s") - 63.0 * 120e-6).abs() < 1e-9
    );
    refused(ANALYZE, &[&arguments[..], &["--chirps", "128"]].concat(), "give fewer --chirps");
    refused(ANALYZE, &[&arguments[..], &["--chirps", "20"]].concat(), "8, 16, 32");
    refused(ANALYZE, &[&arguments[..], &["--uncertainty", "clock=3"]].concat(), "clock_ppm");
}

/// A plate at rest: micrometres by the phase of the frame's beat, and the whole uncertainty beside sigma.
#[test]
fn ranges_by_phase() {
    let mut run = scene(64, 20.0, true, json!([target(7.654321, 0.0, 300.0)]));
    let path = array("plate.npy", &mut run, "64", 64);
    // Without a calibration any turn at 0 m is as probable.
    let unknown = ["--period-s", "120e-6", "--velocity-mps=-1:1", "--phase", "--json"];
    let unknown = lines(ANALYZE, &[&[&path[..]], &RADAR[..], &unknown[..]].concat());
    assert_eq!(unknown[0]["phase"]["sure"], false, "{unknown:?}");
    let numbers = r#""offset_m": 0, "sigma_offset_m": 0, "slope_ppm": 0, "sigma_slope_ppm": 0"#;
    let perfect = format!("{{\"phase_rad\": 0, \"sigma_phase_rad\": 0, {numbers}}}");
    let known = file("perfect.json", perfect.as_bytes());
    let more = [
        "--period-s",
        "120e-6",
        "--velocity-mps=-1:1",
        "--phase",
        "--calibration",
        &known,
        "--uncertainty",
        "carrier_ppm=1,slope_ppm=100,range_offset_m=1e-3",
        "--json",
    ];
    let all = lines(ANALYZE, &[&[&path[..]], &RADAR[..], &more[..]].concat());
    assert_eq!(all.len(), 1, "{all:?}");
    let phase = &all[0]["phase"];
    assert_eq!(phase["sure"], true, "{phase}");
    let error = number(phase, "range_m") - 7.654321;
    assert!(
        error.abs() < 5.0 * number(phase, "sigma_range_m") && error.abs() < 5e-6,
        "{error} {phase}"
    );
    let whole = |of: &Value| number(&of["budget"], "uncertainty_range_m");
    assert!((whole(phase) / 7.654e-6 - 1.0).abs() < 0.1, "{phase}");
    assert!((whole(&all[0]) / 1.26e-3 - 1.0).abs() < 0.1, "{}", all[0]);
    assert!((number(&all[0]["budget"], "slope_range_m") - 0.765e-3).abs() < 1e-6, "{}", all[0]);
}

/// A reflector at a known range gives the phase at 0 m, by which another one's range is absolute.
#[test]
fn calibrated_by_a_known_range() {
    let reflector = |range_m: f64| {
        let mut target = target(range_m, 0.0, 300.0);
        target["target"]["phase_turns"] = json!(0.3);
        json!([target])
    };
    let known = array("known.npy", &mut scene(32, 25.0, true, reflector(1.0)), "32", 32);
    let other = array("other.npy", &mut scene(64, 25.0, true, reflector(2.345678)), "64", 64);
    let saved = crate::cli::fresh("radar.json");
    let more = ["--period-s", "120e-6", "--mixing", "tx-conj-rx", "--json"];
    let told = ["--known-m", "1.000:1e-6", "--save", &saved];
    let all = lines(ANALYZE, &[&[&known[..]], &RADAR[..], &more[..], &told[..]].concat());
    let turns = number(&all[0], "phase_rad") / std::f64::consts::TAU;
    let sigma = number(&all[0], "sigma_phase_rad") / std::f64::consts::TAU;
    assert!((turns - 0.3).abs() < 5.0 * sigma && sigma < 2e-3, "{}", all[0]);
    let by = ["--velocity-mps=-1:1", "--phase", "--calibration", &saved];
    let all = lines(ANALYZE, &[&[&other[..]], &RADAR[..], &more[..], &by[..]].concat());
    let phase = &all[0]["phase"];
    let error = (number(phase, "range_m") - 2.345678) / number(phase, "uncertainty_range_m");
    assert!(phase["sure"] == true && error.abs() < 5.0, "{phase}");
    refused(ANALYZE, &[&[&known[..]], &RADAR[..], &told[..]].concat(), "--force");
    refused(ANALYZE, &[&[&known[..]], &RADAR[..], &["--known-m", "x"]].concat(), "give metres");
    let none = file("none.json", b"{}");
    let no = ["--period-s", "120e-6", "--phase", "--calibration", &none];
    refused(ANALYZE, &[&[&other[..]], &RADAR[..], &no[..]].concat(), "no calibration");
}

/// What bounds a target, its aliases, and the targets beside it.
#[test]
fn a_frame_is_explained() {
    let near = json!([target(18.0, 3.0, 90.0), target(19.4, 4.5, 60.0), target(30.0, -2.0, 50.0)]);
    let mut run = scene(128, -6.0, true, near);
    let path = array("explained.npy", &mut run, "2, 64", 128);
    let usual = ["--period-s", "120e-6", "--mixing", "tx-conj-rx"];
    let bounds = ["--velocity-mps=-8:8"];
    let explained = |frame: &str, more: &[&str]| {
        let all = [&[&path[..]], &RADAR[..], &usual, &["--frame", frame], more].concat();
        run_of("explain", &all)
    };
    let object = |more: &[&str]| -> Value {
        serde_json::from_str(&explained("1", &[more, &["--json"]].concat())).unwrap()
    };
    let told = ["--uncertainty", "slope_ppm=100,carrier_ppm=20"];
    let found = object(&[&bounds[..], &told].concat());
    let targets = found["targets"].as_array().unwrap();
    assert_eq!((targets.len(), &found["frame"]), (3, &json!(1)), "{found}");
    // The numbers are those of `analyze`.
    let all =
        lines(ANALYZE, &[&[&path[..]], &RADAR[..], &usual, &bounds, &told, &["--json"]].concat());
    for (mine, theirs) in targets.iter().zip(&all[3..]) {
        for name in ["frame", "range_m", "sigma_velocity_mps", "verdict", "budget"] {
            assert_eq!(mine[name], theirs[name], "{name}");
        }
    }
    // 1.4 m and 1.5 m/s are 2.8 and 5.9 cells; the third target is 24 cells off.
    let beside = targets[0]["neighbours"].as_array().unwrap();
    assert!(beside.len() == 1 && beside[0]["target"] == 2, "{beside:?}");
    let cells = ["range_cells", "velocity_cells"].map(|name| number(&beside[0], name));
    assert!((cells[0] - 2.8).abs() < 0.5 && (cells[1] - 5.9).abs() < 0.5, "{cells:?}");
    assert_eq!(targets[0]["reasons"][0]["verdict"], targets[0]["verdict"]);
    let text = explained("1", &[&bounds[..], &told].concat());
    for words in
        ["target 1: 17.", "slope", "carrier", "fitted together with target 2", "within the bounds"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    // Without a bound the velocity of a weak one is open.
    let mut run = scene(64, -22.0, true, json!([target(18.0, 11.0, 30.0)]));
    let path = array("open.npy", &mut run, "64", 64);
    let all = [&[&path[..]], &RADAR[..], &usual, &["--frame", "0"]].concat();
    let text = run_of("explain", &all);
    assert!(text.contains("these aliases fit") && text.contains("narrow --velocity-mps"), "{text}");

    // Two in one cell.
    let mut run =
        scene(64, 10.0, true, json!([target(18.0, 3.0, 200.0), target(18.4, 3.1, 190.0)]));
    let path = array("crowded.npy", &mut run, "64", 64);
    let all = [&[&path[..]], &RADAR[..], &usual, &bounds, &["--frame", "0"]].concat();
    let text = run_of("explain", &all);
    assert!(text.contains("unresolved: "), "{text}");
    let refusals = |more: &[&str], line: &str| {
        let arguments = [&[&path[..]], &RADAR[..], &usual, more].concat();
        let output = self::run("explain", &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(line), "{line}: {message}");
        assert!(output.stdout.is_empty(), "{line}");
    };
    refusals(&["--frame", "7"], "the recording has 1 frames");
    refusals(&["--frame", "0", "--block", "0"], "--block");
    refusals(&["--frame", "0", "--known-m", "1"], "options of picket analyze");
    refusals(&["--frame", "0", "--chirps", "1"], "measured one by one");
    refusals(&["--block", "0"], "--chirp-s goes with --frame");
}

/// No alias of 3 m/s, 16 m/s apart, lies within 1 m/s of rest: the target is there, and has no usable place.
#[test]
fn a_target_outside_the_bounds_is_no_answer() {
    let mut run = scene(64, 15.0, true, json!([target(9.0, 3.0, 300.0)]));
    let path = array("outside.npy", &mut run, "64", 64);
    let bounded = |bound: &str| {
        let more = ["--period-s", "120e-6", bound, "--json"];
        lines(ANALYZE, &[&[&path[..]], &RADAR[..], &more[..]].concat())
    };
    let outside = bounded("--velocity-mps=-1:1");
    assert!(outside.iter().all(|target| target["verdict"] == "unresolved"), "{outside:?}");
    let within = bounded("--velocity-mps=-4:4");
    assert!(within.len() == 1 && within[0]["verdict"] == "good", "{within:?}");
    assert!((number(&within[0], "velocity_mps") - 3.0).abs() < 0.05, "{within:?}");
    let wide = ["--period-s", "120e-6", "--velocity-mps=-300:300"];
    refused(ANALYZE, &[&[&path[..]], &RADAR[..], &wide[..]].concat(), "aliases");
    // An array does not say how long its chirps pause.
    refused(ANALYZE, &[&[&path[..]], &RADAR[..]].concat(), "--period-s");
}

/// A plate that swings by 20 um at 100 Hz, and drifts.
#[test]
fn ways_and_swings() {
    let plate = json!([{"target": {"range_m": 6.0, "velocity_mps": 1e-3, "amplitude": 300.0,
        "vibration": [{"amplitude_m": 20e-6, "frequency_hz": 100.0, "phase_turns": 0.1}]}}]);
    let mut run = scene(2048, 10.0, true, plate);
    let path = array("swing.npy", &mut run, "2048", 2048);
    let more = ["--period-s", "120e-6", "--mixing", "tx-conj-rx", "--displacement", "--json"];
    let all = lines(ANALYZE, &[&[&path[..]], &RADAR[..], &more[..]].concat());
    let (swings, ways): (Vec<_>, Vec<_>) = all.iter().partition(|line| !line["swing"].is_null());
    assert!(ways.len() == 2048 && ways.iter().all(|line| line["verdict"] == "good"), "{}", ways[0]);
    let truth = |block: usize| {
        let time_s = run.scene().start_s(block, N) + 0.5 * N as f64 / 2.56e6;
        run.truth(0, time_s, 1).range_m.unwrap()
    };
    let off = |line: &Value| {
        let block = line["block"].as_u64().unwrap() as usize;
        (number(line, "displacement_m") - truth(block) + truth(0))
            / number(line, "sigma_displacement_m")
    };
    // The first block's error is part of all.
    let first = ways.iter().map(|line| off(line)).sum::<f64>() / 2048.0;
    let square = ways.iter().map(|line| (off(line) - first).powi(2)).sum::<f64>() / 2048.0;
    assert!(first.abs() < 5.0 && (0.9..1.1).contains(&square.sqrt()), "{first} {square}");
    let swing = swings[0];
    let within = |key: &str, truth: f64| {
        let error = (number(swing, key) - truth) / number(swing, &format!("sigma_{key}"));
        assert!(error.abs() < 5.0, "{key}: {error} of {swing}");
    };
    within("amplitude_m", 20e-6);
    assert!(
        (number(swing, "frequency_hz") - 100.0).abs() < 5.0 * number(swing, "sigma_hz"),
        "{swing}"
    );
    within("velocity_mps", 20e-6 * std::f64::consts::TAU * 100.0);
    refused(
        ANALYZE,
        &[&[&path[..]], &RADAR[..], &["--displacement", "--shape", "triangle"]].concat(),
        "sawtooth",
    );
}

/// As many chirps as a ramp has samples, and short records: an array the other way round is not measured unless its axes are told.
#[test]
fn a_transposed_array_is_asked_about() {
    let mut run = scene(64, 10.0, true, json!([target(18.0, 3.0, 300.0)]));
    let records: Vec<Vec<[i16; 2]>> = (0..64).map(|index| run.record(index, N)).collect();
    let write = |name: &str, shape: &str, at: &dyn Fn(usize) -> [i16; 2]| {
        let words = (0..64 * N).flat_map(at);
        file(name, &npy("<i2", shape, words.flat_map(i16::to_le_bytes).collect()))
    };
    let straight = write("straight.npy", "64, 256, 2", &|at| records[at / N][at % N]);
    let turned = write("turned.npy", "256, 64, 2", &|at| records[at % 64][at / 64]);
    let more = ["--period-s", "120e-6", "--velocity-mps=-8:8", "--mixing", "tx-conj-rx", "--json"];
    let usual = [&RADAR[..], &more[..]].concat();
    for way in [&[][..], &["--displacement"], &["--known-m", "18"]] {
        refused(ANALYZE, &[&[&turned[..]], &usual[..], way].concat(), "--axes sample,chirp,iq");
    }
    let told = |path: &str, axes: &[&str]| lines(ANALYZE, &[&[path], &usual[..], axes].concat());
    let right = told(&straight, &[]);
    assert!(right.len() == 1 && right[0]["verdict"] == "good", "{right:?}");
    assert_eq!(told(&turned, &["--axes", "sample,chirp,iq"]), right);
    assert_eq!(told(&straight, &["--axes", "chirp,sample,iq"]), right);
}

/// Records that are longer than the ramp have a pause in them, so that the ramp is not the period.
#[test]
fn a_pause_needs_the_period() {
    let mut run = scene(64, 10.0, true, json!([target(18.0, 3.0, 300.0)]));
    let path = array("pause.npy", &mut run, "64", 64);
    let radar = ["--rate", "2.56M", "--chirp-s", "80e-6", "--bandwidth-hz", "240M"];
    let radar = [&[&path[..], "--carrier-hz", "77G", "--json"], &radar[..]].concat();
    refused(ANALYZE, &radar, "--period-s");
    run_text(&[&radar[..], &["--period-s", "120e-6"]].concat());
}

/// The second half of bent ramps is less steep than their middle: told so, the range is right; else it is off by far more than sigma.
#[test]
fn curved_sweeps() {
    let mut run = curved(64, -8.0, true, json!([target(18.0, 3.0, 300.0)]), 0.002);
    let path = array("curved.npy", &mut run, "64", 64);
    let truth = run.truth(0, middle_s(&run, 0), 1).range_m.unwrap();
    let more = ["--period-s", "120e-6", "--velocity-mps=-8:8", "--mixing", "tx-conj-rx", "--json"];
    let half = ["--n", "128", "--guard-s", "52e-6"];
    let usual = [&[&path[..]], &RADAR[..8], &half[..], &more[..]].concat();
    let off = |line: &Value| (number(line, "range_m") - truth) / number(line, "sigma_range_m");
    let straight = lines(ANALYZE, &usual);
    assert!(straight.len() == 1 && off(&straight[0]) < -6.0, "{straight:?}");
    let told = lines(ANALYZE, &[&usual[..], &["--curvature", "0.002"]].concat());
    assert!(told.len() == 1 && told[0]["verdict"] == "good", "{told:?}");
    assert!(off(&told[0]).abs() < 5.0, "{} of {:?}", off(&told[0]), told[0]);
    refused(ANALYZE, &[&usual[..], &["--curvature", "0.25"]].concat(), "below 0.25");
}

//! `picket analyze FILE --burst` and `--accumulate M`: particles in a flow, and an echo below the noise.

use crate::cli::{ANALYZE, lines, recorded, refused, seed};
use picket_simulator::Scene;

const RATE_HZ: f64 = 200_000.0;

/// What the command prints, on stdout and on stderr.
fn printed(arguments: &[&str]) -> [String; 2] {
    let output = crate::cli::run(ANALYZE, arguments);
    [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
}

/// Forty particles of 28 to 32 kHz, in the middle of every 4,000 samples.
#[test]
fn bursts_for_people_spreadsheets_and_programs() {
    const COUNT: usize = 40;
    // Fringes of 4 um; a standard deviation of the envelope is 90 samples.
    let middles = (1..=COUNT).map(|burst| 4000.0 * burst as f64 / RATE_HZ);
    let at: Vec<String> = middles
        .map(|middle_s| format!(r#"{{"middle_s": {middle_s}, "velocity_mps": [0.113, 0.127]}}"#))
        .collect();
    let scene = Scene::from_json(&format!(
        r#"{{"seed": {}, "rate_hz": {RATE_HZ}, "seconds": {},
            "sources": [{{"particles": {{"radius_m": 108e-6, "pedestal": 0.4, "amplitude": 5000, "velocity_mps": 0.12, "at": [{}]}}}}],
            "receiver": {{"noise": {{"rms": 150}}}}}}"#,
        seed(41),
        4000.0 * (COUNT + 1) as f64 / RATE_HZ,
        at.join(", ")
    ));
    let scene = scene.unwrap();
    let run = scene.run(0).unwrap();
    let truth: Vec<(f64, f64)> = run
        .particles(0)
        .iter()
        .map(|passed| (passed.middle_s, passed.velocity_mps / 4e-6))
        .collect();
    let path = recorded("particles.wav", &scene);
    let all = lines(ANALYZE, &[&path, "--burst", "--json"]);
    let (summary, bursts) = all.split_last().unwrap();
    let valid: Vec<_> = bursts.iter().filter(|burst| burst["validation"] == "valid").collect();
    assert!(valid.len() >= COUNT - 2, "{} valid", valid.len());
    for burst in &valid {
        let number = |key: &str| burst[key].as_f64().unwrap();
        let near = |t: &&(f64, f64)| (t.0 - number("time_s")).abs() < 1e-3;
        let (_, hertz) = truth.iter().find(near).unwrap();
        assert!((number("frequency_hz") - hertz).abs() < 5.0 * number("sigma_hz"), "{burst}");
        let transit = 2f64.sqrt() * 108e-6 / (4e-6 * hertz);
        assert!((number("transit_s") / transit - 1.0).abs() < 0.1, "{burst}");
    }
    let mean = truth.iter().map(|t| t.1).sum::<f64>() / COUNT as f64;
    assert_eq!(summary["summary"], true);
    assert!((summary["mean_hz"].as_f64().unwrap() - mean).abs() < 150.0, "{summary} {mean}");
    assert!((500.0..1500.0).contains(&summary["rms_hz"].as_f64().unwrap()), "{summary}");

    let [text, _] = printed(&[&path, "--burst"]);
    assert!(text.contains("bursts valid") && text.contains("weighted with its transit time"));
    let [csv, _] = printed(&[&path, "--burst", "--csv", "--carrier-hz", "2e14"]);
    let mut rows = csv.lines();
    let columns = rows.next().unwrap().split(',').count();
    assert!(rows.next().is_some_and(|row| row.split(',').count() == columns), "{csv}");
}

/// -20 dB a sample: one block does not see it, a hundred do.
#[test]
fn an_echo_below_the_noise() {
    let hertz = 41_234.5;
    let scene = Scene::from_json(&format!(
        r#"{{"seed": {}, "rate_hz": {RATE_HZ}, "seconds": {}, "sources": [{{"tone": {{"frequency_hz": {hertz}, "amplitude": 141.42}}}}],
            "receiver": {{"noise": {{"rms": 1000}}}}}}"#,
        seed(42),
        1024.0 * 205.0 / RATE_HZ
    ));
    let path = recorded("echo.wav", &scene.unwrap());
    let sums = lines(ANALYZE, &[&path, "--accumulate", "100", "--json"]);
    assert_eq!(sums.len(), 2);
    for sum in &sums {
        let number = |key: &str| sum[key].as_f64().unwrap();
        assert_eq!((&sum["verdict"], &sum["blocks"]), (&"good".into(), &100.into()), "{sum}");
        assert!((number("frequency_hz") - hertz).abs() < 5.0 * number("sigma_hz"), "{sum}");
        assert!((number("snr_db") + 20.0).abs() < 1.5, "{sum}");
    }
    let single = lines(ANALYZE, &[&path, "--json"]);
    let weak = single.iter().filter(|line| line["verdict"] == "weak").count();
    assert!(weak > 195, "{weak} weak");
    let [_, told] = printed(&[&path, "--accumulate", "100"]);
    assert!(told.contains("5 blocks at the end are left"), "{told}");
    refused(ANALYZE, &[&path, "--accumulate", "1000"], "fewer than --accumulate 1000");
    refused(ANALYZE, &[&path, "--accumulate", "0"], "0");
    refused(ANALYZE, &[&path, "--burst", "--n", "1000"], "choose 512 or 1024");
}

/// A target at rest before a lidar whose laser's phase walks: the range has the error that follows from the linewidth and the delay, and sigma
/// has it where this is stated as the width of a line that moves as much.
#[test]
fn the_phase_of_a_laser_walks_during_the_delay() {
    for (range_m, linewidth_hz, n) in [(20.0, 1e5, 2048), (20.0, 1e5, 1024), (40.0, 1e4, 2048)] {
        let scene = Scene::from_json(&format!(
            r#"{{"seed": {}, "rate_hz": 250e6, "seconds": 5e-3,
                "waveform": {{"shape": "sawtooth", "carrier_hz": 193.4e12, "bandwidth_hz": 1e9, "ramp_s": 10e-6, "linewidth_hz": {linewidth_hz}}},
                "sources": [{{"target": {{"range_m": {range_m}, "amplitude": 900}}}}],
                "receiver": {{"noise": {{"snr_db": 25}}}}}}"#,
            seed(43),
        ));
        let path = recorded("laser.wav", &scene.unwrap());
        let (delay_s, record_s) = (2.0 * range_m / 299_792_458.0, f64::from(n) / 250e6);
        let variance = 6.0 * linewidth_hz * delay_s * delay_s / std::f64::consts::PI;
        let metres = 299_792_458.0 * 10e-6 / (2.0 * 1e9);
        let told_m = metres * (variance / f64::powi(record_s, 3)).sqrt();
        let width = 10.0 * linewidth_hz * (delay_s / record_s).powi(2);
        let lidar = ["--chirp-s", "10e-6", "--bandwidth-hz", "1G", "--carrier-hz", "193.4e12"];
        let more = ["--velocity-mps=-0.0001:0.0001", "--chirps", "1", "--json"];
        let (n, width) = (n.to_string(), width.to_string());
        let usual = [&[&path[..]], &lidar[..], &more[..], &["--n", &n]].concat();
        let mean = |all: &[serde_json::Value], over: Option<&str>| {
            assert_eq!(all.len(), 500);
            let number = |line: &serde_json::Value, key: &str| line[key].as_f64().unwrap();
            let error = |line: &serde_json::Value| number(line, "range_m") - range_m;
            let squares = all
                .iter()
                .map(|line| (error(line) / over.map_or(1.0, |sigma| number(line, sigma))).powi(2));
            squares.sum::<f64>() / 500.0
        };
        let stated = lines(ANALYZE, &[&usual[..], &["--linewidth", &width]].concat());
        let ratio = mean(&stated, None).sqrt() / told_m;
        let over = Some("sigma_range_m");
        let [square, without] = [mean(&stated, over), mean(&lines(ANALYZE, &usual), over)];
        println!(
            "{range_m} m, {linewidth_hz} Hz, {n}: {ratio:.3} of {told_m:.2e} m, squares {square:.3}, {without:.3}"
        );
        // 500 records know the rms to 3 %.
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
        // The pedestal's part that sigma sees counts twice.
        assert!((0.4..1.2).contains(&square) && without > 2.0, "{square} {without}");
    }
}

//! `picket design` against records of the physics simulator.

use crate::cli::{lines, refused};
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::{Codes, Config, Pipeline};
use picket_simulator::Scene;

const DESIGN: &str = "design";

/// Sigma, resolution and span of a radar of 24.125 GHz: 400 records of a target at 3.1 m/s have the error that is told.
#[test]
fn sigma_is_the_error_of_simulated_records() {
    let told = lines(
        DESIGN,
        &["--carrier-hz", "24.125G", "--rate", "10k", "--n", "1024", "--snr-db", "10", "--json"],
    );
    let number = |key: &str| told[0][key].as_f64().unwrap();
    let scene = Scene::from_json(
        r#"{"seed": 7, "rate_hz": 10000, "seconds": 0.1024, "waveform": {"carrier_hz": 24.125e9},
            "sources": [{"target": {"range_m": 20, "velocity_mps": 3.1, "amplitude": 900}}],
            "receiver": {"mixing": "rx-conj-tx", "noise": {"snr_db": 10}}}"#,
    );
    let scene = scene.unwrap();
    let config = Config::new(10e3, Codes::signed::<12>());
    let mut pipeline = Box::new(Pipeline::<Real, 1024>::new(config.plan().unwrap()));
    let mut squares = 0.0;
    for trial in 0..400 {
        let codes = scene.codes(trial).unwrap();
        let samples: Vec<i16> = codes.into_iter().map(|[code, _]| code).collect();
        let block = samples.as_slice().try_into().unwrap();
        let tone = pipeline.block(&Stamp::default(), block).tone;
        let velocity = tone.hertz() * number("resolution_mps") / number("bin_hz");
        squares += (velocity - 3.1).powi(2);
    }
    let ratio = (squares / 400.0f64).sqrt() / number("sigma_mps");
    // 400 records know it to 4 %; least squares of 33 bins reaches the bound to some percent.
    assert!((0.88..1.2).contains(&ratio), "{ratio}");
    let fastest = 10e3 / 4.0 * 299_792_458.0 / 24.125e9;
    assert!((number("fastest_mps") - fastest).abs() < 1e-9);
    assert_eq!(told[1]["settings"]["n"], 1024);
}

/// From what is wanted to settings, and one line where it cannot be had.
#[test]
fn from_a_wanted_sigma_to_settings() {
    let radar = ["--carrier-hz", "24.125G", "--velocity-mps", "10", "--snr-db", "10", "--json"];
    let of = |sigma: &str| lines(DESIGN, &[&radar[..], &["--sigma-mps", sigma]].concat());
    let (loose, tight) = (of("0.01"), of("0.00005"));
    let n = |lines: &[serde_json::Value]| lines.last().unwrap()["settings"]["n"].as_u64().unwrap();
    // A board takes the first: its blocks have 1024 samples. The second needs longer ones.
    assert_eq!(n(&loose), 1024);
    assert!(n(&tight) > 1024, "{}", n(&tight));
    // 10 m/s are 1609 Hz, at two fifths of the rate.
    let rate = loose.last().unwrap()["settings"]["rate_hz"].as_f64().unwrap();
    assert!((rate * 0.4 - 2.0 * 10.0 * 24.125e9 / 299_792_458.0).abs() < 1e-6, "{rate}");
    refused(
        DESIGN,
        &["--carrier-hz", "24G", "--velocity-mps", "10", "--sigma-mps", "1e-9"],
        "no block of 4096",
    );
    refused(DESIGN, &["--carrier-hz", "24G"], "--velocity-mps");
    refused(
        DESIGN,
        &["--carrier-hz", "24G", "--rate", "1k", "--velocity-mps", "50"],
        "samples per second",
    );
    let short =
        ["--carrier-hz", "24G", "--rate", "10k", "--bandwidth-hz", "200M", "--chirp-s", "1e-3"];
    refused(DESIGN, &short, "the ramp is shorter");
}

/// A chirp's settings are a board's: it takes them, and its ramp rises as fast as the one that was asked for.
#[test]
fn settings_of_a_chirp_work_on_a_board() {
    let radar = ["--carrier-hz", "24G", "--bandwidth-hz", "200M", "--rate", "200k", "--n", "1024"];
    for (chirp_s, shape, guard) in
        [("5.44e-3", "sawtooth", 64), ("5.3e-3", "triangle", 32), ("8e-3", "trapezoid", 64)]
    {
        let more = ["--chirp-s", chirp_s, "--shape", shape, "--json"];
        let told = lines(DESIGN, &[&radar[..], &more[..]].concat());
        let settings = &told.last().unwrap()["settings"];
        let text = settings.to_string();
        let (board, n) = picket_host::watch::settings::from_json(&text).unwrap();
        let picket_dsp::Scene::Chirp(chirp) = board.config.scene else { panic!("{text}") };
        assert_eq!((n, board.guard), (1024, guard), "{text}");
        assert_eq!(settings["scene"]["chirp"]["shape"], shape);
        assert_eq!(settings["drive"]["dac"]["low"], 250);
        let slope = chirp.bandwidth_hz / (f64::from(1024 + guard) / 200e3);
        let asked = 200e6 / chirp_s.parse::<f64>().unwrap();
        assert!((slope / asked - 1.0).abs() < 1e-9, "{slope} {asked}");
    }
}

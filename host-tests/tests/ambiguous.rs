//! What a sequence of chirps cannot decide is said, and bounds that are none are refused.

use picket_dsp::solve::sequence::Sequence;
use picket_dsp::{Codes, Config, ConfigError, Iq, Pipeline, Scene, Stamp, Target, Usable, Verdict};
use picket_simulator::scene;

const N: usize = 1024;

/// 77 GHz, 300 MHz in 110 us, a car anywhere up to 50 m/s, at 40 dB.
const SCENE: &str = r#"{"rate_hz": 10e6, "seconds": 7.1e-3,
    "waveform": {"shape": "sawtooth", "carrier_hz": 77e9, "bandwidth_hz": 300e6, "ramp_s": 110e-6, "guard_s": 7.6e-6, "samples": 1024},
    "sources": [{"target": {"range_m": [15, 60], "velocity_mps": [-50, 50], "amplitude": 400}}],
    "receiver": {"iq": true, "noise": {"snr_db": 40}}}"#;

/// Row 8b: the beats move within each chirp, and the sequence goes on.
#[test]
fn a_sequence_of_beats_that_move_has_an_answer() {
    let scene = scene::Scene::from_json(SCENE).unwrap();
    let chirp = picket_claims::told(&scene).unwrap();
    let equations = chirp.equations(scene.rate_hz, N, true).unwrap();
    let (mut alone, mut ambiguous, mut wrong) = (0, 0, 0);
    for trial in 0..40 {
        let mut run = scene.run(trial).unwrap();
        let mut pipeline = Pipeline::<Iq, N>::new(
            Config::new(scene.rate_hz, Codes::signed::<12>()).plan().unwrap(),
        );
        let mut sequence = Sequence::new(&equations, 1100).unwrap();
        let mut targets = heapless::Vec::new();
        for lap in 0..64u32 {
            let samples = run.record(lap as usize, N).try_into().unwrap();
            let stamp = Stamp { clock: u64::from(lap) * 1100, sequence: lap, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &samples);
            let lines = pipeline.lines(&measurement, 1);
            targets = sequence.push(&stamp, lines.first().expect("a line"));
        }
        let velocity_mps = run.truth(0, 0.0, N).velocity_mps.unwrap();
        let near =
            |target: &Target| (target.velocity.unwrap().to_num::<f64>() - velocity_mps).abs() < 1.0;
        wrong += usize::from(!targets.iter().any(near));
        match targets.as_slice() {
            [target] => alone += usize::from(target.verdict.usable() <= Usable::WithinSigma),
            several => {
                ambiguous += usize::from(several.iter().all(|t| t.verdict == Verdict::Ambiguous));
            }
        }
    }
    println!("seed 0: {alone} alone, {ambiguous} ambiguous, {wrong} without the right one");
    assert!(alone + ambiguous == 40 && alone >= 20 && wrong == 0);
}

/// Ends that are not finite or in the wrong order are refused.
#[test]
fn a_bound_has_its_low_end_first() {
    let chirp = picket_claims::told(&scene::Scene::from_json(SCENE).unwrap()).unwrap();
    let config = Config { scene: Scene::Chirp(chirp), ..Config::new(10e6, Codes::signed::<12>()) };
    for bound in [(5.0, -5.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        for config in [
            Config { velocity_mps: Some(bound), ..config },
            Config { range_m: Some(bound), ..config },
        ] {
            assert_eq!(config.plan::<Iq, N>(), Err(ConfigError::Bounds));
        }
    }
}

//! What a program stores by the library's feature `serde` comes back as it was, and what is wrong with it is told.

use picket_dsp::acquire::burst::Trigger;
use picket_dsp::solve::displacement::Displacement;
use picket_dsp::tone::FrequencyDrift;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::{
    Accumulated, Ambiguity, Arithmetic, Burst, Carrier, Chirp, Codes, Config, Decision, Effort,
    Following, Iq, Measurement, Method, Mixing, Outcome, Pipeline, Reach, Real, Scene, Segment,
    Shape, Stamp, Target, Tone, ToneWithPhase, Unjudged, Validation, Velocity, Verdict, Verdicts,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{from_str, to_string};
use std::fmt::Debug;

/// Stores a value, reads it again, and returns the text.
fn there_and_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) -> String {
    let text = to_string(value).unwrap();
    assert_eq!(&from_str::<T>(&text).unwrap(), value, "{text}");
    text
}

/// The error in one line.
fn refused<T: DeserializeOwned + Debug>(text: &str) -> String {
    from_str::<T>(text).unwrap_err().to_string()
}

fn block<const N: usize>(config: &Config, sample: impl Fn(f64) -> f64) -> Measurement {
    let mut pipeline = Pipeline::<Real, N>::new(config.plan().unwrap());
    let samples = std::array::from_fn(|n| sample(n as f64).round() as i16);
    pipeline.block(&Stamp { sequence: 7, clock: 1 << 40, ..Stamp::default() }, &samples)
}

#[test]
fn every_setting_comes_back() {
    let codes = Codes::between(-3000, 100).unwrap();
    let mut config = Config::new(48e3, codes);
    there_and_back(&config);
    for method in Method::ALL {
        config.method = *method;
        assert!(there_and_back(&config).contains(&format!("\"method\":\"{method}\"")));
    }
    for effort in Effort::ALL {
        config.effort = *effort;
        there_and_back(&config);
    }
    for (reach, arithmetic) in [
        (Reach::Four, Arithmetic::Fixed),
        (Reach::Eight, Arithmetic::Float),
        (Reach::Sixteen, Arithmetic::Fixed),
    ] {
        (config.reach, config.arithmetic) = (reach, arithmetic);
        assert!(there_and_back(&config).contains(&format!("\"reach\":{}", reach.bins())));
    }
    config.band_hz = Some((-1234.5, 0.1 + 0.2));
    config.false_alarm = 1e-9;
    config.following = Following { rate_bins: 1.7, most: 3, refresh: 9 };
    config.carrier = Carrier { linewidth_hz: 12.3, envelope_hz: 4.56 };
    for mixing in Mixing::ALL {
        config.scene = Scene::Doppler { wavelength_m: 1550e-9, angle_rad: 0.1, mixing };
        there_and_back(&config);
        for shape in [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth] {
            let chirp =
                Chirp { shape, mixing, guard_s: 1e-6, sweep_curvature: 0.01, ..Chirp::default() };
            config.scene = Scene::Chirp(chirp);
            there_and_back(&config);
        }
    }
    there_and_back(&Trigger { ratio: Some(1.7), hold_off: 5, least: 6 });
    there_and_back(&Trigger::default());
}

/// The answers to the records of a radar: a line, noise with no sigma, a velocity, ranges that are unique and not.
#[test]
fn every_answer_comes_back() {
    let scene = Scene::Doppler { wavelength_m: 0.0124, angle_rad: 0.0, mixing: Mixing::RxConjTx };
    let config = Config { scene, ..Config::new(8000.0, Codes::signed::<12>()) };
    let seen = block::<1024>(&config, |n| 900.0 * (0.131 * n).sin());
    let text = there_and_back(&seen);
    assert!(text.contains(r#""verdict":"good","also":[]"#), "{text}");
    let nothing = block::<1024>(&config, |_| 3.0);
    assert_eq!(nothing.tone.verdict, Verdict::NoSignal);
    there_and_back(&nothing);

    let Outcome::Velocity(velocity) = seen.result else { panic!("{seen:?}") };
    for shape in [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth] {
        let chirp = Chirp { shape, duration_s: 0.2, ..Chirp::default() };
        let config = Config { scene: Scene::Chirp(chirp), ..config };
        let mut pipeline = Pipeline::<Real, 256>::new(config.plan().unwrap());
        let mut result = Outcome::None;
        for (sequence, &segment) in (0..).zip(shape.segments()) {
            let turn = if segment == Segment::Flat { 0.1 } else { 0.5 + 0.1 * f64::from(sequence) };
            let samples = std::array::from_fn(|n| (500.0 * (turn * n as f64).sin()) as i16);
            let stamp = Stamp { sequence, segment, ..Stamp::default() };
            result = pipeline.block(&stamp, &samples).result;
            there_and_back(&result);
        }
        let Outcome::Target(target) = result else { panic!("{shape:?}: {result:?}") };
        let expected = match shape {
            Shape::Trapezoid => r#""ambiguity":"none""#,
            Shape::Triangle => r#""ambiguity":{"several":[{"range":"#,
            Shape::Sawtooth => {
                r#""sigma_velocity":null,"ambiguity":"coupled","verdict":"ambiguous""#
            }
        };
        assert!(there_and_back(&target).contains(expected), "{target:?}");
    }

    let mut tone = seen.tone;
    for verdict in Verdict::ALL {
        tone.verdict = verdict;
        there_and_back(&tone);
    }
    for bits in 0..0x80 {
        tone.also = Verdicts::from_bits(bits);
        there_and_back(&tone);
    }
    for validation in Validation::ALL {
        there_and_back(&Burst { tone, arrival: 12_345.625, deviation: 71.2, validation });
    }
    there_and_back(&velocity);
    there_and_back(&ToneWithPhase { tone, phase: -1.3, sigma_phase: f32::INFINITY });
    there_and_back(&FrequencyDrift { cycles: 1e-5, sigma: 1e-7 });
    there_and_back(&Harmonic { tone, orders: 0b1011 });
    there_and_back(&Unjudged { frequency: tone.frequency, sigma: tone.sigma });
    there_and_back(&Accumulated { tone, ln_chance: -77.1, blocks: 100 });
    let metres = velocity.velocity;
    there_and_back(&Displacement { metres, sigma: 1e-9, start: 3, verdict: Verdict::Gap });
    let least = Target { range: -metres, ..Target::default() };
    there_and_back(&Target { ambiguity: Ambiguity::Coupled, ..least });
    for decision in Decision::ALL {
        there_and_back(&Target { ambiguity: Ambiguity::Decided(decision), ..least });
    }

    // No number of JSON is NaN.
    let text = to_string(&Tone { snr: f32::NAN, sigma: f32::NAN, ..tone }).unwrap();
    let read: Tone = from_str(&text).unwrap();
    assert!(read.snr.is_nan() && read.sigma == f32::INFINITY, "{text}");
}

/// By hand, with the least that a configuration says.
#[test]
fn what_is_left_out_has_its_default() {
    let read = |text: &str| from_str::<Config>(text).unwrap();
    let config = Config::new(2e6, Codes::signed::<12>());
    let start = r#"{"rate_hz": 2e6, "codes": {"low": -2048, "high": 2047}"#;
    assert_eq!(read(&format!("{start}}}")), config);
    let some = format!(
        r#"{start}, "band_hz": [5e4, 8e5], "following": {{"most": 2}}, "carrier": {{"linewidth_hz": 100}},
            "scene": {{"doppler": {{"wavelength_m": 1.55e-6, "angle_rad": 0}}}}}}"#
    );
    let scene = Scene::Doppler { wavelength_m: 1.55e-6, angle_rad: 0.0, mixing: Mixing::RxConjTx };
    let following = Following { most: 2, ..Following::default() };
    let carrier = Carrier { linewidth_hz: 100.0, ..Carrier::default() };
    let band_hz = Some((5e4, 8e5));
    assert_eq!(read(&some), Config { band_hz, scene, following, carrier, ..config });
    let radar = format!(r#"{start}, "scene": {{"chirp": {{"shape": "sawtooth"}}}}}}"#);
    let scene = Scene::Chirp(Chirp { shape: Shape::Sawtooth, ..Chirp::default() });
    assert_eq!(read(&radar), Config { scene, ..config });
    assert!(read(&some).plan::<Iq, 1024>().is_ok());
}

#[test]
fn what_is_wrong_is_told() {
    let codes = r#""codes": {"low": -2048, "high": 2047}"#;
    for (text, error) in [
        (format!("{{{codes}}}"), "missing field `rate_hz`"),
        (r#"{"rate_hz": 1e6}"#.into(), "missing field `codes`"),
        (
            r#"{"rate_hz": 1e6, "codes": {"low": 0, "high": 100}}"#.into(),
            "a converter has 256 codes or more",
        ),
        (
            format!(r#"{{"rate_hz": 1e6, {codes}, "bandhz": [1, 2]}}"#),
            "unknown field `bandhz`, expected one of",
        ),
        (
            format!(r#"{{"rate_hz": 1e6, {codes}, "following": {{"least": 1}}}}"#),
            "unknown field `least`",
        ),
        (
            format!(r#"{{"rate_hz": 1e6, {codes}, "method": "fft"}}"#),
            r#"string "fft", expected one of "#,
        ),
        (format!(r#"{{"rate_hz": 1e6, {codes}, "reach": 5}}"#), "integer `5`, expected 4, 8 or 16"),
    ] {
        let told = refused::<Config>(&text);
        assert!(told.contains(error), "{text}: {told}");
    }
    let told = refused::<picket_dsp::Frequency>("0.5");
    assert!(
        told.contains("`0.5`, expected at least -0.5 and less than 0.5 cycles per sample"),
        "{told}"
    );
    let told = refused::<Verdicts>(r#"["clipped", "no-signal"]"#);
    assert!(
        told.contains(r#"string "no-signal", expected verdicts that can apply beside another"#),
        "{told}"
    );
    let told = refused::<Velocity>(r#"{"velocity": 1e10, "sigma": 1, "verdict": "good"}"#);
    assert!(told.contains("expected at least -2^31 and less than 2^31"), "{told}");
}

//! Scenes against the textbooks' formulas, which the simulator does not know, and against what they say of themselves.

use picket_simulator::scene::{Change, Density, Receiver, Source, Tone};
use picket_simulator::{Scene, Value};
use std::f64::consts::TAU;

const C: f64 = 299_792_458.0;

fn tone(frequency_hz: f64, amplitude: f64) -> Tone {
    Tone { frequency_hz: frequency_hz.into(), amplitude: Some(amplitude.into()), ..Tone::default() }
}

/// Power of a record at a frequency, over that of the record: the squared magnitude of its correlation.
fn power(record: &[[f64; 2]], turns_per_sample: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (index, [i, q]) in record.iter().enumerate() {
        let (sin, cos) = (TAU * turns_per_sample * index as f64).sin_cos();
        re += i * cos + q * sin;
        im += q * cos - i * sin;
    }
    (re * re + im * im) / (record.len() as f64).powi(2)
}

const CAR: &str = r#"{"rate_hz": 20000, "seconds": 8, "waveform": {"carrier_hz": 24.125e9},
    "sources": [{"target": {"range_m": 90, "velocity_mps": [[0, 20], [2, 20], [6, 0]], "amplitude": 400}}],
    "receiver": {"iq": true, "mixing": "rx-conj-tx", "quadrature_rad": 0.03, "gain_error": 0.02,
                 "hum": [{"frequency_hz": 50, "amplitude": 30}]}}"#;

#[test]
fn a_car_that_brakes_has_its_doppler_shift_and_a_receivers_faults() {
    let scene = Scene::from_json(CAR).unwrap();
    let mut run = scene.run(0).unwrap();
    for (time_s, speed) in [(0.5, 20.0), (4.0, 10.0), (7.0, 0.0)] {
        let truth = run.truth(0, time_s, 200);
        let doppler_hz = 2.0 * speed * 24.125e9 / C;
        // In 10 ms it brakes by .05 m/s, which are 8 Hz.
        assert!((truth.frequency_hz - doppler_hz).abs() < 9.0, "{truth:?}");
        assert!((truth.velocity_mps.unwrap() - speed).abs() < 0.06);
    }
    let stands = run.truth(0, 7.0, 200).range_m.unwrap();
    assert!((stands - (90.0 - 2.0 * 20.0 - 40.0)).abs() < 1e-6, "{stands}");
    // A second of steady speed: the image is as weak as gain and phase are wrong, the hum 22 dB below.
    let record = run.voltages(0.5, 20_000);
    let hz = 2.0 * 20.0 * 24.125e9 / C / 20e3;
    let ratio = (power(&record, -hz) / power(&record, hz)).sqrt();
    assert!((ratio - 0.5 * 0.02f64.hypot(0.03)).abs() < 5e-4, "{ratio}");
    let hum = power(&record, 50.0 / 20e3).sqrt();
    assert!((hum - 15.0).abs() < 1.0, "{hum}");
}

#[test]
fn two_particles_in_a_flow_that_reverses() {
    let scene = Scene::from_json(
        r#"{"rate_hz": 4e6, "seconds": 0.02,
            "sources": [{"particles": {"amplitude": 300, "shift_hz": 1e6, "velocity_mps": [[0, 2], [0.02, -2]],
                "at": [{"middle_s": 0.004, "velocity_mps": 1.2}, {"middle_s": 0.00405, "velocity_mps": 1.2, "level_db": -6}]}}]}"#,
    );
    let mut run = scene.unwrap().run(0).unwrap();
    assert_eq!(run.particles(0).len(), 2);
    // A quarter of a million fringes a second at 1 m/s, and the shift.
    let hertz = 1e6 + 1.2 / 4e-6;
    let record = run.voltages(0.004 - 1e-4, 800);
    let at = |hz: f64| power(&record, hz / 4e6);
    let best = (-300..300)
        .map(|step| hertz + 100.0 * f64::from(step))
        .max_by(|a, b| at(*a).total_cmp(&at(*b)));
    assert!((best.unwrap() - hertz).abs() < 2500.0, "{best:?}");
    // On a pedestal: light is never negative, and most of it is below the fringes' frequency.
    assert!(record.iter().all(|[light, _]| *light >= 0.0) && at(0.0) > at(hertz));
    // The flow carries them back at the other end of its course.
    let later = run.voltages(0.016 - 1e-4, 800);
    assert!(later.iter().any(|[light, _]| *light > 100.0));
    let between = run.voltages(0.010, 400);
    assert!(between.iter().all(|[light, _]| *light < 1.0));
}

#[test]
fn noise_has_the_power_and_the_density_that_are_stated() {
    let slope = || vec![Density::Slope { rise_db: (-20.0).into() }];
    for (shape, iq) in [
        (vec![], false),
        (slope(), false),
        (slope(), true),
        (
            vec![Density::Points { points: vec![[0.0, 0.0], [64.0, 20.0]], beside_tone: false }],
            false,
        ),
    ] {
        let mut scene = Scene { seed: 3, rate_hz: 256.0, seconds: 64.0, ..Scene::default() };
        scene.receiver.iq = iq;
        scene.receiver.noise.rms = Some(10.0.into());
        scene.receiver.noise.shape = shape;
        let mut run = scene.run(0).unwrap();
        let record = run.voltages(0.0, 64 * 256);
        let mean = record.iter().map(|[x, _]| x * x).sum::<f64>() / record.len() as f64;
        assert!((mean / 100.0 - 1.0).abs() < 0.1, "{mean}");
        let places: &[f64] = if iq { &[20.0, 100.0, -100.0] } else { &[20.0, 100.0] };
        for &hz in places {
            let near =
                (0..400).map(|step| power(&record, (hz + 0.02 * f64::from(step - 200)) / 256.0));
            let parts = if iq { 2.0 } else { 1.0 };
            let density = near.sum::<f64>() / 400.0 * record.len() as f64 / 100.0 / parts;
            assert!((density / run.dense(hz) - 1.0).abs() < 0.2, "{hz}: {density}");
        }
    }
}

/// A sine comes out as large as the gain says, and noise as strong as that of its band, to a hundredth.
#[test]
fn filters_pass_what_their_gain_says() {
    let mut scene = Scene { rate_hz: 20e3, seconds: 4.0, ..Scene::default() };
    scene.receiver.high_pass_hz = vec![100.0];
    scene.receiver.low_pass_hz = vec![2000.0, 3000.0];
    scene.receiver.oversampling = 8;
    let rms = |scene: &Scene| {
        let record = scene.run(0).unwrap().voltages(0.0, 80_000);
        // The first half is the switching on.
        (record[40_000..].iter().map(|[x, _]| x * x).sum::<f64>() / 40_000.0).sqrt()
    };
    for hz in [30.0f64, 100.0, 700.0, 2000.0, 6000.0] {
        scene.sources = vec![Source::Tone(tone(hz, 500.0))];
        let gain = scene.run(0).unwrap().gain(hz);
        let corner = |x: f64| x.hypot(1.0);
        let formula = 1.0 / corner(100.0 / hz) / corner(hz / 2000.0) / corner(hz / 3000.0);
        assert!((gain / formula - 1.0).abs() < 0.02, "{hz} Hz: {gain}, not {formula}");
        let seen = 2f64.sqrt() * rms(&scene) / 500.0;
        assert!((seen / gain - 1.0).abs() < 0.01, "{hz} Hz: {seen}, not {gain}");
    }
    scene.sources = Vec::new();
    scene.receiver.noise.rms = Some(100.0.into());
    let passed = scene.run(0).unwrap().passed_noise();
    // 40,000 values whose band is a tenth of their rate: their power spreads by a hundredth.
    let seen = rms(&scene);
    assert!(passed < 30.0 && (seen / passed - 1.0).abs() < 0.03, "{seen}, not {passed}");
}

#[test]
fn codes_end_at_the_rails() {
    let loud = Source::Tone(tone(7.0, 9000.0));
    let mut scene = Scene { rate_hz: 1024.0, seconds: 1.0, ..Scene::default() };
    let mut ends = |rails: Option<[i16; 2]>, unsigned: bool, sources: &[Source]| {
        (scene.converter.rails, scene.converter.unsigned) = (rails, unsigned);
        scene.sources = sources.to_vec();
        let codes = scene.codes(0).unwrap().into_iter().map(|[code, _]| code);
        (codes.clone().min().unwrap(), codes.max().unwrap())
    };
    let loud = std::slice::from_ref(&loud);
    assert_eq!(ends(None, false, loud), (-2048, 2047));
    assert_eq!(ends(None, true, loud), (0, 4095));
    assert_eq!(ends(Some([-100, 3000]), false, loud), (-100, 3000));
    assert_eq!(ends(Some([-2048, 2047]), false, &[]), (0, 0));
    assert_eq!(ends(Some([0, 4095]), false, &[]), (2048, 2048));
    assert_eq!(ends(Some([0, 4094]), false, &[]), (2048, 2048));
}

#[test]
fn a_run_depends_on_seed_and_trial_alone() {
    let mut scene = Scene::from_json(CAR).unwrap();
    scene.seconds = 0.1;
    scene.receiver.noise.rms = Some(20.0.into());
    let codes = |seed: u64, trial: u64| Scene { seed, ..scene.clone() }.codes(trial).unwrap();
    assert_eq!(codes(1, 7), codes(1, 7));
    assert!(codes(1, 7) != codes(1, 8) && codes(1, 7) != codes(2, 7));
    // A further source changes nothing of the others.
    let mut more = scene.clone();
    more.sources.push(Source::Tone(tone(1e3, 0.0)));
    assert_eq!(more.codes(3).unwrap(), scene.codes(3).unwrap());
    assert_eq!(
        serde_json::from_str::<Scene>(&serde_json::to_string(&scene).unwrap()).unwrap(),
        scene
    );
}

#[test]
fn changes_of_a_tone_are_what_they_say() {
    let run = |changes: Vec<Change>| {
        let source = Source::Tone(Tone { changes, ..tone(100.0, 1000.0) });
        Scene { rate_hz: 1024.0, seconds: 1.0, sources: vec![source], ..Scene::default() }
            .run(0)
            .unwrap()
    };
    let value = |x: f64| Value::Fixed(x);
    let chirp =
        run(vec![Change::Chirp { hz_per_s: value(4.0), at_s: value(0.5) }]).truth(0, 0.0, 1024);
    assert!((chirp.frequency_hz - 100.0).abs() < 0.01 && (chirp.mean_hz - 100.0).abs() < 1e-9);
    let step = run(vec![Change::Jump { turns: value(0.1), hz: value(2.0), at_s: value(0.25) }])
        .truth(0, 0.0, 1024);
    assert!((step.mean_hz - 101.5).abs() < 1e-9 && step.nominal_hz == 100.0, "{step:?}");
    let mut on = run(vec![Change::On { from_s: value(0.25), for_s: value(0.5) }]);
    let record = on.voltages(0.0, 1024);
    let loud = |range: std::ops::Range<usize>| record[range].iter().any(|[x, _]| x.abs() > 500.0);
    assert!(!loud(0..256) && loud(256..768) && !loud(768..1024));
}

/// Campbell's theorem: the mean power is the rate times a burst's energy. Nobody comes in exp(-rate) of the time.
#[test]
fn bursts_come_at_random() {
    let value = |x: f64| Value::Fixed(x);
    let changes =
        vec![Change::Bursts { per_s: value(4.0), deviation_s: value(0.01), nepers: value(2.0) }];
    let source = Source::Tone(Tone { changes, ..tone(100.0, 1.0) });
    let receiver = Receiver { iq: true, ..Receiver::default() };
    let (rate_hz, sources) = (1024.0, vec![source]);
    let scene = Scene { rate_hz, seconds: 1000.0, sources, receiver, ..Scene::default() };
    let record = scene.run(0).unwrap().voltages(0.0, 1_024_000);
    let power: Vec<f64> = record.iter().map(|[i, q]| i * i + q * q).collect();
    let energy = (1.0 - (-4f64).exp()) / 4.0 * 0.01 * (TAU / 2.0).sqrt();
    // Of 4,000 bursts the mean power is known to 2 %.
    let mean = power.iter().sum::<f64>() / power.len() as f64;
    assert!((mean / (4.0 * energy) - 1.0).abs() < 0.08, "{mean}");
    // Six deviations to each side of its middle nothing is left of a burst.
    let dark = power.iter().filter(|power| **power == 0.0).count() as f64 / power.len() as f64;
    assert!((dark - (-4.0 * 0.12f64).exp()).abs() < 0.06, "{dark}");
}

#[test]
fn noise_before_the_mixers_has_their_faults() {
    let mut receiver = Receiver { iq: true, gain_error: 1.0.into(), ..Receiver::default() };
    receiver.noise.rms = Some(10.0.into());
    let mut scene = Scene { rate_hz: 1e4, seconds: 1.0, receiver, ..Scene::default() };
    let mut ratio = |mixed: bool| {
        scene.receiver.noise.mixed = mixed;
        let record = scene.run(0).unwrap().voltages(0.0, 10_000);
        let power = |part: usize| record.iter().map(|x| x[part] * x[part]).sum::<f64>();
        power(1) / power(0)
    };
    assert!((ratio(false) - 1.0).abs() < 0.1 && (ratio(true) - 4.0).abs() < 0.4);
}

#[test]
fn without_rounding_other_faults_stay() {
    let mut scene = Scene { rate_hz: 256.0, seconds: 1.0, ..Scene::default() };
    scene.sources = vec![Source::Tone(tone(10.3, 3000.0))];
    scene.converter.inl_codes = 16.0.into();
    let codes = scene.run(0).unwrap().codes(0.0, 256);
    let exact = scene.run(0).unwrap().unrounded(0.0, 256);
    let pure = scene.run(0).unwrap().voltages(0.0, 256);
    for ((code, exact), pure) in codes.iter().zip(&exact).zip(&pure) {
        assert_eq!(f64::from(code[0]), exact[0].round().clamp(-2048.0, 2047.0));
        assert!((exact[0] - pure[0]).abs() < 50.0 && exact[0] != pure[0]);
    }
}

/// Where samples are lost, a walk goes on; where they are old, it was there.
#[test]
fn what_changes_is_there_before_and_after_the_scene() {
    use picket_simulator::scene::Place;
    let changes = vec![Change::Walk { linewidth_hz: 1.0.into() }];
    let mut scene = Scene { rate_hz: 64.0, seconds: 1.0, ..Scene::default() };
    scene.receiver.iq = true;
    scene.sources = vec![Source::Tone(Tone { changes, ..tone(0.0, 1.0) })];
    let place = || Some(Place { at: 32.0.into(), count: 100.0.into() });
    let mut lost = scene.clone();
    lost.converter.lost = place();
    scene.converter.stale = place();
    for scene in [lost, scene] {
        let record = scene.run(0).unwrap().voltages(0.0, 64);
        assert!(record[32..].windows(2).all(|pair| pair[0] != pair[1]));
    }
}

#[test]
fn records_lie_in_the_segments() {
    for (mixing, sign) in [("tx-conj-rx", 1.0), ("rx-conj-tx", -1.0)] {
        let scene = Scene::from_json(&format!(
            r#"{{"rate_hz": 400000, "seconds": 20e-3,
                "waveform": {{"shape": "trapezoid", "carrier_hz": 24e9, "bandwidth_hz": 2e8, "ramp_s": 1e-3, "period_s": 5e-3,
                    "guard_s": 1e-4, "samples": 256}},
                "sources": [{{"target": {{"range_m": 30, "velocity_mps": 3, "amplitude": 500}}}}],
                "receiver": {{"iq": true, "mixing": "{mixing}"}}}}"#
        ));
        let scene = scene.unwrap();
        assert_eq!(scene.records(256), 12);
        assert!((scene.start_s(4, 256) - 6.1e-3).abs() < 1e-12);
        let run = scene.run(0).unwrap();
        let beat = |index| sign * run.truth(0, scene.start_s(index, 256), 256).frequency_hz;
        let (range, shift) = (2e8 / 1e-3 * 60.0 / C, 2.0 * 3.0 * 24e9 / C);
        for (index, wanted) in [range - shift, -shift, -range - shift].into_iter().enumerate() {
            assert!((beat(index) - wanted).abs() < 20.0, "{}, not {wanted}", beat(index));
        }
    }
}

/// An echo that is late by less than the samples of a record: what is left of the laser's phase is the walk of its delay.
#[test]
fn a_lasers_phase_walks_by_the_delay_of_the_echo() {
    let (rate_hz, linewidth_hz, delay_s) = (250e6, 200e3, 0.4e-6);
    let scene = Scene::from_json(&format!(
        r#"{{"rate_hz": {rate_hz}, "seconds": 4.4e-6, "waveform": {{"carrier_hz": 1e9, "linewidth_hz": {linewidth_hz}}},
            "sources": [{{"target": {{"range_m": {}, "amplitude": 1, "phase_turns": 0}}}}], "receiver": {{"iq": true}}}}"#,
        0.5 * delay_s * C
    ));
    let scene = scene.unwrap();
    let (mut squares, mut product, mut apart, records) = (0.0, 0.0, 0.0, 4000);
    for trial in 0..records {
        let record = scene.run(trial).unwrap().voltages(0.0, 1100);
        // Samples 50 ns, and 4 us apart: their walks have seven eighths of the delay in common, and nothing. The carrier turns 400 times.
        let [a, b, c] = [0, 12, 1000].map(|k| record[k][1].atan2(record[k][0]));
        squares += a * a;
        product += a * b;
        apart += a * c;
    }
    let variance = TAU * linewidth_hz * delay_s;
    let common = 1.0 - 12.0 / rate_hz / delay_s;
    // A mean of 4,000 squares is known to 2.2 %, one sigma.
    for (sum, stated) in [(squares, variance), (product, variance * common)] {
        let ratio = sum / records as f64 / stated;
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    }
    assert!((apart / records as f64 / variance).abs() < 0.1, "{apart}");
}

#[test]
fn what_cannot_be_is_said() {
    for (json, said) in [
        (r#"{"rate_hz": 0, "seconds": 1}"#, "rate_hz: give a number above 0"),
        (
            r#"{"rate_hz": 1, "seconds": 1, "sources": [{"target": {"amplitude": 1}}]}"#,
            "sources[0]: nothing is sent",
        ),
        (r#"{"rate_hz": 1, "seconds": 1, "sources": [{"tone": {}}]}"#, "give its amplitude"),
        (
            r#"{"rate_hz": 1, "seconds": 1, "sources": [{"tone": {"amplitude": [[0, 1], [1, 2]]}}]}"#,
            "does not change with time",
        ),
        (
            r#"{"rate_hz": 1, "seconds": 1, "sources": [{"tone": {"amplitude": [5, 2]}}]}"#,
            "amplitude",
        ),
        (r#"{"rate_hz": 1, "seconds": 1, "converter": {"bits": 20}}"#, "bits: give 2 to 16"),
        (
            r#"{"rate_hz": 1, "seconds": 1, "converter": {"rails": [5, 5]}}"#,
            "rails: give the lowest code",
        ),
        (r#"{"rate_hz": 1e6, "seconds": 1e6}"#, "more than 1e9 samples"),
        (
            r#"{"rate_hz": 1, "seconds": 1, "receiver": {"noise": {"snr_db": 3}}}"#,
            "snr_db is that of a source",
        ),
        (
            r#"{"rate_hz": 1, "seconds": 1, "sources": [{"tone": {"hertz": 2}}]}"#,
            "unknown field `hertz`",
        ),
        (
            r#"{"rate_hz": 1, "seconds": 1, "sources": [{"tone": {"amplitude": "big"}}]}"#,
            "expected a number",
        ),
    ] {
        let error = Scene::from_json(json).and_then(|scene| scene.run(0).map(|_| ())).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
}

/// A lap's truth is in the middle of its records; an echo fades as it is told, and that of a surface falls with the range.
#[test]
fn an_echo_fades_and_a_surface_is_seen_from_farther() {
    let scene = |surface: bool| {
        Scene::from_json(&format!(
            r#"{{"rate_hz": 1e6, "seconds": 10, "waveform": {{"shape": "trapezoid", "carrier_hz": 24e9, "bandwidth_hz": 2e8,
                 "ramp_s": 1e-3, "period_s": 0.1, "guard_s": 1e-5, "samples": 900}},
                "sources": [{{"target": {{"range_m": 20, "velocity_mps": -10, "amplitude": 400, "amplitude_at_m": 20,
                    "surface": {surface}, "changes": [{{"level": {{"db": [[4, 0], [6, -20]]}}}}]}}}}]}}"#
        ))
        .unwrap()
    };
    assert_eq!((scene(true).segments(), Scene::default().segments()), (3, 1));
    let truth =
        |surface: bool, lap: usize| scene(surface).run(0).unwrap().truth_of_lap(0, lap, 900);
    let first = truth(true, 0);
    assert!((first.time_s - (1.01e-3 + 0.5 * 899e-6)).abs() < 1e-12, "{first:?}");
    // The flat record's line is that of the speed alone.
    assert!((first.frequency_hz.abs() - 2.0 * 10.0 * 24.2e9 / C).abs() < 1.0, "{first:?}");
    // At 40 m, at 70 m in the middle of the fading, and at 100 m.
    for (lap, falls, fades) in [(20, 2.0, 1.0), (50, 3.5, 10f64.powf(-0.5)), (80, 5.0, 0.1)] {
        let of = |surface: bool| truth(surface, lap).amplitude / 400.0;
        assert!((of(true) * falls / fades - 1.0).abs() < 0.02, "{lap}: {}", of(true));
        assert!((of(false) * falls * falls / fades - 1.0).abs() < 0.02, "{lap}: {}", of(false));
    }
}

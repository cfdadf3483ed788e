//! Eighty unknown recordings of the physics simulator, of fourteen kinds and in ten formats and more: the answers of the command that `picket analyze FILE`
//! proposes are right, or it says that it does not know. `PICKET_TYPED_SEED` gives others.

use crate::cli::seed;
use crate::unknown::{picket, wav};
use picket_simulator::scene::{Density, Mixing, Noise, Scene};
use picket_simulator::{Draw, Run};
use serde_json::json;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

const RECORDINGS: usize = 80;
/// As many are of the first kinds; the rest are of the others.
const FIRST: usize = 60;
/// The samples of which a logger takes one in 64.
const UNEVEN_HZ: f64 = 64e3;
const KINDS: [&str; 9] =
    ["steady", "accelerating", "walker", "bursts", "chirps", "fan", "two", "clipped", "flicker"];

const OTHERS: [&str; 5] = ["string", "square", "empty", "uneven", "cube"];

/// The kind of the recording of this number.
fn kind(index: usize) -> &'static str {
    match index.checked_sub(FIRST) {
        Some(other) => OTHERS[other % OTHERS.len()],
        None => KINDS[index % KINDS.len()],
    }
}

/// A recording of a kind.
struct Recording {
    run: Run,
    rate_hz: f64,
    /// Volts.
    samples: Vec<[f64; 2]>,
    iq: bool,
    /// Where a record of a chirp begins, s, and its samples; else a frequency changes with time.
    chirp: Option<(f64, usize)>,
    /// The other sources are the first one's partials.
    fundamental: bool,
}

impl Recording {
    fn new(scene: &Scene, chirp: Option<(f64, usize)>) -> Self {
        let mut run = scene.run(0).unwrap();
        let (rate_hz, iq) = (scene.rate_hz, scene.receiver.iq);
        let samples = run.voltages(0.0, (rate_hz * scene.seconds).round() as usize);
        Recording { run, rate_hz, samples, iq, chirp, fundamental: false }
    }

    /// The frequencies that are right at a time.
    fn truths(&self, time_s: f64) -> Vec<f64> {
        let (from_s, n) = self.chirp.unwrap_or((time_s, 2));
        let of = |source| self.run.truth(source, from_s, n).frequency_hz;
        let all = self.run.scene().sources.len();
        let sources = 0..if self.fundamental { 1 } else { all };
        sources.map(|source| if self.iq { of(source) } else { of(source).abs() }).collect()
    }
}

/// A recording of a kind, at this signal-to-noise ratio or at any.
fn recording(kind: &str, snr_db: Option<f64>, draw: &mut Draw) -> Recording {
    let any_db = draw.between(12.0, 32.0);
    let snr_db = snr_db.unwrap_or(any_db);
    if kind == "string" {
        let (first_hz, weaker_db) = (draw.between(80.0, 600.0), draw.between(0.0, 15.0));
        let stretch = 10f64.powf(draw.between(-6.0, -4.0));
        let decay_s = draw.between(0.5, 3.0);
        let scene = crate::strings::scene(first_hz, weaker_db, stretch, decay_s, draw);
        let mut string = Recording::new(&scene, None);
        string.fundamental = true;
        return string;
    }
    let iq = draw.below(3) == 0
        && !["walker", "bursts", "fan", "square", "empty", "uneven"].contains(&kind);
    let radar = json!({"carrier_hz": 24.125e9});
    let target = |range_m: f64, speed: serde_json::Value| json!({"range_m": range_m, "velocity_mps": speed, "amplitude": 0.3});
    let scene = |rate_hz: f64,
                 seconds: f64,
                 waveform: &serde_json::Value,
                 targets: serde_json::Value| {
        json!({"rate_hz": rate_hz, "seconds": seconds, "waveform": waveform, "sources": targets})
    };
    let mut chirp = None;
    let scene = match kind {
        "accelerating" => {
            // A car before a radar.
            let (v, a, s) =
                (draw.between(8.0, 20.0), draw.between(-3.5, 3.5), draw.between(2.0, 5.0));
            let car = target(200.0, json!([[0, v], [s, v + a * s]]));
            scene(24e3, s, &radar, json!([{"target": car}]))
        }
        "walker" => {
            // Before an HB100, with the mains in its amplifier.
            let (gait, part) = (draw.between(1.6, 2.2), draw.between(0.05, 0.2));
            let mut body = target(40.0, json!([1.0, 1.8]));
            body["vibration"] = json!([{"amplitude_m": part / (TAU * gait), "frequency_hz": gait}]);
            let hb100 = json!({"carrier_hz": 10.525e9});
            let mut all = scene(4e3, draw.between(8.0, 16.0), &hb100, json!([{"target": body}]));
            let mains = json!({"either": [50, 60]});
            let hum = json!({"frequency_hz": mains, "amplitude": [0.1, 0.8], "harmonics": [[2, -8], [3, -14]]});
            all["receiver"] = json!({"hum": [hum]});
            all
        }
        "bursts" => {
            // Particles in the beams of a laser-Doppler velocimeter.
            let (v, radius_m) = (draw.between(0.05, 0.15), draw.between(60e-6, 120e-6));
            let (mut at, mut middle_s) = (Vec::new(), 0.0);
            while middle_s < 0.6 {
                middle_s += 12.0 * radius_m / v * draw.between(0.8, 2.0);
                at.push(json!({"middle_s": middle_s}));
            }
            let flow = json!({"radius_m": radius_m, "velocity_mps": v, "amplitude": 0.3, "at": at});
            scene(200e3, 0.6, &radar, json!([{"particles": flow}]))
        }
        "chirps" => {
            // A sawtooth of a radar module, without pauses.
            let (rate_hz, period) = (200e3, [1000, 1250, 2000][draw.below(3)]);
            let ramp_s = f64::from(period) / rate_hz;
            let sawtooth = json!({"shape": "sawtooth", "carrier_hz": 24.125e9, "bandwidth_hz": 200e6, "ramp_s": ramp_s});
            chirp = Some((ramp_s + 20.0 / rate_hz, period as usize / 2));
            let corner = target(draw.between(8.0, 40.0), json!(0));
            scene(rate_hz, (0.5 / ramp_s).floor() * ramp_s, &sawtooth, json!([{"target": corner}]))
        }
        "fan" => {
            // A hub that approaches, and blades that come through the beam.
            let mut hub = target(200.0, json!([3, 12]));
            hub["changes"] = json!([{"am": {"depth": [0.1, 0.5], "rate_hz": [20, 60]}}]);
            scene(24e3, 3.0, &radar, json!([{"target": hub}]))
        }
        "two" => {
            let mut second = target(200.0, json!([11, 25]));
            second["amplitude"] = json!([0.03, 0.24]);
            let first = target(200.0, json!([5, 10]));
            scene(24e3, 3.0, &radar, json!([{"target": first}, {"target": second}]))
        }
        "square" => {
            let hz = draw.between(60.0, 1500.0);
            let tone = json!({"frequency_hz": hz, "amplitude": 0.3, "form": "square", "phase_turns": [0, 1]});
            json!({"rate_hz": 48e3, "seconds": 1.5, "sources": [{"tone": tone}], "receiver": {"oversampling": 8}})
        }
        "empty" => {
            // A car that comes by; before and after it nothing is there.
            let (v, a, from_s) =
                (draw.between(8.0, 20.0), draw.between(-1.5, 1.5), draw.between(1.0, 5.0));
            let mut car = target(200.0, json!([[0, v], [12, v + 12.0 * a]]));
            car["changes"] = json!([{"on": {"from_s": from_s, "for_s": [2.5, 5]}}]);
            scene(12e3, 12.0, &radar, json!([{"target": car}]))
        }
        "uneven" => {
            // A logger's samples, whose times `write` makes uneven.
            let hz = draw.between(20.0, 120.0);
            json!({"rate_hz": UNEVEN_HZ, "seconds": 9.0, "sources": [{"tone": {"frequency_hz": hz, "amplitude": 0.3}}]})
        }
        "cube" => {
            // Chirps of a radar module as an array.
            let (rate_hz, period) = (1e6, 512);
            let ramp_s = f64::from(period) / rate_hz;
            let sawtooth = json!({"shape": "sawtooth", "carrier_hz": 60e9, "bandwidth_hz": 1e9, "ramp_s": ramp_s});
            chirp = Some((ramp_s + 20.0 / rate_hz, 400));
            let corner = target(draw.between(2.0, 12.0), json!(0));
            scene(rate_hz, 64.0 * ramp_s, &sawtooth, json!([{"target": corner}]))
        }
        "slow-fm" => {
            // A target that swings before a radar, by a fraction of its mean shift.
            let (swing, turns) = (draw.between(0.3, 1.5), draw.between(0.2, 0.5));
            let mut swings = target(200.0, json!([6, 15]));
            swings["vibration"] = json!([{"amplitude_m": swing / (TAU * turns), "frequency_hz": turns, "phase_turns": [0, 1]}]);
            scene(24e3, draw.between(4.0, 8.0), &radar, json!([{"target": swings}]))
        }
        _ => {
            let rate_hz = [8e3, 48e3][draw.below(2)];
            let shift_hz = draw.between(0.04, 0.4) * rate_hz;
            let speed = shift_hz * 299_792_458.0 / 2.0 / 24.125e9;
            scene(rate_hz, 2.0, &radar, json!([{"target": target(2e3, json!(speed))}]))
        }
    };
    let mut scene: Scene = serde_json::from_value(scene).unwrap();
    (scene.seed, scene.receiver.iq) = (draw.bits(), iq);
    scene.receiver.noise.snr_db = Some(snr_db.into());
    if chirp.is_none() {
        scene.receiver.mixing = Mixing::RxConjTx;
    }
    match kind {
        "clipped" => scene.receiver.limit = Some(draw.between(0.4, 0.9) * 0.3),
        "flicker" => {
            // White noise, and as much of 1/f in each of twelve octaves.
            let white = 0.3 / (2.0 * 10f64.powf(snr_db / 10.0)).sqrt();
            let flicker = 0.1;
            let half_hz = 0.5 * scene.rate_hz;
            let point = |octave: i32| {
                let hz = half_hz * 0.5f64.powi(octave);
                let octaves = 12.0 * std::f64::consts::LN_2;
                let density = white * white / half_hz + flicker * flicker / octaves / hz;
                [hz, 10.0 * density.log10()]
            };
            let points = (0..=12).rev().map(point).collect();
            scene.receiver.noise = Noise {
                rms: Some(white.hypot(flicker).into()),
                shape: vec![Density::Points { points, beside_tone: false }],
                ..Noise::default()
            };
        }
        _ => {}
    }
    Recording::new(&scene, chirp)
}

/// A logger's table: one of 64 samples is taken, and its time is written in milliseconds, or read some microseconds late, or with a pause.
fn table(scene: &Recording, draw: &mut Draw) -> String {
    const APART: usize = 64;
    let (way, mut lost) = (draw.below(3), 0);
    let mut text = String::from(if way == 1 { "micros,adc\n" } else { "time,adc\n" });
    for k in 0..scene.samples.len() / APART {
        lost += usize::from(way == 2 && (4000..4700).contains(&k));
        let late = if way == 1 { draw.below(3) } else { 0 };
        let at = APART * k + late;
        let Some(x) = scene.samples.get(at).filter(|_| !(way == 2 && (4000..4700).contains(&k)))
        else {
            continue;
        };
        let time_s = at as f64 / scene.rate_hz;
        let code = (2048.0 + 5000.0 * x[0]).round();
        text += &match way {
            0 => format!("{:.3},{code}\n", (1e3 * time_s).floor() / 1e3),
            1 => format!("{},{code}\n", (1e6 * time_s).round()),
            _ => format!("{time_s:.6},{code}\n"),
        };
    }
    println!("uneven of kind {way}, {lost} lost");
    text
}

/// A file of NumPy.
pub fn npy(kind: &str, shape: &str, data: Vec<u8>) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}\n");
    [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &data]
        .concat()
}

/// Writes the samples in one of ten formats; gives the file's name, and what a person types of it.
fn write(folder: &Path, index: usize, format: usize, scene: &Recording) -> (String, Vec<String>) {
    let Recording { rate_hz, samples, iq, .. } = scene;
    let parts = if *iq { 2 } else { 1 };
    let full = samples.iter().flatten().fold(1e-9f64, |most, x| most.max(x.abs())) / 0.8;
    let flat = || samples.iter().flat_map(|x| x[..parts].to_vec());
    let integers = |most: f64| flat().map(move |x| (most * x / full).round());
    let rate = vec!["--rate".to_owned(), rate_hz.to_string()];
    let pairs = if *iq { vec!["--iq".to_owned()] } else { vec![] };
    let (suffix, bytes, options): (&str, Vec<u8>, Vec<String>) = match format {
        0..=2 => {
            let bits = [16, 24, 33][format];
            let scale = if bits == 33 { 1.0 } else { 1.0 / full };
            let name = format!("{index}.wav");
            let spec = (parts as u16, bits);
            wav(&folder.join(&name), *rate_hz, spec, flat().map(|x| scale * x));
            return (name, pairs);
        }
        3 => {
            let row = |(k, x): (usize, &[f64; 2])| match iq {
                true => format!("{:.9},{:.6},{:.6}\n", k as f64 / rate_hz, x[0], x[1]),
                false => format!("{:.9},{:.6}\n", k as f64 / rate_hz, x[0]),
            };
            let head = if *iq { "time (s),i,q\n" } else { "time (s),volt\n" };
            let rows: String = samples.iter().enumerate().map(row).collect();
            ("csv", (head.to_owned() + &rows).into(), pairs)
        }
        4 if !iq => {
            let text: String = flat().map(|x| format!("{x:.5}\n")).collect();
            let head = format!(
                "x.txt 1 channel (mono)\nSample Rate: {rate_hz} Hz. Sample values on linear scale.\n\n"
            );
            ("txt", (head + &text).into(), vec![])
        }
        4 | 5 => {
            let kind = if *iq { "<c16" } else { "<f8" };
            let data = flat().flat_map(f64::to_le_bytes).collect();
            ("npy", npy(kind, &format!("{},", samples.len()), data), rate)
        }
        6 => {
            let suffix = if *iq { "cf32" } else { "f32" };
            (suffix, flat().flat_map(|x| (x as f32).to_le_bytes()).collect(), rate)
        }
        7 => {
            let suffix = if *iq { "cs16" } else { "i16" };
            (suffix, integers(32767.0).flat_map(|x| (x as i16).to_le_bytes()).collect(), rate)
        }
        8 => {
            let kind = if *iq { "ci16_le" } else { "ri16_le" };
            let meta = format!(
                r#"{{"global": {{"core:datatype": "{kind}", "core:sample_rate": {rate_hz}, "core:version": "1.0.0"}}, "captures": [{{"core:sample_start": 0}}], "annotations": []}}"#
            );
            fs::write(folder.join(format!("{index}.sigmf-meta")), meta).unwrap();
            let data: Vec<u8> = integers(30_000.0).flat_map(|x| (x as i16).to_le_bytes()).collect();
            ("sigmf-data", data, vec![])
        }
        _ => {
            let suffix = if *iq { "cf64" } else { "f64" };
            (suffix, flat().flat_map(f64::to_le_bytes).collect(), rate)
        }
    };
    let name = format!("{index}.{suffix}");
    fs::write(folder.join(&name), bytes).unwrap();
    (name, options)
}

/// The usable answers within three sigma of the truth, and all usable ones.
fn judged(lines: &str, of: &Recording) -> (usize, usize) {
    let (mut right, mut usable) = (0, 0);
    for line in lines.lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        let verdict = line["verdict"].as_str().unwrap_or_default();
        // Of bursts those that are valid.
        let valid = line["validation"].as_str().is_none_or(|validation| validation == "valid");
        if !valid || !["good", "moving", "clipped", "gap"].contains(&verdict) {
            continue;
        }
        let number = |key: &str| line[key].as_f64().unwrap();
        let (hz, sigma, time) = (number("frequency_hz"), number("sigma_hz"), number("time_s"));
        let sigma = line["uncertainty_hz"].as_f64().unwrap_or(sigma);
        let near = |truth: &f64| (hz - truth).abs() <= 3.0 * sigma;
        usable += 1;
        right += usize::from(of.truths(time).iter().any(near));
    }
    (right, usable)
}

/// What became of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Of the answers of what was proposed at least 95 % are within three sigma.
    Right,
    /// Nothing was proposed, and that was said.
    Unknown,
    /// Fewer are.
    Wrong,
}

/// An empty folder for recordings.
pub fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Draws a recording of a kind, has it looked at, and runs what is proposed.
pub fn outcome(
    folder: &Path,
    index: usize,
    kind: &str,
    snr_db: Option<f64>,
    draw: &mut Draw,
) -> Outcome {
    let scene = recording(kind, snr_db, draw);
    let format = draw.below(10);
    let (name, options) = match kind {
        "uneven" => {
            let name = format!("{index}.csv");
            fs::write(folder.join(&name), table(&scene, draw)).unwrap();
            (name, vec![])
        }
        "cube" => {
            let name = format!("{index}.npy");
            let flat =
                scene.samples.iter().flat_map(|x| if scene.iq { x.to_vec() } else { vec![x[0]] });
            let data = flat.flat_map(|x| (x as f32).to_le_bytes()).collect();
            let kind = if scene.iq { "<c8" } else { "<f4" };
            fs::write(folder.join(&name), npy(kind, "64, 512", data)).unwrap();
            (name, vec!["--rate".into(), scene.rate_hz.to_string()])
        }
        _ => write(folder, index, format, &scene),
    };
    let look = picket(folder, &[vec!["analyze".into(), name.clone()], options].concat());
    let proposed = look.lines().find_map(|line| line.strip_prefix("try       picket "));
    let Some(proposed) = proposed else {
        assert!(
            look.contains("nothing that was tried") || look.contains("no signal stands out"),
            "{look}"
        );
        println!("{index} {kind} {name}: not known\n{look}");
        return Outcome::Unknown;
    };
    let words = proposed.split(' ').map(str::to_owned).chain(["--json".into()]);
    let (within, usable) = judged(&picket(folder, &words.collect::<Vec<_>>()), &scene);
    if usable > 0 && within as f64 >= 0.95 * usable as f64 {
        // The others are kept, to be looked at.
        let _ = fs::remove_file(folder.join(&name));
        println!("{index} {kind}: {within} of {usable} by {proposed}");
        return Outcome::Right;
    }
    println!("{index} {kind} WRONG: {within} of {usable} by {proposed}\n{look}");
    Outcome::Wrong
}

#[test]
fn what_is_proposed_is_right_or_nothing_is() {
    let mut draw = Draw::new(seed(44), 0);
    let folder = folder("survey");
    let outcomes: Vec<Outcome> = (0..RECORDINGS)
        .map(|index| outcome(&folder, index, kind(index), None, &mut draw))
        .collect();
    let count = |wanted: Outcome| outcomes.iter().filter(|&&outcome| outcome == wanted).count();
    let [right, unknown, wrong] = [Outcome::Right, Outcome::Unknown, Outcome::Wrong].map(count);
    println!("{right} right, {unknown} not known, {wrong} wrong of {RECORDINGS}");
    // A walker whose shift lies at the mains' harmonics is not known. Of 17 answers beside a second tone one is 3 sigma off, which is more
    // than 5 %.
    let others =
        outcomes.iter().enumerate().take(FIRST).filter(|(index, _)| kind(*index) != "walker");
    let missed = others.filter(|(_, outcome)| **outcome != Outcome::Right).count();
    assert!(missed <= 1 && wrong <= 2, "{missed} that are no walkers are not right; {wrong} wrong");
    // A car that brakes and leaves within a block has the mean frequency of the part that is there, which is not the block's.
    assert!(right >= 71, "{right} of {RECORDINGS} are right");
}

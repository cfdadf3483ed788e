//! Sixty unknown recordings of the physics simulator, of nine kinds and in ten formats: the answers of what `picket analyze FILE` says to
//! type are right, or it says that it does not know. `PICKET_TYPED_SEED` gives others.

use crate::cli::seed;
use crate::unknown::picket;
use picket_dsp::{Chirp, Mixing, Shape};
use picket_simulator::{Receiver, Sensor, Target, Waveform};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

const RECORDINGS: usize = 60;
const LIGHT: f64 = 299_792_458.0;
const KINDS: [&str; 9] =
    ["steady", "accelerating", "walker", "bursts", "chirps", "fan", "two", "clipped", "flicker"];

/// The frequencies that are right at a time, s and Hz.
type Truth = Box<dyn Fn(f64) -> Vec<f64>>;

/// Samples with what is in them.
struct Scene {
    rate_hz: f64,
    /// Volts.
    samples: Vec<[f64; 2]>,
    iq: bool,
    /// The frequencies that are right at a time.
    truth: Truth,
}

fn normals(rng: &mut ChaCha8Rng) -> impl FnMut() -> f64 + '_ {
    move || rng.sample(StandardNormal)
}

/// A Doppler radar or velocimeter before targets whose ranges are given; codes become volts.
fn doppler(
    carrier_hz: f64,
    (rate_hz, seconds, iq): (f64, f64, bool),
    targets: &[Target],
    snr_db: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<[f64; 2]> {
    let amplitude = targets[0].amplitude;
    let receiver = Receiver::ideal(rate_hz, iq, Mixing::RxConjTx).with_snr(amplitude, snr_db);
    let n = (rate_hz * seconds) as usize;
    receiver.voltages(&Waveform::continuous(carrier_hz), targets, (0, 0.0), n, normals(rng))
}

/// The shift of a speed.
fn shift(carrier_hz: f64, speed: f64) -> f64 {
    2.0 * speed * carrier_hz / LIGHT
}

/// A scene of a kind, at this signal-to-noise ratio or at any.
fn scene(kind: &str, snr_db: Option<f64>, rng: &mut ChaCha8Rng) -> Scene {
    let any_db = rng.random_range(12.0..32.0);
    let snr_db = snr_db.unwrap_or(any_db);
    let iq = rng.random_range(0..3) == 0;
    let k24 = 24.125e9;
    let signed = |iq: bool, hz: f64| if iq { hz } else { hz.abs() };
    match kind {
        "accelerating" => {
            // A car before a radar.
            let (rate_hz, seconds) = (24_000.0, rng.random_range(2.0..5.0));
            let (v, a) = (rng.random_range(8.0..20.0), rng.random_range(-3.5..3.5));
            let target = Target::new(0.3, move |t| 60.0 - v * t - 0.5 * a * t * t);
            let samples = doppler(k24, (rate_hz, seconds, iq), &[target], snr_db, rng);
            let truth = move |t: f64| vec![signed(iq, shift(k24, v + a * t))];
            Scene { rate_hz, samples, iq, truth: Box::new(truth) }
        }
        "walker" => {
            // Before an HB100, with the mains in its amplifier.
            let (carrier, rate_hz, seconds) = (10.525e9, 4000.0, rng.random_range(8.0..16.0));
            let (v, gait, part) = (
                rng.random_range(1.0..1.8),
                rng.random_range(1.6..2.2),
                rng.random_range(0.05..0.2),
            );
            let speed = move |t: f64| v + part * (TAU * gait * t).sin();
            let target = Target::new(0.3, move |t| {
                20.0 - v * t + part / (TAU * gait) * (TAU * gait * t).cos()
            });
            let mut samples = doppler(carrier, (rate_hz, seconds, false), &[target], snr_db, rng);
            let (mains, phase): (f64, f64) = ([50.0, 60.0][rng.random_range(0..2)], rng.random());
            let level = rng.random_range(0.1..0.8);
            for (k, sample) in samples.iter_mut().enumerate() {
                let cycles = mains * k as f64 / rate_hz + phase;
                let hum = (TAU * cycles).sin()
                    + 0.4 * (2.0 * TAU * cycles).sin()
                    + 0.2 * (3.0 * TAU * cycles).sin();
                sample[0] += level * hum;
            }
            let truth = move |t: f64| vec![shift(carrier, speed(t))];
            Scene { rate_hz, samples, iq: false, truth: Box::new(truth) }
        }
        "bursts" => {
            // Particles in the beams of a laser-Doppler velocimeter: fringes of 4 um.
            let (rate_hz, seconds) = (200_000.0, 0.6);
            let (pitch, width) = (4e-6, rng.random_range(60e-6..120e-6));
            let v = rng.random_range(0.05..0.15);
            let count = (seconds * rate_hz) as usize;
            let noise = 0.3 / (2.0 * 10f64.powf(snr_db / 10.0)).sqrt();
            let mut samples: Vec<[f64; 2]> =
                (0..count).map(|_| [noise * rng.sample::<f64, _>(StandardNormal), 0.0]).collect();
            let mut at = 0.0;
            while at < seconds {
                at += 12.0 * width / v * rng.random_range(0.8..2.0);
                let phase: f64 = rng.random();
                let half = (4.0 * width / v * rate_hz) as i64;
                let middle = (at * rate_hz) as i64;
                for k in (middle - half).max(0)..(middle + half).min(count as i64) {
                    let x = v * (k as f64 / rate_hz - at);
                    let envelope = (-2.0 * (x / width).powi(2)).exp();
                    samples[k as usize][0] +=
                        0.3 * envelope * (1.0 + (TAU * (x / pitch + phase)).cos());
                }
            }
            let truth = move |_| vec![v / pitch];
            Scene { rate_hz, samples, iq: false, truth: Box::new(truth) }
        }
        "chirps" => {
            // A sawtooth of a radar module, without pauses.
            let rate_hz = 200_000.0;
            let period = [1000, 1250, 2000][rng.random_range(0..3)];
            let duration_s = f64::from(period) / rate_hz;
            let range: f64 = rng.random_range(8.0..40.0);
            let chirp = Chirp {
                shape: Shape::Sawtooth,
                wavelength_m: LIGHT / k24,
                bandwidth_hz: 200e6,
                duration_s,
                guard_s: 20.0 / rate_hz,
                ..Chirp::default()
            };
            let receiver = Receiver::ideal(rate_hz, iq, Mixing::TxConjRx).with_snr(0.3, snr_db);
            let target = Target::new(0.3, move |_| range);
            let (waveform, targets) = (Waveform::chirp(&chirp, duration_s), [target]);
            let laps = (0.5 / duration_s) as u64;
            let samples = (0..laps)
                .flat_map(|lap| {
                    let n = period as usize;
                    receiver.voltages(&waveform, &targets, (lap, 0.0), n, normals(rng))
                })
                .collect();
            let sensor = Sensor::chirp(&chirp, receiver, period as usize / 2, duration_s);
            let beat = rate_hz * sensor.beat(&Target::new(1.0, move |_| range), (1, 0));
            let truth = move |_| vec![signed(iq, beat)];
            Scene { rate_hz, samples, iq, truth: Box::new(truth) }
        }
        "fan" => {
            // A hub that approaches, and blades that come through the beam.
            let (rate_hz, seconds) = (24_000.0, 3.0);
            let (v, turns) = (rng.random_range(3.0..12.0), rng.random_range(20.0..60.0));
            let (depth, phase) = (rng.random_range(0.1..0.5), rng.random::<f64>());
            let target = Target::new(0.3, move |t| 60.0 - v * t);
            let mut samples = doppler(k24, (rate_hz, seconds, false), &[target], snr_db, rng);
            for (k, sample) in samples.iter_mut().enumerate() {
                sample[0] *= 1.0 + depth * (TAU * (turns * k as f64 / rate_hz + phase)).cos();
            }
            let truth = move |_| vec![shift(k24, v)];
            Scene { rate_hz, samples, iq: false, truth: Box::new(truth) }
        }
        "two" => {
            let (rate_hz, seconds) = (24_000.0, 3.0);
            let (v, w) = (rng.random_range(5.0..10.0), rng.random_range(11.0..25.0));
            let level = rng.random_range(0.1..0.8);
            let targets = [
                Target::new(0.3, move |t| 60.0 - v * t),
                Target::new(0.3 * level, move |t| 90.0 - w * t),
            ];
            let samples = doppler(k24, (rate_hz, seconds, iq), &targets, snr_db, rng);
            let truth = move |_| vec![shift(k24, v), shift(k24, w)];
            Scene { rate_hz, samples, iq, truth: Box::new(truth) }
        }
        "slow-fm" => {
            // A target that swings before a radar, by a fraction of its mean shift.
            let (rate_hz, seconds) = (24_000.0, rng.random_range(4.0..8.0));
            let (v, swing) = (rng.random_range(6.0..15.0), rng.random_range(0.3..1.5));
            let (turns, phase) = (rng.random_range(0.2..0.5), rng.random::<f64>());
            let angle = move |t: f64| TAU * (turns * t + phase);
            let depth = swing / (TAU * turns);
            let target = Target::new(0.3, move |t| 90.0 - v * t + depth * angle(t).cos());
            let samples = doppler(k24, (rate_hz, seconds, iq), &[target], snr_db, rng);
            let truth = move |t: f64| vec![shift(k24, v + swing * angle(t).sin())];
            Scene { rate_hz, samples, iq, truth: Box::new(truth) }
        }
        kind => {
            let (rate_hz, seconds) = ([8000.0, 48_000.0][rng.random_range(0..2)], 2.0);
            let v = rng.random_range(0.04..0.4) * rate_hz * LIGHT / 2.0 / k24;
            let target = Target::new(0.3, move |t| 60.0 - v * t);
            let mut samples = doppler(k24, (rate_hz, seconds, iq), &[target], snr_db, rng);
            if kind == "clipped" {
                let rail = rng.random_range(0.4..0.9) * 0.3;
                samples.iter_mut().flatten().for_each(|x| *x = x.clamp(-rail, rail));
            }
            if kind == "flicker" {
                // 1/f by stages an octave apart.
                let mut stages = [[0.0f64; 2]; 12];
                let level = 0.3 * rng.random_range(0.2..0.6);
                for sample in &mut samples {
                    for (octave, stage) in stages.iter_mut().enumerate() {
                        let share = 0.5f64.powi(octave as i32);
                        for (part, x) in stage.iter_mut().zip(sample.iter_mut()) {
                            let normal: f64 = rng.sample(StandardNormal);
                            *part += share * -*part + (share * (2.0 - share)).sqrt() * normal;
                            *x += level / 4.0 * *part;
                        }
                    }
                }
            }
            let truth = move |_| vec![shift(k24, v)];
            Scene { rate_hz, samples, iq, truth: Box::new(truth) }
        }
    }
}

fn npy(kind: &str, shape: &str, data: Vec<u8>) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}\n");
    [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &data]
        .concat()
}

/// Writes the samples in one of ten formats; gives the file's name, and what a person types of it.
fn write(folder: &Path, index: usize, format: usize, scene: &Scene) -> (String, Vec<String>) {
    let Scene { rate_hz, samples, iq, .. } = scene;
    let parts = if *iq { 2 } else { 1 };
    let full = samples.iter().flatten().fold(1e-9f64, |most, x| most.max(x.abs())) / 0.8;
    let flat = || samples.iter().flat_map(|x| x[..parts].to_vec());
    let integers = |most: f64| flat().map(move |x| (most * x / full).round());
    let rate = vec!["--rate".to_owned(), rate_hz.to_string()];
    let pairs = if *iq { vec!["--iq".to_owned()] } else { vec![] };
    let (suffix, bytes, options): (&str, Vec<u8>, Vec<String>) = match format {
        0..=2 => {
            let path = folder.join(format!("{index}.wav"));
            let bits = [16, 24, 32][format];
            let spec = hound::WavSpec {
                channels: parts as u16,
                sample_rate: *rate_hz as u32,
                bits_per_sample: bits,
                sample_format: if bits == 32 {
                    hound::SampleFormat::Float
                } else {
                    hound::SampleFormat::Int
                },
            };
            let mut writer = hound::WavWriter::create(&path, spec).unwrap();
            match bits {
                32 => flat().for_each(|x| writer.write_sample(x as f32).unwrap()),
                bits => integers((1u32 << (bits - 1)) as f64 - 1.0)
                    .for_each(|x| writer.write_sample(x as i32).unwrap()),
            }
            writer.finalize().unwrap();
            return (format!("{index}.wav"), pairs);
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
fn judged(lines: &str, scene: &Scene) -> (usize, usize) {
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
        let near = |truth: &f64| (hz - truth).abs() <= 3.0 * sigma;
        usable += 1;
        right += usize::from((scene.truth)(time).iter().any(near));
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
    rng: &mut ChaCha8Rng,
) -> Outcome {
    let scene = scene(kind, snr_db, rng);
    let format = rng.random_range(0..10);
    let (name, options) = write(folder, index, format, &scene);
    let look = picket(folder, &[vec!["analyze".into(), name.clone()], options].concat());
    let proposed = look.lines().find_map(|line| line.strip_prefix("try       picket "));
    let Some(proposed) = proposed else {
        assert!(
            look.contains("nothing that was tried") || look.contains("nothing stands out"),
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
    let mut rng = ChaCha8Rng::seed_from_u64(seed(44));
    let folder = folder("sixty");
    let outcomes: Vec<Outcome> = (0..RECORDINGS)
        .map(|index| outcome(&folder, index, KINDS[index % KINDS.len()], None, &mut rng))
        .collect();
    let count = |wanted: Outcome| outcomes.iter().filter(|&&outcome| outcome == wanted).count();
    let [right, unknown, wrong] = [Outcome::Right, Outcome::Unknown, Outcome::Wrong].map(count);
    println!("{right} right, {unknown} not known, {wrong} wrong of {RECORDINGS}");
    // A walker whose shift lies at the mains' harmonics is not known. Of 17 answers beside a second tone one is 3 sigma off, which is more
    // than 5 %.
    assert!(right >= 54 && wrong <= 2, "{right} right, {unknown} not known, {wrong} wrong");
}

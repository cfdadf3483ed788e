//! What the page is given: recordings, damaged ones, and what a board and a stranger say.

use super::RATE_HZ;
use fixed::types::I0F32;
use heapless::Vec;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene as Seen};
use picket_dsp::frame::{Cells, Frame};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict};
use picket_dsp::{Chirp, Iq, Mixing, Pipeline, Plan, Shape};
use picket_simulator::{Run, Scene};
use picket_wire::boot::{Boot, Name};
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::command::{Answer, Command};
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;
use picket_wire::settings::{Drive, Mode, Settings};
use picket_wire::status::Raw;
use serde_json::json;
use std::fs;
use std::path::PathBuf;

const SESSION: &[u8] = include_bytes!("../../../docs/session.bin");

/// The block of the session's last record.
const LAST: u32 = 29;

/// A block of seeded noise about a tone, by integers and a sine: codes of 16 bits.
fn recording(samples: usize, iq: bool) -> std::vec::Vec<i16> {
    let mut state = 0x1234_5678_9ABC_DEF1u64;
    let mut noise = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        ((state >> 40) as i32 - (1 << 23)) as f64 / f64::from(1 << 23) * 900.0
    };
    let sample = |n: usize| {
        // It rises slowly, and swells until it clips.
        let turns = std::f64::consts::TAU * (0.0731 + 2e-8 * n as f64) * n as f64;
        let level = 2000.0 + 36_000.0 * n as f64 / samples as f64;
        [level * turns.cos(), level * turns.sin()]
    };
    let parts = (0..samples).flat_map(|n| sample(n).into_iter().take(if iq { 2 } else { 1 }));
    // A cast saturates.
    parts.map(|x| (x + noise()).round() as i16).collect()
}

fn bytes_of(samples: &[i16]) -> std::vec::Vec<u8> {
    samples.iter().flat_map(|sample| sample.to_le_bytes()).collect()
}

/// A wav file.
fn wav(channels: u16, samples: &[i16]) -> std::vec::Vec<u8> {
    let data = bytes_of(samples);
    let size = data.len() as u32;
    let rate = RATE_HZ as u32;
    let mut file = b"RIFF".to_vec();
    file.extend((36 + size).to_le_bytes());
    file.extend(b"WAVEfmt \x10\0\0\0\x01\0");
    file.extend(channels.to_le_bytes());
    file.extend([rate, 2 * u32::from(channels) * rate].map(u32::to_le_bytes).concat());
    file.extend((2 * channels).to_le_bytes());
    file.extend(b"\x10\0data");
    file.extend(size.to_le_bytes());
    file.extend(data);
    file
}

/// Two tones of a block.
pub fn lines() -> Lines {
    let tone = |cycles: f64, amplitude: f32, verdict: Verdict| ToneWithPhase {
        tone: Tone {
            frequency: Frequency(I0F32::from_num(cycles)),
            sigma: 2e-6,
            snr: 10.0,
            amplitude,
            verdict,
            ..Tone::default()
        },
        phase: -1.25,
        sigma_phase: 0.02,
    };
    let two = [tone(0.1, 1000.0, Verdict::Good), tone(-0.2, 100.0, Verdict::Moving)];
    Lines::from_tones(&Stamp { sequence: LAST, ..Stamp::default() }, Vec::from_slice(&two).unwrap())
}

fn fundamental() -> Fundamental {
    let frequency = Frequency(I0F32::from_num(0.0002));
    let tone =
        Tone { frequency, sigma: 4e-8, snr: 10.0, verdict: Verdict::Good, ..Tone::default() };
    Fundamental::from_harmonic(
        &Stamp { sequence: LAST, ..Stamp::default() },
        Harmonic { tone, orders: 7 },
    )
}

/// What a board said, with two records lost and a frame damaged on the way, and one block of samples behind.
pub fn session() -> std::vec::Vec<u8> {
    let frames: std::vec::Vec<&[u8]> = SESSION.split_inclusive(|&byte| byte == 0).collect();
    let kept = frames.iter().enumerate().filter(|(number, _)| ![10, 11].contains(number));
    let mut bytes: std::vec::Vec<u8> = kept.flat_map(|(_, frame)| frame.to_vec()).collect();
    bytes.extend([3, 1, 4, 1, 5, 0]);
    bytes.extend(lines().to_frame());
    bytes.extend(fundamental().to_frame());
    // 1024 pairs of samples.
    for (offset, piece) in bytes_of(&recording(1024, true)).chunks(Raw::PIECE).enumerate() {
        let raw = Raw {
            sequence: 31,
            offset: (offset * Raw::PIECE) as u16,
            bytes: piece.try_into().unwrap(),
        };
        bytes.extend(raw.to_frame());
    }
    bytes
}

/// What a Doppler radar at 24 GHz has in 200 blocks of a target that approaches and swings; six blocks are silent.
fn swing() -> std::vec::Vec<u8> {
    let mut state = 9u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 16) / 65.536 - 500.0
    };
    let sample = |index: usize| {
        let turns = |hertz: f64| std::f64::consts::TAU * hertz * index as f64 / RATE_HZ;
        let range_m =
            50e-6 * turns(5.0).sin() + 20e-6 * turns(11.0).cos() - 2.0 * index as f64 / RATE_HZ;
        let phase = -2.0 * range_m * 24e9 / SPEED_OF_LIGHT * std::f64::consts::TAU;
        let level = if (160..166).contains(&(index / 1024)) { 0.0 } else { 1.0 };
        [phase.cos(), phase.sin()].map(|part| level * (3000.0 * part + noise()))
    };
    let parts = (0..200 * 1024).flat_map(sample);
    parts.flat_map(|part| (part.round() as i16).to_le_bytes()).collect()
}

/// Samples of a chirp's record, and the chirps of two frames.
pub const RECORD: usize = 256;
/// See there.
pub const CHIRPS: usize = 128;

/// A radar at 77 GHz in front of two targets, at levels that no chirp shows.
pub fn radar() -> Run {
    let target = |range_m: f64, velocity_mps: f64, amplitude: f64| json!({"target": {"range_m": range_m, "velocity_mps": velocity_mps, "amplitude": amplitude, "phase_turns": 0}});
    let scene = json!({
        "seed": 66, "rate_hz": 2.56e6, "seconds": (CHIRPS + 1) as f64 * 120e-6,
        "waveform": {"shape": "sawtooth", "carrier_hz": 77e9, "bandwidth_hz": 306e6, "ramp_s": 102e-6, "guard_s": 2e-6,
            "period_s": 120e-6, "samples": RECORD},
        "sources": [target(18.0, 3.0, 60.0), target(24.0, -5.0, 30.0)],
        "receiver": {"iq": true, "noise": {"snr_db": -8.0}},
    });
    serde_json::from_value::<Scene>(scene).unwrap().run(0).unwrap()
}

/// What it records, as an array of two frames of complex numbers.
fn cube() -> std::vec::Vec<u8> {
    let header = format!(
        "{{'descr': '<c8', 'fortran_order': False, 'shape': (2, {}, {RECORD}), }}\n",
        CHIRPS / 2
    );
    let mut run = radar();
    let codes = (0..CHIRPS).flat_map(|index| run.record(index, RECORD)).flatten();
    let data = codes.flat_map(|code| f32::from(code).to_le_bytes()).collect::<std::vec::Vec<u8>>();
    [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &data]
        .concat()
}

/// A frame and its targets, as a board tells of them.
pub type Told = (ChirpFrame, std::vec::Vec<Found>);

/// What a board with that radar tells of three frames: two of its two targets, and one of noise.
pub fn told() -> (Settings, std::vec::Vec<Told>) {
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        mixing: Mixing::TxConjRx,
        wavelength_m: SPEED_OF_LIGHT / 77e9,
        bandwidth_hz: 306e6,
        duration_s: 102e-6,
        guard_s: 2e-6,
        ..Chirp::default()
    };
    let scene = Seen::Chirp(chirp);
    let config = Config {
        scene,
        velocity_mps: Some((-8.0, 8.0)),
        ..Config::new(2.56e6, Codes::signed::<16>())
    };
    let (count, period_s) = (CHIRPS / 2, 120e-6);
    let mode = Mode::Frames { chirps: count as u16, period_s: Some(period_s) };
    let settings = Settings {
        iq: true,
        guard: 5,
        drive: Drive::External,
        mode,
        config,
        ..Settings::default()
    };
    let plan = settings.frames(RECORD).unwrap().unwrap();
    let mut cells = std::vec![[0i16; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Narrow(&mut cells)).unwrap();
    let mut pipeline = Pipeline::<Iq, RECORD>::new(Plan::tone(config.rate_hz, config.codes));
    let mut run = radar();
    let mut state = 5u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 21) as i16 - 1024
    };
    let told = (0..3).map(|number: usize| {
        for index in 0..count {
            let clipped = match number {
                2 => pipeline.look(&std::array::from_fn(|_| [noise(), noise()])),
                _ => {
                    let record = run.record(number * count + index, RECORD);
                    pipeline.look(record.as_array().unwrap())
                }
            };
            frame.push(&pipeline.spectrum().view(), clipped);
        }
        let targets = frame.targets();
        let sequence = (2 * number * count) as u32;
        let clock = (f64::from(sequence) * period_s * config.rate_hz) as u64;
        let stamp = Stamp { sequence, clock, segment: Segment::Up, gap: number == 0 };
        let frame = ChirpFrame {
            number: number as u32,
            stamp,
            chirps: count as u16,
            passed: if number == 0 { 0 } else { count as u32 },
            targets: targets.len() as u8,
            search_s: 0.0072,
            rate_hz: config.rate_hz,
            period_s,
            ..ChirpFrame::default()
        };
        let found = targets.iter().zip(0..);
        let found = found.map(|(&found, place)| Found { frame: number as u32, place, found });
        (frame, found.collect())
    });
    (settings, told.collect())
}

/// So many of the frames as bytes, behind the board's name and its settings.
fn frames(most: usize) -> std::vec::Vec<u8> {
    let (settings, told) = told();
    let (board, n) = (Name::new("nucleo-f446re"), RECORD as u32);
    let boot = Boot { board, n, core_hz: 180_000_000, measuring: true, ..Boot::default() };
    let reply = Answer { tag: 2, command: Command::GetSettings.number() };
    let mut bytes = boot.to_frame().to_vec();
    bytes.extend(reply.reply(&settings.to_bytes(RECORD)));
    for (frame, found) in told.iter().take(most) {
        bytes.extend(frame.to_frame());
        found.iter().for_each(|found| bytes.extend(found.to_frame()));
    }
    bytes
}

/// A folder with all of it.
pub fn inputs() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("page");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).unwrap();
    let real = recording(100_000, false);
    let iq = recording(40_000, true);
    write("good-tone.wav", &wav(1, &real));
    write("good-iq.i16", &bytes_of(&iq));
    write("two-channels.wav", &wav(2, &iq));
    write("cube.npy", &cube());
    write("picket-pico.uf2", &picket_host::pico::flash::uf2(&[0x5A; 1000]));
    write("swing-iq.i16", &swing());
    let lines: String = real.iter().take(20_000).map(|sample| format!("{sample}\n")).collect();
    write("good-column.csv", lines.as_bytes());
    let whole = wav(1, &real);
    write("bad-truncated.wav", &whole[..whole.len() / 2]);
    write("bad-silence.wav", &wav(1, &[0; 4096]));
    write("bad-stranger.wav", &bytes_of(&real)[..5000]);
    write("bad-empty.wav", &[]);
    write("bare.i16", &bytes_of(&real[..30_000]));
    // Codes of 12 bits that count from 0, and floats whose name tells nothing.
    let codes = |&x: &i16| ((i32::from(x) >> 5) + 2048) as u16;
    let adc: std::vec::Vec<u8> =
        real[..30_000].iter().map(codes).flat_map(u16::to_le_bytes).collect();
    write("bare-adc.u16", &adc);
    let floats = real[..30_000].iter().map(|&x| f32::from(x) / 32768.0);
    write("bare.dat", &floats.flat_map(f32::to_le_bytes).collect::<std::vec::Vec<u8>>());
    write("bad-short.wav", &wav(1, &real[..300]));
    write("bad-name.xyz", b"stranger");
    write("bad-chunk.wav", b"RIFF\xff\xff\xff\xffWAVEJUNK\xff\xff\xff\xffdata\0\0\0\0");
    write("session.bin", &session());
    write("frames.bin", &frames(2));
    write("frames-none.bin", &frames(3));
    // A modem's words, and no zero among them.
    write("stranger.bin", "AT+CGMI OK ".repeat(60).as_bytes());
    folder
}

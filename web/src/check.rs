//! Random blocks through the page's own stations, and a scene of the simulator: what is measured of the first and the samples of the second
//! must be the same to the bit as on every other machine.

#[path = "../../dependents/same_bits.rs"]
pub mod same_bits;

use crate::station::Station;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::{Arithmetic, Codes, Config};
use picket_simulator::scene::{
    Change, Converter, Density, Hum, Noise, Particles, Receiver, Source,
};
use picket_simulator::scene::{Target, Vibration, Waveform};
use picket_simulator::{Scene, Value};
pub use same_bits::Seen;
use same_bits::{Random, fill, hashed};

/// Blocks of each length in a round.
const ROUND: [(usize, u32); 7] =
    [(64, 300), (128, 300), (256, 300), (512, 300), (1024, 300), (2048, 100), (4096, 50)];

/// Measures at least this many blocks, real ones and I/Q in turn, of 64 to 4096 samples.
pub fn checksum(fixed: bool, blocks: u32) -> Seen {
    let mut seen = Seen { blocks: 0, checksum: 0xCBF2_9CE4_8422_2325, good: 0 };
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let mut rounds = ROUND.iter().cycle();
    while seen.blocks < blocks
        && let Some(&(n, times)) = rounds.next()
    {
        measure::<Real>(fixed, n, times, &mut random, &mut seen);
        measure::<Iq>(fixed, n, times, &mut random, &mut seen);
    }
    seen
}

fn measure<R: Record>(fixed: bool, n: usize, blocks: u32, random: &mut Random, seen: &mut Seen) {
    let codes = Codes::signed::<12>();
    let arithmetic = if fixed { Arithmetic::Fixed } else { Arithmetic::Float };
    let config = Config { arithmetic, ..Config::new(48_000.0, codes) };
    let Ok(mut station) = Station::from_config(&config, R::IQ, n, 2047.5) else { return };
    let mut samples = vec![R::Sample::default(); n];
    for sequence in 0..blocks {
        fill::<R>(&mut samples, codes, random);
        let parts: Vec<[i16; 2]> = samples.iter().map(|&sample| R::parts(sample)).collect();
        let stamp = Stamp { sequence, ..Stamp::default() };
        let Some(measurement) = station.block(stamp, &parts) else { continue };
        let tone = measurement.tone;
        seen.blocks += 1;
        seen.good += u32::from(tone.verdict == picket_dsp::Verdict::Good);
        let [sigma, snr, amplitude] = [tone.sigma, tone.snr, tone.amplitude].map(f32::to_bits);
        let frequency = tone.frequency.0.to_bits() as u32;
        for word in [frequency, sigma, snr, amplitude, tone.verdict as u32] {
            seen.checksum = hashed(seen.checksum, word);
        }
    }
}

/// Two targets before a radar whose wave wanders, one braking and rough and one that swings, beside particles in a flow that reverses; with
/// mains hum, pink noise behind a filter, and a converter that is bent, jitters and wraps.
pub fn scene() -> Scene {
    let car = Target {
        range_m: 40.0.into(),
        velocity_mps: Value::Over(vec![[0.0, 14.0], [0.05, 14.0], [0.1, 2.0]]),
        amplitude: Some(400.0.into()),
        amplitude_at_m: Some(40.0),
        spot_m: Some(0.3),
        ..Target::default()
    };
    let plate = Target {
        range_m: (2.0..3.0).into(),
        level_db: Some((-6.0).into()),
        vibration: vec![Vibration {
            amplitude_m: 1e-3.into(),
            frequency_hz: 30.0.into(),
            phase_turns: (0.0..1.0).into(),
        }],
        changes: vec![Change::Walk { linewidth_hz: 3.0.into() }],
        ..Target::default()
    };
    let flow = Particles {
        velocity_mps: Value::Over(vec![[0.0, 1.0], [0.2, -1.0]]),
        turbulence_mps: 0.1,
        per_m: 500.0,
        level_db: Some((-3.0).into()),
        shift_hz: 2e3,
        sizes: 0.4,
        ..Particles::default()
    };
    let hum = Hum {
        frequency_hz: 50.0.into(),
        amplitude: 60.0.into(),
        harmonics: vec![[3.0, -10.0]],
        phase_turns: None,
        direction_turns: None,
    };
    let receiver = Receiver {
        iq: true,
        gain_error: 0.03.into(),
        quadrature_rad: 0.02.into(),
        hum: vec![hum],
        noise: Noise {
            rms: Some(20.0.into()),
            shape: vec![Density::Flicker { power: 0.5.into() }],
            ..Noise::default()
        },
        low_pass_hz: vec![8e3],
        ..Receiver::default()
    };
    let converter = Converter {
        bits: 10,
        wraps: true,
        inl_codes: 3.0.into(),
        jitter_s: 1e-7,
        ..Converter::default()
    };
    let waveform = Waveform { carrier_hz: 24e9, linewidth_hz: 1e4, ..Waveform::default() };
    Scene {
        seed: 7,
        rate_hz: 20e3,
        seconds: 0.2,
        waveform: Some(waveform),
        sources: vec![Source::Target(car), Source::Target(plate), Source::Particles(flow)],
        receiver,
        converter,
        ..Scene::default()
    }
}

/// The checksum of its codes.
///
/// # Errors
/// Why the scene cannot be.
pub fn scene_checksum() -> Result<u64, String> {
    let codes = scene().codes(0)?;
    let word = |[i, q]: [i16; 2]| u32::from(i as u16) << 16 | u32::from(q as u16);
    Ok(codes.into_iter().map(word).fold(0xCBF2_9CE4_8422_2325, hashed))
}

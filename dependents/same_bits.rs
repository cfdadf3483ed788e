//! The same blocks on every machine: what is measured of them must be the same to the bit.
//!
//! The samples are made by integers alone, so that a difference is the library's.

use picket_dsp::acquire::sample::Record;
use picket_dsp::{Arithmetic, Codes, Config, Effort, Iq, Method, Pipeline, Real, Stamp};

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Blocks measured.
    pub blocks: u32,
    /// FNV-1a of every tone's frequency, sigma, signal-to-noise ratio, amplitude and verdict.
    pub checksum: u64,
    /// Tones whose verdict is good.
    pub good: u32,
}

/// Measures 10,000 blocks: real ones and I/Q, of 64 to 4096 samples, every second by least squares with every effort in turn, the others by
/// every method in turn.
pub fn same_bits(arithmetic: Arithmetic) -> Seen {
    let mut seen = Seen { blocks: 0, checksum: 0xCBF2_9CE4_8422_2325, good: 0 };
    measure::<Real, 64>(3000, arithmetic, &mut seen);
    measure::<Iq, 128>(3000, arithmetic, &mut seen);
    measure::<Real, 256>(2000, arithmetic, &mut seen);
    measure::<Iq, 512>(1300, arithmetic, &mut seen);
    measure::<Real, 1024>(600, arithmetic, &mut seen);
    measure::<Iq, 4096>(100, arithmetic, &mut seen);
    seen
}

fn measure<R: Record, const N: usize>(blocks: u32, arithmetic: Arithmetic, seen: &mut Seen) {
    let codes = Codes::signed::<12>();
    let config = Config { arithmetic, ..Config::new(48_000.0, codes) };
    let fits = |method: &Method| method.fits::<R>();
    let mut efforts = Effort::ALL.iter().copied().cycle();
    let mut methods = Method::ALL.iter().copied().filter(fits).cycle();
    let Ok(plan) = config.plan() else { return };
    let mut pipeline = Pipeline::<R, N>::new(plan);
    let mut random = Random(0x2545_F491_4F6C_DD1D ^ N as u64);
    let mut samples = [R::Sample::default(); N];
    for block in 0..blocks {
        let method = if block % 2 == 0 { Some(Method::default()) } else { methods.next() };
        let effort = if block % 2 == 0 { efforts.next() } else { Some(Effort::LOOK) };
        let (Some(method), Some(effort)) = (method, effort) else { return };
        let Ok(plan) = Config { method, effort, ..config }.plan() else { return };
        pipeline.set_plan(plan);
        fill::<R>(&mut samples, codes, &mut random);
        let tone = pipeline.block(&Stamp::default(), &samples).tone;
        seen.blocks += 1;
        seen.good += u32::from(tone.verdict == picket_dsp::Verdict::Good);
        let floats = [tone.sigma, tone.snr, tone.amplitude].map(f32::to_bits);
        let [sigma, snr, amplitude] = floats;
        let frequency = tone.frequency.0.to_bits() as u32;
        for word in [frequency, sigma, snr, amplitude, tone.verdict as u32] {
            seen.checksum = hashed(seen.checksum, word);
        }
    }
}

/// A step of FNV-1a.
pub fn hashed(checksum: u64, word: u32) -> u64 {
    let step = |sum: u64, byte: u8| (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
    word.to_le_bytes().into_iter().fold(checksum, step)
}

/// A tone anywhere, of any strength, in noise of any strength; some clip, and one in 64 holds nothing.
pub fn fill<R: Record>(samples: &mut [R::Sample], codes: Codes, random: &mut Random) {
    let (low, high) = codes.rails();
    let step = random.next();
    let mut phase = random.next();
    let amplitude = 3000 >> random.below(11);
    let noise = 1 << random.below(11);
    let offset = random.below(400) as i32 - 200;
    let nothing = random.below(64) == 0;
    for sample in samples {
        let mut part = |phase: u32| {
            let tone = (amplitude * sine(phase)) >> 15;
            let noise = random.below(2 * noise) as i32 - noise as i32;
            let code = if nothing { offset } else { offset + tone + noise };
            code.clamp(low.into(), high.into()) as i16
        };
        *sample = R::from_parts([part(phase.wrapping_add(1 << 30)), part(phase)]);
        phase = phase.wrapping_add(step);
    }
}

/// The sine of `phase` of 2^32 parts of a turn, full scale 2^15, to 2^-12: a polynomial of the fifth order on half a turn, whose
/// slope is 0 at both ends.
fn sine(phase: u32) -> i32 {
    // Quarters of a turn, -2..2, folded to -1..1; one quarter is 2^15.
    let quarters = (phase as i32) >> 15;
    let z = match quarters {
        32_769.. => 65_536 - quarters,
        ..-32_768 => -65_536 - quarters,
        _ => quarters,
    };
    // z (pi - z^2 ((2 pi - 5) - z^2 (pi - 3))) / 2, coefficients times 2^15.
    let z = i64::from(z);
    let square = (z * z) >> 15;
    let inner = 42_047 - ((square * 4_640) >> 15);
    ((z * (102_944 - ((square * inner) >> 15))) >> 16).clamp(-32_768, 32_767) as i32
}

/// Marsaglia's xorshift, 64 bits (2003), its upper half.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    fn below(&mut self, bound: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(bound)) >> 32) as u32
    }
}

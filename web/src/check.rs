//! Random blocks through the page's own stations: what is measured of them must be the same to the bit as on every other machine.

#[path = "../../dependents/same_bits.rs"]
pub mod same_bits;

use crate::station::from_config;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::{Arithmetic, Codes, Config};
pub use same_bits::Seen;
use same_bits::{Random, fill, hashed};

/// Blocks of each length in a round.
const ROUND: [(usize, u32); 3] = [(1024, 600), (2048, 100), (4096, 50)];

/// Measures at least so many blocks, real ones and I/Q in turn, of 1024 to 4096 samples.
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
    let Ok(mut station) = from_config(&config, R::IQ, n, 2047.5) else { return };
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

//! Measures the records of a file by every default, and prints a line for each kind of answer: how many, how many of them good, and
//! a checksum of every bit. It must be the same whatever features the library has.
//!
//! A record of the file: a byte that says I/Q, a byte with the power of two of its length, a byte with the bits of its codes, then its
//! samples, two bytes each, the lower one first; those of I/Q in pairs.

use picket_dsp::acquire::sample::Record;
use picket_dsp::tone::harmonic::HIGHEST;
use picket_dsp::tone::lines::MOST;
use picket_dsp::{
    Arithmetic, Codes, Config, Effort, FrequencyOnly, Iq, Measurement, Pipeline, Plan, Real, Stamp,
    Tone, Verdict,
};
use std::collections::BTreeMap;

/// The feature wants a logger, which nobody asks.
#[cfg(feature = "defmt")]
mod silent {
    #[defmt::global_logger]
    struct Silent;

    // SAFETY: it writes nothing.
    unsafe impl defmt::Logger for Silent {
        fn acquire() {}
        unsafe fn flush() {}
        unsafe fn release() {}
        unsafe fn write(_: &[u8]) {}
    }

    defmt::timestamp!("");
}

/// What was answered.
struct Seen {
    answers: u32,
    good: u32,
    /// FNV-1a.
    checksum: u64,
}

#[derive(Default)]
struct Answers(BTreeMap<&'static str, Seen>);

impl Answers {
    fn add(&mut self, name: &'static str, words: &[u32], good: bool) {
        let new = Seen { answers: 0, good: 0, checksum: 0xCBF2_9CE4_8422_2325 };
        let seen = self.0.entry(name).or_insert(new);
        seen.answers += 1;
        seen.good += u32::from(good);
        for byte in words.iter().flat_map(|word| word.to_le_bytes()) {
            seen.checksum = (seen.checksum ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
        }
    }

    fn add_tone(&mut self, name: &'static str, tone: &Tone) {
        let [sigma, snr, amplitude] = [tone.sigma, tone.snr, tone.amplitude].map(f32::to_bits);
        let frequency = tone.frequency.0.to_bits() as u32;
        let words = [frequency, sigma, snr, amplitude, tone.verdict as u32];
        self.add(name, &words, tone.verdict == Verdict::Good);
    }

    fn measure<R: Record, const N: usize>(&mut self, samples: &[R::Sample], codes: Codes) {
        let Ok(samples) = <&[R::Sample; N]>::try_from(samples) else { return };
        for (name, arithmetic) in [("float", Arithmetic::Float), ("fixed", Arithmetic::Fixed)] {
            // The rounds of the joint fit are what its feature adds.
            let effort = Effort::LOOK;
            let config = Config { arithmetic, effort, ..Config::new(48e3, codes) };
            let Ok(plan) = config.plan() else { return };
            let mut pipeline = Pipeline::<R, N>::new(plan);
            let measurement = pipeline.block(&Stamp::default(), samples);
            self.add_tone(name, &measurement.tone);
            self.add_others(&pipeline, &measurement);
        }
        let plan = Plan::<R, N>::tone(48e3, codes);
        let (_, tone) = Pipeline::<R, N>::new(plan).tone(&Stamp::default(), samples);
        self.add_tone("default plan", &tone);
        if let Some(line) = FrequencyOnly::<R, N>::new().block(samples, codes) {
            let words = [line.frequency.0.to_bits() as u32, line.sigma.to_bits()];
            self.add("frequency only", &words, false);
        }
    }

    fn add_others<R: Record, const N: usize>(
        &mut self,
        pipeline: &Pipeline<R, N>,
        measurement: &Measurement,
    ) {
        for phasor in pipeline.lines(measurement, MOST) {
            self.add_tone("lines", &phasor.tone);
        }
        if let Some(harmonic) = pipeline.harmonic(measurement, HIGHEST) {
            self.add_tone("harmonic", &harmonic.tone);
        }
        if let Some(rise) = pipeline.rise(measurement) {
            self.add("rise", &[rise.cycles.to_bits(), rise.sigma.to_bits()], false);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("a file of records, please")?;
    let file = std::fs::read(path)?;
    let (mut rest, mut answers) = (&*file, Answers::default());
    while let Some((&[iq, log_n, bits], after)) = rest.split_first_chunk() {
        let (iq, n) = (iq != 0, 1usize << log_n);
        let codes = match bits {
            12 => Codes::signed::<12>(),
            16 => Codes::signed::<16>(),
            _ => return Err("these bits are not expected".into()),
        };
        let Some((samples, after)) = after.split_at_checked(n * if iq { 4 } else { 2 }) else {
            return Err("the file ends within a record".into());
        };
        rest = after;
        let words: Vec<i16> =
            samples.as_chunks().0.iter().map(|&word| i16::from_le_bytes(word)).collect();
        let pairs: Vec<<Iq as Record>::Sample> =
            words.as_chunks().0.iter().map(|&pair| Iq::from_parts(pair)).collect();
        match (iq, n) {
            (false, 128) => answers.measure::<Real, 128>(&words, codes),
            (false, 256) => answers.measure::<Real, 256>(&words, codes),
            (false, 1024) => answers.measure::<Real, 1024>(&words, codes),
            (true, 128) => answers.measure::<Iq, 128>(&pairs, codes),
            (true, 256) => answers.measure::<Iq, 256>(&pairs, codes),
            (true, 1024) => answers.measure::<Iq, 1024>(&pairs, codes),
            _ => return Err("this length is not expected".into()),
        }
    }
    for (name, Seen { answers, good, checksum }) in answers.0 {
        println!("{name}: {answers}, {good} good, {checksum:016x}");
    }
    Ok(())
}

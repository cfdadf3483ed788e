//! Seeded records of tones in noise, as a converter would deliver them.
//!
//! Signal-to-noise ratios follow one convention: `A^2 / (2 sigma^2)` for a real tone, `a^2 / E|z|^2` for a
//! complex one, both per sample. A trial's noise depends on nothing but the seed and the trial's
//! number, so the order in which threads take trials does not matter.

use num_complex::Complex;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_simulator::Scene;
use picket_simulator::scene::{Source, Tone};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// A kind of record with a name.
pub trait Kind: Record {
    /// The name that flags and tables use.
    const NAME: &'static str;
}

impl Kind for Real {
    const NAME: &'static str = "real";
}

impl Kind for Iq {
    const NAME: &'static str = "complex";
}

/// What the converter makes of a voltage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Rounded to codes and clipped at their rails.
    Codes(Codes),
    /// Neither rounded nor clipped.
    Float,
}

impl Width {
    /// Output code range; float converters use 16-bit codes.
    pub const fn codes(self) -> Codes {
        match self {
            Width::Codes(codes) => codes,
            Width::Float => Codes::signed::<16>(),
        }
    }

    /// The sample delivered for a value in codes.
    pub fn convert(self, value: f64) -> f64 {
        match self {
            Width::Float => value,
            Width::Codes(codes) => {
                let (low, high) = codes.rails();
                value.round().clamp(low.into(), high.into())
            }
        }
    }
}

/// One spectral line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Cycles per record; negative for an I/Q line that turns backwards.
    pub bins: f64,
    /// Amplitude in codes.
    pub amplitude: f64,
    /// Phase at the first sample in radians, `None` for a new random one in each record.
    pub phase: Option<f64>,
}

/// What a record holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The lines; the first one is what the signal-to-noise ratio refers to.
    pub lines: Vec<Line>,
    /// Signal-to-noise ratio of the first line in dB; infinite for no noise.
    pub snr_db: f64,
    /// Constant offset in codes, of the sample and its quadrature part.
    pub dc: [f64; 2],
    /// What the converter makes of it.
    pub width: Width,
}

impl Signal {
    /// A single tone of random phase, without offset, delivered in signed 12-bit codes.
    pub fn tone(bins: f64, amplitude: f64, snr_db: f64) -> Self {
        Signal {
            lines: vec![Line { bins, amplitude, phase: None }],
            snr_db,
            dc: [0.0; 2],
            width: Width::Codes(Codes::signed::<12>()),
        }
    }

    /// The standard deviation of the noise in each part of a sample, in codes.
    pub fn sigma(&self) -> f64 {
        let amplitude = self.lines.first().map_or(0.0, |line| line.amplitude);
        amplitude / (2.0 * 10f64.powf(self.snr_db / 10.0)).sqrt()
    }

    /// The scene of `n` samples: a hertz is a bin, a second a record.
    pub fn scene(&self, iq: bool, n: usize) -> Scene {
        let source = |line: &Line| {
            let mut tone = Tone {
                frequency_hz: line.bins.into(),
                amplitude: Some(line.amplitude.abs().into()),
                ..Tone::default()
            };
            if let Some(phase) = line.phase {
                let turned = if line.amplitude < 0.0 { 0.5 } else { 0.0 };
                tone.phase_turns = (phase / TAU + turned).into();
            }
            Source::Tone(tone)
        };
        let sources = self.lines.iter().map(source).collect();
        let mut scene = Scene { rate_hz: n as f64, seconds: 1.0, sources, ..Scene::default() };
        scene.receiver.iq = iq;
        scene.receiver.offset = self.dc.map(Into::into);
        scene.receiver.noise.rms = Some(self.sigma().into());
        scene
    }

    /// A record as numbers, in codes; real records have no imaginary part. Where a number is none, it is silent.
    pub fn record<R: Kind>(&self, n: usize, rng: &mut ChaCha8Rng) -> Vec<Complex<f64>> {
        let scene = Scene { seed: rng.random(), ..self.scene(R::IQ, n) };
        let voltages =
            scene.run(0).map_or_else(|_| vec![[0.0; 2]; n], |mut run| run.voltages(0.0, n));
        let convert = |[re, im]: [f64; 2]| {
            let im = if R::IQ { self.width.convert(im) } else { 0.0 };
            Complex::new(self.width.convert(re), im)
        };
        voltages.into_iter().map(convert).collect()
    }

    /// A record as the converter's codes.
    pub fn codes<R: Kind>(&self, n: usize, rng: &mut ChaCha8Rng) -> Vec<R::Sample> {
        codes::<R>(&self.record::<R>(n, rng))
    }
}

/// Numbers rounded to codes; what does not fit 16 bits ends at the rails.
pub fn codes<R: Kind>(record: &[Complex<f64>]) -> Vec<R::Sample> {
    record.iter().map(|&x| code::<R>(x)).collect()
}

/// A number rounded to a code, as [`codes`] has it.
#[inline(always)]
pub fn code<R: Kind>(x: Complex<f64>) -> R::Sample {
    R::from_parts([nearest(x.re), if R::IQ { nearest(x.im) } else { 0 }])
}

/// As `x.round() as i16`. The function `round` would be a call for each number, unless the compiler may use a new processor.
#[inline(always)]
fn nearest(x: f64) -> i16 {
    /// A sum with it is rounded to whole numbers, a half to the even one, and ends in the bits of that number.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let x = if x.is_nan() { 0.0 } else { x.clamp(i16::MIN.into(), i16::MAX.into()) };
    let even = (x + WHOLE) - WHOLE;
    let rest = x - even;
    let up = if rest >= 0.5 && x > 0.0 { 1.0 } else { 0.0 };
    let down = if rest <= -0.5 && x < 0.0 { 1.0 } else { 0.0 };
    ((even + up - down) + WHOLE).to_bits() as i16
}

/// The generator of trial `trial` under `seed`.
pub fn generator(seed: u64, trial: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(trial);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    fn power(record: &[Complex<f64>]) -> f64 {
        record.iter().map(|x| x.norm_sqr()).sum::<f64>() / record.len() as f64
    }

    #[test]
    fn noise_has_the_power_that_the_ratio_says() {
        // Seed 1; 2^18 samples put the power within 1 %.
        let mut signal = Signal::tone(0.0, 100.0, 3.0);
        signal.width = Width::Float;
        let n = 1 << 18;
        let noise_of = |mut record: Vec<Complex<f64>>, tone: Vec<Complex<f64>>| {
            record.iter_mut().zip(tone).for_each(|(x, t)| *x -= t);
            power(&record)
        };
        signal.lines[0] = Line { bins: 1234.5, amplitude: 100.0, phase: Some(0.4) };
        let clean = Signal { snr_db: f64::INFINITY, ..signal.clone() };
        let ratio = 10f64.powf(0.3);
        let real = noise_of(
            signal.record::<Real>(n, &mut generator(1, 0)),
            clean.record::<Real>(n, &mut generator(1, 0)),
        );
        assert!((1e4 / (2.0 * real) / ratio - 1.0).abs() < 0.01, "{real}");
        let iq = noise_of(
            signal.record::<Iq>(n, &mut generator(1, 1)),
            clean.record::<Iq>(n, &mut generator(1, 1)),
        );
        assert!((1e4 / iq / ratio - 1.0).abs() < 0.01, "{iq}");
    }

    #[test]
    fn a_trial_depends_on_its_number_alone() {
        let signal = Signal::tone(64.2, 1000.0, 0.0);
        let records: Vec<_> =
            [7, 3, 7].map(|t| signal.codes::<Iq>(64, &mut generator(5, t))).into();
        assert_eq!(records[0], records[2]);
        assert_ne!(records[0], records[1]);
    }

    #[test]
    fn the_nearest_code() {
        let halves = (-66_000..66_000).map(|x| f64::from(x) / 2.0);
        let beside = halves.flat_map(|x| [x, x.next_up(), x.next_down()]);
        for x in beside.chain([
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e300,
            0.499_999_999_999_999_94,
        ]) {
            assert_eq!(nearest(x), x.round() as i16, "{x}");
        }
    }

    #[test]
    fn codes_end_at_the_rails() {
        let record = Signal::tone(5.0, 4000.0, 60.0).codes::<Real>(64, &mut generator(1, 0));
        assert_eq!(record.iter().max(), Some(&2047));
        assert_eq!(record.iter().min(), Some(&-2048));
    }
}

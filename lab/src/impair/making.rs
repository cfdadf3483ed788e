//! One record in the making: the scene of a tone in noise, and what an impairment changes of it.

use crate::simulate::Width;
use num_complex::Complex;
use picket_dsp::acquire::codes::Codes;
use picket_simulator::scene::{Change, Converter, Density, Hum, Receiver, Source, Tone};
use picket_simulator::{Scene, Value};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Of what a tone of four sigma of noise below the rails is let through: room for a second tone, hum or modulation.
const ROOM: f64 = 0.6;
/// Ratios beyond are those of no noise, dB.
const NOISELESS_DB: f64 = 300.0;

/// What records are made of besides the impairment.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Samples in a record.
    pub n: usize,
    /// Signal-to-noise ratio in dB per sample, of all of the noise; infinite for none.
    pub snr_db: f64,
    /// The converter.
    pub width: Width,
    /// Amplitude in codes; else six tenths of the largest at which four sigma of noise do not clip.
    pub amplitude: Option<f64>,
    /// Bins between which the tone lies, anywhere; else those that the impairment is for.
    pub bins: Option<(f64, f64)>,
}

impl Setup {
    /// Records of `n` 12-bit samples.
    pub const fn new(n: usize, snr_db: f64) -> Self {
        let width = Width::Codes(Codes::signed::<12>());
        Setup { n, snr_db, width, amplitude: None, bins: None }
    }

    /// Bits of the converter; without one levels refer to 12.
    const fn bits(&self) -> u32 {
        match self.width {
            Width::Codes(codes) => codes.bits(),
            Width::Float => 12,
        }
    }
}

/// A record and its truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Impaired {
    /// The samples in codes; real records have no imaginary part.
    pub samples: Vec<Complex<f64>>,
    /// The mean frequency of the tone over the block, in bins; negative for an I/Q tone that turns backwards.
    /// A jump of the phase is no frequency.
    pub bins: f64,
    /// The frequency in bins that the tone would have without chirp, walk or step.
    pub nominal_bins: f64,
    /// The signal-to-noise ratio in dB of white noise as dense as this noise is at the tone, rounding included.
    pub local_snr_db: f64,
}

/// A scene in the making: a hertz is a bin, a second is a block. An impairment changes it.
pub(super) struct Making<'a> {
    /// The scene's seed.
    seed: u64,
    /// Samples of the record.
    pub n: f64,
    /// Whether samples are pairs.
    pub iq: bool,
    /// The converter's rail in codes.
    pub rail: f64,
    /// The tone's amplitude in codes.
    pub amplitude: f64,
    /// The tone.
    pub tone: Tone,
    /// A walk of the tone's phase that moves the carrier's truth nowhere.
    pub linewidth: Option<Change>,
    /// What else is in the record.
    pub others: Vec<Source>,
    pub receiver: Receiver,
    pub converter: Converter,
    /// What two parts of a scene have in common is drawn from it.
    pub rng: &'a mut ChaCha8Rng,
}

impl<'a> Making<'a> {
    /// A pure tone somewhere in `range`, of random phase.
    pub fn new(iq: bool, setup: &Setup, range: Range, rng: &'a mut ChaCha8Rng) -> Self {
        let (low, high) = range;
        let backwards = rng.random_bool(0.5) && iq && setup.bins.is_none();
        let ends = if backwards { [-high, -low] } else { [low, high] };
        let mut receiver = Receiver { iq, ..Receiver::default() };
        let snr_db = setup.snr_db.max(-NOISELESS_DB);
        receiver.noise.snr_db = (snr_db <= NOISELESS_DB).then_some(snr_db.into());
        receiver.noise.mixed = true;
        let full = crate::sweep::full_amplitude(setup.width, setup.snr_db);
        Making {
            // The same for all impairments, whatever they draw.
            seed: rng.random(),
            n: setup.n as f64,
            iq,
            rail: 2f64.powi(setup.bits() as i32 - 1),
            amplitude: setup.amplitude.unwrap_or(ROOM * full),
            tone: Tone { frequency_hz: Value::Between(ends), ..Tone::default() },
            linewidth: None,
            others: Vec::new(),
            receiver,
            converter: Converter { bits: setup.bits(), ..Converter::default() },
            rng,
        }
    }

    /// Changes the tone.
    pub fn change(&mut self, change: Change) {
        self.tone.changes.push(change);
    }

    /// Adds a tone so far from the first one, of this level over it, with something that changes it.
    pub fn add(&mut self, tone: Tone, level_db: f64, changes: Vec<Change>) {
        self.others.push(Source::Tone(Tone { level_db: Some(level_db.into()), changes, ..tone }));
    }

    /// Adds a real sine of this many cycles a block, of a share of full scale, to I and Q in random shares; of any phase unless it is said.
    pub fn hum(&mut self, cycles: f64, share: f64, phase_turns: Option<Value>) {
        let (frequency_hz, amplitude) = (cycles.into(), (share * self.rail).into());
        let (harmonics, direction_turns) = (Vec::new(), None);
        let hum = Hum { frequency_hz, amplitude, harmonics, phase_turns, direction_turns };
        self.receiver.hum.push(hum);
    }

    /// Shapes the noise.
    pub fn shape(&mut self, density: Density) {
        self.receiver.noise.shape.push(density);
    }

    /// A frequency in bins, of a share of Nyquist's.
    pub fn share_of_nyquist(&self, share: f64) -> Value {
        (0.5 * self.n * share).into()
    }

    /// Any sample but the first.
    pub fn anywhere(&self) -> Value {
        Value::Between([0.5, self.n - 0.5])
    }

    /// The record, and its truth. Were there severities with which a scene cannot be, it would be one of silence that is never right.
    pub fn record(self, setup: &Setup) -> Impaired {
        self.made(setup).unwrap_or_else(|_| Impaired {
            samples: vec![Complex::default(); setup.n],
            bins: f64::NAN,
            nominal_bins: f64::NAN,
            local_snr_db: f64::NAN,
        })
    }

    fn made(self, setup: &Setup) -> Result<Impaired, String> {
        let (n, amplitude) = (setup.n, self.amplitude);
        let tone = Tone { amplitude: Some(amplitude.into()), ..self.tone };
        let mut scene = Scene {
            seed: self.seed,
            rate_hz: self.n,
            seconds: 1.0,
            sources: vec![Source::Tone(tone)],
            receiver: self.receiver,
            converter: self.converter,
            ..Scene::default()
        };
        // What is true is so without the carrier's own width, which is drawn after all other changes.
        // Each sample stands for the time about it: the block is from half a sample before the first one.
        let truth = scene.run(0)?.truth(0, -0.5 / self.n, n);
        if let Some(Source::Tone(tone)) = scene.sources.first_mut() {
            tone.changes.extend(self.linewidth);
        }
        scene.sources.extend(self.others);
        let mut run = scene.run(0)?;
        let samples: Vec<Complex<f64>> = match setup.width {
            Width::Codes(_) => {
                run.codes(0.0, n).into_iter().map(|x| complex(x.map(f64::from))).collect()
            }
            Width::Float => run.unrounded(0.0, n).into_iter().map(complex).collect(),
        };
        let (sigma, dense) = (run.noise(), run.dense(truth.nominal_hz));
        let rounding = if setup.width == Width::Float { 0.0 } else { 1.0 / 12.0 };
        let local = amplitude * amplitude / 2.0 / (sigma * sigma * dense + rounding);
        Ok(Impaired {
            samples,
            bins: truth.mean_hz,
            nominal_bins: truth.nominal_hz,
            local_snr_db: 10.0 * local.log10(),
        })
    }
}

const fn complex([re, im]: [f64; 2]) -> Complex<f64> {
    Complex::new(re, im)
}

/// Between which bins a tone lies.
pub(super) type Range = (f64, f64);

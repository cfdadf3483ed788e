//! One record in the making: a tone, noise, and what an impairment changes of either or of the converter.

use crate::simulate::Width;
use num_complex::Complex;
use picket::acquire::codes::Codes;
use picket_transform::{Fft, Transform};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Of what a tone of four sigma of noise below the rails is let through: room for a second tone, hum or modulation.
const ROOM: f64 = 0.6;
/// Noise that is not white is cut from a longer piece, so that its ends do not meet.
const PIECE: usize = 8;

/// What records are made of besides the impairment.
#[derive(Clone)]
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
    inverse: Arc<dyn Fft<f64>>,
}

impl std::fmt::Debug for Setup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Setup({}, {} dB, {:?}, {:?})", self.n, self.snr_db, self.width, self.bins)
    }
}

impl Setup {
    /// Records of `n` 12-bit samples.
    pub fn new(n: usize, snr_db: f64) -> Self {
        Setup {
            n,
            snr_db,
            width: Width::Codes(Codes::signed::<12>()),
            amplitude: None,
            bins: None,
            inverse: f64::inverse(PIECE * n),
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

/// What becomes of a voltage.
pub type Front = Box<dyn Fn(Complex<f64>) -> Complex<f64>>;
/// Power density over frequency in cycles per sample.
pub type Density = Box<dyn Fn(f64) -> f64>;

/// A record in the making. An impairment changes it; the samples are made of it after.
pub struct Scene<'a> {
    /// Samples.
    pub n: usize,
    /// Whether samples are pairs.
    pub iq: bool,
    /// The tone's frequency, in bins.
    pub nominal: f64,
    /// How far the mean frequency over the block is from it.
    pub shift: f64,
    /// The tone's amplitude in codes.
    pub amplitude: f64,
    /// The converter's rail in codes.
    pub rail: f64,
    /// When each sample of I and of Q is taken, in samples.
    pub instants: [Vec<f64>; 2],
    /// Factors of the tone's amplitude.
    pub gain: Vec<f64>,
    /// The tone's phase besides that of its frequency, radians.
    pub phase: Vec<f64>,
    /// What is added in codes, before noise.
    pub added: Vec<Complex<f64>>,
    /// Power density of the noise over frequency in cycles per sample, on any scale; `None` for white.
    pub density: Option<Density>,
    /// No noise.
    pub silent: bool,
    /// What the front end makes of a voltage.
    pub front: Option<Front>,
    /// What becomes of a code.
    pub digital: Option<Front>,
    /// Whether each two samples change places.
    pub swapped: bool,
    /// From this sample on, so many copies of the one before it are delivered, and the rest later.
    pub copies: Option<(usize, usize)>,
    /// Draws of this record.
    pub rng: &'a mut ChaCha8Rng,
}

impl<'a> Scene<'a> {
    /// A pure tone somewhere in `range`, of random phase.
    pub(super) fn new(iq: bool, setup: &Setup, range: Range, rng: &'a mut ChaCha8Rng) -> Self {
        let n = setup.n;
        let (low, high) = range;
        let place = low + (high - low) * rng.random_range(0.0..1.0);
        let backwards = rng.random_bool(0.5) && iq && setup.bins.is_none();
        let phase = rng.random_range(0.0..TAU);
        let rail = match setup.width {
            Width::Codes(codes) => -f64::from(codes.rails().0),
            Width::Float => 2048.0,
        };
        let full = crate::sweep::full_amplitude(setup.width, setup.snr_db);
        let instants: Vec<f64> = (0..n).map(|k| k as f64).collect();
        Scene {
            n,
            iq,
            nominal: if backwards { -place } else { place },
            shift: 0.0,
            amplitude: setup.amplitude.unwrap_or(ROOM * full),
            rail,
            instants: [instants.clone(), instants],
            gain: vec![1.0; n],
            phase: vec![phase; n],
            added: vec![Complex::new(0.0, 0.0); n],
            density: None,
            silent: false,
            front: None,
            digital: None,
            swapped: false,
            copies: None,
            rng,
        }
    }

    /// Where each sample lies in the block, from its first instant on, in blocks.
    pub fn places(&self) -> impl Iterator<Item = f64> + use<> {
        let n = self.n as f64;
        (0..self.n).map(move |k| k as f64 / n)
    }

    /// +1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.rng.random_bool(0.5) { 1.0 } else { -1.0 }
    }

    /// Any number from 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.rng.random_range(0.0..1.0)
    }

    /// A normal number.
    pub fn normal(&mut self) -> f64 {
        self.rng.sample(StandardNormal)
    }

    /// The tone's phase at sample `k` of the part `part`, radians.
    pub fn angle(&self, part: usize, k: usize) -> f64 {
        TAU * (self.nominal * self.instants[part][k] / self.n as f64).fract() + self.phase[k]
    }

    /// The record, and its truth.
    pub(super) fn record(mut self, setup: &Setup) -> Impaired {
        let snr = if self.silent { f64::INFINITY } else { 10f64.powf(setup.snr_db / 10.0) };
        let sigma = self.amplitude / (2.0 * snr).sqrt();
        let (noise, dense) = self.noise(&setup.inverse);
        let mut samples = Vec::with_capacity(self.n);
        for (k, noise) in noise.into_iter().enumerate() {
            let level = self.amplitude * self.gain[k];
            let tone = Complex::new(self.angle(0, k).cos(), self.angle(1, k).sin()) * level;
            samples.push(tone + self.added[k] + noise * sigma);
        }
        for sample in &mut samples {
            if let Some(front) = &self.front {
                *sample = front(*sample);
            }
            let im = if self.iq { setup.width.convert(sample.im) } else { 0.0 };
            *sample = Complex::new(setup.width.convert(sample.re), im);
            if let Some(digital) = &self.digital {
                let Complex { re, im } = digital(*sample);
                *sample = Complex::new(re, if self.iq { im } else { 0.0 });
            }
        }
        if self.swapped {
            samples.as_chunks_mut().0.iter_mut().for_each(|pair: &mut [_; 2]| pair.reverse());
        }
        if let Some((from, count)) = self.copies {
            let before = samples[from - 1];
            samples.splice(from..from, std::iter::repeat_n(before, count));
            samples.truncate(self.n);
        }
        let rounding = if setup.width == Width::Float { 0.0 } else { 1.0 / 12.0 };
        let local = self.amplitude * self.amplitude / 2.0 / (sigma * sigma * dense + rounding);
        Impaired {
            samples,
            bins: self.nominal + self.shift,
            nominal_bins: self.nominal,
            local_snr_db: 10.0 * local.log10(),
        }
    }

    /// Noise of unit variance in each part, and its density at the tone over that of white noise.
    fn noise(&mut self, inverse: &Arc<dyn Fft<f64>>) -> (Vec<Complex<f64>>, f64) {
        let Some(density) = self.density.take() else {
            let n = self.n;
            let draw = |_| Complex::new(self.normal(), self.normal());
            return ((0..n).map(draw).collect(), 1.0);
        };
        let length = PIECE * self.n;
        let at = |nu: f64| if self.iq { density(nu) } else { density(nu.abs()) };
        let densities: Vec<f64> = (0..length)
            .map(|k| (k as f64 / length as f64 + 0.5).fract() - 0.5)
            .map(|nu| if nu == 0.0 { at(1.0 / length as f64) } else { at(nu) })
            .collect();
        let total: f64 = densities.iter().sum();
        let dense = at(self.nominal / self.n as f64) * length as f64 / total;
        // Of a real record the real part is taken: both signs of a frequency, alike.
        let mut piece: Vec<Complex<f64>> = densities
            .into_iter()
            .map(|d| Complex::new(self.normal(), self.normal()) * (d / total).sqrt())
            .collect();
        inverse.process(&mut piece);
        piece.truncate(self.n);
        (piece, dense)
    }
}

impl std::fmt::Debug for Scene<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Scene({} samples, bin {})", self.n, self.nominal)
    }
}

/// Between which bins a tone lies.
pub(super) type Range = (f64, f64);

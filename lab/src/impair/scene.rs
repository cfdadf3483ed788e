//! One record in the making: a tone, noise, and what an impairment changes of either or of the converter.

use crate::simulate::Width;
use num_complex::Complex;
use picket_dsp::acquire::codes::Codes;
use picket_simulator::walk;
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
    /// Factors of the tone's amplitude, of I and of Q.
    pub gain: [Vec<f64>; 2],
    /// The tone's phase besides that of its frequency, radians, of I and of Q.
    pub phase: [Vec<f64>; 2],
    /// What is added in codes, before noise.
    pub added: Vec<Complex<f64>>,
    /// Factors of the noise's power density over frequency in cycles per sample, on any scale; none for white noise.
    pub density: Vec<Density>,
    /// No noise.
    pub silent: bool,
    /// What the front end makes of a voltage, step by step.
    pub front: Vec<Front>,
    /// Whether codes beyond the rails go on at the other end.
    pub wraps: bool,
    /// What becomes of a code, step by step.
    pub digital: Vec<Front>,
    /// Whether each two samples change places.
    pub swapped: bool,
    /// From this sample on, this many copies of the one before it are delivered, and the rest later.
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
            gain: [vec![1.0; n], vec![1.0; n]],
            phase: [vec![phase; n], vec![phase; n]],
            added: vec![Complex::new(0.0, 0.0); n],
            density: Vec::new(),
            silent: false,
            front: Vec::new(),
            wraps: false,
            digital: Vec::new(),
            swapped: false,
            copies: None,
            rng,
        }
    }

    /// When the samples of I (part 0) or of Q (1) are taken, in blocks since the block's start.
    pub fn times(&self, part: usize) -> impl Iterator<Item = f64> + use<> {
        let n = self.n as f64;
        self.instants[part].clone().into_iter().map(move |t| t / n)
    }

    /// The first and the last time at which a sample of either part is taken, in blocks; the whole block at least.
    pub fn span(&self) -> (f64, f64) {
        let times = || [0, 1].into_iter().flat_map(|part| self.times(part));
        (times().fold(0.0, f64::min), times().fold(1.0, f64::max))
    }

    /// The tone's amplitude times a function of the time in blocks.
    pub fn modulate(&mut self, factor: impl Fn(f64) -> f64) {
        for part in [0, 1] {
            let times = self.times(part);
            self.gain[part].iter_mut().zip(times).for_each(|(gain, u)| *gain *= factor(u));
        }
    }

    /// The tone's phase and a function of the time in blocks, radians.
    pub fn turn(&mut self, angle: impl Fn(f64) -> f64) {
        for part in [0, 1] {
            let times = self.times(part);
            self.phase[part].iter_mut().zip(times).for_each(|(phase, u)| *phase += angle(u));
        }
    }

    /// The tone times a complex envelope, a function of the time in blocks.
    pub fn envelop(&mut self, envelope: impl Fn(f64) -> Complex<f64>) {
        self.modulate(|u| envelope(u).norm());
        self.turn(|u| envelope(u).arg());
    }

    /// A function of the time in blocks, in codes, on top of the tone.
    pub fn add(&mut self, value: impl Fn(f64) -> Complex<f64>) {
        let times = self.times(0).zip(self.times(1));
        for (added, (i, q)) in self.added.iter_mut().zip(times) {
            *added += Complex::new(value(i).re, value(q).im);
        }
    }

    /// In which direction of the plane of I and Q a real waveform comes in: any, and of a real record either sign.
    pub fn direction(&mut self) -> Complex<f64> {
        let direction = Complex::cis(TAU * self.share());
        if self.iq { direction } else { Complex::new(direction.re.signum(), 0.0) }
    }

    /// The tone's phase and a Wiener process whose standard deviation over a block is `rms` radians. Gives the mean frequency that
    /// takes it from its first value to its last, in bins.
    pub fn wander(&mut self, rms: f64) -> f64 {
        let (n, times) = (self.n as f64, self.instants.concat());
        let walked = walk(&times, rms / n.sqrt(), || self.rng.sample(StandardNormal));
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        let latest = |a: &(&f64, &f64), b: &(&f64, &f64)| a.0.total_cmp(b.0);
        let last = times.iter().zip(&walked).max_by(latest);
        self.phase.iter_mut().flatten().zip(&walked).for_each(|(phase, w)| *phase += w);
        last.map_or(0.0, |(last, walked)| walked / TAU * n / (last - first))
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
        TAU * (self.nominal * self.instants[part][k] / self.n as f64).fract() + self.phase[part][k]
    }

    /// The record, and its truth.
    pub(super) fn record(mut self, setup: &Setup) -> Impaired {
        let snr = if self.silent { f64::INFINITY } else { 10f64.powf(setup.snr_db / 10.0) };
        let sigma = self.amplitude / (2.0 * snr).sqrt();
        let (noise, dense) = self.noise(&setup.inverse);
        let mut samples = Vec::with_capacity(self.n);
        for (k, noise) in noise.into_iter().enumerate() {
            let level = |part: usize| self.amplitude * self.gain[part][k];
            let (i, q) = (self.angle(0, k).cos() * level(0), self.angle(1, k).sin() * level(1));
            samples.push(Complex::new(i, q) + self.added[k] + noise * sigma);
        }
        for sample in &mut samples {
            for front in &self.front {
                *sample = front(*sample);
            }
            let code = |voltage: f64| match self.wraps {
                true => (voltage.round() + self.rail).rem_euclid(2.0 * self.rail) - self.rail,
                false => voltage,
            };
            let [re, im] = [sample.re, sample.im].map(|part| setup.width.convert(code(part)));
            *sample = Complex::new(re, im);
            for digital in &self.digital {
                *sample = digital(*sample);
            }
            if !self.iq {
                sample.im = 0.0;
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
        let density = std::mem::take(&mut self.density);
        if density.is_empty() {
            let n = self.n;
            let draw = |_| Complex::new(self.normal(), self.normal());
            return ((0..n).map(draw).collect(), 1.0);
        }
        let length = PIECE * self.n;
        let of = |nu: f64| density.iter().map(|factor| factor(nu)).product::<f64>();
        let at = |nu: f64| if self.iq { of(nu) } else { of(nu.abs()) };
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

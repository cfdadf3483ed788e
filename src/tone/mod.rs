//! From the bins around a peak to a tone with its sigma and verdict.
//!
//! A fit answers with an *offset*: how far the tone is from the peak bin, in bins (cycles per record), positive
//! towards higher frequency, usually in -0.5..=0.5.

mod aliases;
pub mod arithmetic;
pub mod clipped;
pub(crate) mod close_detection;
mod close_judgement;
pub mod detection;
mod detector;
pub mod effort;
pub mod evidence;
pub mod fit;
pub use crate::frequency;
pub(crate) mod front_end;
pub mod harmonic;
pub(crate) mod image;
pub(crate) mod judge;
pub mod line_class;
pub mod lines;
pub mod lock;
pub mod measure;
pub mod noise;
pub mod observer;
pub mod options;
pub mod phasor;
mod residual;
pub mod sigma;
pub mod statistic;
pub mod threshold;
pub mod verdict;
pub mod zoomed;

use crate::spectrum::peak::Band;
use frequency::Frequency;

pub use verdict::{Reasons, Usable, Verdict, Verdicts};

/// One measured tone.
///
/// ```
/// use picket_dsp::{Codes, Pipeline, Plan, Real, Usable, Verdict};
///
/// let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(48_000.0, Codes::signed::<12>()));
/// let sine = |n: usize| 900.0 * (0.131 * n as f64).sin();
/// let samples: [i16; 1024] = std::array::from_fn(|n| sine(n).round() as i16);
/// let tone = pipeline.record(&samples)?.tone;
/// let hertz = 0.131 / std::f64::consts::TAU * 48_000.0; // 1000.766
/// assert!((tone.hertz() - hertz).abs() < 3.0 * tone.sigma_hertz(), "{tone}");
/// assert!((tone.amplitude - 900.0).abs() < 1.0 && tone.snr_db() > 50.0);
/// assert_eq!((tone.verdict, tone.verdict.usable()), (Verdict::Good, Usable::Yes));
/// # Ok::<(), picket_dsp::LengthError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tone {
    /// The frequency.
    pub frequency: Frequency,
    /// One standard deviation of the frequency, in cycles per sample.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma: f32,
    /// Signal-to-noise ratio per sample, as a power ratio: A^2 / (2 s^2) for a real tone of amplitude
    /// A in noise of variance s^2, A^2 / s^2 for a complex tone in complex noise of power s^2.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::number"))]
    pub snr: f32,
    /// Amplitude in ADC codes.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::number"))]
    pub amplitude: f32,
    /// Whether the tone may be used: the most severe reason that applies.
    pub verdict: Verdict,
    /// The other reasons that apply, less severe than the verdict.
    pub also: Verdicts,
    /// The sample rate, Hz, for the methods that answer in hertz; 0 if it is not known.
    pub rate_hz: f64,
}

/// Prints hertz, with two digits of sigma: `999.995 Hz ± 0.041 Hz, SNR 25.9 dB, good`. Other reasons follow the verdict:
/// `clipped, moving`.
impl core::fmt::Display for Tone {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (hertz, sigma, digits) = (self.hertz(), self.sigma_hertz(), self.digits());
        write!(f, "{hertz:.digits$} Hz ± {sigma:.digits$} Hz, ")?;
        write!(f, "SNR {:.1} dB", self.snr_db())?;
        self.reasons().try_for_each(|verdict| write!(f, ", {verdict}"))
    }
}

/// Logs what [`Display`](core::fmt::Display) prints, but for trailing zeros.
#[cfg(feature = "defmt")]
impl defmt::Format for Tone {
    fn format(&self, f: defmt::Formatter) {
        let unit = (0..self.digits()).fold(1.0, |unit, _| 10.0 * unit);
        let [hertz, sigma] =
            [self.hertz(), self.sigma_hertz()].map(|number| libm::rint(number * unit) / unit);
        let decibels = libm::rintf(10.0 * self.snr_db()) / 10.0;
        defmt::write!(f, "{=f64} Hz ± {=f64} Hz, SNR {=f32} dB", hertz, sigma, decibels);
        for verdict in self.reasons() {
            defmt::write!(f, ", {=str}", verdict.name());
        }
    }
}

impl Tone {
    /// All zeros and `Good`: a placeholder.
    pub(crate) const ZERO: Self = Self {
        frequency: Frequency(fixed::types::I0F32::ZERO),
        sigma: 0.0,
        snr: 0.0,
        amplitude: 0.0,
        verdict: Verdict::Good,
        also: Verdicts::NONE,
        rate_hz: 0.0,
    };

    /// A tone with these reasons alone, for its maker to fill in.
    pub(crate) fn with_reasons(reasons: Reasons, rate_hz: f64) -> Self {
        Self { verdict: reasons.verdict(), also: reasons.also(), rate_hz, ..Self::ZERO }
    }

    /// The frequency in hertz.
    pub fn hertz(&self) -> f64 {
        self.frequency.hertz(self.rate_hz)
    }

    /// One standard deviation of the frequency, in hertz.
    pub fn sigma_hertz(&self) -> f64 {
        f64::from(self.sigma) * self.rate_hz
    }

    /// All reasons that apply to the tone, the most severe first: its verdict, then the others.
    pub fn reasons(&self) -> impl Iterator<Item = Verdict> + use<> {
        core::iter::once(self.verdict).chain(self.also.iter())
    }

    /// Whether the tone's frequency is outside of the band in which it was sought: the peak there is the skirt of a line beyond.
    pub(crate) fn is_outside(&self, band: Band, n: usize) -> bool {
        !band.holds(self.frequency, n)
    }

    /// Whether the numbers agree with the verdict: a usable tone has a finite sigma and amplitude, and a signal-to-noise ratio above zero.
    /// Every measured tone is consistent; the check is for bytes from other programs.
    pub const fn is_consistent(&self) -> bool {
        // A fundamental that is not seen itself has the amplitude 0.
        let there = self.snr > 0.0 && self.amplitude >= 0.0 && self.amplitude < f32::INFINITY;
        self.verdict.admits(self.sigma) && (there || matches!(self.verdict.usable(), Usable::No))
    }

    /// The decimals of a hertz that show two digits of sigma.
    fn digits(&self) -> usize {
        // Casts saturate.
        (1.0 - libm::floor(libm::log10(self.sigma_hertz()))).clamp(0.0, 9.0) as usize
    }

    /// The signal-to-noise ratio in decibels.
    pub fn snr_db(&self) -> f32 {
        10.0 * libm::log10f(self.snr)
    }
}

/// The rise of a tone's frequency from the beginning of a record to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrequencyDrift {
    /// The rise, cycles per sample. It is within 1 % up to half a bin, and too small beyond.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::number"))]
    pub cycles: f32,
    /// One standard deviation of the rise, cycles per sample.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma: f32,
}

/// `x` held to `-limit..=limit`; 0 where `x` is NaN, as for a record without a signal.
pub(crate) fn within<T: crate::math::scalar::Scalar>(x: T, limit: T) -> T {
    if x.is_nan() { T::zero() } else { x.min(limit).max(-limit) }
}

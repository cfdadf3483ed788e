//! A tone with everything a reader needs to trust it.

use super::frequency::Frequency;

/// Whether a number may be used. Every number comes with a verdict. If several apply, the tone
/// gets the most severe one; [`Verdict::ALL`] and `<` order them by severity. A telemetry record
/// holds a verdict as its number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum Verdict {
    /// Use it: sigma is its error.
    Good = 0,
    /// One tone whose frequency or level changes within the record. Use it within sigma, as the
    /// mean over the record. Two lines less than one and a half bins apart look the same.
    Moving = 8,
    /// The tone is so near DC or Nyquist that its mirror image disturbs the estimate.
    NearEdge = 1,
    /// More than 1 % of the samples touch a rail. Use it within sigma, which includes how far the
    /// harmonics of clipping move this tone. At most frequencies they hardly do; near a simple
    /// fraction of the rate they move it hundreds of times as far as noise.
    Clipped = 2,
    /// Two tones too close to be separated, or beats that do not belong to one target.
    Unresolved = 3,
    /// The two parts of an I/Q record do not match, for example because one is dead or late. The
    /// tone may be at minus its frequency.
    Image = 9,
    /// Samples were lost just before this block, or within this chirp.
    Gap = 4,
    /// The peak is below the detection threshold: it may be noise.
    Weak = 5,
    /// There is nothing in the band; the numbers mean nothing.
    #[default]
    NoSignal = 6,
    /// Samples lie beyond the rails of the stated codes. The converter's codes are others, so
    /// noise, sigma and clipping mean nothing.
    WrongCodes = 7,
}

impl Verdict {
    /// Every verdict, from best to worst.
    pub const ALL: [Verdict; 10] = [
        Verdict::Good,
        Verdict::Moving,
        Verdict::NearEdge,
        Verdict::Clipped,
        Verdict::Unresolved,
        Verdict::Image,
        Verdict::Gap,
        Verdict::Weak,
        Verdict::NoSignal,
        Verdict::WrongCodes,
    ];

    /// The verdict with this number, as stored in a telemetry record.
    pub fn from_u8(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|&verdict| verdict as u8 == code)
    }

    /// The name that tables and JSON show.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Good => "good",
            Verdict::Moving => "moving",
            Verdict::NearEdge => "near-edge",
            Verdict::Clipped => "clipped",
            Verdict::Unresolved => "unresolved",
            Verdict::Image => "image",
            Verdict::Gap => "gap",
            Verdict::Weak => "weak",
            Verdict::NoSignal => "no-signal",
            Verdict::WrongCodes => "wrong-codes",
        }
    }

    /// What it means, in a sentence.
    pub const fn reason(self) -> &'static str {
        match self {
            Verdict::Good => "One steady tone: the error is as sigma says.",
            Verdict::Moving => {
                "The tone's frequency or level changes within the block: the frequency is the mean over it."
            }
            Verdict::NearEdge => {
                "The tone is so near DC or Nyquist that its mirror image disturbs it."
            }
            Verdict::Clipped => "Samples touch the converter's rails: lower the gain.",
            Verdict::Unresolved => {
                "There is more than one tone in the line: sigma covers what is seen of it."
            }
            Verdict::Image => {
                "The two channels do not belong together: the frequency may have the wrong sign."
            }
            Verdict::Gap => "Samples were lost just before this block.",
            Verdict::Weak => "The line is too weak to be told from noise.",
            Verdict::NoSignal => "There is nothing in the band.",
            Verdict::WrongCodes => {
                "Samples lie beyond the rails that were stated: the converter's codes are others."
            }
        }
    }

    /// Its place in the order of severity.
    const fn severity(self) -> u8 {
        match self {
            Verdict::Good => 0,
            Verdict::Moving => 1,
            Verdict::NearEdge => 2,
            Verdict::Clipped => 3,
            Verdict::Unresolved => 4,
            Verdict::Image => 5,
            Verdict::Gap => 6,
            Verdict::Weak => 7,
            Verdict::NoSignal => 8,
            Verdict::WrongCodes => 9,
        }
    }
}

impl Ord for Verdict {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        self.severity().cmp(&other.severity())
    }
}

impl PartialOrd for Verdict {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl core::fmt::Display for Verdict {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

/// One measured tone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tone {
    /// The frequency.
    pub frequency: Frequency,
    /// One standard deviation of the frequency, in cycles per sample.
    pub sigma: f32,
    /// Signal-to-noise ratio per sample, as a power ratio: A^2 / (2 s^2) for a real tone of amplitude
    /// A in noise of variance s^2, A^2 / s^2 for a complex tone in complex noise of power s^2.
    pub snr: f32,
    /// Amplitude in ADC codes.
    pub amplitude: f32,
    /// Whether it may be used.
    pub verdict: Verdict,
    /// The sample rate, Hz, for the methods that answer in hertz; 0 if it is not known.
    pub rate_hz: f64,
}

/// In hertz, with two digits of sigma: `1000.198 Hz ± 0.010 Hz, SNR 31.2 dB, good`.
impl core::fmt::Display for Tone {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (hertz, sigma) = (self.hertz(), self.sigma_hertz());
        // Casts saturate.
        let digits = (1.0 - libm::floor(libm::log10(sigma))).clamp(0.0, 9.0) as usize;
        write!(f, "{hertz:.digits$} Hz ± {sigma:.digits$} Hz, ")?;
        write!(f, "SNR {:.1} dB, {}", self.snr_db(), self.verdict)
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
        rate_hz: 0.0,
    };

    /// The frequency in hertz.
    pub fn hertz(&self) -> f64 {
        self.frequency.hertz(self.rate_hz)
    }

    /// One standard deviation of the frequency, in hertz.
    pub fn sigma_hertz(&self) -> f64 {
        f64::from(self.sigma) * self.rate_hz
    }

    /// The signal-to-noise ratio in decibels.
    pub fn snr_db(&self) -> f32 {
        10.0 * libm::log10f(self.snr)
    }
}

/// How far a tone's frequency rises from the beginning of a record to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rise {
    /// The rise, cycles per sample. It is within 1 % up to half a bin, and too small beyond.
    pub cycles: f32,
    /// One standard deviation of the rise, cycles per sample.
    pub sigma: f32,
}

//! A tone with everything a reader needs to trust it.

use super::frequency::Frequency;

/// Whether a number may be used. A number is never given without one; of several that apply, the one highest in the order of
/// severity is given, which is that of [`Verdict::ALL`] and of `<`. The numbers are those of a telemetry record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum Verdict {
    /// Use it: the error is as sigma says.
    Good = 0,
    /// One tone whose frequency or level changes within the record: use it within sigma, as the mean over the record. Two lines
    /// less than a bin apart look the same.
    Moving = 8,
    /// The tone is so near DC or Nyquist that its mirror image disturbs the estimate.
    NearEdge = 1,
    /// More than 1 % of the samples touch a rail. Use it within sigma, which has in it how far the harmonics of clipping move this
    /// record's tone: hardly at all in most places, by hundreds of times what noise does near a simple fraction of the rate.
    Clipped = 2,
    /// Two tones too close to be told apart, or beats that do not belong to one target.
    Unresolved = 3,
    /// Both parts of an I/Q record do not belong together, as where one is dead or late: the tone may be at minus its frequency.
    Image = 9,
    /// Samples were lost just before this block, or within this chirp.
    Gap = 4,
    /// The peak is below the detection threshold: it may be noise.
    Weak = 5,
    /// There is nothing in the band; the numbers mean nothing.
    #[default]
    NoSignal = 6,
    /// Samples lie beyond the rails of the codes that were stated: the codes are others, and noise, sigma and clipping mean
    /// nothing.
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
    /// Where it is.
    pub frequency: Frequency,
    /// One standard deviation of the frequency, in cycles per sample.
    pub sigma: f32,
    /// Signal-to-noise ratio per sample, as a power ratio: A^2 / (2 s^2) for a real tone of amplitude
    /// A in noise of variance s^2, A^2 / s^2 for a complex tone in complex noise of power s^2.
    pub snr: f32,
    /// Amplitude in ADC codes.
    pub amplitude: f32,
    /// May it be used?
    pub verdict: Verdict,
    /// The sample rate, for the methods that answer in hertz; 0 where nobody said it.
    pub rate_hz: f64,
}

/// In hertz, with as many digits as sigma has two of: `1000.198 Hz ± 0.010 Hz, SNR 31.2 dB, good`.
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
    /// All zeros, and good: a place to be filled.
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

/// By how much a tone's frequency rises within a record, from its beginning to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rise {
    /// In cycles per sample: within 1 % up to half a bin, too little beyond.
    pub cycles: f32,
    /// One standard deviation of that.
    pub sigma: f32,
}

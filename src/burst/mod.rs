//! Bursts: the signal of one particle that crosses a beam, or of any source that is on for less than a record.
//!
//! A laser-Doppler velocimeter sees each particle as a burst with the Gaussian envelope of its beam. A record that begins at any time holds
//! only a part of the burst, and a fit of a steady tone errs by 2 to 26 times the burst's bound. So a burst is a measurement of its own, as in the
//! processors of such instruments: a detector on the stream cuts a record around it ([`BurstDetector`](crate::acquire::burst::BurstDetector)), and
//! [`Pipeline::burst`](crate::Pipeline::burst) measures its frequency with its envelope as the weight.
//!
//! ```
//! use picket_dsp::{BurstProcessor, Codes, Config, Real};
//!
//! let plan = Config::new(1e6, Codes::signed::<12>()).plan()?;
//! let mut processor = BurstProcessor::<Real, 1024>::new(plan);
//! # let mut state = 1u32;
//! # let mut noise = || { state = state.wrapping_mul(1664525).wrapping_add(1013904223); f64::from(state >> 8) / 16777216.0 - 0.5 };
//! # let stream: Vec<i16> = (0..20_000).map(|n| { let t = f64::from(n) - 9000.0; (500.0 * (-t * t / 2.0 / 1e4).exp() * (0.8 * t).cos() + 60.0 * noise()) as i16 }).collect();
//! # let mut bursts = Vec::new();
//! for chunk in stream.chunks(256) {
//!     processor.push(chunk, |burst| {
//!         println!("{} at {:.0}: {}", burst.validation.name(), burst.arrival, burst.tone);
//! #       bursts.push(*burst);
//!     });
//! }
//! # assert_eq!(bursts.len(), 1);
//! # assert_eq!(bursts[0].validation, picket_dsp::Validation::Valid);
//! # assert!((bursts[0].tone.frequency.cycles() - 0.8 / std::f64::consts::TAU).abs() < 5.0 * f64::from(bursts[0].tone.sigma));
//! # Ok::<(), picket_dsp::ConfigError>(())
//! ```
//!
//! # How good
//!
//! With the envelope `A exp(-(t - c)^2 / 2 s^2)` known, the bound of the frequency of a real tone in noise of variance v is
//!
//! ```text
//! var f = v / (2 pi^2 A^2 sum of (t - c)^2 exp(-(t - c)^2 / s^2)) = v / (pi^2.5 A^2 s^3)      cycles per sample, squared
//! ```
//!
//! and half of this for I/Q with v the variance of the noise in each part. A valid burst has the verdict `good`, and comes with a [`Burst`]. A
//! program that reads tones can read bursts as well; a program that validates bursts reads [`Validation`].

mod baseband;
mod envelope;
pub(crate) mod measure;

use crate::tone::Tone;

/// The reason against a burst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum Validation {
    /// One particle.
    #[default]
    Valid = 0,
    /// The points hold more than one tone with one envelope, which rises and falls once: two particles at once. The tone is unresolved.
    TwoParticles = 1,
    /// Fewer than four cycles within the envelope's two and a half standard deviations on each side of its middle, or a frequency next to
    /// the pedestal's. The tone is near an edge.
    FewCycles = 2,
    /// The envelope is shorter than a thirtieth of a record: use shorter records, or a higher sample rate.
    Short = 3,
    /// The envelope is longer than two fifths of a record: use longer records, or measure the signal as a steady tone.
    Long = 4,
    /// No line stands out: noise, or a particle outside of the fringes.
    Weak = 5,
    /// More than 1 % of the record's samples touch a rail.
    Clipped = 6,
}

impl Validation {
    /// Every validation, from best to worst.
    pub const ALL: [Self; 7] = [
        Self::Valid,
        Self::TwoParticles,
        Self::FewCycles,
        Self::Short,
        Self::Long,
        Self::Weak,
        Self::Clipped,
    ];

    /// A short name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::TwoParticles => "two-particles",
            Self::FewCycles => "few-cycles",
            Self::Short => "short",
            Self::Long => "long",
            Self::Weak => "weak",
            Self::Clipped => "clipped",
        }
    }
}

/// One burst.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Burst {
    /// The tone of the burst. Its amplitude and its signal-to-noise ratio are taken at the envelope's top.
    pub tone: Tone,
    /// The middle of the envelope, samples since the stream's first.
    pub arrival: f64,
    /// The standard deviation of the Gaussian envelope of the amplitude, samples. The transit time, between the points at which the power
    /// is down by `exp(-2)`, is `2 sqrt(2)` times this.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::number"))]
    pub deviation: f32,
    /// Whether one particle made the burst.
    pub validation: Validation,
}

impl Burst {
    /// The transit time, samples: between the points at which the power is down by `exp(-2)`.
    pub fn transit(&self) -> f64 {
        2.0 * core::f64::consts::SQRT_2 * f64::from(self.deviation)
    }
}

//! The reason why a configuration cannot work.

/// The reason why a configuration cannot work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// The sample rate is not 1e-6 to 1e12 Hz.
    Rate,
    /// The band holds no bin between 0 and half the rate (I/Q: between minus and plus half the
    /// rate), or its low end is above its high end.
    Band,
    /// A wavelength, a bandwidth or a duration is not finite and positive, the angle is a right
    /// angle or more, or a sweep's curvature is a quarter or more.
    Scene,
    /// A bound of range or velocity has an end that is not finite, or its low end is above its high end.
    Bounds,
    /// A segment is shorter than its guard and a record.
    Ramp,
    /// One cycle per sample is more than 2^31 metres or metres per second, or less than 2^-32.
    Scale,
    /// The method does not work on this kind of record.
    Method,
    /// The length is not at most 2^22 samples. The core's own transform takes only 64, 128, ... 4096.
    Length,
    /// The plan is for records of another kind or length.
    Records,
    /// The probability of a false alarm is 0 or less, or above 0.5.
    FalseAlarm,
    /// The rate is outside its range, or more than 4 tones are to be followed.
    Following,
    /// The carrier's width is negative, or more than half the sample rate.
    Carrier,
    /// A frame's chirps are not 8, 16, ... 256, its period is shorter than a ramp, or its waveform is not a sawtooth.
    Frame,
}

impl ConfigError {
    /// The cure, in one line.
    pub const fn message(self) -> &'static str {
        match self {
            ConfigError::Rate => "the sample rate must lie between 1e-6 and 1e12 Hz",
            ConfigError::Band => {
                "the band must lie between 0 and half the sample rate, low end first"
            }
            ConfigError::Scene => {
                "wavelength, bandwidth and duration must be positive, the angle below 90 degrees, the sweep's curvature below 1/4"
            }
            ConfigError::Bounds => "a bound of range or velocity must be finite, low end first",
            ConfigError::Ramp => "a ramp must last at least as long as its guard and a record",
            ConfigError::Scale => {
                "range or velocity per cycle must lie between 2^-32 and 2^31: use another rate"
            }
            ConfigError::FalseAlarm => "the false-alarm probability must lie between 0 and 0.5",
            ConfigError::Following => {
                "follow at most 4 tones, with a rate of 1e-6 to 4096 bins a block"
            }
            ConfigError::Carrier => {
                "the carrier's linewidth and envelope must lie between 0 and half the sample rate"
            }
            ConfigError::Frame => {
                "a frame must have 8, 16, ... 256 sawtooth chirps, and a period of at least a ramp"
            }
            ConfigError::Method => "the method does not work on this kind of record",
            ConfigError::Length => "a record must have 64, 128, ... 4096 samples",
            ConfigError::Records => "the plan is for records of another kind or length",
        }
    }
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for ConfigError {}

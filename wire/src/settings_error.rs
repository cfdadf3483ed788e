//! Why settings cannot work on a board, in numbers for the wire and in words for people.

use crate::config::EncodingError;
use picket_dsp::config::ConfigError;

/// Why a sample rate is impossible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RateError {
    /// The rate is above what the converter does at this clock.
    Fast,
    /// The rate is below 1 Hz, which a timer cannot count, or not a number.
    Slow,
    /// The core cannot measure every block at this rate.
    Load,
    /// The worst block that is known takes longer than it lasts at this rate, and the settings want a rate that holds for it.
    Worst,
    /// The settings want a rate that holds for the worst block, which is not known with settings such as these.
    Unsearched,
}

/// Why a DAC cannot play a chirp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WaveformError {
    /// A code is above 4095, or the lower one is not below the higher one.
    Codes,
    /// No whole number of steps fits a segment at a rate that the DAC can follow: change the guard.
    Steps,
}

/// Why a synthesiser cannot make the ramps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RampError {
    /// The reference is not 10 to 110 MHz.
    Reference,
    /// The band leaves 0.5 to 13 GHz, or INT is below 75.
    Frequency,
    /// The bandwidth or the duration is too small or too large for the words of a step.
    Ramp,
}

/// Why a board cannot gather frames of chirps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FramesError {
    /// The board has no frames.
    Absent,
    /// The scene is no sawtooth, or the settings follow tones or report further ones.
    Scene,
    /// The period is that of an external source: it is told for that source alone.
    Period,
    /// The cells, chirps times bins, are more than the board's memory has room for.
    Cells,
}

/// Why settings cannot work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SettingsError {
    /// The bytes are not settings, or they are damaged.
    Encoding(EncodingError),
    /// The measurement's configuration is refused.
    Config(ConfigError),
    /// The sample rate is impossible.
    Rate(RateError),
    /// The DAC cannot play the chirp.
    Waveform(WaveformError),
    /// The synthesiser cannot make the ramps.
    Ramps(RampError),
    /// This image measures blocks of another length.
    Length,
    /// The guard has more than [`GUARD`](crate::settings::GUARD) samples, or there is a guard
    /// without a chirp.
    Guard,
    /// A chirp lacks a drive, or a drive lacks a chirp.
    Drive,
    /// The sync input needs the gate of the sample clock, which the fastest rate does not have, and which
    /// counts no longer chirp than 2^32 of the timer's ticks.
    Sync,
    /// A correction is not a number, the clock's is above 1000 ppm, the slope is outside 0.5 to 2, or an uncertainty is negative.
    Calibration,
    /// The settings follow tones, which this board cannot do.
    Tracking,
    /// The board's core does not have this clock.
    Speed,
    /// The board does not have memory for this many slots, or needs more of them.
    Slots,
    /// The board has no second converter.
    Iq,
    /// The settings ask for sums or bursts, which this board does not have.
    Signals,
    /// Sums or bursts of a chirp, or together with tracks or further tones; tracks together with further tones; or numbers out of range.
    Mode,
    /// Frames of chirps that this board cannot gather.
    Frames(FramesError),
}

impl SettingsError {
    /// The error as a number for the wire: its group and its case.
    pub const fn code(self) -> [u8; 2] {
        match self {
            SettingsError::Encoding(error) => [1, error as u8],
            SettingsError::Config(error) => [2, error as u8],
            SettingsError::Rate(error) => [3, error as u8],
            SettingsError::Waveform(error) => [4, error as u8],
            SettingsError::Ramps(error) => [5, error as u8],
            SettingsError::Length => [6, 0],
            SettingsError::Guard => [7, 0],
            SettingsError::Drive => [8, 0],
            SettingsError::Sync => [9, 0],
            SettingsError::Calibration => [10, 0],
            // 11 was a band across 0 Hz, which is now searched on both sides of the offset.
            SettingsError::Tracking => [12, 0],
            SettingsError::Speed => [13, 0],
            SettingsError::Slots => [14, 0],
            SettingsError::Iq => [15, 0],
            SettingsError::Signals => [16, 0],
            SettingsError::Mode => [17, 0],
            SettingsError::Frames(error) => [18, error as u8],
        }
    }

    /// The words for a [`SettingsError::code`].
    pub const fn message_of(code: [u8; 2]) -> &'static str {
        match code {
            [1, 1] => {
                "the settings have a version or a field that this image does not know: flash a newer one; only the NUCLEO has most above 1 and harmonics"
            }
            [1, _] => "the settings are damaged or of another version",
            [2, _] => "the configuration does not work",
            [3, 0] => {
                "the sample rate is above what the board can do at this clock: lower rate_hz, or see the board's page in docs/"
            }
            [3, 2] => {
                "the core cannot measure every block at this rate: lower rate_hz or most, or follow tones (see the board's page in docs/)"
            }
            [3, 3] => {
                "worst_case: at this rate the worst known block takes longer than it lasts: lower rate_hz, or set effort to 0 (picket flash --dry-run prints the rates that hold)"
            }
            [3, 4] => {
                "worst_case: the worst block is known only for real records (on the NUCLEO also I/Q) with the usual method, without follow, most, harmonics, sums or bursts: remove these, or worst_case"
            }
            [3, _] => {
                "the sample rate is below what the board can count: raise rate_hz to 1 or more"
            }
            [4, _] => {
                "the DAC cannot play the chirp: codes 0 to 4095, guard so that steps are whole"
            }
            [5, _] => "the synthesiser cannot make these ramps",
            [6, _] => "this image measures blocks of another length",
            [7, _] => {
                "guard samples: at most 64, an even number on the Pico, and only with a chirp"
            }
            [8, _] => "a chirp needs a drive, and a drive a chirp",
            [9, _] => {
                "the sync input works neither at the fastest rate nor for chirps of 47 s or more: change rate_hz"
            }
            [10, _] => {
                "calibration: at most 1000 ppm, slope 0.5 to 2; uncertainty: each standard deviation finite, 0 or more"
            }
            [11, _] => {
                "this older image searches I/Q on one side of 0 Hz only, three bins away or more: flash a newer one, or narrow band_hz"
            }
            [12, _] => "this board does not follow tones: remove follow",
            [14, _] => {
                "slots: 4 to 12 on the NUCLEO, 4 to 16 on the Pico, or 0 for the usual number"
            }
            [15, _] => "I/Q needs a second converter, which this board does not have",
            [16, _] => "this board has neither sums nor bursts: set mode to blocks",
            [17, _] => {
                "mode: sums of 1 to 65536 blocks or bursts from a ratio of 1.05 on need a tone or a Doppler scene, without follow, most or harmonics; follow excludes most and harmonics"
            }
            [18, 0] => {
                "this board has no frames of chirps, only the NUCLEO has: set mode to blocks"
            }
            [18, 1] => {
                "frames are of sawtooth chirps, without follow, most or harmonics: set shape to sawtooth, or mode to blocks"
            }
            [18, 2] => {
                "frames: period_s belongs to the drive external, which needs it: the time from one chirp's start to the next's"
            }
            [18, _] => {
                "frames: the NUCLEO has room for 7680 cells, chirps x bins, such as 64 x 120: take fewer chirps, or narrow band_hz or range_m"
            }
            [13, _] => "the board has no such core_mhz: see its page in docs/, or leave it at 0",
            _ => "the settings do not work",
        }
    }
}

impl core::fmt::Display for SettingsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            SettingsError::Config(error) => error.fmt(f),
            other => f.write_str(Self::message_of(other.code())),
        }
    }
}

impl core::error::Error for SettingsError {}

//! A measurement's configuration as bytes: the part that captures and settings share.
//!
//! | offset | field |
//! |---|---|
//! | 0 | flags: u8, bit 0 I/Q records, bit 1 a band, bit 2 the less usual mixing |
//! | 1 | method: u8 |
//! | 2 | scene: u8, 0 tone, 1 Doppler, 2 chirp |
//! | 3 | shape of a chirp: u8, 0 trapezoid, 1 triangle, 2 sawtooth |
//! | 4 | bins on each side that least squares reads: u8 |
//! | 5 | arithmetic: low 4 bits, 0 float, 1 fixed; effort: high 4 bits, 0 look, 1 one, 2 full |
//! | 6 | tones followed: u8 |
//! | 7 | blocks from search to search: u8 |
//! | 8 | the converter's lowest and highest code: 2 i16 |
//! | 12 | samples in a block: u32 |
//! | 16 | rate, band's ends: 3 f64, Hz |
//! | 40 | wavelength, angle or bandwidth, duration: 3 f64 |
//! | 64 | probability of a false alarm: f64 |
//! | 72 | what earlier trackers took: 2 f32, 0.05 and 0; rate of following: f32 |
//!
//! The usual mixing is tx-conj-rx for a chirp, and rx-conj-tx for a Doppler scene. Bit 2 is clear in what layouts without it
//! have written, and these mean the usual one.

use crate::bytes::{Reader, Writer};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::spectrum::fft::twiddle::supported;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;

/// Why bytes are not a capture or not settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodingError {
    /// The bytes do not begin with the magic number.
    Magic,
    /// The bytes are of another version.
    Version,
    /// The checksum is wrong.
    Checksum,
    /// A field has an unknown value.
    Field,
    /// The number of samples in a block is not 64, 128, ... 4096.
    Length,
}

impl core::fmt::Display for EncodingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl EncodingError {
    /// The error in one line.
    pub const fn message(self) -> &'static str {
        match self {
            EncodingError::Magic => "this is not a capture",
            EncodingError::Version => "the capture is of another version",
            EncodingError::Checksum => "the capture's header is damaged",
            EncodingError::Field => "the capture's header has a value without a meaning",
            EncodingError::Length => "a block must have 64, 128, ... 4096 samples",
        }
    }
}

impl core::error::Error for EncodingError {}

/// Length of a configuration, bytes.
pub(crate) const BYTES: usize = 84;

/// Writes a configuration for records of this kind and length.
pub(crate) fn put(writer: &mut Writer<'_>, iq: bool, n: u32, config: &Config) {
    let (band, ends) = match config.band_hz {
        Some((low, high)) => (true, [low, high]),
        None => (false, [0.0; 2]),
    };
    let (scene, shape, scales) = match config.scene {
        Scene::Tone => (0, 0, [0.0; 3]),
        Scene::Doppler { wavelength_m, angle_rad, .. } => (1, 0, [wavelength_m, angle_rad, 0.0]),
        Scene::Chirp(Chirp { shape, wavelength_m, bandwidth_hz, duration_s, .. }) => {
            (2, shape as u8, [wavelength_m, bandwidth_hz, duration_s])
        }
        // A scene of a later library has no number here, and every reader refuses this one.
        _ => (u8::MAX, 0, [0.0; 3]),
    };
    let (lowest, highest) = config.codes.rails();
    let Following { rate_bins, most, refresh } = config.following;
    let flags = u8::from(iq) | u8::from(band) << 1 | u8::from(unusual(config)) << 2;
    writer.put([flags, config.method.id(), scene, shape]);
    let how = config.arithmetic as u8 | config.effort.number() << 4;
    writer.put([config.reach.bins() as u8, how, most, refresh]);
    writer.i16(lowest);
    writer.i16(highest);
    writer.u32(n);
    writer.f64(config.rate_hz);
    for number in ends.into_iter().chain(scales) {
        writer.f64(number);
    }
    writer.f64(config.false_alarm);
    for number in [0.05, 0.0, rate_bins] {
        writer.f32(number);
    }
}

/// Whether a scene has the less usual mixing.
pub(crate) fn unusual(config: &Config) -> bool {
    match config.scene {
        Scene::Doppler { mixing, .. } => mixing != Mixing::RxConjTx,
        Scene::Chirp(Chirp { mixing, .. }) => mixing != Mixing::TxConjRx,
        _ => false,
    }
}

/// Reads a configuration: whether the records are I/Q, their length and the rest. The caller checks
/// it further.
pub(crate) fn take(reader: &mut Reader<'_>) -> Result<(bool, u32, Config), EncodingError> {
    let (iq, n, config) = fields(reader).ok_or(EncodingError::Field)?;
    if supported(n as usize) { Ok((iq, n, config)) } else { Err(EncodingError::Length) }
}

fn fields(reader: &mut Reader<'_>) -> Option<(bool, u32, Config)> {
    let [flags, method, scene, shape] = reader.take()?;
    let [reach, how, most, refresh] = reader.take()?;
    let (lowest, highest) = (reader.i16()?, reader.i16()?);
    let n = reader.u32()?;
    let rate_hz = reader.f64()?;
    let (low, high) = (reader.f64()?, reader.f64()?);
    let (wavelength_m, second, third) = (reader.f64()?, reader.f64()?, reader.f64()?);
    let false_alarm = reader.f64()?;
    let (_, _, rate_bins) = (reader.f32()?, reader.f32()?, reader.f32()?);
    let unusual = flags & 4 != 0;
    let shape = match shape {
        0 => Shape::Trapezoid,
        1 => Shape::Triangle,
        2 => Shape::Sawtooth,
        _ => return None,
    };
    let config = Config {
        rate_hz,
        codes: Codes::between(lowest, highest)?,
        band_hz: (flags & 2 != 0).then_some((low, high)),
        method: Method::from_u8(method)?,
        reach: match reach {
            4 => Reach::Four,
            8 => Reach::Eight,
            16 => Reach::Sixteen,
            _ => return None,
        },
        arithmetic: match how & 15 {
            0 => Arithmetic::Float,
            1 => Arithmetic::Fixed,
            _ => return None,
        },
        effort: Effort::from_number(how >> 4)?,
        false_alarm,
        range_m: None,
        velocity_mps: None,
        scene: match scene {
            0 => Scene::Tone,
            1 => Scene::Doppler {
                wavelength_m,
                angle_rad: second,
                mixing: if unusual { Mixing::TxConjRx } else { Mixing::RxConjTx },
            },
            2 => Scene::Chirp(Chirp {
                shape,
                wavelength_m,
                bandwidth_hz: second,
                duration_s: third,
                mixing: if unusual { Mixing::RxConjTx } else { Mixing::TxConjRx },
                ..Chirp::default()
            }),
            _ => return None,
        },
        following: Following { rate_bins, most, refresh },
        carrier: Carrier::default(),
    };
    Some((flags & 1 != 0, n, config))
}

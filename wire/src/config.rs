//! A measurement's configuration, which captures and settings share.

use crate::layout::{Field, Form, Reader, Writer, choice, layout, named};
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
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

named! {
    Arithmetic: "arithmetic", |arithmetic| *arithmetic as u8, |number| match number {
        0 => Some(Arithmetic::Float),
        1 => Some(Arithmetic::Fixed),
        _ => None,
    }, |arithmetic| match arithmetic {
        Arithmetic::Float => "float",
        Arithmetic::Fixed => "fixed",
    };
    Effort: "effort", |effort| effort.rounds(), Effort::from_rounds, |effort| effort.name();
    Shape: "shape", |shape| *shape as u8, |number| match number {
        0 => Some(Shape::Trapezoid),
        1 => Some(Shape::Triangle),
        2 => Some(Shape::Sawtooth),
        _ => None,
    }, |shape| match shape {
        Shape::Trapezoid => "trapezoid",
        Shape::Triangle => "triangle",
        Shape::Sawtooth => "sawtooth",
    };
    Mixing: "mixing", |mixing| *mixing as u8,
        |number| Mixing::ALL.get(usize::from(number)).copied(), |mixing| mixing.name();
    Reach: "reach", |reach| reach.bins() as u8, |number| match number {
        4 => Some(Reach::Four),
        8 => Some(Reach::Eight),
        16 => Some(Reach::Sixteen),
        _ => None,
    }, |reach| match reach {
        Reach::Four => "4",
        Reach::Eight => "8",
        Reach::Sixteen => "16",
    };
}

impl Field for Codes {
    const FORM: Form = <(i16, i16)>::FORM;
    const MOST: usize = <(i16, i16)>::MOST;

    fn put(&self, writer: &mut Writer<'_>) {
        self.rails().put(writer);
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        Field::take(reader).and_then(|(low, high)| Codes::between(low, high))
    }
}

layout! {
    /// A measurement's configuration.
    Config {
        /// Sample rate, Hz.
        rate_hz: f64,
        /// The converter's lowest and highest code.
        codes: Codes,
        /// The band to search, low end first, Hz.
        band_hz: Option<(f64, f64)>,
        /// The ranges that a target may have, low end first, m.
        range_m: Option<(f64, f64)>,
        /// The velocities that a target may have, low end first, m/s.
        velocity_mps: Option<(f64, f64)>,
        /// Method of estimation.
        method: Method,
        /// Bins on each side that least squares reads.
        reach: Reach,
        /// Arithmetic of least squares.
        arithmetic: Arithmetic,
        /// The most rounds of the joint fit of a line that is not a steady tone.
        effort: Effort,
        /// Probability of a false alarm, for each block.
        false_alarm: f64,
        /// What the samples are taken of.
        scene: Scene,
        /// How tones are followed.
        following: Following,
        /// The width of the tone itself.
        carrier: Carrier,
    }

    /// A chirp.
    Chirp {
        /// Shape of the ramps.
        shape: Shape,
        /// Wavelength of the carrier, m.
        wavelength_m: f64,
        /// How far a ramp rises, Hz.
        bandwidth_hz: f64,
        /// Duration of a segment, s.
        duration_s: f64,
        /// Time from a segment's start to its first sample, s.
        guard_s: f64,
        /// The signal that the receiver conjugates.
        mixing: Mixing,
        /// Curvature of the sweep, of the bandwidth; 0 for straight ramps.
        sweep_curvature: f64,
    }

    /// How tones are followed.
    Following {
        /// Sigma of a new target's rate, bins per block.
        rate_bins: f32,
        /// Tones followed at once, 0 to 4.
        most: u8,
        /// One block in `refresh` is searched whole; 0 or 1 searches all.
        refresh: u8,
    }

    /// The width of the tone itself.
    Carrier {
        /// Linewidth, Hz.
        linewidth_hz: f32,
        /// Bandwidth of the envelope, Hz.
        envelope_hz: f32,
    }

    /// When a burst begins and ends.
    Trigger {
        /// Energy over that of the noise at which a burst begins; none for the usual one.
        ratio: Option<f32>,
        /// Samples after a record in which no burst begins.
        hold_off: u32,
        /// Least energy per sample, squared codes.
        least: u32,
    }
}

choice! {
    Scene {
        0 Tone {},
        1 Doppler {
            /// Wavelength, m.
            wavelength_m: f64,
            /// Angle between beam and motion, radians.
            angle_rad: f64,
            /// The signal that the receiver conjugates.
            mixing: Mixing,
        },
        2 Chirp(chirp: Chirp),
    }
}

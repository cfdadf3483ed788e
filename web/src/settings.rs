//! What the page has set, by name, and the configuration that follows from it.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::{Config, Following, SPEED_OF_LIGHT, Scene};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_recording::{Converter, Format};

/// Formats that a user may choose, in the order of the page.
pub const FORMATS: [Format; 14] = [
    Format::I8,
    Format::U8,
    Format::I16,
    Format::U16,
    Format::I32,
    Format::F32,
    Format::F64,
    Format::Cs8,
    Format::Cu8,
    Format::Cs16,
    Format::Iiqq,
    Format::Cf32,
    Format::Csv,
    Format::Npy,
];

/// What the samples are taken of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// A tone.
    #[default]
    Tone,
    /// A Doppler shift.
    Doppler,
    /// A trapezoid of ramps.
    Chirp,
}

/// The instrument's settings.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Samples in a block.
    pub n: usize,
    /// I/Q records.
    pub iq: bool,
    /// The converter's codes.
    pub codes: Codes,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// The band searched, Hz; nothing set where both ends are 0.
    pub band_hz: (f64, f64),
    /// What is measured.
    pub kind: Kind,
    /// Wavelength of the carrier, m.
    pub wavelength_m: f64,
    /// Bandwidth of a ramp, Hz.
    pub bandwidth_hz: f64,
    /// Which signal an I/Q receiver conjugates; the scene's usual one where nothing is said.
    pub mixing: Option<Mixing>,
    /// The most tones followed.
    pub most: u8,
    /// Whether the displacement of a Doppler radar's target is followed.
    pub displacement: bool,
    /// Blocks that are added without their phases for an answer; 1 where each block has its own.
    pub sum: u32,
    /// A file's format; the one that it shows where nothing is said.
    pub format: Option<Format>,
    /// The converter that a file's numbers are codes of.
    pub converter: Converter,
    /// Codes per unit of a file; 0 where its numbers decide.
    pub scale: f64,
    /// The rate, Hz, of a file that does not know its own; 0 where nothing is said.
    pub file_rate_hz: f64,
    /// The carrier, Hz, of a file of a Doppler radar; 0 where nothing is said.
    pub carrier_hz: f64,
    /// What the ramps of a file sweep, Hz, how long, from one to the next, s, and how many make a frame; 0 where nothing is said.
    pub file_bandwidth_hz: f64,
    /// See there.
    pub chirp_s: f64,
    /// See there.
    pub period_s: f64,
    /// See there.
    pub chirps: usize,
    /// From a ramp's start to its record's first sample, s; 0 where nothing is said.
    pub guard_s: f64,
    /// The velocities that its targets may have, m/s; nothing said where both are 0.
    pub velocity_mps: (f64, f64),
    /// The channel of a file, from 1, and the one that is Q; 0 where nothing is said.
    pub channel: (usize, usize),
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            n: 1024,
            iq: false,
            codes: Codes::signed::<12>(),
            rate_hz: 48e3,
            band_hz: (0.0, 0.0),
            kind: Kind::Tone,
            wavelength_m: 0.0125,
            bandwidth_hz: 200e6,
            mixing: None,
            most: 4,
            displacement: false,
            sum: 1,
            format: None,
            converter: Converter { bits: 12, unsigned: false },
            scale: 0.0,
            file_rate_hz: 0.0,
            carrier_hz: 0.0,
            file_bandwidth_hz: 0.0,
            chirp_s: 0.0,
            period_s: 0.0,
            chirps: 0,
            guard_s: 0.0,
            velocity_mps: (0.0, 0.0),
            channel: (0, 0),
        }
    }
}

impl Settings {
    /// Sets a value by its name; false for an unknown name or a value without meaning.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        // Casts saturate.
        match name {
            "n" => self.n = value as usize,
            "iq" => self.iq = value != 0.0,
            "rate_hz" => self.rate_hz = value,
            "band_low_hz" => self.band_hz.0 = value,
            "band_high_hz" => self.band_hz.1 = value,
            "wavelength_m" => self.wavelength_m = value,
            "bandwidth_hz" => self.bandwidth_hz = value,
            "mixing" => {
                let mixing =
                    Mixing::ALL.into_iter().find(|&mixing| f64::from(mixing as u8) == value);
                self.mixing = mixing;
            }
            "most" => self.most = value as u8,
            "displacement" => self.displacement = value != 0.0,
            "sum" => self.sum = value.max(1.0) as u32,
            // Counted from 1.
            "format" => self.format = FORMATS.get((value as usize).wrapping_sub(1)).copied(),
            "scale" => self.scale = value,
            "file_rate_hz" => self.file_rate_hz = value,
            "carrier_hz" => self.carrier_hz = value,
            "file_bandwidth_hz" => self.file_bandwidth_hz = value,
            "chirp_s" => self.chirp_s = value,
            "period_s" => self.period_s = value,
            "chirps" => self.chirps = value as usize,
            "guard_s" => self.guard_s = value,
            "velocity_low_mps" => self.velocity_mps.0 = value,
            "velocity_high_mps" => self.velocity_mps.1 = value,
            "channel" => self.channel.0 = value as usize,
            "channel_q" => self.channel.1 = value as usize,
            "kind" => {
                self.kind = match value as u8 {
                    1 => Kind::Doppler,
                    2 => Kind::Chirp,
                    _ => Kind::Tone,
                }
            }
            // Unsigned ones as negative widths. Of 16 bits they are read as signed ones.
            "bits" => {
                let (bits, unsigned) = (value.abs() as u32, value < 0.0);
                match Codes::from_bits(!unsigned || bits == 16, bits) {
                    Some(codes) => {
                        (self.codes, self.converter) = (codes, Converter { bits, unsigned });
                    }
                    None => return false,
                }
            }
            _ => return false,
        }
        true
    }

    /// Takes the kind of a file's target from its carrier.
    pub fn of_file(&mut self) {
        self.kind = if self.carrier_hz > 0.0 { Kind::Doppler } else { Kind::Tone };
        if self.kind == Kind::Doppler {
            self.wavelength_m = SPEED_OF_LIGHT / self.carrier_hz;
        }
    }

    /// The metres per second of a hertz of a Doppler shift, negative where approaching lowers it; 0 of other kinds.
    pub fn speed(&self) -> f64 {
        let mixing = self.mixing.unwrap_or(Mixing::RxConjTx);
        let sign = if self.iq { -f64::from(mixing.sign()) } else { 1.0 };
        if self.kind == Kind::Doppler { sign * (self.wavelength_m / 2.0) } else { 0.0 }
    }

    /// The library's configuration.
    pub fn config(&self) -> Config {
        let scene = match self.kind {
            Kind::Tone => Scene::Tone,
            Kind::Doppler => Scene::Doppler {
                wavelength_m: self.wavelength_m,
                angle_rad: 0.0,
                mixing: self.mixing.unwrap_or(Mixing::RxConjTx),
            },
            Kind::Chirp => Scene::Chirp(Chirp {
                shape: Shape::Trapezoid,
                wavelength_m: self.wavelength_m,
                bandwidth_hz: self.bandwidth_hz,
                duration_s: self.n as f64 / self.rate_hz,
                mixing: self.mixing.unwrap_or_default(),
                ..Chirp::default()
            }),
        };
        Config {
            band_hz: (self.band_hz != (0.0, 0.0)).then_some(self.band_hz),
            scene,
            following: Following { most: self.most, ..Following::default() },
            ..Config::new(self.rate_hz, self.codes)
        }
    }

    /// Full scale: the amplitude of a sine from rail to rail, in codes.
    pub fn full_scale(&self) -> f64 {
        let (low, high) = self.codes.rails();
        (f64::from(high) - f64::from(low)) / 2.0
    }
}

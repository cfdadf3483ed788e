//! A recording with all that is needed to measure it: what a user sets and the samples, in one
//! file. An emulated board plays it as its converter.
//!
//! A header of [`Header::BYTES`] bytes, then the blocks without gaps, each sample an `i16` (I/Q: two), all
//! little-endian.

use crate::acquire::frontend::Timing;
use crate::acquire::sample::{Codes, Iq, Real, Record, Segment};
use crate::config::{Config, Following, Scene};
use crate::estimate::least_squares::Reach;
use crate::estimate::measure::Arithmetic;
use crate::estimate::method::Method;
use crate::solve::chirp::Shape;
use crc::{CRC_32_ISO_HDLC, Crc};

/// What precedes the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// True for I/Q pairs.
    pub iq: bool,
    /// Samples in a block.
    pub n: u32,
    /// Blocks in the file.
    pub blocks: u32,
    /// Samples from the start of one block to the start of the next; more than `n` where a ramp is
    /// longer than its record, less where blocks overlap.
    pub stride: u32,
    /// The order in which ramps follow each other.
    pub pattern: Pattern,
    /// Microseconds between two blocks on an emulated board; 0 for so long that none is lost.
    pub period_us: u32,
    /// What the user sets.
    pub config: Config,
}

/// The order in which ramps follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Pattern {
    /// No ramps.
    #[default]
    Continuous = 0,
    /// Up only.
    Sawtooth = 1,
    /// Up, down.
    Triangle = 2,
    /// Up, flat, down.
    Trapezoid = 3,
}

impl Pattern {
    /// The pattern that a scene asks for.
    pub const fn of(scene: &Scene) -> Self {
        match scene {
            Scene::Tone | Scene::Doppler { .. } => Pattern::Continuous,
            Scene::Chirp { shape: Shape::Sawtooth, .. } => Pattern::Sawtooth,
            Scene::Chirp { shape: Shape::Triangle, .. } => Pattern::Triangle,
            Scene::Chirp { shape: Shape::Trapezoid, .. } => Pattern::Trapezoid,
        }
    }

    /// The segments, in their order; none without ramps.
    pub const fn segments(self) -> &'static [Segment] {
        match self {
            Pattern::Continuous => &[],
            Pattern::Sawtooth => &[Segment::Up],
            Pattern::Triangle => &[Segment::Up, Segment::Down],
            Pattern::Trapezoid => &[Segment::Up, Segment::Flat, Segment::Down],
        }
    }
}

/// Why a file is not a capture that can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HeaderError {
    /// It does not begin as a capture does.
    Magic,
    /// It is of another version.
    Version,
    /// Its checksum is wrong.
    Checksum,
    /// A field has a value without a meaning.
    Field,
    /// The number of samples in a block is not 64, 128, ... 4096.
    Length,
}

impl core::fmt::Display for HeaderError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl HeaderError {
    /// One line.
    pub const fn message(self) -> &'static str {
        match self {
            HeaderError::Magic => "this is not a capture",
            HeaderError::Version => "the capture is of another version",
            HeaderError::Checksum => "the capture's header is damaged",
            HeaderError::Field => "the capture's header has a value without a meaning",
            HeaderError::Length => "a block must have 64, 128, ... 4096 samples",
        }
    }
}

impl core::error::Error for HeaderError {}

const MAGIC: [u8; 4] = *b"PKCP";
const VERSION: u8 = 2;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

impl Header {
    /// The size of a header.
    pub const BYTES: usize = 112;

    /// The header of records of kind `R` for this configuration: blocks of `n` samples that follow each
    /// other closely.
    pub const fn of<R: Record>(config: Config, n: u32, blocks: u32) -> Self {
        let pattern = Pattern::of(&config.scene);
        Header { iq: R::IQ, n, blocks, stride: n, pattern, period_us: 0, config }
    }

    /// Bytes of one block.
    pub const fn block_bytes(&self) -> usize {
        self.n as usize * if self.iq { 4 } else { 2 }
    }

    /// How blocks follow each other.
    pub const fn timing(&self) -> Timing {
        Timing { period: self.stride, segments: self.pattern.segments() }
    }

    /// As stored.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let config = &self.config;
        let (band, [low, high]) = match config.band_hz {
            Some((low, high)) => (1, [low, high]),
            None => (0, [0.0; 2]),
        };
        let (scene, shape, scales) = match config.scene {
            Scene::Tone => (0, 0, [0.0; 3]),
            Scene::Doppler { wavelength_m, angle_rad } => (1, 0, [wavelength_m, angle_rad, 0.0]),
            Scene::Chirp { shape, wavelength_m, bandwidth_hz, duration_s } => {
                (2, shape as u8, [wavelength_m, bandwidth_hz, duration_s])
            }
        };
        let codes = match config.codes {
            Codes::Signed12 => 0,
            Codes::Unsigned12 => 1,
            Codes::Signed16 => 2,
        };
        let mut bytes = [0; Self::BYTES];
        let mut writer = Writer(&mut bytes);
        writer.put(MAGIC);
        writer.put([VERSION, self.iq as u8, codes, config.method as u8]);
        writer.put([scene, shape, self.pattern as u8, band]);
        for word in [self.n, self.blocks, self.stride, self.period_us] {
            writer.put(word.to_le_bytes());
        }
        for number in [config.rate_hz, low, high].into_iter().chain(scales) {
            writer.put(number.to_le_bytes());
        }
        writer.put(config.false_alarm.to_le_bytes());
        writer.put([config.reach.bins() as u8, config.arithmetic as u8]);
        let Following { agility, acceleration_bins, rate_bins, most, refresh } = config.following;
        writer.put([most, refresh]);
        for number in [agility, acceleration_bins, rate_bins] {
            writer.put(number.to_le_bytes());
        }
        if let Some((body, last)) = bytes.split_last_chunk_mut() {
            *last = CRC.checksum(body).to_le_bytes();
        }
        bytes
    }

    /// Reads a header. The configuration is not checked further: see [`Config::validate`].
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Result<Self, HeaderError> {
        let mut reader = Reader(bytes);
        if reader.take() != MAGIC {
            return Err(HeaderError::Magic);
        }
        let [version, iq, codes, method] = reader.take();
        if version != VERSION {
            return Err(HeaderError::Version);
        }
        if let Some((body, &last)) = bytes.split_last_chunk()
            && CRC.checksum(body) != u32::from_le_bytes(last)
        {
            return Err(HeaderError::Checksum);
        }
        let [scene, shape, pattern, band] = reader.take();
        let [n, blocks, stride, period_us] = [(); 4].map(|()| u32::from_le_bytes(reader.take()));
        let [rate_hz, low, high, wavelength_m, second, third, false_alarm] =
            [(); 7].map(|()| f64::from_le_bytes(reader.take()));
        if !crate::spectrum::fft::twiddle::supported(n as usize) {
            return Err(HeaderError::Length);
        }
        let shape = match shape {
            0 => Shape::Trapezoid,
            1 => Shape::Triangle,
            2 => Shape::Sawtooth,
            _ => return Err(HeaderError::Field),
        };
        let scene = match scene {
            0 => Scene::Tone,
            1 => Scene::Doppler { wavelength_m, angle_rad: second },
            2 => Scene::Chirp { shape, wavelength_m, bandwidth_hz: second, duration_s: third },
            _ => return Err(HeaderError::Field),
        };
        let codes = match codes {
            0 => Codes::Signed12,
            1 => Codes::Unsigned12,
            2 => Codes::Signed16,
            _ => return Err(HeaderError::Field),
        };
        let pattern = match pattern {
            0 => Pattern::Continuous,
            1 => Pattern::Sawtooth,
            2 => Pattern::Triangle,
            3 => Pattern::Trapezoid,
            _ => return Err(HeaderError::Field),
        };
        let method = Method::from_u8(method).ok_or(HeaderError::Field)?;
        let [reach, arithmetic] = reader.take();
        let reach = match reach {
            4 => Reach::Four,
            8 => Reach::Eight,
            16 => Reach::Sixteen,
            _ => return Err(HeaderError::Field),
        };
        let arithmetic = match arithmetic {
            0 => Arithmetic::Float,
            1 => Arithmetic::Fixed,
            _ => return Err(HeaderError::Field),
        };
        let [most, refresh] = reader.take();
        let [agility, acceleration_bins, rate_bins] =
            [(); 3].map(|()| f32::from_le_bytes(reader.take()));
        let following = Following { agility, acceleration_bins, rate_bins, most, refresh };
        let band_hz = (band == 1).then_some((low, high));
        let config = Config {
            rate_hz,
            codes,
            band_hz,
            method,
            reach,
            arithmetic,
            false_alarm,
            scene,
            following,
        };
        Ok(Header { iq: iq == 1, n, blocks, stride, pattern, period_us, config })
    }
}

/// Reads samples as a capture stores them, as many as both sides hold.
pub fn decode<R: Record>(bytes: &[u8], samples: &mut [R::Sample]) {
    let words = bytes.as_chunks().0.iter().map(|&word| i16::from_le_bytes(word));
    if R::IQ {
        let pairs = bytes.as_chunks::<4>().0.iter();
        for (sample, &[a, b, c, d]) in samples.iter_mut().zip(pairs) {
            *sample = R::of_parts([i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])]);
        }
    } else {
        for (sample, word) in samples.iter_mut().zip(words) {
            *sample = R::of_parts([word, 0]);
        }
    }
}

/// Work to be done with records of a kind and length that are known only at run time.
pub trait ForRecord {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run<R: Record, const N: usize>(self) -> Self::Output;
}

/// Does `work` for records of this kind and length; `None` for a length the FFT does not support.
///
/// The code of all fourteen combinations is in the program, the memory of one in use.
pub fn for_record<W: ForRecord>(iq: bool, n: usize, work: W) -> Option<W::Output> {
    Some(match (iq, n) {
        (false, 64) => work.run::<Real, 64>(),
        (false, 128) => work.run::<Real, 128>(),
        (false, 256) => work.run::<Real, 256>(),
        (false, 512) => work.run::<Real, 512>(),
        (false, 1024) => work.run::<Real, 1024>(),
        (false, 2048) => work.run::<Real, 2048>(),
        (false, 4096) => work.run::<Real, 4096>(),
        (true, 64) => work.run::<Iq, 64>(),
        (true, 128) => work.run::<Iq, 128>(),
        (true, 256) => work.run::<Iq, 256>(),
        (true, 512) => work.run::<Iq, 512>(),
        (true, 1024) => work.run::<Iq, 1024>(),
        (true, 2048) => work.run::<Iq, 2048>(),
        (true, 4096) => work.run::<Iq, 4096>(),
        _ => return None,
    })
}

/// Writes one field after the other; what does not fit is left out.
struct Writer<'a>(&'a mut [u8]);

impl Writer<'_> {
    fn put<const L: usize>(&mut self, field: [u8; L]) {
        if let Some((place, rest)) = core::mem::take(&mut self.0).split_first_chunk_mut() {
            *place = field;
            self.0 = rest;
        }
    }
}

/// Reads one field after the other; zeros beyond the end.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const L: usize>(&mut self) -> [u8; L] {
        match self.0.split_first_chunk() {
            Some((&field, rest)) => {
                self.0 = rest;
                field
            }
            None => [0; L],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers() -> [Header; 3] {
        let config = Config { rate_hz: 48e3, codes: Codes::Signed16, ..Config::default() };
        let lidar = Scene::Chirp {
            shape: Shape::Triangle,
            wavelength_m: 1550e-9,
            bandwidth_hz: 1e9,
            duration_s: 1e-5,
        };
        let velocimeter = Scene::Doppler { wavelength_m: 0.0125, angle_rad: 0.3 };
        [
            Header::of::<Real>(config, 64, 7),
            Header {
                stride: 2500,
                period_us: 9,
                ..Header::of::<Iq>(Config { scene: lidar, ..config }, 4096, u32::MAX)
            },
            Header::of::<Real>(
                Config { scene: velocimeter, band_hz: Some((-1.5, 2e3)), ..config },
                1024,
                0,
            ),
        ]
    }

    #[test]
    fn a_header_comes_back_as_it_was() {
        for header in headers() {
            assert_eq!(Header::from_bytes(&header.to_bytes()), Ok(header));
        }
    }

    #[test]
    fn any_changed_bit_is_seen() {
        for header in headers() {
            for bit in 0..Header::BYTES * 8 {
                let mut bytes = header.to_bytes();
                bytes[bit / 8] ^= 1 << (bit % 8);
                assert!(Header::from_bytes(&bytes).is_err(), "bit {bit}");
            }
        }
    }

    #[test]
    fn lengths_that_the_transform_does_not_support_are_refused() {
        for n in [0, 1, 32, 63, 100, 8192, u32::MAX] {
            let header = Header { n, ..headers()[0] };
            assert_eq!(Header::from_bytes(&header.to_bytes()), Err(HeaderError::Length), "{n}");
        }
    }
}

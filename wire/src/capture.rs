//! A recording with everything needed to measure it: the configuration and the samples, in one
//! file. An emulated board plays it as its converter.
//!
//! The file is a header of [`Header::BYTES`] bytes and then the blocks, without gaps. Each sample
//! is an `i16` (I/Q: two). All numbers are little-endian. A header is a magic number of 4 bytes, a version u8, the structure
//! [`Header`], zeros, and the CRC-32 of all before.

pub use crate::config::EncodingError;
use crate::layout::{Field, Reader, VERSION, Writer, layout};
use crc::{CRC_32_ISO_HDLC, Crc};
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::Config;
use picket_dsp::spectrum::fft::twiddle::supported;

/// The header, which precedes the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// True for I/Q pairs.
    pub iq: bool,
    /// Samples in a block.
    pub n: u32,
    /// Blocks in the file.
    pub blocks: u32,
    /// Samples from the start of one block to the start of the next. It is more than `n` if a ramp
    /// is longer than its record, and less if blocks overlap.
    pub stride: u32,
    /// Microseconds between two blocks on an emulated board; 0 for a period long enough to lose
    /// none.
    pub period_us: u32,
    /// The configuration.
    pub config: Config,
}

layout! {
    /// The header of a capture.
    Header {
        /// Records are I/Q pairs.
        iq: bool,
        /// Samples in a block.
        n: u32,
        /// Blocks in the file.
        blocks: u32,
        /// Samples from the start of one block to the start of the next.
        stride: u32,
        /// Microseconds between two blocks on an emulated board; 0 for a period long enough to lose none.
        period_us: u32,
        /// The configuration.
        config: Config,
    }
}

const MAGIC: [u8; 4] = *b"PKCQ";
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

impl Header {
    /// Length of a header, bytes.
    pub const BYTES: usize = (4 + 1 + <Self as Field>::MOST + 4).next_multiple_of(4);

    /// The header for this configuration: records of kind `R`, blocks of `n` samples that follow
    /// each other without a pause.
    pub const fn from_config<R: Record>(config: Config, n: u32, blocks: u32) -> Self {
        Header { iq: R::IQ, n, blocks, stride: n, period_us: 0, config }
    }

    /// Length of one block, bytes.
    pub const fn block_bytes(&self) -> usize {
        self.n as usize * if self.iq { 4 } else { 2 }
    }

    /// How blocks follow each other.
    pub const fn timing(&self) -> Timing {
        Timing { period: self.stride, segments: self.config.scene.segments() }
    }

    /// The header as bytes.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        let mut writer = Writer::new(&mut bytes);
        MAGIC.put(&mut writer);
        VERSION.put(&mut writer);
        self.put(&mut writer);
        if let Some((body, last)) = bytes.split_last_chunk_mut() {
            *last = CRC.checksum(body).to_le_bytes();
        }
        bytes
    }

    /// Reads a header. [`Config::terms`] checks its configuration further.
    ///
    /// # Errors
    /// The bytes are no capture, are of another version, are damaged, or a field has an unknown
    /// value.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Result<Self, EncodingError> {
        let mut reader = Reader::new(bytes);
        if Field::take(&mut reader) != Some(MAGIC) {
            return Err(EncodingError::Magic);
        }
        if Field::take(&mut reader) != Some(VERSION) {
            return Err(EncodingError::Version);
        }
        if let Some((body, &last)) = bytes.split_last_chunk()
            && CRC.checksum(body) != u32::from_le_bytes(last)
        {
            return Err(EncodingError::Checksum);
        }
        let header = <Self as Field>::take(&mut reader).ok_or(EncodingError::Field)?;
        if supported(header.n as usize) { Ok(header) } else { Err(EncodingError::Length) }
    }
}

/// Reads samples as a capture stores them, as many as fit both sides.
pub fn decode<R: Record>(bytes: &[u8], samples: &mut [R::Sample]) {
    let words = bytes.as_chunks().0.iter().map(|&word| i16::from_le_bytes(word));
    if R::IQ {
        let pairs = bytes.as_chunks::<4>().0.iter();
        for (sample, &[a, b, c, d]) in samples.iter_mut().zip(pairs) {
            *sample = R::from_parts([i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])]);
        }
    } else {
        for (sample, word) in samples.iter_mut().zip(words) {
            *sample = R::from_parts([word, 0]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::codes::Codes;
    use picket_dsp::acquire::sample::{Iq, Real};
    use picket_dsp::config::Scene;
    use picket_dsp::solve::chirp::{Mixing, Shape};
    use picket_dsp::solve::equations::Chirp;

    fn headers() -> [Header; 3] {
        let config = Config::new(48e3, Codes::signed::<16>());
        let lidar = Scene::Chirp(Chirp {
            shape: Shape::Triangle,
            wavelength_m: 1550e-9,
            bandwidth_hz: 1e9,
            duration_s: 1e-5,
            guard_s: 1e-6,
            mixing: Mixing::RxConjTx,
            sweep_curvature: -0.01,
        });
        let velocimeter =
            Scene::Doppler { wavelength_m: 0.0125, angle_rad: 0.3, mixing: Mixing::TxConjRx };
        [
            Header::from_config::<Real>(config, 64, 7),
            Header {
                stride: 2500,
                period_us: 9,
                ..Header::from_config::<Iq>(Config { scene: lidar, ..config }, 4096, u32::MAX)
            },
            Header::from_config::<Real>(
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
            assert_eq!(Header::from_bytes(&header.to_bytes()), Err(EncodingError::Length), "{n}");
        }
    }
}

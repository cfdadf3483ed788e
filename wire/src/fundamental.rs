//! The fundamental of a block's harmonics. It follows the block's telemetry.

use crate::layout::{layout, record};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::tone::harmonic::Harmonic;

/// The fundamental of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fundamental {
    /// The block's sequence number.
    pub sequence: u32,
    /// The block's segment.
    pub segment: Segment,
    /// The fundamental. Its sample rate is that of the block's telemetry, and 0 here.
    pub harmonic: Harmonic,
}

layout! {
    /// The fundamental of a block's harmonics.
    Fundamental {
        /// Number of the block.
        sequence: u32,
        /// Segment of the chirp.
        segment: Segment,
        /// The fundamental.
        harmonic: Harmonic,
    }
}

record!(Fundamental, Fundamental, |fundamental| fundamental.harmonic.tone.is_consistent());

impl Fundamental {
    /// Labels the fundamental of a block with the block's stamp.
    pub fn from_harmonic(stamp: &Stamp, mut harmonic: Harmonic) -> Self {
        harmonic.tone.rate_hz = 0.0;
        Self { sequence: stamp.sequence, segment: stamp.segment, harmonic }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixed::types::I0F32;
    use picket_dsp::tone::Tone;
    use picket_dsp::tone::frequency::Frequency;

    #[test]
    fn a_fundamental_comes_back_as_it_was_and_others_are_refused() {
        let stamp = Stamp { sequence: 9, segment: Segment::Flat, ..Stamp::default() };
        let frequency = Frequency(I0F32::from_bits(-123_456_789));
        let tone = Tone { frequency, sigma: 1e-6, snr: 40.0, rate_hz: 5e5, ..Tone::default() };
        let fundamental = Fundamental::from_harmonic(&stamp, Harmonic { tone, orders: 0b1110 });
        let bytes = fundamental.to_bytes();
        assert_eq!(Fundamental::from_bytes(&bytes), Ok(fundamental));
        assert!(Fundamental::from_bytes(&bytes[..bytes.len() - 1]).is_err());
        let mut wrong = fundamental;
        wrong.harmonic.tone.sigma = f32::NAN;
        wrong.harmonic.tone.verdict = picket_dsp::Verdict::Good;
        assert!(Fundamental::from_bytes(&wrong.to_bytes()).is_err());
    }
}

//! All tones of a block. They follow the block's telemetry, whose tone is among them.

use crate::layout::{layout, record};
use heapless::Vec;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::phasor::ToneWithPhase;

/// The tones of a block, each with its phase.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// The block's sequence number.
    pub sequence: u32,
    /// The block's segment.
    pub segment: Segment,
    /// The tones, the strongest first. Their sample rate is that of the block's telemetry, and 0 here.
    pub tones: Vec<ToneWithPhase, MOST>,
}

layout! {
    /// All tones of a block.
    Lines {
        /// Number of the block.
        sequence: u32,
        /// Segment of the chirp.
        segment: Segment,
        /// The tones, the strongest first.
        tones: Vec<ToneWithPhase, MOST>,
    }
}

record!(Lines, Lines, |lines| lines.tones.iter().all(|line| line.tone.is_consistent()));

impl Lines {
    /// The tones of the block with this stamp.
    pub fn from_tones(stamp: &Stamp, mut tones: Vec<ToneWithPhase, MOST>) -> Self {
        tones.iter_mut().for_each(|phasor| phasor.tone.rate_hz = 0.0);
        Self { sequence: stamp.sequence, segment: stamp.segment, tones }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::RecordError;
    use picket_dsp::tone::{Tone, Verdict};
    use std::string::ToString;

    #[test]
    fn tones_come_back_as_they_were_and_others_are_refused() {
        let stamp = Stamp { sequence: 7, segment: Segment::Down, ..Stamp::default() };
        let tone = Tone { sigma: 1e-6, snr: 40.0, rate_hz: 5e5, ..Tone::default() };
        let phasor = ToneWithPhase { tone, phase: -1.5, sigma_phase: 0.01 };
        let mut lines = Lines::from_tones(&stamp, Vec::from_slice(&[phasor; MOST]).unwrap());
        let bytes = lines.to_bytes();
        assert_eq!(bytes.len(), Lines::BYTES);
        assert_eq!(Lines::from_bytes(&bytes), Ok(lines.clone()));
        let mut newer = bytes.clone();
        newer[0] = 2;
        let newer = Lines::from_bytes(&newer).unwrap_err();
        assert_eq!(newer, RecordError::Version(2));
        assert!(newer.to_string().starts_with("the record is of version 2, this program knows 1"));
        // The segment and the number of tones.
        for (place, value) in [(6, 9), (7, 5)] {
            let mut wrong = bytes.clone();
            wrong[place] = value;
            assert_eq!(Lines::from_bytes(&wrong), Err(RecordError::Field));
        }
        lines.tones[3].tone.sigma = f32::INFINITY;
        lines.tones[3].tone.verdict = Verdict::Good;
        assert_eq!(Lines::from_bytes(&lines.to_bytes()), Err(RecordError::Field));
        lines.tones.clear();
        assert_eq!(Lines::from_bytes(&lines.to_bytes()), Ok(lines));
    }
}

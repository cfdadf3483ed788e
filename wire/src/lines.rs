//! All tones of a block as bytes: little-endian, versioned, the same on every machine. They follow the
//! block's telemetry, whose tone is among them.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | segment: u8 |
//! | 2 | number of tones: u8, at most 4 |
//! | 3 | zero: u8 |
//! | 4 | sequence: u32 |
//! | 8 | the tones, 28 bytes each, the strongest first |
//!
//! A tone: frequency i32 in 2^-32 cycles per sample, its sigma f32 in cycles per sample,
//! signal-to-noise ratio f32 as a power ratio, amplitude f32 in codes, phase at the block's middle and
//! its sigma f32 in radians, verdict u8, what applies beside it u8, zero: 2 bytes.

use super::frame::{self, Frame, Kind};
use crate::bytes::{Reader, Writer};
use fixed::types::I0F32;
use heapless::Vec;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict, Verdicts};

/// The layout's version.
pub const VERSION: u8 = 1;

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

/// Why a frame holds no tones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinesError {
    /// The frame is of another kind.
    Kind(Kind),
    /// The payload is of another version.
    Version(u8),
    /// The payload is cut off, or a field has an unknown value, or one that the tone's verdict forbids.
    Field,
}

impl core::fmt::Display for LinesError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            LinesError::Kind(_) => f.write_str("the frame carries no tones"),
            LinesError::Version(version) => {
                write!(f, "the tones are of version {version}, this reader knows {VERSION}")
            }
            LinesError::Field => f.write_str("a field of the tones has no meaning"),
        }
    }
}

impl core::error::Error for LinesError {}

impl Lines {
    /// The tones of the block with this stamp.
    pub fn from_tones(stamp: &Stamp, mut tones: Vec<ToneWithPhase, MOST>) -> Self {
        tones.iter_mut().for_each(|phasor| phasor.tone.rate_hz = 0.0);
        Self { sequence: stamp.sequence, segment: stamp.segment, tones }
    }

    /// Length of a full report, bytes.
    const MOST: usize = 8 + 28 * MOST;

    /// The tones as a frame.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        let mut payload = [0; Self::MOST];
        let mut writer = Writer::new(&mut payload);
        writer.put([VERSION, self.segment as u8, self.tones.len() as u8, 0]);
        writer.u32(self.sequence);
        for ToneWithPhase { tone, phase, sigma_phase } in &self.tones {
            writer.i32(tone.frequency.0.to_bits());
            for number in [tone.sigma, tone.snr, tone.amplitude, *phase, *sigma_phase] {
                writer.f32(number);
            }
            writer.put([tone.verdict as u8, tone.also.bits(), 0, 0]);
        }
        frame::encode(Kind::Lines, writer.written()).unwrap_or_default()
    }

    /// The tones in a frame.
    ///
    /// # Errors
    /// The frame is of another kind or version, is cut off, or a field has an unknown value.
    pub fn from_frame(frame: &Frame) -> Result<Self, LinesError> {
        if frame.kind != Kind::Lines {
            return Err(LinesError::Kind(frame.kind));
        }
        match frame.payload.first() {
            Some(&VERSION) => Self::read(&mut Reader(&frame.payload)).ok_or(LinesError::Field),
            Some(&version) => Err(LinesError::Version(version)),
            None => Err(LinesError::Field),
        }
    }

    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let [_, segment, count, _] = reader.take()?;
        let mut lines = Lines {
            segment: Segment::from_u8(segment)?,
            sequence: reader.u32()?,
            tones: Vec::new(),
        };
        for _ in 0..count {
            let mut phasor = ToneWithPhase::default();
            phasor.tone.frequency = Frequency(I0F32::from_bits(reader.i32()?));
            let ToneWithPhase { tone: Tone { sigma, snr, amplitude, .. }, phase, sigma_phase } =
                &mut phasor;
            for field in [sigma, snr, amplitude, phase, sigma_phase] {
                *field = reader.f32()?;
            }
            let [verdict, also, _, _] = reader.take()?;
            phasor.tone.verdict = Verdict::from_u8(verdict)?;
            phasor.tone.also = Verdicts::from_bits(also);
            if !phasor.tone.is_consistent() {
                return None;
            }
            lines.tones.push(phasor).ok()?;
        }
        Some(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn tones_come_back_as_they_were_and_others_are_refused() {
        let stamp = Stamp { sequence: 7, segment: Segment::Down, ..Stamp::default() };
        let tone = Tone { sigma: 1e-6, snr: 40.0, rate_hz: 5e5, ..Tone::default() };
        let phasor = ToneWithPhase { tone, phase: -1.5, sigma_phase: 0.01 };
        let mut lines = Lines::from_tones(&stamp, Vec::from_slice(&[phasor; MOST]).unwrap());
        let mut reader = frame::Reader::default();
        let frame = lines.to_frame().iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap();
        assert_eq!(Lines::from_frame(&frame), Ok(lines.clone()));
        let told = |place: usize, value: u8| {
            let mut frame = frame.clone();
            frame.payload[place] = value;
            Lines::from_frame(&frame)
        };
        let newer = told(0, 2).unwrap_err();
        assert_eq!(newer, LinesError::Version(2));
        assert_eq!(newer.to_string(), "the tones are of version 2, this reader knows 1");
        assert_eq!(told(1, 9), Err(LinesError::Field));
        assert_eq!(told(2, 5), Err(LinesError::Field));
        assert_eq!(told(8 + 24, 99), Err(LinesError::Field));
        lines.tones.clear();
        let frame = lines.to_frame().iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap();
        assert_eq!(Lines::from_frame(&frame), Ok(lines));
    }
}

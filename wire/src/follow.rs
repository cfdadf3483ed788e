//! Tracks and targets as bytes: little-endian, versioned, the same on every machine.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | segment: u8 |
//! | 2 | flags: u8, bit 0: measured where the tone was expected, without a search |
//! | 3 | number of tracks: u8, at most 4 |
//! | 4 | sequence: u32 |
//! | 8 | number of targets: u8, at most 4 |
//! | 9 | zero: 3 bytes |
//! | 12 | the tracks, 18 bytes each |
//! | then | the targets, 28 bytes each |
//!
//! A track: number u16 (its low bits), state u8, verdict u8, misses u8, zero u8, frequency i32 in
//! 2^-32 cycles per sample, sigma f32 in cycles per sample, rate f32 in cycles per sample per
//! block. A target: range i64 in 2^-32 m, velocity i64 in 2^-32 m/s, their sigmas f32, verdict u8,
//! ambiguity u8 as in telemetry, number of the rising beat's track u16. A velocity of -2^63 is not known.

use super::frame::{self, Frame, Kind};
use crate::bytes::{Reader, Writer};
use crate::telemetry::{UNKNOWN, known};
use fixed::types::{I0F32, I32F32};
use heapless::Vec;
use picket_dsp::acquire::sample::{Record, Segment, Stamp};
use picket_dsp::solve::candidates::{Ambiguity, Candidates};
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::track::{State, Track};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::{Tone, Verdict};
use picket_dsp::tracker::Tracker;

/// The layout's version.
pub const VERSION: u8 = 1;

/// A track in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sighting {
    /// The low bits of the track's number.
    pub number: u16,
    /// The state of the track.
    pub state: State,
    /// Whether this block's frequency may be used.
    pub verdict: Verdict,
    /// Blocks since its last measurement.
    pub misses: u8,
    /// The frequency of the tone.
    pub frequency: Frequency,
    /// One standard deviation of the frequency, cycles per sample.
    pub sigma: f32,
    /// The rate, cycles per sample per block.
    pub rate: f32,
}

impl From<&Track> for Sighting {
    fn from(track: &Track) -> Self {
        Self {
            number: track.number as u16,
            state: track.state,
            verdict: track.tone.verdict,
            misses: track.misses,
            frequency: track.tone.frequency,
            sigma: track.tone.sigma,
            rate: track.rate(),
        }
    }
}

/// Tracks and targets after a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Follow {
    /// The block's sequence number.
    pub sequence: u32,
    /// The block's segment. The tracks are those of this segment.
    pub segment: Segment,
    /// Whether the block was measured without a search.
    pub locked: bool,
    /// The tracks, oldest first.
    pub tracks: Vec<Sighting, MOST>,
    /// The targets computed from the tracks of all segments, each with the number of its rising
    /// beat's track. Only a chirp's last block has them.
    pub targets: Vec<(u16, Target), MOST>,
}

/// The frame is of another kind or version, or a field has an unknown value, or one that its verdict forbids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoFollow;

impl core::fmt::Display for NoFollow {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the frame carries no tracks that this reader knows")
    }
}

impl core::error::Error for NoFollow {}

impl Follow {
    /// The tracks that a tracker holds after the block with this stamp, and the targets if the
    /// block ends a chirp.
    pub fn from_tracker<R: Record, const N: usize>(tracker: &Tracker<R, N>, stamp: &Stamp) -> Self {
        Self::widened(tracker, stamp, |_| {})
    }

    /// Like [`Follow::from_tracker`], with an instrument's part in the tones' errors: `widen` adds it to a tone's sigma.
    pub fn widened<R: Record, const N: usize>(
        tracker: &Tracker<R, N>,
        stamp: &Stamp,
        widen: impl Fn(&mut Tone),
    ) -> Self {
        let mut tracks = Vec::new();
        let all = tracker.tracks(stamp.segment).iter();
        for track in all.filter(|track| track.state != State::Tentative) {
            let mut tone = track.tone;
            widen(&mut tone);
            // There is room: a tracker follows at most this many.
            let _ = tracks.push(Sighting { sigma: tone.sigma, ..Sighting::from(track) });
        }
        Follow {
            sequence: stamp.sequence,
            segment: stamp.segment,
            locked: tracker.is_locked(stamp.segment),
            tracks,
            targets: if tracker.completes(stamp) { tracker.targets() } else { Vec::new() },
        }
    }

    /// Length of a full report, bytes.
    const MOST: usize = 12 + MOST * (18 + 28);

    /// The report as a frame. It has room for four tracks and four targets.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        let mut payload = [0; Self::MOST];
        let mut writer = Writer::new(&mut payload);
        let (tracks, targets) = (self.tracks.len() as u8, self.targets.len() as u8);
        writer.put([VERSION, self.segment as u8, self.locked.into(), tracks]);
        writer.u32(self.sequence);
        writer.put([targets, 0, 0, 0]);
        for track in &self.tracks {
            writer.u16(track.number);
            writer.put([track.state as u8, track.verdict as u8, track.misses, 0]);
            writer.i32(track.frequency.0.to_bits());
            writer.f32(track.sigma);
            writer.f32(track.rate);
        }
        for (number, target) in &self.targets {
            writer.i64(target.range.to_bits());
            writer.i64(target.velocity.map_or(UNKNOWN, I32F32::to_bits));
            writer.f32(target.sigma_range);
            writer.f32(target.sigma_velocity);
            writer.put([target.verdict as u8, target.ambiguity.number()]);
            writer.u16(*number);
        }
        frame::encode(Kind::Follow, writer.written()).unwrap_or_default()
    }

    /// The report in a frame.
    ///
    /// # Errors
    /// The frame is of another kind or version, or a field has an unknown value.
    pub fn from_frame(frame: &Frame) -> Result<Self, NoFollow> {
        if frame.kind != Kind::Follow {
            return Err(NoFollow);
        }
        Self::read(&mut Reader(&frame.payload)).ok_or(NoFollow)
    }

    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let [version, segment, flags, tracks] = reader.take()?;
        if version != VERSION {
            return None;
        }
        let sequence = reader.u32()?;
        let [targets, _, _, _] = reader.take()?;
        let mut follow = Follow {
            sequence,
            segment: Segment::from_u8(segment)?,
            locked: flags & 1 != 0,
            ..Follow::default()
        };
        for _ in 0..tracks {
            let number = reader.u16()?;
            let [state, verdict, misses, _] = reader.take()?;
            let sighting = Sighting {
                number,
                state: State::from_u8(state)?,
                verdict: Verdict::from_u8(verdict)?,
                misses,
                frequency: Frequency(I0F32::from_bits(reader.i32()?)),
                sigma: reader.f32()?,
                rate: reader.f32()?,
            };
            let known = sighting.verdict.admits(sighting.sigma) && sighting.rate.is_finite();
            if !known {
                return None;
            }
            follow.tracks.push(sighting).ok()?;
        }
        for _ in 0..targets {
            let range = I32F32::from_bits(reader.i64()?);
            let velocity = known(reader.i64()?);
            let (sigma_range, sigma_velocity) = (reader.f32()?, reader.f32()?);
            let [verdict, ambiguity] = reader.take()?;
            let verdict = Verdict::from_u8(verdict)?;
            let ambiguity = Ambiguity::from_number(ambiguity, Candidates::default())?;
            let target =
                Target { range, velocity, sigma_range, sigma_velocity, ambiguity, verdict };
            // A sawtooth's velocity is not known: its sigma is infinite.
            if !(target.verdict.admits(target.sigma_range) && target.sigma_velocity >= 0.0) {
                return None;
            }
            let number = reader.u16()?;
            follow.targets.push((number, target)).ok()?;
        }
        Some(follow)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_report_comes_back_as_it_was() {
        let mut follow =
            Follow { sequence: 77, segment: Segment::Down, locked: true, ..Follow::default() };
        for number in 0..4 {
            let sighting = Sighting {
                number,
                state: State::Held,
                verdict: Verdict::Weak,
                misses: 3,
                frequency: Frequency(I0F32::from_bits(-123_456 * i32::from(number))),
                sigma: 1e-5,
                rate: -2e-4,
            };
            follow.tracks.push(sighting).unwrap();
            let target = Target {
                range: I32F32::from_num(12.5),
                velocity: (number > 0).then_some(I32F32::from_num(-3.25)),
                sigma_range: 0.01,
                sigma_velocity: 0.002,
                verdict: Verdict::Clipped,
                ..Target::default()
            };
            follow.targets.push((number, target)).unwrap();
        }
        let wire = follow.to_frame();
        let mut reader = frame::Reader::default();
        let frame = wire.iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap();
        assert_eq!(Follow::from_frame(&frame), Ok(follow));
        let short =
            Frame { kind: Kind::Follow, payload: Vec::from_slice(&frame.payload[..60]).unwrap() };
        assert_eq!(Follow::from_frame(&short), Err(NoFollow));
    }
}

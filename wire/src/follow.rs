//! Tracks and targets after a block.

use crate::layout::{Field, Form, Reader, Writer, layout, record};
use heapless::Vec;
use picket_dsp::acquire::sample::{Record, Segment, Stamp};
use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Candidate, Candidates};
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::track::{State, Track};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::{Tone, Verdict};
use picket_dsp::tracker::Tracker;

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
    /// beat's track. Only a chirp's last block has them. Their candidates are not sent.
    pub targets: Vec<(u16, Target), MOST>,
}

/// A target that is followed.
struct Followed {
    track: u16,
    target: Target,
}

/// A target behind the low bits of the number of its rising beat's track. Candidates would not fit: they are left out.
impl Field for (u16, Target) {
    const FORM: Form = Followed::FORM;
    const MOST: usize = Followed::MOST - CANDIDATES * Candidate::MOST;

    fn put(&self, writer: &mut Writer<'_>) {
        let (track, mut target) = *self;
        if let Ambiguity::Several(candidates) = &mut target.ambiguity {
            *candidates = Candidates::default();
        }
        Followed { track, target }.put(writer);
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        Followed::take(reader).map(|Followed { track, target }| (track, target))
    }
}

layout! {
    /// A track.
    Sighting {
        /// Low bits of the track's number.
        number: u16,
        /// State of the track.
        state: State,
        /// Whether this block's frequency may be used.
        verdict: Verdict,
        /// Blocks since its last measurement.
        misses: u8,
        /// Frequency, 2^-32 cycles per sample.
        frequency: Frequency,
        /// Sigma of the frequency, cycles per sample.
        sigma: f32,
        /// Rate of the frequency, cycles per sample per block.
        rate: f32,
    }

    /// A target that is followed. Its candidates are not sent.
    Followed {
        /// Low bits of the number of its rising beat's track.
        track: u16,
        /// The target.
        target: Target,
    }

    /// Tracks and targets after a block.
    Follow {
        /// Number of the block.
        sequence: u32,
        /// Segment of the chirp: the tracks are of this one.
        segment: Segment,
        /// The block was measured without a search.
        locked: bool,
        /// The tracks, the oldest first.
        tracks: Vec<Sighting, MOST>,
        /// The targets, after the last block of a chirp.
        targets: Vec<(u16, Target), MOST>,
    }
}

record!(Follow, Follow, |follow| {
    let known = |track: &Sighting| track.verdict.admits(track.sigma) && track.rate.is_finite();
    // A sawtooth's velocity is not known: its sigma is infinite.
    let admitted = |(_, target): &(u16, Target)| {
        target.verdict.admits(target.sigma_range) && target.sigma_velocity >= 0.0
    };
    follow.tracks.iter().all(known) && follow.targets.iter().all(admitted)
});

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
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixed::types::{I0F32, I32F32};

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
        let bytes = follow.to_bytes();
        assert_eq!(bytes.len(), Follow::BYTES - 8);
        assert_eq!(Follow::from_bytes(&bytes), Ok(follow));
        assert!(Follow::from_bytes(&bytes[..60]).is_err());
    }
}

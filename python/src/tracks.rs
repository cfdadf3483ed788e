//! Tones that are followed from block to block.

use crate::native::Native;
use crate::tables::{self, BlockRow, TargetRow, TrackRow, joined};
use picket_dsp::acquire::kind::ForRecord;
use picket_dsp::solve::track::State;
use picket_dsp::{ConfigError, Outcome, Record, Segment, Tracker};

/// The tones of a recording, from its start.
pub struct Follow<'a> {
    pub native: &'a Native,
    pub words: &'a [i16],
    pub hop: usize,
}

/// The rows of the blocks, of the tracks after every block, and of what the held ones amount to.
#[derive(Default)]
pub struct Followed {
    pub blocks: Vec<BlockRow>,
    pub tracks: Vec<TrackRow>,
    pub targets: Vec<[f64; 2 + tables::TARGET]>,
}

impl ForRecord for Follow<'_> {
    type Output = Result<Followed, ConfigError>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let mut followed = Followed::default();
        let plan = self.native.config.plan::<R, N>()?;
        let rate_hz = plan.rate_hz;
        let mut tracker = Box::new(Tracker::<R, N>::new(plan));
        let count = self.native.count(self.words, self.hop);
        self.native.records::<R, N>(self.words, self.hop, 0..count, |stamp, samples| {
            let seen = tracker.block(&stamp, samples);
            followed.blocks.push(tables::block(&seen, None));
            let tracks = tracker.tracks(stamp.segment).iter();
            followed.tracks.extend(tracks.map(|track| tables::track(stamp.clock, track, rate_hz)));
            let mut target = |track: u32, row: TargetRow| {
                followed.targets.push(joined([&[stamp.clock as f64, track.into()], &row]));
            };
            if tracker.completes(&stamp) {
                for (track, seen) in tracker.targets() {
                    target(track.into(), tables::target(&seen));
                }
            }
            let held = tracker.tracks(Segment::Continuous).iter();
            let held = held.filter(|track| track.state == State::Held);
            for (track, velocity) in held.zip(tracker.velocities()) {
                target(track.number, tables::outcome(&Outcome::Velocity(velocity)));
            }
        });
        Ok(followed)
    }
}

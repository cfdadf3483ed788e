//! Frames of chirps.

use crate::either::Idle;
use crate::meter::{Advance, Framed, Gathered, Meter};
use picket_dsp::acquire::sample::{Record, Segment, Stamp};
use picket_dsp::frame::{Cells, Filled, Frame, FramePlan, FrameTarget, Search};
use picket_dsp::pipeline::{Measurement, Pipeline};
use picket_dsp::plan::Plan;
use picket_wire::settings::Settings;

/// The plan of a frame, if there is one.
// Zeros are none, which an option of this plan would not have.
#[repr(u8)]
enum Planned {
    No,
    Yes(FramePlan),
}

/// Gathers chirps to frames, in at most this many cells, and finds the targets of each. While it seeks them, chirps pass.
pub struct Frames<R: Record, const N: usize, const CELLS: usize> {
    pipeline: Pipeline<R, N>,
    plan: Planned,
    cells: [[i16; 2]; CELLS],
    filled: Filled,
    /// The targets of a complete frame are sought.
    seeks: bool,
    search: Search,
    told: Framed,
    /// The sequence number after that of the last chirp.
    next: u32,
    /// The complete frames so far.
    frames: u32,
    /// The sequence number after that of the last complete frame.
    end: u32,
}

impl<R: Record, const N: usize, const CELLS: usize> Idle for Frames<R, N, CELLS> {
    const IDLE: Self = Self {
        pipeline: Pipeline::new(Plan::IDLE),
        plan: Planned::No,
        cells: [[0; 2]; CELLS],
        filled: Filled::NONE,
        seeks: false,
        search: Search::new(),
        told: Framed {
            number: 0,
            first: Stamp { sequence: 0, clock: 0, segment: Segment::Continuous, gap: false },
            passed: 0,
            clipped: 0,
        },
        next: 0,
        frames: 0,
        end: 0,
    };
}

impl<R: Record, const N: usize, const CELLS: usize> Meter<R, N> for Frames<R, N, CELLS> {
    const CELLS: usize = CELLS;

    fn set_plan(&mut self, plan: Plan<R, N>) {
        self.pipeline.set_plan(plan);
    }

    fn choose(&mut self, settings: &Settings) {
        self.plan = settings.frames(N).ok().flatten().map_or(Planned::No, Planned::Yes);
    }

    #[inline(never)] // once in an image, not in each place that measures
    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement {
        let nothing = Measurement { stamp: *stamp, ..Measurement::default() };
        let Planned::Yes(plan) = self.plan else { return nothing };
        // The cells are in use.
        if self.seeks {
            return nothing;
        }
        // A frame has no gap: it begins again.
        if self.filled == Filled::NONE || stamp.gap || stamp.sequence != self.next {
            self.filled = Filled::NONE;
            self.told.first = *stamp;
        }
        self.next = stamp.sequence.wrapping_add(1);
        let clipped = self.pipeline.look(samples);
        let cells = Cells::Narrow(&mut self.cells);
        let Some(mut frame) = Frame::resume(plan, cells, self.filled) else { return nothing };
        if frame.push(&self.pipeline.spectrum().view(), clipped) {
            self.told.passed = self.told.first.sequence.wrapping_sub(self.end);
            self.end = self.next;
            (self.told.number, self.told.clipped) = (self.frames, frame.clipped());
            self.frames = self.frames.wrapping_add(1);
            self.search.begin();
            self.seeks = true;
        }
        self.filled = frame.so_far();
        nothing
    }

    fn gathered(&mut self) -> Gathered {
        Gathered::Nothing
    }

    #[inline(never)] // once in an image
    fn advance(&mut self) -> Advance {
        let Planned::Yes(plan) = self.plan else { return Advance::Idle };
        if !self.seeks {
            return Advance::Idle;
        }
        let cells = Cells::Narrow(&mut self.cells);
        let frame = Frame::resume(plan, cells, self.filled);
        if frame.is_some_and(|frame| self.search.step(&frame)) {
            return Advance::More;
        }
        (self.seeks, self.filled) = (false, Filled::NONE);
        Advance::Done
    }

    fn framed(&self) -> Option<(Framed, &[FrameTarget])> {
        Some((self.told, self.search.targets()))
    }
}

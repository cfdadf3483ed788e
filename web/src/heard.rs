//! Frames of chirps that a board tells of, each with its targets in records behind it.

use crate::answer::Answer;
use crate::frames::places;
use crate::settings::Settings;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::frame::FrameTarget;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::settings::Settings as Device;

/// The frame whose targets come, and the last one whose targets are there.
#[derive(Default)]
pub struct Heard {
    coming: Option<ChirpFrame>,
    targets: Vec<FrameTarget>,
    last: Option<(ChirpFrame, Vec<FrameTarget>)>,
    /// Frames so far whose targets are there.
    pub frames: u32,
}

impl Heard {
    /// Takes a frame. Returns the rows that are complete: those of a frame without targets, or of the one before where some were lost on the way.
    pub fn frame(&mut self, frame: &ChirpFrame, settings: &Settings) -> Vec<Answer> {
        let mut rows = self.finish(settings);
        self.coming = Some(*frame);
        if frame.targets == 0 {
            rows.extend(self.finish(settings));
        }
        rows
    }

    /// Takes a target. Returns the rows of its frame if it is the last one; a target whose frame was lost on the way is left out.
    pub fn target(&mut self, found: &Found, settings: &Settings) -> Vec<Answer> {
        let Some(frame) = self.coming.filter(|frame| frame.number == found.frame) else {
            return Vec::new();
        };
        self.targets.push(found.found);
        if self.targets.len() < usize::from(frame.targets) {
            return Vec::new();
        }
        self.finish(settings)
    }

    /// A row for each target, as those of a recording's frame, with what the board lost.
    fn finish(&mut self, settings: &Settings) -> Vec<Answer> {
        let Some(frame) = self.coming.take() else { return Vec::new() };
        let targets = std::mem::take(&mut self.targets);
        let &ChirpFrame { number, stamp, chirps, clipped, rate_hz, period_s, health, .. } = &frame;
        let middle_s = stamp.clock as f64 / rate_hz + 0.5 * f64::from(chirps) * period_s;
        let row = |(place, found): (usize, &FrameTarget)| {
            // The counters add the rows up.
            let (clipped, gap) = if place == 0 { (clipped, stamp.gap) } else { (0, false) };
            let stamp = Stamp { sequence: number, clock: stamp.sequence.into(), gap, ..stamp };
            let result = Outcome::Target(found.target);
            let measurement = Measurement { stamp, clipped, tone: found.line.tone, result };
            Answer {
                time_s: middle_s,
                lost: health.lost.into(),
                faults: health.faults.into(),
                ..Answer::of(&measurement, settings.n, settings.iq, rate_hz)
            }
        };
        let rows = targets.iter().enumerate().map(row).collect();
        self.last = Some((frame, targets));
        self.frames = self.frames.wrapping_add(1);
        rows
    }

    /// The map of the last frame without its powers, which the board keeps, by the board's settings: see [`crate::frames::Frames::map`]. Empty
    /// without a frame, or if the settings make none.
    pub fn map(&self, (device, n): &(Device, usize)) -> Vec<f64> {
        let plan = device.frames(*n).ok().flatten();
        plan.zip(self.last.as_ref()).map_or_else(Vec::new, |(plan, (frame, targets))| {
            places(&plan, frame.number.into(), f64::NAN, targets)
        })
    }

    /// What the last frame was, in words.
    pub fn words(&self) -> Option<String> {
        let (ChirpFrame { chirps, passed, search_s, .. }, _) = self.last.as_ref()?;
        let search_ms = 1e3 * search_s;
        Some(format!("{chirps} chirps after {passed} in no frame, searched in {search_ms:.0} ms"))
    }
}

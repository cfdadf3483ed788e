//! What the phases of tones tell: ranges to micrometres, ways, velocities from chirp to chirp.

use crate::native::Native;
use crate::views::{self, Row};
use picket_dsp::acquire::kind::ForRecord;
use picket_dsp::plan::Solver;
use picket_dsp::solve::displacement::Unwrapper;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::sequence::Sequence;
use picket_dsp::tone::lines::MOST;
use picket_dsp::{
    ConfigError, Outcome, Pipeline, Record, Scene, Segment, Shape, Stamp, ToneWithPhase,
};
use picket_wire::view;

/// What is asked of the blocks' phases. Each row begins with the block's number.
#[derive(Clone, Copy)]
pub enum Asked {
    /// The range by phase of each chirp.
    Ranges(Calibration),
    /// The calibration by a target at this range, m, with one standard deviation: one row.
    Calibration { known_m: f64, sigma_m: f32 },
    /// The way of the strongest target; from chirp to chirp it turns the phase by less than this share of a turn.
    Way { most_turns: f32 },
    /// The targets of a sequence of sawtooth chirps that begin so many samples apart.
    Sequence { period: u32 },
}

impl Asked {
    /// The names of a row's numbers.
    pub fn columns(self) -> Vec<String> {
        let name = match self {
            Asked::Ranges(_) => "phase_range",
            Asked::Calibration { .. } => "calibration",
            Asked::Way { .. } => "displacement",
            Asked::Sequence { .. } => "target",
        };
        let mut all = vec!["block".to_owned()];
        all.extend(views::columns(name).unwrap_or_default());
        all
    }
}

/// The phases of a recording's blocks.
pub struct Phases<'a> {
    pub native: &'a Native,
    pub words: &'a [i16],
    pub hop: usize,
    pub asked: Asked,
    /// The numbers of the samples that are missing, in order.
    pub missing: &'a [u64],
}

/// What a kind of answer keeps from block to block.
enum Kept {
    Ranging(PhaseRanging, Option<ToneWithPhase>),
    Calibrating(PhaseRanging, Vec<ToneWithPhase>),
    Way(Unwrapper),
    Sequence(Sequence),
}

impl Phases<'_> {
    fn kept<R: Record, const N: usize>(&self, solver: &Solver) -> Result<Kept, ConfigError> {
        let config = &self.native.config;
        let ranging = |calibration| match config.scene {
            Scene::Chirp(chirp) => PhaseRanging::new(&chirp, config.rate_hz, N, R::IQ, calibration),
            _ => Err(ConfigError::Scene),
        };
        Ok(match self.asked {
            Asked::Ranges(calibration) => Kept::Ranging(ranging(calibration)?, None),
            Asked::Calibration { .. } => {
                Kept::Calibrating(ranging(Calibration::default())?, Vec::new())
            }
            Asked::Way { most_turns } => {
                let (scene, rate_hz) = (&config.scene, config.rate_hz);
                Kept::Way(Unwrapper::of_scene(scene, rate_hz, N, R::IQ, most_turns)?)
            }
            Asked::Sequence { period } => {
                let Solver::Chirp(equations) = solver else { return Err(ConfigError::Scene) };
                Kept::Sequence(Sequence::new(equations, period).ok_or(ConfigError::Frame)?)
            }
        })
    }
}

impl ForRecord for Phases<'_> {
    type Output = Result<Vec<Row>, ConfigError>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let plan = self.native.config.plan::<R, N>()?;
        let solver = plan.solver;
        let sawtooth =
            matches!(solver, Solver::Chirp(equations) if equations.shape == Shape::Sawtooth);
        let mut kept = self.kept::<R, N>(&solver)?;
        let mut pipeline = Box::new(Pipeline::<R, N>::new(plan));
        let count = self.native.count(self.words, self.hop);
        let (mut rows, mut lost) = (Vec::new(), false);
        self.native.records::<R, N>(self.words, self.hop, 0..count, |stamp, samples| {
            let next = self.missing.partition_point(|&number| number < stamp.clock);
            let next = self.missing.get(next).copied().unwrap_or(u64::MAX);
            let gap = next < stamp.clock.saturating_add(N as u64);
            lost |= gap;
            let seen = pipeline.block(&Stamp { gap, ..stamp }, samples);
            // Beside the other lines of the block: what leaks of them would turn its phase.
            let line = pipeline.lines(&seen, MOST).first().copied();
            let mut row = vec![f64::from(stamp.sequence)];
            match (&mut kept, line) {
                (Kept::Ranging(ranging, up), Some(line)) => {
                    if stamp.segment == Segment::Up {
                        *up = Some(line);
                    }
                    let Outcome::Target(target) = &seen.result else { return };
                    let answer = match (sawtooth, up) {
                        (true, _) => ranging.at_rest(Segment::Up, &line),
                        (false, Some(up)) => ranging.moving(up, &line, target),
                        (false, None) => return,
                    };
                    views::put(&mut row, &view::PhaseRange::from_answer(&answer));
                }
                (Kept::Calibrating(_, lines), Some(line)) => {
                    if stamp.segment == Segment::Up {
                        lines.push(line);
                    }
                    return;
                }
                (Kept::Way(way), Some(line)) => {
                    let moved = way.push(&Stamp { gap: lost, ..stamp }, &line);
                    views::put(&mut row, &view::Displacement::from_moved(&moved));
                    lost = false;
                }
                (Kept::Sequence(sequence), Some(line)) => {
                    let Asked::Sequence { period } = self.asked else { return };
                    // Chirps of an array begin a period apart, whatever lies between their records.
                    let clock = u64::from(stamp.sequence) * u64::from(period);
                    let stamp = Stamp { clock, gap: lost, ..stamp };
                    for target in &sequence.push(&stamp, &line) {
                        let mut row = row.clone();
                        views::put(&mut row, &view::Target::from_target(target, 0));
                        rows.push(row);
                    }
                    lost = false;
                    return;
                }
                (Kept::Ranging(_, up), None) => {
                    if stamp.segment == Segment::Up {
                        *up = None;
                    }
                    return;
                }
                (_, None) => {
                    lost = true;
                    return;
                }
            }
            rows.push(row);
        });
        if let (Asked::Calibration { known_m, sigma_m }, Kept::Calibrating(ranging, lines)) =
            (self.asked, &kept)
        {
            let known = ranging.calibrate_all(lines, known_m, sigma_m);
            rows.extend(known.map(|known| {
                let mut row = vec![lines.len() as f64];
                views::put(&mut row, &view::Calibration::from(&known));
                row
            }));
        }
        Ok(rows)
    }
}

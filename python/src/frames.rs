//! Targets of frames of chirps.

use crate::native::{Native, samples_of};
use crate::views::{self, Row};
use picket_dsp::acquire::kind::ForRecord;
use picket_dsp::frame::{Cells, Frame, FrameConfig, FramePlan};
use picket_dsp::num_complex::Complex;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::{ConfigError, Pipeline, Plan, Record, Scene, Segment};
use picket_wire::view;
use rayon::prelude::*;

/// What a frame is beside its configuration.
#[derive(Clone)]
pub struct Framing {
    pub chirps: usize,
    pub period_s: f64,
    pub bins: Option<(i32, i32)>,
    pub false_alarm: Option<f64>,
    pub uncertainty: Option<Uncertainty>,
    /// Ranges by phase with this calibration.
    pub calibration: Option<Calibration>,
}

/// What is done with the frames in these words.
pub enum Wanted<'a> {
    /// The check alone.
    Plan,
    /// The targets, less this background.
    Targets(&'a [Complex<f32>]),
    /// What stands still in the first frame.
    Background,
}

/// Frames of a recording.
pub struct Frames<'a> {
    pub native: &'a Native,
    pub words: &'a [i16],
    pub framing: &'a Framing,
    pub wanted: Wanted<'a>,
}

/// Rows of targets, the background with its share of the power, and the distance between aliases in m/s.
#[derive(Default)]
pub struct Found {
    pub rows: Vec<Row>,
    pub background: Vec<Complex<f32>>,
    pub share: f32,
    pub alias_mps: f32,
    /// Bins that are kept of each chirp.
    pub bins: usize,
}

impl Framing {
    /// The plan of frames of records of this kind.
    fn plan(&self, native: &Native) -> Result<FramePlan, ConfigError> {
        let Scene::Chirp(chirp) = native.config.scene else { return Err(ConfigError::Frame) };
        let usual = FrameConfig::new(
            chirp,
            native.config.rate_hz,
            native.n,
            native.iq,
            self.chirps,
            self.period_s,
        );
        let config = FrameConfig {
            bins: self.bins,
            false_alarm: self.false_alarm.unwrap_or(usual.false_alarm),
            range_m: native.config.range_m,
            velocity_mps: native.config.velocity_mps,
            ..usual
        };
        config.plan()
    }

    /// The names of a row's numbers.
    pub fn columns(uncertain: bool, by_phase: bool) -> Vec<String> {
        let of = |name: &str, before: &str| {
            let all = views::columns(name).unwrap_or_default();
            all.into_iter().map(|name| format!("{before}{name}")).collect::<Vec<_>>()
        };
        let mut all = vec!["frame".to_owned()];
        all.extend(of("frame_target", ""));
        if uncertain {
            all.extend(of("budget", "budget_"));
        }
        if by_phase {
            all.extend(of("phase_range", "phase_"));
            if uncertain {
                all.extend(of("budget", "phase_budget_"));
            }
        }
        all
    }
}

impl ForRecord for Frames<'_> {
    type Output = Result<Found, ConfigError>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let Self { native, words, framing, wanted } = self;
        let plan = framing.plan(native)?;
        let (Scene::Chirp(chirp), rate_hz) = (native.config.scene, native.config.rate_hz) else {
            return Err(ConfigError::Frame);
        };
        let ranging = framing
            .calibration
            .map(|calibration| PhaseRanging::new(&chirp, rate_hz, N, R::IQ, calibration));
        let ranging = ranging.transpose()?;
        let found = Found { alias_mps: plan.alias_mps(), bins: plan.bins(), ..Found::default() };
        let parts = if R::IQ { 2 } else { 1 };
        let of_frame = |number: usize, act: &mut dyn FnMut(&Frame<'_>)| {
            let mut cells = vec![[0i32; 2]; plan.cells()];
            let Some(mut frame) = Frame::new(plan, Cells::Wide(&mut cells)) else { return };
            let codes = native.config.codes;
            let mut pipeline = Box::new(Pipeline::<R, N>::new(Plan::tone(rate_hz, codes)));
            let mut samples = Box::new([R::Sample::default(); N]);
            let frame_words = plan.chirps() * N * parts;
            let words = words.get(number * frame_words..).unwrap_or_default();
            for words in words.chunks_exact(N * parts).take(plan.chirps()) {
                for (place, sample) in samples.iter_mut().zip(samples_of::<R>(words)) {
                    *place = sample;
                }
                let clipped = pipeline.look(&samples);
                frame.push(&pipeline.spectrum().view(), clipped);
            }
            act(&frame);
        };
        match wanted {
            Wanted::Plan => Ok(found),
            Wanted::Background => {
                let mut found =
                    Found { background: vec![Complex::default(); plan.bins()], ..found };
                of_frame(0, &mut |frame| found.share = frame.background(&mut found.background));
                Ok(found)
            }
            Wanted::Targets(background) => {
                let count = words.len() / (plan.chirps() * N * parts);
                let rows = |number: usize| {
                    let mut rows = Vec::new();
                    of_frame(number, &mut |frame| {
                        for seen in &frame.targets_beside(background) {
                            rows.push(row(number, seen, framing, ranging.as_ref()));
                        }
                    });
                    rows
                };
                let rows = (0..count).into_par_iter().map(rows).collect::<Vec<_>>();
                Ok(Found { rows: rows.concat(), ..found })
            }
        }
    }
}

/// A target's row, as [`Framing::columns`] names it.
fn row(
    number: usize,
    seen: &picket_dsp::frame::FrameTarget,
    framing: &Framing,
    ranging: Option<&PhaseRanging>,
) -> Row {
    let mut row = vec![number as f64];
    views::put(&mut row, &view::FrameTarget::from_found(seen));
    if let Some(known) = &framing.uncertainty {
        views::put(&mut row, &view::Budget::from_budget(&known.of_target(&seen.target, 0.0)));
    }
    if let Some(ranging) = ranging {
        let answer = ranging.of_target(Segment::Up, &seen.line, &seen.target);
        views::put(&mut row, &view::PhaseRange::from_answer(&answer));
        if let Some(known) = &framing.uncertainty {
            let budget = known.of_phase_range(&answer, 2.0 * answer.spacing());
            views::put(&mut row, &view::Budget::from_budget(&budget));
        }
    }
    row
}

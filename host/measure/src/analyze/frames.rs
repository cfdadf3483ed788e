//! Targets of a recording's frames of chirps.

use super::cut::Cut;
use super::radar::{Layout, Radar, Ramps};
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::with_record;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::frame::{Cells, Frame, FramePlan, FrameTarget};
use picket_dsp::solve::phase_range::PhaseRange;
use picket_dsp::solve::uncertainty::Budget;
use picket_dsp::{Chirp, Pipeline, Plan};
use picket_transform::num_complex::Complex;
use std::path::Path;

/// A target of a frame.
#[derive(Clone, Debug)]
pub struct Found {
    /// The frame's number, and that of its first chirp.
    pub frame: u64,
    /// The number of its first chirp.
    pub chirp: u64,
    /// The target.
    pub found: FrameTarget,
    /// The parts of its error, where what is not known of the radar was told.
    pub budget: Option<Budget>,
    /// Its range by phase, where that was asked for, and its error.
    pub phase: Option<(PhaseRange, Option<Budget>)>,
    /// A reason beside the target's own, which its record cannot know.
    pub also: Option<&'static str>,
    /// The plan of its frame, of a recording's.
    pub plan: Option<FramePlan>,
}

/// Measures every frame. Returns how many there are, and what was left out.
pub fn run(
    file: &Path,
    recording: Recording,
    cut: &Cut,
    (ramps, layout): (&Ramps, &Layout),
    radar: &Radar,
    told: &Told,
    sink: &mut dyn FnMut(Found),
) -> Result<Tally, String> {
    let chirp = radar.chirp(recording.rate_hz(), ramps, told.guard_s, told.curvature);
    let chirps = layout.chirps as u64;
    if layout.together < chirps {
        let there = layout.together;
        return Err(format!("the recording has {there} chirps together: give fewer --chirps"));
    }
    radar.check_period(&recording, told.period_s)?;
    let is_told = [told.period_s.is_some(), told.guard_s.is_some(), radar.velocity_mps.is_some()];
    let assumed = layout.assumed(&recording, ramps, &chirp, is_told);
    let assumed = format!("{}: {assumed}", crate::cli::name(file));
    with_record!(recording.iq(), ramps.n, R, N => frames::<R, N>(recording, cut, (ramps, layout, chirp, &assumed), radar, told, sink))
}

fn frames<R: Kind, const N: usize>(
    recording: Recording,
    cut: &Cut,
    (ramps, layout, chirp, assumed): (&Ramps, &Layout, Chirp, &str),
    radar: &Radar,
    told: &Told,
    sink: &mut dyn FnMut(Found),
) -> Result<Tally, String> {
    let rate_hz = recording.rate_hz();
    let plan = radar.plan(rate_hz, (N, R::IQ), &chirp, layout, cut.band_hz, told.range_m)?;
    let mut cells = vec![[0i32; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Wide(&mut cells)).ok_or("too few cells")?;
    let ranging = told.ranging(&chirp, rate_hz, N, R::IQ)?;
    eprintln!("{assumed}");
    let mut pipeline = Box::new(Pipeline::<R, N>::new(Plan::tone(rate_hz, cut.codes)));
    let mut blocks = recording.blocks(N, ramps.hop, cut.skip + ramps.skip as u64);
    let mut tally = Tally::default();
    let (mut number, mut gaps, chirps) = (0u64, 0u64, layout.chirps as u64);
    let (mut beyond, mut quiet, mut missing) = (false, true, false);
    while let Some((_, samples)) = blocks.next_block().map_err(super::text)? {
        let place = number % layout.together;
        let chirp = number - place % chirps;
        number += 1;
        if place - place % chirps + chirps > layout.together {
            continue;
        }
        if place % chirps == 0 {
            frame.clear();
            (beyond, quiet, missing) = (false, true, false);
        }
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        (beyond, quiet) =
            (beyond | (unfit == Some(Unfit::Beyond)), quiet & (unfit == Some(Unfit::Quiet)));
        missing |= blocks.missing() > 0;
        let clipped = pipeline.look(&record::<R, N>(&values));
        if !frame.push(&pipeline.spectrum().view(), clipped) {
            continue;
        }
        let unfit = beyond.then_some(Unfit::Beyond).or(quiet.then_some(Unfit::Quiet));
        let at = tally.blocks;
        tally.add(unfit);
        gaps += u64::from(missing);
        if missing || unfit.is_some() {
            continue;
        }
        for found in &frame.targets() {
            let uncertainty = told.uncertainty.as_ref();
            let budget = |known: &picket_dsp::solve::uncertainty::Uncertainty| {
                known.of_target(&found.target, 0.0)
            };
            let phase = ranging.as_ref().map(|ranging| {
                let answer = ranging.of_target(Segment::Up, &found.line, &found.target);
                let wavelength_m = 2.0 * answer.spacing();
                (answer, uncertainty.map(|known| known.of_phase_range(&answer, wavelength_m)))
            });
            let budget = uncertainty.map(budget);
            sink(Found {
                frame: at,
                chirp,
                found: *found,
                budget,
                phase,
                also: None,
                plan: Some(plan),
            });
        }
    }
    tally.check(cut.codes)?;
    if gaps > 0 {
        eprintln!("{gaps} of {} frames are left out: samples are missing in them", tally.blocks);
    }
    if tally.blocks == 0 {
        return Err(format!(
            "the recording has {number} chirps, and a frame {chirps}: give fewer --chirps"
        ));
    }
    Ok(tally)
}

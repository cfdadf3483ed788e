//! Targets of frames.

use super::samples;
use crate::case::{Case, told};
use crate::seen::{Seen, Trial};
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::frame::{Cells, Frame, FrameConfig, FramePlan, FrameTarget, settle};
use picket_dsp::num_complex::Complex;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::spectrum::engine;
use picket_dsp::{Chirp, Pipeline, Plan, Record, Segment, Verdict};
use picket_simulator::{Run, Truth};
use std::f64::consts::TAU;

/// A target belongs to a source that is no farther off than this in both directions, cells.
const NEAR: f64 = 1.5;

/// The bounds of a source: one standard deviation of range and velocity, and the sizes of a cell.
struct Bound {
    sigma: [f64; 2],
    cell: [f64; 2],
    /// Metres of range for a metre per second.
    coupling: f64,
}

/// The targets of a frame beside the sources: a [`Seen`] for each source, in its order, and one without an answer for a source that is not found.
pub(super) fn trial<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    chirps: usize,
) -> Trial {
    let (plan, found) = targets::<R, N, E>(case, run, chirps, &[]);
    held::<R, N>(case, run, chirps, (plan, found), case.scene.sources.len())
}

/// The first source's target in a frame, beside a background that was recorded of the others alone, in other noise.
pub(super) fn beside<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    number: u64,
    chirps: usize,
) -> Trial {
    let mut still = case.scene.clone();
    still.sources.remove(0);
    still.seed = still.seed.wrapping_add(1);
    let Ok(mut before) = still.run(number) else { panic!("{}: no background", case.label) };
    let mut background = Vec::new();
    framed::<R, N, E>(case, &mut before, chirps, |frame| {
        background = vec![Complex::default(); frame.plan().bins()];
        frame.background(&mut background);
    });
    let found = targets::<R, N, E>(case, run, chirps, &background);
    held::<R, N>(case, run, chirps, found, 1)
}

/// The targets of a frame beside the first sources.
fn held<R: Record, const N: usize>(
    case: &Case,
    run: &mut Run,
    chirps: usize,
    (plan, mut found): (FramePlan, Vec<FrameTarget>),
    sources: usize,
) -> Trial {
    let scene = &case.scene;
    let Some(chirp) = told(scene) else { panic!("{}: no chirp is told", case.label) };
    let period_s = scene.start_s(1, N) - scene.start_s(0, N);
    let rate_hz = scene.rate_hz;
    let middle_s =
        0.5 * (scene.start_s(0, N) + scene.start_s(chirps - 1, N)) + 0.5 * (N - 1) as f64 / rate_hz;
    let mut trial = Trial::default();
    for source in 0..sources {
        let truth = run.truth(source, middle_s, 1);
        let noise = run.noise();
        let bound = bound::<R, N>(&chirp, rate_hz, chirps, period_s, truth.amplitude / noise);
        let cells = |target: &FrameTarget| {
            let error = error(target, &truth);
            let alias = f64::from(plan.alias_mps());
            // In the map, where aliases stand at one place.
            let beat = (error[0] - bound.coupling * error[1]) / bound.cell[0];
            let faster = error[1] - alias * f64::round(error[1] / alias);
            f64::max(beat.abs(), (faster / bound.cell[1]).abs())
        };
        let near = found
            .iter()
            .enumerate()
            .map(|(index, target)| (index, cells(target)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|&(_, away)| away < NEAR);
        let Some((index, _)) = near else {
            trial.missing += 1;
            trial.seen.push(Seen::NOTHING);
            continue;
        };
        let target = found.remove(index);
        trial.seen.push(seen(&target, &truth, &bound));
    }
    trial.more = found.len();
    trial.more_good = found.iter().filter(|found| found.target.verdict == Verdict::Good).count();
    trial
}

/// The targets of a run's frame beside a background.
fn targets<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    chirps: usize,
    background: &[Complex<f32>],
) -> (FramePlan, Vec<FrameTarget>) {
    let mut found = Vec::new();
    let plan = framed::<R, N, E>(case, run, chirps, |frame| {
        found = frame.targets_beside(background).to_vec();
    });
    (plan, found)
}

/// Gathers a run's frame.
fn framed<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    chirps: usize,
    act: impl FnOnce(&Frame<'_>),
) -> FramePlan {
    let scene = run.scene().clone();
    let Some(chirp) = told(&scene) else { panic!("{}: no chirp is told", case.label) };
    let period_s = scene.start_s(1, N) - scene.start_s(0, N);
    let plan = FrameConfig {
        false_alarm: case.config.false_alarm,
        velocity_mps: case.config.velocity_mps,
        range_m: case.config.range_m,
        ..FrameConfig::new(chirp, scene.rate_hz, N, R::IQ, chirps, period_s)
    }
    .plan();
    let Ok(plan) = plan else { panic!("{}: {plan:?}", case.label) };
    let mut cells = vec![[0i16; 2]; plan.cells()];
    let Some(mut frame) = Frame::new(plan, Cells::Narrow(&mut cells)) else {
        panic!("{}: too few cells", case.label)
    };
    let plan_of_chirps = Plan::tone(scene.rate_hz, case.config.codes);
    let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan_of_chirps));
    for index in 0..chirps {
        let clipped = pipeline.look(&samples::<R, N>(run, index));
        frame.push(&pipeline.spectrum().view(), clipped);
    }
    act(&frame);
    plan
}

/// The one target of two frames of different periods, beside the truth in the middle of the first. Both see it from the same start.
pub(super) fn pair<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    number: u64,
    chirps: usize,
) -> Trial {
    let scene = &case.scene;
    let mut longer = scene.clone();
    if let Some(waveform) = &mut longer.waveform {
        waveform.period_s *= 1.2;
        longer.seconds *= 1.2;
    }
    let Ok(mut second) = longer.run(number) else { panic!("{}: no second frame", case.label) };
    let (plan, found) = targets::<R, N, E>(case, run, chirps, &[]);
    let (other_plan, other) = targets::<R, N, E>(case, &mut second, chirps, &[]);
    let middle_s = 0.5 * (scene.start_s(0, N) + scene.start_s(chirps - 1, N))
        + 0.5 * (N - 1) as f64 / scene.rate_hz;
    let truth = run.truth(0, middle_s, 1);
    let seen = match (found.first(), other.first()) {
        (Some(one), Some(other)) => {
            let settled = settle((one, &plan), (other, &other_plan), 0.0);
            let bound = Bound { sigma: [1.0; 2], cell: [1.0; 2], coupling: 0.0 };
            seen(&settled, &truth, &bound)
        }
        _ => Seen::NOTHING,
    };
    Trial { seen: vec![seen], ..Trial::default() }
}

/// The range by phase of a frame's first target.
pub(super) fn phase<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    chirps: usize,
) -> Trial {
    let scene = &case.scene;
    let Some(chirp) = told(scene) else { panic!("{}: no chirp is told", case.label) };
    let none = Calibration::default();
    let ranging = PhaseRanging::new(&chirp, scene.rate_hz, N, R::IQ, none);
    let Ok(ranging) = ranging else { panic!("{}: {ranging:?}", case.label) };
    let (_, found) = targets::<R, N, E>(case, run, chirps, &[]);
    let middle_s = 0.5 * (scene.start_s(0, N) + scene.start_s(chirps - 1, N))
        + 0.5 * (N - 1) as f64 / scene.rate_hz;
    let truth = run.truth(0, middle_s, 1);
    let [range_m, velocity_mps] =
        [truth.range_m, truth.velocity_mps].map(|of| of.unwrap_or(f64::NAN));
    let half_wave = chirp.wavelength_m / 2.0;
    let seen = found.first().map_or(Seen::NOTHING, |found| {
        let answer = ranging.of_target(Segment::Up, &found.line, &found.target);
        super::phases::seen(&answer, range_m, velocity_mps, half_wave)
    });
    Trial { seen: vec![seen], ..Trial::default() }
}

fn error(target: &FrameTarget, truth: &Truth) -> [f64; 2] {
    let velocity = target.target.velocity.unwrap_or_default().to_num::<f64>();
    [
        target.target.range.to_num::<f64>() - truth.range_m.unwrap_or(f64::NAN),
        velocity - truth.velocity_mps.unwrap_or(f64::NAN),
    ]
}

fn seen(target: &FrameTarget, truth: &Truth, bound: &Bound) -> Seen {
    let [range, velocity] = error(target, truth);
    let of = &target.target;
    let [sigma_range, sigma_velocity] = [of.sigma_range, of.sigma_velocity].map(f64::from);
    let listed = of.ambiguity.candidates().iter().map(|candidate| {
        let range = candidate.range.to_num::<f64>() - truth.range_m.unwrap_or(f64::NAN);
        let velocity = candidate.velocity.to_num::<f64>() - truth.velocity_mps.unwrap_or(f64::NAN);
        (range / sigma_range).abs().max((velocity / sigma_velocity).abs())
    });
    Seen {
        off: [range / sigma_range, velocity / sigma_velocity],
        over_bound: [range / bound.sigma[0], velocity / bound.sigma[1]],
        sigma: sigma_range / bound.sigma[0],
        verdict: of.verdict,
        candidate: listed.min_by(f64::total_cmp),
        ..Seen::NOTHING
    }
}

/// The two-dimensional Cramer-Rao bound for one target, with the ratio of its amplitude to the noise's deviation in each part.
fn bound<R: Record, const N: usize>(
    chirp: &Chirp,
    rate_hz: f64,
    chirps: usize,
    period_s: f64,
    ratio: f64,
) -> Bound {
    // The power of a complex sample over that of its noise; a real record has half of the information.
    let snr = if R::IQ { 0.5 * ratio * ratio } else { 0.25 * ratio * ratio };
    let (n, m) = (N as f64, chirps as f64);
    let frequency = |count: f64| (6.0 / (snr * n * m * (count * count - 1.0))).sqrt() / TAU;
    let slope = chirp.bandwidth_hz / chirp.duration_s;
    let middle_s = chirp.guard_s + 0.5 * (n - 1.0) / rate_hz;
    let carrier = SPEED_OF_LIGHT / chirp.wavelength_m + slope * middle_s;
    let mps = SPEED_OF_LIGHT / (2.0 * carrier * period_s);
    let metres = rate_hz * SPEED_OF_LIGHT / (2.0 * slope);
    let velocity = frequency(m) * mps;
    let range = (frequency(n) * metres).hypot(velocity * carrier / slope);
    let coupling = carrier / slope;
    Bound { sigma: [range, velocity], cell: [metres / n, mps / m], coupling }
}

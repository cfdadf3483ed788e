//! Ranges by phase.

use super::samples;
use crate::case::{Case, told};
use crate::seen::{Seen, Trial};
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::solve::phase_range::{Calibration, PhaseRange, PhaseRanging};
use picket_dsp::spectrum::engine;
use picket_dsp::{Outcome, Pipeline, Record, Segment, Shape, Stamp, ToneWithPhase};
use picket_simulator::Run;

/// Lines that are sought.
const LINES: usize = 1;

/// The range by phase of one chirp, beside the truth at the moment to which it refers. The first source is the target; its phase at 0 m is 0.
pub(super) fn trial<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    pipeline: &mut Pipeline<R, N, E>,
) -> Trial {
    let scene = &case.scene;
    let Some(chirp) = told(scene) else { panic!("{}: no chirp is told", case.label) };
    let rate_hz = scene.rate_hz;
    let ranging = PhaseRanging::new(&chirp, rate_hz, N, R::IQ, Calibration::default());
    let Ok(ranging) = ranging else { panic!("{}: {ranging:?}", case.label) };
    let segments = chirp.shape.segments();
    let mut tones = [None::<ToneWithPhase>; 2];
    let mut target = None;
    for (index, &segment) in segments.iter().enumerate() {
        let stamp = Stamp { segment, sequence: index as u32, ..Stamp::default() };
        let samples = samples::<R, N>(run, index);
        let measurement = pipeline.block(&stamp, &samples);
        let tone = pipeline.lines(&measurement, LINES).first().copied();
        match segment {
            Segment::Down => tones[1] = tone,
            Segment::Up => tones[0] = tone,
            _ => {}
        }
        if let Outcome::Target(found) = measurement.result {
            target = Some(found);
        }
    }
    let answer = match (tones, target, chirp.shape) {
        ([Some(up), _], _, Shape::Sawtooth) => ranging.at_rest(Segment::Up, &up),
        ([Some(up), Some(down)], Some(target), _) => ranging.moving(&up, &down, &target),
        _ => return Trial { seen: vec![Seen::NOTHING], ..Trial::default() },
    };
    let truth = run.truth_of_lap(0, 0, N);
    let carrier_hz = scene.waveform.as_ref().map_or(f64::NAN, |waveform| waveform.carrier_hz);
    let half_wave = SPEED_OF_LIGHT / carrier_hz / 2.0;
    let range_m = truth.range_m.unwrap_or(f64::NAN);
    let seen = seen(&answer, range_m, truth.velocity_mps.unwrap_or(f64::NAN), half_wave);
    Trial { seen: vec![seen], ..Trial::default() }
}

/// A range by phase beside the truth.
pub(super) fn seen(answer: &PhaseRange, range_m: f64, velocity_mps: f64, half_wave: f64) -> Seen {
    let off = answer.range.to_num::<f64>() - range_m;
    let faster = answer.velocity.map_or(0.0, |velocity| {
        (velocity.to_num::<f64>() - velocity_mps) / f64::from(answer.sigma_velocity)
    });
    let sigma = f64::from(answer.sigma_by_phase);
    let candidate = answer
        .candidates()
        .map(|candidate| ((candidate.range.to_num::<f64>() - range_m) / sigma).abs())
        .min_by(f64::total_cmp);
    Seen {
        off: [off / f64::from(answer.sigma), faster],
        verdict: answer.verdict,
        candidate,
        cycles: answer.is_sure().then_some(off / half_wave),
        ..Seen::NOTHING
    }
}

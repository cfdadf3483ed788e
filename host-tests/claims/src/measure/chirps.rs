//! Targets of chirps.

use super::samples;
use crate::case::{Case, told};
use crate::seen::{Seen, Trial};
use picket_dsp::config::Config;
use picket_dsp::solve::sequence::Sequence;
use picket_dsp::spectrum::engine;
use picket_dsp::{Ambiguity, Outcome, Pipeline, Record, Segment, Stamp, Target, Usable};
use picket_simulator::{Run, Truth};

/// The target of the last chirp, held against the nearest source at the moment to which it refers. A chirp one of whose beats is within
/// three bins of half the rate, or on a ramp of 0 Hz, where no tone can be told from its image or an offset, is left out.
pub(super) fn trial<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    pipeline: &mut Pipeline<R, N, E>,
    laps: usize,
) -> Trial {
    let Config { scene: picket_dsp::Scene::Chirp(told), .. } = case.config else {
        panic!("{}: no chirp is told", case.label)
    };
    let segments = told.shape.segments();
    let rate_hz = case.scene.rate_hz;
    let mut answer = None;
    for index in 0..laps * segments.len() {
        let start_s = case.scene.start_s(index, N);
        let Some(&segment) = segments.get(index % segments.len()) else { continue };
        let stamp = Stamp {
            segment,
            sequence: index as u32,
            clock: (start_s * rate_hz).round() as u64,
            ..Stamp::default()
        };
        let samples = samples::<R, N>(run, index);
        if let Outcome::Target(target) = pipeline.block(&stamp, &samples).result {
            answer = Some(target);
        }
        for source in 0..case.scene.sources.len() {
            let beat = run.truth(source, start_s, N).frequency_hz.abs() * N as f64 / rate_hz;
            let low = segment != Segment::Flat && beat < 3.0;
            if low || beat > N as f64 / 2.0 - 3.0 {
                return Trial::default();
            }
        }
    }
    let Some(target) = answer else {
        return Trial { seen: vec![Seen::NOTHING], ..Trial::default() };
    };
    let ends = [(laps - 1) * segments.len(), laps * segments.len() - 1];
    let [first, last] = ends.map(|index| case.scene.start_s(index, N));
    let middle_s = 0.5 * (first + last) + 0.5 * (N - 1) as f64 / rate_hz;
    let truths: Vec<Truth> =
        (0..case.scene.sources.len()).map(|source| run.truth(source, middle_s, 1)).collect();
    let nearest = |target: &Target| {
        let all = truths.iter().map(|truth| off(target, truth));
        all.min_by(|a, b| worst(*a).total_cmp(&worst(*b))).unwrap_or([f64::NAN; 2])
    };
    let candidate = match &target.ambiguity {
        Ambiguity::Several(candidates) => candidates
            .iter()
            .map(|candidate| {
                let (range, velocity) = (candidate.range, Some(candidate.velocity));
                worst(nearest(&Target { range, velocity, ..target }))
            })
            .min_by(f64::total_cmp),
        _ => None,
    };
    let (off, verdict) = (nearest(&target), target.verdict);
    let seen = Seen { off, verdict, candidate, ..Seen::NOTHING };
    Trial { seen: vec![seen], ..Trial::default() }
}

/// How far a target is off, range and velocity, in its sigmas.
fn off(target: &Target, truth: &Truth) -> [f64; 2] {
    let range = target.range.to_num::<f64>() - truth.range_m.unwrap_or(f64::NAN);
    let velocity = target
        .velocity
        .map_or(0.0, |velocity| velocity.to_num::<f64>() - truth.velocity_mps.unwrap_or(f64::NAN));
    let over = |error: f64, sigma: f32| if error == 0.0 { 0.0 } else { error / f64::from(sigma) };
    [over(range, target.sigma_range), over(velocity, target.sigma_velocity)]
}

fn worst(off: [f64; 2]) -> f64 {
    off[0].abs().max(off[1].abs())
}

/// What so many chirps show together in the end, at the moment of the last.
pub(super) fn sequence<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    pipeline: &mut Pipeline<R, N, E>,
    laps: u32,
) -> Trial {
    let scene = &case.scene;
    let period = ((scene.start_s(1, N) - scene.start_s(0, N)) * scene.rate_hz).round() as u32;
    let equations = told(scene).map(|chirp| chirp.equations(scene.rate_hz, N, R::IQ));
    let sequence = equations.and_then(|of| Sequence::new(&of.ok()?, period));
    let Some(mut sequence) = sequence else { panic!("{}: no sequence of chirps", case.label) };
    let mut listed = Vec::new();
    for lap in 0..laps {
        let samples = samples::<R, N>(run, lap as usize);
        let clock = u64::from(lap) * u64::from(period);
        let stamp = Stamp { clock, sequence: lap, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &samples);
        if let Some(phasor) = pipeline.lines(&measurement, 1).first() {
            listed = sequence.push(&stamp, phasor).to_vec();
        }
    }
    let truth = run.truth(0, scene.start_s(laps as usize - 1, N), N);
    let usable = |target: &Target| target.verdict.usable() <= Usable::WithinSigma;
    assert!(listed.len() < 2 || !listed.iter().any(usable), "{}: one of several", case.label);
    let each = listed.iter().map(|target| (off(target, &truth), target.verdict));
    let nearest = each.min_by(|a, b| worst(a.0).total_cmp(&worst(b.0)));
    let seen = nearest.map_or(Seen::NOTHING, |(off, verdict)| Seen {
        off,
        verdict,
        candidate: Some(worst(off)),
        ..Seen::NOTHING
    });
    Trial { seen: vec![seen], ..Trial::default() }
}

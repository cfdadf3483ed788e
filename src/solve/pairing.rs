//! Several targets from the beats of a chirp: finds the beats of the rising ramp, of the flat segment and of the falling ramp that belong
//! to one target.
//!
//! The beats of one target satisfy one condition (see [`super::chirp`]) and are equally strong. If beats of different targets do both
//! by chance, they make a ghost. But one chirp later a ghost is not where its own velocity takes it: its beats move as three targets do. So a
//! triple of beats is a target if the chirps before led to it. Until then its verdict is `Ambiguous`.

use super::chirp::{self, Target};
use super::equations::Equations;
use super::segments::{Segments, TRAPEZOID};
use crate::acquire::sample::Stamp;
use crate::list::{first, remove};
use crate::math::fixed_point::to_f32;
use crate::tone::lines::MOST;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::{Usable, Verdict};
use heapless::Vec;

/// Chirps after which an unseen target is forgotten; half as many while the target is not sure.
const MISSES: u8 = 6;

/// The most targets remembered: the sure ones, and triples that may be targets.
const REMEMBERED: usize = 6 * MOST;

/// The most triples of a chirp that are examined.
const TRIPLES: usize = 8 * MOST;

/// Half a gate, in standard deviations.
const GATE: f32 = 5.0;

/// The largest difference between the echoes of one target in the three segments, as a ratio of amplitudes: 3 dB. Noise may add to it.
const EQUAL: f32 = 1.41;

/// The limits of a target's motion: its acceleration, and the time between chirps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionModel {
    /// Time from one chirp to the next, seconds.
    pub period_s: f32,
    /// The most acceleration, m/s^2.
    pub acceleration: f32,
}

/// Pairs the beats of chirp after chirp.
#[derive(Clone, Debug)]
pub struct Pairing {
    equations: Equations,
    /// Whether the beats come from I/Q records, so that their signs are known.
    signed: bool,
    habits: MotionModel,
    beats: [Vec<ToneWithPhase, MOST>; 3],
    segments: Segments,
    /// The falling ramp of the last whole chirp.
    chirp: u32,
    courses: Vec<TargetHypothesis, REMEMBERED>,
}

/// A target of the chirps before.
#[derive(Clone, Copy, Debug)]
struct TargetHypothesis {
    target: Target,
    /// Chirps since the target was seen.
    misses: u8,
    /// Whether the target was where it was expected.
    sure: bool,
    seen: bool,
}

/// Three beats that may belong to one target.
#[derive(Clone, Copy)]
struct Triple {
    beats: [usize; 3],
    target: Target,
    /// The hypothesis that leads to the triple, and the triple's distance from the predicted target, in gates.
    course: Option<usize>,
    distance: f32,
}

impl Pairing {
    /// Pairing for a trapezoid with these equations; `signed` for I/Q records.
    pub const fn new(equations: Equations, signed: bool, habits: MotionModel) -> Self {
        let beats = [const { Vec::new() }; 3];
        let segments = Segments::new();
        Self { equations, signed, habits, beats, segments, chirp: 0, courses: Vec::new() }
    }

    /// Takes the tones of one segment. The falling ramp completes a chirp and returns its targets, the sure ones first. A chirp with a lost
    /// segment returns none.
    ///
    /// Cost: up to 64 triples of beats, each against every target remembered.
    pub fn push(&mut self, stamp: &Stamp, phasors: &[ToneWithPhase]) -> Option<Vec<Target, MOST>> {
        let index = self.segments.push(stamp)?;
        let usable = phasors.iter().copied();
        let usable = usable.filter(|phasor| phasor.tone.verdict.usable() < Usable::No);
        if let Some(beats) = self.beats.get_mut(index) {
            *beats = first(usable);
        }
        if !self.segments.complete(stamp.segment, TRAPEZOID) {
            return None;
        }
        // Chirps in between that were lost.
        let lost = (stamp.sequence.wrapping_sub(self.chirp) / 3).saturating_sub(1);
        let lost = u8::try_from(lost).unwrap_or(u8::MAX);
        self.chirp = stamp.sequence;
        for course in &mut self.courses {
            course.misses = course.misses.saturating_add(lost);
        }
        Some(self.pair())
    }

    /// The targets of a whole chirp.
    fn pair(&mut self) -> Vec<Target, MOST> {
        let mut triples = self.triples();
        let mut used = [[false; MOST]; 3];
        let mut targets = Vec::new();
        let mut fresh: Vec<Target, TRIPLES> = Vec::new();
        self.courses.iter_mut().for_each(|course| course.seen = false);
        while let Some(triple) = self.next(&mut triples) {
            let taken = used.iter().zip(triple.beats);
            if taken.into_iter().any(|(used, beat)| used.get(beat).copied().unwrap_or(true)) {
                continue;
            }
            let led = triple.course.and_then(|index| self.courses.get_mut(index));
            let Some(course) = led.filter(|course| !course.seen) else {
                // Each triple may be a target or a ghost, so none takes its beats from another.
                let _ = fresh.push(triple.target);
                continue;
            };
            *course = TargetHypothesis { target: triple.target, misses: 0, sure: true, seen: true };
            for (used, beat) in used.iter_mut().zip(triple.beats) {
                if let Some(used) = used.get_mut(beat) {
                    *used = true;
                }
            }
            let _ = targets.push(triple.target);
        }
        self.courses.retain_mut(|course| {
            course.misses = if course.seen { 0 } else { course.misses.saturating_add(1) };
            course.misses < if course.sure { MISSES } else { MISSES / 2 }
        });
        for &target in &fresh {
            let course = TargetHypothesis { target, misses: 0, sure: false, seen: true };
            // Without room the target is seen again in the next chirp.
            let _ = self.courses.push(course);
            let verdict = target.verdict.max(Verdict::Ambiguous);
            let _ = targets.push(Target { verdict, ..target });
        }
        targets
    }

    /// Removes the triple that chooses next: triples of sure hypotheses before others, and the nearest first.
    fn next(&self, triples: &mut Vec<Triple, TRIPLES>) -> Option<Triple> {
        // Distances are below two.
        const BEHIND: f32 = 10.0;
        let rank = |triple: &Triple| match triple.course.and_then(|index| self.courses.get(index)) {
            Some(course) if course.sure => triple.distance,
            Some(_) => triple.distance + BEHIND,
            None => triple.distance + 2.0 * BEHIND,
        };
        let ranks = triples.iter().map(rank).enumerate();
        let (index, _) = ranks.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let triple = triples.get(index).copied();
        remove(triples, index);
        triple
    }

    /// All triples whose beats may belong to one target.
    fn triples(&self) -> Vec<Triple, TRIPLES> {
        let [ups, flats, downs] = &self.beats;
        let mut triples = Vec::new();
        for (i, up) in ups.iter().enumerate() {
            for (j, flat) in flats.iter().enumerate() {
                for (k, down) in downs.iter().enumerate() {
                    let tones = [up.tone, flat.tone, down.tone];
                    let off = chirp::contradiction(&tones, self.signed, &self.equations);
                    if off > 1.0 || !are_equal(&[*up, *flat, *down]) {
                        continue;
                    }
                    let target = chirp::trapezoid(&tones, self.signed, &self.equations);
                    let nearest = self.nearest(&target);
                    let triple = Triple {
                        beats: [i, j, k],
                        target,
                        course: nearest.map(|(index, _)| index),
                        distance: nearest.map_or(off, |(_, distance)| distance),
                    };
                    let _ = triples.push(triple);
                }
            }
        }
        triples
    }

    /// The hypothesis that leads to a target: a sure one before others, the nearest of equals.
    fn nearest(&self, target: &Target) -> Option<(usize, f32)> {
        let places = self.courses.iter().enumerate().filter_map(|(index, course)| {
            let distance = self.distance(course, target);
            (distance < 1.0).then_some((index, distance + if course.sure { 0.0 } else { 1.0 }))
        });
        places.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// The distance of a target from the target that a hypothesis predicts, in gates.
    fn distance(&self, course: &TargetHypothesis, target: &Target) -> f32 {
        let MotionModel { period_s, acceleration } = self.habits;
        let time = period_s * (1.0 + f32::from(course.misses));
        let old = &course.target;
        let of = |target: &Target| to_f32(target.velocity.unwrap_or_default());
        let velocity = of(old);
        let range = to_f32(old.range);
        let off_range = to_f32(target.range) - (range - velocity * time);
        let off_velocity = of(target) - velocity;
        let sigma_range = libm::hypotf(
            libm::hypotf(old.sigma_range, target.sigma_range),
            old.sigma_velocity * time,
        );
        let sigma_velocity = libm::hypotf(old.sigma_velocity, target.sigma_velocity);
        let range_gate = GATE * sigma_range + 0.5 * acceleration * time * time;
        let velocity_gate = GATE * sigma_velocity + acceleration * time;
        (off_range.abs() / range_gate).max(off_velocity.abs() / velocity_gate)
    }
}

/// Whether three beats are as strong as the beats of one target.
fn are_equal(beats: &[ToneWithPhase; 3]) -> bool {
    let [a, b, c] = beats;
    [(a, b), (b, c), (a, c)].into_iter().all(|(x, y)| {
        // An amplitude's relative error equals the phase's error.
        let error = GATE * libm::hypotf(x.sigma_phase, y.sigma_phase);
        let (x, y) = (x.tone.amplitude, y.tone.amplitude);
        x.max(y) < (EQUAL + error) * x.min(y)
    })
}

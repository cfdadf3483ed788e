//! The causes that are seen through a tone's moments: changes of the tone, and lines so near that they look alike.
//!
//! A cause is a set of orthogonal directions, each with a normal prior. Of a direction `along` is what is seen, times its size; `size`
//! the square of its size; `pull` what a unit of it does to the offset. With a prior variance t the energy that it explains is
//! `sum along^2 t / (1 + size t)`, and it is `sum ln(1 + size t) / 2` less probable than nothing for being able to.

use super::belief::{Belief, size, sizes};
use super::constants::{CLOSE, DISTANCES, ORDERS, SMOOTH, WALK};
use super::leftover::Leftover;
use super::moments::Moments;
use crate::math::scalar::Scalar as _;

/// One direction of a cause.
#[derive(Clone, Copy, Debug, Default)]
pub struct Direction {
    /// What is seen along it, in deviations of the noise, times the root of `size`.
    pub along: f32,
    /// The square of its length.
    pub size: f32,
    /// What a unit of it does to the offset, bins.
    pub pull: f32,
}

/// A cause at its most probable size.
#[derive(Clone, Copy, Debug)]
pub struct Best {
    /// The logarithm of its weight at that size.
    pub log: f32,
    /// The prior variance there.
    pub variance: f32,
}

impl Best {
    /// Nothing.
    pub const NONE: Self = Self { log: f32::NEG_INFINITY, variance: 1.0 };
}

/// What a round knows that all causes need.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// The evidence of what is left.
    pub leftover: Leftover,
    /// The variance of the offset in noise as loud as the ring's, bins squared.
    pub variance: f32,
    /// The square of the tone's strength.
    pub strength: f32,
}

impl Ground {
    /// The belief in a cause that explains so much energy, is less probable by a logarithm, and moves the offset.
    pub fn belief(&self, explained: f32, cost: f32, offset: f32, variance: f32) -> Belief {
        let (log, scale) = self.leftover.less(explained);
        Belief { log: log - cost, offset, variance: (self.variance + variance) * scale }
    }

    /// That of directions of which a unit has a prior variance of 16^0, 16^1 and so on, up to `most`.
    pub fn weigh(&self, directions: &[Direction], most: f32) -> (Belief, Best) {
        let (count, log) = sizes(most);
        let (mut all, mut best) = (Belief::NEVER, Best::NONE);
        for number in 0..count {
            let t = size(number);
            let belief = self.sized(directions, t).times(-log);
            if belief.log > best.log {
                best = Best { log: belief.log, variance: t };
            }
            all = all.or(belief);
        }
        (all, best)
    }

    fn sized(&self, directions: &[Direction], t: f32) -> Belief {
        /// Products beyond might have no number.
        const LARGE: f32 = 1e20;
        let [mut explained, mut logs, mut offset, mut variance] = [0.0; 4];
        let mut product = 1.0;
        for Direction { along, size, pull } in directions {
            let wider = 1.0 + size * t;
            let share = t / wider;
            explained += along * along * share;
            offset += pull * along * share;
            variance += pull * pull * share;
            product *= wider;
            if product > LARGE {
                logs += product.log_e();
                product = 1.0;
            }
        }
        self.belief(explained, 0.5 * (logs + product.log_e()), offset, variance)
    }
}

/// A change of the level: a random walk's, or a smoother one's. Each of the three smoothnesses with its best size.
pub fn level(ground: &Ground, moments: &Moments) -> (Belief, [(Best, [f32; SMOOTH]); 3]) {
    let mut all = Belief::NEVER;
    let mut walk: [f32; SMOOTH] = [1.0; SMOOTH];
    walk.iter_mut().zip(WALK).for_each(|(size, walk)| *size = walk);
    let best = [1, 2, 4].map(|power| {
        let sizes = walk.map(|size| match power {
            1 => size,
            2 => size * size,
            _ => size * size * size * size,
        });
        let mut directions = [Direction::default(); SMOOTH];
        for ((direction, size), seen) in directions.iter_mut().zip(sizes).zip(moments.amplitude) {
            *direction = Direction { along: seen * size.root(), size, pull: 0.0 };
        }
        /// The logarithm of a third: the smoothnesses are as probable as each other.
        const THIRD: f32 = -1.098_612_3;
        let (belief, best) = ground.weigh(&directions, 2.0 * ground.strength);
        all = all.or(belief.times(THIRD));
        (best, sizes)
    });
    (all, best)
}

/// Radians: a phase changes by so much at most, as a variance over that of a level.
const PHASES: f32 = 4.0;

/// A phase that bends, as in a sweep.
pub fn bend(ground: &Ground, moments: &Moments) -> (Belief, Best) {
    let [_, along, ..] = moments.phase;
    let direction = Direction { along, size: 1.0, pull: 0.0 };
    ground.weigh(&[direction], 2.0 * PHASES * ground.strength)
}

/// A phase that wanders, or jumps: a random walk's, of which order 1 is the frequency and unseen.
pub fn wander(ground: &Ground, moments: &Moments) -> (Belief, Best) {
    let deviation = ground.variance.root();
    let mut directions = [Direction::default(); ORDERS];
    for ((direction, walk), seen) in directions.iter_mut().zip(WALK).zip(moments.phase) {
        *direction = Direction { along: seen * walk.root(), size: walk, pull: 0.0 };
    }
    let [first, ..] = &mut directions;
    *first = Direction { along: 0.0, size: 0.0, pull: -deviation };
    ground.weigh(&directions, 2.0 * PHASES * ground.strength)
}

/// A line near the tone.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Its distance from the tone, bins.
    pub distance: f32,
    /// How probable it is.
    pub belief: Belief,
    /// Its most probable size.
    pub best: Best,
    /// What it has along the tone's phase and a quarter turn on, at that size.
    pub value: [f32; 2],
}

impl Place {
    /// None.
    pub const NONE: Self =
        Self { distance: f32::INFINITY, belief: Belief::NEVER, best: Best::NONE, value: [0.0; 2] };
}

/// Lines up to 1.5 bins away on both sides. `prior` is the logarithm of that of a distance.
pub fn close(ground: &Ground, moments: &Moments, prior: impl Fn(f32) -> f32) -> [[Place; 2]; 6] {
    let deviation = ground.variance.root();
    let mut places = [[Place::NONE; 2]; 6];
    for ((pair, shape), distance) in places.iter_mut().zip(&CLOSE).zip(DISTANCES) {
        // Along the tone's phase, and a quarter turn on: what is even and odd in the distance.
        let [[mut even, mut odd], [mut even_on, mut odd_on]] = [[0.0; 2]; 2];
        let (mut total, mut first) = (0.0, 0.0);
        let seen = moments.amplitude.iter().zip(&moments.phase);
        for (p, (length, (amplitude, phase))) in (1..).zip(shape.iter().zip(seen)) {
            let signed = if p % 4 < 2 { *length } else { -length };
            total += length * length;
            if p % 2 == 0 {
                even += signed * amplitude;
                even_on += signed * phase;
            } else {
                odd += signed * phase;
                odd_on -= signed * amplitude;
            }
            if p == 1 {
                first = *length;
            }
        }
        for (place, side) in pair.iter_mut().zip([-1.0, 1.0]) {
            let directions = [
                Direction {
                    along: even + side * odd,
                    size: total - first * first,
                    pull: -deviation * side * first,
                },
                Direction { along: even_on + side * odd_on, size: total, pull: 0.0 },
            ];
            let (belief, best) = ground.weigh(&directions, 2.0 * ground.strength);
            let prior = prior(distance);
            let value = directions.map(|Direction { along, size, .. }| {
                along * best.variance / (1.0 + size * best.variance)
            });
            *place = Place {
                distance: side * distance,
                belief: belief.times(prior),
                best: Best { log: best.log + prior, ..best },
                value,
            };
        }
    }
    places
}

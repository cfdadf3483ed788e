//! The causes that show in a tone's moments: changes of the tone, and lines so near that they look alike.
//!
//! A cause is a set of orthogonal directions, each with a normal prior. Of a direction, `along` is the observation along it times its size;
//! `size` the square of its size; `pull` the effect of one unit on the offset. With a prior variance t the energy that it explains is
//! `sum along^2 t / (1 + size t)`, and its flexibility makes it `sum ln(1 + size t) / 2` less probable than nothing.

use super::belief::{Belief, size, sizes};
use super::constants::{CLOSE, DISTANCES, ORDERS, SMOOTH, WALK};
use super::leftover::Leftover;
use super::moments::Moments;
use crate::math::scalar::Scalar as _;

/// One direction of a cause.
#[derive(Clone, Copy, Debug, Default)]
pub struct Direction {
    /// The observation along the direction, in deviations of the noise, times the root of `size`.
    pub along: f32,
    /// The square of the direction's length.
    pub size: f32,
    /// The effect of one unit on the offset, bins.
    pub pull: f32,
}

/// A cause at its most probable size.
#[derive(Clone, Copy, Debug)]
pub struct Best {
    /// The logarithm of the cause's weight at this size.
    pub log: f32,
    /// The prior variance at this size.
    pub variance: f32,
}

impl Best {
    /// No cause.
    pub const NONE: Self = Self { log: f32::NEG_INFINITY, variance: 1.0 };
}

/// The quantities of a round that all causes need.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// The evidence of the residual.
    pub leftover: Leftover,
    /// The variance of the offset in noise as loud as the ring, bins squared.
    pub variance: f32,
    /// The square of the tone's strength.
    pub strength: f32,
}

impl Ground {
    /// The belief in a cause that explains this energy, is less probable by the logarithm `cost`, and moves the offset.
    pub fn belief(&self, explained: f32, cost: f32, offset: f32, variance: f32) -> Belief {
        let (log, scale) = self.leftover.less(explained);
        Belief { log: log - cost, offset, variance: (self.variance + variance) * scale }
    }

    /// The belief in these directions, of which a unit has a prior variance of 16^0, 16^1 and so on, up to `most`.
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
        /// Products beyond might become NaN.
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

/// A change of the level: a random walk, or a smoother change. Each of the three smoothnesses has its best size.
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
        /// The logarithm of a third: the smoothnesses are equally probable.
        const THIRD: f32 = -1.098_612_3;
        let (belief, best) = ground.weigh(&directions, 2.0 * ground.strength);
        all = all.or(belief.times(THIRD));
        (best, sizes)
    });
    (all, best)
}

/// The limit of a phase's change in radians, as a variance over the variance of a level.
const PHASES: f32 = 4.0;

/// A phase that bends, as in a sweep.
pub fn bend(ground: &Ground, moments: &Moments) -> (Belief, Best) {
    let [_, along, ..] = moments.phase;
    let direction = Direction { along, size: 1.0, pull: 0.0 };
    ground.weigh(&[direction], 2.0 * PHASES * ground.strength)
}

/// A phase that wanders, or jumps: a random walk, of which order 1 is the frequency and does not show.
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
    /// The line's distance from the tone, bins.
    pub distance: f32,
    /// The belief in the line.
    pub belief: Belief,
    /// The line's most probable size.
    pub best: Best,
    /// The line's value along the tone's phase and a quarter turn on, at this size.
    pub value: [f32; 2],
}

impl Place {
    /// No line.
    pub const NONE: Self =
        Self { distance: f32::INFINITY, belief: Belief::NEVER, best: Best::NONE, value: [0.0; 2] };
}

/// Lines up to 1.5 bins away on both sides. `prior` returns the logarithm of a distance's prior.
pub fn close(ground: &Ground, moments: &Moments, prior: impl Fn(f32) -> f32) -> [[Place; 2]; 6] {
    let deviation = ground.variance.root();
    let mut places = [[Place::NONE; 2]; 6];
    for ((pair, shape), distance) in places.iter_mut().zip(&CLOSE).zip(DISTANCES) {
        // Along the tone's phase, and a quarter turn on: the parts that are even and odd in the distance.
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

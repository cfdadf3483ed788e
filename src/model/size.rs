//! The evidence of a cause of unknown size.
//!
//! A cause is a set of orthogonal directions with normal priors, of a variance that is tried from the noise's up to the tone's, each 16
//! times the one below, all equally probable.

use super::belief::Belief;
use super::leftover::Leftover;
use super::logarithm::{Product, ln};
use crate::math::scalar::{Scalar as _, larger};

/// The number of sizes of a cause that are tried at most.
const SIZES: usize = 10;

/// The search ends at a size whose logarithm is this far below the best one's.
const FAR_BELOW: f32 = 3.0;

/// One direction of a cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direction {
    /// The observation along it times the size's unit.
    pub along: f32,
    /// The square of the size's unit, as far as the bins show it.
    pub square: f32,
    /// The offset that a size of 1 causes, bins.
    pub pull: f32,
}

/// A cause by its sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighed {
    /// The belief in the cause.
    pub belief: Belief,
    /// The logarithm of the belief in the best size.
    pub best: f32,
    /// The best size's variance.
    pub variance: f32,
}

impl Weighed {
    /// An impossible cause.
    pub const NEVER: Self = Self { belief: Belief::NEVER, best: f32::NEG_INFINITY, variance: 1.0 };
}

/// The effect of a cause of one size.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effect {
    /// The energy that it explains.
    pub explained: f32,
    /// The penalty for the freedom of the directions: half the logarithm of the information over the prior's.
    pub cost: f32,
    /// The offset that it moves the tone to.
    pub offset: f32,
    /// The variance that it adds.
    pub variance: f32,
}

/// What all causes of a round are weighed against.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// The evidence of the residual.
    pub leftover: Leftover,
    /// The variance of the tone's offset.
    pub variance: f32,
    /// The tone's energy.
    pub strength: f32,
}

/// The most energy that directions can explain.
pub fn energy(directions: &[Direction]) -> f32 {
    let seen = directions.iter().filter(|direction| direction.square > 0.0);
    seen.map(|direction| direction.along * direction.along / direction.square).sum()
}

impl Ground {
    /// The gain of a cause that explains this energy, if its size were free.
    pub fn gain(&self, energy: f32) -> f32 {
        self.leftover.less(energy).0
    }

    /// Weighs a cause of a variance up to `most`, whose likely variance is `guess`. The largest sizes come first.
    pub fn sized(&self, most: f32, guess: f32, mut effect: impl FnMut(f32) -> Effect) -> Weighed {
        let power = |x: f32| (x.clamp(1.0, 1e12).to_bits() >> 23) as i32 - 127;
        let count = 1 + power(most) / 4;
        let prior = ln(count as f32);
        let first = ((power(guess) + 2) / 4 + 1).max(0).min(count - 1);
        let mut all = [Belief::NEVER; SIZES];
        let mut weighed = Weighed::NEVER;
        let mut tried = 0;
        for (belief, number) in all.iter_mut().zip((0..=first).rev()) {
            tried += 1;
            let variance = f32::two_to(4 * number);
            let effect = effect(variance);
            let (gain, scale) = self.leftover.less(effect.explained);
            let log = gain - effect.cost - prior;
            let spread = (self.variance + effect.variance) * scale;
            *belief = Belief { log, offset: effect.offset, variance: spread };
            if log > weighed.best {
                (weighed.best, weighed.variance) = (log, variance);
            } else if log < weighed.best - FAR_BELOW {
                break;
            }
        }
        Weighed { belief: Belief::any(all.get(..tried).unwrap_or_default()), ..weighed }
    }

    /// Weighs a cause by its directions.
    #[inline(never)]
    pub fn weigh(&self, directions: &[Direction], most: f32) -> Weighed {
        let squares: f32 = directions.iter().map(|direction| direction.square).sum();
        self.sized(most, energy(directions) / larger(squares, 1e-6), |variance| {
            let mut effect = Effect::default();
            let mut product = Product::ONE;
            for Direction { along, square, pull } in directions {
                let wider = 1.0 + square * variance;
                let share = variance / wider;
                effect.explained += along * along * share;
                effect.offset += pull * along * share;
                effect.variance += pull * pull * share;
                product.times(wider);
            }
            effect.cost = 0.5 * product.ln();
            effect
        })
    }
}

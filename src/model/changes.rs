//! Changes of the tone, and lines close to it, on the residual of the nine numbers.
//!
//! Real and imaginary parts of the residual, turned back by the tone's phase and each order's quarter turns, are changes of the amplitude
//! and of the phase. A change of the level is a random walk of the amplitude, or a smoother one; a bend is order 2
//! of the phase; a phase that wanders or jumps is a random walk, whose order 1 is frequency; a close line has the moments of its distance.

use super::constants::{CLOSE, DISTANCES, ORDERS, WALK};
use super::joint::Joint;
use super::shape::turned;
use super::size::Direction;
use crate::math::scalar::Scalar as _;

/// The smoothnesses of a level.
pub const SMOOTHS: usize = 2;

/// The variances of a level by orders: those of a random walk, or their squares.
pub fn level(smooth: usize) -> [f32; ORDERS] {
    WALK.map(|walk| if smooth == 0 { walk } else { walk * walk })
}

/// The variances of a slow swing by orders: slope and bow are as large as each other, and further orders fall as the fourth powers of a
/// random walk's.
pub fn swing() -> [f32; ORDERS] {
    let [_, bow, ..] = WALK;
    WALK.map(|walk| {
        let ratio = if walk < bow { walk / bow } else { 1.0 };
        ratio * ratio * ratio * ratio
    })
}

/// Close lines that are tried.
pub const PLACES: usize = 2 * DISTANCES.len();

/// The residual's moments, of order 1 and up, in deviations of the noise.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// Moments of the amplitude.
    pub amplitude: [f32; ORDERS],
    /// Moments of the phase; 0 at order 1, which is the frequency.
    pub phase: [f32; ORDERS],
    /// The share of each order that lines beside the tone leave.
    pub seen: [f32; ORDERS],
}

impl Moments {
    /// The moments of a joint fit's residual.
    pub fn of(joint: &Joint) -> Self {
        let back = joint.envelope.unit.conj();
        let shares = joint.from.shares();
        let (mut amplitude, mut phase, mut seen) = ([0.0; ORDERS], [0.0; ORDERS], [1.0; ORDERS]);
        let rest = joint.rest.iter().zip(shares).zip(0..).skip(1);
        let cells = amplitude.iter_mut().zip(&mut phase).zip(&mut seen);
        for (((amplitude, phase), seen), ((rest, share), p)) in cells.zip(rest) {
            // A turn back by `j^p` equals a turn on by `j^(3 p)`.
            let along = turned(rest * back, 3 * p) * share.root();
            (*amplitude, *phase, *seen) = (along.re, along.im, share);
        }
        let [first, ..] = &mut phase;
        *first = 0.0;
        Self { amplitude, phase, seen }
    }

    /// A level of each smoothness: its directions, and its variances by orders.
    pub fn levels(&self) -> [[Direction; ORDERS]; SMOOTHS] {
        let mut levels = [[Direction::default(); ORDERS]; SMOOTHS];
        for (smooth, level) in levels.iter_mut().enumerate() {
            let sizes = self::level(smooth);
            for ((direction, size), (along, seen)) in
                level.iter_mut().zip(sizes).zip(self.amplitude.iter().zip(&self.seen))
            {
                *direction =
                    Direction { along: along * size.root(), square: size * seen, pull: 0.0 };
            }
        }
        levels
    }

    /// A bend of the phase.
    pub fn bend(&self) -> [Direction; 1] {
        let ([_, along, ..], [_, square, ..]) = (self.phase, self.seen);
        [Direction { along, square, pull: 0.0 }]
    }

    /// A phase that wanders. `deviation` is the offset's: order 1 is frequency.
    pub fn wander(&self, deviation: f32) -> [Direction; ORDERS] {
        let mut wander = [Direction::default(); ORDERS];
        let seen = WALK.iter().zip(&self.phase).zip(&self.seen);
        for (direction, ((walk, along), seen)) in wander.iter_mut().zip(seen) {
            *direction = Direction { along: along * walk.root(), square: walk * seen, pull: 0.0 };
        }
        let [first, ..] = &mut wander;
        *first = Direction { along: 0.0, square: 0.0, pull: -deviation };
        wander
    }

    /// Close lines at each of [`DISTANCES`] below and above the tone, by strength along the tone's phase and a quarter turn on.
    pub fn close(&self, deviation: f32) -> [(f32, [Direction; 2]); PLACES] {
        let mut close = [(0.0, [Direction::default(); 2]); PLACES];
        let [seen_first, ..] = self.seen;
        let pairs = close.as_chunks_mut::<2>().0.iter_mut();
        for (([below, above], moments), distance) in pairs.zip(&CLOSE).zip(DISTANCES) {
            let [mut even, mut odd] = [[0.0; 2]; 2];
            let mut total = 0.0;
            let seen = self.amplitude.iter().zip(&self.phase).zip(&self.seen);
            for (((amplitude, phase), seen), (length, p)) in seen.zip(moments.iter().zip(1..)) {
                let signed = if p % 4 < 2 { *length } else { -length };
                total += length * length * seen;
                let [sums, by] = if p % 2 == 0 {
                    [&mut even, &mut [*amplitude, *phase]]
                } else {
                    [&mut odd, &mut [*phase, -amplitude]]
                };
                let [re, im] = sums;
                let [along, on] = *by;
                *re += signed * along;
                *im += signed * on;
            }
            let [first, ..] = moments;
            let ([even, even_on], [odd, odd_on]) = (even, odd);
            for (cell, side) in [(below, -1.0), (above, 1.0)] {
                let along = Direction {
                    along: even + side * odd,
                    square: total - first * first * seen_first,
                    pull: -deviation * side * first,
                };
                let on = Direction { along: even_on + side * odd_on, square: total, pull: 0.0 };
                *cell = (side * distance, [along, on]);
            }
        }
        close
    }
}

//! Seeded random numbers: the same on every machine.

use core::f64::consts::TAU;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A stream of random numbers. Each trial under a seed, and each part of a scene in it, has a stream of its own: neither the order in
/// which trials are made nor a further source changes what the others draw.
#[derive(Clone, Debug)]
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// The stream of a trial.
    pub fn new(seed: u64, trial: u64) -> Self {
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        stream.set_stream(trial);
        Draw(stream)
    }

    /// The stream of a part of a scene, in a trial.
    pub(crate) fn part(seed: u64, trial: u64, part: usize) -> Self {
        Self::new(seed ^ (part as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15), trial)
    }

    /// Any number from 0 to 1, the latter excluded.
    pub fn share(&mut self) -> f64 {
        self.0.random()
    }

    /// Any number between two.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Any phase, radians.
    pub fn phase(&mut self) -> f64 {
        TAU * self.share()
    }

    /// A normal number.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// An exponential number of mean 1: the power of a bin of noise, the time between arrivals.
    pub fn exponential(&mut self) -> f64 {
        -libm::log(1.0 - self.share())
    }

    /// A number below this one, from 0 on.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count.max(1))
    }

    /// Yes or no.
    pub fn either(&mut self) -> bool {
        self.0.random()
    }

    /// +1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.either() { 1.0 } else { -1.0 }
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }
}

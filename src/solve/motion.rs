//! How a followed tone may move: a bank of three Kalman filters of two states, frequency and rate, weighed by their innovations.
//!
//! It is not known beforehand whether a target stands, accelerates or jumps, and a single filter is wrong about two of the three. So three
//! models run in parallel, as an interacting multiple model (Blom and Bar-Shalom 1988; Bar-Shalom, Li and Kirubarajan 2001, section
//! 11.6.6). The models mix before each block; after it, each is as probable as its innovation says. The answer is the mean of all three,
//! and its variance includes what they differ by.
//!
//! | model | what moves it from block to block |
//! |---|---|
//! | calm | white acceleration, Lambda [`CALM`] |
//! | agile | white acceleration, Lambda [`AGILE`] |
//! | restless | white steps of the frequency and of the rate, learnt |
//!
//! Lambda is the sigma of the acceleration over the sigma of a measurement, per block squared (Kalata 1984). It sets a filter's steady state:
//!
//! | Lambda | gain of the frequency | of the rate | variance over a block's | settles in |
//! |---|---|---|---|---|
//! | 0.05 | 0.271 | 0.043 | 0.27 | 11 blocks |
//! | 0.9 | 0.732 | 0.466 | 0.73 | 3 |
//!
//! The restless model's steps are those of the innovations (covariance matching, Mehra 1972), never less than [`STEP`] sigma of a
//! measurement, and in each block as large as explains it. So a tone that steps is answered as its block measures it, with the block's own
//! sigma.

use crate::math::scalar::Scalar;

/// Lambda of the calm model.
pub(crate) const CALM: f32 = 0.05;

/// The gains of frequency and rate to which the calm model settles.
pub(super) const CALM_GAINS: [f32; 2] = [0.271, 0.043];

/// Lambda of the agile model.
const AGILE: f32 = 0.9;

/// The least steps of the restless model, in sigma of a measurement. What is smaller, the agile model follows.
const STEP: f32 = 3.0;

/// The weight of a block in the steps that the restless model has learnt, and the factor by which they may grow from one block to the next.
const RENEWAL: f32 = 0.25;
const GROWTH: f32 = 2.0;

/// The probabilities that a target changes to another model: one calm block in 100 is the last, and one in 50 of the others.
const BEGINS: f32 = 0.005;
const ENDS: f32 = 0.015;

/// The probabilities of changes, for each model from the calm, the agile and the restless one.
const CHANGES: [[f32; MODELS]; MODELS] = [
    [1.0 - 2.0 * BEGINS, ENDS, 0.5 * ENDS],
    [BEGINS, 1.0 - ENDS - BEGINS, 0.5 * ENDS],
    [BEGINS, BEGINS, 1.0 - ENDS],
];

/// Three models are the fewest that follow a target that stands, one that accelerates and one that jumps.
const MODELS: usize = 3;

/// A filter of the bank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Model {
    /// The probability of the model.
    weight: f32,
    /// The frequency beyond the bank's, cycles per sample, and the rate, cycles per sample per block.
    place: f32,
    rate: f32,
    /// Variance of the frequency, covariance, variance of the rate.
    covariance: [f32; 3],
}

impl Model {
    /// The mean of models with these weights, and the covariance of their mixture.
    fn mixture(models: &[Self; MODELS], weights: [f32; MODELS]) -> Self {
        let mut mean = Self::default();
        for (model, weight) in models.iter().zip(&weights) {
            mean.weight += weight;
            mean.place += weight * model.place;
            mean.rate += weight * model.rate;
        }
        let whole = 1.0 / mean.weight;
        (mean.place, mean.rate) = (mean.place * whole, mean.rate * whole);
        let [mut x, mut xv, mut v] = [0.0; 3];
        for (model, weight) in models.iter().zip(&weights) {
            let [of_x, of_xv, of_v] = model.covariance;
            let (dx, dv) = (model.place - mean.place, model.rate - mean.rate);
            x += weight * (of_x + dx * dx);
            xv += weight * (of_xv + dx * dv);
            v += weight * (of_v + dv * dv);
        }
        Self { covariance: [x * whole, xv * whole, v * whole], ..mean }
    }

    /// Advances by `blocks`, moved by noise of these three parts of a covariance.
    fn predict(&mut self, blocks: f32, noise: [f32; 3]) {
        let [x, xv, v] = self.covariance;
        let [nx, nxv, nv] = noise;
        self.place += self.rate * blocks;
        self.covariance = [x + blocks * (xv + xv + blocks * v) + nx, xv + blocks * v + nxv, v + nv];
    }

    /// Takes a measurement that lies `innovation` from the prediction. Returns the logarithm of its likelihood.
    fn update(&mut self, innovation: f32, variance: f32) -> f32 {
        let [x, xv, v] = self.covariance;
        let total = (x + variance).max(f32::MIN_POSITIVE);
        let (gain, rate_gain) = (x / total, xv / total);
        self.place += gain * innovation;
        self.rate += rate_gain * innovation;
        // The variances after the measurement. Neither can round below zero.
        let rest = variance / total;
        self.covariance = [x * rest, xv * rest, (v - rate_gain * xv).max(0.0)];
        -0.5 * (square(innovation) / total + total.log_e())
    }
}

/// The motion of a tone. The frequency itself is the track's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    /// The calm, the agile and the restless model.
    models: [Model; MODELS],
    /// The answer: the mixture of all models.
    all: Model,
    /// The variance of the restless model's steps as learnt, of the frequency and of the rate per block.
    steps: f32,
}

impl Motion {
    /// A tone seen once, with the variances of a measurement and of a new target's rate.
    pub fn start(variance: f32, rate: f32) -> Self {
        let weight = const { 1.0 / MODELS as f32 };
        let model = Model { weight, covariance: [variance, 0.0, rate], ..Model::default() };
        Self { models: [model; MODELS], all: model, steps: rate }
    }

    /// The rate, cycles per sample per block.
    pub fn rate(&self) -> f32 {
        self.all.rate
    }

    /// Variance of the frequency, covariance, variance of the rate.
    pub fn covariance(&self) -> [f32; 3] {
        self.all.covariance
    }

    /// Forgets the rate: its variance is that of a new target's again.
    pub fn forget(&mut self, rate: f32) {
        for model in &mut self.models {
            let [x, _, _] = model.covariance;
            model.covariance = [x, 0.0, rate];
        }
        self.steps = self.steps.max(rate);
        self.centre();
    }

    /// Notes that what looked like scatter of this variance is a movement: the target may be that far off, and may step that far again.
    pub fn unsettle(&mut self, variance: f32) {
        for model in &mut self.models {
            let [x, xv, v] = model.covariance;
            model.covariance = [x + variance, xv, v + variance];
        }
        self.steps = self.steps.max(variance);
        self.centre();
    }

    /// Turns the frequency's axis, as a mirror image has it.
    pub fn turn(&mut self) {
        for model in &mut self.models {
            (model.place, model.rate) = (-model.place, -model.rate);
        }
        self.all.rate = -self.all.rate;
    }

    /// Advances by `blocks`. `variance` is that of a measurement. Returns the move of the frequency, cycles per sample.
    pub fn predict(&mut self, blocks: f32, variance: f32) -> f32 {
        // A white acceleration, constant within a block. Its variance grows with the number of blocks.
        let accelerated = |agility: f32| {
            let v = square(agility) * variance * blocks;
            [blocks * blocks * 0.25 * v, blocks * 0.5 * v, v]
        };
        let steps = blocks * self.steps;
        let least = blocks * square(STEP) * variance;
        let noises = [accelerated(CALM), accelerated(AGILE), [steps.max(least), 0.0, steps]];
        let [calm, agile, restless] = self.models.each_ref().map(|model| model.weight);
        self.models = CHANGES
            .map(|[a, b, c]| Model::mixture(&self.models, [a * calm, b * agile, c * restless]));
        for (model, noise) in self.models.iter_mut().zip(&noises) {
            model.predict(blocks, *noise);
        }
        self.centre()
    }

    /// Takes a measurement that lies `innovation` from the prediction. Returns the move of the frequency, cycles per sample.
    pub fn update(&mut self, innovation: f32, variance: f32) -> f32 {
        let [_, _, restless] = &mut self.models;
        let [x, _, v] = &mut restless.covariance;
        let beyond = (square(innovation - restless.place) - *x - variance).max(0.0);
        (*x, *v) = (*x + beyond, *v + beyond);
        self.steps += RENEWAL * (GROWTH * beyond - self.steps);
        let logs =
            self.models.each_mut().map(|model| model.update(innovation - model.place, variance));
        let most = logs.into_iter().fold(f32::NEG_INFINITY, f32::max);
        for (model, log) in self.models.iter_mut().zip(logs) {
            model.weight *= libm::expf(log - most);
        }
        let whole = 1.0 / self.models.iter().map(|model| model.weight).sum::<f32>();
        self.models.iter_mut().for_each(|model| model.weight *= whole);
        self.centre()
    }

    /// Mixes the answer from all models, and measures their places from its place, which it returns.
    fn centre(&mut self) -> f32 {
        let weights = self.models.each_ref().map(|model| model.weight);
        self.all = Model::mixture(&self.models, weights);
        let place = self.all.place;
        self.models.iter_mut().for_each(|model| model.place -= place);
        place
    }
}

/// The gain of the frequency to which a filter settles at this Lambda (Kalata 1984: `1 - r^2`, with `r = (4 + L - sqrt(8 L + L^2)) / 4`).
pub(crate) fn gain(agility: f32) -> f32 {
    let r = 0.25 * (4.0 + agility - (agility * (8.0 + agility)).root());
    1.0 - r * r
}

fn square(x: f32) -> f32 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f32 = 1e-10;

    /// A bank whose last 200 measurements were where it expected them.
    fn settled() -> Motion {
        let mut motion = Motion::start(R, 4e-6);
        for _ in 0..200 {
            let moved = motion.predict(1.0, R);
            motion.update(-moved, R);
        }
        motion
    }

    /// The gains of the table above.
    #[test]
    fn a_filter_settles_where_the_tracking_index_says() {
        for (agility, [alpha, beta]) in [(CALM, CALM_GAINS), (AGILE, [0.732, 0.466])] {
            assert!((gain(agility) - alpha).abs() < 5e-4, "{agility}: {}", gain(agility));
            let mut model = Model { covariance: [R, 0.0, R], ..Model::default() };
            let q = agility * agility * R;
            for _ in 0..200 {
                model.predict(1.0, [0.25 * q, 0.5 * q, q]);
                model.update(0.0, R);
            }
            let [variance, covariance, _] = model.covariance.map(|c| c / R);
            assert!((variance / alpha - 1.0).abs() < 0.01, "{agility}: {variance}");
            assert!((covariance / beta - 1.0).abs() < 0.01, "{agility}: {covariance}");
        }
    }

    /// A calm target has the calm model's variance; 15 % more belong to the other two.
    #[test]
    fn a_calm_target_is_followed_calmly() {
        let [variance, _, _] = settled().covariance().map(|c| c / R);
        assert!((0.27..0.32).contains(&variance), "{variance}");
    }

    /// A step of 20 sigma or 4,000 is answered as the block measures it, with at least the block's sigma; so are the blocks behind it.
    #[test]
    fn a_step_is_answered_as_measured() {
        for step in [20.0, 4000.0] {
            let step = step * R.sqrt();
            let mut motion = settled();
            let mut place = 0.0;
            for block in 0..4 {
                place += motion.predict(1.0, R);
                place += motion.update(step - place, R);
                let [variance, _, _] = motion.covariance();
                let error = place - step;
                assert!(error * error < variance, "{block}: {error} of {step}");
                assert!(block > 0 || variance > 0.9 * R, "{block}: {}", variance / R);
                assert!(variance < 1.2 * R, "{block}: {}", variance / R);
            }
        }
    }

    /// A target that seemed to scatter by 1e4 sigma is where the next block measures it, and its next step is no surprise.
    #[test]
    fn an_end_of_scatter_is_no_surprise() {
        let mut motion = settled();
        let scatter = 1e8 * R;
        motion.unsettle(scatter);
        let moved = motion.update(scatter.root(), R);
        assert!((moved / scatter.root() - 1.0).abs() < 1e-3, "{moved}");
        motion.predict(1.0, R);
        let [variance, _, _] = motion.covariance();
        assert!(variance > 0.9 * scatter, "{}", variance / scatter);
    }

    /// Two misses and a likelihood of nothing leave numbers.
    #[test]
    fn extremes_stay_finite() {
        for (variance, innovation) in
            [(0.0, 0.0), (0.0, 0.5), (1e-30, 0.5), (0.9, 1e-12), (0.9, 0.5)]
        {
            let mut motion = Motion::start(variance, 4e-6);
            for _ in 0..100 {
                motion.predict(1e9, variance);
                motion.predict(1.0, variance);
                motion.update(innovation, variance);
            }
            assert!(motion.covariance().iter().all(|c| c.is_finite()), "{variance} {motion:?}");
        }
    }
}

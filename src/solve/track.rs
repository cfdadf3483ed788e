//! A tone followed from block to block.
//!
//! A Kalman filter of two states, frequency and its rate. It takes each measurement with the estimator's sigma, and assumes white
//! acceleration between blocks (Bar-Shalom, Li and Kirubarajan 2001, section 6.3). The frequency is kept in steps of 2^-32 cycle per
//! sample, as exact as measured; the rate and the covariance are `f32`. Lambda is the sigma of the acceleration over the sigma of a
//! measurement, per block squared. It sets the steady state:
//!
//! | Lambda | gain of the frequency | of the rate | variance over a block's | settles in |
//! |---|---|---|---|---|
//! | 0.01 | 0.132 | 0.0093 | 0.13 | 23 blocks |
//! | 0.03 | 0.217 | 0.027 | 0.22 | 14 |
//! | 0.1 | 0.360 | 0.080 | 0.36 | 8 |
//! | 0.3 | 0.537 | 0.204 | 0.54 | 6 |

use crate::math::scalar::Scalar;
use crate::tone::Tone;
use crate::tone::evidence::Evidence;
use crate::tone::judge::LineClass;

/// The parameters of the filter that follows tones, in its own units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// Lambda: sigma of a target's acceleration over sigma of a measurement, per block squared.
    /// Usual values are 0.03 to 0.1.
    pub agility: f32,
    /// The least sigma of the acceleration, cycles per sample per block squared. A
    /// target may accelerate this much however well it is measured.
    pub acceleration: f32,
    /// Sigma of the rate of a target that was seen only once, cycles per sample per block.
    pub rate: f32,
    /// Lines that are less than this apart, cycles per sample, are one line.
    pub apart: f32,
    /// The variance that the tone's envelope adds to a block of the mean power, in squared cycles per sample. It includes the effect of the
    /// correlation from block to block: see [`Width::followed`](crate::carrier::Width::followed).
    pub envelope: f32,
    /// The part of this variance that a block's own sigma includes, see [`crate::carrier`].
    pub stated: f32,
    /// The most tones followed at once: 0 to [`crate::tone::lines::MOST`]; 0 follows none.
    pub most: usize,
    /// While a track is held, one block in `refresh` is searched whole; 0 or 1 searches every
    /// block.
    pub refresh: u8,
}

/// The gain of the frequency to which the filter settles at this Lambda (Kalata 1984: `1 - r^2`, with `r = (4 + L - sqrt(8 L + L^2)) / 4`).
pub(crate) fn gain(agility: f32) -> f32 {
    let r = 0.25 * (4.0 + agility - (agility * (8.0 + agility)).root());
    1.0 - r * r
}

/// The state of a track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// Seen once. A second detection within two more blocks confirms the track.
    #[default]
    Tentative = 0,
    /// Confirmed.
    Held = 1,
    /// Missed in [`MISSES`] blocks in a row. The track is reported once in this state and then
    /// dropped.
    Lost = 2,
}

impl State {
    /// The state with this number on the wire; `None` for an unknown number.
    pub const fn from_u8(code: u8) -> Option<Self> {
        match code {
            0 => Some(State::Tentative),
            1 => Some(State::Held),
            2 => Some(State::Lost),
            _ => None,
        }
    }

    /// "tentative", "held" or "lost".
    pub const fn name(self) -> &'static str {
        match self {
            State::Tentative => "tentative",
            State::Held => "held",
            State::Lost => "lost",
        }
    }
}

/// Misses in a row after which a track is lost.
pub const MISSES: u8 = 5;

/// Blocks within which a tentative track is confirmed or dropped.
const TRIAL: u32 = 2;

/// Half the gate, in standard deviations of the innovation.
pub const GATE: f32 = 4.0;

/// The widest half gate, cycles per sample. A target that was missed often could be anywhere, and
/// the search for new targets finds it.
const WIDEST: f32 = 1.0 / 64.0;

/// The rate, cycles per sample per block, and the covariance of frequency and rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Motion {
    rate: f32,
    /// Variance of the frequency, covariance, variance of the rate.
    covariance: [f32; 3],
}

impl Motion {
    /// Advances by `blocks`. Returns the move of the frequency, in cycles per sample.
    fn predict(&mut self, blocks: f32, acceleration: f32) -> f32 {
        let [x, xv, v] = self.covariance;
        // A white acceleration, constant within a block. Its variance grows with the number of
        // blocks.
        let q = acceleration * acceleration * blocks;
        self.covariance = [
            x + blocks * (xv + xv) + blocks * blocks * (v + q * 0.25),
            xv + blocks * (v + q * 0.5),
            v + q,
        ];
        self.rate * blocks
    }

    /// Takes a measurement that lies `innovation` from the prediction. Returns the move of the frequency.
    fn update(&mut self, innovation: f32, variance: f32) -> f32 {
        let [x, xv, v] = self.covariance;
        let total = x + variance;
        let (gain, rate_gain) = (x / total, xv / total);
        self.rate += rate_gain * innovation;
        // The variances after the measurement. Neither can round below zero.
        let rest = variance / total;
        self.covariance = [x * rest, xv * rest, (v - rate_gain * xv).max(0.0)];
        gain * innovation
    }
}

/// A tone that is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// The number of the track, counted since the start. A track keeps its number.
    pub number: u32,
    /// The state of the track.
    pub state: State,
    /// The tone as filtered, or as predicted if this block missed it. The sigma is the filter's. The verdict is `Good` only if this block's
    /// measurement was good.
    pub tone: Tone,
    /// Blocks since the first measurement.
    pub age: u32,
    /// Blocks since the last measurement.
    pub misses: u8,
    motion: Motion,
    learnt: Learnt,
}

/// The scatter and the restlessness of a target, learnt from its measurements.
///
/// A measurement's sigma covers the noise within one block. A target with many reflecting parts scatters more from block to block, the more
/// the weaker it is in a block (see [`crate::carrier`]), and nobody knows beforehand how it moves. The innovations, divided by their own
/// sigma, show both. Their mean square should be 1: if it is more, the measurements scatter more. Each should be independent of the one
/// before: if two in a row lie on the same side, the target accelerates more than expected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Learnt {
    /// The variance of a measurement as stated by its blocks, averaged.
    variance: f32,
    /// The square of the amplitude, averaged, and the number of measurements in the average.
    power: f32,
    seen: f32,
    /// Logarithms of two factors, not below 0: of the measurements' variance and of the acceleration's sigma.
    scatter: f32,
    unrest: f32,
    /// The last innovation over its sigma.
    last: f32,
}

impl Learnt {
    /// The speed of learning, and the level that noise alone must not exceed, so that a steady
    /// target does not seem restless by chance.
    const SPEED: f32 = 0.05;
    const SCATTER: f32 = 1.3;
    const UNREST: f32 = 0.3;
    /// The limit of one innovation, the limit of the sum of all, and the least sum that has an effect. A track with nothing to learn
    /// exceeds the least sum one time in ten.
    const MOST: f32 = 9.0;
    const HIGHEST: f32 = 18.0;
    const EVIDENT: f32 = 0.3;
    /// The share of a block in the average of variances, and the factor by which one block may be
    /// better than the average.
    const RENEWAL: f32 = 1.0 / 8.0;
    const BETTER: f32 = 4.0;
    /// The measurements that the average power has, and the deepest fade that counts.
    const POWERS: f32 = 32.0;
    const DEEPEST: f32 = 1e4;

    fn start(tone: &Tone) -> Self {
        let power = square(tone.amplitude);
        Self { variance: square(tone.sigma), power, seen: 1.0, ..Self::default() }
    }

    /// The factor by which a tone is weaker than the average, in power.
    fn faded(&self, tone: &Tone) -> f32 {
        let faded = self.power / square(tone.amplitude);
        // A tone without an amplitude gives NaN here.
        if faded < Self::DEEPEST { faded } else { Self::DEEPEST }
    }

    /// The variance of a measurement whose block states `block`, of a tone that is weaker by `faded` than the average: the known part, and
    /// the part learnt beyond.
    fn variance(&self, block: f32, faded: f32, tracking: &Tracking) -> [f32; 2] {
        let average = self.average(block);
        let stated = average.max(block / Self::BETTER);
        let known = stated + (tracking.envelope * faded - tracking.stated);
        [known, average * (Self::times(self.scatter) - 1.0) * faded]
    }

    /// The sum of both parts. The learnt factor settles where squared innovations are [`Learnt::SCATTER`] times their mean: the whole
    /// variance is larger by this ratio.
    fn whole([known, learnt]: [f32; 2]) -> f32 {
        known + Self::SCATTER * learnt
    }

    /// The standard deviation by which measurements scatter beyond what their blocks state.
    fn excess(&self) -> f32 {
        (self.variance * (Self::times(self.scatter) - 1.0)).root()
    }

    fn times(log: f32) -> f32 {
        if log > Self::EVIDENT { libm::expf(log) } else { 1.0 }
    }

    /// A harmonic mean: a suspicious block states too large a variance.
    fn average(&self, block: f32) -> f32 {
        1.0 / ((1.0 - Self::RENEWAL) / self.variance + Self::RENEWAL / block)
    }

    /// Takes this measurement's innovation over its sigma.
    #[allow(clippy::manual_clamp)] // `clamp` checks its bounds
    fn learn(&mut self, tone: &Tone, innovation: f32) {
        self.variance = self.average(square(tone.sigma));
        self.seen = (self.seen + 1.0).min(Self::POWERS);
        self.power += (square(tone.amplitude) - self.power) / self.seen;
        let within = |x: f32| x.max(-Self::MOST).min(Self::MOST);
        let grown = |log: f32, by: f32| (log + Self::SPEED * by).max(0.0).min(Self::HIGHEST);
        self.scatter = grown(self.scatter, within(innovation * innovation) - Self::SCATTER);
        self.unrest = grown(self.unrest, within(innovation * self.last) - Self::UNREST);
        self.last = innovation;
    }

    /// Sigma of the acceleration.
    fn acceleration(&self, tracking: &Tracking) -> f32 {
        let usual = (tracking.agility * self.variance.root()).max(tracking.acceleration);
        usual * Self::times(self.unrest)
    }
}

impl Track {
    /// A track that starts with a measurement.
    pub fn start(number: u32, tone: &Tone, tracking: &Tracking) -> Self {
        let variance = square(tone.sigma);
        let motion = Motion { rate: 0.0, covariance: [variance, 0.0, square(tracking.rate)] };
        Self { number, tone: *tone, motion, learnt: Learnt::start(tone), ..Self::default() }
    }

    /// The rate, cycles per sample per block.
    pub fn rate(&self) -> f32 {
        self.motion.rate
    }

    /// Variance of the frequency, covariance, variance of the rate; in cycles per sample and
    /// blocks.
    pub fn covariance(&self) -> [f32; 3] {
        self.motion.covariance
    }

    /// Advances by `blocks` blocks. After a gap the clock may have moved, so the rate is as
    /// uncertain as at the start.
    pub fn predict(&mut self, blocks: u32, gap: bool, tracking: &Tracking) {
        if gap {
            let [x, _, _] = self.motion.covariance;
            self.motion.covariance = [x, 0.0, square(tracking.rate)];
        }
        let moved = self.motion.predict(blocks as f32, self.learnt.acceleration(tracking));
        self.shift(moved);
        self.age = self.age.saturating_add(blocks);
    }

    /// Half the gate for a measurement like the last ones, cycles per sample.
    pub fn gate(&self, tracking: &Tracking) -> f32 {
        let [place, _, _] = self.motion.covariance;
        let variance = Learnt::whole(self.learnt.variance(self.learnt.variance, 1.0, tracking));
        (GATE * (place + variance).root()).min(WIDEST)
    }

    /// The standard deviation by which the measurements scatter beyond their own sigmas, cycles per sample: the carrier's width as learnt
    /// by the track. 0 where there is nothing to learn.
    pub fn excess(&self) -> f32 {
        self.learnt.excess()
    }

    /// The distance of a tone from the prediction, cycles per sample, signed. It wraps round the
    /// circle of I/Q frequencies.
    pub fn innovation(&self, tone: &Tone) -> f32 {
        tone.frequency.beyond(self.tone.frequency)
    }

    /// The distance of a tone from the prediction in half gates; `None` outside the gate, and for a tone whose sigma locates nothing. No
    /// gate is narrower than the distance below which another line would be a part of this one.
    pub fn distance(&self, tone: &Tone, tracking: &Tracking) -> Option<f32> {
        let [place, _, _] = self.motion.covariance;
        let gate = GATE * (place + Learnt::whole(self.variance(tone, tracking))).root();
        let gate = gate.min(WIDEST).max(tracking.apart);
        let distance = self.innovation(tone).abs() / gate;
        (distance <= 1.0 && tells(tone)).then_some(distance)
    }

    /// The variance of this measurement, by [`Learnt::variance`].
    fn variance(&self, tone: &Tone, tracking: &Tracking) -> [f32; 2] {
        self.learnt.variance(square(tone.sigma), self.learnt.faded(tone), tracking)
    }

    /// Updates the track with this block's measurement.
    pub fn update(&mut self, tone: &Tone, tracking: &Tracking) {
        let innovation = self.innovation(tone);
        let [known, learnt] = self.variance(tone, tracking);
        let variance = Learnt::whole([known, learnt]);
        let [place, _, _] = self.motion.covariance;
        self.learnt.learn(tone, innovation / (place + known + learnt).root());
        // A measurement beyond the gate scatters more than is known so far.
        let variance = variance.max(square(innovation) * (1.0 / (GATE * GATE)) - place);
        let moved = self.motion.update(innovation, variance);
        self.tone = Tone { frequency: self.tone.frequency, ..*tone };
        self.shift(moved);
        self.misses = 0;
        // A tentative track lives so briefly that any second measurement confirms it.
        if self.state == State::Tentative {
            self.state = State::Held;
        }
    }

    /// Notes that this block has no measurement.
    pub fn miss(&mut self) {
        self.misses = self.misses.saturating_add(1);
        let given_up = match self.state {
            State::Tentative => self.age >= TRIAL,
            State::Held => self.misses >= MISSES,
            State::Lost => true,
        };
        if given_up {
            self.state = State::Lost;
        }
        let missed = Evidence { detected: false, ..Evidence::CLEAN };
        self.tone.conclude(if given_up { &Evidence::NO_TONE } else { &missed });
    }

    /// Notes that another tone is too near to separate the two. This is neither a hit nor a miss.
    pub fn coast(&mut self) {
        self.tone.conclude(&Evidence { line: LineClass::Unresolved, ..Evidence::CLEAN });
    }

    fn shift(&mut self, cycles: f32) {
        self.tone.frequency = self.tone.frequency.moved(cycles);
        let [variance, _, _] = self.motion.covariance;
        self.tone.sigma = variance.root();
    }
}

/// Whether a tone's sigma locates it: a sigma of a cycle per sample is the whole spectrum. An infinite sigma, from a record that sits on a
/// rail, would make the filter's covariance NaN.
pub(super) fn tells(tone: &Tone) -> bool {
    tone.sigma < 1.0
}

fn square(x: f32) -> f32 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::frequency::Frequency;
    use crate::tone::verdict::Verdict;

    const TRACKING: Tracking = Tracking {
        agility: 0.05,
        acceleration: 0.0,
        rate: 2e-3,
        apart: 0.0,
        envelope: 0.0,
        stated: 0.0,
        most: 1,
        refresh: 0,
    };

    fn tone(cycles: f64, sigma: f32) -> Tone {
        let frequency = Frequency::from_bins(0, cycles, 1).unwrap();
        Tone { frequency, sigma, snr: 1.0, amplitude: 1.0, rate_hz: 1.0, ..Tone::ZERO }
    }

    /// The gains and the variance of the table above.
    #[test]
    fn the_filter_settles_where_the_tracking_index_says() {
        for (agility, variance, alpha) in
            [(0.01, 0.132, 0.132), (0.03, 0.217, 0.217), (0.1, 0.36, 0.36), (0.3, 0.537, 0.537)]
        {
            let tracking = Tracking { agility, ..TRACKING };
            let mut track = Track::start(0, &tone(0.1, 1e-5), &tracking);
            for _ in 0..400 {
                track.predict(1, false, &tracking);
                track.update(&tone(0.1, 1e-5), &tracking);
            }
            let ratio = f64::from(track.covariance()[0]) / 1e-10;
            assert!((ratio / variance - 1.0).abs() < 0.01, "{agility}: {ratio}");
            // The move of the answer for a step of one sigma.
            track.predict(1, false, &tracking);
            let before = track.tone.frequency.cycles();
            track.update(&tone(0.1 + 1e-5, 1e-5), &tracking);
            let moved = (track.tone.frequency.cycles() - before) / 1e-5;
            assert!((moved / alpha - 1.0).abs() < 0.02, "{agility}: {moved}");
            assert!((f64::from(gain(agility)) / alpha - 1.0).abs() < 0.02, "{agility}");
        }
    }

    #[test]
    fn a_steady_rate_is_followed_without_lag() {
        let mut track = Track::start(0, &tone(0.1, 1e-6), &TRACKING);
        let mut cycles = 0.1;
        for _ in 0..100 {
            cycles += 1e-4;
            track.predict(1, false, &TRACKING);
            track.update(&tone(cycles, 1e-6), &TRACKING);
        }
        assert!((track.tone.frequency.cycles() - cycles).abs() < 1e-8);
        assert!((track.rate() - 1e-4).abs() < 1e-8);
        assert_eq!(track.state, State::Held);
    }

    #[test]
    fn a_tone_of_unknown_place_is_in_no_gate() {
        let mut track = Track::start(0, &tone(0.1, 1e-6), &TRACKING);
        track.predict(1, false, &TRACKING);
        assert!(track.distance(&tone(0.1, 1e-6), &TRACKING).is_some());
        for sigma in [1.0, 1e30, f32::INFINITY, f32::NAN] {
            assert_eq!(track.distance(&tone(0.1, sigma), &TRACKING), None, "{sigma}");
        }
    }

    #[test]
    fn negative_frequencies_meet_on_the_circle() {
        let mut track = Track::start(0, &tone(-0.4999, 1e-5), &TRACKING);
        track.predict(1, false, &TRACKING);
        assert!((track.innovation(&tone(0.4999, 1e-5)) + 2e-4).abs() < 1e-7);
        track.update(&tone(0.4999, 1e-5), &TRACKING);
        assert!(track.tone.frequency.cycles().abs() > 0.4998);
    }

    #[test]
    fn two_of_three_make_a_track_and_five_misses_end_it() {
        let mut track = Track::start(7, &tone(0.2, 1e-5), &TRACKING);
        let mut other = track;
        track.predict(1, false, &TRACKING);
        track.miss();
        track.predict(1, false, &TRACKING);
        track.update(&tone(0.2, 1e-5), &TRACKING);
        assert_eq!((track.state, track.number), (State::Held, 7));
        for misses in 1..=MISSES {
            track.predict(1, false, &TRACKING);
            track.miss();
            let expected = if misses < MISSES { State::Held } else { State::Lost };
            assert_eq!(track.state, expected);
            assert_ne!(track.tone.verdict, Verdict::Good);
        }
        for _ in 0..2 {
            other.predict(1, false, &TRACKING);
            other.miss();
        }
        assert_eq!(other.state, State::Lost);
    }

    #[test]
    fn a_gap_forgets_the_rate_and_not_the_place() {
        let mut track = Track::start(0, &tone(0.1, 1e-6), &TRACKING);
        for _ in 0..50 {
            track.predict(1, false, &TRACKING);
            track.update(&tone(0.1, 1e-6), &TRACKING);
        }
        let (place, gate) = (track.tone.frequency, track.gate(&TRACKING));
        track.predict(3, true, &TRACKING);
        assert_eq!(track.tone.frequency, place);
        assert!(track.gate(&TRACKING) > 100.0 * gate);
    }
}

//! A tone followed from block to block.
//!
//! A bank of Kalman filters takes each measurement with the estimator's sigma, and learns from it how the target moves, see
//! [`motion`](super::motion). The frequency is kept in steps of 2^-32 cycle per sample, as exact as measured; the rate and the covariance
//! are `f32`.

use super::motion::Motion;
use crate::math::scalar::Scalar;
use crate::tone::evidence::Evidence;
use crate::tone::frequency::Frequency;
use crate::tone::judge::LineClass;
use crate::tone::{Reasons, Tone, Usable, Verdict};

/// The parameters of the filter that follows tones, in its own units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// Sigma of the rate of a target that was seen only once, cycles per sample per block.
    pub rate: f32,
    /// Whether frequencies have a sign. Without one, a tone that moves through 0 Hz comes back as its mirror image.
    pub signed: bool,
    /// The signal-to-noise ratio per sample from which a block detects a tone by itself.
    pub evident: f32,
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

/// The evidence against a prediction: it is no measurement.
const COASTING: Evidence = Evidence::new(Reasons::NONE.with(Verdict::Coasting));

/// The weight of a block in the share of blocks that detect a tone by themselves.
const CREDIT: f32 = 1.0 / 8.0;

/// Half the gate, in standard deviations of the innovation.
pub const GATE: f32 = 4.0;

/// The widest half gate, cycles per sample. A target that was missed often could be anywhere, and
/// the search for new targets finds it.
const WIDEST: f32 = 1.0 / 64.0;

/// A tone that is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// The number of the track, counted since the start. A track keeps its number.
    pub number: u32,
    /// The state of the track.
    pub state: State,
    /// The tone as filtered, or as predicted if this block missed it: then its verdict is [`Verdict::Coasting`]. The sigma is the filter's.
    /// The verdict is `Good` only if this block's measurement was good.
    pub tone: Tone,
    /// Blocks since the first measurement.
    pub age: u32,
    /// Blocks since the last measurement.
    pub misses: u8,
    /// The share of the blocks that detected the tone by themselves.
    credit: f32,
    /// Blocks since the last measurement, with those that are missing.
    blocks: u32,
    motion: Motion,
    learnt: Learnt,
}

/// The scatter of a target, learnt from its measurements.
///
/// A measurement's sigma covers the noise within one block. A target with many reflecting parts scatters more from block to block, the more
/// the weaker it is in a block (see [`crate::carrier`]). Its second differences show it: `s = z[k] - 2 z[k-1] + z[k-2]` does not know of a
/// steady rate. Measurements of the variance `R` that scatter independently make two successive ones `-4 R` on average; a target that
/// swings or accelerates makes them positive, and one that steps does so once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Learnt {
    /// The variance of a measurement as stated by its blocks, averaged.
    variance: f32,
    /// The square of the amplitude, averaged, and the number of measurements in the average.
    power: f32,
    seen: f32,
    /// The logarithm of the factor of the measurements' variance, not below 0.
    scatter: f32,
    /// The last measurement, the difference to the one before, and the last second difference.
    last: Frequency,
    difference: f32,
    second: f32,
    /// Measurements in a row, of which the differences are: at most 3.
    row: u8,
}

impl Learnt {
    /// The speed of learning, and the level that noise alone must not exceed, so that a steady
    /// target does not seem to scatter by chance.
    const SPEED: f32 = 0.03;
    const SCATTER: f32 = 1.3;
    /// The limit of one block, the limit of the sum of all, and the least sum that has an effect. A track with nothing to learn
    /// exceeds the least sum one time in ten.
    const MOST: f32 = 4.0;
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
        let last = tone.frequency;
        Self { variance: square(tone.sigma), power, seen: 1.0, last, row: 1, ..Self::default() }
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

    /// The sum of both parts. The learnt factor settles where the products are [`Learnt::SCATTER`] times their mean: the whole
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

    /// The square of the acceleration by the last measurements, the larger of two second differences.
    fn bend(&self, tone: &Tone) -> f32 {
        let second = tone.frequency.beyond(self.last) - self.difference;
        if self.row >= 2 { square(second).max(square(self.second)) } else { 0.0 }
    }

    /// Takes a measurement of this variance; `blocks` have passed since the last one.
    #[allow(clippy::manual_clamp)] // `clamp` checks its bounds
    fn learn(&mut self, tone: &Tone, variance: f32, blocks: u32) {
        self.variance = self.average(square(tone.sigma));
        self.seen = (self.seen + 1.0).min(Self::POWERS);
        self.power += (square(tone.amplitude) - self.power) / self.seen;
        if blocks != 1 {
            self.row = 0;
        }
        let difference = tone.frequency.beyond(self.last);
        let second = difference - self.difference;
        if self.row >= 3 {
            let product = -0.25 * second * self.second / variance;
            let product = product.max(-Self::MOST).min(Self::MOST);
            let grown = self.scatter + Self::SPEED * (product - Self::SCATTER);
            self.scatter = grown.max(0.0).min(Self::HIGHEST);
        }
        (self.last, self.difference, self.second) = (tone.frequency, difference, second);
        self.row = (self.row + 1).min(3);
    }
}

impl Track {
    /// A track that starts with a measurement.
    pub fn start(number: u32, tone: &Tone, tracking: &Tracking) -> Self {
        let motion = Motion::start(square(tone.sigma), square(tracking.rate));
        Self {
            number,
            tone: *tone,
            credit: 0.5,
            motion,
            learnt: Learnt::start(tone),
            ..Self::default()
        }
    }

    /// The rate, cycles per sample per block.
    pub fn rate(&self) -> f32 {
        self.motion.rate()
    }

    /// Variance of the frequency, covariance, variance of the rate; in cycles per sample and
    /// blocks.
    pub fn covariance(&self) -> [f32; 3] {
        self.motion.covariance()
    }

    /// Advances by `blocks` blocks. After a gap the clock may have moved, so the rate is as
    /// uncertain as at the start.
    pub fn predict(&mut self, blocks: u32, gap: bool, tracking: &Tracking) {
        if gap {
            self.motion.forget(square(tracking.rate));
        }
        let variance = Learnt::whole(self.usual(tracking));
        let moved = self.motion.predict(blocks as f32, variance);
        self.blocks = self.blocks.saturating_add(blocks);
        self.shift(moved);
        let Frequency(turns) = self.tone.frequency;
        if !tracking.signed && turns < 0 {
            self.tone.frequency = Frequency(turns.wrapping_neg());
            self.motion.turn();
            self.learnt.row = 0;
        }
        self.age = self.age.saturating_add(blocks);
    }

    /// Half the gate for a measurement like the last ones, cycles per sample.
    pub fn gate(&self, tracking: &Tracking) -> f32 {
        let [place, _, _] = self.motion.covariance();
        let variance = Learnt::whole(self.usual(tracking));
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
        let [place, _, _] = self.motion.covariance();
        let gate = GATE * (place + Learnt::whole(self.variance(tone, tracking))).root();
        let gate = gate.min(WIDEST).max(tracking.apart);
        let distance = self.innovation(tone).abs() / gate;
        (distance <= 1.0 && tells(tone)).then_some(distance)
    }

    /// The variance of a measurement like the last ones.
    fn usual(&self, tracking: &Tracking) -> [f32; 2] {
        self.learnt.variance(self.learnt.variance, 1.0, tracking)
    }

    /// The variance of what a block's sigma does not cover. A rough value is right within a bin. A frequency that changes is answered as the
    /// mean over the block; least squares weighs the block's middle most, by `6 u (1 - u)`. So a rate that changes by `a` over the block
    /// moves it by `a / 2 (1/12 - 1/20) = a / 60` from the plain mean.
    fn unknown(&self, tone: &Tone, tracking: &Tracking) -> f32 {
        let rough = tone.verdict.usable() > Usable::WithinSigma;
        let moving = tone.reasons().any(|reason| reason == Verdict::Moving);
        let bend = if moving { self.learnt.bend(tone) * (1.0 / 3600.0) } else { 0.0 };
        if rough { bend + square(0.5 * tracking.apart) } else { bend }
    }

    /// The variance of this measurement, by [`Learnt::variance`].
    fn variance(&self, tone: &Tone, tracking: &Tracking) -> [f32; 2] {
        self.learnt.variance(square(tone.sigma), self.learnt.faded(tone), tracking)
    }

    /// Updates the track with this block's measurement. `alone` says that the block detected the tone without the track.
    ///
    /// A tone that only its track makes credible is `Weak` until at least half of the last blocks have detected it by themselves: a track
    /// is not surer than its blocks.
    pub fn update(&mut self, tone: &Tone, alone: bool, tracking: &Tracking) {
        let innovation = self.innovation(tone);
        let [known, learnt] = self.variance(tone, tracking);
        let variance = Learnt::whole([known, learnt]) + self.unknown(tone, tracking);
        self.learnt.learn(tone, known + learnt, self.blocks);
        self.blocks = 0;
        let moved = self.motion.update(innovation, variance);
        self.tone = Tone { frequency: self.tone.frequency, ..*tone };
        self.shift(moved);
        self.credit += CREDIT * (f32::from(u8::from(alone)) - self.credit);
        let detected = alone || self.credit > 0.5;
        self.tone.conclude(&Evidence { detected, ..Evidence::new(tone.said()) });
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
        self.tone.conclude(&Evidence { detected: false, ..COASTING });
    }

    /// Notes that this block has no measurement, but a tone that lies `innovation` from the prediction. If the two are near, it may be the
    /// target after a step: sigma covers it.
    pub fn reject(&mut self, innovation: f32) {
        self.miss();
        if innovation.abs() < WIDEST {
            self.tone.sigma = (square(self.tone.sigma) + square(innovation)).root();
        }
    }

    /// Notes that another tone is too near to separate the two. This is neither a hit nor a miss.
    pub fn coast(&mut self) {
        self.tone.conclude(&Evidence { line: LineClass::Unresolved, ..COASTING });
    }

    fn shift(&mut self, cycles: f32) {
        self.tone.frequency = self.tone.frequency.moved(cycles);
        let [variance, _, _] = self.motion.covariance();
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

    const TRACKING: Tracking = Tracking {
        rate: 2e-3,
        signed: true,
        evident: 0.0,
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

    #[test]
    fn a_steady_rate_is_followed_without_lag() {
        let mut track = Track::start(0, &tone(0.1, 1e-6), &TRACKING);
        let mut cycles = 0.1;
        for _ in 0..100 {
            cycles += 1e-4;
            track.predict(1, false, &TRACKING);
            track.update(&tone(cycles, 1e-6), true, &TRACKING);
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
        track.update(&tone(0.4999, 1e-5), true, &TRACKING);
        assert!(track.tone.frequency.cycles().abs() > 0.4998);
    }

    #[test]
    fn two_of_three_make_a_track_and_five_misses_end_it() {
        let mut track = Track::start(7, &tone(0.2, 1e-5), &TRACKING);
        let mut other = track;
        track.predict(1, false, &TRACKING);
        track.miss();
        track.predict(1, false, &TRACKING);
        track.update(&tone(0.2, 1e-5), true, &TRACKING);
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
            track.update(&tone(0.1, 1e-6), true, &TRACKING);
        }
        let (place, gate) = (track.tone.frequency, track.gate(&TRACKING));
        track.predict(3, true, &TRACKING);
        assert_eq!(track.tone.frequency, place);
        assert!(track.gate(&TRACKING) > 100.0 * gate);
    }
}

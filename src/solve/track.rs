//! A tone followed from block to block.
//!
//! A bank of Kalman filters takes each measurement with the estimator's sigma, and learns from it how the target moves, see
//! `solve::motion`. The frequency is kept in steps of 2^-32 cycle per sample, as exact as measured; the rate and the covariance
//! are `f32`.

use super::motion::{CALM_GAINS, Motion};
use crate::frequency::Frequency;
use crate::math::scalar::Scalar;
use crate::tone::evidence::Evidence;
use crate::tone::line_class::LineClass;
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

/// The widest half gate in which a track looks for what the block alone did not detect, cycles per sample, or two bins. In a wider one it
/// would find another target, and go on as that.
const NEAR: f32 = 1.0 / 256.0;

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
/// the weaker it is in a block (see [`crate::carrier`]); a target that steps is somewhere else from one block to the next. Both leave a
/// prediction far off. The better of two predictions distinguishes them: a line through the last measurements ([`Predictor`]), or the last
/// measurement alone, moved by the line's rate. If the line is nearly as good, the target scatters, by the mean square of the line's errors.
///
/// | target | mean square of the calm line's error | of the last measurement's | of the quick line's | of the last one's |
/// |---|---|---|---|---|
/// | scatters with the variance 1 | 1 | 1 | 1 | 1 |
/// | steps with the variance 1 in each block, or once: the sum over all blocks | 1.6 | 0.5 | 0.8 | 0.5 |
/// | swings in six blocks with the mean square 1 | 1.0 | 0.5 | 1.1 | 0.5 |
/// | swings in four blocks | 1.0 | 1.0 | 1.1 | 1.0 |
///
/// Each is over the variance of that prediction's error where a target scatters. The calm line decides best, but lags behind a target that
/// accelerates while it scatters; the quick line follows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Learnt {
    /// The variance of a measurement as stated by its blocks, averaged.
    variance: f32,
    /// The square of the amplitude, averaged, and the number of measurements in the averages.
    power: f32,
    seen: f32,
    /// The variance by which measurements scatter beyond what is known, over `variance`.
    scatter: f32,
    /// The last measurement, the difference to the one before, and the last second difference.
    last: Frequency,
    difference: f32,
    second: f32,
    /// The calm line and the quick one.
    lines: [Predictor; 2],
    /// Measurements in a row, of which the differences and the lines are: at most [`Learnt::LONG`].
    row: u8,
}

impl Learnt {
    /// The least mean square that shows a scatter: one steady target in ten exceeds it by chance.
    const EVIDENT: f32 = 1.3;
    /// The share of a block in the average of variances, and the factor by which one block may be
    /// better than the average.
    const RENEWAL: f32 = 1.0 / 8.0;
    const BETTER: f32 = 4.0;
    /// The measurements that the other averages have, and the deepest fade that counts.
    const MEASUREMENTS: f32 = 32.0;
    const DEEPEST: f32 = 1e4;
    /// The measurements after which the gains of both lines stay as they are.
    const LONG: u8 = 13;

    fn start(tone: &Tone) -> Self {
        let power = square(tone.amplitude);
        let (variance, last) = (square(tone.sigma), tone.frequency);
        let lines = [Predictor { error: 1.0, alone: 1.0, ..Predictor::default() }; 2];
        Self { variance, power, seen: 1.0, last, lines, row: 1, ..Self::default() }
    }

    /// The factor by which a tone is weaker than the average, in power.
    fn faded(&self, tone: &Tone) -> f32 {
        let faded = self.power / square(tone.amplitude);
        // A tone without an amplitude gives NaN here.
        if faded < Self::DEEPEST { faded } else { Self::DEEPEST }
    }

    /// The known variance of a measurement whose block states `block`, of a tone that is weaker by `faded` than the average, and the variance
    /// of which its scatter is a multiple.
    fn parts(&self, block: f32, faded: f32, tracking: &Tracking) -> [f32; 2] {
        let average = self.average(block);
        let stated = average.max(block / Self::BETTER);
        // A fade raises what is learnt to no more than a bin's worth: beyond it, any peak would be the target's.
        let bin = square(0.5 * tracking.apart) / self.scatter.max(f32::MIN_POSITIVE);
        let unit = average.max(bin).min(average * faded.max(1.0));
        [stated + (tracking.envelope * faded - tracking.stated), unit]
    }

    /// The variance of a measurement of these parts.
    fn whole(&self, [known, unit]: [f32; 2]) -> f32 {
        known + unit * self.scatter
    }

    /// The standard deviation by which measurements scatter beyond what their blocks state.
    fn excess(&self) -> f32 {
        (self.variance * self.scatter).root()
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

    /// Takes a measurement whose variance has these parts; `blocks` have passed since the last one.
    fn learn(&mut self, tone: &Tone, parts: [f32; 2], blocks: u32) {
        let variance = self.whole(parts) / (1.0 + self.scatter);
        self.variance = self.average(square(tone.sigma));
        self.seen = (self.seen + 1.0).min(Self::MEASUREMENTS);
        self.power += (square(tone.amplitude) - self.power) / self.seen;
        if blocks != 1 {
            self.row = 0;
        }
        let difference = tone.frequency.beyond(self.last);
        let share = 1.0 / (self.seen - 1.0);
        for (line, kind) in self.lines.iter_mut().zip(&LINES) {
            line.take(difference, self.row, variance, share, kind);
        }
        (self.second, self.difference) = (difference - self.difference, difference);
        self.last = tone.frequency;
        self.row = (self.row + 1).min(Self::LONG);
        let scatters = |(line, kind): (&Predictor, &Kind)| {
            let ratio = if self.scatter > 0.0 { kind.lasts } else { kind.begins };
            let beyond = line.error - 1.0;
            (line.error > Self::EVIDENT && beyond < ratio * (line.alone - 1.0)).then_some(beyond)
        };
        self.scatter = self.lines.iter().zip(&LINES).find_map(scatters).unwrap_or(0.0);
    }
}

/// A line through the last measurements, and how well it predicts them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Predictor {
    /// The place beyond the last measurement, and the rate.
    place: f32,
    rate: f32,
    /// The squares of the errors of the line and of the last measurement alone, averaged, over those of a target that does not scatter.
    error: f32,
    alone: f32,
}

/// How a line is drawn, and what it decides.
struct Kind {
    /// The least gains of its place and rate, and the least variance of a measurement beyond the last one moved by its rate.
    place: f32,
    rate: f32,
    alone: f32,
    /// The errors of the line over those of the last measurement, below which a scatter begins, and to which it lasts.
    begins: f32,
    lasts: f32,
}

/// The gains are those to which filters with a Lambda of 0.05 and 0.18 settle.
const LINES: [Kind; 2] = [
    Kind { place: CALM_GAINS[0], rate: CALM_GAINS[1], alone: 2.09, begins: 1.3, lasts: 1.7 },
    Kind { place: 0.45, rate: 0.133, alone: 2.29, begins: 1.15, lasts: 1.45 },
];

impl Predictor {
    /// The limit of one square, over the mean square, and the limit of the mean.
    const MOST: f32 = 30.0;
    const HIGHEST: f32 = 1e8;

    /// Takes a measurement of this variance, `difference` beyond the last one. It is `share` of the averages.
    fn take(&mut self, difference: f32, row: u8, variance: f32, share: f32, kind: &Kind) {
        if row < 2 {
            (self.place, self.rate) = (0.0, if row == 0 { 0.0 } else { difference });
            return;
        }
        // The gains of least squares, as long as they are larger.
        let n = f32::from(row);
        let product = (n + 1.0) * (n + 2.0);
        let gain = (2.0 * (2.0 * n + 1.0) / product).max(kind.place);
        let moved = difference - self.rate;
        let error = moved - self.place;
        self.place = (gain - 1.0) * error;
        self.rate += (6.0 / product).max(kind.rate) * error;
        // A variance of nothing makes these infinite or NaN, and `min` a number of both.
        let error = (square(error) * (1.0 - gain) / variance).min(Self::HIGHEST);
        let alone = (2.0 + 12.0 / (n * n - 1.0)).max(kind.alone) * variance;
        let alone = (square(moved) / alone).min(Self::HIGHEST);
        let most = Self::MOST * self.error.max(1.0);
        let limited = most / most.max(error).max(alone);
        self.error += share * (limited * error - self.error);
        self.alone += share * (limited * alone - self.alone);
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
        let variance = self.usual(tracking);
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

    /// Half the gate in which to look for a measurement like the last ones, cycles per sample.
    pub fn gate(&self, tracking: &Tracking) -> f32 {
        let [place, _, _] = self.motion.covariance();
        (GATE * (place + self.usual(tracking)).root()).min(NEAR.max(tracking.apart))
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
        let gate = GATE * (place + self.learnt.whole(self.parts(tone, tracking))).root();
        let gate = gate.min(WIDEST).max(tracking.apart);
        let distance = self.innovation(tone).abs() / gate;
        (distance <= 1.0 && tells(tone)).then_some(distance)
    }

    /// The variance of a measurement like the last ones.
    fn usual(&self, tracking: &Tracking) -> f32 {
        self.learnt.whole(self.learnt.parts(self.learnt.variance, 1.0, tracking))
    }

    /// The variance of what a block's sigma does not cover. A rough value is right within a bin. A frequency that changes is answered as the
    /// mean over the block; least squares weighs the block's middle most, by `6 u (1 - u)`. So a rate that changes by `a` over the block
    /// moves it by `a / 2 (1/12 - 1/20) = a / 60` from the plain mean.
    fn unknown(&self, tone: &Tone, tracking: &Tracking) -> f32 {
        let rough = tone.verdict.usable() > Usable::WithinSigma;
        let bend = if moves(tone) { self.learnt.bend(tone) * (1.0 / 3600.0) } else { 0.0 };
        if rough { bend + square(0.5 * tracking.apart) } else { bend }
    }

    /// The parts of this measurement's variance, by [`Learnt::parts`].
    fn parts(&self, tone: &Tone, tracking: &Tracking) -> [f32; 2] {
        self.learnt.parts(square(tone.sigma), self.learnt.faded(tone), tracking)
    }

    /// Updates the track with this block's measurement. `alone` says that the block detected the tone without the track.
    ///
    /// A tone that only its track makes credible is `Weak` until at least half of the last blocks have detected it by themselves: a track
    /// is not surer than its blocks.
    pub fn update(&mut self, tone: &Tone, alone: bool, tracking: &Tracking) {
        let innovation = self.innovation(tone);
        let (parts, unknown) = (self.parts(tone, tracking), self.unknown(tone, tracking));
        let before = self.learnt.whole(parts);
        self.learnt.learn(tone, parts, self.blocks);
        let after = self.learnt.whole(parts);
        if before > after && self.learnt.scatter == 0.0 {
            self.motion.unsettle(before - after);
        }
        // Where a target that stood begins to move within a block, the block's sigma covers more than the change, and no innovation shows it.
        if moves(tone) && !moves(&self.tone) {
            self.motion.unsettle(square(tone.sigma));
        }
        let variance = after + unknown;
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

/// Whether a tone moves within its block.
fn moves(tone: &Tone) -> bool {
    tone.reasons().any(|reason| reason == Verdict::Moving)
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

    /// A track of measurements at these places of a target that stands, in sigma of a measurement.
    fn followed(places: impl Iterator<Item = f64>) -> Track {
        let mut places = places.map(|place| tone(0.1 + 1e-6 * place, 1e-6));
        let mut track = Track::start(0, &places.next().unwrap(), &TRACKING);
        for tone in places {
            track.predict(1, false, &TRACKING);
            track.update(&tone, true, &TRACKING);
        }
        track
    }

    /// Sums of twelve numbers with the variance 1/12.
    fn noise() -> impl Iterator<Item = f64> {
        let mut state = 1u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        core::iter::repeat_with(move || (0..12).map(|_| uniform()).sum())
    }

    #[test]
    fn a_scatter_is_learnt() {
        for scatter in [10.0, 300.0] {
            let track = followed(noise().map(|z| scatter * z).take(200));
            let learnt = f64::from(track.excess()) / 1e-6;
            assert!((0.7..1.3).contains(&(learnt / scatter)), "{learnt} of {scatter}");
            let sigma = f64::from(track.tone.sigma) / 1e-6;
            assert!((0.4..0.8).contains(&(sigma / scatter)), "{sigma} of {scatter}");
        }
    }

    /// Noise alone, a target that steps once, in each block, and one that swings in six blocks.
    #[test]
    fn a_motion_is_no_scatter() {
        let excess = followed(noise().take(200)).excess();
        assert!(excess < 0.7e-6, "{excess}");
        let step = |(k, z): (usize, f64)| z + if k < 150 { 0.0 } else { 300.0 };
        let mut place = 0.0;
        let walk = |z: f64| {
            place += 100.0 * z;
            place
        };
        let swing =
            |(k, z): (usize, f64)| z + 100.0 * (k as f64 * core::f64::consts::FRAC_PI_3).sin();
        for (name, track) in [
            ("step", followed(noise().enumerate().map(step).take(160))),
            ("walk", followed(noise().map(walk).take(200))),
            ("swing", followed(noise().enumerate().map(swing).take(200))),
        ] {
            assert!(track.excess() < 1e-6, "{name}: {}", track.excess());
            assert!(track.tone.sigma < 1.2e-6, "{name}: {}", track.tone.sigma);
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

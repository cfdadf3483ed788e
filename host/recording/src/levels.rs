//! The levels of samples: where they lie, how fine their steps are, whether they are clipped.

use super::Sample;
use std::collections::HashMap;
use std::f64::consts::FRAC_2_PI;

/// What clips spends this share of the samples at either end, and twice what a sine does that does not.
const CLIPPED: f64 = 0.002;
/// The most different values that are counted: the codes of 16 bits. With more, steps do not matter.
const DISTINCT: usize = 1 << 16;
/// Samples whose values are counted.
const COUNTED: u64 = 1 << 20;
/// A value lies on a step if it is off by less than this share of one: what is printed with few digits is rounded.
const OFF_STEP: f64 = 0.2;

/// Levels of samples, in the units of what they were taken from; I and Q together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
    /// The mean.
    pub mean: f64,
    /// The root of the mean square without the mean.
    pub rms: f64,
    /// The step between values, where all of them are multiples of one.
    pub step: Option<f64>,
    /// The share of the samples that lie at either end, where that is more than a sine spends there; else 0.
    pub clipped: f64,
    /// Whether the lowest and the highest value are where they were clipped.
    pub ends: [bool; 2],
    /// Every value is a whole number.
    pub whole: bool,
}

/// Levels of samples that come one after the other.
#[derive(Debug, Default)]
pub(super) struct Gauge {
    count: u64,
    low: f64,
    high: f64,
    first: f64,
    sum: f64,
    squares: f64,
    fraction: bool,
    times: HashMap<u64, u32>,
    many: bool,
}

impl Levels {
    /// The levels of samples; missing ones (NaN) do not count. `None` where there are none.
    pub fn from_samples(samples: &[Sample], iq: bool) -> Option<Self> {
        let mut gauge = Gauge::default();
        samples.iter().for_each(|sample| gauge.add(*sample, iq));
        gauge.levels()
    }
}

impl Gauge {
    pub fn add(&mut self, sample: Sample, iq: bool) {
        self.value(sample.value.re);
        if iq {
            self.value(sample.value.im);
        }
    }

    fn value(&mut self, x: f64) {
        if x.is_nan() {
            return;
        }
        if self.count == 0 {
            (self.low, self.high, self.first) = (x, x, x);
        }
        self.low = self.low.min(x);
        self.high = self.high.max(x);
        self.sum += x - self.first;
        self.squares += (x - self.first) * (x - self.first);
        self.fraction |= x.fract() != 0.0;
        if self.count < COUNTED && !self.many {
            // Zero has two signs.
            *self.times.entry((x + 0.0).to_bits()).or_default() += 1;
            self.many = self.times.len() > DISTINCT;
        }
        self.count += 1;
    }

    pub fn levels(&self) -> Option<Levels> {
        let &Self { count, low, high, first, sum, squares, fraction, .. } = self;
        if count == 0 {
            return None;
        }
        let (mean, square) = (sum / count as f64, squares / count as f64);
        let rms = (square - mean * mean).max(0.0).sqrt();
        let step = self.step();
        let (clipped, ends) = self.clipped(step);
        Some(Levels { low, high, mean: first + mean, rms, step, clipped, ends, whole: !fraction })
    }

    /// The largest step that divides all values, if there is one: the least distance between two of them, or the greatest divisor
    /// of whole numbers.
    fn step(&self) -> Option<f64> {
        let mut values: Vec<f64> = self.times.keys().map(|&bits| f64::from_bits(bits)).collect();
        values.sort_by(f64::total_cmp);
        let (&low, &high) = (values.first()?, values.last()?);
        let span = high - low;
        if self.many || span <= 0.0 || !span.is_finite() {
            // What has more values than 16 bits has steps if it is whole.
            return (self.many && !self.fraction).then_some(1.0);
        }
        if !self.fraction {
            let offsets = values.iter().map(|value| (value - low).min(1e15) as u64);
            return Some(offsets.fold(0, divisor).max(1) as f64);
        }
        let least = values.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let steps = (span / least).round();
        let step = span / steps;
        let off = |value: &f64| {
            let steps = (value - low) / step;
            (steps - steps.round()).abs()
        };
        // Where so few of the steps are taken, it is chance that values lie on them.
        let taken = values.len() as f64 > 4.0 && steps < DISTINCT as f64;
        (taken && values.iter().map(off).fold(0.0, f64::max) < OFF_STEP).then_some(step)
    }

    /// The share of the values at either end, and which of the ends are clipped.
    fn clipped(&self, step: Option<f64>) -> (f64, [bool; 2]) {
        let counted = self.count.min(COUNTED) as f64;
        // In cells of a code each: floats that were computed differ in their last digits.
        let cell = (self.high - self.low) / DISTINCT as f64;
        let mut cells = HashMap::<u32, f64>::new();
        for (&bits, &times) in &self.times {
            let place = (f64::from_bits(bits) - self.low) / cell;
            *cells.entry(place as u32).or_default() += f64::from(times);
        }
        // The highest value is the end of the last cell.
        let highest = cells.remove(&(DISTINCT as u32)).unwrap_or(0.0);
        *cells.entry(DISTINCT as u32 - 1).or_default() += highest;
        let places = [0, DISTINCT as u32 - 1];
        let between = cells.iter().filter(|(place, _)| !places.contains(place));
        let between = between.map(|(_, &times)| times).fold(0.0, f64::max);
        // A whole sine of so many steps spends this share of its time in the outermost two. In step with the clock it comes there
        // more often, but then to other values as well.
        let amplitude = (self.high - self.low) / 2.0;
        let sine = (1.0 - step.unwrap_or(0.0).max(cell) / amplitude).max(-1.0).acos() * FRAC_2_PI;
        let [low, high] = places.map(|place| cells.get(&place).copied().unwrap_or(0.0));
        let share = (low + high) / counted;
        let often = |times: f64| times > 4.0 * between;
        if amplitude > 0.0 && (often(low) || often(high)) && share > CLIPPED + 2.0 * sine {
            (share, [often(low), often(high)])
        } else {
            (0.0, [false; 2])
        }
    }
}

fn divisor(a: u64, b: u64) -> u64 {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(cycles: f64, amplitude: f64, rails: (f64, f64)) -> Vec<Sample> {
        let part = |n: u32| amplitude * (TAU * cycles * f64::from(n)).sin();
        let code = |n: u32| part(n).round().clamp(rails.0, rails.1);
        (0..20_000).map(|n| Sample::of(code(n), None)).collect()
    }

    fn levels(samples: &[Sample]) -> Levels {
        Levels::from_samples(samples, false).unwrap()
    }

    /// Slow and fast, of few codes and of many.
    #[test]
    fn what_clips_is_told_from_what_is_whole() {
        for cycles in [0.0005, 0.01, 0.025_720_2, 0.1, 0.234_567, 0.412_345] {
            for amplitude in [5.0, 100.0, 9000.0, 30_000.0] {
                let whole = levels(&sine(cycles, amplitude, (-32_767.0, 32_767.0))).clipped;
                assert_eq!(whole, 0.0, "{cycles} cycles a sample, {amplitude} codes");
            }
        }
        // What is in step with the clock has few values, clipped or whole.
        for cycles in [0.000_513, 0.010_037, 0.025_720_2, 0.100_073, 0.234_567, 0.412_345] {
            for amplitude in [110.0, 9000.0] {
                let rail = 0.8 * amplitude;
                let both = levels(&sine(cycles, amplitude, (-rail, rail)));
                assert!(
                    both.clipped > 0.2,
                    "{cycles} cycles a sample, {amplitude} codes: {both:?}"
                );
                assert_eq!(both.ends, [true; 2]);
                let one = levels(&sine(cycles, amplitude, (-rail, 2.0 * amplitude)));
                assert!(one.clipped > 0.1 && one.ends == [true, false], "{one:?}");
            }
        }
    }

    /// A tone of ten samples, computed in floats: its values come again and again, except for their last digits.
    #[test]
    fn floats_in_step_with_the_clock_are_not_clipped() {
        let part = |n: u32| Sample::of(5e3 * (0.1 * TAU * f64::from(n)).cos(), None);
        let levels = levels(&(0..2048).map(part).collect::<Vec<_>>());
        assert_eq!((levels.clipped, levels.ends), (0.0, [false; 2]));
    }

    #[test]
    fn steps_of_a_scope_that_prints_few_digits() {
        // 8 bits over 10.24 V, printed to a hundredth of a volt.
        let volts = |n: u32| {
            let code = (100.0 * (0.37 * f64::from(n)).sin()).round();
            Sample::of((code * 0.04 * 1e2).round() / 1e2, None)
        };
        let step = levels(&(0..5000).map(volts).collect::<Vec<_>>()).step.unwrap();
        assert!((step - 0.04).abs() < 1e-4, "{step}");
        let fine = |n: u32| Sample::of((0.37 * f64::from(n)).sin(), None);
        assert_eq!(levels(&(0..5000).map(fine).collect::<Vec<_>>()).step, None);
        assert_eq!(Levels::from_samples(&[Sample::of(f64::NAN, None)], false), None);
    }
}

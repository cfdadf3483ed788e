//! A sample clock against another clock, by the arrivals of blocks.
//!
//! Blocks arrive late, never early: a bus, an operating system or a busy loop delays them. The earliest arrivals lie near a straight line,
//! whose slope is the ratio of the clocks. [`RateCheck`] keeps the earliest arrival of each of up to [`WINDOWS`] windows, which grow as time
//! goes on, and draws the line through them. Windows in which all blocks were late lie above it and are left out. The scatter of the others
//! gives sigma.

use crate::math::scalar::Scalar as _;

/// The most windows; a number that can be halved.
pub const WINDOWS: usize = 32;

/// The fewest windows that give a line.
const FEWEST: usize = 4;

/// A window is left out if it is later than the line by this many times the median distance: the earliest arrivals scatter with an exponential
/// tail, which this leaves nearly whole.
const LATE: f32 = 10.0;

/// The earliest arrival of a window.
#[derive(Clone, Copy, Debug, Default)]
struct Earliest {
    /// Seconds of the other clock since the first block.
    time_s: f32,
    /// Ticks of the other clock by which it was later than the stated rate has it.
    late: i64,
}

/// The error of a sample clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClockError {
    /// The true sample rate over the stated one less 1, parts per million.
    pub ppm: f32,
    /// One standard deviation, parts per million.
    pub sigma_ppm: f32,
    /// Seconds from the first block to the last.
    pub seconds: f32,
}

impl ClockError {
    /// Whether the rate is off by more than this tolerance, beyond five standard deviations.
    pub fn is_beyond(&self, tolerance_ppm: f32) -> bool {
        self.ppm.abs() - 5.0 * self.sigma_ppm > tolerance_ppm
    }
}

/// Compares a sample clock with another clock, such as a host's or a timer's.
///
/// ```
/// use picket_dsp::acquire::rate_check::RateCheck;
///
/// // Blocks of 1024 samples at a stated 1 MS/s, whose converter makes 0.8: a timer of 1 MHz measures their arrivals.
/// let mut check = RateCheck::new(1e6, 1e6).unwrap();
/// for block in 1..4000u64 {
///     check.push(1024 * block, 1280 * block + 100 + (block * 7919) % 1000);
/// }
/// let error = check.error().unwrap();
/// assert!(error.is_beyond(100.0) && (error.ppm + 2e5).abs() < 50.0, "{error:?}");
/// ```
#[derive(Clone, Debug)]
pub struct RateCheck {
    /// Ticks for a sample, in steps of 2^-32, and seconds for a tick.
    ticks: u64,
    tick_s: f32,
    first: Option<[u64; 2]>,
    last_s: f32,
    /// A window, s.
    window_s: f32,
    windows: [Option<Earliest>; WINDOWS],
}

impl RateCheck {
    /// For a stated sample rate and the other clock's rate, Hz. `None` if a rate is not positive, or a sample has less than 2^-20 or more than
    /// 2^31 ticks.
    pub fn new(rate_hz: f64, ticks_hz: f64) -> Option<Self> {
        let ticks = ticks_hz / rate_hz;
        let usable = rate_hz > 0.0 && ticks_hz >= 1e-3 && ticks_hz.is_finite();
        if !usable || !(1.0 / 1_048_576.0..2_147_483_648.0).contains(&ticks) {
            return None;
        }
        Some(Self {
            ticks: (ticks * 4_294_967_296.0) as u64,
            tick_s: (1.0 / ticks_hz) as f32,
            first: None,
            last_s: 0.0,
            // Windows of a block or more: they grow at once.
            window_s: 1e-3,
            windows: [None; WINDOWS],
        })
    }

    /// Takes a block's end: the samples since any start, and the other clock's ticks at its arrival. Samples that were lost count. Both counts
    /// go up; a block before the first one is passed over. Cost: some twenty operations.
    pub fn push(&mut self, samples: u64, ticks: u64) {
        let [first_samples, first_ticks] = *self.first.get_or_insert([samples, ticks]);
        let (Some(samples), Some(ticks)) =
            (samples.checked_sub(first_samples), ticks.checked_sub(first_ticks))
        else {
            return;
        };
        let due = (u128::from(samples) * u128::from(self.ticks)) >> 32;
        let late = (ticks as i64).wrapping_sub(due as i64);
        let time_s = ticks as f32 * self.tick_s;
        self.last_s = self.last_s.max(time_s);
        while time_s >= self.window_s * WINDOWS as f32 {
            self.merge();
        }
        let here = Earliest { time_s, late };
        if let Some(window) = self.windows.get_mut((time_s / self.window_s) as usize)
            && window.is_none_or(|earliest| late < earliest.late)
        {
            *window = Some(here);
        }
    }

    /// Windows of twice the length.
    fn merge(&mut self) {
        let mut merged = [None; WINDOWS];
        for (place, pair) in merged.iter_mut().zip(self.windows.as_chunks::<2>().0) {
            *place = match *pair {
                [Some(a), Some(b)] => Some(if b.late < a.late { b } else { a }),
                [a, b] => a.or(b),
            };
        }
        self.windows = merged;
        self.window_s *= 2.0;
    }

    /// The clock's error so far; `None` before there are four windows.
    pub fn error(&self) -> Option<ClockError> {
        let mut kept: heapless::Vec<[f32; 2], WINDOWS> = heapless::Vec::new();
        let origin = self.windows.iter().flatten().next()?.late;
        for window in self.windows.iter().flatten() {
            // There is room.
            let _ = kept.push([window.time_s, (window.late - origin) as f32 * self.tick_s]);
        }
        let mut line = Trend::through(&kept)?;
        // Twice: late windows lift the first line.
        for _ in 0..4 {
            let limit = LATE * line.median(&kept);
            let before = kept.len();
            let on_line = |point: &[f32; 2]| line.off(point) <= limit;
            if kept.iter().filter(|point| on_line(point)).count() < FEWEST {
                break;
            }
            kept.retain(on_line);
            line = Trend::through(&kept)?;
            if kept.len() == before {
                break;
            }
        }
        // Each second of the other clock the samples fall behind by the slope.
        Some(ClockError {
            ppm: -1e6 * line.slope,
            sigma_ppm: 1e6 * line.sigma,
            seconds: self.last_s,
        })
    }
}

/// A straight line through points.
struct Trend {
    middle: [f32; 2],
    slope: f32,
    sigma: f32,
}

impl Trend {
    fn through(points: &[[f32; 2]]) -> Option<Self> {
        let count = points.len() as f32;
        if points.len() < FEWEST {
            return None;
        }
        let mean = |of: usize| points.iter().filter_map(|point| point.get(of)).sum::<f32>() / count;
        let middle = [mean(0), mean(1)];
        let [mut spread, mut moment] = [0.0; 2];
        for [t, y] in points {
            spread += (t - middle[0]) * (t - middle[0]);
            moment += (t - middle[0]) * (y - middle[1]);
        }
        let slope = moment / spread.max(f32::MIN_POSITIVE);
        let line = Self { middle, slope, sigma: 0.0 };
        let rest: f32 = points.iter().map(|point| line.off(point) * line.off(point)).sum();
        Some(Self { sigma: (rest / (count - 2.0) / spread.max(f32::MIN_POSITIVE)).root(), ..line })
    }

    /// The median distance of points from the line.
    fn median(&self, points: &[[f32; 2]]) -> f32 {
        let half = points.len() / 2;
        let off = |point: &[f32; 2]| self.off(point).abs();
        let below = |limit: f32| points.iter().filter(|point| off(point) < limit).count();
        let nearer = points.iter().map(off).filter(|&distance| below(distance) <= half);
        nearer.fold(0.0, f32::max)
    }

    fn off(&self, [t, y]: &[f32; 2]) -> f32 {
        y - self.middle[1] - self.slope * (t - self.middle[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    /// Ten minutes of blocks with a millisecond of jitter, and bursts in which all are late by up to 50 ms: a clock's error within a part
    /// per million, and as sigma says.
    #[test]
    fn ten_minutes_tell_a_part_per_million() {
        println!("seeds: 1 to 200");
        let (mut sum, mut worst) = (0.0, 0.0f64);
        for seed in 1..=200u64 {
            let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let mut share = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1u64 << 53) as f64
            };
            let ppm = 100.0 * (share() - 0.5);
            let mut check = RateCheck::new(48_000.0, 1e6).unwrap();
            let mut burst = 0.0;
            for block in 0..28_125u64 {
                let samples = 1024 * block;
                let true_s = samples as f64 / (48_000.0 * (1.0 + 1e-6 * ppm));
                // Exponential jitter with a mean of a millisecond; a burst every ten seconds or so.
                if share() < 0.002 {
                    burst = 50e-3 * share();
                }
                burst *= 0.98;
                let late = -1e-3 * libm::log(1.0 - share()) + burst;
                check.push(samples, ((true_s + late) * 1e6) as u64 + 5_000);
            }
            let error = check.error().unwrap();
            assert!(error.seconds > 599.0 && error.sigma_ppm < 1.0, "{error:?}");
            let off = f64::from(error.ppm) - ppm;
            worst = worst.max(off.abs());
            sum += (off / f64::from(error.sigma_ppm)).powi(2);
        }
        let mean = sum / 200.0;
        println!("mean of (error / sigma)^2 {mean:.3}, worst {worst:.3} ppm");
        assert!((0.7..1.4).contains(&mean) && worst < 1.0, "{mean} {worst}");
    }

    /// Five seconds are enough for a converter that makes 80 % of what was asked.
    #[test]
    fn a_slow_converter_is_told_in_five_seconds() {
        let mut check = RateCheck::new(100_000.0, 1e6).unwrap();
        assert_eq!(check.error(), None);
        for block in 0..=390u64 {
            check.push(1024 * block, 12_800 * block + (block * 7919) % 1000);
        }
        let error = check.error().unwrap();
        assert!(error.is_beyond(1000.0) && (error.ppm + 2e5).abs() < 300.0, "{error:?}");
        assert!(error.seconds < 5.0);
    }
}

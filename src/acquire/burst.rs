//! Bursts in a stream: cuts a record around each interval in which the signal rises above its noise.
//!
//! The detector sums the energy of cells of N/64 samples, the offset subtracted, and compares the energy of the last eight cells with the
//! noise. The noise is a quantile of these energies, followed in steps, so that bursts hardly raise it as long as they take less than half
//! of the time. All arithmetic is in integers.

use super::codes::Codes;
use super::sample::Record;
use crate::chance::ratio;
use crate::math::scalar::Scalar as _;

/// Cells in a record.
const CELLS: usize = 64;
/// Cells whose energy is compared with the noise.
const WINDOW: usize = 8;
/// Cells whose energies are kept: two records of them.
const HISTORY: usize = 2 * CELLS;

/// The detector's counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Samples taken.
    pub samples: u64,
    /// Bursts around which a record was cut.
    pub bursts: u32,
    /// Bursts that ended while the record of another was not complete, or within the hold-off.
    pub lost: u32,
    /// Signals longer than a record and a half: not a burst, or a threshold that is too low.
    pub long: u32,
    /// Samples from the end of a burst to the end of its record, and of hold-offs: the dead time.
    pub dead: u64,
}

/// The conditions under which a burst begins and ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Trigger {
    /// The energy of an eighth of a record over the quartile of the noise's energy, at which a burst begins; it ends at half of the excess.
    /// `None` is the ratio that noise exceeds in one of 3,000 cells: 1.6 for real records of 1,024 samples.
    pub ratio: Option<f32>,
    /// Samples after a record in which no burst begins.
    pub hold_off: u32,
    /// The least energy per sample of a burst, squared codes, however quiet the noise is.
    pub least: u32,
}

impl Trigger {
    /// The least ratio: a lower ratio is raised to it.
    pub const LEAST_RATIO: f32 = 1.05;
}

/// A record around a burst.
#[derive(Clone, Copy, Debug)]
pub struct Cut<'a, R: Record, const N: usize> {
    /// The number of the record's first sample, counted from the stream's first.
    pub clock: u64,
    /// The samples. The burst's middle is near the middle of them.
    pub samples: &'a [R::Sample; N],
    /// The middle of the burst's energy, samples from the first.
    pub middle: f32,
    /// The standard deviation of a Gaussian envelope with the energy's spread, samples.
    pub deviation: f32,
}

/// The sums of one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    sum: [i32; 2],
    squares: u64,
    filled: usize,
}

/// A burst in progress.
#[derive(Clone, Copy, Debug)]
struct Begun {
    /// The cell at which the burst began, counted as in `cells`.
    cell: u32,
    /// The largest energy of a window so far.
    most: u64,
    /// The cell at which the energy last rose to four times its value, and the energy there.
    rose: (u32, u64),
}

/// A burst that ended, whose record is not yet complete.
#[derive(Clone, Copy, Debug)]
struct Ended {
    /// The number of the first sample of the burst's record.
    first: u64,
    middle: f32,
    deviation: f32,
}

/// Finds bursts in a stream and cuts a record around each. Its memory is `6 N` bytes for real samples, `12 N` for I/Q, and 1.2 KB.
///
/// Cost: a copy, two additions and a product a sample, and the comparison once a cell.
#[derive(Clone)]
pub struct BurstDetector<R: Record, const N: usize> {
    codes: Codes,
    trigger: Trigger,
    /// The ratio of energy to noise, in 1/256.
    ratio: u32,
    ring: [[R::Sample; N]; 2],
    record: [R::Sample; N],
    cell: Cell,
    history: [u64; HISTORY],
    /// Cells since the start or the last gap.
    cells: u32,
    /// The offset of both parts from the middle of the codes, in 1/256 code.
    offset: [i32; 2],
    noise: u64,
    clock: u64,
    /// The clock at which the next burst may begin.
    free: u64,
    /// The burst in progress.
    began: Option<Begun>,
    /// The least energy since a burst ended whose energy has not yet sunk into the noise.
    waning: Option<u64>,
    ended: Option<Ended>,
    counters: Counters,
}

/// Without its samples and energies.
impl<R: Record, const N: usize> core::fmt::Debug for BurstDetector<R, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("BurstDetector")
            .field("codes", &self.codes)
            .field("trigger", &self.trigger)
            .field("clock", &self.clock)
            .field("counters", &self.counters)
            .finish_non_exhaustive()
    }
}

impl<R: Record, const N: usize> BurstDetector<R, N> {
    /// Samples in a cell: short records have fewer cells, because a sum of few squares says little.
    const LENGTH: usize = if N / CELLS < 4 { 4 } else { N / CELLS };

    /// A placeholder of zeros that waits for [`BurstDetector::set_plan`]: for static memory.
    pub const IDLE: Self = {
        assert!(N.is_power_of_two() && N >= 64, "N must be 64, 128, ... 4096");
        Self {
            codes: Codes::IDLE,
            trigger: Trigger { ratio: None, hold_off: 0, least: 0 },
            ratio: 0,
            ring: [[R::ZERO; N]; 2],
            record: [R::ZERO; N],
            cell: Cell { sum: [0; 2], squares: 0, filled: 0 },
            history: [0; HISTORY],
            cells: 0,
            offset: [0; 2],
            noise: 0,
            clock: 0,
            free: 0,
            began: None,
            waning: None,
            ended: None,
            counters: Counters { samples: 0, bursts: 0, lost: 0, long: 0, dead: 0 },
        }
    };

    /// A detector for a stream of these codes.
    pub fn new(codes: Codes, trigger: Trigger) -> Self {
        let mut detector = Self::IDLE;
        detector.set_plan(codes, trigger);
        detector
    }

    /// Takes samples of these codes from the next on, and another trigger. The noise estimate stays.
    pub fn set_plan(&mut self, codes: Codes, trigger: Trigger) {
        let degrees = (WINDOW * Self::LENGTH * if R::IQ { 2 } else { 1 }) as f32;
        let quantile = |deviations: f32| ratio(deviations, degrees, f32::INFINITY);
        // 3.4 deviations are exceeded in one of 3,000; .674 below the mean is the quartile.
        let usual = quantile(3.4) / quantile(-0.674);
        let least = trigger
            .ratio
            .filter(|ratio| ratio.is_finite())
            .map_or(usual, |r| r.max(Trigger::LEAST_RATIO));
        // The cast saturates.
        (self.codes, self.trigger, self.ratio) = (codes, trigger, (256.0 * least.min(1e6)) as u32);
    }

    /// The number of the next sample.
    pub const fn clock(&self) -> u64 {
        self.clock
    }

    /// The counts so far.
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The noise power per sample that the detector follows, squared codes: both parts' of I/Q.
    pub fn noise(&self) -> f32 {
        self.noise as f32 / (WINDOW * Self::LENGTH) as f32
    }

    /// Takes samples, as codes. Calls `each` with the record around every burst that is complete.
    pub fn push(&mut self, samples: &[R::Sample], mut each: impl FnMut(&Cut<R, N>)) {
        let middle = i32::from(self.codes.middle());
        let mut rest = samples;
        while !rest.is_empty() {
            let room = Self::LENGTH.saturating_sub(self.cell.filled).max(1);
            let (now, later) = rest.split_at_checked(room).unwrap_or((rest, &[]));
            rest = later;
            self.store(now);
            let mut sums = self.cell;
            for &sample in now {
                let [i, q] = R::parts(sample);
                let i = i32::from(i).wrapping_sub(middle);
                sums.sum[0] = sums.sum[0].wrapping_add(i);
                sums.squares = sums.squares.wrapping_add(i.unsigned_abs().pow(2).into());
                if R::IQ {
                    let q = i32::from(q).wrapping_sub(middle);
                    sums.sum[1] = sums.sum[1].wrapping_add(q);
                    sums.squares = sums.squares.wrapping_add(q.unsigned_abs().pow(2).into());
                }
            }
            sums.filled = sums.filled.wrapping_add(now.len());
            self.cell = sums;
            self.clock = self.clock.wrapping_add(now.len() as u64);
            self.counters.samples = self.counters.samples.wrapping_add(now.len() as u64);
            if self.cell.filled >= Self::LENGTH {
                self.step(&mut each);
            }
        }
    }

    /// Reports that `samples` samples are missing here. A burst in progress is dropped.
    pub fn lost(&mut self, samples: u64) {
        self.clock = self.clock.wrapping_add(samples);
        if self.began.is_some() || self.ended.is_some() {
            self.counters.lost = self.counters.lost.wrapping_add(1);
        }
        (self.began, self.waning, self.ended) = (None, None, None);
        self.cell = Cell::default();
        // No record and no window crosses the gap.
        self.cells = 0;
        self.free = self.free.max(self.clock);
    }

    /// Puts samples of one cell into the ring, whose length is a multiple of the cell's except for gaps.
    fn store(&mut self, samples: &[R::Sample]) {
        let ring = self.ring.as_flattened_mut();
        let at = self.clock as usize & (2 * N - 1);
        let (head, tail) = samples.split_at_checked(2 * N - at).unwrap_or((samples, &[]));
        for (from, part) in [(at, head), (0, tail)] {
            let places = ring.get_mut(from..).unwrap_or_default();
            places.iter_mut().zip(part).for_each(|(place, sample)| *place = *sample);
        }
    }

    /// The energy of cell `index`, counted as in `cells`.
    fn energy(&self, index: u32) -> u64 {
        self.history.get(index as usize & (HISTORY - 1)).copied().unwrap_or(0)
    }

    /// Completes a cell.
    fn step(&mut self, each: &mut impl FnMut(&Cut<R, N>)) {
        let length = Self::LENGTH as i64;
        let Cell { sum, squares, .. } = core::mem::take(&mut self.cell);
        // sum of (x - m)^2, with m in 1/256.
        let mut energy = (squares as i64).wrapping_mul(1 << 16);
        let means = sum.map(|sum| (256 * i64::from(sum) / length) as i32);
        if self.noise == 0 && self.cells == 0 {
            self.offset = means;
        }
        for (&sum, &offset) in sum.iter().zip(&self.offset) {
            let m = i64::from(offset);
            energy = energy.wrapping_sub(512 * m * i64::from(sum)).wrapping_add(length * m * m);
        }
        let energy = (energy >> 16).max(0) as u64;
        if let Some(place) = self.history.get_mut(self.cells as usize & (HISTORY - 1)) {
            *place = energy;
        }
        self.cells = self.cells.wrapping_add(1);
        self.cut(each);
        if (self.cells as usize) < WINDOW {
            return;
        }
        let window: u64 =
            (1..=WINDOW as u32).map(|back| self.energy(self.cells.wrapping_sub(back))).sum();
        let window = window.max(1);
        if self.noise == 0 {
            self.noise = window;
        }
        let least = u64::from(self.trigger.least) * (WINDOW * Self::LENGTH) as u64;
        // A burst ends at half of the excess at which it began, so that noise does not split it.
        let ratio = if self.began.is_some() { 128 + self.ratio / 2 } else { self.ratio };
        let loud =
            window.saturating_mul(256) > self.noise.saturating_mul(ratio.into()) && window > least;
        if !loud {
            // A 256th of the difference each cell: four records. A burst's pedestal is not an offset.
            for (offset, mean) in self.offset.iter_mut().zip(means) {
                *offset = offset.wrapping_add(mean.wrapping_sub(*offset) >> 8);
            }
        }
        // One up for three down: the quartile. The steps are a 256th.
        let step = (self.noise >> 8).max(1);
        self.noise = if window > self.noise {
            self.noise.saturating_add(step)
        } else {
            self.noise.saturating_sub(3 * step).max(1)
        };
        self.follow(window, loud, means);
    }

    /// Begins or ends a burst by the energy of the last eight cells.
    ///
    /// A strong burst ends where its energy is a sixteenth of its maximum, 1.7 deviations behind its middle, instead of where noise hides
    /// it; the next burst begins once the noise has hidden this one, or at four times the least energy in between.
    fn follow(&mut self, window: u64, loud: bool, means: [i32; 2]) {
        let Some(begun) = &mut self.began else {
            let rises = match &mut self.waning {
                _ if !loud => false,
                None => true,
                Some(least) => {
                    *least = window.min(*least);
                    window / 4 > *least
                }
            };
            if !loud {
                self.waning = None;
            }
            if rises && self.clock >= self.free {
                let cell = self.cells;
                self.began = Some(Begun { cell, most: window, rose: (cell, window) });
                self.waning = None;
            }
            return;
        };
        begun.most = begun.most.max(window);
        if window / 4 > begun.rose.1 {
            begun.rose = (self.cells, window);
        }
        let Begun { cell, most, rose } = *begun;
        if !loud || window < most / 16 {
            self.began = None;
            self.waning = loud.then_some(window);
            self.end(cell);
        } else if self.cells.wrapping_sub(rose.0) as usize > 3 * CELLS / 2 {
            self.counters.long = self.counters.long.wrapping_add(1);
            self.began = None;
            // Noise and offset are set to their present values.
            self.noise = window;
            self.offset = means;
        }
    }

    /// Finds the middle and the length of the burst that ended.
    fn end(&mut self, began: u32) {
        if self.ended.is_some() {
            self.counters.lost = self.counters.lost.wrapping_add(1);
            return;
        }
        // The window was loud from `began` on: the burst began within the window, and has been over for one window.
        let span = self.cells.wrapping_sub(began).saturating_add(WINDOW as u32 + 2);
        let first = self.cells.saturating_sub(span.min(HISTORY as u32 - 1));
        let noise = self.noise as f32 / (0.95 * WINDOW as f32);
        let moments = |above: f32| {
            let (mut sum, mut place, mut spread) = (0.0, 0.0, 0.0);
            for (index, at) in (first..self.cells).zip(0u16..) {
                let excess = self.energy(index) as f32 - noise;
                let weight = if excess > above { excess } else { 0.0 };
                let at = f32::from(at) + 0.5;
                sum += weight;
                place += weight * at;
                spread += weight * at * at;
            }
            let middle = place / sum;
            (middle, spread / sum - middle * middle)
        };
        // A cell of noise scatters by the root of two over its samples: the energy above two of these deviations is the burst's.
        let (middle, variance) = moments(noise * (8.0 / Self::LENGTH as f32).root());
        let length = Self::LENGTH as f32;
        // The energy's spread is the envelope's deviation over the root of two.
        let deviation = (2.0 * variance.max(0.0)).root() * length;
        let deviation = deviation.clamp(0.03 * N as f32, 0.4 * N as f32);
        if !middle.is_finite() || deviation.is_nan() {
            return;
        }
        let back = (self.cells.wrapping_sub(first) as f32 - middle) * length;
        // The casts saturate.
        let centre = self.clock.saturating_sub(back as u64);
        let first = centre.saturating_sub(N as u64 / 2);
        // The ring holds no earlier sample, nor any from before a gap.
        let held = self.clock.saturating_sub((self.cells as u64 * length as u64).min(2 * N as u64));
        let start = first.max(held);
        let middle = self.clock.wrapping_sub(start) as f32 - back;
        self.ended = Some(Ended { first: start, middle, deviation });
    }

    /// Cuts the record of the burst that ended, if it is complete.
    fn cut(&mut self, each: &mut impl FnMut(&Cut<R, N>)) {
        let Some(Ended { first, middle, deviation }) = self.ended else {
            return;
        };
        self.counters.dead = self.counters.dead.wrapping_add(Self::LENGTH as u64);
        if self.clock < first.saturating_add(N as u64) {
            return;
        }
        self.ended = None;
        let ring = self.ring.as_flattened();
        let at = first as usize & (2 * N - 1);
        let (end, start) = (ring.get(at..).unwrap_or_default(), ring);
        let places = self.record.iter_mut();
        places.zip(end.iter().chain(start)).for_each(|(place, sample)| *place = *sample);
        self.counters.bursts = self.counters.bursts.wrapping_add(1);
        let hold = u64::from(self.trigger.hold_off);
        self.counters.dead = self.counters.dead.wrapping_add(hold);
        self.free = self.clock.wrapping_add(hold);
        each(&Cut { clock: first, samples: &self.record, middle, deviation });
    }
}

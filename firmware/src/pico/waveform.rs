//! A chirp by pulse widths, in step with the samples.
//!
//! Slice 7 makes a pulse for each sample; its width is the chirp's height at that sample. A low-pass filter (docs/pico.md) turns the pulses
//! into a ramp. Pulses and samples count one crystal, by two multipliers, so they cannot drift apart.
//!
//! ```text
//! GP14       /‾‾‾‾‾‾\            behind the filter: up, flat, down
//!           /        \
//! GP12     |‾‾‾‾‾|____________|‾‾  high in the first segment, or in the first half of a sawtooth
//! samples  |gg.........|gg.........|gg.........|   g: guard, dropped: the filter settles
//! ```

use super::N;
use super::words::CORE_CYCLES;
use picket_dsp::solve::chirp::Shape;
use picket_wire::settings::GUARD;
use picket_wire::settings_error::WaveformError;

/// The most samples in a chirp: the size of the table.
pub const PLACES: usize = 3 * (N + GUARD as usize);
/// The highest code of the settings: the level that is always high.
const FULL: u16 = 4095;

/// A chirp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Waveform {
    shape: Shape,
    /// Samples in a segment.
    length: u32,
    /// The code at the lowest frequency and at the highest, 0 to 4095.
    codes: [u16; 2],
    /// Cycles of the converter's clock from a sample to the next.
    period: u32,
}

/// The count of a slice: PWM_CHn_DIV and TOP (DS 4.5.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// DIV: INT 11:4.
    pub divider: u32,
    /// TOP: counts of a period, less one.
    pub top: u32,
}

impl Waveform {
    /// The chirp with segments of `length` samples, `period` cycles of the converter's clock apart.
    ///
    /// # Errors
    /// The codes are out of range or out of order.
    pub fn plan(
        shape: Shape,
        length: u32,
        period: u32,
        codes: [u16; 2],
    ) -> Result<Self, WaveformError> {
        let [low, high] = codes;
        if low >= high || high > FULL {
            return Err(WaveformError::Codes);
        }
        Ok(Self { shape, length, codes, period })
    }

    /// Segments in the chirp.
    const fn segments(&self) -> u32 {
        self.shape.segments().len() as u32
    }

    /// Samples in the chirp.
    pub const fn samples(&self) -> u32 {
        self.length.saturating_mul(self.segments())
    }

    /// The count of slice 7: a period is a sample.
    pub const fn count(&self) -> Count {
        let cycles = self.period.saturating_mul(CORE_CYCLES);
        match cycles {
            // The level of all counts needs its 16 bits, too.
            1..=0xFFFF => Count { divider: 1 << 4, top: cycles - 1 },
            _ => Count { divider: CORE_CYCLES << 4, top: self.period.saturating_sub(1) },
        }
    }

    /// The count of slice 6, and its level: a period is a chirp, and the level covers the first segment, or half a sawtooth. `None` where a
    /// chirp is too long for the counter.
    pub fn sync(&self) -> Option<(Count, u32)> {
        let parts = self.segments().max(2);
        let chirp = self.samples().checked_mul(self.period)?.checked_mul(CORE_CYCLES)?;
        let part = chirp.checked_div(parts)?;
        (1..=255).find_map(|divider: u32| {
            let (level, top) = (part.checked_div(divider)?, chirp.checked_div(divider)?);
            let whole = level * parts == top && level * divider == part && top <= 1 << 16;
            whole.then_some((Count { divider: divider << 4, top: top - 1 }, level))
        })
    }

    /// The height of the chirp at a sample: codes, times the segment's length.
    fn height(&self, sample: u32) -> u64 {
        let [low, high] = self.codes.map(u64::from);
        let length = u64::from(self.length);
        let segment = sample.checked_div(self.length).unwrap_or(0);
        let rise = (high - low) * u64::from(sample - segment * self.length);
        match (segment, self.shape) {
            (0, _) => low * length + rise,
            (1, Shape::Trapezoid) => high * length,
            _ => high * length - rise,
        }
    }

    /// Fills the table with the levels of slice 7, and returns the part in use. A level is rounded so that the sum of all levels up to it
    /// is right, since the filter adds them up. The table begins with the chirp's third sample: the controller fetches each level a sample
    /// before the slice takes it over, and the first two are written before the first request.
    pub fn fill<'a>(&self, table: &'a mut [u16; PLACES]) -> &'a [u16] {
        let levels = u64::from(self.count().top) + 1;
        let whole = (u64::from(FULL) * u64::from(self.length)).max(1);
        let samples = self.samples().min(PLACES as u32);
        let mut rest = whole / 2;
        for sample in 0..samples {
            rest += levels * self.height(sample);
            let level = rest / whole;
            rest -= level * whole;
            // Two places on: the last two levels are the first two of the next chirp.
            let place = if sample < 2 { sample + samples - 2 } else { sample - 2 };
            if let Some(place) = table.get_mut(place as usize) {
                *place = level.min(0xFFFF) as u16;
            }
        }
        table.get(..samples as usize).unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chirp(shape: Shape, guard: u32, period: u32, codes: [u16; 2]) -> Waveform {
        Waveform::plan(shape, N as u32 + guard, period, codes).unwrap()
    }

    /// The levels in their order.
    fn levels(wave: &Waveform) -> std::vec::Vec<u16> {
        let mut table = [0; PLACES];
        let mut levels = wave.fill(&mut table).to_vec();
        levels.rotate_right(2);
        levels
    }

    #[test]
    fn levels_follow_the_chirp_within_a_step_and_their_sum_within_one() {
        for shape in [Shape::Sawtooth, Shape::Triangle, Shape::Trapezoid] {
            for (guard, period, codes) in [
                (0, 96, [0, 4095]),
                (64, 96, [400, 3700]),
                (10, 1000, [0, 1]),
                (64, 21_845, [0, 4095]),
                (2, 21_846, [1, 4095]),
                (0, 65_536, [4000, 4095]),
            ] {
                let wave = chirp(shape, guard, period, codes);
                let (length, counts) = (f64::from(wave.length), f64::from(wave.count().top) + 1.0);
                let levels = levels(&wave);
                assert_eq!(levels.len() as u32, wave.samples());
                let [low, high] = codes.map(|code| f64::from(code) / 4095.0 * counts);
                let mut beyond = 0.0f64;
                for (&level, sample) in levels.iter().zip(0..) {
                    let step = f64::from(sample % wave.length) / length;
                    let wanted = match (sample / wave.length, shape) {
                        (0, _) => low + (high - low) * step,
                        (1, Shape::Trapezoid) => high,
                        _ => high - (high - low) * step,
                    };
                    assert!((f64::from(level) - wanted).abs() <= 1.0, "{wave:?} {sample}");
                    beyond += f64::from(level) - wanted;
                    // A level that is high for 65,536 counts would need one count more than a level can have.
                    let most = if counts > 65_535.0 { f64::from(sample + 1) } else { 1.0 };
                    assert!(beyond.abs() <= most, "{wave:?} {sample} {beyond}");
                }
            }
        }
    }

    #[test]
    fn a_period_is_a_sample_and_the_sync_a_chirp() {
        for (shape, segments) in [(Shape::Sawtooth, 1), (Shape::Triangle, 2), (Shape::Trapezoid, 3)]
        {
            for guard in (0..=64).step_by(2) {
                for period in [96, 97, 480, 4800, 21_845, 21_846, 65_536] {
                    let wave = chirp(shape, guard, period, [0, 4095]);
                    let Count { divider, top } = wave.count();
                    assert_eq!((divider >> 4) * (top + 1), 3 * period);
                    assert!(top <= 0xFFFF && divider <= 0xFF << 4);
                    let cycles = 3 * period * wave.length * segments;
                    let Some((Count { divider, top }, level)) = wave.sync() else {
                        // Refused only: a long chirp, or one that no divider divides.
                        assert!(cycles > 48_000_000 / 1000 * 10, "{wave:?}");
                        continue;
                    };
                    assert_eq!((divider >> 4) * (top + 1), cycles);
                    assert_eq!((divider >> 4) * level, cycles / segments.max(2));
                    assert!(top <= 0xFFFF && level <= top);
                }
            }
        }
    }

    /// Behind 1 kΩ and 15 nF, then 10 kΩ and 1.5 nF, the values in docs/pico.md, at 500 kS/s: the ramp between its guards is a straight
    /// line, within the deviation stated there.
    #[test]
    fn behind_its_filter_a_ramp_is_straight() {
        let wave = chirp(Shape::Triangle, 64, 96, [300, 3800]);
        let levels = levels(&wave);
        let counts = wave.count().top + 1;
        let tick = 1.0 / 144e6;
        // The second section loads the first one with a tenth of it.
        let (c1, c2, r1, r2) = (15e-9, 1.5e-9, 1e3, 10e3);
        let (mut first, mut second) = (0.0f64, 0.0f64);
        let mut seen = std::vec::Vec::new();
        // The second time round nothing remains of the start.
        for (&level, sample) in levels.iter().chain(&levels).zip(0u32..) {
            let mut mean = 0.0;
            for count in 0..counts {
                let pulse = if count < u32::from(level) { 4095.0 } else { 0.0 };
                let through = (first - second) / r2;
                first += ((pulse - first) / r1 - through) / c1 * tick;
                second += through / c2 * tick;
                mean += second / f64::from(counts);
            }
            if sample >= wave.samples() {
                seen.push((mean, second));
            }
        }
        for segment in seen.chunks_exact(wave.length as usize) {
            let block = &segment[64..];
            let slope = (block[1023].0 - block[0].0) / 1023.0;
            let line = |n: usize| block[0].0 + slope * n as f64;
            let bend = block.iter().enumerate().map(|(n, (mean, _))| (mean - line(n)).abs());
            let ripple = block.iter().map(|(mean, end)| (end - mean).abs());
            let [bend, ripple] = [bend.fold(0.0, f64::max), ripple.fold(0.0, f64::max)];
            std::println!("bend {bend:.2}, ripple {ripple:.2} codes of 4096");
            assert!(bend < 0.6 && ripple < 2.5, "{bend} {ripple}");
        }
    }

    #[test]
    fn codes_out_of_range_are_refused() {
        for codes in [[9, 9], [10, 9], [0, 4096]] {
            let wave = Waveform::plan(Shape::Sawtooth, 1024, 96, codes);
            assert_eq!(wave, Err(WaveformError::Codes));
        }
    }
}

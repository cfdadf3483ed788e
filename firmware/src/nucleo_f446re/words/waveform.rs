//! A chirp on the board's own DAC, locked to the sampling.
//!
//! TIM4 counts the updates of TIM3, which are samples, and steps the DAC once every `hold` samples. Stream 5 of DMA1 feeds the DAC from a
//! table of one whole chirp, round and round. A segment is a whole number of steps, and both start at one edge. So block and segment cannot
//! drift apart, whatever the clock does.
//!
//! ```text
//! DAC        /‾‾‾‾‾‾\            one table: up, flat, down
//!           /        \
//! samples  |gg.........|gg.........|gg.........|   g: guard, dropped: echo's delay, filters' settling
//! ```

use picket_dsp::solve::chirp::Shape;
use picket_wire::settings_error::WaveformError;

/// The fastest rate of the DAC, updates a second (DS 6.3.26).
pub const DAC_RATE_HZ: f64 = 1e6;
/// The most steps in a chirp: the size of the table.
pub const STEPS: usize = 1024;

/// One chirp on the DAC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Waveform {
    /// The ramps.
    pub shape: Shape,
    /// Samples in a step: TIM4_ARR plus 1. At least 2: a counter whose reload value is 0 is blocked
    /// (RM 17.4.12).
    pub hold: u16,
    /// Steps in a segment.
    pub steps: u16,
    /// The DAC's code at the lowest frequency and at the highest.
    pub codes: [u16; 2],
}

impl Waveform {
    /// The waveform with the finest steps for segments of `length` samples at `rate_hz`.
    ///
    /// # Errors
    /// The codes are out of range or out of order, or no whole number of steps fits a segment.
    pub fn plan(
        shape: Shape,
        length: u32,
        rate_hz: f64,
        codes: [u16; 2],
    ) -> Result<Self, WaveformError> {
        let [low, high] = codes;
        if low >= high || high > 4095 {
            return Err(WaveformError::Codes);
        }
        let follows = |hold: u32| rate_hz <= DAC_RATE_HZ * f64::from(hold);
        let segments = shape.segments().len();
        for hold in 2..=length.min(1 << 12) {
            let steps = length.checked_div(hold).unwrap_or(0);
            let whole = steps.checked_mul(hold) == Some(length);
            if whole && follows(hold) && steps > 1 && steps as usize * segments <= STEPS {
                return Ok(Waveform { shape, hold: hold as u16, steps: steps as u16, codes });
            }
        }
        Err(WaveformError::Steps)
    }

    /// Steps in the whole chirp.
    pub const fn len(&self) -> usize {
        self.steps as usize * self.shape.segments().len()
    }

    /// Always false: a waveform has at least two steps. Clippy asks for this function.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The DAC's code at a step of the chirp. The last step of a ramp is one step below its end,
    /// where the next segment begins, so every step has the same height.
    pub fn code(&self, step: usize) -> u16 {
        let [low, high] = self.codes;
        let steps = u32::from(self.steps).max(1);
        let (segment, step) = ((step as u32 / steps), (step as u32 % steps));
        // The product is at most 4095 * 1024. Rounding does not lift the quotient above the whole.
        let rise = (u32::from(high.saturating_sub(low)) * step + steps / 2) / steps;
        match (segment, self.shape) {
            (0, _) => low.saturating_add(rise as u16),
            (1, Shape::Trapezoid) => high,
            _ => high.saturating_sub(rise as u16),
        }
    }

    /// Fills the table. Returns the part that the DMA plays, which begins with the second step. The first step is already in the DAC's
    /// register: a trigger outputs it before requesting the next.
    pub fn fill<'a>(&self, table: &'a mut [u16; STEPS]) -> &'a [u16] {
        for (step, code) in table.iter_mut().enumerate() {
            *code = self.code(if step + 1 < self.len() { step + 1 } else { 0 });
        }
        table.get(..self.len()).unwrap_or(&[])
    }
}

/// TIM2 as the source of a pulse on PB10 (Arduino D6), high during the first segment of each chirp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncOutput {
    /// TIM2_ARR: samples in a chirp, minus 1.
    pub reload: u32,
    /// TIM2_CCR3: samples in a segment.
    pub compare: u32,
}

impl SyncOutput {
    /// The pulse for chirps of `segments` segments of `length` samples.
    pub const fn new(segments: u16, length: u32) -> Self {
        let chirp = length.saturating_mul(segments as u32);
        // A sawtooth has one segment, so its pulse must end before the next one.
        let compare = if segments < 2 { length / 2 } else { length };
        SyncOutput { reload: chirp.saturating_sub(1), compare }
    }
}

/// TIM2_ARR as the gate for chirps of this many timer ticks; `None` for more than TIM2 counts.
pub fn gate_ticks(ticks: u64) -> Option<u32> {
    u32::try_from(ticks).ok().filter(|&ticks| ticks > 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_trapezoid_rises_rests_and_falls_in_equal_steps() {
        let wave = Waveform::plan(Shape::Trapezoid, 1088, 1.5e6, [100, 3500]).unwrap();
        // 2 samples a step make 544 steps a segment, too many for the table; 4 samples make 272.
        assert_eq!((wave.hold, wave.steps, wave.len()), (4, 272, 816));
        let mut table = [0; STEPS];
        let mut codes: Vec<u16> = wave.fill(&mut table).to_vec();
        codes.rotate_right(1);
        assert_eq!(codes[0], wave.code(0));
        assert_eq!(codes.len(), 816);
        assert_eq!((codes[0], codes[272], codes[543], codes[544]), (100, 3500, 3500, 3500));
        let back = codes.iter().cycle().skip(1);
        for (index, (a, b)) in codes.iter().zip(back).enumerate() {
            let step = i32::from(*b) - i32::from(*a);
            match index / 272 {
                // 3400 / 272 = 12.5, also from the last step into the next segment.
                0 => assert!((12..=13).contains(&step), "{index}: {step}"),
                1 => assert_eq!(step, 0),
                _ => assert!((-13..=-12).contains(&step), "{index}: {step}"),
            }
        }
    }

    #[test]
    fn steps_are_whole_and_the_dac_can_follow() {
        for shape in [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth] {
            for length in [64, 128, 1024, 1056, 1088, 4096, 4160] {
                for rate in [1e3, 5e5, 1.5e6, 2.4e6] {
                    let wave = Waveform::plan(shape, length, rate, [0, 4095]).unwrap();
                    assert_eq!(u32::from(wave.hold) * u32::from(wave.steps), length);
                    // A reload value of 0 blocks the counter (RM 17.4.12).
                    assert!(wave.hold > 1);
                    assert!(rate / f64::from(wave.hold) <= DAC_RATE_HZ);
                    assert!(wave.len() <= STEPS && !wave.is_empty());
                    assert!((0..wave.len()).all(|step| wave.code(step) <= 4095));
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_played() {
        let plan = |length, codes| Waveform::plan(Shape::Trapezoid, length, 1.5e6, codes);
        for codes in [[5, 5], [6, 5], [0, 4096]] {
            assert_eq!(plan(1088, codes), Err(WaveformError::Codes));
        }
        // 1087 is prime.
        assert_eq!(plan(1087, [0, 4095]), Err(WaveformError::Steps));
        assert_eq!(plan(0, [0, 4095]), Err(WaveformError::Steps));
    }

    #[test]
    fn a_pulse_marks_a_segment_and_a_gate_lets_a_chirp_through() {
        assert_eq!(SyncOutput::new(3, 1088), SyncOutput { reload: 3263, compare: 1088 });
        assert_eq!(SyncOutput::new(1, 1088).compare, 544);
        assert_eq!(gate_ticks(3 * 1088 * 60), Some(195_840));
        assert_eq!((gate_ticks(0), gate_ticks(1 << 32)), (None, None));
    }
}

//! From the units of a file to codes of 16 bits.

use super::levels::Levels;

/// The codes of 16 bits.
const RAILS: (f64, f64) = (-32768.0, 32767.0);
/// Where the ends of what is not clipped come to lie, as a share of the rails: the converter's own rails are not known, and a sample
/// at ours would be taken for a clipped one.
const HEADROOM: f64 = 0.9;
/// Of a recording that cannot be read twice only the beginning is known: as far again in all directions is left free twice over.
const UNKNOWN: f64 = 0.25;

/// How the numbers of a file become codes: `code = factor * number + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Codes per unit of the file.
    pub factor: f64,
    /// The code of the number 0.
    pub shift: f64,
}

/// The usual scaling of a format, and whether the data may choose a better one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub usual: Scaling,
    pub by_data: bool,
}

impl Scaling {
    /// Numbers that are codes.
    pub const CODES: Scaling = Scaling { factor: 1.0, shift: 0.0 };

    /// The code of a number.
    pub fn code(&self, number: f64) -> f64 {
        self.factor * number + self.shift
    }

    /// The number of a code.
    pub fn number(&self, code: f64) -> f64 {
        (code - self.shift) / self.factor
    }

    /// The scaling that uses all 16 bits for numbers of these levels. Whole numbers that are codes of 16 bits already stay what they
    /// are. Steps become whole numbers of codes, so that nothing is rounded, where this costs less than the headroom. A clipped end
    /// comes to lie at the rail.
    pub fn from_levels(levels: &Levels) -> Self {
        let &Levels { low, high, step, ends, whole, .. } = levels;
        if whole && low >= RAILS.0 && high <= RAILS.1 {
            return Self::CODES;
        }
        if high <= low {
            return Self { factor: 1.0, shift: -low };
        }
        let bottom = if ends[0] { RAILS.0 } else { HEADROOM * RAILS.0 };
        let top = if ends[1] { RAILS.1 } else { HEADROOM * RAILS.1 };
        let mut factor = (top - bottom) / (high - low);
        if let Some(step) = step.filter(|step| !(ends[0] && ends[1]) && factor * step >= 1.0) {
            factor = (factor * step).floor() / step;
        }
        let shift = match ends {
            [false, true] => top - factor * high,
            [true, _] => bottom - factor * low,
            // A number that is 0 gets a whole code, and its steps with it.
            [false, false] => match step {
                Some(step) => {
                    let middle = low + ((high - low) / step / 2.0).floor() * step;
                    -factor * middle
                }
                None => -factor * f64::midpoint(low, high),
            },
        };
        Self { factor, shift }
    }

    /// The scaling for a recording that is known only in part, from its beginning.
    pub(super) fn of_beginning(levels: &Levels) -> Self {
        let scaling = Self::from_levels(&Levels { ends: [false; 2], ..*levels });
        if scaling == Self::CODES {
            return scaling;
        }
        Self { factor: UNKNOWN * scaling.factor, shift: UNKNOWN * scaling.shift }
    }
}

impl Unit {
    /// Codes of 16 bits, as they are.
    pub const CODES: Unit = Unit { usual: Scaling::CODES, by_data: false };
    /// Numbers that the data give a scale to.
    pub const FREE: Unit = Unit { usual: Scaling::CODES, by_data: true };
    /// Numbers from -1 to 1.
    pub const SHARE: Unit = Unit { usual: Scaling { factor: 32768.0, shift: 0.0 }, by_data: true };

    /// Whole numbers of this many bits, of 16 or more.
    pub fn bits(bits: u32) -> Self {
        let factor = (16.0 - f64::from(bits)).exp2();
        Unit { usual: Scaling { factor, shift: 0.0 }, by_data: bits > 16 }
    }

    /// Whole numbers of 8 bits around a middle: their rails are the rails.
    pub const fn eight_bits(middle: f64) -> Self {
        let shift = 128.0 - 257.0 * middle;
        Unit { usual: Scaling { factor: 257.0, shift }, by_data: false }
    }

    /// Whole numbers of 16 bits from 0 on.
    pub const OFFSET_16: Unit =
        Unit { usual: Scaling { factor: 1.0, shift: -32768.0 }, by_data: false };
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVELS: Levels = Levels {
        low: 0.5,
        high: 2.5,
        mean: 1.5,
        rms: 0.7,
        step: None,
        clipped: 0.0,
        ends: [false; 2],
        whole: false,
    };

    #[test]
    fn all_sixteen_bits_are_used() {
        let scaling = Scaling::from_levels(&LEVELS);
        let ends = [scaling.code(0.5), scaling.code(2.5)];
        assert!(ends[0] < -29_000.0 && ends[1] > 29_000.0 && ends[1] < 30_000.0, "{ends:?}");
        assert!((scaling.number(scaling.code(1.25)) - 1.25).abs() < 1e-12);
        // A clipped end is at the rail, and the other one is not.
        let clipped = Scaling::from_levels(&Levels { ends: [false, true], ..LEVELS });
        assert!((clipped.code(2.5) - 32767.0).abs() < 1e-6 && clipped.code(0.5) > -32000.0);
        let both = Scaling::from_levels(&Levels { ends: [true; 2], ..LEVELS });
        assert!((both.code(2.5) - 32767.0).abs() < 1e-6 && (both.code(0.5) + 32768.0).abs() < 1e-6);
        let codes = Levels { low: 0.0, high: 4095.0, whole: true, step: Some(1.0), ..LEVELS };
        assert_eq!(Scaling::from_levels(&codes), Scaling::CODES);
        let flat = Scaling::from_levels(&Levels { high: 0.5, ..LEVELS });
        assert_eq!(flat.code(0.5), 0.0);
    }

    #[test]
    fn steps_are_whole_numbers_of_codes() {
        let scaling = Scaling::from_levels(&Levels { step: Some(0.01), ..LEVELS });
        for steps in 0..=200 {
            let code = scaling.code(0.5 + 0.01 * f64::from(steps));
            assert!((code - code.round()).abs() < 1e-6, "{code}");
        }
    }
}

//! What the bytes of a file without a header may be. Numbers of one kind that are read as another have marks of their own: an
//! exponent is no mantissa, and a byte around 128 is not the upper half of a number around 0.

use super::Format;

/// Numbers that are looked at.
const LOOKED_AT: usize = 4096;
/// Floats of a recording lie in this range, or are 0.
const RANGE: (f64, f64) = (1e-12, 1e12);
/// Of a hundred numbers this many have to be a recording's: one read from others is in ranges like this by chance, once in three.
const SHARE: f64 = 0.99;
/// Bytes of a converter of eight bits have their mean so near 128, and a spread that is a sine's or less: bytes that take any value
/// alike have 74.
const MIDDLE: f64 = 12.0;
const SPREAD: f64 = 60.0;

/// The readings that are possible, in the words of `--format`; empty where 16-bit integers are the only one.
pub(super) fn readings(head: &[u8]) -> &'static [Format] {
    if floats(head, 8, |b| f64::from_le_bytes(b.try_into().unwrap_or_default())) {
        return &[Format::F64, Format::Cf64];
    }
    if floats(head, 4, |b| f64::from(f32::from_le_bytes(b.try_into().unwrap_or_default()))) {
        return &[Format::F32, Format::Cf32];
    }
    if eight_bits(head) {
        return &[Format::Cu8, Format::U8];
    }
    &[]
}

/// Whether the bytes are floats of a recording.
fn floats(head: &[u8], width: usize, read: impl Fn(&[u8]) -> f64) -> bool {
    let values: Vec<f64> = head.chunks_exact(width).take(LOOKED_AT).map(read).collect();
    let fits = |x: &&f64| **x == 0.0 || (RANGE.0..RANGE.1).contains(&x.abs());
    let not_zero = values.iter().filter(|x| **x != 0.0).count();
    let count = values.len() as f64;
    // Silence is silence in every kind of number.
    values.len() >= 16
        && not_zero as f64 > count / 4.0
        && values.iter().filter(fits).count() as f64 >= SHARE * count
}

/// Whether even and odd bytes are alike, and lie around 128 as those of a converter of eight bits do.
fn eight_bits(head: &[u8]) -> bool {
    let lies = |from: usize| {
        let bytes = || head.iter().skip(from).step_by(2).take(LOOKED_AT).map(|&b| f64::from(b));
        let count = bytes().count() as f64;
        let mean = bytes().sum::<f64>() / count;
        let spread = (bytes().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
        count >= 64.0 && (mean - 127.5).abs() < MIDDLE && spread > 0.5 && spread < SPREAD
    };
    lies(0) && lies(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(n: u32) -> f64 {
        (TAU * 0.0371 * f64::from(n)).sin()
    }

    #[test]
    fn numbers_of_one_kind_are_not_read_as_another() {
        let bytes = |of: &dyn Fn(u32) -> Vec<u8>| (0..4096).flat_map(of).collect::<Vec<u8>>();
        for level in [1e-3, 0.1, 1.0, 300.0] {
            let floats = bytes(&|n| ((level * sine(n)) as f32).to_le_bytes().into());
            assert_eq!(readings(&floats)[0], Format::F32, "{level}");
            let doubles = bytes(&|n| (level * sine(n)).to_le_bytes().into());
            assert_eq!(readings(&doubles)[0], Format::F64, "{level}");
        }
        for level in [3.0, 100.0, 2000.0, 32_000.0] {
            for offset in [0.0, 2048.0] {
                let codes = bytes(&|n| ((level * sine(n) + offset) as i16).to_le_bytes().into());
                assert!(readings(&codes).is_empty(), "{level} {offset}");
            }
        }
        for level in [2.0, 20.0, 80.0] {
            let bytes = bytes(&|n| vec![(127.5 + level * sine(n)) as u8]);
            assert_eq!(readings(&bytes)[0], Format::Cu8, "{level}");
        }
        let doubles = bytes(&|n| (f64::from(n % 5) / 4.0).to_le_bytes().into());
        assert_eq!(readings(&doubles)[0], Format::F64);
        assert!(readings(&[0; 4096]).is_empty() && readings(&[]).is_empty());
    }
}

//! Headerless numbers of 16 bits in another order than one channel's: words of 32 bits, two channels in turn, pairs of I and Q in turn
//! or in fours.
//!
//! The second-order linear prediction of a tone is exact, over samples `lag` apart, too, as long as these are of one channel. Where
//! two channels come in turn it is exact at lag 2 and not at lag 1: a line at f is beside one of its mirror image at half the rate
//! less f. I I Q Q is alike at lag 4.

use super::Format;

/// The number of samples looked at; fewer show nothing.
const LOOKED_AT: usize = 16_384;
const LEAST: usize = 256;
/// The share of power that a right prediction leaves, and the factor by which a wrong one leaves more.
const LEFT: f64 = 0.05;
const TIMES: f64 = 8.0;
/// Mirror images of at least this share of the power.
const MIRRORED: f64 = 0.1;

const WORDS: &str = "this looks like 32-bit words, whose upper halves are empty: add --format i32, or --format i16 if it is not";
const TURNS: &str = "this looks like two channels in turn: add --channels 2 --channel 1, or --iq if they are I and Q, or --format i16 if it is not";
const FOURS: &str =
    "this looks like I and Q in fours, I I Q Q: add --format iiqq, or --format i16 if it is not";

/// What numbers of this format look like, and what to add for it.
pub(super) fn like(head: &[u8], format: Format) -> Option<&'static str> {
    if format != Format::I16 && format != Format::U16 {
        return None;
    }
    let number = |pair: &[u8; 2]| f64::from(i16::from_le_bytes(*pair));
    let x: Vec<f64> = head.as_chunks().0.iter().take(LOOKED_AT).map(number).collect();
    if x.len() < LEAST {
        return None;
    }
    let part = |first: usize| x.iter().skip(first).step_by(2);
    let varies = |first: usize| part(first).any(|value| *value != x[first]);
    // The sign of a word goes on through its upper half.
    let sign = |pair: &[f64]| pair[1] == 0.0 || pair[1] == -1.0 && pair[0] < 0.0;
    if varies(0) && x.chunks_exact(2).all(sign) {
        return Some(WORDS);
    }
    let half = x.len() as f64 / 2.0;
    let means = [0, 1].map(|first| part(first).sum::<f64>() / half);
    let mean = f64::midpoint(means[0], means[1]);
    let power = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64;
    if power <= 0.0 || !x.len().is_multiple_of(2) {
        return None;
    }
    let apart = (means[0] - means[1]).powi(2) / 4.0;
    let own: Vec<f64> = x.iter().enumerate().map(|(k, x)| x - means[k % 2]).collect();
    let [one, two, four] = [1, 2, 4].map(|lag| left(&own, lag));
    if apart > 0.5 * power {
        return Some(TURNS);
    }
    if four < LEFT && two > TIMES * four && two > 0.2 * MIRRORED {
        return Some(FOURS);
    }
    if two < LEFT && (one > MIRRORED && one > TIMES * two || slow_mirror(&own) > MIRRORED) {
        return Some(TURNS);
    }
    None
}

/// The share of the power that the best prediction from the values one and two lags before leaves, of each of the channels in turn.
fn left(x: &[f64], lag: usize) -> f64 {
    let (mut left, mut all) = (0.0, 0.0);
    for first in 0..lag {
        let mut sums = [0.0; 6];
        for k in (2 * lag + first..x.len()).step_by(lag) {
            let (now, a, b) = (x[k], x[k - lag], x[k - 2 * lag]);
            let more = [now * now, now * a, now * b, a * a, a * b, b * b];
            sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
        let [nn, na, nb, aa, ab, bb] = sums;
        let determinant = aa * bb - ab * ab;
        let [one, two] = match determinant > 1e-12 * aa * bb {
            true => [(na * bb - nb * ab) / determinant, (nb * aa - na * ab) / determinant],
            false => [0.0; 2],
        };
        left += (nn - one * na - two * nb).max(0.0);
        all += nn;
    }
    if all > 0.0 { left / all } else { 1.0 }
}

/// The power around half the rate as a share of that around 0 Hz: of two slow signals in turn both are there.
fn slow_mirror(x: &[f64]) -> f64 {
    const MEAN: usize = 16;
    let power = |sign: f64| {
        let mean =
            |some: &[f64]| some.iter().rev().fold(0.0, |sum, x| x + sign * sum) / MEAN as f64;
        x.windows(MEAN).map(|some| mean(some).powi(2)).sum::<f64>()
    };
    let (low, high) = (power(1.0), power(-1.0));
    let all: f64 = x.iter().map(|x| x * x).sum();
    if low.max(high) < 2.0 * MIRRORED * all {
        0.0
    } else {
        low.min(high) / low.max(high).max(1e-300)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Numbers with noise, from the place of each.
    fn of(value: impl Fn(usize) -> f64) -> Option<&'static str> {
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24) - 0.5
        };
        let code = |k: usize| (value(k) + 40.0 * noise()).round() as i16;
        let bytes: Vec<u8> = (0..8192)
            .map(code)
            .collect::<Vec<_>>()
            .into_iter()
            .flat_map(i16::to_le_bytes)
            .collect();
        like(&bytes, Format::I16)
    }

    fn tone(cycles: f64, k: usize, phase: f64) -> f64 {
        1000.0 * (TAU * (cycles * k as f64 + phase)).sin()
    }

    #[test]
    fn orders_are_told_apart() {
        for cycles in [0.003, 0.0217, 0.125, 0.2371, 0.25, 0.375, 0.4321, 0.49] {
            assert_eq!(of(|k| tone(cycles, k, 0.1)), None, "{cycles}");
            assert_eq!(
                of(|k| 2048.0 + tone(cycles, k, 0.1).clamp(-800.0, 800.0)),
                None,
                "{cycles}"
            );
            let both = |k: usize| tone(cycles, k, 0.1) + 0.5 * tone(0.27 * cycles, k, 0.0);
            assert_eq!(of(both), None, "{cycles}");
            // Of a high tone the two parts are one of the next samples' too.
            if cycles < 0.3 {
                assert_eq!(
                    of(|k| tone(cycles, k / 2, 0.25 * (k % 2) as f64)),
                    Some(TURNS),
                    "{cycles}"
                );
            }
            let two = |k: usize| {
                tone(if k.is_multiple_of(2) { cycles } else { 0.41 * cycles }, k / 2, 0.0)
            };
            assert_eq!(of(two), Some(TURNS), "{cycles}");
            let other =
                |k: usize| if k.is_multiple_of(2) { tone(cycles, k / 2, 0.3) } else { 3000.0 };
            assert_eq!(of(other), Some(TURNS), "{cycles}");
            let four = |k: usize| tone(cycles, k / 4 * 2 + k % 2, 0.25 * (k / 2 % 2) as f64);
            // Around a quarter of the rate the two parts are each other's neighbours.
            if (0.02..0.48).contains(&cycles) && (cycles - 0.25).abs() > 0.02 {
                assert_eq!(of(four), Some(FOURS), "{cycles}");
            }
        }
        let square = |k: usize| if (0.0371 * k as f64).fract() < 0.5 { 900.0 } else { -900.0 };
        assert_eq!(of(square), None);
        assert_eq!(of(|_| 0.0), None);
        let words: Vec<u8> =
            (0..4096).flat_map(|k| (2048 + tone(0.06, k, 0.0) as i32).to_le_bytes()).collect();
        assert_eq!(like(&words, Format::I16), Some(WORDS));
        assert_eq!(like(&[0; 4096], Format::I16), None);
    }
}

//! Twiddle factors, computed by the compiler: packed Q15 pairs, one table for each length.

/// The smallest record length.
pub const MIN_LENGTH: usize = 64;
/// The largest record length.
pub const MAX_LENGTH: usize = 4096;

/// Whether the FFT supports this record length: 64, 128, ... 4096.
pub const fn supported(n: usize) -> bool {
    n.is_power_of_two() && n >= MIN_LENGTH && n <= MAX_LENGTH
}

/// Two Q15 numbers in a word, low half first. The DSP extension multiplies this form.
pub type Packed = u32;

/// The three factors of a radix-4 butterfly, `exp(-j 2 pi q i / M)` for q = 1, 2, 3, each packed as
/// `cos | -sin << 16`. The negated sine reaches -1.0, which Q15 holds, and never +1.0, which Q15
/// does not hold. The factor 1 has a path of its own.
pub type Triple = [Packed; 3];

/// Radix-4 factors of an `m`-point transform. Entry `i` serves the last pass, every `stride`-th
/// entry an earlier pass.
pub const fn passes(m: usize) -> &'static [Triple] {
    match m {
        32..=1024 if ONE_TABLE => &PASSES_1024,
        32 => &PASSES_32,
        64 => &PASSES_64,
        128 => &PASSES_128,
        256 => &PASSES_256,
        512 => &PASSES_512,
        1024 => &PASSES_1024,
        2048 => &PASSES_2048,
        4096 => &PASSES_4096,
        _ => &[],
    }
}

/// Whether shorter transforms use the table of the longest, and need some of its factors: a page has all lengths, and its size counts.
const ONE_TABLE: bool = cfg!(target_arch = "wasm32");

/// A factor of 32 bits, `[cos, sin]` in Q31.
pub type Fine = [i32; 2];

/// The three factors of a radix-4 butterfly, as in [`Triple`] but of 32 bits each.
pub type FineTriple = [Fine; 3];

/// Factors as in [`passes`], of 32 bits, for the long transforms; empty for the others. In a long transform, rounding the factors to 16
/// bits would leave an error as large as the noise of a bin.
pub const fn fine_passes(m: usize) -> &'static [FineTriple] {
    match m {
        2048 if ONE_TABLE => &FINE_4096,
        2048 => &FINE_2048,
        4096 => &FINE_4096,
        _ => &[],
    }
}

/// Factors that split an `n/2`-point complex spectrum into the `n`-point spectrum of a real record.
/// Entry `k` is `-cos | -sin << 16` of `2 pi k / n`, k = 0..n/4.
pub const fn splits(n: usize) -> &'static [Packed] {
    match n {
        64 => &SPLITS_64,
        128 => &SPLITS_128,
        256 => &SPLITS_256,
        512 => &SPLITS_512,
        1024 => &SPLITS_1024,
        2048 => &SPLITS_2048,
        4096 => &SPLITS_4096,
        _ => &[],
    }
}

/// Factors that split the bins of the longest real record as [`splits`] does, of 32 bits, for the bins that are measured: `sin(2 pi k / n)`
/// in Q31, k = 0..=n/4. Empty for the other lengths, whose passes have factors of 16 bits.
pub const fn sines(n: usize) -> &'static [i32] {
    match n {
        4096 => &SINES_4096,
        _ => &[],
    }
}

const PASSES_32: [Triple; 8] = triples();
const PASSES_64: [Triple; 16] = triples();
const PASSES_128: [Triple; 32] = triples();
const PASSES_256: [Triple; 64] = triples();
const PASSES_512: [Triple; 128] = triples();
const PASSES_1024: [Triple; 256] = triples();
const PASSES_2048: [Triple; 512] = triples();
const PASSES_4096: [Triple; 1024] = triples();

static FINE_2048: [FineTriple; 512] = fine_triples();
static FINE_4096: [FineTriple; 1024] = fine_triples();

const SPLITS_64: [Packed; 16] = quarter();
const SPLITS_128: [Packed; 32] = quarter();
const SPLITS_256: [Packed; 64] = quarter();
const SPLITS_512: [Packed; 128] = quarter();
const SPLITS_1024: [Packed; 256] = quarter();
const SPLITS_2048: [Packed; 512] = quarter();
const SPLITS_4096: [Packed; 1024] = quarter();

static SINES_4096: [i32; 1025] = quarter_sines();

// Const functions cannot use `get_mut`. An index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn triples<const Q: usize>() -> [Triple; Q] {
    let mut table = [[0; 3]; Q];
    let mut i = 0;
    while i < Q {
        let mut q = 0;
        while q < 3 {
            table[i][q] = factor((q + 1) * i, 4 * Q);
            q += 1;
        }
        i += 1;
    }
    table
}

#[allow(clippy::indexing_slicing)]
const fn fine_triples<const Q: usize>() -> [FineTriple; Q] {
    let mut table = [[[0; 2]; 3]; Q];
    let mut i = 0;
    while i < Q {
        let mut q = 0;
        while q < 3 {
            let (sin, cos) = sin_cos((q + 1) * i, 4 * Q);
            table[i][q] = [q31(cos), q31(sin)];
            q += 1;
        }
        i += 1;
    }
    table
}

#[allow(clippy::indexing_slicing)]
const fn quarter<const Q: usize>() -> [Packed; Q] {
    let mut table = [0; Q];
    let mut k = 0;
    while k < Q {
        let (sin, cos) = sin_cos(k, 4 * Q);
        table[k] = pack(q15(-cos), q15(-sin));
        k += 1;
    }
    table
}

#[allow(clippy::indexing_slicing)]
const fn quarter_sines<const Q: usize>() -> [i32; Q] {
    let mut table = [0; Q];
    let mut k = 0;
    while k < Q {
        table[k] = q31(sin_cos(k, 4 * (Q - 1)).0);
        k += 1;
    }
    table
}

/// `exp(-j 2 pi i / n)`, packed as `cos | -sin << 16`.
pub(super) const fn factor(i: usize, n: usize) -> Packed {
    let (sin, cos) = sin_cos(i, n);
    pack(q15(cos), q15(-sin))
}

const fn pack(low: i16, high: i16) -> Packed {
    low as u16 as u32 | (high as u16 as u32) << 16
}

/// `x` in Q15, rounded to nearest and saturated.
pub(super) const fn q15(x: f64) -> i16 {
    let scaled = x * 32768.0;
    // `as` saturates. Adding or subtracting half a unit first rounds to nearest.
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i16
}

/// `x` in Q31, rounded to nearest and saturated.
pub(super) const fn q31(x: f64) -> i32 {
    let scaled = x * 2_147_483_648.0;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
}

/// Sine and cosine of `2 pi i / n`, within 1e-15. The angle is folded into an eighth of a turn,
/// where twelve terms of the series are exact to the last digit. `n` is a multiple of 8.
pub const fn sin_cos(i: usize, n: usize) -> (f64, f64) {
    let i = i % n;
    let quadrant = i * 4 / n;
    let rest = i - quadrant * n / 4;
    let (sin, cos) = if rest * 8 <= n {
        series(core::f64::consts::TAU * rest as f64 / n as f64)
    } else {
        let (s, c) = series(core::f64::consts::TAU * (n / 4 - rest) as f64 / n as f64);
        (c, s)
    };
    match quadrant {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

const fn series(x: f64) -> (f64, f64) {
    let (mut sin, mut cos) = (0.0, 0.0);
    let mut term = 1.0;
    let mut power = 0;
    while power < 24 {
        match power % 4 {
            0 => cos += term,
            1 => sin += term,
            2 => cos -= term,
            _ => sin -= term,
        }
        power += 1;
        term *= x / power as f64;
    }
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_equals_the_library() {
        for n in [64usize, 1024, 4096] {
            for i in 0..n {
                let angle = core::f64::consts::TAU * i as f64 / n as f64;
                let (sin, cos) = sin_cos(i, n);
                assert!((sin - libm::sin(angle)).abs() < 2e-15, "sin {i}/{n}");
                assert!((cos - libm::cos(angle)).abs() < 2e-15, "cos {i}/{n}");
            }
        }
    }

    #[test]
    fn factors_are_rounded_and_at_most_saturated_by_half_a_count() {
        // Q15 ends at 32767, so a cosine within half a count of 1 loses up to one count.
        let close = |got: i16, exact: f64| {
            (f64::from(got) - exact).abs() <= if exact > 32767.0 { 1.0 } else { 0.5 + 1e-9 }
        };
        for m in [32, 64, 128, 256, 512, 1024, 2048, 4096] {
            for (i, triple) in passes(m).iter().enumerate().skip(1) {
                for (q, &factor) in triple.iter().enumerate() {
                    let (sin, cos) = sin_cos((q + 1) * i, m);
                    let [low, high] = [factor as i16, (factor >> 16) as i16];
                    assert!(
                        close(low, 32768.0 * cos) && close(high, -32768.0 * sin),
                        "{m} {i} {q}"
                    );
                }
            }
        }
    }

    #[test]
    fn sines_are_a_quarter_of_a_turn() {
        const N: usize = 4096;
        assert_eq!(sines(N).len(), N / 4 + 1);
        for (k, &sine) in sines(N).iter().enumerate() {
            let exact = 2_147_483_648.0 * sin_cos(k, N).0;
            // The sine of a quarter turn is 1, which 32 bits do not hold.
            let most = if k < N / 4 { 0.5 } else { 1.0 };
            assert!((f64::from(sine) - exact).abs() <= most, "{k}");
        }
    }
}

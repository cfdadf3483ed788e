//! A reciprocal in four multiplications, for cores without an FPU: their division is slow or
//! missing.

/// The seeds: the inverse of the middle of each part of 1..2, with eight fractional bits without
/// the leading one.
const SEEDS: [u8; 128] = {
    let mut seeds = [0; 128];
    let mut i = 0;
    while i < 128 {
        // This runs at compile time: an index out of range would not compile.
        #[allow(clippy::indexing_slicing)]
        {
            seeds[i] = (512.0 / (1.0 + (i as f64 + 0.5) / 128.0) - 256.0 + 0.5) as u8;
        }
        i += 1;
    }
    seeds
};

/// `2^61 / m` with a relative error of 2^-27, at most 2^31, for `m` within 2^30..2^31.
///
/// Newton's step is `r (2 - m r)`. The difference of `m r` from a power of two fits in 32 bits, so
/// a product modulo 2^32 is enough.
pub(super) fn of(m: u32) -> u32 {
    let rough = rough(m);
    // r = 2^46 / m to 14 bits: 2^45 - (m/2) r is below 2^31.
    let off = (m >> 1).wrapping_mul(rough).wrapping_neg() as i32;
    (rough << 15).wrapping_add_signed((off >> 16).wrapping_mul(rough as i32) >> 14)
}

/// `2^46 / m` to 14 bits, at most 2^16, for the same `m`.
#[inline(always)]
pub(super) fn rough(m: u32) -> u32 {
    let seed = SEEDS.get((m >> 23 & 127) as usize).map_or(256, |&seed| u32::from(seed) + 256);
    // r = 2^39 / m to 8 bits: 2^37 - (m/4) r is below 2^30.
    let off = (m >> 2).wrapping_mul(seed).wrapping_neg() as i32;
    (seed << 7).wrapping_add_signed((off >> 14).wrapping_mul(seed as i32) >> 16)
}

#[cfg(test)]
mod tests {
    #[test]
    fn reciprocals() {
        let mut worst = 0.0f64;
        for m in (1u32 << 30..1 << 31).step_by(9973).chain([(1 << 30) + 1, (1 << 31) - 1]) {
            let exact = 2f64.powi(61) / f64::from(m);
            let inverse = super::of(m);
            assert!(inverse <= 1 << 31);
            worst = worst.max((f64::from(inverse) / exact - 1.0).abs());
        }
        assert!(worst < 2f64.powi(-27), "{worst:e}");
    }
}

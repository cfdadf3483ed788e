//! Products that are wider than a register.

/// The squared magnitude, without overflow for any parts.
#[inline(always)]
pub const fn power(x: [i32; 2]) -> u64 {
    if cfg!(short_products) {
        // Without an instruction for the whole product a library would multiply all four pairs of halves.
        let (re, im) = (x[0].unsigned_abs(), x[1].unsigned_abs());
        let ([a, b], [c, d]) = ([re >> 16, re & 0xffff], [im >> 16, im & 0xffff]);
        // Upper halves are at most 2^15, so their sums of products fit.
        let (high, middle) = (a * a + c * c, a * b + c * d);
        let low = b.wrapping_mul(b) as u64 + d.wrapping_mul(d) as u64;
        return ((high as u64) << 32) + ((middle as u64) << 17) + low;
    }
    let [re, im] = [x[0] as i64, x[1] as i64];
    (re * re) as u64 + (im * im) as u64
}

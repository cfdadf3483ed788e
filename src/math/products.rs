//! Products wider than a register.

/// The squared magnitude; no parts overflow it.
#[inline(always)]
pub const fn power(x: [i32; 2]) -> u64 {
    if cfg!(short_products) {
        // A library multiplies all four pairs of halves if the core has no instruction for the
        // whole product.
        let (re, im) = (x[0].unsigned_abs(), x[1].unsigned_abs());
        let ([a, b], [c, d]) = ([re >> 16, re & 0xffff], [im >> 16, im & 0xffff]);
        // The upper halves are at most 2^15, so the sums of their products fit.
        let (high, middle) = (a * a + c * c, a * b + c * d);
        let low = b.wrapping_mul(b) as u64 + d.wrapping_mul(d) as u64;
        return ((high as u64) << 32) + ((middle as u64) << 17) + low;
    }
    let [re, im] = [x[0] as i64, x[1] as i64];
    (re * re) as u64 + (im * im) as u64
}

/// A sum plus the squared magnitude. One after the other the squares go into the sum without an instruction of their own.
#[inline(always)]
pub const fn plus_power(sum: u64, x: [i32; 2]) -> u64 {
    if cfg!(short_products) {
        return sum.wrapping_add(power(x));
    }
    let [re, im] = [x[0] as i64, x[1] as i64];
    sum.wrapping_add((re * re) as u64).wrapping_add((im * im) as u64)
}

//! The signal-to-noise ratio from the whole power spectrum, as FESA needs it.

use crate::math::scalar::Scalar;

/// The signal-to-noise ratio of a record by Parseval's theorem (Yang et al. 2011, eqs 11 to 13), as a power
/// ratio per sample, 1e-6..=1e12.
///
/// `power(k)` is `|X[k]|^2` for `k` in `0..n`, in any unit. The paper does not say which bins are noise. Here the bins farther than a
/// quarter of the record from the peak are, round the circle: `|k - peak| > n/4`. The tone's leakage into them bounds the answer: the error
/// is -26 dB at 60 dB for a tone between bins. This accuracy is enough to choose a lag, but not for a sigma.
///
/// Cost: N powers (2 N multiplications), N additions, 2 divisions.
pub fn parseval<T: Scalar>(n: usize, peak: i32, power: impl Fn(i32) -> T) -> T {
    let length = n as i32;
    let (mut total, mut noise, mut count) = (T::zero(), T::zero(), 0);
    let first = peak.wrapping_sub(length / 2);
    for distance in 0..length {
        let p = power(first.wrapping_add(distance).checked_rem_euclid(length).unwrap_or(0));
        total = total + p;
        if (distance - length / 2).abs() > length / 4 {
            noise = noise + p;
            count += 1;
        }
    }
    let noise = noise * T::from_i32(length) / T::from_i32(count.max(1));
    let (least, most) = (T::new(1e-6), T::new(1e12));
    if noise > T::zero() { ((total - noise) / noise).max(least).min(most) } else { most }
}

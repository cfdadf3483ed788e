//! The bins of a search.

use crate::frequency::Frequency;

/// Bins on each side of the peak that count as its skirt and not as noise.
pub const SKIRT: i32 = 8;

/// The bins that a search may return, both ends included, except for the bin of a constant offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Band {
    /// The first bin.
    pub low: i32,
    /// The last bin.
    pub high: i32,
    /// The bin into which a constant offset of the converter falls, which no search returns and no floor sums. It may lie outside.
    pub offset: i32,
}

impl Band {
    /// Bins `low..=high` of a record whose offset is in bin 0.
    pub const fn new(low: i32, high: i32) -> Self {
        Band { low, high, offset: 0 }
    }

    /// The whole spectrum of a real record without DC and Nyquist: bins 1..=N/2-1.
    pub const fn real(n: usize) -> Self {
        Band::new(1, n as i32 / 2 - 1)
    }

    /// The whole spectrum of an I/Q record: bins 0..=N-1, without a search at DC.
    pub const fn iq(n: usize) -> Self {
        Band::new(0, n as i32 - 1)
    }

    /// The number of bins, the bin of an offset included.
    pub const fn width(&self) -> u32 {
        if self.high < self.low { 0 } else { (self.high - self.low) as u32 + 1 }
    }

    /// Whether the band holds the bin of an offset.
    pub const fn has_offset(&self) -> bool {
        self.low <= self.offset && self.offset <= self.high
    }

    /// Whether a frequency is at most half a bin outside of the band, round the circle, in a record of `n` samples.
    pub fn holds(&self, frequency: Frequency, n: usize) -> bool {
        let half = (1i64 << 31) / n.max(1) as i64;
        let first = half.wrapping_mul(2 * i64::from(self.low) - 1);
        // The low 32 bits are the way round the circle.
        let past = i64::from(frequency.0.to_bits()).wrapping_sub(first) as u32;
        i64::from(past) <= half.wrapping_mul(2 * i64::from(self.width()))
    }
}

//! Values out of random bytes; what the bytes lack reads zero.

/// The bytes that are left.
pub struct Input<'a>(pub &'a [u8]);

impl Input<'_> {
    /// The next bytes.
    pub fn take<const L: usize>(&mut self) -> [u8; L] {
        let mut field = [0; L];
        let (used, rest) = self.0.split_at(L.min(self.0.len()));
        field[..used.len()].copy_from_slice(used);
        self.0 = rest;
        field
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let [byte] = self.take();
        byte
    }

    /// Any float.
    pub fn float(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    /// A float that a setting may have: a byte chooses between any float and a power of two.
    pub fn number(&mut self) -> f64 {
        match self.byte() {
            0 => self.float(),
            exponent => f64::from(self.byte()) * 2f64.powi(i32::from(exponent) - 128),
        }
    }
}

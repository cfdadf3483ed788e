//! Seeded random numbers for what is simulated on the page.

/// Marsaglia's xorshift, 64 bits (2003), and his polar normals.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
    /// A normal number that is left.
    spare: Option<f64>,
}

impl Random {
    /// A generator; seeds near each other begin apart.
    pub fn new(seed: u64) -> Self {
        Random { state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1, spare: None }
    }

    /// A number from 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        (self.state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A normal number.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // The loop ends: each round has a chance of 0.785.
        loop {
            let [x, y] = [0; 2].map(|_| 2.0 * self.share() - 1.0);
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                let stretch = libm::sqrt(-2.0 * libm::log(square) / square);
                self.spare = Some(y * stretch);
                return x * stretch;
            }
        }
    }
}

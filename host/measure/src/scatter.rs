//! Whether values scatter as their sigmas say.

/// Scatter and sigmas agree if they differ by less than this factor, or by less than this many deviations of the scatter itself.
const FACTOR: f64 = 1.2;
const DEVIATIONS: f64 = 4.0;

/// How many times as wide as their sigmas values scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// The factor.
    pub times: f64,
    degrees: f64,
}

impl Scatter {
    /// Of values whose deviations from their mean, each over its sigma, have this sum of squares. `None` of fewer than two.
    pub fn of(squares: f64, count: usize) -> Option<Self> {
        let degrees = count as f64 - 1.0;
        (degrees > 0.0).then(|| Self { times: (squares / degrees).sqrt(), degrees })
    }

    /// Whether that may be chance, or is too little to matter.
    pub fn agrees(&self) -> bool {
        // Wilson and Hilferty: the cube root of a chi-square is nearly normal.
        let part = 2.0 / (9.0 * self.degrees);
        let deviations = (self.times.powf(2.0 / 3.0) - 1.0 + part) / part.sqrt();
        (1.0 / FACTOR..=FACTOR).contains(&self.times) || deviations.abs() <= DEVIATIONS
    }
}

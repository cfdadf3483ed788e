//! Linear equations with a symmetric, positive matrix, by the matrix's Cholesky factor.

use crate::math::scalar::Scalar as _;

/// Rows of a square matrix; only the lower triangle counts.
pub type Rows<const M: usize> = [[f32; M]; M];

/// Cholesky's factor L of a matrix `S L L' S`, with the roots of its diagonal in S, so that columns of any size are alike.
#[derive(Clone, Debug)]
pub struct Factor<const M: usize> {
    lower: Rows<M>,
    /// The reciprocals of the diagonal of L, and of the diagonal of S.
    pivots: [f32; M],
    scales: [f32; M],
    /// The rows that count.
    count: usize,
}

/// The share of each diagonal element that is added, since single precision has no more digits.
const RIDGE: f32 = 1e-6;

impl<const M: usize> Factor<M> {
    /// The factor of an empty matrix.
    pub const NONE: Self =
        Self { lower: [[0.0; M]; M], pivots: [1.0; M], scales: [0.0; M], count: 0 };

    /// The factor of the first `count` rows of a matrix. Vectors are used up to this length, too.
    pub fn from_rows(rows: &Rows<M>, count: usize) -> Self {
        let mut factor = Self::NONE;
        factor.lower = *rows;
        factor.set(count);
        factor
    }

    /// The rows, to be filled before [`Factor::set`].
    pub fn rows(&mut self) -> &mut Rows<M> {
        &mut self.lower
    }

    /// Factors the first `count` of its rows.
    pub fn set(&mut self, count: usize) {
        self.count = M.min(count);
        let Self { lower, pivots, scales, count } = self;
        for (i, (row, scale)) in lower.iter().zip(scales.iter_mut()).take(*count).enumerate() {
            let own = row.get(i).copied().unwrap_or(0.0);
            *scale = if own > 1e-30 { 1.0 / own.root() } else { 0.0 };
        }
        for i in 0..*count {
            let Some((above, [row, ..])) = lower.split_at_mut_checked(i) else { break };
            let mine = scales.get(i).copied().unwrap_or(0.0);
            for (j, other) in above.iter().enumerate() {
                let theirs = scales.get(j).copied().unwrap_or(0.0);
                let pivot = pivots.get(j).copied().unwrap_or(0.0);
                if let Some((done, [value, ..])) = row.split_at_mut_checked(j) {
                    let sum: f32 = done.iter().zip(other).map(|(a, b)| a * b).sum();
                    *value = (*value * mine * theirs - sum) * pivot;
                }
            }
            let Some((done, [value, ..])) = row.split_at_mut_checked(i) else { break };
            let own = 1.0 + RIDGE - done.iter().map(|a| a * a).sum::<f32>();
            let root = own.max(RIDGE).root();
            *value = root;
            if let Some(pivot) = pivots.get_mut(i) {
                *pivot = 1.0 / root;
            }
        }
    }

    /// `L^-1 S^-1 v`: its square is `v' A^-1 v`.
    pub fn forward(&self, v: &[f32; M]) -> [f32; M] {
        let mut out = [0.0; M];
        for (i, row) in self.lower.iter().take(self.count).enumerate() {
            let at = |values: &[f32; M]| values.get(i).copied().unwrap_or(0.0);
            if let Some((done, [value, ..])) = out.split_at_mut_checked(i) {
                let sum: f32 = done.iter().zip(row).map(|(a, b)| a * b).sum();
                *value = (at(v) * at(&self.scales) - sum) * at(&self.pivots);
            }
        }
        out
    }

    /// `S^-1 L^-T v`: after [`Factor::forward`] the solution.
    pub fn backward(&self, v: &[f32; M]) -> [f32; M] {
        let mut rest = *v;
        for i in (0..self.count).rev() {
            let at = |values: &[f32; M]| values.get(i).copied().unwrap_or(0.0);
            let value = at(&rest) * at(&self.pivots);
            if let (Some(row), Some((done, left))) =
                (self.lower.get(i), rest.split_at_mut_checked(i))
            {
                for (rest, a) in done.iter_mut().zip(row) {
                    *rest -= a * value;
                }
                if let Some(last) = left.first_mut() {
                    *last = value;
                }
            }
        }
        for (i, value) in rest.iter_mut().enumerate() {
            let scale = self.scales.get(i).filter(|_| i < self.count);
            *value *= scale.copied().unwrap_or(0.0);
        }
        rest
    }

    /// The logarithm of the determinant of the first `count` rows.
    pub fn log_determinant(&self) -> f32 {
        let pivots = self.pivots.iter().zip(&self.scales).take(self.count);
        let logs = pivots.filter(|(_, scale)| **scale > 0.0);
        logs.map(|(pivot, scale)| -2.0 * (pivot * scale).log_e()).sum()
    }
}

/// The product of two vectors.
pub fn product<const M: usize>(a: &[f32; M], b: &[f32; M]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved() {
        let rows = [[4.0, 0.0, 0.0], [2.0, 9e6, 0.0], [0.0, 3e3, 5.0]];
        let factor = Factor::from_rows(&rows, 3);
        let x = factor.backward(&factor.forward(&[2.006, 33_001.0, 19.0]));
        for (x, exact) in x.into_iter().zip([0.5, 3e-3, 2.0]) {
            assert!((x - exact).abs() < 1e-4 * exact, "{x}");
        }
        let determinant = 4.0 * (9e6 * 5.0 - 9e6) - 2.0 * 10.0;
        assert!((factor.log_determinant() - libm::logf(determinant)).abs() < 1e-4);
    }
}

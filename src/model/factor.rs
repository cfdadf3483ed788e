//! Linear equations with a symmetric, positive matrix, by the matrix's Cholesky factor, which grows row by row.

use crate::math::scalar::{Scalar as _, larger};

/// Cholesky's factor of a matrix of at most `M` rows.
#[derive(Clone, Debug)]
pub struct Factor<const M: usize> {
    lower: [[f32; M]; M],
    /// The reciprocals of the diagonal.
    over: [f32; M],
    count: usize,
}

/// The share of each diagonal element that is added to it: single precision cannot resolve less.
const RIDGE: f32 = 1e-6;

impl<const M: usize> Factor<M> {
    /// The factor of an empty matrix.
    pub const fn new() -> Self {
        Self { lower: [[0.0; M]; M], over: [1.0; M], count: 0 }
    }

    /// Begins another matrix.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// The number of rows.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The reciprocals of the factor's diagonal.
    pub fn over(&self) -> &[f32; M] {
        &self.over
    }

    /// Adds a row: the products with the rows before, and on the diagonal `own` and a prior's precision.
    #[inline(always)]
    pub fn push(&mut self, own: f32, prior: f32, products: impl IntoIterator<Item = f32>) {
        let Self { lower, over, count } = self;
        let Some((above, [row, ..])) = lower.split_at_mut_checked(*count) else { return };
        row.iter_mut().zip(products).take(above.len()).for_each(|(cell, value)| *cell = value);
        let taken = forward(above, over, row);
        let left = own * (1.0 + RIDGE) + prior - taken;
        let root = larger(left, larger(RIDGE * own, 1e-30)).root();
        if let Some((cell, over)) = row.get_mut(*count).zip(over.get_mut(*count)) {
            (*cell, *over) = (root, 1.0 / root);
            *count += 1;
        }
    }

    /// `L^-1 v` in place; returns its square, `v' A^-1 v`.
    pub fn forward(&self, v: &mut [f32; M]) -> f32 {
        forward(self.lower.get(..self.count).unwrap_or_default(), &self.over, v)
    }

    /// `L^-T v` in place: after [`Factor::forward`] the solution.
    pub fn backward(&self, v: &mut [f32; M]) {
        let rows = self.lower.iter().zip(&self.over).enumerate().take(self.count);
        for (i, (row, over)) in rows.rev() {
            if let Some((done, [value, ..])) = v.split_at_mut_checked(i) {
                *value *= over;
                for (rest, a) in done.iter_mut().zip(row) {
                    *rest -= a * *value;
                }
            }
        }
    }

    /// The diagonal of the factor.
    pub fn diagonal(&self) -> impl Iterator<Item = f32> {
        self.lower.iter().enumerate().take(self.count).filter_map(|(i, row)| row.get(i).copied())
    }
}

/// Eliminates the rows of a factor from a vector.
#[inline(never)]
fn forward<const M: usize>(rows: &[[f32; M]], over: &[f32; M], v: &mut [f32; M]) -> f32 {
    let mut square = 0.0;
    for (i, (row, over)) in rows.iter().zip(over).enumerate() {
        if let Some((done, [value, ..])) = v.split_at_mut_checked(i) {
            let mut sum = *value;
            for (a, b) in done.iter().zip(row) {
                sum -= a * b;
            }
            *value = sum * over;
            square += *value * *value;
        }
    }
    square
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved() {
        let mut factor = Factor::<4>::new();
        for (row, own) in [([0.0; 2], 4.0), ([2.0, 0.0], 9.0), ([0.0, 3.0], 5.0)] {
            factor.push(own, 0.0, row);
        }
        let mut x = [2.0, 31.0, 19.0, 0.0];
        factor.forward(&mut x);
        factor.backward(&mut x);
        let rows = [[4.0, 2.0, 0.0], [2.0, 9.0, 3.0], [0.0, 3.0, 5.0]];
        for (row, y) in rows.iter().zip([2.0, 31.0, 19.0]) {
            let sum: f32 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((sum - y).abs() < 1e-4 * y, "{sum} {y}");
        }
        let determinant: f32 = factor.diagonal().map(|x| x * x).product();
        assert!((determinant - 124.0).abs() < 1e-2, "{determinant}");
    }
}

//! The joint fit: the tone with all causes found beside it.
//!
//! The model is linear in all strengths and changes, and nearly so in the frequencies. With C its columns, b the window's bins and T the
//! prior variances, each Gauss-Newton step solves
//!
//! ```text
//! (C' C + 1/T) s = C' b        covariance of s: (C' C + 1/T)^-1
//! ```
//!
//! whose entry for the tone's frequency is the variance of the offset. Columns without a prior have `1/T = 0`.

use super::constants::{LENGTHS, LINES, NEAR, SMOOTH, STEPS};
use super::factor::{Factor, product};
use super::line::{Bins, Line, changes};
use super::shape::{NOTHING, Shape, dot, take};
use super::window::Window;
use super::{leak, slow};
use crate::math::scalar::Scalar as _;
use num_complex::Complex;

/// The most columns: the tone's three with the columns of all lines, or of a level and a phase that both change, or of leakage. A cause
/// joins the fit only where there is room.
pub const COLUMNS: usize = 3 + 3 * LINES;

/// Another line, with the priors of its strength and of its offset.
#[derive(Clone, Copy, Debug)]
pub struct Other {
    /// The line.
    pub line: Line,
    /// The reciprocals of the prior variances: of the strength's parts, and of a step of the offset.
    pub precision: [f32; 2],
}

/// The tone and the causes kept beside it.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The tone.
    pub tone: Line,
    /// Other lines, the first `count` of them.
    pub others: [Other; LINES],
    /// The number of other lines.
    pub count: usize,
    /// The reciprocal of the prior variance of each order of the amplitude that changes.
    pub level: [Option<f32>; SMOOTH],
    /// The reciprocal of the prior variance of each order of the phase that changes.
    pub phase: [Option<f32>; SMOOTH],
    /// The changes of amplitude and phase, in parts of the tone and in radians.
    pub changes: [[f32; SMOOTH]; 2],
    /// The prior variance of the frequency that a wandering phase has within the record and that nothing shows, bins squared.
    pub hidden: f32,
    /// Whether slow terms are kept.
    pub slow: bool,
    /// Whether leakage is kept.
    pub leak: bool,
}

/// A fit's columns, and the posterior of their sizes, all linear. The struct is the memory in which a fit works.
#[derive(Debug)]
pub struct Solution {
    shapes: [Shape; COLUMNS],
    /// The reciprocal of the prior variance of each column.
    precision: [f32; COLUMNS],
    count: usize,
    factor: Factor<COLUMNS>,
    /// The posterior mean of the sizes.
    pub values: [f32; COLUMNS],
    /// The residual.
    pub left: Shape,
    /// The residual's energy with the priors taken into account.
    pub energy: f32,
    /// The residual's degrees of freedom.
    pub free: f32,
    /// The tone's frequency in the factor: the square of this vector is the variance.
    frequency: [f32; COLUMNS],
    hidden: f32,
}

impl Solution {
    /// A solution before any fit.
    pub const fn new() -> Self {
        Self {
            shapes: [NOTHING; COLUMNS],
            precision: [0.0; COLUMNS],
            count: 0,
            factor: Factor::NONE,
            values: [0.0; COLUMNS],
            left: NOTHING,
            energy: 0.0,
            free: 0.0,
            frequency: [0.0; COLUMNS],
            hidden: 0.0,
        }
    }

    fn add(&mut self, shape: &Shape, precision: f32) {
        let place = self.count;
        if let (Some(cell), Some(prior)) =
            (self.shapes.get_mut(place), self.precision.get_mut(place))
        {
            (*cell, *prior) = (*shape, precision);
            self.count += 1;
        }
    }

    fn shapes(&self) -> &[Shape] {
        self.shapes.get(..self.count).unwrap_or_default()
    }

    fn along(&self, shape: &Shape) -> [f32; COLUMNS] {
        let mut along = [0.0; COLUMNS];
        for (along, column) in along.iter_mut().zip(self.shapes()) {
            *along = dot(column, shape);
        }
        along
    }

    /// The variance of the offset in noise as loud as the ring.
    pub fn variance(&self) -> f32 {
        product(&self.frequency, &self.frequency) + self.hidden
    }

    /// The part of a further column that the fit cannot take: a vector whose products are to be subtracted from the products of the
    /// columns, and the effect of one unit of the column on the offset.
    pub fn taken(&self, column: &Shape) -> ([f32; COLUMNS], f32) {
        let taken = self.factor.forward(&self.along(column));
        let pull = product(&self.frequency, &taken);
        (taken, pull)
    }

    /// The logarithm by which the fit is less probable because of its flexibility, beyond the energy that it leaves.
    pub fn cost(&self) -> f32 {
        let priors = self.precision.iter().take(self.count).filter(|prior| **prior > 0.0);
        0.5 * (self.factor.log_determinant() - priors.map(|prior| prior.log_e()).sum::<f32>())
    }

    /// The number of the fit's parameters without a prior.
    pub fn fitted(&self, window: &Window) -> f32 {
        window.numbers() - self.free
    }
}

impl Joint {
    /// The tone alone, at `offset` bins from the peak.
    pub fn at(offset: f32) -> Self {
        let none = Other { line: Line::NONE, precision: [0.0; 2] };
        Self {
            tone: Line { offset, ..Line::NONE },
            others: [none; LINES],
            count: 0,
            level: [None; SMOOTH],
            phase: [None; SMOOTH],
            changes: [[0.0; SMOOTH]; 2],
            hidden: 0.0,
            slow: false,
            leak: false,
        }
    }

    /// The other lines.
    pub fn lines(&self) -> &[Other] {
        self.others.get(..self.count).unwrap_or_default()
    }

    /// Adds one more line at this distance from the tone, with a first strength.
    pub fn add(&mut self, distance: f32, value: Complex<f32>) {
        let strength = self.tone.value.norm_sqr().max(1e-30);
        let line = Line { offset: self.tone.offset + distance, value };
        if let Some(other) = self.others.get_mut(self.count) {
            *other = Other { line, precision: [1.0 / strength, 4.0 / (distance * distance)] };
            self.count += 1;
        }
    }

    /// The tone's phase.
    fn unit(&self) -> Complex<f32> {
        let size = self.tone.value.norm_sqr();
        if size > 0.0 { self.tone.value * (1.0 / size.root()) } else { Complex::new(1.0, 0.0) }
    }

    /// The changes that are kept.
    fn kept(&self) -> impl Iterator<Item = &f32> {
        self.level.iter().chain(&self.phase).flatten()
    }

    /// The number of columns.
    fn width(&self) -> usize {
        let slow = if self.slow { slow::TERMS } else { 0 };
        let leak = if self.leak { leak::TERMS } else { 0 };
        3 + self.kept().count() + 3 * self.count + slow + leak
    }

    /// Whether the columns fit into a [`Solution`].
    pub fn has_room(&self) -> bool {
        self.width() <= COLUMNS
    }

    #[inline(never)]
    fn columns(&self, window: &Window, columns: &mut Solution) {
        columns.count = 0;
        let bins = Bins::at(window, self.tone.offset);
        let [strength, mut turn, mut slope] = bins.columns_along(self.unit(), self.tone.value);
        for column in [&strength, &turn, &slope] {
            columns.add(column, 0.0);
        }
        if self.kept().next().is_some() {
            let mut places = [[None; SMOOTH]; 2];
            let priors = self.level.iter().chain(&self.phase);
            for (place, prior) in places.as_flattened_mut().iter_mut().zip(priors) {
                if let Some(prior) = prior {
                    *place = Some(columns.count);
                    columns.add(&NOTHING, *prior);
                }
            }
            let tone = &self.tone;
            let whole = [&mut turn, &mut slope];
            changes(window, tone, &self.changes, &mut columns.shapes, &places, whole);
            let [_, second, third, ..] = &mut columns.shapes;
            (*second, *third) = (turn, slope);
        }
        for Other { line, precision: [strength, place] } in self.lines() {
            let precisions = [*strength, *strength, *place];
            let shapes = Bins::at(window, line.offset).columns(line.value);
            shapes.iter().zip(precisions).for_each(|(shape, prior)| columns.add(shape, prior));
        }
        if self.slow {
            slow::columns(window).iter().for_each(|shape| columns.add(shape, 0.0));
        }
        if self.leak {
            leak::columns(window).iter().for_each(|shape| columns.add(shape, 0.0));
        }
    }

    /// Fits all strengths and changes, and a step of each frequency, to the window's bins times `scale`.
    #[inline(never)]
    pub fn solve(&self, window: &Window, scale: f32, solution: &mut Solution) {
        self.columns(window, solution);
        let Solution { shapes, precision, count, factor, .. } = &mut *solution;
        let shapes = shapes.get(..*count).unwrap_or_default();
        let rows = factor.rows().iter_mut();
        for (i, ((row, shape), prior)) in rows.zip(shapes).zip(precision).enumerate() {
            for (j, (cell, other)) in row.iter_mut().zip(shapes).take(i + 1).enumerate() {
                *cell = dot(shape, other) + if i == j { *prior } else { 0.0 };
            }
        }
        solution.factor.set(solution.count);
        for (left, bin) in solution.left.iter_mut().zip(&window.bins) {
            *left = bin * scale;
        }
        solution.values = [0.0; COLUMNS];
        // Once more on the residual: single precision needs a second pass where columns are much alike.
        for _ in 0..if solution.count > 3 { 2 } else { 1 } {
            let mut along = solution.along(&solution.left);
            let own = along.iter_mut().zip(&solution.values).zip(solution.precision);
            own.for_each(|((along, value), prior)| *along -= prior * value);
            let step = solution.factor.backward(&solution.factor.forward(&along));
            let Solution { values, shapes, left, count, .. } = solution;
            for ((value, step), shape) in values.iter_mut().zip(step).zip(shapes).take(*count) {
                *value += step;
                take(left, shape, step);
            }
        }
        let priors = solution.precision.iter().take(solution.count);
        let own = solution.values.iter().zip(priors.clone());
        solution.energy = dot(&solution.left, &solution.left)
            + own.map(|(value, prior)| prior * value * value).sum::<f32>();
        let unbound = priors.filter(|prior| **prior == 0.0).count();
        solution.free = (window.numbers() - unbound as f32).max(1.0);
        let mut third = [0.0; COLUMNS];
        let [_, _, place, ..] = &mut third;
        *place = 1.0;
        solution.frequency = solution.factor.forward(&third);
        solution.hidden = self.hidden;
    }

    /// Gauss-Newton steps on the frequencies, until a step is a fifth of the noise's effect. The solution belongs to the last step.
    #[inline(never)]
    pub fn fit(&mut self, window: &Window, scale: f32, steps: usize, solution: &mut Solution) {
        let mut current = false;
        for _ in 0..=steps.min(STEPS) {
            let known = self.tone.value.norm_sqr() > 0.0;
            self.solve(window, scale, solution);
            current = self.step(solution, known);
            if current {
                break;
            }
        }
        // Of two close lines the stronger one is the tone.
        for other in self.others.iter_mut().take(self.count) {
            let near = (other.line.offset - self.tone.offset).abs() < NEAR;
            if near && other.line.value.norm_sqr() > self.tone.value.norm_sqr() {
                core::mem::swap(&mut other.line, &mut self.tone);
                current = false;
            }
        }
        if !current {
            self.solve(window, scale, solution);
        }
    }

    /// Takes the step of a solution; returns whether the step was negligible. Without a strength a line has no slope yet.
    fn step(&mut self, solution: &Solution, known: bool) -> bool {
        /// The limit of a step in bins, and the limit of another line's step as a share of the distance.
        const STEP: f32 = 0.3;
        const SHARE: f32 = 0.5;
        /// The largest distance from the peak, bins.
        const FARTHEST: f32 = 1.2;
        /// The square of a step, over the variance, that ends the fit. The last solution includes the step, so the remaining error is of
        /// second order.
        const SETTLED: f32 = 4e-2;
        let [re, im, slope, rest @ ..] = solution.values;
        let (before, mut rest) = (self.tone.offset, rest.iter());
        let priors = self.level.iter().chain(&self.phase);
        let mut changes = self.changes;
        for (change, prior) in changes.as_flattened_mut().iter_mut().zip(priors) {
            if prior.is_some() {
                *change = rest.next().copied().unwrap_or(0.0);
            }
        }
        let lines = rest.as_slice().as_chunks().0;
        let mut moved = slope * slope / solution.variance().max(1e-30);
        for (other, values) in self.others.iter().take(self.count).zip(lines) {
            let &[_, _, slope]: &[f32; 3] = values;
            moved = moved.max(slope * slope * other.line.value.norm_sqr());
        }
        let strength = self.tone.value.norm_sqr();
        let orders = changes.as_flattened().iter().zip(self.changes.as_flattened());
        let lengths = LENGTHS.iter().skip(1).take(SMOOTH).cycle();
        for ((after, before), length) in orders.zip(lengths) {
            let step = (after - before) / length;
            moved = moved.max(step * step * strength);
        }
        if known && moved < SETTLED {
            return true;
        }
        self.changes = changes;
        self.tone.value = self.unit() * Complex::new(re, im);
        let go = |offset: f32, step: f32, most: f32| {
            if known { offset + step.clamp(-most, most) } else { offset }
        };
        self.tone.offset = go(before, slope, STEP).clamp(-FARTHEST, FARTHEST);
        for (other, values) in self.others.iter_mut().take(self.count).zip(lines) {
            let &[re, im, slope] = values;
            other.line.value = Complex::new(re, im);
            let most = ((other.line.offset - self.tone.offset).abs() * SHARE).min(STEP);
            other.line.offset = go(other.line.offset, slope, most);
        }
        false
    }
}

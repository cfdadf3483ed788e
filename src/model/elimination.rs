//! The lines beside the tone eliminated from the bins: what is left is nine numbers of the tone's envelope.
//!
//! Columns are real and sizes complex, so one matrix of products serves amplitude and phase. With B the lines' columns, F the envelope's
//! and y the bins, the normal equations of the envelope c beside the best lines are `S c = b` with `S = F'F - F'B (B'B)^-1 B'F` and
//! `b = F'y - F'B (B'B)^-1 B'y`.

use super::columns::{Envelopes, Line};
use super::constants::{LINES, P, WIDTH};
use super::factor::Factor;
use super::shape::{Orders, Shape, ZERO};

/// The most columns of lines: each has its strength and its place.
pub const COLUMNS: usize = 2 * LINES;

/// Sizes of the lines' columns, real and imaginary parts.
pub type Sizes = [[f32; COLUMNS]; 2];

/// The columns, their products, and the lines' factor.
#[derive(Debug)]
pub struct Elimination {
    /// The envelope's columns.
    pub envelopes: Envelopes,
    /// The lines' columns.
    pub lines: [Line; LINES],
    /// The products of the envelope's columns.
    gram: [[f32; P]; P],
    factor: Factor<COLUMNS>,
    /// The envelope's products with the lines, whitened.
    beside: [[f32; COLUMNS]; P],
    /// The lines' products with the bins, whitened.
    values: Sizes,
    /// What is left of the products of the envelope's columns: S.
    pub schur: [[f32; P]; P],
    /// What is left of the envelope's products with the bins: b.
    pub seen: Orders,
    /// The factor of S.
    pub white: Factor<P>,
}

impl Elimination {
    /// Room for columns.
    pub const fn new() -> Self {
        Self {
            envelopes: [[0.0; P]; WIDTH],
            lines: [[[0.0; 2]; WIDTH]; LINES],
            gram: [[0.0; P]; P],
            factor: Factor::new(),
            beside: [[0.0; COLUMNS]; P],
            values: [[0.0; COLUMNS]; 2],
            schur: [[0.0; P]; P],
            seen: Orders::ZERO,
            white: Factor::new(),
        }
    }

    /// Computes the products of the envelope's columns, nine at a time.
    #[inline(never)]
    pub fn refer(&mut self) {
        let Self { envelopes, gram, .. } = self;
        for (a, rows) in (0..).zip(gram.as_chunks_mut::<3>().0) {
            for b in 0..=a {
                let products = square(envelopes, a, b);
                for (row, products) in rows.iter_mut().zip(products) {
                    if let Some(cells) = row.as_chunks_mut::<3>().0.get_mut(b) {
                        *cells = products;
                    }
                }
            }
        }
        // The matrix is symmetric.
        for p in 1..P {
            let Some((above, [row, ..])) = gram.split_at_mut_checked(p) else { break };
            for (above, cell) in above.iter_mut().zip(row) {
                if let Some(other) = above.get_mut(p) {
                    *other = *cell;
                }
            }
        }
    }

    /// Factors the products of the first lines, whose columns have been computed. `priors` are the precisions of strength and place of each.
    #[inline(never)]
    pub fn eliminate(&mut self, priors: &[[f32; 2]]) {
        let Self { lines, factor, .. } = self;
        factor.clear();
        for (l, (line, &[strength, place])) in lines.iter().zip(priors).enumerate() {
            let mut products = [[0.0; COLUMNS]; 2];
            let [values, slopes] = &mut products;
            let cells = values.as_chunks_mut::<2>().0.iter_mut().zip(slopes.as_chunks_mut::<2>().0);
            for (other, (values, slopes)) in lines.iter().zip(cells).take(l + 1) {
                for ([a, b], [c, d]) in line.iter().zip(other) {
                    values[0] += a * c;
                    values[1] += a * d;
                    slopes[0] += b * c;
                    slopes[1] += b * d;
                }
            }
            let own = |row: &[f32; COLUMNS], at: usize| row.get(at).copied().unwrap_or(0.0);
            let diagonal = [own(values, 2 * l), own(slopes, 2 * l + 1)];
            factor.push(diagonal[0], strength, *values);
            factor.push(diagonal[1], place, *slopes);
        }
    }

    /// Computes the products of the first `O` orders with the lines, and what is left of the orders' own products.
    #[inline(never)]
    pub fn reduce<const O: usize>(&mut self) {
        let Self { envelopes, lines, gram, factor, beside, schur, .. } = self;
        let count = factor.count();
        if count == 0 {
            *schur = *gram;
            return;
        }
        for (l, line) in lines.iter().enumerate().take(count / 2) {
            let mut sums = [[0.0; O]; 2];
            for (row, [value, slope]) in envelopes.iter().zip(line) {
                let [along, place] = &mut sums;
                for ((along, place), order) in along.iter_mut().zip(place).zip(row) {
                    *along += value * order;
                    *place += slope * order;
                }
            }
            let [along, place] = sums;
            for ((row, along), place) in beside.iter_mut().zip(along).zip(place) {
                if let Some([a, b]) = row.as_chunks_mut::<2>().0.get_mut(l) {
                    (*a, *b) = (along, place);
                }
            }
        }
        for row in beside.iter_mut().take(O) {
            factor.forward(row);
        }
        for ((row, own), mine) in schur.iter_mut().zip(&*gram).zip(&*beside).take(O) {
            for ((cell, own), theirs) in row.iter_mut().zip(own).zip(&*beside).take(O) {
                let taken: f32 = mine.iter().zip(theirs).take(count).map(|(a, b)| a * b).sum();
                *cell = own - taken;
            }
        }
    }

    /// Computes the products with the bins: those of the lines, whitened, and what is left of those of the first `O` orders.
    #[inline(never)]
    pub fn see<const O: usize>(&mut self, bins: &Shape) {
        let Self { envelopes, lines, factor, beside, values, seen, .. } = self;
        let count = factor.count();
        let [re, im] = values;
        let cells = re.as_chunks_mut::<2>().0.iter_mut().zip(im.as_chunks_mut::<2>().0);
        for (line, (re, im)) in lines.iter().zip(cells).take(count / 2) {
            let (mut along, mut place) = (ZERO, ZERO);
            for ([value, slope], bin) in line.iter().zip(bins) {
                along += bin * *value;
                place += bin * *slope;
            }
            (*re, *im) = ([along.re, place.re], [along.im, place.im]);
        }
        factor.forward(re);
        factor.forward(im);
        *seen = products::<O>(envelopes, bins);
        for (seen, values) in [(&mut seen.re, &*re), (&mut seen.im, &*im)] {
            for (seen, beside) in seen.iter_mut().zip(&*beside).take(O) {
                for (a, value) in beside.iter().zip(values).take(count) {
                    *seen -= a * value;
                }
            }
        }
    }

    /// The sizes of the lines beside this envelope, of which `O` orders count.
    #[inline(never)]
    pub fn sizes<const O: usize>(&self, envelope: &Orders) -> Sizes {
        let mut sizes = self.values;
        let count = self.factor.count();
        if count > 0 {
            for (sizes, parts) in sizes.iter_mut().zip([&envelope.re, &envelope.im]) {
                for (c, beside) in parts.iter().zip(&self.beside).take(O) {
                    for (a, size) in beside.iter().zip(&mut *sizes).take(count) {
                        *size -= a * c;
                    }
                }
                self.factor.backward(sizes);
            }
        }
        sizes
    }

    /// The residual of the bins.
    #[inline(never)]
    pub fn left(&self, envelope: &Orders, [re, im]: &Sizes, bins: &Shape, left: &mut Shape) {
        *left = *bins;
        for (left, row) in left.iter_mut().zip(&self.envelopes) {
            for ((order, re), im) in row.iter().zip(&envelope.re).zip(&envelope.im) {
                left.re -= re * order;
                left.im -= im * order;
            }
        }
        let sizes = re.as_chunks::<2>().0.iter().zip(im.as_chunks::<2>().0);
        for (line, ([a, c], [b, d])) in self.lines.iter().zip(sizes).take(self.factor.count() / 2) {
            for (left, [value, slope]) in left.iter_mut().zip(line) {
                left.re -= a * value + c * slope;
                left.im -= b * value + d * slope;
            }
        }
    }

    /// The factor of what is left of the first `O` orders' products.
    #[inline(never)]
    pub fn whiten<const O: usize>(&mut self) {
        let Self { schur, white, .. } = self;
        white.clear();
        for (p, row) in schur.iter().enumerate().take(O) {
            white.push(row.get(p).copied().unwrap_or(0.0), 0.0, *row);
        }
    }

    /// The share of each order's square that lines and lower orders leave; 1 without lines.
    pub fn shares(&self) -> [f32; P] {
        let mut shares = [1.0; P];
        if self.factor.count() > 0 {
            let own = self.gram.iter().enumerate().filter_map(|(p, row)| row.get(p));
            for (share, (root, own)) in shares.iter_mut().zip(self.white.diagonal().zip(own)) {
                *share = if root * root < *own { root * root / own } else { 1.0 };
            }
        }
        shares
    }

    /// These products with the orders, whitened in place; returns their energy.
    pub fn whitened(&self, products: &mut Orders) -> f32 {
        self.white.forward(&mut products.re) + self.white.forward(&mut products.im)
    }

    /// A further column: its products with the lines and the first two orders, whitened, in the lines' order, then the orders'.
    #[inline(never)]
    pub fn taken(&self, column: &Line) -> Taken {
        let mut taken = Taken { lines: [0.0; COLUMNS], orders: [0.0; P], own: 0.0 };
        let Taken { lines, orders, own } = &mut taken;
        for [value, _] in column {
            *own += value * value;
        }
        let count = self.factor.count();
        for (line, cell) in self.lines.iter().zip(lines.as_chunks_mut::<2>().0).take(count / 2) {
            let [along, place] = cell;
            for ([value, slope], [column, _]) in line.iter().zip(column) {
                *along += value * column;
                *place += slope * column;
            }
        }
        *own -= self.factor.forward(lines);
        let [zeroth, first, ..] = orders;
        for ([a, b, ..], [column, _]) in self.envelopes.iter().zip(column) {
            *zeroth += a * column;
            *first += b * column;
        }
        for (order, beside) in orders.iter_mut().zip(&self.beside).take(2) {
            *order -= beside.iter().zip(&*lines).take(count).map(|(a, b)| a * b).sum::<f32>();
        }
        self.white.forward(orders);
        let [zeroth, ..] = orders;
        *own -= *zeroth * *zeroth;
        taken
    }
}

/// What the lines and the tone take of a further column.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    lines: [f32; COLUMNS],
    orders: [f32; P],
    /// The column's square beside the lines and the tone's strength.
    pub own: f32,
}

impl Taken {
    /// The part along the tone's frequency.
    pub fn first(&self) -> f32 {
        let [_, first, ..] = self.orders;
        first
    }

    /// What is taken of the product of two columns.
    pub fn product(&self, other: &Self) -> f32 {
        let lines: f32 = self.lines.iter().zip(&other.lines).map(|(a, b)| a * b).sum();
        let ([a, b, ..], [c, d, ..]) = (self.orders, other.orders);
        lines + a * c + b * d
    }
}

/// The products of three orders with three others.
#[inline(always)]
fn square(rows: &Envelopes, a: usize, b: usize) -> [[f32; 3]; 3] {
    let mut sums = [[0.0; 3]; 3];
    for row in rows {
        let (chunks, _) = row.as_chunks::<3>();
        let (Some(left), Some(right)) = (chunks.get(a), chunks.get(b)) else { break };
        for (sums, left) in sums.iter_mut().zip(left) {
            for (sum, right) in sums.iter_mut().zip(right) {
                *sum += left * right;
            }
        }
    }
    sums
}

/// The products of the first `O` orders with bins.
#[inline(always)]
pub fn products<const O: usize>(envelopes: &Envelopes, bins: &Shape) -> Orders {
    let mut sums = Orders::ZERO;
    let ([mut re, mut im], Orders { re: all, im: other }) = ([[0.0; O]; 2], &mut sums);
    for (row, bin) in envelopes.iter().zip(bins) {
        for ((order, re), im) in row.iter().zip(&mut re).zip(&mut im) {
            *re += order * bin.re;
            *im += order * bin.im;
        }
    }
    all.iter_mut().zip(re).for_each(|(cell, sum)| *cell = sum);
    other.iter_mut().zip(im).for_each(|(cell, sum)| *cell = sum);
    sums
}

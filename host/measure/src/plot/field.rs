//! A quantity over an area, as shades of grey behind a chart's lines.

use plotters::prelude::*;

/// Shades there are; the lightest is not drawn.
pub const SHADES: u8 = 24;

/// Cells of equal size over a rectangle of a chart.
#[derive(Clone, Debug)]
pub struct Field {
    /// The left and the right end.
    pub x: (f64, f64),
    /// The lower and the upper end.
    pub y: (f64, f64),
    /// Cells in a column.
    pub rows: usize,
    /// A shade for every cell, below [`SHADES`]: column by column from the left, each from below.
    pub shades: Vec<u8>,
}

/// A rectangle of one shade, by two of its corners.
type Patch = ([(f64, f64); 2], RGBColor);

impl Field {
    /// Cells of one shade that lie side by side in a row become one rectangle, so that a picture in lines stays small.
    pub fn patches(&self) -> Vec<Patch> {
        let columns = self.shades.len() / self.rows.max(1);
        let place = |ends: (f64, f64), index: usize, count: usize| {
            ends.0 + (ends.1 - ends.0) * index as f64 / count.max(1) as f64
        };
        let mut patches = Vec::new();
        for row in 0..self.rows {
            let shade = |column: usize| self.shades[column * self.rows + row];
            let (low, high) = (place(self.y, row, self.rows), place(self.y, row + 1, self.rows));
            let mut from = 0;
            for column in 1..=columns {
                if column < columns && shade(column) == shade(from) {
                    continue;
                }
                if shade(from) > 0 {
                    let (left, right) =
                        (place(self.x, from, columns), place(self.x, column, columns));
                    patches.push(([(left, low), (right, high)], colour(shade(from))));
                }
                from = column;
            }
        }
        patches
    }
}

/// From the paper's white to a grey that lines of any colour stand out from.
fn colour(shade: u8) -> RGBColor {
    let depth = f64::from(shade.min(SHADES - 1)) / f64::from(SHADES - 1);
    let part = |end: f64| (255.0 + (end - 255.0) * depth).round() as u8;
    RGBColor(part(70.0), part(78.0), part(92.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_are_one_patch_and_the_lightest_none() {
        // Three columns of two rows.
        let shades = vec![0, 5, 3, 5, 3, 0];
        let field = Field { x: (0.0, 3.0), y: (10.0, 20.0), rows: 2, shades };
        let patches = field.patches();
        assert_eq!(patches.len(), 2);
        assert_eq!(patches[0].0, [(1.0, 10.0), (3.0, 15.0)]);
        assert_eq!(patches[1].0, [(0.0, 15.0), (2.0, 20.0)]);
        assert_eq!(colour(0), RGBColor(255, 255, 255));
    }
}

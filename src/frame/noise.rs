//! The noise around a target: the cells around it, in both directions, less the echoes.

use super::echo::Echo;
use super::map::{EMPTY, Map};
use crate::math::series::circle;
use crate::tone::noise::Noise;
use crate::tone::noise::quietest::quietest;
use heapless::Vec;
use num_complex::Complex;

/// Columns on each side, and rows on each side.
const COLUMNS: i32 = 10;
const ROWS: i32 = 8;

/// The column of a target and its neighbours are left out: the fit has taken some of their noise.
const LEFT_OUT: i32 = 1;

/// Columns that are looked at.
const MOST: usize = 2 * (COLUMNS - LEFT_OUT) as usize;

/// The mean power of a cell of noise around an echo with this walk; `None` where no cell is free.
pub(super) fn beside(map: &Map, echo: &Echo) -> Option<Noise> {
    let plan = map.plan;
    let chirps = plan.chirps as i32;
    // All rows of a frame of few chirps, once.
    let rows = (2 * ROWS + 1).min(chirps);
    let mut means = Vec::<f32, MOST>::new();
    let mut column = EMPTY;
    let (mut low, mut high) = (LEFT_OUT + 1, COLUMNS);
    // Where the band ends on one side, the other lends columns.
    let free = |away: i32| map.keeps(echo.peak + away);
    while !free(-high) && high > low {
        high -= 1;
    }
    let lent = COLUMNS - high;
    low = -high;
    let high = COLUMNS + lent;
    for away in low..=high {
        if away.abs() <= LEFT_OUT || !free(away) {
            continue;
        }
        map.column(echo.peak + away, echo.walk, &mut column);
        let mut sum = 0.0;
        for row in 0..rows {
            let row = echo.row - rows / 2 + row;
            let (step, mut turn) = (circle::<f32>(-row, chirps), Complex::new(1.0, 0.0));
            let mut value = Complex::new(0.0, 0.0);
            for cell in column.iter().take(plan.chirps) {
                value += cell * turn;
                turn *= step;
            }
            sum += value.norm_sqr();
        }
        if means.push(sum / (rows * chirps) as f32).is_err() {
            break;
        }
    }
    quietest(&mut means, rows as f32)
}

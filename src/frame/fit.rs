//! The echo of one target by two fits of a tone: over the samples of a chirp, and over the chirps.
//!
//! The sum over the chirps, each turned back by the target's turn, is a chirp's record of length `n`, and its tone is the beat. The sum over
//! the bins, each weighed as the beat fills it, is an I/Q record of as many values as there are chirps, and its tone is the turn from chirp
//! to chirp. About the middles of frame and chirps the two frequencies are uncorrelated. Each record is that of the cells less all echoes,
//! and this echo as a pure tone in addition: so walks, bends and mirror images are removed exactly once the fit has settled.

use super::echo::{Echo, Share, kernel};
use super::map::{CHIRPS, Column, EMPTY, Map};
use crate::acquire::sample::Iq;
use crate::math::scalar::{Scalar as _, nearest};
use crate::math::series::circle;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::tone::fit::{Fit, FitStart, fit_bins};
use core::f32::consts::FRAC_1_PI;
use num_complex::Complex;

/// Bins on each side of the beat that are read.
pub(super) const REACH: i32 = 16;
const WIDTH: usize = 2 * REACH as usize + 1;

/// Taps on each side by which a part of a bin's walk is taken out.
const TAPS: i32 = 4;

/// Bins: those of the window, and the taps next to it.
const READ: i32 = REACH + TAPS;

/// The most turns of a curve: a fit sees about a radian of it, and a search from the middle no more.
const MOST_CURVE: f32 = 2.0;

/// The result of both fits, of an echo whose amplitude is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    pub echo: Echo,
    pub beat: Fit<f32>,
    pub turn: Fit<f32>,
    /// The energy of a line of amplitude 1 in the cells that were read.
    pub energy: f32,
    /// How far the fits moved beat and turn, in bins.
    pub moved: [f32; 2],
}

/// The two records of an echo, without the echo itself.
struct Records {
    /// The sum over the bins, for each chirp; the sum over the chirps, for each bin.
    turn: Column,
    beat: [Complex<f32>; WIDTH],
    /// The energy in each chirp.
    energy: f32,
}

impl Map<'_> {
    /// Fits an echo to the cells less all other echoes, which the map holds; the echo itself is not among them. `first` is true if only the
    /// echo's place is known.
    pub fn fit(&self, echo: &Echo, first: bool) -> Option<Fitted> {
        let plan = self.plan;
        let chirps = plan.chirps;
        let records = self.records(echo);
        // The amplitude: the mean over the chirps, turned back; and what the curve still lacks.
        let mut phases = Echo { curve: 0.0, ..*echo }.phases(plan);
        let (mut sum, mut curved) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for (chirp, value) in records.turn.iter().take(chirps).enumerate() {
            let back = value * phases.next().conj();
            let x = plan.place(chirp) / chirps as f32;
            sum += back;
            curved += back * (x * x - 1.0 / 12.0);
        }
        let amplitude = sum / chirps as f32;
        // The mean of (x^2 - 1/12)^2 is 1/180.
        let lacks = (curved * sum.conj()).im / sum.norm_sqr().max(f32::MIN_POSITIVE);
        let curve = (echo.curve + 180.0 * 0.5 * FRAC_1_PI * lacks).clamp(-MOST_CURVE, MOST_CURVE);
        let usual = |offset: f32| if first { FitStart::Usual } else { FitStart::From(offset, 2) };
        // Over the chirps.
        let half = ((chirps as i32 - 1) / 2).min(REACH);
        let mut bins = [Complex::new(0.0, 0.0); WIDTH];
        for (place, bin) in bins.iter_mut().take(2 * half as usize + 1).enumerate() {
            let row = echo.row - half + place as i32;
            let (step, mut turn) = (circle::<f32>(-row, chirps as i32), Complex::new(1.0, 0.0));
            for value in records.turn.iter().take(chirps) {
                *bin += value * turn;
                turn *= step;
            }
        }
        let bins = bins.get(..2 * half as usize + 1)?;
        let around = Bins::<f32, Iq, Rectangular>::from_middle(chirps, echo.row, bins);
        let turn = fit_bins(&around, half as usize, usual(echo.turn))?;
        // Over the samples: from the phase of the middle to that of the first sample.
        let mut bins = records.beat;
        for (place, bin) in bins.iter_mut().enumerate() {
            let i = place as i32 - REACH;
            let turn = circle::<f32>(i, 2 * plan.n as i32);
            *bin = *bin * turn * if i & 1 == 0 { 1.0 } else { -1.0 };
        }
        let around = Bins::<f32, Iq, Rectangular>::from_middle(plan.n, echo.peak, &bins);
        let beat = fit_bins(&around, REACH as usize, usual(echo.offset))?;
        let moved = [beat.offset - echo.offset, turn.offset - echo.turn];
        let mut next = Echo { offset: beat.offset, turn: turn.offset, amplitude, curve, ..*echo };
        next.centre(chirps as i32);
        next.move_on(plan);
        Some(Fitted { echo: next, beat, turn, energy: records.energy * chirps as f32, moved })
    }

    /// The records of an echo, from cells without all other echoes.
    fn records(&self, echo: &Echo) -> Records {
        let plan = self.plan;
        let walks = echo.walk.abs() * plan.chirps as f32 > 0.05;
        let mut records =
            Records { turn: EMPTY, beat: [Complex::new(0.0, 0.0); WIDTH], energy: 0.0 };
        let mut column = EMPTY;
        let reach = if walks { READ } else { REACH };
        let start = echo.phases(plan);
        // Of an echo that walks, its own share is subtracted from the cells and put back as a pure tone.
        for away in -reach..=reach {
            let bin = echo.peak + away;
            self.column(bin, if walks { echo.walk } else { 0.0 }, &mut column);
            let mut phases = start;
            let share = Share::new(echo, plan, |place| echo.line(plan, bin, place));
            let image = |here: i32, place: f32| echo.image(plan, here, place);
            let mirror =
                if plan.iq { None } else { Share::new(echo, plan, |place| image(bin, place)) };
            for (chirp, (cell, sum)) in
                column.iter().zip(&mut records.turn).take(plan.chirps).enumerate()
            {
                let (place, phase) = (plan.place(chirp), phases.next());
                let jump = if walks { nearest(echo.walk * place) } else { 0.0 };
                let here = bin.wrapping_add(jump as i32);
                let line =
                    share.map_or_else(|| echo.line(plan, here, place), |share| share.at(place));
                let kept = self.keeps(here);
                // The mirror image of a real record.
                let mut cell = *cell;
                if !plan.iq && kept {
                    let turned = (echo.amplitude * phase).conj();
                    cell -=
                        turned * mirror.map_or_else(|| image(here, place), |share| share.at(place));
                }
                let rest = if kept {
                    cell - echo.amplitude * phase * line
                } else {
                    Complex::new(0.0, 0.0)
                };
                if away.abs() <= REACH && kept {
                    *sum += rest * line.conj();
                    records.energy += line.norm_sqr();
                }
                // The part of a bin that the jump leaves.
                let part = if walks { echo.walk * place - jump } else { 0.0 };
                let back = rest * phase.conj() / plan.chirps as f32;
                if part.abs() < 1e-3 {
                    add(&mut records.beat, away, back);
                } else {
                    // sin(pi (tap + part)) / (pi (tap + part)), whose sines differ in sign alone.
                    let sine = f32::unit(0.5 * part).im * FRAC_1_PI;
                    for tap in -TAPS..=TAPS {
                        let sine = if tap & 1 == 0 { sine } else { -sine };
                        add(&mut records.beat, away + tap, back * (sine / (tap as f32 + part)));
                    }
                }
            }
        }
        records.energy /= plan.chirps as f32;
        let unit = 1.0 / records.energy.max(f32::MIN_POSITIVE);
        let straight = Echo { curve: 0.0, ..*echo };
        let (mut phases, mut curves) = (straight.phases(plan), echo.curves(plan));
        for value in records.turn.iter_mut().take(plan.chirps) {
            *value = *value * unit * curves.next().conj() + echo.amplitude * phases.next();
        }
        for (place, bin) in records.beat.iter_mut().enumerate() {
            *bin += echo.amplitude * kernel(plan.n, place as i32 - REACH, echo.offset, 0.0);
        }
        records
    }

    /// The evidence for an echo of another velocity: the power of the cells along it, over that of a line of amplitude 1. All other echoes are
    /// subtracted from the cells.
    pub fn along(&self, echo: &Echo) -> f32 {
        let plan = self.plan;
        let start = echo.phases(plan);
        let mut column = EMPTY;
        let (mut sum, mut energy) = (Complex::new(0.0, 0.0), 0.0);
        for away in -REACH..=REACH {
            let bin = echo.peak + away;
            self.column(bin, echo.walk, &mut column);
            let mut phases = start;
            for (chirp, cell) in column.iter().take(plan.chirps).enumerate() {
                let (place, phase) = (plan.place(chirp), phases.next());
                let here = bin.wrapping_add(nearest(echo.walk * place) as i32);
                let line = echo.line(plan, here, place);
                if self.keeps(here) {
                    sum += cell * (line * phase).conj();
                    energy += line.norm_sqr();
                }
            }
        }
        sum.norm_sqr() / energy.max(f32::MIN_POSITIVE)
    }
}

impl Echo {
    /// Keeps both rests within half a bin.
    pub fn centre(&mut self, chirps: i32) {
        let whole = nearest(self.offset);
        self.peak += whole as i32;
        self.offset -= whole;
        let whole = nearest(self.turn);
        self.row += whole as i32;
        self.turn -= whole;
        // A whole turn is an alias.
        let half = chirps / 2;
        if self.row >= half {
            (self.row, self.alias) = (self.row - chirps, self.alias + 1);
        } else if self.row < -half {
            (self.row, self.alias) = (self.row + chirps, self.alias - 1);
        }
    }
}

fn add(bins: &mut [Complex<f32>; WIDTH], away: i32, value: Complex<f32>) {
    if let Some(bin) = usize::try_from(away + REACH).ok().and_then(|place| bins.get_mut(place)) {
        *bin += value;
    }
}

const _: () = assert!(CHIRPS >= WIDTH);

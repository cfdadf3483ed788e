//! The cells less the background and the echoes found so far.

use super::cells::Store;
use super::echo::{Echo, Share, kernel};
use super::plan::FramePlan;
use crate::math::scalar::{Scalar as _, nearest};
use crate::math::series::circle;
use heapless::Vec;
use num_complex::Complex;

/// The most targets of a frame.
pub const TARGETS: usize = 8;

/// The most chirps.
pub(super) const CHIRPS: usize = 256;

/// A bin over the chirps.
pub(super) type Column = [Complex<f32>; CHIRPS];

/// A column of zeros.
pub(super) const EMPTY: Column = [Complex::new(0.0, 0.0); CHIRPS];

/// A frame, and the echoes found in it so far.
pub(super) struct Map<'a> {
    pub plan: &'a FramePlan,
    pub store: &'a Store<'a>,
    /// The mean over the chirps of a frame without targets, for each bin; empty without one.
    pub background: &'a [Complex<f32>],
    pub echoes: Vec<Echo, TARGETS>,
}

impl Map<'_> {
    /// The factor that turns a cell of this bin into codes with the phase of the record's middle.
    fn twist(&self, bin: i32) -> Complex<f32> {
        let unit = f32::two_to(self.store.filled.exponent);
        let unit = if bin & 1 == 0 { unit } else { -unit };
        circle::<f32>(-bin, 2 * self.plan.n as i32) * unit
    }

    /// A cell less the background, as it is stored; 0 for a bin that is not kept.
    fn cell(&self, bin: i32, chirp: usize) -> Complex<f32> {
        let place = bin.wrapping_sub(self.plan.first);
        let [re, im] = self.store.get(place, chirp);
        let cell = Complex::new(re, im);
        let still = usize::try_from(place).ok().and_then(|place| self.background.get(place));
        still.map_or(cell, |still| cell - still * f32::two_to(-self.store.filled.exponent))
    }

    /// A bin over the chirps, less the echoes. Where a beat walks, by `walk` bins a chirp, the bin goes with it, to the nearest whole one.
    pub fn column(&self, bin: i32, walk: f32, column: &mut Column) {
        let plan = self.plan;
        let still = walk.abs() * (plan.chirps as f32) < 1.0;
        let at = |chirp: usize| {
            let jump = if still { 0 } else { nearest(walk * plan.place(chirp)) as i32 };
            bin.wrapping_add(jump)
        };
        if still && !self.keeps(bin) {
            column.iter_mut().take(plan.chirps).for_each(|cell| *cell = Complex::new(0.0, 0.0));
            return;
        }
        let (mut twisted, mut twist) = (bin, self.twist(bin));
        for (chirp, cell) in column.iter_mut().take(plan.chirps).enumerate() {
            let here = at(chirp);
            if here != twisted {
                (twisted, twist) = (here, self.twist(here));
            }
            *cell = self.cell(here, chirp) * twist;
        }
        // An echo that is put aside has no amplitude.
        for echo in self.echoes.iter().filter(|echo| echo.amplitude.norm_sqr() > 0.0) {
            let mut phases = echo.phases(plan);
            let line = |bin: i32, place: f32| echo.line(plan, bin, place);
            let image = |bin: i32, place: f32| echo.image(plan, bin, place);
            let (mut line_here, mut image_here) = (None, None);
            if still {
                line_here = Share::new(echo, plan, |place| line(bin, place));
                if !plan.iq {
                    image_here = Share::new(echo, plan, |place| image(bin, place));
                }
            }
            for (chirp, cell) in column.iter_mut().take(plan.chirps).enumerate() {
                let here = at(chirp);
                let turned = echo.amplitude * phases.next();
                if !self.keeps(here) {
                    continue;
                }
                let place = plan.place(chirp);
                let line = line_here.map_or_else(|| line(here, place), |share| share.at(place));
                *cell -= turned * line;
                if !plan.iq {
                    let image =
                        image_here.map_or_else(|| image(here, place), |share| share.at(place));
                    *cell -= turned.conj() * image;
                }
            }
        }
    }

    /// The noise in the beat and in the turn of an echo, over that of the cells around it. The background's noise, 1/M of a chirp's, is the
    /// same in every chirp: it adds up as an echo at rest does.
    #[inline(never)] // once in an image
    pub fn excess(&self, echo: &Echo) -> [f32; 2] {
        if self.background.is_empty() {
            return [1.0; 2];
        }
        let chirps = self.plan.chirps;
        let sum = |turn: f32| kernel(chirps, -echo.row, turn, 0.0).re / chirps as f32;
        let (along, slope) =
            (sum(echo.turn), 2.0 * (sum(echo.turn + 0.25) - sum(echo.turn - 0.25)));
        // The turn's weights are those of a line through the chirps, of which the slope over pi is the sum.
        let slope = slope * (core::f32::consts::FRAC_1_PI * 1.732_050_8);
        [1.0 + along * along, 1.0 + slope * slope]
    }

    /// Whether a bin is kept.
    pub fn keeps(&self, bin: i32) -> bool {
        usize::try_from(bin.wrapping_sub(self.plan.first)).is_ok_and(|place| place < self.plan.bins)
    }
}

//! The joint fit: each tone is fitted to its bins less the models of the others, until none moves.
//!
//! This is the idea of RELAX (Li and Stoica 1996), with nine bins a tone in place of the whole record: the fit of one tone is repeated
//! whenever the fits of its neighbours have moved their leakage by more than the noise allows.

use super::rest::Found;
use super::{Hunt, Mark, ROOM};
use crate::list::first as first_of;
use crate::spectrum::bins::REACH;
use crate::tone::fit::{Fit, FitStart, Model, Reach, fit_around, take_around};
use core::mem::MaybeUninit;
use heapless::Vec;
use num_complex::Complex;

/// A tone is fitted anew if another tone's residual in its bins has changed so much that the remaining error exceeds this share of the
/// noise power in the bins of the tone's own neighbour when both are fitted once more in the end, or [`OWN`] times the noise power in its
/// own bins. An error falls with the square of the distance twice: on the way to the neighbour, and on the way back.
const SETTLED: f32 = 2e-4;
const OWN: f32 = 10.0;

/// From this offset on, in bins, a tone is centred on another bin.
const AWAY: f32 = 0.6;

/// The most times that every tone is fitted anew when another is found.
const SWEEPS: usize = 6;

/// A tone nearer than this is itself among the nine bins of another.
const WITHIN: i32 = 6;

/// Room for the bins of a fit.
pub(super) type Window = Vec<Complex<f32>, { 2 * REACH + 1 }>;

impl Hunt<'_> {
    /// The bins within `reach` of a peak, less the models of all tones but one. Beyond an end of a real
    /// spectrum they are mirrored.
    pub(super) fn bins<'w>(
        &self,
        peak: i32,
        reach: Reach,
        except: Option<usize>,
        window: &'w mut Window,
    ) -> &'w mut [Complex<f32>] {
        let (n, reach) = (self.layout.n as i32, reach.bins());
        let first = peak - reach as i32;
        if !self.layout.iq && (first < 1 || peak + reach as i32 >= n / 2) {
            let mirrored = self.rest.bins(peak, except);
            // There is room for every reach.
            *window = first_of((0..=2 * reach as i32).map(|i| mirrored.at(i - reach as i32)));
            return window;
        }
        let mut places = [MaybeUninit::uninit(); 2 * REACH + 1];
        let places = places.get_mut(..2 * reach + 1).unwrap_or_default();
        let unit = self.rest.unit;
        for &[re, im] in self.rest.view.fill(first, places) {
            let _ = window.push(Complex::new(re as f32 * unit, im as f32 * unit));
        }
        for (index, found) in self.rest.found.iter().enumerate() {
            if Some(index) != except {
                take_around(self.layout, &found.model, peak, window);
            }
        }
        window
    }

    /// Fits a tone to nine bins around a peak, less the others' models.
    fn fitted(&self, peak: i32, except: Option<usize>, course: FitStart<f32>) -> Option<Found> {
        let mut window = Window::new();
        let bins = self.bins(peak, Reach::Four, except, &mut window);
        let fit = fit_around(self.layout, bins, peak, course)?;
        Some(Found { peak, fit, model: Model::new(&fit, peak, self.layout.n as i32) })
    }

    /// Adds a line in noise of this power in a bin; false if no bins can be fitted.
    pub(super) fn add(&mut self, peak: i32, course: FitStart<f32>, mark: Mark) -> bool {
        let Some(found) = self.fitted(peak, None, course) else { return false };
        let index = self.rest.found.len();
        if self.rest.found.push(found).is_err() || self.marks.push(mark).is_err() {
            return false;
        }
        self.tell(index, None);
        true
    }

    /// Fits every tone anew until the others' residuals in its bins no longer change.
    pub(super) fn settle(&mut self) {
        for _ in 0..SWEEPS {
            if self.rest.found.iter().zip(&self.marks).all(|(_, mark)| !mark.due) {
                break;
            }
            for index in 0..self.rest.found.len() {
                self.refit(index);
            }
        }
        self.leak();
    }

    /// Fits a tone anew if due.
    fn refit(&mut self, index: usize) {
        let Some(mark) = self.marks.get_mut(index) else { return };
        if !core::mem::take(&mut mark.due) {
            return;
        }
        let Some(&Found { peak, fit: Fit { offset, .. }, model }) = self.rest.found.get(index)
        else {
            return;
        };
        let moved = if offset.abs() > AWAY { offset.signum() as i32 } else { 0 };
        let course = FitStart::From(offset - moved as f32, 1);
        let Some(found) = self.fitted(peak + moved, Some(index), course) else { return };
        self.take(index, found);
        self.tell(index, Some(&model));
    }

    /// Marks the other tones that a changed or new tone affects.
    pub(super) fn tell(&mut self, index: usize, before: Option<&Model<f32>>) {
        let Some(Found { peak, model, .. }) = self.rest.found.get(index) else { return };
        let zero = Complex::new(0.0, 0.0);
        let [whole, leakage] = [Model::value, Model::leakage]
            .map(|part| (part(model) - before.map_or(zero, part)).norm_sqr());
        let neighbours = self.neighbours();
        let all = self.rest.found.iter().zip(&mut self.marks).zip(neighbours);
        for (other, ((found, mark), nearest)) in all.enumerate() {
            let square = (nearest * nearest) as f32;
            let settled = (SETTLED * square * square).min(OWN);
            let apart = self.layout.apart(*peak, found.peak).max(1);
            // Near by, the bins of one tone are among the bins of the other.
            let power = if apart <= WITHIN { whole + leakage } else { leakage };
            let apart = apart as f32;
            if other != index && power > settled * mark.noise * (apart * apart) {
                mark.due = true;
            }
        }
    }

    /// The distance of each tone from the one nearest to it, in bins.
    fn neighbours(&self) -> [i32; ROOM] {
        let mut nearest = [self.layout.n as i32; ROOM];
        let found = &self.rest.found;
        for (index, (one, nearest)) in found.iter().zip(&mut nearest).enumerate() {
            for (_, other) in found.iter().enumerate().filter(|(other, _)| *other != index) {
                *nearest = (*nearest).min(self.layout.apart(one.peak, other.peak));
            }
        }
        nearest
    }

    pub(super) fn take(&mut self, index: usize, found: Found) {
        if let Some(place) = self.rest.found.get_mut(index) {
            *place = found;
        }
    }
}

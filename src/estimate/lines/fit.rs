//! The joint fit: each tone to its bins less the models of the others, tone after tone.

use super::super::least_squares::{Course, Fit, Model, Reach, fit_known};
use super::super::measure::residual;
use super::super::several::{Found, SWEEPS};
use super::super::uncertainty::sigma_bins;
use super::Hunt;
use crate::acquire::sample::Record;
use crate::spectrum::bins::{Bins, REACH, Rectangular};
use crate::spectrum::engine::Engine;
use core::mem::MaybeUninit;
use num_complex::Complex;

/// A fit is settled if no tone moves by more than this share of its sigma.
const SETTLED: f32 = 0.1;

/// From this offset on, in bins, a tone is centred on another bin.
const AWAY: f32 = 0.6;

impl<R: Record, const N: usize, E: Engine> Hunt<'_, R, N, E> {
    /// The bins within `reach` of a peak, less the models of all tones but one. Beyond an end of a real
    /// spectrum they are mirrored.
    pub(super) fn bins(
        &self,
        peak: i32,
        reach: usize,
        except: Option<usize>,
    ) -> Bins<f32, R, Rectangular> {
        let (n, first) = (N as i32, peak - reach as i32);
        let inside = R::IQ || first >= 1 && peak + (reach as i32) < n / 2;
        let others = || {
            let all = self.rest.found.iter().enumerate();
            all.filter(move |(index, _)| Some(*index) != except).map(|(_, found)| found)
        };
        if !inside {
            return self.rest.bins(peak, except);
        }
        let mut places = [MaybeUninit::uninit(); 2 * REACH + 1];
        let places = places.get_mut(..2 * reach + 1).unwrap_or_default();
        let mut bins = [Complex::new(0.0, 0.0); 2 * REACH + 1];
        let unit = self.rest.unit;
        for (bin, [re, im]) in bins.iter_mut().zip(self.rest.spectrum.fill(first, places)) {
            *bin = Complex::new(*re as f32 * unit, *im as f32 * unit);
        }
        let bins = bins.get_mut(..2 * reach + 1).unwrap_or_default();
        others().for_each(|found| found.model.take_from::<R>(first, bins));
        Bins::of_middle(N, peak, bins)
    }

    /// Fits every tone anew until none moves. Returns whether that came to an end.
    pub(super) fn settle(&mut self, reach: Reach) {
        for _ in 0..2 * SWEEPS {
            if !self.sweep(reach) {
                break;
            }
        }
        self.leak();
    }

    /// Fits every tone once to the bins less the other models. Returns whether one moved.
    fn sweep(&mut self, reach: Reach) -> bool {
        let mut moves = false;
        for index in 0..self.rest.found.len() {
            let Some(&old) = self.rest.found.get(index) else { break };
            let offset = old.fit.offset;
            let moved = if offset.abs() > AWAY { offset.signum() as i32 } else { 0 };
            let (peak, start) = (old.peak + moved, offset - moved as f32);
            let bins = self.bins(peak, reach.bins(), Some(index));
            let Some(fit) = fit_known::<R, N>(&bins, reach.bins(), Course::From(start, 1)) else {
                continue;
            };
            let sigma = sigma_bins(&fit, N, residual(&fit, N));
            moves |= (fit.offset - start).abs() > SETTLED * sigma;
            self.take(index, peak, fit);
        }
        moves
    }

    /// The first tone, fitted to all its bins.
    pub(super) fn alone(&mut self, peak: i32) -> bool {
        let reach = self.options.reach.bins();
        let bins = self.bins(peak, reach, None);
        let fit = fit_known::<R, N>(&bins, reach, Course::Usual);
        fit.is_some_and(|fit| {
            let model = Model::new(&fit, peak, N as i32);
            self.rest.found.push(Found { peak, fit, model }).is_ok() && self.own.push(true).is_ok()
        })
    }

    fn take(&mut self, index: usize, peak: i32, fit: Fit<f32>) {
        if let Some(found) = self.rest.found.get_mut(index) {
            *found = Found { peak, fit, model: Model::new(&fit, peak, N as i32) };
        }
    }
}

//! Frames of chirps: range and velocity of several targets from a sequence of sawtooth chirps, also of targets that no single chirp shows.
//!
//! ```
//! use picket_dsp::frame::{Cells, Frame, FrameConfig};
//! use picket_dsp::{Chirp, Codes, Config, Pipeline, Iq, Shape, Verdict};
//!
//! // 77 GHz, 300 MHz in 100 us, 256 samples a chirp, 64 chirps, one every 120 us.
//! let chirp = Chirp {
//!     shape: Shape::Sawtooth,
//!     wavelength_m: 299_792_458.0 / 77e9,
//!     bandwidth_hz: 300e6,
//!     duration_s: 101e-6,
//!     guard_s: 1e-6,
//!     ..Chirp::default()
//! };
//! let rate_hz = 2.56e6;
//! let config = FrameConfig {
//!     bins: Some((1, 127)),
//!     velocity_mps: Some((-8.0, 8.0)),
//!     ..FrameConfig::new(chirp, rate_hz, 256, true, 64, 120e-6)
//! };
//! let plan = config.plan()?;
//! let mut cells = vec![[0i16; 2]; plan.cells()];
//! let mut frame = Frame::new(plan, Cells::Narrow(&mut cells)).unwrap();
//! let mut pipeline = Pipeline::<Iq, 256>::new(Config::new(rate_hz, Codes::signed::<12>()).plan()?);
//! # let mut state = 1u32;
//! # let mut noise = || {
//! #     state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
//! #     f64::from(state >> 16) / 327.68 - 100.0
//! # };
//! for chirp in 0..64 {
//! #     let samples: [[i16; 2]; 256] = std::array::from_fn(|n| {
//! #         let t = 1e-6 + n as f64 / rate_hz;
//! #         let time = t + f64::from(chirp) * 120e-6 - 0.5 * 63.0 * 120e-6 - 1e-6 - 0.5 * 255.0 / rate_hz;
//! #         let tau = 2.0 * (20.0 - 3.0 * time) / 299_792_458.0;
//! #         let turns = tau * (77e9 + 300e6 / 101e-6 * (t - 0.5 * tau));
//! #         let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
//! #         [(300.0 * cos + noise()) as i16, (300.0 * sin + noise()) as i16]
//! #     });
//!     let clipped = pipeline.look(&samples); // the samples of a chirp
//!     frame.push(&pipeline.spectrum().view(), clipped);
//! }
//! let targets = frame.targets();
//! assert_eq!(targets.len(), 1);
//! let target = targets[0].target; // 20 m, 3 m/s
//! assert!((target.range.to_num::<f32>() - 20.0).abs() < 5.0 * target.sigma_range);
//! assert!((target.velocity.unwrap().to_num::<f32>() - 3.0).abs() < 5.0 * target.sigma_velocity);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Steps
//!
//! 1. Each chirp is transformed by the engine. The bins of the band are kept in the caller's memory, [`FramePlan::cells`] of them
//!    ([`Cells`]). So far all is in integers; what follows is in floats.
//! 2. A transform over the chirps makes a map of ranges and velocities. The place of most evidence is sought in it, in steps of half a
//!    cell in both directions (`search`). Beats that walk through cells within a frame are sought along their walk.
//! 3. The target is fitted by the library's own fit of a tone, over the samples and over the chirps in turn (`fit`), and taken from the
//!    cells. The search goes on in the rest, and all targets are fitted again together, up to [`TARGETS`].
//! 4. The noise is that of the cells around a target, in both directions (`noise`); a target counts if noise alone exceeds it in no more
//!    frames than the setting allows.
//! 5. A target that louder ones may make, as a harmonic or a sideband, is [`Verdict::Unresolved`](crate::Verdict::Unresolved) (`ghost`).
//! 6. Range and velocity follow with their covariance:
//!
//! ```text
//! turns a chirp = -s 2 V (f0 + S t) Tc / c      beat = s (S 2 R / c (1 + 2 V / c) - 2 V (f0 + S t) / c)
//! ```
//!
//! in the middle of the frame and at the middle `t` of the chirp's record, with the period Tc and the receiver's orientation s.
//!
//! # Aliases
//!
//! The turn from chirp to chirp leaves the velocity open by half a wavelength a period ([`FramePlan::alias_mps`]). The bounds of the
//! velocity decide, or the target's own movement: it moves through cells only with its true velocity. Where neither does, the target is
//! [`Verdict::Ambiguous`](crate::Verdict::Ambiguous) and lists the aliases with their odds; a second frame of another period decides, see [`settle`].
//!
//! # Cost
//!
//! Counted on a Cortex-M4F for 32 chirps of 127 bins, I/Q: 8 thousand instructions to store a chirp, 46 million for the answer with two
//! targets. Most of them are fits: each reads 33 bins of every chirp, for each target that is known, and all targets are fitted some eight
//! times. A search reads all cells once for each velocity with a walk of its own, and once more for each target. The stack holds 15 KB.
//! [`Search`] takes the answer in steps, for a program that has other things to do meanwhile.
//!
//! Sources: Stove 1992 (doi:10.1049/ip-f-2.1992.0048) for the map; the two fits, their sigmas and the chances are this project's own.

mod cells;
mod echo;
mod fit;
mod ghost;
mod hunt;
mod map;
mod noise;
mod periods;
mod plan;
mod search;
mod target;
mod transform;

pub use cells::{Cells, Filled};
pub use hunt::Search;
pub use map::TARGETS;
pub use periods::settle;
pub use plan::{ALIASES, CHIRPS, FREE_ALIASES, FrameConfig, FramePlan};
pub use target::FrameTarget;

use crate::math::scalar::Scalar as _;
use crate::spectrum::view::View;
use cells::Store;
use heapless::Vec;
use map::{EMPTY, Map};
use num_complex::Complex;
use transform::Factors;

/// A frame in progress.
///
/// The frame owns only numbers; its cells are the caller's.
#[derive(Debug)]
pub struct Frame<'a> {
    plan: FramePlan,
    store: Store<'a>,
}

impl<'a> Frame<'a> {
    /// A frame in these cells. `None` if there are fewer than [`FramePlan::cells`].
    pub fn new(plan: FramePlan, cells: Cells<'a>) -> Option<Self> {
        Some(Self { plan, store: Store::new(cells, plan.chirps, plan.bins)? })
    }

    /// A frame that goes on where another was, in the same cells: for a program that cannot hold a frame together with its cells.
    pub fn resume(plan: FramePlan, cells: Cells<'a>, filled: Filled) -> Option<Self> {
        let mut frame = Self::new(plan, cells)?;
        frame.store.filled = filled;
        Some(frame)
    }

    /// How far the frame is, for [`Frame::resume`].
    pub const fn so_far(&self) -> Filled {
        self.store.filled
    }

    /// The plan.
    pub const fn plan(&self) -> &FramePlan {
        &self.plan
    }

    /// The chirps of the frame in progress.
    pub const fn filled(&self) -> usize {
        self.store.filled.chirps
    }

    /// The samples of these chirps that touch a rail.
    pub const fn clipped(&self) -> u32 {
        self.store.filled.clipped
    }

    /// Takes the bins of the next chirp, and the number of its samples that touch a rail, as [`Pipeline::look`](crate::Pipeline::look) counts them: where more
    /// than a share of [`CLIPPED`](crate::tone::sigma::CLIPPED) of a frame's do, all its targets are [`Verdict::Clipped`](crate::Verdict::Clipped), because
    /// the harmonics of a clipped echo look like targets. Returns whether the frame is complete. A chirp beyond the last one begins a new frame; a
    /// chirp of another length or kind is ignored.
    pub fn push(&mut self, view: &View, clipped: u32) -> bool {
        let (n, chirps) = (self.plan.n, self.plan.chirps);
        if view.layout.n != n || view.layout.iq != self.plan.iq {
            return false;
        }
        if self.filled() >= chirps {
            self.clear();
        }
        self.store.push(view, self.plan.first, clipped);
        self.filled() == chirps
    }

    /// Begins again: after a gap between chirps.
    pub const fn clear(&mut self) {
        self.store.filled = Filled::NONE;
    }

    /// The targets of the frame that is complete, the strongest first; none of a frame in progress. All are at least detected, see
    /// [`FrameTarget::target`] for their verdicts.
    pub fn targets(&self) -> Vec<FrameTarget, TARGETS> {
        self.targets_beside(&[])
    }

    /// [`Frame::targets`] less the background that [`Frame::background`] recorded of one frame.
    pub fn targets_beside(&self, background: &[Complex<f32>]) -> Vec<FrameTarget, TARGETS> {
        let mut search = Search::new();
        while search.step_beside(self, background) {}
        search.targets
    }

    /// The map as a picture shows it: the power of a bin at each turn from chirp to chirp, from -M/2 to M/2 - 1 of M, in squared codes.
    /// Zeros for a bin that is not kept; [`FramePlan::cell`] has their ranges and velocities. Costs a transform of M points.
    pub fn powers(&self, bin: i32, powers: &mut [f32]) {
        self.powers_beside(&[], bin, powers);
    }

    /// [`Frame::powers`] less the background that [`Frame::background`] recorded of one frame.
    pub fn powers_beside(&self, background: &[Complex<f32>], bin: i32, powers: &mut [f32]) {
        let chirps = self.plan.chirps;
        let map = Map { plan: &self.plan, store: &self.store, background, echoes: Vec::new() };
        let mut column = EMPTY;
        map.column(bin, 0.0, &mut column);
        let mut points = [Complex::new(0.0, 0.0); transform::MOST];
        points.iter_mut().zip(&column).for_each(|(point, cell)| *point = *cell);
        let factors = Factors::new(chirps);
        factors.transform(&mut points);
        for (place, point) in points.iter().take(chirps).enumerate() {
            let row = (factors.frequency(place) + chirps / 2) % chirps.max(1);
            if let Some(power) = powers.get_mut(row) {
                *power = point.norm_sqr();
            }
        }
    }

    /// Records the clutter at rest: the mean over the frame's chirps, a number for each kept bin. Returns its share of all power, 0 to 1:
    /// little power is little to subtract. The caller keeps the time. Its noise, 1/M of a chirp's, is in the sigmas of targets near rest.
    pub fn background(&self, still: &mut [Complex<f32>]) -> f32 {
        let (mut power, mut all) = (0.0, 0.0);
        let chirps = self.plan.chirps;
        let unit = f32::two_to(self.store.filled.exponent);
        for (bin, still) in still.iter_mut().take(self.plan.bins).enumerate() {
            let mut sum = Complex::new(0.0, 0.0);
            for chirp in 0..chirps {
                let [re, im] = self.store.get(bin as i32, chirp);
                let cell = Complex::new(re, im) * unit;
                sum += cell;
                all += cell.norm_sqr();
            }
            *still = sum / chirps as f32;
            power += still.norm_sqr() * chirps as f32;
        }
        if all > 0.0 { power / all } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Chirp, Codes, Config, Iq, Mixing, Pipeline, Shape};
    use std::f64::consts::TAU;

    const N: usize = 64;
    const M: usize = 16;

    /// Without its own background a map has nothing at rest, and elsewhere what it had.
    #[test]
    fn powers_beside_a_background_have_no_clutter() {
        let chirp = Chirp {
            shape: Shape::Sawtooth,
            mixing: Mixing::TxConjRx,
            wavelength_m: 0.004,
            bandwidth_hz: 300e6,
            duration_s: 65e-6,
            guard_s: 1e-6,
            ..Chirp::default()
        };
        let plan = FrameConfig::new(chirp, 1e6, N, true, M, 80e-6).plan().unwrap();
        let mut cells = std::vec![[0i32; 2]; plan.cells()];
        let mut frame = Frame::new(plan, Cells::Wide(&mut cells)).unwrap();
        let config = Config::new(1e6, Codes::signed::<12>());
        let mut pipeline = Pipeline::<Iq, N>::new(config.plan().unwrap());
        for chirp in 0..M {
            // Clutter in bin 9, and in bin 20 a target that turns by 3/16 from chirp to chirp.
            let samples: [[i16; 2]; N] = std::array::from_fn(|n| {
                let [still, moving] = [(9.0, 0.0), (20.0, 3.0)].map(|(beat, turns)| {
                    TAU * (beat * n as f64 / N as f64 + turns * chirp as f64 / M as f64)
                });
                let of = |wave: fn(f64) -> f64| 900.0 * wave(still) + 300.0 * wave(moving);
                [of(f64::cos) as i16, of(f64::sin) as i16]
            });
            let clipped = pipeline.look(&samples);
            frame.push(&pipeline.spectrum().view(), clipped);
        }
        let mut still = std::vec![Complex::new(0.0, 0.0); plan.bins()];
        let share = frame.background(&mut still);
        assert!((share - 0.9).abs() < 0.01, "{share}");
        let column = |background: &[Complex<f32>], bin: i32| {
            let mut column = [0.0; M];
            frame.powers_beside(background, bin, &mut column);
            column
        };
        for bin in [9, 20, 30] {
            let mut whole = [0.0; M];
            frame.powers(bin, &mut whole);
            assert_eq!(whole, column(&[], bin));
            let beside = column(&still, bin);
            let most = 900.0 * (N * M) as f32;
            for (row, (whole, beside)) in whole.into_iter().zip(beside).enumerate() {
                let wanted = if row == M / 2 { 0.0 } else { whole };
                assert!((beside - wanted).abs() < 1e-8 * most * most, "{bin} {row}: {beside}");
            }
            if bin < 30 {
                let row = if bin == 9 { M / 2 } else { M / 2 + 3 };
                let level = (if bin == 9 { 900.0 } else { 300.0 }) * (N * M) as f32;
                assert!((whole[row].sqrt() / level - 1.0).abs() < 0.01, "{bin}: {}", whole[row]);
            }
        }
    }
}

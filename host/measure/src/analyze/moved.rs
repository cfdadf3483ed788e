//! The displacement of the strongest target by its phase, and what swings in it: for the tool and for the page.

use crate::length::LENGTHS;
use picket_dsp::config::{Config, ConfigError, Scene};
use picket_dsp::solve::displacement::{Displacement, Unwrapper};
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::{Codes, Stamp, Usable};
use std::f64::consts::TAU;

/// From chirp to chirp a target turns the phase by less than this share of a turn.
const MOST_TURNS: f32 = 0.25;

/// The most swings that are told of.
pub const SWINGS: usize = 4;

/// Where a target is in a block, beside where it was at the start.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// The block's or the chirp's number.
    pub block: u64,
    /// The time of its middle, s.
    pub time_s: f64,
    /// Its way.
    pub moved: Displacement,
}

/// A swing of the target.
#[derive(Clone, Copy, Debug)]
pub struct Swing {
    /// Its line in the spectrum of the way.
    pub line: ToneWithPhase,
    /// To each side, m, with one standard deviation.
    pub amplitude_m: [f64; 2],
    /// The amplitude of its velocity, m/s, with one standard deviation.
    pub velocity_mps: [f64; 2],
}

/// What the blocks' phases are followed by.
pub struct Ways {
    unwrapper: Unwrapper,
    period_s: f64,
    /// Chirps between pauses of unknown length.
    together: u64,
    blocks: u64,
    lost: bool,
}

impl Ways {
    /// Of blocks of `n` samples of this scene, one each `period_s`, so many of them between pauses.
    ///
    /// # Errors
    /// See [`Unwrapper::of_scene`].
    pub fn new(
        scene: &Scene,
        rate_hz: f64,
        (n, iq): (usize, bool),
        (period_s, together): (f64, u64),
    ) -> Result<Self, ConfigError> {
        let unwrapper = Unwrapper::of_scene(scene, rate_hz, n, iq, MOST_TURNS)?;
        Ok(Self { unwrapper, period_s, together, blocks: 0, lost: false })
    }

    /// Takes the strongest line of the next block, whose first sample has the number `clock`. `None` where the block has no line or was left
    /// out; behind it, as behind a gap, the displacement restarts.
    pub fn push(&mut self, clock: u64, gap: bool, line: Option<&ToneWithPhase>) -> Option<Moved> {
        let block = self.blocks;
        self.blocks += 1;
        self.lost |= gap || block > 0 && block.is_multiple_of(self.together);
        let gap = std::mem::replace(&mut self.lost, line.is_none());
        let stamp = Stamp { sequence: block as u32, clock, gap, ..Stamp::default() };
        let moved = self.unwrapper.push(&stamp, line?);
        Some(Moved { block, time_s: (block as f64 + 0.5) * self.period_s, moved })
    }

    /// The longest stretch without a new start, as a record; `None` where it is too short or does not move.
    pub fn record(&self, all: &[Moved]) -> Option<WayRecord> {
        let usable = |it: &Moved| it.moved.verdict.usable() <= Usable::WithinSigma;
        let together = |a: &Moved, b: &Moved| {
            usable(a) && usable(b) && a.moved.start == b.moved.start && a.block + 1 == b.block
        };
        let longest = all.chunk_by(together).max_by_key(|part| part.len())?;
        let n = LENGTHS.into_iter().rfind(|n| *n <= longest.len())?;
        let way: Vec<f64> = longest.iter().take(n).map(|it| it.moved.metres.to_num()).collect();
        let rest = beside_a_line(&way);
        let most = rest.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let metres = most / 30_000.0;
        let codes = rest.iter().map(|x| (x / metres).round() as i16).collect();
        (most > 0.0).then_some(WayRecord { codes, metres, rate_hz: 1.0 / self.period_s })
    }
}

/// A stretch of a way beside its straight line, as real samples of 16 bits.
pub struct WayRecord {
    /// The samples; there are as many as a record may have.
    pub codes: Vec<i16>,
    /// The metres of a code.
    metres: f64,
    rate_hz: f64,
}

impl WayRecord {
    /// What its lines are measured by.
    pub fn config(&self) -> Config {
        Config::new(self.rate_hz, Codes::signed::<16>())
    }

    /// The swings that its lines are, of which there are at most [`SWINGS`].
    pub fn swings(&self, lines: &[ToneWithPhase]) -> Vec<Swing> {
        let swing = |&line: &ToneWithPhase| {
            let amplitude_m = f64::from(line.tone.amplitude) * self.metres;
            // The relative error of an amplitude is that of the phase.
            let sigma_m = amplitude_m * f64::from(line.sigma_phase);
            let turn = TAU * line.tone.hertz();
            let velocity_mps = [turn * amplitude_m, turn * sigma_m];
            Swing { line, amplitude_m: [amplitude_m, sigma_m], velocity_mps }
        };
        let usable = |line: &&ToneWithPhase| line.tone.verdict.usable() < Usable::No;
        lines.iter().filter(usable).map(swing).collect()
    }
}

/// What is left of numbers beside their straight line.
fn beside_a_line(all: &[f64]) -> Vec<f64> {
    let count = all.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = all.iter().sum::<f64>() / count;
    let places = || (0..all.len()).map(|place| place as f64 - middle);
    let square: f64 = places().map(|place| place * place).sum();
    let slope = places().zip(all).map(|(place, x)| place * x).sum::<f64>() / square;
    places().zip(all).map(|(place, x)| x - mean - slope * place).collect()
}

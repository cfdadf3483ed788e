//! The search for all targets of a frame: the strongest first, each subtracted from the cells before the next is sought. It goes in steps, so
//! that a program can do other things between them.

use super::Frame;
use super::chance::ln_chance;
use super::echo::Echo;
use super::fit::Fitted;
use super::map::{Map, TARGETS};
use super::noise;
use super::search::{HIDDEN, Strongest};
use super::target::{FrameTarget, apart};
use crate::list::{insert, remove};
use crate::math::scalar::Scalar as _;
use crate::tone::Verdict;
use crate::tone::fit::Fit;
use heapless::Vec;
use num_complex::Complex;

/// Two echoes nearer than this in both directions are one, cells.
const ONE: f32 = 1.2;

/// A target with less than this share of the strongest one's power may be a residual of the strongest one: -50 dB.
const LEFT: f32 = 1e-5;

/// Rounds in which all echoes are fitted together: after each new one, and in the end.
const ROUNDS: usize = 2;
const LAST: usize = 8;

/// A fit has settled when it moves less than this share of its sigma.
const SETTLED: f32 = 0.02;

/// What the next step of a search does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Seeks another echo, by the walk of this number.
    Seek(i32),
    /// Fits the newest echo alone.
    Join,
    /// Fits all echoes together, so many times already, and then judges the newest one.
    Round(usize),
    /// Fits all echoes together until they have settled; so many times already.
    Settle(usize),
    /// Makes a target of the echo of this index.
    Report(usize),
    /// Nothing: all targets are there.
    Done,
}

/// The search for the targets of a complete frame, in steps: [`Frame::targets`](super::Frame::targets) takes all of them at once. A step goes
/// through the map once, fits all echoes together, or makes a target of one.
///
/// ```text
/// let mut search = Search::new();
/// while search.step(&frame) {
///     // what cannot wait
/// }
/// search.targets()
/// ```
#[derive(Clone, Debug)]
pub struct Search {
    stage: Stage,
    /// The strongest place so far.
    best: Option<Strongest>,
    echoes: Vec<Echo, TARGETS>,
    hidden: Vec<(i32, i32), HIDDEN>,
    crowded: Vec<(i32, i32), HIDDEN>,
    pub(super) targets: Vec<FrameTarget, TARGETS>,
}

impl Search {
    /// A search that begins.
    pub const fn new() -> Self {
        Self {
            stage: Stage::Seek(0),
            best: None,
            echoes: Vec::new(),
            hidden: Vec::new(),
            crowded: Vec::new(),
            targets: Vec::new(),
        }
    }

    /// Begins again.
    pub fn begin(&mut self) {
        (self.stage, self.best) = (Stage::Seek(0), None);
        self.echoes.clear();
        self.hidden.clear();
        self.crowded.clear();
        self.targets.clear();
    }

    /// Goes on, in the frame in which the search began. Returns whether there is more to do. A frame in progress has no targets.
    pub fn step(&mut self, frame: &Frame) -> bool {
        self.step_beside(frame, &[])
    }

    /// [`Search::step`] less what stood in the background.
    #[inline(never)] // once in an image
    pub fn step_beside(&mut self, frame: &Frame, background: &[Complex<f32>]) -> bool {
        if frame.filled() < frame.plan.chirps {
            self.stage = Stage::Done;
        }
        let echoes = core::mem::take(&mut self.echoes);
        let map = Map { plan: &frame.plan, store: &frame.store, background, echoes };
        let mut hunt = Hunt { map };
        self.stage = match self.stage {
            Stage::Seek(_) if hunt.map.echoes.is_full() => Stage::Settle(0),
            Stage::Seek(step) => {
                if let Some(place) = hunt.map.search(step, &self.hidden)
                    && self.best.is_none_or(|best| place.is_better(&best))
                {
                    self.best = Some(place);
                }
                if step + 1 < hunt.map.steps() {
                    Stage::Seek(step + 1)
                } else {
                    match self.best {
                        Some(place)
                            if hunt.is_likely(&place)
                                && hunt.map.echoes.push(place.echo).is_ok() =>
                        {
                            Stage::Join
                        }
                        _ => Stage::Settle(0),
                    }
                }
            }
            Stage::Join if hunt.settle_newest() => Stage::Round(0),
            Stage::Join => Stage::Settle(0),
            Stage::Round(times) if times < ROUNDS => {
                hunt.round(1.0);
                Stage::Round(times + 1)
            }
            Stage::Round(_) => match self.best.take() {
                Some(place) if hunt.judge(&place, &mut self.hidden, &mut self.crowded) => {
                    Stage::Seek(0)
                }
                _ => Stage::Settle(0),
            },
            Stage::Settle(times) if times < LAST && !hunt.round(SETTLED) => {
                Stage::Settle(times + 1)
            }
            Stage::Settle(_) => Stage::Report(0),
            Stage::Report(index) if index < hunt.map.echoes.len() => {
                if let Some(target) = hunt.report(index, &self.crowded) {
                    let louder = |other: &FrameTarget| {
                        target.line.tone.amplitude > other.line.tone.amplitude
                    };
                    let place = self.targets.iter().position(louder);
                    insert(&mut self.targets, place.unwrap_or(usize::MAX), target);
                }
                Stage::Report(index + 1)
            }
            Stage::Report(_) | Stage::Done => Stage::Done,
        };
        self.echoes = hunt.map.echoes;
        self.stage != Stage::Done
    }

    /// The targets once there is nothing more to do, the strongest first.
    pub fn targets(&self) -> &Vec<FrameTarget, TARGETS> {
        &self.targets
    }
}

impl Default for Search {
    fn default() -> Self {
        Self::new()
    }
}

/// A search with the map that it goes through.
struct Hunt<'a> {
    map: Map<'a>,
}

impl Hunt<'_> {
    /// Whether a place exceeds the noise enough for a fit.
    fn is_likely(&self, place: &Strongest) -> bool {
        let plan = self.map.plan;
        // The search loses 2 dB at the most.
        let chance = ln_chance(1.7 * place.ratio, self.map.tried(), plan.chirps as f32, 1e6);
        chance <= plan.false_alarm.log_e()
    }

    /// Judges the newest echo, which was sought at this place. Returns whether there may be one more.
    #[inline(never)] // its room on the stack is not beside a report's
    fn judge(
        &mut self,
        place: &Strongest,
        hidden: &mut Vec<(i32, i32), HIDDEN>,
        crowded: &mut Vec<(i32, i32), HIDDEN>,
    ) -> bool {
        let plan = self.map.plan;
        let least = plan.false_alarm.log_e();
        let index = self.map.echoes.len().saturating_sub(1);
        let Some(newest) = self.map.echoes.get(index).copied() else { return false };
        let mut others = self.map.echoes.iter().take(index);
        let near = others.any(|other| apart(&newest, other, plan.chirps) < ONE);
        let most = self.map.echoes.iter().map(|echo| echo.amplitude.norm_sqr()).fold(0.0, f32::max);
        let remainder = newest.amplitude.norm_sqr() < LEFT * most;
        if near || remainder || !self.stands_out(index, least) {
            remove(&mut self.map.echoes, index);
            self.round(1.0);
            let at = place.echo;
            let row = 2 * at.row + if at.turn > 0.25 { 1 } else { 0 };
            if near {
                let _ = crowded.push((newest.peak, newest.row));
            }
            return (near || remainder) && hidden.push((at.peak, row)).is_ok();
        }
        true
    }

    /// Fits the newest echo alone, from its place; without a fit it is dropped.
    fn settle_newest(&mut self) -> bool {
        let index = self.map.echoes.len().saturating_sub(1);
        for step in 0..3 {
            let Some(fitted) = self.fit(index, step == 0) else {
                remove(&mut self.map.echoes, index);
                return false;
            };
            if let Some(echo) = self.map.echoes.get_mut(index) {
                *echo = fitted.echo;
            }
            if step == 0 {
                self.choose(index);
            }
        }
        true
    }

    /// Gives an echo the alias that fits best. Returns whether it is another one.
    fn choose(&mut self, index: usize) -> bool {
        let aliases = self.without(index, |map, echo| map.aliases(echo, 1.0)).unwrap_or_default();
        let plan = self.map.plan;
        if let Some(&(alias, _)) = aliases.first()
            && let Some(echo) = self.map.echoes.get_mut(index)
            && echo.alias != alias
        {
            echo.alias = alias;
            echo.move_on(plan);
            return true;
        }
        false
    }

    /// Fits every echo once more. Returns whether none moved by more than this share of its sigma.
    fn round(&mut self, share: f32) -> bool {
        let mut settled = true;
        for index in 0..self.map.echoes.len() {
            let Some(fitted) = self.fit(index, false) else { continue };
            let Fitted { beat, turn, moved: [beat_moved, turn_moved], .. } = &fitted;
            // Sigma without the noise estimate: the residual is no less than the noise.
            let far = |moved: f32, fit: &Fit<f32>| {
                let noise = fit.residual / (0.5 * fit.dof.max(1) as f32);
                moved * moved * 2.0 * fit.information > share * share * noise
            };
            settled &= !(far(*beat_moved, beat) || far(*turn_moved, turn));
            if let Some(echo) = self.map.echoes.get_mut(index) {
                *echo = fitted.echo;
            }
        }
        settled
    }

    /// Fits one echo to the cells less the others.
    fn fit(&mut self, index: usize, first: bool) -> Option<Fitted> {
        self.without(index, |map, echo| map.fit(echo, first))?
    }

    /// Runs a function on the map without one echo, then puts the echo back.
    fn without<T>(&mut self, index: usize, of: impl FnOnce(&Map, &Echo) -> T) -> Option<T> {
        let echo = *self.map.echoes.get(index)?;
        let silent = Echo { amplitude: Complex::new(0.0, 0.0), ..echo };
        *self.map.echoes.get_mut(index)? = silent;
        let result = of(&self.map, &echo);
        *self.map.echoes.get_mut(index)? = echo;
        Some(result)
    }

    /// Whether an echo exceeds the noise around it.
    fn stands_out(&mut self, index: usize, least: f32) -> bool {
        let Some(&echo) = self.map.echoes.get(index) else { return false };
        let (tried, rows) = (self.map.tried(), self.map.plan.chirps as f32);
        let Some(beside) = noise::beside(&self.map, &echo) else { return false };
        let Some(fitted) = self.fit(index, false) else { return false };
        let ratio = fitted.echo.amplitude.norm_sqr() * fitted.energy / beside.power;
        ln_chance(ratio, tried, rows, beside.cells) <= least
    }

    /// The target of an echo, if it is one.
    #[inline(never)] // its room on the stack is not beside a search's
    fn report(&mut self, index: usize, crowded: &[(i32, i32)]) -> Option<FrameTarget> {
        let chirps = self.map.plan.chirps;
        let echo = *self.map.echoes.get(index)?;
        let beside = noise::beside(&self.map, &echo)?;
        // Another alias walks otherwise: it is fitted again.
        if self.choose(index) {
            for _ in 0..3 {
                if let Some(fitted) = self.fit(index, false)
                    && let Some(echo) = self.map.echoes.get_mut(index)
                {
                    *echo = fitted.echo;
                }
            }
        }
        let aliases = self.without(index, |map, echo| map.aliases(echo, beside.power));
        let aliases = aliases.unwrap_or_default();
        let echo = *self.map.echoes.get(index)?;
        let beside = noise::beside(&self.map, &echo)?;
        let others = self.map.echoes.iter().enumerate().filter(|(other, _)| *other != index);
        let mut nearest =
            others.map(|(_, other)| apart(&echo, other, chirps)).fold(f32::INFINITY, f32::min);
        if crowded
            .iter()
            .any(|&(peak, row)| (echo.peak - peak).abs() <= 2 && (echo.row - row).abs() <= 2)
        {
            nearest = 0.0;
        }
        let fitted = self.fit(index, false)?;
        let target =
            self.without(index, |map, _| map.target(&fitted, &beside, &aliases, nearest))?;
        let is_noise = target.target.verdict == Verdict::Weak
            || target.ln_chance > self.map.plan.false_alarm.log_e();
        (!is_noise).then_some(target)
    }
}

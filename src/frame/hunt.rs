//! The search for all targets of a frame: the strongest first, each subtracted from the cells before the next is sought. It goes in steps, so
//! that a program can do other things between them.

use super::Frame;
use super::echo::Echo;
use super::fit::Fitted;
use super::map::{Map, TARGETS};
use super::noise;
use super::plan::MOST_ALIASES;
use super::search::{HIDDEN, Strongest};
use super::target::{FrameTarget, apart};
use crate::chance::ln_of_map;
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
// A search that begins is zeros, so that one in static memory is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
enum Stage {
    /// Seeks another echo, by the walk of this number.
    Seek(i32),
    /// Fits the newest echo alone, from its place.
    Join,
    /// Weighs another alias of the echo of this index.
    Weigh(usize, Weighed),
    /// Fits the echo of this index beside the others, then the next one.
    Fit(usize, Round),
    /// Judges the newest echo.
    Judge,
    /// Makes a target of the echo of this index.
    Report(usize),
    /// Nothing: all targets are there.
    Done,
}

/// What an echo's aliases are weighed for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Weighed {
    /// The newest echo's first alias.
    Join,
    /// The alias of an echo whose target is made.
    Choose,
    /// The odds of that target's aliases.
    Report,
}

/// A round in which all echoes are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Round {
    /// With the newest echo, after so many rounds; then it is judged.
    Join(usize),
    /// Without the newest echo. Says whether another one is sought then.
    Leave(bool),
    /// Until all have settled, after so many rounds.
    Settle(usize),
}

const SETTLE: Stage = Stage::Fit(0, Round::Settle(0));

/// The search for the targets of a complete frame, in steps: [`Frame::targets`](super::Frame::targets) takes all of them at once. A step goes
/// through the map once, fits an echo, weighs one of its aliases, or makes a target of it.
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
    /// Whether no echo has moved in this round.
    settled: bool,
    /// The strongest place so far.
    best: Option<Strongest>,
    echoes: Vec<Echo, TARGETS>,
    /// The aliases of an echo that are weighed so far, each with its evidence, a power; the best first.
    aliases: Vec<(i32, f32), MOST_ALIASES>,
    hidden: Vec<(i32, i32), HIDDEN>,
    crowded: Vec<(i32, i32), HIDDEN>,
    pub(super) targets: Vec<FrameTarget, TARGETS>,
}

impl Search {
    /// A search that begins.
    pub const fn new() -> Self {
        Self {
            stage: Stage::Seek(0),
            settled: false,
            best: None,
            echoes: Vec::new(),
            aliases: Vec::new(),
            hidden: Vec::new(),
            crowded: Vec::new(),
            targets: Vec::new(),
        }
    }

    /// Begins again.
    pub fn begin(&mut self) {
        (self.stage, self.best) = (Stage::Seek(0), None);
        self.echoes.clear();
        self.aliases.clear();
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
        self.stage = self.next(&mut hunt);
        self.echoes = hunt.map.echoes;
        self.stage != Stage::Done
    }

    /// Takes a step. Returns the next one.
    fn next(&mut self, hunt: &mut Hunt) -> Stage {
        match self.stage {
            Stage::Seek(_) if hunt.map.echoes.is_full() => SETTLE,
            Stage::Seek(step) => {
                if let Some(place) = hunt.map.search(step, &self.hidden)
                    && self.best.is_none_or(|best| place.is_better(&best))
                {
                    self.best = Some(place);
                }
                if step + 1 < hunt.map.steps() {
                    return Stage::Seek(step + 1);
                }
                match self.best {
                    Some(place)
                        if hunt.is_likely(&place) && hunt.map.echoes.push(place.echo).is_ok() =>
                    {
                        Stage::Join
                    }
                    _ => SETTLE,
                }
            }
            Stage::Join => {
                let index = hunt.newest();
                if hunt.refit(index, true, 1.0).is_some() {
                    self.weigh(index, Weighed::Join)
                } else {
                    remove(&mut hunt.map.echoes, index);
                    SETTLE
                }
            }
            Stage::Weigh(index, _) if index >= hunt.map.echoes.len() => Stage::Done,
            Stage::Weigh(index, what) => {
                if hunt.weigh(index, &mut self.aliases) {
                    return self.stage;
                }
                let changed = what != Weighed::Report && hunt.choose(index, &self.aliases);
                // Another alias walks otherwise.
                let times = match what {
                    Weighed::Join => 2,
                    Weighed::Choose if changed => 3,
                    _ => 0,
                };
                for _ in 0..times {
                    let _ = hunt.refit(index, false, 1.0);
                }
                match what {
                    Weighed::Join => Stage::Fit(0, Round::Join(0)),
                    Weighed::Choose if changed => self.weigh(index, Weighed::Report),
                    _ => Stage::Report(index),
                }
            }
            Stage::Fit(index, round) => {
                self.settled |= index == 0;
                if index < hunt.map.echoes.len() {
                    self.settled &= hunt.refit(index, false, SETTLED).unwrap_or(true);
                    return Stage::Fit(index + 1, round);
                }
                match round {
                    Round::Join(times) if times + 1 < ROUNDS => {
                        Stage::Fit(0, Round::Join(times + 1))
                    }
                    Round::Join(_) => Stage::Judge,
                    Round::Leave(true) => Stage::Seek(0),
                    Round::Leave(false) => SETTLE,
                    Round::Settle(times) if times + 1 < LAST && !self.settled => {
                        Stage::Fit(0, Round::Settle(times + 1))
                    }
                    Round::Settle(_) => self.weigh(0, Weighed::Choose),
                }
            }
            Stage::Judge => match self.best.take() {
                Some(place) => hunt.judge(&place, &mut self.hidden, &mut self.crowded),
                None => SETTLE,
            },
            Stage::Report(index) => {
                let Some(target) = hunt.report(index, &mut self.aliases, &self.crowded) else {
                    return self.weigh(index + 1, Weighed::Choose);
                };
                let louder =
                    |other: &FrameTarget| target.line.tone.amplitude > other.line.tone.amplitude;
                let place = self.targets.iter().position(louder);
                insert(&mut self.targets, place.unwrap_or(usize::MAX), target);
                self.weigh(index + 1, Weighed::Choose)
            }
            Stage::Done => Stage::Done,
        }
    }

    /// Begins to weigh the aliases of an echo.
    fn weigh(&mut self, index: usize, what: Weighed) -> Stage {
        self.aliases.clear();
        Stage::Weigh(index, what)
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
        let [excess, _] = self.map.excess(&place.echo);
        let ratio = 1.7 * place.ratio / excess;
        let chance = ln_of_map(ratio, self.map.tried(), plan.chirps as f32, 2e6);
        chance <= plan.false_alarm.log_e()
    }

    /// The index of the newest echo.
    fn newest(&self) -> usize {
        self.map.echoes.len().saturating_sub(1)
    }

    /// Judges the newest echo, which was sought at this place. Returns what is next: another one is sought, or there may be no more.
    #[inline(never)] // its room on the stack is not beside a report's
    fn judge(
        &mut self,
        place: &Strongest,
        hidden: &mut Vec<(i32, i32), HIDDEN>,
        crowded: &mut Vec<(i32, i32), HIDDEN>,
    ) -> Stage {
        let plan = self.map.plan;
        let least = plan.false_alarm.log_e();
        let index = self.newest();
        let Some(newest) = self.map.echoes.get(index).copied() else { return SETTLE };
        let mut others = self.map.echoes.iter().take(index);
        let near = others.any(|other| apart(&newest, other, plan.chirps) < ONE);
        let most = self.map.echoes.iter().map(|echo| echo.amplitude.norm_sqr()).fold(0.0, f32::max);
        let remainder = newest.amplitude.norm_sqr() < LEFT * most;
        if !(near || remainder) && self.stands_out(index, least) {
            return Stage::Seek(0);
        }
        remove(&mut self.map.echoes, index);
        let at = place.echo;
        let row = 2 * at.row + if at.turn > 0.25 { 1 } else { 0 };
        if near {
            let _ = crowded.push((newest.peak, newest.row));
        }
        let more = (near || remainder) && hidden.push((at.peak, row)).is_ok();
        Stage::Fit(0, Round::Leave(more))
    }

    /// Weighs the next of an echo's aliases within the bounds, from the first one on. Returns whether there is one more.
    fn weigh(&mut self, index: usize, all: &mut Vec<(i32, f32), MOST_ALIASES>) -> bool {
        let plan = self.map.plan;
        let Some([first, last]) = self.map.echoes.get(index).map(|echo| plan.aliases(echo)) else {
            return false;
        };
        let alias = first.wrapping_add(all.len() as i32);
        let power = self.without(index, |map, echo| map.evidence(echo, alias)).unwrap_or(0.0);
        let place = all.iter().position(|&(_, least)| power > least).unwrap_or(all.len());
        insert(all, place, (alias, power));
        alias < last && !all.is_full()
    }

    /// Gives an echo the alias that fits best. Returns whether it is another one.
    fn choose(&mut self, index: usize, aliases: &[(i32, f32)]) -> bool {
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

    /// Fits an echo once more. Returns whether it moved by no more than this share of its sigma; `None` without a fit.
    #[inline(never)] // once in an image
    fn refit(&mut self, index: usize, first: bool, share: f32) -> Option<bool> {
        let fitted = self.fit(index, first)?;
        let Fitted { beat, turn, moved: [beat_moved, turn_moved], .. } = &fitted;
        // Sigma without the noise estimate: the residual is no less than the noise.
        let far = |moved: f32, fit: &Fit<f32>| {
            let noise = fit.residual / (0.5 * fit.dof.max(1) as f32);
            moved * moved * 2.0 * fit.information > share * share * noise
        };
        let settled = !(far(*beat_moved, beat) || far(*turn_moved, turn));
        if let Some(echo) = self.map.echoes.get_mut(index) {
            *echo = fitted.echo;
        }
        Some(settled)
    }

    /// Fits one echo to the cells less the others.
    #[inline(never)] // once in an image
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
        let [excess, _] = self.map.excess(&fitted.echo);
        let ratio = fitted.echo.amplitude.norm_sqr() * fitted.energy / (beside.power * excess);
        ln_of_map(ratio, tried, rows, beside.dof) <= least
    }

    /// The target of an echo whose aliases are weighed, if it is one.
    #[inline(never)] // its room on the stack is not beside a search's
    fn report(
        &mut self,
        index: usize,
        aliases: &mut Vec<(i32, f32), MOST_ALIASES>,
        crowded: &[(i32, i32)],
    ) -> Option<FrameTarget> {
        let chirps = self.map.plan.chirps;
        let echo = *self.map.echoes.get(index)?;
        let beside = noise::beside(&self.map, &echo)?;
        aliases.iter_mut().for_each(|(_, power)| *power /= beside.power);
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
            self.without(index, |map, _| map.target(&fitted, &beside, aliases, nearest))?;
        let is_noise = target.target.verdict == Verdict::Weak
            || target.ln_chance > self.map.plan.false_alarm.log_e();
        (!is_noise).then_some(target)
    }
}

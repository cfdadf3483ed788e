//! Targets that louder ones may make: no target stands there.
//!
//! - **Harmonics and sums.** A front end or an amplifier that is not quite linear adds harmonics of an echo: beat and turn are 2 or 3 times
//!   those of the echo. Where it adds a second harmonic, it also adds the sum of two echoes, and so on up to the order 7. The image of an I/Q
//!   receiver whose channels differ is the multiple -1.
//! - **Sidebands.** An echo whose level or phase swings from chirp to chirp has two sidebands in its range, one on each side of its velocity. A
//!   ripple of the sweep, or of the supply, makes two at its velocity, one on each side of its range ("paired echoes"). Both have nearly one
//!   level, so the map at the mirrored place decides: a target by itself has only noise there.
//!
//! All are known by their places, within sigma: a target by itself is anywhere in the map, and in those rows where others are, too, if they
//! rest. One that stands there by chance cannot be distinguished from them: it is
//! [`Verdict::Unresolved`](crate::Verdict::Unresolved) as well.

use super::echo::Echo;
use super::map::Map;
use crate::math::fixed_point::to_f32;
use crate::math::scalar::{Scalar as _, nearest};

/// The power of a louder echo over that of what it makes: a level that swings by half has sidebands of a quarter.
const LOUDER: f32 = 16.0;

/// The highest order of a sum of multiples of two echoes, and the highest that is sought without a lower one.
const HIGHEST: i32 = 7;
const FIRST: i32 = 3;

/// The share of targets far below another one that a front end makes at one such place.
const PRIOR: f32 = 0.01;

/// A place is another one beyond this many sigma, and beyond this part of a cell: the leakage of a louder echo moves it so far.
const WITHIN: f32 = 5.0;
const CELL: f32 = 0.01;

/// Two sidebands differ by no more than this factor of power.
const EQUAL: f32 = 4.0;

/// Noise has more than this many times its mean power in one place of three thousand.
const NOISE: f32 = 8.0;

/// The sums of multiples of two echoes up to [`HIGHEST`], or of the first one alone.
fn sums(both: bool) -> impl Iterator<Item = [i32; 2]> + Clone {
    (-HIGHEST..=HIGHEST).flat_map(move |k| {
        let most = if both { HIGHEST - k.abs() } else { 0 };
        (-most..=most).map(move |l| [k, l])
    })
}

/// An echo that may be a ghost.
pub(super) struct Suspect<'a> {
    pub echo: &'a Echo,
    /// The energy of a line of amplitude 1 in the cells that its fit reads.
    pub energy: f32,
    /// Its power over that of the noise.
    pub ratio: f32,
    /// Sigma of the beat, bins, of the turn, bins of the frame, and of the range, m.
    pub sigma: [f32; 3],
}

impl Map<'_> {
    /// Whether louder echoes may make this one. The map holds all other echoes.
    #[inline(never)] // its room on the stack is not beside a target's
    pub fn is_ghost(&self, suspect: &Suspect) -> bool {
        let least = LOUDER * suspect.echo.amplitude.norm_sqr();
        let louder = || self.echoes.iter().filter(|echo| echo.amplitude.norm_sqr() > least);
        louder().any(|of| {
            self.is_sideband(suspect, of)
                || self.is_sum(suspect, of, None)
                || louder().any(|with| {
                    of.amplitude.norm_sqr() > with.amplitude.norm_sqr()
                        && self.is_sum(suspect, of, Some(with))
                })
        })
    }

    /// Whether the suspect is where a front end makes a sum of multiples of an echo, and of a weaker one.
    fn is_sum(&self, suspect: &Suspect, of: &Echo, with: Option<&Echo>) -> bool {
        let sum = |times| self.combined(of, with.unwrap_or(of), times);
        sums(with.is_some()).any(|times @ [k, l]| {
            let order = k.abs() + l.abs();
            // Minus a real record's line is the line itself.
            let own = order < 2 && (k != -1 || !self.plan.iq);
            if own || with.is_some() && l == 0 || !self.is_made(suspect, of, &sum(times), order) {
                return false;
            }
            if l == 0 && order <= FIRST {
                return true;
            }
            // An odd function makes sums of the third order, any other of the second.
            let lower = if order & 1 == 0 { 2 } else { 3 };
            let mut lowers =
                sums(with.is_some()).filter(|[k, l]| k.abs() + l.abs() == lower).map(sum);
            // Beyond the band they are not seen.
            let unseen = l == 0 && lowers.clone().any(|other| !self.keeps(other.peak));
            let least = (1.0 / LOUDER).max(NOISE / suspect.ratio);
            unseen
                || lowers.any(|other| {
                    self.keeps(other.peak)
                        && !self.is_at(suspect, suspect.echo, &other)
                        && self.share_at(suspect, &other, true) > Some(least)
                })
        })
    }

    /// Whether the suspect is a sideband of an echo, and the other one is there as well.
    fn is_sideband(&self, suspect: &Suspect, of: &Echo) -> bool {
        let (plan, echo) = (self.plan, suspect.echo);
        let [sigma_beat, sigma_turn, sigma_range] = suspect.sigma;
        let [bins, rows] = self.between(echo, of);
        let [range, of_range] = [echo, of].map(|echo| to_f32(self.place(echo)[0]));
        // A level that swings within a chirp, too, has its sidebands at one range, as a target of another velocity; one that steps from
        // chirp to chirp at one beat.
        let in_beat = bins.abs() < WITHIN * sigma_beat + CELL;
        let in_range = (range - of_range).abs()
            < WITHIN * sigma_range + CELL * plan.range.float.abs() / plan.n as f32;
        let with_velocity = rows.abs() < WITHIN * sigma_turn + CELL;
        let likely = (in_beat || in_range) != with_velocity;
        self.share_at(suspect, &self.combined(of, echo, [2, -1]), likely)
            .is_some_and(|share| (1.0 / EQUAL..EQUAL).contains(&share))
    }

    /// An echo whose beat and turn are so many times those of two echoes.
    fn combined(&self, a: &Echo, b: &Echo, [k, l]: [i32; 2]) -> Echo {
        let sum = |a: f32, b: f32| k as f32 * a + l as f32 * b;
        let mut echo = Echo {
            peak: k * a.peak + l * b.peak,
            offset: sum(a.offset, b.offset),
            row: k * a.row + l * b.row,
            turn: sum(a.turn, b.turn),
            curve: sum(a.curve, b.curve),
            ..*a
        };
        echo.centre(self.plan.chirps as i32);
        echo.alias = a.alias;
        echo.move_on(self.plan);
        echo
    }

    /// The power at a place, as a share of the suspect's: of the echo that is there, or else of the cells if they are to be asked.
    fn share_at(&self, suspect: &Suspect, place: &Echo, cells: bool) -> Option<f32> {
        let own = suspect.echo.amplitude.norm_sqr();
        let near = |echo: &&Echo| {
            let [bins, rows] = self.between(echo, place);
            echo.amplitude.norm_sqr() > 0.0 && bins.abs().max(rows.abs()) < 1.0
        };
        match self.echoes.iter().find(near) {
            Some(echo) => self.is_at(suspect, echo, place).then(|| echo.amplitude.norm_sqr() / own),
            None => cells.then(|| self.along(place) / (own * suspect.energy)),
        }
    }

    /// The way from a place to an echo: bins, and bins of the frame, the shortest ones round the circles.
    fn between(&self, echo: &Echo, place: &Echo) -> [f32; 2] {
        let way = |whole: i32, rest: f32, length: usize| {
            let (whole, length) = (whole as f32 + rest, length as f32);
            whole - length * nearest(whole / length)
        };
        [
            way(echo.peak - place.peak, echo.offset - place.offset, self.plan.n),
            way(echo.row - place.row, echo.turn - place.turn, self.plan.chirps),
        ]
    }

    /// Whether a suspect rather is what an echo makes at a place than a target there by chance.
    fn is_made(&self, suspect: &Suspect, of: &Echo, place: &Echo, order: i32) -> bool {
        let [bins, rows] = self.between(suspect.echo, place);
        let [sigma_beat, sigma_turn, _] = suspect.sigma;
        // The louder echoes' sigmas are at most a quarter, times the order.
        let squared = (order * order) as f32;
        // The square of the odds: a normal density over an even one.
        let odds = |away: f32, sigma: f32, length: usize| {
            let variance = (1.0 + squared / LOUDER) * sigma * sigma + squared * CELL * CELL;
            let length = length as f32;
            length * length / (core::f32::consts::TAU * variance)
                * libm::expf(-away * away / variance)
        };
        // Whatever rests is in the row of what one at rest makes.
        let [_, own] = self.between(place, of);
        let row = odds(rows, sigma_turn, self.plan.chirps);
        let row = if own.abs() < 1.0 { row.min(1.0) } else { row };
        PRIOR * PRIOR * odds(bins, sigma_beat, self.plan.n) * row > 1.0
    }

    /// Whether an echo is at a place that follows from others, which a suspect follows from as well: it has at most twice the suspect's sigma.
    fn is_at(&self, suspect: &Suspect, echo: &Echo, place: &Echo) -> bool {
        let [sigma_beat, sigma_turn, _] = suspect.sigma;
        let within = WITHIN * (1.0 + EQUAL).root();
        let [bins, rows] = self.between(echo, place);
        bins.abs() < within * sigma_beat + CELL && rows.abs() < within * sigma_turn + CELL
    }
}

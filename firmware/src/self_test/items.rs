//! The items that every board can try.

use super::line::Line;
use super::stream::{Found, MOMENT};
use super::{Bench, Outcome, Trial};
use crate::instrument::storage::{self, Payload};
use picket_dsp::config::Config;
use picket_instrument::words::payload;
use picket_wire::settings::Settings;

/// Settings for a tone at a rate; a core's clock of 0 is the usual one.
pub fn tone_at(rate_hz: f64, mhz: u16) -> Settings {
    let settings = Settings::default();
    let config = Config { rate_hz, ..settings.config };
    Settings { core_mhz: mhz, config, ..settings }
}

/// The largest root mean square of the deviations from the board's tone, in sigmas.
const WRONG: f64 = 3.0;
/// The longest time of a watchdog with the slowest oscillator, with a margin, ms.
const TOO_LONG: u32 = 10_000;

impl<B: Trial<N, SLOT>, const N: usize, const SLOT: usize> Bench<'_, B, N, SLOT> {
    /// The core's clock, MHz.
    pub fn mhz(&self) -> u16 {
        (self.board.clocks().core_hz / 1_000_000) as u16
    }

    /// Measures the board's tone at a rate, and counts the blocks by the timer.
    pub fn rate(&mut self, rate_hz: f64) -> Outcome {
        let settings = tone_at(rate_hz, self.mhz());
        let line = Line::new("").decimal(rate_hz / 1e3, 0).text(" kS/s: ");
        if let Ok((_, words)) = self.board.plan(&settings) {
            B::play(&words);
        }
        let Some(found) = self.stream(&settings, MOMENT, &mut |_, _, _| 0) else {
            return (false, line.text("it does not start"));
        };
        let Found { good, blocks, peak, load, hertz, sigma, error, .. } = found;
        let line = found.counted(line);
        let line = line.text(", the longest ").number(peak).text(" permille of its time, awake ");
        let line = line.number(load).text("; ").text(B::TONE.name).text(" ").decimal(hertz, 3);
        let line = line.text(" Hz +- ").decimal(sigma, 3).text(", wrong by ").decimal(error, 2);
        let line = line.text(" sigma of at most ").decimal(WRONG, 0).text(", ");
        let line = line.text(B::TONE.verdict.name()).text(" in ").number(good);
        // A sigma of a tenth of a bin is not a measurement.
        let fine = sigma > 0.0 && sigma < 0.1 * rate_hz / N as f64;
        // Nearly all blocks have the tone's verdict, and the deviations agree with their sigmas, which do not cover an uneven output.
        let holds = found.whole() && peak <= 1_000 && fine && error < WRONG;
        (holds && good >= blocks - blocks / 20, line)
    }

    /// Milliseconds since these ticks.
    fn since(&self, begun: u32) -> u32 {
        let ticks = self.board.ticks().wrapping_sub(begun);
        ticks.checked_div(self.board.clocks().ticks_hz / 1_000).unwrap_or(0)
    }

    /// Settings that no other program saves.
    fn marked(&self) -> Payload {
        payload(&Settings { start: false, ..tone_at(12_345.0, self.mhz()) }, N)
    }

    /// Saves marked settings, for the next item to load.
    pub fn save(&mut self) -> Outcome {
        let begun = self.board.ticks();
        self.board.feed();
        let saved = storage::save(&mut B::Storage::default(), &self.marked()).is_ok();
        let milliseconds = self.since(begun);
        self.board.feed();
        (saved, Line::new("settings saved in ").number(milliseconds).text(" ms"))
    }

    /// Loads the marked settings, and saves those before them again, which lie in the other page.
    pub fn reload(&mut self) -> Outcome {
        let mut storage = B::Storage::default();
        let loaded = storage::load(&storage).map(|(_, _, loaded)| loaded);
        let former = storage::before(&storage);
        let former = former.unwrap_or_else(|| payload(&Settings::default(), N));
        self.board.feed();
        let found = loaded.is_some_and(|loaded| loaded == self.marked());
        let back = found && storage::save(&mut storage, &former).is_ok();
        self.board.feed();
        (back, Line::new("settings loaded after a reset, the former ones back"))
    }

    /// Starves the watchdog. The item ends by a reset, and [`Bench::bitten`] judges its outcome.
    pub fn starve(&mut self) -> Outcome {
        let begun = self.board.ticks();
        self.board.feed();
        loop {
            // A timer wakes the core ten times a second.
            self.board.sleep(None);
            let starved = self.since(begun);
            if starved > TOO_LONG {
                return (false, Line::new("watchdog: it does not bite"));
            }
            self.state.starved_ms = starved;
            self.state.save();
        }
    }

    /// Judges the watchdog's reset.
    pub(super) fn bitten(&mut self) -> Outcome {
        let (starved, expected) = (self.state.starved_ms, self.state.bites_ms);
        let line = Line::new("watchdog: it bites after ").number(starved).text(" to ");
        let line = line.number(starved + 100).text(" ms, ").number(expected);
        let near = (starved + 50).abs_diff(expected) <= expected / 20 + 50;
        (near, line.text(" by its clock"))
    }
}

/// The scatter of samples around their mean.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scatter {
    count: u32,
    sum: i64,
    squares: i64,
}

impl Scatter {
    /// Adds samples, of 12 bits.
    pub fn add(&mut self, samples: &[i16]) {
        self.count += samples.len() as u32;
        for &sample in samples {
            self.sum += i64::from(sample);
            self.squares += i64::from(sample) * i64::from(sample);
        }
    }

    /// The mean; NaN without samples.
    pub fn mean(&self) -> f64 {
        self.sum as f64 / f64::from(self.count)
    }

    /// The standard deviation; NaN without samples.
    pub fn deviation(&self) -> f64 {
        let variance = self.squares as f64 / f64::from(self.count) - self.mean() * self.mean();
        libm::sqrt(if variance < 0.0 { 0.0 } else { variance })
    }
}

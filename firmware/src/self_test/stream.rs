//! Blocks in the instrument's way, and counts over them.

use super::line::Line;
use super::{Bench, Trial};
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_wire::settings::Settings;

/// The results of the blocks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// Blocks measured.
    pub blocks: u32,
    /// Blocks lost, by the front end's counters.
    pub lost: u32,
    /// Faults, by the front end's counters.
    pub faults: u32,
    /// Blocks with the verdict of the board's tone.
    pub good: u32,
    /// Whether the number of blocks agrees with the time passed.
    pub punctual: bool,
    /// The longest measurement of a block, permille of its time.
    pub peak: u32,
    /// The time awake, permille.
    pub load: u32,
    /// The last frequency, Hz.
    pub hertz: f64,
    /// Its sigma, Hz.
    pub sigma: f64,
    /// The root of the mean square of the deviations from the board's tone, in sigmas.
    pub error: f64,
    /// The largest deviation that the item found.
    pub worst: u32,
}

/// The duration at a rate, seconds.
const SECONDS: u32 = 10;
/// The number of blocks in a quick test.
pub const MOMENT: u32 = 8;

impl Found {
    /// Whether blocks came, in time, and none was lost.
    pub const fn whole(&self) -> bool {
        self.blocks > 0 && self.lost == 0 && self.faults == 0 && self.punctual
    }

    /// Appends how many there were.
    pub fn counted(&self, line: Line) -> Line {
        let line = line.number(self.blocks).text(" blocks, ").number(self.lost);
        let line = line.text(" lost, ").number(self.faults).text(" faults");
        if self.punctual { line } else { line.text(", not in time") }
    }
}

impl<B: Trial<N, SLOT>, const N: usize, const SLOT: usize> Bench<'_, B, N, SLOT> {
    /// Measures blocks by these settings, only `moment` of them in a quick test; `None` if the board does not start. `deviation` judges each
    /// block, whose measurement took so many ticks.
    #[inline(never)] // once, for all items
    pub fn stream(
        &mut self,
        settings: &Settings,
        moment: u32,
        deviation: &mut dyn FnMut(&Stamp, &[i16; N], u32) -> u32,
    ) -> Option<Found> {
        let Bench { board, meters, .. } = self;
        let (plan, words) = board.plan(settings).ok()?;
        meters.set(&plan);
        let rate_hz = plan.settings.config.rate_hz;
        let ticks_hz = board.clocks().ticks_hz;
        let block_ticks = (f64::from(plan.length) / rate_hz * f64::from(ticks_hz)) as u32;
        let blocks = (f64::from(SECONDS) * rate_hz / f64::from(plan.length)) as u32;
        let wanted = if self.state.quick { moment } else { blocks.max(moment) };
        let mut found = Found::default();
        let mut squares = 0.0;
        let mut blocks = board.sample(&plan, &words)?;
        let begun = board.ticks();
        let (mut asleep, mut idle) = (0_u32, 0_u32);
        let mut last = begun;
        while found.blocks < wanted {
            let now = board.ticks();
            let Some(mut block) = blocks.receive() else {
                // Two blocks' time and a tenth of a second: the stream hangs.
                idle = idle.saturating_add(now.wrapping_sub(last));
                last = now;
                if idle > block_ticks.saturating_mul(2).saturating_add(ticks_hz / 10) {
                    break;
                }
                board.sleep(Some(&blocks));
                asleep = asleep.wrapping_add(board.ticks().wrapping_sub(now));
                continue;
            };
            (idle, last) = (0, now);
            let guard = plan.settings.guard;
            board.correct(&mut block.slot);
            let before = board.ticks();
            let tone = meters.block::<N, SLOT>(&mut block, guard).tone;
            let ticks = board.ticks().wrapping_sub(before);
            let samples = block.slot.samples::<Real, N>(guard);
            found.worst = found.worst.max(deviation(&block.stamp, samples, ticks));
            found.peak = found.peak.max(board.ticks().wrapping_sub(now));
            blocks.release(block.slot);
            board.feed();
            found.blocks += 1;
            found.good += u32::from(tone.verdict == B::TONE.verdict);
            (found.hertz, found.sigma) = (tone.hertz(), tone.sigma_hertz());
            let error = (tone.frequency.cycles() - B::TONE.frequency) / f64::from(tone.sigma);
            squares += error * error;
        }
        let passed = board.ticks().wrapping_sub(begun).max(1);
        let counters = board.counters();
        (found.lost, found.faults) = (counters.lost(), counters.faults());
        // The timer wraps after 47 s or more, long after the last block.
        let due = f64::from(passed) / f64::from(block_ticks.max(1));
        found.punctual = libm::fabs(f64::from(counters.filled()) - due) < 2.0;
        let permille = |ticks: u32, of: u32| {
            (u64::from(ticks) * 1000).checked_div(u64::from(of)).unwrap_or(0) as u32
        };
        found.peak = permille(found.peak, block_ticks);
        found.load = permille(passed.saturating_sub(asleep), passed);
        found.error = libm::sqrt(squares / f64::from(found.blocks.max(1)));
        Some(found)
    }
}

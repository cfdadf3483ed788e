//! Log lines over RTT for a debugger (feature `defmt`, levels by `DEFMT_LOG`): the start, the settings, losses, faults, restarts. They come from
//! the main loop, never from an interrupt, and never wait for the debugger.

use crate::board::Board;
use defmt_rtt as _;
use picket_dsp::acquire::frontend::Counters;
use picket_instrument::End;
use picket_wire::boot::{Causes, LastEnd};
use picket_wire::settings::Settings;

/// Tells of the last program's end and of this one's start.
pub fn start<B: Board<N, SLOT>, const N: usize, const SLOT: usize>(
    board: &B,
    causes: Causes,
    last: &LastEnd,
) {
    if last.kind != 0 {
        defmt::error!("the last program ended: kind {}, pc {:#x}", last.kind, last.pc);
    }
    let (name, cause) = (B::NAME, causes.message());
    defmt::info!("{} started by {}, program {:08x}", name, cause, B::program());
    let clocks = board.clocks();
    defmt::info!("{} Hz from {}", clocks.core_hz, clocks.source.name());
}

/// Tells of the settings in use.
pub fn settings(settings: &Settings, measuring: bool) {
    let rate_hz = settings.config.rate_hz;
    let (iq, guard, slots) = (settings.iq, settings.guard, settings.slots);
    defmt::info!("{} S/s, iq {}, guard {}, slots {}", rate_hz, iq, guard, slots);
    if measuring {
        defmt::info!("measuring");
    } else {
        defmt::warn!("stopped");
    }
}

/// Tells of the end of this program.
pub fn end(end: &End) {
    match end {
        End::Restart(_) => defmt::info!("restarts with other settings"),
        End::Reboot => defmt::info!("restarts"),
    }
}

/// Tells of losses and faults, once a second.
#[derive(Debug, Default)]
pub struct Losses {
    since: u32,
    seen: Counters,
}

impl Losses {
    /// Looks at the board's counters, if a second has passed.
    pub fn look<B: Board<N, SLOT>, const N: usize, const SLOT: usize>(&mut self, board: &B) {
        let now = board.ticks();
        if now.wrapping_sub(self.since) < board.clocks().ticks_hz {
            return;
        }
        self.since = now;
        let counters = board.counters();
        let new = counters.since(&core::mem::replace(&mut self.seen, counters));
        if new.faults() > 0 {
            defmt::error!("faults: {}", new);
        } else if new.lost() > 0 {
            defmt::warn!("lost {} of {} blocks", new.lost(), new.filled());
        }
    }
}

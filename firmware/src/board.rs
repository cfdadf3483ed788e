//! The requirements of the instrument's loop on a board. `docs/own-board.md` describes a board with only a timer and a serial port.

use crate::instrument::plan::Plan;
use crate::slot::Slot;
use picket_dsp::acquire::frontend::Blocks;
pub use picket_instrument::{Clocks, Port};
use picket_wire::boot::Causes;
use picket_wire::settings::Settings;

/// A board whose blocks have `N` samples, in slots of `WORDS` words: `N` words, and a guard's words if the board has chirps. It is what the
/// instrument needs of a board, a [`Port`], and what the loop around it needs.
///
/// Settings take effect by a restart, so there is only one way into operation. Every method returns
/// within bounded time.
pub trait Board<const N: usize, const WORDS: usize>:
    Port<N, WORDS, Storage: Default, Slots = Blocks<'static, Slot<WORDS>>> + Sized
{
    /// The causes of the chip's reset. The instrument reads them once, before [`Board::start`].
    fn causes() -> Causes {
        Causes::default()
    }

    /// Sets up clocks, pins, a timer that never stops, the watchdog and the line to the host.
    /// `None` at the second call.
    fn start(settings: &Settings) -> Option<Self>;

    /// The clocks that the start has set up.
    fn clocks(&self) -> Clocks;

    /// Starts the converter, once. Returns the main loop's end of the blocks; `None` at the second call.
    fn sample(
        &mut self,
        plan: &Plan<N>,
        words: &Self::Words,
    ) -> Option<Blocks<'static, Slot<WORDS>>>;

    /// Whether a better clock than that of [`Board::clocks`] is there again, so that a restart would use it. The loop asks in every turn.
    fn clock_returned(&mut self) -> bool {
        false
    }

    /// The next byte from the host; `None` if none waits.
    fn receive(&mut self) -> Option<u8>;

    /// Waits, within bounded time, until the line has sent everything. The instrument calls it
    /// before a restart.
    fn flush(&mut self);

    /// Sleeps until an interrupt, at most some tenths of a second: the loop feeds the watchdog. Returns at once if a block or a byte is
    /// waiting.
    fn sleep(&mut self, blocks: Option<&Blocks<'static, Slot<WORDS>>>);

    /// The CRC-32 of the program in flash; 0 if unknown.
    fn program() -> u32 {
        0
    }
}

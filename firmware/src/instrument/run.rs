//! The instrument's loop on a chip: it passes bytes and blocks of a board to the instrument, and turns the instrument's ends into resets.

use super::crashes::Crashes;
use super::handover::{self, Handover, words};
use super::meter::Meters;
use super::stack;
use crate::board::Board;
use picket_dsp::acquire::frontend::Blocks;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_instrument::bounds::HEARD;
use picket_instrument::meter::Meter;
use picket_instrument::{End, Start};

/// The instrument on a board. `M` measures real records, `Q` I/Q records.
pub struct Instrument<B, const N: usize, const SLOT: usize, M, Q>
where
    B: Board<N, SLOT>,
    M: Meter<Real, N> + 'static,
    Q: Meter<Iq, N> + 'static,
{
    board: B,
    crashes: Crashes,
    inner: picket_instrument::Instrument<'static, B, N, SLOT, M, Q>,
}

impl<B, const N: usize, const SLOT: usize, M, Q> Instrument<B, N, SLOT, M, Q>
where
    B: Board<N, SLOT>,
    M: Meter<Real, N>,
    Q: Meter<Iq, N>,
{
    /// Takes the instrument from reset to its loop, with the image's [`meters`](crate::meters).
    /// `None` only at the second call.
    // Not inlined, so that the stack of the start is free again afterwards.
    #[inline(never)]
    pub fn start(meters: Option<&'static mut Meters<M, Q>>) -> Option<Self> {
        let Handover { last, settings: left, saves } = Handover::take();
        let causes = B::causes();
        let crashes = handover::count(causes, &last);
        let storage = B::Storage::default();
        let mut start = Start::new::<N>(left, &storage, crashes);
        let mut board = B::start(&start.settings)?;
        #[cfg(feature = "defmt")]
        super::log::start(&board, causes, &last);
        (start.causes, start.last, start.saves, start.program) =
            (causes, last, saves, B::program());
        start.clocks = board.clocks();
        start.stack = Some(stack::high_water);
        let (mut inner, words) =
            picket_instrument::Instrument::new(&board, start, storage, meters?)?;
        // Last, so that no block passes before the loop runs.
        let starts = inner.plan().settings.start;
        let blocks = if starts { board.sample(inner.plan(), &words) } else { None };
        #[cfg(feature = "defmt")]
        super::log::settings(&inner.plan().settings, blocks.is_some());
        inner.begin(&mut board, blocks);
        Some(Self { board, crashes, inner })
    }

    /// Runs until a reset.
    pub fn run(mut self) -> ! {
        #[cfg(feature = "defmt")]
        let mut losses = super::log::Losses::default();
        loop {
            #[cfg(feature = "defmt")]
            losses.look(&self.board);
            for _ in 0..HEARD {
                let Some(byte) = self.board.receive() else { break };
                if let Some(end) = self.inner.on_byte(&mut self.board, byte) {
                    self.end(end);
                }
            }
            let block = self.inner.slots().and_then(Blocks::receive);
            let blocked = block.is_some();
            if let Some(block) = block {
                self.inner.on_block(&mut self.board, block);
            }
            self.inner.poll(&mut self.board);
            handover::lives(self.crashes, self.inner.seconds());
            if self.board.clock_returned() {
                let end = self.inner.again();
                self.end(end);
            }
            if !(blocked || self.inner.works()) {
                let before = self.board.ticks();
                self.board.sleep(self.inner.slots().as_deref());
                self.inner.slept(self.board.ticks().wrapping_sub(before));
            }
        }
    }

    /// Starts the next program by a reset, once the last answer is out.
    fn end(&mut self, end: End) -> ! {
        #[cfg(feature = "defmt")]
        super::log::end(&end);
        self.board.flush();
        let settings = match end {
            End::Restart(settings) => Some(words(&settings, N)),
            End::Reboot => None,
        };
        Handover { settings, saves: self.inner.saves(), ..Handover::default() }.leave()
    }
}

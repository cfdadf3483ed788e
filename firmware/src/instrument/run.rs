//! The instrument's loop on a chip: it passes bytes and blocks of a board to the instrument, and turns the instrument's ends into resets.

use super::crashes::Crashes;
use super::handover::{self, Handover, words};
use super::meter::Meters;
use super::plan::Plan;
use super::stack::Stack;
use crate::board::Board;
use crate::slot::Slot;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Blocks, Counters};
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::pipeline::Measurement;
use picket_instrument::bounds::HEARD;
use picket_instrument::meter::Meter;
use picket_instrument::{End, Port, Start};
use picket_wire::boot::Clock;
use picket_wire::settings::Settings;
use picket_wire::settings_error::SettingsError;

/// A board as the instrument sees it.
struct Wired<B: Board<N, SLOT>, const N: usize, const SLOT: usize> {
    board: B,
    storage: B::Storage,
    blocks: Option<Blocks<'static, Slot<SLOT>>>,
    stack: Stack,
    crashes: Crashes,
}

impl<B: Board<N, SLOT>, const N: usize, const SLOT: usize> Port<N, SLOT> for Wired<B, N, SLOT> {
    const NAME: &'static str = B::NAME;
    const CODES: Codes = B::CODES;
    type Words = B::Words;
    type Storage = B::Storage;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, B::Words), SettingsError> {
        self.board.plan(settings)
    }

    fn correct(&self, slot: &mut Slot<SLOT>) {
        self.board.correct(slot);
    }

    fn widen(&self, measurement: &mut Measurement) {
        self.board.widen(measurement);
    }

    fn release(&mut self, slot: Slot<SLOT>) {
        if let Some(blocks) = &mut self.blocks {
            blocks.release(slot);
        }
    }

    fn counters(&self) -> Counters {
        self.board.counters()
    }

    fn clock(&self) -> Clock {
        self.board.clock()
    }

    fn core_hz(&self) -> u32 {
        self.board.core_hz()
    }

    fn ticks(&self) -> u32 {
        self.board.ticks()
    }

    fn ticks_hz(&self) -> u32 {
        self.board.ticks_hz()
    }

    fn has_room(&self, bytes: usize) -> bool {
        self.board.has_room(bytes)
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        self.board.send(frame)
    }

    fn storage(&mut self) -> &mut B::Storage {
        &mut self.storage
    }

    fn pause(&mut self) {
        self.board.pause();
    }

    fn resume(&mut self) {
        self.board.resume();
    }

    fn gate_opened(&mut self) -> bool {
        self.board.gate_opened()
    }

    fn stalled(&mut self) -> bool {
        self.board.stalled()
    }

    fn feed(&mut self) {
        self.board.feed();
    }

    fn self_test(&mut self) -> bool {
        self.board.self_test()
    }

    fn lives(&mut self, seconds: u32) {
        handover::lives(self.crashes, seconds);
    }

    fn stack(&mut self) -> u32 {
        self.stack.high_water()
    }
}

/// The instrument on a board. `M` measures real records, `Q` I/Q records.
pub struct Instrument<B, const N: usize, const SLOT: usize, M, Q>
where
    B: Board<N, SLOT>,
    M: Meter<Real, N> + 'static,
    Q: Meter<Iq, N> + 'static,
{
    wired: Wired<B, N, SLOT>,
    inner: picket_instrument::Instrument<'static, Wired<B, N, SLOT>, N, SLOT, M, Q>,
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
        let board = B::start(&start.settings)?;
        #[cfg(feature = "defmt")]
        super::log::start(&board, causes, &last);
        (start.causes, start.last, start.saves, start.program) =
            (causes, last, saves, B::program());
        let mut wired = Wired { board, storage, blocks: None, stack: Stack::unknown(), crashes };
        let (mut inner, words) = picket_instrument::Instrument::new(&wired, start, meters?)?;
        // Last, so that no block passes before the loop runs.
        if inner.plan().settings.start {
            wired.blocks = wired.board.sample(inner.plan(), &words);
        }
        let measuring = wired.blocks.is_some();
        #[cfg(feature = "defmt")]
        super::log::settings(&inner.plan().settings, measuring);
        inner.begin(&mut wired, measuring);
        Some(Self { wired, inner })
    }

    /// Runs until a reset.
    pub fn run(mut self) -> ! {
        #[cfg(feature = "defmt")]
        let mut losses = super::log::Losses::default();
        loop {
            #[cfg(feature = "defmt")]
            losses.look(&self.wired.board);
            for _ in 0..HEARD {
                let Some(byte) = self.wired.board.receive() else { break };
                if let Some(end) = self.inner.on_byte(&mut self.wired, byte) {
                    self.end(end);
                }
            }
            let block = self.wired.blocks.as_mut().and_then(Blocks::receive);
            let blocked = block.is_some();
            if let Some(block) = block {
                self.inner.on_block(&mut self.wired, block);
            }
            self.inner.poll(&mut self.wired);
            if self.wired.board.clock_returned() {
                let end = self.inner.again();
                self.end(end);
            }
            if !(blocked || self.inner.works()) {
                let before = self.wired.board.ticks();
                self.wired.board.sleep(self.wired.blocks.as_ref());
                self.inner.slept(self.wired.board.ticks().wrapping_sub(before));
            }
        }
    }

    /// Starts the next program by a reset, once the last answer is out.
    fn end(&mut self, end: End) -> ! {
        #[cfg(feature = "defmt")]
        super::log::end(&end);
        self.wired.board.flush();
        let settings = match end {
            End::Restart(settings) => Some(words(&settings, N)),
            End::Reboot => None,
        };
        Handover { settings, saves: self.inner.saves(), ..Handover::default() }.leave()
    }
}

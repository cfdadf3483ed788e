//! A stand-in for an analog-to-digital converter on AN505 and AN547: samples of a capture in the
//! board's large memory, a timer for the sample clock, PL081 or a copy by the core for the DMA.
//!
//! Each interrupt of the timer "converts" a block: the controller copies it into the slot that it
//! holds. The controller's terminal-count interrupt then hands the slot over. Neither interrupt
//! waits or logs.

use super::halt::{Exit, exit};
use super::playback::Playback;
use super::{self as mps2, CLOCK_HZ, DMA_IRQ, Dma as Controller, Timer};
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::interrupt::{Mutex, free};
use picket_dsp::acquire::frontend::{Blocks, Counters, Dma, Filler, FrontEnd, Status};
use picket_dsp::acquire::sample::Record;
use picket_dsp::spectrum::fft::twiddle::MAX_LENGTH;
use picket_wire::capture::Header;
use static_cell::ConstStaticCell;

/// Memory of a block of any kind and length: 4 bytes for each sample of the longest I/Q record.
type Memory = [u32; MAX_LENGTH];
type Slot = crate::slot::Slot<MAX_LENGTH>;

/// The input of the converter: 16 MiB of AN505's PSRAM, or of AN547's DDR memory.
#[derive(Debug)]
pub struct Input(&'static mut [u32]);

impl Input {
    const START: usize = if cfg!(an505) { 0x8000_0000 } else { 0x7000_0000 };
    const WORDS: usize = (16 << 20) / 4;

    /// The input; `None` at the second call.
    pub fn take() -> Option<Self> {
        static TAKEN: AtomicBool = AtomicBool::new(false);
        if TAKEN.swap(true, Ordering::Relaxed) {
            return None;
        }
        // SAFETY: the board has this memory at this address. The linker script does not use it, and this is
        // the only reference to it. Any bits are valid words.
        let words = unsafe {
            core::slice::from_raw_parts_mut(
                core::ptr::with_exposed_provenance_mut(Self::START),
                Self::WORDS,
            )
        };
        Some(Input(words))
    }

    /// Reads up to `blocks` blocks of `words` words. Returns the number of blocks that have room.
    pub fn read(&mut self, playback: &mut Playback, words: usize, blocks: u32) -> u32 {
        let room = self.0.len().checked_div(words).unwrap_or(0) as u32;
        let count = blocks.min(room);
        if let Some(used) = self.0.get_mut(..count as usize * words) {
            // SAFETY: the words seen as bytes, with the same extent and lifetime.
            let bytes = unsafe {
                core::slice::from_raw_parts_mut(used.as_mut_ptr().cast(), size_of_val(used))
            };
            playback.read(bytes);
        }
        count
    }
}

/// The converter and its DMA controller, with the slot being filled.
pub struct PlayedConverter {
    controller: Controller,
    slot: Slot,
    words: usize,
    input: Option<Input>,
    next: usize,
    blocks: u32,
    interrupts: Interrupts,
}

/// The number of interrupts of each kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Interrupts {
    /// Interrupts of the timer.
    pub timer: u32,
    /// Interrupts of the DMA controller.
    pub dma: u32,
}

impl PlayedConverter {
    /// Converts the next block, or stops the timer if there is none.
    fn convert(&mut self) {
        self.interrupts.timer = self.interrupts.timer.wrapping_add(1);
        let source = self.input.as_ref().filter(|_| self.blocks > 0);
        let source = source.and_then(|input| input.0.get(self.next..)?.get(..self.words));
        let Some((source, place)) = source.zip(self.slot.memory().get_mut(..self.words)) else {
            Timer::ZERO.stop();
            return;
        };
        // SAFETY: the input does not change while the converter has it. The slot is exchanged only after the transfer's end (`Filler` reads
        // `status` first). The converter lives in a static.
        let started = unsafe { self.controller.start(source, place) };
        self.blocks -= u32::from(started);
        self.next += self.words;
    }
}

impl Dma for PlayedConverter {
    type Slot = Slot;

    fn status(&mut self) -> Status {
        self.interrupts.dma = self.interrupts.dma.wrapping_add(1);
        Status { completed: self.controller.finish().into(), ..Status::default() }
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        Ok(core::mem::replace(&mut self.slot, empty))
    }

    fn restart(&mut self) -> u32 {
        1
    }
}

static FILLER: Mutex<RefCell<Option<Filler<'static, PlayedConverter>>>> =
    Mutex::new(RefCell::new(None));

/// Runs `work` on the interrupts' half; `None` before that half exists.
fn with_filler<T>(work: impl FnOnce(&mut Filler<'static, PlayedConverter>) -> T) -> Option<T> {
    free(|token| FILLER.borrow(token).try_borrow_mut().ok()?.as_mut().map(work))
}

/// The interrupt of the converter's clock.
pub extern "C" fn timer() {
    Timer::ZERO.clear();
    with_filler(|filler| filler.dma().convert());
}

extern "C" fn transferred() {
    with_filler(Filler::interrupt);
}

/// The interrupts' part of the vector table.
pub const HANDLERS: mps2::Handlers = mps2::handlers(&[
    #[cfg(an505)]
    (mps2::TIMER_IRQ, timer),
    (DMA_IRQ, transferred),
]);

/// The main loop's end of the front end.
pub struct Acquisition {
    blocks: Blocks<'static, Slot>,
    input: Option<Input>,
    words: usize,
    ticks: u32,
}

/// Emulated time skips the core's sleep, so a block may take a second.
const PERIOD_US: u32 = 1_000_000;

impl Acquisition {
    /// Sets up the front end for blocks as `header` describes; `None` at the second call.
    pub fn new(header: &Header) -> Option<Self> {
        static MEMORY: [ConstStaticCell<Memory>; 2] =
            [const { ConstStaticCell::new([0; MAX_LENGTH]) }; 2];
        static FRONT_END: ConstStaticCell<FrontEnd<Slot, 2>> =
            ConstStaticCell::new(FrontEnd::new());
        let [first, second] = &MEMORY;
        let (slot, spare) = (Slot::new(first.try_take()?), Slot::new(second.try_take()?));
        let words = header.block_bytes() / 4;
        let converter = PlayedConverter {
            controller: Controller::new(),
            slot,
            words,
            input: None,
            next: 0,
            blocks: 0,
            interrupts: Interrupts::default(),
        };
        let (filler, blocks) = FRONT_END.try_take()?.split(converter, header.timing(), [spare]);
        free(|token| {
            if let Ok(mut place) = FILLER.borrow(token).try_borrow_mut() {
                *place = Some(filler);
            }
        });
        Timer::ZERO.enable();
        mps2::enable(DMA_IRQ);
        let period = if header.period_us == 0 { PERIOD_US } else { header.period_us };
        let ticks = u64::from(period) * u64::from(CLOCK_HZ / 1_000_000);
        let ticks = ticks.min(u32::MAX.into()) as u32;
        Some(Self { blocks, input: Input::take(), words, ticks })
    }

    /// Converts the whole capture and runs `work` on each block, with the counters up to it. The
    /// converter's clock stands still while the input is refilled.
    pub fn play<R: Record, const N: usize>(
        &mut self,
        playback: &mut Playback,
        mut work: impl FnMut(&picket_dsp::acquire::sample::Stamp, &Counters, &[R::Sample; N]),
    ) -> (Counters, Interrupts) {
        let mut left = playback.header.blocks;
        while left > 0 {
            let Some(mut input) = self.input.take() else {
                exit(Exit::Stalled);
            };
            let count = input.read(playback, self.words, left);
            left = left.saturating_sub(count);
            with_filler(|filler| {
                let converter = filler.dma();
                converter.input = Some(input);
                converter.next = 0;
                converter.blocks = count;
            });
            Timer::ZERO.start(self.ticks);
            while self.input.is_none() {
                let more = self.blocks.process(|stamp, counters, slot| {
                    work(stamp, counters, slot.samples::<R, N>(0));
                });
                if more.is_none() {
                    self.input = self.sleep();
                }
            }
        }
        with_filler(|filler| (*filler.counters(), filler.dma().interrupts)).unwrap_or_default()
    }

    /// Sleeps until an interrupt, unless a block waits. Returns the input when it is used up and
    /// every block was taken.
    fn sleep(&mut self) -> Option<Input> {
        free(|token| {
            if self.blocks.waiting() {
                return None;
            }
            let mut filler = FILLER.borrow(token).try_borrow_mut().ok()?;
            let converter = filler.as_mut()?.dma();
            if converter.blocks == 0 && !Timer::ZERO.running() {
                return converter.input.take();
            }
            // An interrupt ends the sleep, though it is served only after the critical section.
            cortex_m::asm::wfi();
            None
        })
    }
}

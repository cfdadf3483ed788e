//! A stream that fills two slots in turn, register by register: DMA2's stream 0 of an STM32F4 in double-buffer mode (RM0390,
//! 9.3.10), and a driver that does to it what `firmware/src/nucleo_f446re/converter.rs` does to the chip, in the same order, and counts
//! by the same code. Time may pass before every access, so every fault can come at every step of the hand-over.

use picket_dsp::acquire::frontend::{Dma, Status};
use picket_firmware::nucleo_f446re::words::passage::{Elapsed, Look, Passage};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// The longest block, samples.
pub const LONGEST: usize = 12;
/// Ticks of the timer in a sample.
const TICKS: u64 = 180;
/// The right to a piece of the stream's memory. Neither `Copy` nor `Clone`, as the front end asks.
#[derive(Debug)]
pub struct Slot(usize);

/// The stream, its memory, and the time.
#[derive(Debug)]
pub struct Hardware {
    /// Samples in a block.
    pub length: u64,
    /// By how much the stamps' clock advances from block to block.
    pub period: u32,
    /// Samples since power-on.
    pub now: u64,
    /// Ticks at power-on.
    offset: u32,
    memory: Vec<[u64; LONGEST]>,
    address: [usize; 2],
    running: bool,
    target: bool,
    complete: bool,
    broken: bool,
    overrun: bool,
    /// Whether an interrupt is pending.
    pub pending: bool,
    /// When this run of the stream began, and the number of its first block.
    begun: (u64, u64),
    /// Samples that pass before the next accesses, one after the other.
    pub held_up: VecDeque<u64>,
}

impl Hardware {
    /// A stream that stands still, with memory for this many slots.
    pub fn new(length: u64, period: u32, slots: usize, offset: u32) -> Self {
        Self {
            length,
            period,
            now: 0,
            offset,
            memory: vec![[u64::MAX; LONGEST]; slots],
            address: [0, 1],
            running: false,
            target: false,
            complete: false,
            broken: false,
            overrun: false,
            pending: false,
            begun: (0, 0),
            held_up: VecDeque::new(),
        }
    }

    /// The number of the block that is being filled, or would be.
    pub fn number(&self) -> u64 {
        self.begun.1 + (self.now - self.begun.0) / self.length
    }

    /// Time passes, and the stream fills its slots. Each sample is its own clock.
    pub fn run(&mut self, samples: u64) {
        for _ in 0..samples {
            if self.running {
                let (index, number) = ((self.now - self.begun.0) % self.length, self.number());
                let value = number.wrapping_mul(self.period.into()).wrapping_add(index);
                self.memory[self.address[usize::from(self.target)]][index as usize] = value;
                if index + 1 == self.length {
                    self.target = !self.target;
                    self.complete = true;
                    self.pending = true;
                }
            }
            self.now += 1;
        }
    }

    /// The samples of a block in this slot.
    pub fn samples(&self, slot: &Slot) -> &[u64] {
        &self.memory[slot.0][..self.length as usize]
    }

    /// A transfer fails.
    pub fn fail(&mut self) {
        (self.running, self.pending) = (false, true);
        self.broken = true;
    }

    /// The converter has a sample before the last one was fetched.
    pub fn overrun(&mut self) {
        (self.running, self.pending, self.overrun) = (false, true, true);
    }

    fn access(&mut self) {
        let samples = self.held_up.pop_front().unwrap_or(0);
        self.run(samples);
    }

    fn ticks(&mut self) -> u32 {
        self.access();
        self.offset.wrapping_add(self.now.wrapping_mul(TICKS) as u32)
    }

    /// A write to the address in use stops the stream with an error.
    fn set_address(&mut self, which: bool, slot: &Slot) {
        self.access();
        if self.running && self.target == which {
            return self.fail();
        }
        self.address[usize::from(which)] = slot.0;
    }
}

/// The driver.
pub struct Chain {
    hardware: Rc<RefCell<Hardware>>,
    held: [Slot; 2],
    passage: Passage,
    /// Blocks that the next restart leaves out besides: a long time at once, so that counts wrap.
    pub skips: u32,
}

impl Chain {
    /// The driver, and the slots that it does not hold.
    pub fn new(hardware: Rc<RefCell<Hardware>>, segments: usize) -> (Self, Vec<Slot>) {
        let (slots, block) = {
            let hardware = hardware.borrow();
            (hardware.memory.len(), hardware.length * TICKS)
        };
        let chain = Chain {
            hardware,
            held: [Slot(0), Slot(1)],
            passage: Passage::new(segments, Elapsed::new(Some(block))),
            skips: 0,
        };
        (chain, (2..slots).map(Slot).collect())
    }

    /// Stops the stream.
    pub fn stop(&mut self) {
        let mut hardware = self.hardware.borrow_mut();
        hardware.access();
        hardware.running = false;
        hardware.access();
        (hardware.complete, hardware.broken) = (false, false);
    }

    /// Starts it at the first sample of a chirp, as block `number`.
    pub fn start(&mut self, number: u64) {
        let mut hardware = self.hardware.borrow_mut();
        hardware.address = [self.held[0].0, self.held[1].0];
        (hardware.target, hardware.overrun, hardware.running) = (false, false, true);
        hardware.begun = (hardware.now, number);
        let held_up = std::mem::take(&mut hardware.held_up);
        self.passage.begin(hardware.ticks());
        hardware.held_up = held_up;
    }
}

impl Dma for Chain {
    type Slot = Slot;

    fn status(&mut self) -> Status {
        let mut hardware = self.hardware.borrow_mut();
        let now = hardware.ticks();
        hardware.access();
        let (complete, broken) = (hardware.complete, hardware.broken);
        hardware.access();
        let target = hardware.target;
        hardware.access();
        hardware.complete &= !complete;
        hardware.broken &= !broken;
        hardware.access();
        let adc_overrun = hardware.overrun;
        self.passage.status(Look { now, complete, target, broken, adc_overrun })
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        let seen = self.passage.target();
        let place = usize::from(!seen);
        self.hardware.borrow_mut().set_address(!seen, &empty);
        let full = std::mem::replace(&mut self.held[place], empty);
        let target = {
            let mut hardware = self.hardware.borrow_mut();
            hardware.access();
            hardware.target
        };
        if target == seen {
            return Ok(full);
        }
        let empty = std::mem::replace(&mut self.held[place], full);
        self.stop();
        self.passage.stop();
        self.hardware.borrow_mut().pending = true;
        Err(empty)
    }

    fn restart(&mut self) -> u32 {
        self.stop();
        let (late, next) = {
            let mut hardware = self.hardware.borrow_mut();
            // The truth, by the stream's own count.
            (self.passage.late(hardware.ticks()), hardware.number() + 1)
        };
        let skips = std::mem::take(&mut self.skips);
        let skipped = self.passage.skip(late.saturating_add(skips));
        let beyond = u64::from(skipped) - u64::from(late);
        self.start(next + beyond);
        skipped
    }
}

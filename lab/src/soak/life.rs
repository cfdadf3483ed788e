//! A life of the front end, from power-on through random faults to a quiet end, against what must come out.

use super::same;
use super::stream::{Chain, Hardware, LONGEST, Slot};
use super::tally::{Fault, Tally};
use picket_dsp::acquire::frontend::{Block, Blocks, Counters, Filler, FrontEnd, Timing};
use picket_dsp::acquire::sample::Segment;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

const SEGMENTS: [&[Segment]; 4] = [
    &[],
    &[Segment::Up],
    &[Segment::Up, Segment::Down],
    &[Segment::Up, Segment::Flat, Segment::Down],
];

/// Events in a life.
const EVENTS: usize = 4000;

struct Life<'a> {
    rng: ChaCha8Rng,
    hardware: Rc<RefCell<Hardware>>,
    filler: Filler<'a, Chain>,
    blocks: Blocks<'a, Slot>,
    timing: Timing,
    held: VecDeque<Block<Slot>>,
    /// The number that would follow the last block received without a gap.
    follows: u64,
    received: u32,
    tally: Tally,
}

/// Lives life `number` of this seed.
///
/// # Errors
/// What came out is not what must; in a sentence.
pub fn live(seed: u64, number: u64) -> Result<Tally, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    match rng.random_range(1..=3) {
        1 => with_spares::<1>(rng),
        2 => with_spares::<2>(rng),
        _ => with_spares::<3>(rng),
    }
}

fn with_spares<const SPARES: usize>(mut rng: ChaCha8Rng) -> Result<Tally, String> {
    let length = rng.random_range(6..=LONGEST as u64);
    // With so long a period the clock wraps after some 2^32 blocks, about where the sequence wraps, too.
    let wraps = rng.random_bool(0.5);
    let period = if wraps { u32::MAX - rng.random_range(0..9) } else { length as u32 };
    let segments = SEGMENTS[rng.random_range(0..SEGMENTS.len())];
    let timing = Timing { period, segments };
    let hardware = Hardware::new(length, period, 2 + SPARES, rng.random());
    let hardware = Rc::new(RefCell::new(hardware));
    let (chain, spares) = Chain::new(hardware.clone(), segments.len());
    let spares: [Slot; SPARES] = spares.try_into().map_err(|_| "slots")?;
    let mut front_end = FrontEnd::<Slot, 4>::new();
    let (filler, blocks) = front_end.split(chain, timing, spares);
    let (held, tally) = (VecDeque::new(), Tally { lives: 1, ..Tally::default() });
    let mut life =
        Life { rng, hardware, filler, blocks, timing, held, follows: 0, received: 0, tally };
    life.filler.dma().start(0);
    if wraps {
        let before = life.rng.random_range(0..2 * EVENTS as u32);
        life.pause(u32::MAX - before);
    }
    for _ in 0..EVENTS {
        life.event()?;
    }
    life.quiet()?;
    let Counters { blocks, overruns, .. } = *life.filler.counters();
    life.tally.blocks += u64::from(blocks);
    life.tally.faults[Fault::Stall as usize] += u64::from(overruns);
    life.tally.lost += u64::from(life.filler.counters().filled().wrapping_sub(blocks));
    life.tally.wraps += u64::from(life.follows > u64::from(u32::MAX));
    Ok(life.tally)
}

impl Life<'_> {
    fn event(&mut self) -> Result<(), String> {
        match self.rng.random_range(0..100) {
            0..40 => {
                self.end_of_a_block();
                self.serve();
            }
            40..48 => self.held_up(),
            48..54 => self.late(),
            54..58 => {
                self.tally.fault(Fault::Doubled);
                self.filler.interrupt();
            }
            58..60 => {
                self.tally.fault(Fault::Transfer);
                self.hardware.borrow_mut().fail();
            }
            60..62 => {
                self.tally.fault(Fault::Overrun);
                self.hardware.borrow_mut().overrun();
            }
            62 => {
                self.tally.fault(Fault::Pause);
                self.pause(0);
            }
            63..82 => self.receive()?,
            _ => self.release()?,
        }
        Ok(())
    }

    fn run(&mut self, samples: u64) {
        self.hardware.borrow_mut().run(samples);
    }

    fn end_of_a_block(&mut self) {
        let mut hardware = self.hardware.borrow_mut();
        for _ in 0..hardware.length {
            hardware.run(1);
            if hardware.pending {
                break;
            }
        }
    }

    fn serve(&mut self) {
        if std::mem::take(&mut self.hardware.borrow_mut().pending) {
            self.filler.interrupt();
        }
    }

    /// The interrupt is held up at any of its accesses, for less than a block in all.
    fn held_up(&mut self) {
        self.tally.fault(Fault::HeldUp);
        let before = self.rng.random_range(0..4);
        self.end_of_a_block();
        self.run(before);
        let mut left = self.hardware.borrow().length - 1;
        let steps: VecDeque<u64> = (0..10)
            .map(|_| {
                let most = if self.rng.random_bool(0.7) { 0 } else { left };
                let samples = self.rng.random_range(0..=most);
                left -= samples;
                samples
            })
            .collect();
        self.hardware.borrow_mut().held_up = steps;
        self.serve();
        self.hardware.borrow_mut().held_up.clear();
    }

    /// Interrupts are not served for a while.
    fn late(&mut self) {
        self.tally.fault(Fault::Late);
        let length = self.hardware.borrow().length;
        let samples = match self.rng.random_range(0..8) {
            0 => self.rng.random_range(0..40 * length),
            _ => self.rng.random_range(0..4 * length),
        };
        self.run(samples);
        self.serve();
    }

    /// The samples stop, as while settings are saved, and start again; a long pause passes at once.
    fn pause(&mut self, skips: u32) {
        self.filler.dma().stop();
        let samples = self.rng.random_range(0..30);
        self.run(samples);
        self.filler.dma().skips = skips;
        self.filler.restart();
        self.hardware.borrow_mut().pending = false;
    }

    fn receive(&mut self) -> Result<(), String> {
        let Some(block) = self.blocks.receive() else {
            let delivered = self.filler.counters().blocks;
            return same("blocks delivered", delivered, self.received);
        };
        self.received = self.received.wrapping_add(1);
        let number = self.check(&block)?;
        same("the gap before a block", block.stamp.gap, number != self.follows)?;
        same("blocks so far", block.counters.blocks, self.received)?;
        same("blocks and losses", block.counters.filled(), (number + 1) as u32)?;
        self.follows = number + 1;
        self.held.push_back(block);
        Ok(())
    }

    /// The samples of a block are those that its stamp tells. Returns its number.
    fn check(&self, block: &Block<Slot>) -> Result<u64, String> {
        let hardware = self.hardware.borrow();
        let samples = hardware.samples(&block.slot);
        for (index, &sample) in samples.iter().enumerate() {
            let clock = block.stamp.clock.wrapping_add(index as u64);
            same("a sample's clock", sample, clock)?;
        }
        // The low half of the number stands in the stamp; the rest is the stream's.
        let now = hardware.number();
        let number = now - u64::from((now as u32).wrapping_sub(block.stamp.sequence));
        let expected = self.timing.stamp(number, block.stamp.gap);
        same("a stamp", block.stamp, expected)?;
        Ok(number)
    }

    fn release(&mut self) -> Result<(), String> {
        let Some(block) = self.held.pop_front() else { return Ok(()) };
        // Nothing was written to it while it was the main loop's.
        let first = self.hardware.borrow().samples(&block.slot)[0];
        same("a sample while its block was held", first, block.stamp.clock)?;
        let hardware = self.hardware.borrow();
        let last = hardware.samples(&block.slot).last().copied().unwrap_or(0);
        let clock = block.stamp.clock.wrapping_add(hardware.length - 1);
        same("a sample while its block was held", last, clock)?;
        drop(hardware);
        self.blocks.release(block.slot);
        Ok(())
    }

    /// When the faults end, every block comes, without a gap, and the counts add up.
    fn quiet(&mut self) -> Result<(), String> {
        self.serve();
        self.serve();
        for round in 0..8 {
            while self.blocks.waiting() {
                self.receive()?;
            }
            while !self.held.is_empty() {
                self.release()?;
            }
            let (before, follows) = (self.received, self.follows);
            self.end_of_a_block();
            self.serve();
            if round > 2 {
                self.receive()?;
                same("blocks after the faults", self.received, before + 1)?;
                same("the number after the faults", self.follows, follows + 1)?;
            }
        }
        same("blocks filled", self.follows, self.hardware.borrow().number())
    }
}

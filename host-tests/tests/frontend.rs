//! The front end against a mock controller whose interrupts come late, early, doubled or not at all
//! and whose transfers fail.
//!
//! Every sample is its own clock, so a block that mixes two, or whose stamp is wrong, shows.

use picket_dsp::acquire::frontend::{Blocks, Counters, Dma, Filler, FrontEnd, Status, Timing};
use picket_dsp::acquire::sample::Segment;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

const N: u64 = 8;
const SEGMENTS: [Segment; 3] = [Segment::Up, Segment::Flat, Segment::Down];

type Slot = Box<[u64; N as usize]>;

/// A controller in time: the sample with clock `c` belongs to block `c / period`.
struct Machine {
    period: u64,
    /// One slot, or two that are filled in turn.
    held: Vec<Slot>,
    /// How often a fill of each held place has begun.
    begun: Vec<u32>,
    current: usize,
    clock: u64,
    /// The chain stands still before this clock; for ever after a fault.
    start: Option<u64>,
    /// Completed and not yet told, and the place and fill of the last.
    completed: u32,
    last: (usize, u32),
    told: (usize, u32),
    faults: Status,
    /// The first block not yet told of.
    next: u64,
    /// Samples that pass in the interrupt between question and exchange.
    delay: u64,
    /// What the counters should say.
    expected: Counters,
}

impl Machine {
    fn new(depth: usize, guard: u64) -> Self {
        Machine {
            period: N + guard,
            held: (0..depth).map(|_| Slot::default()).collect(),
            begun: vec![0; depth],
            current: 0,
            clock: 0,
            start: Some(0),
            completed: 0,
            last: (0, 0),
            told: (0, 0),
            faults: Status::default(),
            next: 0,
            delay: 0,
            expected: Counters::default(),
        }
    }

    /// One sample period.
    fn step(&mut self) {
        let index = self.clock % self.period;
        if self.start.is_some_and(|start| start <= self.clock) {
            if index == 0 {
                self.begun[self.current] += 1;
            }
            if index < N {
                self.held[self.current][index as usize] = self.clock;
            }
            if index == N - 1 {
                self.completed += 1;
                self.last = (self.current, self.begun[self.current]);
            }
            if index == self.period - 1 {
                self.current = (self.current + 1) % self.held.len();
            }
        }
        self.clock += 1;
    }

    fn run(&mut self, samples: u64) {
        (0..samples).for_each(|_| self.step());
    }

    /// Until a block is complete, or one could have been.
    fn run_block(&mut self) {
        for _ in 0..2 * self.period {
            let before = self.completed;
            self.step();
            if self.completed > before {
                break;
            }
        }
    }

    fn fail(&mut self, dma_error: bool) {
        self.start = None;
        self.faults.dma_error |= dma_error;
        self.faults.adc_overrun |= !dma_error;
    }
}

#[derive(Clone)]
struct Mock(Rc<RefCell<Machine>>);

impl Dma for Mock {
    type Slot = Slot;

    fn status(&mut self) -> Status {
        let machine = &mut *self.0.borrow_mut();
        let status = Status { completed: machine.completed, ..machine.faults };
        machine.next += u64::from(machine.completed);
        machine.told = machine.last;
        (machine.completed, machine.faults) = (0, Status::default());
        let expected = &mut machine.expected;
        if status.dma_error || status.adc_overrun {
            expected.dma_errors += u32::from(status.dma_error);
            expected.adc_overruns += u32::from(status.adc_overrun);
            expected.broken += status.completed;
        } else if status.completed == 0 {
            expected.spurious += 1;
        } else {
            expected.missed += status.completed - 1;
        }
        status
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        let machine = &mut *self.0.borrow_mut();
        let delay = std::mem::take(&mut machine.delay);
        machine.run(delay);
        let (place, fill) = machine.told;
        if machine.begun[place] == fill {
            machine.expected.blocks += 1;
            Ok(std::mem::replace(&mut machine.held[place], empty))
        } else {
            machine.expected.late += 1;
            Err(empty)
        }
    }

    fn restart(&mut self) -> u32 {
        let machine = &mut *self.0.borrow_mut();
        let block = machine.clock.div_ceil(machine.period).max(machine.next + 1);
        machine.start = Some(block * machine.period);
        machine.current = 0;
        let passed = (block - machine.next) as u32;
        machine.next = block;
        machine.expected.broken += passed;
        passed
    }
}

#[derive(Clone, Copy, Debug)]
enum Event {
    /// A block completes and its interrupt is served at once.
    Block,
    /// Time passes and no interrupt is served: what completes is lost or late.
    Pass(u64),
    /// An interrupt, whether or not there is cause for it.
    Interrupt,
    /// The next exchange is held up.
    Delay(u64),
    DmaError,
    AdcOverrun,
    /// The main loop takes a block, or gives back the one it has held longest.
    Receive,
    Release,
}

struct Bench<'a> {
    machine: Rc<RefCell<Machine>>,
    filler: Filler<'a, Mock>,
    blocks: Blocks<'a, Slot>,
    spares: u32,
    held: VecDeque<Slot>,
    received: u32,
    released: u32,
    /// The block that would follow the last one received without a gap.
    follows: u64,
    gaps: u32,
}

impl Bench<'_> {
    fn apply(&mut self, event: &Event) {
        match *event {
            Event::Block => {
                self.machine.borrow_mut().run_block();
                self.interrupt();
            }
            Event::Pass(samples) => self.machine.borrow_mut().run(samples),
            Event::Interrupt => self.interrupt(),
            Event::Delay(samples) => self.machine.borrow_mut().delay = samples,
            Event::DmaError => self.machine.borrow_mut().fail(true),
            Event::AdcOverrun => self.machine.borrow_mut().fail(false),
            Event::Receive => self.receive(),
            Event::Release => {
                if let Some(slot) = self.held.pop_front() {
                    self.blocks.release(slot);
                    self.released += 1;
                }
            }
        }
    }

    fn interrupt(&mut self) {
        {
            // The only fault the controller does not see: every spare slot is with the main loop.
            let machine = &mut *self.machine.borrow_mut();
            let whole = machine.completed > 0 && machine.faults == Status::default();
            if whole && machine.expected.blocks - self.released == self.spares {
                machine.expected.overruns += 1;
            }
        }
        self.filler.interrupt();
        let machine = self.machine.borrow();
        assert_eq!(*self.filler.counters(), machine.expected);
        assert_eq!(u64::from(self.filler.counters().filled()), machine.next, "delivered + lost");
    }

    fn receive(&mut self) {
        let Some(block) = self.blocks.receive() else {
            assert_eq!(self.filler.counters().blocks, self.received, "a block vanished");
            return;
        };
        self.received += 1;
        let stamp = block.stamp;
        let clocks = std::array::from_fn(|n| stamp.clock + n as u64);
        assert_eq!(*block.slot, clocks, "samples of {stamp:?}");
        let number = stamp.clock / self.machine.borrow().period;
        assert_eq!(stamp.clock % self.machine.borrow().period, 0);
        assert_eq!(u64::from(stamp.sequence), number);
        assert_eq!(stamp.segment, SEGMENTS[(number % 3) as usize]);
        assert_eq!(stamp.gap, number != self.follows, "gap of {stamp:?}");
        assert_eq!(block.counters.blocks, self.received);
        assert_eq!(u64::from(block.counters.filled()), number + 1);
        self.gaps += u32::from(stamp.gap);
        self.follows = number + 1;
        self.held.push_back(block.slot);
    }
}

/// Plays the events; gives the counters and the number of gaps.
fn play<const SPARES: usize>(depth: usize, guard: u64, events: &[Event]) -> (Counters, u32) {
    let machine = Rc::new(RefCell::new(Machine::new(depth, guard)));
    let timing = Timing { period: (N + guard) as u32, segments: &SEGMENTS };
    let mut front_end = FrontEnd::<Slot, 4>::new();
    let spares: [Slot; SPARES] = std::array::from_fn(|_| Slot::default());
    let (filler, blocks) = front_end.split(Mock(machine.clone()), timing, spares);
    let mut bench = Bench {
        machine,
        filler,
        blocks,
        spares: SPARES as u32,
        held: VecDeque::new(),
        received: 0,
        released: 0,
        follows: 0,
        gaps: 0,
    };
    events.iter().for_each(|event| bench.apply(event));
    // Whatever happened, the chain goes on: when all is given back, the second block at the latest
    // is delivered, and from then on without a gap.
    bench.machine.borrow_mut().delay = 0;
    bench.interrupt();
    // Restarts without any time between them begin that many blocks ahead.
    {
        let machine = &mut *bench.machine.borrow_mut();
        let ahead = machine.start.map_or(0, |start| start.saturating_sub(machine.clock));
        machine.run(ahead);
    }
    for _ in 0..8 {
        bench.receive();
        bench.apply(&Event::Release);
    }
    for round in 0..6 {
        let (before, gaps) = (bench.received, bench.gaps);
        bench.apply(&Event::Block);
        bench.receive();
        bench.apply(&Event::Release);
        if round > 1 {
            assert_eq!((bench.received, bench.gaps), (before + 1, gaps), "the chain stands still");
        }
    }
    (*bench.filler.counters(), bench.gaps)
}

fn play_any(spares: u8, depth: usize, guard: u64, events: &[Event]) -> (Counters, u32) {
    match spares {
        1 => play::<1>(depth, guard, events),
        2 => play::<2>(depth, guard, events),
        _ => play::<3>(depth, guard, events),
    }
}

/// Errors that follow each other at once, each restarted.
#[test]
fn errors_in_a_row_only_cost_time() {
    for count in 1..20 {
        let events = [Event::DmaError, Event::Interrupt].repeat(count);
        for spares in 1..=3 {
            play_any(spares, 1, 0, &events);
            play_any(spares, 2, 3, &events);
        }
    }
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        8 => Just(Event::Block),
        2 => (0..4 * N).prop_map(Event::Pass),
        2 => Just(Event::Interrupt),
        1 => (0..4 * N).prop_map(Event::Delay),
        1 => Just(Event::DmaError),
        1 => Just(Event::AdcOverrun),
        8 => Just(Event::Receive),
        8 => Just(Event::Release),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn any_faults_in_any_order(
        spares in 1u8..=3,
        depth in 1usize..=2,
        guard in 0u64..6,
        events in prop::collection::vec(event(), 0..200),
    ) {
        play_any(spares, depth, guard, &events);
    }
}

/// A long run in which every fault happens, so that the property above is known to see them.
#[test]
fn every_fault_is_met_and_counted() {
    println!("seed 11");
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for depth in [1, 2] {
        let events: Vec<Event> = (0..200_000)
            .map(|_| match rng.random_range(0..100) {
                0..40 => Event::Block,
                40..43 => Event::Pass(rng.random_range(0..3 * N)),
                43..46 => Event::Interrupt,
                46..48 => Event::Delay(rng.random_range(0..3 * N)),
                48 => Event::DmaError,
                49 => Event::AdcOverrun,
                50..75 => Event::Receive,
                _ => Event::Release,
            })
            .collect();
        let (counters, gaps) = play::<2>(depth, 2, &events);
        println!("depth {depth}: {counters:?}, {gaps} gaps");
        let Counters { blocks, overruns, missed, late, broken, spurious, dma_errors, adc_overruns } =
            counters;
        assert!(blocks > 20_000 && gaps > 1_000, "{counters:?}");
        for fault in [overruns, missed, late, broken, spurious, dma_errors, adc_overruns] {
            assert!(fault > 500, "{counters:?}");
        }
    }
}

#[test]
fn without_faults_nothing_is_lost() {
    let events = [Event::Block, Event::Receive, Event::Release].repeat(10_000);
    for (depth, spares) in [(1, 1), (2, 1), (2, 3)] {
        let (counters, gaps) = play_any(spares, depth, 0, &events);
        // The end of a run asks once without cause.
        let clean = Counters { blocks: 10_006, spurious: 1, ..Counters::default() };
        assert_eq!((counters, gaps), (clean, 0));
    }
}

#[test]
fn a_continuous_wave_has_no_segments() {
    let timing = Timing::continuous(1024);
    let stamp = timing.stamp((1 << 32) + 5, false);
    assert_eq!((stamp.sequence, stamp.clock), (5, ((1 << 32) + 5) * 1024));
    assert_eq!(stamp.segment, Segment::Continuous);
    // The chirp's phase goes on where the sequence wraps.
    let chirp = Timing { period: 1, segments: &SEGMENTS };
    let around: Vec<_> =
        ((1u64 << 32) - 1..=1 << 32).map(|n| chirp.stamp(n, false).segment).collect();
    assert_eq!(around, [Segment::Up, Segment::Flat]);
}

//! A whole life of an instrument, on a host: bytes of a host or of nobody, blocks or none, a line that stalls, flash that fails, power
//! that ends within any word's write, crashes and restarts. What is asserted is what a host can see.

use super::input::Input;
use super::measure::samples;
use picket_dsp::Usable;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Block, Counters};
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::pipeline::Measurement;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_instrument::crashes::Crashes;
use picket_instrument::every::Every;
use picket_instrument::meter;
use picket_instrument::plan::Plan;
use picket_instrument::slot::Slot;
use picket_instrument::storage::{self, PAGE, Page, Storage};
use picket_instrument::words::{WORDS, payload, words};
use picket_instrument::{Clocks, End, Instrument, Port, Slots, Start, checksum};
use picket_wire::boot::{Boot, Causes, Clock, LastEnd, Origin};
use picket_wire::command::{Answer, Command, Refusal, Request};
use picket_wire::frame::{Kind, Reader, WIRE};
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use picket_wire::settings_error::SettingsError;
use picket_wire::status::{Raw, Status};
use picket_wire::telemetry::Telemetry;
use std::cell::RefCell;
use std::rc::Rc;

/// Samples in a block.
const N: usize = 64;
/// Words of a slot: room for the longest guard.
const SLOT: usize = 128;
const SLOTS: usize = 3;
const TICKS_HZ: u32 = 1_000_000;
/// Bytes that wait for the line at most.
const QUEUE: usize = 1024;
/// Bytes of a status on the line: 57 of payload, and 8 around them.
const STATUS: usize = 66;

/// What the flash does wrong.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// It refuses, after it has done a part.
    Refuses,
    /// The power goes in the middle of it.
    Power,
}

/// Two pages, and the operations until one fails.
struct Flash {
    pages: [[u32; PAGE]; 2],
    fault: Option<(Fault, u8)>,
    /// The bits that the operation that fails has done.
    done: u32,
    /// The power is off.
    off: bool,
}

impl Flash {
    /// The bits that this operation does, and whether it succeeds.
    fn turn(&mut self) -> (u32, bool) {
        match &mut self.fault {
            _ if self.off => (0, false),
            Some((fault, 0)) => {
                self.off = *fault == Fault::Power;
                self.fault = None;
                (self.done, false)
            }
            Some((_, left)) => {
                *left -= 1;
                (u32::MAX, true)
            }
            None => (u32::MAX, true),
        }
    }
}

/// The flash, which the instrument and the bench hold.
#[derive(Clone)]
struct Chip(Rc<RefCell<Flash>>);

impl Storage for Chip {
    type Error = ();

    fn read(&self, page: Page, index: usize) -> u32 {
        self.0.borrow().pages[page as usize][index]
    }

    fn erase(&mut self, page: Page) -> Result<(), ()> {
        let mut flash = self.0.borrow_mut();
        let (done, fine) = flash.turn();
        flash.pages[page as usize].iter_mut().for_each(|word| *word |= done);
        fine.then_some(()).ok_or(())
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), ()> {
        let mut flash = self.0.borrow_mut();
        let (done, fine) = flash.turn();
        flash.pages[page as usize][index] &= word | !done;
        fine.then_some(()).ok_or(())
    }
}

/// What the instrument has around it, and what a host sees.
struct World {
    ticks: u32,
    flash: Chip,
    slots: Free,
    counters: Counters,
    /// Bytes that wait for the line, and whether it takes none.
    waits: usize,
    stuck: bool,
    /// Frames that it refused, since a host has reset the counts.
    refused: u32,
    fed: bool,
    host: Reader,
    seen: Vec<Seen>,
}

/// What an order is answered.
type Said = Result<Vec<u8>, Refusal>;

/// What a host understands of what the line took.
enum Seen {
    Boot(Boot),
    Status(Status),
    Telemetry(Telemetry),
    Raw(Raw),
    Answer(Answer, Said),
    Other,
}

impl World {
    /// Time passes, and the line sends 92,160 bytes a second.
    fn pass(&mut self, ticks: u32) {
        self.ticks = self.ticks.wrapping_add(ticks);
        if !self.stuck {
            self.waits =
                self.waits.saturating_sub((u64::from(ticks) * 92_160 / 1_000_000) as usize);
        }
    }
}

impl World {
    /// A block of the converter, if it found a slot: a tone of any frequency and noise.
    fn block(
        &mut self,
        plan: &Plan<N>,
        number: &mut u64,
        input: &mut Input,
    ) -> Option<Block<Slot<SLOT>>> {
        let [kind, shift, frequency, phase] = input.take();
        let missed = u32::from(kind & 0xF0 == 0xF0);
        self.counters.missed = self.counters.missed.wrapping_add(missed);
        *number += 1 + u64::from(missed);
        let Some(mut slot) = self.slots.0.borrow_mut().pop() else {
            self.counters.overruns = self.counters.overruns.wrapping_add(1);
            return None;
        };
        self.counters.blocks = self.counters.blocks.wrapping_add(1);
        let bytes = [kind | 1, shift, frequency, phase];
        let samples = samples::<Real, SLOT>(&mut Input(&bytes));
        for (word, pair) in slot.memory().iter_mut().zip(samples.iter().zip(samples.iter().rev())) {
            *word = u32::from(*pair.0 as u16) | u32::from(*pair.1 as u16) << 16;
        }
        let stamp = plan.timing.stamp(*number - 1, missed > 0);
        Some(Block { stamp, counters: self.counters, slot })
    }
}

/// The memory for the next blocks, which the instrument and the bench hold.
#[derive(Clone, Default)]
struct Free(Rc<RefCell<Vec<Slot<SLOT>>>>);

impl Slots<SLOT> for Free {
    fn release(&mut self, slot: Slot<SLOT>) {
        let mut slots = self.0.borrow_mut();
        slots.push(slot);
        assert!(slots.len() <= SLOTS);
    }
}

impl Port<N, SLOT> for World {
    const NAME: &'static str = "fuzz";
    const CODES: Codes = Codes::signed::<16>();
    type Words = ();
    type Storage = Chip;
    type Slots = Free;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, ()), SettingsError> {
        // A converter that runs at 1 MHz by a whole number.
        let nominal = settings.calibration.nominal_hz(settings.config.rate_hz);
        let period = (1e6 / nominal).round().clamp(1.0, 1e5);
        Ok((Plan::new(settings, 1e6 / period)?, ()))
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn ticks(&self) -> u32 {
        self.ticks
    }

    fn has_room(&self, bytes: usize) -> bool {
        QUEUE - self.waits >= bytes
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        assert!(!frame.is_empty() && frame.len() <= WIRE);
        if !self.has_room(frame.len()) {
            self.refused += 1;
            return false;
        }
        self.waits += frame.len();
        for &byte in frame {
            let Some(frame) = self.host.push(byte) else { continue };
            let frame = frame.expect("what the instrument sends is whole");
            self.seen.push(match frame.kind {
                Kind::Boot => Seen::Boot(Boot::from_frame(&frame).expect("a boot record")),
                Kind::Status => Seen::Status(Status::from_frame(&frame).expect("a status")),
                Kind::Telemetry => {
                    Seen::Telemetry(Telemetry::from_frame(&frame).expect("a record"))
                }
                Kind::Raw => Seen::Raw(Raw::from_frame(&frame).expect("a piece")),
                Kind::Reply | Kind::Refusal => {
                    let (answer, said) = Answer::from_frame(&frame).expect("an answer");
                    Seen::Answer(answer, said.map(<[u8]>::to_vec))
                }
                _ => Seen::Other,
            });
        }
        true
    }

    fn stalled(&mut self) -> bool {
        self.stuck && self.waits > 0
    }

    fn feed(&mut self) {
        self.fed = true;
    }
}

/// What a host knows of the instrument, from its frames alone.
struct Knows {
    /// The settings in force, and their checksum, which each record must name.
    settings: Settings,
    label: u32,
    measuring: bool,
    /// What may lie in the flash: one, or after a save that was cut off, two. None is nothing.
    kept: Vec<Option<Vec<u8>>>,
    /// The last status since the counters were reset.
    status: Option<Status>,
    /// The counters when they were.
    zero: Counters,
    sequence: Option<u32>,
    /// Whether a save was ever cut off or refused.
    torn: bool,
    statuses: u32,
    saves: u32,
    /// The word of [`Crashes`], which memory keeps.
    crashes: u32,
}

/// How a life begins.
#[derive(Default)]
struct Birth {
    left: Option<[u32; WORDS]>,
    causes: Causes,
    last: LastEnd,
}

/// What measures, of either kind of record.
type Meters = meter::Meters<Every<Real, N, CELLS>, Every<Iq, N, CELLS>>;

/// The cells of a frame: eight chirps of all bins, of either kind of record.
const CELLS: usize = 8 * N;

/// Each step takes some bytes. Returns the number of steps.
pub fn steps(bytes: &[u8]) -> u64 {
    lives(&mut Box::new(Meters::IDLE), Input(bytes))
}

/// As [`steps`], for libFuzzer.
pub fn instrument(bytes: &[u8]) {
    steps(bytes);
}

fn lives(meters: &mut Meters, mut input: Input) -> u64 {
    let mut memory = Box::new([[0u32; SLOT]; SLOTS]);
    let [fill, ticks] = input.take();
    // A new chip, or one that held something else; ticks that wrap soon.
    let page = [if fill & 1 == 0 { u32::MAX } else { u32::from(fill) * 0x0101_0101 }; PAGE];
    let flash = Flash { pages: [page; 2], fault: None, done: 0, off: false };
    let mut flash = Chip(Rc::new(RefCell::new(flash)));
    // Or one with settings.
    let kept = fill & 2 != 0;
    let config = Config { codes: World::CODES, ..Settings::default().config };
    let settings = Settings { config, ..Settings::default() };
    if kept {
        storage::save(&mut flash, &payload(&settings, N)).expect("flash that works so far");
    }
    let mut world = World {
        ticks: u32::MAX - u32::from(ticks) * 100_000,
        flash,
        slots: Free::default(),
        counters: Counters::default(),
        waits: 0,
        stuck: false,
        refused: 0,
        fed: false,
        host: Reader::default(),
        seen: Vec::new(),
    };
    let mut knows = Knows {
        settings: Settings::default(),
        label: 0,
        measuring: false,
        kept: vec![kept.then(|| settings.to_bytes(N).to_vec())],
        status: None,
        zero: Counters::default(),
        sequence: None,
        torn: false,
        statuses: 0,
        saves: 0,
        crashes: Crashes::at_start(0, Causes(1), &LastEnd::default()).word(),
    };
    let mut birth = Birth { causes: Causes(1), ..Birth::default() };
    let mut steps = 0;
    while !input.0.is_empty() {
        // SAFETY: the slots of the life before, which alone referred to this memory, are dropped: those of the world here, the one in
        // a capture with its instrument.
        *world.slots.0.borrow_mut() = memory
            .iter_mut()
            .map(|words| Slot::new(unsafe { &mut *std::ptr::from_mut(words) }))
            .collect();
        birth = life(meters, &mut world, &mut knows, birth, &mut input, &mut steps);
        world.slots.0.borrow_mut().clear();
    }
    steps
}

/// One life, from a start to the next: how that begins.
fn life(
    meters: &mut Meters,
    world: &mut World,
    knows: &mut Knows,
    birth: Birth,
    input: &mut Input,
    steps: &mut u64,
) -> Birth {
    // A reset: nothing waits, and the counters begin anew.
    (world.waits, world.refused, world.stuck) = (0, 0, false);
    world.counters = Counters::default();
    world.host = Reader::default();
    (knows.status, knows.zero, knows.sequence) = (None, Counters::default(), None);
    let Birth { left, causes, last } = birth;
    let crashes = Crashes::at_start(knows.crashes, causes, &last);
    knows.crashes = crashes.word();
    let start = Start::new::<N>(left, &world.flash, crashes);
    let clocks = Clocks { source: Clock::External, core_hz: TICKS_HZ, ticks_hz: TICKS_HZ };
    let start = Start { causes, last, saves: knows.saves, clocks, ..start };
    let made = Instrument::new(&*world, start, world.flash.clone(), meters);
    let (mut it, ()) = made.expect("the default settings work here");
    let measuring = it.plan().settings.start;
    let slots = measuring.then(|| world.slots.clone());
    it.begin(world, slots);
    let request = Request { tag: 77, command: Command::GetSettings };
    assert!(it.on_bytes(world, &request.to_frame()).is_none());
    knows.born(world, left, crashes.halts());
    let mut number = 0u64;
    while !input.0.is_empty() {
        *steps += 1;
        let [step, how] = input.take();
        let before = QUEUE - world.waits;
        let mut did = Did::Other;
        let heard = match step % 16 {
            // Time, with a block at its end or not.
            0..=5 => {
                world.pass(u32::from(how) * if step & 64 == 0 { 50 } else { 5000 });
                did = Did::Nothing;
                if knows.measuring
                    && step % 16 < 5
                    && let Some(block) = world.block(it.plan(), &mut number, input)
                {
                    it.on_block(world, block);
                    did = Did::Block;
                }
                None
            }
            6 => {
                let (noise, rest) = input.0.split_at(usize::from(how % 32).min(input.0.len()));
                input.0 = rest;
                it.on_bytes(world, noise)
            }
            7 => {
                // A damaged frame, and the zero that ends it.
                let mut frame = Request { tag: how, command: Command::Save }.to_frame();
                let place = usize::from(input.byte()) % frame.len();
                frame[place] ^= 1 << (how & 7);
                it.on_bytes(world, &frame).or_else(|| it.on_bytes(world, &[0]))
            }
            8 => {
                world.stuck = how & 1 != 0;
                None
            }
            9 => {
                let fault = if how & 1 == 0 { Fault::Refuses } else { Fault::Power };
                world.flash.0.borrow_mut().fault = Some((fault, how / 2 % (PAGE as u8 + 2)));
                world.flash.0.borrow_mut().done = u32::from_le_bytes(input.take());
                None
            }
            10 => {
                let last = LastEnd { kind: 1, ..LastEnd::default() };
                let birth = match how & 3 {
                    0 => Birth { causes: Causes(1), ..Birth::default() },
                    1 => Birth { causes: Causes(4), last, left: None },
                    2 => Birth { causes: Causes(8), ..Birth::default() },
                    _ => {
                        world.pass(20 * TICKS_HZ);
                        did = Did::Silence;
                        Birth::default()
                    }
                };
                if did != Did::Silence {
                    knows.saves = 0;
                    return birth;
                }
                None
            }
            _ => {
                // What came before ends here, so that the order is a frame of its own.
                let ended = it.on_bytes(world, &[0]);
                assert!(ended.is_none(), "no order is complete without its checksum");
                knows.hear(world, None);
                let room = QUEUE - world.waits;
                let request = Request { tag: how, command: knows.order(step, how, input) };
                let heard = it.on_bytes(world, &request.to_frame());
                let said = knows.hear(world, Some(&request));
                assert!(
                    said.is_some() || room < WIRE,
                    "an order that nobody answered: {request:?}"
                );
                knows.ordered(world, &request, said, &heard);
                heard
            }
        };
        if world.flash.0.borrow().off {
            world.flash.0.borrow_mut().off = false;
            knows.saves = 0;
            knows.hear(world, None);
            return Birth { causes: Causes(1), ..Birth::default() };
        }
        if let Some(end) = heard {
            knows.hear(world, None);
            assert_eq!(world.slots.0.borrow().len(), SLOTS, "an end that keeps a block");
            knows.saves = it.saves();
            let left = match end {
                End::Restart(settings) => Some(words(&settings, N)),
                End::Reboot => None,
            };
            return Birth { left, causes: Causes(4), ..Birth::default() };
        }
        world.fed = false;
        it.poll(world);
        // The watchdog is fed while blocks come, and is not when they have stayed away for long.
        assert!(did != Did::Block || world.stalled() || world.fed, "alive, and not fed");
        assert!(did != Did::Silence || !knows.measuring || !world.fed, "dead, and fed");
        let statuses = knows.statuses;
        knows.hear(world, None);
        // Records and captures leave room for an answer, and for a status each second.
        if did != Did::Other {
            let told = (knows.statuses - statuses) as usize * STATUS;
            assert!(
                QUEUE - world.waits + told >= before.min(WIRE),
                "a record in an answer's place"
            );
        }
    }
    Birth::default()
}

/// What a step did.
#[derive(Clone, Copy, PartialEq)]
enum Did {
    Block,
    Nothing,
    Silence,
    Other,
}

impl Knows {
    /// Hears the first words of a life, which began with these settings or those in flash.
    fn born(&mut self, world: &mut World, left: Option<[u32; WORDS]>, halted: bool) {
        let mut seen = world.seen.drain(..);
        let Some(Seen::Boot(boot)) = seen.next() else { panic!("no boot record") };
        let Some(Seen::Answer(_, Ok(body))) = seen.next() else { panic!("no settings") };
        let (settings, n) = Settings::from_bytes(&body).expect("settings");
        assert_eq!((n, boot.n, boot.unfit, boot.halted), (N, N as u32, false, halted));
        assert_eq!(boot.settings, checksum::of_bytes(&body));
        assert_eq!(boot.measuring, settings.start);
        // By which settings of a host or of the flash this may be.
        let told = |start: bool| Settings { start, ..settings }.to_bytes(N).to_vec();
        let is = |wanted: &[u8]| {
            let (wanted, _) = Settings::from_bytes(wanted).expect("settings that were answered");
            wanted.to_bytes(N)[..] == told(wanted.start)[..]
                && settings.start == (wanted.start && !halted)
        };
        match (left, boot.origin) {
            (Some(left), Origin::Host) => {
                let bytes: Vec<u8> = left.iter().flat_map(|word| word.to_le_bytes()).collect();
                assert!(is(&bytes), "others than the host has set");
            }
            (None, Origin::Flash) => {
                self.kept.retain(|kept| kept.as_deref().is_some_and(is));
                assert!(!self.kept.is_empty(), "neither the old settings nor the new ones");
            }
            (None, origin @ (Origin::Default | Origin::Unreadable)) => {
                assert!(self.kept.contains(&None), "settings that were saved are gone");
                // A first save that was cut off.
                assert!(origin == Origin::Default || self.kept.len() > 1 || self.torn);
                self.torn |= origin == Origin::Unreadable;
                self.kept = vec![None];
                let config = Config { codes: World::CODES, ..Settings::default().config };
                let start = origin == Origin::Default && !halted;
                let wanted = Settings { config, start, ..Settings::default() };
                assert_eq!(settings, wanted);
            }
            other => panic!("{other:?}"),
        }
        (self.settings, self.label, self.measuring) = (settings, boot.settings, boot.measuring);
    }

    /// Hears what the line took, and returns the answer to an order.
    fn hear(&mut self, world: &mut World, asked: Option<&Request>) -> Option<Said> {
        let mut answered = None;
        for seen in std::mem::take(&mut world.seen) {
            match seen {
                Seen::Boot(_) => panic!("a second boot record"),
                Seen::Status(status) => self.status(world, status),
                Seen::Telemetry(record) => self.record(world, &record),
                Seen::Raw(raw) => assert!(self.measuring && !raw.bytes.is_empty()),
                Seen::Answer(answer, said) => match asked {
                    Some(request) if request.answer() == answer => {
                        assert!(answered.replace(said).is_none(), "two answers to one order");
                    }
                    // Noise that is an order: one in 2^32.
                    _ => assert_eq!((answer, said), (Answer::default(), Err(Refusal::Damaged))),
                },
                Seen::Other => assert!(self.measuring),
            }
        }
        answered
    }

    /// Counters that are those of the converter, and none runs backwards.
    fn status(&mut self, world: &World, status: Status) {
        self.statuses += 1;
        assert_eq!(status.counters, world.counters.since(&self.zero));
        assert!(status.load <= 1000 && status.dropped >= world.refused, "{status:?}");
        if let Some(last) = self.status {
            assert!(status.dropped >= last.dropped && status.refused >= last.refused);
        }
        self.status = Some(status);
    }

    /// A record of the settings in force, later than the one before.
    fn record(&mut self, world: &World, record: &Telemetry) {
        let Telemetry { measurement: Measurement { stamp, tone, .. }, health, basis, .. } = record;
        assert!(self.measuring);
        assert_eq!(basis.map(|basis| basis.settings), Some(self.label));
        assert_eq!(tone.rate_hz.to_bits(), self.settings.config.rate_hz.to_bits());
        assert!(self.sequence.is_none_or(|last| stamp.sequence > last));
        self.sequence = Some(stamp.sequence);
        let since = world.counters.since(&self.zero);
        assert_eq!((health.lost, health.faults), (since.lost(), since.faults()));
        let usable = tone.verdict.usable() <= Usable::WithinSigma;
        assert!(!usable || tone.sigma.is_finite(), "{tone:?}");
    }

    /// An order that a host may give.
    fn order(&self, step: u8, how: u8, input: &mut Input) -> Command {
        match (step % 16, how & 3) {
            (11, _) => {
                Command::SetSettings(self.changed(how, input), if how == 255 { 128 } else { N })
            }
            (12, _) => Command::Save,
            (13, 0) => Command::Identify,
            (13, 1) => Command::GetSettings,
            (13, 2) => Command::Status,
            (13, _) => Command::Reset,
            (14, _) => Command::Capture(u16::from(how)),
            (_, 0) => Command::Start,
            (_, 1) => Command::Stop,
            (_, 2) => Command::Reboot,
            _ => Command::Start,
        }
    }

    /// The settings in force, with some fields changed; most of them work.
    fn changed(&self, how: u8, input: &mut Input) -> Settings {
        let base = self.settings;
        let [rate, every, scene, mode] = input.take();
        let config = Config { rate_hz: 1e6 / (1.0 + f64::from(rate)), ..base.config };
        let drive = if scene % 4 == 1 { Drive::Dac { low: 0, high: 9 } } else { Drive::Off };
        let scene = match scene % 4 {
            1 => Scene::Chirp(Chirp {
                shape: [Shape::Sawtooth, Shape::Triangle, Shape::Trapezoid]
                    [usize::from(scene) / 4 % 3],
                wavelength_m: 0.0125,
                bandwidth_hz: 200e6,
                duration_s: 1.0,
                ..Chirp::default()
            }),
            2 => Scene::Doppler { wavelength_m: 0.0125, angle_rad: 0.1, mixing: Mixing::default() },
            _ => Scene::Tone,
        };
        let settings = Settings {
            iq: how & 1 != 0,
            config: Config { scene, ..config },
            guard: if drive == Drive::Off { 0 } else { u16::from(every % 65) },
            drive,
            report_every: u16::from(every % 4),
            start: how & 64 == 0,
            mode: Mode::Blocks,
            most: 1,
            harmonics: 0,
            ..base
        };
        match mode % 8 {
            0 => Settings { most: 1 + mode / 8 % 4, harmonics: mode / 32, ..settings },
            1 => {
                let following = Following { most: mode / 8 % 5, ..Following::default() };
                Settings { config: Config { following, ..settings.config }, ..settings }
            }
            2 => {
                let drift_bins = input.number() as f32;
                let mode = Mode::Accumulate { blocks: u32::from(mode) / 8, drift_bins };
                Settings { mode, ..settings }
            }
            3 => {
                let ratio = (mode & 8 != 0).then(|| input.number() as f32);
                let mode = Mode::Bursts(Trigger { ratio, hold_off: 4, least: 1 });
                Settings { mode, ..settings }
            }
            4 => {
                let clock_ppm = input.number() as f32;
                let calibration = Calibration { clock_ppm, ..Calibration::default() };
                Settings { calibration, ..settings }
            }
            5 => {
                let config = Config { false_alarm: input.number(), ..settings.config };
                Settings { config, ..settings }
            }
            6 => {
                let band_hz = Some((input.number(), input.number()));
                Settings { config: Config { band_hz, ..settings.config }, ..settings }
            }
            _ => {
                let chirps = 8 << (mode / 8 % 3);
                let period_s = (mode & 32 != 0).then(|| input.number());
                Settings { mode: Mode::Frames { chirps, period_s }, ..settings }
            }
        }
    }

    /// Learns what an order has done: by its answer, or, where the line had no room for one, by its end.
    fn ordered(
        &mut self,
        world: &mut World,
        asked: &Request,
        said: Option<Said>,
        heard: &Option<End>,
    ) {
        let body = self.settings.to_bytes(N);
        match (asked.command, said) {
            (Command::SetSettings(..) | Command::Start | Command::Stop, said) => {
                match (said, heard) {
                    (Some(Ok(body)), Some(End::Restart(settings))) => {
                        assert_eq!(settings.to_bytes(N)[..], body[..]);
                    }
                    (None, Some(End::Restart(_)))
                    | (None | Some(Err(Refusal::Settings(_))), None) => {}
                    other => panic!("{other:?}"),
                }
            }
            (Command::Reboot, said) => {
                assert!(matches!(said, None | Some(Ok(_))) && *heard == Some(End::Reboot));
            }
            // This board cannot try itself.
            (Command::SelfTest, said) => {
                assert!(matches!(said, None | Some(Err(Refusal::Unknown))) && heard.is_none());
            }
            (Command::Save, said) => match said {
                Some(Ok(_)) => self.kept = vec![Some(body.to_vec())],
                Some(Err(Refusal::Often)) => {}
                Some(Err(Refusal::Flash)) | None => {
                    self.torn = true;
                    self.kept.push(Some(body.to_vec()));
                }
                other => panic!("{other:?}"),
            },
            (Command::Reset, _) => {
                (self.zero, self.status) = (world.counters, None);
                world.refused = 0;
            }
            (Command::Capture(_), Some(said)) => assert_eq!(said.is_ok(), self.measuring),
            (Command::GetSettings, Some(said)) => assert_eq!(said.as_deref(), Ok(&body[..])),
            (Command::Identify, Some(said)) => {
                let boot = Boot::from_bytes(&said.expect("a boot record")).expect("a boot record");
                assert_eq!((boot.settings, boot.measuring), (self.label, self.measuring));
            }
            (Command::Status, Some(said)) => assert_eq!(said, Ok(Vec::new())),
            (
                Command::Capture(_) | Command::GetSettings | Command::Identify | Command::Status,
                None,
            ) => {}
        }
    }
}

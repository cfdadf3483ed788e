//! The instrument's loop: blocks to records, commands to answers.
//!
//! Settings take effect by a restart, so that there is one way only into operation: a command checks them, leaves them to
//! the next program and resets the chip. Start and stop are settings like the others.

use super::converter::{self, Slot};
use super::measurer::Measurer;
use super::serial::Serial;
use super::storage::{self, Flash};
use super::trace::{Legacy, Stack, WORDS};
use super::{N, start};
use crate::acquire::frontend::{Block, Blocks, Counters};
use crate::acquire::sample::{Iq, Real};
use crate::control::clock::Tree;
use crate::control::settings::{Instrument as Plan, Settings, SettingsError};
use crate::control::slots;
use crate::pipeline::Measurement;
use crate::report::boot::{Boot, Causes, LastEnd};
use crate::report::command::{Answer, Command, Refusal, Request};
use crate::report::frame::{Kind, Reader, WIRE};
use crate::report::record::{Health, Record};
use crate::report::status::{Raw, Status};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use heapless::Vec;

/// The instrument.
pub struct Instrument {
    tree: Tree,
    plan: Plan,
    boot: Boot,
    serial: Serial,
    reader: Reader,
    refused: u32,
    blocks: Option<Blocks<'static, Slot>>,
    measurer: Measurer,
    /// Blocks still to be sent as they are, and the one being sent with the bytes that are out.
    captures: u16,
    raw: Option<(Block<Slot>, usize)>,
    until_report: u16,
    zero: Counters,
    /// When the last status was sent, and the ticks asleep since.
    since: u32,
    asleep: u32,
    /// The longest measurement since then.
    longest: u32,
    stack: Stack,
}

fn words(settings: &Settings) -> [u32; WORDS] {
    let bytes = settings.to_bytes(N);
    let mut words = [0; WORDS];
    let fields = bytes.as_chunks().0.iter().map(|&field| u32::from_le_bytes(field));
    words.iter_mut().zip(fields).for_each(|(place, word)| *place = word);
    words
}

fn of_words(words: &[u32; WORDS]) -> Option<Settings> {
    let mut bytes = [0; Settings::BYTES];
    let places = bytes.as_chunks_mut().0.iter_mut();
    places.zip(words).for_each(|(place, word)| *place = word.to_le_bytes());
    match Settings::of_bytes(&bytes) {
        Ok((settings, N)) => Some(settings),
        _ => None,
    }
}

impl Instrument {
    /// From reset to the loop. `None` only where memory is taken a second time.
    // What the start needs of the stack is free again when it is over.
    #[inline(never)]
    pub fn start() -> Option<Self> {
        let Legacy { last, settings: left } = Legacy::take();
        let causes = start::causes();
        let kept = slots::load::<WORDS, _>(&Flash).map(|(_, _, words)| words);
        let stored = left.is_none() && kept.is_some();
        let wanted = left.or(kept).and_then(|words| of_words(&words)).unwrap_or_default();
        let tree = start::clock(wanted.speed);
        start::peripherals();
        start::brown_out_level();
        start::watchdog();
        let serial = Serial::start(tree.apb1_hz)?;
        // On a slower clock than was asked for, settings that were right may not work: then the board waits for others.
        let (plan, unfit) = match validated(&wanted, &tree) {
            Ok(plan) => (plan, false),
            Err(_) => {
                let safe = Settings { start: false, ..Settings::default() };
                (safe.validate(N, &tree).ok()?, true)
            }
        };
        let mut boot = boot_record(&tree, &plan, causes, last, stored, unfit);
        // Last, so that no block passes before the loop runs.
        let blocks = if plan.settings.start { converter::start(&plan, &tree) } else { None };
        boot.measuring = blocks.is_some();
        let mut instrument = Self {
            tree,
            plan,
            boot,
            serial,
            reader: Reader::default(),
            refused: 0,
            blocks,
            measurer: Measurer::take(&plan)?,
            captures: 0,
            raw: None,
            until_report: 0,
            zero: Counters::default(),
            since: start::ticks(),
            asleep: 0,
            longest: 0,
            stack: Stack::unknown(),
        };
        let frame = instrument.boot.to_frame();
        instrument.serial.send(&frame);
        Some(instrument)
    }

    /// For ever.
    pub fn run(mut self) -> ! {
        loop {
            self.listen();
            let measured = self.measure();
            self.send_raw();
            if measured || self.may_rest() {
                start::feed();
            }
            if start::ticks().wrapping_sub(self.since) > self.tree.timer_hz {
                self.send_status();
            }
            if !measured {
                let before = start::ticks();
                converter::sleep(self.blocks.as_ref());
                self.asleep = self.asleep.wrapping_add(start::ticks().wrapping_sub(before));
            }
        }
    }

    /// True where no block is due within the watchdog's time.
    fn may_rest(&self) -> bool {
        let Plan { sampling, length, settings, .. } = &self.plan;
        let slow = f64::from(*length) > sampling.rate_hz;
        self.blocks.is_none() || slow || settings.drive == crate::control::settings::Drive::External
    }

    /// Measures a block, if there is one.
    fn measure(&mut self) -> bool {
        let Some(blocks) = &mut self.blocks else { return false };
        let Some(block) = blocks.receive() else { return false };
        let guard = self.plan.settings.guard;
        let before = start::ticks();
        let mut measurement = self.measurer.block(&block, guard);
        self.longest = self.longest.max(start::ticks().wrapping_sub(before));
        self.plan.settings.calibration.apply(&mut measurement);
        let since = block.counters.since(&self.zero);
        let captured = self.captures > 0 && self.raw.is_none();
        if captured {
            self.captures -= 1;
            self.raw = Some((block, 0));
        } else if let Some(blocks) = &mut self.blocks {
            // Before its record is out: whoever sees that may count on the slot.
            blocks.release(block.slot);
        }
        self.until_report = self.until_report.saturating_sub(1);
        if self.until_report == 0 || captured {
            self.until_report = self.plan.settings.report_every;
            self.report(measurement, since);
        }
        true
    }

    fn report(&mut self, measurement: Measurement, since: Counters) {
        let method = self.plan.plan.options.method;
        let health = Health { lost: since.lost(), faults: since.faults() };
        let stamp = measurement.stamp;
        self.serial.send(&Record { measurement, method, health }.to_frame());
        if let Some(follow) = self.measurer.followed(&stamp) {
            self.serial.send(&follow.to_frame());
        }
    }

    /// Sends what the line takes of the block that is being captured.
    fn send_raw(&mut self) {
        // A status must find room beside.
        while self.serial.has_room(2 * WIRE)
            && let Some((block, sent)) = self.raw.take()
        {
            let guard = self.plan.settings.guard;
            let mut bytes = Vec::new();
            let length = if self.plan.settings.iq {
                let samples = block.slot.samples::<Iq>(guard).as_flattened();
                piece(samples, sent, &mut bytes);
                size_of_val(samples)
            } else {
                let samples = block.slot.samples::<Real>(guard);
                piece(samples, sent, &mut bytes);
                size_of_val(samples)
            };
            let raw = Raw { sequence: block.stamp.sequence, offset: sent as u16, bytes };
            let sent = sent + raw.bytes.len();
            if sent < length {
                self.raw = Some((block, sent));
            } else if let Some(blocks) = &mut self.blocks {
                blocks.release(block.slot);
            }
            self.serial.send(&raw.to_frame());
        }
    }

    fn send_status(&mut self) {
        let now = start::ticks();
        let passed = now.wrapping_sub(self.since).max(1);
        let awake = u64::from(passed.saturating_sub(self.asleep));
        let status = Status {
            counters: converter::counters().since(&self.zero),
            dropped: self.serial.dropped,
            refused: self.refused,
            load: (awake * 1000 / u64::from(passed)) as u32,
            stack: self.stack.high_water(),
            longest: self.longest,
        };
        (self.since, self.asleep, self.longest) = (now, 0, 0);
        self.serial.send(&status.to_frame());
    }

    /// Follows the host's commands.
    fn listen(&mut self) {
        while let Some(byte) = self.serial.receive() {
            let Some(frame) = self.reader.push(byte) else { continue };
            let request = match frame {
                Ok(frame) if frame.kind == Kind::Command => Request::of_frame(&frame),
                // What was sent to others, or came back, is no command.
                Ok(_) => continue,
                Err(_) => Err((Answer::default(), Refusal::Damaged)),
            };
            let (answer, outcome) = match request {
                Ok(request) => (request.answer(), self.follow(&request)),
                Err((answer, refusal)) => (answer, Err(refusal)),
            };
            if let Err(refusal) = outcome {
                self.refused = self.refused.wrapping_add(1);
                self.serial.send(&answer.refusal(refusal));
            }
        }
    }

    fn follow(&mut self, request: &Request) -> Result<(), Refusal> {
        let answer = request.answer();
        match request.command {
            Command::Identify => self.serial.send(&answer.reply(&self.boot.to_bytes())),
            Command::GetSettings => {
                self.serial.send(&answer.reply(&self.plan.settings.to_bytes(N)));
            }
            Command::SetSettings(settings, n) => {
                let plan = check(&settings, n, &self.tree)?;
                self.restart(answer, plan.settings);
            }
            Command::Start => self.restart(answer, Settings { start: true, ..self.plan.settings }),
            Command::Stop => self.restart(answer, Settings { start: false, ..self.plan.settings }),
            Command::Reboot => self.reboot(answer),
            Command::Save => {
                slots::save(&mut Flash, &words(&self.plan.settings)).map_err(|_| Refusal::Flash)?;
                start::feed();
                self.serial.send(&answer.reply(&[]));
            }
            Command::Capture(blocks) => {
                if self.blocks.is_none() {
                    return Err(Refusal::Stopped);
                }
                self.captures = blocks;
                self.serial.send(&answer.reply(&[]));
            }
            Command::Reset => {
                self.zero = converter::counters();
                (self.serial.dropped, self.refused) = (0, 0);
                self.serial.send(&answer.reply(&[]));
            }
            Command::Status => {
                self.serial.send(&answer.reply(&[]));
                self.send_status();
            }
        }
        Ok(())
    }

    /// Answers with the settings and starts anew with them.
    fn restart(&mut self, answer: Answer, settings: Settings) {
        self.serial.send(&answer.reply(&settings.to_bytes(N)));
        self.serial.flush();
        let settings = Some(words(&settings));
        Legacy { last: LastEnd::default(), settings }.leave()
    }

    /// Starts anew as from power-on.
    fn reboot(&mut self, answer: Answer) {
        self.serial.send(&answer.reply(&[]));
        self.serial.flush();
        Legacy::default().leave()
    }
}

/// Settings that were sent, for the clock as it would be with them.
fn check(settings: &Settings, n: usize, tree: &Tree) -> Result<Plan, Refusal> {
    let refused = |error: SettingsError| Refusal::Settings(error.code());
    if n != N {
        return Err(refused(SettingsError::Length));
    }
    validated(settings, &Tree::new(settings.speed, tree.source)).map_err(refused)
}

/// Settings that this image can follow.
fn validated(settings: &Settings, tree: &Tree) -> Result<Plan, SettingsError> {
    if settings.config.following.most > 0 && !Measurer::FOLLOWS {
        return Err(SettingsError::Tracking);
    }
    settings.validate(N, tree)
}

/// As many bytes of the samples as a piece holds, from byte `from` on, little-endian.
fn piece(samples: &[i16], from: usize, bytes: &mut Vec<u8, { Raw::PIECE }>) {
    for sample in samples.iter().skip(from / 2).take(Raw::PIECE / 2) {
        // A piece has room for as many.
        let _ = bytes.extend_from_slice(&sample.to_le_bytes());
    }
}

fn boot_record(
    tree: &Tree,
    plan: &Plan,
    causes: Causes,
    last: LastEnd,
    stored: bool,
    unfit: bool,
) -> Boot {
    let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    Boot {
        clock: tree.source,
        causes,
        measuring: false,
        stored,
        unfit,
        program: storage::program(),
        settings: crc.checksum(&plan.settings.to_bytes(N)),
        n: N as u32,
        core_hz: tree.core_hz,
        last,
    }
}

//! The instrument's loop: blocks to telemetry, commands to answers.
//!
//! Settings take effect by a restart, so there is only one way into operation. A command checks the
//! settings, leaves them to the next program and resets the chip. Start and stop are settings like
//! the others.

use super::bounds::{Deadline, HEARD, Refusals, Saves, health};
use super::crashes::Crashes;
use super::legacy::{self, Legacy, WORDS, words};
use super::measurer::{FOLLOWS, Gathered, IqMeter, LINES, Measurer, Meter, Meters, SIGNALS};
use super::plan::Plan;
use super::stack::Stack;
use super::storage::{self, Kept};
use crate::board::Board;
use crate::slot::Slot;
use heapless::Vec;
use picket::acquire::frontend::{Block, Blocks, Counters};
use picket::acquire::sample::{Iq, Real};
use picket::burst;
use picket::pipeline::Measurement;
use picket_wire::boot::{Boot, Causes, LastEnd, Name, Origin};
use picket_wire::burst::Burst;
use picket_wire::capture::EncodingError;
use picket_wire::command::{Answer, Command, Refusal, Request};
use picket_wire::frame::{Kind, Reader, WIRE};
use picket_wire::settings::{Mode, Settings};
use picket_wire::settings_error::SettingsError;
use picket_wire::status::{Raw, Status};
use picket_wire::sum::Sum;
use picket_wire::telemetry::{Basis, Health, Telemetry};

/// The line's room with which a record is sent. A piece of a capture takes less, and leaves room for an answer.
const RECORD: usize = 3 * WIRE;

/// The instrument. `Q` measures I/Q records.
pub struct Instrument<
    B: Board<N, SLOT>,
    const N: usize,
    const SLOT: usize,
    Q: IqMeter<N> = Meter<Iq, N>,
> {
    board: B,
    plan: Plan<N>,
    boot: Boot,
    reader: Reader,
    refused: u32,
    refusals: Refusals,
    saves: Saves,
    /// Frames dropped because the line had no room.
    dropped: u32,
    blocks: Option<Blocks<'static, Slot<SLOT>>>,
    measurer: Measurer<N, Q>,
    /// Raw blocks still to send, and the block being sent with the number of its bytes that are
    /// out.
    captures: u16,
    raw: Option<(Block<Slot<SLOT>>, usize)>,
    until_report: u16,
    zero: Counters,
    /// The ticks at the last status, and the ticks asleep since.
    since: u32,
    asleep: u32,
    crashes: Crashes,
    /// Seconds since the start.
    seconds: u32,
    /// The longest measurement since the last status, ticks.
    longest: u32,
    stack: Stack,
    /// The duration of a block with its guard, ticks.
    block: u64,
    /// When a block must come, and when a byte must leave the line.
    next_block: Deadline,
    next_byte: Deadline,
}

/// The settings in these words, if they are for blocks of `N` samples. Compiled once for what the last program left and for the flash.
#[inline(never)]
fn of_words<const N: usize>(words: &[u32; WORDS]) -> Option<Settings> {
    let mut bytes = [0; Settings::BYTES];
    let places = bytes.as_chunks_mut().0.iter_mut();
    places.zip(words).for_each(|(place, word)| *place = word.to_le_bytes());
    let (settings, n) = Settings::of_bytes(&bytes).ok()?;
    (n == N).then_some(settings)
}

/// Settings that this image can follow, and their words.
fn planned<B: Board<N, SLOT>, const N: usize, const SLOT: usize>(
    board: &B,
    settings: &Settings,
) -> Result<(Plan<N>, B::Words), SettingsError> {
    if settings.config.following.most > 0 && !FOLLOWS {
        return Err(SettingsError::Tracking);
    }
    if (settings.further() > 0 || settings.order() > 0) && !LINES {
        return Err(SettingsError::Encoding(EncodingError::Version));
    }
    if settings.mode != Mode::Blocks && !SIGNALS {
        return Err(SettingsError::Signals);
    }
    board.plan(settings)
}

/// The duration of a block with its guard, ticks.
fn block_ticks<const N: usize>(plan: &Plan<N>, ticks_hz: u32) -> u64 {
    let seconds = f64::from(plan.length) / plan.settings.config.rate_hz;
    (seconds * f64::from(ticks_hz)) as u64
}

impl<B, const N: usize, const SLOT: usize, Q> Instrument<B, N, SLOT, Q>
where
    B: Board<N, SLOT>,
    Q: IqMeter<N>,
{
    /// Takes the instrument from reset to its loop, with the image's [`meters`](crate::meters).
    /// `None` only at the second call.
    // Not inlined, so that the stack of the start is free again afterwards.
    #[inline(never)]
    pub fn start(meters: Option<Meters<N, Q>>) -> Option<Self> {
        let Legacy { last, settings: left, saves } = Legacy::take();
        let causes = B::causes();
        let crashes = legacy::count(causes, &last);
        let reads = |words: &[u32; WORDS]| of_words::<N>(words).is_some();
        let kept = storage::latest(&B::Storage::default(), reads);
        let (words, origin) = match (left.filter(reads), kept) {
            (Some(left), _) => (Some(left), Origin::Host),
            (None, Kept::Found(kept)) => (Some(kept), Origin::Flash),
            (None, Kept::Nothing) => (None, Origin::Default),
            (None, Kept::Unreadable) => (None, Origin::Unreadable),
        };
        let mut wanted = words.and_then(|words| of_words::<N>(&words)).unwrap_or_default();
        // It waits for a host: to measure by other settings than the saved ones would be silently wrong.
        wanted.start &= origin != Origin::Unreadable && !crashes.halts();
        let mut board = B::start(&wanted)?;
        // If the clock is slower than wanted, correct settings may fail: the board then waits for
        // others.
        let (plan, words, unfit) = match planned(&board, &wanted) {
            Ok((plan, words)) => (plan, words, false),
            Err(_) => {
                let safe = Settings { start: false, ..Settings::default() };
                let (plan, words) = board.plan(&safe).ok()?;
                (plan, words, true)
            }
        };
        let basis = plan.basis(board.clock());
        let mut boot = boot_record::<B, N, SLOT>(&board, basis, causes, last, origin, unfit);
        // This comes last, so that no block passes before the loop runs.
        let blocks = if plan.settings.start { board.sample(&plan, &words) } else { None };
        (boot.measuring, boot.halted) = (blocks.is_some(), crashes.halts());
        let since = board.ticks();
        let ticks_hz = board.ticks_hz();
        let block = block_ticks(&plan, ticks_hz);
        let mut instrument = Self {
            board,
            plan,
            boot,
            reader: Reader::default(),
            refused: 0,
            refusals: Refusals::new(since),
            saves: Saves::new(saves),
            dropped: 0,
            blocks,
            measurer: Measurer::new(meters?, &plan),
            captures: 0,
            raw: None,
            until_report: 0,
            zero: Counters::default(),
            since,
            asleep: 0,
            crashes,
            seconds: 0,
            longest: 0,
            stack: Stack::unknown(),
            block,
            next_block: Deadline::new(block, since, ticks_hz),
            next_byte: Deadline::new(0, since, ticks_hz),
        };
        // A zero ends what a program left on the line that could not wait for it.
        let _ = instrument.board.send(&[0]);
        let frame = instrument.boot.to_frame();
        instrument.send(&frame);
        Some(instrument)
    }

    /// Runs for ever.
    pub fn run(mut self) -> ! {
        loop {
            self.listen();
            let measured = self.measure();
            self.send_raw();
            if self.progress(measured) {
                self.board.feed();
            }
            if self.board.ticks().wrapping_sub(self.since) > self.board.ticks_hz() {
                self.saves.second();
                self.seconds = self.seconds.saturating_add(1);
                legacy::lives(self.crashes, self.seconds);
                self.send_status();
            }
            if !measured {
                let before = self.board.ticks();
                self.board.sleep(self.blocks.as_ref());
                self.asleep = self.asleep.wrapping_add(self.board.ticks().wrapping_sub(before));
            }
        }
    }

    /// Sends a frame, or counts it as dropped.
    fn send(&mut self, frame: &[u8]) {
        if frame.is_empty() || !self.board.send(frame) {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }

    /// Whether the loop makes progress: neither a block nor a byte on the line is overdue. An external source may pause as
    /// long as it likes.
    fn progress(&mut self, measured: bool) -> bool {
        let now = self.board.ticks();
        let due = self.blocks.is_some() && self.board.gate_opened();
        let stalled = self.board.stalled();
        let blocks = self.next_block.holds(now, due, measured);
        self.next_byte.holds(now, stalled, !stalled) && blocks
    }

    /// Measures a block, if one waits. Returns whether it did.
    fn measure(&mut self) -> bool {
        let Some(blocks) = &mut self.blocks else { return false };
        let Some(mut block) = blocks.receive() else { return false };
        let guard = self.plan.settings.guard;
        let before = self.board.ticks();
        self.board.correct(&mut block.slot);
        let measured = self.measurer.block(&mut block, guard);
        let gathered = self.measurer.gathered();
        let mut measurement = measured;
        self.board.widen(&mut measurement);
        self.longest = self.longest.max(self.board.ticks().wrapping_sub(before));
        self.plan.settings.calibration.apply(&mut measurement);
        let health = health(&block.counters, &self.zero);
        let captured = self.captures > 0 && self.raw.is_none();
        if captured {
            self.captures -= 1;
            self.raw = Some((block, 0));
        } else if let Some(blocks) = &mut self.blocks {
            // The slot is released before the telemetry is out, so a host that has the telemetry
            // knows that the slot is free.
            blocks.release(block.slot);
        }
        let sum = match gathered {
            Gathered::Block => None,
            Gathered::Sum(sum) => Some(sum),
            Gathered::Nothing => return true,
            Gathered::Bursts(bursts) => {
                bursts.iter().for_each(|burst| self.report_burst(burst, health));
                return true;
            }
        };
        self.until_report = self.until_report.saturating_sub(1);
        if self.until_report == 0 || captured {
            self.until_report = self.plan.settings.report_every;
            self.report(&measured, measurement, health, before, captured, sum);
        }
        true
    }

    /// Reports a burst.
    fn report_burst(&mut self, burst: &Burst, health: Health) {
        let (tone, result) = (burst.burst.tone, burst.result);
        let mut measurement = Measurement { tone, result, ..Measurement::default() };
        self.board.widen(&mut measurement);
        let inner = burst::Burst { tone: measurement.tone, ..burst.burst };
        let burst = Burst { burst: inner, result: measurement.result, health, ..*burst };
        if self.board.has_room(RECORD) {
            self.send(&burst.to_frame());
        } else {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }

    /// Reports a block whose measurement began at a tick: what was measured, and what is told of it.
    fn report(
        &mut self,
        measured: &Measurement,
        measurement: Measurement,
        health: Health,
        began: u32,
        captured: bool,
        sum: Option<Sum>,
    ) {
        let method = self.plan.plan.options.method;
        let stamp = measurement.stamp;
        let lines = self.measurer.lines(measured, self.plan.settings.further());
        let fundamental = self.measurer.fundamental(measured, self.plan.settings.order());
        if LINES {
            self.longest = self.longest.max(self.board.ticks().wrapping_sub(began));
        }
        // Answers, the status and a capture find room on a full line; a captured block's record is of the capture.
        if !captured && !self.board.has_room(RECORD) {
            self.dropped = self.dropped.wrapping_add(1);
            return;
        }
        let (settings, clock) = (self.boot.settings, self.boot.clock);
        let effort = self.plan.plan.options.effort as u8;
        let basis = Some(Basis { settings, clock, effort });
        self.send(&Telemetry { measurement, method, health, basis }.to_frame());
        if let Some(sum) = sum {
            self.send(&sum.to_frame());
        }
        if let Some(lines) = lines {
            self.send(&lines.to_frame());
        }
        if let Some(fundamental) = fundamental {
            self.send(&fundamental.to_frame());
        }
        if let Some(follow) = self.measurer.followed(&stamp) {
            self.send(&follow.to_frame());
        }
    }

    /// Sends as much of the captured block as the line takes.
    fn send_raw(&mut self) {
        // The line must keep room for a status.
        while self.board.has_room(2 * WIRE)
            && let Some((block, sent)) = self.raw.take()
        {
            let guard = self.plan.settings.guard;
            let mut bytes = Vec::new();
            let length = if self.plan.settings.iq {
                let samples = block.slot.samples::<Iq, N>(guard).as_flattened();
                piece(samples, sent, &mut bytes);
                size_of_val(samples)
            } else {
                let samples = block.slot.samples::<Real, N>(guard);
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
            self.send(&raw.to_frame());
        }
    }

    fn send_status(&mut self) {
        let now = self.board.ticks();
        let passed = now.wrapping_sub(self.since).max(1);
        let awake = u64::from(passed.saturating_sub(self.asleep));
        let status = Status {
            counters: self.board.counters().since(&self.zero),
            dropped: self.dropped,
            refused: self.refused,
            load: (awake * 1000 / u64::from(passed)) as u32,
            stack: self.stack.high_water(),
            longest: self.longest,
            peak: (u64::from(self.longest) * 1000).checked_div(self.block).unwrap_or(0) as u32,
        };
        (self.since, self.asleep, self.longest) = (now, 0, 0);
        self.send(&status.to_frame());
    }

    /// Follows the host's commands.
    fn listen(&mut self) {
        for _ in 0..HEARD {
            let Some(byte) = self.board.receive() else { return };
            let Some(frame) = self.reader.push(byte) else { continue };
            let request = match frame {
                Ok(frame) if frame.kind == Kind::Command => Request::of_frame(&frame),
                // Frames for others, or echoes, are not commands.
                Ok(_) => continue,
                Err(_) => Err((Answer::default(), Refusal::Damaged)),
            };
            let (answer, outcome) = match request {
                Ok(request) => (request.answer(), self.follow(&request)),
                Err((answer, refusal)) => (answer, Err(refusal)),
            };
            if let Err(refusal) = outcome {
                self.refused = self.refused.wrapping_add(1);
                let (now, hz) = (self.board.ticks(), self.board.ticks_hz());
                if refusal != Refusal::Damaged || self.refusals.answers(now, hz) {
                    self.send(&answer.refusal(refusal));
                }
            }
        }
    }

    fn follow(&mut self, request: &Request) -> Result<(), Refusal> {
        let answer = request.answer();
        match request.command {
            Command::Identify => self.send(&answer.reply(&self.boot.to_bytes())),
            Command::GetSettings => {
                self.send(&answer.reply(&self.plan.settings.to_bytes(N)));
            }
            Command::SetSettings(settings, n) => {
                let plan = self.check(&settings, n)?;
                self.restart(answer, plan.settings);
            }
            Command::Start => self.restart(answer, Settings { start: true, ..self.plan.settings }),
            Command::Stop => self.restart(answer, Settings { start: false, ..self.plan.settings }),
            Command::Reboot => self.reboot(answer),
            Command::Save => {
                let words = words(&self.plan.settings, N);
                self.save(&words)?;
                self.send(&answer.reply(&[]));
            }
            Command::Capture(blocks) => {
                if self.blocks.is_none() {
                    return Err(Refusal::Stopped);
                }
                self.captures = blocks;
                self.send(&answer.reply(&[]));
            }
            Command::Reset => {
                self.zero = self.board.counters();
                (self.dropped, self.refused) = (0, 0);
                self.send(&answer.reply(&[]));
            }
            Command::Status => {
                self.send(&answer.reply(&[]));
                self.send_status();
            }
        }
        Ok(())
    }

    /// Saves settings. Flash that is erased holds the core for a second or two: the samples stop
    /// before, and start again after it.
    fn save(&mut self, words: &[u32; WORDS]) -> Result<(), Refusal> {
        let mut storage = B::Storage::default();
        if storage::load::<WORDS, _>(&storage).is_some_and(|(_, _, newest)| newest == *words) {
            return Ok(());
        }
        if !self.saves.permit() {
            return Err(Refusal::Often);
        }
        let measuring = self.blocks.is_some();
        if measuring {
            self.board.pause();
        }
        self.board.feed();
        let saved = storage::save(&mut storage, words).map_err(|_| Refusal::Flash);
        self.board.feed();
        if measuring {
            self.board.resume();
        }
        self.next_block = Deadline::new(self.block, self.board.ticks(), self.board.ticks_hz());
        saved
    }

    /// Checks settings that a command brought.
    fn check(&self, settings: &Settings, n: usize) -> Result<Plan<N>, Refusal> {
        let refused = |error: SettingsError| Refusal::Settings(error.code());
        if n != N {
            return Err(refused(SettingsError::Length));
        }
        planned(&self.board, settings).map(|(plan, _)| plan).map_err(refused)
    }

    /// Answers with the settings and restarts with them.
    fn restart(&mut self, answer: Answer, settings: Settings) {
        self.send(&answer.reply(&settings.to_bytes(N)));
        self.board.flush();
        let settings = Some(words(&settings, N));
        Legacy { settings, saves: self.saves.used(), ..Legacy::default() }.leave()
    }

    /// Restarts as from power-on.
    fn reboot(&mut self, answer: Answer) {
        self.send(&answer.reply(&[]));
        self.board.flush();
        Legacy { saves: self.saves.used(), ..Legacy::default() }.leave()
    }
}

/// Appends bytes of the samples from byte `from` on, little-endian, as many as a piece holds.
fn piece(samples: &[i16], from: usize, bytes: &mut Vec<u8, { Raw::PIECE }>) {
    for sample in samples.iter().skip(from / 2).take(Raw::PIECE / 2) {
        // A piece has room for this many.
        let _ = bytes.extend_from_slice(&sample.to_le_bytes());
    }
}

fn boot_record<B: Board<N, SLOT>, const N: usize, const SLOT: usize>(
    board: &B,
    basis: Basis,
    causes: Causes,
    last: LastEnd,
    origin: Origin,
    unfit: bool,
) -> Boot {
    Boot {
        board: const { Name::new(B::NAME) },
        clock: basis.clock,
        causes,
        measuring: false,
        halted: false,
        origin,
        unfit,
        program: B::program(),
        settings: basis.settings,
        n: N as u32,
        core_hz: board.core_hz(),
        last,
    }
}

//! The machine: blocks to telemetry, commands to answers.
//!
//! Settings take effect by a new start, so there is only one way into operation. A command checks the settings and ends the instrument; the
//! caller starts another instrument with them. Start and stop are settings like the others.

use crate::bounds::{Deadline, Refusals, Saves, health};
use crate::meter::{Advance, Framed, Gathered, Meter, Meters};
use crate::plan::Plan;
use crate::port::{Clocks, Port, Slots};
use crate::slot::Slot;
use crate::start::Start;
use crate::storage;
use crate::words::payload;
use heapless::Vec;
use picket_dsp::acquire::frontend::{Block, Counters};
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::burst;
use picket_dsp::config::Scene;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::tone::Tone;
use picket_wire::boot::{Boot, Name, Origin};
use picket_wire::burst::Burst;
use picket_wire::capture::EncodingError;
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::command::{Answer, Command, Refusal, Request};
use picket_wire::frame::{Kind, Reader, WIRE};
use picket_wire::settings::{Mode, Settings};
use picket_wire::settings_error::{FramesError, SettingsError};
use picket_wire::status::{Raw, Status};
use picket_wire::sum::Sum;
use picket_wire::telemetry::{Basis, Health, Telemetry};

/// The room on the line with which a record is sent. A piece of a capture takes less, and leaves room for an answer.
const RECORD: usize = 3 * WIRE;

/// The end of an instrument. Its last answer may still wait for the line; the memory of every block is back in the slots.
#[expect(clippy::large_enum_variant, reason = "nothing is allocated here, and there is one of it")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// Another instrument shall start, with these settings.
    Restart(Settings),
    /// Another instrument shall start, as from power-on.
    Reboot,
}

/// The instrument on a port `P`, whose blocks have `N` samples in slots of `SLOT` words. `M` measures real records, `Q` I/Q records.
pub struct Instrument<
    'a,
    P: Port<N, SLOT>,
    const N: usize,
    const SLOT: usize,
    M: Meter<Real, N> = Pipeline<Real, N>,
    Q: Meter<Iq, N> = Pipeline<Iq, N>,
> {
    plan: Plan<N>,
    boot: Boot,
    reader: Reader,
    refused: u32,
    refusals: Refusals,
    saves: Saves,
    /// Frames dropped because the line had no room.
    dropped: u32,
    meters: &'a mut Meters<M, Q>,
    storage: P::Storage,
    /// Where the memory of blocks comes back to; `None` while nothing is sampled.
    slots: Option<P::Slots>,
    clocks: Clocks,
    stack: Option<fn() -> u32>,
    /// Raw blocks still to send; and the block being sent, with the number of its bytes already sent.
    captures: u16,
    raw: Option<(Block<Slot<SLOT>>, usize)>,
    until_report: u16,
    zero: Counters,
    /// The ticks at the last status, and the ticks asleep since.
    since: u32,
    asleep: u32,
    /// Seconds since the start.
    seconds: u32,
    /// The longest measurement since the last status, ticks.
    longest: u32,
    /// Whether there is more to do at once, and the ticks at its beginning.
    works: bool,
    begun: u32,
    /// The duration of a block with its guard, ticks.
    block: u64,
    /// Whether a block came since the last look.
    measured: bool,
    /// The deadlines of the next block, and of the next byte on the line.
    next_block: Deadline,
    next_byte: Deadline,
}

/// Checks settings that this instrument can follow; returns their words on the board, whose codes they are given.
// Not inlined: it is called at two places.
#[inline(never)]
fn planned<P, const N: usize, const SLOT: usize, M, Q>(
    port: &P,
    settings: &mut Settings,
) -> Result<(Plan<N>, P::Words), SettingsError>
where
    P: Port<N, SLOT>,
    M: Meter<Real, N>,
    Q: Meter<Iq, N>,
{
    let can = |real: bool, iq: bool| if settings.iq { iq } else { real };
    if settings.config.following.most > 0 && !can(M::FOLLOWS, Q::FOLLOWS) {
        return Err(SettingsError::Tracking);
    }
    if (settings.further() > 0 || settings.order() > 0) && !can(M::LINES, Q::LINES) {
        return Err(SettingsError::Encoding(EncodingError::Version));
    }
    let signals = matches!(settings.mode, Mode::Accumulate { .. } | Mode::Bursts(_));
    if signals && !can(M::SIGNALS, Q::SIGNALS) {
        return Err(SettingsError::Signals);
    }
    settings.config.codes = P::CODES;
    let cells = if settings.iq { Q::CELLS } else { M::CELLS };
    if matches!(settings.mode, Mode::Frames { .. }) && cells == 0 {
        return Err(SettingsError::Frames(FramesError::Absent));
    }
    let planned = port.plan(settings)?;
    match planned.0.settings.frames(N)? {
        Some(frames) if frames.cells() > cells => Err(SettingsError::Frames(FramesError::Cells)),
        _ => Ok(planned),
    }
}

/// The duration of a block with its guard, ticks.
fn block_ticks<const N: usize>(plan: &Plan<N>, ticks_hz: u32) -> u64 {
    let seconds = f64::from(plan.length) / plan.settings.config.rate_hz;
    (seconds * f64::from(ticks_hz)) as u64
}

impl<'a, P, const N: usize, const SLOT: usize, M, Q> Instrument<'a, P, N, SLOT, M, Q>
where
    P: Port<N, SLOT>,
    M: Meter<Real, N>,
    Q: Meter<Iq, N>,
{
    /// An instrument before its first block, and its settings' words on the board. Where the wanted settings cannot work on the board in
    /// its present state, the default ones are taken, stopped, and the boot record says so: if the clock is slower than wanted, the board
    /// waits for other settings. `None` if not even the default ones work.
    pub fn new(
        port: &P,
        mut start: Start,
        storage: P::Storage,
        meters: &'a mut Meters<M, Q>,
    ) -> Option<(Self, P::Words)> {
        let (planned, unfit) = match planned::<P, N, SLOT, M, Q>(port, &mut start.settings) {
            Ok(planned) => (planned, false),
            Err(_) => {
                start.settings = Settings { start: false, ..Settings::default() };
                (planned::<P, N, SLOT, M, Q>(port, &mut start.settings).ok()?, true)
            }
        };
        let (plan, words) = planned;
        meters.set(&plan);
        let Clocks { source, core_hz, ticks_hz } = start.clocks;
        let basis = plan.basis(source);
        let boot = Boot {
            board: const { Name::new(P::NAME) },
            clock: basis.clock,
            causes: start.causes,
            measuring: false,
            halted: start.halted,
            origin: start.origin,
            unfit,
            program: start.program,
            settings: basis.settings,
            n: N as u32,
            core_hz,
            last: start.last,
        };
        let since = port.ticks();
        let block = block_ticks(&plan, ticks_hz);
        let instrument = Self {
            plan,
            boot,
            reader: Reader::default(),
            refused: 0,
            refusals: Refusals::new(since),
            saves: Saves::new(start.saves),
            dropped: 0,
            meters,
            storage,
            slots: None,
            clocks: start.clocks,
            stack: start.stack,
            captures: 0,
            raw: None,
            until_report: 0,
            zero: Counters::default(),
            since,
            asleep: 0,
            seconds: 0,
            longest: 0,
            works: false,
            begun: since,
            block,
            measured: false,
            next_block: Deadline::new(block, since, ticks_hz),
            next_byte: Deadline::new(0, since, ticks_hz),
        };
        Some((instrument, words))
    }

    /// Sends the boot record. If the samples have been started, blocks may come from now on, and their memory goes back to the slots.
    pub fn begin(&mut self, port: &mut P, slots: Option<P::Slots>) {
        self.boot.measuring = slots.is_some();
        self.slots = slots;
        // A zero ends a frame that the last program may have left on the line.
        let _ = port.send(&[0]);
        let frame = self.boot.to_frame();
        self.send(port, &frame);
    }

    /// The settings in use, and the values that follow from them. Samples shall be taken if the settings say `start`.
    pub const fn plan(&self) -> &Plan<N> {
        &self.plan
    }

    /// The end after which the next instrument measures as this one was asked to, where something beside the settings has changed: a clock
    /// that came back.
    pub fn again(&self) -> End {
        let given = self.boot.origin == Origin::Host && !self.boot.unfit;
        if given { End::Restart(self.plan.settings) } else { End::Reboot }
    }

    /// Where the memory of blocks comes back to; `None` while nothing is sampled.
    pub const fn slots(&mut self) -> Option<&mut P::Slots> {
        self.slots.as_mut()
    }

    /// The storage, for the next instrument.
    pub fn into_storage(self) -> P::Storage {
        self.storage
    }

    /// Seconds since the start.
    pub const fn seconds(&self) -> u32 {
        self.seconds
    }

    /// Gives a block's memory back.
    fn release(&mut self, slot: Slot<SLOT>) {
        if let Some(slots) = &mut self.slots {
            slots.release(slot);
        }
    }

    /// The recent saves, for the [`Start`] of the next instrument.
    pub const fn saves(&self) -> u32 {
        self.saves.used()
    }

    /// Counts `ticks` of sleep of the core, which are not part of its load.
    pub const fn slept(&mut self, ticks: u32) {
        self.asleep = self.asleep.wrapping_add(ticks);
    }

    /// Takes bytes of the host, and answers its commands. After an end, which a command may bring, the remaining bytes are dropped. More
    /// than [`HEARD`](crate::bounds::HEARD) at a time may keep a block waiting.
    pub fn on_bytes(&mut self, port: &mut P, bytes: &[u8]) -> Option<End> {
        bytes.iter().find_map(|&byte| self.on_byte(port, byte))
    }

    /// Takes one byte of the host, see [`Instrument::on_bytes`].
    // Not inlined, so that a command's settings take no stack beside a measurement.
    #[inline(never)]
    pub fn on_byte(&mut self, port: &mut P, byte: u8) -> Option<End> {
        let request = match self.reader.push(byte)? {
            Ok(frame) if frame.kind == Kind::Command => Request::from_frame(&frame),
            // Frames for others, or echoes, are not commands.
            Ok(_) => return None,
            Err(_) => Err((Answer::default(), Refusal::Damaged)),
        };
        let (answer, outcome) = match request {
            Ok(request) => (request.answer(), self.follow(port, &request)),
            Err((answer, refusal)) => (answer, Err(refusal)),
        };
        let refusal = match outcome {
            Ok(None) => return None,
            Ok(end) => {
                if let Some((block, _)) = self.raw.take() {
                    self.release(block.slot);
                }
                return end;
            }
            Err(refusal) => refusal,
        };
        self.refused = self.refused.wrapping_add(1);
        if refusal != Refusal::Damaged || self.refusals.answers(port.ticks(), self.clocks.ticks_hz)
        {
            self.send(port, &answer.refusal(refusal));
        }
        None
    }

    /// Measures a block, and sends its record if one is due. The block's memory goes back to the slots, now or once the block is
    /// captured.
    pub fn on_block(&mut self, port: &mut P, mut block: Block<Slot<SLOT>>) {
        self.measured = true;
        let guard = self.plan.settings.guard;
        let before = port.ticks();
        port.correct(&mut block.slot);
        let measured = self.meters.block::<N, SLOT>(&mut block, guard);
        self.tell(port, block, measured, before);
    }

    /// Tells of a block whose measurement began at a tick.
    #[inline(never)] // the room of what is told is not beside the measurement's
    fn tell(&mut self, port: &mut P, block: Block<Slot<SLOT>>, measured: Measurement, before: u32) {
        let gathered = self.meters.gathered::<N>();
        let mut measurement = measured;
        port.widen(&mut measurement);
        self.longest = self.longest.max(port.ticks().wrapping_sub(before));
        self.plan.settings.calibration.apply(&mut measurement);
        let health = health(&block.counters, &self.zero);
        // A capture waits for room, too: sent right behind another, its record would take the room of an answer.
        let captured = self.captures > 0 && self.raw.is_none() && port.has_room(RECORD);
        if captured {
            self.captures -= 1;
            self.raw = Some((block, 0));
        } else {
            // The slot is released before the telemetry is out, so a host that has the telemetry
            // knows that the slot is free.
            self.release(block.slot);
        }
        let sum = match gathered {
            Gathered::Block => None,
            Gathered::Sum(sum) => Some(sum),
            Gathered::Nothing => return,
            Gathered::Bursts(bursts) => {
                return bursts.iter().for_each(|burst| self.report_burst(port, burst, health));
            }
        };
        self.until_report = self.until_report.saturating_sub(1);
        if self.until_report == 0 || captured {
            self.until_report = self.plan.settings.report_every;
            self.report(port, &measured, measurement, health, before, sum);
        }
    }

    /// Does all work that is due: sends pieces of a captured block while the line has room, feeds the watchdog while blocks and bytes make
    /// progress, and sends the status once a second. Call it after each block, and at least some ten times a second.
    ///
    /// It also goes on with what outlasts a block, by a part: do not sleep while the instrument [works](Instrument::works).
    pub fn poll(&mut self, port: &mut P) {
        self.send_raw(port);
        self.advance(port);
        if self.progress(port) {
            port.feed();
        }
        if port.ticks().wrapping_sub(self.since) > self.clocks.ticks_hz {
            self.saves.second();
            self.seconds = self.seconds.saturating_add(1);
            self.send_status(port);
        }
    }

    /// Whether [`Instrument::poll`] has more to do at once.
    pub const fn works(&self) -> bool {
        self.works
    }

    /// Goes on with the search for the targets of a frame.
    fn advance(&mut self, port: &mut P) {
        if !self.works {
            self.begun = port.ticks();
        }
        let advance = self.meters.advance::<N>();
        self.works = advance == Advance::More;
        if advance == Advance::Done {
            self.report_frame(port);
        }
    }

    /// By what blocks are measured.
    fn basis(&self) -> Basis {
        let effort = self.plan.plan.options.effort.available().rounds();
        Basis { settings: self.boot.settings, clock: self.boot.clock, effort }
    }

    /// Reports a frame and its targets.
    #[inline(never)] // its room on the stack is not beside a search's
    fn report_frame(&mut self, port: &mut P) {
        let settings = &self.plan.settings;
        let Ok(Some(frames)) = settings.frames(N) else { return };
        let Some((framed, targets)) = self.meters.framed::<N>() else { return };
        // All of it, or nothing.
        if !port.has_room((1 + targets.len()) * WIRE) {
            self.dropped = self.dropped.wrapping_add(1);
            return;
        }
        let Framed { number, first, passed, clipped } = framed;
        let chirps = frames.chirps();
        let rate_hz = settings.config.rate_hz;
        let period_s = match (settings.mode, settings.config.scene) {
            (Mode::Frames { period_s: Some(period_s), .. }, _) => period_s,
            (_, Scene::Chirp(chirp)) => chirp.duration_s,
            _ => return,
        };
        let frame = ChirpFrame {
            number,
            stamp: first,
            chirps: chirps as u16,
            passed,
            clipped,
            targets: targets.len() as u8,
            search_s: port.ticks().wrapping_sub(self.begun) as f32
                / self.clocks.ticks_hz.max(1) as f32,
            rate_hz,
            period_s,
            health: health(&port.counters(), &self.zero),
            basis: Some(self.basis()),
        };
        let mut sent = port.send(&frame.to_frame());
        for (place, found) in targets.iter().enumerate() {
            let result = Outcome::Target(found.target);
            let mut measurement = widened(port, found.line.tone, result);
            settings.calibration.apply(&mut measurement);
            let mut found = *found;
            found.line.tone = measurement.tone;
            found.covariance *= settings.calibration.range_slope;
            if let Outcome::Target(target) = measurement.result {
                found.target = target;
            }
            let told = Found { frame: number, place: place as u8, found };
            sent &= port.send(&told.to_frame());
        }
        if !sent {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }

    /// Sends a frame, or counts it as dropped.
    #[inline(never)] // once in an image, not for each kind
    fn send(&mut self, port: &mut P, frame: &[u8]) {
        if frame.is_empty() || !port.send(frame) {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }

    /// Whether there is progress: neither a block nor a byte on the line is overdue. An external source may pause as
    /// long as it likes.
    fn progress(&mut self, port: &mut P) -> bool {
        let now = port.ticks();
        let due = self.boot.measuring && port.gate_opened();
        let stalled = port.stalled();
        let measured = core::mem::take(&mut self.measured);
        let blocks = self.next_block.holds(now, due, measured);
        self.next_byte.holds(now, stalled, !stalled) && blocks
    }

    /// Reports a burst.
    fn report_burst(&mut self, port: &mut P, burst: &Burst, health: Health) {
        let measurement = widened(port, burst.burst.tone, burst.result);
        let inner = burst::Burst { tone: measurement.tone, ..burst.burst };
        let burst = Burst { burst: inner, result: measurement.result, health, ..*burst };
        if port.has_room(RECORD) {
            self.send(port, &burst.to_frame());
        } else {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }

    /// Reports a block whose measurement began at a tick: the measurement, and the values derived from it.
    fn report(
        &mut self,
        port: &mut P,
        measured: &Measurement,
        measurement: Measurement,
        health: Health,
        began: u32,
        sum: Option<Sum>,
    ) {
        let method = self.plan.plan.options.method;
        let stamp = measurement.stamp;
        let lines = self.meters.lines::<N>(measured, self.plan.settings.further());
        let fundamental = self.meters.fundamental::<N>(measured, self.plan.settings.order());
        if M::LINES || Q::LINES {
            self.longest = self.longest.max(port.ticks().wrapping_sub(began));
        }
        // Answers, the status and a capture find room on a full line.
        if !port.has_room(RECORD) {
            self.dropped = self.dropped.wrapping_add(1);
            return;
        }
        let basis = Some(self.basis());
        let uncertainty = self.plan.total(&measurement);
        self.send(port, &Telemetry { measurement, method, health, basis, uncertainty }.to_frame());
        if let Some(sum) = sum {
            self.send(port, &sum.to_frame());
        }
        if let Some(mut lines) = lines {
            lines.tones.iter_mut().for_each(|line| widen(port, &mut line.tone));
            self.send(port, &lines.to_frame());
        }
        if let Some(mut fundamental) = fundamental {
            // Its own amplitude is not known where its first order is not seen.
            let amplitude = measured.tone.amplitude;
            let mut tone = Tone { amplitude, ..fundamental.harmonic.tone };
            widen(port, &mut tone);
            fundamental.harmonic.tone.sigma = tone.sigma;
            self.send(port, &fundamental.to_frame());
        }
        if let Some(mut follow) = self.meters.followed::<N>(&stamp, |tone| widen(port, tone)) {
            for (_, target) in &mut follow.targets {
                let result = Outcome::Target(*target);
                let mut measurement = widened(port, Tone::default(), result);
                self.plan.settings.calibration.apply(&mut measurement);
                if let Outcome::Target(widened) = measurement.result {
                    *target = widened;
                }
            }
            self.send(port, &follow.to_frame());
        }
    }

    /// Sends pieces of the captured block as long as the line has room.
    fn send_raw(&mut self, port: &mut P) {
        // The line must keep room for a status.
        while port.has_room(2 * WIRE)
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
            } else {
                self.release(block.slot);
            }
            self.send(port, &raw.to_frame());
        }
    }

    fn send_status(&mut self, port: &mut P) {
        let now = port.ticks();
        let passed = now.wrapping_sub(self.since).max(1);
        let awake = u64::from(passed.saturating_sub(self.asleep));
        let status = Status {
            counters: port.counters().since(&self.zero),
            dropped: self.dropped,
            refused: self.refused,
            load: (awake * 1000 / u64::from(passed)) as u32,
            stack: self.stack.map_or(0, |stack| stack()),
            longest: self.longest,
            peak: (u64::from(self.longest) * 1000).checked_div(self.block).unwrap_or(0) as u32,
        };
        (self.since, self.asleep, self.longest) = (now, 0, 0);
        self.send(port, &status.to_frame());
    }

    fn follow(&mut self, port: &mut P, request: &Request) -> Result<Option<End>, Refusal> {
        let answer = request.answer();
        let settings = self.plan.settings;
        match request.command {
            Command::Identify => self.send(port, &answer.reply(&self.boot.to_bytes())),
            Command::GetSettings => self.send(port, &answer.reply(&settings.to_bytes(N))),
            Command::SetSettings(mut settings, n) => {
                let plan = self.check(port, &mut settings, n)?;
                return Ok(Some(self.restart(port, answer, plan.settings)));
            }
            Command::Start => {
                let settings = Settings { start: true, ..settings };
                return Ok(Some(self.restart(port, answer, settings)));
            }
            Command::Stop => {
                let settings = Settings { start: false, ..settings };
                return Ok(Some(self.restart(port, answer, settings)));
            }
            Command::Reboot => {
                self.send(port, &answer.reply(&[]));
                return Ok(Some(End::Reboot));
            }
            Command::SelfTest => {
                if !port.self_test() {
                    return Err(Refusal::Unknown);
                }
                self.send(port, &answer.reply(&[]));
                return Ok(Some(End::Reboot));
            }
            Command::Save => {
                self.save(port, &settings)?;
                self.send(port, &answer.reply(&[]));
            }
            Command::Capture(blocks) => {
                if !self.boot.measuring {
                    return Err(Refusal::Stopped);
                }
                self.captures = blocks;
                self.send(port, &answer.reply(&[]));
            }
            Command::Reset => {
                self.zero = port.counters();
                (self.dropped, self.refused) = (0, 0);
                self.send(port, &answer.reply(&[]));
            }
            Command::Status => {
                self.send(port, &answer.reply(&[]));
                self.send_status(port);
            }
        }
        Ok(None)
    }

    /// Saves settings. Erasing flash holds the core for a second or two: the samples stop before, and start again afterwards.
    // Not inlined, so that the payloads take no stack below a command that saves nothing.
    #[inline(never)]
    fn save(&mut self, port: &mut P, settings: &Settings) -> Result<(), Refusal> {
        let payload = payload(settings, N);
        if storage::load(&self.storage).is_some_and(|(_, _, newest)| newest == payload) {
            return Ok(());
        }
        if !self.saves.permit() {
            return Err(Refusal::Often);
        }
        let measuring = self.boot.measuring;
        if measuring {
            port.pause();
        }
        port.feed();
        let saved = storage::save(&mut self.storage, &payload).map_err(|_| Refusal::Flash);
        port.feed();
        if measuring {
            port.resume();
        }
        self.next_block = Deadline::new(self.block, port.ticks(), self.clocks.ticks_hz);
        saved
    }

    /// Checks settings that a command brought.
    fn check(&self, port: &P, settings: &mut Settings, n: usize) -> Result<Plan<N>, Refusal> {
        let refused = |error: SettingsError| Refusal::Settings(error.code());
        if n != N {
            return Err(refused(SettingsError::Length));
        }
        planned::<P, N, SLOT, M, Q>(port, settings).map(|(plan, _)| plan).map_err(refused)
    }

    /// Answers with the settings and ends with them.
    // Not inlined: three orders end so.
    #[inline(never)]
    fn restart(&mut self, port: &mut P, answer: Answer, settings: Settings) -> End {
        self.send(port, &answer.reply(&settings.to_bytes(N)));
        End::Restart(settings)
    }
}

/// Appends bytes of the samples from byte `from` on, little-endian, up to the size of a piece.
fn piece(samples: &[i16], from: usize, bytes: &mut Vec<u8, { Raw::PIECE }>) {
    for sample in samples.iter().skip(from / 2).take(Raw::PIECE / 2) {
        // A piece has room for this many.
        let _ = bytes.extend_from_slice(&sample.to_le_bytes());
    }
}

/// A tone, and what follows from it, with the board's part in their sigmas.
#[inline(never)] // once in an image, not for each kind of record
fn widened<P: Port<N, SLOT>, const N: usize, const SLOT: usize>(
    port: &P,
    tone: Tone,
    result: Outcome,
) -> Measurement {
    let mut measurement = Measurement { tone, result, ..Measurement::default() };
    port.widen(&mut measurement);
    measurement
}

/// Adds the board's part to a tone's sigma.
fn widen<P: Port<N, SLOT>, const N: usize, const SLOT: usize>(port: &P, tone: &mut Tone) {
    *tone = widened(port, *tone, Outcome::None).tone;
}

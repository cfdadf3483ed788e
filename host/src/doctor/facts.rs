//! What a board says of itself while it is watched.

use crate::device::{Blocks, Listener, Said};
use crate::end;
use crate::watch::WatchError;
use crate::watch::orders::Pending;
use crate::watch::port::{Piece, Source};
use crate::watch::settings;
use picket_wire::boot::Boot;
use picket_wire::command::Command;
use picket_wire::settings::{Mode, Settings};
use picket_wire::status::Status;
use picket_wire::telemetry::Telemetry;
use std::time::{Duration, Instant};

/// What is known of a board.
#[derive(Debug, Default)]
pub struct Facts {
    /// Why the port does not open, or the board does not answer.
    pub failure: Option<String>,
    /// Bytes that came.
    pub bytes: u64,
    /// Frames that were not understood, and the version of a record that is unknown here.
    pub bad: u64,
    pub version: Option<u8>,
    pub boot: Option<Boot>,
    /// The settings, and the samples in a block.
    pub settings: Option<(Settings, usize)>,
    /// The statuses, each with the seconds since the first.
    pub statuses: Vec<(f64, Status)>,
    /// The last measurements.
    pub records: Vec<Telemetry>,
    /// How often the board started anew meanwhile.
    pub starts: u32,
    /// A block as it is.
    pub block: Vec<i16>,
}

/// Measurements that are kept.
const RECORDS: usize = 64;
/// The longest wait for a status, which comes once a second.
const SILENCE: Duration = Duration::from_secs(8);
/// The longest wait for a captured block, beyond its own duration.
const CAPTURE: Duration = Duration::from_secs(8);

/// Hears a board.
struct Ear<'a> {
    source: &'a mut Source,
    listener: Listener,
    facts: Facts,
    pieces: Blocks,
    began: Option<Instant>,
    /// How much longer than a board an emulated one may take.
    slower: u32,
}

impl Facts {
    /// Asks a board and watches it for some of its seconds. What it does not say is missing. An `emulated` one may take longer.
    pub fn gather(source: &mut Source, seconds: u32, emulated: bool) -> Self {
        let mut ear = Ear {
            source,
            listener: Listener::default(),
            facts: Self::default(),
            pieces: Blocks::default(),
            began: None,
            slower: if emulated { 30 } else { 1 },
        };
        if let Err(error) = ear.all(seconds) {
            ear.facts.failure = Some(error.to_string());
        }
        (ear.facts.bad, ear.facts.version) = (ear.listener.bad, ear.listener.version);
        ear.facts
    }

    /// Whether its blocks follow the clock, one after the other.
    pub fn steady(&self) -> Option<&Settings> {
        let (settings, _) = self.settings.as_ref()?;
        (settings.drive != picket_wire::settings::Drive::External).then_some(settings)
    }
}

impl Ear<'_> {
    fn all(&mut self, seconds: u32) -> Result<(), WatchError> {
        self.ask(Pending::of([Command::Identify, Command::GetSettings]))?;
        // The statuses before this moment may be those of another program.
        self.facts.statuses.clear();
        self.began = None;
        let mut heard = Instant::now();
        let mut seen = 0;
        while self.facts.statuses.len() <= seconds as usize
            && heard.elapsed() < SILENCE * self.slower
        {
            if !self.hear(None)? {
                break;
            }
            if self.facts.statuses.len() > seen {
                (seen, heard) = (self.facts.statuses.len(), Instant::now());
            }
        }
        let measures = self.facts.boot.is_some_and(|boot| boot.measuring);
        let (Some((settings, n)), true) = (self.facts.settings, measures) else { return Ok(()) };
        self.ask(Pending::of([Command::Capture(1)]))?;
        let begun = Instant::now();
        let block = Duration::from_secs_f64((3.0 * n as f64 / settings.config.rate_hz).min(60.0));
        while self.facts.block.is_empty() && begun.elapsed() < (CAPTURE + block) * self.slower {
            if !self.hear(None)? {
                break;
            }
        }
        Ok(())
    }

    /// Gives orders until they are answered.
    fn ask(&mut self, mut orders: Pending) -> Result<(), WatchError> {
        orders.ask(self.source)?;
        while !orders.done() && self.hear(Some(&mut orders))? {}
        Ok(())
    }

    /// Hears a piece. False at the end.
    fn hear(&mut self, mut orders: Option<&mut Pending>) -> Result<bool, WatchError> {
        if end::asked().is_some() {
            return Ok(false);
        }
        let bytes = match self.source.piece()? {
            Piece::End => return Ok(false),
            Piece::Opened => Vec::new(),
            Piece::Bytes(bytes) => bytes,
        };
        self.facts.bytes += bytes.len() as u64;
        for said in self.listener.read(&bytes) {
            if let Some(orders) = orders.as_deref_mut() {
                orders.hear(&said, self.source)?;
            }
            self.take(said);
        }
        if let Some(orders) = orders {
            let heard = self.facts.boot.is_some() || self.listener.records > 0;
            orders.again(self.source, heard, self.facts.bytes)?;
        }
        Ok(true)
    }

    fn take(&mut self, said: Said) {
        let facts = &mut self.facts;
        match said {
            Said::Boot(boot) => {
                facts.starts += u32::from(facts.boot.is_some());
                facts.boot = Some(boot);
            }
            Said::Status(status) => {
                let began = *self.began.get_or_insert_with(Instant::now);
                facts.statuses.push((began.elapsed().as_secs_f64(), status));
            }
            Said::Telemetry(record) => {
                if facts.records.len() == RECORDS {
                    facts.records.remove(0);
                }
                facts.records.push(record);
            }
            Said::Answer(answer, Ok(body)) if answer.command == Command::Identify.number() => {
                facts.boot = Boot::from_bytes(&body).ok().or(facts.boot);
            }
            Said::Answer(answer, Ok(body)) if answer.command == Command::GetSettings.number() => {
                facts.settings = settings::from_answer(&body).or(facts.settings);
            }
            Said::Raw(raw) => {
                let Some((settings, n)) = facts.settings else { return };
                let length = 2 * n * if settings.iq { 2 } else { 1 };
                if let Some((_, bytes)) = self.pieces.push(&raw, length) {
                    let codes = bytes.as_chunks().0.iter();
                    facts.block = codes.map(|code| i16::from_le_bytes(*code)).collect();
                }
            }
            _ => {}
        }
    }
}

/// Whether each block has a measurement of its own.
pub fn by_blocks(settings: &Settings) -> bool {
    settings.mode == Mode::Blocks
}

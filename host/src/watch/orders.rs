//! Orders to a device, one after the other: each is repeated until the device answers, a bounded number of times.

use super::port::Source;
use super::{WatchError, settings};
use crate::cli::print_line;
use crate::device::Said;
use clap::Args;
use picket_wire::command::{Answer, Command, Refusal, Request};
use picket_wire::settings::Settings;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Commands of the user to the board.
#[derive(Args, Debug)]
pub struct Orders {
    /// Prints the board's settings as JSON and ends
    #[arg(long)]
    get_settings: bool,
    /// Sends the settings in this JSON file to the board (docs/board.md)
    #[arg(long, value_name = "FILE")]
    set_settings: Option<PathBuf>,
    /// Tells the board to store its settings in flash
    #[arg(long)]
    save: bool,
    /// Measures the error of the board's clock by this machine's to 1 ppm, which takes minutes, stores clock_ppm on the board, and ends
    #[arg(long, conflicts_with_all = ["save", "stop", "get_settings", "capture", "live", "count"])]
    save_clock: bool,
    /// Tells the board to measure
    #[arg(long, conflicts_with = "stop")]
    start: bool,
    /// Tells the board to stop, and ends
    #[arg(long)]
    stop: bool,
    /// Sets the board's counters to 0
    #[arg(long)]
    reset: bool,
    /// Captures the samples of this many blocks, little-endian i16, into the file of --capture-to, and ends
    #[arg(long, value_name = "BLOCKS", requires = "capture_to")]
    capture: Option<u16>,
    /// File for the captured samples; read it by picket analyze FILE --format i16 --bits 12 --unsigned
    #[arg(long, value_name = "FILE", requires = "capture")]
    capture_to: Option<PathBuf>,
}

/// After this an order is sent again. A board that erases its flash is deaf for as long.
const AGAIN: Duration = Duration::from_secs(1);
/// So often an order is sent.
const TRIES: u32 = 8;
/// So often, where nothing that was heard was a board: it is the wrong port.
const TRIES_UNHEARD: u32 = 3;

/// An order as the user typed it.
const fn told(command: &Command) -> &'static str {
    match command {
        Command::Identify | Command::Status => "who are you?",
        Command::GetSettings => "--get-settings",
        Command::SetSettings(..) => "--set-settings",
        Command::Save => "--save",
        Command::Start => "--start",
        Command::Stop => "--stop",
        Command::Capture(_) => "--capture",
        Command::Reset => "--reset",
        Command::Reboot => "reboot",
        Command::SelfTest => "--self-test",
    }
}

/// Whether an order changes something.
const fn changes(command: &Command) -> bool {
    // A capture is done when its blocks are here.
    use Command::{Capture, GetSettings, Identify, Status};
    !matches!(command, Identify | GetSettings | Status | Capture(_))
}

/// Orders on their way.
pub struct Pending {
    queue: VecDeque<Command>,
    sent: Option<Request>,
    /// When it was last sent, and how often.
    asked: Option<(Instant, u32)>,
    tag: u8,
    ends: bool,
    print: bool,
    /// The user ordered something.
    ordered: bool,
    /// The settings are requested by the program, not by the user.
    renews: bool,
}

impl Orders {
    /// Whether there is one.
    pub fn any(&self) -> bool {
        let plain =
            [self.get_settings, self.save, self.save_clock, self.start, self.stop, self.reset];
        plain.contains(&true) || self.set_settings.is_some() || self.capture.is_some()
    }

    /// Blocks to capture, and where to.
    pub fn capture(&self) -> Option<(u16, &Path)> {
        self.capture.zip(self.capture_to.as_deref())
    }

    /// Whether the clock's error is to be stored.
    pub const fn saves_clock(&self) -> bool {
        self.save_clock
    }

    /// The file of settings.
    pub fn settings(&self) -> Option<&Path> {
        self.set_settings.as_deref()
    }

    /// In the order in which they make sense.
    pub fn prepare(&self) -> Result<Pending, WatchError> {
        let mut queue = VecDeque::from([Command::Identify]);
        if let Some(path) = &self.set_settings {
            let (settings, n) = settings::read(path)?;
            queue.push_back(Command::SetSettings(settings, n));
        }
        queue.push_back(Command::GetSettings);
        let plain = [
            (self.start, Command::Start),
            (self.stop, Command::Stop),
            (self.reset, Command::Reset),
            (self.save, Command::Save),
        ];
        queue.extend(plain.into_iter().filter(|(wanted, _)| *wanted).map(|(_, command)| command));
        queue.extend(self.capture.map(Command::Capture));
        let ends = self.get_settings || self.stop || self.save || self.capture.is_some();
        Ok(Pending {
            queue,
            sent: None,
            asked: None,
            tag: 0,
            ends,
            print: self.get_settings,
            ordered: self.any(),
            renews: false,
        })
    }
}

impl Pending {
    /// These orders, and nothing else.
    pub fn of<const COUNT: usize>(queue: [Command; COUNT]) -> Self {
        Self {
            queue: queue.into(),
            sent: None,
            asked: None,
            tag: 0,
            ends: true,
            print: false,
            ordered: true,
            renews: false,
        }
    }

    /// Sends the order whose turn it is, when the port has been opened.
    pub fn ask(&mut self, source: &mut Source) -> Result<(), WatchError> {
        if !source.listens() {
            return Ok(());
        }
        if self.queue.is_empty() && self.sent.is_none() {
            // Back again: what it is and how it is set may have changed.
            self.queue.extend([Command::Identify, Command::GetSettings]);
        }
        // A zero ends whatever noise the port was opened with.
        source.send(&[0]);
        match self.sent {
            Some(request) => self.send(request, source),
            None => self.next(source),
        }
        Ok(())
    }

    fn send(&mut self, request: Request, source: &mut Source) {
        source.send(&request.to_frame());
        let tries = self.asked.map_or(0, |(_, tries)| tries);
        self.asked = Some((Instant::now(), tries + 1));
    }

    /// Sends an order again that was not answered: a board that restarts, as after new settings, does not hear. `heard` is
    /// whether anything that was heard was a board, `bytes` how much was. Questions that nobody ordered are given up quietly where
    /// a board was heard.
    ///
    /// # Errors
    /// The order was sent often enough.
    pub fn again(
        &mut self,
        source: &mut Source,
        heard: bool,
        bytes: u64,
    ) -> Result<(), WatchError> {
        let (Some(request), Some((last, tries))) = (self.sent, self.asked) else { return Ok(()) };
        if last.elapsed() < AGAIN || !source.listens() {
            return Ok(());
        }
        if !heard && tries >= if self.ordered { TRIES_UNHEARD } else { TRIES } {
            return Err(WatchError::Unheard { tries, bytes });
        }
        if tries >= TRIES {
            if self.renews && request.command == Command::GetSettings {
                self.renews = false;
                self.next(source);
                return Ok(());
            }
            if self.ordered {
                return Err(WatchError::Unanswered { order: told(&request.command), tries });
            }
            (self.sent, self.asked) = (None, None);
            self.queue.clear();
            return Ok(());
        }
        // A zero ends whatever came of the last one.
        source.send(&[0]);
        self.send(request, source);
        Ok(())
    }

    /// Asks for the settings again, because they may be others now; not where that is on its way.
    pub fn renew(&mut self, source: &mut Source) {
        let asks = |command: &Command| *command == Command::GetSettings;
        let asked =
            self.queue.iter().any(asks) || self.sent.is_some_and(|sent| asks(&sent.command));
        if source.listens() && !asked {
            self.renews = true;
            self.add(Command::GetSettings, source);
        }
    }

    /// Sends settings, has the board keep them, and ends.
    pub fn keep(&mut self, settings: Settings, n: usize, source: &mut Source) {
        self.ends = true;
        self.add(Command::SetSettings(settings, n), source);
        self.add(Command::Save, source);
    }

    /// Another order behind the others.
    pub fn add(&mut self, command: Command, source: &mut Source) {
        self.queue.push_back(command);
        if self.sent.is_none() {
            self.next(source);
        }
    }

    fn next(&mut self, source: &mut Source) {
        self.tag = self.tag.wrapping_add(1);
        self.sent = self.queue.pop_front().map(|command| Request { tag: self.tag, command });
        self.asked = None;
        if let Some(request) = self.sent {
            self.send(request, source);
        }
    }

    /// Looks for the answer.
    pub fn hear(&mut self, said: &Said, source: &mut Source) -> Result<(), WatchError> {
        let (Some(request), Said::Answer(answer, body)) = (self.sent, said) else { return Ok(()) };
        // What arrives damaged has lost its tag.
        let damaged = *answer == Answer::default() && *body == Err(Refusal::Damaged);
        if damaged && self.asked.is_some_and(|(_, tries)| tries < TRIES) {
            self.send(request, source);
        }
        if *answer != request.answer() {
            return Ok(());
        }
        self.sent = None;
        self.renews &= request.command != Command::GetSettings;
        match body {
            Err(refusal) if self.ordered => return Err(WatchError::Refused(*refusal)),
            Err(_) => {}
            Ok(body) if request.command == Command::GetSettings && self.print => {
                self.print = false;
                if let Some((settings, n)) = settings::from_answer(body) {
                    print_line(&settings::to_json(&settings, n));
                }
            }
            Ok(_) if self.ordered && changes(&request.command) => {
                eprintln!("{}: done", told(&request.command));
            }
            Ok(_) => {}
        }
        self.next(source);
        Ok(())
    }

    /// Whether only the answers to commands are wanted, and not the measurements meanwhile.
    pub fn alone(&self) -> bool {
        self.ends
    }

    /// Whether all was answered and nothing else was wanted.
    pub fn done(&self) -> bool {
        self.ends && self.queue.is_empty() && self.sent.is_none()
    }
}

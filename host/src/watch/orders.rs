//! Orders to a device, one after the other: each is sent again until it is answered.

use super::port::Source;
use super::{WatchError, settings};
use crate::cli::print_line;
use crate::device::Said;
use clap::Args;
use picket::report::command::{Command, Request};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// What the user orders.
#[derive(Args, Debug)]
pub struct Orders {
    /// Prints the device's settings as JSON and ends
    #[arg(long)]
    get_settings: bool,
    /// Uses the settings in this JSON file from now on (docs/board.md)
    #[arg(long, value_name = "FILE")]
    set_settings: Option<PathBuf>,
    /// Keeps the settings over a reset
    #[arg(long)]
    save: bool,
    /// Measures
    #[arg(long, conflicts_with = "stop")]
    start: bool,
    /// Stops measuring and ends
    #[arg(long)]
    stop: bool,
    /// Sets the device's counters to 0
    #[arg(long)]
    reset: bool,
    /// Captures so many blocks as they are, little-endian i16, to --capture-to, and ends
    #[arg(long, value_name = "BLOCKS", requires = "capture_to")]
    capture: Option<u16>,
    /// The capture's file: for picket analyze FILE --format i16 --bits 12 --unsigned
    #[arg(long, value_name = "FILE", requires = "capture")]
    capture_to: Option<PathBuf>,
}

/// Orders on their way.
pub struct Pending {
    queue: VecDeque<Command>,
    sent: Option<Request>,
    tag: u8,
    ends: bool,
    print: bool,
}

impl Orders {
    /// Whether there is one.
    pub fn any(&self) -> bool {
        let plain = [self.get_settings, self.save, self.start, self.stop, self.reset];
        plain.contains(&true) || self.set_settings.is_some() || self.capture.is_some()
    }

    /// Blocks to capture, and where to.
    pub fn capture(&self) -> Option<(u16, &Path)> {
        self.capture.zip(self.capture_to.as_deref())
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
        Ok(Pending { queue, sent: None, tag: 0, ends, print: self.get_settings })
    }
}

impl Pending {
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
            Some(request) => source.send(&request.to_frame()),
            None => self.next(source),
        }
        Ok(())
    }

    fn next(&mut self, source: &mut Source) {
        self.tag = self.tag.wrapping_add(1);
        self.sent = self.queue.pop_front().map(|command| Request { tag: self.tag, command });
        if let Some(request) = self.sent {
            source.send(&request.to_frame());
        }
    }

    /// Looks for the answer.
    pub fn hear(&mut self, said: &Said, source: &mut Source) -> Result<(), WatchError> {
        let (Some(request), Said::Answer(answer, body)) = (self.sent, said) else { return Ok(()) };
        if *answer != request.answer() {
            return Ok(());
        }
        self.sent = None;
        match body {
            Err(refusal) => return Err(WatchError::Refused(*refusal)),
            Ok(body) if self.print && request.command == Command::GetSettings => {
                if let Some((settings, n)) = settings::of_answer(body) {
                    print_line(&settings::to_json(&settings, n));
                }
            }
            Ok(_) => {}
        }
        self.next(source);
        Ok(())
    }

    /// Whether all was answered and nothing else was wanted.
    pub fn done(&self) -> bool {
        self.ends && self.queue.is_empty() && self.sent.is_none()
    }
}

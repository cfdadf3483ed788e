//! An emulated board with its serial port on the emulator's own input and output.

use crate::device::{Listener, Said};
use crate::emulator::{RunError, reader};
use crate::end::Owned;
use crate::toolchain::io_error;
use picket_wire::command::{Command, Refusal, Request};
use std::collections::VecDeque;
use std::io::Write;
use std::process::{ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// The host's end of the serial port. The emulator ends with it, and with the thread that started it: see [`Owned::start`].
pub struct Console {
    _emulator: Owned,
    to_board: ChildStdin,
    from_board: Receiver<Vec<u8>>,
    listener: Listener,
    said: VecDeque<Said>,
    tag: u8,
    /// Every byte the board has sent, if they are kept.
    pub recorded: Option<Vec<u8>>,
}

impl Console {
    /// Starts an emulator whose arguments put the serial port on its input and output.
    ///
    /// # Errors
    /// It does not start.
    pub fn start(mut command: std::process::Command) -> Result<Self, RunError> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let emulator = Owned::start(command).map_err(io_error("qemu-system-arm"))?;
        let gone = || RunError::Emulator("it did not start".into());
        let to_board = emulator.stdin().ok_or_else(gone)?;
        let from_board = reader(emulator.stdout());
        let (listener, said) = (Listener::default(), VecDeque::new());
        Ok(Self {
            _emulator: emulator,
            to_board,
            from_board,
            listener,
            said,
            tag: 0,
            recorded: None,
        })
    }

    /// What was said and counted so far.
    pub fn listener(&self) -> &Listener {
        &self.listener
    }

    /// Sends bytes to the board's serial port as they are.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), RunError> {
        self.to_board.write_all(bytes).map_err(io_error("the serial port"))?;
        self.to_board.flush().map_err(io_error("the serial port"))?;
        Ok(())
    }

    /// The next thing the board says; `None` after `limit` without one.
    pub fn hear(&mut self, limit: Duration) -> Result<Option<Said>, RunError> {
        let end = Instant::now() + limit;
        loop {
            if let Some(said) = self.said.pop_front() {
                return Ok(Some(said));
            }
            match self.from_board.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(bytes) => {
                    self.said.extend(self.listener.read(&bytes));
                    if let Some(recorded) = &mut self.recorded {
                        recorded.extend(bytes);
                    }
                }
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(RunError::Emulator("it ended".into()));
                }
            }
        }
    }

    /// The next thing for which `wanted` gives something; what comes before is passed over.
    pub fn expect<T>(&mut self, mut wanted: impl FnMut(Said) -> Option<T>) -> Result<T, RunError> {
        const LIMIT: Duration = Duration::from_secs(60);
        let end = Instant::now() + LIMIT;
        while let Some(said) = self.hear(end.saturating_duration_since(Instant::now()))? {
            if let Some(wanted) = wanted(said) {
                return Ok(wanted);
            }
        }
        Err(RunError::Timeout(LIMIT))
    }

    /// Waits for a turn of the board's loop, in which it measures at most one block. Returns all messages before the status.
    ///
    /// The board answers bytes before it measures the block that waits, so only the second status comes after the block.
    pub fn turn(&mut self) -> Result<Vec<Said>, RunError> {
        let mut before = self.until_status()?;
        before.extend(self.until_status()?);
        Ok(before)
    }

    /// Asks for the status. Returns all messages before it.
    fn until_status(&mut self) -> Result<Vec<Said>, RunError> {
        let (mut before, mut answered) = (Vec::new(), false);
        self.tag = self.tag.wrapping_add(1);
        let request = Request { tag: self.tag, command: Command::Status };
        self.send(&request.to_frame())?;
        self.expect(|said| match said {
            Said::Answer(answer, _) if answer == request.answer() => {
                answered = true;
                None
            }
            Said::Status(_) if answered => Some(()),
            other => {
                before.push(other);
                None
            }
        })?;
        Ok(before)
    }

    /// Asks a question and gives the answer to it.
    pub fn request(&mut self, command: Command) -> Result<Result<Vec<u8>, Refusal>, RunError> {
        self.tag = self.tag.wrapping_add(1);
        let request = Request { tag: self.tag, command };
        self.send(&request.to_frame())?;
        self.expect(|said| match said {
            Said::Answer(answer, body) if answer == request.answer() => Some(body),
            _ => None,
        })
    }
}

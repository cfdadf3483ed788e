//! Commands of a host to an instrument, and its answers.
//!
//! ```text
//! host -> board  Kind::Command  tag: u8 | command: u8 | body
//! board -> host  Kind::Reply    tag: u8 | command: u8 | body
//!                Kind::Refusal  tag: u8 | command: u8 | reason: u8 | detail: [u8; 2]
//! ```
//!
//! The host chooses the tag and the answer repeats it, so an answer belongs to one question. A
//! damaged frame is answered by a refusal with tag and command 0.

use super::frame::{self, Frame, Kind, WIRE};
use crate::settings::Settings;
use crate::settings_error::SettingsError;
use heapless::Vec;

/// A question or an order.
#[expect(clippy::large_enum_variant, reason = "nothing is allocated here, and there is one of it")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Asks for the boot record; answered by a [`super::boot::Boot`].
    Identify,
    /// Measure.
    Start,
    /// Stop measuring.
    Stop,
    /// Asks for the settings in use; answered by them, rounded to what the board does.
    GetSettings,
    /// Use these settings from now on; the number is the block's length. Answered by the settings
    /// as rounded. Nothing changes if they cannot work.
    SetSettings(Settings, usize),
    /// Store the settings in use in flash.
    Save,
    /// Send this many blocks of raw samples, each after its telemetry. Blocks that pass during the
    /// sending are lost and counted.
    Capture(u16),
    /// Set the counters to 0.
    Reset,
    /// Restart, as from power-on.
    Reboot,
    /// Asks for the status; answered, and a [`super::status::Status`] follows.
    Status,
    /// Restart and try the board, which reports in lines of text and then starts as from power-on. A board that cannot refuses it as unknown.
    SelfTest,
}

/// Why a command was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The frame was damaged.
    Damaged,
    /// The command is unknown, or its body has the wrong length.
    Unknown,
    /// The settings cannot work; the code is a
    /// [`SettingsError::code`](super::settings_error::SettingsError::code).
    Settings([u8; 2]),
    /// The flash did not store the settings.
    Flash,
    /// A capture is impossible because the instrument is stopped.
    Stopped,
    /// Settings were saved too often: each save wears the flash.
    Often,
}

impl Refusal {
    const fn code(self) -> [u8; 3] {
        match self {
            Refusal::Damaged => [1, 0, 0],
            Refusal::Unknown => [2, 0, 0],
            Refusal::Settings([what, how]) => [3, what, how],
            Refusal::Flash => [4, 0, 0],
            Refusal::Stopped => [5, 0, 0],
            Refusal::Often => [6, 0, 0],
        }
    }

    const fn of_code([reason, what, how]: [u8; 3]) -> Option<Self> {
        match reason {
            1 => Some(Refusal::Damaged),
            2 => Some(Refusal::Unknown),
            3 => Some(Refusal::Settings([what, how])),
            4 => Some(Refusal::Flash),
            5 => Some(Refusal::Stopped),
            6 => Some(Refusal::Often),
            _ => None,
        }
    }
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Refusal::Damaged => "the command arrived damaged: send it again",
            Refusal::Unknown => "the board does not know the command: flash the same version",
            Refusal::Settings(code) => SettingsError::message_of(*code),
            Refusal::Flash => "the board's flash did not take the settings",
            Refusal::Stopped => "the board is not measuring: start it first",
            Refusal::Often => {
                "settings were saved too often, and each save wears the flash: wait ten minutes"
            }
        })
    }
}

impl core::error::Error for Refusal {}

/// A command with its tag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The host's tag.
    pub tag: u8,
    /// The command.
    pub command: Command,
}

/// The head of an answer: the tag and the command's number from the request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// The host's tag.
    pub tag: u8,
    /// The number of the command, [`Command::number`].
    pub command: u8,
}

impl Command {
    /// The number of the command on the wire.
    pub const fn number(&self) -> u8 {
        match self {
            Command::Identify => 1,
            Command::Start => 2,
            Command::Stop => 3,
            Command::GetSettings => 4,
            Command::SetSettings(..) => 5,
            Command::Save => 6,
            Command::Capture(_) => 7,
            Command::Reset => 8,
            Command::Reboot => 9,
            Command::Status => 10,
            Command::SelfTest => 11,
        }
    }
}

impl Request {
    /// The request as a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        let head = [self.tag, self.command.number()];
        match self.command {
            Command::SetSettings(settings, n) => {
                from_parts(Kind::Command, &head, &settings.to_bytes(n))
            }
            Command::Capture(blocks) => from_parts(Kind::Command, &head, &blocks.to_le_bytes()),
            _ => from_parts(Kind::Command, &head, &[]),
        }
    }

    /// The request in a frame of [`Kind::Command`].
    ///
    /// # Errors
    /// The frame holds no request that can be followed. The head and the refusal are the answer to
    /// send.
    pub fn from_frame(frame: &Frame) -> Result<Self, (Answer, Refusal)> {
        let Some((&[tag, command], body)) = frame.payload.split_first_chunk() else {
            return Err((Answer::default(), Refusal::Unknown));
        };
        let answer = Answer { tag, command };
        let unknown = Err((answer, Refusal::Unknown));
        if frame.kind != Kind::Command {
            return unknown;
        }
        let command = match (command, body) {
            (1, []) => Command::Identify,
            (2, []) => Command::Start,
            (3, []) => Command::Stop,
            (4, []) => Command::GetSettings,
            (5, body) => {
                let (settings, n) = Settings::from_bytes(body)
                    .map_err(|error| (answer, Refusal::Settings(error.code())))?;
                Command::SetSettings(settings, n)
            }
            (6, []) => Command::Save,
            (7, &[low, high]) => Command::Capture(u16::from_le_bytes([low, high])),
            (8, []) => Command::Reset,
            (9, []) => Command::Reboot,
            (10, []) => Command::Status,
            (11, []) => Command::SelfTest,
            _ => return unknown,
        };
        Ok(Request { tag, command })
    }

    /// The head of the answer to this request.
    pub const fn answer(&self) -> Answer {
        Answer { tag: self.tag, command: self.command.number() }
    }
}

impl Answer {
    /// A reply with this head and this body.
    pub fn reply(self, body: &[u8]) -> Vec<u8, WIRE> {
        from_parts(Kind::Reply, &[self.tag, self.command], body)
    }

    /// A refusal with this head.
    pub fn refusal(self, refusal: Refusal) -> Vec<u8, WIRE> {
        from_parts(Kind::Refusal, &[self.tag, self.command], &refusal.code())
    }

    /// The head of an answer in a frame, and the body or the refusal. `None` for a frame of another
    /// kind or form.
    pub fn from_frame(frame: &Frame) -> Option<(Self, Result<&[u8], Refusal>)> {
        let (&[tag, command], body) = frame.payload.split_first_chunk()?;
        let said = match frame.kind {
            Kind::Reply => Ok(body),
            Kind::Refusal => Err(Refusal::of_code(*body.first_chunk()?)?),
            _ => return None,
        };
        Some((Self { tag, command }, said))
    }
}

fn from_parts(kind: Kind, head: &[u8], body: &[u8]) -> Vec<u8, WIRE> {
    let mut payload = Vec::<u8, { frame::PAYLOAD }>::new();
    let fits = payload.extend_from_slice(head).is_ok() && payload.extend_from_slice(body).is_ok();
    // Every body is shorter than a payload; tests show it.
    if fits { frame::encode(kind, &payload).unwrap_or_default() } else { Vec::new() }
}

//! The boot record: what an instrument says of itself at its start, and when a host asks.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version of this layout: u8 |
//! | 1 | source of the clock: u8, 0 external, 1 internal, 2 internal and slow |
//! | 2 | reset causes: u8, bit 0 power or brown-out, 1 pin, 2 software, 3 watchdog, 4 other |
//! | 3 | flags: u8, bit 0 measuring, 1 settings from flash, 2 these settings do not work here, 3 the settings in flash cannot be read, 4 none are in flash, 5 stopped after three crashes in a row |
//! | 4 | CRC-32 of the program: u32 |
//! | 8 | CRC-32 of the settings in use: u32 |
//! | 12 | samples in a block: u32 |
//! | 16 | core's clock: u32, Hz |
//! | 20 | how the last program ended: u32, 0 unknown, 1 hard fault, 2 unexpected interrupt, 3 the external clock failed, 4 panic, 5 stack overflow |
//! | 24 | program counter at that end: u32 |
//! | 28 | two further words about that end: 2 u32 |
//! | 36 | the board's name: 16 bytes of ASCII, zeros behind it |

use super::frame::{self, Frame, Kind, WIRE};
use crate::bytes::{Reader, Writer};
use heapless::Vec;

/// The source of the sample clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Clock {
    /// A crystal or an external clock: some ten ppm.
    External = 0,
    /// The internal oscillator, because the external clock did not start: frequencies may be 1 %
    /// wrong.
    Internal = 1,
    /// The internal oscillator without its multiplier: also 1 %, and slow.
    #[default]
    Slow = 2,
}

impl Clock {
    /// The source with this number on the wire; `None` for an unknown number.
    pub const fn from_u8(code: u8) -> Option<Self> {
        match code {
            0 => Some(Clock::External),
            1 => Some(Clock::Internal),
            2 => Some(Clock::Slow),
            _ => None,
        }
    }

    /// The source's name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Clock::External => "external",
            Clock::Internal => "internal",
            Clock::Slow => "slow",
        }
    }

    /// The source in words, for a user.
    pub const fn message(self) -> &'static str {
        match self {
            Clock::External => "the crystal",
            Clock::Internal => {
                "internal oscillator (1 %): the external clock did not come, see the board's page in docs/"
            }
            Clock::Slow => {
                "internal oscillator without its multiplier (1 %, slow): it did not lock"
            }
        }
    }
}

/// A board's name: up to 16 bytes of ASCII.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Name([u8; 16]);

impl Name {
    /// A board's name. A longer name is cut; a letter outside ASCII becomes a question mark.
    pub const fn new(name: &str) -> Self {
        let mut bytes = [0; 16];
        let mut rest: &mut [u8] = &mut bytes;
        let mut letters = name.as_bytes();
        while let (Some((place, more)), Some((&letter, others))) =
            (rest.split_first_mut(), letters.split_first())
        {
            *place = if letter.is_ascii_graphic() || letter == b' ' { letter } else { b'?' };
            (rest, letters) = (more, others);
        }
        Name(bytes)
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        let used = self.0.iter().position(|&letter| letter == 0).unwrap_or(self.0.len());
        self.0.get(..used).and_then(|name| str::from_utf8(name).ok()).unwrap_or("?")
    }
}

/// How the previous program ended. Memory keeps it over the reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LastEnd {
    /// 0 nothing known, 1 a hard fault, 2 an unexpected interrupt, 3 the external clock failed, 4 a panic, 5 the stack overflowed.
    pub kind: u32,
    /// The program counter at the end.
    pub pc: u32,
    /// After a hard fault: the link register and CFSR. After an interrupt: its number. After a panic: its line. After an overflow: the
    /// stack pointer.
    pub more: [u32; 2],
}

/// Reset causes, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Causes(pub u8);

impl Causes {
    /// The causes in words, the gravest first.
    pub const fn message(self) -> &'static str {
        match self.0 {
            causes if causes & 8 != 0 => "watchdog",
            causes if causes & 1 != 0 => "power",
            causes if causes & 4 != 0 => "software",
            causes if causes & 2 != 0 => "reset button",
            causes if causes & 16 != 0 => "other",
            _ => "unknown",
        }
    }
}

/// Where an instrument's settings come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Origin {
    /// A host gave them before a restart.
    #[default]
    Host,
    /// They were saved in flash.
    Flash,
    /// They are the default ones: none are in flash.
    Default,
    /// They are the default ones, and it waits stopped: those in flash cannot be read, because another program saved them or they are
    /// damaged. They stay there until a host saves others.
    Unreadable,
}

impl Origin {
    /// The origin in words, for a user.
    pub const fn message(self) -> &'static str {
        match self {
            Origin::Host => "settings as given",
            Origin::Flash => "settings from its flash",
            Origin::Default => "the default settings, for it has saved none",
            Origin::Unreadable => {
                "settings in its flash that it cannot read, so it is stopped with the default ones: give it settings and save them"
            }
        }
    }

    const fn flags(self) -> u8 {
        match self {
            Origin::Host => 0,
            Origin::Flash => 2,
            Origin::Unreadable => 8,
            Origin::Default => 16,
        }
    }

    const fn of_flags(flags: u8) -> Self {
        match flags {
            flags if flags & 2 != 0 => Origin::Flash,
            flags if flags & 8 != 0 => Origin::Unreadable,
            flags if flags & 16 != 0 => Origin::Default,
            _ => Origin::Host,
        }
    }
}

/// A boot record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boot {
    /// The board's name.
    pub board: Name,
    /// The source of the sample clock.
    pub clock: Clock,
    /// Why the chip was reset.
    pub causes: Causes,
    /// Whether the instrument measures.
    pub measuring: bool,
    /// Where its settings come from.
    pub origin: Origin,
    /// Whether it waits stopped because it has ended abnormally three times in a row, each time within a minute. An order that starts it,
    /// or power-on, ends that.
    pub halted: bool,
    /// Whether those settings do not work here, so that it waits with the default ones.
    pub unfit: bool,
    /// CRC-32 of the program in flash.
    pub program: u32,
    /// CRC-32 of the settings in use.
    pub settings: u32,
    /// Samples in a block.
    pub n: u32,
    /// The core's clock, Hz.
    pub core_hz: u32,
    /// How the previous program ended.
    pub last: LastEnd,
}

const VERSION: u8 = 2;

impl Boot {
    /// Length of the record, bytes.
    pub const BYTES: usize = 52;

    /// The record as bytes.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let flags =
            u8::from(self.measuring) | u8::from(self.unfit) << 2 | u8::from(self.halted) << 5;
        let flags = flags | self.origin.flags();
        let LastEnd { kind, pc, more: [a, b] } = self.last;
        let words = [self.program, self.settings, self.n, self.core_hz, kind, pc, a, b];
        let mut bytes = [0; Self::BYTES];
        let mut writer = Writer::new(&mut bytes);
        writer.put([VERSION, self.clock as u8, self.causes.0, flags]);
        for word in words {
            writer.u32(word);
        }
        writer.put(self.board.0);
        bytes
    }

    /// The record as a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        frame::encode(Kind::Boot, &self.to_bytes()).unwrap_or_default()
    }

    /// The record in these bytes; `None` if they are too short, of another version, or hold an
    /// unknown number. Bytes appended by a later version are ignored.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut reader = Reader(bytes);
        let [VERSION, clock, causes, flags] = reader.take()? else { return None };
        let mut word = || reader.u32();
        let [program, settings, n, core_hz, kind, pc, a, b] =
            [word()?, word()?, word()?, word()?, word()?, word()?, word()?, word()?];
        Some(Self {
            board: Name(reader.take()?),
            clock: Clock::from_u8(clock)?,
            causes: Causes(causes),
            measuring: flags & 1 != 0,
            origin: Origin::of_flags(flags),
            unfit: flags & 4 != 0,
            halted: flags & 32 != 0,
            program,
            settings,
            n,
            core_hz,
            last: LastEnd { kind, pc, more: [a, b] },
        })
    }

    /// The record in a frame; `None` if the frame holds none.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        (frame.kind == Kind::Boot).then(|| Self::from_bytes(&frame.payload)).flatten()
    }
}

//! What an instrument says of itself when it starts, or when it is asked.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version of this layout: u8 |
//! | 1 | source of the clock: u8, 0 external, 1 internal, 2 internal and slow |
//! | 2 | reset causes: u8, bit 0 power or brown-out, 1 pin, 2 software, 3 watchdog, 4 other |
//! | 3 | flags: u8, bit 0 measuring, 1 settings from flash, 2 the settings in flash do not work here |
//! | 4 | CRC-32 of the program: u32 |
//! | 8 | CRC-32 of the settings in use: u32 |
//! | 12 | samples in a block: u32 |
//! | 16 | core's clock: u32, Hz |
//! | 20 | the last end: u32, 0 none, 1 hard fault, 2 unexpected interrupt |
//! | 24 | program counter there: u32 |
//! | 28 | two further words of it: 2 u32 |
//! | 36 | the board's name: 16 bytes of ASCII, zeros behind it |

use super::frame::{self, Frame, Kind, WIRE};
use crate::bytes::{Reader, Writer};
use heapless::Vec;

/// Where the sample clock comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Clock {
    /// A crystal, or a clock from outside: some ten ppm.
    External = 0,
    /// The internal oscillator, as the external clock did not come: frequencies may be 1 % wrong.
    Internal = 1,
    /// The internal oscillator without its multiplier: as wrong, and slow.
    #[default]
    Slow = 2,
}

impl Clock {
    /// The source with this number.
    pub const fn from_u8(code: u8) -> Option<Self> {
        match code {
            0 => Some(Clock::External),
            1 => Some(Clock::Internal),
            2 => Some(Clock::Slow),
            _ => None,
        }
    }

    /// What a user should know.
    pub const fn message(self) -> &'static str {
        match self {
            Clock::External => "crystal",
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
    /// The name; what is longer is cut, what is not ASCII becomes a question mark.
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

    /// As text.
    pub fn as_str(&self) -> &str {
        let used = self.0.iter().position(|&letter| letter == 0).unwrap_or(self.0.len());
        self.0.get(..used).and_then(|name| str::from_utf8(name).ok()).unwrap_or("?")
    }
}

/// How the program before this one ended, kept over the reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LastEnd {
    /// 0 nothing known, 1 a hard fault, 2 an unexpected interrupt.
    pub kind: u32,
    /// The program counter.
    pub pc: u32,
    /// Hard fault: the link register and CFSR. Interrupt: its number.
    pub more: [u32; 2],
}

/// Reset causes, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Causes(pub u8);

impl Causes {
    /// In words, the gravest first.
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

/// The record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boot {
    /// The board.
    pub board: Name,
    /// Where the clock comes from.
    pub clock: Clock,
    /// Why the chip was reset.
    pub causes: Causes,
    /// Whether it measures.
    pub measuring: bool,
    /// Whether its settings come from flash.
    pub stored: bool,
    /// Whether the settings in flash were found not to work, so that the default ones are in use.
    pub unfit: bool,
    /// CRC-32 of the program in flash.
    pub program: u32,
    /// CRC-32 of the settings in use.
    pub settings: u32,
    /// Samples in a block.
    pub n: u32,
    /// The core's clock, Hz.
    pub core_hz: u32,
    /// How the last program ended.
    pub last: LastEnd,
}

const VERSION: u8 = 2;

impl Boot {
    /// Bytes of the record.
    pub const BYTES: usize = 52;

    /// The record's bytes.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let flags = [self.measuring, self.stored, self.unfit];
        let flags = flags.iter().rev().fold(0, |bits, &flag| bits << 1 | u8::from(flag));
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

    /// As a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        frame::encode(Kind::Boot, &self.to_bytes()).unwrap_or_default()
    }

    /// The record in these bytes; what a later version appends is passed over.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
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
            stored: flags & 2 != 0,
            unfit: flags & 4 != 0,
            program,
            settings,
            n,
            core_hz,
            last: LastEnd { kind, pc, more: [a, b] },
        })
    }

    /// The record a frame carries.
    pub fn of_frame(frame: &Frame) -> Option<Self> {
        (frame.kind == Kind::Boot).then(|| Self::of_bytes(&frame.payload)).flatten()
    }
}

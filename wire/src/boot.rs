//! The boot record: the state of an instrument at its start, and when a host asks.

use crate::layout::{Field, Form, Reader, Writer, as_number, layout, named, record};

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
#[repr(u8)]
pub enum Origin {
    /// A host gave them before a restart.
    #[default]
    Host = 0,
    /// They were saved in flash.
    Flash = 1,
    /// They are the default ones: none are in flash.
    Default = 2,
    /// They are the default ones, and it waits stopped: those in flash cannot be read, because another program saved them or they are
    /// damaged. They stay there until a host saves others.
    Unreadable = 3,
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

    /// The origin with this number on the wire; `None` for an unknown number.
    pub const fn from_u8(number: u8) -> Option<Self> {
        match number {
            0 => Some(Origin::Host),
            1 => Some(Origin::Flash),
            2 => Some(Origin::Default),
            3 => Some(Origin::Unreadable),
            _ => None,
        }
    }

    /// The origin's name.
    pub const fn name(self) -> &'static str {
        match self {
            Origin::Host => "host",
            Origin::Flash => "flash",
            Origin::Default => "default",
            Origin::Unreadable => "unreadable",
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

layout! {
    /// The end of the last program.
    LastEnd {
        /// 0 unknown, 1 hard fault, 2 unexpected interrupt, 3 the external clock failed, 4 panic, 5 stack overflow.
        kind: u32,
        /// Program counter at that end.
        pc: u32,
        /// After a hard fault the link register and CFSR, after an interrupt its number, after a panic its line, after an overflow the
        /// stack pointer.
        more: [u32; 2],
    }

    /// What an instrument says of itself.
    Boot {
        /// The board's name: ASCII, zeros behind it.
        board: Name,
        /// Source of the sample clock.
        clock: Clock,
        /// Reset causes: bit 0 power or brown-out, 1 pin, 2 software, 3 watchdog, 4 other.
        causes: Causes,
        /// It measures.
        measuring: bool,
        /// Where its settings come from.
        origin: Origin,
        /// It is stopped after three crashes in a row.
        halted: bool,
        /// These settings do not work here.
        unfit: bool,
        /// CRC-32 of the program.
        program: u32,
        /// CRC-32 of the settings in use.
        settings: u32,
        /// Samples in a block.
        n: u32,
        /// The core's clock, Hz.
        core_hz: u32,
        /// The end of the last program.
        last: LastEnd,
    }
}

record!(Boot, Boot, |_| true);

named! {
    Clock: "clock", |clock| *clock as u8, Clock::from_u8, |clock| clock.name();
    Origin: "origin", |origin| *origin as u8, Origin::from_u8, |origin| origin.name();
}

as_number! {
    Causes as u8, |causes| causes.0, |bits| Some(Causes(bits));
}

impl Field for Name {
    const FORM: Form = <[u8; 16]>::FORM;
    const MOST: usize = 16;

    fn put(&self, writer: &mut Writer<'_>) {
        self.0.put(writer);
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        Field::take(reader).map(Name)
    }
}

//! What an instrument says of itself when it starts, or when it is asked.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version of this layout: u8 |
//! | 1 | source of the clock: u8 |
//! | 2 | reset causes: u8, bit 0 power or brown-out, 1 pin, 2 software, 3 watchdog, 4 other |
//! | 3 | flags: u8, bit 0 measuring, 1 settings from flash, 2 the settings in flash do not work here |
//! | 4 | CRC-32 of the program: u32 |
//! | 8 | CRC-32 of the settings in use: u32 |
//! | 12 | samples in a block: u32 |
//! | 16 | core's clock: u32, Hz |
//! | 20 | the last end: u32, 0 none, 1 hard fault, 2 unexpected interrupt |
//! | 24 | program counter there: u32 |
//! | 28 | two further words of it: 2 u32 |

use super::frame::{self, Frame, Kind, WIRE};
use crate::control::clock::Source;
use heapless::Vec;

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
    /// From RCC_CSR (RM 6.3.21): LPWR 31, WWDG 30, IWDG 29, SFT 28, POR 27, PIN 26, BOR 25.
    pub fn of_csr(csr: u32) -> Self {
        let bit = |mask: u32, place: u8| if csr & mask == 0 { 0 } else { 1 << place };
        // Every cause pulls the pin: it is told only where it stands alone.
        let others = bit(1 << 27 | 1 << 25, 0) | bit(1 << 28, 2) | bit(1 << 29, 3);
        let others = others | bit(1 << 31 | 1 << 30, 4);
        Causes(if others == 0 { bit(1 << 26, 1) } else { others })
    }

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
    /// Where the clock comes from.
    pub clock: Source,
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

const VERSION: u8 = 1;

impl Boot {
    /// Bytes of the record.
    pub const BYTES: usize = 36;

    /// The record's bytes.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let flags = [self.measuring, self.stored, self.unfit];
        let flags = flags.iter().rev().fold(0, |bits, &flag| bits << 1 | u8::from(flag));
        let LastEnd { kind, pc, more: [a, b] } = self.last;
        let words = [self.program, self.settings, self.n, self.core_hz, kind, pc, a, b];
        let mut bytes = [0; Self::BYTES];
        let (chunks, _) = bytes.as_chunks_mut();
        let head = [VERSION, self.clock as u8, self.causes.0, flags];
        let all = [head].into_iter().chain(words.map(u32::to_le_bytes));
        chunks.iter_mut().zip(all).for_each(|(place, field)| *place = field);
        bytes
    }

    /// As a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        frame::encode(Kind::Boot, &self.to_bytes()).unwrap_or_default()
    }

    /// The record in these bytes; what a later version appends is passed over.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let (&[VERSION, clock, causes, flags], rest) = bytes.split_first_chunk()? else {
            return None;
        };
        let words = rest.as_chunks().0.first_chunk::<8>()?.map(u32::from_le_bytes);
        let [program, settings, n, core_hz, kind, pc, a, b] = words;
        Some(Self {
            clock: Source::from_u8(clock)?,
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

//! The rates that a board holds: where the blocks are usual ones, and whatever the signal is.

use picket_dsp::Effort;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_firmware::nucleo_f446re::words::sampling;
use picket_firmware::{nucleo_f446re, pico};
use std::fmt;

/// The highest rates of one kind of record, of those that the board's timers make.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// What the records are called.
    pub kind: &'static str,
    /// Where now and then a block takes longer than usual: what the board takes, Hz.
    pub usual_hz: f64,
    /// Where each block may take as long as any that a search over signals found with this effort, Hz; none if there was no search.
    pub always_hz: Vec<(Effort, f64)>,
}

/// The rates of the NUCLEO at 180 MHz.
pub fn nucleo() -> [Rates; 2] {
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    let fastest = |cycles| sampling::fastest(&tree, nucleo_f446re::N as u32, cycles);
    let [real, iq] = sampling::BLOCK_CYCLES.map(fastest);
    let [always, always_iq] = sampling::WORST_CYCLES
        .map(|cycles| Effort::ALL.iter().copied().zip(cycles.map(fastest)).collect());
    [
        Rates { kind: "real", usual_hz: real, always_hz: always },
        Rates { kind: "I/Q", usual_hz: iq, always_hz: always_iq },
    ]
}

/// The rates of the Pico.
pub fn pico() -> [Rates; 2] {
    let fastest = pico::words::fastest;
    // The image has no joint fit.
    let always = vec![(Effort::LOOK, fastest(pico::words::WORST_CYCLES, false))];
    [
        Rates { kind: "real", usual_hz: fastest(0, false), always_hz: always },
        Rates { kind: "I/Q", usual_hz: fastest(0, true), always_hz: Vec::new() },
    ]
}

impl fmt::Display for Rates {
    /// A line, in thousands of samples a second.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} records: {:.1} kS/s of usual blocks", self.kind, self.usual_hz / 1e3)?;
        if self.always_hz.is_empty() {
            return f.write_str("; of what takes longest not searched");
        }
        f.write_str("; whatever the signal is ")?;
        for (at, (effort, rate_hz)) in self.always_hz.iter().enumerate() {
            let comma = if at > 0 { ", " } else { "" };
            write!(f, "{comma}{:.1} at effort {}", rate_hz / 1e3, effort.name())?;
        }
        Ok(())
    }
}

//! The program as it was executed, from the emulator's log: which pieces of it ran, in which order.

use super::cycles::Clock;
use super::step::Step;
use std::collections::HashMap;
use std::rc::Rc;

/// The registers that `firmware/src/mps2/count.rs` copies to themselves where work begins and ends.
const BEGIN: u8 = 8;
const END: u8 = 9;

/// What was executed between two marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Section {
    /// Instructions.
    pub instructions: u64,
    /// Modelled cycles.
    pub cycles: u64,
}

/// Follows the log.
#[derive(Debug)]
pub struct Trace {
    clock: Clock,
    /// Pieces by their place in the emulator, which translates a piece anew where it has to be shorter.
    pieces: HashMap<u64, Rc<[Step]>>,
    /// The piece that the emulator translates.
    new: Vec<Step>,
    /// The piece that is being executed: it counts once the log shows what came after it.
    running: Option<Rc<[Step]>>,
    instructions: u64,
    begin: Option<(u64, u64)>,
    /// What was found.
    pub sections: Vec<Section>,
}

impl Trace {
    /// Nothing was executed yet.
    pub fn new(clock: Clock) -> Self {
        Self {
            clock,
            pieces: HashMap::new(),
            new: Vec::new(),
            running: None,
            instructions: 0,
            begin: None,
            sections: Vec::new(),
        }
    }

    /// Takes the log's next line.
    pub fn line(&mut self, line: &str) {
        if let Some(rest) = line.strip_prefix("Trace ") {
            self.runs(rest);
        } else if line.starts_with("IN:") {
            self.new.clear();
        } else if line.starts_with("0x") {
            self.new.extend(Step::read(line));
        } else if line.starts_with("Stopped execution of TB chain") {
            // The piece was about to run, and an interrupt or the emulator's clock came before it.
            self.running = None;
        } else if let Some((_, at)) = line.split_once("rewound execution of TB to ") {
            // Its access to a device is done once more, in a piece of its own.
            if let (Some(piece), Some(at)) = (self.running.take(), number(at)) {
                let done: Vec<Step> =
                    piece.iter().take_while(|step| step.address < at).copied().collect();
                self.finish(&done, None);
            }
        }
    }

    /// `0: 0x7fd1a4000100 [00800408/00000140/00000110/ff020200] name`: the piece's place, and where it begins.
    fn runs(&mut self, rest: &str) {
        let mut words = rest.split_whitespace().skip(1);
        let Some(place) = words
            .next()
            .and_then(|word| u64::from_str_radix(word.trim_start_matches("0x"), 16).ok())
        else {
            return;
        };
        if !self.new.is_empty() {
            self.pieces.insert(place, std::mem::take(&mut self.new).into());
        }
        let next = self.pieces.get(&place).cloned();
        if let Some(piece) = self.running.take() {
            self.finish(&piece, next.as_ref().and_then(|next| next.first()));
        }
        self.running = next;
    }

    fn finish(&mut self, piece: &[Step], next: Option<&Step>) {
        for (index, step) in piece.iter().enumerate() {
            let last = index + 1 == piece.len();
            let to = next.filter(|next| last && (step.jumps || next.address != step.end()));
            match step.mark {
                Some(BEGIN) => self.begin = Some((self.instructions, self.clock.cycles)),
                Some(END) => {
                    self.sections.extend(self.begin.take().map(|(instructions, cycles)| Section {
                        instructions: self.instructions - instructions,
                        cycles: self.clock.cycles - cycles,
                    }))
                }
                _ => {
                    self.instructions += 1;
                    self.clock.execute(step, to);
                }
            }
        }
    }
}

fn number(text: &str) -> Option<u32> {
    u32::from_str_radix(text.trim().trim_start_matches("0x"), 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The log of a loop of three instructions that runs twice between the marks, with all that the emulator does besides.
    const LOG: &str = "\
IN: main
0x00000100:  46c0       mov      r8, r8
0x00000102:  6808       ldr      r0, [r1]
0x00000104:  46c9       mov      sb, sb

Trace 0: 0x7f0000000100 [00800400/00000100/00000010/ff020200] main
cpu_io_recompile: rewound execution of TB to 00000102
IN: main
0x00000102:  6808       ldr      r0, [r1]

Trace 0: 0x7f0000000200 [00800400/00000102/00000010/ff020200] main
IN: main
0x00000104:  46c9       mov      sb, sb
0x00000106:  46c0       mov      r8, r8

Trace 0: 0x7f0000000300 [00800400/00000104/00000010/ff020200] main
IN: main
0x00000108:  1c40       adds     r0, r0, #1
0x0000010a:  4290       cmp      r0, r2
0x0000010c:  d1fc       bne      #0x108

Trace 0: 0x7f0000000400 [00800400/00000108/00000010/ff020200] main
Stopped execution of TB chain before 0x7f0000000400 [00000108] main
Trace 0: 0x7f0000000400 [00800400/00000108/00000010/ff020200] main
Trace 0: 0x7f0000000400 [00800400/00000108/00000010/ff020200] main
IN: main
0x0000010e:  46c9       mov      sb, sb
0x00000110:  e7fe       b        #0x110

Trace 0: 0x7f0000000500 [00800400/0000010e/00000010/ff020200] main
Trace 0: 0x7f0000000500 [00800400/0000010e/00000010/ff020200] main
";

    #[test]
    fn what_was_executed_counts_once() {
        let mut trace = Trace::new(Clock::of(&crate::bench::CORES[0]).unwrap());
        LOG.lines().for_each(|line| trace.line(line));
        // Six instructions, and the refill of the branch that was taken.
        let sections =
            [Section { instructions: 1, cycles: 2 }, Section { instructions: 6, cycles: 7 }];
        assert_eq!(trace.sections, sections);
    }
}

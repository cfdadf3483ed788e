//! Modelled cycles: the executed instructions, one after the other, by Arm's tables of their timing.
//!
//! The tables: Cortex-M4 (DDI 0439D, 3.3.1, 3.3.2, 7.2.3), Cortex-M3 (DDI 0337I, 3.3.1, 3.3.2), Cortex-M0+ (DDI 0484C, 3.3). What they
//! leave open is set as follows: a taken branch refills the pipeline in one cycle, in two if its target is known late (BX, POP) or is
//! a wide instruction across two words; a division takes 7 cycles, a long multiplication of the Cortex-M3 4, with a sum 6; `MULS` of
//! the Cortex-M0+ takes 1. No wait states, no contention, no interrupts.

use super::Core;
use super::step::{Access, Kind, Step};
use crate::emulator::Machine;
use crate::toolchain::Target;

/// A core whose timing is published.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Table {
    M4,
    M3,
    M0,
}

/// A core that executes one instruction after the other, and its clock.
#[derive(Clone, Debug)]
pub struct Clock {
    table: Table,
    /// Cycles since the start.
    pub cycles: u64,
    /// When a division or root of the floating-point unit is done.
    float_done: u64,
    before: Option<Step>,
}

impl Clock {
    /// The clock of a core; `None` if Arm publishes no table of it.
    pub fn of(core: &Core) -> Option<Self> {
        let table = match (core.machine, core.target) {
            (Machine::An386, _) => Table::M4,
            (Machine::An385, Target::M3) => Table::M3,
            (Machine::An385, Target::M0) => Table::M0,
            _ => return None,
        };
        Some(Self { table, cycles: 0, float_done: 0, before: None })
    }

    /// Executes an instruction. `to` is where the program goes on if that is not behind it.
    pub fn execute(&mut self, step: &Step, to: Option<&Step>) {
        let cycles = self.cost(step) + to.map_or(0, |to| self.refill(step, to));
        if step.is_float() && self.float_done > self.cycles {
            self.cycles = self.float_done;
        }
        if step.kind == Kind::FloatDivision {
            self.float_done = self.cycles + 14;
        }
        self.cycles += cycles;
        self.before = Some(*step);
    }

    /// Cycles until the first instruction at a branch's target executes.
    fn refill(&self, step: &Step, to: &Step) -> u64 {
        if self.table == Table::M0 {
            // POP with the program counter takes two more than without, BL two more than it would untaken.
            return if step.words() > 0 || step.links { 2 } else { 1 };
        }
        let across = to.wide && !to.address.is_multiple_of(4);
        1 + u64::from(step.late || across)
    }

    fn cost(&self, step: &Step) -> u64 {
        let words = step.words();
        match (self.table, step.kind) {
            (Table::M0, Kind::Load(_) | Kind::Store(_)) => 2,
            (_, Kind::Load(access)) => self.load(access) + self.stall(step),
            (_, Kind::Store(access)) => self.store(access) + self.stall(step),
            (Table::M0, Kind::Words(_)) => 1 + words,
            (_, Kind::Words(_)) => 1 + words + self.stall(step),
            (_, Kind::FloatMemory) => 2 + self.stall(step),
            (_, Kind::FloatSum) => 3 + self.consumes(step),
            (_, Kind::Float | Kind::FloatDivision) => 1 + self.consumes(step),
            (_, Kind::TwoRegisters) => 2,
            (_, Kind::Division) => 7,
            (Table::M3, Kind::Sum) => 2,
            (Table::M3, Kind::Long) => 4,
            (Table::M3, Kind::LongSum) => 6,
            (_, Kind::Table) => 2,
            // It is folded into a narrow instruction before it.
            (Table::M4 | Table::M3, Kind::IfThen) => match &self.before {
                Some(before) if !before.wide => 0,
                _ => 1,
            },
            (Table::M0, Kind::System) => 3,
            _ => 1,
        }
    }

    /// Loads of one word follow each other in one cycle each, after the first.
    fn load(&self, access: Access) -> u64 {
        if access == Access::Update { 2 } else { 2 - self.pipelined() }
    }

    /// The write buffer hides the second cycle unless the address takes two registers.
    fn store(&self, access: Access) -> u64 {
        if access == Access::Index { 2 - self.pipelined() } else { 1 }
    }

    fn pipelined(&self) -> u64 {
        match &self.before {
            Some(Step { kind: Kind::Load(access), .. }) => u64::from(*access != Access::Update),
            _ => 0,
        }
    }

    /// An address waits a cycle for the instruction or the load before that makes it.
    fn stall(&self, step: &Step) -> u64 {
        let Some(before) = &self.before else { return 0 };
        if before.writes & step.address_of == 0 {
            return 0;
        }
        match before.kind {
            Kind::Load(_) => 1,
            _ => u64::from(!before.is_memory()),
        }
    }

    /// A result of the floating-point unit's arithmetic can be read after one more cycle.
    fn consumes(&self, step: &Step) -> u64 {
        match &self.before {
            Some(before) if before.is_arithmetic() => {
                u64::from(before.floats & step.reads_floats != 0)
            }
            _ => 0,
        }
    }
}

/// From modelled cycles to the most that a chip is to be expected to take with program and data in memories without wait states.
///
/// Of CMSIS-DSP 4.5 on an LPC4370 with its program in RAM, measured by E. Hughes (github.com/ehughes/ESC-M4, sheets 8 and 9), the model
/// meets a filter of floats to the cycle, and is 4 to 10 % below the transform of floats
/// (`host-tests/tests/cycles.rs`).
pub fn range(cycles: u64) -> [u64; 2] {
    [cycles, cycles + cycles / 10]
}

/// The fewest and the most cycles of this many instructions on cores without a table; `None` for the Cortex-M7, which issues two
/// instructions at a time where it can.
///
/// Cortex-M33: as on the Cortex-M4, on which the kernels take 1.2 to 1.6 cycles an instruction. Cortex-M55: a vector instruction keeps its
/// unit (loads and stores, sums, products) busy for two cycles, two of different units overlap by one, and a scatter takes a cycle a word
/// (software optimization guide). Of FFT and peak 33 of 100 instructions are vector loads and stores, 33 sums, 20 products, 3 scatters:
/// the low figure if every two neighbours overlap, the high one if none do.
pub fn rough(core: &Core, instructions: u64) -> Option<[u64; 2]> {
    let factors = match core.target {
        Target::M33 => [1.2, 1.6],
        Target::M55 => [1.1, 2.1],
        _ => return None,
    };
    Some(factors.map(|factor: f64| (instructions as f64 * factor).round() as u64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::CORES;

    fn clock(name: &str) -> Option<Clock> {
        Clock::of(CORES.iter().find(|core| core.name == name).unwrap())
    }

    /// The cycles of these lines, each `address bytes name operands`.
    fn cycles(core: &str, lines: &[&str]) -> u64 {
        let mut clock = clock(core).unwrap();
        let steps: Vec<Step> = lines.iter().map(|line| Step::read(line).unwrap()).collect();
        steps.iter().for_each(|step| clock.execute(step, None));
        clock.cycles
    }

    /// The examples of DDI 0439D, 3.3.2.
    #[test]
    fn loads_are_pipelined_as_the_manual_says() {
        let m4 = |lines: &[&str]| cycles("M4F", lines);
        let load = "0x00000000:  6808  ldr r0, [r1]";
        assert_eq!(m4(&[load, "0x00000002:  6811  ldr r1, [r2]"]), 3);
        let index = "0x00000000:  5888  ldr r0, [r1, r2]";
        assert_eq!(m4(&[index, "0x00000002:  6158  str r0, [r3, #0x14]"]), 3);
        assert_eq!(m4(&[index, "0x00000002:  5099  str r1, [r3, r2]"]), 3);
        let third = "0x00000004:  685a  ldr r2, [r3, #4]";
        assert_eq!(
            m4(&["0x00000000:  5948  ldr r0, [r1, r5]", "0x00000002:  6811  ldr r1, [r2]", third]),
            4
        );
        // What was loaded is the next address.
        assert_eq!(m4(&[load, "0x00000002:  6802  ldr r2, [r0]"]), 4);
        // An address that the instruction before makes.
        assert_eq!(m4(&["0x00000000:  3104  adds r1, #4", "0x00000002:  6808  ldr r0, [r1]"]), 4);
        assert_eq!(
            m4(&[
                "0x00000000:  e9d0 1200  ldrd r1, r2, [r0]",
                "0x00000004:  e8b0 000e  ldm.w r0!, {r1, r2, r3}"
            ]),
            7
        );
        assert_eq!(
            m4(&["0x00000000:  6008  str r0, [r1]", "0x00000002:  6048  str r0, [r1, #4]"]),
            2
        );
    }

    #[test]
    fn floats_wait_for_each_other() {
        let m4 = |lines: &[&str]| cycles("M4F", lines);
        let product = "0x00000000:  ee20 0a20  vmul.f32 s0, s0, s1";
        assert_eq!(m4(&[product, "0x00000004:  ee71 0a01  vadd.f32 s1, s2, s2"]), 2);
        assert_eq!(m4(&[product, "0x00000004:  ee70 0a01  vadd.f32 s1, s0, s2"]), 3);
        // The sum that a product is added to is read later.
        assert_eq!(m4(&[product, "0x00000004:  ee01 0a01  vmla.f32 s0, s2, s2"]), 4);
        // Integers go on beside a division.
        let quotient = "0x00000000:  ee80 0a20  vdiv.f32 s0, s0, s1";
        let others = ["0x00000004:  3001  adds r0, #1"; 13];
        let last = "0x00000006:  ee31 1a01  vadd.f32 s2, s2, s2";
        assert_eq!(m4(&[quotient, last]), 15);
        assert_eq!(m4(&[&[quotient][..], &others, &[last]].concat()), 15);
    }

    #[test]
    fn branches_refill_the_pipeline() {
        let step = |line| Step::read(line).unwrap();
        let cost = |core, from: &Step, to: Option<&Step>| {
            let mut clock = clock(core).unwrap();
            clock.execute(from, to);
            clock.cycles
        };
        let (branch, back) =
            (step("0x00000010:  d1f6  bne #0x0"), step("0x00000010:  bd10  pop {r4, pc}"));
        let (narrow, across) = (
            step("0x00000000:  3001  adds r0, #1"),
            step("0x00000002:  eb00 0001  add.w r0, r0, r1"),
        );
        assert_eq!(
            [None, Some(&narrow), Some(&across)].map(|to| cost("M4F", &branch, to)),
            [1, 2, 3]
        );
        assert_eq!([None, Some(&narrow)].map(|to| cost("M0", &branch, to)), [1, 2]);
        assert_eq!(cost("M4F", &back, Some(&narrow)), 5);
        assert_eq!(cost("M0", &back, Some(&narrow)), 5);
        assert_eq!(cost("M0", &step("0x00000010:  f000 f801  bl #0x16"), Some(&narrow)), 3);
    }

    /// On the Cortex-M3 a product of 64 bits takes its time; of the Cortex-M33 and M7 nobody publishes what takes how long.
    #[test]
    fn cores_differ() {
        let product = ["0x00000000:  fb81 0102  smull r0, r1, r1, r2"];
        assert_eq!(["M4F", "M3"].map(|core| cycles(core, &product)), [1, 4]);
        assert!(["M33", "M7", "M55"].iter().all(|core| clock(core).is_none()));
        assert_eq!(range(1000), [1000, 1100]);
    }
}

//! A model of cycles, for orientation.

use crate::toolchain::Target;

/// The fewest and the most cycles that so many instructions of these loops take, by Arm's tables of instruction timings; no
/// measurement.
///
/// The share of each kind of instruction is that of the transform's butterfly: of 41 instructions 5 loads and 4 stores of two
/// words, and a branch. Cortex-M4: a load or store of two words takes 3 cycles, 2 where it follows another (DDI 0439D, table
/// 3-1), a taken branch 2 to 4, all others 1, long multiplications included. Cortex-M33 much the same (DDI 0553,
/// 100230). Cortex-M55: a vector instruction keeps its unit (loads and stores, sums, products) busy for two cycles, two of different
/// units overlap by one, and a scatter takes a cycle a word (software optimization guide). Of FFT and peak 33 of 100 instructions
/// are vector loads and stores, 33 sums, 20 products, 3 scatters: the low figure if every two neighbours overlap, the high one if
/// none do. Cortex-M7 issues two instructions at a time where it can: from half as many cycles. Cortex-M3: a long multiplication 3 to 5
/// cycles, with sum 4 to 7 (DDI 0337H), and a quarter of the portable loops' instructions are such. Cortex-M0: a load or store 2
/// cycles, a taken branch 3 (DDI 0432C), and `MULS` 1 cycle, not the optional 32.
///
/// Left out: wait states of the flash, caches, contention with DMA, interrupts, and where the linker puts the loops.
pub fn range(target: Target, instructions: u64) -> Option<[u64; 2]> {
    let (low, high) = match target {
        Target::M4f | Target::M33 => (1.2, 1.6),
        Target::M55 => (1.1, 2.1),
        Target::M3 => (1.5, 2.2),
        Target::M0 => (1.3, 1.8),
    };
    let scaled = |factor: f64| (instructions as f64 * factor).round() as u64;
    Some([scaled(low), scaled(high)])
}

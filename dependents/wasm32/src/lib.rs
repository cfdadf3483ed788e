//! Blocks measured in a web page's machine: `run.mjs` calls it.
#![no_std]

#[path = "../../same_bits.rs"]
mod same_bits;

use picket_dsp::Arithmetic;
use same_bits::same_bits;

/// The checksum of every tone, by either arithmetic.
#[unsafe(no_mangle)]
pub extern "C" fn checksum(fixed: bool) -> u64 {
    same_bits(if fixed { Arithmetic::Fixed } else { Arithmetic::Float }).checksum
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    core::arch::wasm32::unreachable()
}

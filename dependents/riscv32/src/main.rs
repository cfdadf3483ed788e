//! Blocks measured on a 32-bit RISC-V without a floating-point unit, as QEMU's machine `virt` emulates it: one line for each
//! arithmetic on the serial port.
#![no_std]
#![no_main]

#[path = "../../same_bits.rs"]
mod same_bits;

use core::fmt::Write;
use panic_halt as _;
use picket_dsp::Arithmetic;
use riscv_rt::entry;
use same_bits::same_bits;

#[entry]
fn main() -> ! {
    for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
        let checksum = same_bits(arithmetic).checksum;
        let _ = writeln!(Uart, "{arithmetic:?} {checksum:016x}");
    }
    // SAFETY: the machine's finisher is there, and this word ends the emulation.
    unsafe { (0x10_0000 as *mut u32).write_volatile(0x5555) };
    loop {
        core::hint::spin_loop();
    }
}

/// The machine's serial port, a 16550 that is always ready.
struct Uart;

impl Write for Uart {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            // SAFETY: the transmit register is there, and a byte written to it is sent.
            unsafe { (0x1000_0000 as *mut u8).write_volatile(byte) };
        }
        Ok(())
    }
}

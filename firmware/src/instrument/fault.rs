//! How a program ends that should not: a fault, an unexpected interrupt, a panic that cannot be.

use super::legacy::Legacy;
use core::arch::naked_asm;
use core::ptr::read_volatile;
use cortex_m::peripheral::SCB;
use picket_wire::boot::LastEnd;

/// An interrupt that nobody expects.
pub extern "C" fn unexpected() {
    // SAFETY: the system control block is always there, and reading ICSR changes nothing.
    let number = unsafe { (*SCB::PTR).icsr.read() } & 0x1FF;
    end(LastEnd { kind: 2, pc: 0, more: [number, 0] })
}

fn end(last: LastEnd) -> ! {
    Legacy { last, settings: None }.leave()
}

/// A fault hands the stack with the interrupted program's registers over.
// SAFETY: this is the name by which cortex-m-rt's vector table knows the handler, and it does not return.
#[unsafe(no_mangle)]
#[unsafe(naked)]
extern "C" fn HardFault() -> ! {
    naked_asm!("mrs r0, msp", "b {}", sym hard_fault)
}

/// # Safety
/// `frame` must be what the core stacked: eight words.
unsafe extern "C" fn hard_fault(frame: *const u32) -> ! {
    // The configurable faults' status (CFSR).
    const CFSR: *const u32 = 0xE000_ED28 as *const u32;
    // SAFETY: the caller vouches for the frame, of which lr is word 5 and pc word 6; the register is always there.
    let [lr, pc, cfsr] =
        unsafe { [read_volatile(frame.add(5)), read_volatile(frame.add(6)), read_volatile(CFSR)] };
    end(LastEnd { kind: 1, pc, more: [lr, cfsr] })
}

/// Calls a function that does not exist: the image links only if the optimiser finds no way to a panic.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn picket_can_panic() -> !;
    }
    // SAFETY: there is no such function: an image in which this call can be reached does not link.
    unsafe { picket_can_panic() }
}

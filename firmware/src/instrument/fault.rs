//! The unwanted ends of a program: by a fault, an unexpected interrupt, or a panic that cannot occur.

use super::handover::Handover;
use crate::fence;
use core::arch::naked_asm;
use core::ptr::read_volatile;
use cortex_m::peripheral::SCB;
use picket_wire::boot::LastEnd;

/// Handles an unexpected interrupt.
pub extern "C" fn unexpected() {
    // SAFETY: the system control block is always there, and reading ICSR changes nothing.
    let number = unsafe { (*SCB::PTR).icsr.read() } & 0x1FF;
    end(LastEnd { kind: 2, pc: 0, more: [number, 0] })
}

/// The vector table of a device with this number of interrupts, of which the image uses none: each restarts the board, which then reports
/// it.
#[macro_export]
macro_rules! no_interrupts {
    ($lines:expr) => {
        // SAFETY: cortex-m-rt's linker script requires this name and section for the device's part of the vector table, whose type is an
        // array of handlers.
        #[unsafe(link_section = ".vector_table.interrupts")]
        #[unsafe(no_mangle)]
        static __INTERRUPTS: [extern "C" fn(); $lines] =
            [$crate::instrument::fault::unexpected; $lines];
    };
}

/// Restarts the board, which then reports this end.
pub fn end(last: LastEnd) -> ! {
    Handover { last, ..Handover::default() }.leave()
}

/// Passes the stack with the interrupted program's registers to the fault handler, which gets the whole stack for itself: of the old one
/// nothing may be left.
// SAFETY: cortex-m-rt's vector table has the handler under this name, and it does not return.
#[unsafe(no_mangle)]
#[unsafe(naked)]
extern "C" fn HardFault() -> ! {
    // A short branch may not reach; nothing returns to the long one's link.
    #[cfg(short_products)]
    naked_asm!("mrs r0, msp", "ldr r1, =_stack_start", "mov sp, r1", "bl {}", sym hard_fault);
    #[cfg(not(short_products))]
    naked_asm!("mrs r0, msp", "ldr r1, =_stack_start", "mov sp, r1", "b {}", sym hard_fault)
}

/// # Safety
/// `frame` must be where the core stacked eight words, unless it is below the stack.
unsafe extern "C" fn hard_fault(frame: *const u32) -> ! {
    let place = frame.addr();
    if place < fence::end() {
        // The core may not have been able to stack anything.
        end(LastEnd { kind: 5, pc: 0, more: [place as u32, 0] })
    }
    // SAFETY: the caller guarantees the frame, in which lr is word 5 and pc word 6.
    let [lr, pc] = unsafe { [read_volatile(frame.add(5)), read_volatile(frame.add(6))] };
    // The configurable faults' status, which Armv6-M does not have.
    #[cfg(short_products)]
    let cfsr = 0;
    #[cfg(not(short_products))]
    // SAFETY: the system control block is always there, and reading CFSR changes nothing.
    let cfsr = unsafe { (*SCB::PTR).cfsr.read() };
    end(LastEnd { kind: 1, pc, more: [lr, cfsr] })
}

/// Restarts the board, which then reports the line: the crates for USB and for logs hold panics.
#[cfg(any(feature = "usb", feature = "defmt"))]
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    let line = info.location().map_or(0, |location| location.line());
    end(LastEnd { kind: 4, pc: 0, more: [line, 0] })
}

/// Calls a function that does not exist. The image links only if the optimiser finds no way to a
/// panic.
#[cfg(not(any(feature = "usb", feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn picket_can_panic() -> !;
    }
    // SAFETY: the function does not exist; an image that can reach this call does not link.
    unsafe { picket_can_panic() }
}

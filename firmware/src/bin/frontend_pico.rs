//! The instrument on a Raspberry Pi Pico: the converter by two DMA channels, telemetry and commands over UART0. docs/pico.md explains
//! wiring and use.
#![no_std]
#![no_main]

use core::arch::global_asm;
use cortex_m_rt::entry;
use picket_dsp::acquire::sample::Real;
use picket_dsp::pipeline::Pipeline;
use picket_firmware::instrument::Instrument;
use picket_firmware::pico::{N, Pairs, Pico, SLOT, start};
use picket_firmware::self_test;

picket_firmware::pico_vectors!();

#[entry]
fn main() -> ! {
    start::whole();
    // One converter takes the pairs of an I/Q record in turn.
    let meters = picket_firmware::meters!(Pipeline<Real, N>, Pairs);
    if self_test::due() {
        self_test::run::<Pico, N, SLOT>(meters);
    }
    match Instrument::<Pico, N, SLOT, _, _>::start(meters) {
        Some(instrument) => instrument.run(),
        // The crystal did not come: the watchdog restarts the chip.
        None => loop {
            cortex_m::asm::nop();
        },
    }
}

// Copies the code for SRAM there (`pico.x`), before any of it is called. In assembly, since a compiled loop may become a call of a copying
// function, which lies there, too.
global_asm!(
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "ldr r0, =__hot_start",
    "ldr r1, =__hot_end",
    "ldr r2, =__hot_stored",
    "b 2f",
    "1: ldmia r2!, {{r3}}",
    "stmia r0!, {{r3}}",
    "2: cmp r0, r1",
    "blo 1b",
    "bx lr",
);

//! The device's part of the vector table.

use super::{converter, serial, start};
use crate::instrument::fault;
use stm32f4::stm32f446 as pac;

/// Puts the image's handlers into its vector table.
#[macro_export]
macro_rules! nucleo_vectors {
    () => {
        // SAFETY: cortex-m-rt's linker script requires this name and section for the device's part of the vector table, whose type is an
        // array of handlers.
        #[unsafe(link_section = ".vector_table.interrupts")]
        #[unsafe(no_mangle)]
        static __INTERRUPTS: [$crate::nucleo_f446re::vectors::Handler;
            $crate::nucleo_f446re::vectors::LINES] = $crate::nucleo_f446re::vectors::HANDLERS;
    };
}

/// Interrupt lines of the chip (RM 10.2).
pub const LINES: usize = 97;
/// A handler in the vector table.
pub type Handler = unsafe extern "C" fn();

/// The device's part of the vector table: handlers for the lines in use. For every other line, a
/// handler restarts the board, which then reports the interrupt.
// A line out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
pub const HANDLERS: [Handler; LINES] = {
    let mut table: [Handler; LINES] = [fault::unexpected; LINES];
    table[pac::Interrupt::DMA2_STREAM0 as usize] = converter::filled;
    table[pac::Interrupt::ADC as usize] = converter::filled;
    table[pac::Interrupt::TIM2 as usize] = converter::pulsed;
    table[pac::Interrupt::USART2 as usize] = serial::serve;
    table[pac::Interrupt::TIM5 as usize] = start::wake;
    table
};

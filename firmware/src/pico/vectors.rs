//! The device's part of the vector table.

use super::{converter, line, start};
use crate::instrument::fault;
use rp2040_hal::pac;

/// Puts the image's handlers into its vector table, and the chip's second boot stage before it.
#[macro_export]
macro_rules! pico_vectors {
    () => {
        // SAFETY: cortex-m-rt's linker script requires this name and section for the device's part of the vector table, whose type is an
        // array of handlers.
        #[unsafe(link_section = ".vector_table.interrupts")]
        #[unsafe(no_mangle)]
        static __INTERRUPTS: [$crate::pico::vectors::Handler; $crate::pico::vectors::LINES] =
            $crate::pico::vectors::HANDLERS;

        // SAFETY: pico.x puts this section at the start of flash, where the boot ROM reads it.
        #[unsafe(link_section = ".boot2")]
        #[used]
        static BOOT2: [u8; 256] = $crate::pico::vectors::BOOT2;
    };
}

/// The chip's access to the flash of a Pico: the ROM runs this code first.
pub const BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_W25Q080;

/// Interrupt lines of the chip (DS 2.3.2), including the six that nothing drives.
pub const LINES: usize = 32;
/// A handler in the vector table.
pub type Handler = unsafe extern "C" fn();

/// The device's part of the vector table: handlers for the lines in use. For every other line, a
/// handler restarts the board, which then reports the interrupt.
// A line out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
pub const HANDLERS: [Handler; LINES] = {
    let mut table: [Handler; LINES] = [fault::unexpected; LINES];
    table[pac::Interrupt::DMA_IRQ_0 as usize] = converter::filled;
    table[pac::Interrupt::DMA_IRQ_1 as usize] = line::sent;
    table[pac::Interrupt::UART0_IRQ as usize] = line::received;
    table[pac::Interrupt::TIMER_IRQ_0 as usize] = start::wake;
    #[cfg(feature = "usb")]
    {
        table[pac::Interrupt::USBCTRL_IRQ as usize] = super::usb::event;
    }
    table
};

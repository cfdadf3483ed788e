//! ARM's MPS2 boards as QEMU emulates them: AN385 (Cortex-M3), AN386 (M4F), AN500 (M7) and AN505
//! (M33, secure side), and the MPS3 board AN547 (M55, secure side). Only AN505 has a DMA controller;
//! on AN547 an interrupt copies instead.
//!
//! Register layouts: ARM DDI 0479 (CMSDK timer and UART), DDI 0218 (PL081), DAI 0505 (AN505), DAI
//! 0547 (AN547).

#[cfg(any(an505, an547))]
pub mod converter;
pub mod count;
pub mod halt;
pub mod playback;
#[cfg(an547)]
mod vectors_an547;

use core::cell::UnsafeCell;
use core::ptr::{read_volatile, write_volatile};
use halt::{Exit, exit};

/// A register that hardware shares.
#[repr(transparent)]
struct Register(UnsafeCell<u32>);

impl Register {
    fn read(&self) -> u32 {
        // SAFETY: a register exists only inside a peripheral's block, which is always mapped.
        unsafe { read_volatile(self.0.get()) }
    }

    fn write(&self, value: u32) {
        // SAFETY: as for reading. Only the registers of the DMA controller can make memory unsafe,
        // and `Dma::start` is their only user.
        unsafe { write_volatile(self.0.get(), value) }
    }
}

/// A peripheral, the only access to its registers.
macro_rules! peripheral {
    ($(#[$doc:meta])* $name:ident, $block:ident { $($field:ident),* $(,)? }, $($instance:ident = $an505:literal, $an547:literal, $other:literal;)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name(usize);

        #[repr(C)]
        struct $block { $($field: Register),* }

        impl $name {
            $(
                #[allow(missing_docs)]
                pub const $instance: Self = Self(if cfg!(an505) {
                    $an505
                } else if cfg!(an547) {
                    $an547
                } else {
                    $other
                });
            )*

            fn registers(self) -> &'static $block {
                // SAFETY: the address is one of the constants above, at which the boards have this
                // peripheral. Registers are shared, and every access is volatile.
                unsafe { &*(self.0 as *const $block) }
            }
        }
    };
}

#[cfg_attr(an547, path = "timer_an547.rs")]
mod timer;
pub use timer::*;

peripheral! {
    /// A serial port. QEMU's port is never busy for long and has no baud rate.
    Uart, UartBlock { data, state, control, interrupt, divider },
    ZERO = 0x5020_0000, 0x5930_3000, 0x4000_4000;
    ONE = 0x5020_1000, 0x5930_4000, 0x4000_5000;
}

impl Uart {
    /// The number of times that a full port is polled before a byte is dropped. QEMU drains the port at once.
    const PATIENCE: u32 = 1_000_000;

    /// Switches the transmitter on.
    pub fn enable(self) {
        let uart = self.registers();
        uart.divider.write(16);
        uart.control.write(1);
    }

    /// Sends bytes. Returns how many it dropped.
    pub fn send(self, bytes: &[u8]) -> u32 {
        let uart = self.registers();
        let mut lost = 0u32;
        for &byte in bytes {
            let ready = (0..Self::PATIENCE).any(|_| uart.state.read() & 1 == 0);
            if ready {
                uart.data.write(byte.into());
            } else {
                lost = lost.saturating_add(1);
            }
        }
        lost
    }
}

/// Sends `name=value` and a newline.
pub fn figure(uart: Uart, name: &str, value: u64) {
    uart.send(name.as_bytes());
    uart.send(b"=");
    send_number(uart, value);
    uart.send(b"\n");
}

/// Sends a number in decimal digits. `core`'s formatting contains panics.
fn send_number(uart: Uart, number: u64) {
    let mut digits = [0u8; 20];
    let mut rest = number;
    let mut used = 0;
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
        used += 1;
        if rest == 0 {
            break;
        }
    }
    uart.send(digits.get(digits.len().saturating_sub(used)..).unwrap_or(&[]));
}

#[cfg(any(an505, an547))]
pub use dma::{DMA_IRQ, Dma};

#[cfg(an547)]
#[path = "dma_an547.rs"]
mod dma;

#[cfg(an505)]
mod dma {
    use super::Register;

    /// The interrupt at the end of a transfer (terminal count).
    pub const DMA_IRQ: usize = 57;

    #[repr(C)]
    struct Channel {
        source: Register,
        destination: Register,
        next: Register,
        control: Register,
        configuration: Register,
    }

    #[repr(C)]
    struct Block {
        status: Register,
        done: Register,
        done_clear: Register,
        error: Register,
        error_clear: Register,
        others: [Register; 7],
        configuration: Register,
        rest: [Register; 51],
        channel: Channel,
    }

    const _: () = assert!(core::mem::offset_of!(Block, channel) == 0x100);
    const _: () = assert!(core::mem::offset_of!(Block, configuration) == 0x30);

    /// The remainder of a transfer that is too long for one: the channel loads it at the end of the first part.
    #[repr(C, align(4))]
    #[derive(Clone, Copy, Debug, Default)]
    struct Link {
        source: u32,
        destination: u32,
        next: u32,
        control: u32,
    }

    /// The DMA controller PL081, number 0: one channel, memory to memory.
    ///
    /// QEMU transfers everything at once, at the write that enables the controller. Its request
    /// lines are not wired, so the timer's interrupt starts each block.
    #[derive(Debug)]
    pub struct Dma {
        link: Link,
    }

    impl Default for Dma {
        fn default() -> Self {
            Self::new()
        }
    }

    impl Dma {
        /// The largest number of words in one transfer.
        const LONGEST: usize = 2048;
        /// Words of 32 bits; both addresses count up.
        const CONTROL: u32 = 2 << 18 | 2 << 21 | 1 << 26 | 1 << 27;
        /// An interrupt at the end.
        const INTERRUPT: u32 = 1 << 31;

        /// The controller, idle.
        pub const fn new() -> Self {
            Dma { link: Link { source: 0, destination: 0, next: 0, control: 0 } }
        }

        fn registers() -> &'static Block {
            // SAFETY: AN505 has a PL081 here (secure alias); volatile access only.
            unsafe { &*(0x5011_0000 as *const Block) }
        }

        /// Starts to copy `source` to `destination`, at most 4096 words; [`DMA_IRQ`] signals the
        /// end. Returns false and does nothing if there are more words, or if the lengths differ.
        ///
        /// # Safety
        /// Until the interrupt, no other code may touch `destination`, and `source` and this `Dma` must live and stay unchanged.
        pub unsafe fn start(&mut self, source: *const [u32], destination: *mut [u32]) -> bool {
            let words = source.len();
            if words != destination.len() || words == 0 || words > 2 * Self::LONGEST {
                return false;
            }
            let first = words.min(Self::LONGEST);
            let rest = words - first;
            let (from, to) = (source.cast::<u32>() as u32, destination.cast::<u32>() as u32);
            let bytes = first as u32 * 4;
            self.link = Link {
                source: from.wrapping_add(bytes),
                destination: to.wrapping_add(bytes),
                next: 0,
                control: rest as u32 | Self::CONTROL | Self::INTERRUPT,
            };
            let last = if rest == 0 { Self::INTERRUPT } else { 0 };
            let dma = Self::registers();
            dma.configuration.write(0);
            dma.channel.source.write(from);
            dma.channel.destination.write(to);
            let next = if rest == 0 { 0 } else { &raw const self.link as u32 };
            dma.channel.next.write(next);
            dma.channel.control.write(first as u32 | Self::CONTROL | last);
            // Enabled, memory to memory, error and terminal-count interrupts let through.
            dma.channel.configuration.write(1 | 1 << 14 | 1 << 15);
            // The samples and the link must be in memory before the controller reads them.
            cortex_m::asm::dsb();
            dma.configuration.write(1);
            true
        }

        /// Clears the interrupt. Returns whether a transfer had ended.
        pub fn finish(&mut self) -> bool {
            let dma = Self::registers();
            let done = dma.done.read() & 1 != 0;
            dma.done_clear.write(1);
            dma.error_clear.write(1);
            // The barrier keeps reads of the controller's data after this point.
            cortex_m::asm::dsb();
            done
        }
    }
}

/// The number of an interrupt line, for the NVIC.
#[derive(Clone, Copy, Debug)]
pub struct Line(pub usize);

// SAFETY: the numbers are the constants of this module, all below 240.
unsafe impl cortex_m::interrupt::InterruptNumber for Line {
    fn number(self) -> u16 {
        self.0 as u16
    }
}

/// Enables an interrupt line.
pub fn enable(line: usize) {
    // SAFETY: the handlers share state with the main loop only through atomics, queues and cells made for sharing, so no critical section
    // depends on a masked line.
    unsafe { cortex_m::peripheral::NVIC::unmask(Line(line)) }
}

/// A handler in the vector table.
pub type Handler = unsafe extern "C" fn();

/// Armv6-M has half as many interrupts; `build.rs` detects it by its short products.
const LINES: usize = if cfg!(short_products) { 32 } else { 64 };

/// Handlers of the first interrupt lines, enough for every core here.
pub type Handlers = [Handler; LINES];

/// The table with these handlers; every other interrupt stops the image.
// Const functions cannot use `get_mut`; an index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
pub const fn handlers(named: &[(usize, Handler)]) -> Handlers {
    let mut table: Handlers = [unexpected; LINES];
    let mut index = 0;
    while index < named.len() {
        table[named[index].0] = named[index].1;
        index += 1;
    }
    table
}

extern "C" fn unexpected() {
    exit(Exit::Unexpected)
}

/// Puts an image's handlers into its vector table.
#[macro_export]
macro_rules! vectors {
    ($handlers:expr) => {
        // SAFETY: cortex-m-rt's linker script requires this name and section for the device's part of the vector table, whose type is an
        // array of handlers.
        #[unsafe(link_section = ".vector_table.interrupts")]
        #[unsafe(no_mangle)]
        static __INTERRUPTS: $crate::mps2::Handlers = $handlers;
    };
}

/// Puts the converter's handlers into an image's vector table. On AN547 its clock is SysTick, an exception of the core.
#[macro_export]
macro_rules! converter_vectors {
    () => {
        $crate::vectors!($crate::mps2::converter::HANDLERS);

        #[cfg(an547)]
        #[cortex_m_rt::exception]
        fn SysTick() {
            $crate::mps2::converter::timer();
        }
    };
}

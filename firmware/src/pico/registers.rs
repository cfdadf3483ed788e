//! The chip's registers by name, and the macro that writes them.

use rp2040_hal::pac;

/// Writes a word to a register.
macro_rules! put {
    ($register:expr, $word:expr) => {
        // SAFETY: `words` computes this word for this register, or the caller names its bits. The access is volatile, and only one place
        // writes the register at a time.
        $register.write(|w| unsafe { w.bits($word) })
    };
}

pub(crate) use put;

/// Access to the registers of a peripheral.
macro_rules! peripheral {
    ($($name:ident: $block:ty = $peripheral:ty;)*) => {
        $(
            #[allow(missing_docs)]
            pub fn $name() -> &'static $block {
                // SAFETY: the chip has this peripheral at this address. Registers are shared, and every
                // access is a volatile read or write.
                unsafe { &*<$peripheral>::PTR }
            }
        )*
    };
}

peripheral! {
    adc: pac::adc::RegisterBlock = pac::ADC;
    dma: pac::dma::RegisterBlock = pac::DMA;
    pwm: pac::pwm::RegisterBlock = pac::PWM;
    io: pac::io_bank0::RegisterBlock = pac::IO_BANK0;
    pads: pac::pads_bank0::RegisterBlock = pac::PADS_BANK0;
    psm: pac::psm::RegisterBlock = pac::PSM;
    resets: pac::resets::RegisterBlock = pac::RESETS;
    timer: pac::timer::RegisterBlock = pac::TIMER;
    uart: pac::uart0::RegisterBlock = pac::UART0;
    usb: pac::usbctrl_regs::RegisterBlock = pac::USBCTRL_REGS;
    watchdog: pac::watchdog::RegisterBlock = pac::WATCHDOG;
}

/// Lets an interrupt through.
pub fn enable(line: pac::Interrupt) {
    // SAFETY: the vector table has a handler for this line.
    unsafe { pac::NVIC::unmask(line) };
}

/// Waits until `ready`, for some milliseconds at most; false if it gave up.
#[must_use]
pub fn wait(mut ready: impl FnMut() -> bool) -> bool {
    (0..100_000).any(|_| ready())
}

//! The chip's registers by name.

use rp2040_hal::pac;
use rp2040_hal::pac::dma::ch::ch_al1_ctrl;

/// Writes a number to a register that is one: an address, a count, a mask of channels.
macro_rules! put {
    ($register:expr, $word:expr) => {
        // SAFETY: the register takes any number, and a channel only has addresses of registers and of memory that is its own. The access is
        // volatile, and only one place writes the register at a time.
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

/// What the control words of all channels say: on, errors of before forgotten, and the channel that the end starts, which is none if a
/// channel names itself.
pub fn control(w: &mut ch_al1_ctrl::W, next: usize) -> &mut ch_al1_ctrl::W {
    // SAFETY: the controller has a channel of this number.
    unsafe { w.chain_to().bits(next as u8) };
    w.read_error().clear_bit_by_one().write_error().clear_bit_by_one().en().set_bit()
}

/// The control word of a channel that writes a word at once.
pub fn single(w: &mut ch_al1_ctrl::W, next: usize) -> &mut ch_al1_ctrl::W {
    control(w, next).high_priority().set_bit().data_size().size_word().treq_sel().permanent()
}

/// Whether a channel has stopped with an error.
pub fn failed(channel: usize) -> bool {
    let state = dma().ch(channel).ch_al1_ctrl().read();
    state.read_error().bit_is_set() || state.write_error().bit_is_set()
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

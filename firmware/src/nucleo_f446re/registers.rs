//! The chip's registers by name.

use super::PLAYED;
use stm32f4::stm32f446 as pac;

/// Access to the registers of a peripheral.
macro_rules! peripheral {
    ($($name:ident: $block:ty = $address:expr;)*) => {
        $(
            #[allow(missing_docs)]
            pub fn $name() -> &'static $block {
                // SAFETY: the chip has this peripheral at this address, or the emulated one has
                // memory there that the linker does not use. Registers are shared, and every access
                // is a volatile read or write.
                unsafe { &*($address as *const $block) }
            }
        )*
    };
}

/// The address of the peripheral itself, or of its place in [`PLAYED`].
const fn played(own: usize, place: usize) -> usize {
    if cfg!(feature = "played") { PLAYED + place } else { own }
}

peripheral! {
    rcc: pac::rcc::RegisterBlock = pac::RCC::PTR;
    pwr: pac::pwr::RegisterBlock = pac::PWR::PTR;
    flash: pac::flash::RegisterBlock = pac::FLASH::PTR;
    iwdg: pac::iwdg::RegisterBlock = pac::IWDG::PTR;
    gpioa: pac::gpioa::RegisterBlock = pac::GPIOA::PTR;
    gpiob: pac::gpiob::RegisterBlock = pac::GPIOB::PTR;
    syscfg: pac::syscfg::RegisterBlock = pac::SYSCFG::PTR;
    spi1: pac::spi1::RegisterBlock = pac::SPI1::PTR;
    usart2: pac::usart1::RegisterBlock = pac::USART2::PTR;
    tim2: pac::tim2::RegisterBlock = pac::TIM2::PTR;
    tim3: pac::tim3::RegisterBlock = pac::TIM3::PTR;
    tim4: pac::tim3::RegisterBlock = pac::TIM4::PTR;
    tim5: pac::tim5::RegisterBlock = pac::TIM5::PTR;
    tim11: pac::tim11::RegisterBlock = pac::TIM11::PTR;
    dac: pac::dac::RegisterBlock = pac::DAC::PTR;
    dma1: pac::dma2::RegisterBlock = pac::DMA1::PTR;
    dma2: pac::dma2::RegisterBlock = played(0x4002_6400, 0);
    adc1: pac::adc1::RegisterBlock = played(0x4001_2000, 0x400);
    adc2: pac::adc1::RegisterBlock = played(0x4001_2100, 0x500);
    adc_common: pac::adc_common::RegisterBlock = played(0x4001_2300, 0x700);
}

/// The number of polls for some microseconds before a wait gives up. Longer waits use [`within`](super::start::within). Every wait ends.
pub const PATIENCE: u32 = 200_000;

/// Waits until `ready`; false if it gave up.
#[must_use]
pub fn wait(mut ready: impl FnMut() -> bool) -> bool {
    (0..PATIENCE).any(|_| ready())
}

/// Enables an interrupt line.
pub fn enable(line: pac::Interrupt) {
    // SAFETY: handlers share state with the main loop only through queues, atomics and cells made for sharing, so no critical section
    // depends on a masked line.
    unsafe { cortex_m::peripheral::NVIC::unmask(line) }
}

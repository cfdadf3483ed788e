//! A radar BGT60TR13C at the SPI of a NUCLEO-F446RE: its lamp shines while something comes nearer. Clock at PB13, data to the radar at PB15
//! and from it at PB14, its chip select at PB12, reset at PB1, interrupt at PB2.
#![no_std]
#![no_main]

use core::convert::Infallible;
use cortex_m::singleton;
use embassy_executor::Spawner;
use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{Level, Output, Pull, Speed};
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::{bind_interrupts, dma, interrupt, peripherals};
use embassy_time::{Delay, Timer};
use embedded_hal_bus::spi::ExclusiveDevice;
use panic_halt as _;
use picket_with_bgt60tr13c::{Memory, is_nearing, run};

bind_interrupts!(struct Irqs {
    DMA1_STREAM3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
    DMA1_STREAM4 => dma::InterruptHandler<peripherals::DMA1_CH4>;
    EXTI2 => exti::InterruptHandler<interrupt::typelevel::EXTI2>;
});

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(Default::default());
    let mut lamp = Output::new(p.PA5, Level::Low, Speed::Low);
    let Some(memory) = singleton!(: Memory = Memory::NEW) else { return };
    let mut config = spi::Config::default();
    config.frequency = Hertz(8_000_000);
    let mut bus = Spi::new(p.SPI2, p.PB13, p.PB15, p.PB14, p.DMA1_CH4, p.DMA1_CH3, Irqs, config);
    let mut select = Output::new(p.PB12, Level::High, Speed::VeryHigh);
    let mut reset = Output::new(p.PB1, Level::High, Speed::Low);
    let mut interrupt = ExtiInput::new(p.PB2, p.EXTI2, Pull::Down, Irqs);
    loop {
        let Ok(device) = ExclusiveDevice::new(&mut bus, &mut select, Delay);
        let ended: Result<Infallible, _> =
            run((device, &mut reset, &mut interrupt, Delay), memory, |targets| {
                lamp.set_level(targets.iter().any(is_nearing).into());
            })
            .await;
        // The radar does not answer, or its FIFO overflowed: begin anew.
        let Err(_) = ended;
        lamp.set_low();
        Timer::after_millis(100).await;
    }
}

//! A radar BGT60TR13C at the SPI of a Pico 2: its lamp shines while something comes nearer. Clock at GPIO 18, data to the radar at 19 and
//! from it at 16, its chip select at 17, reset at 20, interrupt at 21.
#![no_std]
#![no_main]

use core::convert::Infallible;
use cortex_m::singleton;
use embassy_executor::Spawner;
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1};
use embassy_rp::spi::{self, Spi};
use embassy_rp::{bind_interrupts, dma};
use embassy_time::{Delay, Timer};
use embedded_hal_bus::spi::ExclusiveDevice;
use panic_halt as _;
use picket_with_bgt60tr13c::{Memory, is_nearing, run};

bind_interrupts!(struct Irqs {
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>, dma::InterruptHandler<DMA_CH1>;
});

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let mut lamp = Output::new(p.PIN_25, Level::Low);
    let Some(memory) = singleton!(: Memory = Memory::NEW) else { return };
    let mut config = spi::Config::default();
    config.frequency = 20_000_000;
    let mut bus =
        Spi::new(p.SPI0, p.PIN_18, p.PIN_19, p.PIN_16, p.DMA_CH0, p.DMA_CH1, Irqs, config);
    let mut select = Output::new(p.PIN_17, Level::High);
    let mut reset = Output::new(p.PIN_20, Level::High);
    let mut interrupt = Input::new(p.PIN_21, Pull::Down);
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

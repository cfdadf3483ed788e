//! An STM32F446's converter at 16 kHz by embassy-stm32's ring buffer: the lamp of a NUCLEO board shines while there is a good tone
//! on PA0.
#![no_std]
#![no_main]

use cortex_m::singleton;
use embassy_executor::Spawner;
use embassy_stm32::adc::{Adc, AdcChannel, CONTINUOUS, Exten, SampleTime};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::{bind_interrupts, dma, peripherals};
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};

bind_interrupts!(struct Irqs {
    DMA2_STREAM0 => dma::InterruptHandler<peripherals::DMA2_CH0>;
});

/// The converter's clock is 8 MHz after the HAL's start; a conversion takes 480 + 12 of its cycles.
const RATE_HZ: f64 = 8e6 / 492.0;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(Default::default());
    let mut lamp = Output::new(p.PA5, Level::Low, Speed::Low);
    let Some(adc_data) = singleton!(: [u16; 1024] = [0; 1024]) else { return };
    let mut adc = Adc::new(p.ADC1).into_ring_buffered(
        p.DMA2_CH0,
        adc_data,
        Irqs,
        [(p.PA0.degrade_adc(), SampleTime::CYCLES480)].into_iter(),
        CONTINUOUS,
        Exten::DISABLED,
    );
    let mut words = [0u16; 512];
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    let mut framer = Framer::<Real, 1024>::new(Format::unsigned::<12>());
    loop {
        match adc.read(&mut words).await {
            Ok(_) => framer.push(&words, |stamp, samples| {
                let (_, tone) = pipeline.tone(stamp, samples);
                lamp.set_level((tone.verdict == Verdict::Good).into());
            }),
            // The converter overran the ring. Nobody knows how many samples are missing.
            Err(_) => framer.lost(1),
        }
    }
}

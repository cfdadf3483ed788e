//! An STM32G431's converter at 24.5 kHz by embassy-stm32's ring buffer: the lamp of a NUCLEO-G431KB shines while there is a good
//! tone on PA0.
#![no_std]
#![no_main]

use cortex_m::singleton;
use embassy_executor::Spawner;
use embassy_stm32::adc::{Adc, AdcChannel, CONTINUOUS, Exten, SampleTime};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::pac::{ADC1, adc::vals::Ovrmod};
use embassy_stm32::rcc::mux::Adcsel;
use embassy_stm32::{Config, bind_interrupts, dma, peripherals};
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};

bind_interrupts!(struct Irqs {
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
});

/// The converter takes the core's 16 MHz; a conversion takes 640.5 + 12.5 of its cycles.
const RATE_HZ: f64 = 16e6 / 653.0;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let mut clocks = Config::default();
    clocks.rcc.mux.adc12sel = Adcsel::SYS;
    let p = embassy_stm32::init(clocks);
    let mut lamp = Output::new(p.PB8, Level::Low, Speed::Low);
    let Some(adc_data) = singleton!(: [u16; 1024] = [0; 1024]) else { return };
    let mut adc = Adc::new(p.ADC1, Default::default()).into_ring_buffered(
        p.DMA1_CH1,
        adc_data,
        Irqs,
        [(p.PA0.degrade_adc(), SampleTime::CYCLES640_5)].into_iter(),
        CONTINUOUS,
        Exten::DISABLED,
    );
    // A conversion that nobody fetched is overwritten: else the converter would stand still from then on.
    ADC1.cfgr().modify(|w| w.set_ovrmod(Ovrmod::OVERWRITE));
    let mut words = [0u16; 512];
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    let mut framer = Framer::<Real, 1024>::new(Format::unsigned::<12>());
    loop {
        let whole = adc.read(&mut words).await.is_ok();
        let overwritten = ADC1.isr().read().ovr();
        ADC1.isr().write(|w| w.set_ovr(true));
        if !whole || overwritten {
            // The ring was not emptied in time, or a conversion was not fetched. Nobody knows how many are missing.
            framer.lost(1);
            continue;
        }
        framer.push(&words, |stamp, samples| {
            let (_, tone) = pipeline.tone(stamp, samples);
            lamp.set_level((tone.verdict == Verdict::Good).into());
        });
    }
}

//! An RP2040's converter at 20 kHz by embassy-rp, a chunk at a time: the lamp of a Pico shines while there is a good tone on GPIO 26.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_rp::adc::{Adc, Channel, Config, InterruptHandler};
use embassy_rp::gpio::{Level, Output, Pull};
use embassy_rp::peripherals::DMA_CH0;
use embassy_rp::{bind_interrupts, dma};
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};

bind_interrupts!(struct Irqs {
    ADC_IRQ_FIFO => InterruptHandler;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
});

const RATE_HZ: f64 = 48e6 / 2400.0;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let mut lamp = Output::new(p.PIN_25, Level::Low);
    let mut adc = Adc::new(p.ADC, Irqs, Config::default());
    let mut dma_ch = dma::Channel::new(p.DMA_CH0, Irqs);
    let mut pin = Channel::new_pin(p.PIN_26, Pull::None);
    let mut words = [0u16; 1024];
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    let mut framer = Framer::<Real, 1024>::new(Format::unsigned::<12>());
    let mut clock = 0;
    loop {
        if adc.read_many(&mut pin, &mut words, 2399, &mut dma_ch).await.is_ok() {
            framer.push_at(clock, &words, |stamp, samples| {
                let (_, tone) = pipeline.tone(stamp, samples);
                lamp.set_level((tone.verdict == Verdict::Good).into());
            });
        }
        // The converter stands still until the next chunk. A pause of a record's length is assumed, so no record reaches across it.
        clock += 2 * 1024;
    }
}

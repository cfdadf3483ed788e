//! An RP2040's converter at 20 kHz, two DMA channels in turn: the lamp of a Pico shines while there is a good tone on GPIO 26.
#![no_std]
#![no_main]

use cortex_m::singleton;
use embedded_hal::digital::OutputPin;
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};
use rp2040_hal::adc::{Adc, AdcPin};
use rp2040_hal::dma::{DMAExt, SingleChannel, double_buffer};
use rp2040_hal::gpio::Pins;
use rp2040_hal::pac::{Interrupt, NVIC, Peripherals, interrupt};
use rp2040_hal::{Sio, Watchdog, clocks, entry};

/// What the chip reads first: how to read the rest.
#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_GENERIC_03H;

const RATE_HZ: f64 = 48e6 / 2400.0;

#[interrupt]
fn DMA_IRQ_0() {
    // SAFETY: nobody else writes the register that takes the two channels' flags back.
    unsafe { Peripherals::steal().DMA.ints0().write(|w| w.bits(3)) };
}

#[entry]
fn main() -> ! {
    let Some(mut chip) = Peripherals::take() else { loop {} };
    let mut watchdog = Watchdog::new(chip.WATCHDOG);
    let crystal_hz = 12_000_000;
    let resets = &mut chip.RESETS;
    let (xosc, tree) = (chip.XOSC, chip.CLOCKS);
    let (system, usb) = (chip.PLL_SYS, chip.PLL_USB);
    let _clocks =
        clocks::init_clocks_and_plls(crystal_hz, xosc, tree, system, usb, resets, &mut watchdog);
    let sio = Sio::new(chip.SIO);
    let pins = Pins::new(chip.IO_BANK0, chip.PADS_BANK0, sio.gpio_bank0, resets);
    let mut lamp = pins.gpio25.into_push_pull_output();
    let Ok(mut pin) = AdcPin::new(pins.gpio26.into_floating_input()) else { loop {} };
    let mut adc = Adc::new(chip.ADC, resets);
    let mut fifo =
        adc.build_fifo().clock_divider(2399, 0).set_channel(&mut pin).enable_dma().start_paused();
    let mut dma = chip.DMA.split(resets);
    dma.ch0.enable_irq0();
    dma.ch1.enable_irq0();
    // SAFETY: the handler takes its flags back.
    unsafe { NVIC::unmask(Interrupt::DMA_IRQ_0) };
    let (Some(first), Some(second)) =
        (singleton!(: [u16; 512] = [0; 512]), singleton!(: [u16; 512] = [0; 512]))
    else {
        loop {}
    };
    let channels = (dma.ch0, dma.ch1);
    let transfer = double_buffer::Config::new(channels, fifo.dma_read_target(), first).start();
    let mut transfer = transfer.write_next(second);
    fifo.resume();
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    let mut framer = Framer::<Real, 1024>::new(Format::unsigned::<12>());
    loop {
        while !transfer.is_done() {
            cortex_m::asm::wfi();
        }
        let (words, next) = transfer.wait();
        if fifo.is_over() {
            // Nobody knows how many.
            framer.lost(1);
        }
        framer.push(&words[..], |stamp, samples| {
            let (_, tone) = pipeline.tone(stamp, samples);
            let _ = lamp.set_state((tone.verdict == Verdict::Good).into());
        });
        transfer = next.write_next(words);
    }
}

//! An STM32F446's converter at 16 kHz, its DMA in a circle over two halves: the lamp of a NUCLEO board shines while there is a good
//! tone on PA0.
#![no_std]
#![no_main]

use core::array::from_fn;
use core::sync::atomic::{AtomicU16, AtomicU32, Ordering::Relaxed};
use cortex_m_rt::entry;
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};
use stm32f4::stm32f446::{Interrupt, NVIC, Peripherals, interrupt};

/// The converter's clock is 8 MHz after reset; a conversion takes 480 + 12 of its cycles.
const RATE_HZ: f64 = 8e6 / 492.0;
const HALF: usize = 512;
static SAMPLES: [AtomicU16; 2 * HALF] = [const { AtomicU16::new(0) }; 2 * HALF];
/// Halves filled so far.
static HALVES: AtomicU32 = AtomicU32::new(0);

#[interrupt]
fn DMA2_STREAM0() {
    // SAFETY: nobody else writes the register that takes flags back.
    let dma = unsafe { Peripherals::steal() }.DMA2;
    dma.lifcr().write(|w| w.chtif0().set_bit().ctcif0().set_bit());
    HALVES.fetch_add(1, Relaxed);
}

/// Handles an overrun: the converter has stopped, since a word was not fetched in time. The main loop sees it by the converter's
/// flag, and starts anew.
#[interrupt]
fn ADC() {
    // SAFETY: the main loop writes the register only while the converter runs, which it does not.
    unsafe { Peripherals::steal() }.ADC1.cr1().write(|w| w.ovrie().clear_bit());
}

#[entry]
fn main() -> ! {
    let Some(chip) = Peripherals::take() else { loop {} };
    start(&chip);
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    let mut framer = Framer::<Real, 1024>::new(Format::unsigned::<12>());
    let mut done = 0;
    loop {
        let overrun = || chip.ADC1.sr().read().ovr().bit_is_set();
        // Asleep until the next half is there: an interrupt that waits ends the sleep.
        cortex_m::interrupt::free(|_| {
            if HALVES.load(Relaxed) == done && !overrun() {
                cortex_m::asm::wfi();
            }
        });
        if overrun() {
            cortex_m::interrupt::free(|_| {
                start(&chip);
                // The stream begins with the first half, and what it left is passed over: the count shows the gap.
                HALVES.store(HALVES.load(Relaxed).wrapping_add(2) & !1, Relaxed);
            });
            done = HALVES.load(Relaxed);
        }
        let halves = HALVES.load(Relaxed);
        if halves == done {
            continue;
        }
        done = halves;
        let newest = halves.wrapping_sub(1);
        let first = newest as usize % 2 * HALF;
        let words: [u16; HALF] = from_fn(|n| SAMPLES[first + n].load(Relaxed));
        // A half that nobody fetched in time is a gap, which the framer finds by the count.
        framer.push_at(u64::from(newest) * HALF as u64, &words, |stamp, samples| {
            let (_, tone) = pipeline.tone(stamp, samples);
            let good = tone.verdict == Verdict::Good;
            chip.GPIOA.odr().modify(|_, w| w.odr5().bit(good));
        });
    }
}

/// PA0 to ADC1, ADC1 to stream 0 of DMA2 (RM0390, 9.5 and 13.12), until an overrun; after one, again (13.8.1).
fn start(chip: &Peripherals) {
    chip.RCC.ahb1enr().write(|w| w.gpioaen().set_bit().dma2en().set_bit());
    chip.RCC.apb2enr().write(|w| w.adc1en().set_bit());
    chip.GPIOA.moder().modify(|_, w| w.moder0().analog().moder5().output());
    let stream = chip.DMA2.st(0);
    stream.cr().modify(|_, w| w.en().clear_bit());
    while stream.cr().read().en().bit_is_set() {}
    // SAFETY: the addresses are the converter's result and memory of so many samples that is only read elsewhere; the other words
    // take flags back.
    unsafe {
        stream.par().write(|w| w.bits(chip.ADC1.dr().as_ptr() as u32));
        stream.m0ar().write(|w| w.bits(SAMPLES.as_ptr() as u32));
        stream.ndtr().write(|w| w.bits(SAMPLES.len() as u32));
        // A stream that is switched off says that it is done.
        chip.DMA2.lifcr().write(|w| w.bits(0x3D));
        NVIC::unpend(Interrupt::DMA2_STREAM0);
        // MSIZE 14:13, PSIZE 12:11: half words; MINC 10, CIRC 8, TCIE 4, HTIE 3, EN 0.
        stream.cr().write(|w| w.bits(1 << 13 | 1 << 11 | 1 << 10 | 1 << 8 | 1 << 4 | 1 << 3 | 1));
        // Channel 0, 480 cycles.
        chip.ADC1.smpr2().write(|w| w.bits(7));
        chip.ADC1.sr().write(|w| w.bits(0));
        NVIC::unmask(Interrupt::DMA2_STREAM0);
        NVIC::unmask(Interrupt::ADC);
    }
    chip.ADC1.cr1().write(|w| w.ovrie().set_bit());
    chip.ADC1.cr2().write(|w| w.adon().set_bit().cont().set_bit().dma().set_bit().dds().set_bit());
    chip.ADC1.cr2().modify(|_, w| w.swstart().set_bit());
}

//! An ESP32-C3's converter at 10 kHz, a conversion at each tick of a timer, since the HAL has no DMA for it: the lamp on GPIO 8, lit
//! when low as on many small boards, shines while there is a good tone on GPIO 3.
#![no_std]
#![no_main]

use core::array::from_fn;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, AtomicU16, AtomicU32, AtomicUsize, Ordering::Relaxed};
use critical_section::Mutex;
use esp_hal::Blocking;
use esp_hal::analog::adc::{Adc, AdcConfig, AdcPin, Attenuation};
use esp_hal::clock::CpuClock;
use esp_hal::gpio::{Level, Output, OutputConfig};
use esp_hal::peripherals::{ADC1, GPIO3};
use esp_hal::time::Duration;
use esp_hal::timer::{PeriodicTimer, systimer::SystemTimer};
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};

esp_bootloader_esp_idf::esp_app_desc!();

const RATE_HZ: f64 = 10_000.0;
const HALF: usize = 512;
static SAMPLES: [AtomicU16; 2 * HALF] = [const { AtomicU16::new(0) }; 2 * HALF];
/// Where the next sample goes.
static NEXT: AtomicUsize = AtomicUsize::new(0);
/// Halves filled so far.
static HALVES: AtomicU32 = AtomicU32::new(0);
/// A conversion was not ready at the tick after its own.
static LATE: AtomicBool = AtomicBool::new(false);

/// What the interrupt works with.
struct Converter {
    timer: PeriodicTimer<'static, Blocking>,
    adc: Adc<'static, ADC1<'static>, Blocking>,
    pin: AdcPin<GPIO3<'static>, ADC1<'static>>,
}

static CONVERTER: Mutex<RefCell<Option<Converter>>> = Mutex::new(RefCell::new(None));

#[esp_hal::handler]
fn tick() {
    critical_section::with(|section| {
        let mut converter = CONVERTER.borrow_ref_mut(section);
        let Some(Converter { timer, adc, pin }) = converter.as_mut() else { return };
        timer.clear_interrupt();
        // The conversion that the last tick began; the second call begins the next one.
        let word = adc.read_oneshot(pin);
        let _ = adc.read_oneshot(pin);
        let next = NEXT.load(Relaxed);
        match word {
            Ok(word) => SAMPLES[next].store(word, Relaxed),
            Err(_) => LATE.store(true, Relaxed),
        }
        if next % HALF == HALF - 1 {
            HALVES.store(HALVES.load(Relaxed).wrapping_add(1), Relaxed);
        }
        NEXT.store((next + 1) % (2 * HALF), Relaxed);
    });
}

#[esp_hal::main]
fn main() -> ! {
    let chip = esp_hal::init(esp_hal::Config::default().with_cpu_clock(CpuClock::max()));
    let mut lamp = Output::new(chip.GPIO8, Level::High, OutputConfig::default());
    let mut config = AdcConfig::new();
    let mut pin = config.enable_pin(chip.GPIO3, Attenuation::_11dB);
    let mut adc = Adc::new(chip.ADC1, config);
    let mut timer = PeriodicTimer::new(SystemTimer::new(chip.SYSTIMER).alarm0);
    timer.set_interrupt_handler(tick);
    let _ = adc.read_oneshot(&mut pin);
    let period = Duration::from_micros((1e6 / RATE_HZ) as u64);
    let started = timer.start(period).is_ok();
    timer.listen();
    critical_section::with(|section| {
        CONVERTER.replace(section, started.then_some(Converter { timer, adc, pin }));
    });
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    let mut framer = Framer::<Real, 1024>::new(Format::unsigned::<12>());
    let mut done = 0;
    loop {
        let halves = HALVES.load(Relaxed);
        if halves == done {
            continue;
        }
        done = halves;
        let newest = halves.wrapping_sub(1);
        let first = newest as usize % 2 * HALF;
        let words: [u16; HALF] = from_fn(|n| SAMPLES[first + n].load(Relaxed));
        if LATE.load(Relaxed) {
            LATE.store(false, Relaxed);
            framer.lost(1);
            continue;
        }
        // A half that nobody fetched in time is a gap, which the framer finds by the count.
        framer.push_at(u64::from(newest) * HALF as u64, &words, |stamp, samples| {
            let (_, tone) = pipeline.tone(stamp, samples);
            lamp.set_level((tone.verdict != Verdict::Good).into());
        });
    }
}

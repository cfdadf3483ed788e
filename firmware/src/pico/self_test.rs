//! What this board tries of itself, with one wire from GP14 to GP26: the chirp's output, without its filter, at the converter's input.
//!
//! The output is high or low, so the converter reads its largest code or its smallest, and its noise shows at the sensor of the chip's
//! temperature alone.

use super::registers::{adc, wait};
use super::waveform::Count;
use super::words::{CORE_CYCLES, CORE_MHZ, WATCHDOG_LOAD, Words};
use super::{N, Pairs, Pico, SLOT, chirp, line, start};
use crate::self_test::items::{Scatter, tone_at};
use crate::self_test::line::Line;
use crate::self_test::stream::MOMENT;
use crate::self_test::{self, Outcome, Tone, Trial};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::Verdict;
use picket_wire::settings::{Drive, Settings};

type Bench<'a> = self_test::Bench<'a, Pico, N, SLOT>;
type Item = self_test::Item<Pico, N, SLOT>;

const fn item(run: fn(&mut Bench) -> Outcome) -> Item {
    Item { mhz: CORE_MHZ, run }
}

/// Samples in a period of the square wave.
const SQUARE: u32 = 16;

impl Trial<N, SLOT> for Pico {
    type Real = Pipeline<Real, N>;
    type Iq = Pairs;

    const ITEMS: &'static [Item] = &[
        item(clocks),
        item(levels),
        item(temperature),
        item(|bench| bench.rate(500e3)),
        item(|bench| bench.rate(10e3)),
        item(|bench| bench.rate(48e3)),
        item(|bench| bench.rate(100e3)),
        item(|bench| bench.rate(250e3)),
        item(ramps),
        item(|bench| bench.save()),
        item(|bench| bench.reload()),
        item(|bench| bench.starve()),
    ];

    // Each sample is at a rail.
    const TONE: Tone = Tone {
        name: "GP14's square wave",
        frequency: 1.0 / SQUARE as f64,
        verdict: Verdict::Clipped,
    };

    fn play(words: &Words) {
        let cycles = SQUARE * CORE_CYCLES * words.period;
        // The periods of the list's rates have this divider.
        let divider = cycles.div_ceil(1 << 16);
        let counts = cycles.checked_div(divider).unwrap_or(0);
        let count = Count { divider: divider << 4, top: counts.saturating_sub(1) };
        chirp::pulses(count, counts / 2);
    }

    fn heard() -> bool {
        line::usb_open()
    }
}

/// A tick of the timer in the time of [`clocks`], with the cycles between two readings, MHz.
const FINE: f64 = 0.02;

/// Counts the core's cycles in 50 ms of the timer, which counts the crystal's microseconds, as the watchdog does.
fn clocks(bench: &mut Bench) -> Outcome {
    bench.state.bites_ms = WATCHDOG_LOAD / 2_000;
    // SAFETY: nothing else uses this timer of the core.
    let mut systick = unsafe { cortex_m::Peripherals::steal() }.SYST;
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(MOST);
    systick.clear_current();
    systick.enable_counter();
    let look = || cortex_m::interrupt::free(|_| (start::ticks(), SYST::get_current()));
    let (begun, first) = look();
    let _ = start::within(50, || false);
    let (ended, last) = look();
    let cycles = first.wrapping_sub(last) & MOST;
    let mhz = f64::from(cycles) / f64::from(ended.wrapping_sub(begun));
    let line =
        Line::new("clock of the core: ").decimal(mhz, 3).text(" MHz by the crystal's timer, ");
    let line = line.number(CORE_MHZ.into()).text(" +- ").decimal(FINE, 2);
    (libm::fabs(mhz - f64::from(CORE_MHZ)) < FINE, line)
}

/// The largest count of the core's timer.
const MOST: u32 = 0x00FF_FFFF;

/// Takes one conversion of an input after another; an input that does not convert gives none.
fn conversions(input: u8, sensor: bool) -> Scatter {
    let mut scatter = Scatter::default();
    for _ in 0..N {
        adc().cs().write(|w| {
            // SAFETY: the converter has an input of this number.
            unsafe { w.ainsel().bits(input) };
            w.en().set_bit().ts_en().bit(sensor).start_once().set_bit()
        });
        if wait(|| adc().cs().read().ready().bit_is_set()) {
            scatter.add(&[adc().result().read().bits() as i16]);
        }
    }
    adc().cs().write(|w| w.en().set_bit());
    scatter
}

/// The most codes from an output's level to the end of the range. The data sheet names no offset of the converter; the filter before its
/// reference, of 200 ohms, keeps the reference some 30 mV, 37 codes, below the supply (Pico data sheet, 4.3).
const OFF: f64 = 40.0;
/// The largest code.
const FULL: f64 = 4095.0;

/// Reads the output's two levels.
fn levels(_: &mut Bench) -> Outcome {
    const COUNTS: u32 = 100;
    let [low, high] = [0, COUNTS].map(|level| {
        chirp::pulses(Count { divider: 1 << 4, top: COUNTS - 1 }, level);
        conversions(0, false).mean()
    });
    let line =
        Line::new("levels of GP14 at GP26, codes: low ").decimal(low, 1).text(" of at most ");
    let line = line.decimal(OFF, 0).text(", high ").decimal(high, 1).text(" of at least ");
    (low <= OFF && high >= FULL - OFF, line.decimal(FULL - OFF, 0))
}

/// The sensor's volts at 27 degrees, the change by a degree (DS 4.9.5), and the volts of the largest code.
const SENSOR: [f64; 3] = [0.706, -0.001_721, 3.3];
/// The chip's own range, degrees (DS 5.5): the sensor's spread and the reference's error are some tens of degrees.
const DEGREES: [f64; 2] = [-20.0, 85.0];
/// The largest scatter of the sensor's codes. The converter has 8.7 effective bits (DS 4.9.3), a noise of 4096 / 2^8.7 / 12^0.5 = 2.84
/// codes; the sensor and the supply, which is the reference, may have an equal noise each.
const SCATTER: f64 = 5.0;

/// Reads the chip's temperature, an input at rest.
fn temperature(_: &mut Bench) -> Outcome {
    let codes = conversions(4, true);
    let [at_27, a_degree, reference] = SENSOR;
    let degrees = 27.0 + (codes.mean() * reference / FULL - at_27) / a_degree;
    let [coldest, warmest] = DEGREES;
    let line = Line::new("temperature of the chip: ").decimal(degrees, 1).text(" C of ");
    let line = line.decimal(coldest, 0).text(" to ").decimal(warmest, 0);
    let line = line.text("; noise of its sensor, codes: ").decimal(codes.deviation(), 2);
    let line = line.text(" of at most ").decimal(SCATTER, 0);
    let near = (coldest..=warmest).contains(&degrees);
    (near && codes.deviation() <= SCATTER, line)
}

/// The most samples of a block on the wrong side of a chirp's step.
const ASTRAY: u32 = 8;

/// Plays a chirp, whose pulses are samples wide: a sample is high from the height on at which its pulse reaches it. So each rise has a step
/// at the same sample, each fall one at the mirrored sample, and the flat part has none.
fn ramps(bench: &mut Bench) -> Outcome {
    let shape = Shape::Trapezoid;
    let (wavelength_m, bandwidth_hz) = (0.0125, 200e6);
    let scene = Scene::Chirp(Chirp { shape, wavelength_m, bandwidth_hz, ..Chirp::default() });
    let settings = tone_at(100e3, CORE_MHZ);
    let drive = Drive::Dac { low: 0, high: 4095 };
    let settings = Settings { config: Config { scene, ..settings.config }, drive, ..settings };
    let mut step = None;
    let found = bench.stream(&settings, MOMENT, &mut |stamp, samples, _| {
        let high = |sample: &i16| *sample > 2048;
        let count = samples.iter().filter(|sample| high(sample)).count();
        let step = *step.get_or_insert(count);
        let astray = |(place, sample): &(usize, &i16)| {
            high(sample)
                != match stamp.sequence % 3 {
                    0 => place + step >= N,
                    1 => true,
                    _ => *place < step,
                }
        };
        samples.iter().enumerate().filter(astray).count() as u32
    });
    let line = Line::new("chirp of GP14 at GP26, in step: ");
    let Some(found) = found else { return (false, line.text("it does not start")) };
    let step = step.unwrap_or(0);
    let line = found.counted(line).text(", a step of ").number(step as u32).text(" samples, ");
    let line = line.number(found.worst).text(" astray of at most ").number(ASTRAY);
    (found.whole() && (1..N).contains(&step) && found.worst <= ASTRAY, line)
}

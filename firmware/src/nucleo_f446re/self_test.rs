//! The items of the list: each is tried by itself after a reset, and reports its result in a line.

use super::line::Line;
use super::state::State;
use super::stream::{Found, MOMENT, stream};
use super::tone;
use crate::board::Board;
use crate::instrument::storage::{self, Payload};
use crate::nucleo_f446re::start::Quiet;
use crate::nucleo_f446re::words::clock::HSE_HZ;
use crate::nucleo_f446re::words::guard::{LSI_HZ, WATCHDOG};
use crate::nucleo_f446re::words::sampling::BLOCK_CYCLES;
use crate::nucleo_f446re::{Measuring, N, Nucleo, chirp, gauge, registers, start, storage::Flash};
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_instrument::words::payload;
use picket_wire::boot::{Causes, Clock};
use picket_wire::settings::{Drive, Settings};
use static_cell::ConstStaticCell;

/// The tools of an item.
pub struct Bench<'a> {
    pub board: Nucleo,
    pub state: &'a mut State,
    /// What measures the blocks: the instrument's own.
    pub meters: &'static mut Measuring,
    /// The causes of the chip's reset before this item.
    pub causes: Causes,
}

/// Whether the item holds, and the figures.
pub type Outcome = (bool, Line);

/// One item.
pub struct Item {
    /// The core's clock, MHz.
    pub mhz: u16,
    /// Tries it.
    pub run: fn(&mut Bench) -> Outcome,
}

const fn item(mhz: u16, run: fn(&mut Bench) -> Outcome) -> Item {
    Item { mhz, run }
}

/// The list.
pub const ITEMS: [Item; 15] = [
    item(180, clocks),
    item(144, clocks),
    item(180, level),
    item(180, cycles),
    item(180, noise),
    item(144, noise),
    item(180, |bench| rate(bench, 500e3)),
    item(180, |bench| rate(bench, 10e3)),
    item(180, |bench| rate(bench, 100e3)),
    item(180, |bench| rate(bench, 1.5e6)),
    item(144, |bench| rate(bench, 1.2e6)),
    item(180, ramps),
    item(180, save),
    item(180, reload),
    item(180, starve),
];

fn clocks(bench: &mut Bench) -> Outcome {
    let (core_hz, ticks_hz) = (bench.board.core_hz(), bench.board.ticks_hz());
    let line = Line::new("clock of ").number(core_hz / 1_000_000).text(" MHz from ");
    let line = line.text(match bench.board.clock() {
        Clock::External => "the crystal",
        Clock::Internal => "the internal oscillator",
        Clock::Slow => "the internal oscillator, slow",
    });
    let (probe, watchdog) = (gauge::probe_hz(core_hz), gauge::watchdog_hz(ticks_hz));
    let line = match probe {
        Some(hz) => line.text(": the probe's 8 MHz are ").decimal(hz / 1e6, 6).text(" by it"),
        None => line.text(": the probe's clock does not come"),
    };
    let line = match watchdog {
        Some(hz) => line.text(", the watchdog's 32 kHz ").decimal(hz / 1e3, 2),
        None => line.text(", the watchdog's oscillator does not come"),
    };
    let [_, slowest, fastest] = LSI_HZ.map(f64::from);
    let exact = probe.is_some_and(|hz| libm::fabs(hz / f64::from(HSE_HZ) - 1.0) < 20e-6);
    let near = watchdog.is_some_and(|hz| (slowest..=fastest).contains(&hz));
    bench.state.watchdog_hz = watchdog.unwrap_or(0.0) as u32;
    (bench.board.clock() == Clock::External && exact && near, line)
}

fn level(_: &mut Bench) -> Outcome {
    let options = registers::flash().optcr().read();
    let line = Line::new("option word ").hex(options.bits()).text(": a reset below 2.7 V is ");
    // The code of level 3 (RM 3.8.5).
    let is_set = options.bor_lev().bits() == 0;
    let told = if is_set { "set" } else { "not set, picket flash --brown-out sets it" };
    // Either result is right.
    (true, line.text(told))
}

/// Counts the cycles of a block, with and without the flash being read ahead.
fn cycles(bench: &mut Bench) -> Outcome {
    let line = Line::new("cycles of a block: ");
    tone::play();
    let mut least = [u32::MAX; 2];
    let mut blocks = 0_u32;
    let found = stream(bench, &tone_at(100e3, 180), 2 * TURN, &mut |_, _, cycles| {
        let ahead = blocks / TURN % 2 == 1;
        match blocks % TURN {
            0 => start::quiet(if ahead { Quiet::Ahead } else { Quiet::USED }),
            MIXED.. => {
                let [usual, read_ahead] = &mut least;
                let least = if ahead { read_ahead } else { usual };
                *least = cycles.min(*least);
            }
            _ => {}
        }
        blocks = blocks.wrapping_add(1);
        0
    });
    start::quiet(Quiet::USED);
    let Some(found) = found else { return (false, line.text("it does not start")) };
    let ([usual, ahead], [most, _]) = (least, BLOCK_CYCLES);
    let line = line.number(usual).text(", with prefetch ").number(ahead);
    let line = line.text("; reserved are ").number(most as u32);
    (found.good > 0 && u64::from(usual) < most, line)
}

fn tone_at(rate_hz: f64, mhz: u16) -> Settings {
    let settings = Settings::default();
    let config = Config { rate_hz, ..settings.config };
    Settings { core_mhz: mhz, config, ..settings }
}

/// The largest root mean square of the deviations from the DAC's tone, in sigmas.
const WRONG: f64 = 3.0;

fn rate(bench: &mut Bench, rate_hz: f64) -> Outcome {
    tone::play();
    let mhz = (bench.board.core_hz() / 1_000_000) as u16;
    let line = Line::new("").decimal(rate_hz / 1e3, 0).text(" kS/s: ");
    let Some(found) = stream(bench, &tone_at(rate_hz, mhz), MOMENT, &mut |_, _, _| 0) else {
        return (false, line.text("it does not start"));
    };
    let Found { lost, faults, good, blocks, punctual, peak, load, hertz, sigma, error, .. } = found;
    let line = counted(line, &found);
    let line = line.text(", the longest ").number(peak).text(" permille of its time, awake ");
    let line = line.number(load).text("; the DAC's tone ").decimal(hertz, 3).text(" Hz +- ");
    let line =
        line.decimal(sigma, 3).text(", wrong by ").decimal(error, 2).text(" sigma of at most ");
    let line = line.decimal(WRONG, 0).text(", good in ");
    let line = line.number(good);
    let whole = blocks > 0 && lost == 0 && faults == 0 && punctual && peak <= 1_000;
    // A sigma of a tenth of a bin is not a measurement.
    let fine = sigma > 0.0 && sigma < 0.1 * rate_hz / N as f64;
    // Nearly all blocks are good, and the deviations agree with their sigmas, which do not cover the unevenness of the DAC's steps.
    (whole && fine && error < WRONG && good >= blocks - blocks / 20, line)
}

/// Blocks with a measure against noise, before the next measure takes its turn; and the first blocks of a turn, which began before it or
/// were under way.
const TURN: u32 = 8;
const MIXED: u32 = 2;
/// The largest scatter of the codes of an input at rest. The converter's own noise is at least 64 dB below the largest sine (DS table 77),
/// 4096 / 8^0.5 / 10^(64 / 20) = 0.914 codes; the DAC may have an equal noise, and this board's reference is its digital supply.
const SCATTER: f64 = 4.0;

/// Measures the codes of an input at rest, while the core measures blocks of them, with each measure against the chip's noise.
fn noise(bench: &mut Bench) -> Outcome {
    const MEASURES: [(&str, Quiet); 4] = [
        (" with prefetch ", Quiet::Ahead),
        (", without ", Quiet::Still),
        (", with ADCDC1 ", Quiet::First),
        (", with ADCxDC2 ", Quiet::Second),
    ];
    static TABLE: ConstStaticCell<[u16; 2]> = ConstStaticCell::new([0; 2]);
    let mhz = (bench.board.core_hz() / 1_000_000) as u16;
    let line = Line::new("noise at A0 at ").number(mhz.into()).text(" MHz, codes:");
    let Some(table) = TABLE.try_take() else { return (false, line) };
    *table = [tone::MIDDLE; 2];
    chirp::play(tone::MIDDLE, table, u16::MAX);
    // The last measure is for converters of 36 MHz.
    let count = if mhz == 144 { MEASURES.len() } else { MEASURES.len() - 1 };
    let mut scatters = [Scatter::default(); MEASURES.len()];
    let mut blocks = 0;
    let moment = TURN * MEASURES.len() as u32;
    let found = stream(bench, &tone_at(500e3, mhz), moment, &mut |_, samples, _| {
        let turn = ((blocks / TURN) as usize).checked_rem(count).unwrap_or(0);
        let place = blocks % TURN;
        if let (0, Some((_, quiet))) = (place, MEASURES.get(turn)) {
            start::quiet(*quiet);
        }
        if let (MIXED.., Some(scatter)) = (place, scatters.get_mut(turn)) {
            scatter.add(samples);
        }
        blocks = blocks.wrapping_add(1);
        0
    });
    let Some(found) = found else { return (false, line.text(" it does not start")) };
    let (mut line, mut used) = (line, f64::INFINITY);
    for ((name, quiet), scatter) in MEASURES.iter().zip(&scatters).take(count) {
        let deviation = scatter.deviation();
        line = line.text(name).decimal(deviation, 3);
        if *quiet == Quiet::USED {
            used = deviation;
        }
    }
    let line = line.text("; at most ").decimal(SCATTER, 0);
    (used < SCATTER && found.lost == 0 && found.faults == 0 && found.punctual, line)
}

/// The scatter of samples around their mean.
#[derive(Clone, Copy, Default)]
struct Scatter {
    count: u32,
    sum: i64,
    squares: i64,
}

impl Scatter {
    fn add(&mut self, samples: &[i16; N]) {
        self.count += N as u32;
        for &sample in samples {
            let sample = i64::from(sample) - i64::from(tone::MIDDLE);
            self.sum += sample;
            self.squares += sample * sample;
        }
    }

    /// The standard deviation; NaN without samples.
    fn deviation(&self) -> f64 {
        let count = f64::from(self.count);
        let mean = self.sum as f64 / count;
        libm::sqrt(self.squares as f64 / count - mean * mean)
    }
}

fn counted(line: Line, found: &Found) -> Line {
    let line = line.number(found.blocks).text(" blocks, ").number(found.lost).text(" lost, ");
    let line = line.number(found.faults).text(" faults");
    if found.punctual { line } else { line.text(", not in time") }
}

fn ramps(bench: &mut Bench) -> Outcome {
    const GUARD: u16 = 32;
    let scene = Scene::Chirp(Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 0.0,
        ..Chirp::default()
    });
    let settings = tone_at(500e3, 180);
    let settings = Settings {
        config: Config { scene, ..settings.config },
        guard: GUARD,
        drive: Drive::Dac { low: 400, high: 3600 },
        ..settings
    };
    let wave = bench.board.plan(&settings).ok().and_then(|(_, words)| words.waveform);
    let Some(wave) = wave else { return (false, Line::new("chirp: it cannot be played")) };
    let found = stream(bench, &settings, MOMENT, &mut |stamp, samples, _| {
        // The DAC's code at the middle of the block; the ADC's average shows it.
        let steps = usize::from(wave.steps);
        let first = stamp.sequence as usize % 3 * steps;
        let hold = usize::from(wave.hold).max(1);
        let deviation = samples.iter().enumerate().fold(0, |sum, (n, sample)| {
            let step = (n + usize::from(GUARD)).checked_div(hold).unwrap_or(0);
            sum + i32::from(*sample) - i32::from(wave.code(first + step))
        });
        (deviation / N as i32).unsigned_abs()
    });
    let line = Line::new("chirp of A2 at A0, in step: ");
    let Some(found) = found else { return (false, line.text("it does not start")) };
    let line = counted(line, &found).text(", codes off by ").number(found.worst).text(" at most");
    let whole = found.blocks > 0 && found.lost == 0 && found.faults == 0 && found.punctual;
    (whole && found.worst <= 40, line)
}

/// Milliseconds since these ticks.
fn since(bench: &Bench, begun: u32) -> u32 {
    let ticks = bench.board.ticks().wrapping_sub(begun);
    ticks.checked_div(bench.board.ticks_hz() / 1_000).unwrap_or(0)
}

/// Settings that no other program saves.
fn marked() -> Payload {
    payload(&Settings { start: false, ..tone_at(12_345.0, 180) }, N)
}

fn save(bench: &mut Bench) -> Outcome {
    let begun = bench.board.ticks();
    bench.board.feed();
    let saved = storage::save(&mut Flash, &marked()).is_ok();
    let milliseconds = since(bench, begun);
    bench.board.feed();
    (saved, Line::new("settings saved in ").number(milliseconds).text(" ms"))
}

fn reload(bench: &mut Bench) -> Outcome {
    let loaded = storage::load(&Flash).map(|(_, _, loaded)| loaded);
    // The former settings lie in the other page.
    let former = storage::before(&Flash);
    let found = loaded.is_some_and(|loaded| loaded == marked());
    let former = former.unwrap_or_else(|| payload(&Settings::default(), N));
    bench.board.feed();
    let back = found && storage::save(&mut Flash, &former).is_ok();
    bench.board.feed();
    let line = Line::new("settings loaded after a reset, the former ones back");
    (back, line)
}

/// The longest time of a watchdog with the slowest oscillator, with a margin, ms.
const TOO_LONG: u32 = 10_000;

/// The last item ends by a reset; [`bitten`] judges its outcome.
fn starve(bench: &mut Bench) -> Outcome {
    let begun = bench.board.ticks();
    bench.board.feed();
    loop {
        // A timer wakes the core ten times a second.
        bench.board.sleep(None);
        let starved = since(bench, begun);
        if starved > TOO_LONG {
            return (false, Line::new("watchdog: it does not bite"));
        }
        bench.state.starved_ms = starved;
        bench.state.save();
    }
}

/// Judges the watchdog's reset.
pub fn bitten(bench: &mut Bench) -> Outcome {
    let State { watchdog_hz, starved_ms, .. } = *bench.state;
    let expected = WATCHDOG.milliseconds(watchdog_hz.max(1));
    let line = Line::new("watchdog: it bites after ").number(starved_ms).text(" to ");
    let line = line.number(starved_ms + 100).text(" ms, ").number(expected);
    let near = (starved_ms + 50).abs_diff(expected) <= expected / 20 + 50;
    (near, line.text(" by its oscillator"))
}

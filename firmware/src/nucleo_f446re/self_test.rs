//! What this board tries of itself, with one wire from A2 to A0.

use super::start::{self, Quiet};
use super::words::clock::HSE_HZ;
use super::words::guard::{LSI_HZ, WATCHDOG};
use super::words::sampling::BLOCK_CYCLES;
use super::{CELLS, N, Nucleo, SLOT, chirp, gauge, registers, tone};
use crate::board::{Board, Clocks, Port};
use crate::instrument::meter::Every;
use crate::self_test::items::{Scatter, tone_at};
use crate::self_test::line::Line;
use crate::self_test::stream::MOMENT;
use crate::self_test::{self, Outcome, Trial};
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::Verdict;
use picket_wire::boot::Clock;
use picket_wire::settings::{Drive, Settings};
use static_cell::ConstStaticCell;

type Bench<'a> = self_test::Bench<'a, Nucleo, N, SLOT>;
type Item = self_test::Item<Nucleo, N, SLOT>;

const fn item(mhz: u16, run: fn(&mut Bench) -> Outcome) -> Item {
    Item { mhz, run }
}

impl Trial<N, SLOT> for Nucleo {
    type Real = Every<Real, N, CELLS>;
    type Iq = Every<Iq, N, CELLS>;

    const ITEMS: &'static [Item] = &[
        item(180, clocks),
        item(144, clocks),
        item(180, level),
        item(180, cycles),
        item(180, noise),
        item(144, noise),
        item(180, |bench| bench.rate(500e3)),
        item(180, |bench| bench.rate(10e3)),
        item(180, |bench| bench.rate(100e3)),
        item(180, |bench| bench.rate(1.5e6)),
        item(144, |bench| bench.rate(1.2e6)),
        item(180, ramps),
        item(180, |bench| bench.save()),
        item(180, |bench| bench.reload()),
        item(180, |bench| bench.starve()),
    ];

    const TONE: self_test::Tone = self_test::Tone {
        name: "the DAC's tone",
        frequency: tone::FREQUENCY,
        verdict: Verdict::Good,
    };

    fn play(_: &Self::Words) {
        tone::play();
    }
}

fn clocks(bench: &mut Bench) -> Outcome {
    let Clocks { source, core_hz, ticks_hz } = bench.board.clocks();
    let line = Line::new("clock of ").number(core_hz / 1_000_000).text(" MHz from ");
    let line = line.text(match source {
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
    bench.state.bites_ms = WATCHDOG.milliseconds((watchdog.unwrap_or(0.0) as u32).max(1));
    (source == Clock::External && exact && near, line)
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
    let found = bench.stream(&tone_at(100e3, 180), 2 * TURN, &mut |_, _, ticks| {
        let ahead = blocks / TURN % 2 == 1;
        match blocks % TURN {
            0 => start::quiet(if ahead { Quiet::Ahead } else { Quiet::USED }),
            MIXED.. => {
                let [usual, read_ahead] = &mut least;
                let least = if ahead { read_ahead } else { usual };
                *least = ticks.min(*least);
            }
            _ => {}
        }
        blocks = blocks.wrapping_add(1);
        0
    });
    start::quiet(Quiet::USED);
    let Some(found) = found else { return (false, line.text("it does not start")) };
    let Clocks { core_hz, ticks_hz, .. } = bench.board.clocks();
    let cycles = (core_hz / 1_000).checked_div(ticks_hz / 1_000);
    let [usual, ahead] = least.map(|ticks| ticks.saturating_mul(cycles.unwrap_or(0)));
    let [most, _] = BLOCK_CYCLES;
    let line = line.number(usual).text(", with prefetch ").number(ahead);
    let line = line.text("; reserved are ").number(most as u32);
    (found.good > 0 && u64::from(usual) < most, line)
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
    let mhz = bench.mhz();
    let line = Line::new("noise at A0 at ").number(mhz.into()).text(" MHz, codes:");
    let Some(table) = TABLE.try_take() else { return (false, line) };
    *table = [tone::MIDDLE; 2];
    chirp::play(tone::MIDDLE, table, u16::MAX);
    // The last measure is for converters of 36 MHz.
    let count = if mhz == 144 { MEASURES.len() } else { MEASURES.len() - 1 };
    let mut scatters = [Scatter::default(); MEASURES.len()];
    let mut blocks = 0;
    let moment = TURN * MEASURES.len() as u32;
    let found = bench.stream(&tone_at(500e3, mhz), moment, &mut |_, samples, _| {
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
    (used < SCATTER && found.whole(), line)
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
    let found = bench.stream(&settings, MOMENT, &mut |stamp, samples, _| {
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
    let line = found.counted(line).text(", codes off by ").number(found.worst).text(" at most");
    (found.whole() && found.worst <= 40, line)
}

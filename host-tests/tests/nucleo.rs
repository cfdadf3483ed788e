//! The NUCLEO's image on QEMU's STM32F405, the host playing converters and DMA: every block measured to the bit, every fault
//! counted, no block mixed with another.
//!
//! 600 blocks; `PICKET_BLOCKS=20000` for the long run.

use fixed::types::I32F32;
use host_tests::figures::hold;
use host_tests::prepare_packages;
use picket_claims::samples;
use picket_dsp::Effort;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::Counters;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::pipeline::{Outcome, Pipeline};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::Verdict;
use picket_dsp::tracker::Tracker;
use picket_firmware::instrument::plan::Plan;
use picket_firmware::nucleo_f446re::PLAYED;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_firmware::nucleo_f446re::words::sampling::{BLOCK_CYCLES, WORST_CYCLES};
use picket_host::analyze::{self, Analysis};
use picket_host::arithmetic::Arithmetic;
use picket_host::board::{Board, image};
use picket_host::device::{Blocks, Said};
use picket_host::emulator::Footprint;
use picket_host::{flash, recording, scenario};
use picket_lab::bench::worst;
use picket_simulator::scene;
use picket_wire::boot::{Boot, Clock, Origin};
use picket_wire::command::{Command, Refusal, Request};
use picket_wire::follow::Follow;
use picket_wire::lines::Lines;
use picket_wire::settings::{Drive, Settings};
use picket_wire::status::Status;
use picket_wire::telemetry::{Health, Telemetry};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

mod fence;
mod frames;
mod several;
mod signals;

const N: usize = 1024;
const SEED: u64 = 446;

fn played() -> &'static PathBuf {
    static IMAGE: OnceLock<PathBuf> = OnceLock::new();
    IMAGE.get_or_init(|| {
        prepare_packages();
        image(true, false).unwrap_or_else(|error| panic!("{error}"))
    })
}

/// Checks what the image takes with the stack that it took so far, and holds that stack as a figure.
fn fits(board: &mut Board, doing: &str) {
    let (footprint, stack) = (Footprint::from_elf(played()).unwrap(), status(board).stack);
    println!("{doing}: RAM {} B and {stack} B of stack", footprint.ram);
    // Its registers are played in the last 4 KB of the chip's memory.
    assert!(footprint.ram + u64::from(stack) <= 124 << 10, "{footprint:?} and {stack}");
    hold(&format!("board, bytes of stack, {doing}"), 1.0, &[stack.into()]);
}

fn tree() -> Tree {
    Tree::new(Speed::Mhz180, Source::Hsi)
}

/// What these settings become on the board.
fn planned(settings: &Settings) -> (Plan<N>, Words) {
    Words::plan(settings, &tree()).unwrap()
}

/// A tone of the converter's codes: `bin` may have a fraction.
fn tone(bin: f64, amplitude: f64, noise: f64, rng: &mut impl Rng) -> [i16; N] {
    let phase: f64 = rng.random();
    std::array::from_fn(|n| {
        let angle = std::f64::consts::TAU * (bin * n as f64 / N as f64 + phase);
        let value = 2048.0 + amplitude * angle.sin() + noise * rng.random_range(-1.0..1.0);
        value.round().clamp(0.0, 4095.0) as i16
    })
}

fn bytes(samples: &[i16]) -> Vec<u8> {
    samples.iter().flat_map(|sample| sample.to_le_bytes()).collect()
}

/// The board's measurement, made on this machine.
struct Here<R: Record> {
    plan: Plan<N>,
    words: Words,
    pipeline: Pipeline<R, N>,
}

impl<R: Record> Here<R> {
    fn new(settings: &Settings) -> Self {
        let (plan, words) = planned(settings);
        let terms = picket_dsp::plan::Plan::from_terms(*plan.plan);
        Self { plan, words, pipeline: Pipeline::new(terms.unwrap()) }
    }

    fn record(&mut self, stamp: Stamp, samples: &[R::Sample; N], health: Health) -> Telemetry {
        let measurement = self.pipeline.block(&stamp, samples);
        let basis = Some(self.plan.basis(tree().source.clock()));
        let (method, uncertainty) = (self.plan.plan.options.method, self.plan.total(&measurement));
        Telemetry { measurement, method, health, basis, uncertainty }
    }

    fn stamp(&self, number: u64, gap: bool) -> Stamp {
        self.plan.timing.stamp(number, gap)
    }
}

fn next_record(board: &mut Board) -> Telemetry {
    let record = board.expect(|said| match said {
        Said::Telemetry(record) => Some(record),
        _ => None,
    });
    record.unwrap_or_else(|error| panic!("{error}"))
}

fn status(board: &mut Board) -> Status {
    board.request(Command::Status).unwrap().unwrap();
    let status = board.expect(|said| match said {
        Said::Status(status) => Some(status),
        _ => None,
    });
    status.unwrap()
}

fn boot(board: &mut Board) -> Boot {
    let boot = board.expect(|said| match said {
        Said::Boot(boot) => Some(boot),
        _ => None,
    });
    boot.unwrap_or_else(|error| panic!("{error}"))
}

fn start() -> (Board, Boot) {
    let mut board = Board::start(played()).unwrap();
    let boot = boot(&mut board);
    (board, boot)
}

/// The settings of an image that was never set, with every round: by its rate alone the board would take none.
fn with_rounds() -> Settings {
    Settings { effort: Some(Effort::THREE), ..Settings::default() }
}

#[test]
fn thousands_of_blocks_and_every_record_right() {
    println!("seed {SEED}");
    let count = std::env::var("PICKET_BLOCKS").ok().and_then(|n| n.parse().ok()).unwrap_or(600);
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut board, first) = start();
    // QEMU has no multiplier: the board falls back, says so, and measures all the same.
    assert_eq!((first.clock, first.core_hz), (Clock::Slow, 16_000_000));
    assert!(first.measuring && first.origin == Origin::Default && !first.unfit);
    assert_eq!(first.last.kind, 0);
    // It runs the program that was built.
    assert_eq!(first.program, flash::checksum(played()).unwrap());
    let settings = with_rounds();
    board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    let mut here = Here::<Real>::new(&settings);
    // What the settings ask for stands in the registers (RM0390, 9.5 and 13.13): the stream's control, length and source, then
    // ADC_CR1, CR2, SMPR2 and SQR3.
    let times = 0o11 * u32::from(here.words.sampling.time);
    let stream = [0x0007_2D17, N as u32, PLAYED as u32 + 0x44C];
    let converter = [0x0400_0000, 0x1800_0301, times, 0];
    assert_eq!(board.registers().unwrap()[..7], [&stream[..], &converter[..]].concat());
    let started = std::time::Instant::now();
    let mut good = 0;
    for number in 0..count {
        let bin = rng.random_range(5.0..500.0);
        let samples = tone(bin, 900.0, 30.0, &mut rng);
        assert!(board.block(&bytes(&samples)).unwrap(), "the stream stands still");
        let stamp = here.stamp(number, false);
        let expected = here.record(stamp, &samples, Health::default());
        assert_eq!(next_record(&mut board).to_bytes(), expected.to_bytes(), "block {number}");
        let found = expected.measurement.tone;
        let error = (found.frequency.0.to_num::<f64>() - bin / N as f64) / f64::from(found.sigma);
        // Six deviations: one in 500 million.
        assert!(error.abs() < 6.0, "block {number}: {error} sigma, {found:?}");
        good += u64::from(found.verdict == Verdict::Good);
    }
    // A verdict may err once in some thousand blocks; the figures above may not.
    assert!(good * 1000 >= count * 998, "{good} of {count} good");
    let seconds = started.elapsed().as_secs_f64();
    let status = status(&mut board);
    assert_eq!(status.counters, Counters { blocks: count as u32, ..Counters::default() });
    assert_eq!((status.dropped, status.refused, board.listener().bad), (0, 0, 0));
    assert_eq!((board.listener().records, board.listener().missing), (count, 0));
    println!("{count} blocks right, none lost, {:.0} a second", count as f64 / seconds);
    let footprint = Footprint::from_elf(played()).unwrap();
    println!("flash {} B, RAM {} B without the stack", footprint.flash, footprint.ram);
    assert!(footprint.flash <= flash::BUDGET.flash, "{footprint:?}");
    assert!(footprint.ram <= flash::BUDGET.ram, "{footprint:?}");
    let bytes = [footprint.flash, footprint.ram].map(|bytes| bytes as f64);
    hold("board, bytes of flash and RAM without the stack", 1.0, &bytes);
    fits(&mut board, "block by block");
}

#[test]
fn instructions_of_a_block() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    // One tone in some needs more than the first look.
    let settings = Settings { effort: Some(Effort::LOOK), ..Settings::default() };
    board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    status(&mut board);
    board.recorded = Some(Vec::new());
    for _ in 0..5 {
        let samples = tone(rng.random_range(20.0..480.0), 900.0, 30.0, &mut rng);
        assert!(board.block(&bytes(&samples)).unwrap());
        next_record(&mut board);
    }
    let longest = several::longest_block(&mut board);
    // 1024 samples last 61,440 cycles of 144 MHz at 2.4 MS/s, 122,880 of 180 MHz at 1.5 MS/s and 368,640 at 500 kS/s, where the
    // image starts.
    println!("{longest} instructions for a block of {N}");
    assert!(longest > 10_000 && longest < 50_000, "{longest}");
    hold("board, instructions of a block", 1.0, &[longest.into()]);
    let found = [0, 1, 2, 3].map(|rounds| worst_block::<Real>(rounds) as f64);
    let found_iq = [0, 1, 2, 3].map(|rounds| worst_block::<Iq>(rounds) as f64);
    // A long search finds more than a short one: it is printed.
    if std::env::var_os("PICKET_LONG").is_some() {
        return;
    }
    hold(
        "board, instructions of the worst block that a short search finds",
        1.0,
        &[found, found_iq].concat(),
    );
    // By the cycles that an instruction takes on the emulated core without wait states, and those of a record. A short search finds four
    // fifths of the most that any search has found.
    for (found, most) in [found, found_iq].iter().zip(WORST_CYCLES) {
        for (instructions, most) in found.iter().zip(most) {
            let cycles = 1.64 * instructions + 37e3;
            println!("{cycles} cycles of {most}");
            assert!((0.8..=1.0).contains(&(cycles / most as f64)), "{cycles} of {most}");
        }
    }
}

/// A triangle's ramps, of one target and of four: what the board reserves for a block is more than one takes.
#[test]
fn instructions_of_a_ramp() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let chirp = Chirp {
        shape: Shape::Triangle,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        ..Chirp::default()
    };
    let defaults = Settings::default();
    let config = Config { rate_hz: 250e3, scene: Scene::Chirp(chirp), ..defaults.config };
    let drive = Drive::Dac { low: 400, high: 3600 };
    let settings = Settings { config, drive, ..defaults };
    board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    let mut here = Here::<Real>::new(&settings);
    let alone = [(100.4, 500.0)];
    let several = [(60.2, 500.0), (83.4, 450.0), (131.9, 400.0), (300.7, 350.0)];
    let mut number = 0;
    let longest = [&alone[..], &several].map(|targets| {
        status(&mut board);
        board.recorded = Some(Vec::new());
        for _ in 0..6 {
            let samples = tones(targets, 10.0, &mut rng);
            assert!(board.block(&bytes(&samples)).unwrap());
            let expected = here.record(here.stamp(number, false), &samples, Health::default());
            assert_eq!(next_record(&mut board).to_bytes(), expected.to_bytes(), "block {number}");
            number += 1;
        }
        several::longest_block(&mut board)
    });
    println!("{longest:?} instructions");
    let [most, _] = BLOCK_CYCLES;
    let [one, _] = longest;
    assert!(1.4 * f64::from(one) < most as f64);
    hold("board, instructions of a ramp of one target and of four", 1.0, &longest.map(f64::from));
}

/// The most instructions that a search over signals finds for a block with so many rounds. `PICKET_LONG=1` makes it a long one.
fn worst_block<R: Record>(rounds: u8) -> u64 {
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let effort = Effort::from_rounds(rounds);
    let settings = Settings { iq: R::IQ, effort, ..Settings::default() };
    board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    let count = |records: &[Vec<R::Sample>]| -> Result<Vec<u64>, Infallible> {
        let counts = records.iter().map(|record| {
            let codes: Vec<i16> =
                R::pairs(record).iter().flatten().map(|code| code + 2048).collect();
            status(&mut board);
            board.recorded = Some(Vec::new());
            assert!(board.block(&bytes(&codes)).unwrap());
            let record = next_record(&mut board);
            assert_eq!(record.basis.unwrap().effort, rounds);
            several::longest_block(&mut board).into()
        });
        Ok(counts.collect())
    };
    let generations = if std::env::var_os("PICKET_LONG").is_some() { 60 } else { 12 };
    let Ok(found) = worst::breed::<R, _>(N, Codes::signed::<12>(), worst::SEED, generations, count);
    let found = found.into_iter().flatten().max_by_key(|worst| worst.instructions).unwrap();
    println!("{rounds}: {} instructions by {}", found.instructions, found.signal);
    found.instructions
}

/// Records and tracks to the bit, and how long the core is awake at the fastest rate.
#[test]
fn a_tone_is_followed_and_a_held_one_leaves_the_core_asleep() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let following = Following { most: 1, refresh: 16, ..Following::default() };
    let settings = Settings::default();
    let settings = Settings { config: Config { following, ..settings.config }, ..settings };
    board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    let (plan, _) = planned(&settings);
    let terms = picket_dsp::plan::Plan::from_terms(*plan.plan).unwrap();
    let mut tracker = Box::new(Tracker::<Real, N>::new(terms));
    let method = plan.plan.options.method;
    let (mut short, mut whole) = (Vec::new(), Vec::new());
    for number in 0..40 {
        let samples = tone(200.3 + 0.05 * number as f64, 900.0, 30.0, &mut rng);
        status(&mut board);
        board.recorded = Some(Vec::new());
        assert!(board.block(&bytes(&samples)).unwrap());
        let stamp = plan.timing.stamp(number, false);
        let measurement = tracker.block(&stamp, &samples);
        let basis = Some(plan.basis(tree().source.clock()));
        let expected =
            Telemetry { measurement, method, health: Health::default(), basis, uncertainty: None };
        assert_eq!(next_record(&mut board).to_bytes(), expected.to_bytes(), "block {number}");
        let follow = board.expect(|said| match said {
            Said::Follow(follow) => Some(follow),
            _ => None,
        });
        let follow = follow.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            follow.to_frame(),
            Follow::from_tracker(&tracker, &stamp).to_frame(),
            "block {number}"
        );
        let way = if follow.locked { &mut short } else { &mut whole };
        way.push(several::longest_block(&mut board));
    }
    // Searched: the first two, and one of 16.
    assert!(short.len() >= 34 && whole.len() >= 4, "{short:?} {whole:?}");
    let middle = |mut counts: Vec<u32>| {
        counts.sort_unstable();
        counts[counts.len() / 2]
    };
    let (locked, searched) = (middle(short), middle(whole));
    // At 2.4 MS/s a block lasts 61,440 cycles of 144 MHz; 1.3 cycles an instruction are modelled, not measured.
    let load = |instructions: u32| 1.3 * f64::from(instructions) / 61_440.0;
    let held = (15.0 * load(locked) + load(searched)) / 16.0;
    println!(
        "{locked} instructions for a block of a held tone, {searched} for a search: at 2.4 MS/s the measurement takes {:.0} % and {:.0} % of the time, {:.0} % with a search every 16 blocks",
        100.0 * load(locked),
        100.0 * load(searched),
        100.0 * held
    );
    assert!(held < 0.35, "{held}");
    hold(
        "board, instructions of a held block and of a search",
        1.0,
        &[locked.into(), searched.into()],
    );
    fits(&mut board, "following a tone");
}

#[test]
fn tracks_beside_further_tones_are_refused() {
    let (mut board, _) = start();
    let following = Following { most: 1, ..Following::default() };
    let settings = Settings::default();
    let settings =
        Settings { most: 2, config: Config { following, ..settings.config }, ..settings };
    let refused = board.request(Command::SetSettings(settings, N)).unwrap();
    assert_eq!(refused, Err(Refusal::Settings([17, 0])));
}

/// The sum of tones of the converter's codes: their bins and amplitudes.
fn tones(lines: &[(f64, f64)], noise: f64, rng: &mut impl Rng) -> [i16; N] {
    let phases: Vec<f64> = lines.iter().map(|_| rng.random()).collect();
    std::array::from_fn(|n| {
        let sum = lines.iter().zip(&phases).map(|((bin, amplitude), phase)| {
            amplitude * (std::f64::consts::TAU * (bin * n as f64 / N as f64 + phase)).sin()
        });
        let value = 2048.0 + sum.sum::<f64>() + noise * rng.random_range(-1.0..1.0);
        value.round().clamp(0.0, 4095.0) as i16
    })
}

#[test]
fn every_fault_is_counted_and_none_touches_a_neighbour() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut board, _) = start();
    let mut here = Here::<Real>::new(&Settings::default());
    let mut expected = Counters::default();
    let mut number = 0;
    let mut gap = false;
    for round in 0..60 {
        match round % 6 {
            // The host is late, or an interrupt is lost: two blocks and one interrupt.
            1 => {
                let lost = tone(50.0, 1500.0, 0.0, &mut rng);
                assert!(board.fill(&bytes(&lost)).unwrap());
                expected.missed += 1;
                number += 1;
                gap = true;
            }
            // An interrupt without cause.
            2 => {
                board.interrupt().unwrap();
                expected.spurious += 1;
            }
            3 => {
                board.dma_error().unwrap();
                expected.dma_errors += 1;
                expected.broken += 1;
                number += 1;
                gap = true;
            }
            4 => {
                board.adc_overrun().unwrap();
                expected.adc_overruns += 1;
                expected.broken += 1;
                number += 1;
                gap = true;
            }
            _ => {}
        }
        // What the board has made of it is seen before the next block is played.
        assert_eq!(
            status(&mut board).counters,
            Counters {
                missed: expected.missed.saturating_sub(u32::from(round % 6 == 1)),
                ..expected
            }
        );
        // A block after the fault: a tone, a clipped one, or nothing at all.
        let samples = match round % 5 {
            0 => tone(rng.random_range(5.0..500.0), 5000.0, 10.0, &mut rng),
            1 => [2048; N],
            _ => tone(rng.random_range(5.0..500.0), 900.0, 30.0, &mut rng),
        };
        assert!(board.block(&bytes(&samples)).unwrap(), "round {round}: the stream stands still");
        expected.blocks += 1;
        let health = Health { lost: expected.lost(), faults: expected.faults() };
        let ours = here.record(here.stamp(number, gap), &samples, health);
        let theirs = next_record(&mut board);
        assert_eq!(theirs.to_bytes(), ours.to_bytes(), "round {round}: {theirs:?} {ours:?}");
        let verdict = theirs.measurement.tone.verdict;
        match round % 5 {
            0 => assert!(theirs.measurement.clipped > 10, "round {round}"),
            1 => assert_eq!(verdict, Verdict::NoSignal, "round {round}"),
            _ if gap => assert_eq!(verdict, Verdict::Gap, "round {round}"),
            _ => assert_eq!(verdict, Verdict::Good, "round {round}"),
        }
        number += 1;
        gap = false;
    }
    assert_eq!(status(&mut board).counters, expected);
    assert_eq!(expected.filled() as u64, number);
    board.request(Command::Reset).unwrap().unwrap();
    assert_eq!(status(&mut board).counters, Counters::default());
}

#[test]
fn settings_are_checked_used_and_a_chirp_goes_through_segment_by_segment() {
    let (mut board, first) = start();
    board.recorded = Some(Vec::new());
    let scene = Scene::Chirp(Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 0.0,
        ..Chirp::default()
    });
    // Both sides of 0 Hz, beside the converters' offsets.
    let band_hz = Some((-120e3, 120e3));
    let codes = Codes::unsigned::<12>();
    let config =
        Config { rate_hz: 250e3, scene, codes, band_hz, ..Config::new(1.0, Codes::signed::<12>()) };
    let drive = Drive::Dac { low: 400, high: 3600 };
    let settings = Settings { iq: true, config, guard: 32, drive, ..Settings::default() };
    // What cannot work changes nothing.
    let contradiction = Settings { guard: 65, ..settings };
    let refused = board.request(Command::SetSettings(contradiction, N)).unwrap();
    assert_eq!(refused, Err(Refusal::Settings([7, 0])));
    let refused = board.request(Command::SetSettings(settings, 512)).unwrap();
    assert_eq!(refused, Err(Refusal::Settings([6, 0])));
    let same = board.request(Command::Identify).unwrap().unwrap();
    assert_eq!(Boot::from_bytes(&same), Ok(first));
    // What can is answered as it will be used, and used after a restart.
    let body = board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    let (used, n) = Settings::from_bytes(&body).unwrap();
    assert_eq!((used, n), (planned(&settings).0.settings, N));
    let second = boot(&mut board);
    assert!(second.measuring && second.settings != first.settings);
    let body = board.request(Command::GetSettings).unwrap().unwrap();
    assert_eq!(Settings::from_bytes(&body), Ok((used, N)));
    let mut here = Here::<Iq>::new(&settings);
    // A target that comes nearer, or at rest, so that its flat beat is under the offset.
    let speeds = [25.0, 0.0];
    let mut runs = speeds.map(|velocity_mps| {
        let radar = scenario::sensor::<Iq>(&used.config, N, 0.0, 20);
        let target = scene::Source::Target(scenario::echo(900.0, 90.0, velocity_mps));
        let mut scene = scenario::before(radar, vec![target], 30.0);
        scene.receiver.offset = [150.0.into(), (-80.0).into()];
        scene.run(SEED).unwrap()
    });
    let mut targets = 0;
    for number in 0..60u64 {
        let half = number as usize / 30;
        let samples = samples::<Iq, N>(&mut runs[half], number as usize);
        assert!(board.block(&bytes(samples.as_flattened())).unwrap());
        let expected = here.record(here.stamp(number, false), &samples, Health::default());
        assert_eq!(next_record(&mut board).to_bytes(), expected.to_bytes(), "block {number}");
        let Outcome::Target(found) = expected.measurement.result else { continue };
        let off = |value: I32F32, truth: f64, sigma: f32| {
            (value.to_num::<f64>() - truth).abs() / f64::from(sigma)
        };
        assert!(found.verdict <= Verdict::Moving, "{found:?}");
        let truth = runs[half].truth_of_lap(0, number as usize / 3, N);
        let [range_m, velocity_mps] = scenario::place(&truth);
        assert!(off(found.range, range_m, found.sigma_range) < 6.0, "{found:?}");
        assert!(
            off(found.velocity.unwrap(), velocity_mps, found.sigma_velocity) < 6.0,
            "{found:?}"
        );
        targets += 1;
    }
    assert_eq!(targets, 20, "one for each chirp of three segments");
    // For `cargo picket watch --replay`.
    let session = Path::new(env!("CARGO_TARGET_TMPDIR")).join("emulated-session.bin");
    std::fs::write(session, board.recorded.take().unwrap()).unwrap();
    // QEMU's flash is read-only, and the board says that it kept nothing.
    assert_eq!(board.request(Command::Save).unwrap(), Err(Refusal::Flash));
    // Stopped, it neither measures nor captures, and starts again.
    board.request(Command::Stop).unwrap().unwrap();
    assert!(!boot(&mut board).measuring);
    assert_eq!(board.request(Command::Capture(1)).unwrap(), Err(Refusal::Stopped));
    board.request(Command::Start).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    board.request(Command::Reboot).unwrap().unwrap();
    assert_eq!(boot(&mut board), first, "the default settings after a restart as from power-on");
}

#[test]
fn noise_on_the_line_is_refused_and_costs_nothing_else() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut board, first) = start();
    let mut here = Here::<Real>::new(&Settings::default());
    let before = status(&mut board).refused;
    for number in 0..20 {
        for _ in 0..5 {
            // A damaged order to stop, and bytes that are nothing.
            let mut frame =
                Request { tag: rng.random(), command: Command::Stop }.to_frame().to_vec();
            let last = frame.len() - 1;
            frame[rng.random_range(0..last)] ^= 1 << rng.random_range(0..8);
            let mut noise = vec![0; rng.random_range(0..20)];
            rng.fill_bytes(&mut noise);
            noise.push(0);
            board.send(&[frame, noise].concat()).unwrap();
        }
        let samples = tone(100.25, 900.0, 30.0, &mut rng);
        assert!(board.block(&bytes(&samples)).unwrap(), "a damaged command was followed");
        let expected = here.record(here.stamp(number, false), &samples, Health::default());
        assert_eq!(next_record(&mut board).to_bytes(), expected.to_bytes(), "block {number}");
    }
    let after = status(&mut board);
    assert!(after.refused >= before + 100, "{after:?}");
    assert_eq!(after.counters.blocks, 20);
    let same = board.request(Command::Identify).unwrap().unwrap();
    assert_eq!(Boot::from_bytes(&same), Ok(first));
}

#[test]
fn captured_blocks_are_the_samples_and_are_measured_alike() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut board, _) = start();
    let mut here = Here::<Real>::new(&Settings::default());
    board.request(Command::Capture(5)).unwrap().unwrap();
    let mut captured = Vec::new();
    let mut measured = Vec::new();
    for number in 0..5 {
        let samples = tone(rng.random_range(5.0..500.0), 900.0, 30.0, &mut rng);
        assert!(board.block(&bytes(&samples)).unwrap());
        let record = next_record(&mut board);
        let mut blocks = Blocks::default();
        let block = board.expect(|said| match said {
            Said::Raw(raw) => blocks.push(&raw, 2 * N),
            _ => None,
        });
        let (sequence, raw) = block.unwrap();
        assert_eq!((sequence, &raw), (record.measurement.stamp.sequence, &bytes(&samples)));
        let expected = here.record(here.stamp(number, false), &samples, Health::default());
        assert_eq!(record.to_bytes(), expected.to_bytes());
        captured.extend(raw);
        measured.push(record.measurement.tone.frequency.bins(N));
    }
    // At this rate the board takes no round. `cargo picket analyze` on the capture gives the board's frequencies, bit for bit.
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("captured.i16");
    std::fs::write(&file, &captured).unwrap();
    let read = recording::Options {
        format: Some(recording::Format::I16),
        rate_hz: Some(500e3),
        ..Default::default()
    };
    let analysis = Analysis {
        read,
        n: Some(N),
        effort: Effort::LOOK,
        ..Analysis::new(Codes::unsigned::<12>(), Arithmetic::Target)
    };
    let mut replayed = Vec::new();
    analyze::run(&file, &analysis, |answer| replayed.push(answer.bins.unwrap()), |_| {}).unwrap();
    assert_eq!(replayed, measured);
    // No more than were asked for.
    let samples = tone(80.0, 900.0, 30.0, &mut rng);
    assert!(board.block(&bytes(&samples)).unwrap());
    next_record(&mut board);
    let more = std::iter::from_fn(|| board.hear(Duration::from_millis(100)).unwrap());
    assert!(more.take(20).all(|said| !matches!(said, Said::Raw(_))));
}

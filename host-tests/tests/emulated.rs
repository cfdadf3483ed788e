//! The core under emulation: the same bits on every machine, and no block lost on the way.

use host_tests::{prepare_images, sized};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::kind::{ForRecord, for_record};
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment};
use picket_dsp::config::{Config, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::Verdict;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::effort::Effort;
use picket_host::emulator::{Capture, Machine, Outcome, RunError};
use picket_host::toolchain::{Firmware, Profile, Target};
use picket_wire::capture::Header;
use picket_wire::frame::Reader;
use picket_wire::telemetry::{Health, Telemetry};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SEED: u64 = 20_220_222;
const LIMIT: Duration = Duration::from_secs(300);

fn image(bin: &str, target: Target) -> PathBuf {
    image_with(bin, target, &["mps2"])
}

fn image_with(bin: &str, target: Target, features: &[&str]) -> PathBuf {
    prepare_images(target);
    let firmware = Firmware { bin, target, features, profile: Profile::Release };
    firmware.build().unwrap_or_else(|error| panic!("{error}"))
}

/// Random blocks: a tone anywhere, of any strength, in noise of any strength, over a DC offset; some
/// clip, some hold nothing.
fn blocks<R: Record, const N: usize>(header: &Header) -> Vec<[R::Sample; N]> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED ^ u64::from(header.n) << 8 ^ u64::from(header.iq));
    let (low, high) = header.config.codes.rails();
    let middle = (f64::from(low) + f64::from(high)) / 2.0;
    let full = f64::from(high) - middle;
    (0..header.blocks)
        .map(|_| {
            let turns: f64 = rng.random_range(-0.5..0.5);
            let phase: f64 = rng.random();
            let amplitude = full * 10f64.powf(rng.random_range(-3.0..0.2));
            let noise = full * 10f64.powf(rng.random_range(-4.0..0.0));
            let offset = middle + full * rng.random_range(-0.1..0.1);
            let nothing = rng.random_range(0..50) == 0;
            std::array::from_fn(|n| {
                let angle = std::f64::consts::TAU * (turns * n as f64 + phase);
                let part = |value: f64, noise: f64| {
                    let code = if nothing { offset } else { offset + amplitude * value + noise };
                    code.round().clamp(low.into(), high.into()) as i16
                };
                let mut noise = || noise * rng.random_range(-1.0..1.0);
                R::from_parts([part(angle.cos(), noise()), part(angle.sin(), noise())])
            })
        })
        .collect()
}

/// Writes a capture of random blocks, and measures them here.
struct Here(Header);

impl ForRecord for Here {
    type Output = (Capture, Vec<u8>);

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let Here(header) = self;
        measured::<R, N>(&header, &blocks::<R, N>(&header))
    }
}

/// A capture of these blocks, and what is measured of it here.
fn measured<R: Record, const N: usize>(
    header: &Header,
    blocks: &[[R::Sample; N]],
) -> (Capture, Vec<u8>) {
    let mut capture = Capture::create(header).unwrap();
    let plan = header.config.plan::<R, N>().unwrap();
    let mut pipeline = Pipeline::<R, N>::new(plan);
    let mut telemetry = Vec::new();
    for (sequence, samples) in blocks.iter().enumerate() {
        capture.push::<R>(samples).unwrap();
        let stamp = header.timing().stamp(sequence as u64, false);
        let measurement = pipeline.block(&stamp, samples);
        let (method, health) = (plan.options.method, Health::default());
        telemetry.extend(
            Telemetry { measurement, method, health, basis: None, uncertainty: None }.to_frame(),
        );
    }
    (capture, telemetry)
}

fn here(header: &Header) -> (Capture, Vec<u8>) {
    for_record(header.iq, header.n as usize, Here(*header)).unwrap()
}

fn there(capture: Capture, machine: Machine, bin: &str) -> Result<(Outcome, Vec<u8>), RunError> {
    run(capture, machine, &image(bin, machine.target()))
}

fn run(capture: Capture, machine: Machine, image: &Path) -> Result<(Outcome, Vec<u8>), RunError> {
    let mut telemetry = Vec::new();
    let outcome = capture.run(machine, image, LIMIT, |bytes| telemetry.extend(bytes))?;
    Ok((outcome, telemetry))
}

fn records(telemetry: &[u8]) -> Vec<Telemetry> {
    let mut reader = Reader::default();
    let frames = telemetry.iter().filter_map(|&byte| reader.push(byte));
    frames.map(|frame| Telemetry::from_frame(&frame.unwrap()).unwrap()).collect()
}

/// The first record that differs says more than two heaps of bytes.
fn assert_same(here: &[u8], there: &[u8], what: &str) {
    if here == there {
        return;
    }
    let (here, there) = (records(here), records(there));
    for (ours, theirs) in here.iter().zip(&there) {
        // A NaN differs from itself: compare what is printed.
        assert_eq!(format!("{ours:?}"), format!("{theirs:?}"), "{what}");
    }
    panic!("{what}: {} records here, {} there", here.len(), there.len());
}

const LIDAR: Scene = Scene::Chirp(Chirp {
    shape: Shape::Trapezoid,
    wavelength_m: 1550e-9,
    bandwidth_hz: 1e9,
    duration_s: 17e-6,
    guard_s: 0.0,
    mixing: Mixing::TxConjRx,
    sweep_curvature: 0.0,
});

fn config(method: Method, scene: Scene) -> Config {
    Config { rate_hz: 250e6, method, scene, ..Config::new(1.0, Codes::signed::<12>()) }
}

/// Lengths of real and of I/Q records: all.
const EVERY: [&[u32]; 2] = [&[64, 128, 256, 512, 1024, 2048, 4096]; 2];
/// Those of `core_check` without the feature `every-kind`.
const FOUR: [&[u32]; 2] = [&[64, 1024], &[256, 4096]];

/// 1,000 real blocks of 1024 by the default method, then every method on records it is right for, the lengths taking
/// turns, and least squares with its sums in integers.
fn headers(lengths: [&[u32]; 2]) -> Vec<Header> {
    let doppler =
        Scene::Doppler { wavelength_m: 1550e-9, angle_rad: 0.1, mixing: Mixing::RxConjTx };
    let mut headers =
        vec![Header::from_config::<Real>(config(Method::default(), LIDAR), 1024, 1000)];
    for iq in [false, true] {
        let fits = |method: &&Method| {
            if iq { method.fits::<Iq>() } else { method.fits::<Real>() }
        };
        let scene = if iq { doppler } else { Scene::Tone };
        let plain = Method::ALL.iter().filter(fits).map(|&method| config(method, scene));
        let fixed = Config { arithmetic: Arithmetic::Fixed, ..config(Method::default(), scene) };
        let lengths = lengths[usize::from(iq)];
        let fixed = lengths.iter().map(|_| fixed);
        for (mut config, &n) in plain.chain(fixed).zip(lengths.iter().cycle()) {
            if n % 3 == 1 {
                config.codes = Codes::signed::<16>();
            }
            headers.push(Header { iq, ..Header::from_config::<Real>(config, n, 4) });
        }
    }
    headers
}

fn same_bits_on(machine: Machine, target: Target, bin: &str) {
    let lengths = if bin == "core_check" { FOUR } else { EVERY };
    same_bits(machine, target, &image(bin, target), lengths);
}

fn same_bits(machine: Machine, target: Target, image: &Path, lengths: [&[u32]; 2]) {
    println!("seed {SEED}");
    let headers = headers(lengths);
    for header in &headers {
        let what = format!(
            "{target:?} on {machine:?}, {:?}, iq {}, n {}",
            header.config.method, header.iq, header.n
        );
        let (capture, ours) = here(header);
        let (outcome, theirs) =
            run(capture, machine, image).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(records(&ours).len(), header.blocks as usize);
        assert_same(&ours, &theirs, &what);
        print!("{what}: {} blocks the same", header.blocks);
        if let Some(ticks) = outcome.figure("ticks") {
            let instructions = ticks as f64 * machine.instructions_per_tick();
            print!(", {:.0} instructions a block", instructions / f64::from(header.blocks));
        }
        println!();
    }
}

/// Blocks of which each has another line somewhere near its tone, a level that swings, and a phase that bends, of any strength.
fn hard_blocks<R: Record, const N: usize>(header: &Header) -> Vec<[R::Sample; N]> {
    let mut rng =
        ChaCha8Rng::seed_from_u64(SEED ^ u64::from(header.n) << 16 ^ u64::from(header.iq));
    (0..header.blocks)
        .map(|_| {
            let bins = rng.random_range(0.1..0.4) * N as f64;
            let apart: f64 = rng.random_range(-12.0..12.0);
            let [other, depth, bend]: [f64; 3] =
                std::array::from_fn(|_| 10f64.powf(rng.random_range(-3.0..0.0)));
            let [first, second, third]: [f64; 3] = std::array::from_fn(|_| rng.random());
            let noise = 10f64.powf(rng.random_range(0.0..2.0));
            std::array::from_fn(|n| {
                let x = n as f64 / N as f64;
                let turns = bins * x + bend * (x - 0.5) * (x - 0.5) + first;
                let level = 1.0 + depth * (std::f64::consts::TAU * (x + third)).sin();
                let [tone, line] =
                    [turns, (bins + apart) * x + second].map(|turns| std::f64::consts::TAU * turns);
                let mut part = |tone: f64, line: f64| {
                    let value = 800.0 * (level * tone + other * line);
                    (value + noise * rng.random_range(-1.0..1.0)).clamp(-2047.0, 2047.0) as i16
                };
                R::from_parts([part(tone.cos(), line.cos()), part(tone.sin(), line.sin())])
            })
        })
        .collect()
}

/// The joint fit's answers are the host's to the bit, and what a block costs is printed for every effort.
fn joint_fits_on(machine: Machine, target: Target) {
    let image = image_with("core_check", target, &["mps2", "joint-fit"]);
    // Floats in software are slow.
    let count = sized(if target == Target::M4f { 25 } else { 3 }, 100) as u32;
    for (iq, n) in [(false, 64), (true, 256), (false, 1024)] {
        let looks = Effort::ALL.iter().map(|&effort| {
            let config = Config { effort, ..config(Method::default(), Scene::Tone) };
            let header = Header { iq, ..Header::from_config::<Real>(config, n, count) };
            let (capture, ours, verdicts) = for_record(iq, n as usize, Hard(header)).unwrap();
            let what = format!("{target:?}, iq {iq}, n {n}, {}", effort.name());
            let (outcome, theirs) =
                run(capture, machine, &image).unwrap_or_else(|error| panic!("{what}: {error}"));
            assert_same(&ours, &theirs, &what);
            let ticks = outcome.figure("ticks").unwrap_or_default();
            let instructions =
                ticks as f64 * machine.instructions_per_tick() / f64::from(count);
            println!(
                "{what}: {count} blocks the same, {instructions:.0} instructions a block, {verdicts} usable"
            );
            if target == Target::M4f && effort == Effort::THREE {
                // As docs/performance.md says.
                assert!((0.1e6..0.6e6).contains(&instructions));
            }
            verdicts
        });
        let usable: Vec<usize> = looks.collect();
        // The first look lets pass what one round leaves unresolved.
        let [_, rounds @ ..] = &usable[..] else { panic!() };
        assert!(rounds.is_sorted(), "{usable:?}");
    }
}

#[test]
fn joint_fits_give_the_same_bits() {
    joint_fits_on(Machine::An386, Target::M4f);
}

#[test]
#[ignore = "needs images of the Cortex-M3: cargo test --test all -- --ignored"]
fn joint_fits_give_the_same_bits_on_cortex_m3() {
    joint_fits_on(Machine::An385, Target::M3);
}

#[test]
#[ignore = "needs images of the Cortex-M0: cargo test --test all -- --ignored"]
fn joint_fits_give_the_same_bits_on_cortex_m0() {
    joint_fits_on(Machine::An385, Target::M0);
}

/// Writes a capture of hard blocks, measures them here, and counts the usable answers.
struct Hard(Header);

impl ForRecord for Hard {
    type Output = (Capture, Vec<u8>, usize);

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let Hard(header) = self;
        let blocks = hard_blocks::<R, N>(&header);
        let (capture, telemetry) = measured::<R, N>(&header, &blocks);
        let usable = records(&telemetry)
            .iter()
            .filter(|record| {
                matches!(record.measurement.tone.verdict, Verdict::Good | Verdict::Moving)
            })
            .count();
        (capture, telemetry, usable)
    }
}

/// The M0's code runs on the M3's board, see `bench::CORES`.
#[test]
#[ignore = "needs images of the Cortex-M0: cargo test --test all -- --ignored"]
fn cortex_m0_gives_the_same_bits() {
    same_bits_on(Machine::An385, Target::M0, "core_check");
}

#[test]
#[ignore = "needs images of the Cortex-M55: cargo test --test all -- --ignored"]
fn cortex_m55_gives_the_same_bits() {
    same_bits_on(Machine::An547, Target::M55, "frontend_qemu");
}

#[test]
#[ignore = "needs images of the Cortex-M3: cargo test --test all -- --ignored"]
fn cortex_m3_gives_the_same_bits() {
    same_bits_on(Machine::An385, Target::M3, "core_check");
}

#[test]
fn cortex_m4f_gives_the_same_bits() {
    same_bits_on(Machine::An386, Target::M4f, "core_check");
}

#[test]
#[ignore = "needs one more image: cargo test --test all -- --ignored"]
fn cortex_m4f_gives_the_same_bits_for_every_kind() {
    let image = image_with("core_check", Target::M4f, &["mps2", "every-kind"]);
    same_bits(Machine::An386, Target::M4f, &image, EVERY);
}

#[test]
fn cortex_m7_gives_the_same_bits() {
    same_bits_on(Machine::An500, Target::M4f, "core_check");
}

#[test]
fn cortex_m33_gives_the_same_bits() {
    same_bits_on(Machine::An505, Target::M33, "frontend_qemu");
}

/// By a DMA controller.
#[test]
fn the_front_end_delivers_every_block_in_order() {
    delivers_in_order(Machine::An505);
}

/// By a copy in the interrupt, in the controller's place.
#[test]
#[ignore = "needs images of the Cortex-M55: cargo test --test all -- --ignored"]
fn the_front_end_of_cortex_m55_delivers_every_block_in_order() {
    delivers_in_order(Machine::An547);
}

fn delivers_in_order(board: Machine) {
    println!("seed {SEED}");
    // The last two are longer than one transfer of the controller, and than its memory of input.
    for (iq, n, blocks) in
        [(false, 64, 90), (false, 1024, 300), (true, 4096, 30), (false, 4096, 2500)]
    {
        let header = Header::from_config::<Real>(config(Method::ZRife, LIDAR), n, blocks);
        let header = Header { iq, stride: n + 500, ..header };
        let (capture, ours) = here(&header);
        let (outcome, theirs) = there(capture, board, "frontend_qemu").unwrap();
        assert_same(&ours, &theirs, &format!("{board:?}, iq {iq}, n {n}"));
        for (index, record) in records(&theirs).iter().enumerate() {
            let stamp = record.measurement.stamp;
            assert_eq!(stamp.sequence, index as u32);
            assert_eq!(stamp.clock, index as u64 * u64::from(n + 500));
            assert_eq!(stamp.segment, [Segment::Up, Segment::Flat, Segment::Down][index % 3]);
            assert!(!stamp.gap);
        }
        for (name, value) in [("blocks", blocks), ("lost", 0), ("faults", 0)] {
            assert_eq!(outcome.figure(name), Some(value.into()), "{name}");
        }
        // Each block took one interrupt of the timer and one of the controller; the timer's last finds
        // the input used up, once for each time it was filled.
        assert_eq!(outcome.figure("transfers"), Some(blocks.into()));
        assert!(outcome.figure("conversions") > Some(blocks.into()));
    }
}

#[test]
fn a_converter_that_is_too_fast_loses_blocks_and_every_one_is_counted() {
    counts_its_losses(Machine::An505);
}

#[test]
#[ignore = "needs images of the Cortex-M55: cargo test --test all -- --ignored"]
fn a_converter_of_cortex_m55_that_is_too_fast_loses_blocks_and_every_one_is_counted() {
    counts_its_losses(Machine::An547);
}

fn counts_its_losses(board: Machine) {
    let header = Header::from_config::<Real>(config(Method::ZRife, Scene::Tone), 1024, 200);
    let header = Header { period_us: 1000, ..header };
    let (capture, _) = here(&header);
    let (outcome, telemetry) = there(capture, board, "frontend_qemu").unwrap();
    let records = records(&telemetry);
    let lost = outcome.figure("lost").unwrap();
    assert!(lost > 0 && records.len() > 10, "{}", outcome.messages);
    assert_eq!(records.len() as u64 + lost, 200);
    for pair in records.windows(2) {
        let [before, after] = [pair[0].measurement.stamp, pair[1].measurement.stamp];
        let skipped = after.sequence - before.sequence - 1;
        assert_eq!(after.gap, skipped > 0);
        assert_eq!(pair[1].health.lost - pair[0].health.lost, skipped);
    }
}

#[test]
fn what_cannot_be_measured_stops_with_one_line() {
    let fast = Config { rate_hz: -1.0, ..Config::new(1.0, Codes::signed::<12>()) };
    let capture = Capture::create(&Header::from_config::<Real>(fast, 64, 1)).unwrap();
    let error = there(capture, Machine::An505, "frontend_qemu").unwrap_err().to_string();
    assert_eq!(error, "the firmware says: the sample rate must lie between 1e-6 and 1e12 Hz");
    let capture = Capture::create(&Header::from_config::<Real>(
        Config::new(1.0, Codes::signed::<12>()),
        64,
        1,
    ))
    .unwrap();
    let error = there(capture, Machine::An505, "frontend_qemu").unwrap_err().to_string();
    assert_eq!(error, "the firmware says: the capture ends before its last block");
    let capture = Capture::create(&Header::from_config::<Real>(
        Config::new(1.0, Codes::signed::<12>()),
        65,
        1,
    ))
    .unwrap();
    let error = there(capture, Machine::An505, "frontend_qemu").unwrap_err().to_string();
    assert_eq!(error, "the firmware says: a block must have 64, 128, ... 4096 samples");
}

//! What goes wrong: no record is of a mixed block, every loss is counted, and the stamps are right after it.

use super::scene::{expected, measured, plug, plug_usb, record, settings, status};
use host_tests::sized;
use picket_claims::scenes::{Kind, line, tones};
use picket_firmware::pico::N;
use picket_host::pico::bench::{Completed, Pico};
use picket_host::pico::converter::Converter;
use picket_wire::settings::Settings;
use picket_wire::telemetry::Telemetry;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// A fault: its kind, and how long it lasts, us.
pub type Fault = (&'static str, f64);

/// How a board's blocks are taken.
pub struct Blocks {
    pub settings: Settings,
    /// A block's time, ns.
    pub nanos: f64,
    /// Conversions in a block.
    pub conversions: usize,
}

/// A tone without a jump, in noise: each window of it is measured otherwise, wherever it begins.
fn steady(blocks: usize, seed: u64) -> Vec<i16> {
    // Whole cycles in all of it, since it comes again and again.
    let n = N * blocks;
    let mut scene = tones(Kind::Real, n, [line((100 * blocks + 37) as f64, 1200.0)], 4.0);
    (scene.seed, scene.receiver.offset[0]) = (seed, 2048.0.into());
    let converter = Converter::default();
    let voltages = scene.run(0).unwrap().voltages(0.0, n);
    voltages.into_iter().map(|[voltage, _]| converter.code(voltage)).collect()
}

/// What a block's noise makes of its tone; the verdict also tells of a gap before it.
fn key(record: &Telemetry) -> String {
    let tone = &record.measurement.tone;
    format!("{:?} {:?} {:?}", tone.frequency, tone.snr, tone.amplitude)
}

/// The number that each completed block must have: one more than the last, and if the channels started anew in between, the
/// blocks that have begun since, too. The board reads its timer of microseconds before it sets the channels up: a block that
/// begins meanwhile is the one that the samples are of.
fn numbers(blocks: &[Completed], nanos: f64) -> Vec<u64> {
    const SET_UP: f64 = 2_000.0;
    let mut numbers = vec![0];
    for pair in blocks.windows(2) {
        let idle = pair[1].nanos - nanos - pair[0].nanos;
        let anew = pair[1].starts > pair[0].starts;
        let passed = if anew { ((idle - SET_UP) / nanos).ceil().max(1.0) as u64 } else { 0 };
        numbers.push(numbers[numbers.len() - 1] + 1 + passed);
    }
    numbers
}

/// A board that measures real records of a steady tone.
fn begin(mut pico: Pico, seed: u64) -> (Pico, Blocks) {
    pico.order("usb plug").unwrap();
    pico.samples(&steady(300, seed)).unwrap();
    pico.keep(N).unwrap();
    pico.power().unwrap();
    (pico, Blocks { settings: settings(), nanos: 2_048_000.0, conversions: N })
}

/// Lets these faults happen, each some time after the one before, and checks everything. Returns the blocks that were delivered.
pub fn play(
    (mut pico, blocks): (Pico, Blocks),
    faults: &[(f64, Fault)],
    seed: u64,
) -> Vec<Completed> {
    pico.run(6_000).unwrap();
    for &(after, (kind, duration)) in faults {
        pico.run(after as u64).unwrap();
        match kind {
            "usb" => pico.order("usb unplug").map(drop).unwrap(),
            _ => pico.fault(kind, duration).unwrap(),
        }
        pico.run(duration as u64).unwrap();
        if kind == "usb" {
            pico.order("usb plug").unwrap();
        }
    }
    pico.run(16_000).unwrap();
    let status = status(&mut pico);
    let counters = status.counters;
    assert_eq!(status.dropped, 0, "seed {seed}");
    let told = |kind: &str| faults.iter().filter(|(_, (k, _))| *k == kind).count() as u32;
    assert_eq!(counters.dma_errors, told("error"), "seed {seed}: {counters:?}");
    // One that is found while it lasts, and the samples started anew, comes again.
    let over = pico.figures().unwrap().over;
    assert_eq!(counters.adc_overruns, over, "seed {seed}: {counters:?}");
    assert!(over >= told("overrun"), "seed {seed}: {counters:?}");
    assert!(counters.spurious >= told("doubled"), "seed {seed}: {counters:?}");
    let kept = pico.kept(blocks.conversions).unwrap();
    let flat: Vec<i16> = kept.iter().flat_map(|block| block.samples.iter().copied()).collect();
    let frames = expected(&blocks.settings, &flat);
    let mut places = HashMap::new();
    for (place, frame) in frames.iter().enumerate() {
        places.insert(key(&measured(frame).unwrap()), place);
    }
    let numbers = numbers(&kept, blocks.nanos);
    let frames = pico.sent.split_inclusive(|&byte| byte == 0);
    let records: Vec<Telemetry> = frames.filter_map(record).collect();
    let (mut next, mut delivered) = (0, Vec::new());
    for (count, record) in records.iter().enumerate() {
        let stamp = &record.measurement.stamp;
        let at = format!("seed {seed}, {stamp:?}, {faults:?}");
        let place = *places.get(&key(record)).unwrap_or_else(|| panic!("mixed: {at}"));
        assert_eq!(u64::from(stamp.sequence), numbers[place], "number of block {place}: {at}");
        assert_eq!(stamp.clock, numbers[place] * N as u64, "{at}");
        assert_eq!(stamp.gap, stamp.sequence != next, "{at}");
        assert_eq!(record.health.lost, stamp.sequence - count as u32, "{at}");
        next = stamp.sequence + 1;
        delivered.push(kept[place].clone());
    }
    assert!(records.len() > 4, "{faults:?}");
    let by_usb = by_usb(&pico, &records);
    println!(
        "seed {seed}, {} faults: {} of {} completed blocks delivered, {by_usb} of them by USB, {counters:?}",
        faults.len(),
        records.len(),
        kept.len()
    );
    delivered
}

/// How many records came by USB: each as it came by the wire, which may still have the last one to send.
fn by_usb(pico: &Pico, records: &[Telemetry]) -> usize {
    let others: Vec<Telemetry> =
        pico.by_usb.split_inclusive(|&byte| byte == 0).filter_map(record).collect();
    let last = records.last().unwrap().measurement.stamp.sequence;
    for other in others.iter().filter(|other| other.measurement.stamp.sequence <= last) {
        assert!(records.contains(other), "only by USB: {other:?}");
    }
    others.len()
}

/// One of each kind, and interrupts late by other times.
pub const EACH: [Fault; 8] = [
    ("late", 1_500.0),
    ("late", 3_000.0),
    ("late", 5_000.0),
    ("late", 15_000.0),
    ("doubled", 0.0),
    ("lost", 0.0),
    ("overrun", 40.0),
    ("error", 0.0),
];

/// A fault of any kind that the chip itself has.
pub fn any(rng: &mut impl Rng) -> Fault {
    match rng.random_range(0..6) {
        0 => ("late", rng.random_range(10.0..15_000.0)),
        1 => ("doubled", 0.0),
        2 => ("lost", 0.0),
        3 => ("overrun", rng.random_range(12.0..500.0)),
        4 => ("late", [1_500.0, 3_000.0, 5_000.0, 15_000.0][rng.random_range(0..4)]),
        _ => ("error", 0.0),
    }
}

#[test]
fn each_fault_alone_is_counted_exactly() {
    let each: Vec<(f64, Fault)> = EACH.iter().map(|&fault| (9_300.0, fault)).collect();
    let pico = plug();
    play(begin(pico, 81), &each, 81);
}

/// Faults of every kind at any moment, on the image with USB: 1,000 in the long form.
#[test]
fn random_faults_mix_no_block() {
    let mut rng = ChaCha8Rng::seed_from_u64(82);
    let rounds = sized(1, 25);
    for seed in 0..rounds {
        let mut fault = || match rng.random_range(0..7) {
            0 => ("usb", rng.random_range(10.0..8_000.0)),
            _ => any(&mut rng),
        };
        let mut faults = Vec::new();
        for _ in 0..sized(30, 40) {
            faults.push(fault());
        }
        let faults: Vec<(f64, Fault)> =
            faults.into_iter().map(|fault| (rng.random_range(4_200.0..9_000.0), fault)).collect();
        let pico = plug_usb();
        play(begin(pico, 1_000 + seed), &faults, 1_000 + seed);
    }
}

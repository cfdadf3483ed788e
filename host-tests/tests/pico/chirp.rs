//! The board's own chirp: levels and samples in step, blocks and segments that stay together, records that are the host's.

use super::scene::{expected, frames, measure, measured, plug, record, set_plan, status};
use host_tests::sized;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_firmware::pico::N;
use picket_firmware::pico::waveform::PLACES;
use picket_firmware::pico::words::Words;
use picket_host::pico::bench::Pico;
use picket_host::scenario;
use picket_simulator::scene::Source;
use picket_wire::command::{Command, Refusal};
use picket_wire::settings::{Drive, Settings};
use picket_wire::settings_error::{RateError, SettingsError, WaveformError};
use picket_wire::telemetry::Telemetry;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A chirp of the board's own.
fn settings(shape: Shape, guard: u16, rate_hz: f64) -> Settings {
    let scene = Scene::Chirp(Chirp {
        shape,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 1.0,
        ..Chirp::default()
    });
    let config = Config { rate_hz, scene, ..Settings::default().config };
    let drive = Drive::Dac { low: 300, high: 3800 };
    Settings { config, guard, drive, ..Settings::default() }
}

/// What a converter at the chirp's output reads in a whole chirp: the level of 4096 at each sample.
fn ramp(settings: &Settings) -> Vec<i16> {
    let (_, words) = Words::plan(settings).unwrap();
    let wave = words.waveform.unwrap();
    let mut table = [0; PLACES];
    let mut levels = wave.fill(&mut table).to_vec();
    levels.rotate_right(2);
    let counts = wave.count().top + 1;
    let code = |level: u16| (4096 * u32::from(level) / counts).min(4095) as i16;
    levels.into_iter().map(code).collect()
}

/// A measuring board with these settings, whose chirp's output is wired to its input.
fn wired(settings: Settings) -> Pico {
    let mut pico = plug();
    pico.power().unwrap();
    pico.order("wire").unwrap();
    set_plan(&mut pico, settings, |pico| {
        pico.keep(N).unwrap();
        pico.order("edges").unwrap();
    });
    pico
}

/// Every completed block is its segment of the chirp, sample by sample, from each start of the samples on. Returns their number.
fn in_step(pico: &Pico, settings: &Settings) -> usize {
    let (plan, _) = Words::plan(settings).unwrap();
    let (ramp, length) = (ramp(settings), plan.length as usize);
    let segments = ramp.len() / length;
    let blocks = pico.kept(N).unwrap();
    let (mut starts, mut segment) = (f64::NAN, 0);
    for (block, number) in blocks.iter().zip(0..) {
        segment = if block.starts == starts { (segment + 1) % segments } else { 0 };
        starts = block.starts;
        let begin = segment * length + usize::from(settings.guard);
        assert!(block.samples == ramp[begin..begin + N], "block {number}, segment {segment}");
    }
    blocks.len()
}

/// Every record is that of the segment which its stamp names, of a chirp with these samples. Returns their number.
pub fn in_place(pico: &Pico, settings: &Settings, chirp: &[i16]) -> usize {
    let (plan, _) = Words::plan(settings).unwrap();
    let wanted: Vec<Telemetry> =
        expected(settings, chirp).iter().map(|frame| measured(frame).unwrap()).collect();
    let frames = frames(&pico.sent);
    for (sequence, frame) in &frames {
        let record = record(frame).unwrap();
        let segment = *sequence as usize % wanted.len();
        let stamp = record.measurement.stamp;
        assert_eq!(stamp.segment, plan.timing.segments[segment], "{stamp:?}");
        assert_eq!(stamp.clock, u64::from(*sequence) * u64::from(plan.length), "{stamp:?}");
        let tone = |record: &Telemetry| format!("{:?}", record.measurement.tone.frequency);
        assert_eq!(tone(&measured(frame).unwrap()), tone(&wanted[segment]), "{stamp:?}");
    }
    frames.len()
}

/// Chirp and samples keep their phase to a sample: a thousand chirps in the long form.
#[test]
fn chirp_and_samples_stay_in_step() {
    let chirps = sized(12, 1_000);
    for (shape, guard, rate_hz) in
        [(Shape::Trapezoid, 64, 500e3), (Shape::Sawtooth, 0, 250e3), (Shape::Triangle, 32, 96e3)]
    {
        let settings = settings(shape, guard, rate_hz);
        let (plan, words) = Words::plan(&settings).unwrap();
        let mut pico = wired(settings);
        let wave = words.waveform.unwrap();
        let sample = f64::from(words.period) / 48e6 * 1e9;
        let chirp = f64::from(wave.samples()) * sample;
        pico.run((chirp * (chirps as f64 + 0.5) / 1e3) as u64).unwrap();
        let blocks = in_step(&pico, &settings);
        assert!(blocks >= plan.timing.segments.len() * chirps as usize, "{blocks} blocks");
        let records = in_place(&pico, &settings, &ramp(&settings));
        let counters = status(&mut pico).counters;
        // A ramp is no tone: it may take longer than a block, until no slot is free.
        assert_eq!((counters.lost(), counters.faults()), (counters.overruns, 0), "{shape:?}");
        // The sync pulse marks the first segment of each chirp but the first one, which the emulator leaves out.
        let edges = pico.order("edges").unwrap();
        let edge = |line: &String| {
            let (level, nanos) = line.split_once(' ').unwrap();
            (level == "1", nanos.parse::<f64>().unwrap())
        };
        let edges: Vec<(bool, f64)> = edges.iter().map(edge).collect();
        let rises: Vec<f64> = edges.iter().filter(|edge| edge.0).map(|edge| edge.1).collect();
        let segment = f64::from(wave.samples()) * sample / plan.timing.segments.len().max(2) as f64;
        let kept = pico.kept(N).unwrap();
        let ends = kept.iter().skip(plan.timing.segments.len() - 1);
        let ends: Vec<f64> =
            ends.step_by(plan.timing.segments.len()).map(|block| block.nanos).collect();
        assert!(rises.len() as u64 >= chirps - 1, "{} pulses", rises.len());
        let late = ends[0] - rises[0];
        for (number, (&rise, &end)) in rises.iter().zip(&ends).enumerate() {
            let phase = (end - rise - late) / sample;
            assert!(phase.abs() < 0.01, "{shape:?}, chirp {number}: {phase} samples");
            let wanted = rises[0] + number as f64 * chirp;
            assert!((rise - wanted).abs() < 0.01 * sample, "{shape:?}, pulse {number}");
            let fall = edges.iter().find(|(up, at)| !up && *at > rise);
            if let Some((_, fall)) = fall {
                assert!((fall - rise - segment).abs() < 0.01 * sample, "{shape:?}, {number}");
            }
        }
        println!(
            "{shape:?}: {blocks} blocks and {records} records in step, a chirp ends {:.2} samples after the next pulse's rise",
            late / sample
        );
    }
}

/// After faults and after a save the samples begin with a chirp, and what passed is counted by its segments.
#[test]
fn faults_leave_blocks_and_segments_together() {
    let mut rng = ChaCha8Rng::seed_from_u64(83);
    for round in 0..sized(1, 10) {
        let settings = settings(Shape::Trapezoid, 64, 500e3);
        let mut pico = wired(settings);
        for fault in 0..30 {
            pico.run(rng.random_range(4_000..20_000)).unwrap();
            let (kind, duration) = match rng.random_range(0..5) {
                0 => ("late", rng.random_range(10.0..15_000.0)),
                1 => ("doubled", 0.0),
                2 => ("lost", 0.0),
                3 => ("overrun", rng.random_range(12.0..500.0)),
                _ => ("error", 0.0),
            };
            pico.fault(kind, duration).unwrap();
            pico.run(duration as u64).unwrap();
            if fault == 15 {
                assert_eq!(pico.request(Command::Save).unwrap(), Ok(vec![]));
            }
        }
        pico.run(20_000).unwrap();
        let records = in_place(&pico, &settings, &ramp(&settings));
        let counters = status(&mut pico).counters;
        println!("round {round}: {records} records, {counters:?}");
        assert!(counters.faults() > 0 && records > 100);
    }
}

/// With an echo in each segment every record is the host's, targets and all, and none is lost.
#[test]
fn every_record_of_a_chirp_is_the_hosts() {
    let settings = settings(Shape::Trapezoid, 64, 430e3);
    let (plan, _) = Words::plan(&settings).unwrap();
    let blocks = sized(60, 3_000);
    // The board takes the samples of the guards, too.
    let Scene::Chirp(chirp) = plan.settings.config.scene else { panic!("no chirp") };
    let scene = Scene::Chirp(Chirp { guard_s: 0.0, ..chirp });
    let config = Config { scene, ..plan.settings.config };
    let radar = scenario::sensor::<Real>(&config, plan.length as usize, 0.0, 1);
    let target = Source::Target(scenario::echo(900.0, 15.0..250.0, -40.0..40.0));
    let scene = scenario::before(radar, vec![target], 50.0);
    let codes = (0..blocks / 3).flat_map(|chirp| scene.codes(chirp).unwrap());
    let samples: Vec<i16> = codes.map(|[code, _]| code).collect();
    let mut pico = plug();
    pico.power().unwrap();
    set_plan(&mut pico, settings, |pico| pico.samples(&samples).unwrap());
    pico.zero().unwrap();
    measure(&mut pico, blocks);
    let figures = pico.figures().unwrap();
    let wanted = expected(&settings, &samples);
    let records = frames(&pico.sent);
    for (((sequence, frame), wanted), number) in records.iter().zip(&wanted).zip(0..) {
        assert_eq!(*sequence, number, "lost before block {number}");
        assert!(frame == wanted, "{number}: {:#?}", [frame, wanted].map(|frame| record(frame)));
    }
    assert!(records.len() as u64 >= blocks, "{} records", records.len());
    println!(
        "{} records of chirps byte for byte, load {:.1} %",
        records.len(),
        100.0 * figures.load()
    );
    // A moving target bends its beat, and every ramp is looked at closely; then the beats are paired.
    assert!(figures.load() <= 0.99, "{figures:?}");
}

#[test]
fn what_the_board_cannot_play_is_refused() {
    let mut pico = plug();
    pico.power().unwrap();
    let chirp = settings(Shape::Triangle, 0, 500e3);
    // The sync input's gate counts 116 ms.
    let slow = Settings { drive: Drive::External, ..settings(Shape::Triangle, 0, 10e3) };
    for (settings, error) in [
        (Settings { guard: 1, ..chirp }, SettingsError::Guard),
        (slow, SettingsError::Rate(RateError::Slow)),
        (
            Settings { drive: Drive::Dac { low: 5, high: 4096 }, ..chirp },
            SettingsError::Waveform(WaveformError::Codes),
        ),
    ] {
        let refused = Err(Refusal::Settings(error.code()));
        assert_eq!(pico.request(Command::SetSettings(settings, N)).unwrap(), refused);
    }
}

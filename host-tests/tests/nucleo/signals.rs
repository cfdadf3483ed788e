//! Sums and bursts, each to the bit as this machine has it, and what the board refuses.

use super::several::longest_block;
use super::*;
use picket_claims::scenes::{Kind, line, records, tones};
use picket_dsp::accumulate::Accumulator;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::pipeline::BurstProcessor;
use picket_firmware::nucleo_f446re::words::sampling::BLOCK_CYCLES;
use picket_firmware::nucleo_f446re::words::{ADD_CYCLES, BURST_CYCLES, SUM_CYCLES};
use picket_host::device::Listener;
use picket_simulator::Passed;
use picket_wire::settings::Mode;
use picket_wire::settings_error::SettingsError;
use picket_wire::{burst, sum};

/// A wavelength, so that what is measured is a velocity, too.
fn doppler(mode: Mode, iq: bool) -> Settings {
    let settings = Settings::default();
    let scene = Scene::Doppler {
        wavelength_m: 1550e-9,
        angle_rad: 0.0,
        mixing: picket_dsp::Mixing::default(),
    };
    let config = Config { scene, rate_hz: 200e3, ..settings.config };
    Settings { mode, iq, config, ..settings }
}

/// The image with these settings.
fn begun(settings: &Settings) -> Board {
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let answer = board.request(Command::SetSettings(*settings, N)).unwrap();
    let answer = answer.unwrap_or_else(|refusal| panic!("{refusal}"));
    assert_eq!(Settings::from_bytes(&answer).unwrap().0.mode, settings.mode);
    assert!(boot(&mut board).measuring);
    board.recorded = Some(Vec::new());
    board
}

/// What was said since the settings.
fn heard(board: &Board) -> Listener {
    let mut listener = Listener::default();
    listener.read(board.recorded.as_deref().unwrap());
    listener
}

/// Noise as of a photodiode around the middle of the codes, with a weak tone of a new phase in each block.
fn weak<R: Record>(bin: f64, block: u64) -> [R::Sample; N] {
    let mut scene = tones(Kind::of::<R>(), N, [line(bin, 30.0)], 120.0);
    scene.converter.unsigned = true;
    samples::<R, N>(&mut scene.run(block).unwrap(), 0)
}

/// The bytes of samples as a converter delivers them.
fn delivered<R: Record>(samples: &[R::Sample; N]) -> Vec<u8> {
    let parts = samples.iter().map(|&sample| R::parts(sample));
    let parts = parts.flat_map(|parts| parts.into_iter().take(if R::IQ { 2 } else { 1 }));
    bytes(&parts.collect::<Vec<i16>>())
}

fn sums<R: Record>() {
    let mode = Mode::Accumulate { blocks: 25, drift_bins: 0.0 };
    let settings = doppler(mode, R::IQ);
    let mut board = begun(&settings);
    let mut here = Here::<R>::new(&settings);
    let mut sum = Accumulator::<R, N>::new(25).with_false_alarm(settings.config.false_alarm);
    let (bin, mut alone) = (200.37, 0);
    let (mut expected, mut said) = (Vec::new(), Vec::new());
    for number in 0..75 {
        let samples = weak::<R>(bin, number);
        assert!(board.block(&delivered::<R>(&samples)).unwrap());
        said.extend(board.turn().unwrap());
        let stamp = here.stamp(number, false);
        let mut record = here.record(stamp, &samples, Health::default());
        alone += u32::from(record.measurement.tone.verdict == Verdict::Good);
        let Some(added) = sum.add(&record.measurement, &here.pipeline) else { continue };
        record.measurement.tone = added.tone;
        record.measurement.result = here.pipeline.outcome(&added.tone);
        assert!(matches!(record.measurement.result, Outcome::Velocity(_)));
        expected.push(Said::Telemetry(record));
        let (sequence, blocks, ln_chance) = (number as u32, 25, added.ln_chance);
        expected.push(Said::Sum(sum::Sum { sequence, blocks, ln_chance }));
        let tone = added.tone;
        let off = (tone.frequency.bins(N) - bin) / (f64::from(tone.sigma) * N as f64);
        assert!(tone.verdict == Verdict::Good && off.abs() < 5.0, "{tone}");
    }
    said.extend(board.turn().unwrap());
    said.retain(|said| matches!(said, Said::Telemetry(_) | Said::Sum(_)));
    assert_eq!((said.len(), &said), (6, &expected));
    assert_eq!(heard(&board).missing, 0);
    println!("{alone} of 75 blocks alone can be used");
    let longest = longest_block(&mut board);
    // A sum that is never complete: what a block takes alone, by the first look.
    let mut settings = doppler(Mode::Accumulate { blocks: 1000, drift_bins: 0.0 }, R::IQ);
    settings.effort = Some(picket_dsp::Effort::LOOK);
    let mut board = begun(&settings);
    for number in 0..6 {
        assert!(board.block(&delivered::<R>(&weak::<R>(bin, number))).unwrap());
        board.turn().unwrap();
    }
    let block = longest_block(&mut board);
    fits(&mut board, if R::IQ { "with sums of I/Q blocks" } else { "with sums" });
    let kind = if R::IQ { "I/Q" } else { "real" };
    println!("{kind}: {block} instructions a block, {longest} with the sum's line");
    let of = |cycles: [u64; 2]| cycles[usize::from(R::IQ)] as f64;
    assert!(1.4 * f64::from(block) < of(BLOCK_CYCLES) + of(ADD_CYCLES));
    assert!(1.4 * f64::from(longest - block) < of(SUM_CYCLES));
    hold(
        &format!("board, instructions of {kind} blocks in a sum"),
        1.0,
        &[block.into(), longest.into()],
    );
}

/// What one block cannot show, the sum of 25 does, bit by bit as on this machine.
#[test]
fn sums_on_the_board_are_those_of_this_machine() {
    sums::<Real>();
    sums::<Iq>();
}

/// Particles in fringes, as light on a photodiode: bursts bit by bit as on this machine, the numbers without a gap, the lost blocks
/// told to the detector.
#[test]
fn bursts_on_the_board_are_those_of_this_machine() {
    let settings = doppler(Mode::Bursts(Trigger::default()), false);
    let mut board = begun(&settings);
    let here = Here::<Real>::new(&settings);
    let rate_hz = here.plan.settings.config.rate_hz;
    let mut processor = Box::new(BurstProcessor::<Real, N>::new(*here.pipeline.plan()));
    // Fringes of 200 um before particles of 4 m/s: 20 kHz, and an envelope whose deviation is an eighth of a record.
    let record_s = N as f64 / rate_hz;
    let particle = |number: u32| {
        let from = 12.0 + 4.25 * f64::from(number);
        scene::Particle {
            middle_s: (from * record_s..(from + 2.0) * record_s).into(),
            velocity_mps: Some((3.2..4.8).into()),
            ..scene::Particle::default()
        }
    };
    let particles = scene::Particles {
        fringe_m: 200e-6,
        radius_m: 5.1e-3,
        visibility: 0.7,
        at: (0..24).map(particle).collect(),
        amplitude: Some(280.0.into()),
        ..scene::Particles::default()
    };
    let blocks = 120u64;
    let mut scene = records(Kind::Real, N, vec![scene::Source::Particles(particles)], 20.0);
    (scene.rate_hz, scene.seconds) = (rate_hz, blocks as f64 * record_s);
    (scene.receiver.offset[0], scene.converter.unsigned) = ((1500.0 - 2048.0).into(), true);
    let mut run = scene.run(SEED).unwrap();
    let (mut valid, mut within, mut lost_blocks) = (0, 0, 0);
    let (mut expected, mut said) = (Vec::new(), Vec::new());
    for block in 0..blocks {
        let samples = samples::<Real, N>(&mut run, block as usize);
        // The converter overruns once, in the middle, with no block waiting.
        if block == blocks / 2 {
            said.extend(board.turn().unwrap());
            board.adc_overrun().unwrap();
            let counters = status(&mut board).counters;
            lost_blocks = counters.lost();
            assert!(lost_blocks > 0);
        }
        assert!(board.block(&bytes(&samples)).unwrap());
        said.extend(board.turn().unwrap());
        let stamp = here.stamp(block + u64::from(lost_blocks), false);
        let mut bursts = Vec::new();
        processor.block(&stamp, &samples, |burst| bursts.push(*burst));
        let (counters, number) = (*processor.counters(), expected.len() as u32);
        for (number, burst) in (number..).zip(bursts) {
            let result = here.pipeline.outcome(&burst.tone);
            let health = Health { lost: lost_blocks, faults: u32::from(lost_blocks > 0) };
            expected.push(Said::Burst(burst::Burst { number, burst, result, counters, health }));
            if burst.validation != picket_dsp::Validation::Valid {
                continue;
            }
            valid += 1;
            let shift = u64::from(lost_blocks) * N as u64;
            let time_s = (burst.arrival - shift as f64) / rate_hz;
            let away = |passed: &&Passed| (passed.middle_s - time_s).abs();
            let near = run.particles(0).iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let hertz = near.unwrap().velocity_mps / 200e-6;
            let off = (burst.tone.hertz() - hertz) / burst.tone.sigma_hertz();
            within += u32::from(off.abs() < 5.0);
        }
    }
    said.extend(board.turn().unwrap());
    said.retain(|said| matches!(said, Said::Telemetry(_) | Said::Burst(_)));
    let number = expected.len();
    assert_eq!((said.len(), &said), (number, &expected));
    println!("{number} bursts, {valid} valid, {within} within 5 sigma");
    assert!(valid >= 18 && within == valid, "{valid} {within}");
    let heard = heard(&board);
    assert_eq!((heard.records, heard.missing), (number as u64, 0));
    let longest = longest_block(&mut board);
    println!("{longest} instructions");
    fits(&mut board, "with bursts");
    let [most, _] = BURST_CYCLES;
    assert!(1.4 * f64::from(longest) < most as f64);
    hold("board, instructions of a burst", 1.0, &[longest.into()]);
    // By the crystal's clock.
    let held = |mode: Mode| {
        let tree = Tree::new(Speed::Mhz180, Source::HsePll);
        let rate = (1..1500).rev().find(|&kilohertz| {
            let config = Config { rate_hz: 1e3 * f64::from(kilohertz), ..settings.config };
            let settings = Settings { config, slots: 8, mode, ..settings };
            Words::plan::<N>(&settings, &tree).is_ok()
        });
        f64::from(rate.unwrap())
    };
    let sums = Mode::Accumulate { blocks: 100, drift_bins: 0.0 };
    hold("board, kS/s with sums and with bursts", 1.0, &[held(sums), held(settings.mode)]);
}

/// Settings that go with no sum and no burst.
#[test]
fn what_is_no_sum_and_no_burst_is_refused() {
    let told = |board: &mut Board, settings: &Settings| {
        board.request(Command::SetSettings(*settings, N)).unwrap().unwrap_err()
    };
    let bursts = Mode::Bursts(Trigger::default());
    let (mut board, _) = start();
    let code = SettingsError::Mode.code();
    let mut chirp = doppler(bursts, false);
    chirp.config.scene = Scene::Chirp(Chirp {
        shape: Shape::Triangle,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 1.0,
        ..Chirp::default()
    });
    chirp.drive = Drive::Dac { low: 0, high: 4095 };
    let accumulate = |blocks, drift_bins| doppler(Mode::Accumulate { blocks, drift_bins }, true);
    let ratio = Some(1.0);
    for settings in [
        chirp,
        accumulate(0, 0.0),
        accumulate(65_537, 0.0),
        accumulate(2, f32::NAN),
        doppler(Mode::Bursts(Trigger { ratio, ..Trigger::default() }), false),
    ] {
        assert_eq!(told(&mut board, &settings), Refusal::Settings(code), "{:?}", settings.mode);
    }
}

//! Several tones of a block, and a fundamental.

use super::*;
use picket_dsp::solve::chirp::Mixing;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_firmware::nucleo_f446re::words::HARMONICS_CYCLES;
use picket_host::device::Listener;
use picket_wire::fundamental::Fundamental;
use picket_wire::settings_error::{RateError, SettingsError};

/// The longest block since the bytes of the board are recorded. Each status tells the longest since the one before, and one comes
/// each second by itself.
pub fn longest_block(board: &mut Board) -> u32 {
    status(board);
    let recorded = board.recorded.take().unwrap();
    let said = Listener::default().read(&recorded);
    let told = said.into_iter().filter_map(|said| match said {
        Said::Status(status) => Some(status.longest),
        _ => None,
    });
    told.max().unwrap()
}

/// All tones to the bit, as many as there are and as were asked for.
#[test]
fn several_tones_of_a_block_are_those_of_this_machine() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let scenes: [&[(f64, f64)]; 3] = [
        &[(200.3, 900.0)],
        &[(100.4, 400.0), (131.9, 900.0)],
        &[(60.2, 700.0), (63.4, 500.0), (300.7, 100.0)],
    ];
    let mut longest = Vec::new();
    for most in [4, 2, 1] {
        let settings = Settings { most, ..with_rounds() };
        let answer = board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
        assert_eq!(Settings::from_bytes(&answer).unwrap().0.most, most);
        assert!(boot(&mut board).measuring);
        let mut here = Here::<Real>::new(&settings);
        board.recorded = Some(Vec::new());
        for (number, scene) in scenes.iter().cycle().take(9).enumerate() {
            let samples = tones(scene, 10.0, &mut rng);
            assert!(board.block(&bytes(&samples)).unwrap());
            let stamp = here.stamp(number as u64, false);
            let expected = here.record(stamp, &samples, Health::default());
            let record = board.expect(|said| match said {
                Said::Telemetry(record) => Some(record),
                Said::Lines(_) => panic!("the tones of a block that was not measured"),
                _ => None,
            });
            assert_eq!(record.unwrap().to_bytes(), expected.to_bytes(), "block {number}");
            if most == 1 {
                continue;
            }
            let lines = board.expect(|said| match said {
                Said::Lines(lines) => Some(lines),
                _ => None,
            });
            let lines = lines.unwrap_or_else(|error| panic!("{error}"));
            let found = here.pipeline.lines(&expected.measurement, most.into());
            assert_eq!(found.len(), scene.len().min(most.into()), "block {number}");
            assert!(found.is_sorted_by(|a, b| a.tone.amplitude >= b.tone.amplitude));
            assert_eq!(
                lines.to_frame(),
                Lines::from_tones(&stamp, found).to_frame(),
                "block {number}"
            );
        }
        longest.push(longest_block(&mut board));
    }
    println!("{longest:?} instructions");
    fits(&mut board, "with four tones");
    let longest: Vec<f64> = longest.into_iter().map(f64::from).collect();
    hold("board, instructions of blocks of 4, 2 and 1 tones", 1.0, &longest);
}

/// The whole error of a velocity stands beside its sigma, and is not less than what the settings say is not known.
#[test]
fn the_whole_error_stands_beside_sigma() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut board = Board::start(played()).unwrap();
    boot(&mut board);
    let (wavelength_m, angle_rad) = (0.0125, 0.5);
    let scene = Scene::Doppler { wavelength_m, angle_rad, mixing: Mixing::RxConjTx };
    let known = Uncertainty {
        clock_ppm: 30.0,
        carrier_ppm: 40.0,
        angle_rad: 0.01,
        ..Uncertainty::default()
    };
    let config = Config { scene, ..with_rounds().config };
    let settings = Settings { config, uncertainty: Some(known), ..with_rounds() };
    let negative = Uncertainty { clock_ppm: -1.0, ..known };
    let refused = Settings { uncertainty: Some(negative), ..settings };
    let refusal = board.request(Command::SetSettings(refused, N)).unwrap();
    assert_eq!(refusal, Err(Refusal::Settings(SettingsError::Calibration.code())));
    let answer = board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert_eq!(Settings::from_bytes(&answer).unwrap().0.uncertainty, Some(known));
    assert!(boot(&mut board).measuring);
    let mut here = Here::<Real>::new(&settings);
    for number in 0..3 {
        let samples = tone(200.3, 900.0, 30.0, &mut rng);
        assert!(board.block(&bytes(&samples)).unwrap());
        let expected = here.record(here.stamp(number, false), &samples, Health::default());
        let record = next_record(&mut board);
        assert_eq!(record.to_bytes(), expected.to_bytes(), "block {number}");
        let (total, tone) = (record.uncertainty.unwrap(), record.measurement.tone);
        let Outcome::Velocity(answer) = record.measurement.result else { panic!("{record:?}") };
        let velocity = answer.velocity.to_num::<f64>();
        // 50 ppm of clock and carrier; tan(0.5) = 0.546302 for each radian of the angle, and 1 + 2 tan^2 = 1.596892 for its square.
        let parts = [50e-6, 0.546302 * 0.01, 1.596892 * 1e-4 / 2f64.sqrt()];
        let squares: f64 = parts.iter().map(|part| (part * velocity).powi(2)).sum();
        let whole = (squares + f64::from(answer.sigma).powi(2)).sqrt();
        assert!((f64::from(total.velocity) / whole - 1.0).abs() < 1e-4, "{total:?} {whole}");
        let clock = 30e-6 * 200.3 / N as f64;
        let whole = (f64::from(tone.sigma).powi(2) + clock * clock).sqrt();
        assert!((f64::from(total.frequency) / whole - 1.0).abs() < 1e-4, "{total:?} {whole}");
        assert_eq!(total.range, 0.0);
    }
}

/// The board finds the fundamental of a motor ten times weaker than its harmonics, to the bit as this machine does.
#[test]
fn a_fundamental_is_that_of_this_machine() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let settings = Settings { harmonics: 15, ..with_rounds() };
    let answer = board.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert_eq!(Settings::from_bytes(&answer).unwrap().0.harmonics, 15);
    assert!(boot(&mut board).measuring);
    let mut here = Here::<Real>::new(&settings);
    board.recorded = Some(Vec::new());
    // The edges of two slow squares have the most orders, which fold.
    for number in 0..8 {
        // In two blocks as many lines as are sought, and more.
        let (bin, count) = (rng.random_range(20.0..50.0), if number < 4 { 4 } else { 10 });
        let (square, bin) = (number >= 6, if number >= 6 { 0.2 * bin } else { bin });
        let series = [80.0, 500.0, 400.0, 200.0, 150.0, 120.0, 100.0, 90.0, 70.0, 60.0];
        let series: Vec<(f64, f64)> = series
            .into_iter()
            .zip(1..=count)
            .map(|(amplitude, order)| (f64::from(order) * bin, amplitude))
            .collect();
        let mut samples = tones(if square { &[] } else { &series }, 10.0, &mut rng);
        if square {
            for (n, sample) in samples.iter_mut().enumerate() {
                let high = (n as f64 * bin / N as f64).fract() < 0.5;
                *sample += if high { 800 } else { -800 };
            }
        }
        assert!(board.block(&bytes(&samples)).unwrap());
        let stamp = here.stamp(number, false);
        let expected = here.record(stamp, &samples, Health::default());
        let fundamental = board.expect(|said| match said {
            Said::Fundamental(fundamental) => Some(fundamental),
            _ => None,
        });
        let fundamental = fundamental.unwrap();
        let harmonic = here.pipeline.harmonic(&expected.measurement, 15).unwrap();
        assert_eq!(fundamental, Fundamental::from_harmonic(&stamp, harmonic), "block {number}");
        let tone = &fundamental.harmonic.tone;
        let off = tone.frequency.bins(N) - bin;
        assert!(off.abs() < 5.0 * f64::from(tone.sigma) * N as f64, "{off} bins: {fundamental:?}");
        let seen = if square { 0b101 } else { 0b110 };
        assert_eq!(fundamental.harmonic.orders & seen, seen, "{fundamental:?}");
        // Lines beyond those that are sought stay in what is left, which may show.
        assert!(count > 4 || tone.verdict == Verdict::Good, "{fundamental:?}");
    }
    let longest = f64::from(longest_block(&mut board));
    println!("{longest} instructions");
    let [block, _] = BLOCK_CYCLES;
    assert!(1.4 * longest < (block + HARMONICS_CYCLES) as f64);
    hold("board, instructions of a block of harmonics", 1.0, &[longest]);
}

/// The fastest rates with so many tones a block: a step faster is refused with the reason, and fewer tones would do.
#[test]
fn rates_at_which_several_tones_take_longer_than_a_block_are_refused() {
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    let held = |settings: Settings, rate_hz: f64| {
        let config = Config { rate_hz, ..settings.config };
        let settings = Settings { core_mhz: 180, config, ..settings };
        Words::plan::<N>(&settings, &tree).map(|(plan, _)| plan.settings.config.rate_hz)
    };
    let fastest = |settings: Settings| {
        let rates = (1..1500).rev().map(|kilohertz| 1e3 * f64::from(kilohertz));
        rates.into_iter().find(|&rate_hz| held(settings, rate_hz).is_ok()).unwrap()
    };
    let several = |most| Settings { most, ..Settings::default() };
    let refused = Err(SettingsError::Rate(RateError::Load));
    assert!(SettingsError::Rate(RateError::Load).to_string().contains("most"));
    let rates = [4, 2].map(|most| {
        let rate_hz = fastest(several(most));
        assert_eq!(held(several(most), 1.03 * rate_hz), refused, "{most} at {rate_hz}");
        assert!(held(several(most - 1), 1.03 * rate_hz).is_ok(), "{most} at {rate_hz}");
        rate_hz
    });
    let harmonics = Settings { harmonics: 10, ..Settings::default() };
    let slowest = fastest(harmonics);
    assert_eq!(held(harmonics, 1.03 * slowest), refused);
    let kilohertz = [rates[0], rates[1], slowest].map(|rate_hz| rate_hz / 1e3);
    hold("board, kS/s with 4 tones, with 2 and with harmonics", 1.0, &kilohertz);
}

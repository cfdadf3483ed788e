//! The NUCLEO's real image from power-on, on rsemu's model of the chip with converters of our own (`host-tests/rsemu`): what a
//! board would show at its first power-up.
//!
//! Each test has a short form. `PICKET_LONG=1 cargo test -p host-tests --test rsemu` runs the long ones.

#[path = "rsemu/board.rs"]
mod board;
#[path = "rsemu/source.rs"]
mod source;

use board::{Emulated, Sectors, file};
use picket::acquire::sample::{Real, Segment};
use picket::config::{Config, Scene};
use picket::pipeline::Pipeline;
use picket::plan::Plan as Terms;
use picket::solve::chirp::Shape;
use picket_firmware::nucleo_f446re::N;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_wire::boot::Clock;
use picket_wire::command::{Command, Refusal};
use picket_wire::settings::{Drive, Settings};

/// The short or the long form's number.
fn sized(short: u64, long: u64) -> u64 {
    if std::env::var_os("PICKET_LONG").is_some() { long } else { short }
}

fn tone(rate_hz: f64) -> Settings {
    let settings = Settings::default();
    Settings { config: Config { rate_hz, ..settings.config }, ..settings }
}

const DAC: Drive = Drive::Dac { low: 400, high: 3600 };

fn chirp(rate_hz: f64, shape: Shape, guard: u16, drive: Drive) -> Settings {
    let scene = Scene::Chirp { shape, wavelength_m: 0.0125, bandwidth_hz: 200e6, duration_s: 0.0 };
    let settings = tone(rate_hz);
    Settings { config: Config { scene, ..settings.config }, guard, drive, ..settings }
}

fn words(settings: &Settings) -> Words {
    let speed = Speed::of_mhz(settings.core_mhz).unwrap();
    Words::plan::<N>(settings, &Tree::new(speed, Source::HsePll)).unwrap().1
}

#[test]
fn it_starts_by_the_crystal_and_measures() {
    let Some((mut board, boot)) = Emulated::start(&tone(500e3)) else { return };
    assert_eq!((boot.clock, boot.core_hz), (Clock::External, 180_000_000));
    assert!(boot.measuring && boot.stored && !boot.unfit, "{boot:?}");
    board.run(20_000);
    assert!(!board.telemetry().is_empty());
    // APB1 a quarter, APB2 a half, by the multiplier (RM 6.3.3).
    assert_eq!(board.read(0x4002_3808), 0x940A);
    // CSSON.
    assert_eq!(board.read(0x4002_3800) >> 19 & 1, 1);
    board.assert_rules();
}

/// Settings that were not saved live until the second reset, and each start is told with its cause.
#[test]
fn it_restarts_twice_in_a_row() {
    let Some((mut board, _)) = Emulated::start(&tone(500e3)) else { return };
    board.request(Command::SetSettings(tone(250e3), N)).unwrap();
    for (stored, rate_hz) in [(false, 250e3), (true, 500e3), (true, 500e3)] {
        let boot = board.boot();
        assert_eq!((boot.causes.message(), boot.stored, boot.last.kind), ("software", stored, 0));
        assert!(boot.measuring && boot.clock == Clock::External, "{boot:?}");
        let body = board.request(Command::GetSettings).unwrap();
        let (settings, _) = Settings::of_bytes(body.as_slice().try_into().unwrap()).unwrap();
        assert!((settings.config.rate_hz - rate_hz).abs() < 1.0, "{settings:?}");
        board.request(Command::Reboot).unwrap();
    }
    assert_eq!(board.resets.len(), 3);
    board.assert_rules();
}

/// Without blocks nothing but the timer's interrupt wakes the core, and the watchdog must not bite.
#[test]
fn it_stays_up_without_blocks() {
    let stopped = Settings { start: false, ..tone(500e3) };
    let external = chirp(500e3, Shape::Trapezoid, 32, Drive::External);
    let unfit = Settings { guard: 40, ..tone(500e3) };
    for (name, settings) in
        [("stopped", stopped), ("unfit", unfit), ("external", external), ("100 S/s", tone(100.0))]
    {
        let Some(mut board) = Emulated::plug() else { return };
        // It sleeps nearly all the time.
        board.order("quantum 1000");
        let mut sectors = Sectors::new();
        sectors.save(&settings);
        board.load(&sectors);
        let (mut board, boot) = board.power();
        assert_eq!(boot.unfit, name == "unfit");
        board.run(sized(4, 60) * 1_000_000 + 500_000);
        assert_eq!(board.resets, [], "{name}");
    }
}

/// A block that is overdue stops the feeding: the converter's clock is stopped behind the program's back.
#[test]
fn the_watchdog_bites_when_blocks_stay_away() {
    let Some((mut board, _)) = Emulated::start(&tone(500e3)) else { return };
    // TIM3's counter.
    board.write(0x4000_0400, 0);
    while board.resets.is_empty() && board.now < 8_000_000 {
        board.run(10_000);
    }
    let (at, cause) = board.resets.first().expect("it waits for ever").clone();
    assert_eq!(cause, "watchdog");
    // A second of patience and the watchdog's four.
    assert!((4_500_000..6_500_000).contains(&at), "{at}");
}

/// The two sectors after a save, whatever the flash does to the core meanwhile.
#[test]
fn settings_are_saved_in_every_state() {
    for (name, settings) in [
        ("stopped", Settings { start: false, ..tone(500e3) }),
        ("measuring", tone(500e3)),
        ("slow", tone(100.0)),
    ] {
        // All of them only in the long form.
        let stalls: &[bool] = match (name, sized(0, 1)) {
            (_, 1) => &[false, true],
            ("stopped", _) => &[false],
            ("measuring", _) => &[true],
            _ => &[],
        };
        for &stall in stalls {
            let Some(mut board) = Emulated::plug() else { return };
            // The longest erasure (data sheet, table 48), and a short one.
            board.order(&format!("erase {}", sized(150, 2000)));
            board.order(&format!("stall {}", u8::from(stall)));
            let (mut board, _) = board.power();
            board.request(Command::SetSettings(settings, N)).unwrap();
            board.boot();
            let saved = board.request(Command::Save);
            assert_eq!(saved, Ok(vec![]), "{name}, stall {stall}");
            let resets: Vec<_> =
                board.resets.iter().filter(|(_, cause)| cause == "watchdog").collect();
            assert_eq!(resets, Vec::<&(u64, String)>::new(), "{name}, stall {stall}");
            let sectors = board.sectors();
            assert_eq!(
                sectors.settings().map(|s| s.config.rate_hz.round()),
                Some(settings.config.rate_hz),
                "{name}"
            );
        }
    }
}

/// The label of a block's segment, as the DAC's codes in it say.
fn played(codes: &[u16]) -> Segment {
    let (first, last) = (codes[0], codes[N - 1]);
    match first.cmp(&last) {
        std::cmp::Ordering::Less => Segment::Up,
        std::cmp::Ordering::Equal => Segment::Flat,
        std::cmp::Ordering::Greater => Segment::Down,
    }
}

#[test]
fn after_a_save_the_segments_are_right_and_the_loss_is_exact() {
    // Remainders of blocks and chirps.
    let erasures: &[u64] =
        if sized(0, 1) == 0 { &[98, 99] } else { &[97, 98, 99, 500, 1000, 2000] };
    for &erase_ms in erasures {
        let settings = chirp(500e3, Shape::Trapezoid, 32, DAC);
        let Some(mut board) = Emulated::plug() else { return };
        board.order(&format!("erase {erase_ms}"));
        let mut sectors = Sectors::new();
        sectors.save(&Settings { report_every: 2, ..settings });
        board.load(&sectors);
        let (mut board, _) = board.power();
        board.request(Command::SetSettings(settings, N)).unwrap();
        board.boot();
        board.order("input 0 dac");
        board.run(5_000);
        let begun = board.now;
        for _ in 0..3 {
            let (measurement, codes) = board.capture();
            assert_eq!(measurement.stamp.segment, played(&codes), "before, {erase_ms} ms");
        }
        let before = board.status();
        let sequence = board.capture().0.stamp.sequence;
        let at = board.now;
        board.request(Command::Save).unwrap();
        board.run(10_000);
        for _ in 0..4 {
            let (measurement, codes) = board.capture();
            assert_eq!(measurement.stamp.segment, played(&codes), "after, {erase_ms} ms");
        }
        let after = board.status();
        let (last, _) = board.capture();
        // Blocks of 1056 samples pass with the time, whoever looks; a chirp has three.
        let passed = f64::from(last.stamp.sequence - sequence);
        let expected = (board.now - at) as f64 * 1e-6 * 500e3 / 1056.0;
        assert!((passed - expected).abs() < 6.0, "{erase_ms} ms: {passed} {expected}");
        let lost = after.counters.lost() - before.counters.lost();
        let shortest = erase_ms as f64 * 1e-3 * 500e3 / 1056.0;
        assert!((f64::from(lost) - shortest).abs() < 8.0, "{erase_ms} ms: {lost} {shortest}");
        board.assert_rules();
        assert_eq!(after.counters.faults(), 0, "{after:?}");
        assert!(begun < at);
    }
}

/// The power goes at moments spread over a save: then either the old settings or the new ones.
#[test]
fn power_may_go_during_a_save() {
    let (old, new) = (tone(500e3), tone(250e3));
    let moments = sized(2, 64);
    let mut seen = [0, 0];
    for moment in 0..moments {
        let Some(mut board) = Emulated::plug() else { return };
        board.order("erase 20");
        let mut sectors = Sectors::new();
        sectors.save(&old);
        board.load(&sectors);
        let (mut board, _) = board.power();
        board.request(Command::SetSettings(new, N)).unwrap();
        board.boot();
        let request = picket_wire::command::Request { tag: 9, command: Command::Save };
        board.hear(&request.to_frame());
        // The order takes 0.2 ms on the line, the erasure 20 ms, the words some 50.
        board.run(100 + 22_000 * moment / (moments - 1));
        let (board, boot) = board.power();
        assert!(boot.stored && !boot.unfit && boot.measuring, "moment {moment}: {boot:?}");
        let mut board = board;
        let body = board.request(Command::GetSettings).unwrap();
        let rate =
            Settings::of_bytes(body.as_slice().try_into().unwrap()).unwrap().0.config.rate_hz;
        let place = [old, new].iter().position(|s| (s.config.rate_hz - rate).abs() < 1.0);
        seen[place.unwrap_or_else(|| panic!("moment {moment}: {rate}"))] += 1;
    }
    println!("old {}, new {}", seen[0], seen[1]);
    assert!(seen[0] > 0 && seen[1] > 0, "{seen:?}");
}

/// The DAC plays the table, each code once a chirp, at even distances.
#[test]
fn a_chirp_is_played_code_by_code() {
    let rates: &[f64] =
        if sized(0, 1) == 0 { &[500e3] } else { &[100e3, 500e3, 1e6, 1.5e6, 1.6e6] };
    for &rate in rates {
        for guard in [0, 32] {
            let core_mhz = if rate > 1.5e6 { 144 } else { 180 };
            let settings =
                Settings { core_mhz, report_every: 20, ..chirp(rate, Shape::Sawtooth, guard, DAC) };
            let Some((mut board, boot)) = Emulated::start(&settings) else { return };
            assert!(boot.measuring, "{rate}, guard {guard}");
            let wave = words(&settings).waveform.unwrap();
            board.order("keep 1");
            board.run((5.0 * f64::from(1024 + guard) / rate * 1e6) as u64);
            let codes = board.pairs("codes");
            assert!(codes.len() > 4 * wave.len(), "{rate}, guard {guard}: {} codes", codes.len());
            let table: Vec<u32> = (0..wave.len()).map(|step| wave.code(step).into()).collect();
            let first = table.iter().position(|code| *code == codes[0].1).unwrap();
            for (n, (_, code)) in codes.iter().enumerate() {
                assert_eq!(
                    *code,
                    table[(first + n) % table.len()],
                    "{rate}, guard {guard}, code {n}"
                );
            }
            // A step lasts `hold` samples; the first bus has half of the timers' rate.
            let ticks =
                u64::from(wave.hold) * u64::from(words(&settings).sampling.period.ticks()) / 2;
            for pair in codes.windows(2) {
                assert!(
                    (pair[1].0 - pair[0].0).abs_diff(ticks) <= 1,
                    "{rate}, guard {guard}: {pair:?} {ticks}"
                );
            }
            assert_eq!(board.status().counters.faults(), 0);
            board.assert_rules();
        }
    }
}

/// After each overrun the next chirp is met at its first sample.
#[test]
fn an_external_chirp_is_met_anew_after_each_overrun() {
    let settings =
        Settings { report_every: 30, ..chirp(500e3, Shape::Trapezoid, 32, Drive::External) };
    let Some((mut board, _)) = Emulated::start(&settings) else { return };
    // Ticks of the second bus since the pulse, 180 a sample.
    board.order("input 0 pulse 180");
    // A pulse of 1 ms every 8 ms: PSC, ARR, CCR1, CCMR1 PWM 1, CCER, EGR, CR1.
    for (at, word) in
        [(0x28, 7), (0x2C, 7999), (0x34, 1000), (0x18, 0x60), (0x20, 1), (0x14, 1), (0, 1)]
    {
        board.write(0x4000_1000 + at, word);
    }
    board.run(20_000);
    for round in 0..sized(4, 100) {
        // A chirp lasts 6.3 of the 8 ms: the overrun comes anywhere in it.
        board.run(8_000 + 731 * (round % 11));
        board.order("overrun");
        board.run(9_000);
        let (measurement, codes) = board.capture();
        let segment = match measurement.stamp.segment {
            Segment::Up => 0,
            Segment::Flat => 1,
            Segment::Down => 2,
            Segment::Continuous => panic!("a chirp"),
        };
        let first = 1056 * segment + 32;
        for (n, code) in codes.iter().enumerate() {
            // From the pulse to the first result pass a sample, and the conversion.
            let late = i64::from(*code) - (first + n as i64);
            assert!((0..=3).contains(&late), "round {round}, sample {n}: {late}");
        }
    }
    board.assert_rules();
}

/// The sync output rises with the first sample of each chirp, and at no other time.
#[test]
fn the_sync_output_has_an_edge_a_chirp() {
    let settings = Settings { report_every: 9, ..chirp(500e3, Shape::Trapezoid, 32, DAC) };
    let Some((mut board, _)) = Emulated::start(&settings) else { return };
    for round in 0..sized(4, 20) {
        board.pairs("edges");
        // The output is low for two thirds of a chirp, high for the first.
        board.run(1_700 + 1_310 * (round % 7));
        board.order("overrun");
        board.run(30_000);
        let edges = board.pairs("edges");
        // 90 MHz; a segment has 1056 samples of 180 ticks, a chirp three.
        let (segment, chirp) = (1056 * 180, 3 * 1056 * 180);
        let rises: Vec<u64> =
            edges.iter().filter(|(_, high)| *high == 1).map(|(at, _)| *at).collect();
        let falls: Vec<u64> =
            edges.iter().filter(|(_, high)| *high == 0).map(|(at, _)| *at).collect();
        let mut uneven = 0;
        for pair in rises.windows(2) {
            uneven += u32::from((pair[1] - pair[0]).abs_diff(chirp) > 90);
        }
        // The restart shifts the chirps once.
        assert!(uneven <= 1, "{edges:?}");
        for rise in &rises[1..] {
            if let Some(fall) = falls.iter().find(|fall| *fall > rise) {
                assert!((fall - rise).abs_diff(segment) <= 90, "{edges:?}");
            }
        }
    }
}

/// Codes of a converter: a tone over a table whose length has no factor in common with a block's.
fn table(amplitude: f64) -> Vec<u16> {
    let length = 8191;
    let code = |n: usize| {
        let angle = std::f64::consts::TAU * 1013.0 * n as f64 / length as f64;
        let noise = ((n * 7919) % 61) as f64 - 30.0;
        (2048.0 + amplitude * angle.sin() + noise).round().clamp(0.0, 4095.0) as u16
    };
    (0..length).map(code).collect()
}

/// Blocks without a pause, each measured to the bit. Returns what the board says at the end.
fn stream(settings: &Settings, codes: &[u16], blocks: u64) -> Option<picket_wire::status::Status> {
    let mut board = Emulated::plug()?;
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    board.order(&format!("input 0 table {}", file(&bytes).display()));
    let mut sectors = Sectors::new();
    sectors.save(settings);
    board.load(&sectors);
    let (mut board, boot) = board.power();
    assert!(boot.measuring);
    let speed = Speed::of_mhz(settings.core_mhz).unwrap();
    let (plan, _) = Words::plan::<N>(settings, &Tree::new(speed, Source::HsePll)).unwrap();
    let mut pipeline = Pipeline::<Real, N>::new(Terms::of_terms(*plan.plan).unwrap());
    let time = blocks as f64 * N as f64 / settings.config.rate_hz;
    let mut left = (time * 1e6) as u64;
    let mut seen = 0;
    while left > 0 {
        let piece = left.min(100_000);
        board.run(piece);
        left -= piece;
        for record in board.telemetry() {
            let stamp = record.measurement.stamp;
            let from = stamp.clock as usize;
            let samples = std::array::from_fn(|n| codes[(from + n) % codes.len()] as i16);
            let mut expected = pipeline.block(stamp, &samples);
            settings.calibration.apply(&mut expected);
            assert_eq!(record.measurement, expected, "block {}", stamp.sequence);
            seen += 1;
        }
    }
    let status = board.status();
    println!(
        "{:.2} MS/s: {seen} records right of {} blocks, {} lost; awake {} permille, the longest block {}",
        settings.config.rate_hz / 1e6,
        status.counters.blocks,
        status.counters.lost(),
        status.load,
        status.peak
    );
    assert!(seen > 0);
    board.assert_rules();
    Some(status)
}

#[test]
fn no_block_is_lost_at_one_and_a_half_million_samples_a_second() {
    let blocks = sized(100, 10_000);
    // Blocks that clip take four times as long.
    for (rate_hz, amplitude, share) in [(1.5e6, 900.0, 1), (400e3, 6000.0, 4)] {
        let settings = Settings { report_every: 3, ..tone(rate_hz) };
        let Some(status) = stream(&settings, &table(amplitude), blocks / share) else { return };
        assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0), "{status:?}");
        assert!(u64::from(status.counters.blocks) >= blocks / share - 2);
    }
}

/// What the settings allow is measured without a loss, and what is faster is refused: `sampling::BLOCK_CYCLES`.
#[test]
fn the_fastest_rate_that_is_not_refused_holds() {
    let settings = Settings { report_every: 3, core_mhz: 144, slots: 8, ..tone(1.6e6) };
    let blocks = sized(60, 2_000);
    let Some(status) = stream(&settings, &table(900.0), blocks) else { return };
    assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0), "{status:?}");
    let faster = Settings { core_mhz: 144, ..tone(2.4e6) };
    let (mut board, _) = Emulated::start(&settings).unwrap();
    let refused = board.request(Command::SetSettings(faster, N));
    assert_eq!(refused, Err(Refusal::Settings([3, 2])));
}

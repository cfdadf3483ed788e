//! The Pico's real image on other people's emulator of its chip (`rp2040js`, `host/rp2040`): the whole signal path, from the
//! converter's queue by DMA and interrupt to records on the line.
//!
//! Each test has a short form. `PICKET_LONG=1 cargo test --test pico --release` runs the long ones.

#[path = "pico/chirp.rs"]
mod chirp;
#[path = "pico/demo.rs"]
mod demo;
#[path = "pico/faults.rs"]
mod faults;
#[path = "pico/latency.rs"]
mod latency;
#[path = "pico/pairs.rs"]
mod pairs;
#[path = "pico/pulses.rs"]
mod pulses;
#[path = "pico/scene.rs"]
mod scene;
#[path = "pico/self_test.rs"]
mod self_test;
#[path = "pico/usb.rs"]
mod usb;

use host_tests::figures::hold;
use host_tests::sized;
use picket_firmware::pico::N;
use picket_host::pico::bench::Pico;
use picket_host::rates;
use picket_wire::boot::{Clock, Origin};
use picket_wire::command::{Command, Refusal};
use picket_wire::settings::Settings;
use picket_wire::settings_error::{RateError, SettingsError};
use scene::{Hard, expected, frames, plug, settings, status, stream};

/// Measures so many blocks, of which one in `hard_one_in` takes longest, and holds every record against the host's. None is lost.
fn compare(blocks: u64, hard_one_in: Option<u64>, seed: u64) -> (Pico, Vec<u32>) {
    let samples = stream(blocks as usize, hard_one_in.map(|every| (every, Hard::Mixed)), seed);
    let mut pico = plug();
    pico.samples(&samples).unwrap();
    let boot = pico.power().unwrap();
    assert_eq!(
        (boot.board.as_str(), boot.clock, boot.core_hz),
        ("pico", Clock::External, 144_000_000)
    );
    assert!(boot.measuring && !boot.unfit && boot.n == N as u32, "{boot:?}");
    assert_eq!(boot.program, scene::program());
    pico.zero().unwrap();
    scene::measure(&mut pico, blocks);
    let wanted = expected(&settings(), &samples);
    let records = frames(&pico.sent);
    for ((sequence, frame), number) in records.iter().zip(0..) {
        assert_eq!(*sequence, number, "lost before record {number}, seed {seed}");
        let wanted = &wanted[*sequence as usize % wanted.len()];
        let pair = [frame, wanted].map(|frame| scene::record(frame));
        assert!(frame == wanted, "block {sequence} differs, seed {seed}: {pair:#?}");
    }
    assert!(records.len() as u64 >= blocks);
    (pico, records.into_iter().map(|(sequence, _)| sequence).collect())
}

/// Gapless at 500 kS/s and the default clock; the core sleeps a fifth of the time. Where the linker puts the code moves the load by .3 %, at
/// the same cycles.
#[test]
fn every_record_is_the_hosts_and_none_is_lost() {
    let blocks = sized(100, 10_000);
    let (mut pico, records) = compare(blocks, None, 18);
    let figures = pico.figures().unwrap();
    let status = status(&mut pico);
    println!(
        "{} records byte for byte, load {:.1} %, {:.0} cycles and {:.2} exceptions a block, longest measurement {} us, \
         queue at most {}, samples without a place {}, stack {} B",
        records.len(),
        100.0 * figures.load(),
        figures.cycles / records.len() as f64,
        figures.entries / records.len() as f64,
        status.longest,
        figures.level,
        figures.overruns,
        status.stack
    );
    assert_eq!((status.counters.lost(), status.counters.faults(), status.dropped), (0, 0, 0));
    assert!(figures.level <= 2 && figures.overruns == 0, "{figures:?}");
    assert!(figures.load() <= 0.8, "{figures:?}");
    assert_eq!((figures.core_hz, figures.baud), (144e6, 921_600.0));
}

/// Blocks that take longer than their time wait in the spare slots.
#[test]
fn one_hard_block_in_ten_waits_in_the_spare_slots() {
    let blocks = sized(30, 5_000);
    let (mut pico, _) = compare(blocks, Some(10), 19);
    let (figures, status) = (pico.figures().unwrap(), status(&mut pico));
    println!("load {:.1} %, longest {} us of 2048", 100.0 * figures.load(), status.longest);
    assert!(status.longest > 2_048, "no block is hard: {status:?}");
    assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0));
    assert!(figures.level <= 2 && figures.overruns == 0, "{figures:?}");
}

/// Where all blocks are hard, the rest is dropped and counted: no record is wrong.
#[test]
fn where_all_blocks_are_hard_the_losses_are_counted() {
    let kinds = [Hard::Moving, Hard::Drifting, Hard::Clipped, Hard::Noise, Hard::Constant];
    for &hard in kinds.iter().take(sized(2, 5) as usize) {
        let mut pico = plug();
        let samples = stream(64, Some((1, hard)), 20);
        pico.samples(&samples).unwrap();
        pico.power().unwrap();
        pico.run(1_000 * sized(100, 10_000)).unwrap();
        let status = status(&mut pico);
        let records = frames(&pico.sent);
        let wanted = expected(&settings(), &samples);
        for ((sequence, frame), count) in records.iter().zip(0..) {
            let number = *sequence as usize % wanted.len();
            let (got, want) = (scene::measured(frame), scene::measured(&wanted[number]));
            assert!(got == want, "{hard:?} {sequence}: {got:?}, not {want:?}");
            let told = scene::record(frame).unwrap().health;
            assert_eq!((told.lost, told.faults), (sequence - count, 0), "{hard:?} {sequence}");
        }
        println!(
            "{hard:?}: {} records of {} blocks, {} dropped, longest {} us",
            records.len(),
            status.counters.filled(),
            status.counters.overruns,
            status.longest
        );
        assert!(!records.is_empty() && status.counters.filled() > 40);
        let dropped = f64::from(status.counters.overruns) / f64::from(status.counters.filled());
        let most = if hard == Hard::Drifting { 0.9 } else { 0.25 };
        assert!(dropped <= most, "{hard:?}: {dropped}");
        assert_eq!(status.counters.lost(), status.counters.overruns);
        assert_eq!(status.counters.faults(), 0);
    }
}

/// At the rates that are said to hold whatever the signal is, none is lost where every block has a tone that moves beside a drift, which
/// takes longest.
#[test]
fn tones_that_move_beside_a_drift_hold_a_slower_rate() {
    let [real, _] = rates::pico();
    for (effort, rate_hz) in real.always_hz {
        let mut pico = plug();
        let blocks = sized(20, 5_000);
        // They come again and again, at a place in the sequence that tells which.
        let samples = stream(61, Some((1, Hard::Drifting)), 23);
        pico.power().unwrap();
        let mut slow = settings();
        slow.config.rate_hz = rate_hz;
        slow.effort = Some(effort);
        slow.worst_case = true;
        scene::set_plan(&mut pico, slow, |pico| pico.samples(&samples).unwrap());
        scene::measure(&mut pico, blocks);
        let status = status(&mut pico);
        println!(
            "{}: {:.1} kS/s, {} blocks, {:?}, longest {} us",
            effort.name(),
            rate_hz / 1e3,
            status.counters.filled(),
            status.counters,
            status.longest
        );
        assert_eq!((status.counters.lost(), status.counters.faults(), status.dropped), (0, 0, 0));
        let wanted = expected(&slow, &samples);
        let measured = |frame: &[u8]| scene::measured(frame).unwrap();
        for (sequence, frame) in frames(&pico.sent) {
            let wanted = &wanted[sequence as usize % wanted.len()];
            assert_eq!(measured(&frame), measured(wanted), "block {sequence}");
        }
        let longest = f64::from(status.longest);
        hold("pico, ms of the longest block", 0.001, &[longest / 1e3]);
    }
}

#[test]
fn settings_outlive_a_restart_and_are_kept_in_flash() {
    let mut pico = plug();
    pico.samples(&stream(8, None, 21)).unwrap();
    let boot = pico.power().unwrap();
    assert_eq!((boot.causes.message(), boot.origin), ("power", Origin::Default));
    let mut slow = settings();
    slow.config.rate_hz = 100e3;
    slow.report_every = 5;
    pico.request(Command::SetSettings(slow, N)).unwrap().unwrap();
    let boot = pico.boot().unwrap();
    assert_eq!((boot.causes.message(), boot.origin, boot.last.kind), ("software", Origin::Host, 0));
    let rate = |pico: &mut Pico| {
        let body = pico.request(Command::GetSettings).unwrap().unwrap();
        Settings::from_bytes(&body).unwrap().0.config.rate_hz
    };
    assert_eq!(rate(&mut pico), 100e3);
    assert_eq!(pico.request(Command::Save).unwrap(), Ok(vec![]));
    let saved = status(&mut pico).counters;
    // An erasure takes the model 45 ms: five blocks of 10 ms, and words that take less than a block.
    println!("a save: {} blocks lost of {}", saved.lost(), saved.filled());
    assert!((4..12).contains(&saved.lost()) && saved.lost() == saved.broken && saved.faults() == 0);
    let boot = pico.power().unwrap();
    assert_eq!((boot.causes.message(), boot.origin, boot.unfit), ("power", Origin::Flash, false));
    assert_eq!(rate(&mut pico), 100e3);
    pico.request(Command::Reboot).unwrap().unwrap();
    assert_eq!(pico.boot().unwrap().origin, Origin::Flash);
    // A pair takes two conversions.
    let iq = Settings { iq: true, ..settings() };
    let refused = Err(Refusal::Settings(SettingsError::Rate(RateError::Fast).code()));
    assert_eq!(pico.request(Command::SetSettings(iq, N)).unwrap(), refused);
}

/// The supply's regulator keeps to one rate of switching, and a line with nothing on it is no break.
#[test]
fn supply_and_receiver_are_set() {
    let mut pico = plug();
    pico.power().unwrap();
    // Pico datasheet, 2.1: GPIO 23 is the regulator's mode, high for one rate. RP2040 datasheet, 2.19.6.1 and 2.3.1.7: IO_BANK0's
    // GPIO23_CTRL with function 5, SIO's GPIO_OUT and GPIO_OE.
    assert_eq!(pico.read(0x4001_40BC).unwrap() & 31, 5);
    let [out, enable] = [0xD000_0010, 0xD000_0020].map(|at| pico.read(at).unwrap() >> 23 & 1);
    assert_eq!([out, enable], [1, 1]);
    // 2.10.6: VREG_AND_CHIP_RESET's VREG, VSEL 7:4 = 12 for 1.15 V.
    assert_eq!(pico.read(0x4006_4000).unwrap() >> 4 & 15, 12);
    // 2.19.6.3: PADS_BANK0's GPIO1 with PUE 3 and without PDE 2.
    assert_eq!(pico.read(0x4001_C008).unwrap() >> 2 & 3, 0b10);
}

/// Without blocks the timer wakes the core, and the watchdog is fed; when blocks stay away, it bites.
#[test]
fn the_watchdog_bites_only_when_blocks_stay_away() {
    let mut pico = plug();
    pico.power().unwrap();
    pico.request(Command::Stop).unwrap().unwrap();
    pico.boot().unwrap();
    let resets = pico.resets.len();
    pico.run(6_000_000).unwrap();
    assert_eq!(pico.resets.len(), resets, "the watchdog bit a board that is stopped");
    pico.request(Command::Start).unwrap().unwrap();
    assert!(pico.boot().unwrap().measuring);
    let (resets, at) = (pico.resets.len(), pico.now);
    // The converter stops: START_MANY off.
    pico.order("write 0x4004c000 1").unwrap();
    while pico.resets.len() == resets && pico.now < at + 8_000_000 {
        pico.run(50_000).unwrap();
    }
    assert!((4_900_000..5_300_000).contains(&(pico.resets[resets] - at)), "{:?}", pico.resets);
    assert_eq!(pico.boot().unwrap().causes.message(), "watchdog");
}

/// What the emulator, as npm gets it, does otherwise than the chip: docs/pico.md lists it. A line that is false has been mended.
#[test]
fn the_emulator_does_so_otherwise() {
    let scripts = picket_host::pico::bench::emulator().unwrap_or_else(|error| panic!("{error}"));
    let node = picket_host::toolchain::node().unwrap();
    let output = std::process::Command::new(node).arg(scripts.join("otherwise.mjs")).output();
    let text = String::from_utf8(output.unwrap().stdout).unwrap();
    println!("{text}");
    assert_eq!(text.lines().count(), 19);
    for line in text.lines() {
        assert!(line.ends_with(" true"), "mended: {line}");
    }
}

/// Flash and RAM, with the stack that was seen.
#[test]
fn the_image_keeps_its_budget() {
    let budget: serde_json::Value = serde_json::from_str(include_str!("../budget.json")).unwrap();
    let keeps = |image: &str, elf: Result<std::path::PathBuf, _>| {
        let elf = elf.unwrap_or_else(|error| panic!("{error}"));
        let footprint = picket_host::pico::flash::footprint(&elf).unwrap();
        for (what, spent) in [("flash", footprint.flash), ("ram", footprint.ram)] {
            let allowed = budget[image][what].as_u64().unwrap();
            println!("{image}, {what}: {spent} of {allowed} B");
            assert!(spent as f64 <= 1.01 * allowed as f64, "{what}: {spent} of {allowed} B");
        }
        let most = picket_host::pico::flash::BUDGET;
        assert!(footprint.flash <= most.flash && footprint.ram <= most.ram, "{footprint:?}");
        footprint
    };
    keeps("pico", picket_host::pico::image());
    let footprint = keeps("pico_usb", picket_host::pico::usb_image());
    let mut pico = scene::plug_usb();
    pico.samples(&stream(20, Some((4, Hard::Mixed)), 22)).unwrap();
    pico.power().unwrap();
    pico.run(60_000).unwrap();
    let stack = u64::from(status(&mut pico).stack);
    println!("stack: {stack} B");
    assert!(footprint.ram + stack <= 264 << 10, "{footprint:?} and {stack} of stack");
}

//! The serial port over USB, beside the other: the image with it, at the emulator's own host.

use super::scene::{expected, frames, plug_usb, settings, status, stream};
use host_tests::sized;
use picket_host::device::{Listener, Said};
use picket_host::pico::bench::Pico;
use picket_wire::command::{Command, Request};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A board that measures, with a program at its USB port.
fn connected(blocks: usize, seed: u64) -> (Pico, Vec<Vec<u8>>) {
    let samples = stream(blocks, None, seed);
    let mut pico = plug_usb();
    pico.samples(&samples).unwrap();
    pico.order("usb plug").unwrap();
    pico.power().unwrap();
    (pico, expected(&settings(), &samples))
}

/// The sequence of each record that came by USB, of which every frame is whole and the host's own, and how many frames were not.
fn received(pico: &Pico, wanted: &[Vec<u8>]) -> (Vec<u32>, u64) {
    let mut listener = Listener::default();
    listener.read(&pico.by_usb);
    let (records, wire) = (frames(&pico.by_usb), frames(&pico.sent));
    for (sequence, frame) in &records {
        // The wire is slower: it may still have the last one to send.
        let by_wire = wire.iter().find(|(other, _)| other == sequence);
        assert!(by_wire.is_none_or(|(_, other)| other == frame), "block {sequence} differs");
        let block = wanted.get(*sequence as usize);
        assert!(block.is_none_or(|block| block == frame), "block {sequence} is not the host's");
    }
    (records.into_iter().map(|(sequence, _)| sequence).collect(), listener.bad)
}

#[test]
fn usb_says_what_the_wire_says_and_takes_commands() {
    let blocks = sized(60, 5_000);
    let (mut pico, wanted) = connected(60, 31);
    pico.run(30_000).unwrap();
    pico.zero().unwrap();
    pico.run(2_048 * blocks).unwrap();
    let figures = pico.figures().unwrap();
    let identify = Request { tag: 77, command: Command::Identify };
    let hex: String = identify.to_frame().iter().map(|byte| format!("{byte:02x}")).collect();
    pico.order(&format!("usb hear {hex}")).unwrap();
    pico.run(5_000).unwrap();
    let mut listener = Listener::default();
    let answered = listener
        .read(&pico.by_usb)
        .into_iter()
        .any(|said| matches!(said, Said::Answer(answer, _) if answer == identify.answer()));
    assert!(answered, "no answer by USB");
    let (records, bad) = received(&pico, &wanted);
    println!("{} records by USB, load {:.1} %", records.len(), 100.0 * figures.load());
    assert!(records.len() as u64 >= blocks && bad == 0, "{} {bad}", records.len());
    assert!(records.windows(2).all(|pair| pair[1] == pair[0] + 1), "{records:?}");
    let status = status(&mut pico);
    assert_eq!((status.dropped, status.counters.lost(), status.counters.faults()), (0, 0, 0));
    assert!(figures.load() < 0.80 && figures.level <= 2, "{figures:?}");
}

/// No packet is given to the controller in the last fifth of a frame, in which a corrupted one may hang it for ever (RP2040-E15).
#[test]
fn no_packet_is_given_at_the_end_of_a_frame() {
    let (mut pico, _) = connected(60, 34);
    pico.run(30_000 + 2_048 * sized(60, 2_000)).unwrap();
    let lines = pico.order("usb count").unwrap();
    let counts: Vec<u64> =
        lines[0].split_whitespace().filter_map(|word| word.parse().ok()).collect();
    println!("{} packets of {} within the last fifth of a frame", counts[0], counts[1]);
    assert!(counts[1] > 100 && counts[0] == 0, "{lines:?}");
}

/// Commands of two programs, one at each port, whose bytes come mixed: each frame stays whole.
#[test]
fn two_hosts_do_not_mix_their_frames() {
    let (mut pico, _) = connected(60, 35);
    pico.run(30_000).unwrap();
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let refused = status(&mut pico).refused;
    let identify = |tag| Request { tag, command: Command::Identify }.to_frame().to_vec();
    for round in 0..sized(20, 300) as u8 {
        let (one, other) = (identify(2 * (round % 100)), identify(2 * (round % 100) + 1));
        for (a, b) in one.iter().zip(&other) {
            pico.hear(&[*a]).unwrap();
            pico.order(&format!("usb hear {}", hex(&[*b]))).unwrap();
            pico.run(40).unwrap();
        }
    }
    pico.run(20_000).unwrap();
    assert_eq!(status(&mut pico).refused, refused);
}

/// A program that has the port open and does not read: what finds no room is dropped whole and counted.
#[test]
fn records_that_nobody_reads_are_dropped_and_counted() {
    let (mut pico, wanted) = connected(60, 32);
    pico.run(30_000).unwrap();
    let (before, _) = received(&pico, &wanted);
    pico.order("usb read 0").unwrap();
    pico.run(300_000).unwrap();
    let held = received(&pico, &wanted).0.len() - before.len();
    pico.order("usb read 1").unwrap();
    pico.run(30_000).unwrap();
    let status = status(&mut pico);
    let (records, bad) = received(&pico, &wanted);
    let span = u64::from(records[records.len() - 1] - records[0]) + 1;
    let missing = span - records.len() as u64;
    println!("{missing} records missing by USB of {span}, dropped {}", status.dropped);
    assert!(held <= 2 && missing > 80 && bad == 0, "{held} {missing} {bad}");
    assert_eq!(u64::from(status.dropped), missing);
    assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0));
    // By the wire all came.
    let wire: Vec<u32> = frames(&pico.sent).into_iter().map(|(sequence, _)| sequence).collect();
    assert!(wire.windows(2).all(|pair| pair[1] == pair[0] + 1));
}

/// The cable is pulled at any moment and put back: at most the cut frame is bad, and nothing is counted that nobody waited for.
#[test]
fn a_cable_may_be_pulled_in_mid_frame() {
    let (mut pico, wanted) = connected(60, 33);
    let mut rng = ChaCha8Rng::seed_from_u64(33);
    pico.run(25_000).unwrap();
    let (pulls, mut cut) = (sized(6, 200), 0);
    for pull in 1..=pulls {
        pico.run(rng.random_range(1..9_000)).unwrap();
        // Every second time a frame's first packet is out, and no more.
        let whole = |pico: &Pico| pico.by_usb.last() == Some(&0);
        while pull % 2 == 0 && whole(&pico) {
            pico.run(20).unwrap();
        }
        cut += u64::from(!whole(&pico));
        pico.order("usb unplug").unwrap();
        // Back before the device has noticed, or after it.
        pico.run(rng.random_range(100..60_000)).unwrap();
        let before = pico.by_usb.len();
        pico.order("usb plug").unwrap();
        pico.run(40_000).unwrap();
        assert!(pico.by_usb.len() > before + 1_000, "silent after pull {pull}");
    }
    let (records, bad) = received(&pico, &wanted);
    println!("{} records by USB over {pulls} pulls, {bad} frames cut", records.len());
    assert!(bad == cut && cut >= pulls / 2, "{bad} of {cut}");
    assert!(records.windows(2).all(|pair| pair[1] > pair[0]), "{records:?}");
    let status = status(&mut pico);
    assert_eq!((status.dropped, status.counters.lost(), status.counters.faults()), (0, 0, 0));
    assert!(pico.resets.is_empty(), "{:?}", pico.resets);
}

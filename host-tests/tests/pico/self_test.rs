//! The board tries itself: its list holds on a sound bench, by either port, and what is wrong on the bench shows in it.

use super::scene::{plug, plug_usb};
use host_tests::sized;
use picket_host::pico::bench::Pico;
use picket_wire::boot::Origin;
use picket_wire::command::{Command, Request};
use picket_wire::settings::Settings;

/// What the board has said by the port that the list is asked for at.
fn said(pico: &Pico, usb: bool) -> String {
    String::from_utf8_lossy(if usb { &pico.by_usb } else { &pico.sent }).into_owned()
}

fn tell(pico: &mut Pico, usb: bool, bytes: &[u8]) {
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    pico.order(&format!("{}hear {hex}", if usb { "usb " } else { "" })).unwrap();
}

/// Gives the order, shortens the list, and returns its lines up to the one that has `word`.
fn list(pico: &mut Pico, usb: bool, word: &str) -> Vec<String> {
    pico.sent.clear();
    pico.by_usb.clear();
    tell(pico, usb, &Request { tag: 9, command: Command::SelfTest }.to_frame());
    let end = pico.now + 30_000_000;
    let mut shortened = false;
    while pico.now < end {
        pico.run(20_000).unwrap();
        let text = said(pico, usb);
        let Some(begin) = text.find("picket self-test") else { continue };
        if !shortened {
            tell(pico, usb, b"q\0");
            shortened = true;
        }
        let whole = text[begin..].rsplit_once('\n').map_or("", |(whole, _)| whole);
        let lines: Vec<String> =
            whole.lines().map(|line| line.trim_matches(['\0', '\r']).into()).collect();
        let done = |line: &String| line.contains(word) && !line.starts_with("- once more");
        if let Some(last) = lines.iter().position(done) {
            return lines[..=last].to_vec();
        }
    }
    panic!("{word}: {}", said(pico, usb));
}

/// The list of a board on a sound bench.
fn holds(pico: &mut Pico, usb: bool) {
    let lines = list(pico, usb, "result:");
    lines.iter().for_each(|line| println!("{line}"));
    assert!(lines[0].ends_with("started by software"), "{}", lines[0]);
    for (line, wanted) in lines[1..].iter().zip([
        "clock of the core: 14",
        "levels of GP14 at GP26, codes: low 0.0 of at most 40, high 4095.0 of at least 4055",
        "temperature of the chip: 26.9 C of -20 to 85; noise of its sensor, codes: 0.",
        "500 kS/s: 8 blocks, 0 lost, 0 faults",
        "10 kS/s: 8 blocks, 0 lost, 0 faults",
        "48 kS/s: 8 blocks, 0 lost, 0 faults",
        "100 kS/s: 8 blocks, 0 lost, 0 faults",
        "250 kS/s: 8 blocks, 0 lost, 0 faults",
        "chirp of GP14 at GP26, in step: 8 blocks, 0 lost, 0 faults",
        "settings saved in 55 ms",
        "settings loaded after a reset, the former ones back",
        "watchdog: it bites after 3",
        "stack: ",
    ]) {
        assert!(line.starts_with(&format!("- [x] {wanted}")), "{wanted}: {line}");
    }
    assert_eq!(lines[14], "result: 13 of 13 hold");
}

/// A board with settings that somebody has saved, on a bench with the wire.
fn on_bench(mut pico: Pico, orders: &[&str]) -> Pico {
    for order in orders {
        pico.order(order).unwrap();
    }
    pico.power().unwrap();
    pico
}

#[test]
fn the_list_holds_and_saved_settings_stay() {
    let mut pico = on_bench(plug(), &["jumper"]);
    let saved = Settings { report_every: 7, ..Settings::default() };
    pico.request(Command::SetSettings(saved, picket_firmware::pico::N)).unwrap().unwrap();
    pico.boot().unwrap();
    assert_eq!(pico.request(Command::Save).unwrap(), Ok(vec![]));
    pico.take();
    holds(&mut pico, false);
    // It is an instrument again.
    let boot = pico.boot().unwrap();
    assert_eq!((boot.origin, boot.measuring), (Origin::Flash, true));
    let kept = pico.request(Command::GetSettings).unwrap().unwrap();
    assert_eq!(Settings::from_bytes(&kept).unwrap().0.report_every, 7);
}

/// Each item restarts the board, and its port over USB comes again.
#[test]
fn the_list_comes_by_usb() {
    let mut pico = on_bench(plug_usb(), &["usb plug", "jumper"]);
    pico.run(50_000).unwrap();
    holds(&mut pico, true);
}

#[test]
fn a_broken_wire_is_seen() {
    let mut pico = on_bench(plug(), &[]);
    let lines = list(&mut pico, false, "500 kS/s");
    let wrong =
        |word: &str| lines.iter().find(|line| line.contains(word) && line.contains("WRONG"));
    assert!(wrong("low 2048.0").is_some(), "{lines:#?}");
    let rate =
        wrong("500 kS/s: 8 blocks, 0 lost, 0 faults").unwrap_or_else(|| panic!("{lines:#?}"));
    assert!(rate.ends_with("clipped in 0"), "{rate}");
    // Each was tried three times.
    assert_eq!(lines.iter().filter(|line| line.starts_with("- once more: 500 kS/s")).count(), 2);
}

/// A converter whose clock is too slow by half, or by less.
#[test]
fn a_wrong_clock_is_seen() {
    for times in &["2", "1.2"][..sized(1, 2) as usize] {
        let mut pico = on_bench(plug(), &["jumper", &format!("slow {times}")]);
        let lines = list(&mut pico, false, "500 kS/s");
        let rate = lines.last().unwrap();
        println!("{rate}");
        assert!(rate.starts_with("- [ ] WRONG: 500 kS/s"), "{lines:#?}");
    }
}

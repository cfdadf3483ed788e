//! However a command ends: what was recorded is kept, and no emulator goes on.

use crate::device::{ended, path, plug, session, signal, start, text};
use nix::sys::signal::Signal;
use std::fs;
use std::io::{Read, Write};
use std::time::{Duration, Instant};

#[test]
fn what_was_recorded_is_kept_however_it_ends() {
    for (number, sent) in [Signal::SIGINT, Signal::SIGTERM, Signal::SIGKILL].into_iter().enumerate()
    {
        let (name, kept) =
            (path(&format!("port-kept-{number}")), path(&format!("kept-{number}.bin")));
        let _ = fs::remove_file(&kept);
        let (mut ours, _theirs) = plug(&name);
        let running = start(&["watch", name.to_str().unwrap(), "--record", kept.to_str().unwrap()]);
        ours.read_exact(&mut [0; 8]).unwrap();
        ours.write_all(&session()).unwrap();
        let begun = Instant::now();
        let length = || fs::metadata(&kept).map_or(0, |data| data.len());
        while length() < session().len() as u64 && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        signal(&running, sent);
        let output = ended(running);
        assert_eq!(fs::read(&kept).unwrap(), session(), "{sent}");
        if sent != Signal::SIGKILL {
            assert!(output.status.success(), "{sent}: {}", text(&output.stderr));
            assert!(
                text(&output.stdout).contains("8 records, 2 blocks"),
                "{}",
                text(&output.stdout)
            );
        }
    }
}

/// The emulator ends with the demo, even where that is killed and can do nothing more: only Linux ends the children of who is killed.
#[cfg(target_os = "linux")]
#[test]
fn no_emulator_is_left_behind() {
    for (sent, code) in [(Signal::SIGTERM, Some(128 + 15)), (Signal::SIGKILL, None)] {
        let running = start(&["demo", "--seeds", "200", "--json"]);
        let id = running.0.id();
        let children =
            || fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap_or_default();
        let name =
            |child: &str| fs::read_to_string(format!("/proc/{child}/comm")).unwrap_or_default();
        let begun = Instant::now();
        // The image may have to be built before.
        let emulator = loop {
            assert!(begun.elapsed() < Duration::from_secs(300), "no emulator was started");
            match children().split(' ').find(|child| name(child).starts_with("qemu")) {
                Some(child) => break child.to_owned(),
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        signal(&running, sent);
        let output = ended(running);
        assert_eq!(output.status.code(), code, "{}", text(&output.stderr));
        // The toolchain says what it chose; nothing else.
        let said = text(&output.stderr);
        assert!(said.lines().all(|line| line.starts_with("toolchain:")), "{said}");
        let begun = Instant::now();
        while name(&emulator).starts_with("qemu") && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(!name(&emulator).starts_with("qemu"), "{sent}: the emulator goes on");
    }
}

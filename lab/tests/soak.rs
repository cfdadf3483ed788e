//! `lab soak`: short runs. The long ones are with `PICKET_LONG=1`.

use serde_json::Value;
use std::process::Command;

fn soak(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_lab"))
        .args(["soak", "--json", "--minutes", "60"])
        .args(arguments)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{summary}");
    assert_eq!(summary["wrong"], Value::Null);
    summary
}

fn lives(short: &str, long: &str) -> String {
    if std::env::var_os("PICKET_LONG").is_some() { long.into() } else { short.into() }
}

/// 10^5 faults at every step of the hand-over; in the long form 10^6, and 10^7 damaged frames.
#[test]
fn faults_at_every_access_mix_no_block_and_are_counted() {
    let count = lives("250", "5100");
    let first = soak(&["--lives", &count]);
    let of = |key: &str| first[key].as_u64().unwrap();
    let lived = of("lives");
    assert_eq!(lived.to_string(), count);
    assert!(of("faults") > 800 * lived && of("blocks") > 350 * lived, "{first}");
    assert!(of("damaged_frames") > 1900 * lived && of("wraps") > lived / 10, "{first}");
    for fault in ["late", "doubled", "held_up", "transfer", "overrun", "pause", "stall"] {
        assert!(of(&format!("faults_{fault}")) > 5 * lived, "{fault}: {first}");
    }
    // The seed tells everything.
    assert_eq!(soak(&["--lives", "20"]), soak(&["--lives", "20", "--faults", "1"]));
    assert_ne!(soak(&["--lives", "20"]), soak(&["--lives", "20", "--faults", "2"]));
}

/// The NUCLEO's image: faults, commands, restarts, captures.
#[test]
fn the_emulated_nucleo_comes_through() {
    let summary = soak(&["--board", "nucleo", "--lives", &lives("1", "100")]);
    let of = |key: &str| summary[key].as_u64().unwrap();
    assert!(of("blocks") == 400 * of("lives") && of("faults") > 100 * of("lives"), "{summary}");
}

/// The emulated board with DMA, at paces at which it loses blocks.
#[test]
fn the_emulated_mps2_comes_through() {
    let summary = soak(&["--board", "mps2", "--lives", &lives("1", "60")]);
    let of = |key: &str| summary[key].as_u64().unwrap();
    assert_eq!(of("blocks") + of("lost"), 20_000 * of("lives"), "{summary}");
    assert!(of("lost") > 100, "{summary}");
}

//! The report that an owner can send: JSON with all that was seen, and the list as text.

use super::checks::Check;
use super::facts::Facts;
use crate::watch::{line, settings};
use serde_json::{Value, json};
use std::time::{SystemTime, UNIX_EPOCH};

/// Everything that was seen.
pub fn json(port: &str, facts: &Facts, checks: &[Check], list: &[String]) -> String {
    let parsed = |text: String| serde_json::from_str(&text).unwrap_or(Value::String(text));
    let when = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let checks: Vec<Value> = checks
        .iter()
        .map(|check| json!({"name": check.name, "holds": check.held(), "seen": check.seen, "cause": check.cause}))
        .collect();
    let boot = facts.boot.map(|boot| {
        let last = boot.last;
        json!({
            "board": boot.board.as_str(), "program": format!("{:08x}", boot.program), "core_hz": boot.core_hz,
            "clock": boot.clock.name(), "causes": boot.causes.0, "origin": boot.origin.name(), "n": boot.n,
            "measuring": boot.measuring, "halted": boot.halted, "unfit": boot.unfit,
            "last": {"kind": last.kind, "pc": last.pc, "more": last.more},
        })
    });
    let statuses: Vec<Value> = facts
        .statuses
        .iter()
        .map(|(at, status)| json!({"s": at, "status": parsed(line::status(status))}))
        .collect();
    let records: Vec<Value> = facts
        .records
        .iter()
        .map(|record| {
            let tone = record.measurement.tone;
            json!({
                "block": record.measurement.stamp.sequence, "frequency_hz": tone.frequency.cycles() * tone.rate_hz,
                "sigma_hz": f64::from(tone.sigma) * tone.rate_hz, "snr_db": tone.snr_db(), "verdict": tone.verdict.name(),
                "lost": record.health.lost, "faults": record.health.faults,
            })
        })
        .collect();
    let report = json!({
        "picket": env!("CARGO_PKG_VERSION"), "system": std::env::consts::OS, "machine": std::env::consts::ARCH,
        "unix_s": when, "port": port, "failure": facts.failure, "bytes": facts.bytes, "bad_frames": facts.bad,
        "checks": checks, "list": list, "boot": boot,
        "settings": facts.settings.as_ref().map(|(values, n)| parsed(settings::to_json(values, *n))),
        "statuses": statuses, "records": records, "block": facts.block,
    });
    format!("{report}\n")
}

/// The list with what it is of.
pub fn text(facts: &Facts, lines: &[String], result: &str) -> String {
    let head = format!(
        "picket doctor {} on {} {}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH
    );
    let failure = facts.failure.iter().map(|said| format!("failure: {said}"));
    let lines = [head].into_iter().chain(lines.iter().cloned()).chain(failure);
    lines.chain([result.into()]).map(|line| line + "\n").collect()
}

//! The ten checks: what was seen, and the cause and the cure where it is not what it should be.

use super::facts::{Facts, by_blocks};
use crate::watch::line;
use picket_dsp::Verdict;
use picket_dsp::acquire::frontend::Counters;
use picket_wire::boot::{Clock, Origin};
use picket_wire::layout::VERSION;

/// A check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// What is checked.
    pub name: &'static str,
    /// What was seen.
    pub seen: String,
    /// Why it does not hold, and what to do; `None` if it holds.
    pub cause: Option<String>,
}

impl Check {
    /// Whether it holds.
    pub const fn held(&self) -> bool {
        self.cause.is_none()
    }

    /// As it is printed.
    pub fn lines(&self) -> Vec<String> {
        let Self { name, seen, cause } = self;
        match cause {
            None => vec![format!("- [x] {name}: {seen}")],
            Some(cause) => vec![format!("- [ ] {name}: {seen}"), format!("      {cause}")],
        }
    }
}

/// What a check has seen, and its cause.
type Outcome = (String, Option<&'static str>);

/// Nothing is known, because of an earlier check.
const UNKNOWN: &str = "not known: see the checks above";

fn unknown() -> Outcome {
    ("not seen".into(), Some(UNKNOWN))
}

fn if_not(holds: bool, cause: &'static str) -> Option<&'static str> {
    (!holds).then_some(cause)
}

/// All checks. An `emulated` board's seconds are not this computer's.
pub fn all(facts: &Facts, emulated: bool) -> Vec<Check> {
    let outcomes: [(&'static str, Outcome); 10] = [
        ("port", port(facts)),
        ("protocol", protocol(facts)),
        ("program", program(facts)),
        ("start", start(facts)),
        ("clock", clock(facts)),
        ("settings", settings(facts)),
        ("blocks", blocks(facts, emulated)),
        ("losses", losses(facts)),
        ("load", load(facts)),
        ("input", input(facts)),
    ];
    let check = |(name, (seen, cause)): (_, Outcome)| {
        // What the system or the board itself says is the cause.
        let said = facts.failure.clone().filter(|_| name == "port" && cause.is_some());
        Check { name, seen, cause: said.or(cause.map(Into::into)) }
    };
    outcomes.into_iter().map(check).collect()
}

fn port(facts: &Facts) -> Outcome {
    let silent = "the board says nothing: is this the board's port, has the board power, is the image written (picket flash)?";
    (format!("{} bytes", facts.bytes), if_not(facts.bytes > 0, silent))
}

fn protocol(facts: &Facts) -> Outcome {
    if facts.bytes == 0 {
        return unknown();
    }
    let cause = match (facts.version, facts.boot) {
        (Some(_), _) => {
            Some("the image is of another version than this tool: flash the tool's own")
        }
        (None, None) => Some(
            "bytes came, and no answer of a board: another device's port, other firmware, or the line loses bytes (921,600 baud)",
        ),
        // The first frame may be cut where the port was opened.
        _ => if_not(facts.bad <= 1, "the line damages frames: try another cable or socket"),
    };
    let version = facts.version.unwrap_or(VERSION);
    (format!("version {version}, {} frames not understood", facts.bad), cause)
}

fn program(facts: &Facts) -> Outcome {
    let Some(boot) = facts.boot else { return unknown() };
    let seen = format!("{}, program {:08x}", boot.board.as_str(), boot.program);
    (
        seen,
        if_not(boot.program != 0, "the board does not know its program's checksum: flash it again"),
    )
}

fn start(facts: &Facts) -> Outcome {
    let Some(boot) = facts.boot else { return unknown() };
    let cause = if boot.halted {
        Some(
            "it stopped after three crashes in a row: send the report, then start it by `picket watch PORT --start`",
        )
    } else if facts.starts > 0 {
        Some(
            "it started anew while it was watched: see its cause; a weak supply or cable does so, too",
        )
    } else if boot.last.kind != 0 {
        Some("the program before ended by a failure: send the report")
    } else if boot.causes.message() == "watchdog" {
        Some(
            "the watchdog had to restart it: blocks or the serial line had stopped; send the report",
        )
    } else {
        None
    };
    (line::boot(&boot), cause)
}

fn clock(facts: &Facts) -> Outcome {
    let Some(boot) = facts.boot else { return unknown() };
    let missing = "the probe's clock does not reach the chip: SB16, SB50 and SB54 closed, SB55 open, R35 and R37 removed (docs/board.md)";
    let seen = format!("{} MHz from {}", boot.core_hz / 1_000_000, boot.clock.message());
    (seen, if_not(boot.clock == Clock::External, missing))
}

fn settings(facts: &Facts) -> Outcome {
    let (Some(boot), Some((settings, n))) = (facts.boot, &facts.settings) else { return unknown() };
    let seen = format!(
        "{}, blocks of {n} at {} S/s, {}",
        boot.origin.name(),
        settings.config.rate_hz,
        if boot.measuring { "measuring" } else { "stopped" }
    );
    let cause = if boot.origin == Origin::Unreadable {
        Some(
            "those in its flash are damaged or another program's: send it settings, `--set-settings FILE --save`",
        )
    } else if boot.unfit {
        Some(
            "they do not work here, so it has the default ones: send others (a slow clock allows fewer)",
        )
    } else {
        if_not(boot.measuring, "it is stopped: `picket watch PORT --start`")
    };
    (seen, cause)
}

/// What changed from the first status to the last, and the number of seconds of the board between them.
fn counted(facts: &Facts) -> Option<(Counters, usize)> {
    let [(_, first), .., (_, last)] = &facts.statuses[..] else { return None };
    Some((last.counters.since(&first.counters), facts.statuses.len() - 1))
}

fn blocks(facts: &Facts, emulated: bool) -> Outcome {
    let Some((counters, seconds)) = counted(facts) else { return unknown() };
    let Some((settings, n)) = &facts.settings else { return unknown() };
    let passed = facts.statuses.last().map_or(0.0, |(at, _)| *at);
    let filled = counters.filled();
    let seen = format!("{filled} in {seconds} seconds of the board, {passed:.2} of this computer");
    if facts.steady().is_none() {
        let cause =
            "no pulse opens its gate: is the source's sync pulse at D3 (NUCLEO) or GP13 (Pico)?";
        return (seen, if_not(filled > 0, cause));
    }
    let samples = (n + usize::from(settings.guard)) as f64;
    let due = seconds as f64 * settings.config.rate_hz / samples;
    // A status follows the end of a block: its second is a block too long at most, and the first may be late by one.
    let whole = (f64::from(filled) - due).abs() <= 2.0 + 0.01 * due + seconds as f64;
    let even = emulated || (passed / seconds as f64 - 1.0).abs() < 0.05;
    let cause = if filled == 0 {
        Some("no block comes: the converter or its DMA stands still; send the report")
    } else if !whole {
        Some("more or fewer blocks than the rate gives: the sample clock is wrong; send the report")
    } else {
        if_not(even, "the board's seconds are not this computer's: its clock is wrong")
    };
    (seen, cause)
}

fn losses(facts: &Facts) -> Outcome {
    let Some((counters, _)) = counted(facts) else { return unknown() };
    let [(_, first), .., (_, last)] = &facts.statuses[..] else { return unknown() };
    let dropped = last.dropped.wrapping_sub(first.dropped);
    let (lost, faults) = (counters.lost(), counters.faults());
    let seen = format!("{lost} blocks lost, {faults} faults, {dropped} frames without room");
    let cause = if faults > 0 {
        Some("the converter's stream failed: send the report")
    } else if lost > 0 {
        Some("the loop is too slow for these settings, or pulses came too early: lower the rate")
    } else {
        if_not(dropped == 0, "the serial line is full: raise report_every")
    };
    (seen, cause)
}

fn load(facts: &Facts) -> Outcome {
    let Some((_, last)) = facts.statuses.last() else { return unknown() };
    let peak = facts.statuses.iter().map(|(_, status)| status.peak).max().unwrap_or(0);
    let seen = format!(
        "awake {} permille, the longest block {peak} permille of its time, stack {} B",
        last.load, last.stack
    );
    let cause = "a block takes longer than it lasts: lower the rate";
    (seen, if_not(peak <= 1000, cause))
}

fn input(facts: &Facts) -> Outcome {
    let block = &facts.block;
    let (Some(least), Some(most)) = (block.iter().min(), block.iter().max()) else {
        return unknown();
    };
    let count = block.len() as f64;
    let mean = block.iter().map(|code| f64::from(*code)).sum::<f64>() / count;
    let square = block.iter().map(|code| (f64::from(*code) - mean).powi(2)).sum::<f64>() / count;
    let good = |record: &&picket_wire::telemetry::Telemetry| {
        record.measurement.tone.verdict == Verdict::Good
    };
    let shown = match facts.records.iter().rev().find(good) {
        Some(record)
            if facts.settings.as_ref().is_some_and(|(settings, _)| by_blocks(settings)) =>
        {
            let tone = record.measurement.tone;
            let hertz = tone.frequency.cycles() * tone.rate_hz;
            format!(", a tone at {hertz:.3} Hz +- {:.3}", f64::from(tone.sigma) * tone.rate_hz)
        }
        _ => ", no steady tone".into(),
    };
    let seen =
        format!("codes {least} to {most}, mean {mean:.1}, scatter {:.2}{shown}", square.sqrt());
    let cause = if *most <= 8 {
        Some(
            "A0 (GP26 on a Pico) is at ground: set it to the middle by two resistors, couple by a capacitor",
        )
    } else if *least >= 4087 {
        Some("A0 (GP26 on a Pico) is at 3.3 V: set it to the middle by two resistors")
    } else if *least <= 0 || *most >= 4095 {
        Some("the input clips: lower the signal, and never go beyond 0 and 3.3 V")
    } else {
        if_not(
            most > least,
            "every sample has the same code: the converter stands still, or nothing is connected",
        )
    };
    (seen, cause)
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_wire::boot::{Boot, Causes, LastEnd, Name};
    use picket_wire::settings::Settings;
    use picket_wire::status::Status;

    /// A board as it should be.
    fn sound() -> Facts {
        let boot = Boot {
            board: Name::new("nucleo-f446re"),
            clock: Clock::External,
            causes: Causes(1),
            measuring: true,
            program: 1,
            n: 1024,
            core_hz: 180_000_000,
            ..Boot::default()
        };
        let status = |second: u32| {
            let counters = Counters { blocks: 488 * second, ..Counters::default() };
            (
                f64::from(second) * 1.001,
                Status { counters, load: 400, peak: 500, ..Status::default() },
            )
        };
        Facts {
            bytes: 9_000,
            boot: Some(boot),
            settings: Some((Settings::default(), 1024)),
            statuses: (0..5).map(status).collect(),
            block: vec![2000, 2100, 2050, 1990],
            ..Facts::default()
        }
    }

    fn failed(facts: &Facts) -> Vec<&'static str> {
        let checks = all(facts, false);
        assert_eq!(checks.len(), 10);
        checks.iter().filter(|check| !check.held()).map(|check| check.name).collect()
    }

    #[test]
    fn a_sound_board_passes() {
        assert_eq!(failed(&sound()), [""; 0]);
    }

    #[test]
    fn each_failure_fails_its_own_check() {
        type Change = fn(&mut Facts);
        fn boot(facts: &mut Facts) -> &mut Boot {
            facts.boot.as_mut().unwrap()
        }
        let cases: [(Change, &str); 17] = [
            (|facts| facts.bad = 3, "protocol"),
            (|facts| facts.version = Some(99), "protocol"),
            (|facts| boot(facts).program = 0, "program"),
            (|facts| boot(facts).halted = true, "start"),
            (|facts| boot(facts).causes = Causes(8), "start"),
            (|facts| boot(facts).last = LastEnd { kind: 1, ..LastEnd::default() }, "start"),
            (|facts| facts.starts = 1, "start"),
            (|facts| boot(facts).clock = Clock::Internal, "clock"),
            (|facts| boot(facts).origin = Origin::Unreadable, "settings"),
            (|facts| boot(facts).unfit = true, "settings"),
            (|facts| facts.statuses.iter_mut().for_each(|(at, _)| *at *= 1.1), "blocks"),
            (|facts| facts.statuses[4].1.counters.blocks += 60, "blocks"),
            (|facts| facts.statuses[3].1.peak = 1_001, "load"),
            (|facts| facts.statuses[4].1.dropped = 1, "losses"),
            (|facts| facts.block = vec![0; 9], "input"),
            (|facts| facts.block = vec![2048; 9], "input"),
            (|facts| facts.block = vec![3000, 4095, 2000], "input"),
        ];
        for (change, name) in cases {
            let mut facts = sound();
            change(&mut facts);
            assert_eq!(failed(&facts), [name]);
        }
        // A lost block is none that is missing.
        let mut facts = sound();
        let counters = &mut facts.statuses[4].1.counters;
        (counters.overruns, counters.blocks) = (2, counters.blocks - 2);
        assert_eq!(failed(&facts), ["losses"]);
    }

    #[test]
    fn a_board_that_says_nothing_fails_all_and_its_port_says_why() {
        let facts = Facts { failure: Some("no such port".into()), ..Facts::default() };
        let checks = all(&facts, false);
        assert!(checks.iter().all(|check| !check.held()));
        assert_eq!(checks[0].cause.as_deref(), Some("no such port"));
        assert!(checks.iter().flat_map(Check::lines).all(|line| !line.contains('\n')));
    }
}

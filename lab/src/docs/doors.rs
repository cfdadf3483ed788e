//! What the library does, and by which of its doors: each name in the table is looked up in the door, and each name of a door stands in the table.

use super::Table;
use super::figures::{head, row};
use crate::toolchain;
use clap::CommandFactory;
use picket_wire::layout::Form;
use picket_wire::schema::{RECORDS, SETTINGS};
use std::collections::BTreeSet;
use std::fs;

pub(super) const TABLES: &[Table] = &[Table::new("docs/start.md", "doors", |_| lines())];

/// Something that the library does.
struct Feature {
    name: &'static str,
    /// The path in the library.
    library: &'static str,
    /// Options or commands of `picket`, names of Python's module, calls of C without what stands before them, records or settings of the
    /// wire, calls of the page's modules. Empty where a door lacks it.
    tool: &'static [&'static str],
    python: &'static [&'static str],
    c: &'static [&'static str],
    wire: &'static [&'static str],
    page: &'static [&'static str],
}

const FEATURES: &[Feature] = &[
    Feature {
        name: "the strongest tone",
        library: "Pipeline::block",
        tool: &["analyze", "watch", "demo"],
        python: &["Pipeline", "analyze", "Doppler", "Chirp", "Answers"],
        c: &["init_tone", "init", "block", "measure", "size"],
        wire: &["Telemetry", "Settings", "Boot", "Status"],
        page: &["picket_simulate", "picket_read", "picket_hear"],
    },
    Feature {
        name: "several tones",
        library: "Pipeline::lines",
        tool: &["analyze --most"],
        python: &["Pipeline.lines"],
        c: &["lines"],
        wire: &["Lines"],
        page: &["tones_find"],
    },
    Feature {
        name: "a fundamental of harmonics",
        library: "Pipeline::harmonic",
        tool: &["analyze --harmonics"],
        python: &["Pipeline.harmonics"],
        c: &["harmonics"],
        wire: &["Fundamental"],
        page: &[],
    },
    Feature {
        name: "tones followed",
        library: "Tracker",
        tool: &["analyze --track"],
        python: &["Tracker"],
        c: &["tracker_init", "track", "targets", "tracker_size"],
        wire: &["Follow"],
        page: &["picket_tracks"],
    },
    Feature {
        name: "bursts",
        library: "BurstProcessor",
        tool: &["analyze --burst"],
        python: &["BurstProcessor"],
        c: &["bursts_init", "bursts_push", "bursts_lost", "bursts_counts", "bursts_size"],
        wire: &["Burst"],
        page: &["tones_flow_begin", "tones_flow"],
    },
    Feature {
        name: "sums of blocks",
        library: "Accumulator",
        tool: &["analyze --accumulate"],
        python: &["Accumulator"],
        c: &["accumulator_init", "accumulate", "accumulator_size"],
        wire: &["Sum"],
        page: &[],
    },
    Feature {
        name: "range and velocity of a chirp",
        library: "Scene::Chirp",
        tool: &["analyze --chirp-s"],
        python: &["Chirp"],
        c: &["measure"],
        wire: &["Telemetry"],
        page: &["picket_simulate"],
    },
    Feature {
        name: "several targets of a triangle or trapezoid",
        library: "solve::pairing::Pairing",
        tool: &["demo --scenario"],
        python: &[],
        c: &[],
        wire: &[],
        page: &[],
    },
    Feature {
        name: "targets of a frame of chirps",
        library: "frame::Frame",
        tool: &["analyze --chirps"],
        python: &["Frame"],
        c: &[
            "picket_frame_cells",
            "picket_frame_init",
            "picket_frame_clear",
            "picket_frame_targets",
            "picket_frame_background",
            "picket_frame_size",
            "frame_push",
        ],
        wire: &["ChirpFrame", "Found"],
        page: &["picket_map", "picket_background"],
    },
    Feature {
        name: "a target's velocity from chirp to chirp",
        library: "solve::sequence::Sequence",
        tool: &[],
        python: &["Sequence"],
        c: &[],
        wire: &[],
        page: &[],
    },
    Feature {
        name: "displacement",
        library: "solve::displacement::Unwrapper",
        tool: &["analyze --displacement"],
        python: &["Displacement"],
        c: &["picket_way_init", "picket_way_push", "picket_way_size"],
        wire: &[],
        page: &["picket_swings"],
    },
    Feature {
        name: "range by phase",
        library: "solve::phase_range::PhaseRanging",
        tool: &["analyze --phase"],
        python: &["PhaseRanging", "Frame"],
        c: &["picket_range_by_phase", "picket_range_by_phases"],
        wire: &[],
        page: &[],
    },
    Feature {
        name: "calibration at a known range",
        library: "solve::phase_range::Calibration",
        tool: &["analyze --calibration"],
        python: &["Calibration"],
        c: &["picket_calibrate"],
        wire: &[],
        page: &[],
    },
    Feature {
        name: "the whole error",
        library: "solve::uncertainty::Uncertainty",
        tool: &["analyze --uncertainty", "design --uncertainty"],
        python: &["Uncertainty"],
        c: &["picket_budget_of_target", "picket_budget_of_phase_range"],
        wire: &[],
        page: &[],
    },
    Feature {
        name: "the clock error by another clock",
        library: "acquire::rate_check::RateCheck",
        tool: &["watch --save-clock"],
        python: &[],
        c: &[],
        wire: &[],
        page: &[],
    },
    Feature {
        name: "the clock error by a known tone",
        library: "Tone::hertz",
        tool: &["calibrate", "analyze --reference"],
        python: &[],
        c: &[],
        wire: &["Settings"],
        page: &[],
    },
    Feature {
        name: "why a verdict",
        library: "Pipeline::explain",
        tool: &["explain"],
        python: &["explain"],
        c: &[],
        wire: &[],
        page: &["tones_explain"],
    },
    Feature {
        name: "rates and lengths for a task",
        library: "tone::sigma::bound_bins",
        tool: &["design"],
        python: &[],
        c: &[],
        wire: &[],
        page: &["tones_design"],
    },
    Feature {
        name: "scenes and their truth",
        library: "picket_simulator::Scene",
        tool: &["simulate"],
        python: &["simulate"],
        c: &[],
        wire: &[],
        page: &["picket_start"],
    },
    Feature {
        name: "recordings, and what boards sent",
        library: "picket_wire",
        tool: &["watch --record", "analyze"],
        python: &["read_recording", "read_telemetry"],
        c: &[],
        wire: &["Telemetry"],
        page: &["picket_open"],
    },
    Feature {
        name: "other methods, for comparisons",
        library: "Method",
        tool: &["analyze --method"],
        python: &["METHODS"],
        c: &[],
        wire: &["Settings"],
        page: &[],
    },
    Feature {
        name: "names of verdicts and statuses",
        library: "Verdict",
        tool: &["explain"],
        python: &["VERDICTS", "__version__"],
        c: &[
            "picket_version",
            "picket_status_message",
            "picket_verdict_name",
            "picket_verdict_reason",
            "picket_verdict_usable",
            "picket_verdict_is_among",
            "picket_validation_name",
        ],
        wire: &["Telemetry"],
        page: &["picket_words"],
    },
];

/// The table.
///
/// # Errors
/// A name that its door does not have, or a door's name that no row has.
pub fn lines() -> Result<Vec<String>, String> {
    check()?;
    let mut lines = head("| what | library | tool | Python | C | boards | page |");
    for feature in FEATURES {
        let of = |names: &[&str]| match names {
            [] => "-".to_owned(),
            names => {
                let shown: Vec<String> = names.iter().take(3).map(|it| format!("`{it}`")).collect();
                shown.join(", ") + if names.len() > 3 { ", ..." } else { "" }
            }
        };
        let Feature { name, library, tool, python, c, wire, page } = feature;
        lines.push(row([
            (*name).to_owned(),
            of(&[library]),
            of(tool),
            of(python),
            of(c),
            of(wire),
            of(page),
        ]));
    }
    Ok(lines)
}

/// A door: its name, the names that it has, those of a feature, and whether each of its names is one of a feature.
type Door = (&'static str, BTreeSet<String>, fn(&Feature) -> &[&'static str], bool);

/// Compares the rows with the doors.
fn check() -> Result<(), String> {
    let doors: [Door; 5] = [
        ("picket", tool(), |it| it.tool, false),
        ("picket_dsp of Python", python()?, |it| it.python, true),
        ("picket.h", header()?, |it| it.c, true),
        ("the wire", wire(), |it| it.wire, true),
        ("the page", page()?, |it| it.page, false),
    ];
    for (door, there, of, whole) in &doors {
        let named: BTreeSet<String> =
            FEATURES.iter().flat_map(of).map(|name| (*name).to_owned()).collect();
        if let Some(name) = named.difference(there).next() {
            return Err(format!("{door} has no {name}"));
        }
        if let Some(name) = there.difference(&named).next().filter(|_| *whole) {
            return Err(format!("{name} of {door} stands in no row of lab/src/docs/doors.rs"));
        }
    }
    Ok(())
}

fn read(path: &str) -> Result<String, String> {
    fs::read_to_string(toolchain::workspace().join(path))
        .map_err(|error| format!("{path}: {error}"))
}

/// The commands, and their options.
fn tool() -> BTreeSet<String> {
    let program = picket_host::cli::Picket::command();
    let mut all = BTreeSet::new();
    for command in program.get_subcommands() {
        all.insert(command.get_name().to_owned());
        let options = command.get_arguments().filter_map(|argument| argument.get_long());
        all.extend(options.map(|option| format!("{} --{option}", command.get_name())));
    }
    all
}

/// What the module exports, and the methods that are features of their own.
fn python() -> Result<BTreeSet<String>, String> {
    let text = read("python/picket_dsp/__init__.py")?;
    let list = text.split_once("__all__ = [").and_then(|it| it.1.split_once(']'));
    let list = list.ok_or("python/picket_dsp/__init__.py has no __all__")?.0;
    let names = list.split(',').map(|name| name.trim().trim_matches('"').to_owned());
    let mut all: BTreeSet<String> = names.filter(|name| !name.is_empty()).collect();
    for method in ["lines", "harmonics"] {
        let defined = text.contains(&format!("    def {method}("));
        all.extend(defined.then(|| format!("Pipeline.{method}")));
    }
    Ok(all)
}

/// The calls that the header declares, those for a kind and length without its name.
fn header() -> Result<BTreeSet<String>, String> {
    let text = read("c/include/picket.h")?;
    let calls = text.split([' ', '*', '\n']).filter_map(|word| word.split_once('('));
    let own = |(name, _): (&str, &str)| {
        let of_kind = name.strip_prefix("KIND##_");
        of_kind.or(name.strip_prefix("picket_").map(|_| name)).map(str::to_owned)
    };
    let shown = |name: &String| !name.starts_with("picket_real");
    Ok(calls.filter_map(own).filter(shown).collect())
}

/// The records of boards, and their settings.
fn wire() -> BTreeSet<String> {
    let name = |form: &Form| match form {
        Form::Structure(structure) => crate::schema::last(structure.name).to_owned(),
        _ => String::new(),
    };
    let records = RECORDS.iter().map(|(_, form)| name(form));
    records.chain([name(&SETTINGS)]).collect()
}

/// The calls of the page's modules.
fn page() -> Result<BTreeSet<String>, String> {
    let texts = [read("web/src/lib.rs")?, read("web/tones/src/lib.rs")?].concat();
    let calls = texts.split("extern \"C\" fn ").skip(1).filter_map(|rest| rest.split_once('('));
    Ok(calls.map(|(name, _)| name.to_owned()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_wire::view::VIEWS;

    /// Every door has what the table says, and the table all that a door has.
    #[test]
    fn the_doors_are_as_the_table_says() {
        assert_eq!(check(), Ok(()));
        // A structure that C has stands for something in it, so each view is one that a call gives or takes.
        let header = read("c/include/picket.h").unwrap();
        for view in VIEWS {
            let Form::Structure(structure) = view else { continue };
            let name = structure.name;
            assert!(header.matches(name).count() > 2, "{name} is not used in picket.h");
        }
    }
}

//! The tools as a user runs them, as one program: it is compiled and linked once.

/// The program under test.
const PROGRAM: &str = env!("CARGO_BIN_EXE_picket");

mod builds;
mod calibrate;
mod calibrate_range;
mod cli;
mod demo;
mod design;
mod device;
mod end;
mod explain;
mod field;
mod formats;
mod frames;
mod misuse;
mod overwrite;
mod program;
mod rates;
mod scenes;
mod security;
mod serialized;
mod session;
mod signals;
mod sources;
mod speed;
mod strings;
mod survey;
mod survey_kinds;
mod tones;
mod typed;
mod unknown;
mod unmeasured;

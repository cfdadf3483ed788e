//! The tools as a user runs them, as one program: it is compiled and linked once.

/// The program under test.
const PROGRAM: &str = env!("CARGO_BIN_EXE_picket");

mod bad;
mod builds;
mod calibrate;
mod cli;
mod demo;
mod design;
mod device;
mod end;
mod explain;
mod field;
mod five;
mod formats;
mod left_out;
mod overwrite;
mod program;
mod rates;
mod scenes;
mod security;
mod serialized;
mod session;
mod signals;
mod sixty;
mod sources;
mod speed;
mod strings;
mod tones;
mod typed;
mod unknown;

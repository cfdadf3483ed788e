//! The tools as a user runs them, as one program: it is compiled and linked once.

mod bad;
mod builds;
mod campaign;
mod cli;
mod demo;
mod design;
mod device;
mod end;
mod explain;
mod formats;
mod impair;
mod left_out;
mod overwrite;
mod paths;
mod rates;
mod readme;
mod report;
mod scenes;
mod session;
mod signals;
mod sixty;
mod soak;
mod tones;
mod trust;
mod typed;
mod unknown;

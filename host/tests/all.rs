//! The tools as a user runs them, as one program: it is compiled and linked once.

mod bad;
mod builds;
mod campaign;
mod cli;
mod demo;
mod device;
mod end;
mod explain;
mod formats;
mod impair;
mod paths;
mod readme;
mod report;
mod session;
mod soak;
mod tones;
mod trust;
mod typed;
mod unknown;

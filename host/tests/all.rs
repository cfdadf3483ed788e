//! The tools as a user runs them, as one program: it is compiled and linked once.

mod bad;
mod cli;
mod demo;
mod device;
mod readme;
mod report;
mod session;
mod typed;
mod unknown;

//! Host tools.
/// `print!`, by [`cli::print`].
macro_rules! out {
    ($($t:tt)*) => { $crate::cli::print(&format!($($t)*)) };
}
/// `println!`, by [`cli::print`].
macro_rules! outln {
    ($($t:tt)*) => { $crate::cli::print_line(&format!($($t)*)) };
}

pub mod analyze;
pub mod arithmetic;
pub mod band;
pub mod bench;
pub mod board;
pub mod c;
pub mod calibrate;
pub mod campaign;
pub mod cli;
pub mod console;
pub mod demo;
pub mod design;
pub mod device;
pub mod docs;
pub mod emulator;
pub mod end;
pub mod estimator;
pub mod explain;
pub mod firmware;
pub mod flash;
pub mod follow;
pub mod impair;
pub mod output;
pub mod pico;
pub mod progress;
pub mod python;
pub mod rates;
pub mod recipe;
pub mod reference;
pub mod report;
pub mod scenario;
pub mod shell;
pub mod simulate;
pub mod soak;
pub mod spectrogram;
pub mod survey;
pub mod sweep;
pub mod toolchain;
pub mod trials;
pub mod watch;
pub mod web;

pub use picket_recording as recording;

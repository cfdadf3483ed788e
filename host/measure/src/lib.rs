//! From recordings and scenes to answers: what Picket's programs share. The library's loops are compiled here once for every length
//! and kind, and the programs around them link to that.

/// `print!`, by [`cli::print`].
#[macro_export]
macro_rules! out {
    ($($t:tt)*) => { $crate::cli::print(&format!($($t)*)) };
}
/// `println!`, by [`cli::print`].
#[macro_export]
macro_rules! outln {
    ($($t:tt)*) => { $crate::cli::print_line(&format!($($t)*)) };
}

pub mod analyze;
pub mod arithmetic;
pub mod band;
pub mod cli;
pub mod end;
pub mod estimator;
pub mod explain;
pub mod follow;
pub mod length;
pub mod output;
pub mod plot;
pub mod progress;
pub mod reference;
pub mod scatter;
pub mod scenario;
pub mod simulate;
pub mod spectrogram;
pub mod survey;
pub mod trials;
pub mod views;

pub use picket_recording as recording;

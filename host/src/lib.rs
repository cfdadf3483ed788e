//! The program `picket`.

#[macro_use]
extern crate picket_measure;

pub mod board;
pub mod c;
pub mod calibrate;
pub mod cli;
pub mod console;
pub mod demo;
pub mod design;
pub mod device;
pub mod doctor;
pub mod emulator;
pub mod flash;
pub mod pico;
pub mod python;
pub mod rates;
pub mod recipe;
pub mod shell;
pub mod toolchain;
pub mod watch;
pub mod web;

pub use picket_measure::{
    analyze, arithmetic, band, end, estimator, explain, follow, output, plot, progress, recording,
    reference, scatter, scenario, simulate, spectrogram, survey, trials, views,
};

//! The command line of `picket`: the commands, and the parsing of options. An error is one line.

use crate::{
    analyze, c, calibrate, demo, design, doctor, explain, flash, python, recipe, shell, watch, web,
};
use clap::{Parser, Subcommand};
use std::fmt::Display;
use std::process::ExitCode;

pub use picket_measure::cli::*;

/// Measures frequency, range and velocity in ADC samples, each with its sigma: recorded, simulated, emulated, or live from a board.
#[derive(Debug, Parser)]
#[command(name = "picket", version)]
pub struct Picket {
    #[command(subcommand)]
    command: Command,
}

/// Each has its options beside what it runs.
#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::options::Options),
    Analyze(Box<analyze::command::Options>),
    Explain(Box<explain::Options>),
    Design(design::Options),
    Simulate(recipe::Options),
    Flash(flash::Options),
    Doctor(doctor::Options),
    Watch(watch::Options),
    Calibrate(calibrate::Options),
    Web(web::Options),
    C(c::Options),
    Python(python::Options),
    Completions(shell::Completions),
    Man(shell::Man),
}

impl Command {
    fn run(&self) -> Result<ExitCode, Failure> {
        Ok(match self {
            Command::Demo(options) => demo::run(options).map_err(told)?,
            Command::Analyze(options) => analyze::command::run(options)?,
            Command::Explain(options) => explain::run(options)?,
            Command::Design(options) => design::run(options)?,
            Command::Simulate(options) => recipe::run(options)?,
            Command::Flash(options) => flash::run(options).map_err(told)?,
            Command::Doctor(options) => doctor::run(options).map_err(told)?,
            Command::Watch(options) => watch::run(options)?,
            Command::Calibrate(options) => calibrate::run(options)?,
            Command::Web(options) => web::run(options).map_err(told)?,
            Command::C(options) => c::run(options).map_err(told)?,
            Command::Python(options) => python::run(options).map_err(told)?,
            Command::Completions(options) => shell::completions(options)?,
            Command::Man(options) => shell::man(options)?,
        })
    }
}

fn told(error: impl Display) -> String {
    error.to_string()
}

/// Parses the arguments and runs the command. A wrong option or an error is one line on stderr and exit code 2.
pub fn main() -> ExitCode {
    picket_measure::cli::main("picket", "`picket demo` needs no hardware", |picket: &Picket| {
        picket.command.run()
    })
}

//! The command line of `lab`.

use crate::{bench, bits, docs, firmware, report, schema, soak, sweep};
use clap::{Parser, Subcommand};
pub use picket_measure::cli::*;
use std::process::ExitCode;

/// What Picket's developers run: benchmarks on emulated cores, campaigns, the papers' figures.
#[derive(Debug, Parser)]
#[command(name = "lab", version)]
pub struct Lab {
    #[command(subcommand)]
    command: Command,
}

/// Each has its options beside what it runs.
#[derive(Debug, Subcommand)]
enum Command {
    Sweep(sweep::command::Options),
    Report(report::command::Options),
    Bench(bench::command::Options),
    Bits(bits::Options),
    Docs(docs::Options),
    Schema(schema::Options),
    Firmware(firmware::Options),
    Soak(soak::Options),
}

impl Command {
    fn run(&self) -> Result<ExitCode, Failure> {
        Ok(match self {
            Command::Sweep(options) => sweep::command::run(options)?,
            Command::Report(options) => report::command::run(options)?,
            Command::Bench(options) => bench::command::run(options)?,
            Command::Bits(options) => bits::run(options)?,
            Command::Docs(options) => docs::run(options)?,
            Command::Schema(options) => schema::run(options)?,
            Command::Firmware(options) => {
                firmware::run(options).map_err(|error| error.to_string())?
            }
            Command::Soak(options) => soak::run(options)?,
        })
    }
}

/// Parses the arguments and runs the command. A wrong option or an error is one line on stderr and exit code 2.
pub fn main() -> ExitCode {
    picket_measure::cli::main("lab", "`lab bench` counts instructions", |lab: &Lab| {
        lab.command.run()
    })
}

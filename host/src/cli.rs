//! The program `picket`: its commands, and what they have in common: options that are right or one line that says what is wrong.

use crate::{analyze, bench, demo, firmware, flash, report, shell, sweep, watch};
use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

/// Frequencies, ranges and velocities from a microcontroller's converter: simulated, emulated, recorded, or live from a board.
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
    Analyze(analyze::command::Options),
    Sweep(sweep::command::Options),
    Report(report::command::Options),
    Bench(bench::command::Options),
    Firmware(firmware::Options),
    Flash(flash::Options),
    Watch(watch::Options),
    Completions(shell::Completions),
    Man(shell::Man),
}

impl Command {
    fn run(&self) -> Result<ExitCode, String> {
        match self {
            Command::Demo(options) => told(demo::run(options)),
            Command::Analyze(options) => analyze::command::run(options),
            Command::Sweep(options) => sweep::command::run(options),
            Command::Report(options) => report::command::run(options),
            Command::Bench(options) => bench::command::run(options),
            Command::Firmware(options) => told(firmware::run(options)),
            Command::Flash(options) => told(flash::run(options)),
            Command::Watch(options) => told(watch::run(options)),
            Command::Completions(options) => shell::completions(options),
            Command::Man(options) => shell::man(options),
        }
    }
}

fn told<E: Display>(result: Result<ExitCode, E>) -> Result<ExitCode, String> {
    result.map_err(|error| error.to_string())
}

/// Parses the arguments and runs the command. A wrong option or an error is one line on stderr and exit code 2.
pub fn main() -> ExitCode {
    match Picket::try_parse() {
        Ok(picket) => picket.command.run().unwrap_or_else(fail),
        Err(error) => match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
                print(&error.to_string());
                ExitCode::SUCCESS
            }
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => fail(
                "name a command: `picket help` lists all, `picket demo` needs no hardware".into(),
            ),
            _ => fail(one_line(&error.to_string())),
        },
    }
}

fn fail(message: String) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(2)
}

/// clap's message without its usage lines.
fn one_line(message: &str) -> String {
    let told = message.trim_start_matches("error: ").split("\n\nUsage").next().unwrap_or(message);
    let told = told.split("\n\nFor more").next().unwrap_or(told);
    let words: Vec<&str> = told.split_whitespace().collect();
    words.join(" ") + " (--help lists all)"
}

/// Prints a line on stdout.
pub fn print_line(line: &str) {
    print(&format!("{line}\n"));
}

/// Prints on stdout. When the reader has gone (`| head`), the program ends quietly.
pub fn print(text: &str) {
    if std::io::stdout().lock().write_all(text.as_bytes()).is_err() {
        std::process::exit(0);
    }
}

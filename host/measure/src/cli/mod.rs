//! Command lines: a program's arguments, the command that they name, and errors of one line.

mod print;
mod values;

pub use print::{decimals, figures, name, print, print_line, quoted, short};
pub use values::{MAGNITUDES, count, hertz, number, picture, positive, positive_hertz};

use crate::end;
use clap::error::ErrorKind as Asked;
use clap::{Arg, CommandFactory, FromArgMatches};
use print::printed;
use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

/// Why a command ended early: one line, and the exit code.
#[derive(Debug)]
pub struct Failure {
    message: String,
    code: u8,
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Failure { message, code: 2 }
    }
}

impl Failure {
    /// What was asked for could not be written, or not all of it.
    pub fn unwritten(message: String) -> Self {
        Failure { message, code: 1 }
    }
}

/// Parses the arguments of `P`, the program of this name, and runs it. A wrong option or an error is one line on stderr and exit code 2.
/// `first` is the advice for a user who names no command.
pub fn main<P: CommandFactory + FromArgMatches>(
    name: &str,
    first: &str,
    run: impl FnOnce(&P) -> Result<ExitCode, Failure>,
) -> ExitCode {
    end::listen();
    let error = match parsed::<P>() {
        Ok(program) => return run(&program).unwrap_or_else(fail),
        Err(error) => error,
    };
    match error.kind() {
        Asked::DisplayHelp | Asked::DisplayVersion => {
            print(&error.to_string());
            ExitCode::SUCCESS
        }
        Asked::DisplayHelpOnMissingArgumentOrSubcommand => match std::env::args().nth(1) {
            None => fail(format!("name a command: `{name} help` lists all, {first}")),
            Some(which) => fail(format!("name what to do: `{name} help {which}` lists all")),
        },
        _ => fail(one_line(&error.to_string())),
    }
}

/// The command line. A negative number is a value, not an option; the parser of the value reports errors.
fn parsed<P: CommandFactory + FromArgMatches>() -> Result<P, clap::Error> {
    let takes = |arg: &Arg| !arg.is_positional() && arg.get_action().takes_values();
    let command = P::command().mut_subcommands(|command| {
        command.mut_args(|arg| if takes(&arg) { arg.allow_negative_numbers(true) } else { arg })
    });
    P::from_arg_matches(&command.try_get_matches()?)
}

/// Prints why a command ended early, in one line on stderr, and gives its exit code.
fn fail(failure: impl Into<Failure>) -> ExitCode {
    let Failure { message, code } = failure.into();
    if end::asked().is_some() {
        // What failed is what the signal ended; whoever listens for it ends the program.
        std::thread::sleep(Duration::from_secs(5));
    }
    let _ = writeln!(std::io::stderr(), "error: {}", printed(&message));
    ExitCode::from(code)
}

/// Rust's messages for a text that is not a number, each with the advice to print instead.
const PLAIN: [(&str, &str); 5] = [
    ("invalid digit found in string", "give a whole number from 0 on"),
    ("cannot parse integer from empty string", "give a whole number from 0 on"),
    ("number too large to fit in target type", "give a smaller number"),
    ("invalid float literal", "give a number"),
    ("cannot parse float from empty string", "give a number"),
];

/// clap's message without its usage lines.
fn one_line(message: &str) -> String {
    let told = message.trim_start_matches("error: ").split("\n\nUsage").next().unwrap_or(message);
    let told = told.split("\n\nFor more").next().unwrap_or(told);
    // Of a value that is wrong it says how to pass it on as a file's name.
    let told = told.split("tip: to pass").next().unwrap_or(told);
    let words: Vec<&str> = told.split_whitespace().collect();
    let mut line = words.join(" ");
    for (theirs, plain) in PLAIN {
        line = line.replace(theirs, plain);
    }
    line + " (--help lists all)"
}

//! What every command has in common: options that are right or one line that says what is wrong.

use clap::Parser;
use clap::error::ErrorKind;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

/// Parses the options and runs `command`. A wrong option or an error is one line on stderr and exit code 2.
pub fn main<O: Parser, E: Display>(command: impl FnOnce(O) -> Result<ExitCode, E>) -> ExitCode {
    let options = match O::try_parse() {
        Ok(options) => options,
        Err(error)
            if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) =>
        {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => return fail(one_line(&error.to_string())),
    };
    match command(options) {
        Ok(code) => code,
        Err(error) => fail(error),
    }
}

fn fail(message: impl Display) -> ExitCode {
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

/// Prints a line on stdout. When the reader has gone (`| head`), the program ends quietly.
pub fn print_line(line: &str) {
    if writeln!(std::io::stdout().lock(), "{line}").is_err() {
        std::process::exit(0);
    }
}

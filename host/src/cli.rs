//! The command line of `picket`: the commands, and the parsing of options. An error is one line.

use crate::{
    analyze, bench, c, calibrate, demo, design, docs, end, explain, firmware, flash, python,
    recipe, report, shell, soak, sweep, toolchain, watch, web,
};
use clap::error::ErrorKind as Asked;
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Frequencies, ranges and velocities from a microcontroller's converter: simulated, emulated, recorded, or live from a board.
#[derive(Debug, Parser)]
#[command(name = "picket", version)]
pub struct Picket {
    /// Missing packages are installed by apt-get, as root, without a question
    #[arg(long, global = true)]
    yes: bool,
    #[command(subcommand)]
    command: Command,
}

/// Each has its options beside what it runs.
#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::options::Options),
    Analyze(analyze::command::Options),
    Explain(explain::Options),
    Design(design::Options),
    Simulate(recipe::Options),
    Sweep(sweep::command::Options),
    Report(report::command::Options),
    Bench(bench::command::Options),
    Firmware(firmware::Options),
    Soak(soak::Options),
    Flash(flash::Options),
    Watch(watch::Options),
    Calibrate(calibrate::Options),
    Web(web::Options),
    C(c::Options),
    Python(python::Options),
    Docs(docs::Options),
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
            Command::Sweep(options) => sweep::command::run(options)?,
            Command::Report(options) => report::command::run(options)?,
            Command::Bench(options) => bench::command::run(options)?,
            Command::Firmware(options) => firmware::run(options).map_err(told)?,
            Command::Soak(options) => soak::run(options)?,
            Command::Flash(options) => flash::run(options).map_err(told)?,
            Command::Watch(options) => watch::run(options)?,
            Command::Calibrate(options) => calibrate::run(options)?,
            Command::Web(options) => web::run(options).map_err(told)?,
            Command::C(options) => c::run(options).map_err(told)?,
            Command::Python(options) => python::run(options).map_err(told)?,
            Command::Docs(options) => docs::run(options)?,
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
    end::listen();
    match parsed() {
        Ok(picket) => {
            toolchain::agree(picket.yes);
            picket.command.run().unwrap_or_else(fail)
        }
        Err(error) => {
            match error.kind() {
                Asked::DisplayHelp | Asked::DisplayVersion => {
                    print(&error.to_string());
                    ExitCode::SUCCESS
                }
                Asked::DisplayHelpOnMissingArgumentOrSubcommand => {
                    let which = std::env::args().nth(1).unwrap_or_default();
                    fail(match which.is_empty() {
                    true => "name a command: `picket help` lists all, `picket demo` needs no hardware".to_owned(),
                    false => format!("name what to do: `picket help {which}` lists all"),
                })
                }
                _ => fail(one_line(&error.to_string())),
            }
        }
    }
}

/// The command line. A negative number is a value, not an option; the parser of the value reports errors.
fn parsed() -> Result<Picket, clap::Error> {
    let takes = |arg: &Arg| !arg.is_positional() && arg.get_action().takes_values();
    let command = Picket::command().mut_subcommands(|command| {
        command.mut_args(|arg| if takes(&arg) { arg.allow_negative_numbers(true) } else { arg })
    });
    Picket::from_arg_matches(&command.try_get_matches()?)
}

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

/// A number of the command line.
pub fn number(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "give a number".into())
}

/// A frequency of the command line, hertz: 48000, 48k, 2.5M or 24G.
pub fn hertz(text: &str) -> Result<f64, String> {
    let units = [("k", 1e3), ("M", 1e6), ("G", 1e9)];
    let of = |&(unit, factor): &(&str, f64)| Some((text.strip_suffix(unit)?, factor));
    let (digits, factor) = units.iter().find_map(of).unwrap_or((text, 1.0));
    let number: Result<f64, _> = digits.parse();
    number.map(|number| number * factor).map_err(|_| "give hertz: 48000, 48k or 1M".into())
}

/// Sizes of what is given in units: sums and quotients of them have a meaning, and light is among the frequencies.
pub const MAGNITUDES: RangeInclusive<f64> = 1e-18..=1e18;

/// A frequency above 0.
pub fn positive_hertz(text: &str) -> Result<f64, String> {
    let wrong = || "give a positive number of hertz: 48000, 48k or 1M".into();
    hertz(text).ok().filter(|hz| MAGNITUDES.contains(hz)).ok_or_else(wrong)
}

/// A count from 1 to `MOST`: what is counted takes memory.
pub fn count<const MOST: usize>(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MOST).contains(count));
    count.ok_or_else(|| format!("give at least 1 and at most {MOST}"))
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = number(text).ok().filter(|number| MAGNITUDES.contains(number));
    number.ok_or_else(|| "give a positive number, 1e-18 to 1e18".into())
}

/// The file of a picture: its name tells its kind.
pub fn picture(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|suffix| suffix == "svg" || suffix == "png");
    known.then_some(path).ok_or_else(|| "name the picture .svg or .png".into())
}

/// What a file says of itself, short enough for a message.
pub fn short(text: &str) -> String {
    excerpt(text, 60)
}

/// The first this many characters, and what would move a terminal's cursor as a sign: a message stays what it is, whatever it quotes.
fn excerpt(text: &str, most: usize) -> String {
    let shown = |character: char| if character.is_control() { '\u{fffd}' } else { character };
    let mut words: String = text.chars().take(most).map(shown).collect();
    if text.chars().nth(most).is_some() {
        words += "...";
    }
    words
}

/// An error as it is printed: its lines, none of them longer than anybody reads.
fn printed(message: &str) -> String {
    const LINES: usize = 100;
    let lines: Vec<String> = message.lines().take(LINES).map(|line| excerpt(line, 2000)).collect();
    lines.join("\n")
}

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let plain =
        !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_./,+:".contains(c));
    if plain { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Prints a line on stdout.
pub fn print_line(line: &str) {
    print(&format!("{line}\n"));
}

/// Prints on stdout. When the reader has gone (`| head`), the program ends quietly; when stdout takes no more (a full disk), it
/// ends with exit code 1 and says how much was written.
pub fn print(text: &str) {
    static LINES: AtomicU64 = AtomicU64::new(0);
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Ok(()) => {
            LINES.fetch_add(text.lines().count() as u64, Ordering::Relaxed);
        }
        Err(error) if error.kind() == ErrorKind::BrokenPipe => end::leave(0),
        Err(error) => {
            let lines = LINES.load(Ordering::Relaxed);
            let _ = writeln!(
                std::io::stderr(),
                "error: stdout: {error}; {lines} lines were written before"
            );
            end::leave(1)
        }
    }
}

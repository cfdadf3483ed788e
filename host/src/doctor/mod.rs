//! `picket doctor`: the first power-up, in ten checks. It asks the board for its identity and state, and changes nothing on it.

mod checks;
mod facts;
mod report;
mod self_test;

use crate::cli::print_line;
use crate::output::Output;
use crate::watch::port::Source;
use crate::watch::{WatchError, ports};
use checks::Check;
use clap::Args;
use facts::Facts;
use std::fmt;
use std::path::PathBuf;
use std::process::ExitCode;

/// Goes through a board's first power-up: ten checks, each with its cause if it does not hold, and a report to send.
#[derive(Args, Debug)]
pub struct Options {
    /// The board's serial port; without it the ports are listed
    port: Option<String>,
    /// File for the report as JSON; the list goes next to it, as text [default: picket-doctor.json, then picket-doctor-2.json and so on]
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Duration of the checks, in seconds of the board
    #[arg(long, value_name = "SECONDS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(2..=600))]
    seconds: u32,
    /// Has the board try itself afterwards, with one wire, on a NUCLEO from A2 to A0, on a Pico from GP14 to GP26: clocks, noise, five rates,
    /// the chirp, saved settings, watchdog
    #[arg(long)]
    self_test: bool,
    /// With --self-test: watches each rate for a moment instead of ten seconds
    #[arg(long, requires = "self_test")]
    quick: bool,
    /// The board is emulated: its seconds are not this computer's
    #[arg(long, hide = true)]
    emulated: bool,
    #[command(flatten)]
    output: Output,
}

/// Why there is no list.
#[derive(Debug)]
pub enum DoctorError {
    /// No port is named.
    Port(WatchError),
    /// The report cannot be written.
    Report(String),
}

impl fmt::Display for DoctorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DoctorError::Port(error) => error.fmt(f),
            DoctorError::Report(said) => f.write_str(said),
        }
    }
}

/// Runs the checks. The exit code is 1 if one does not hold.
pub fn run(options: &Options) -> Result<ExitCode, DoctorError> {
    let Some(port) = &options.port else {
        let (lines, first) = ports::list();
        lines.iter().for_each(|line| eprintln!("{line}"));
        return Err(DoctorError::Port(WatchError::Nameless(first)));
    };
    let report = options.report.clone().unwrap_or_else(|| next(options.output));
    let list = report.with_extension("txt");
    for file in [&report, &list] {
        options.output.check(file, &[]).map_err(DoctorError::Report)?;
    }
    let (facts, source) = match Source::open(Some(port), None) {
        Ok(mut source) => {
            let facts = Facts::gather(&mut source, options.seconds, options.emulated);
            (facts, Some(source))
        }
        Err(error) => (Facts { failure: Some(error.to_string()), ..Facts::default() }, None),
    };
    let checks = checks::all(&facts, options.emulated);
    let mut lines: Vec<String> = checks.iter().flat_map(Check::lines).collect();
    lines.iter().for_each(|line| print_line(line));
    let held = checks.iter().filter(|check| check.held()).count();
    let mut result = format!("result: {held} of {} hold", checks.len());
    print_line(&result);
    let mut holds = held == checks.len();
    if let (true, Some(mut source), Some(boot)) = (options.self_test, source, facts.boot) {
        let tried = self_test::listen(&mut source, boot.program, options.quick, options.emulated);
        let (list, held) = tried.map_err(DoctorError::Port)?;
        holds &= held;
        lines.push(std::mem::take(&mut result));
        result = list.last().cloned().unwrap_or_default();
        lines.extend(list.into_iter().rev().skip(1).collect::<Vec<_>>().into_iter().rev());
    }
    let json = report::json(port, &facts, &checks, &lines);
    options.output.write(&report, json.as_bytes()).map_err(DoctorError::Report)?;
    let text = report::text(&facts, &lines, &result);
    options.output.write(&list, text.as_bytes()).map_err(DoctorError::Report)?;
    eprintln!("{} and {} are the report", report.display(), list.display());
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// The first report here that no run before has written.
fn next(output: Output) -> PathBuf {
    let name = |number: u32| match number {
        1 => PathBuf::from("picket-doctor.json"),
        number => format!("picket-doctor-{number}.json").into(),
    };
    let free = |file: &PathBuf| !(file.exists() || file.with_extension("txt").exists());
    let free = |file: &PathBuf| output.force || free(file);
    (1..1000).map(name).find(free).unwrap_or_else(|| name(1))
}

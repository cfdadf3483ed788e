//! The main job without hardware: the firmware under emulation, fed with scenes or a recording.
//!
//! A demonstration is a scene of [`crate::scenario`], what measures it, and what is shown of the answers: each file here says this of one, and the
//! rest is the same for all.

mod cars;
pub mod drive;
mod fan;
mod feed;
mod ldv;
mod nucleo;
pub mod options;
pub mod pico;
mod replay;
pub mod seeds;
mod session;
pub mod shown;
pub mod table;
mod traffic;
mod vibration;
mod wind;

use options::{Board, Options, Scenario};
use shown::Shown;
use std::fmt::Display;
use std::process::ExitCode;

/// An error in one line, with the cure.
#[derive(Debug)]
pub struct DemoError(pub String);

impl Display for DemoError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for DemoError {}

/// Any error as its one line.
pub fn said(error: impl Display) -> DemoError {
    DemoError(error.to_string())
}

/// Does what the options say and prints it. Failure: it is not as it should be.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    fits(options)?;
    if let Some(file) = &options.plot {
        options.output.check(file, &[]).map_err(said)?;
        if options.scenario.has_two_pictures() {
            options.output.check(&shown::beside(file), &[]).map_err(said)?;
        }
    }
    if let Some(file) = &options.replay {
        return replay::run(file, options);
    }
    if options.seeds > 1 || options.versus.is_some() {
        return seeds::run(options);
    }
    match options.scenario {
        Scenario::Board => session::run(options),
        Scenario::Table3 if options.board == Board::Mps2 => table::here_and_there(options),
        _ => measured(options)?.show(options),
    }
}

/// What a scene gives.
pub fn measured(options: &Options) -> Result<Shown, DemoError> {
    match options.scenario {
        Scenario::Table3 => table::lidar(options)?.shown(options),
        Scenario::Radar => table::radar(options)?.shown(options),
        Scenario::Turntable => table::turntable(options)?.shown(options),
        Scenario::Drive => drive::measured(options),
        Scenario::Traffic => traffic::measured(options),
        Scenario::Cars => cars::measured(options),
        Scenario::Vibration => vibration::measured(options),
        Scenario::Ldv => ldv::measured(options),
        Scenario::Wind => wind::measured(options),
        Scenario::Fan => fan::measured(options),
        Scenario::Board => Err(said("a session is bytes: add --record FILE")),
    }
}

/// Refuses options that this run would ignore.
fn fits(options: &Options) -> Result<(), DemoError> {
    use Scenario::{Drive, Ldv, Radar, Table3, Turntable, Wind};
    let is = |scenario| options.scenario == scenario;
    let (table, board, core) = (is(Table3), is(Scenario::Board), options.scenario.is_by_the_core());
    let (replay, json, log) = (options.replay.is_some(), options.json, options.log.is_some());
    let (method, plot) = (options.method.is_some(), options.plot.is_some());
    let versus = options.versus.is_some();
    let several = options.seeds > 1;
    let pico = options.board == Board::Pico;
    let nucleo = options.board == Board::Nucleo;
    let laser = options.linewidth_hz.is_some() || options.sweep_error.is_some();
    let refused = [
        (
            board && (method || options.snr_db.is_some() || log || json),
            "the board's session has its own method and noise, and no log or JSON: picket watch --jsonl prints it",
        ),
        (
            options.record.is_some() && !board,
            "--record keeps a board's session: add --scenario board",
        ),
        (
            nucleo && (!(is(Ldv) || is(Wind)) || replay),
            "the NUCLEO adds blocks and takes bursts here: use --scenario ldv or wind",
        ),
        (
            pico && !replay && !table,
            "the Pico measures the lidar's records or a recording: use --scenario table3 or --replay",
        ),
        (
            pico && (options.iq || log || (replay && options.n != feed::N)),
            "the Pico has real blocks of 1024 samples, and no log",
        ),
        (
            options.mixing.is_some() && !is(Radar),
            "--mixing is of the radar's receiver: add --scenario radar",
        ),
        (
            plot && (board || is(Radar)),
            "--plot draws other scenes than radar and board: add --scenario drive",
        ),
        (plot && (several || versus), "--plot draws one run: leave --seeds and --versus out"),
        (
            laser && !table,
            "--linewidth-hz and --sweep-error are of the lidar's laser: use --scenario table3",
        ),
        (
            options.spot_mm.is_some() && !is(Turntable),
            "--spot-mm is of the turntable's beam: add --scenario turntable",
        ),
        (
            (is(Drive) || core) && method,
            "this scene is measured by least squares: leave --method out",
        ),
        (core && log, "this scene is measured by the core on this machine, which has no log"),
        (
            versus && !table,
            "--versus compares methods on the lidar's targets: use --scenario table3",
        ),
        (several && !table, "--seeds sums up the lidar's targets: use --scenario table3"),
    ];
    refused.into_iter().find(|(wrong, _)| *wrong).map_or(Ok(()), |(_, why)| Err(said(why)))
}

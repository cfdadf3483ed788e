//! The main job without hardware: the firmware under emulation, fed with targets or a recording.

pub mod answer;
pub mod drive;
mod errors;
pub mod fan;
pub mod ldv;
pub mod measure;
mod nucleo;
pub mod options;
pub mod pico;
pub mod replay;
pub mod seeds;
mod session;
pub mod table;
pub mod traffic;
pub mod vibration;
pub mod wind;

use crate::scenario;
use options::{Board, Options, Scenario};
use std::fmt::Display;
use std::path::Path;
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

/// Draws what a scenario has measured, and writes its lines for programs or prints it for people. Failure: it is not as it should be.
fn shown(
    options: &Options,
    draw: impl FnOnce(&Path) -> Result<(), DemoError>,
    lines: impl FnOnce() -> Result<(), DemoError>,
    print: impl FnOnce(),
    inside: bool,
) -> Result<ExitCode, DemoError> {
    if let Some(file) = &options.plot {
        draw(file)?;
    }
    if options.json {
        lines()?;
    } else {
        print();
    }
    Ok(if inside { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Does what the options say and prints it. Failure: a row is outside the bars.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    fits(options)?;
    if let (Some(file), Scenario::Table3) = (&options.plot, options.scenario) {
        drive::check_both(file, options.output)?;
    } else if let Some(file) = &options.plot {
        options.output.check(file, &[]).map_err(said)?;
    }
    if let Some(file) = &options.replay {
        return replay::run(file, options);
    }
    if options.seeds > 1 || options.versus.is_some() {
        return seeds::run(options);
    }
    let summary = match options.scenario {
        Scenario::Table3 if options.board == Board::Mps2 => return table3(options),
        Scenario::Table3 => measure::lidar(options)?,
        Scenario::Radar => measure::radar(options)?,
        Scenario::Turntable => measure::turntable(options)?,
        Scenario::Drive => return drive::run(options),
        Scenario::Traffic => return traffic::run(options),
        Scenario::Vibration => return vibration::run(options),
        Scenario::Ldv => return ldv::run(options),
        Scenario::Wind => return wind::run(options),
        Scenario::Fan => return fan::run(options),
        Scenario::Board => return session::run(options),
    };
    let text = || match options.scenario {
        Scenario::Table3 => summary.lidar_text(),
        Scenario::Radar => summary.radar_text(),
        _ => summary.turntable_text(),
    };
    shown(
        options,
        |file| errors::draw(&summary, options.scenario, file, options.output),
        || summary.json().map_err(said).map(|lines| out!("{lines}")),
        || out!("{}\n\n{}", heading(options), text()),
        summary.inside() == summary.results.len(),
    )
}

/// The lidar's rows as the library measures them on this machine, at once, and then as the emulated board does: both have the same bits.
fn table3(options: &Options) -> Result<ExitCode, DemoError> {
    let lidar = measure::Lidar::new(options.method, options.laser())?;
    let here = lidar.on_host(options.snr_db(), options.seed, options.seeds)?;
    let people = !options.json;
    if people {
        let summary = lidar.summary(here.iter(), options.seeds);
        outln!("{}\n\n{}", heading(options), summary.lidar_text());
        outln!(
            "by the library on this machine; now the firmware measures the same samples on an emulated Cortex-M33"
        );
    }
    let there = lidar.on_board(options)?;
    let board = lidar.summary(there.iter(), options.seeds);
    let different = lidar.different(&here, &there);
    let rows = board.results.len();
    if let Some(file) = &options.plot {
        errors::draw(&board, options.scenario, file, options.output)?;
    }
    if !people {
        out!("{}", board.json().map_err(said)?);
    }
    if different.is_empty() {
        if people {
            outln!("the board: all {rows} rows the same, bit for bit");
        }
    } else {
        let which: Vec<String> = different.iter().map(usize::to_string).collect();
        if people {
            out!("{}", board.lidar_text());
        }
        eprintln!(
            "error: the board's bits differ in {} of {rows} rows: {}",
            which.len(),
            which.join(", ")
        );
    }
    let right = different.is_empty() && board.inside() == rows;
    Ok(if right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Refuses options that this run would ignore.
fn fits(options: &Options) -> Result<(), DemoError> {
    let drive = options.scenario == Scenario::Drive;
    let board = options.scenario == Scenario::Board;
    let own = options.method.is_some() || options.snr_db.is_some();
    if board && (own || options.log.is_some() || options.json) {
        return Err(said(
            "the board's session has its own method and noise, and no log or JSON: picket watch --jsonl prints it",
        ));
    }
    if options.record.is_some() && !board {
        return Err(said("--record keeps a board's session: add --scenario board"));
    }
    let scene = matches!(options.scenario, Scenario::Ldv | Scenario::Wind);
    if options.board == Board::Nucleo && (!scene || options.replay.is_some()) {
        return Err(said(
            "the NUCLEO adds blocks and takes bursts here: use --scenario ldv or wind",
        ));
    }
    let pico = options.board == Board::Pico;
    let replay = options.replay.is_some();
    if pico && !replay && options.scenario != Scenario::Table3 {
        return Err(said(
            "the Pico measures the lidar's records or a recording: use --scenario table3 or --replay",
        ));
    }
    if pico && (options.iq || options.log.is_some() || (replay && options.n != measure::N)) {
        return Err(said("the Pico has real blocks of 1024 samples, and no log"));
    }
    if options.mixing.is_some() && options.scenario != Scenario::Radar {
        return Err(said("--mixing is of the radar's receiver: add --scenario radar"));
    }
    let core = options.scenario.is_by_the_core();
    let table = matches!(options.scenario, Scenario::Table3);
    if options.plot.is_some() && (board || options.scenario == Scenario::Radar) {
        return Err(said("--plot draws other scenes than radar and board: add --scenario drive"));
    }
    if options.plot.is_some() && (options.seeds > 1 || options.versus.is_some()) {
        return Err(said("--plot draws one run: leave --seeds and --versus out"));
    }
    if (options.linewidth_hz.is_some() || options.sweep_error.is_some()) && !table {
        return Err(said(
            "--linewidth-hz and --sweep-error are of the lidar's laser: use --scenario table3",
        ));
    }
    if options.spot_mm.is_some() && options.scenario != Scenario::Turntable {
        return Err(said("--spot-mm is of the turntable's beam: add --scenario turntable"));
    }
    if (drive || core) && options.method.is_some() {
        return Err(said("this scene is measured by least squares: leave --method out"));
    }
    if core && options.log.is_some() {
        return Err(said("this scene is measured by the core on this machine, which has no log"));
    }
    if options.versus.is_some() && options.scenario != Scenario::Table3 {
        return Err(said(
            "--versus compares methods on the lidar's targets: use --scenario table3",
        ));
    }
    if options.seeds > 1 && options.scenario != Scenario::Table3 {
        return Err(said("--seeds sums up the lidar's targets: use --scenario table3"));
    }
    Ok(())
}

fn heading(options: &Options) -> String {
    let (snr, seed) = (options.snr_db(), options.seed);
    match options.scenario {
        Scenario::Table3 if options.board == Board::Pico => format!(
            "The lidar of Ye et al. 2022 at a Pico's 500 kS/s, ramps of {:.3} ms solved by the host, N = {}, {snr} dB, seed {seed}",
            1e3 * measure::N as f64 / pico::RATE_HZ,
            measure::N
        ),
        Scenario::Table3 => format!(
            "Lidar of Ye et al. 2022: 1550 nm, 1 GHz in 10 us, 12 bits at 250 MS/s, N = {} per ramp, {snr} dB, seed {seed}",
            measure::N
        ),
        Scenario::Radar => format!(
            "Radar: 24 GHz, 200 MHz in 4.224 ms, I/Q ({}), 12 bits at 250 kS/s, N = {} per ramp, {snr} dB, seed {seed}",
            options.mixing().name(),
            measure::N
        ),
        _ => format!(
            "Velocimeter of Yang et al. 2011: 1550 nm, rim of {} mm, I/Q at 10 MS/s, N = {}, {snr} dB, seed {seed}",
            scenario::TURNTABLE_RADIUS_M * 1e3,
            measure::N
        ),
    }
}

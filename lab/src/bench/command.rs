//! `lab bench`: instructions of every stage on emulated cores, beside other people's transforms.

use super::cycles::Clock;
use super::model::Model;
use super::worst::Worst;
use super::{self as bench, CORES, Core, ENGINES, How, LENGTHS, Row, Scope};
use crate::analyze::input::effort;
use crate::output::Output;
use crate::toolchain::{Need, ToolError, have};
use crate::{cli, progress};
use clap::Args;
use picket_dsp::tone::fit::Reach;
use picket_dsp::{Codes, Effort, Iq, Real};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Counts instructions and models cycles of every stage of a measurement on emulated Cortex-M cores.
///
/// Beside them are cycles, modelled by Arm's tables from the program as it was executed, without wait states, caches and interrupts, for
/// cores of which there is such a table. The records are a seeded corpus: tones in noise at any frequency, at the threshold, at the edges, several
/// lines, coloured noise, noise alone, silence, impulses, and records with samples at the rails, whose most is a column of
/// its own. `--search 60` breeds signals from those that take longest, for the worst block that it can find. Figures marked with a star are quoted.
#[derive(Args, Debug)]
pub struct Options {
    /// Cores, separated by commas: M4F, M33, M55, M7, M3, M0
    #[arg(long, value_delimiter = ',', default_value = "M4F,M33,M55,M7,M3,M0")]
    core: Vec<String>,
    /// Engines of ours, separated by commas: i32, f32, the last on cores with an FPU
    #[arg(long, value_delimiter = ',', default_value = "i32,f32")]
    engine: Vec<String>,
    /// Record lengths, separated by commas
    #[arg(long, value_delimiter = ',')]
    n: Vec<usize>,
    /// Bins on each side that least squares reads: 4, 8 or 16
    #[arg(long, default_value_t = 16)]
    k: usize,
    /// How closely a line that is no steady tone is looked at
    #[arg(long, value_name = "EFFORT", default_value = Effort::default().name(), value_parser = effort)]
    effort: Effort,
    /// Random blocks that kernels and their definition are compared on, at each length
    #[arg(long, default_value_t = 20)]
    random: u32,
    /// Generations of 64 signals each in a search for the worst block, of any shape: 0 for none
    #[arg(long, default_value_t = 0)]
    search: usize,
    /// The seed of that search
    #[arg(long, default_value_t = bench::worst::SEED)]
    seed: u64,
    /// Searches I/Q records
    #[arg(long, requires = "search")]
    iq: bool,
    /// Searches records of codes of 16 bits instead of 12
    #[arg(long, requires = "search")]
    wide: bool,
    /// Counts a block of the tracker instead, N = 1024: measured where its tone is expected, and searched whole
    #[arg(long, conflicts_with_all = ["n", "k", "effort", "plot", "search", "seed"])]
    locked: bool,
    /// Counts the further tones of a block instead, N = 1024, beside its first
    #[arg(long, conflicts_with_all = ["n", "k", "effort", "plot", "search", "seed", "locked"])]
    several: bool,
    /// Counts what the frequency of a tone takes instead, beside its error at 20 and 40 dB: ours, and other transforms with the largest
    /// bin and Jacobsen's interpolation
    #[arg(long, conflicts_with_all = ["engine", "k", "effort", "random", "search", "seed", "locked", "several"])]
    precision: bool,
    /// Draws instructions over N for the first core into this SVG file; with `--precision` error over cycles
    #[arg(long)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
    /// One JSON object a line
    #[arg(long)]
    json: bool,
}

/// Counts and prints.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    if let Some(path) = &options.plot {
        options.output.check(path, &[])?;
    }
    let cores = options.core.iter().map(|name| {
        let core = CORES.iter().find(|core| core.name.eq_ignore_ascii_case(name));
        core.ok_or_else(|| format!("there is no core {name}: choose of M4F, M33, M55, M7, M3, M0"))
    });
    let cores = cores.collect::<Result<Vec<_>, _>>()?;
    let ready = || {
        let each = cores.iter().map(|core| Need::Core(core.target));
        let needs: Vec<Need> = each.chain([Need::Emulator]).collect();
        have(&needs).map_err(|error| error.to_string())
    };
    if options.locked {
        ready()?;
        return locked(&cores, options.random, options.json);
    }
    if options.several {
        ready()?;
        return several(&cores, options.json);
    }
    let lengths = if options.n.is_empty() { LENGTHS.to_vec() } else { options.n.clone() };
    if let Some(n) = lengths.iter().find(|n| !LENGTHS.contains(n)) {
        return Err(format!("N = {n}: choose of 64, 128, ... 4096"));
    }
    if options.precision {
        ready()?;
        return precision(options, &cores, &lengths);
    }
    let reach = match options.k {
        4 => Reach::Four,
        8 => Reach::Eight,
        16 => Reach::Sixteen,
        k => return Err(format!("K = {k}: choose 4, 8 or 16")),
    };
    let how = How { reach, effort: options.effort, ..How::default() };
    let engines = options.engine.iter().map(|name| {
        let engine = ENGINES.iter().find(|engine| engine.name.ends_with(name.as_str()));
        engine.ok_or_else(|| format!("there is no engine {name}: choose of i32, f32"))
    });
    let engines = engines.collect::<Result<Vec<_>, _>>()?;
    ready()?;
    let pairs: usize =
        cores.iter().map(|core| engines.iter().filter(|engine| engine.is_for(core)).count()).sum();
    let bar = progress::bar((pairs * lengths.len()) as u64, "runs");
    let (mut rows, mut compared, mut unequal) = (Vec::new(), 0, 0);
    let mut quoted = None;
    for core in cores {
        let engines = engines.iter().filter(|engine| engine.is_for(core));
        let images = engines.map(|&engine| Ok((engine, bench::image(core, engine, Scope::All)?)));
        let images = images.collect::<Result<Vec<_>, ToolError>>().map_err(|e| e.to_string())?;
        for &n in &lengths {
            let mut new = Vec::new();
            for (engine, image) in &images {
                let model = Model::of(core, image, n, how).map_err(|error| error.to_string())?;
                let counts = bench::count(core, engine, image, n, how, options.random);
                let count = counts.map_err(|error| error.to_string())?;
                let (blocks, different) = count.equality();
                (compared, unequal) = (compared + blocks, unequal + different);
                let mut rows = count.rows(model.as_ref());
                if options.search > 0 {
                    let found = search(options, core, image, n, how)?;
                    let whole = rows.iter_mut().filter(|row| row.stage == "measurement");
                    whole.for_each(|row| row.found = found);
                }
                new.extend(rows);
                bar.inc(1);
            }
            // What cannot be had is not asked for again.
            let counted = quoted.is_none().then(|| bench::cmsis::rows(core, n)).transpose();
            let counted = counted.unwrap_or_else(|error| {
                quoted = Some(error);
                None
            });
            new.extend(counted.unwrap_or_else(|| bench::quoted::rows(core, n)));
            if options.json {
                for row in &new {
                    print_json(row)?;
                }
            }
            rows.extend(new);
        }
    }
    bar.finish_and_clear();
    if let Some(path) = &options.plot {
        let core = rows.first().map_or("M4F", |row: &Row| row.core);
        let text = bench::plot::chart(&rows, core).svg()?;
        options.output.write(path, text.as_bytes())?;
    }
    if options.json {
        cli::print_line(
            &serde_json::json!({
                "summary": true, "rows": rows.len(), "blocks_compared": compared, "blocks_unequal": unequal,
            })
            .to_string(),
        );
    } else {
        cli::print_line(&bench::table::table(&rows).to_string());
        cli::print_line(&format!(
            "Instructions counted on emulated cores, least squares with K = {}, records of seed {}: median, 95 % and worst of those \
             without a sample at a rail, worst of those with; then the most that `--search` found, without and with. Cycles \
             are modelled: the median of a quarter of the records.\n\
             {}Kernel and portable definition: {compared} blocks compared, {unequal} differ.",
            options.k,
            bench::SEED,
            quoted.map_or(String::new(), |error| format!("* {}: {error}\n", bench::quoted::SOURCE)),
        ));
    }
    Ok(if unequal == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The worst block that a search finds, without a sample at a rail and with. The log gets the signals.
fn search(
    options: &Options,
    core: &Core,
    image: &Path,
    n: usize,
    how: How,
) -> Result<[Option<u64>; 2], String> {
    let (seed, generations) = (options.seed, options.search);
    let codes = if options.wide { Codes::signed::<16>() } else { how.codes };
    let how = How { codes, ..how };
    let found = if options.iq {
        bench::worst::search::<Iq>(core, image, n, how, seed, generations)
    } else {
        bench::worst::search::<Real>(core, image, n, how, seed, generations)
    };
    let found = found.map_err(|error| error.to_string())?;
    for (kind, worst) in ["", " with samples at a rail"].iter().zip(&found) {
        if let Some(worst) = worst {
            let (name, Worst { instructions, cycles, signal }) = (core.name, worst);
            let cycles = cycles.map_or(String::new(), |cycles| format!(", {cycles} cycles"));
            eprintln!("{name}, N = {n}{kind}: {instructions} instructions{cycles} by {signal}");
        }
    }
    Ok(found.map(|worst| worst.map(|worst| worst.instructions)))
}

/// Cycles and errors of tones.
fn precision(
    options: &Options,
    cores: &[&'static Core],
    lengths: &[usize],
) -> Result<ExitCode, String> {
    let modelled = |core: &&&Core| Clock::of(core).is_some() && core.has_fpu();
    if let Some(core) = cores.iter().find(|core| !modelled(core)) {
        return Err(format!(
            "{}: cycles of floats are modelled of the M4F alone: type --core M4F",
            core.name
        ));
    }
    let bar = progress::bar((cores.len() * lengths.len()) as u64, "lengths");
    let (mut points, mut missing) = (Vec::new(), None);
    for core in cores {
        for &n in lengths {
            let (new, without) = bench::precision::points(core, n)?;
            missing = missing.or(without);
            if options.json {
                new.iter().try_for_each(print_json)?;
            }
            points.extend(new);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    if let Some(path) = &options.plot {
        let text = bench::precision::chart(&points).svg()?;
        options.output.write(path, text.as_bytes())?;
    }
    if options.json {
        print_json(&serde_json::json!({ "summary": true, "rows": points.len() }))?;
    } else {
        cli::print_line(&bench::table::precision(&points).to_string());
        cli::print_line(&format!(
            "Modelled cycles from a record to the frequency of its tone, and the rms error over the Cramer-Rao bound of {} tones in the middle \
             half of the spectrum, seed {}.{}",
            bench::precision::TONES,
            bench::SEED,
            missing.map_or(String::new(), |error| format!("\nWithout CMSIS-DSP: {error}")),
        ));
    }
    Ok(ExitCode::SUCCESS)
}

/// The tracker's blocks.
fn locked(cores: &[&'static Core], random: u32, json: bool) -> Result<ExitCode, String> {
    let (here, _) = bench::locked::here().map_err(|error| error.to_string())?;
    let (mut rows, mut same, mut compared, mut unequal) = (Vec::new(), true, 0, 0);
    for core in cores {
        let image = bench::locked::image(core).map_err(|error| error.to_string())?;
        let count =
            bench::locked::count(core, &image, random).map_err(|error| error.to_string())?;
        same &= count.telemetry == here;
        (compared, unequal) = (compared + count.equality.0, unequal + count.equality.1);
        rows.extend(count.rows);
    }
    if json {
        rows.iter().try_for_each(print_json)?;
        print_json(&serde_json::json!({ "summary": true, "rows": rows.len(), "same_bits": same,
            "blocks_compared": compared, "blocks_unequal": unequal,
        }))?;
    } else {
        cli::print_line(&bench::table::locked(&rows).to_string());
        let bits = if same { "the same bits as on this machine" } else { "OTHER BITS than here" };
        cli::print_line(&format!(
            "Instructions of blocks of 1024 samples, counted on emulated cores. Records and tracks: {bits}.\n\
             Kernel and portable definition: {compared} blocks compared, {unequal} differ."
        ));
    }
    Ok(if same && unequal == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Blocks of one to four tones.
fn several(cores: &[&'static Core], json: bool) -> Result<ExitCode, String> {
    let (here, _) = bench::several::here().map_err(|error| error.to_string())?;
    let (mut all, mut same) = (Vec::new(), true);
    for core in cores {
        let image = bench::several::image(core).map_err(|error| error.to_string())?;
        let (rows, sent) =
            bench::several::count(core, &image).map_err(|error| error.to_string())?;
        same &= sent == here;
        all.extend(rows);
    }
    if json {
        all.iter().try_for_each(print_json)?;
        print_json(&serde_json::json!({ "summary": true, "rows": all.len(), "same_bits": same }))?;
    } else {
        cli::print_line(&bench::table::several(&all).to_string());
        let bits = if same { "the same bits as on this machine" } else { "OTHER BITS than here" };
        cli::print_line(&format!(
            "Instructions of blocks of 1024 samples, counted on emulated cores: the measurement, then its phase or all tones beside. Tones: {bits}."
        ));
    }
    Ok(if same { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn print_json(row: &impl serde::Serialize) -> Result<(), String> {
    cli::print_line(&serde_json::to_string(row).map_err(|error| error.to_string())?);
    Ok(())
}

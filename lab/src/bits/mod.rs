//! `lab bits`: whether a change of the library keeps the bits of its answers.
//!
//! A record is drawn by its number and the seed alone: a scene with one thing wrong, a kind, a length, an engine, settings, and the way of its
//! samples through the library. The bits of all answers to it make its digest.

mod case;
mod digest;
mod measure;

use crate::impair::Impairment;
use crate::output::Output;
use crate::{cli, progress};
use case::Case;
use clap::Args;
use digest::Digest;
use picket_dsp::acquire::sample::{Iq, Real};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Measures many records of every impairment, and prints digests of the answers' bits. A change of the library that keeps the answers keeps
/// the digests. With `--compare` the exit code is 1 if a digest differs.
#[derive(Args, Debug)]
pub struct Options {
    /// Records
    #[arg(long, default_value_t = 10_000)]
    records: u64,
    /// Seed of the records
    #[arg(long, default_value_t = 58)]
    seed: u64,
    /// Shows the answers to the record of this number, a line for each number, in place of digests
    #[arg(long, value_name = "NUMBER", conflicts_with_all = ["records", "out", "compare"])]
    record: Option<u64>,
    /// Writes the digest of each record into this file, JSON
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Prints what differs from this file of an earlier `--out`, whose seed and number of records it takes
    #[arg(long, value_name = "FILE", conflicts_with_all = ["records", "seed"])]
    compare: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// The digests of records, by their numbers. JSON has them in hexadecimal digits, which no reader rounds.
#[derive(Debug, Serialize, Deserialize)]
struct Digests {
    seed: u64,
    digests: Vec<String>,
}

/// Runs the command.
///
/// # Errors
/// A file cannot be read or written.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let all = impairments();
    if let Some(number) = options.record {
        let (label, digest) = answered(&all, options.seed, number, true)?;
        cli::print(&format!("{label}\n{}{:016x}\n", digest.lines(), digest.hash()));
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(out) = &options.out {
        options.output.check(out, &[])?;
    }
    let before = options.compare.as_deref().map(read).transpose()?;
    let (seed, count) = match &before {
        Some(before) => (before.seed, before.digests.len() as u64),
        None => (options.seed, options.records),
    };
    let bar = progress::bar(count, "records");
    let found = (0..count).into_par_iter().map(|number| {
        let (label, digest) = answered(&all, seed, number, false)?;
        bar.inc(1);
        Ok((label, format!("{:016x}", digest.hash())))
    });
    let found: Vec<(String, String)> = found.collect::<Result<_, String>>()?;
    bar.finish_and_clear();
    if let Some(out) = &options.out {
        let digests = found.iter().map(|(_, digest)| digest.clone()).collect();
        let json = serde_json::to_vec(&Digests { seed, digests });
        options.output.write(out, &json.map_err(|error| error.to_string())?)?;
    }
    match before {
        Some(before) => Ok(compare(&found, &before)),
        None => {
            print(&found);
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn read(file: &Path) -> Result<Digests, String> {
    let text = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    serde_json::from_slice(&text).map_err(|error| format!("{}: {error}", file.display()))
}

/// Every impairment, once for each kind of record that can have it.
fn impairments() -> Vec<(Impairment, bool)> {
    let all = [Impairment::all(), Impairment::signals(), Impairment::front_end()].concat();
    let both = all.into_iter().flat_map(|impairment| {
        let fits = [impairment.fits::<Real>(), impairment.fits::<Iq>()];
        let kinds = [false, true].into_iter().zip(fits).filter(|(_, fits)| *fits);
        kinds.map(|(iq, _)| (impairment.clone(), iq)).collect::<Vec<_>>()
    });
    both.collect()
}

/// A record's label and the digest of its answers.
fn answered(
    all: &[(Impairment, bool)],
    seed: u64,
    number: u64,
    listed: bool,
) -> Result<(String, Digest), String> {
    let mut case = Case::new(all, seed, number).ok_or("there is no such record")?;
    let mut digest = Digest::new(listed);
    let label = case.label();
    measure::measure(&mut case, &mut digest)
        .map_err(|error| format!("record {number}, {label}: {error}"))?;
    Ok((label, digest))
}

/// One line for each way, kind, length and engine, and one for all.
fn print(found: &[(String, String)]) {
    let mut rows = BTreeMap::<Vec<&str>, (u64, Digest)>::new();
    let mut total = Digest::new(false);
    for (label, digest) in found {
        // The impairment is the label's last word.
        let key = label.split(' ').take(4).collect();
        let (count, sum) = rows.entry(key).or_insert_with(|| (0, Digest::new(false)));
        *count += 1;
        sum.of(digest);
        total.of(digest);
    }
    for (label, (count, sum)) in &rows {
        cli::print_line(&format!("{:28} {count:>7} {:016x}", label.join(" "), sum.hash()));
    }
    cli::print_line(&format!("{:28} {:>7} {:016x}", "all", found.len(), total.hash()));
}

/// One line for each label with records that differ.
fn compare(found: &[(String, String)], before: &Digests) -> ExitCode {
    let mut rows = BTreeMap::<&str, (u64, u64, u64)>::new();
    let pairs = found.iter().zip(&before.digests).zip(0..);
    for (((label, now), was), number) in pairs {
        let (of, differ, first) = rows.entry(label).or_insert((0, 0, number));
        if now != was {
            *first = if *differ == 0 { number } else { *first };
            *differ += 1;
        }
        *of += 1;
    }
    let mut sum = 0;
    for (label, (of, differ, first)) in rows {
        if differ > 0 {
            cli::print_line(&format!("{label}: {differ} of {of} differ, the first is {first}"));
            sum += differ;
        }
    }
    cli::print_line(&format!("{sum} of {} records differ", found.len()));
    if sum == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

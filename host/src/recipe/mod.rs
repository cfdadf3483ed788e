//! `picket simulate`: the recording that a recipe of docs/recipes should give, by the physics of its sensor and the filter of its circuit.

pub mod circuit;
mod fmcw;
mod hb100;
mod laser;

use crate::cli;
use crate::output::Output;
use clap::{Args, ValueEnum};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::path::PathBuf;
use std::process::ExitCode;

/// Writes the recording that a recipe of docs/recipes should give: the physics of its sensor, the filter of its circuit, codes of 12 bits from 0
/// on, as a file of 16-bit integers. Prints what is in it.
#[derive(Args, Debug)]
pub struct Options {
    /// The recipe
    #[arg(value_enum)]
    recipe: Recipe,
    /// Where it is written
    file: PathBuf,
    /// Distance at the start, m [default: the recipe's]
    #[arg(long, value_name = "M", value_parser = cli::positive)]
    range_m: Option<f64>,
    /// Speed, m/s; towards the sensor [default: the recipe's]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true, value_parser = cli::number)]
    velocity_mps: Option<f64>,
    /// Another seed gives other noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    output: Output,
}

/// The recipes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Recipe {
    /// A person in front of an HB100 with its amplifier
    Hb100,
    /// Particles in the fringes of two laser beams, in front of a photodiode
    Laser,
    /// A corner reflector before a module whose frequency a ramp tunes
    Fmcw,
}

/// What a recipe gives.
pub struct Recorded {
    /// Samples per second.
    pub rate_hz: f64,
    /// The codes.
    pub codes: Vec<i16>,
    /// What is in them, a line each.
    pub truth: Vec<String>,
}

/// What is asked of a recipe.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// The distance at the start, m.
    pub range_m: Option<f64>,
    /// The speed towards the sensor, m/s.
    pub velocity_mps: Option<f64>,
}

/// Seeded normal numbers.
pub struct Random(ChaCha8Rng);

impl Random {
    fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    fn share(&mut self) -> f64 {
        self.0.random()
    }
}

impl Recipe {
    /// The recording.
    ///
    /// # Errors
    /// What is wanted cannot be recorded so; the sentence says what can.
    pub fn record(self, wanted: Wanted, seed: u64) -> Result<Recorded, String> {
        let random = &mut Random(ChaCha8Rng::seed_from_u64(seed));
        match self {
            Recipe::Hb100 => hb100::record(wanted, random),
            Recipe::Laser => laser::record(wanted, random),
            Recipe::Fmcw => fmcw::record(wanted, random),
        }
    }
}

/// Writes the recording and prints what is in it.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let Options { recipe, ref file, range_m, velocity_mps, seed, output } = *options;
    output.check(file, &[])?;
    let recorded = recipe.record(Wanted { range_m, velocity_mps }, seed)?;
    let bytes: Vec<u8> = recorded.codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    output.write(file, &bytes)?;
    let Recorded { rate_hz, codes, truth } = recorded;
    let seconds = codes.len() as f64 / rate_hz;
    outln!("{}: {seconds:.2} s at {rate_hz} Hz, 12 bits from 0 on", file.display());
    for line in truth {
        outln!("{line}");
    }
    Ok(ExitCode::SUCCESS)
}

/// A signal-to-noise ratio per sample of a sine, dB.
fn snr_db(amplitude: f64, noise: f64) -> f64 {
    10.0 * (amplitude * amplitude / 2.0 / (noise * noise)).log10()
}

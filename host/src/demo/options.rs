//! What a user types after `picket demo`.

use crate::output::Output;
use crate::{band, cli};
use clap::{Parser, ValueEnum};
use picket::Mixing;
use picket::methods::registry::Method;
use std::path::PathBuf;

/// The signal-to-noise ratio unless told otherwise, dB: on the emulated board, and of scenes for the core alone.
const SNR_DB: f64 = -5.0;
const CORE_SNR_DB: f64 = 20.0;

/// Runs the firmware on an emulated Cortex-M and prints truth beside measurement.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// The emulated board
    #[arg(long, value_enum, default_value_t = Board::Mps2)]
    pub board: Board,

    /// What is in front of the sensor
    #[arg(long, value_enum, default_value_t = Scenario::Table3, conflicts_with = "replay")]
    pub scenario: Scenario,

    /// Signal-to-noise ratio per sample, dB [default: -5; traffic, vibration: 20]
    #[arg(long, allow_negative_numbers = true, value_parser = decibels, conflicts_with = "replay")]
    pub snr_db: Option<f64>,

    /// Seed of the noise
    #[arg(long, default_value_t = 1, conflicts_with = "replay")]
    pub seed: u64,

    /// Repeat with so many seeds, counted from --seed, and sum up (table3)
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=10_000), conflicts_with = "replay")]
    pub seeds: u64,

    /// Another method on the same samples, to compare with (table3)
    #[arg(long, value_parser = method, conflicts_with = "replay")]
    pub versus: Option<Method>,

    /// Method of estimation
    #[arg(long, value_parser = method)]
    pub method: Option<Method>,

    /// Measure this recording (wav, or int16) instead
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,

    /// Sample rate of the recording, Hz (a wav file tells its own)
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, allow_negative_numbers = true, requires = "replay")]
    pub rate: Option<f64>,

    /// Samples in a block of the recording: 64, 128, ... 4096
    #[arg(long, default_value_t = 1024, requires = "replay")]
    pub n: usize,

    /// Band searched in the recording, Hz
    #[arg(long, value_name = "LO:HI", value_parser = band::parse, allow_hyphen_values = true, requires = "replay")]
    pub band: Option<(f64, f64)>,

    /// Carrier of a Doppler radar, Hz: gives speeds
    #[arg(long, value_name = "F", value_parser = cli::number, allow_negative_numbers = true, requires = "replay")]
    pub carrier_hz: Option<f64>,

    /// The recording holds I/Q pairs
    #[arg(long, requires = "replay")]
    pub iq: bool,

    /// Draw a drive or traffic (velocities beside it) or a vibration to this file, svg or png
    #[arg(long, value_name = "FILE", value_parser = cli::picture, conflicts_with = "replay")]
    pub plot: Option<PathBuf>,

    /// Which signal the radar's receiver conjugates [default: tx-conj-rx]
    #[arg(long, value_parser = mixing, conflicts_with = "replay")]
    pub mixing: Option<Mixing>,

    /// Keep the board's session in this file
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    pub record: Option<PathBuf>,

    /// Whether files are replaced.
    #[command(flatten)]
    pub output: Output,

    /// Show the firmware's log on stderr
    #[arg(long)]
    pub log: bool,

    /// One JSON object a line
    #[arg(long)]
    pub json: bool,
}

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Arm's MPS2 with a Cortex-M33, whose converter is played (QEMU)
    Mps2,
    /// The Raspberry Pi Pico with its own image: tones at 500 kS/s, a chirp's from its ramps' records (rp2040js)
    Pico,
}

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scenario {
    /// Fourteen targets over the span of the lidar paper's Table 3, approaching and receding
    Table3,
    /// Targets from a walker to a train before a 24 GHz radar with I/Q records, by a triangle and by a trapezoid
    Radar,
    /// The Doppler paper's turntable, in both directions
    Turntable,
    /// A car that comes, brakes, stands and leaves, another that passes it, two dropouts: followed by the tracker
    Drive,
    /// Four cars that cross in range and in speed, all of them in each chirp of a lidar; by the core on this machine
    Traffic,
    /// A plate at 30 cm that swings by 10 um before a 122 GHz radar, from the phase; by the core on this machine
    Vibration,
    /// A target that comes nearer, as the NUCLEO would report it: to --record, and to show by `picket watch --replay`
    Board,
}

impl Default for Options {
    /// What `picket demo` alone does.
    fn default() -> Self {
        Self::parse_from(["demo"])
    }
}

impl Options {
    /// The signal-to-noise ratio per sample, dB.
    pub fn snr_db(&self) -> f64 {
        let usual = if self.scenario.is_by_the_core() { CORE_SNR_DB } else { SNR_DB };
        self.snr_db.unwrap_or(usual)
    }

    /// The radar's mixing.
    pub fn mixing(&self) -> Mixing {
        self.mixing.unwrap_or_default()
    }
}

impl Scenario {
    /// Whether the core measures it on this machine, and no emulated board.
    pub fn is_by_the_core(self) -> bool {
        matches!(self, Scenario::Traffic | Scenario::Vibration)
    }
}

/// Beyond, the converter's codes hold nothing but the signal, or nothing of it.
fn decibels(text: &str) -> Result<f64, String> {
    let snr_db = cli::number(text)?;
    let inside = (-200.0..=200.0).contains(&snr_db);
    inside.then_some(snr_db).ok_or_else(|| "give a number from -200 to 200".into())
}

fn mixing(text: &str) -> Result<Mixing, String> {
    Mixing::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Mixing::ALL.iter().map(|m| m.name()).collect();
        format!("choose one of {}", names.join(", "))
    })
}

fn method(text: &str) -> Result<Method, String> {
    Method::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Method::ALL.iter().map(|m| m.name()).collect();
        format!("choose one of {}", names.join(", "))
    })
}

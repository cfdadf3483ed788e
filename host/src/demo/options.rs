//! What a user types after `picket demo`.

use crate::analyze::ramp::mixing;
use crate::output::Output;
use crate::scenario::Laser;
use crate::{band, cli};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Parser, ValueEnum};
use picket_dsp::Mixing;
use picket_dsp::methods::registry::Method;
use std::path::PathBuf;

/// The signal-to-noise ratio by default, dB: of the papers' scenes, of those that show something weaker or shorter than
/// the tone, and of wind, which no block sees.
const SNR_DB: f64 = -5.0;
const CLEAR_SNR_DB: f64 = 20.0;
const WIND_SNR_DB: f64 = -20.0;

/// Simulates a sensor, measures it with the firmware on an emulated board, and prints the truth next to the answers.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// The emulated board
    #[arg(long, value_enum, default_value_t = Board::Mps2)]
    pub board: Board,

    /// What is in front of the sensor
    #[arg(long, value_enum, default_value_t = Scenario::Table3, conflicts_with = "replay")]
    pub scenario: Scenario,

    /// Signal-to-noise ratio per sample, dB [default: -5; traffic, vibration, ldv, fan: 20; wind: -20]
    #[arg(long, allow_negative_numbers = true, value_parser = decibels, conflicts_with = "replay")]
    pub snr_db: Option<f64>,

    /// Seed of the noise
    #[arg(long, default_value_t = 1, conflicts_with = "replay")]
    pub seed: u64,

    /// Repeat with this many seeds, counted from --seed, and print a summary (table3)
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=10_000), conflicts_with = "replay")]
    pub seeds: u64,

    /// Another method on the same samples, to compare with (table3)
    #[arg(long, value_parser = method(), conflicts_with = "replay")]
    pub versus: Option<Method>,

    /// Method of estimation
    #[arg(long, value_parser = method())]
    pub method: Option<Method>,

    /// Measure this recording (wav, or int16) instead
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,

    /// Sample rate of the recording, Hz (a wav file states its own)
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

    /// Draw the scene to this file, svg or png; table3, drive, traffic and cars draw the velocities to a second file next to it
    #[arg(long, value_name = "FILE", value_parser = cli::picture, conflicts_with = "replay")]
    pub plot: Option<PathBuf>,

    /// Which signal the radar's receiver conjugates [default: tx-conj-rx]
    #[arg(long, value_parser = mixing(), conflicts_with = "replay")]
    pub mixing: Option<Mixing>,

    /// Linewidth of the lidar's laser, full width at half maximum, Hz (table3) [default: 0]
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, allow_negative_numbers = true, conflicts_with = "replay")]
    pub linewidth_hz: Option<f64>,

    /// Curvature of the lidar's ramps: height of their middle above the straight line, as a share of the bandwidth; the solver does not know
    /// it (table3) [default: 0]
    #[arg(long, value_name = "SHARE", value_parser = curvature, allow_negative_numbers = true, conflicts_with = "replay")]
    pub sweep_error: Option<f64>,

    /// Diameter of the beam's spot on the turntable's rough rim, mm; the bandwidth of its speckle is speed over diameter [default: no speckle]
    #[arg(long, value_name = "MM", value_parser = millimetres, allow_negative_numbers = true, conflicts_with = "replay")]
    pub spot_mm: Option<f64>,

    /// Store the board's session in this file
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    pub record: Option<PathBuf>,

    /// Whether files are replaced.
    #[command(flatten)]
    pub output: Output,

    /// Write the firmware's log to this file as defmt frames, for `defmt-print`
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,

    /// Print one JSON object per line
    #[arg(long)]
    pub json: bool,
}

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Arm's MPS2 with a Cortex-M33 and a played converter (QEMU)
    Mps2,
    /// The NUCLEO-F446RE with its image for sums and bursts, slowed down to 200 kS/s: ldv and wind (QEMU)
    Nucleo,
    /// The Raspberry Pi Pico with its own image: tones at 500 kS/s, a chirp's from its ramps' records (rp2040js)
    Pico,
}

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scenario {
    /// Fourteen targets over the span of the lidar paper's Table 3, approaching and receding
    #[value(alias = "lidar")]
    Table3,
    /// Targets from a walker to a train in front of a 24 GHz radar with I/Q records, by a triangle and by a trapezoid
    Radar,
    /// The Doppler paper's turntable, in both directions
    Turntable,
    /// A car that approaches, brakes, stands and leaves, another that passes it, two dropouts: followed by the tracker
    Drive,
    /// Four cars whose ranges and speeds cross, all in each chirp of a lidar; by the library on this machine
    Traffic,
    /// Such cars in front of a 77 GHz radar that sends frames of chirps, all in each frame; by the library on this machine
    Cars,
    /// A plate at 30 cm that swings by 10 um in front of a 122 GHz radar, from the phase; by the library on this machine
    Vibration,
    /// Particles in a turbulent flow that cross a laser's fringes, by the burst processor; by the library on this machine, or the NUCLEO
    Ldv,
    /// Wind around a cone of 36 beams, 20 dB below the noise, from sums of 100 blocks; by the library on this machine, or the NUCLEO
    Wind,
    /// A fan that moves in front of a 24 GHz radar with I/Q records: its body's speed between its blades' sidebands
    Fan,
    /// An approaching target, as the NUCLEO would report it: for --record, and for `picket watch --replay`
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
        self.snr_db.unwrap_or(match self.scenario {
            Scenario::Traffic | Scenario::Vibration | Scenario::Ldv | Scenario::Fan => CLEAR_SNR_DB,
            Scenario::Wind => WIND_SNR_DB,
            _ => SNR_DB,
        })
    }

    /// The lidar's laser.
    pub fn laser(&self) -> Laser {
        let [linewidth_hz, sweep_error] =
            [self.linewidth_hz, self.sweep_error].map(Option::unwrap_or_default);
        Laser { linewidth_hz, sweep_error }
    }

    /// The diameter of the spot on a rough surface, m.
    pub fn spot_m(&self) -> Option<f64> {
        self.spot_mm.map(|spot_mm| 1e-3 * spot_mm)
    }

    /// The radar's mixing.
    pub fn mixing(&self) -> Mixing {
        self.mixing.unwrap_or_default()
    }
}

impl Scenario {
    /// Whether ranges and velocities are drawn, each in a picture.
    pub fn has_two_pictures(self) -> bool {
        matches!(self, Scenario::Table3 | Scenario::Drive | Scenario::Traffic | Scenario::Cars)
    }

    /// Whether the core measures it on this machine, and no emulated board.
    pub fn is_by_the_core(self) -> bool {
        matches!(
            self,
            Scenario::Traffic
                | Scenario::Cars
                | Scenario::Vibration
                | Scenario::Ldv
                | Scenario::Wind
        )
    }
}

/// Beyond, the converter's codes hold nothing but the signal, or nothing of it.
fn decibels(text: &str) -> Result<f64, String> {
    let snr_db = cli::number(text)?;
    let inside = (-200.0..=200.0).contains(&snr_db);
    inside.then_some(snr_db).ok_or_else(|| "give a number from -200 to 200".into())
}

/// From the width of a fibre's core to that of the turntable: beyond, nothing is a spot on its rim.
fn millimetres(text: &str) -> Result<f64, String> {
    let spot_mm = cli::number(text)?;
    let inside = (0.01..=300.0).contains(&spot_mm);
    inside.then_some(spot_mm).ok_or_else(|| "give a diameter from 0.01 to 300 mm".into())
}

/// Beyond, a ramp turns back before its end.
fn curvature(text: &str) -> Result<f64, String> {
    let share = cli::number(text)?;
    let inside = share.abs() < 0.25;
    inside.then_some(share).ok_or_else(|| "give a share above -0.25 and below 0.25".into())
}

fn method() -> impl TypedValueParser<Value = Method> {
    let names = PossibleValuesParser::new(Method::ALL.iter().map(|method| method.name()));
    names.map(|name| Method::from_name(&name).unwrap_or_default())
}

//! What a board says when its sample rate changes: of every frame with a frequency, a tenth of the rate.

use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict};
use picket_wire::boot::Boot;
use picket_wire::command::Answer;
use picket_wire::follow::{Follow, Sighting};
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;
use picket_wire::settings::Settings;
use picket_wire::telemetry::{Health, Telemetry};

/// The rate first, and the rate then, Hz.
pub const RATES: [f64; 2] = [250e3, 100e3];

/// How it comes that the rate is another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// The board restarts.
    Restart,
    /// The recording begins in the middle of a record.
    Partial,
    /// Another host sends settings, whose answer is not heard here.
    Elsewhere,
    /// The port goes away and comes back.
    Reopened,
}

pub const SCENES: [Scene; 4] = [Scene::Restart, Scene::Partial, Scene::Elsewhere, Scene::Reopened];

/// A block's frames at this rate.
fn block(sequence: u32, rate_hz: f64) -> Vec<u8> {
    let stamp = Stamp { sequence, clock: 1024 * u64::from(sequence), ..Stamp::default() };
    let tone = Tone {
        frequency: Frequency::from_bins(102, 0.4_f64, 1024).unwrap(),
        sigma: 1e-6,
        snr: 1000.0,
        amplitude: 900.0,
        verdict: Verdict::Good,
        rate_hz,
        ..Tone::default()
    };
    let measurement = Measurement { stamp, clipped: 0, tone, result: Outcome::None };
    let method = Method::LeastSquaresReal;
    let mut bytes = Telemetry {
        measurement,
        method,
        health: Health::default(),
        basis: None,
        uncertainty: None,
    }
    .to_frame()
    .to_vec();
    let phasor = ToneWithPhase { tone, phase: 0.5, sigma_phase: 0.01 };
    bytes.extend(Lines::from_tones(&stamp, [phasor, phasor].into_iter().collect()).to_frame());
    bytes.extend(Fundamental::from_harmonic(&stamp, Harmonic { tone, orders: 3 }).to_frame());
    let track = Sighting { frequency: tone.frequency, sigma: tone.sigma, ..Sighting::default() };
    let tracks = [track].into_iter().collect();
    bytes.extend(Follow { sequence, tracks, ..Follow::default() }.to_frame());
    bytes
}

fn blocks(rate_hz: f64) -> Vec<u8> {
    (1..=3).flat_map(|sequence| block(sequence, rate_hz)).collect()
}

pub fn boot() -> Vec<u8> {
    Boot { n: 1024, core_hz: 180_000_000, measuring: true, ..Boot::default() }.to_frame().to_vec()
}

/// The bytes of its settings at this rate.
pub fn settings(rate_hz: f64) -> Vec<u8> {
    let defaults = Settings::default();
    let config = Config { rate_hz, ..defaults.config };
    Settings { config, ..defaults }.to_bytes(1024).to_vec()
}

impl Scene {
    /// What is said before the rate changes, and after it. Three blocks are in each part but the first of [`Scene::Partial`].
    pub fn bytes(self) -> [Vec<u8>; 2] {
        let [first, then] = RATES;
        let answer = Answer { tag: 1, command: 4 }.reply(&settings(first)).to_vec();
        let before = [boot(), answer, blocks(first)].concat();
        let after = blocks(then);
        match self {
            Scene::Restart => [before, [boot(), after].concat()],
            Scene::Partial => [block(0, first).split_off(40), after],
            Scene::Elsewhere | Scene::Reopened => [before, after],
        }
    }
}

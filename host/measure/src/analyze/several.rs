//! All the tones of each block of a recording, or the fundamental of its harmonics, as the core on a
//! board would find them.

use super::Style;
use super::carrier::{self, Carrier, Speed};
use super::cut::Cut;
use super::fundamental::Fundamental;
use super::unfit::{Tally, Unfit};
use crate::cli::print_line;
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::with_record;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_transform::num_complex::Complex;
use serde::Serialize;
use std::path::Path;

/// What is sought, and how.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// The blocks.
    pub cut: Cut,
    /// The probability of a false alarm in a block of noise.
    pub false_alarm: f64,
    /// The carrier of a Doppler radar, for speeds.
    pub carrier: Option<Carrier>,
    /// What is sought in a block.
    pub sought: Sought,
}

/// What is sought in a block.
#[derive(Clone, Copy, Debug)]
pub enum Sought {
    /// At most this number of tones.
    Tones(usize),
    /// The fundamental, from its harmonics up to this order.
    Harmonics(u32),
}

/// What is found.
#[derive(Clone, Debug)]
pub enum Finding {
    /// A tone.
    Tone(Found),
    /// A fundamental.
    Fundamental(Fundamental),
}

/// A tone of a block. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Found {
    /// The block's number.
    pub block: u64,
    /// The time of the block's middle.
    pub time_s: f64,
    /// The tone's number in the block, from 1: the strongest first.
    pub tone: usize,
    /// Its frequency; negative ones exist for I/Q.
    pub frequency_hz: f64,
    /// One standard deviation of it.
    pub sigma_hz: f64,
    /// Signal-to-noise ratio per sample.
    pub snr_db: f64,
    /// Its amplitude in codes.
    pub amplitude: f64,
    /// Its phase in the block's middle.
    pub phase_rad: f64,
    /// One standard deviation of it.
    pub sigma_phase_rad: f64,
    /// The speed in front of a radar of this carrier.
    #[serde(flatten)]
    pub speed: Option<Speed>,
    /// Whether it may be used.
    pub verdict: &'static str,
}

impl Found {
    fn of(
        block: u64,
        time_s: f64,
        number: usize,
        phasor: &ToneWithPhase,
        speed: Option<Speed>,
    ) -> Self {
        let ToneWithPhase { tone, phase, sigma_phase } = phasor;
        Self {
            block,
            time_s,
            tone: number,
            frequency_hz: tone.hertz(),
            sigma_hz: tone.sigma_hertz(),
            snr_db: tone.snr_db().into(),
            amplitude: tone.amplitude.into(),
            phase_rad: (*phase).into(),
            sigma_phase_rad: (*sigma_phase).into(),
            speed,
            verdict: tone.verdict.name(),
        }
    }
}

/// Gives what is found in every block of `file` to `sink`.
///
/// Not generic, so that the pipelines of all lengths are compiled here, once, and not by every caller.
pub fn run(
    file: &Path,
    search: &Search,
    sink: &mut dyn FnMut(&Finding),
    progress: &mut dyn FnMut(u64),
) -> Result<Tally, String> {
    let recording = search.cut.open(file)?;
    with_record!(recording.iq(), search.cut.n, R, N => blocks::<R, N>(recording, search, sink, progress))
}

fn blocks<R: Kind, const N: usize>(
    recording: Recording,
    search: &Search,
    sink: &mut dyn FnMut(&Finding),
    progress: &mut dyn FnMut(u64),
) -> Result<Tally, String> {
    let &Search { cut, false_alarm, carrier, sought } = search;
    let Cut { hop, skip, band_hz, codes, reach, width, .. } = cut;
    let rate_hz = recording.rate_hz();
    let config =
        Config { band_hz, reach, false_alarm, carrier: width, ..Config::new(rate_hz, codes) };
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(super::text)?));
    let mut blocks = recording.blocks(N, hop, skip);
    let (mut block, mut tally) = (0u32, Tally::default());
    while let Some((start, samples)) = blocks.next_block().map_err(super::text)? {
        let unfit = Unfit::of(samples, codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        let gap = blocks.gap();
        tally.add(unfit);
        progress(hop as u64);
        if unfit.is_some() {
            block = block.wrapping_add(1);
            continue;
        }
        let stamp = Stamp { sequence: block, clock: start, gap, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &record::<R, N>(&values));
        let number = block.into();
        let time_s = (start as f64 + N as f64 / 2.0) / rate_hz;
        match sought {
            Sought::Tones(most) => {
                for (tone, phasor) in (1..).zip(&pipeline.lines(&measurement, most)) {
                    let (shift, sigma) = (phasor.tone.hertz(), phasor.tone.sigma_hertz());
                    let speed = carrier.map(|carrier| carrier.speed(shift, Some(sigma), R::IQ));
                    let found = Found::of(number, time_s, tone, phasor, speed);
                    sink(&Finding::Tone(found));
                }
            }
            Sought::Harmonics(order) => {
                if let Some(harmonic) = pipeline.harmonic(&measurement, order) {
                    let fundamental = Fundamental::from_harmonic(number, time_s, &harmonic);
                    sink(&Finding::Fundamental(fundamental));
                }
            }
        }
        block = block.wrapping_add(1);
    }
    tally.check(codes)?;
    Ok(tally)
}

/// Prints the headings of the tones.
pub fn print_heading(style: Style, speeds: bool) {
    match style {
        Style::Json => {}
        Style::Csv => print_line(&format!(
            "block,time_s,tone,frequency_hz,sigma_hz,snr_db,amplitude,phase_rad,sigma_phase_rad,verdict{}",
            if speeds { carrier::CSV } else { "" }
        )),
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>5} {:>16} {:>12} {:>7} {:>10} {:>9} {:>7}{}  verdict",
            "block",
            "time s",
            "tone",
            "frequency Hz",
            "sigma Hz",
            "SNR dB",
            "amplitude",
            "phase rad",
            "sigma",
            if speeds { carrier::TEXT } else { "" },
        )),
    }
}

/// Prints a tone.
pub fn print(found: &Found, style: Style) {
    let Found { block, time_s, tone, frequency_hz, sigma_hz, snr_db, amplitude, .. } = found;
    let Found { phase_rad, sigma_phase_rad, speed, verdict, .. } = found;
    match style {
        Style::Json => print_line(&serde_json::to_string(found).unwrap_or_default()),
        Style::Csv => {
            let speed = Speed::csv(*speed);
            print_line(&format!(
                "{block},{time_s},{tone},{frequency_hz},{sigma_hz},{snr_db},{amplitude},{phase_rad},{sigma_phase_rad},{verdict}{speed}"
            ));
        }
        Style::Text => {
            let speed = Speed::text(*speed);
            print_line(&format!(
                "{block:>8} {time_s:>11.4} {tone:>5} {frequency_hz:>16.6} {sigma_hz:>12.6} {snr_db:>7.1} {amplitude:>10.2} {phase_rad:>9.4} \
                 {sigma_phase_rad:>7.4}{speed}  {verdict}"
            ));
        }
    }
}

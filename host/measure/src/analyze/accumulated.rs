//! The lines of sums of many blocks of a recording, each too weak for one block.

use super::carrier::{self, Carrier, Speed};
use super::cut::Cut;
use super::unfit::{Tally, Unfit};
use super::{Style, text};
use crate::cli::print_line;
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::with_record;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::{Accumulated, Accumulator};
use picket_transform::num_complex::Complex;
use serde::Serialize;
use std::path::Path;

/// What is added, and how.
#[derive(Clone, Copy, Debug)]
pub struct Sum {
    /// The blocks.
    pub cut: Cut,
    /// Blocks of a sum.
    pub blocks: u32,
    /// How fast the line moves.
    pub drift_hz_per_s: f64,
    /// The probability of a false alarm in a sum of noise.
    pub false_alarm: f64,
    /// The carrier of a Doppler radar, for speeds.
    pub carrier: Option<Carrier>,
}

/// The line of a sum. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Found {
    /// The sum's number.
    pub sum: u64,
    /// The blocks that were added.
    pub blocks: u32,
    /// The time of the middle.
    pub time_s: f64,
    /// The frequency; negative ones exist for I/Q.
    pub frequency_hz: f64,
    /// One standard deviation of it.
    pub sigma_hz: f64,
    /// Signal-to-noise ratio per sample.
    pub snr_db: f64,
    /// The amplitude in codes.
    pub amplitude: f64,
    /// The logarithm to the base of ten of the probability that noise alone has such a line.
    pub log10_chance: f64,
    /// The speed in front of a radar of this carrier.
    #[serde(flatten)]
    pub speed: Option<Speed>,
    /// Whether it may be used.
    pub verdict: &'static str,
}

/// Gives the line of each sum of `file` to `sink`; the blocks left over are too few for one, and are counted.
///
/// Not generic, so that the pipelines of all lengths are compiled here, once, and not by every caller.
pub fn run(
    file: &Path,
    sum: &Sum,
    sink: &mut dyn FnMut(&Found),
    progress: &mut dyn FnMut(u64),
) -> Result<(u32, Tally), String> {
    let recording = sum.cut.open(file)?;
    with_record!(recording.iq(), sum.cut.n, R, N => blocks::<R, N>(recording, sum, sink, progress))
}

fn blocks<R: Kind, const N: usize>(
    recording: Recording,
    sum: &Sum,
    sink: &mut dyn FnMut(&Found),
    progress: &mut dyn FnMut(u64),
) -> Result<(u32, Tally), String> {
    let &Sum { cut, blocks: count, drift_hz_per_s, false_alarm, carrier } = sum;
    let Cut { hop, skip, band_hz, codes, width, .. } = cut;
    let rate_hz = recording.rate_hz();
    let config = Config { band_hz, false_alarm, carrier: width, ..Config::new(rate_hz, codes) };
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(text)?));
    let drift = drift_hz_per_s * hop as f64 / rate_hz * N as f64 / rate_hz;
    let mut accumulator = Box::new(
        Accumulator::<R, N>::new(count).with_drift(drift as f32).with_false_alarm(false_alarm),
    );
    let mut pieces = recording.blocks(N, hop, skip);
    let (mut block, mut first, mut number) = (0u32, None, 0);
    let mut tally = Tally::default();
    while let Some((start, samples)) = pieces.next_block().map_err(text)? {
        let stamp = Stamp { sequence: block, clock: start, ..Stamp::default() };
        block = block.wrapping_add(1);
        progress(N as u64);
        let unfit = Unfit::of(samples, codes);
        tally.add(unfit);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        // A block with a missing sample is left out, too; the others still add up.
        if unfit.is_some() || pieces.gap() {
            continue;
        }
        let measurement = pipeline.block(&stamp, &record::<R, N>(&values));
        let from = *first.get_or_insert(start);
        if let Some(accumulated) = accumulator.add(&measurement, &pipeline) {
            let middle = (from + start) as f64 / 2.0 + N as f64 / 2.0;
            sink(&Found::of::<R>(&accumulated, number, middle / rate_hz, carrier));
            (number, first) = (number + 1, None);
        }
    }
    tally.check(codes)?;
    Ok((accumulator.added(), tally))
}

impl Found {
    fn of<R: Kind>(
        accumulated: &Accumulated,
        number: u64,
        time_s: f64,
        carrier: Option<Carrier>,
    ) -> Self {
        let Accumulated { tone, ln_chance, blocks } = accumulated;
        let (frequency_hz, sigma_hz) = (tone.hertz(), tone.sigma_hertz());
        Self {
            sum: number,
            blocks: *blocks,
            time_s,
            frequency_hz,
            sigma_hz,
            snr_db: tone.snr_db().into(),
            amplitude: tone.amplitude.into(),
            log10_chance: f64::from(*ln_chance) / std::f64::consts::LN_10,
            speed: carrier.map(|carrier| carrier.speed(frequency_hz, Some(sigma_hz), R::IQ)),
            verdict: tone.verdict.name(),
        }
    }
}

/// Prints the headings of the sums.
pub fn print_heading(style: Style, speeds: bool) {
    match style {
        Style::Json => {}
        Style::Csv => print_line(&format!(
            "sum,blocks,time_s,frequency_hz,sigma_hz,snr_db,amplitude,log10_chance,verdict{}",
            if speeds { carrier::CSV } else { "" }
        )),
        Style::Text => print_line(&format!(
            "{:>5} {:>7} {:>11} {:>16} {:>12} {:>7} {:>10}{}  {:<10} chance",
            "sum",
            "blocks",
            "time s",
            "frequency Hz",
            "sigma Hz",
            "SNR dB",
            "amplitude",
            if speeds { carrier::TEXT } else { "" },
            "verdict",
        )),
    }
}

/// Prints the line of a sum.
pub fn print(found: &Found, style: Style) {
    let Found { sum, blocks, time_s, frequency_hz, sigma_hz, snr_db, amplitude, .. } = found;
    let (chance, verdict) = (found.log10_chance, found.verdict);
    print_line(&match style {
        Style::Json => serde_json::to_string(found).unwrap_or_default(),
        Style::Csv => format!(
            "{sum},{blocks},{time_s},{frequency_hz},{sigma_hz},{snr_db},{amplitude},{chance},{verdict}{}",
            Speed::csv(found.speed)
        ),
        Style::Text => format!(
            "{sum:>5} {blocks:>7} {time_s:>11.4} {frequency_hz:>16.4} {sigma_hz:>12.4} {snr_db:>7.1} {amplitude:>10.2}{}  {verdict:<10} 1e{chance:.0}",
            Speed::text(found.speed)
        ),
    });
}

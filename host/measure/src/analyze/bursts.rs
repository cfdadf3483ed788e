//! The bursts of a recording, as of particles in a laser-Doppler velocimeter.

use super::carrier::{self, Carrier, Speed};
use super::cut::Cut;
use super::unfit::{Tally, Unfit};
use super::{Style, text};
use crate::cli::print_line;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::with_record;
use picket_dsp::acquire::burst::Counters;
use picket_dsp::config::Config;
use picket_dsp::{Burst, BurstProcessor, Validation};
use serde::Serialize;
use std::path::Path;

/// A burst. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Found {
    /// Its number.
    pub burst: u64,
    /// The time of its middle.
    pub time_s: f64,
    /// Its frequency; negative ones exist for I/Q.
    pub frequency_hz: f64,
    /// One standard deviation of it.
    pub sigma_hz: f64,
    /// Signal-to-noise ratio per sample at its top.
    pub snr_db: f64,
    /// Its amplitude at its top, in codes.
    pub amplitude: f64,
    /// The time between the points at which its power is down by `exp(-2)`.
    pub transit_s: f64,
    /// The speed in front of a radar of this carrier.
    #[serde(flatten)]
    pub speed: Option<Speed>,
    /// Whether it is one particle's.
    pub validation: &'static str,
    /// Whether its frequency may be used.
    pub verdict: &'static str,
}

/// All bursts together. The means are over valid bursts, each weighted with its transit time: fast particles come more often, and stay
/// as much shorter.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Summary {
    /// Always true: it distinguishes this line from the others.
    pub summary: bool,
    /// Bursts that were measured, noise that looked like one included.
    pub bursts: u64,
    /// Valid bursts.
    pub valid: u64,
    /// Bursts that came while the record of another was not complete.
    pub lost: u32,
    /// Signals too long for a burst.
    pub long: u32,
    /// Valid bursts per second.
    pub rate_hz: f64,
    /// The share of the time in which no burst could begin.
    pub dead_share: f64,
    /// The mean frequency.
    pub mean_hz: Option<f64>,
    /// The standard deviation of the frequency from burst to burst, without the share of their own errors.
    pub rms_hz: Option<f64>,
}

/// Gives every burst of `file` to `sink`.
///
/// Not generic, so that the processors of all lengths are compiled here, once, and not by every caller.
pub fn run(
    file: &Path,
    cut: &Cut,
    radar: Option<Carrier>,
    sink: &mut dyn FnMut(&Found),
    progress: &mut dyn FnMut(u64),
) -> Result<(Summary, Tally), String> {
    let recording = cut.open(file)?;
    with_record!(recording.iq(), cut.n, R, N => stream::<R, N>(recording, cut, radar, sink, progress))
}

fn stream<R: Kind, const N: usize>(
    recording: Recording,
    cut: &Cut,
    radar: Option<Carrier>,
    sink: &mut dyn FnMut(&Found),
    progress: &mut dyn FnMut(u64),
) -> Result<(Summary, Tally), String> {
    let rate_hz = recording.rate_hz();
    let config = Config { band_hz: cut.band_hz, ..Config::new(rate_hz, cut.codes) };
    let mut processor = Box::new(BurstProcessor::<R, N>::new(config.plan::<R, N>().map_err(text)?));
    let (mut sums, mut tally) = (Sums::default(), Tally::default());
    let start_s = cut.skip as f64 / rate_hz;
    // Pieces of the stream, each after the other.
    const PIECE: usize = 64;
    let mut pieces = recording.blocks(PIECE, PIECE, cut.skip);
    while let Some((_, samples)) = pieces.next_block().map_err(text)? {
        let unfit = Unfit::of(samples, cut.codes);
        let codes: Vec<R::Sample> = samples.iter().map(|s| R::from_parts(s.code())).collect();
        tally.add(unfit);
        progress(PIECE as u64);
        if unfit == Some(Unfit::Beyond) || pieces.gap() {
            processor.lost(PIECE as u64);
            continue;
        }
        processor.push(&codes, |burst| {
            let found = Found::of::<R>(burst, sums.bursts, start_s, rate_hz, radar);
            sums.take(burst, &found);
            sink(&found);
        });
    }
    tally.check(cut.codes)?;
    Ok((sums.summary(processor.counters(), rate_hz), tally.without_quiet()))
}

impl Found {
    fn of<R: Kind>(
        burst: &Burst,
        number: u64,
        start_s: f64,
        rate_hz: f64,
        radar: Option<Carrier>,
    ) -> Self {
        let Burst { tone, arrival, validation, .. } = burst;
        let (frequency_hz, sigma_hz) = (tone.hertz(), tone.sigma_hertz());
        Self {
            burst: number,
            time_s: start_s + arrival / rate_hz,
            frequency_hz,
            sigma_hz,
            snr_db: tone.snr_db().into(),
            amplitude: tone.amplitude.into(),
            transit_s: burst.transit() / rate_hz,
            speed: radar.map(|carrier| carrier.speed(frequency_hz, Some(sigma_hz), R::IQ)),
            validation: validation.name(),
            verdict: tone.verdict.name(),
        }
    }
}

/// Sums over bursts.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    bursts: u64,
    frequency: Weighted,
}

impl Sums {
    fn take(&mut self, burst: &Burst, found: &Found) {
        self.bursts += 1;
        if burst.validation == Validation::Valid {
            self.frequency.add(found.transit_s, found.frequency_hz, found.sigma_hz);
        }
    }

    fn summary(&self, counters: &Counters, rate_hz: f64) -> Summary {
        let samples = counters.samples.max(1) as f64;
        let valid = self.frequency.count;
        Summary {
            summary: true,
            bursts: self.bursts,
            valid,
            lost: counters.lost,
            long: counters.long,
            rate_hz: valid as f64 * rate_hz / samples,
            dead_share: counters.dead as f64 / samples,
            mean_hz: self.frequency.mean(),
            rms_hz: self.frequency.rms(),
        }
    }
}

/// Mean and spread of values that have a weight and a sigma each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Weighted {
    /// Values.
    pub count: u64,
    /// Of the weights, and of them times the value, its square and its variance.
    sums: [f64; 4],
    /// A value near the mean, from which others are counted: their squares must not cancel.
    near: f64,
}

impl Weighted {
    /// Takes a value.
    pub fn add(&mut self, weight: f64, value: f64, sigma: f64) {
        if self.count == 0 {
            self.near = value;
        }
        self.count += 1;
        let x = value - self.near;
        let terms = [1.0, x, x * x, sigma * sigma];
        self.sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
    }

    /// The mean.
    pub fn mean(&self) -> Option<f64> {
        let [weight, first, ..] = self.sums;
        (self.count > 0).then_some(self.near + first / weight)
    }

    /// The standard deviation, without the share of the values' own sigmas.
    pub fn rms(&self) -> Option<f64> {
        let [weight, first, second, variance] = self.sums;
        let mean = first / weight;
        let spread = (second / weight - mean * mean - variance / weight).max(0.0);
        (self.count > 1).then_some(spread.sqrt())
    }
}

/// Prints the headings of the bursts.
pub fn print_heading(style: Style, speeds: bool) {
    match style {
        Style::Json => {}
        Style::Csv => print_line(&format!(
            "burst,time_s,frequency_hz,sigma_hz,snr_db,amplitude,transit_s,validation,verdict{}",
            if speeds { carrier::CSV } else { "" }
        )),
        Style::Text => print_line(&format!(
            "{:>6} {:>12} {:>16} {:>12} {:>7} {:>10} {:>12}{}  validation",
            "burst",
            "time s",
            "frequency Hz",
            "sigma Hz",
            "SNR dB",
            "amplitude",
            "transit s",
            if speeds { carrier::TEXT } else { "" },
        )),
    }
}

/// Prints a burst.
pub fn print(found: &Found, style: Style) {
    let Found { burst, time_s, frequency_hz, sigma_hz, snr_db, amplitude, transit_s, .. } = found;
    let (validation, verdict) = (found.validation, found.verdict);
    print_line(&match style {
        Style::Json => serde_json::to_string(found).unwrap_or_default(),
        Style::Csv => format!(
            "{burst},{time_s},{frequency_hz},{sigma_hz},{snr_db},{amplitude},{transit_s},{validation},{verdict}{}",
            Speed::csv(found.speed)
        ),
        Style::Text => format!(
            "{burst:>6} {time_s:>12.6} {frequency_hz:>16.4} {sigma_hz:>12.4} {snr_db:>7.1} {amplitude:>10.1} {transit_s:>12.3e}{}  {validation}",
            Speed::text(found.speed)
        ),
    });
}

/// Prints the sums.
pub fn print_summary(summary: &Summary, style: Style) {
    let Summary { bursts, valid, lost, long, rate_hz, dead_share, mean_hz, rms_hz, .. } = summary;
    match style {
        Style::Csv => {}
        Style::Json => print_line(&serde_json::to_string(summary).unwrap_or_default()),
        Style::Text => {
            print_line(&format!(
                "{valid} of {bursts} bursts valid, {rate_hz:.1} per second; {lost} lost, {long} too long, dead for {:.1} %",
                100.0 * dead_share
            ));
            if let (Some(mean), Some(rms)) = (mean_hz, rms_hz) {
                print_line(&format!(
                    "mean {mean:.3} Hz, rms {rms:.3} Hz, each burst weighted with its transit time"
                ));
            }
        }
    }
}

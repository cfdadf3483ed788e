//! The core's tracker on a recording, as the firmware would run it.

use crate::analyze::Style;
use crate::analyze::carrier::{self, Carrier, Speed};
use crate::analyze::cut::Cut;
use crate::cli::print_line;
use crate::recording::Recording;
use crate::simulate::{Kind, codes};
use crate::with_record;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, Following};
use picket_dsp::solve::track::{State, Track};
use picket_dsp::tone::effort::Effort;
use picket_dsp::tracker::Tracker;
use picket_transform::num_complex::Complex;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// What is followed, and how.
#[derive(Clone, Copy, Debug)]
pub struct Pursuit {
    /// The blocks.
    pub cut: Cut,
    /// How tones are followed.
    pub following: Following,
    /// The effort spent on a line that is not a steady tone.
    pub effort: Effort,
    /// The Doppler radar that they are shifts of, if they are.
    pub carrier: Option<Carrier>,
}

/// A track in a block. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sighting {
    /// The block's number.
    pub block: u64,
    /// The time of the block's middle.
    pub time_s: f64,
    /// The track's number.
    pub track: u32,
    /// How it stands.
    pub state: &'static str,
    /// Its frequency, filtered.
    pub frequency_hz: f64,
    /// One standard deviation of it.
    pub sigma_hz: f64,
    /// Its rate.
    pub rate_hz_per_s: f64,
    /// Blocks since its first measurement.
    pub age: u32,
    /// Blocks since its last one.
    pub misses: u8,
    /// The speed in front of a radar, where its carrier is known.
    #[serde(flatten)]
    pub speed: Option<Speed>,
    /// Whether this block's frequency may be used.
    pub verdict: &'static str,
}

/// A track as a whole.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Trail {
    /// Always true: it distinguishes this line from the others.
    pub summary: bool,
    /// The track's number.
    pub track: u32,
    /// When it was first held.
    pub from_s: f64,
    /// When it was last seen.
    pub to_s: f64,
    /// Blocks in which it was seen.
    pub blocks: u64,
    /// The frequency when it was first held.
    pub from_hz: f64,
    /// The frequency when it was last seen.
    pub to_hz: f64,
}

/// Follows the tones of `file`; `sink` has every held track of every block. Gives the tracks, in their order.
///
/// Not generic, so that the trackers of all lengths are compiled here, once, and not by every caller.
pub fn run(
    file: &Path,
    pursuit: &Pursuit,
    sink: &mut dyn FnMut(&Sighting),
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<Trail>, String> {
    let recording = pursuit.cut.open(file)?;
    let mut trails = BTreeMap::<u32, Trail>::new();
    let mut sink = |sighting: &Sighting| {
        if sighting.misses == 0 {
            let Sighting { track, time_s, frequency_hz, .. } = *sighting;
            let trail = trails.entry(track).or_insert(Trail {
                summary: true,
                track,
                from_s: time_s,
                to_s: time_s,
                blocks: 0,
                from_hz: frequency_hz,
                to_hz: frequency_hz,
            });
            (trail.to_s, trail.to_hz, trail.blocks) = (time_s, frequency_hz, trail.blocks + 1);
        }
        sink(sighting);
    };
    with_record!(recording.iq(), pursuit.cut.n, R, N => blocks::<R, N>(recording, pursuit, &mut sink, progress))?;
    Ok(trails.into_values().collect())
}

fn blocks<R: Kind, const N: usize>(
    recording: Recording,
    pursuit: &Pursuit,
    sink: &mut dyn FnMut(&Sighting),
    progress: &mut dyn FnMut(u64),
) -> Result<(), String> {
    let &Pursuit { cut, following, effort, carrier } = pursuit;
    let Cut { hop, skip, band_hz, codes, reach, width, .. } = cut;
    let rate_hz = recording.rate_hz();
    let config = Config {
        rate_hz,
        codes,
        band_hz,
        reach,
        following,
        effort,
        carrier: width,
        ..Config::new(1.0, Codes::signed::<12>())
    };
    let mut tracker = Box::new(Tracker::<R, N>::new(config.plan::<R, N>().map_err(text)?));
    let mut blocks = recording.blocks(N, hop, skip);
    let mut block = 0u32;
    while let Some((start, samples)) = blocks.next_block().map_err(text)? {
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        let gap = blocks.gap();
        let stamp = Stamp { sequence: block, clock: start, gap, ..Stamp::default() };
        tracker.block(&stamp, &record::<R, N>(&values));
        let time_s = (start as f64 + N as f64 / 2.0) / rate_hz;
        for track in tracker.tracks(Segment::Continuous) {
            if track.state == State::Held {
                let mut sighting = sighting(track, block.into(), time_s, rate_hz, hop);
                let Sighting { frequency_hz, sigma_hz, .. } = sighting;
                let speed = |carrier: Carrier| carrier.speed(frequency_hz, Some(sigma_hz), R::IQ);
                sighting.speed = carrier.map(speed);
                sink(&sighting);
            }
        }
        block = block.wrapping_add(1);
        progress(hop as u64);
    }
    Ok(())
}

/// A block's samples in the converter's codes.
pub(crate) fn record<R: Kind, const N: usize>(values: &[Complex<f64>]) -> [R::Sample; N] {
    let mut samples = codes::<R>(values).into_iter();
    std::array::from_fn(|_| samples.next().unwrap_or_default())
}

fn sighting(track: &Track, block: u64, time_s: f64, rate_hz: f64, hop: usize) -> Sighting {
    Sighting {
        block,
        time_s,
        track: track.number,
        state: track.state.name(),
        frequency_hz: track.tone.frequency.hertz(rate_hz),
        sigma_hz: f64::from(track.tone.sigma) * rate_hz,
        rate_hz_per_s: f64::from(track.rate()) * rate_hz * rate_hz / hop as f64,
        age: track.age,
        misses: track.misses,
        speed: None,
        verdict: track.tone.verdict.name(),
    }
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Prints the headings of the sightings.
pub fn print_heading(style: Style, speeds: bool) {
    let beyond = |columns| if speeds { columns } else { "" };
    match style {
        Style::Json => {}
        Style::Csv => print_line(&format!(
            "block,time_s,track,state,frequency_hz,sigma_hz,rate_hz_per_s,age,misses,verdict{}",
            beyond(carrier::CSV)
        )),
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>6} {:>16} {:>12} {:>12} {:>7}{}  verdict",
            "block",
            "time s",
            "track",
            "frequency Hz",
            "sigma Hz",
            "rate Hz/s",
            "misses",
            beyond(carrier::TEXT)
        )),
    }
}

/// Prints a sighting.
pub fn print(sighting: &Sighting, style: Style) {
    let Sighting { block, time_s, track, frequency_hz, sigma_hz, rate_hz_per_s, .. } = sighting;
    let Sighting { state, age, misses, speed, verdict, .. } = sighting;
    match style {
        Style::Json => print_line(&serde_json::to_string(sighting).unwrap_or_default()),
        Style::Csv => print_line(&format!(
            "{block},{time_s},{track},{state},{frequency_hz},{sigma_hz},{rate_hz_per_s},{age},{misses},{verdict}{}",
            Speed::csv(*speed)
        )),
        Style::Text => print_line(&format!(
            "{block:>8} {time_s:>11.4} {track:>6} {frequency_hz:>16.4} {sigma_hz:>12.4} {rate_hz_per_s:>12.3} {misses:>7}{}  {verdict}",
            Speed::text(*speed)
        )),
    }
}

/// Prints the tracks.
pub fn print_trails(trails: &[Trail], style: Style) {
    for trail in trails {
        match style {
            Style::Json => print_line(&serde_json::to_string(trail).unwrap_or_default()),
            Style::Csv => {}
            Style::Text => {
                let Trail { track, from_s, to_s, blocks, from_hz, to_hz, .. } = trail;
                print_line(&format!(
                    "track {track}: {from_s:.2} to {to_s:.2} s, {from_hz:.1} to {to_hz:.1} Hz, seen in {blocks} blocks"
                ));
            }
        }
    }
}

//! Ranges and velocities of a recording of chirps, ramp by ramp.

use super::Style;
use super::cut::{self, Cut};
use super::unfit::{Tally, Unfit};
use crate::cli::print_line;
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::{length, with_record};
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_dsp::pipeline::{Outcome, Pipeline};
use picket_dsp::tone::effort::Effort;
use picket_dsp::{Chirp, Mixing, Shape};
use picket_transform::num_complex::Complex;
use serde::Serialize;
use std::path::Path;

/// What is known of the radar.
#[derive(Clone, Copy, Debug)]
pub struct Radar {
    /// The ramps.
    pub shape: Shape,
    /// The carrier, Hz.
    pub carrier_hz: f64,
    /// What a ramp sweeps, Hz.
    pub bandwidth_hz: f64,
    /// How long, s.
    pub chirp_s: f64,
    /// The signal that the receiver conjugates.
    pub mixing: Mixing,
    /// The velocities that targets may have, m/s.
    pub velocity_mps: Option<(f64, f64)>,
    /// The effort for lines that are not steady tones.
    pub effort: Effort,
}

/// A chirp's target. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Found {
    /// The chirp's number.
    pub chirp: u64,
    /// The time of its first record's middle.
    pub time_s: f64,
    /// Its last beat, and one standard deviation of it.
    pub frequency_hz: f64,
    /// One standard deviation of it.
    pub sigma_hz: f64,
    /// The range.
    pub range_m: f64,
    /// One standard deviation of it.
    pub sigma_range_m: f64,
    /// The velocity, positive when approaching; absent where one ramp does not show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_mps: Option<f64>,
    /// One standard deviation of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_velocity_mps: Option<f64>,
    /// Signal-to-noise ratio per sample.
    pub snr_db: f64,
    /// Whether it may be used.
    pub verdict: &'static str,
}

/// How the records lie in the ramps, in samples.
struct Ramps {
    n: usize,
    hop: usize,
    guard: usize,
}

impl Radar {
    /// The metres that a hertz of beat is.
    pub fn metres_per_hertz(&self) -> f64 {
        SPEED_OF_LIGHT * self.chirp_s / (2.0 * self.bandwidth_hz)
    }

    /// A record is the end of its ramp, whose beginning settles; of records of their own it is their end.
    fn ramps(&self, recording: &Recording, n: Option<usize>) -> Result<Ramps, String> {
        let rate_hz = recording.rate_hz();
        let ramp = (self.chirp_s * rate_hz).round() as usize;
        let row = recording.row().and_then(|row| usize::try_from(row).ok());
        let hop = row.unwrap_or(ramp);
        let within = ramp.min(hop);
        let longest = || length::LENGTHS.into_iter().rev().find(|&n| n <= within);
        let n = n.or_else(longest).filter(|&n| n <= within).ok_or_else(|| {
            format!("a ramp of {} s has {ramp} samples at {rate_hz} Hz: give a longer --chirp-s, or --n 64", self.chirp_s)
        })?;
        length::check(n)?;
        Ok(Ramps { n, hop, guard: within - n })
    }
}

/// Measures every chirp of `file`; `cut` states how it is read and where the first ramp begins.
pub fn run(
    file: &Path,
    cut: &Cut,
    n: Option<usize>,
    radar: &Radar,
    sink: &mut dyn FnMut(&Found),
) -> Result<Tally, String> {
    let recording = Recording::open(file, cut.read).map_err(super::text)?;
    if !recording.knows_rate() {
        return Err("ranges need the sample rate: add --rate HZ".into());
    }
    if recording.clock().is_some_and(|clock| clock.walk_s > 0.0) {
        return Err(recording.clock().map_or(String::new(), |clock| cut::uneven(&clock, cut.n)));
    }
    cut::assumed(file, &recording);
    let ramps = radar.ramps(&recording, n)?;
    with_record!(recording.iq(), ramps.n, R, N => chirps::<R, N>(recording, cut, &ramps, radar, sink))
}

fn chirps<R: Kind, const N: usize>(
    recording: Recording,
    cut: &Cut,
    ramps: &Ramps,
    radar: &Radar,
    sink: &mut dyn FnMut(&Found),
) -> Result<Tally, String> {
    let rate_hz = recording.rate_hz();
    let chirp = Chirp {
        shape: radar.shape,
        wavelength_m: SPEED_OF_LIGHT / radar.carrier_hz,
        bandwidth_hz: radar.bandwidth_hz,
        duration_s: radar.chirp_s,
        guard_s: ramps.guard as f64 / rate_hz,
        mixing: radar.mixing,
        ..Chirp::default()
    };
    let config = Config {
        scene: Scene::Chirp(chirp),
        band_hz: cut.band_hz,
        reach: cut.reach,
        carrier: cut.width,
        velocity_mps: radar.velocity_mps,
        effort: radar.effort,
        ..Config::new(rate_hz, cut.codes)
    };
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(super::text)?));
    let segments = radar.shape.segments();
    let mut blocks = recording.blocks(N, ramps.hop, cut.skip + ramps.guard as u64);
    let (mut number, mut tally, mut begin) = (0u32, Tally::default(), 0.0);
    while let Some((start, samples)) = blocks.next_block().map_err(super::text)? {
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        tally.add(unfit);
        let place = number as usize % segments.len();
        let time_s = (start as f64 + N as f64 / 2.0) / rate_hz;
        if place == 0 {
            begin = time_s;
        }
        let segment = segments.get(place).copied().unwrap_or_default();
        let stamp = Stamp { sequence: number, clock: start, segment, gap: blocks.gap() };
        number = number.wrapping_add(1);
        if unfit.is_some() {
            continue;
        }
        let measurement = pipeline.block(&stamp, &record::<R, N>(&values));
        if let Outcome::Target(target) = measurement.result {
            let tone = &measurement.tone;
            let known = target.velocity.is_some();
            sink(&Found {
                chirp: u64::from(stamp.sequence) / segments.len() as u64,
                time_s: begin,
                frequency_hz: tone.hertz(),
                sigma_hz: tone.sigma_hertz(),
                range_m: target.range.to_num(),
                sigma_range_m: target.sigma_range.into(),
                velocity_mps: target.velocity.map(|velocity| velocity.to_num()),
                sigma_velocity_mps: known.then(|| target.sigma_velocity.into()),
                snr_db: tone.snr_db().into(),
                verdict: target.verdict.name(),
            });
        }
    }
    tally.check(cut.codes)?;
    Ok(tally)
}

/// Prints the headings of the targets.
pub fn print_heading(style: Style) {
    match style {
        Style::Json => {}
        Style::Csv => print_line(
            "chirp,time_s,frequency_hz,sigma_hz,range_m,sigma_range_m,velocity_mps,sigma_velocity_mps,snr_db,verdict",
        ),
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>14} {:>10} {:>12} {:>10} {:>13} {:>10} {:>7}  verdict",
            "chirp",
            "time s",
            "beat Hz",
            "sigma",
            "range m",
            "sigma",
            "velocity m/s",
            "sigma",
            "SNR dB"
        )),
    }
}

/// Prints a target.
pub fn print(found: &Found, style: Style) {
    let Found { chirp, time_s, frequency_hz, sigma_hz, range_m, sigma_range_m, .. } = found;
    let Found { velocity_mps, sigma_velocity_mps, snr_db, verdict, .. } = found;
    match style {
        Style::Json => print_line(&serde_json::to_string(found).unwrap_or_default()),
        Style::Csv => {
            let [velocity, sigma] = [velocity_mps, sigma_velocity_mps]
                .map(|x| x.map_or(String::new(), |x| x.to_string()));
            print_line(&format!(
                "{chirp},{time_s},{frequency_hz},{sigma_hz},{range_m},{sigma_range_m},{velocity},{sigma},{snr_db},{verdict}"
            ));
        }
        Style::Text => {
            let [velocity, sigma] = [velocity_mps, sigma_velocity_mps]
                .map(|x| x.map_or("-".into(), |x| format!("{x:.4}")));
            print_line(&format!(
                "{chirp:>8} {time_s:>11.4} {frequency_hz:>14.4} {sigma_hz:>10.4} {range_m:>12.6} {sigma_range_m:>10.6} {velocity:>13} {sigma:>10} \
                 {snr_db:>7.1}  {verdict}"
            ));
        }
    }
}

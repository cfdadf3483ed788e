//! Ranges and velocities of a recording of chirps, ramp by ramp.

use super::cut::{self, Cut};
use super::frames;
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::{length, views, with_record};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_dsp::pipeline::{Outcome, Pipeline};
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::lines::MOST;
use picket_dsp::{Chirp, Mixing, Shape};
use picket_transform::num_complex::Complex;
use picket_wire::view;
use serde::Serialize;
use serde_json::{Map, Value};
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
    /// The probability of a false alarm in a frame, where it is told.
    pub false_alarm: Option<f64>,
}

/// A chirp's target. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
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
    /// The range by phase, where that was asked for and there is a tone for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<Map<String, Value>>,
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

/// What is found.
#[derive(Debug)]
pub enum Finding {
    /// A chirp's target.
    Chirp(Found),
    /// A frame's target.
    Frame(Box<frames::Found>),
}

/// How the records lie in the ramps, in samples.
#[derive(Clone, Copy, Debug)]
pub struct Ramps {
    /// Samples of a record.
    pub n: usize,
    /// From one ramp's first sample in the recording to the next one's.
    pub hop: usize,
    /// Samples that are left out before each record.
    pub skip: usize,
}

impl Radar {
    /// The metres that a hertz of beat is.
    pub fn metres_per_hertz(&self) -> f64 {
        SPEED_OF_LIGHT * self.chirp_s / (2.0 * self.bandwidth_hz)
    }

    /// A record is the end of its ramp, whose beginning settles; of records of their own it is their end.
    ///
    /// # Errors
    /// The ramps are shorter than a record, or do not repeat after a whole number of samples; an array looks transposed.
    pub fn ramps(
        &self,
        recording: &Recording,
        cut: &Cut,
        n: Option<usize>,
        told: &Told,
    ) -> Result<Ramps, String> {
        let rate_hz = recording.rate_hz();
        let ramp = (self.chirp_s * rate_hz).round() as usize;
        let row = recording.row().and_then(|row| usize::try_from(row).ok());
        if cut.read.axes.is_none() {
            self.check_axes(recording, ramp)?;
        }
        let hop = match (row, told.period_s) {
            (Some(row), _) => row,
            (None, None) => ramp,
            (None, Some(period_s)) => {
                let samples = period_s * rate_hz;
                if (samples - samples.round()).abs() > 1e-3 || samples < 1.0 {
                    return Err(format!(
                        "a period of {period_s} s has {samples:.3} samples at {rate_hz} Hz: chirps that begin between samples are no frame"
                    ));
                }
                samples.round() as usize
            }
        };
        let within = ramp.min(hop);
        let longest = || length::LENGTHS.into_iter().rev().find(|&n| n <= within);
        let n = n.or_else(longest).filter(|&n| n <= within).ok_or_else(|| {
            format!("a ramp of {} s has {ramp} samples at {rate_hz} Hz: give a longer --chirp-s, or --n 64", self.chirp_s)
        })?;
        length::check(n)?;
        Ok(Ramps { n, hop, skip: within - n })
    }

    /// Whether an array whose axes nobody told is another way round: as many chirps as a ramp has samples, and records that are much
    /// shorter than the ramp, or longer.
    fn check_axes(&self, recording: &Recording, ramp: usize) -> Result<(), String> {
        let sides = (recording.row(), recording.frame(), recording.axes());
        let (Some(samples), Some(chirps), Some(axes)) = sides else { return Ok(()) };
        let share = |side: u64| side as f64 / ramp as f64;
        let fills = |side: u64| (0.75..=1.0).contains(&share(side));
        if !fills(chirps) || (0.5..=1.0).contains(&share(samples)) {
            return Ok(());
        }
        let other = axes.exchanged();
        Err(format!(
            "a ramp of {} s has {ramp} samples at {} Hz, and the array {samples} times {chirps}: transposed, --axes {other}, or as it is, --axes {axes}",
            self.chirp_s,
            recording.rate_hz()
        ))
    }

    /// The waveform, whose records begin where they lie in the recording's ramps or where that is told.
    pub fn chirp(&self, rate_hz: f64, ramps: &Ramps, told: &Told) -> Chirp {
        Chirp {
            shape: self.shape,
            wavelength_m: SPEED_OF_LIGHT / self.carrier_hz,
            bandwidth_hz: self.bandwidth_hz,
            duration_s: self.chirp_s,
            guard_s: told.guard_s.unwrap_or(ramps.skip as f64 / rate_hz),
            sweep_curvature: told.curvature,
            mixing: self.mixing,
        }
    }
}

/// Measures every chirp of `file`; `cut` states how it is read and where the first ramp begins.
pub fn run(
    file: &Path,
    cut: &Cut,
    n: Option<usize>,
    radar: &Radar,
    told: &Told,
    sink: &mut dyn FnMut(&Finding),
) -> Result<(Tally, bool), String> {
    let recording = Recording::open(file, cut.read).map_err(super::text)?;
    if !recording.knows_rate() {
        return Err("ranges need the sample rate: add --rate HZ".into());
    }
    if recording.clock().is_some_and(|clock| clock.walk_s > 0.0) {
        return Err(recording.clock().map_or(String::new(), |clock| cut::uneven(&clock, cut.n)));
    }
    let ramps = radar.ramps(&recording, cut, n, told)?;
    if let Some(layout) = frames::layout(&recording, radar, told) {
        let mut sink = |found: frames::Found| sink(&Finding::Frame(Box::new(found)));
        let tally = frames::run(file, recording, cut, (&ramps, &layout), radar, told, &mut sink)?;
        return Ok((tally, true));
    }
    cut::assumed(file, &recording);
    with_record!(recording.iq(), ramps.n, R, N => chirps::<R, N>(recording, cut, &ramps, (radar, told), sink))
        .map(|tally| (tally, false))
}

fn chirps<R: Kind, const N: usize>(
    recording: Recording,
    cut: &Cut,
    ramps: &Ramps,
    (radar, told): (&Radar, &Told),
    sink: &mut dyn FnMut(&Finding),
) -> Result<Tally, String> {
    let rate_hz = recording.rate_hz();
    let chirp = radar.chirp(rate_hz, ramps, told);
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
    let sawtooth = radar.shape == Shape::Sawtooth;
    let ranging = told.ranging(&chirp, rate_hz, N, R::IQ)?;
    if told.phase && sawtooth {
        eprintln!("a sawtooth's range by phase is that of a target at rest");
    }
    let mut rising = None;
    let segments = radar.shape.segments();
    let is_array = recording.row().is_some();
    let mut blocks = recording.blocks(N, ramps.hop, cut.skip + ramps.skip as u64);
    let (mut number, mut tally, mut begin) = (0u32, Tally::default(), 0.0);
    while let Some((start, samples)) = blocks.next_block().map_err(super::text)? {
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        tally.add(unfit);
        let place = number as usize % segments.len();
        let half_s = 0.5 * N as f64 / rate_hz;
        // The records of an array have pauses between them.
        let time_s = match told.period_s.filter(|_| is_array) {
            Some(period_s) => {
                let lap = number as usize / segments.len().max(1);
                lap as f64 * period_s + place as f64 * radar.chirp_s + chirp.guard_s + half_s
            }
            None => start as f64 / rate_hz + half_s,
        };
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
        let line = match told.phase {
            true => pipeline.lines(&measurement, MOST).first().copied(),
            false => None,
        };
        if segment == Segment::Up {
            rising = line;
        }
        if let Outcome::Target(target) = measurement.result {
            let phase = ranging.as_ref().and_then(|ranging| match sawtooth {
                true => Some(ranging.at_rest(Segment::Up, &line?)),
                false => Some(ranging.moving(&rising?, &line?, &target)),
            });
            let tone = &measurement.tone;
            let known = target.velocity.is_some();
            sink(&Finding::Chirp(Found {
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
                phase: phase.map(|answer| views::object(&view::PhaseRange::from_answer(&answer))),
            }));
        }
    }
    tally.check(cut.codes)?;
    Ok(tally)
}

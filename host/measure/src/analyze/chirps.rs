//! Ranges and velocities of a recording of chirps, ramp by ramp.

use super::cut::{self, Cut};
use super::frames;
use super::radar::{Radar, Ramps};
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::{views, with_record};
use picket_dsp::Shape;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::{Outcome, Pipeline};
use picket_dsp::tone::lines::MOST;
use picket_transform::num_complex::Complex;
use picket_wire::view;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

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
    let rate_hz = recording.rate_hz();
    let segments = radar.shape.segments().len().max(1) as f64;
    // Of a chirp with several ramps each begins where the last ends.
    let each = told.found.map(|samples| samples / segments);
    let period_s = each.map(|samples| samples.round() / rate_hz).or(told.period_s);
    let mut ramps = radar.ramps(&recording, n, period_s, cut.read.axes.is_some())?;
    if told.find_ramps {
        // A beginning that is found late is known to two samples: the record is not to reach into the next ramp.
        ramps.skip = ramps.skip.saturating_sub(2);
    }
    let told = &Told { period_s, ..told.clone() };
    if told.chirps.is_some_and(|chirps| chirps > 1)
        && let Some(samples) = told.found.filter(|samples| samples.fract() != 0.0)
    {
        return Err(format!(
            "the ramps repeat each {samples:.3} samples: chirps that begin between samples are no frame"
        ));
    }
    if let Some(layout) = radar.layout(&recording, told.chirps, told.period_s) {
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
    let chirp = radar.chirp(rate_hz, ramps, told.guard_s, told.curvature);
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
    let every = told.found.map_or(ramps.hop as f64, |samples| samples / segments.len() as f64);
    let mut blocks = recording.blocks(N, ramps.hop, cut.skip + ramps.skip as u64).every(every);
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

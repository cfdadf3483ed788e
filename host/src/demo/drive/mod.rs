//! A drive in front of a 77 GHz radar, followed by the firmware's tracker: truth, single chirps and tracks side by side.

mod show;
mod summary;

pub(super) use show::{check_both, save_both};
pub use summary::Summary;

use super::answer::{Answer, lines};
use super::measure::{N, play_on};
use super::options::Options;
use super::{DemoError, said};
use crate::device::Said;
use crate::emulator::Capture;
use crate::progress;
use crate::scenario::drive::{self, CYCLES, Scene};
use crate::simulate::generator;
use picket_dsp::acquire::sample::{Real, Segment, Stamp};
use picket_dsp::pipeline::Outcome;
use picket_dsp::tone::Verdict;
use picket_dsp::tracker::Tracker;
use picket_simulator::Sensor;
use picket_wire::capture::Header;
use picket_wire::follow::Follow;
use picket_wire::frame::Reader;
use picket_wire::telemetry::Telemetry;
use serde::Serialize;
use std::process::ExitCode;

/// Nearer than this to the truth an answer is of the target, in metres and in metres per second.
const NEAR_M: f64 = 2.0;
const NEAR_MPS: f64 = 1.0;

/// One chirp. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The chirp's number.
    pub row: usize,
    /// The moment to which the chirp's ranges refer.
    pub time_s: f64,
    /// Signal-to-noise ratio per sample; `None` while the signal is cut off.
    pub snr_db: Option<f64>,
    /// Where the target is.
    pub truth_range_m: f64,
    /// How fast it approaches.
    pub truth_velocity_mps: f64,
    /// What the chirp alone shows.
    pub single: Option<Answer>,
    /// What the tracks show: the one that began as the target.
    pub tracked: Option<Answer>,
    /// All tracked targets, by number.
    pub targets: Vec<(u16, Answer)>,
}

/// Drives, prints and draws. Failure: a track is wrong where it says that it is good, or changed hands.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    if let Some(file) = &options.plot {
        show::check_both(file, options.output)?;
    }
    let (records, follows) = driven(options)?;
    let rows = rows(&records, &follows);
    let summary = Summary::of(&rows);
    if let Some(file) = &options.plot {
        show::draw(&rows, file, options.output)?;
    }
    if options.json {
        lines(&rows, &summary)?;
    } else {
        show::print(&rows, &summary, options);
    }
    // One loss is in the script: the signal is cut off for half a second.
    let right = summary.tracked_wrong == 0 && summary.numbers.len() <= 2;
    Ok(if right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The samples of a chirp's segment.
fn samples(radar: &Sensor, seed: u64, cycle: usize, segment: usize) -> Vec<i16> {
    let rng = &mut generator(seed, (3 * cycle + segment) as u64);
    drive::samples(radar, cycle, segment, rng)
}

/// The whole drive through the firmware.
pub fn driven(options: &Options) -> Result<(Vec<Telemetry>, Vec<Follow>), DemoError> {
    let radar = drive::radar(N);
    let header = Header::from_config::<Real>(drive::config(), N as u32, 3 * CYCLES as u32);
    let mut capture = Capture::create(&header).map_err(said)?;
    for cycle in 0..CYCLES {
        for segment in 0..3 {
            let samples = samples(&radar, options.seed, cycle, segment);
            capture.push::<Real>(&samples).map_err(said)?;
        }
    }
    let bar = progress::bar(3 * CYCLES as u64, "blocks");
    let (mut records, mut follows) = (Vec::new(), Vec::new());
    play_on("tracker_qemu", capture, options, |said| match said {
        Said::Telemetry(record) => {
            bar.inc(1);
            records.push(record);
        }
        Said::Follow(follow) => follows.push(follow),
        _ => {}
    })
    .map_err(said)?;
    bar.finish_and_clear();
    Ok((records, follows))
}

/// A report as it arrives: what a frame does not carry is left out.
fn as_sent(follow: &Follow) -> Result<Follow, DemoError> {
    let mut reader = Reader::default();
    let frame = follow.to_frame().into_iter().find_map(|byte| reader.push(byte));
    let frame = frame.ok_or_else(|| said("no frame"))?.map_err(said)?;
    Follow::from_frame(&frame).map_err(said)
}

/// What the core's tracker follows on this machine.
pub fn on_host(seed: u64) -> Result<Vec<Follow>, DemoError> {
    let (plan, radar) = (drive::config().plan().map_err(said)?, drive::radar(N));
    let mut tracker = Box::new(Tracker::<Real, N>::new(plan));
    let mut follows = Vec::new();
    for cycle in 0..CYCLES {
        for (number, segment) in [Segment::Up, Segment::Flat, Segment::Down].into_iter().enumerate()
        {
            let mut block = [0; N];
            block.copy_from_slice(&samples(&radar, seed, cycle, number));
            let sequence = (3 * cycle + number) as u32;
            let stamp = Stamp { sequence, segment, ..Stamp::default() };
            tracker.block(&stamp, &block);
            follows.push(as_sent(&Follow::from_tracker(&tracker, &stamp))?);
        }
    }
    Ok(follows)
}

fn rows(records: &[Telemetry], follows: &[Follow]) -> Vec<Row> {
    let mut number = None;
    let mut rows = Vec::new();
    let radar = drive::radar(N);
    for row in 0..CYCLES {
        let time_s = drive::moment_s(&radar, row);
        let scene = Scene::at(time_s);
        let last = 3 * row as u32 + 2;
        let single = records.iter().find(|r| r.measurement.stamp.sequence == last);
        let single = single.and_then(|record| match &record.measurement.result {
            Outcome::Target(target) => Some(target.into()),
            _ => None,
        });
        let follow = follows.iter().find(|follow| follow.sequence == last);
        let targets: Vec<(u16, Answer)> =
            follow.iter().flat_map(|f| f.targets.iter().map(|(n, t)| (*n, t.into()))).collect();
        let up = follows.iter().find(|follow| follow.sequence + 2 == last);
        let alive =
            |number: &u16| up.is_some_and(|up| up.tracks.iter().any(|t| t.number == *number));
        // The target is the first that was found near it, for as long as its track lives.
        number = number.filter(alive).or_else(|| {
            let near = |(_, answer): &&(u16, Answer)| {
                answer.verdict == Verdict::Good.name()
                    && (answer.range_m - scene.range_m).abs() < NEAR_M
            };
            targets.iter().find(near).map(|(number, _)| *number)
        });
        let tracked = number.and_then(|number| targets.iter().find(|t| t.0 == number)).map(|t| t.1);
        rows.push(Row {
            row,
            time_s,
            snr_db: scene.snr_db,
            truth_range_m: scene.range_m,
            truth_velocity_mps: scene.velocity_mps,
            single,
            tracked,
            targets,
        });
    }
    rows
}

//! A drive before a 77 GHz radar, followed by the firmware's tracker: truth, single chirps and tracks side by side.

use super::measure::{N, play_on};
use super::options::Options;
use super::table::table;
use super::{DemoError, said};
use crate::device::Said;
use crate::emulator::Capture;
use crate::progress;
use crate::report::chart::{Axis, Chart, Series, Style};
use crate::scenario::drive::{self, CYCLE_S, CYCLES, Scene};
use crate::simulate::{Line, Signal, generator};
use comfy_table::{Cell, CellAlignment};
use picket::acquire::capture::Header;
use picket::acquire::sample::{Real, Segment, Stamp};
use picket::config::{Plan, Solver};
use picket::estimate::tone::Verdict;
use picket::pipeline::Outcome;
use picket::report::follow::Follow;
use picket::report::frame::Reader;
use picket::report::record::Record;
use picket::solve::chirp::{Scales, Target};
use picket::tracker::Tracker;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// The noise of a sample, in codes.
const NOISE: f64 = 60.0;

/// Nearer than this to the truth an answer is of the target, in metres and in metres per second.
const NEAR_M: f64 = 2.0;
const NEAR_MPS: f64 = 1.0;

/// One chirp. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The chirp's number.
    pub row: usize,
    /// When.
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

/// A measured target.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Answer {
    /// Metres.
    pub range_m: f64,
    /// Metres per second, positive when approaching.
    pub velocity_mps: f64,
    /// One standard deviation.
    pub sigma_range_m: f64,
    /// One standard deviation.
    pub sigma_velocity_mps: f64,
    /// Whether it may be used.
    pub verdict: &'static str,
}

impl From<&Target> for Answer {
    fn from(target: &Target) -> Self {
        Answer {
            range_m: target.range.to_num(),
            velocity_mps: target.velocity.to_num(),
            sigma_range_m: target.sigma_range.into(),
            sigma_velocity_mps: target.sigma_velocity.into(),
            verdict: target.verdict.name(),
        }
    }
}

/// The drive as a whole.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Chirps.
    pub chirps: usize,
    /// Those in which the target was tracked.
    pub tracked: usize,
    /// Single answers with the verdict good that are more than two metres or 1 m/s off.
    pub single_wrong: usize,
    /// Tracked answers, of either car, with the verdict good that are as far from both.
    pub tracked_wrong: usize,
    /// Root mean square over the chirps where both are good and right.
    pub single_rms_range_m: f64,
    /// The same of the tracks.
    pub tracked_rms_range_m: f64,
    /// The same of the velocity.
    pub single_rms_velocity_mps: f64,
    /// The same of the tracks.
    pub tracked_rms_velocity_mps: f64,
    /// The numbers of the target's tracks, in their order: a new one after each loss.
    pub numbers: Vec<u16>,
}

/// Drives, prints and draws. Failure: a track is wrong where it says that it is good, or changed hands.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let (records, follows) = driven(options)?;
    let rows = rows(&records, &follows);
    let summary = summary(&rows);
    if let Some(file) = &options.plot {
        draw(&rows, file)?;
    }
    if options.json {
        for row in &rows {
            println!("{}", serde_json::to_string(row).map_err(said)?);
        }
        println!("{}", serde_json::to_string(&summary).map_err(said)?);
    } else {
        print(&rows, &summary, options);
    }
    // One loss is in the script: the signal is cut off for half a second.
    let right = summary.tracked_wrong == 0 && summary.numbers.len() <= 2;
    Ok(if right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The samples of a chirp's segment.
fn samples(seed: u64, cycle: usize, segment: usize, scales: &Scales) -> Vec<i16> {
    let beats = Scene::at(cycle as f64 * CYCLE_S).beats(scales);
    let lines = beats.into_iter().nth(segment).unwrap_or_default();
    let lines = lines.into_iter().map(|(cycles, snr_db)| Line {
        // A real tone is the same at minus its frequency.
        bins: cycles.abs() * N as f64,
        amplitude: NOISE * (2.0 * 10f64.powf(snr_db / 10.0)).sqrt(),
        phase: None,
    });
    // The first line sets the noise: one of no amplitude to speak of.
    let mark = Line { bins: 0.0, amplitude: 1e-6, phase: Some(0.0) };
    let signal = Signal {
        lines: std::iter::once(mark).chain(lines).collect(),
        snr_db: 20.0 * (1e-6 / NOISE).log10() - 10.0 * 2f64.log10(),
        ..Signal::tone(0.0, 0.0, 0.0)
    };
    signal.codes::<Real>(N, &mut generator(seed, (3 * cycle + segment) as u64))
}

fn scales() -> Result<(Plan, Scales), DemoError> {
    let plan = drive::config().validate::<Real>(N).map_err(said)?;
    let Solver::Chirp(_, scales) = plan.solver else { return Err(said("no chirp")) };
    Ok((plan, scales))
}

/// The whole drive through the firmware.
pub fn driven(options: &Options) -> Result<(Vec<Record>, Vec<Follow>), DemoError> {
    let (_, scales) = scales()?;
    let header = Header::of::<Real>(drive::config(), N as u32, 3 * CYCLES as u32);
    let mut capture = Capture::create(&header).map_err(said)?;
    for cycle in 0..CYCLES {
        for segment in 0..3 {
            capture.push::<Real>(&samples(options.seed, cycle, segment, &scales)).map_err(said)?;
        }
    }
    let bar = progress::bar(3 * CYCLES as u64, "blocks");
    let (mut records, mut follows) = (Vec::new(), Vec::new());
    play_on("tracker_qemu", capture, options, |said| match said {
        Said::Record(record) => {
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
    Follow::of_frame(&frame).map_err(said)
}

/// What the core's tracker follows on this machine.
pub fn on_host(seed: u64) -> Result<Vec<Follow>, DemoError> {
    let (plan, scales) = scales()?;
    let mut tracker = Box::new(Tracker::<Real, N>::new(plan));
    let mut follows = Vec::new();
    for cycle in 0..CYCLES {
        for (number, segment) in [Segment::Up, Segment::Flat, Segment::Down].into_iter().enumerate()
        {
            let mut block = [0; N];
            block.copy_from_slice(&samples(seed, cycle, number, &scales));
            let sequence = (3 * cycle + number) as u32;
            let stamp = Stamp { sequence, segment, ..Stamp::default() };
            tracker.block(stamp, &block);
            follows.push(as_sent(&tracker.follow(&stamp))?);
        }
    }
    Ok(follows)
}

fn rows(records: &[Record], follows: &[Follow]) -> Vec<Row> {
    let mut number = None;
    let mut rows = Vec::new();
    for row in 0..CYCLES {
        let time_s = row as f64 * CYCLE_S;
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

fn summary(rows: &[Row]) -> Summary {
    let good = |answer: &Option<Answer>| answer.filter(|a| a.verdict == Verdict::Good.name());
    let at = |answer: &Answer, range_m: f64, velocity_mps: f64| {
        (answer.range_m - range_m).abs() < NEAR_M
            && (answer.velocity_mps - velocity_mps).abs() < NEAR_MPS
    };
    let right = |row: &Row, answer: &Answer| at(answer, row.truth_range_m, row.truth_velocity_mps);
    // A track outlives what it follows by some chirps, and says that it is weak then.
    let either = |row: &Row, answer: &Answer| {
        let other = Scene::at(row.time_s).other;
        right(row, answer) || other.is_some_and(|(range, speed)| at(answer, range, speed))
    };
    let single_wrong =
        rows.iter().filter(|row| good(&row.single).is_some_and(|a| !either(row, &a)));
    let tracked_wrong = rows.iter().flat_map(|row| row.targets.iter().map(move |t| (row, t.1)));
    let tracked_wrong =
        tracked_wrong.filter(|(row, a)| good(&Some(*a)).is_some_and(|a| !either(row, &a)));
    let mut squares = [0.0; 4];
    let mut count = 0.0;
    let mut numbers = Vec::new();
    for row in rows {
        if let Some(tracked) = row.tracked
            && let Some((number, _)) = row.targets.iter().find(|t| t.1.range_m == tracked.range_m)
            && !numbers.contains(number)
        {
            numbers.push(*number);
        }
        let (Some(single), Some(tracked)) = (good(&row.single), good(&row.tracked)) else {
            continue;
        };
        if !right(row, &single) || !right(row, &tracked) {
            continue;
        }
        let errors = [
            single.range_m - row.truth_range_m,
            tracked.range_m - row.truth_range_m,
            single.velocity_mps - row.truth_velocity_mps,
            tracked.velocity_mps - row.truth_velocity_mps,
        ];
        squares.iter_mut().zip(errors).for_each(|(square, error)| *square += error * error);
        count += 1.0;
    }
    let [single_range, tracked_range, single_velocity, tracked_velocity] =
        squares.map(|square| (square / f64::max(count, 1.0)).sqrt());
    Summary {
        summary: true,
        chirps: rows.len(),
        tracked: rows.iter().filter(|row| row.tracked.is_some()).count(),
        single_wrong: single_wrong.count(),
        tracked_wrong: tracked_wrong.count(),
        single_rms_range_m: single_range,
        tracked_rms_range_m: tracked_range,
        single_rms_velocity_mps: single_velocity,
        tracked_rms_velocity_mps: tracked_velocity,
        numbers,
    }
}

/// The drive's last lines, as a person reads them.
fn text(summary: &Summary) -> String {
    let numbers: Vec<_> = summary.numbers.iter().map(u16::to_string).collect();
    format!(
        "tracked in {} of {} chirps, as number {}\n\
           good but off by 2 m or 1 m/s   chirp alone {}, tracked {}\n\
           range rms                      chirp alone {:.2} cm, tracked {:.2} cm\n\
           velocity rms                   chirp alone {:.2} cm/s, tracked {:.2} cm/s\n",
        summary.tracked,
        summary.chirps,
        numbers.join(", then "),
        summary.single_wrong,
        summary.tracked_wrong,
        100.0 * summary.single_rms_range_m,
        100.0 * summary.tracked_rms_range_m,
        100.0 * summary.single_rms_velocity_mps,
        100.0 * summary.tracked_rms_velocity_mps
    )
}

fn print(rows: &[Row], summary: &Summary, options: &Options) {
    println!(
        "A drive before a 77 GHz radar: 300 MHz in 1 ms, 12 bits at 1.024 MS/s, N = {N} per ramp, 20 chirps a second, seed {}\n",
        options.seed
    );
    let mut table = table(&[
        "time s",
        "SNR dB",
        "true m",
        "m/s",
        "chirp alone m",
        "m/s",
        "verdict",
        "tracked m",
        "+-",
        "m/s",
        "+-",
        "verdict",
    ]);
    let answer = |answer: &Option<Answer>, sigmas: bool| -> Vec<String> {
        let Some(a) = answer else {
            return vec!["-".into(); if sigmas { 5 } else { 3 }];
        };
        let verdict = a.verdict.to_string();
        if sigmas {
            vec![
                format!("{:.3}", a.range_m),
                format!("{:.3}", a.sigma_range_m),
                format!("{:.3}", a.velocity_mps),
                format!("{:.3}", a.sigma_velocity_mps),
                verdict,
            ]
        } else {
            vec![format!("{:.3}", a.range_m), format!("{:.3}", a.velocity_mps), verdict]
        }
    };
    for row in rows.iter().step_by(20) {
        let mut cells = vec![
            format!("{:.1}", row.time_s),
            row.snr_db.map_or("none".into(), |snr| format!("{snr:.1}")),
            format!("{:.3}", row.truth_range_m),
            format!("{:.3}", row.truth_velocity_mps),
        ];
        cells.extend(answer(&row.single, false));
        cells.extend(answer(&row.tracked, true));
        let right = |cell: String| Cell::new(cell).set_alignment(CellAlignment::Right);
        table.add_row(cells.into_iter().map(right));
    }
    println!("{}\n", table.trim_fmt());
    print!("{}", text(summary));
}

/// Draws the ranges to `file` and the velocities beside it.
fn draw(rows: &[Row], file: &Path) -> Result<(), DemoError> {
    let single = |take: fn(&Answer) -> f64| {
        rows.iter()
            .filter_map(move |row| {
                row.single
                    .as_ref()
                    .filter(|a| a.verdict != Verdict::Weak.name())
                    .map(|a| (row.time_s, take(a)))
            })
            .collect::<Vec<_>>()
    };
    let tracked = |take: fn(&Answer) -> f64| {
        let all = rows.iter().flat_map(|row| row.targets.iter().map(move |t| (row.time_s, t.1)));
        all.map(move |(time, answer)| (time, take(&answer))).collect::<Vec<_>>()
    };
    let other: Vec<_> = rows
        .iter()
        .filter_map(|row| {
            Scene::at(row.time_s).other.map(|(range, speed)| (row.time_s, range, speed))
        })
        .collect();
    let end = CYCLES as f64 * CYCLE_S;
    let ranges = Chart {
        name: "drive-range",
        title: "A drive at 77 GHz: range".into(),
        x: Axis::linear("time, s", 0.0, end),
        y: Axis::linear("range, m", 0.0, 200.0),
        series: vec![
            Series::new("chirp alone, not weak", Style::Points, 6, single(|a| a.range_m)),
            Series::new("tracked", Style::Points, 0, tracked(|a| a.range_m)),
            Series::new("truth", Style::Line, 1, rows.iter().map(|r| (r.time_s, r.truth_range_m))),
            Series::new("truth, another car", Style::Dashed, 2, other.iter().map(|o| (o.0, o.1))),
        ],
    };
    let velocities = Chart {
        name: "drive-velocity",
        title: "A drive at 77 GHz: velocity".into(),
        y: Axis::linear("velocity towards the radar, m/s", -16.0, 16.0),
        series: vec![
            Series::new("chirp alone, not weak", Style::Points, 6, single(|a| a.velocity_mps)),
            Series::new("tracked", Style::Points, 0, tracked(|a| a.velocity_mps)),
            Series::new(
                "truth",
                Style::Line,
                1,
                rows.iter().map(|r| (r.time_s, r.truth_velocity_mps)),
            ),
            Series::new("truth, another car", Style::Dashed, 2, other.iter().map(|o| (o.0, o.2))),
        ],
        ..ranges.clone()
    };
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let suffix = file.extension().unwrap_or_default().to_string_lossy().into_owned();
    let beside = file.with_file_name(format!("{stem}-velocity.{suffix}"));
    ranges.save(file).map_err(said)?;
    velocities.save(&beside).map_err(said)
}

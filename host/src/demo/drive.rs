//! A drive in front of a 77 GHz radar, followed by the firmware's tracker: truth, single chirps and tracks side by side.

use super::feed::{N, play, records};
use super::options::Options;
use super::shown::{Answer, Shown, keys, lines, over_time, rms, table};
use super::{DemoError, said};
use crate::device::Said;
use crate::plot::chart::{Axis, Style};
use crate::scenario::drive::{self, CYCLE_S, CYCLES};
use crate::scenario::place;
use picket_dsp::Verdict;
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::pipeline::Outcome;
use picket_dsp::tracker::Tracker;
use picket_wire::follow::Follow;
use picket_wire::frame::Reader;
use picket_wire::telemetry::Telemetry;
use serde::Serialize;

/// Nearer than this to the truth an answer is of the target, in metres and in metres per second.
const NEAR: [f64; 2] = [2.0, 1.0];

/// One chirp. The keys are those of the JSON lines.
#[derive(Serialize)]
struct Row {
    row: usize,
    /// The moment to which the chirp's ranges refer.
    time_s: f64,
    /// Of a sample; none while the signal is cut off.
    snr_db: Option<f64>,
    truth_range_m: f64,
    truth_velocity_mps: f64,
    /// What the chirp alone shows.
    single: Option<Answer>,
    /// What the tracks show: the one that began as the target.
    tracked: Option<Answer>,
    /// All tracked targets, by number.
    targets: Vec<(u16, Answer)>,
    #[serde(skip)]
    number: Option<u16>,
    #[serde(skip)]
    other: Option<[f64; 2]>,
}

impl Row {
    const fn truth(&self) -> [f64; 2] {
        [self.truth_range_m, self.truth_velocity_mps]
    }

    /// Whether an answer is called good and of no car. A track outlives what it follows by some chirps, and says that it coasts then.
    fn is_wrong(&self, answer: &Answer) -> bool {
        let cars = [Some(self.truth()), self.other];
        answer.is_good() && !cars.into_iter().flatten().any(|car| answer.is_near(car, NEAR))
    }
}

/// The whole drive through the firmware.
pub fn driven(options: &Options) -> Result<(Vec<Telemetry>, Vec<Follow>), DemoError> {
    let config = drive::config();
    let blocks = records::<Real>(&drive::scene(options.seed, N), &config)?;
    let blocks: Vec<_> = blocks.map(|(_, samples)| Ok(samples.to_vec())).collect();
    let (mut records, mut follows) = (Vec::new(), Vec::new());
    play::<Real>("tracker_qemu", (config, N), blocks.into_iter(), options, |_, said| match said {
        Said::Telemetry(record) => records.push(record),
        Said::Follow(follow) => follows.push(follow),
        _ => {}
    })?;
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
    let config = drive::config();
    let mut tracker = Box::new(Tracker::<Real, N>::new(config.plan().map_err(said)?));
    let follow = |(stamp, block): (Stamp, [i16; N])| {
        tracker.block(&stamp, &block);
        as_sent(&Follow::from_tracker(&tracker, &stamp))
    };
    records::<Real>(&drive::scene(seed, N), &config)?.map(follow).collect()
}

fn rows(seed: u64, records: &[Telemetry], follows: &[Follow]) -> Result<Vec<Row>, DemoError> {
    let run = drive::scene(seed, N).run(0).map_err(said)?;
    let mut number = None;
    let row = |row: usize| {
        let [car, other] = [0, 1].map(|source| run.truth_of_lap(source, row, N));
        let [truth_range_m, truth_velocity_mps] = place(&car);
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
                answer.is_good() && (answer.range_m - truth_range_m).abs() < NEAR[0]
            };
            targets.iter().find(near).map(|(number, _)| *number)
        });
        let tracked = targets.iter().find(|t| Some(t.0) == number).map(|t| t.1);
        let (time_s, snr_db) = (car.time_s, drive::snr_db(car.amplitude));
        let number = number.filter(|_| tracked.is_some());
        let other = drive::snr_db(other.amplitude).map(|_| place(&other));
        Row {
            row,
            time_s,
            snr_db,
            truth_range_m,
            truth_velocity_mps,
            single,
            tracked,
            targets,
            number,
            other,
        }
    };
    Ok((0..CYCLES).map(row).collect())
}

/// Right: no track is wrong where it says that it is good, or changed hands.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let (records, follows) = driven(options)?;
    let rows = rows(options.seed, &records, &follows)?;
    let wrong = |row: &Row, answer: &Answer| usize::from(row.is_wrong(answer));
    let single_wrong: usize = rows.iter().flat_map(|r| r.single.iter().map(|a| wrong(r, a))).sum();
    let tracked_wrong: usize =
        rows.iter().flat_map(|r| r.targets.iter().map(|(_, a)| wrong(r, a))).sum();
    // Chirps where both are good and right.
    let both = rows.iter().filter_map(|row| {
        let is_right = |a: &Answer| a.is_good() && a.is_near(row.truth(), NEAR);
        let answers = [row.single.filter(is_right)?, row.tracked.filter(is_right)?];
        Some(answers.map(|answer| answer.off(row.truth())))
    });
    let both: Vec<_> = both.collect();
    let of = |who: usize, what: usize| rms(both.iter().map(|errors| errors[who][what]));
    let mut numbers: Vec<u16> = Vec::new();
    for number in rows.iter().filter_map(|row| row.number) {
        if !numbers.contains(&number) {
            numbers.push(number);
        }
    }
    let (chirps, tracked) = (rows.len(), rows.iter().filter(|row| row.tracked.is_some()).count());
    let all = keys! {
        summary: true,
        chirps,
        tracked,
        single_wrong,
        tracked_wrong,
        single_rms_range_m: of(0, 0),
        tracked_rms_range_m: of(1, 0),
        single_rms_velocity_mps: of(0, 1),
        tracked_rms_velocity_mps: of(1, 1),
        numbers: &numbers,
    };
    let then: Vec<_> = numbers.iter().map(u16::to_string).collect();
    let cm = |who, what| 100.0 * of(who, what);
    let text = format!(
        "tracked in {tracked} of {chirps} chirps, as number {}\n\
           good but off by 2 m or 1 m/s   chirp alone {single_wrong}, tracked {tracked_wrong}\n\
           range rms                      chirp alone {:.2} cm, tracked {:.2} cm\n\
           velocity rms                   chirp alone {:.2} cm/s, tracked {:.2} cm/s\n",
        then.join(", then "),
        cm(0, 0),
        cm(1, 0),
        cm(0, 1),
        cm(1, 1)
    );
    let table = table(
        rows.iter().step_by(20),
        "time s: time_s .1 | SNR dB: snr_db .1 | true m: truth_range_m .3 | m/s: truth_velocity_mps .3 | chirp alone m: single/range_m .3 | \
         m/s: single/velocity_mps .3 | verdict: single/verdict | tracked m: tracked/range_m .3 | +-: tracked/sigma_range_m .3 | \
         m/s: tracked/velocity_mps .3 | +-: tracked/sigma_velocity_mps .3 | verdict: tracked/verdict",
        |_| false,
    );
    let single = rows.iter().filter_map(|row| Some((row.time_s, row.single?)));
    let single = single.filter(|(_, answer)| answer.verdict != Verdict::Weak);
    let tracked = rows.iter().flat_map(|row| row.targets.iter().map(|t| (row.time_s, t.1)));
    let at = |(time_s, answer): (f64, Answer)| (time_s, answer.place());
    let truth = rows.iter().map(|row| (row.time_s, row.truth()));
    let other = rows.iter().filter_map(|row| Some((row.time_s, row.other?)));
    let charts = over_time(
        ["drive-range", "drive-velocity"],
        "A drive at 77 GHz",
        CYCLES as f64 * CYCLE_S,
        [
            Axis::linear("range, m", 0.0, 200.0),
            Axis::linear("velocity towards the radar, m/s", -16.0, 16.0),
        ],
        &[
            ("chirp alone, not weak", Style::Points, 6, single.map(at).collect()),
            ("tracked", Style::Points, 0, tracked.map(at).collect()),
            ("truth", Style::Line, 1, truth.collect()),
            ("truth, another car", Style::Dashed, 2, other.collect()),
        ],
    );
    Ok(Shown {
        heading: format!(
            "A drive before a 77 GHz radar: 303 MHz in 1.01 ms, 12 bits at 1.024 MS/s, N = {N} per ramp, 20 chirps a second, seed {}",
            options.seed
        ),
        table,
        text,
        lines: lines(&rows, &all)?,
        charts,
        // One loss is in the script: the signal is cut off for half a second.
        right: tracked_wrong == 0 && numbers.len() <= 2,
    })
}

//! Four cars in front of a lidar: what each chirp shows of all of them, with only cars called good.

use super::feed::{N, records};
use super::options::Options;
use super::shown::{Answer, Keys, Points, Shown, keys, lines, over_time, rms, table};
use super::{DemoError, said};
use crate::plot::chart::{Axis, Style};
use crate::scenario::traffic::{self as scene, ACCELERATION, CARS, CYCLE_S, CYCLES};
use crate::scenario::{lidar, place};
use picket_dsp::plan::Solver;
use picket_dsp::solve::pairing::{MotionModel, Pairing};
use picket_dsp::{Pipeline, Real};
use picket_simulator::Run;
use serde::Serialize;

/// Nearer than this to a car an answer is of that car, in metres and in metres per second.
const NEAR: [f64; 2] = [0.5, 0.3];

/// Beats this many bins apart from any other, from DC and from half the rate can be measured.
const APART_BINS: f64 = 3.0;
const EDGE_BINS: f64 = 4.0;

/// The share of those cars that must be found.
const FOUND: f64 = 0.95;

/// One chirp or frame. The keys are those of the JSON lines.
#[derive(Serialize)]
pub(super) struct Row {
    pub row: usize,
    pub time_s: f64,
    pub cars: Vec<Car>,
    /// What it shows.
    pub targets: Vec<Answer>,
}

/// A car.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Car {
    pub range_m: f64,
    pub velocity_mps: f64,
    /// Whether it can be told from any other.
    pub apart: bool,
}

impl Car {
    const fn place(&self) -> [f64; 2] {
        [self.range_m, self.velocity_mps]
    }

    fn has(&self, answer: &Answer) -> bool {
        answer.is_near(self.place(), NEAR)
    }
}

/// What is said of the rows.
pub(super) struct Told {
    pub heading: String,
    /// What a row is, of several.
    pub what: &'static str,
    /// Of cars that can be found.
    pub found: &'static str,
    /// The names of the pictures, and what stands above them.
    pub name: [&'static str; 2],
    pub title: &'static str,
    pub seconds: f64,
    /// The first row that is expected to know all cars, and from one row of the table to the next.
    pub begin: usize,
    pub every: usize,
}

/// The result over all chirps: whether only cars are called good, and nearly all that are visible are found.
fn summary(rows: &[Row], told: &Told) -> (Keys, String, bool) {
    let good = rows.iter().flat_map(|row| row.targets.iter().map(move |answer| (row, answer)));
    let good: Vec<_> = good.filter(|(_, answer)| answer.is_good()).collect();
    let sigmas: Vec<[f64; 2]> = good
        .iter()
        .filter_map(|(row, answer)| {
            let car = row.cars.iter().find(|car| car.has(answer))?;
            let [range, velocity] = answer.off(car.place());
            Some([range / answer.sigma_range_m, velocity / answer.sigma_velocity_mps])
        })
        .collect();
    let [range_sigmas, velocity_sigmas] = [0, 1].map(|what| rms(sigmas.iter().map(|s| s[what])));
    let cars =
        rows.iter().skip(told.begin).flat_map(|row| row.cars.iter().map(move |car| (row, car)));
    let cars: Vec<_> = cars.filter(|(_, car)| car.apart).collect();
    let is_found =
        |(row, car): &&(&Row, &Car)| row.targets.iter().any(|a| a.is_good() && car.has(a));
    let (apart, found) = (cars.len(), cars.iter().filter(is_found).count());
    let (chirps, good, ghosts) = (rows.len(), good.len(), good.len() - sigmas.len());
    let text = format!(
        "{good} targets called good in {chirps} {}, {ghosts} of them ghosts\n\
         {found} of {apart} cars found {}\n\
         error over sigma   range {range_sigmas:.2}, velocity {velocity_sigmas:.2} (rms)\n",
        told.what, told.found
    );
    let right = ghosts == 0 && found as f64 >= FOUND * apart as f64;
    let all =
        keys! { summary: true, chirps, good, ghosts, apart, found, range_sigmas, velocity_sigmas };
    (all, text, right)
}

/// The cars at the moment to which a chirp's ranges refer, and which of them can be separated from the others.
fn cars(run: &Run, cycle: usize) -> Vec<Car> {
    let beats = std::array::from_fn::<_, { CARS.len() }, _>(|car| {
        let beat = |segment: usize| {
            let start_s = run.scene().start_s(3 * cycle + segment, N);
            run.truth(car, start_s, N).frequency_hz.abs() * N as f64 / run.scene().rate_hz
        };
        [0, 1, 2].map(beat)
    });
    let car = |(index, beat): (usize, &[f64; 3])| {
        let clear = |segment: usize| {
            let bins = beat[segment];
            let others = beats.iter().enumerate().filter(|(other, _)| *other != index);
            bins > EDGE_BINS
                && bins < (N / 2) as f64 - EDGE_BINS
                && others.map(|(_, o)| (o[segment] - bins).abs()).all(|apart| apart >= APART_BINS)
        };
        let [range_m, velocity_mps] = place(&run.truth_of_lap(index, cycle, N));
        Car { range_m, velocity_mps, apart: (0..3).all(clear) }
    };
    beats.iter().enumerate().map(car).collect()
}

/// Each chirp of a seed.
fn rows(seed: u64, snr_db: f64) -> Result<Vec<Row>, DemoError> {
    let plan = lidar().plan::<Real, N>().map_err(said)?;
    let Solver::Chirp(equations) = plan.solver else { return Err(said("no chirp")) };
    let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
    let habits = MotionModel { period_s: CYCLE_S as f32, acceleration: ACCELERATION as f32 };
    let mut pairing = Pairing::new(equations, false, habits);
    let scene = scene::scene(seed, N, snr_db);
    let truth = scene.run(0).map_err(said)?;
    let mut rows: Vec<Row> = Vec::new();
    for (stamp, samples) in records::<Real>(&scene, &lidar())? {
        let row = stamp.sequence as usize / 3;
        if row == rows.len() {
            let time_s = truth.truth_of_lap(0, row, N).time_s;
            rows.push(Row { row, time_s, cars: cars(&truth, row), targets: Vec::new() });
        }
        let measurement = pipeline.block(&stamp, &samples);
        let paired = pairing.push(&stamp, &pipeline.lines(&measurement, 4));
        rows[row].targets.extend(paired.iter().flatten().map(Answer::from));
    }
    Ok(rows)
}

/// A line of the table for each car with the target that is of it, the good one before others, and then for the targets of no car. The first
/// has the time.
fn pairs(row: &Row) -> Vec<Keys> {
    let mut left: Vec<&Answer> = row.targets.iter().collect();
    left.sort_by_key(|answer| !answer.is_good());
    let mut pairs: Vec<(Option<&Car>, Option<&Answer>)> = Vec::new();
    for car in &row.cars {
        let place = left.iter().position(|answer| car.has(answer));
        pairs.push((Some(car), place.map(|place| left.remove(place))));
    }
    pairs.extend(left.into_iter().map(|answer| (None, Some(answer))));
    let line = |(index, (car, answer)): (usize, (Option<&Car>, Option<&Answer>))| {
        let time = if index == 0 { format!("{:.1}", row.time_s) } else { String::new() };
        keys! { time, car, answer, off: car.zip(answer).map(|(car, answer)| answer.off(car.place())) }
    };
    pairs.into_iter().enumerate().map(line).collect()
}

/// Right: only cars are called good, and nearly all that are visible are found.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let rows = rows(options.seed, options.snr_db())?;
    let heading = format!(
        "Four cars before a lidar: 1550 nm, 1 GHz in 10 us, 12 bits at 250 MS/s, N = {N} per ramp, 20 chirps a second, {} dB at 20 m, \
         seed {}",
        options.snr_db(),
        options.seed
    );
    shown(&rows, Told { heading, ..told() })
}

/// What is said of the lidar's chirps.
fn told() -> Told {
    Told {
        heading: String::new(),
        what: "chirps",
        found: "whose three beats are 3 bins from any other",
        name: ["traffic-range", "traffic-velocity"],
        title: "Four cars before a lidar",
        seconds: CYCLES as f64 * CYCLE_S,
        // The first two of a run know no car yet.
        begin: 2,
        every: 40,
    }
}

/// The rows as a table, as figures and as pictures.
pub(super) fn shown(rows: &[Row], told: Told) -> Result<Shown, DemoError> {
    let (all, text, right) = summary(rows, &told);
    let shown: Vec<Keys> = rows.iter().step_by(told.every).flat_map(pairs).collect();
    let table = table(
        &shown,
        "time s: time | true m: car/range_m .3 | m/s: car/velocity_mps +.3 | measured m: answer/range_m .3 | m/s: answer/velocity_mps +.3 | \
         off cm: 100 off/0 +.2 | cm/s: 100 off/1 +.2 | verdict: answer/verdict",
        |_| false,
    );
    let good = |wanted: bool| {
        let all = rows.iter().flat_map(|row| row.targets.iter().map(|a| (row.time_s, a)));
        all.filter(|(_, a)| a.is_good() == wanted).map(|(time_s, a)| (time_s, a.place())).collect()
    };
    let way = |(car, label): (usize, _)| {
        let way = rows.iter().map(|row| (row.time_s, row.cars[car].place()));
        (label, Style::Line, 1 + car, way.collect())
    };
    let mut points: Vec<Points> =
        vec![("not good", Style::Points, 6, good(false)), ("good", Style::Points, 0, good(true))];
    points.extend(["truth, car 1", "car 2", "car 3", "car 4"].into_iter().enumerate().map(way));
    let charts = over_time(
        told.name,
        told.title,
        told.seconds,
        [
            Axis::linear("range, m", 0.0, 120.0),
            Axis::linear("velocity towards the sensor, m/s", -20.0, 20.0),
        ],
        &points,
    );
    Ok(Shown { heading: told.heading, table, text, lines: lines(rows, &all)?, charts, right })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_that_is_no_car_is_a_ghost() {
        let mut rows = rows(1, 20.0).unwrap();
        assert!(summary(&rows, &told()).2);
        let good = rows.iter_mut().flat_map(|row| &mut row.targets);
        good.take(100).for_each(|answer| answer.range_m += 1.0);
        assert!(!summary(&rows, &told()).2);
    }
}

//! Four cars in front of a lidar: what each chirp shows of all of them, with nothing called good that is no car.

use super::answer::{Answer, lines};
use super::drive::{check_both, save_both};
use super::measure::N;
use super::options::Options;
use super::{DemoError, said, shown};
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::lidar;
use crate::scenario::traffic::{self as scene, ACCELERATION, CYCLE_S, CYCLES, Car};
use crate::simulate::generator;
use picket_dsp::plan::Solver;
use picket_dsp::solve::pairing::{MotionModel, Pairing};
use picket_dsp::{Pipeline, Real, Segment, Stamp, Verdict};
use picket_simulator::Sensor;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// Nearer than this to a car an answer is of that car, in metres and in metres per second.
const NEAR_M: f64 = 0.5;
const NEAR_MPS: f64 = 0.3;

/// Beats this many bins apart from any other, from DC and from half the rate can be measured.
const APART_BINS: f64 = 3.0;
const EDGE_BINS: f64 = 4.0;

/// The share of those cars that must be found.
const FOUND: f64 = 0.95;

/// One chirp. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The chirp's number.
    pub row: usize,
    /// When.
    pub time_s: f64,
    /// The cars.
    pub cars: Vec<Truth>,
    /// What the chirp shows.
    pub targets: Vec<Answer>,
}

/// A car.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Truth {
    /// Metres.
    pub range_m: f64,
    /// Metres per second, positive when approaching.
    pub velocity_mps: f64,
    /// Whether its three beats are three bins from any other.
    pub apart: bool,
}

impl Answer {
    fn is_good(&self) -> bool {
        self.verdict == Verdict::Good.name()
    }

    fn is_of(&self, car: &Truth) -> bool {
        (self.range_m - car.range_m).abs() < NEAR_M
            && (self.velocity_mps - car.velocity_mps).abs() < NEAR_MPS
    }
}

/// The traffic as a whole.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Chirps.
    pub chirps: usize,
    /// Good targets.
    pub good: usize,
    /// Good targets that are not a car.
    pub ghosts: usize,
    /// Cars whose three beats are three bins from any other, summed over the chirps.
    pub apart: usize,
    /// Cars apart that were found, and good.
    pub found: usize,
    /// Root mean square of error over sigma, of the good targets' ranges.
    pub range_sigmas: f64,
    /// Root mean square of error over sigma, of the good targets' velocities.
    pub velocity_sigmas: f64,
}

impl Summary {
    /// Of all chirps. The first two of a run know no car yet.
    pub fn of(rows: &[Row]) -> Self {
        let mut summary = Summary { summary: true, chirps: rows.len(), ..Summary::default() };
        let mut squares = [0.0; 2];
        for row in rows {
            for answer in row.targets.iter().filter(|answer| answer.is_good()) {
                summary.good += 1;
                match row.cars.iter().find(|car| answer.is_of(car)) {
                    Some(car) => {
                        let range = (answer.range_m - car.range_m) / answer.sigma_range_m;
                        let velocity =
                            (answer.velocity_mps - car.velocity_mps) / answer.sigma_velocity_mps;
                        squares[0] += range * range;
                        squares[1] += velocity * velocity;
                    }
                    None => summary.ghosts += 1,
                }
            }
            for car in row.cars.iter().filter(|car| car.apart && row.row > 1) {
                summary.apart += 1;
                let found = row.targets.iter().any(|answer| answer.is_good() && answer.is_of(car));
                summary.found += usize::from(found);
            }
        }
        let real = summary.good.saturating_sub(summary.ghosts).max(1) as f64;
        [summary.range_sigmas, summary.velocity_sigmas] = squares.map(|sum| (sum / real).sqrt());
        summary
    }

    /// Whether nothing but cars is called good, and nearly all that can be are found.
    pub fn inside(&self) -> bool {
        self.ghosts == 0 && self.found as f64 >= FOUND * self.apart as f64
    }
}

/// The cars at the moment to which a chirp's ranges refer, and which of them can be told from the others.
fn truths(cars: &[Car; 4], lidar: &Sensor, cycle: usize) -> Vec<Truth> {
    let beats = cars.each_ref().map(|car| car.bins(lidar, cycle));
    let truth = |(index, car): (usize, &Car)| {
        let others = || beats.iter().enumerate().filter(move |(other, _)| *other != index);
        let clear = |segment: usize| {
            let bins = beats[index][segment];
            bins > EDGE_BINS
                && bins < (N / 2) as f64 - EDGE_BINS
                && others().all(|(_, other)| (other[segment] - bins).abs() >= APART_BINS)
        };
        let [range_m, velocity_mps] = car.at(scene::moment_s(lidar, cycle));
        Truth { range_m, velocity_mps, apart: (0..3).all(clear) }
    };
    cars.iter().enumerate().map(truth).collect()
}

/// Measures every chirp of a seed.
pub fn measured(seed: u64, snr_db: f64) -> Result<Vec<Row>, DemoError> {
    let plan = lidar().plan::<Real, N>().map_err(said)?;
    let Solver::Chirp(equations) = plan.solver else { return Err(said("no chirp")) };
    let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
    let habits = MotionModel { period_s: CYCLE_S as f32, acceleration: ACCELERATION as f32 };
    let mut pairing = Pairing::new(equations, false, habits);
    let rng = &mut generator(seed, 0);
    let (cars, lidar) = (scene::cars(rng), scene::lidar(N, snr_db));
    let rows = (0..CYCLES).map(|row| {
        let time_s = scene::moment_s(&lidar, row);
        let mut targets = Vec::new();
        for (index, segment) in [Segment::Up, Segment::Flat, Segment::Down].into_iter().enumerate()
        {
            let mut samples = [0; N];
            samples.copy_from_slice(&scene::samples(&lidar, &cars, row, index, rng));
            let stamp = Stamp { sequence: (3 * row + index) as u32, segment, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &samples);
            let paired = pairing.push(&stamp, &pipeline.lines(&measurement, 4));
            targets.extend(paired.iter().flatten().map(Answer::from));
        }
        Row { row, time_s, cars: truths(&cars, &lidar, row), targets }
    });
    Ok(rows.collect())
}

/// Measures, prints and draws. Failure: something else than a car is called good, or cars are not found.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    if let Some(file) = &options.plot {
        check_both(file, options.output)?;
    }
    let rows = measured(options.seed, options.snr_db())?;
    let summary = Summary::of(&rows);
    let draw = |file: &Path| draw(&rows, file, options.output);
    let print = || print(&rows, &summary, options);
    shown(options, draw, || lines(&rows, &summary), print, summary.inside())
}

/// Each car with the target that is of it, the good one before others, and then the targets of no car.
fn pairs(row: &Row) -> Vec<(Option<&Truth>, Option<&Answer>)> {
    let mut left: Vec<&Answer> = row.targets.iter().collect();
    left.sort_by_key(|answer| !answer.is_good());
    let mut pairs = Vec::new();
    for car in &row.cars {
        let place = left.iter().position(|answer| answer.is_of(car));
        pairs.push((Some(car), place.map(|place| left.remove(place))));
    }
    pairs.extend(left.into_iter().map(|answer| (None, Some(answer))));
    pairs
}

fn print(rows: &[Row], summary: &Summary, options: &Options) {
    outln!(
        "Four cars before a lidar: 1550 nm, 1 GHz in 10 us, 12 bits at 250 MS/s, N = {N} per ramp, 20 chirps a second, {} dB at \
         20 m, seed {}\n",
        options.snr_db(),
        options.seed
    );
    outln!(
        "{:>7} {:>9} {:>8} {:>11} {:>9} {:>8} {:>8}  verdict",
        "time s",
        "true m",
        "m/s",
        "measured m",
        "m/s",
        "off cm",
        "cm/s"
    );
    for row in rows.iter().step_by(40) {
        let mut time = format!("{:.1}", row.time_s);
        for (car, answer) in pairs(row) {
            let time = std::mem::take(&mut time);
            let truth = car.map_or(format!("{:>9} {:>8}", "-", "-"), |car| {
                format!("{:>9.3} {:>+8.3}", car.range_m, car.velocity_mps)
            });
            let measured = answer.map_or(String::new(), |a| {
                let off = car.map_or(format!("{:>8} {:>8}", "-", "-"), |car| {
                    let (range, velocity) =
                        (a.range_m - car.range_m, a.velocity_mps - car.velocity_mps);
                    format!("{:>+8.2} {:>+8.2}", 100.0 * range, 100.0 * velocity)
                });
                let Answer { range_m, velocity_mps, verdict, .. } = a;
                format!(" {range_m:>11.3} {velocity_mps:>+9.3} {off}  {verdict}")
            });
            outln!("{time:>7} {truth}{measured}");
        }
    }
    outln!(
        "\n{} targets called good in {} chirps, {} of them ghosts\n\
         {} of {} cars found whose three beats are {APART_BINS} bins from any other\n\
         error over sigma   range {:.2}, velocity {:.2} (rms)",
        summary.good,
        summary.chirps,
        summary.ghosts,
        summary.found,
        summary.apart,
        summary.range_sigmas,
        summary.velocity_sigmas
    );
}

/// Draws the ranges to `file` and the velocities beside it.
fn draw(rows: &[Row], file: &Path, output: Output) -> Result<(), DemoError> {
    let chart = |name, title: &str, y, take: fn(&Answer) -> f64, truth: fn(&Truth) -> f64| {
        let good = |wanted: bool| {
            let all = rows.iter().flat_map(|row| row.targets.iter().map(move |a| (row.time_s, a)));
            all.filter(move |(_, a)| a.is_good() == wanted).map(move |(time, a)| (time, take(a)))
        };
        let mut series = vec![
            Series::new("not good", Style::Points, 6, good(false)),
            Series::new("good", Style::Points, 0, good(true)),
        ];
        for (car, label) in ["truth, car 1", "car 2", "car 3", "car 4"].into_iter().enumerate() {
            let way = rows.iter().map(|row| (row.time_s, truth(&row.cars[car])));
            series.push(Series::new(label, Style::Line, 1 + car, way));
        }
        let x = Axis::linear("time, s", 0.0, CYCLES as f64 * CYCLE_S);
        Chart { name, title: title.into(), x, y, series }
    };
    let ranges = chart(
        "traffic-range",
        "Four cars before a lidar: range",
        Axis::linear("range, m", 0.0, 120.0),
        |answer| answer.range_m,
        |car| car.range_m,
    );
    let velocities = chart(
        "traffic-velocity",
        "Four cars before a lidar: velocity",
        Axis::linear("velocity towards the lidar, m/s", -20.0, 20.0),
        |answer| answer.velocity_mps,
        |car| car.velocity_mps,
    );
    save_both(&ranges, &velocities, file, output)
}

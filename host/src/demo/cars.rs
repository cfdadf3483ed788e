//! Four cars in front of a radar that sends frames of chirps: what each frame shows of all of them, with nothing called good that is no car.

use super::options::Options;
use super::shown::{Answer, Shown};
use super::traffic::{Car, Row, Told, shown};
use super::{DemoError, said};
use crate::scenario::cars::{self as radar, CHIRPS, EVERY, FRAMES, N, PERIOD_S};
use crate::scenario::{place, record};
use picket_dsp::frame::{Cells, Frame, FramePlan};
use picket_dsp::{Iq, Pipeline, Plan};
use picket_simulator::Run;
use rayon::prelude::*;

/// Cars so many cells apart in range or in velocity can be told from each other.
const APART: f64 = 3.0;

/// A car nearer to the ends of the band than so many cells is beside it.
const EDGE: f64 = 4.0;

/// What the words below the table say of cars that can be found.
const FOUND: &str = "that are 3 cells from any other in range or in velocity";

/// The sizes of a cell, m and m/s.
fn cells(plan: &FramePlan) -> [f64; 2] {
    let chirp = radar::config().chirp;
    let swept = chirp.bandwidth_hz * N as f64 / radar::config().rate_hz / chirp.duration_s;
    [
        picket_dsp::config::SPEED_OF_LIGHT / (2.0 * swept),
        f64::from(plan.alias_mps()) / CHIRPS as f64,
    ]
}

/// The cars in the middle of a frame, and which of them can be told from the others.
fn cars(run: &Run, plan: &FramePlan, middle_s: f64) -> Vec<Car> {
    let places: Vec<[f64; 2]> =
        (0..run.scene().sources.len()).map(|car| place(&run.truth(car, middle_s, 1))).collect();
    let [bin, row] = cells(plan);
    let car = |(index, &[range_m, velocity_mps]): (usize, &[f64; 2])| {
        let others = places.iter().enumerate().filter(|(other, _)| *other != index);
        let mut apart = others.map(|(_, other)| {
            ((other[0] - range_m) / bin).abs().max(((other[1] - velocity_mps) / row).abs())
        });
        let inside = range_m > EDGE * bin && range_m < (N as f64 / 2.0 - EDGE) * bin;
        Car { range_m, velocity_mps, apart: inside && apart.all(|cells| cells >= APART) }
    };
    places.iter().enumerate().map(car).collect()
}

/// The chirps of a frame, and the cars in its middle.
struct Taken {
    chirps: Vec<Vec<[i16; 2]>>,
    time_s: f64,
    cars: Vec<Car>,
}

/// A frame of a run.
fn taken(run: &mut Run, plan: &FramePlan, number: usize) -> Taken {
    let first = number * EVERY;
    let ends = [first, first + CHIRPS - 1].map(|index| run.scene().start_s(index, N));
    let middle_s = f64::midpoint(ends[0], ends[1]) + 0.5 * (N - 1) as f64 / radar::config().rate_hz;
    let chirps = (first..first + CHIRPS).map(|index| record::<Iq>(run, index, N)).collect();
    Taken { chirps, time_s: middle_s, cars: cars(run, plan, middle_s) }
}

/// What a frame shows.
fn row(number: usize, taken: Taken, plan: FramePlan) -> Result<Row, DemoError> {
    let mut memory = vec![[0i16; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Narrow(&mut memory)).ok_or_else(|| said("no room"))?;
    let codes = radar::codes();
    let mut pipeline = Box::new(Pipeline::<Iq, N>::new(Plan::tone(radar::config().rate_hz, codes)));
    for samples in &taken.chirps {
        let samples = samples.as_array().ok_or_else(|| said("a record of another length"))?;
        let clipped = pipeline.look(samples);
        frame.push(&pipeline.spectrum().view(), clipped);
    }
    let targets = frame.targets().iter().map(|found| Answer::from(&found.target)).collect();
    Ok(Row { row: number, time_s: taken.time_s, cars: taken.cars, targets })
}

/// Each frame of a seed.
fn rows(seed: u64, snr_db: f64) -> Result<Vec<Row>, DemoError> {
    let plan = radar::config().plan().map_err(said)?;
    let mut run = radar::scene(seed, snr_db).run(0).map_err(said)?;
    let frames: Vec<Taken> = (0..FRAMES).map(|number| taken(&mut run, &plan, number)).collect();
    let rows = frames.into_par_iter().enumerate();
    rows.map(|(number, taken)| row(number, taken, plan)).collect()
}

/// Right: nothing but cars is called good, and nearly all that can be are found.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let rows = rows(options.seed, options.snr_db())?;
    let heading = format!(
        "Four cars before a radar: 77 GHz, 150 MHz in 50 us, 12 bits at 5.12 MS/s I/Q, {CHIRPS} chirps of {N} samples a frame, 10 frames in 3 s, \
         {} dB at 20 m, seed {}",
        options.snr_db(),
        options.seed
    );
    let told = Told {
        heading,
        what: "frames",
        found: FOUND,
        name: ["cars-range", "cars-velocity"],
        title: "Four cars before a radar of 77 GHz",
        seconds: (FRAMES * EVERY) as f64 * PERIOD_S,
        // The first frame knows each car.
        begin: 0,
        every: 7,
    };
    shown(&rows, told)
}

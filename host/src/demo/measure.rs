//! Feeds the firmware with targets and reads its answers.

use super::options::{Board, Options};
use super::table::{Answer, Result as Row, Summary};
use super::{DemoError, pico, said};
use crate::device::{Listener, Said};
use crate::emulator::{Capture, Machine, RunError};
use crate::progress;
use crate::scenario::{self, Laser, radar};
use crate::simulate::{Kind, Signal, generator};
use crate::toolchain::{Firmware, Need, Profile, have, io_error};
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_simulator::Sensor;
use picket_wire::capture::Header;
use picket_wire::telemetry::Telemetry;
use rayon::prelude::*;
use std::fs;
use std::time::Duration;

/// Samples in a block.
pub const N: usize = 1024;

/// The amplitude that uses a 12-bit converter well: tone plus four sigmas of the noise reach the rail.
fn amplitude(snr_db: f64) -> f64 {
    2047.0 / (1.0 + 4.0 * Signal::tone(0.0, 1.0, snr_db).sigma())
}

/// Of that, for speckle: it is above twice its root mean square in one moment of fifty.
const SPECKLED: f64 = 0.5;

/// The lidar's rows, once for each seed.
pub fn lidar(options: &Options) -> Result<Summary, DemoError> {
    let lidar = Lidar::new(options.method, options.laser())?;
    let measurements = lidar.on_board(options)?;
    Ok(lidar.summary(measurements.iter(), options.seeds))
}

/// The lidar's task: what is set and what is in front of it.
pub(super) struct Lidar {
    pub config: Config,
    method: Method,
    pub rows: Vec<scenario::Row>,
    pub sensor: Sensor,
    bent: Option<String>,
}

impl Lidar {
    pub fn new(method: Option<Method>, laser: Laser) -> Result<Self, DemoError> {
        let config = configured(scenario::lidar(), method);
        let plan = config.plan::<Real, N>().map_err(said)?;
        let sensor = laser.sensor(&config, N);
        let bent = (laser != Laser::default()).then(|| {
            let Laser { linewidth_hz, sweep_error } = laser;
            format!(
                "laser of {} kHz linewidth, ramps bent by {} % of the bandwidth",
                1e-3 * linewidth_hz,
                100.0 * sweep_error
            )
        });
        let method = plan.options.method;
        Ok(Lidar { config, method, rows: scenario::table3(), sensor, bent })
    }

    /// What a board measures of the rows, once for each seed.
    pub fn on_board(&self, options: &Options) -> Result<Vec<Measurement>, DemoError> {
        let Lidar { config, ref rows, ref sensor, .. } = *self;
        let records = match options.board {
            // A NUCLEO was refused before: it is for other scenes.
            Board::Mps2 | Board::Nucleo => measured::<Real>(config, sensor, rows, options)?,
            Board::Pico => pico::lidar(config, sensor, rows, options)?,
        };
        Ok(records.into_iter().map(|record| record.measurement).collect())
    }

    /// What the firmware's pipeline measures of them on this machine, from the same samples, once for each seed.
    pub fn on_host(
        &self,
        snr_db: f64,
        seed: u64,
        seeds: u64,
    ) -> Result<Vec<Measurement>, DemoError> {
        let plan = self.config.plan::<Real, N>().map_err(said)?;
        let per_seed = (self.rows.len() * self.sensor.segments()) as u32;
        let of_seed = |index: u64| {
            let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
            let seed = seed.wrapping_add(index);
            let blocks = blocks::<Real>(&self.sensor, &self.rows, None, snr_db, seed);
            let measured = (0u32..).zip(blocks).map(|(trial, samples)| {
                let segment = [Segment::Up, Segment::Flat, Segment::Down][trial as usize % 3];
                let sequence = index as u32 * per_seed + trial;
                let stamp = Stamp { sequence, segment, ..Stamp::default() };
                samples.as_array().map(|samples| pipeline.block(&stamp, samples))
            });
            measured.flatten().collect::<Vec<_>>()
        };
        Ok((0..seeds).into_par_iter().flat_map_iter(of_seed).collect())
    }

    /// The numbers of the rows, from 1 on, that two runs do not answer with the same bits.
    pub fn different(&self, one: &[Measurement], other: &[Measurement]) -> Vec<usize> {
        let segments = self.sensor.segments();
        let row = |all: &[Measurement], row: usize| -> Vec<_> {
            let of_row = all.iter().filter(|m| m.stamp.sequence as usize / segments == row);
            of_row.map(|m| (m.stamp.sequence, m.clipped, m.tone, m.result)).collect()
        };
        let same = |&at: &usize| {
            let answers = row(one, at);
            answers.len() == segments && answers == row(other, at)
        };
        (0..self.rows.len()).filter(|at| !same(at)).map(|at| at + 1).collect()
    }

    /// Truth beside measurement, for this many seeds one after the other.
    pub fn summary<'a>(
        &self,
        measurements: impl Iterator<Item = &'a Measurement>,
        seeds: u64,
    ) -> Summary {
        let answers = measurements.filter_map(|measurement| answer(measurement, 3));
        let rows: Vec<_> = (0..seeds).flat_map(|_| self.rows.iter().copied()).collect();
        let results = results(&rows, answers);
        let (method, bent) = (self.method.name().into(), self.bent.clone());
        Summary { results, bars: scenario::LIDAR_BARS, method, mixing: None, bent }
    }
}

/// Targets in front of the 24 GHz radar, by both shapes.
pub fn radar(options: &Options) -> Result<Summary, DemoError> {
    let (rows, mut results, mut method) = (radar::rows(), Vec::new(), Method::default());
    for shape in radar::SHAPES {
        let config = configured(radar::config(shape, options.mixing()), options.method);
        method = config.plan::<Iq, N>().map_err(said)?.options.method;
        let sensor = scenario::sensor::<Iq>(&config, N, 0.0);
        let records = measured::<Iq>(config, &sensor, &rows, options)?;
        let measurements = records.iter().map(|record| &record.measurement);
        let answers = measurements.filter_map(|record| answer(record, sensor.segments()));
        let of_shape = self::results(&rows, answers);
        results.extend(of_shape.into_iter().map(|row| Row { shape: Some(shape), ..row }));
    }
    let mixing = Some(options.mixing());
    Ok(Summary { results, bars: radar::BARS, method: method.name().into(), mixing, bent: None })
}

/// The row that a target is of, and its answer.
fn answer(measurement: &Measurement, segments: usize) -> Option<(usize, Answer)> {
    let Outcome::Target(target) = measurement.result else { return None };
    let answer = Answer {
        range_m: target.range.to_num(),
        velocity_mps: target.velocity.map_or(f64::NAN, |velocity| velocity.to_num()),
        sigma_range_m: target.sigma_range.into(),
        sigma_velocity_mps: target.sigma_velocity.into(),
        verdict: target.verdict,
    };
    Some((measurement.stamp.sequence as usize / segments, answer))
}

/// The turntable's speeds.
pub fn turntable(options: &Options) -> Result<Summary, DemoError> {
    let config = configured(scenario::turntable(), options.method);
    let plan = config.plan::<Iq, N>().map_err(said)?;
    let rows = scenario::turntable_rows();
    let sensor = scenario::sensor::<Iq>(&config, N, 0.0);
    let records = measured::<Iq>(config, &sensor, &rows, options)?;
    let answers = records.iter().filter_map(|record| match record.measurement.result {
        Outcome::Velocity(velocity) => Some((
            record.measurement.stamp.sequence as usize,
            Answer {
                range_m: 0.0,
                velocity_mps: velocity.velocity.to_num(),
                sigma_range_m: 0.0,
                sigma_velocity_mps: velocity.sigma.into(),
                verdict: velocity.verdict,
            },
        )),
        _ => None,
    });
    let results = results(&rows, answers);
    let method = plan.options.method.name().into();
    let bent = options.spot_mm.map(|spot_mm| format!("rough rim below a spot of {spot_mm} mm"));
    Ok(Summary { results, bars: scenario::TURNTABLE_BARS, method, mixing: None, bent })
}

fn configured(config: Config, method: Option<Method>) -> Config {
    Config { method: method.unwrap_or(config.method), ..config }
}

/// The records of rows, one for each segment, in order, with the noise of a seed. The targets are rough where the beam's spot has a
/// diameter.
pub(super) fn blocks<R: Record>(
    sensor: &Sensor,
    rows: &[scenario::Row],
    spot_m: Option<f64>,
    snr_db: f64,
    seed: u64,
) -> impl Iterator<Item = Vec<R::Sample>> {
    let segments = rows.iter().flat_map(|row| (0..sensor.segments()).map(move |s| (row, s)));
    segments.zip(0..).map(move |((row, segment), trial)| {
        let rng = &mut generator(seed, trial);
        let amplitude = amplitude(snr_db);
        let target = match spot_m {
            Some(spot_m) => row.rough(sensor, amplitude * SPECKLED, spot_m, rng),
            None => row.target(sensor, amplitude, rng),
        };
        scenario::received::<R>(sensor, segment, target, snr_db, rng)
    })
}

/// The records of the rows for each seed, through the firmware.
fn measured<R: Kind>(
    config: Config,
    sensor: &Sensor,
    rows: &[scenario::Row],
    options: &Options,
) -> Result<Vec<Telemetry>, DemoError> {
    let blocks = (rows.len() * sensor.segments()) as u64 * options.seeds;
    let header = Header::from_config::<R>(config, N as u32, blocks as u32);
    let mut capture = Capture::create(&header).map_err(said)?;
    for seed in options.seed..options.seed.wrapping_add(options.seeds) {
        for samples in self::blocks::<R>(sensor, rows, options.spot_m(), options.snr_db(), seed) {
            capture.push::<R>(&samples).map_err(said)?;
        }
    }
    let bar = progress::bar(blocks, "blocks");
    let mut records = Vec::new();
    play(capture, options, |record| {
        bar.inc(1);
        records.push(record);
    })
    .map_err(said)?;
    bar.finish_and_clear();
    Ok(records)
}

/// Plays a capture to the firmware; `take` gets each record as it comes. Gives what was lost on the way.
pub fn play(
    capture: Capture,
    options: &Options,
    mut take: impl FnMut(Telemetry),
) -> Result<Listener, RunError> {
    play_on("frontend_qemu", capture, options, |said| {
        if let Said::Telemetry(record) = said {
            take(record);
        }
    })
}

/// Plays a capture to another image, and returns all that the image says.
pub fn play_on(
    bin: &'static str,
    capture: Capture,
    options: &Options,
    mut take: impl FnMut(Said),
) -> Result<Listener, RunError> {
    have(&[Need::Core(BOARD.target()), Need::Emulator])?;
    let features: &[&str] = if options.log.is_some() { &["mps2", "log"] } else { &["mps2"] };
    let profile = Profile::Release;
    let image = Firmware { bin, target: BOARD.target(), features, profile };
    let image = image.build()?;
    let mut listener = Listener::default();
    let outcome = capture.run(BOARD, &image, LIMIT, |piece| {
        listener.read(piece).into_iter().for_each(&mut take);
    })?;
    if let Some(file) = &options.log {
        fs::write(file, &outcome.log).map_err(io_error(file.display()))?;
        eprintln!("the log: defmt-print -e {} <{}", image.display(), file.display());
    }
    Ok(listener)
}

/// The board that has DMA.
const BOARD: Machine = Machine::An505;

/// No run takes longer.
const LIMIT: Duration = Duration::from_secs(3600);

/// Rows with their answers, where one arrived.
fn results(truths: &[scenario::Row], answers: impl Iterator<Item = (usize, Answer)>) -> Vec<Row> {
    let mut results: Vec<Row> =
        truths.iter().map(|&truth| Row { truth, shape: None, answer: None }).collect();
    for (row, answer) in answers {
        if let Some(result) = results.get_mut(row) {
            result.answer = Some(answer);
        }
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_or_a_lost_record_is_a_row_that_differs() {
        let lidar = Lidar::new(None, Laser::default()).unwrap();
        let measured = lidar.on_host(-5.0, 1, 1).unwrap();
        let none: [usize; 0] = [];
        assert_eq!(lidar.different(&measured, &measured), none);
        let mut other = measured.clone();
        other[7].tone.sigma = f32::from_bits(other[7].tone.sigma.to_bits() ^ 1);
        assert_eq!(lidar.different(&measured, &other), [3]);
        other.pop();
        assert_eq!(lidar.different(&measured, &other), [3, 28]);
        assert_eq!(lidar.different(&other[..0], &other[..0]).len(), 28);
    }
}

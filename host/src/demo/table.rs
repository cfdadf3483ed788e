//! Targets one after the other, measured by a board's firmware: truth next to measurement, and whether each error is within the paper's limits.

use super::feed::{N, play};
use super::options::{Board, Options};
use super::shown::{Answer, Keys, Shown, code, is_usable, keys, lines, rms, table};
use super::{DemoError, pico, said};
use crate::device::Said;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::{self, Bars, Laser, Row, radar as before_radar, record};
use crate::simulate::{Kind, Signal};
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::{Mixing, Shape, Verdict};
use picket_simulator::Scene;
use picket_wire::telemetry::Telemetry;
use rayon::prelude::*;
use std::process::ExitCode;

/// A row and its answer, if a record of it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The truth.
    pub truth: Row,
    /// The chirp's shape, where the table has several.
    pub shape: Option<Shape>,
    /// The measurement.
    pub answer: Option<Answer>,
}

impl Measured {
    const fn true_place(&self) -> [f64; 2] {
        [self.truth.range_m, self.truth.velocity_mps]
    }

    /// Errors in metres and metres per second.
    pub fn errors(&self) -> Option<[f64; 2]> {
        Some(self.answer?.off(self.true_place()))
    }

    /// True where both errors are inside the bars. A row without an answer is outside.
    pub fn inside(&self, bars: &Bars) -> bool {
        self.errors().is_some_and(|[range, velocity]| {
            range.abs() <= bars.range_m && velocity.abs() <= bars.velocity_mps
        })
    }

    fn is_usable(&self) -> bool {
        self.answer.is_some_and(|answer| is_usable(answer.verdict))
    }
}

/// A range or a velocity: its line below a table, and its picture.
#[derive(Clone, Copy, Debug)]
struct Quantity {
    /// Its place among range and velocity.
    what: usize,
    name: &'static str,
    /// The unit of an error, and what a metre or a metre per second is in it.
    unit: (&'static str, f64),
    /// Digits of an error's root mean square, and of the bar.
    digits: [usize; 2],
    /// Who sets the bar.
    bar: &'static str,
    /// The picture of its errors: its name, and what it is of.
    picture: [&'static str; 2],
    /// What the error is drawn over: its place as above, and the axis.
    over: (usize, &'static str, f64, f64),
    /// The axis of the error.
    error: &'static str,
}

/// How the results of a scene are shown, and what they must keep to.
#[derive(Clone, Copy, Debug)]
struct Look {
    columns: &'static str,
    quantities: &'static [Quantity],
    bars: Bars,
}

const PAPER: &str = "the paper: at most";
const OVER_RANGE: (usize, &str, f64, f64) = (0, "range, m", 0.0, 120.0);
const LIDAR: Look = Look {
    columns: "row: row | true L m: truth_range_m .0 | true V km/h: 3.6 truth_velocity_mps +.0 | L m: range_m .3 ± sigma_range_m | \
              V km/h: 3.6 velocity_mps +.3 ± sigma_velocity_mps | dL cm: 100 off/0 +.2 | dV km/h: 3.6 off/1 +.3 | verdict: verdict",
    quantities: &[
        Quantity {
            what: 0,
            name: "range",
            unit: ("cm", 100.0),
            digits: [2, 0],
            bar: PAPER,
            picture: ["lidar-range", "Targets before a lidar: error of the range"],
            over: OVER_RANGE,
            error: "error, cm",
        },
        Quantity {
            what: 1,
            name: "velocity",
            unit: ("km/h", 3.6),
            digits: [3, 2],
            bar: PAPER,
            picture: ["lidar-velocity", "Targets before a lidar: error of the velocity"],
            over: OVER_RANGE,
            error: "error, km/h",
        },
    ],
    bars: scenario::LIDAR_BARS,
};
const RESOLUTION: &str = "the bar, a tenth of the resolution:";
const RADAR: Look = Look {
    columns: "row: row | shape: shape | true L m: truth_range_m .0 | true V m/s: truth_velocity_mps +.0 | L m: range_m .3 ± sigma_range_m | \
              V m/s: velocity_mps +.3 ± sigma_velocity_mps | dL cm: 100 off/0 +.2 | dV m/s: off/1 +.3 | verdict: verdict",
    quantities: &[
        Quantity { digits: [2, 1], bar: RESOLUTION, ..LIDAR.quantities[0] },
        Quantity { unit: ("m/s", 1.0), digits: [3, 3], bar: RESOLUTION, ..LIDAR.quantities[1] },
    ],
    bars: before_radar::BARS,
};
const TURNTABLE: Look = Look {
    columns: "row: row | true V mm/s: 1e3 truth_velocity_mps +.3 | V mm/s: 1e3 velocity_mps +.3 ± sigma_velocity_mps | \
              dV mm/s: 1e3 off/1 +.3 | verdict: verdict",
    quantities: &[Quantity {
        unit: ("mm/s", 1e3),
        digits: [3, 0],
        bar: "the paper: below",
        picture: ["turntable", "A turntable before a velocimeter: error of the rim's speed"],
        over: (1, "speed of the rim, m/s", -4.0, 4.0),
        error: "error, mm/s",
        ..LIDAR.quantities[1]
    }],
    bars: scenario::TURNTABLE_BARS,
};

/// A table of results and what it must keep to.
#[derive(Clone, Debug)]
pub struct Summary {
    /// All rows, in order.
    pub results: Vec<Measured>,
    /// The method's name.
    pub method: String,
    /// Which signal the receiver conjugates, where there is a choice.
    mixing: Option<Mixing>,
    /// What bends the phase within a block, for people: then the table has the errors of usable answers, too.
    bent: Option<String>,
    look: Look,
}

impl Summary {
    /// How many rows are inside the bars.
    pub fn inside(&self) -> usize {
        self.results.iter().filter(|result| self.has(result)).count()
    }

    fn has(&self, row: &Measured) -> bool {
        row.inside(&self.look.bars)
    }

    /// Root mean square and largest magnitude of an error over the rows that have an answer.
    fn spread(&self, what: usize) -> (f64, f64) {
        let errors = || self.results.iter().filter_map(|row| Some(row.errors()?[what]));
        (rms(errors()), errors().map(f64::abs).fold(0.0, f64::max))
    }

    /// Root mean square of the errors of what may be used, and of these over their sigmas. A velocimeter has no range, and no sigma of it.
    fn usable(&self, what: usize) -> (f64, f64) {
        let usable = || self.results.iter().filter(|result| result.is_usable());
        let errors = || usable().filter_map(|row| Some((row.errors()?[what], row.answer?)));
        let sigmas = errors().map(|(error, answer)| error / answer.sigmas()[what]);
        (rms(errors().map(|(error, _)| error)), rms(sigmas.filter(|ratio| ratio.is_finite())))
    }

    fn count_usable(&self) -> usize {
        self.results.iter().filter(|result| result.is_usable()).count()
    }

    /// The rows, for people.
    pub fn rows_text(&self) -> String {
        let row = |(keys, row): (Keys, &Measured)| {
            let off = ("off", serde_json::json!(row.errors()));
            Keys(keys.0.into_iter().chain([off]).collect())
        };
        let rows: Vec<Keys> = self.keys().into_iter().zip(&self.results).map(row).collect();
        let inside = |keys: &Keys| keys.0.contains(&("inside", true.into()));
        table(&rows, self.look.columns, |row| !inside(row))
    }

    /// What stands below the rows.
    pub fn text(&self) -> String {
        let (inside, rows) = (self.inside(), self.results.len());
        let mut text = format!("{inside} of {rows} rows inside, by {}\n", self.method);
        for q in self.look.quantities {
            let ((unit, scale), [digits, of_bar]) = (q.unit, q.digits);
            let (rms, worst) = self.spread(q.what);
            let [rms, worst, bar] =
                [rms, worst, self.look.bars.of(q.what)].map(|error| scale * error);
            let name = q.name;
            let errors =
                format!("{name:<9} rms {rms:.digits$} {unit}, worst {worst:.digits$} {unit}");
            text += &format!("  {errors:<42} ({} {bar:.of_bar$} {unit})\n", q.bar);
        }
        let Some(bent) = &self.bent else { return text };
        let usable = self.count_usable();
        text += &format!("{bent}: {usable} of {rows} usable within sigma\n");
        for Quantity { what, name, unit: (unit, scale), digits: [digits, _], .. } in
            self.look.quantities
        {
            let (rms, sigmas) = self.usable(*what);
            let rms = format!("{:.digits$} {unit}", scale * rms);
            text += &format!("  {name:<9} rms {rms}, error over sigma {sigmas:.2}\n");
        }
        text
    }

    /// What each row has, for programs.
    fn keys(&self) -> Vec<Keys> {
        let row = |(index, result): (usize, &Measured)| {
            let answer = result.answer;
            let mut keys = keys! {
                row: index + 1,
                truth_range_m: result.truth.range_m,
                truth_velocity_mps: result.truth.velocity_mps,
                range_m: answer.map(|a| a.range_m),
                velocity_mps: answer.map(|a| a.velocity_mps),
                sigma_range_m: answer.map(|a| a.sigma_range_m),
                sigma_velocity_mps: answer.map(|a| a.sigma_velocity_mps),
                verdict: answer.map_or(Verdict::NoSignal, |a| a.verdict).name(),
                inside: self.has(result),
                method: &self.method,
            };
            keys.0.extend(result.shape.map(|shape| ("shape", name(shape).into())));
            keys.0.extend(self.mixing.map(|mixing| ("mixing", mixing.name().into())));
            keys
        };
        self.results.iter().enumerate().map(row).collect()
    }

    /// One object a line, the summary last.
    fn lines(&self) -> Result<Vec<String>, DemoError> {
        let method = &self.method;
        let [(rms_range_m, worst_range_m), (rms_velocity_mps, worst_velocity_mps)] =
            [0, 1].map(|what| self.spread(what));
        let [(usable_rms_range_m, range_sigmas), (usable_rms_velocity_mps, velocity_sigmas)] =
            [0, 1].map(|what| self.usable(what));
        let [bar_range_m, bar_velocity_mps] = [0, 1].map(|what| self.look.bars.of(what));
        let (inside, usable) = (self.inside(), self.count_usable());
        let mut all = keys! {
            summary: true, rows: self.results.len(), inside, rms_range_m, worst_range_m, rms_velocity_mps, worst_velocity_mps,
            bar_range_m, bar_velocity_mps, usable, usable_rms_range_m, usable_rms_velocity_mps, range_sigmas,
            velocity_sigmas, method,
        };
        all.0.extend(self.mixing.map(|mixing| ("mixing", mixing.name().into())));
        lines(&self.keys(), &all)
    }

    /// The table and its pictures.
    pub fn shown(&self, options: &Options) -> Result<Shown, DemoError> {
        Ok(Shown {
            heading: heading(options),
            table: self.rows_text(),
            text: self.text(),
            lines: self.lines()?,
            charts: self.look.quantities.iter().map(|quantity| self.chart(quantity)).collect(),
            right: self.inside() == self.results.len(),
        })
    }

    /// The errors of a quantity and their sigmas, with the bar.
    fn chart(&self, q: &Quantity) -> Chart {
        let (_, scale) = q.unit;
        let of = |wanted: bool| -> Vec<[f64; 3]> {
            let rows = self.results.iter().filter(|row| row.is_usable() == wanted);
            let seen = rows.filter_map(|row| {
                let (error, sigma) = (row.errors()?[q.what], row.answer?.sigmas()[q.what]);
                Some([row.true_place()[q.over.0], scale * error, scale * sigma])
            });
            seen.collect()
        };
        // An answer that cannot be used may be off by any number: it does not stretch the axis.
        let (usable, bar) = (of(true), scale * self.look.bars.of(q.what));
        let most = usable.iter().map(|[_, error, sigma]| error.abs() + sigma).fold(bar, f64::max);
        let series = |label, colour, seen: &[[f64; 3]]| {
            Series::new(label, Style::Points, colour, seen.iter().map(|s| (s[0], s[1])))
                .with_errors(seen.iter().map(|s| s[2]))
        };
        let (_, over, from, to) = q.over;
        let limit = |label, at| Series::new(label, Style::Dashed, 1, [(from, at), (to, at)]);
        let [name, title] = q.picture;
        Chart {
            name,
            title: title.into(),
            x: Axis::linear(over, from, to),
            y: Axis::linear(q.error, -1.2 * most, 1.2 * most),
            series: vec![
                series("not usable ± sigma", 6, &of(false)),
                series("usable ± sigma", 0, &usable),
                limit("+ the paper's accuracy", bar),
                limit("- the paper's accuracy", -bar),
            ],
        }
    }
}

/// The name of a shape.
const fn name(shape: Shape) -> &'static str {
    match shape {
        Shape::Trapezoid => "trapezoid",
        Shape::Triangle => "triangle",
        Shape::Sawtooth => "sawtooth",
    }
}

pub(super) fn heading(options: &Options) -> String {
    use super::options::Scenario;
    let (snr, seed) = (options.snr_db(), options.seed);
    let what = match options.scenario {
        Scenario::Table3 if options.board == Board::Pico => format!(
            "The lidar of Ye et al. 2022 at a Pico's 500 kS/s, ramps of {:.3} ms solved by the host, N = {N}",
            1e3 * N as f64 / pico::RATE_HZ
        ),
        Scenario::Table3 => format!(
            "Lidar of Ye et al. 2022: 1550 nm, 1 GHz in 10 us, 12 bits at 250 MS/s, N = {N} per ramp"
        ),
        Scenario::Radar => format!(
            "Radar: 24 GHz, 200 MHz in 4.224 ms, I/Q ({}), 12 bits at 250 kS/s, N = {N} per ramp",
            options.mixing().name()
        ),
        _ => format!(
            "Velocimeter of Yang et al. 2011: 1550 nm, rim of {} mm, I/Q at 10 MS/s, N = {N}",
            scenario::TURNTABLE_RADIUS_M * 1e3
        ),
    };
    format!("{what}, {snr} dB, seed {seed}")
}

/// A table's task: what is set, and what is in front of it.
pub(super) struct Task {
    pub config: Config,
    method: Method,
    rows: Vec<Row>,
    sensor: Scene,
    look: Look,
    bent: Option<String>,
    spot_m: Option<f64>,
}

impl Task {
    fn new<R: Record>(
        (config, method): (Config, Option<Method>),
        rows: Vec<Row>,
        look: Look,
    ) -> Result<Self, DemoError> {
        let config = Config { method: method.unwrap_or(config.method), ..config };
        let method = config.plan::<R, N>().map_err(said)?.options.method;
        let sensor = scenario::sensor::<R>(&config, N, 0.0, 1);
        Ok(Task { config, method, rows, sensor, look, bent: None, spot_m: None })
    }

    /// The lidar's, with its laser.
    pub fn lidar(method: Option<Method>, laser: Laser) -> Result<Self, DemoError> {
        let task = Task::new::<Real>((scenario::lidar(), method), scenario::table3(), LIDAR)?;
        let Laser { linewidth_hz, sweep_error } = laser;
        let bent = (laser != Laser::default()).then(|| {
            let (khz, share) = (1e-3 * linewidth_hz, 100.0 * sweep_error);
            format!("laser of {khz} kHz linewidth, ramps bent by {share} % of the bandwidth")
        });
        Ok(Task { sensor: laser.of(task.sensor), bent, ..task })
    }

    /// The records of all rows, one for each segment, in order, with the noise of a seed.
    pub fn blocks<R: Record>(
        &self,
        snr_db: f64,
        seed: u64,
    ) -> Result<Vec<Vec<R::Sample>>, DemoError> {
        // Tone and four sigmas of the noise reach the rail. Speckle is above twice its root mean square in one moment of fifty.
        let amplitude = 2047.0 / (1.0 + 4.0 * Signal::tone(0.0, 1.0, snr_db).sigma());
        let amplitude = if self.spot_m.is_some() { 0.5 * amplitude } else { amplitude };
        let mut blocks = Vec::new();
        for (row, trial) in self.rows.iter().zip(0..) {
            let scene = row.scene(&self.sensor, N, (amplitude, snr_db), self.spot_m);
            let mut run = Scene { seed, ..scene }.run(trial).map_err(said)?;
            blocks.extend((0..self.sensor.segments()).map(|index| record::<R>(&mut run, index, N)));
        }
        Ok(blocks)
    }

    /// The records of each seed that the options name.
    pub fn all_blocks<R: Record>(
        &self,
        options: &Options,
    ) -> Result<Vec<Vec<R::Sample>>, DemoError> {
        let seeds = options.seed..options.seed.wrapping_add(options.seeds);
        let blocks = seeds.map(|seed| self.blocks::<R>(options.snr_db(), seed));
        Ok(blocks.collect::<Result<Vec<_>, _>>()?.concat())
    }

    /// The answers of the firmware on the emulated MPS2.
    fn on_mps2<R: Kind>(&self, options: &Options) -> Result<Vec<Measurement>, DemoError> {
        let blocks = self.all_blocks::<R>(options)?.into_iter().map(Ok);
        let mut measurements = Vec::new();
        play::<R>("frontend_qemu", (self.config, N), blocks, options, |_, said| {
            if let Said::Telemetry(record) = said {
                measurements.push(record.measurement);
            }
        })?;
        Ok(measurements)
    }

    /// What a board measures of the lidar's rows, once for each seed.
    fn on_board(&self, options: &Options) -> Result<Vec<Measurement>, DemoError> {
        match options.board {
            // A NUCLEO was refused before: it is for other scenes.
            Board::Mps2 | Board::Nucleo => self.on_mps2::<Real>(options),
            Board::Pico => {
                let measurement = |record: Telemetry| record.measurement;
                Ok(pico::lidar(self, options)?.into_iter().map(measurement).collect())
            }
        }
    }

    /// What the firmware's pipeline measures of the lidar's rows on this machine, from the same samples, once for each seed.
    pub fn on_host(
        &self,
        snr_db: f64,
        seed: u64,
        seeds: u64,
    ) -> Result<Vec<Measurement>, DemoError> {
        let plan = self.config.plan::<Real, N>().map_err(said)?;
        let segments = self.config.scene.segments();
        let of_seed = |index: u64| {
            let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
            let blocks = self.blocks::<Real>(snr_db, seed.wrapping_add(index))?;
            let first = index as u32 * blocks.len() as u32;
            let measured = (first..).zip(blocks).filter_map(|(sequence, samples)| {
                let segment = segments[sequence as usize % segments.len()];
                let stamp = Stamp { sequence, segment, ..Stamp::default() };
                Some(pipeline.block(&stamp, samples.as_array()?))
            });
            Ok(measured.collect::<Vec<_>>())
        };
        let all: Result<Vec<_>, _> = (0..seeds).into_par_iter().map(of_seed).collect();
        Ok(all?.concat())
    }

    /// The numbers of the rows, from 1 on, that two runs do not answer with the same bits.
    fn different(&self, one: &[Measurement], other: &[Measurement]) -> Vec<usize> {
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
    pub fn summary(&self, measurements: &[Measurement], seeds: u64) -> Summary {
        let truths = (0..seeds).flat_map(|_| self.rows.iter());
        let mut results: Vec<Measured> =
            truths.map(|&truth| Measured { truth, shape: None, answer: None }).collect();
        for measurement in measurements {
            let answer = match &measurement.result {
                Outcome::Target(target) => target.into(),
                Outcome::Velocity(velocity) => Answer {
                    range_m: self.rows.first().map_or(0.0, |row| row.range_m),
                    velocity_mps: velocity.velocity.to_num(),
                    sigma_range_m: 0.0,
                    sigma_velocity_mps: velocity.sigma.into(),
                    verdict: velocity.verdict,
                },
                _ => continue,
            };
            let row = measurement.stamp.sequence as usize / self.sensor.segments();
            if let Some(result) = results.get_mut(row) {
                result.answer = Some(answer);
            }
        }
        let (method, bent) = (self.method.name().into(), self.bent.clone());
        Summary { results, method, mixing: None, bent, look: self.look }
    }
}

/// The lidar's rows, once for each seed.
pub fn lidar(options: &Options) -> Result<Summary, DemoError> {
    let task = Task::lidar(options.method, options.laser())?;
    Ok(task.summary(&task.on_board(options)?, options.seeds))
}

/// Targets in front of the 24 GHz radar, by both shapes.
pub fn radar(options: &Options) -> Result<Summary, DemoError> {
    let [mut both, trapezoid] = before_radar::SHAPES.map(|shape| {
        let config = (before_radar::config(shape, options.mixing()), options.method);
        let task = Task::new::<Iq>(config, before_radar::rows(), RADAR)?;
        let mut summary = task.summary(&task.on_mps2::<Iq>(options)?, 1);
        summary.results.iter_mut().for_each(|row| row.shape = Some(shape));
        Ok(Summary { mixing: Some(options.mixing()), ..summary })
    });
    if let (Ok(both), Ok(trapezoid)) = (&mut both, &trapezoid) {
        both.results.extend(&trapezoid.results);
    }
    trapezoid.and(both)
}

/// The turntable's speeds.
pub fn turntable(options: &Options) -> Result<Summary, DemoError> {
    let config = (scenario::turntable(), options.method);
    let task = Task::new::<Iq>(config, scenario::turntable_rows(), TURNTABLE)?;
    let bent = options.spot_mm.map(|spot_mm| format!("rough rim below a spot of {spot_mm} mm"));
    let task = Task { bent, spot_m: options.spot_m(), ..task };
    Ok(task.summary(&task.on_mps2::<Iq>(options)?, 1))
}

/// The lidar's rows as the library measures them on this machine, at once, and then as the emulated board does: both have the same bits.
pub(super) fn here_and_there(options: &Options) -> Result<ExitCode, DemoError> {
    let task = Task::lidar(options.method, options.laser())?;
    let here = task.on_host(options.snr_db(), options.seed, options.seeds)?;
    let people = !options.json;
    if people {
        let shown = task.summary(&here, options.seeds).shown(options)?;
        outln!("{}\n\n{}\n\n{}", shown.heading, shown.table, shown.text);
        outln!(
            "by the library on this machine; now the firmware measures the same samples on an emulated Cortex-M33"
        );
    }
    let there = task.on_board(options)?;
    let board = task.summary(&there, options.seeds).shown(options)?;
    let (different, rows) = (task.different(&here, &there), task.rows.len());
    board.draw(options)?;
    if !people {
        board.lines.iter().for_each(|line| outln!("{line}"));
    } else if different.is_empty() {
        outln!("the board: all {rows} rows the same, bit for bit");
    } else {
        out!("{}\n\n{}", board.table, board.text);
    }
    if !different.is_empty() {
        let which: Vec<String> = different.iter().map(usize::to_string).collect();
        let (count, which) = (which.len(), which.join(", "));
        eprintln!("error: the board's bits differ in {count} of {rows} rows: {which}");
    }
    Ok(code(different.is_empty() && board.right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_or_a_lost_record_is_a_row_that_differs() {
        let lidar = Task::lidar(None, Laser::default()).unwrap();
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

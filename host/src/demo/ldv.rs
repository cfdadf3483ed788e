//! Particles in a turbulent flow: each one's speed by the burst processor, and the flow's mean and rms.

use super::answer::lines;
use super::measure::N;
use super::nucleo::Nucleo;
use super::options::{Board, Options};
use super::{DemoError, said, shown};
use crate::analyze::bursts::Weighted;
use crate::device::Said;
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::progress;
use crate::scenario::flow::{self, FRINGES, Flow, MEAN_MPS, PARTICLES, TURBULENCE};
use picket_dsp::acquire::burst::{Counters, Trigger};
use picket_dsp::{Burst, BurstProcessor, Real, Validation};
use picket_simulator::Particle;
use picket_wire::settings::Mode;
use serde::Serialize;
use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;

/// How far mean and rms may be from the flow's, shares of them.
const MEAN_BAR: f64 = 0.003;
const RMS_BAR: f64 = 0.03;

/// One burst. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Row {
    /// When it is in the middle.
    pub time_s: f64,
    /// The speed of the particle that is nearest then, if one is within the beam's radius.
    pub truth_mps: Option<f64>,
    /// The speed.
    pub velocity_mps: f64,
    /// One standard deviation.
    pub sigma_mps: f64,
    /// The time between the points at which its power is down by `exp(-2)`.
    pub transit_s: f64,
    /// Whether it is one particle's.
    pub validation: &'static str,
}

/// The flow as a whole.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Particles that crossed.
    pub particles: usize,
    /// Bursts that were measured.
    pub bursts: usize,
    /// Valid ones.
    pub valid: u64,
    /// Bursts that came while the record of another was not complete.
    pub lost: u32,
    /// The share of the time in which no burst could begin.
    pub dead_share: f64,
    /// The flow's mean velocity, its rms about it, and what was measured: each burst weighs as much as its transit took.
    pub truth_mean_mps: f64,
    /// See above.
    pub mean_mps: f64,
    /// See above.
    pub truth_rms_mps: f64,
    /// See above.
    pub rms_mps: f64,
    /// The mean with equal weights, which counts fast particles too often.
    pub alike_mean_mps: f64,
    /// Root mean square of error over sigma of the valid bursts that are within 5 sigma of their particle's speed.
    pub sigmas: f64,
    /// The others that have a particle.
    pub beyond: u64,
}

impl Summary {
    fn of(rows: &[Row], particles: usize) -> Self {
        let (mut flow, mut alike) = (Weighted::default(), Weighted::default());
        let (mut squares, mut within, mut beyond) = (0.0, 0u64, 0);
        for row in rows.iter().filter(|row| row.is_valid()) {
            flow.add(row.transit_s, row.velocity_mps, row.sigma_mps);
            alike.add(1.0, row.velocity_mps, row.sigma_mps);
            let Some(truth) = row.truth_mps else { continue };
            let error = (row.velocity_mps - truth) / row.sigma_mps;
            if error.abs() > 5.0 {
                beyond += 1;
            } else {
                within += 1;
                squares += error * error;
            }
        }
        Summary {
            summary: true,
            particles,
            bursts: rows.len(),
            valid: flow.count,
            truth_mean_mps: MEAN_MPS,
            mean_mps: flow.mean().unwrap_or(f64::NAN),
            truth_rms_mps: TURBULENCE * MEAN_MPS,
            rms_mps: flow.rms().unwrap_or(f64::NAN),
            alike_mean_mps: alike.mean().unwrap_or(f64::NAN),
            sigmas: (squares / within.max(1) as f64).sqrt(),
            beyond,
            ..Summary::default()
        }
    }

    /// How far mean and rms are from the flow's, shares of them.
    pub fn errors(&self) -> [f64; 2] {
        [self.mean_mps / self.truth_mean_mps - 1.0, self.rms_mps / self.truth_rms_mps - 1.0]
    }

    /// Whether mean and rms are the flow's.
    pub fn inside(&self) -> bool {
        let [mean, rms] = self.errors();
        mean.abs() < MEAN_BAR && rms.abs() < RMS_BAR
    }
}

impl Row {
    fn is_valid(&self) -> bool {
        self.validation == Validation::Valid.name()
    }

    fn of(burst: &Burst, particles: &[Particle]) -> Self {
        let rate_hz = flow::config().rate_hz;
        let time_s = burst.arrival / rate_hz;
        let away = |particle: &&Particle| (particle.middle_s - time_s).abs();
        // They come one after the other.
        let next = particles.partition_point(|particle| particle.middle_s < time_s);
        let near = particles.iter().take(next + 1).skip(next.saturating_sub(1));
        let near = near.min_by(|a, b| away(a).total_cmp(&away(b)));
        let near = near.filter(|near| away(near) < FRINGES.radius_m / near.speed_mps);
        Row {
            time_s,
            truth_mps: near.map(|particle| particle.speed_mps),
            velocity_mps: burst.tone.hertz() * FRINGES.spacing_m,
            sigma_mps: burst.tone.sigma_hertz() * FRINGES.spacing_m,
            transit_s: burst.transit() / rate_hz,
            validation: burst.validation.name(),
        }
    }
}

/// What measures the bursts.
enum By {
    Core(Box<BurstProcessor<Real, N>>),
    Board(Box<Nucleo>, Counters),
}

impl By {
    fn new(board: Board) -> Result<Self, DemoError> {
        if board == Board::Nucleo {
            let mode = Mode::Bursts(Trigger::default());
            let board = Nucleo::start(flow::config(), false, mode)?;
            return Ok(By::Board(Box::new(board), Counters::default()));
        }
        let plan = flow::config().plan::<Real, N>().map_err(said)?;
        Ok(By::Core(Box::new(BurstProcessor::new(plan))))
    }

    /// Takes codes, whole blocks of them.
    fn push(&mut self, codes: &[i16], mut each: impl FnMut(&Burst)) -> Result<(), DemoError> {
        match self {
            By::Core(processor) => processor.push(codes, each),
            By::Board(board, counters) => {
                for block in codes.chunks(N) {
                    for said in board.block(block)? {
                        if let Said::Burst(mut told) = said {
                            // What was slowed down for the board.
                            told.burst.tone.rate_hz = flow::config().rate_hz;
                            *counters = told.counters;
                            each(&told.burst);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn counters(&self) -> &Counters {
        match self {
            By::Core(processor) => processor.counters(),
            By::Board(_, counters) => counters,
        }
    }
}

/// Measures every burst of a flow, by the core here or by the emulated board.
pub fn measured(seed: u64, snr_db: f64, board: Board) -> Result<(Vec<Row>, Summary), DemoError> {
    let mut processor = By::new(board)?;
    let mut flow = Flow::new(seed, snr_db);
    let bar = progress::bar(PARTICLES as u64, "particles");
    let mut rows = Vec::new();
    // The last burst is complete a record after its particle.
    let mut after = 0;
    while after < 2 {
        after += usize::from(flow.is_over());
        let codes = flow.codes(64 * N);
        bar.set_position(flow.particles.len() as u64);
        processor.push(&codes, |burst| rows.push(Row::of(burst, &flow.particles)))?;
    }
    bar.finish_and_clear();
    let counters = processor.counters();
    let dead_share = counters.dead as f64 / counters.samples as f64;
    let summary = Summary::of(&rows, flow.particles.len());
    Ok((rows, Summary { lost: counters.lost, dead_share, ..summary }))
}

/// Measures, prints and draws. Failure: mean or rms are not the flow's.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let (rows, summary) = measured(options.seed, options.snr_db(), options.board)?;
    let draw = |file: &Path| draw(&rows, &summary, file, options.output);
    let print = || print(&rows, &summary, options);
    shown(options, draw, || lines(&rows, &summary), print, summary.inside())
}

fn print(rows: &[Row], summary: &Summary, options: &Options) {
    outln!(
        "Particles in a flow of {MEAN_MPS} m/s with {:.0} % turbulence, in fringes of 4 um: 12 bits at 10 MS/s, N = {N}, {} dB at the \
         top of a usual burst, seed {}\n",
        100.0 * TURBULENCE,
        options.snr_db(),
        options.seed
    );
    outln!(
        "{:>9} {:>9} {:>13} {:>7} {:>10}  validation",
        "time ms",
        "true m/s",
        "measured m/s",
        "+-",
        "transit us"
    );
    for row in rows.iter().take(25) {
        let truth = row.truth_mps.map_or("-".into(), |truth| format!("{truth:.4}"));
        outln!(
            "{:>9.3} {truth:>9} {:>13.4} {:>7.4} {:>10.2}  {}",
            1e3 * row.time_s,
            row.velocity_mps,
            row.sigma_mps,
            1e6 * row.transit_s,
            row.validation
        );
    }
    let [mean, rms] = summary.errors().map(|error| 100.0 * error);
    let alike = 100.0 * (summary.alike_mean_mps / summary.truth_mean_mps - 1.0);
    outln!(
        "\n{} of {} bursts valid, of {} particles; {} lost, dead for {:.1} %\n  \
         mean  {:.4} m/s, {mean:+.2} % off (true: {} m/s; all bursts alike: {alike:+.2} %)\n  \
         rms   {:.4} m/s, {rms:+.1} % off (true: {:.1} m/s)\n  \
         error over sigma of a burst {:.2} (rms), {} beyond 5",
        summary.valid,
        summary.bursts,
        summary.particles,
        summary.lost,
        100.0 * summary.dead_share,
        summary.mean_mps,
        summary.truth_mean_mps,
        summary.rms_mps,
        summary.truth_rms_mps,
        summary.sigmas,
        summary.beyond
    );
}

/// The histogram of the velocities, weighted with the transit times and not, and the flow's distribution.
fn draw(rows: &[Row], summary: &Summary, file: &Path, output: Output) -> Result<(), DemoError> {
    const BINS: usize = 48;
    let rms = summary.truth_rms_mps;
    // Four deviations to each side.
    let (low, high) = (MEAN_MPS - 4.0 * rms, MEAN_MPS + 4.0 * rms);
    let width = (high - low) / BINS as f64;
    let density = |weight: fn(&Row) -> f64| {
        let (mut sums, mut total) = ([0.0; BINS], 0.0);
        for row in rows.iter().filter(|row| row.is_valid()) {
            total += weight(row);
            let bin = (row.velocity_mps - low) / width;
            if let Some(sum) = (bin >= 0.0).then(|| sums.get_mut(bin as usize)).flatten() {
                *sum += weight(row);
            }
        }
        let middle = move |bin: usize| low + (bin as f64 + 0.5) * width;
        sums.into_iter().enumerate().map(move |(bin, sum)| (middle(bin), sum / total / width))
    };
    let truth = (0..=200).map(|i| {
        let x = -4.0 + f64::from(i) / 25.0;
        (MEAN_MPS + x * rms, (-0.5 * x * x).exp() / (rms * TAU.sqrt()))
    });
    let chart = Chart {
        name: "ldv",
        title: format!(
            "{} bursts of a flow with {:.0} % turbulence: mean {:.3} m/s, rms {:.3} m/s",
            summary.valid,
            100.0 * TURBULENCE,
            summary.mean_mps,
            summary.rms_mps
        ),
        x: Axis::linear("velocity, m/s", low, high),
        y: Axis::linear("density, s/m", 0.0, 1.2 / (rms * TAU.sqrt())),
        series: vec![
            Series::new("by transit time", Style::Marked, 0, density(|row| row.transit_s)),
            Series::new("all bursts alike", Style::Points, 6, density(|_| 1.0)),
            Series::new("the flow", Style::Line, 1, truth),
        ],
    };
    chart.save(file, output).map_err(said)
}

//! Particles in a turbulent flow: each one's speed by the burst processor, and the flow's mean and rms.

use super::feed::N;
use super::nucleo::Nucleo;
use super::options::{Board, Options};
use super::shown::{Shown, keys, lines, rms, table};
use super::{DemoError, said};
use crate::analyze::bursts::Weighted;
use crate::device::Said;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::progress;
use crate::scenario::flow::{self, FRINGE_M, MEAN_MPS, RADIUS_M, TURBULENCE};
use picket_dsp::acquire::burst::{Counters, Trigger};
use picket_dsp::{Burst, BurstProcessor, Real, Validation};
use picket_simulator::Passed;
use picket_wire::settings::Mode;
use serde::Serialize;
use std::f64::consts::TAU;

/// How far mean and rms may be from the flow's, shares of them.
const MEAN_BAR: f64 = 0.003;
const RMS_BAR: f64 = 0.03;

/// Blocks that are taken at once: few enough that memory is used again, and not given back to the system.
const BLOCKS: usize = 4;

/// One burst. The keys are those of the JSON lines.
#[derive(Serialize)]
struct Row {
    /// When it is in the middle.
    time_s: f64,
    /// The speed of the particle that is nearest then, if one is within the beam's radius.
    truth_mps: Option<f64>,
    velocity_mps: f64,
    sigma_mps: f64,
    /// The time between the points at which its power is down by `exp(-2)`.
    transit_s: f64,
    /// Whether it is one particle's.
    validation: &'static str,
}

impl Row {
    fn is_valid(&self) -> bool {
        self.validation == Validation::Valid.name()
    }

    fn of(burst: &Burst, particles: &[Passed]) -> Self {
        let rate_hz = flow::config().rate_hz;
        let time_s = burst.arrival / rate_hz;
        let away = |particle: &&Passed| (particle.middle_s - time_s).abs();
        // They come one after the other.
        let next = particles.partition_point(|particle| particle.middle_s < time_s);
        let near = particles.iter().take(next + 1).skip(next.saturating_sub(1));
        let near = near.min_by(|a, b| away(a).total_cmp(&away(b)));
        let near = near.filter(|near| away(near) < RADIUS_M / near.velocity_mps);
        Row {
            time_s,
            truth_mps: near.map(|particle| particle.velocity_mps),
            velocity_mps: burst.tone.hertz() * FRINGE_M,
            sigma_mps: burst.tone.sigma_hertz() * FRINGE_M,
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

/// Right: mean and rms are the flow's.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let mut processor = By::new(options.board)?;
    let scene = flow::scene(options.seed, options.snr_db());
    let mut run = scene.run(0).map_err(said)?;
    let (end_s, piece_s) = (scene.seconds, (BLOCKS * N) as f64 / scene.rate_hz);
    let passed: Vec<Passed> = run.particles(0).to_vec();
    let particles = passed.iter().filter(|one| (0.0..end_s).contains(&one.middle_s)).count();
    let pieces = (end_s / piece_s) as usize;
    let bar = progress::bar(pieces as u64, "pieces");
    let mut rows = Vec::new();
    for piece in 0..pieces {
        let codes = run.codes(piece as f64 * piece_s, BLOCKS * N);
        let codes: Vec<i16> = codes.into_iter().map(|[code, _]| code).collect();
        processor.push(&codes, |burst| rows.push(Row::of(burst, &passed)))?;
        bar.inc(1);
    }
    bar.finish_and_clear();

    let (mut flow, mut alike) = (Weighted::default(), Weighted::default());
    let valid_rows = || rows.iter().filter(|row| row.is_valid());
    for row in valid_rows() {
        flow.add(row.transit_s, row.velocity_mps, row.sigma_mps);
        alike.add(1.0, row.velocity_mps, row.sigma_mps);
    }
    let errors =
        || valid_rows().filter_map(|row| Some((row.velocity_mps - row.truth_mps?) / row.sigma_mps));
    let sigmas = rms(errors().filter(|error| error.abs() <= 5.0));
    let beyond = errors().filter(|error| error.abs() > 5.0).count();
    let (bursts, valid, lost) = (rows.len(), flow.count, processor.counters().lost);
    let dead_share = processor.counters().dead as f64 / processor.counters().samples as f64;
    let (truth_mean_mps, truth_rms_mps) = (MEAN_MPS, TURBULENCE * MEAN_MPS);
    let [mean_mps, rms_mps, alike_mean_mps] =
        [flow.mean(), flow.rms(), alike.mean()].map(|value| value.unwrap_or(f64::NAN));
    let all = keys! {
        summary: true, particles, bursts, valid, lost, dead_share, truth_mean_mps, mean_mps, truth_rms_mps, rms_mps,
        alike_mean_mps, sigmas, beyond,
    };
    let [mean, rms, alike] =
        [mean_mps / truth_mean_mps, rms_mps / truth_rms_mps, alike_mean_mps / truth_mean_mps]
            .map(|ratio| 100.0 * (ratio - 1.0));
    let text = format!(
        "{valid} of {bursts} bursts valid, of {particles} particles; {lost} lost, dead for {:.1} %\n  \
         mean  {mean_mps:.4} m/s, {mean:+.2} % off (true: {truth_mean_mps} m/s; all bursts alike: {alike:+.2} %)\n  \
         rms   {rms_mps:.4} m/s, {rms:+.1} % off (true: {truth_rms_mps:.1} m/s)\n  \
         error over sigma of a burst {sigmas:.2} (rms), {beyond} beyond 5\n",
        100.0 * dead_share
    );
    let table = table(
        rows.iter().take(25),
        "time ms: 1e3 time_s .3 | true m/s: truth_mps .4 | measured m/s: velocity_mps .4 | +-: sigma_mps .4 | transit us: 1e6 transit_s .2 | \
         validation: validation",
        |_| false,
    );
    let title = format!(
        "{valid} bursts of a flow with {:.0} % turbulence: mean {mean_mps:.3} m/s, rms {rms_mps:.3} m/s",
        100.0 * TURBULENCE
    );
    Ok(Shown {
        heading: format!(
            "Particles in a flow of {MEAN_MPS} m/s with {:.0} % turbulence, in fringes of 4 um: 12 bits at 10 MS/s, N = {N}, {} dB at the \
             top of a usual burst, seed {}",
            100.0 * TURBULENCE,
            options.snr_db(),
            options.seed
        ),
        table,
        text,
        lines: lines(&rows, &all)?,
        charts: vec![chart(&rows, title)],
        right: mean.abs() < 100.0 * MEAN_BAR && rms.abs() < 100.0 * RMS_BAR,
    })
}

/// The histogram of the velocities, weighted with the transit times and not, and the flow's distribution.
fn chart(rows: &[Row], title: String) -> Chart {
    const BINS: usize = 48;
    let rms = TURBULENCE * MEAN_MPS;
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
    Chart {
        name: "ldv",
        title,
        x: Axis::linear("velocity, m/s", low, high),
        y: Axis::linear("density, s/m", 0.0, 1.2 / (rms * TAU.sqrt())),
        series: vec![
            Series::new("by transit time", Style::Marked, 0, density(|row| row.transit_s)),
            Series::new("all bursts alike", Style::Points, 6, density(|_| 1.0)),
            Series::new("the flow", Style::Line, 1, truth),
        ],
    }
}

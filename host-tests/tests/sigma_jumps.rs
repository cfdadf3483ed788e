//! The sigma of a steady tone beside hum or a second tone, from block to block: it is even, or `picket explain` names what widened it.

use picket_claims::samples;
use picket_claims::scenes::{Kind, deviation, line, tones};
use picket_dsp::{Codes, Config, Iq, Pipeline, Real, Record, Stamp};
use picket_host::explain::rows::{Notes, Row, rows};
use picket_simulator::{Draw, Scene};
use rayon::prelude::*;

const N: usize = 1024;
const BLOCKS: u64 = 100;
const SEED: u64 = 50;
/// Where the tone is, in cycles a block: near the hum, and farther and farther from it.
const TONES: [f64; 3] = [30.3, 137.5, 300.1];
const AMPLITUDE: f64 = 400.0;

/// What is beside the tone, at a level over the tone's in dB.
#[derive(Clone, Copy, Debug)]
enum Beside {
    /// Of so many cycles a block.
    Hum(f64, f64),
    /// So many bins away.
    Tone(f64, f64),
}

/// The blocks of a tone, with another phase of both in each: their sigmas, and the tests behind their verdicts.
fn blocks<R: Record>(bins: f64, beside: Beside, snr_db: f64) -> Vec<(f32, Vec<Row>)> {
    let (place, level_db) = match beside {
        Beside::Hum(cycles, level_db) => (cycles, level_db),
        Beside::Tone(away, level_db) => (bins + away, level_db),
    };
    let other = line(place, AMPLITUDE * 10f64.powf(level_db / 20.0));
    let noise = deviation(AMPLITUDE, snr_db);
    let scene = tones(Kind::of::<R>(), N, [line(bins, AMPLITUDE), other], noise);
    // The tone is what is searched for, whatever the hum's level.
    let config =
        Config { band_hz: Some((12.0, 500.0)), ..Config::new(N as f64, Codes::signed::<12>()) };
    let plan = config.plan().unwrap();
    let block = |trial: u64| {
        let scene = Scene { seed: Draw::new(SEED, trial).bits(), ..scene.clone() };
        let samples = samples::<R, N>(&mut scene.run(0).unwrap(), 0);
        let notes = Notes::default();
        let mut pipeline = Pipeline::<R, N>::new(plan);
        let (_, tone, evidence) = pipeline.explain(&Stamp::default(), &samples, &notes);
        (tone.sigma, rows(&notes.taken().0, &evidence, N))
    };
    (0..BLOCKS).into_par_iter().map(block).collect()
}

/// Twice the sigma of noise alone is four times its variance: of a line that is called steady the test of that name tells at least half of it.
const TOLD: f64 = 2.0;

/// What the tests name as the cause of a wide sigma: a line that is no steady tone, by the tests that fired, or one with more variance than
/// noise alone, by the first looks that exceeded their limits. Nothing where no line is judged so.
fn causes(rows: &[Row]) -> Vec<&'static str> {
    let judged = |row: &&Row| row.test == "line" && (row.fired || row.value >= Some(TOLD));
    if !rows.iter().any(|row| judged(&row)) {
        return Vec::new();
    }
    let looks = ["changes", "within-2", "within-4", "within-all"];
    let exceeds = |row: &&Row| row.fired || looks.contains(&row.test) && row.value > row.limit;
    rows.iter().filter(exceeds).map(|row| row.test).collect()
}

/// The share of the blocks whose sigma is above twice the median, and how many of these no test explains.
fn wide<R: Record>(bins: f64, beside: Beside, snr_db: f64) -> (f64, usize) {
    let blocks = blocks::<R>(bins, beside, snr_db);
    let mut sigmas: Vec<f32> = blocks.iter().map(|(sigma, _)| *sigma).collect();
    sigmas.sort_by(f32::total_cmp);
    let median = sigmas[sigmas.len() / 2];
    let wide: Vec<&[Row]> = blocks
        .iter()
        .filter(|(sigma, _)| *sigma > 2.0 * median)
        .map(|(_, rows)| rows.as_slice())
        .collect();
    let unexplained = wide.iter().filter(|rows| causes(rows).is_empty()).count();
    let share = wide.len() as f64 / BLOCKS as f64;
    if share > 0.05 {
        let mut tests: Vec<&str> = wide.iter().flat_map(|rows| causes(rows)).collect();
        tests.sort_unstable();
        tests.dedup();
        println!(
            "{}, tone at {bins}, {beside:?}, {snr_db} dB: {:.0} % wide, by {}",
            Kind::of::<R>().name(),
            100.0 * share,
            tests.join(" ")
        );
    }
    (share, unexplained)
}

#[test]
fn sigma_is_even_or_what_widens_it_is_named() {
    println!("seed {SEED}");
    let hum = [1.5, 2.0, 2.5, 3.0]
        .map(|cycles| [-10.0, 0.0, 10.0].map(|level_db| Beside::Hum(cycles, level_db)));
    let tones = [3.0, 5.0, 8.0, 12.0, 20.0, 40.0].map(|away| {
        [-40.0, -30.0, -20.0, -10.0, -6.0].map(|level_db| Beside::Tone(away, level_db))
    });
    for (name, besides, most) in [("hum", hum.concat(), 73), ("a second tone", tones.concat(), 180)]
    {
        let (mut cells, mut uneven, mut worst) = (0, 0, 0.0f64);
        for beside in besides {
            for snr_db in [10.0, 20.0, 30.0, 40.0] {
                for bins in TONES {
                    for (share, unexplained) in
                        [wide::<Real>(bins, beside, snr_db), wide::<Iq>(bins, beside, snr_db)]
                    {
                        assert_eq!(unexplained, 0, "{bins} {beside:?} {snr_db} dB");
                        cells += 1;
                        uneven += usize::from(share > 0.05);
                        worst = worst.max(share);
                    }
                }
            }
        }
        println!(
            "beside {name}: in {uneven} of {cells} cells more than 5 % of the blocks have a sigma above twice the median, at most {:.0} %",
            100.0 * worst
        );
        // As many as there are: one more is a change for the worse.
        assert!(uneven <= most, "{name}: {uneven} of {cells}");
    }
}

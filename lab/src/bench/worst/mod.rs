//! The worst block: an evolutionary search over signals for the record whose measurement takes the most instructions.
//!
//! No corpus has the worst block in it. The search starts from random [signals](signal::Signal) and keeps those that take the most, with and
//! without samples at a rail: their children take their places. The emulator counts exactly, so a search finds the same from the same seed.

pub mod signal;

use super::{Core, Figures, How, config, model, run};
use crate::emulator::RunError;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_wire::capture::Header;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use signal::Signal;
use std::path::Path;

/// The seed of a search.
pub const SEED: u64 = 40;
/// Signals of a generation.
const SIGNALS: usize = 64;
/// Parents, of those with and of those without samples at a rail.
const PARENTS: usize = 8;
/// One of this many children has no parents.
const STRANGERS: u32 = 8;

/// A signal, and what the measurement of its record took.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// The instructions.
    pub instructions: u64,
    /// The modelled cycles, of the worst of all; `None` for the others, and for a core whose timing is not published.
    pub cycles: Option<u64>,
    /// The signal.
    pub signal: Signal,
}

/// Searches for this many generations. Returns the worst without a sample at a rail, and with.
///
/// # Errors
/// The emulator failed.
pub fn search<R: Record>(
    core: &Core,
    image: &Path,
    n: usize,
    how: How,
    seed: u64,
    generations: usize,
) -> Result<[Option<Worst>; 2], RunError> {
    let count = |records: &[Vec<R::Sample>]| measurements::<R>(core, image, n, how, records);
    let mut worst = breed::<R, _>(n, how.codes, seed, generations, count)?;
    for Worst { cycles, signal, .. } in worst.iter_mut().flatten() {
        *cycles = model::measurement::<R>(core, image, n, how, &signal.record::<R>(n, how.codes))?;
    }
    Ok(worst)
}

/// Breeds signals for this many generations from those whose records of `n` samples of these codes take the most; `count` says what each record takes.
///
/// # Errors
/// The errors of `count`.
pub fn breed<R: Record, E>(
    n: usize,
    codes: Codes,
    seed: u64,
    generations: usize,
    mut count: impl FnMut(&[Vec<R::Sample>]) -> Result<Vec<u64>, E>,
) -> Result<[Option<Worst>; 2], E> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut signals: Vec<Signal> = (0..SIGNALS).map(|_| Signal::random(&mut rng)).collect();
    let mut parents: [Vec<Worst>; 2] = Default::default();
    for _ in 0..generations {
        let records: Vec<_> = signals.iter().map(|signal| signal.record::<R>(n, codes)).collect();
        let counts = count(&records)?;
        for ((signal, record), instructions) in signals.drain(..).zip(&records).zip(counts) {
            let (low, high) = codes.rails();
            let clipped = R::pairs(record).iter().flatten().any(|x| [low, high].contains(x));
            let worst = Worst { instructions, cycles: None, signal };
            parents[usize::from(clipped)].push(worst);
        }
        for kind in &mut parents {
            kind.sort_by_key(|worst| std::cmp::Reverse(worst.instructions));
            kind.truncate(PARENTS);
        }
        // Both kinds have as many children, whichever takes more.
        signals.extend((0..SIGNALS).map(|index| {
            let kind = &parents[index % 2];
            if kind.is_empty() || rng.random_ratio(1, STRANGERS) {
                return Signal::random(&mut rng);
            }
            let [one, other] = [(); 2].map(|()| rng.random_range(0..kind.len()));
            Signal::child(&mut rng, &kind[one].signal, &kind[other].signal)
        }));
    }
    Ok(parents.map(|kind| kind.into_iter().next()))
}

/// The instructions of the measurement of each record.
fn measurements<R: Record>(
    core: &Core,
    image: &Path,
    n: usize,
    how: How,
    records: &[Vec<R::Sample>],
) -> Result<Vec<u64>, RunError> {
    let header = Header::from_config::<R>(config(core, how), n as u32, records.len() as u32);
    let header = Header { period_us: 0, ..header };
    let (figures, _): (Figures, _) = run::<R>(core, image, &header, records, |_| {})?;
    let ticks = figures.get("measurement").filter(|ticks| ticks.len() == records.len());
    let ticks = ticks.ok_or_else(|| RunError::Emulator("it counted not every record".into()))?;
    let rate = core.machine.instructions_per_tick();
    Ok(ticks.iter().map(|&ticks| (ticks as f64 * rate).round() as u64).collect())
}

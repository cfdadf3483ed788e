//! The worst block: an evolutionary search over signals for the record whose measurement takes the most instructions.
//!
//! No corpus has the worst block in it. The search starts from random [signals](signal::Signal) and keeps those that take the most, with and
//! without samples at a rail: their children take their places. The emulator counts exactly, so a search finds the same from the same seed.

pub mod signal;

use super::{Core, Figures, config, run};
use crate::emulator::RunError;
use picket::acquire::codes::Codes;
use picket::acquire::sample::Real;
use picket::tone::fit::Reach;
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
/// One of so many children has no parents.
const STRANGERS: u32 = 8;

/// A signal, and what the measurement of its record took.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// The instructions.
    pub instructions: u64,
    /// The signal.
    pub signal: Signal,
}

/// Searches for so many generations. Returns the worst without a sample at a rail, and with.
///
/// # Errors
/// The emulator failed.
pub fn search(
    core: &Core,
    image: &Path,
    n: usize,
    seed: u64,
    generations: usize,
) -> Result<[Option<Worst>; 2], RunError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut signals: Vec<Signal> = (0..SIGNALS).map(|_| Signal::random(&mut rng)).collect();
    let mut parents: [Vec<Worst>; 2] = Default::default();
    for _ in 0..generations {
        let records: Vec<_> = signals.iter().map(|signal| signal.record(n)).collect();
        let counts = measurements(core, image, n, &records)?;
        for ((signal, record), instructions) in signals.drain(..).zip(&records).zip(counts) {
            let (low, high) = Codes::signed::<12>().rails();
            let clipped = record.iter().any(|x| [low, high].contains(x));
            parents[usize::from(clipped)].push(Worst { instructions, signal });
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
fn measurements(
    core: &Core,
    image: &Path,
    n: usize,
    records: &[Vec<i16>],
) -> Result<Vec<u64>, RunError> {
    let header = Header::of::<Real>(config(core, Reach::default()), n as u32, records.len() as u32);
    let header = Header { period_us: 0, ..header };
    let (figures, _): (Figures, _) = run::<Real>(core, image, &header, records, |_| {})?;
    let ticks = figures.get("measurement").filter(|ticks| ticks.len() == records.len());
    let ticks = ticks.ok_or_else(|| RunError::Emulator("it counted not every record".into()))?;
    let rate = core.machine.instructions_per_tick();
    Ok(ticks.iter().map(|&ticks| (ticks as f64 * rate).round() as u64).collect())
}

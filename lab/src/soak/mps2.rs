//! The emulated board with DMA (AN505, Cortex-M33): thousands of blocks at a pace at which the core loses some. Every record is
//! right to the bit, and every block is either there or counted.

use super::tally::{Fault, Tally};
use super::{same, samples};
use crate::device::{Listener, Said};
use crate::emulator::{Capture, Machine, RunError};
use crate::toolchain::{Firmware, Profile};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_wire::capture::Header;
use picket_wire::telemetry::{Health, Telemetry};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Duration;

const N: usize = 64;
const BOARD: Machine = Machine::An505;
/// Blocks in a life.
const BLOCKS: u32 = 20_000;
const LIMIT: Duration = Duration::from_secs(600);

/// Lives life `number` of this seed.
///
/// # Errors
/// The emulator does not run, or what came out is not what must; in a sentence.
pub fn live(seed: u64, number: u64) -> Result<Tally, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    if rng.random() { from_kind::<Iq>(rng) } else { from_kind::<Real>(rng) }
}

fn from_kind<R: Record>(mut rng: ChaCha8Rng) -> Result<Tally, String> {
    let told = |error: RunError| error.to_string();
    let config = Config::new(1e6, Codes::signed::<12>());
    // Some instructions more or less than a block takes; or as long as it wants.
    let period_us = if rng.random_bool(0.2) { 0 } else { rng.random_range(1500..5000) };
    let header = Header { period_us, ..Header::from_config::<R>(config, N as u32, BLOCKS) };
    let mut capture = Capture::create(&header).map_err(told)?;
    let mut played = Vec::new();
    for _ in 0..BLOCKS {
        let samples = samples::<R, N>(&mut rng, false)?;
        capture.push::<R>(&samples).map_err(told)?;
        played.push(samples);
    }
    static IMAGE: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let image = IMAGE.get_or_init(built).as_ref()?;
    let plan = config.plan::<R, N>().map_err(|error| error.to_string())?;
    let mut expected = Expected {
        pipeline: Pipeline::new(plan),
        header,
        played,
        follows: 0,
        tally: Tally { lives: 1, ..Tally::default() },
    };
    let (mut listener, mut wrong) = (Listener::default(), None);
    let outcome = capture.run(BOARD, image, LIMIT, |piece| {
        for said in listener.read(piece) {
            if let (Said::Telemetry(theirs), None) = (said, &wrong) {
                wrong = expected.record(&theirs).err();
            }
        }
    });
    let outcome = outcome.map_err(told)?;
    if let Some(wrong) = wrong {
        return Err(wrong);
    }
    let Expected { mut tally, .. } = expected;
    tally.lost = u64::from(BLOCKS) - tally.blocks;
    same("damaged frames", listener.bad, 0)?;
    same("the blocks delivered", outcome.figure("blocks"), Some(tally.blocks))?;
    same("the blocks lost", outcome.figure("lost"), Some(tally.lost))?;
    same("the blocks that found no slot", outcome.figure("overruns"), Some(tally.lost))?;
    same("other faults", outcome.figure("faults"), Some(0))?;
    tally.faults[Fault::Stall as usize] = tally.lost;
    Ok(tally)
}

fn built() -> Result<PathBuf, String> {
    let (target, profile) = (BOARD.target(), Profile::Release);
    let image = Firmware { bin: "frontend_qemu", target, features: &["mps2"], profile };
    image.build().map_err(|error| error.to_string())
}

/// What the board must send.
struct Expected<R: Record> {
    pipeline: Pipeline<R, N>,
    header: Header,
    played: Vec<[R::Sample; N]>,
    /// The number of the block that would follow without a gap.
    follows: u32,
    tally: Tally,
}

impl<R: Record> Expected<R> {
    fn record(&mut self, theirs: &Telemetry) -> Result<(), String> {
        let number = theirs.measurement.stamp.sequence;
        let samples = self.played.get(number as usize).filter(|_| number >= self.follows);
        let samples = samples.ok_or_else(|| format!("block {number} after {}", self.follows))?;
        let stamp = self.header.timing().stamp(number.into(), number > self.follows);
        let measurement = self.pipeline.block(&stamp, samples);
        let lost = number - self.tally.blocks as u32;
        let method = self.pipeline.plan().options.method;
        let ours = Telemetry {
            measurement,
            method,
            health: Health { lost, faults: 0 },
            basis: None,
            uncertainty: None,
        };
        if theirs.to_bytes() != ours.to_bytes() {
            return Err(format!("block {number}: {theirs:?}, not {ours:?}"));
        }
        self.follows = number + 1;
        self.tally.blocks += 1;
        Ok(())
    }
}

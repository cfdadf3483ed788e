//! Kernels against their definition: both run on the emulated core, on blocks that it draws itself.

use super::{Core, run};
use crate::emulator::RunError;
use crate::progress;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::Config;
use picket_wire::capture::Header;
use std::fmt;
use std::path::Path;

/// The seed of the random blocks.
pub const SEED: u32 = 20_220_222;
/// The image sends a byte after this many blocks.
const STEP: u64 = 256;

/// How many blocks were compared, and how many of them differed: by all engines of the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Equality {
    /// Blocks, by engine.
    pub compared: Vec<u64>,
    /// Blocks that differ.
    pub unequal: u64,
    /// The number of the first that differs.
    pub first: Option<u64>,
    /// Interrupts of kernels by kernels, where the image makes such; those that differ count above.
    pub interrupts: Option<u64>,
}

/// Drives kernels and definition with `blocks` random records of `n` samples, with a bar on a terminal.
pub fn compare<R: Record>(
    core: &Core,
    image: &Path,
    n: usize,
    blocks: u32,
    seed: u32,
) -> Result<Equality, RunError> {
    let config = Config::new(1.0, Codes::signed::<12>());
    let header =
        Header { period_us: blocks, stride: seed, ..Header::from_config::<R>(config, n as u32, 0) };
    let bar = progress::bar(blocks.into(), "blocks");
    let run = run::<R>(core, image, &header, &[], |bytes| {
        // An image with two engines drives one after the other.
        let done = bar.position() + STEP * bytes.len() as u64;
        bar.set_length(bar.length().unwrap_or(0).max(done));
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let (mut figures, _) = run?;
    let mut each = |name| figures.remove(name).unwrap_or_default();
    Ok(Equality {
        compared: each("compared"),
        unequal: each("unequal").iter().sum(),
        first: each("first_unequal").first().copied(),
        interrupts: each("interrupts").first().copied(),
    })
}

impl Equality {
    /// Whether each engine compared this many blocks, and none differed.
    pub fn holds(&self, blocks: u32) -> bool {
        let enough = self.compared.iter().all(|&compared| compared >= u64::from(blocks));
        enough && !self.compared.is_empty() && self.unequal == 0
    }
}

impl fmt::Display for Equality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} blocks, {} differ", self.compared, self.unequal)?;
        self.interrupts.map_or(Ok(()), |count| write!(f, ", {count} interrupts"))?;
        self.first.map_or(Ok(()), |first| write!(f, ", the first of them number {first}"))
    }
}

//! Instructions of frames of chirps, of ranges by phase, of the whole error and of a clock beside another.

use super::{Core, LIMIT};
use crate::emulator::{Capture, RunError};
use crate::toolchain::{Firmware, Profile, ToolError};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::Config;
use picket_wire::capture::Header;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The image.
pub fn image(core: &Core) -> Result<PathBuf, ToolError> {
    let (target, profile) = (core.target, Profile::Release);
    Firmware { bin: "bench_frames", target, features: &["mps2"], profile }.build()
}

/// Counts on a core: the most of each stage.
pub fn count(core: &Core, image: &Path) -> Result<BTreeMap<String, u64>, RunError> {
    // The image makes its own samples.
    let config = Config::new(1.0, Codes::signed::<12>());
    let capture = Capture::create(&Header::from_config::<Real>(config, 64, 0))?;
    let outcome = capture.run(core.machine, image, LIMIT, |_| ())?;
    let per_tick = core.machine.instructions_per_tick();
    let most = |ticks: &Vec<u64>| ticks.iter().max().copied().unwrap_or_default() as f64;
    let counted = outcome.figures();
    Ok(counted
        .iter()
        .map(|(stage, ticks)| (stage.clone(), (most(ticks) * per_tick) as u64))
        .collect())
}

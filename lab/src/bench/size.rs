//! The program memory of the smallest programs.

use super::Core;
use crate::emulator::{Footprint, RunError};
use crate::toolchain::{Firmware, Profile};

/// Bytes of program memory, code, tables and start-up, of an image that measures real records of 1,024 samples at default features, and
/// does nothing else. The image `frequency_only` answers without a verdict, `single` with one.
pub fn program_memory(core: &Core, bin: &'static str, profile: Profile) -> Result<u64, RunError> {
    let image = Firmware { bin, target: core.target, features: &["cores"], profile };
    Ok(Footprint::from_elf(&image.build()?)?.flash)
}

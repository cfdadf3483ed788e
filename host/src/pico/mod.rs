//! The Raspberry Pi Pico: its image, and the board on rp2040js.

pub mod bench;
pub mod converter;
pub mod flash;

use crate::emulator::RunError;
use crate::flash::binary_at;
use crate::toolchain::{Firmware, Profile, Target, ToolError};
use std::path::{Path, PathBuf};

/// The image's name.
pub const IMAGE: &str = "frontend_pico";

/// Where its flash is read.
pub const FLASH: u32 = 0x1000_0000;

/// The image without USB, which the linker proves free of reachable panics; else it is the board's.
pub fn image() -> Result<PathBuf, ToolError> {
    of_feature("pico")
}

/// The board's image, with a serial port at its pins and one over USB.
pub fn usb_image() -> Result<PathBuf, ToolError> {
    of_feature("usb")
}

fn of_feature(feature: &str) -> Result<PathBuf, ToolError> {
    let (target, profile) = (Target::M0, Profile::Release);
    Firmware { bin: IMAGE, target, features: &[feature], profile }.build()
}

/// The image as it lies in flash.
pub fn binary(elf: &Path) -> Result<Vec<u8>, RunError> {
    binary_at(elf, FLASH)
}

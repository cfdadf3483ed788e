//! `picket flash`: the image on its way to the board; here the NUCLEO's.

use crate::board;
use crate::emulator::{Footprint, RunError};
use crate::pico;
use crate::toolchain::{ToolError, firmware_dir, io_error, on_path};
use clap::{Args, ValueEnum};
use crc::{CRC_32_ISO_HDLC, Crc};
use object::read::elf::{ElfFile32, ProgramHeader};
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// A board that has an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// The NUCLEO-F446RE, by probe-rs
    Nucleo,
    /// The Raspberry Pi Pico, by its drive
    Pico,
}

/// Builds the board's image and writes it to the board.
#[derive(Args, Debug)]
pub struct Options {
    /// The board
    #[arg(long, value_enum, default_value_t = Board::Nucleo)]
    board: Board,
    /// The image that also follows tones from block to block: see `follow` in docs/board.md
    #[arg(long)]
    tracking: bool,
    /// Stops before the board
    #[arg(long)]
    dry_run: bool,
}

/// Builds the image, shows its size and writes it.
pub fn run(options: &Options) -> Result<ExitCode, FlashError> {
    if options.board == Board::Pico {
        return to_pico(options);
    }
    let image = build(options.tracking)?;
    outln!("{image}");
    if !options.dry_run {
        write(&image)?;
        outln!("written: picket watch lists the ports");
    }
    Ok(ExitCode::SUCCESS)
}

fn to_pico(options: &Options) -> Result<ExitCode, FlashError> {
    if options.tracking {
        return Err(FlashError::NoTracking);
    }
    let image = pico::flash::build()?;
    outln!("{image}");
    if !options.dry_run {
        let drive = pico::flash::write(&image)?;
        outln!("copied to {}: picket watch lists the ports", drive.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// Flash and RAM that the image may take. Sixteen slots for blocks take 70 KB of the RAM, which nothing else needs.
pub const BUDGET: Footprint = Footprint { flash: 112 << 10, ram: 100 << 10 };

/// What the image that follows tones may take: the chip has 256 KB of flash for it, and 128 KB of RAM.
pub const TRACKING: Footprint = Footprint { flash: 136 << 10, ram: 112 << 10 };

const CHIP: &str = "STM32F446RETx";
const START: u32 = 0x0800_0000;

/// Why the image is not on the board.
#[derive(Debug)]
#[non_exhaustive]
pub enum FlashError {
    /// It was not built, or its files cannot be read or written.
    Image(RunError),
    /// probe-rs is missing.
    Missing(PathBuf),
    /// probe-rs found no board, or failed.
    Probe(String),
    /// No drive of a Pico is mounted.
    NoDrive(PathBuf),
    /// The Pico has no image that follows tones.
    NoTracking,
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FlashError::Image(error) => error.fmt(f),
            FlashError::Missing(binary) => write!(
                f,
                "probe-rs is missing: type `cargo install probe-rs-tools --locked`, or copy {} to the drive that the board shows",
                binary.display()
            ),
            FlashError::NoDrive(file) => write!(
                f,
                "no drive RPI-RP2 is mounted: hold BOOTSEL while you plug the Pico in, then try again or copy {} to its drive",
                file.display()
            ),
            FlashError::NoTracking => {
                write!(f, "the Pico has no image that follows tones: leave --tracking out")
            }
            FlashError::Probe(text) => {
                write!(f, "{text}: is the board plugged in by its USB socket?")
            }
        }
    }
}

impl std::error::Error for FlashError {}

impl From<ToolError> for FlashError {
    fn from(error: ToolError) -> Self {
        FlashError::Image(error.into())
    }
}

impl From<RunError> for FlashError {
    fn from(error: RunError) -> Self {
        FlashError::Image(error)
    }
}

/// An image that was built.
#[derive(Debug)]
pub struct Image {
    /// With symbols.
    pub elf: PathBuf,
    /// As it lies in flash.
    pub binary: PathBuf,
    /// What it takes.
    pub footprint: Footprint,
    /// What it may take.
    pub budget: Footprint,
    /// The checksum that the board reports of itself.
    pub program: u32,
}

impl fmt::Display for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Footprint { flash, ram } = self.footprint;
        let Footprint { flash: most_flash, ram: most_ram } = self.budget;
        write!(
            f,
            "program {:08x}: flash {flash} of {most_flash} B, RAM {ram} of {most_ram} B without the stack\n{}",
            self.program,
            self.binary.display()
        )
    }
}

/// Builds the image, or the one that follows tones.
pub fn build(tracking: bool) -> Result<Image, FlashError> {
    let elf = board::image(false, tracking)?;
    let bytes = binary(&elf)?;
    let binary = firmware_dir().join("picket-nucleo.bin");
    std::fs::write(&binary, &bytes).map_err(io_error(binary.display()))?;
    let budget = if tracking { TRACKING } else { BUDGET };
    Ok(Image { footprint: Footprint::of(&elf)?, budget, program: checksum(&elf)?, elf, binary })
}

/// The checksum that the board reports of itself: CRC-32 of the parts of its image one after the other, without what lies between
/// them.
pub fn checksum(elf: &Path) -> Result<u32, RunError> {
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    parts(elf, START)?.iter().for_each(|(_, bytes)| digest.update(bytes));
    Ok(digest.finalize())
}

/// The image as it lies in flash, from its start on; erased flash between its parts.
pub fn binary(elf: &Path) -> Result<Vec<u8>, RunError> {
    binary_at(elf, START)
}

/// The same for flash that starts elsewhere.
pub(crate) fn binary_at(elf: &Path, start: u32) -> Result<Vec<u8>, RunError> {
    let mut binary = Vec::new();
    for (place, bytes) in parts(elf, start)? {
        binary.resize(binary.len().max(place + bytes.len()), 0xFF);
        binary[place..place + bytes.len()].copy_from_slice(&bytes);
    }
    Ok(binary)
}

/// The parts of an image with their places in flash.
fn parts(elf: &Path, start: u32) -> Result<Vec<(usize, Vec<u8>)>, RunError> {
    let wrong = |error: &dyn fmt::Display| -> RunError {
        io_error(elf.display())(std::io::Error::other(error.to_string())).into()
    };
    let data = std::fs::read(elf).map_err(io_error(elf.display()))?;
    let file = ElfFile32::<object::Endianness>::parse(&*data).map_err(|error| wrong(&error))?;
    let endian = file.endian();
    let mut parts = Vec::new();
    for segment in file.elf_program_headers() {
        let bytes = segment.data(endian, &*data).map_err(|()| wrong(&"a segment is cut off"))?;
        if segment.p_type(endian) != object::elf::PT_LOAD || bytes.is_empty() {
            continue;
        }
        let place = segment.p_paddr(endian).checked_sub(start);
        let place = place.ok_or_else(|| wrong(&"the image is not for this board's flash"))?;
        parts.push((place as usize, bytes.to_vec()));
    }
    Ok(parts)
}

/// Writes the image by probe-rs and starts it.
pub fn write(image: &Image) -> Result<(), FlashError> {
    let Some(probe) = on_path("probe-rs") else {
        return Err(FlashError::Missing(image.binary.clone()));
    };
    for arguments in [&["download", "--verify"][..], &["reset"]] {
        let mut command = Command::new(&probe);
        command.args(arguments).args(["--chip", CHIP]).stdin(Stdio::null());
        if arguments.len() > 1 {
            command.arg(&image.elf);
        }
        let output = command.output().map_err(io_error(probe.display()))?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            let line = text.lines().find(|line| !line.trim().is_empty()).unwrap_or("it failed");
            return Err(FlashError::Probe(format!("probe-rs: {}", line.trim())));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_told_in_a_line_that_says_what_to_do() {
        let missing = FlashError::Missing("picket.bin".into()).to_string();
        assert!(missing.contains("type `cargo install probe-rs-tools --locked`"), "{missing}");
        assert!(missing.contains("copy picket.bin"), "{missing}");
        let absent = FlashError::Probe("probe-rs: no probe was found".into()).to_string();
        assert!(absent.contains("plugged in"), "{absent}");
        assert!(!missing.contains('\n') && !absent.contains('\n'));
    }
}

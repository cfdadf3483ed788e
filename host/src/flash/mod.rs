//! `picket flash`: the image on its way to the board; here the NUCLEO's.

pub mod drive;
mod pack;

use crate::board;
use crate::emulator::{Footprint, RunError};
use crate::output::Output;
use crate::pico;
use crate::rates;
use crate::toolchain::{Need, Target, ToolError, firmware_dir, have, io_error, on_path};
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
    /// The image that also sets the chip's brown-out level, once, by its option bytes: see docs/board.md
    #[arg(long)]
    brown_out: bool,
    /// Stops before the board
    #[arg(long)]
    dry_run: bool,
    /// Builds every image of both boards into a folder, with a page on how to flash them without this tool
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["board", "brown_out", "dry_run"])]
    pack: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// The images for the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Measures as the settings say.
    Usual,
    /// As the usual one, and sets the brown-out level.
    BrownOut,
}

/// Builds the image, shows its size and writes it.
pub fn run(options: &Options) -> Result<ExitCode, FlashError> {
    if let Some(folder) = &options.pack {
        have(&[Need::Core(Target::M4f), Need::Core(Target::M0)])?;
        outln!("{}", pack::pack(folder, options.output)?.trim_end());
        return Ok(ExitCode::SUCCESS);
    }
    if options.board == Board::Pico {
        return to_pico(options);
    }
    let kind = if options.brown_out { Kind::BrownOut } else { Kind::Usual };
    have(&[Need::Core(Target::M4f)])?;
    let image = build(kind)?;
    outln!("{image}");
    rates::nucleo().iter().for_each(|rates| outln!("{rates}"));
    if !options.dry_run {
        if let Some(drive) = write(&image)? {
            outln!("copied to {}", drive.display());
        }
        match kind {
            Kind::BrownOut => {
                outln!(
                    "written: its start sets the chip's brown-out level to 2.7 V, unless that is set; leave the board its power for some seconds"
                );
            }
            _ => outln!("written: picket watch lists the ports"),
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn to_pico(options: &Options) -> Result<ExitCode, FlashError> {
    if options.brown_out {
        return Err(FlashError::NoSuchImage);
    }
    have(&[Need::Core(Target::M0)])?;
    let image = pico::flash::build()?;
    outln!("{image}");
    rates::pico().iter().for_each(|rates| outln!("{rates}"));
    if !options.dry_run {
        let drive = pico::flash::write(&image)?;
        outln!("copied to {}: picket watch lists the ports", drive.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// Flash and RAM that the image may take without its stack. The program follows the settings' sectors, from 48 KB on. Twelve slots for blocks take 52 KB of the RAM.
pub const BUDGET: Footprint = Footprint { flash: 464 << 10, ram: 104 << 10 };

const CHIP: &str = "STM32F446RETx";
const START: u32 = 0x0800_0000;

/// Why the image is not on the board.
#[derive(Debug)]
#[non_exhaustive]
pub enum FlashError {
    /// It was not built, or its files cannot be read or written.
    Image(RunError),
    /// probe-rs is missing, and no drive of a NUCLEO is mounted.
    Missing(PathBuf),
    /// probe-rs found no board, or failed.
    Probe(String),
    /// No drive of a Pico is mounted.
    NoDrive(PathBuf),
    /// The NUCLEO's drive took the file and says what failed.
    Drive(String),
    /// The folder of all images.
    Folder(String),
    /// The Pico has no brown-out level to set.
    NoSuchImage,
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FlashError::Image(error) => error.fmt(f),
            FlashError::Missing(binary) => write!(
                f,
                "neither probe-rs nor the board's drive is there: plug the board in and mount its drive NODE_F446RE, then try again or copy {} to it; or type `cargo install probe-rs-tools --locked`",
                binary.display()
            ),
            FlashError::Drive(said) => {
                write!(
                    f,
                    "the board's programmer: {said}: press the board's black button and try again, or update the programmer by ST's STSW-LINK007"
                )
            }
            FlashError::Folder(said) => f.write_str(said),
            FlashError::NoDrive(file) => write!(
                f,
                "no drive RPI-RP2 is mounted: hold BOOTSEL while you plug the Pico in, then try again or copy {} to its drive",
                file.display()
            ),
            FlashError::NoSuchImage => {
                write!(f, "this board has no such image: --brown-out is the NUCLEO's")
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

/// Builds one of the images.
pub fn build(kind: Kind) -> Result<Image, FlashError> {
    let elf = match kind {
        Kind::Usual => board::image(false, false)?,
        Kind::BrownOut => board::image(false, true)?,
    };
    let bytes = binary(&elf)?;
    let name = match kind {
        Kind::BrownOut => "picket-brown-out.bin",
        _ => "picket-nucleo.bin",
    };
    let binary = firmware_dir().join(name);
    std::fs::write(&binary, &bytes).map_err(io_error(binary.display()))?;
    Ok(Image {
        footprint: Footprint::from_elf(&elf)?,
        budget: BUDGET,
        program: checksum(&elf)?,
        elf,
        binary,
    })
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

/// The image as it lies in flash that starts at `start`.
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

/// Writes the image by probe-rs and starts it; without probe-rs by the board's drive, which it returns.
pub fn write(image: &Image) -> Result<Option<PathBuf>, FlashError> {
    let Some(probe) = on_path("probe-rs") else {
        let drive = drive::find(Board::Nucleo);
        let drive = drive.ok_or_else(|| FlashError::Missing(image.binary.clone()))?;
        drive::copy(Board::Nucleo, &image.binary, &drive)?;
        return Ok(Some(drive));
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
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_told_in_a_line_that_says_what_to_do() {
        let missing = FlashError::Missing("picket.bin".into()).to_string();
        assert!(missing.contains("type `cargo install probe-rs-tools --locked`"), "{missing}");
        assert!(missing.contains("copy picket.bin") && missing.contains("drive"), "{missing}");
        let absent = FlashError::Probe("probe-rs: no probe was found".into()).to_string();
        assert!(absent.contains("plugged in"), "{absent}");
        assert!(!missing.contains('\n') && !absent.contains('\n'));
    }
}

//! `picket flash`: the image on its way to the board; here the NUCLEO's.

pub mod drive;
mod pack;

use crate::board;
use crate::cli::print_line;
use crate::emulator::{Footprint, RunError};
use crate::end;
use crate::output::Output;
use crate::pico;
use crate::rates;
use crate::toolchain::{Need, Target, ToolError, firmware_dir, have, io_error, on_path};
use crate::watch::WatchError;
use crate::watch::port::{Piece, Source};
use clap::{Args, ValueEnum};
use crc::{CRC_32_ISO_HDLC, Crc};
use object::read::elf::{ElfFile32, ProgramHeader};
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

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
    /// Writes the self-test: it works through the list of docs/board.md, with one wire from A2 to A0
    #[arg(long)]
    self_test: bool,
    /// Writes an image that also sets the chip's brown-out level in its option bytes, once: see docs/board.md
    #[arg(long, conflicts_with = "self_test")]
    brown_out: bool,
    /// Writes nothing: restarts the self-test on the board, and prints its list
    #[arg(long, value_name = "PORT", requires = "self_test", conflicts_with = "dry_run")]
    listen: Option<String>,
    /// With --listen: watches each rate for a moment instead of ten seconds
    #[arg(long, requires = "listen")]
    quick: bool,
    /// Builds and shows the size, but writes nothing to the board
    #[arg(long)]
    dry_run: bool,
    /// Builds every image of both boards into a folder, with a page on how to flash them without this tool
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["board", "self_test", "brown_out", "dry_run"])]
    pack: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// The images for the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Measures as the settings say.
    Usual,
    /// Goes through the board's list.
    SelfTest,
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
    let kind = match options {
        Options { self_test: true, .. } => Kind::SelfTest,
        Options { brown_out: true, .. } => Kind::BrownOut,
        _ => Kind::Usual,
    };
    have(&[Need::Core(Target::M4f)])?;
    let image = build(kind)?;
    if let Some(port) = &options.listen {
        return listen(port, options.quick, image.program);
    }
    outln!("{image}");
    // The self-test runs at the rates of its list.
    if kind != Kind::SelfTest {
        rates::nucleo().iter().for_each(|rates| outln!("{rates}"));
    }
    if !options.dry_run {
        if let Some(drive) = write(&image)? {
            outln!("copied to {}", drive.display());
        }
        match kind {
            Kind::SelfTest => {
                outln!("written: wire A2 to A0, then picket flash --self-test --listen PORT")
            }
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
    if options.self_test || options.brown_out {
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

/// Flash and RAM that the image may take without its stack. Twelve slots for blocks take 52 KB of the RAM.
pub const BUDGET: Footprint = Footprint { flash: 384 << 10, ram: 104 << 10 };

/// What the self-test may take: its code lies in RAM as well, and its DAC's table of 10 KB.
pub const SELF_TEST: Footprint = Footprint { flash: 148 << 10, ram: 60 << 10 };

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
    /// The Pico has neither a self-test nor a brown-out level to set.
    NoSuchImage,
    /// The board's port.
    Port(WatchError),
    /// The self-test says nothing more.
    Silent,
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
                write!(f, "the board's programmer: {said}: press the board's black button and try again, or update the programmer by ST's STSW-LINK007")
            }
            FlashError::Folder(said) => f.write_str(said),
            FlashError::NoDrive(file) => write!(
                f,
                "no drive RPI-RP2 is mounted: hold BOOTSEL while you plug the Pico in, then try again or copy {} to its drive",
                file.display()
            ),
            FlashError::NoSuchImage => {
                write!(
                    f,
                    "this board has no such image: --brown-out and --self-test are the NUCLEO's"
                )
            }
            FlashError::Port(error) => error.fmt(f),
            FlashError::Silent => f.write_str(
                "the board says nothing more: is the self-test on it (picket flash --self-test), and is it the board's port?",
            ),
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

impl From<WatchError> for FlashError {
    fn from(error: WatchError) -> Self {
        FlashError::Port(error)
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
        Kind::SelfTest => board::self_test()?,
    };
    let bytes = binary(&elf)?;
    let name = match kind {
        Kind::SelfTest => "picket-self-test.bin",
        Kind::BrownOut => "picket-brown-out.bin",
        _ => "picket-nucleo.bin",
    };
    let binary = firmware_dir().join(name);
    std::fs::write(&binary, &bytes).map_err(io_error(binary.display()))?;
    let budget = if kind == Kind::SelfTest { SELF_TEST } else { BUDGET };
    Ok(Image {
        footprint: Footprint::from_elf(&elf)?,
        budget,
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

/// The longest silence of a self-test, which starves its watchdog: eight seconds, and a rate's ten.
const PATIENCE: Duration = Duration::from_secs(25);

/// Begins the self-test on the board again and prints its list. The exit code is 1 if an item does not hold.
fn listen(port: &str, quick: bool, program: u32) -> Result<ExitCode, FlashError> {
    let mut source = Source::open(Some(port), None)?;
    let mut list = List::new(program);
    let mut heard = Instant::now();
    let (mut asked, mut text) = (None, Vec::new());
    while end::asked().is_none() {
        match source.piece()? {
            // What waited in the port belongs to an older list.
            Piece::Opened => {
                source.send(b"\n");
                asked = Some(Instant::now());
            }
            Piece::End => break,
            Piece::Bytes(bytes) => {
                if !bytes.is_empty() {
                    heard = Instant::now();
                }
                text.extend(bytes);
            }
        }
        while let Some(length) = text.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = text.drain(..=length).collect();
            let line = String::from_utf8_lossy(&line);
            if list.line(line.trim()) && quick {
                source.send(b"q");
            }
        }
        if let Some(held) = list.held {
            return Ok(if held { ExitCode::SUCCESS } else { ExitCode::from(1) });
        }
        // An item that is under way begins nothing again: asked again, the next one does.
        if !list.begun
            && asked.is_some_and(|asked: Instant| asked.elapsed() > Duration::from_secs(3))
        {
            source.send(b"\n");
            asked = Some(Instant::now());
        }
        if heard.elapsed() > PATIENCE {
            return Err(FlashError::Silent);
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The list as it comes.
#[derive(Debug)]
struct List {
    /// The checksum of the image that was built.
    program: u32,
    begun: bool,
    wrong: bool,
    /// Whether every item held, at the end.
    held: Option<bool>,
}

impl List {
    const fn new(program: u32) -> Self {
        Self { program, begun: false, wrong: false, held: None }
    }

    /// Prints a line from the list's beginning on. True at the beginning.
    fn line(&mut self, line: &str) -> bool {
        let head = line.starts_with("picket self-test");
        self.begun |= head;
        if !self.begun || line.is_empty() {
            return false;
        }
        print_line(line);
        if head {
            let same = line.contains(&format!("program {:08x}", self.program));
            self.wrong = !same;
            print_line(if same {
                "- [x] the program is the one that was built here"
            } else {
                "- [ ] WRONG: the program is not the one that is built here"
            });
        }
        self.wrong |= line.contains("WRONG");
        if line.starts_with("result:") {
            self.held = Some(!self.wrong);
        }
        head
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_told_in_a_line_that_says_what_to_do() {
        let missing = FlashError::Missing("picket.bin".into()).to_string();
        assert!(missing.contains("type `cargo install probe-rs-tools --locked`"), "{missing}");
        assert!(missing.contains("copy picket.bin") && missing.contains("drive"), "{missing}");
        let silent = FlashError::Silent.to_string();
        assert!(silent.contains("--self-test") && !silent.contains('\n'));
        let absent = FlashError::Probe("probe-rs: no probe was found".into()).to_string();
        assert!(absent.contains("plugged in"), "{absent}");
        assert!(!missing.contains('\n') && !absent.contains('\n'));
    }

    #[test]
    fn a_list_holds_if_each_item_does() {
        let head = "picket self-test 0.1.0 on nucleo-f446re, program 0000abcd, started by power";
        for (program, item, held) in [
            (0xABCD, "- [x] clock", true),
            (0xABCD, "- [ ] WRONG: clock", false),
            (0xABCE, "- [x] clock", false),
        ] {
            let mut list = List::new(program);
            assert!(!list.line("result: 0 of 1 hold") && list.held.is_none());
            assert!(list.line(head));
            assert!(!list.line(item) && !list.line("result: 1 of 1 hold"));
            assert_eq!(list.held, Some(held));
        }
    }
}

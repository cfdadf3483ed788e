//! Runs a firmware image on an emulated board, with a capture as its converter's input.

use crate::end::{self, Owned};
use crate::toolchain::{self, ToolError, io_error};
use picket_dsp::acquire::sample::Record;
use picket_wire::capture::Header;
use std::collections::HashMap;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A board that QEMU emulates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Machine {
    /// MPS2 AN385, Cortex-M3.
    An385,
    /// MPS2 AN386, Cortex-M4F.
    An386,
    /// MPS2 AN500, Cortex-M7.
    An500,
    /// MPS2 AN505, Cortex-M33; has DMA.
    An505,
    /// MPS3 AN547, Cortex-M55.
    An547,
}

impl Machine {
    /// QEMU's name.
    pub const fn name(self) -> &'static str {
        match self {
            Machine::An385 => "mps2-an385",
            Machine::An386 => "mps2-an386",
            Machine::An500 => "mps2-an500",
            Machine::An505 => "mps2-an505",
            Machine::An547 => "mps3-an547",
        }
    }

    /// The core it has.
    pub const fn target(self) -> toolchain::Target {
        match self {
            Machine::An385 => toolchain::Target::M3,
            Machine::An386 | Machine::An500 => toolchain::Target::M4f,
            Machine::An505 => toolchain::Target::M33,
            Machine::An547 => toolchain::Target::M55,
        }
    }

    /// Instructions in one tick of its timers under the instruction clock of 64 ns each.
    pub const fn instructions_per_tick(self) -> f64 {
        match self {
            Machine::An385 | Machine::An386 | Machine::An500 => 40.0 / 64.0,
            Machine::An505 => 50.0 / 64.0,
            // The image counts 256ths of a tick at 32 MHz.
            Machine::An547 => 31.25 / 64.0 / 256.0,
        }
    }

    /// Instructions in one tick of the core's own timer, SysTick.
    pub const fn instructions_per_core_tick(self) -> f64 {
        match self {
            Machine::An547 => 256.0 * self.instructions_per_tick(),
            _ => self.instructions_per_tick(),
        }
    }
}

/// Emulated time by instructions, 64 ns each, skipped while the core sleeps: a run is the same every
/// time, however busy the host.
const ICOUNT: &str = "shift=6,align=off,sleep=off";

/// What the emulated board did.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The image's exit code; 0 is success.
    pub code: i32,
    /// What it wrote to its second serial port: an error, or figures as `name=value` lines.
    pub messages: String,
    /// What it wrote to the file of results.
    pub results: Vec<u8>,
    /// What it logged, as defmt frames.
    pub log: Vec<u8>,
}

impl Outcome {
    /// The figure of this name.
    pub fn figure(&self, name: &str) -> Option<u64> {
        self.messages
            .lines()
            .find_map(|line| line.strip_prefix(name)?.strip_prefix('=')?.parse().ok())
    }

    /// Every figure, by name, in the order it came.
    pub fn figures(&self) -> HashMap<String, Vec<u64>> {
        let mut figures = HashMap::<_, Vec<_>>::new();
        for line in self.messages.lines() {
            if let Some((name, value)) = line.split_once('=')
                && let Ok(value) = value.parse()
            {
                figures.entry(name.into()).or_default().push(value);
            }
        }
        figures
    }
}

/// Why an emulation did not come to its end.
#[derive(Debug)]
#[non_exhaustive]
pub enum RunError {
    /// A tool is missing, or a file.
    Tool(ToolError),
    /// It took longer than allowed and was stopped.
    Timeout(Duration),
    /// QEMU did not start the image or broke down.
    Emulator(String),
    /// The image stopped with an error.
    Image {
        /// Its exit code.
        code: i32,
        /// Its words.
        message: String,
    },
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RunError::Tool(error) => error.fmt(f),
            RunError::Timeout(limit) => {
                write!(f, "the emulated board was stopped after {} s", limit.as_secs())
            }
            RunError::Emulator(text) => write!(f, "qemu-system-arm: {text}"),
            RunError::Image { code, message } if message.is_empty() => {
                write!(f, "the firmware stopped with code {code}")
            }
            RunError::Image { message, .. } => write!(f, "the firmware says: {message}"),
        }
    }
}

impl std::error::Error for RunError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            RunError::Tool(error) => Some(error),
            _ => None,
        }
    }
}

impl From<ToolError> for RunError {
    fn from(error: ToolError) -> Self {
        RunError::Tool(error)
    }
}

/// A capture under construction, in a directory of its own that is removed with it.
#[derive(Debug)]
pub struct Capture {
    directory: TempDir,
    file: BufWriter<File>,
}

impl Capture {
    /// An empty capture with this header.
    pub fn create(header: &Header) -> Result<Self, RunError> {
        let directory = tempfile::Builder::new()
            .prefix("picket-")
            .tempdir()
            .map_err(io_error("the temporary directory"))?;
        end::takes_along(directory.path());
        let path = directory.path().join("capture.bin");
        let mut file = BufWriter::new(File::create(&path).map_err(io_error(path.display()))?);
        file.write_all(&header.to_bytes()).map_err(io_error(path.display()))?;
        Ok(Self { directory, file })
    }

    /// Appends a block of samples.
    pub fn push<R: Record>(&mut self, samples: &[R::Sample]) -> Result<(), RunError> {
        let used = if R::IQ { 2 } else { 1 };
        for &sample in samples {
            for part in R::parts(sample).into_iter().take(used) {
                self.file.write_all(&part.to_le_bytes()).map_err(io_error("the capture"))?;
            }
        }
        Ok(())
    }

    /// Runs `image` on `machine` with this capture. Telemetry is given to `telemetry` as it comes, in
    /// pieces of any size. The emulator is stopped after `limit`.
    pub fn run(
        mut self,
        machine: Machine,
        image: &Path,
        limit: Duration,
        telemetry: impl FnMut(&[u8]),
    ) -> Result<Outcome, RunError> {
        self.file.flush().map_err(io_error("the capture"))?;
        run(machine, image, self.directory.path(), limit, Told::Telemetry, telemetry)
    }

    /// Likewise. What the emulator executes is given to `trace`, line by line.
    pub fn trace(
        mut self,
        machine: Machine,
        image: &Path,
        limit: Duration,
        mut trace: impl FnMut(&str),
    ) -> Result<Outcome, RunError> {
        self.file.flush().map_err(io_error("the capture"))?;
        let mut line = Vec::new();
        run(machine, image, self.directory.path(), limit, Told::Trace, |piece| {
            for part in piece.split_inclusive(|&byte| byte == b'\n') {
                line.extend_from_slice(part);
                if line.ends_with(b"\n") {
                    trace(String::from_utf8_lossy(&line).trim_end());
                    line.clear();
                }
            }
        })
    }
}

/// What is given to the caller as it comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    /// What the image sends by its first serial port.
    Telemetry,
    /// What the emulator logs: each piece of the program as it is translated, and each that is executed.
    Trace,
}

fn run(
    machine: Machine,
    image: &Path,
    directory: &Path,
    limit: Duration,
    told: Told,
    mut tell: impl FnMut(&[u8]),
) -> Result<Outcome, RunError> {
    let image = fs::canonicalize(image).map_err(io_error(image.display()))?;
    let mut command = Command::new(toolchain::qemu()?);
    command.current_dir(directory);
    command.args(["-machine", machine.name(), "-icount", ICOUNT, "-kernel"]).arg(image);
    command.args(["-nodefaults", "-nographic", "-net", "none"]);
    command.args(["-chardev", "stdio,id=telemetry,signal=off", "-serial", "chardev:telemetry"]);
    command.args(["-serial", "file:messages"]);
    command.args(["-chardev", "file,id=log,path=log"]);
    command.args(["-semihosting-config", "enable=on,target=native,chardev=log"]);
    command.stdin(Stdio::null());
    if told == Told::Trace {
        // It logs beside its errors.
        command.args(["-d", "in_asm,exec,nochain"]).stdout(Stdio::null()).stderr(Stdio::piped());
    } else {
        let errors = directory.join("errors");
        command.stdout(Stdio::piped());
        command.stderr(File::create(&errors).map_err(io_error(errors.display()))?);
    }
    let board = Owned::start(command).map_err(io_error("qemu-system-arm"))?;
    let end = Instant::now() + limit;
    let pieces = match told {
        Told::Telemetry => reader(board.stdout()),
        Told::Trace => reader(board.stderr()),
    };
    loop {
        match pieces.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(piece) => tell(&piece),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => return Err(RunError::Timeout(limit)),
        }
    }
    let status = ended(&board, end).ok_or(RunError::Timeout(limit))?;
    let read = |name: &str| fs::read(directory.join(name)).unwrap_or_default();
    let text = |name: &str| String::from_utf8_lossy(&read(name)).trim().to_owned();
    match status.code() {
        Some(0) => Ok(Outcome {
            code: 0,
            messages: text("messages"),
            results: read("results.bin"),
            log: read("log"),
        }),
        // QEMU's own failures are code 1, and a signal has no code.
        Some(1) | None => Err(RunError::Emulator(text("errors").replace('\n', "; "))),
        Some(code) => Err(RunError::Image { code, message: text("messages") }),
    }
}

/// Reads a pipe on a thread of its own, so that waiting for it can end.
pub(crate) fn reader(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (sender, receiver) = sync_channel(16);
    std::thread::spawn(move || {
        let mut buffer = [0; 1 << 16];
        let Some(mut pipe) = pipe else { return };
        loop {
            match pipe.read(&mut buffer) {
                Ok(0) => return,
                Ok(count) => {
                    if sender.send(buffer[..count].to_vec()).is_err() {
                        return;
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => return,
            }
        }
    });
    receiver
}

/// How an emulator ended, if it did before `end`.
fn ended(board: &Owned, end: Instant) -> Option<ExitStatus> {
    loop {
        match board.try_wait() {
            Ok(Some(status)) => return Some(status),
            Ok(None) if Instant::now() < end => std::thread::sleep(Duration::from_millis(2)),
            _ => return None,
        }
    }
}

/// What an image takes of the board's memories, from the sections of its ELF file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Footprint {
    /// Bytes of program and constants, with the initial values of variables.
    pub flash: u64,
    /// Bytes of variables; the stack comes on top.
    pub ram: u64,
}

impl Footprint {
    /// Bytes of the section `.rodata`, where C compilers place tables.
    pub fn constants(elf: &Path) -> Result<u64, RunError> {
        use object::{Object, ObjectSection};
        let bytes = fs::read(elf).map_err(io_error(elf.display()))?;
        let file = object::File::parse(&*bytes)
            .map_err(|error| io_error(elf.display())(io::Error::other(error)))?;
        Ok(file.section_by_name(".rodata").map_or(0, |section| section.size()))
    }

    /// Reads an ELF file.
    pub fn from_elf(elf: &Path) -> Result<Self, RunError> {
        use object::{Object, ObjectSection, SectionFlags, SectionKind};
        let bytes = fs::read(elf).map_err(io_error(elf.display()))?;
        let file = object::File::parse(&*bytes)
            .map_err(|error| io_error(elf.display())(io::Error::other(error)))?;
        let mut footprint = Footprint::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                continue;
            };
            if sh_flags.0 & object::elf::SHF_ALLOC.0 == 0 {
                continue;
            }
            let stored = section.kind() != SectionKind::UninitializedData;
            let written = sh_flags.0 & object::elf::SHF_WRITE.0 != 0;
            footprint.flash += if stored { section.size() } else { 0 };
            footprint.ram += if written { section.size() } else { 0 };
        }
        Ok(footprint)
    }
}

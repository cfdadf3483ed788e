//! The NUCLEO's image on QEMU's STM32F405; this module plays the converters and DMA.
//!
//! Real are the vector table, the interrupts and who owns which buffer, the serial port, the timers, and every instruction of
//! the program. Played, in a piece of memory, are the registers of DMA2 and the converters: QEMU has none. Neither there nor here
//! are the clock's multiplier, the watchdog and the flash controller.

use crate::console::Console;
use crate::emulator::RunError;
use crate::toolchain::{self, Firmware, Profile, Target, io_error};
use std::io::{BufRead, BufReader, Write};
#[cfg(not(unix))]
use std::net::TcpStream as Stream;
use std::ops::{Deref, DerefMut};
#[cfg(unix)]
use std::os::unix::net::UnixStream as Stream;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The image's name.
pub const IMAGE: &str = "frontend_nucleo";

/// The image for the board, or for the emulator; `brown_out`: it also sets the chip's brown-out level, once.
pub fn image(played: bool, brown_out: bool) -> Result<PathBuf, toolchain::ToolError> {
    let board = if played { "played" } else { "nucleo" };
    let features = [board, "brown-out"];
    let features = if brown_out { &features[..] } else { &features[..1] };
    let (target, profile) = (Target::M4f, Profile::Balanced);
    Firmware { bin: IMAGE, target, features, profile }.build()
}

/// Addresses of what is played; see `board::nucleo_f446re::PLAYED`.
mod at {
    pub const LISR: u32 = 0x2001_F000;
    pub const LIFCR: u32 = LISR + 0x08;
    pub const CR: u32 = LISR + 0x10;
    pub const NDTR: u32 = LISR + 0x14;
    pub const PAR: u32 = LISR + 0x18;
    pub const M0AR: u32 = LISR + 0x1C;
    pub const M1AR: u32 = LISR + 0x20;
    pub const ADC1: u32 = LISR + 0x400;
    pub const ADC_COMMON: u32 = LISR + 0x700;
    /// NVIC_ISPR.
    pub const PENDING: u32 = 0xE000_E200;
}

/// DMA_SxCR (RM 9.5.5), EN, and CT: the slot being filled.
const STREAM_EN: u32 = 1;
const STREAM_CT: u32 = 1 << 19;
/// DMA_LISR (RM 9.5.1), TCIF0.
const STREAM_0_COMPLETE: u32 = 1 << 5;
/// ADC_SR (RM 13.13.1), OVR.
const ADC_SR_OVR: u32 = 1 << 5;

/// The interrupt of DMA2's stream 0, and of the converters.
const STREAM_IRQ: u32 = 56;
const ADC_IRQ: u32 = 18;

/// The emulated board.
pub struct Board {
    console: Console,
    qtest: BufReader<Stream>,
    _directory: TempDir,
}

impl Board {
    /// Starts an image built with the feature `played`.
    pub fn start(image: &Path) -> Result<Self, RunError> {
        Self::start_with(image, &[])
    }

    /// Starts an image whose timers count one tick per instruction.
    pub fn start_counted(image: &Path) -> Result<Self, RunError> {
        Self::start_with(image, &["-icount", "shift=0"])
    }

    fn start_with(image: &Path, options: &[&str]) -> Result<Self, RunError> {
        let directory = tempfile::Builder::new()
            .prefix("picket-")
            .tempdir()
            .map_err(io_error("the temporary directory"))?;
        let socket = directory.path().join("qtest");
        let mut command = std::process::Command::new(toolchain::qemu()?);
        command.args(["-machine", machine()?, "-kernel"]).arg(image);
        command.args(["-nodefaults", "-nographic", "-net", "none", "-serial", "null"]);
        command.args(["-chardev", "stdio,id=usart2,signal=off", "-serial", "chardev:usart2"]);
        command.arg("-qtest").arg(format!("unix:{},server=on,wait=off", socket.display()));
        command.args(["-qtest-log", "none"]).args(options);
        let console = Console::start(command)?;
        let end = Instant::now() + Duration::from_secs(20);
        let stream = loop {
            match connect(&socket) {
                Ok(stream) => break stream,
                Err(error) if Instant::now() > end => return Err(io_error("qtest")(error).into()),
                Err(_) => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        let limit = Some(Duration::from_secs(20));
        stream.set_read_timeout(limit).map_err(io_error("qtest"))?;
        Ok(Self { console, qtest: BufReader::new(stream), _directory: directory })
    }

    fn ask(&mut self, line: &str) -> Result<u32, RunError> {
        let stream = self.qtest.get_mut();
        stream.write_all(line.as_bytes()).map_err(io_error("qtest"))?;
        let mut answer = String::new();
        self.qtest.read_line(&mut answer).map_err(io_error("qtest"))?;
        let value = answer.trim().strip_prefix("OK").map(str::trim);
        let value = value.ok_or_else(|| RunError::Emulator(format!("qtest: {}", answer.trim())))?;
        let hex = value.trim_start_matches("0x");
        Ok(u64::from_str_radix(hex, 16).unwrap_or_default() as u32)
    }

    /// A word of the board's memory.
    pub fn read(&mut self, address: u32) -> Result<u32, RunError> {
        self.ask(&format!("readl {address:#x}\n"))
    }

    fn write(&mut self, address: u32, word: u32) -> Result<(), RunError> {
        self.ask(&format!("writel {address:#x} {word:#x}\n")).map(drop)
    }

    /// Pends the stream's interrupt, once.
    pub fn interrupt(&mut self) -> Result<(), RunError> {
        self.pend(STREAM_IRQ)
    }

    fn pend(&mut self, line: u32) -> Result<(), RunError> {
        self.settle()?;
        self.write(at::PENDING + line / 32 * 4, 1 << (line % 32))
    }

    /// Clears what the board has asked to be cleared, as the controller would have at once.
    fn settle(&mut self) -> Result<(), RunError> {
        let clear = self.read(at::LIFCR)?;
        if clear != 0 {
            self.write(at::LIFCR, 0)?;
            let flags = self.read(at::LISR)?;
            self.write(at::LISR, flags & !clear)?;
        }
        Ok(())
    }

    /// The stream completes a segment: `samples` go to the slot that is being filled, behind the guard, and it turns to the other.
    /// The interrupt is still to come. False if the stream stands still.
    pub fn fill(&mut self, samples: &[u8]) -> Result<bool, RunError> {
        self.settle()?;
        let control = self.read(at::CR)?;
        if control & STREAM_EN == 0 {
            return Ok(false);
        }
        // MSIZE 14:13: 1 half words, 2 words.
        let bytes = self.read(at::NDTR)? << (control >> 13 & 3);
        let place = if control & STREAM_CT == 0 { at::M0AR } else { at::M1AR };
        let address = self.read(place)? + bytes.saturating_sub(samples.len() as u32);
        self.ask(&format!("write {address:#x} {:#x} 0x{}\n", samples.len(), hex(samples)))?;
        self.write(at::CR, control ^ STREAM_CT)?;
        let flags = self.read(at::LISR)?;
        self.write(at::LISR, flags | STREAM_0_COMPLETE)?;
        Ok(true)
    }

    /// A block as it should be: filled, and its interrupt.
    pub fn block(&mut self, samples: &[u8]) -> Result<bool, RunError> {
        let running = self.fill(samples)?;
        if running {
            self.interrupt()?;
        }
        Ok(running)
    }

    /// The stream stops with an error.
    pub fn dma_error(&mut self) -> Result<(), RunError> {
        self.settle()?;
        let (flags, control) = (self.read(at::LISR)?, self.read(at::CR)?);
        // TEIF0.
        self.write(at::LISR, flags | 1 << 3)?;
        self.write(at::CR, control & !STREAM_EN)?;
        self.interrupt()
    }

    /// A result came before the last one was fetched.
    pub fn adc_overrun(&mut self) -> Result<(), RunError> {
        self.write(at::ADC1, ADC_SR_OVR)?;
        self.pend(ADC_IRQ)
    }

    /// What the board has written to the converters and the stream: DMA_S0CR, NDTR, PAR, ADC1_CR1, CR2, SMPR2, SQR3, ADC_CCR.
    pub fn registers(&mut self) -> Result<[u32; 8], RunError> {
        let adc = at::ADC1;
        let places = [
            at::CR,
            at::NDTR,
            at::PAR,
            adc + 4,
            adc + 8,
            adc + 0x10,
            adc + 0x34,
            at::ADC_COMMON + 4,
        ];
        let mut words = [0; 8];
        for (word, place) in words.iter_mut().zip(places) {
            *word = self.read(place)?;
        }
        Ok(words)
    }
}

/// QEMU's socket.
#[cfg(unix)]
fn connect(socket: &Path) -> std::io::Result<Stream> {
    Stream::connect(socket)
}

/// QEMU's socket, which is one of Unix.
#[cfg(not(unix))]
fn connect(_: &Path) -> std::io::Result<Stream> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// What is said to it and by it.
impl Deref for Board {
    type Target = Console;

    fn deref(&self) -> &Console {
        &self.console
    }
}

impl DerefMut for Board {
    fn deref_mut(&mut self) -> &mut Console {
        &mut self.console
    }
}

fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]);
    digits.map(|digit| char::from(DIGITS[usize::from(digit)])).collect()
}

/// The machine with an STM32F405 that this QEMU has.
fn machine() -> Result<&'static str, RunError> {
    const NAMES: [&str; 2] = ["netduinoplus2", "olimex-stm32-h405"];
    let output = std::process::Command::new(toolchain::qemu()?)
        .args(["-machine", "help"])
        .output()
        .map_err(io_error("qemu-system-arm"))?;
    let list = String::from_utf8_lossy(&output.stdout);
    let known = |name: &&str| list.lines().any(|line| line.split(' ').next() == Some(name));
    NAMES
        .into_iter()
        .find(known)
        .ok_or_else(|| RunError::Emulator("it has no machine with an STM32F405".into()))
}

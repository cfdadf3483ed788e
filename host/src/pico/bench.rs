//! A Pico on rp2040js: power, signals, faults, and the host's end of its serial port.
//!
//! The emulator is other people's; `host/rp2040/` has the scripts around it. Time is emulated: nothing passes until an order
//! says so.

use crate::device::{Listener, Said};
use crate::emulator::RunError;
use crate::end::Owned;
use crate::toolchain::{ToolError, firmware_dir, io_error, node, scripts, workspace};
use picket_wire::boot::Boot;
use picket_wire::command::{Command, Refusal, Request};
use picket_wire::telemetry::Telemetry;
use serde::Deserialize;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{ChildStdin, ChildStdout, Stdio};
use tempfile::TempDir;

/// The scripts and the emulator, which npm gets at the first need.
///
/// # Errors
/// Node.js, npm or the package cannot be had: the error says what to type.
pub fn emulator() -> Result<PathBuf, ToolError> {
    let files = ["bench.mjs", "chip.mjs", "correct.mjs", "faults.mjs", "otherwise.mjs", "usb.mjs"];
    scripts(&workspace().join("host/rp2040"), &files, "rp2040js", firmware_dir().join("rp2040"))
}

/// What happened since the figures were last set to zero.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Figures {
    /// Emulated time, and how much of it the core slept, ns.
    pub nanos: f64,
    /// The time asleep, ns.
    pub idle: f64,
    /// Cycles awake, with 15 for each exception's entry.
    pub cycles: f64,
    /// Instructions.
    pub instructions: f64,
    /// Exceptions.
    pub entries: f64,
    /// Frames that left by the serial port.
    pub frames: u64,
    /// The most samples in the converter's queue, of four.
    pub level: u32,
    /// Samples that found no place in it.
    pub overruns: u32,
    /// Starts of the converter after which one did.
    pub over: u32,
    /// Samples converted.
    pub taken: u64,
    /// The core's clock, Hz.
    #[serde(rename = "clkSys")]
    pub core_hz: f64,
    /// The rate of the serial port, baud.
    pub baud: f64,
}

impl Figures {
    /// The part of the time that the core was awake.
    pub fn load(&self) -> f64 {
        1.0 - self.idle / self.nanos
    }
}

/// A block as the two channels completed it.
#[derive(Clone, Debug, PartialEq)]
pub struct Completed {
    /// When, ns.
    pub nanos: f64,
    /// How often the converter was started before.
    pub starts: f64,
    /// Its samples.
    pub samples: Vec<i16>,
}

/// The board.
pub struct Pico {
    emulator: Owned,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    listener: Listener,
    said: VecDeque<Said>,
    folder: TempDir,
    /// Every byte it has sent by its serial port.
    pub sent: Vec<u8>,
    /// Every byte it has sent by USB.
    pub by_usb: Vec<u8>,
    /// Emulated time, us.
    pub now: u64,
    /// When it was reset, us.
    pub resets: Vec<u64>,
    tag: u8,
}

/// The bytes of a line.
fn bytes(hex: &str) -> impl Iterator<Item = u8> {
    let pairs = (0..hex.len()).step_by(2).filter_map(|at| hex.get(at..at + 2));
    pairs.filter_map(|pair| u8::from_str_radix(pair, 16).ok())
}

fn failed(text: impl Into<String>) -> RunError {
    RunError::Emulator(text.into())
}

impl Pico {
    /// A board without power, with this in its flash.
    pub fn plug(binary: &[u8]) -> Result<Self, RunError> {
        let scripts = emulator()?;
        let folder = tempfile::Builder::new().prefix("picket-").tempdir();
        let folder = folder.map_err(io_error("the temporary directory"))?;
        let image = folder.path().join("image.bin");
        std::fs::write(&image, binary).map_err(io_error(image.display()))?;
        let mut command = std::process::Command::new(node()?);
        command.arg(scripts.join("bench.mjs")).arg(&image);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let emulator = Owned::start(command).map_err(io_error("node"))?;
        let gone = || failed("it did not start");
        let orders = emulator.stdin().ok_or_else(gone)?;
        let answers = BufReader::new(emulator.stdout().ok_or_else(gone)?);
        Ok(Self {
            emulator,
            orders,
            answers,
            listener: Listener::default(),
            said: VecDeque::new(),
            folder,
            sent: Vec::new(),
            by_usb: Vec::new(),
            now: 0,
            resets: Vec::new(),
            tag: 0,
        })
    }

    /// Gives an order, and the lines that answer it.
    pub fn order(&mut self, line: &str) -> Result<Vec<String>, RunError> {
        writeln!(self.orders, "{line}").map_err(io_error("the emulator"))?;
        self.orders.flush().map_err(io_error("the emulator"))?;
        let mut lines = Vec::new();
        loop {
            let mut answer = String::new();
            let length = self.answers.read_line(&mut answer).map_err(io_error("the emulator"))?;
            if length == 0 {
                let _ = self.emulator.try_wait();
                return Err(failed(format!("it ended at: {line}")));
            }
            let answer = answer.trim();
            match answer.split_once(' ').unwrap_or((answer, "")) {
                ("ok", "") => return Ok(lines),
                ("ok", error) => return Err(failed(format!("{line}: {error}"))),
                ("say", hex) => self.say(hex),
                ("usb", hex) => self.by_usb.extend(bytes(hex)),
                ("at", time) => self.now = time.parse().unwrap_or(self.now),
                ("reset", time) => self.resets.extend(time.parse::<u64>()),
                (_, rest) => lines.push(rest.into()),
            }
        }
    }

    fn say(&mut self, hex: &str) {
        for byte in bytes(hex) {
            self.sent.push(byte);
            self.said.extend(self.listener.push(byte));
        }
    }

    /// A file for the emulator.
    fn file(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, RunError> {
        let path = self.folder.path().join(name);
        std::fs::write(&path, bytes).map_err(io_error(path.display()))?;
        Ok(path)
    }

    /// What the converter gives from now on, again and again.
    pub fn samples(&mut self, samples: &[i16]) -> Result<(), RunError> {
        self.inputs(samples, 1)
    }

    /// What the two inputs give, again and again; codes of one moment stand side by side.
    pub fn both(&mut self, samples: &[[i16; 2]]) -> Result<(), RunError> {
        self.inputs(samples.as_flattened(), 2)
    }

    fn inputs(&mut self, samples: &[i16], inputs: u32) -> Result<(), RunError> {
        let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
        let path = self.file("samples.i16", &bytes)?;
        self.order(&format!("samples {} {inputs}", path.display())).map(drop)
    }

    /// Writes flash.
    pub fn load(&mut self, address: u32, bytes: &[u8]) -> Result<(), RunError> {
        let path = self.file("flash.bin", bytes)?;
        self.order(&format!("load {address:#x} {}", path.display())).map(drop)
    }

    /// Power off and on, and the boot record.
    pub fn power(&mut self) -> Result<Boot, RunError> {
        self.said.clear();
        self.listener = Listener::default();
        self.order("power")?;
        self.boot()
    }

    /// The next boot record.
    pub fn boot(&mut self) -> Result<Boot, RunError> {
        self.expect(|said| match said {
            Said::Boot(boot) => Some(*boot),
            _ => None,
        })
    }

    /// Lets time pass, us.
    pub fn run(&mut self, microseconds: u64) -> Result<(), RunError> {
        self.order(&format!("run {microseconds}")).map(drop)
    }

    /// Lets time pass until this many more frames have come, or this many milliseconds are over.
    pub fn frames(&mut self, count: u64, milliseconds: u64) -> Result<(), RunError> {
        self.order(&format!("frames {count} {milliseconds}")).map(drop)
    }

    /// A word of memory or of a register.
    pub fn read(&mut self, address: u32) -> Result<u32, RunError> {
        let lines = self.order(&format!("read {address:#x}"))?;
        lines.first().and_then(|word| word.parse().ok()).ok_or_else(|| failed("no word"))
    }

    /// Sends bytes to the board.
    pub fn hear(&mut self, bytes: &[u8]) -> Result<(), RunError> {
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.order(&format!("hear {hex}")).map(drop)
    }

    /// Makes a fault happen now; `faults.mjs` has their names.
    pub fn fault(&mut self, kind: &str, microseconds: f64) -> Result<(), RunError> {
        self.order(&format!("fault {kind} {microseconds}")).map(drop)
    }

    /// Sets the figures to zero.
    pub fn zero(&mut self) -> Result<(), RunError> {
        self.order("zero").map(drop)
    }

    /// The figures since they were zero.
    pub fn figures(&mut self) -> Result<Figures, RunError> {
        let lines = self.order("figures")?;
        let text = lines.first().map(String::as_str).unwrap_or_default();
        serde_json::from_str(text).map_err(|error| failed(error.to_string()))
    }

    /// From now on the blocks of `n` conversions that the channels complete are kept.
    pub fn keep(&mut self, n: usize) -> Result<(), RunError> {
        let path = self.folder.path().join("blocks");
        self.order(&format!("blocks {} {}", path.display(), 2 * n)).map(drop)
    }

    /// The blocks that were kept.
    pub fn kept(&self, n: usize) -> Result<Vec<Completed>, RunError> {
        let path = self.folder.path().join("blocks");
        let bytes = std::fs::read(&path).map_err(io_error(path.display()))?;
        let blocks = bytes.chunks_exact(16 + 2 * n).filter_map(|block| {
            let (nanos, rest) = block.split_first_chunk()?;
            let (starts, samples) = rest.split_first_chunk()?;
            let [nanos, starts] = [nanos, starts].map(|word| f64::from_le_bytes(*word));
            let samples = samples.as_chunks().0.iter().map(|&code| i16::from_le_bytes(code));
            Some(Completed { nanos, starts, samples: samples.collect() })
        });
        Ok(blocks.collect())
    }

    /// Waits for something that is said, which it takes away; everything else stays.
    pub fn expect<T>(&mut self, mut wanted: impl FnMut(&Said) -> Option<T>) -> Result<T, RunError> {
        const PATIENCE: u64 = 6_000_000;
        let end = self.now + PATIENCE;
        let mut seen = 0;
        loop {
            while let Some(said) = self.said.get(seen) {
                if let Some(found) = wanted(said) {
                    self.said.remove(seen);
                    return Ok(found);
                }
                seen += 1;
            }
            if self.now > end {
                return Err(failed(format!("it is not said: {:?}", self.said.back())));
            }
            self.run(1_000)?;
        }
    }

    /// Asks, and waits for the answer.
    pub fn request(&mut self, command: Command) -> Result<Result<Vec<u8>, Refusal>, RunError> {
        self.tag = self.tag.wrapping_add(1);
        let request = Request { tag: self.tag, command };
        self.hear(&request.to_frame())?;
        self.expect(|said| match said {
            Said::Answer(answer, body) if *answer == request.answer() => Some(body.clone()),
            _ => None,
        })
    }

    /// All that was said and not yet taken.
    pub fn take(&mut self) -> Vec<Said> {
        self.said.drain(..).collect()
    }

    /// The measurements that came, which it takes away.
    pub fn telemetry(&mut self) -> Vec<Telemetry> {
        let records = self.said.iter().filter_map(|said| match said {
            Said::Telemetry(record) => Some(*record),
            _ => None,
        });
        let records = records.collect();
        self.said.retain(|said| !matches!(said, Said::Telemetry(_)));
        records
    }

    /// Forgets what it said of its status so far.
    pub fn forget_status(&mut self) {
        self.said.retain(|said| !matches!(said, Said::Status(_)));
    }

    /// What was said and counted so far.
    pub fn listener(&self) -> &Listener {
        &self.listener
    }
}

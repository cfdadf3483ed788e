//! A NUCLEO on the emulator's bench: power, signals, the host's side of its serial port.

use super::source;
use picket_dsp::pipeline::Measurement;
use picket_firmware::instrument::storage::{self, PAGE, Page, Storage};
use picket_firmware::instrument::words::payload;
use picket_firmware::nucleo_f446re::N;
use picket_host::device::{Listener, Said};
use picket_host::toolchain::ToolError;
use picket_host::{board, flash};
use picket_wire::boot::Boot;
use picket_wire::command::{Command, Refusal, Request};
use picket_wire::settings::Settings;
use picket_wire::status::Status;
use picket_wire::telemetry::Telemetry;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// The image as it lies in flash. `PICKET_IMAGE` names another one than this source's.
pub fn image() -> &'static PathBuf {
    static IMAGE: OnceLock<PathBuf> = OnceLock::new();
    IMAGE.get_or_init(|| {
        if let Some(other) = std::env::var_os("PICKET_IMAGE") {
            return other.into();
        }
        in_flash(board::image(false, false))
    })
}

/// An image with this name as it lies in flash, built at the first need.
pub fn built(
    place: &'static OnceLock<PathBuf>,
    build: fn() -> Result<PathBuf, ToolError>,
) -> &'static Path {
    place.get_or_init(|| in_flash(build()))
}

/// A built image as it lies in flash.
fn in_flash(elf: Result<PathBuf, ToolError>) -> PathBuf {
    let elf = elf.unwrap_or_else(|error| panic!("{error}"));
    file(&flash::binary(&elf).unwrap_or_else(|error| panic!("{error}")))
}

/// A file with these bytes.
pub fn file(bytes: &[u8]) -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let name = format!("picket-bench-{}-{number}.bin", std::process::id());
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// The board.
pub struct Emulated {
    child: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    listener: Listener,
    said: VecDeque<(u64, Said)>,
    /// Every byte it has sent.
    pub sent: Vec<u8>,
    /// Emulated time, us.
    pub now: u64,
    /// Resets since it was plugged in, with their causes.
    pub resets: Vec<(u64, String)>,
    tag: u8,
}

impl Drop for Emulated {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The longest wait for an answer, us.
const PATIENCE: u64 = 6_000_000;

/// The two sectors of flash that keep settings, at 0x0800 4000.
pub struct Sectors(pub Vec<u8>);

impl Sectors {
    /// Erased.
    pub fn new() -> Self {
        Self(vec![0xFF; 0x8000])
    }

    fn at(page: Page, index: usize) -> std::ops::Range<usize> {
        let at = 0x4000 * page as usize + 4 * index;
        at..at + 4
    }

    /// What the board would load.
    pub fn settings(&self) -> Option<Settings> {
        let (_, _, payload) = storage::load(self)?;
        Some(Settings::from_bytes(&payload).unwrap().0)
    }

    /// Saves settings as the board does.
    pub fn save(&mut self, settings: &Settings) {
        self.save_of(N, settings);
    }

    /// Saves settings as a program for blocks of `n` samples does.
    pub fn save_of(&mut self, n: usize, settings: &Settings) {
        storage::save(self, &payload(settings, n)).unwrap();
    }
}

impl Storage for Sectors {
    type Error = ();

    fn read(&self, page: Page, index: usize) -> u32 {
        u32::from_le_bytes(self.0[Self::at(page, index)].try_into().unwrap())
    }

    fn erase(&mut self, page: Page) -> Result<(), ()> {
        let at = Self::at(page, 0).start;
        self.0[at..at + 0x4000].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), ()> {
        self.0[Self::at(page, index)].copy_from_slice(&word.to_le_bytes());
        Ok(())
    }
}

impl Emulated {
    /// A board without power.
    pub fn plug() -> Self {
        Self::plug_with(image())
    }

    /// The same with another image.
    pub fn plug_with(image: &Path) -> Self {
        let program = source::program();
        let mut child = std::process::Command::new(program)
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (orders, answers) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        Self {
            child,
            orders,
            answers: BufReader::new(answers),
            listener: Listener::default(),
            said: VecDeque::new(),
            sent: Vec::new(),
            now: 0,
            resets: Vec::new(),
            tag: 0,
        }
    }

    /// A board that was saved these settings, from power-on until it has told of its start.
    pub fn start(settings: &Settings) -> (Self, Boot) {
        Self::start_with(image(), settings)
    }

    /// The same with another image.
    pub fn start_with(image: &Path, settings: &Settings) -> (Self, Boot) {
        let mut board = Self::plug_with(image);
        let mut sectors = Sectors::new();
        sectors.save(settings);
        board.load(&sectors);
        board.power()
    }

    /// Writes what flash keeps.
    pub fn load(&mut self, sectors: &Sectors) {
        let file = file(&sectors.0);
        self.order(&format!("load 0x08004000 {}", file.display()));
    }

    /// What flash keeps.
    pub fn sectors(&mut self) -> Sectors {
        let mut sectors = Sectors::new();
        for page in [Page::A, Page::B] {
            for index in 0..PAGE {
                let at = Sectors::at(page, index);
                let word = self.read(0x0800_4000 + at.start as u32);
                sectors.0[at].copy_from_slice(&word.to_le_bytes());
            }
        }
        sectors
    }

    /// Power off and on, and the boot record.
    pub fn power(mut self) -> (Self, Boot) {
        self.order("power");
        self.listener = Listener::default();
        self.said.clear();
        let boot = self.boot();
        (self, boot)
    }

    /// The next boot record.
    pub fn boot(&mut self) -> Boot {
        self.expect(|said| match said {
            Said::Boot(boot) => Some(*boot),
            _ => None,
        })
    }

    /// Gives an order to the bench, and the lines that answer it.
    pub fn order(&mut self, line: &str) -> Vec<String> {
        writeln!(self.orders, "{line}").unwrap();
        self.orders.flush().unwrap();
        let mut lines = Vec::new();
        loop {
            let mut answer = String::new();
            assert!(self.answers.read_line(&mut answer).unwrap() > 0, "the emulator ended: {line}");
            let answer = answer.trim();
            match answer.split_once(' ').unwrap_or((answer, "")) {
                ("ok", "") => return lines,
                ("ok", error) => panic!("{line}: {error}"),
                ("say", hex) => self.say(hex),
                ("at", time) => self.now = time.parse().unwrap(),
                ("reset", reset) => {
                    let (time, cause) = reset.split_once(' ').unwrap();
                    self.resets.push((time.parse().unwrap(), cause.into()));
                }
                (_, rest) => lines.push(rest.into()),
            }
        }
    }

    fn say(&mut self, hex: &str) {
        for at in (0..hex.len()).step_by(2) {
            let byte = u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
            self.sent.push(byte);
            if let Some(said) = self.listener.push(byte) {
                self.said.push_back((self.now, said));
            }
        }
    }

    /// Lets time pass, us.
    pub fn run(&mut self, microseconds: u64) {
        self.order(&format!("run {microseconds}"));
    }

    /// A word of the chip's memory or registers.
    pub fn read(&mut self, address: u32) -> u32 {
        self.order(&format!("read {address:#x}"))[0].parse().unwrap()
    }

    /// Writes a word.
    pub fn write(&mut self, address: u32, word: u32) {
        self.order(&format!("write {address:#x} {word:#x}"));
    }

    /// Sends pulses of 1 ms to the sync input from now on, one every so many us.
    pub fn pulses(&mut self, period: u32) {
        self.pulses_of(32, 1000, period);
    }

    /// Sends pulses of `width` to the sync input from now on, one every `period`, both in so many ticks of 31 ns.
    pub fn pulses_of(&mut self, ticks: u32, width: u32, period: u32) {
        // PSC, ARR, CCR1, CCMR1 PWM 1, CCER, EGR, CR1.
        let words = [(0x28, ticks - 1), (0x2C, period - 1), (0x34, width), (0x18, 0x60), (0x20, 1)];
        for (at, word) in words.into_iter().chain([(0x14, 1), (0, 1)]) {
            self.write(0x4000_1000 + at, word);
        }
    }

    /// Sends bytes to the board.
    pub fn hear(&mut self, bytes: &[u8]) {
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.order(&format!("hear {hex}"));
    }

    /// Waits for something that is said, which it takes away; everything before it stays.
    pub fn expect<T>(&mut self, mut wanted: impl FnMut(&Said) -> Option<T>) -> T {
        let end = self.now + PATIENCE;
        let mut seen = 0;
        loop {
            while seen < self.said.len() {
                if let Some(found) = wanted(&self.said[seen].1) {
                    self.said.remove(seen);
                    return found;
                }
                seen += 1;
            }
            assert!(self.now < end, "it is not said: {:?}", self.said.back());
            self.run(1_000);
        }
    }

    /// Asks, and waits for the answer.
    pub fn request(&mut self, command: Command) -> Result<Vec<u8>, Refusal> {
        self.tag = self.tag.wrapping_add(1);
        let request = Request { tag: self.tag, command };
        self.hear(&request.to_frame());
        self.expect(|said| match said {
            Said::Answer(answer, body) if *answer == request.answer() => Some(body.clone()),
            _ => None,
        })
    }

    /// The board's status.
    pub fn status(&mut self) -> Status {
        self.said.retain(|(_, said)| !matches!(said, Said::Status(_)));
        self.request(Command::Status).unwrap();
        self.expect(|said| match said {
            Said::Status(status) => Some(*status),
            _ => None,
        })
    }

    /// The measurements that came, which it takes away.
    pub fn telemetry(&mut self) -> Vec<Telemetry> {
        let records = self.said.iter().filter_map(|(_, said)| match said {
            Said::Telemetry(record) => Some(*record),
            _ => None,
        });
        let records = records.collect();
        self.said.retain(|(_, said)| !matches!(said, Said::Telemetry(_)));
        records
    }

    /// Captures a block as it is, with its measurement.
    pub fn capture(&mut self) -> (Measurement, Vec<u16>) {
        self.telemetry();
        self.request(Command::Capture(1)).unwrap();
        let mut bytes = Vec::new();
        let mut number = 0;
        self.expect(|said| match said {
            Said::Raw(raw) if usize::from(raw.offset) == bytes.len() => {
                bytes.extend_from_slice(&raw.bytes);
                number = raw.sequence;
                (bytes.len() == 2 * N).then_some(())
            }
            _ => None,
        });
        self.said.retain(|(_, said)| !matches!(said, Said::Raw(_)));
        let codes = bytes.chunks_exact(2).map(|code| u16::from_le_bytes(code.try_into().unwrap()));
        let codes = codes.collect();
        let record = self.telemetry().into_iter().find(|r| r.measurement.stamp.sequence == number);
        (record.expect("a captured block is reported").measurement, codes)
    }

    /// Numbers in pairs: edges at D6 with their times, or the DAC's codes.
    pub fn pairs(&mut self, what: &str) -> Vec<(u64, u32)> {
        let lines = self.order(what);
        let text = lines.first().cloned().unwrap_or_default();
        let pair = |pair: &str| {
            let (time, value) = pair.split_once(':').unwrap();
            (time.parse().unwrap(), value.parse().unwrap())
        };
        text.split_whitespace().map(pair).collect()
    }

    /// Asserts that the program broke no rule of the manual.
    pub fn assert_rules(&mut self) {
        let broken = self.order("broken");
        assert!(broken.is_empty(), "{broken:?}");
    }
}

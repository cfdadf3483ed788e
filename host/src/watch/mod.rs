//! `picket watch`: what an instrument measures, live, recorded or replayed; and orders to it.

mod capture;
mod clock;
mod error;
mod frames;
mod fundamental;
pub mod line;
mod live;
pub mod orders;
pub mod port;
pub mod ports;
pub mod scale;
pub mod settings;

use crate::cli::{self, print_line};
use crate::device::{Listener, Said};
use crate::end;
use crate::output::{Growing, Output};
use capture::Capture;
use clap::Args;
use clock::{HostClock, Told};
pub use error::WatchError;
use error::{io, unheard, unknown};
use frames::Frames;
use fundamental::Fundamental;
use orders::{Orders, Pending};
use picket_wire::command::Command;
use port::{Piece, Source};
use scale::Scale;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Shows what a board measures: a table, or lines for programs.
#[derive(Args, Debug)]
pub struct Options {
    /// The board's serial port (/dev/ttyACM0), or - for its bytes on stdin; without a port the ports are listed
    #[arg(conflicts_with = "replay")]
    port: Option<String>,
    /// Prints comma-separated values with a header
    #[arg(long, group = "style")]
    csv: bool,
    /// Prints one JSON object per line
    #[arg(long, group = "style")]
    jsonl: bool,
    /// Prints lines for the plotter Teleplot (and Serial Studio): >name:value
    #[arg(long, group = "style")]
    teleplot: bool,
    /// Draws answer, verdict, history and counters on the terminal; prints lines if the output is not a terminal
    #[arg(long, group = "style", conflicts_with = "count")]
    live: bool,
    /// Stores every received byte in a file
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Reads a recorded file instead of a port
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    /// Samples per second, if the board does not report them
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Ends after this number of measurements
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Prints a udev rule for Linux that lets every user open the board's port
    #[arg(long, exclusive = true)]
    install_udev: bool,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    orders: Orders,
}

impl Options {
    /// Whether the messages can be stored in the wanted file.
    fn check(&self) -> Result<(), WatchError> {
        let capture = self.orders.capture().map(|(_, path)| path);
        let mut read: Vec<&Path> = self.replay.iter().map(PathBuf::as_path).collect();
        read.extend(self.port.as_deref().map(Path::new));
        read.extend(self.orders.settings());
        for file in self.record.as_deref().into_iter().chain(capture) {
            self.output.check(file, &read).map_err(WatchError::Output)?;
            read.push(file);
        }
        if self.record.is_some() && self.record.as_deref() == capture {
            return Err(WatchError::Output(
                "--record and --capture-to are one file: name two".into(),
            ));
        }
        Ok(())
    }
}

/// How measurements are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Style {
    Table,
    Csv,
    Jsonl,
    Teleplot,
}

/// Watches until the source ends.
pub fn run(options: &Options) -> Result<ExitCode, WatchError> {
    let style = match (options.csv, options.jsonl, options.teleplot) {
        (true, ..) => Style::Csv,
        (_, true, _) => Style::Jsonl,
        (.., true) => Style::Teleplot,
        _ => Style::Table,
    };
    if options.install_udev {
        cli::print(ports::UDEV);
        return Ok(ExitCode::SUCCESS);
    }
    if options.port.is_none() && options.replay.is_none() {
        let (lines, first) = ports::list();
        lines.iter().for_each(|line| eprintln!("{line}"));
        return Err(WatchError::Nameless(first));
    }
    options.check()?;
    if options.live && !options.orders.any() && std::io::stdout().is_terminal() {
        return live::run(options);
    }
    let orders = options.orders.prepare()?;
    let mut source = Source::open(options.port.as_deref(), options.replay.as_deref())?;
    if options.orders.any() && !source.listens() {
        return Err(WatchError::Orders);
    }
    let kept = |path: &Path| Kept::create(path, options.output);
    let record = options.record.as_deref().map(kept).transpose()?;
    let capture = options.orders.capture();
    let capture =
        capture.map(|(blocks, path)| Ok(Capture::create(kept(path)?, blocks))).transpose()?;
    let mut watch = Watch::new(style, options, orders.alone(), capture);
    end::look();
    let ended = watch.until_the_end(&mut source, orders, record, options.count);
    if watch.heard || ended.is_ok() && source.listens() {
        watch.finish();
    }
    ended?;
    let name = options.replay.as_ref().map(|path| path.display().to_string());
    let name = name.unwrap_or_else(|| "the input".into());
    match watch.listener.version {
        _ if source.listens() || watch.heard || end::asked().is_some() => Ok(ExitCode::SUCCESS),
        Some(version) => Err(WatchError::Version { what: name, version }),
        None => Err(WatchError::Nothing(name)),
    }
}

/// A file that keeps everything written to it, however the program ends.
struct Kept(Growing);

impl Kept {
    fn create(path: &Path, output: Output) -> Result<Self, WatchError> {
        output.grow(path).map(Kept).map_err(io(path.display()))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), WatchError> {
        let Kept(file) = self;
        file.add(bytes).map_err(|source| {
            let what = file.path().display().to_string();
            WatchError::Full { what, kept: file.bytes(), source }
        })
    }
}

/// What is shown, and how far.
struct Watch {
    style: Style,
    listener: Listener,
    scale: Scale,
    /// The header of comma-separated values is written.
    header: bool,
    /// The header of the table that is written: of records whose rate is known, or of others.
    heading: Option<bool>,
    /// The last row for people: not more than they can read.
    shown: Option<Instant>,
    /// The block of that row, if it is the last one's.
    sequence: Option<u32>,
    frames: Frames,
    capture: Option<Capture>,
    /// Only the answers to commands are wanted, not the measurements meanwhile.
    quiet: bool,
    /// A frame was understood.
    heard: bool,
    patience: Patience,
    /// The board's clock against this machine's; of a port, whose bytes come as the board sends them.
    clock: HostClock,
    begun: Instant,
    /// The clock's error is to be stored on the board; not any more once it is sent.
    save_clock: bool,
}

/// When the terminal reports silence.
#[derive(Debug)]
struct Patience {
    since: Instant,
    bytes: u64,
    told: bool,
}

impl Patience {
    const TWO_SECONDS: Duration = Duration::from_secs(2);

    /// The line that is due, once.
    fn line(&mut self, version: Option<u8>) -> Option<String> {
        if self.told || self.since.elapsed() < Self::TWO_SECONDS {
            return None;
        }
        self.told = true;
        let why = version.map_or_else(|| unheard(self.bytes), unknown);
        Some(format!("waiting for the device: {why}"))
    }
}

impl Watch {
    fn new(style: Style, options: &Options, quiet: bool, capture: Option<Capture>) -> Self {
        Self {
            style,
            listener: Listener::default(),
            scale: Scale::given(options.rate),
            header: false,
            heading: None,
            shown: None,
            sequence: None,
            frames: Frames::default(),
            capture,
            quiet,
            heard: false,
            // Orders that nobody hears end the program, and say why.
            patience: Patience { since: Instant::now(), bytes: 0, told: options.orders.any() },
            clock: HostClock::default(),
            begun: Instant::now(),
            save_clock: options.orders.saves_clock(),
        }
    }

    /// Shows what comes until there is no more, enough came, the orders were followed, or the user ends it.
    fn until_the_end(
        &mut self,
        source: &mut Source,
        mut orders: Pending,
        mut record: Option<Kept>,
        count: Option<u64>,
    ) -> Result<(), WatchError> {
        while end::asked().is_none() {
            let bytes = match source.piece()? {
                Piece::End => break,
                Piece::Opened => {
                    // Another host may have had it meanwhile.
                    self.scale.forget();
                    self.clock.restart();
                    orders.ask(source)?;
                    orders.renew(source);
                    continue;
                }
                Piece::Bytes(bytes) => bytes,
            };
            let arrival = self.begun.elapsed();
            if let Some(file) = &mut record {
                file.write(&bytes)?;
            }
            self.patience.bytes += bytes.len() as u64;
            for byte in bytes {
                let Some(said) = self.listener.push(byte) else { continue };
                (self.heard, self.patience.told) = (true, true);
                orders.hear(&said, source)?;
                if self.scale.hear(&said, &self.listener) {
                    orders.renew(source);
                }
                if source.listens() {
                    self.compare(&said, arrival, &mut orders, source)?;
                }
                self.show(said)?;
                if count.is_some_and(|count| self.listener.records >= count) {
                    return Ok(());
                }
            }
            if orders.done() && !self.capturing() {
                break;
            }
            if let Some(line) = self.patience.line(self.listener.version) {
                eprintln!("{line}");
            }
            orders.again(source, self.heard, self.patience.bytes)?;
            self.capture_again(&mut orders, source)?;
        }
        Ok(())
    }

    /// Compares the board's clock with this machine's.
    fn compare(
        &mut self,
        said: &Said,
        arrival: Duration,
        orders: &mut Pending,
        source: &mut Source,
    ) -> Result<(), WatchError> {
        let (scale, listener) = (&self.scale, &self.listener);
        let rate_of = |sequence| scale.rate_of(sequence, listener);
        let Some(told) = self.clock.hear(said, rate_of, arrival) else { return Ok(()) };
        if self.save_clock && matches!(told, Told::Wrong(_)) {
            let line = self.clock.line(&told, Style::Table);
            return Err(WatchError::Clock(format!("--save-clock: nothing is stored: {line}")));
        }
        if !self.quiet {
            let line = self.clock.line(&told, self.style);
            if self.style == Style::Jsonl { print_line(&line) } else { self.note(&line) }
        }
        if self.save_clock
            && let Some((settings, n)) = self.clock.corrected()
        {
            self.save_clock = false;
            orders.keep(settings, n, source);
        }
        Ok(())
    }

    fn capturing(&self) -> bool {
        self.capture.as_ref().is_some_and(Capture::misses)
    }

    /// Requests captured blocks again that did not arrive whole.
    fn capture_again(
        &mut self,
        orders: &mut Pending,
        source: &mut Source,
    ) -> Result<(), WatchError> {
        let Some(capture) = &mut self.capture else { return Ok(()) };
        if !orders.done() {
            capture.begin();
            return Ok(());
        }
        let seconds = self.scale.known().map_or(0.0, |known| known.n as f64 / known.rate_hz);
        let block = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        if let Some(left) = capture.again(block)? {
            orders.add(Command::Capture(left), source);
        }
        Ok(())
    }

    fn show(&mut self, said: Said) -> Result<(), WatchError> {
        self.frames.hear(&said);
        match said {
            Said::Telemetry(_)
            | Said::Status(_)
            | Said::Follow(_)
            | Said::Lines(_)
            | Said::Fundamental(_)
            | Said::Burst(_)
            | Said::Sum(_)
            | Said::ChirpFrame(_)
            | Said::Found(_)
                if self.quiet => {}
            Said::Telemetry(record) => {
                self.sequence = None;
                let rate_hz = self.rate_of(record.measurement.stamp.sequence);
                let row = line::Row::from_record(&record, rate_hz, &self.listener);
                self.row(&row.at_wrong_rate(self.clock.is_wrong()))
            }
            Said::Burst(burst) => {
                self.sequence = None;
                let rate_hz = self.rate_of(burst.number);
                let row = line::Row::from_burst(&burst, rate_hz, &self.listener);
                self.row(&row.at_wrong_rate(self.clock.is_wrong()))
            }
            Said::ChirpFrame(frame) => self.frames.frame(&frame, self.style),
            Said::Found(found) => self.frames.target(&found, self.clock.is_wrong(), self.style),
            Said::Sum(sum) => self.below(sum.sequence, line::sum(&sum, self.style)),
            Said::Lines(lines) => {
                let tones = line::Lines::from_tones(&lines, self.rate_of(lines.sequence));
                self.below(lines.sequence, tones.written(self.style));
            }
            Said::Fundamental(found) => {
                let fundamental = Fundamental::from_harmonic(&found, self.rate_of(found.sequence));
                self.below(found.sequence, fundamental.written(self.style));
            }
            Said::Boot(boot) => self.note(&line::boot(&boot)),
            Said::Raw(raw) => {
                // What a block is, only the settings say: pieces before them are asked for again.
                let length = self.scale.known().map(|known| known.bytes());
                if let (Some(capture), Some(length)) = (&mut self.capture, length) {
                    capture.push(&raw, length)?;
                }
            }
            Said::Status(status) if self.style == Style::Jsonl => {
                print_line(&line::status(&status))
            }
            Said::Follow(follow) if self.style == Style::Jsonl => {
                let rate_hz = self.rate_of(follow.sequence);
                line::follow(&follow, rate_hz).iter().for_each(|line| print_line(line))
            }
            Said::Status(_) | Said::Answer(..) | Said::Follow(_) => {}
        }
        Ok(())
    }

    fn rate_of(&self, sequence: u32) -> Option<f64> {
        self.scale.rate_of(sequence, &self.listener)
    }

    fn row(&mut self, row: &line::Row) {
        match self.style {
            Style::Jsonl => print_line(&row.json()),
            Style::Teleplot => row.teleplot().iter().for_each(|line| print_line(line)),
            Style::Csv => {
                if !std::mem::replace(&mut self.header, true) {
                    print_line(line::CSV);
                }
                print_line(&row.csv());
            }
            Style::Table => {
                let now = Instant::now();
                let quick = Duration::from_millis(100);
                let busy = self.shown.is_some_and(|shown| now - shown < quick);
                if busy && std::io::stdout().is_terminal() {
                    return;
                }
                self.shown = Some(now);
                self.sequence = Some(row.sequence());
                if self.heading.replace(row.knows_rate()) != Some(row.knows_rate()) {
                    print_line(line::table_heading(row.knows_rate()));
                }
                print_line(&row.table());
            }
        }
    }

    /// The lines below the row of a block.
    fn below(&mut self, sequence: u32, written: Vec<String>) {
        let shown = match self.style {
            Style::Csv => self.header,
            Style::Table => self.sequence == Some(sequence),
            Style::Jsonl | Style::Teleplot => true,
        };
        if shown {
            written.iter().for_each(|line| print_line(line));
        }
    }

    /// A line for people, next to the output for programs.
    fn note(&self, text: &str) {
        if self.style == Style::Table && !self.quiet {
            print_line(text);
        } else {
            eprintln!("{text}");
        }
    }

    fn finish(&self) {
        let Listener { records, missing, lost, bad, .. } = self.listener;
        match self.style {
            _ if self.quiet => {}
            Style::Jsonl => {
                let error = self.clock.error();
                print_line(
                    &serde_json::json!({
                        "summary": true, "records": records, "missing": missing,
                        "missing_lost": lost, "bad_frames": bad,
                        "rate_error_ppm": error.map(|error| error.ppm),
                        "sigma_rate_error_ppm": error.map(|error| error.sigma_ppm),
                    })
                    .to_string(),
                );
            }
            _ => {
                let whose = if missing > 0 {
                    format!(" ({lost} lost by the board, the others left out)")
                } else {
                    String::new()
                };
                self.note(&format!(
                    "{records} records, {missing} blocks between them without one{whose}, {bad} bad frames"
                ));
                if let Some(error) = self.clock.error() {
                    self.note(&format!(
                        "the sample clock is off by {:+.1} ± {:.1} ppm of the stated rate, by this machine's clock in {:.0} s",
                        error.ppm, error.sigma_ppm, error.seconds
                    ));
                }
            }
        }
    }
}

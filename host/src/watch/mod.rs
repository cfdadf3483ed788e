//! `cargo watch-device`: what an instrument measures, live, recorded or replayed; and orders to it.

pub mod line;
pub mod orders;
pub mod port;
pub mod settings;

use crate::cli::print_line;
use crate::device::{Blocks, Listener, Said};
use clap::Parser;
use line::Scale;
use orders::Orders;
use port::{Piece, Source};
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Shows what a device measures: a table, or lines for programs.
#[derive(Parser, Debug)]
#[command(name = "cargo watch-device", version)]
pub struct Options {
    /// The device's serial port (/dev/ttyACM0), or - for its bytes on stdin
    #[arg(required_unless_present = "replay", conflicts_with = "replay")]
    port: Option<String>,
    /// Comma-separated values with a header
    #[arg(long, group = "style")]
    csv: bool,
    /// One JSON object a line
    #[arg(long, group = "style")]
    jsonl: bool,
    /// Lines for the plotter Teleplot (and Serial Studio): >name:value
    #[arg(long, group = "style")]
    teleplot: bool,
    /// Keeps every byte received in a file
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Reads a recorded file instead of a port
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    /// Samples per second, where the device does not tell
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Ends after so many measurements
    #[arg(long, value_name = "COUNT")]
    count: Option<u64>,
    #[command(flatten)]
    orders: Orders,
}

/// Why watching ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum WatchError {
    /// A file or port.
    Io {
        /// Which.
        what: String,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Orders need a port.
    Orders,
    /// The settings' file.
    Settings(String),
    /// The device refused.
    Refused(picket_wire::command::Refusal),
}

impl fmt::Display for WatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WatchError::Io { what, source } => write!(f, "{what}: {source}"),
            WatchError::Orders => {
                f.write_str("orders need a port: neither stdin nor a file listens")
            }
            WatchError::Settings(what) => f.write_str(what),
            WatchError::Refused(refusal) => write!(f, "the device refuses: {refusal}"),
        }
    }
}

impl std::error::Error for WatchError {}

fn io(what: impl fmt::Display) -> impl FnOnce(std::io::Error) -> WatchError {
    move |source| WatchError::Io { what: what.to_string(), source }
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
    let mut source = Source::open(options.port.as_deref(), options.replay.as_deref())?;
    if options.orders.any() && !source.listens() {
        return Err(WatchError::Orders);
    }
    let record = options
        .record
        .as_ref()
        .map(|path| File::create(path).map(BufWriter::new).map_err(io(path.display())));
    let mut record = record.transpose()?;
    let mut watch = Watch::new(style, options);
    let mut orders = options.orders.prepare()?;
    let mut end = Ok(());
    loop {
        let bytes = match source.piece()? {
            Piece::End => break,
            Piece::Opened => {
                orders.ask(&mut source)?;
                continue;
            }
            Piece::Bytes(bytes) => bytes,
        };
        if let Some(file) = &mut record {
            file.write_all(&bytes).map_err(io("the recording"))?;
        }
        for said in watch.listener.read(&bytes) {
            match orders.hear(&said, &mut source) {
                Ok(()) => watch.show(said)?,
                Err(error) => end = Err(error),
            }
        }
        let enough = options.count.is_some_and(|count| watch.listener.records >= count);
        if enough || end.is_err() || (orders.done() && !watch.capturing()) {
            break;
        }
    }
    if let Some(file) = &mut record {
        file.flush().map_err(io("the recording"))?;
    }
    watch.finish();
    end.map(|()| ExitCode::SUCCESS)
}

/// What is shown, and how far.
struct Watch {
    style: Style,
    listener: Listener,
    scale: Scale,
    header: bool,
    /// The last row for people: not more than they can read.
    shown: Option<Instant>,
    blocks: Blocks,
    capture: Option<(BufWriter<File>, u64)>,
    capture_error: Option<WatchError>,
}

impl Watch {
    fn new(style: Style, options: &Options) -> Self {
        let (capture, capture_error) = match options.orders.capture() {
            None => (None, None),
            Some((blocks, path)) => match File::create(path) {
                Ok(file) => (Some((BufWriter::new(file), blocks.into())), None),
                Err(source) => (None, Some(io(path.display())(source))),
            },
        };
        Self {
            style,
            listener: Listener::default(),
            scale: Scale { rate_hz: options.rate, ..Scale::default() },
            header: false,
            shown: None,
            blocks: Blocks::default(),
            capture,
            capture_error,
        }
    }

    fn capturing(&self) -> bool {
        self.capture.as_ref().is_some_and(|(_, left)| *left > 0)
    }

    fn show(&mut self, said: Said) -> Result<(), WatchError> {
        if let Some(error) = self.capture_error.take() {
            return Err(error);
        }
        match said {
            Said::Telemetry(record) => {
                self.row(&line::Row::of(&record, &self.scale, &self.listener))
            }
            Said::Boot(boot) => {
                self.scale.n = Some(boot.n as usize);
                self.note(&line::boot(&boot));
            }
            Said::Answer(_, Ok(body)) => {
                if let Some((settings, n)) = settings::of_answer(&body) {
                    self.scale = Scale {
                        rate_hz: Some(settings.config.rate_hz),
                        n: Some(n),
                        iq: settings.iq,
                    };
                }
            }
            Said::Raw(raw) => {
                let length = self.scale.n.unwrap_or(1024) * if self.scale.iq { 4 } else { 2 };
                if let Some((_, bytes)) = self.blocks.push(&raw, length)
                    && let Some((file, left)) = &mut self.capture
                {
                    file.write_all(&bytes).map_err(io("the capture"))?;
                    file.flush().map_err(io("the capture"))?;
                    *left = left.saturating_sub(1);
                }
            }
            Said::Status(status) if self.style == Style::Jsonl => {
                print_line(&line::status(&status))
            }
            Said::Follow(follow) if self.style == Style::Jsonl => {
                line::follow(&follow, &self.scale).iter().for_each(|line| print_line(line))
            }
            Said::Status(_) | Said::Answer(..) | Said::Follow(_) => {}
        }
        Ok(())
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
                if !std::mem::replace(&mut self.header, true) {
                    print_line(line::TABLE);
                }
                print_line(&row.table());
            }
        }
    }

    /// A line for people, beside what is for programs.
    fn note(&self, text: &str) {
        if self.style == Style::Table {
            print_line(text);
        } else {
            eprintln!("{text}");
        }
    }

    fn finish(&self) {
        let Listener { records, missing, bad, .. } = self.listener;
        match self.style {
            Style::Jsonl => print_line(&format!(
                r#"{{"summary":true,"records":{records},"missing":{missing},"bad_frames":{bad}}}"#
            )),
            _ => self.note(&format!(
                "{records} records, {missing} blocks between them without one, {bad} bad frames"
            )),
        }
    }
}

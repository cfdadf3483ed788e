//! `picket calibrate`: the error of a board's sample clock, from a reference of known frequency at its input; or the phase at 0 m and the
//! range's offset of a radar, from a target at a known distance.

mod clock;
mod error;
mod range;

use crate::analyze::known;
use crate::cli;
use crate::device::{Listener, Said};
use crate::output::Output;
use crate::progress;
use crate::watch::WatchError;
use crate::watch::orders::Pending;
use crate::watch::port::{Piece, Source};
use crate::watch::{ports, settings};
use clap::Args;
pub use error::CalibrateError;
use picket_wire::boot::{Boot, Clock};
use picket_wire::command::Command;
use picket_wire::settings::Settings;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Measures the clock error of a board by a reference at its input (--reference), or a radar's phase at 0 m and its range's offset by a target at
/// a known distance (--range), and prints the settings that correct them.
#[derive(Args, Debug)]
pub struct Options {
    /// The board's serial port (/dev/ttyACM0); without a port the ports are listed
    #[arg(conflicts_with = "replay")]
    port: Option<String>,
    /// The frequency of the sine at the board's input, known better than the board's clock error
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, required_unless_present = "range")]
    reference: Option<f64>,
    /// The distance of the strongest target, which rests, m, with one standard deviation behind a colon: 1.000:0.0001
    #[arg(long, value_name = "M[:SIGMA]", value_parser = known::parse, conflicts_with = "reference")]
    range: Option<(f64, f64)>,
    /// What --to wrote at another distance: gives the slope of the sweep as well
    #[arg(long, value_name = "FILE", requires = "range", conflicts_with = "reference")]
    first: Option<PathBuf>,
    /// Writes the calibration of --range into a file, for analyze --calibration
    #[arg(long, value_name = "FILE", requires = "range", conflicts_with = "reference")]
    to: Option<PathBuf>,
    /// The temperature of the radar, degrees Celsius, which stands beside the calibration: the phase at 0 m changes with it
    #[arg(long, value_name = "C", value_parser = cli::number, allow_negative_numbers = true, requires = "range", conflicts_with = "reference")]
    celsius: Option<f64>,
    /// Duration of the measurement, s
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = cli::positive)]
    seconds: f64,
    /// Sends the new clock_ppm, or range_offset_m and range_slope, to the board, which stores it
    #[arg(long, conflicts_with = "replay")]
    save: bool,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// Reads a recording of picket watch --record instead of a port
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// Measures, prints the result, and saves it on request.
pub fn run(options: &Options) -> Result<ExitCode, CalibrateError> {
    if options.port.is_none() && options.replay.is_none() {
        let (lines, first) = ports::list();
        lines.iter().for_each(|line| eprintln!("{line}"));
        let wanted = if options.range.is_some() { "--range M" } else { "--reference HZ" };
        return Err(CalibrateError::Nameless(first, wanted));
    }
    if let Some(file) = &options.to {
        let read = [&options.replay, &options.first].into_iter().flatten();
        let read: Vec<&Path> = read.map(PathBuf::as_path).collect();
        options.output.check(file, &read).map_err(CalibrateError::Line)?;
    }
    let source = Source::open(options.port.as_deref(), options.replay.as_deref())?;
    if options.save && !source.listens() {
        return Err(WatchError::Orders.into());
    }
    let talk = &mut Talk::new(source);
    match (options.range, options.reference) {
        (Some(range), _) => range::run(talk, options, range),
        (_, Some(reference_hz)) => clock::run(talk, options, reference_hz),
        (None, None) => Ok(()),
    }?;
    Ok(ExitCode::SUCCESS)
}

/// A board, or its recording.
struct Talk {
    source: Source,
    listener: Listener,
    orders: Pending,
    /// A frame was understood.
    heard: bool,
    bytes: u64,
    /// The board's clock, if it reports it.
    clock: Option<Clock>,
}

impl Talk {
    fn new(source: Source) -> Self {
        let orders = Pending::of([Command::Identify, Command::GetSettings]);
        Self { source, listener: Listener::default(), orders, heard: false, bytes: 0, clock: None }
    }

    /// The next message; nothing for a moment without one, `None` at the end of a recording.
    fn next(&mut self) -> Result<Option<Vec<Said>>, WatchError> {
        let bytes = match self.source.piece()? {
            Piece::End => return Ok(None),
            Piece::Opened => {
                self.orders.ask(&mut self.source)?;
                return Ok(Some(Vec::new()));
            }
            Piece::Bytes(bytes) => bytes,
        };
        self.bytes += bytes.len() as u64;
        let said = self.listener.read(&bytes);
        self.heard |= !said.is_empty();
        for said in &said {
            self.orders.hear(said, &mut self.source)?;
            match said {
                Said::Boot(boot) => self.clock = Some(boot.clock),
                Said::Answer(answer, Ok(body)) if answer.command == Command::Identify.number() => {
                    self.clock = Boot::from_bytes(body).ok().map(|boot| boot.clock).or(self.clock);
                }
                _ => {}
            }
        }
        self.orders.again(&mut self.source, self.heard, self.bytes)?;
        Ok(Some(said))
    }

    /// The settings that a board uses.
    fn settings(&mut self) -> Result<Option<(Settings, usize)>, WatchError> {
        while let Some(said) = self.next()? {
            if let Some(known) = said.iter().find_map(told) {
                return Ok(Some(known));
            }
        }
        Ok(None)
    }

    /// Sends settings to the board, sees that it uses them, and has it keep them on request.
    fn send(&mut self, wanted: &Settings, n: usize, save: bool) -> Result<(), CalibrateError> {
        self.orders.add(Command::SetSettings(*wanted, n), &mut self.source);
        self.orders.add(Command::GetSettings, &mut self.source);
        let mut asked = false;
        while let Some(said) = self.next()? {
            for said in said {
                let Some((settings, _)) = told(&said) else { continue };
                if (settings.calibration, settings.most) != (wanted.calibration, wanted.most) {
                    return Err(CalibrateError::Another(settings.calibration.clock_ppm));
                }
                if !std::mem::replace(&mut asked, true) && save {
                    self.orders.add(Command::Save, &mut self.source);
                }
            }
            if asked && self.orders.done() {
                return Ok(());
            }
        }
        Ok(())
    }
}

/// The settings that a board uses, if this message has them.
fn told(said: &Said) -> Option<(Settings, usize)> {
    let Said::Answer(answer, Ok(body)) = said else { return None };
    let asked = answer.command == Command::GetSettings.number();
    asked.then(|| settings::from_answer(body)).flatten()
}

/// A board that was listened to, by which settings.
#[derive(Clone, Copy, Debug)]
struct Heard {
    settings: Settings,
    n: usize,
    /// The board's clock, if it reports it.
    clock: Option<Clock>,
    seconds: f64,
}

impl Heard {
    /// Whether a record of this sample rate is of these settings.
    fn is_of_it(&self, rate_hz: f64) -> bool {
        (rate_hz / self.settings.config.rate_hz - 1.0).abs() < 1e-9
    }
}

/// Listens to the board for the given time. `suits` is whether settings can be used; `take` takes what is said, and `None` where all before
/// that is of other settings.
fn collect(
    talk: &mut Talk,
    options: &Options,
    suits: &dyn Fn(&Settings) -> Result<(), CalibrateError>,
    take: &mut dyn FnMut(Option<&Said>),
) -> Result<Heard, CalibrateError> {
    let live = talk.source.listens();
    let bar = progress::bar(options.seconds.ceil() as u64, "s");
    let mut known = None;
    let (mut since, mut first, mut passed) = (Instant::now(), None, 0.0);
    let mut seconds: f64 = 0.0;
    while let Some(said) = talk.next()? {
        for said in said {
            let stamp = match &said {
                // Other settings may be in use from here on.
                Said::Boot(_) => {
                    (known, first) = (None, None);
                    take(None);
                    talk.orders.renew(&mut talk.source);
                    None
                }
                Said::Telemetry(record) => {
                    Some((record.measurement.stamp, record.measurement.tone.rate_hz))
                }
                Said::ChirpFrame(frame) => Some((frame.stamp, frame.rate_hz)),
                _ => None,
            };
            if let Some((stamp, rate_hz)) = stamp.filter(|_| !live || known.is_some()) {
                let first = *first.get_or_insert(stamp.clock);
                passed = stamp.clock.wrapping_sub(first) as f64 / rate_hz.max(1e-6);
                if !live {
                    seconds = passed;
                }
            }
            if if live { known.is_some() } else { passed <= options.seconds } {
                take(Some(&said));
            }
            if let Some((settings, n)) = told(&said) {
                suits(&settings)?;
                if known.replace((settings, n)).is_none() {
                    since = Instant::now();
                }
            }
        }
        if live {
            seconds = known.map_or(0.0, |_| since.elapsed().as_secs_f64());
        }
        bar.set_position(seconds as u64);
        if live && seconds >= options.seconds {
            break;
        }
    }
    bar.finish_and_clear();
    let Some((settings, n)) = known else {
        let name = options.replay.as_ref().map(|path| path.display().to_string());
        let name = name.unwrap_or_else(|| "the input".into());
        return Err(match talk.heard {
            true => CalibrateError::NoSettings(name),
            false => WatchError::Nothing(name).into(),
        });
    };
    let seconds = seconds.min(options.seconds);
    Ok(Heard { settings, n, clock: talk.clock, seconds })
}

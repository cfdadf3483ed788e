//! `picket calibrate`: the error of a board's sample clock, from a reference of known frequency at its input.

mod error;

use crate::cli::{self, decimals, print_line};
use crate::device::{Listener, Said};
use crate::progress;
use crate::watch::WatchError;
use crate::watch::orders::Pending;
use crate::watch::port::{Piece, Source};
use crate::watch::{ports, settings};
use clap::Args;
pub use error::CalibrateError;
use picket_dsp::config::Scene;
use picket_dsp::tone::{Tone, Usable};
use picket_wire::boot::{Boot, Clock};
use picket_wire::command::Command;
use picket_wire::settings::{Calibration, Mode, Settings};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Measures the clock error of a board by a reference at its input, and prints the setting `clock_ppm` that corrects it.
#[derive(Args, Debug)]
pub struct Options {
    /// The board's serial port (/dev/ttyACM0); without a port the ports are listed
    #[arg(conflicts_with = "replay")]
    port: Option<String>,
    /// The frequency of the sine at the board's input, known better than the board's clock error
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz)]
    reference: f64,
    /// Duration of the measurement, s
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = cli::positive)]
    seconds: f64,
    /// Sends the new clock_ppm to the board, which stores it
    #[arg(long, conflicts_with = "replay")]
    save: bool,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// Reads a recording of picket watch --record instead of a port
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
}

/// Measures, prints the result, and saves it on request.
pub fn run(options: &Options) -> Result<ExitCode, CalibrateError> {
    if options.port.is_none() && options.replay.is_none() {
        let (lines, first) = ports::list();
        lines.iter().for_each(|line| eprintln!("{line}"));
        return Err(CalibrateError::Nameless(first));
    }
    let source = Source::open(options.port.as_deref(), options.replay.as_deref())?;
    if options.save && !source.listens() {
        return Err(WatchError::Orders.into());
    }
    let mut talk = Talk::new(source);
    let collected = collect(&mut talk, options)?;
    let Collected { settings, n, clock, .. } = collected;
    let calibrated = Calibrated::of(&collected, options.reference)?;
    if clock.is_some_and(|clock| clock != Clock::External) {
        eprintln!(
            "the board runs by its internal oscillator, whose rate changes with temperature and supply: this correction holds only as long as they do"
        );
    }
    if !options.json {
        calibrated.lines().iter().for_each(|line| print_line(line));
    }
    if options.save {
        save(&mut talk, &settings::with_clock(&settings, calibrated.after_ppm), n)?;
    }
    match (options.json, options.save) {
        (true, _) => print_line(&calibrated.json(clock, options.save)),
        (_, true) => print_line("set and saved"),
        _ if talk.source.listens() => print_line("--save sets it and keeps it over a reset"),
        _ => {}
    }
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
}

impl Talk {
    fn new(source: Source) -> Self {
        let orders = Pending::of([Command::Identify, Command::GetSettings]);
        Self { source, listener: Listener::default(), orders, heard: false, bytes: 0 }
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
        }
        self.orders.again(&mut self.source, self.heard, self.bytes)?;
        Ok(Some(said))
    }
}

/// The settings that a board uses, if this message has them.
fn told(said: &Said) -> Option<(Settings, usize)> {
    let Said::Answer(answer, Ok(body)) = said else { return None };
    let asked = answer.command == Command::GetSettings.number();
    asked.then(|| settings::from_answer(body)).flatten()
}

/// What was measured, by which settings.
#[derive(Clone, Debug)]
struct Collected {
    settings: Settings,
    n: usize,
    /// The board's clock, if it reports it.
    clock: Option<Clock>,
    /// The tones of all records.
    tones: Vec<Tone>,
    seconds: f64,
}

/// Listens to the board for the given time.
fn collect(talk: &mut Talk, options: &Options) -> Result<Collected, CalibrateError> {
    let live = talk.source.listens();
    let bar = progress::bar(options.seconds.ceil() as u64, "s");
    let (mut known, mut clock, mut tones) = (None, None, Vec::new());
    let (mut since, mut first) = (Instant::now(), None);
    let mut seconds: f64 = 0.0;
    while let Some(said) = talk.next()? {
        for said in said {
            match &said {
                // Other settings may be in use from here on.
                Said::Boot(boot) => {
                    (known, clock, first) = (None, Some(boot.clock), None);
                    tones.clear();
                    talk.orders.renew(&mut talk.source);
                }
                Said::Answer(answer, Ok(body)) if answer.command == Command::Identify.number() => {
                    clock = Boot::from_bytes(body).ok().map(|boot| boot.clock).or(clock);
                }
                Said::Telemetry(record) if !live || known.is_some() => {
                    let (tone, stamp) = (record.measurement.tone, record.measurement.stamp);
                    let first = *first.get_or_insert(stamp.clock);
                    let passed = stamp.clock.wrapping_sub(first) as f64 / tone.rate_hz.max(1e-6);
                    if !live {
                        seconds = passed;
                    }
                    if live || passed <= options.seconds {
                        tones.push(tone);
                    }
                }
                _ => {}
            }
            if let Some((settings, n)) = told(&said) {
                suits(&settings, options.reference)?;
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
    let rate_hz = settings.config.rate_hz;
    // A record that was on its way is of the settings before.
    tones.retain(|tone| (tone.rate_hz / rate_hz - 1.0).abs() < 1e-9);
    let seconds = seconds.min(options.seconds);
    Ok(Collected { settings, n, clock, tones, seconds })
}

/// Whether a board with these settings measures the reference.
fn suits(settings: &Settings, reference_hz: f64) -> Result<(), CalibrateError> {
    let config = &settings.config;
    if matches!(config.scene, Scene::Chirp(_)) {
        return Err(CalibrateError::Chirp);
    }
    if matches!(settings.mode, Mode::Bursts(_)) {
        return Err(CalibrateError::Bursts);
    }
    if !settings.start {
        return Err(CalibrateError::Stopped);
    }
    let rate_hz = config.rate_hz;
    if reference_hz >= rate_hz / 2.0 {
        return Err(CalibrateError::Beyond { reference_hz, rate_hz });
    }
    match config.band_hz {
        Some((low, high)) if settings.order() == 0 && !(low..=high).contains(&reference_hz) => {
            Err(CalibrateError::Band { reference_hz, low, high })
        }
        _ => Ok(()),
    }
}

/// What comes out.
#[derive(Clone, Copy, Debug)]
struct Calibrated {
    reference_hz: f64,
    /// The weighted mean of what the board reads, and its standard deviation.
    mean_hz: f64,
    sigma_hz: f64,
    /// Records that were used, and those that were not.
    records: usize,
    left_out: usize,
    seconds: f64,
    /// How many times as wide as their sigmas the records scatter, if there are two or more.
    scatter: Option<f64>,
    agrees: bool,
    before_ppm: f32,
    after_ppm: f64,
    sigma_ppm: f64,
}

/// The tone's distance from the reference, as a share of it: a board's clock is off by at most the half of it before the correction, and
/// after it.
const REACH: f64 = 2.1e-6 * Calibration::MOST_PPM as f64;
/// Scatter and sigmas agree if they differ by less than this factor, or by less than this many deviations of the scatter itself.
const FACTOR: f64 = 1.2;
const DEVIATIONS: f64 = 4.0;

impl Calibrated {
    fn of(collected: &Collected, reference_hz: f64) -> Result<Self, CalibrateError> {
        let Collected { settings, ref tones, seconds, clock, n } = *collected;
        if tones.is_empty() {
            let block = n as f64 / settings.config.rate_hz;
            return Err(CalibrateError::Silent { seconds, block });
        }
        let usable = |tone: &&Tone| tone.verdict.usable() <= Usable::WithinSigma;
        let readings: Vec<(f64, f64)> = tones
            .iter()
            .filter(usable)
            .map(|tone| (tone.hertz(), tone.sigma_hertz()))
            .filter(|(hertz, sigma)| *hertz != 0.0 && *sigma > 0.0 && sigma.is_finite())
            .collect();
        if readings.is_empty() {
            let most = tones.iter().map(|tone| tone.verdict);
            let count = |verdict| tones.iter().filter(|tone| tone.verdict == verdict).count();
            let verdict = most.max_by_key(|&verdict| count(verdict)).unwrap_or_default();
            return Err(CalibrateError::Unusable { records: tones.len(), verdict });
        }
        let reach = |sigma: f64| REACH * reference_hz + 5.0 * sigma;
        let near = |&&(hertz, sigma): &&(f64, f64)| (hertz - reference_hz).abs() <= reach(sigma);
        let used: Vec<(f64, f64)> = readings.iter().filter(near).copied().collect();
        let internal = clock.is_some_and(|clock| clock != Clock::External);
        let off = |hertz, ppm| CalibrateError::Off { hertz, reference_hz, ppm, internal };
        let pace = settings.calibration.true_hz(1.0);
        // The clock's error with which the board would read the reference.
        let ppm_of = |hertz: f64| (pace * reference_hz / hertz - 1.0) * 1e6;
        // A tone or two of others between those of the reference do no harm.
        if 2 * used.len() < readings.len() {
            let mut all = readings;
            all.sort_by(|(one, _), (other, _)| one.total_cmp(other));
            let (median, _) = all[all.len() / 2];
            return Err(off(median, ppm_of(median)));
        }
        let weight = |sigma: f64| 1.0 / (sigma * sigma);
        let weights: f64 = used.iter().map(|&(_, sigma)| weight(sigma)).sum();
        // Of differences, so that no digit is lost.
        let sum: f64 =
            used.iter().map(|&(hertz, sigma)| weight(sigma) * (hertz - reference_hz)).sum();
        let mean_hz = reference_hz + sum / weights;
        let squares: f64 =
            used.iter().map(|&(hertz, sigma)| weight(sigma) * (hertz - mean_hz).powi(2)).sum();
        let degrees = used.len() as f64 - 1.0;
        let scatter = (degrees > 0.0).then(|| (squares / degrees).sqrt());
        // Wilson and Hilferty: the cube root of a chi-square is nearly normal.
        let part = 2.0 / (9.0 * degrees);
        let deviations =
            scatter.map_or(0.0, |scatter| (scatter.powf(2.0 / 3.0) - 1.0 + part) / part.sqrt());
        let right = scatter.is_none_or(|scatter| (1.0 / FACTOR..=FACTOR).contains(&scatter));
        // A sigma that covers an internal oscillator says nothing of the scatter, which alone tells the mean's sigma.
        let agrees = internal || right || deviations.abs() <= DEVIATIONS;
        // Where the records scatter more, so does their mean.
        let least = if agrees { 1.0 } else { scatter.unwrap_or(1.0).max(1.0) };
        let wider = if internal { scatter.unwrap_or(1.0) } else { least };
        let sigma_hz = wider / weights.sqrt();
        let after_ppm = ppm_of(mean_hz);
        if after_ppm.abs() > f64::from(Calibration::MOST_PPM) {
            return Err(off(mean_hz, after_ppm));
        }
        Ok(Self {
            reference_hz,
            mean_hz,
            sigma_hz,
            records: used.len(),
            left_out: tones.len() - used.len(),
            seconds,
            scatter: scatter.filter(|_| !internal),
            agrees,
            before_ppm: settings.calibration.clock_ppm,
            after_ppm,
            sigma_ppm: sigma_hz / mean_hz * pace * 1e6,
        })
    }

    /// For people.
    fn lines(&self) -> Vec<String> {
        let Self { reference_hz, mean_hz, sigma_hz, records, left_out, seconds, .. } = *self;
        let (fine, ppm) = (decimals(sigma_hz), decimals(self.sigma_ppm));
        let left = if left_out == 0 { String::new() } else { format!(", {left_out} left out") };
        let mean = format!(
            "{records} records in {seconds:.1} s{left}: {mean_hz:.fine$} Hz ± {sigma_hz:.fine$} Hz where the reference is {reference_hz} Hz"
        );
        let scatter = self.scatter.map(|scatter| match (self.agrees, scatter > 1.0) {
            (true, _) => "their scatter agrees with their sigmas".to_owned(),
            (false, true) => format!(
                "they scatter {scatter:.1} times as wide as their sigmas, and the sigma above is widened by that: the reference or the clock wanders, or something disturbs the tone"
            ),
            (false, false) => format!(
                "they scatter {scatter:.2} times as wide as their sigmas, which are too wide here"
            ),
        });
        let result = format!(
            "clock_ppm {} before, {:.ppm$} ± {:.ppm$} now; the reference's own error adds to that",
            self.before_ppm, self.after_ppm, self.sigma_ppm
        );
        [Some(mean), scatter, Some(result)].into_iter().flatten().collect()
    }

    /// For programs.
    fn json(&self, clock: Option<Clock>, saved: bool) -> String {
        serde_json::json!({
            "reference_hz": self.reference_hz, "mean_hz": self.mean_hz, "sigma_hz": self.sigma_hz,
            "records": self.records, "left_out": self.left_out, "seconds": self.seconds,
            "scatter": self.scatter, "scatter_agrees": self.agrees,
            "clock_ppm_before": f64::from(self.before_ppm), "clock_ppm": self.after_ppm,
            "sigma_ppm": self.sigma_ppm, "clock": clock.map(Clock::name), "saved": saved,
        })
        .to_string()
    }
}

/// Sends settings to the board, sees that it uses them, and has it keep them.
fn save(talk: &mut Talk, wanted: &Settings, n: usize) -> Result<(), CalibrateError> {
    talk.orders.add(Command::SetSettings(*wanted, n), &mut talk.source);
    talk.orders.add(Command::GetSettings, &mut talk.source);
    let mut asked = false;
    while let Some(said) = talk.next()? {
        for said in said {
            let Some((settings, _)) = told(&said) else { continue };
            if settings.calibration != wanted.calibration {
                return Err(CalibrateError::Another(settings.calibration.clock_ppm));
            }
            if !std::mem::replace(&mut asked, true) {
                talk.orders.add(Command::Save, &mut talk.source);
            }
        }
        if asked && talk.orders.done() {
            return Ok(());
        }
    }
    Ok(())
}

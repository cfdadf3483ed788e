//! `picket analyze`: methods on a recording.

use super::accumulated::{self, Sum};
use super::bursts;
use super::carrier::Carrier;
use super::chirps::{self, Finding as Ranged};
use super::clock::Reference;
use super::cut::Cut;
use super::displacement::{self, Sensor};
use super::fundamental;
use super::input::Input;
use super::known;
use super::moved::Moved;
use super::radar::Radar;
use super::ramp::Chirps;
use super::ranges;
use super::repeats::Repeats;
use super::several::{self, Finding, Search, Sought};
use super::told::Told;
use super::{self as analyze, Analysis, Style};
use crate::arithmetic::Arithmetic;
use crate::follow::{self, Pursuit, Sighting};
use crate::output::Output;
use crate::recording;
use crate::survey::Survey;
use crate::{cli, estimator, progress, spectrogram};
use clap::Args;
use picket_dsp::Shape;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier as Width;
use picket_dsp::config::{Config, Following};
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::verdict::Verdict;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Measures the strongest tone in each block of a recording. Without options: says what is in it and how to measure it.
#[derive(Args, Debug)]
#[command(after_help = estimator::help())]
pub struct Options {
    #[command(flatten)]
    input: Input,
    /// Methods, separated by commas (listed below) [default: least squares]
    #[arg(long, conflicts_with = "chirp_s")]
    method: Option<String>,
    #[command(flatten)]
    chirps: Chirps,
    #[command(flatten)]
    told: Told,
    /// The recording is of a tone of this frequency: returns the clock error in ppm
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, conflicts_with_all = ["method", "chirp_s", "carrier_hz"])]
    reference: Option<f64>,
    /// Follow tones from block to block, as the firmware does
    #[arg(long, conflicts_with_all = ["method", "arith"])]
    track: bool,
    /// Draws into this file, SVG or PNG by its name: with --track the tracks over the spectrogram; without other options the answers of the
    /// proposed command with their sigmas, or the spectrum if there is no proposal
    #[arg(long, value_name = "FILE", value_parser = cli::picture)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
    /// Tones of a block, at most 1 to 4, each with amplitude and phase; with --track: followed at once [default: 1]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(1..=4), conflicts_with_all = ["method", "arith"])]
    most: Option<u8>,
    /// Finds one fundamental per block from its harmonics up to this order, 2 to 32; --band then limits the fundamental
    #[arg(long, value_name = "ORDER", value_parser = clap::value_parser!(u32).range(2..=32), conflicts_with_all = ["method", "arith", "most", "track", "carrier_hz"])]
    harmonics: Option<u32>,
    /// Measures bursts, as of particles in a laser-Doppler velocimeter: frequency, time, transit time and validation of each, and their mean
    /// weighted by the transit time. --n is the record of a burst, 3 to 20 times its standard deviation
    #[arg(long, conflicts_with_all = ["method", "arith", "most", "harmonics", "track", "hop"])]
    burst: bool,
    /// Adds the spectra of this many blocks, for echoes too weak for one: ten times as many show echoes 5 dB weaker
    #[arg(long, value_name = "BLOCKS", value_parser = clap::value_parser!(u32).range(1..=i64::from(picket_dsp::accumulate::MOST_BLOCKS)), conflicts_with_all = ["method", "arith", "most", "harmonics", "track", "burst"])]
    accumulate: Option<u32>,
    /// Rate at which the line moves during a sum, Hz per second
    #[arg(long, value_name = "HZ_PER_S", value_parser = cli::number, allow_negative_numbers = true, default_value_t = 0.0, requires = "accumulate")]
    drift: f64,
    /// Prints one JSON object per line
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Prints comma-separated values
    #[arg(long)]
    csv: bool,
}

/// Analyses the recording and prints what is found.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let style = match (options.json, options.csv) {
        (true, _) => Style::Json,
        (_, true) => Style::Csv,
        _ => Style::Text,
    };
    if let Some(picture) = &options.plot {
        options.output.check(picture, &[&options.input.file])?;
    }
    let cut = options.input.cut()?;
    let (read, reach, width) = (cut.read, cut.reach, cut.width);
    let others = options.most.is_some() && !options.track
        || options.harmonics.is_some()
        || options.burst
        || options.accumulate.is_some();
    if others && options.input.effort != Effort::default() {
        return Err("--effort is for the strongest tone of each block, and for --track".into());
    }
    if options.burst && width != Width::default() {
        return Err("--linewidth and --envelope are of longer tones than --burst measures".into());
    }
    if options.track {
        return track(options, cut, style);
    }
    if options.looks() {
        return look(options, read);
    }
    if options.plot.is_some() {
        return Err(
            "--plot draws tracks: add --track; or the spectrum: give FILE and no other option"
                .into(),
        );
    }
    if let Some(radar) = options.chirps.radar(&options.input) {
        if let Some(range) = options.told.known_m {
            let file = &options.input.file;
            if let Some(path) = &options.told.save {
                let first = options.told.first.iter();
                let read: Vec<&Path> = first.chain([file]).map(PathBuf::as_path).collect();
                options.output.check(path, &read)?;
            }
            let told = (&radar, &options.told);
            let (known, tally) = known::run(file, &cut, options.input.n, told, range)?;
            known::tell(&known, style, (options.told.save.as_deref(), options.output))?;
            tally.tell(cli::name(file), cut.codes);
            return Ok(ended(tally.left_out()));
        }
        if options.told.displacement {
            return way(options, cut, style, &Sensor::Chirps(radar));
        }
        return ranges(options, cut, style, &radar);
    }
    if let Some(carrier) = options.carrier().filter(|_| options.told.displacement) {
        return way(options, cut, style, &Sensor::Wave(carrier));
    }
    if options.burst {
        return burst(options, cut, style);
    }
    if let Some(blocks) = options.accumulate {
        return accumulate(options, cut, style, blocks);
    }
    let tones = options.most.map(|most| Sought::Tones(most.into()));
    if let Some(sought) = tones.or(options.harmonics.map(Sought::Harmonics)) {
        return several(options, cut, style, sought);
    }
    let analysis = Analysis {
        estimators: options
            .method
            .as_ref()
            .map(|names| estimator::parse(names, reach))
            .transpose()?,
        carrier: options.carrier(),
        ..options.input.analysis()?
    };
    let bar = progress::count("samples");
    let mut first = true;
    let (mut answers, mut unresolved) = (0_u64, 0);
    let mut reference = options.reference.map(Reference::new);
    let sink = |answer: analyze::Answer| {
        answers += 1;
        if let Some(reference) = &mut reference {
            reference.add(&answer);
        }
        unresolved += u64::from(answer.verdict == Verdict::Unresolved.name());
        // Only now is it sure that there is something to print.
        if std::mem::take(&mut first) {
            analyze::print_heading(style, options.chirps.carrier_hz.is_some(), &answer);
        }
        bar.suspend(|| analyze::print(&answer, style));
    };
    let summary = analyze::run(&options.input.file, &analysis, sink, |samples| bar.inc(samples));
    bar.finish_and_clear();
    let summary = summary?;
    // One in twenty.
    if unresolved * 20 > answers && analysis.effort != Effort::THREE {
        eprintln!("{unresolved} of {answers} are unresolved: --effort 3 fits what else is there");
    }
    if let Some(reference) = reference {
        reference.error()?.print(style);
    }
    if style == Style::Json {
        cli::print_line(&serde_json::to_string(&summary).unwrap_or_default());
    }
    Ok(ended(summary.skipped + summary.left_out))
}

/// Failure where something was left out.
fn ended(left_out: u64) -> ExitCode {
    if left_out == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

impl Options {
    /// The Doppler radar, if there is one.
    fn carrier(&self) -> Option<Carrier> {
        self.chirps.carrier_hz.map(|hz| Carrier { hz, mixing: self.chirps.mixing() })
    }

    /// True where nothing says how to measure: a first look is wanted.
    fn looks(&self) -> bool {
        let json = analyze::is_json(&self.input.file, self.input.format);
        let blocks = self.input.n.is_some() || self.input.hop.is_some() || self.input.skip > 0;
        let how = self.input.band.is_some()
            || self.method.is_some()
            || self.chirps.carrier_hz.is_some()
            || self.reference.is_some();
        let codes = self.input.bits != 16 || self.input.unsigned || self.input.k != 16;
        let numbers = self.input.arith != Arithmetic::default()
            || self.input.effort != Effort::default()
            || self.input.width() != Width::default()
            || self.input.false_alarm != Config::new(1.0, Codes::signed::<12>()).false_alarm;
        let several = self.most.is_some()
            || self.harmonics.is_some()
            || self.burst
            || self.accumulate.is_some();
        !(json || blocks || several || how || codes || numbers || self.json || self.csv)
    }
}

/// A first look at an unknown recording.
fn look(options: &Options, read: recording::Options) -> Result<ExitCode, String> {
    let survey = Survey::of(&options.input.file, read)?;
    if let Some(picture) = &options.plot {
        survey.draw(&options.input.file, read, (picture, options.output))?;
    }
    cli::print(&survey.text(&options.input.typed()));
    Ok(ExitCode::SUCCESS)
}

/// All the tones of each block, or its fundamental.
fn several(options: &Options, cut: Cut, style: Style, sought: Sought) -> Result<ExitCode, String> {
    let carrier = options.carrier();
    let search = Search { cut, false_alarm: options.input.false_alarm, carrier, sought };
    let bar = progress::count("samples");
    let heading = || match sought {
        Sought::Tones(_) => several::print_heading(style, carrier.is_some()),
        Sought::Harmonics(_) => fundamental::print_heading(style),
    };
    let mut none = true;
    let mut sink = |finding: &Finding| {
        if std::mem::take(&mut none) {
            heading();
        }
        bar.suspend(|| match finding {
            Finding::Tone(found) => several::print(found, style),
            Finding::Fundamental(fundamental) => fundamental.print(style),
        });
    };
    let file = &options.input.file;
    let done = several::run(file, &search, &mut sink, &mut |samples| bar.inc(samples));
    bar.finish_and_clear();
    let tally = done?;
    if none {
        heading();
        eprintln!("no tone in {} blocks", tally.blocks);
    }
    tally.tell(cli::name(file), cut.codes);
    Ok(ended(tally.left_out()))
}

/// Ranges and velocities, chirp by chirp or frame by frame.
fn ranges(options: &Options, cut: Cut, style: Style, radar: &Radar) -> Result<ExitCode, String> {
    let mut none = true;
    let file = &options.input.file;
    let mut sink = |found: &Ranged| {
        if std::mem::take(&mut none) {
            ranges::print_heading(found, style);
        }
        ranges::print(found, style);
    };
    let (mut cut, mut told) = (cut, options.told.clone());
    if let Some(found) = repeats(file, &cut, radar, &told)? {
        cut.skip += found.first;
        told.found = Some(found.period);
    }
    let (tally, framed) = chirps::run(file, &cut, options.input.n, radar, &told, &mut sink)?;
    if none && framed {
        let frames = tally.blocks;
        eprintln!(
            "no target in {frames} frames: is --chirp-s one ramp's? Of I/Q samples try the other --mixing (now {})",
            options.chirps.mixing().name()
        );
    } else if none {
        return Err(
            "no chirp has a target: is --skip at the first ramp, and --chirp-s one ramp's?".into(),
        );
    }
    tally.tell(cli::name(file), cut.codes);
    Ok(ended(tally.left_out()))
}

/// How the ramps repeat, where that is to be found.
fn repeats(file: &Path, cut: &Cut, radar: &Radar, told: &Told) -> Result<Option<Repeats>, String> {
    if told.trigger.is_none() && !told.find_ramps {
        return Ok(None);
    }
    let recording = recording::Recording::open(file, cut.read).map_err(|it| it.to_string())?;
    if !recording.knows_rate() {
        return Err("ranges need the sample rate: add --rate HZ".into());
    }
    let rate_hz = recording.rate_hz();
    let found = match told.trigger {
        Some(channel) => Repeats::by_trigger(file, cut, channel)?,
        None if radar.shape != Shape::Sawtooth => {
            return Err(
                "rising and falling ramps look alike: --find-ramps finds a sawtooth's, --trigger others".into(),
            );
        }
        None => Repeats::by_comb(file, cut, radar.chirp_s * rate_hz)?,
    };
    let ramps = radar.shape.segments().len();
    let all = ramps as f64 * radar.chirp_s * rate_hz;
    if found.period < all - 2.0 || ramps > 1 && found.period > all + 2.0 {
        return Err(format!(
            "chirps repeat each {:.1} samples, and {ramps} ramps of {} s take {all:.1}: {}",
            found.period,
            radar.chirp_s,
            if ramps > 1 {
                "these have to follow each other without a pause"
            } else {
                "is --chirp-s one ramp's?"
            }
        ));
    }
    found.tell(file, rate_hz);
    Ok(Some(found))
}

/// The way of the strongest target, and what swings in it.
fn way(options: &Options, cut: Cut, style: Style, sensor: &Sensor) -> Result<ExitCode, String> {
    let mut none = true;
    let file = &options.input.file;
    let mut sink = |moved: &Moved| {
        if std::mem::take(&mut none) {
            displacement::print_heading(style);
        }
        displacement::print(moved, style);
    };
    let told = (sensor, &options.told);
    let (tally, swings) = displacement::run(file, &cut, options.input.n, told, &mut sink)?;
    swings.iter().for_each(|swing| displacement::print_swing(swing, style));
    if none {
        return Err("no block has a tone: a way is that of the strongest target".into());
    }
    tally.tell(cli::name(file), cut.codes);
    Ok(ended(tally.left_out()))
}

/// Bursts, and their sums.
fn burst(options: &Options, cut: Cut, style: Style) -> Result<ExitCode, String> {
    let carrier = options.carrier();
    let bar = progress::count("samples");
    let mut none = true;
    let mut sink = |found: &bursts::Found| {
        if std::mem::take(&mut none) {
            bursts::print_heading(style, carrier.is_some());
        }
        bar.suspend(|| bursts::print(found, style));
    };
    let file = &options.input.file;
    let done = bursts::run(file, &cut, carrier, &mut sink, &mut |samples| bar.inc(samples));
    bar.finish_and_clear();
    let (summary, tally) = done?;
    if none {
        bursts::print_heading(style, carrier.is_some());
    }
    bursts::print_summary(&summary, style);
    tally.tell(cli::name(file), cut.codes);
    Ok(ended(tally.left_out()))
}

/// Sums of blocks.
fn accumulate(options: &Options, cut: Cut, style: Style, blocks: u32) -> Result<ExitCode, String> {
    let carrier = options.carrier();
    let (drift_hz_per_s, false_alarm) = (options.drift, options.input.false_alarm);
    let sum = Sum { cut, blocks, drift_hz_per_s, false_alarm, carrier };
    let bar = progress::count("samples");
    let mut none = true;
    let mut sink = |found: &accumulated::Found| {
        if std::mem::take(&mut none) {
            accumulated::print_heading(style, carrier.is_some());
        }
        bar.suspend(|| accumulated::print(found, style));
    };
    let file = &options.input.file;
    let done = accumulated::run(file, &sum, &mut sink, &mut |samples| bar.inc(samples));
    bar.finish_and_clear();
    let (left, tally) = done?;
    tally.tell(cli::name(file), cut.codes);
    if none {
        return Err(format!("the recording has {left} blocks, fewer than --accumulate {blocks}"));
    }
    if left > 0 {
        eprintln!("{left} blocks at the end are left: too few for another sum");
    }
    Ok(ended(tally.left_out()))
}

/// Tones followed from block to block.
fn track(options: &Options, cut: Cut, style: Style) -> Result<ExitCode, String> {
    if options.plot.is_some() && options.input.file.as_os_str() == "-" {
        return Err("--plot reads the recording twice: give a file, not -".into());
    }
    let following = Following { most: options.most.unwrap_or(1), ..Following::default() };
    let carrier = options.carrier();
    let pursuit = Pursuit { cut, following, effort: options.input.effort, carrier };
    let bar = progress::count("samples");
    let (mut blocks, mut sightings) = (0, Vec::new());
    let mut sink = |sighting: &Sighting| {
        if sightings.is_empty() {
            follow::print_heading(style, carrier.is_some());
        }
        sightings.push(*sighting);
        bar.suspend(|| follow::print(sighting, style));
    };
    let trails = follow::run(&options.input.file, &pursuit, &mut sink, &mut |samples| {
        blocks += 1;
        bar.inc(samples);
    });
    bar.finish_and_clear();
    let trails = trails?;
    if sightings.is_empty() {
        follow::print_heading(style, carrier.is_some());
        eprintln!("no tone was held in {blocks} blocks");
    }
    follow::print_trails(&trails, style);
    if let Some(picture) = &options.plot {
        let to = (picture.as_path(), options.output);
        spectrogram::draw(&options.input.file, &cut, &sightings, &trails, to)?;
    }
    Ok(ExitCode::SUCCESS)
}

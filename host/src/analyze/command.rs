//! `picket analyze`: methods on a recording.

use super::carrier::Carrier;
use super::cut::Cut;
use super::fundamental;
use super::input::Input;
use super::several::{self, Finding, Search, Sought};
use super::{self as analyze, Analysis, Style};
use crate::arithmetic::Arithmetic;
use crate::follow::{self, Pursuit, Sighting};
use crate::recording::{self, Format};
use crate::survey::Survey;
use crate::{cli, estimator, progress, spectrogram};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use picket::acquire::codes::Codes;
use picket::config::{Config, Following};
use picket::solve::chirp::Mixing;
use std::path::PathBuf;
use std::process::ExitCode;

/// Measures the strongest tone in each block of a recording.
#[derive(Args, Debug)]
#[command(after_help = estimator::help())]
pub struct Options {
    #[command(flatten)]
    input: Input,
    /// Methods, separated by commas (listed below) [default: least squares]
    #[arg(long)]
    method: Option<String>,
    /// Carrier of a Doppler radar, Hz: gives speeds
    #[arg(long, value_name = "F", value_parser = cli::positive, allow_negative_numbers = true)]
    carrier_hz: Option<f64>,
    /// Which signal an I/Q receiver conjugates before it multiplies: rx-conj-tx if an approaching target's shift is positive,
    /// tx-conj-rx if it is negative, or if I and Q are exchanged
    #[arg(long, value_name = "MIXING", value_parser = mixing(), default_value = Mixing::RxConjTx.name(), requires = "carrier_hz")]
    mixing: Mixing,
    /// Follow tones from block to block, as the firmware does
    #[arg(long, conflicts_with_all = ["method", "arith"])]
    track: bool,
    /// Draws the tracks over the spectrogram, or without --track the spectrum with its floor, into this file, SVG or PNG by its name
    #[arg(long, value_name = "FILE", value_parser = cli::picture)]
    plot: Option<PathBuf>,
    /// The most tones of a block, 1 to 4, each with amplitude and phase; with --track: followed at once [default: 1]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(1..=4), conflicts_with_all = ["method", "arith"])]
    most: Option<u8>,
    /// One fundamental a block from its harmonics up to this order, 2 to 32; --band is then the fundamental's
    #[arg(long, value_name = "ORDER", value_parser = clap::value_parser!(u32).range(2..=32), conflicts_with_all = ["method", "arith", "most", "track", "carrier_hz"])]
    harmonics: Option<u32>,
    /// The sigma of a target's acceleration, in bins per block squared, below which the filter does not go. A m/s^2 before a
    /// Doppler radar of L m wavelength are 2 A/L (hop/rate)^2 N/rate: at 24 GHz, 48 kHz and N = 4096 a car that brakes at
    /// 3 m/s^2 does 0.3, and 2 follows one that drives past
    #[arg(long, value_name = "BINS", default_value_t = 0.1, requires = "track")]
    acceleration: f32,
    /// One JSON object a line
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Comma-separated values
    #[arg(long)]
    csv: bool,
}

/// The names of the two ways to mix.
fn mixing() -> impl TypedValueParser<Value = Mixing> {
    let names = PossibleValuesParser::new(Mixing::ALL.map(Mixing::name));
    names.map(|name| Mixing::from_name(&name).unwrap_or_default())
}

/// Analyses the recording and prints what is found.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let (read, codes, reach) =
        (options.input.read()?, options.input.codes()?, options.input.reach()?);
    let style = match (options.json, options.csv) {
        (true, _) => Style::Json,
        (_, true) => Style::Csv,
        _ => Style::Text,
    };
    let n = options.input.n.unwrap_or(analyze::BLOCK);
    let hop = options.input.hop.unwrap_or(n);
    let (skip, band_hz) = (options.input.skip, options.input.band);
    let cut = Cut { read, n, hop, skip, band_hz, codes, reach };
    if options.track {
        return track(options, cut, style);
    }
    if options.looks() {
        return look(options, read);
    }
    if options.plot.is_some() {
        return Err(
            "--plot draws tracks: add --track; or the spectrum, where FILE is all that is given"
                .into(),
        );
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
        style,
        ..options.input.analysis()?
    };
    let bar = progress::count("samples");
    let mut first = true;
    let sink = |answer| {
        // Only now is it sure that there is something to print.
        if std::mem::take(&mut first) {
            analyze::print_heading(style, options.carrier_hz.is_some());
        }
        bar.suspend(|| analyze::print(&answer, style));
    };
    let summary = analyze::run(&options.input.file, &analysis, sink, |samples| bar.inc(samples));
    bar.finish_and_clear();
    let summary = summary?;
    if style == Style::Json {
        cli::print_line(&serde_json::to_string(&summary).unwrap_or_default());
    }
    Ok(if summary.skipped == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Options {
    /// The Doppler radar, if there is one.
    fn carrier(&self) -> Option<Carrier> {
        self.carrier_hz.map(|hz| Carrier { hz, mixing: self.mixing })
    }

    /// True where nothing says how to measure: a first look is wanted.
    fn looks(&self) -> bool {
        let json =
            self.input.format.or_else(|| Format::guess(&self.input.file)) == Some(Format::Json);
        let blocks = self.input.n.is_some() || self.input.hop.is_some() || self.input.skip > 0;
        let how = self.input.band.is_some() || self.method.is_some() || self.carrier_hz.is_some();
        let codes = self.input.bits != 16 || self.input.unsigned || self.input.k != 16;
        let numbers = self.input.arith != Arithmetic::F64
            || self.input.false_alarm != Config::new(1.0, Codes::signed::<12>()).false_alarm;
        let several = self.most.is_some() || self.harmonics.is_some();
        !(json || blocks || several || how || codes || numbers || self.json || self.csv)
    }
}

/// A first look at an unknown recording.
fn look(options: &Options, read: recording::Options) -> Result<ExitCode, String> {
    let survey = Survey::of(&options.input.file, read)?;
    if let Some(picture) = &options.plot {
        survey.draw(&options.input.file, picture)?;
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
    let (mut blocks, mut none) = (0, true);
    let mut sink = |finding: &Finding| {
        if std::mem::take(&mut none) {
            heading();
        }
        bar.suspend(|| match finding {
            Finding::Tone(found) => several::print(found, style),
            Finding::Fundamental(fundamental) => fundamental.print(style),
        });
    };
    let done = several::run(&options.input.file, &search, &mut sink, &mut |samples| {
        blocks += 1;
        bar.inc(samples);
    });
    bar.finish_and_clear();
    done?;
    if none {
        heading();
        eprintln!("no tone in {blocks} blocks");
    }
    Ok(ExitCode::SUCCESS)
}

/// Tones followed from block to block.
fn track(options: &Options, cut: Cut, style: Style) -> Result<ExitCode, String> {
    if options.plot.is_some() && options.input.file.as_os_str() == "-" {
        return Err("--plot reads the recording twice: give a file, not -".into());
    }
    let following = Following {
        acceleration_bins: options.acceleration,
        most: options.most.unwrap_or(1),
        ..Following::default()
    };
    let carrier = options.carrier();
    let pursuit = Pursuit { cut, following, carrier };
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
        spectrogram::draw(&options.input.file, &cut, &sightings, &trails, picture)?;
    }
    Ok(ExitCode::SUCCESS)
}

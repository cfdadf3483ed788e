//! A recording on the command line: how it is read, cut into blocks and measured.

use super::Analysis;
use super::cut::Cut;
use crate::arithmetic::Arithmetic;
use crate::recording::{self, Axes, Converter, Format};
use crate::{band, cli, estimator};
use clap::{Args, ValueEnum};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier as Width;
use picket_dsp::config::Config;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;
use std::path::PathBuf;

/// Which recording, and how it is read.
#[derive(Args, Debug)]
pub struct Input {
    /// The recording: wav, FLAC, SigMF, npy, npz, mat, csv, headerless numbers, or JSON lines; - for stdin
    pub file: PathBuf,
    /// Format [default: from the file's name and its first bytes]
    #[arg(long, value_enum)]
    pub format: Option<Format>,
    /// Samples per second, if the file does not state them; without a rate, frequencies are in cycles per sample
    #[arg(long, value_name = "HZ", allow_hyphen_values = true, value_parser = cli::hertz)]
    pub rate: Option<f64>,
    /// Samples in a block: 64, 128, ... 4096 [default: 1024; JSON: the whole record]
    #[arg(long, value_parser = cli::count::<{ 1 << 22 }>)]
    pub n: Option<usize>,
    /// Samples from one block's start to the next [default: N]
    #[arg(long, value_parser = cli::count::<{ 1 << 40 }>)]
    pub hop: Option<usize>,
    /// The channel or column, counted from 1; two, as in 2,3, are I and Q
    #[arg(long, visible_alias = "column", value_name = "C[,Q]", value_parser = channel)]
    pub channel: Option<(usize, Option<usize>)>,
    /// Commas in a csv file are decimal points, not separators
    #[arg(long)]
    pub decimal_comma: bool,
    /// Channels of headerless numbers, in turn; --channel chooses
    #[arg(long, value_name = "COUNT", value_parser = cli::count::<256>)]
    pub channels: Option<usize>,
    /// The axes of an array, of frame, chirp, rx, sample and iq, as in chirp,rx,sample; --channel selects a receiver
    #[arg(long, value_name = "SIDES")]
    pub axes: Option<Axes>,
    /// The part to read of a table whose rate changes, counted from 1 [default: the longest]
    #[arg(long, value_name = "PART", value_parser = cli::count::<64>)]
    pub part: Option<usize>,
    /// Samples to skip at the start
    #[arg(long, default_value_t = 0)]
    pub skip: u64,
    /// Takes two channels, or pairs of numbers, as I and Q
    #[arg(long)]
    pub iq: bool,
    /// Band to search, Hz, both ends included
    #[arg(long, value_name = "LO:HI", value_parser = band::parse, allow_hyphen_values = true)]
    pub band: Option<(f64, f64)>,
    /// Bins on each side that least squares reads: 4, 8 or 16
    #[arg(long, default_value_t = 16)]
    pub k: usize,
    /// Arithmetic: that of boards with an FPU, or without
    #[arg(long, value_enum, default_value_t)]
    pub arith: Arithmetic,
    /// How much work to spend on a line that is not a steady tone, in rounds of a joint fit:
    /// - 0: tests and a few more fits, as cores without an FPU do
    /// - 1, 2: with one cause beside the tone, or two, such as a drift, hum or another line
    /// - 3: with three
    #[arg(long, verbatim_doc_comment, value_name = "ROUNDS", default_value = Effort::default().name(), value_parser = effort)]
    pub effort: Effort,
    /// Linewidth of the laser, Hz, full width at half maximum; sigma then covers it (docs/signals.md)
    #[arg(long, value_name = "HZ", default_value_t = 0.0, value_parser = width)]
    pub linewidth: f32,
    /// Bandwidth of the echo's envelope, Hz, full width at half maximum, as of speckle; sigma then covers it (docs/signals.md)
    #[arg(long, value_name = "HZ", default_value_t = 0.0, value_parser = width)]
    pub envelope: f32,
    /// Bits of the converter: 8, 10, 12, 14 or 16. They decide where samples clip, in files of any format; whole numbers are codes
    #[arg(long, default_value_t = 16)]
    pub bits: u32,
    /// Codes count from 0, as those of a microcontroller's converter do
    #[arg(long)]
    pub unsigned: bool,
    /// Factor from the file's numbers to codes [default: 1 for integers of 16 bits; others use all 16 bits]
    #[arg(long)]
    pub scale: Option<f64>,
    /// Probability that a block of noise passes for a tone, above 0 and at most 0.5
    #[arg(long, value_name = "P", default_value_t = Config::new(1.0, Codes::signed::<12>()).false_alarm, value_parser = cli::number)]
    pub false_alarm: f64,
}

/// One channel, or two for I and Q.
fn channel(text: &str) -> Result<(usize, Option<usize>), String> {
    let number = |text: &str| text.trim().parse().ok().filter(|&channel: &usize| channel > 0);
    let channels = match text.split_once(',') {
        None => number(text).map(|channel| (channel, None)),
        Some((i, q)) => number(i).zip(number(q)).map(|(i, q)| (i, Some(q))),
    };
    channels.ok_or_else(|| "give a number from 1 on, or two for I and Q: 2,3".into())
}

/// A width in hertz.
fn width(text: &str) -> Result<f32, String> {
    let right = |hz: &f32| *hz >= 0.0 && hz.is_finite();
    text.parse().ok().filter(right).ok_or_else(|| "give a width in Hz, 0 or more".into())
}

/// An effort by its name.
pub fn effort(name: &str) -> Result<Effort, String> {
    Effort::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Effort::ALL.iter().map(|effort| effort.name()).collect();
        format!("choose one of {}", names.join(", "))
    })
}

impl Input {
    /// The tone's own width.
    pub const fn width(&self) -> Width {
        Width { linewidth_hz: self.linewidth, envelope_hz: self.envelope }
    }

    /// How the file is read.
    pub fn read(&self) -> Result<recording::Options, String> {
        if self.scale.is_some_and(|scale| !cli::MAGNITUDES.contains(&scale)) {
            return Err("--scale must be a positive number, 1e-18 to 1e18".into());
        }
        Ok(recording::Options {
            format: self.format,
            rate_hz: self.rate,
            iq: self.iq,
            scale: self.scale,
            channel: self.channel,
            decimal_comma: self.decimal_comma,
            channels: self.channels,
            axes: self.axes,
            part: self.part,
            converter: Some(Converter { bits: self.bits, unsigned: self.unsigned }),
        })
    }

    /// The codes of the samples.
    pub fn codes(&self) -> Result<Codes, String> {
        // Unsigned codes of 16 bits are read as signed ones.
        let signed = !self.unsigned || self.bits == 16;
        let codes = Codes::from_bits(signed, self.bits).filter(|_| self.bits.is_multiple_of(2));
        codes.ok_or_else(|| format!("--bits {}: choose 8, 10, 12, 14 or 16", self.bits))
    }

    /// The reach of least squares.
    pub fn reach(&self) -> Result<Reach, String> {
        estimator::reach(self.k)
    }

    /// How it is cut into blocks.
    pub fn cut(&self) -> Result<Cut, String> {
        let n = self.n.unwrap_or(super::BLOCK);
        Ok(Cut {
            read: self.read()?,
            n,
            hop: self.hop.unwrap_or(n),
            skip: self.skip,
            band_hz: self.band,
            codes: self.codes()?,
            reach: self.reach()?,
            width: self.width(),
        })
    }

    /// The measurement of its blocks by the best method of their kind.
    pub fn analysis(&self) -> Result<Analysis, String> {
        Ok(Analysis {
            read: self.read()?,
            n: self.n,
            hop: self.hop,
            skip: self.skip,
            band_hz: self.band,
            estimators: None,
            reach: self.reach()?,
            codes: self.codes()?,
            arithmetic: self.arith,
            effort: self.effort,
            width: self.width(),
            false_alarm: self.false_alarm,
            carrier: None,
        })
    }

    /// The file and how it is read, as it was typed.
    pub fn typed(&self) -> String {
        let mut words = cli::quoted(&self.file.display().to_string());
        if let Some(format) = self.format.and_then(|format| format.to_possible_value()) {
            words += &format!(" --format {}", format.get_name());
        }
        if let Some(rate) = self.rate {
            words += &format!(" --rate {rate}");
        }
        if let Some(scale) = self.scale {
            words += &format!(" --scale {scale}");
        }
        match self.channel {
            Some((first, Some(second))) => words += &format!(" --channel {first},{second}"),
            Some((first, None)) => words += &format!(" --channel {first}"),
            None => {}
        }
        if let Some(channels) = self.channels {
            words += &format!(" --channels {channels}");
        }
        if let Some(axes) = self.axes {
            words += &format!(" --axes {axes}");
        }
        if let Some(part) = self.part {
            words += &format!(" --part {part}");
        }
        let flags = [(self.iq, " --iq"), (self.decimal_comma, " --decimal-comma")];
        flags.into_iter().filter(|(given, _)| *given).for_each(|(_, flag)| words += flag);
        words
    }
}

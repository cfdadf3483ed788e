//! A board on a serial port: what it says, and orders to it.

use crate::answer::Answer;
use crate::device::{Blocks, Listener, Said};
use crate::row::row;
use crate::settings::{Kind, Settings};
use crate::station::{self, Station};
use picket::acquire::sample::Stamp;
use picket::config::Scene;
use picket::estimate::tone::Tone;
use picket::solve::chirp::{Mixing, Shape};
use picket::solve::equations::Chirp;
use picket_wire::boot::Boot;
use picket_wire::command::{Command, Request};
use picket_wire::lines::Lines;
use picket_wire::settings::Settings as Device;
use picket_wire::status::Status;

/// What is known of a board.
#[derive(Default)]
pub struct Board {
    /// Tells its frames apart.
    pub listener: Listener,
    blocks: Blocks,
    device: Option<(Device, usize)>,
    boot: Option<Boot>,
    status: Option<Status>,
    /// What measures its raw blocks, once its settings are known.
    pub station: Option<Box<dyn Station>>,
    lines: Lines,
    fundamental: Option<Tone>,
    /// Raw blocks measured here.
    pub raw: u32,
    /// Its last word, if that was a refusal.
    pub refused: Option<String>,
    tag: u8,
    bytes: u64,
}

impl Board {
    /// Takes bytes; gives the answers in them.
    pub fn hear(&mut self, bytes: &[u8], settings: &mut Settings) -> Vec<Answer> {
        self.bytes += bytes.len() as u64;
        let mut answers = Vec::new();
        for &byte in bytes {
            match self.listener.push(byte) {
                Some(Said::Telemetry(record)) => {
                    let told = record.measurement.tone.rate_hz;
                    let rate_hz = match &self.device {
                        Some((device, _)) => device.config.rate_hz,
                        None if told > 0.0 => told,
                        None => settings.rate_hz,
                    };
                    let mut row = Answer::of(&record.measurement, settings.n, settings.iq, rate_hz);
                    // As `picket watch` has it, to the bit.
                    let tone = record.measurement.tone;
                    row.time_s = row.clock / rate_hz;
                    row.frequency_hz = tone.frequency.0.to_num::<f64>() * rate_hz;
                    row.sigma_hz = f64::from(tone.sigma) * rate_hz;
                    row.snr_db = 10.0 * libm::log10(tone.snr.into());
                    row.lost = record.health.lost.into();
                    row.faults = record.health.faults.into();
                    answers.push(row);
                }
                Some(Said::Boot(boot)) => {
                    settings.n = boot.n as usize;
                    self.boot = Some(boot);
                }
                Some(Said::Status(status)) => self.status = Some(status),
                Some(Said::Answer(_, Ok(body))) => self.answered(&body, settings),
                Some(Said::Answer(_, Err(refusal))) => self.refused = Some(refusal.to_string()),
                Some(Said::Raw(raw)) => {
                    let length = settings.n * if settings.iq { 4 } else { 2 };
                    if let Some((sequence, bytes)) = self.blocks.push(&raw, length) {
                        self.measure(sequence, &bytes, settings.iq);
                    }
                }
                Some(Said::Lines(lines)) => self.lines = lines,
                Some(Said::Fundamental(said)) => self.fundamental = Some(said.harmonic.tone),
                Some(Said::Follow(_)) | None => {}
            }
        }
        answers
    }

    /// Settings, if that is what a body holds.
    fn answered(&mut self, body: &[u8], settings: &mut Settings) {
        let Some((device, n)) = Device::of_bytes(body).ok() else {
            return;
        };
        let config = &device.config;
        (settings.n, settings.iq, settings.rate_hz) = (n, device.iq, config.rate_hz);
        settings.codes = config.codes;
        settings.kind = match config.scene {
            Scene::Doppler { .. } => Kind::Doppler,
            Scene::Chirp(_) => Kind::Chirp,
            _ => Kind::Tone,
        };
        // A raw block is measured as a tone: which of a chirp's segments it is, it does not say.
        let plain = picket::Config { scene: Scene::Tone, ..*config };
        self.station = station::of_config(&plain, device.iq, n, settings.full_scale()).ok();
        self.device = Some((device, n));
    }

    /// The tones that the board told last, see [`row`].
    pub fn tones(&self, settings: &Settings) -> impl Iterator<Item = f64> {
        self.lines.tones.iter().flat_map(move |tone| row(tone, settings.rate_hz))
    }

    fn measure(&mut self, sequence: u32, bytes: &[u8], iq: bool) {
        let words = bytes.as_chunks().0.iter().map(|&word| i16::from_le_bytes(word));
        let words: Vec<i16> = words.collect();
        let samples: Vec<[i16; 2]> = match iq {
            true => words.as_chunks().0.to_vec(),
            false => words.into_iter().map(|word| [word, 0]).collect(),
        };
        if let Some(station) = &mut self.station {
            station.block(Stamp { sequence, ..Stamp::default() }, &samples);
            self.raw += 1;
        }
    }

    /// The bytes of an order, by its name; none for an unknown name.
    pub fn order(&mut self, name: &str, count: u16) -> Vec<u8> {
        let command = match name {
            "identify" => Command::Identify,
            "start" => Command::Start,
            "stop" => Command::Stop,
            "settings" => Command::GetSettings,
            "capture" => Command::Capture(count),
            "reset" => Command::Reset,
            "status" => Command::Status,
            _ => return Vec::new(),
        };
        (self.tag, self.refused) = (self.tag.wrapping_add(1), None);
        Request { tag: self.tag, command }.to_frame().to_vec()
    }

    /// What is known, a line each: a name, a tab and the words.
    pub fn words(&self) -> String {
        let mut text = String::new();
        let mut say = |name: &str, words: String| text += &format!("{name}\t{words}\n");
        if let Some(boot) = &self.boot {
            let state = if boot.measuring { "measuring" } else { "stopped" };
            let name = boot.board.as_str();
            let megahertz = f64::from(boot.core_hz) / 1e6;
            say("board", format!("{name}, {megahertz} MHz from {}", boot.clock.message()));
            say(
                "started by",
                format!("{}, program {:08x}, {state}", boot.causes.message(), boot.program),
            );
        }
        if let Some((device, n)) = &self.device {
            let config = &device.config;
            let kind = if device.iq { "I/Q" } else { "real" };
            say("records", format!("{n} samples, {kind}, at {} kHz", config.rate_hz / 1e3));
            let scene = match config.scene {
                Scene::Doppler { wavelength_m, mixing, .. } => {
                    let mixing = mixed(device.iq, mixing);
                    format!("Doppler shift, wavelength {} mm{mixing}", wavelength_m * 1e3)
                }
                Scene::Chirp(Chirp { shape, wavelength_m, bandwidth_hz, mixing, .. }) => format!(
                    "{} of {} MHz, wavelength {} mm{}",
                    match shape {
                        Shape::Trapezoid => "trapezoid",
                        Shape::Triangle => "triangle",
                        Shape::Sawtooth => "sawtooth",
                    },
                    bandwidth_hz / 1e6,
                    wavelength_m * 1e3,
                    mixed(device.iq, mixing)
                ),
                _ => "a tone".into(),
            };
            say("scene", scene);
            if let Some((low, high)) = config.band_hz {
                say("band", format!("{} to {} kHz", low / 1e3, high / 1e3));
            }
        }
        if let (Some(tone), Some((device, _))) = (&self.fundamental, &self.device) {
            let hertz = |cycles: f64| cycles * device.config.rate_hz;
            let (at, sigma) = (hertz(tone.frequency.0.to_num()), hertz(tone.sigma.into()));
            say("fundamental", format!("{at:.4} Hz \u{b1} {sigma:.4} Hz, {}", tone.verdict.name()));
        }
        if let Some(status) = &self.status {
            say("load", format!("{:.1} %", f64::from(status.load) / 10.0));
            say("dropped frames", status.dropped.to_string());
        }
        if let Some(refusal) = &self.refused {
            say("refused", refusal.clone());
        }
        if self.listener.records == 0 && self.boot.is_none() && self.bytes > 400 {
            say(
                "nothing yet",
                format!("{} bytes came, and no frame: is it the board's port?", self.bytes),
            );
        }
        text
    }
}

/// The mixing of I/Q records; real ones are the same for both.
fn mixed(iq: bool, mixing: Mixing) -> String {
    if iq { format!(", {}", mixing.name()) } else { String::new() }
}

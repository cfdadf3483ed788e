//! A board on a serial port: its messages, and commands to it.

use crate::answer::Answer;
use crate::device::{Blocks, Listener, Said};
use crate::heard::Heard;
use crate::row::row;
use crate::settings::{Kind, Settings};
use crate::station::Station;
use picket_dsp::acquire::burst::Counters;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::config::Scene;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::Tone;
use picket_wire::boot::Boot;
use picket_wire::burst::Burst;
use picket_wire::command::{Command, Request};
use picket_wire::lines::Lines;
use picket_wire::settings::Settings as Device;
use picket_wire::status::Status;
use picket_wire::sum::Sum;
use picket_wire::telemetry::Telemetry;

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
    pub station: Option<Station>,
    lines: Lines,
    lines_hz: f64,
    fundamental: Option<Tone>,
    burst: Option<Burst>,
    sum: Option<Sum>,
    /// Its frames of chirps, if that is what it gathers.
    pub heard: Option<Heard>,
    /// The sample rate of the last record, if it reports one.
    told_hz: Option<f64>,
    /// The settings have become unknown.
    asks: bool,
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
                Some(Said::Telemetry(record)) => answers.push(self.measured(&record, settings)),
                Some(Said::Burst(burst)) => {
                    self.burst = Some(burst);
                    answers.push(self.measured(&burst.record(), settings));
                }
                Some(Said::Sum(sum)) => self.sum = Some(sum),
                Some(Said::Boot(boot)) => {
                    settings.n = boot.n as usize;
                    self.forget();
                    (self.told_hz, self.status, self.boot) = (None, None, Some(boot));
                }
                Some(Said::Status(status)) => self.status = Some(status),
                Some(Said::Answer(_, Ok(body))) => self.answered(&body, settings),
                Some(Said::Answer(_, Err(refusal))) => self.refused = Some(refusal.to_string()),
                Some(Said::Raw(raw)) => {
                    // What a block is, only the settings say.
                    let Some((device, n)) = &self.device else { continue };
                    let (iq, length) = (device.iq, n * if device.iq { 4 } else { 2 });
                    if let Some((sequence, bytes)) = self.blocks.push(&raw, length) {
                        self.measure(sequence, &bytes, iq);
                    }
                }
                Some(Said::Lines(lines)) => {
                    // Without a rate its tones have no frequencies to show.
                    let rate_hz = self.rate_of(lines.sequence);
                    if rate_hz > 0.0 {
                        (self.lines, self.lines_hz) = (lines, rate_hz);
                    }
                }
                Some(Said::Fundamental(said)) => {
                    let rate_hz = self.rate_of(said.sequence);
                    self.fundamental = Some(Tone { rate_hz, ..said.harmonic.tone });
                }
                Some(Said::ChirpFrame(frame)) => {
                    (self.told_hz, settings.rate_hz) = (Some(frame.rate_hz), frame.rate_hz);
                    let heard = self.heard.get_or_insert_default();
                    answers.extend(heard.frame(&frame, settings));
                }
                Some(Said::Found(found)) => {
                    let rows = self.heard.as_mut().map(|heard| heard.target(&found, settings));
                    answers.extend(rows.unwrap_or_default());
                }
                Some(Said::Follow(_)) | None => {}
            }
        }
        answers
    }

    /// The row of a record.
    fn measured(&mut self, record: &Telemetry, settings: &mut Settings) -> Answer {
        let told = self.listener.rate_hz();
        if told.is_some() && self.told_hz.is_some() && told != self.told_hz {
            self.forget();
        }
        (self.told_hz, self.heard) = (told, None);
        let rate_hz = self.rate_of(record.measurement.stamp.sequence);
        if rate_hz > 0.0 {
            settings.rate_hz = rate_hz;
        }
        let mut row = Answer::of(&record.measurement, settings.n, settings.iq, rate_hz);
        // As `picket watch` has it, to the bit.
        let tone = record.measurement.tone;
        row.time_s = row.clock / rate_hz;
        row.frequency_hz = tone.frequency.0.to_num::<f64>() * rate_hz;
        row.sigma_hz = f64::from(tone.sigma) * rate_hz;
        row.snr_db = 10.0 * libm::log10(tone.snr.into());
        row.lost = record.health.lost.into();
        row.faults = record.health.faults.into();
        if let Some(total) = record.uncertainty {
            row.uncertainty_hz = f64::from(total.frequency) * rate_hz;
            // What the answer does not have is absent here, too.
            let beside = |value: f64, error: f32| if value.is_nan() { value } else { error.into() };
            row.uncertainty_range_m = beside(row.range_m, total.range);
            row.uncertainty_velocity_mps = beside(row.velocity_mps, total.velocity);
        }
        row
    }

    /// The settings may be others now: the page asks for them.
    fn forget(&mut self) {
        (self.device, self.station, self.fundamental) = (None, None, None);
        (self.burst, self.sum, self.heard) = (None, None, None);
        self.lines = Lines::default();
        self.asks = true;
    }

    /// The sample rate of a block's answers: that of its record, or of the settings if no record has one. NaN if unknown.
    fn rate_of(&self, sequence: u32) -> f64 {
        let settings = self.device.as_ref().map(|(device, _)| device.config.rate_hz);
        let told = match self.listener.rate_hz() {
            Some(_) => self.listener.rate_of(sequence),
            None => settings,
        };
        told.unwrap_or(f64::NAN)
    }

    /// Settings, if that is what a body holds.
    fn answered(&mut self, body: &[u8], settings: &mut Settings) {
        let Some((device, n)) = Device::from_bytes(body).ok() else {
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
        let plain = picket_dsp::Config { scene: Scene::Tone, ..*config };
        self.station = Station::from_config(&plain, device.iq, n, settings.full_scale()).ok();
        (self.device, self.asks, self.told_hz) = (Some((device, n)), false, None);
    }

    /// The tones that the board sent last, see [`row`].
    pub fn tones(&self) -> impl Iterator<Item = f64> {
        self.lines.tones.iter().flat_map(|tone| row(tone, self.lines_hz))
    }

    /// The map of its last frame of chirps, see [`Heard::map`].
    pub fn map(&self) -> Vec<f64> {
        let both = self.heard.as_ref().zip(self.device.as_ref());
        both.map_or_else(Vec::new, |(heard, device)| heard.map(device))
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
            let rate_hz = self.told_hz.unwrap_or(config.rate_hz);
            say("records", format!("{n} samples, {kind}, at {} kHz", rate_hz / 1e3));
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
        if self.asks {
            say("settings", "asked for: they may be others now".into());
        }
        if let Some(tone) = self.fundamental.filter(|tone| tone.rate_hz > 0.0) {
            let hertz = |cycles: f64| cycles * tone.rate_hz;
            let (at, sigma) = (hertz(tone.frequency.0.to_num()), hertz(tone.sigma.into()));
            say("fundamental", format!("{at:.4} Hz \u{b1} {sigma:.4} Hz, {}", tone.verdict.name()));
        }
        if let Some(Burst { burst, counters, .. }) = &self.burst {
            let validation = burst.validation.name();
            let transit_us = 1e6 * burst.transit() / self.told_hz.unwrap_or(f64::NAN);
            let Counters { samples, bursts, lost, long, dead } = counters;
            let share = 100.0 * *dead as f64 / (*samples).max(1) as f64;
            say("burst", format!("{validation}, transit time {transit_us:.1} us"));
            say("bursts", format!("{bursts}, {lost} lost, {long} too long, dead for {share:.1} %"));
        }
        if let Some(sum) = &self.sum {
            let digits = -sum.ln_chance / core::f32::consts::LN_10;
            say("sum", format!("{} blocks, noise alone once in 10^{digits:.1}", sum.blocks));
        }
        if let Some(words) = self.heard.as_ref().and_then(Heard::words) {
            say("frame", words);
        }
        if let Some(status) = &self.status {
            say("load", format!("{:.1} %", f64::from(status.load) / 10.0));
            say("dropped frames", status.dropped.to_string());
        }
        if let Some(refusal) = &self.refused {
            say("refused", refusal.clone());
        }
        if self.listener.records == 0 && self.boot.is_none() && self.bytes > 400 {
            let why = match self.listener.version {
                Some(version) => format!(
                    "its records are of version {version}, which this page does not know: flash the board with this version's image"
                ),
                None => format!("{} bytes came, and no frame: is it the board's port?", self.bytes),
            };
            say("nothing yet", why);
        }
        text
    }
}

/// The mixing of I/Q records; real ones are the same for both.
fn mixed(iq: bool, mixing: Mixing) -> String {
    if iq { format!(", {}", mixing.name()) } else { String::new() }
}

#[cfg(test)]
#[path = "../../host/tests/scenes.rs"]
mod scenes;

#[cfg(test)]
mod tests {
    use super::*;

    /// As `picket watch` shows it, see `host/tests/rates.rs`.
    #[test]
    fn a_records_own_rate_is_shown() {
        for scene in scenes::SCENES {
            let [before, after] = scene.bytes();
            let (mut board, mut settings) = (Board::default(), Settings::default());
            for row in board.hear(&before, &mut settings) {
                assert_eq!((row.frequency_hz.round(), settings.rate_hz), (25_000.0, 250e3));
            }
            let rows = board.hear(&after, &mut settings);
            let numbers: Vec<_> = rows
                .iter()
                .map(|row| (row.frequency_hz.round(), (row.time_s * 100e3).round()))
                .collect();
            assert_eq!(numbers, [1.0, 2.0, 3.0].map(|n| (10_000.0, 1024.0 * n)), "{scene:?}");
            assert_eq!(settings.rate_hz, 100e3);
            let tones: Vec<f64> = board.tones().collect();
            assert!(tones.len() > 8 && tones[0].round() == 10_000.0, "{scene:?}: {tones:?}");
            let words = board.words();
            assert!(words.contains("fundamental\t10000.0000 Hz"), "{scene:?}: {words}");
            assert!(!words.contains("250 kHz"), "{words}");
            // A port that is opened again is another board to the page, which asks it anyway.
            let unknown = scene != scenes::Scene::Partial;
            assert_eq!(words.contains("settings\tasked for"), unknown, "{scene:?}: {words}");
        }
    }
}

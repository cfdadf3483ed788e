//! What the page works with: its settings, its source, and what it reads next.

use crate::answer::Answer;
use crate::board::Board;
use crate::file::{self, File};
use crate::frames::{Background, Frames};
use crate::moved::Swing;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::station::{Picture, Station};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::tone::{Verdict, Verdicts};

/// Where blocks come from.
enum Source {
    /// Nothing was started.
    None,
    /// The simulated scene, or samples as they come.
    Station(Box<Station>),
    /// A recording.
    File(Box<File>),
    /// A recording of frames of chirps.
    Frames(Box<Frames>),
    /// A board.
    Board(Box<Board>),
}

/// The state behind the page.
pub struct Page {
    /// Bytes from the page.
    pub inbox: Vec<u8>,
    /// Numbers for it.
    pub numbers: Vec<f64>,
    /// Text or bytes for it.
    pub text: Vec<u8>,
    settings: Settings,
    scene: Scene,
    source: Source,
    /// Samples that fill no block yet, and blocks before them.
    rest: Vec<[i16; 2]>,
    blocks: u32,
    picture: Picture,
    background: Background,
}

impl Page {
    /// A page on which nothing runs.
    pub fn new() -> Self {
        Self {
            inbox: Vec::new(),
            numbers: Vec::new(),
            text: Vec::new(),
            settings: Settings::default(),
            scene: Scene::new(1),
            source: Source::None,
            rest: Vec::new(),
            blocks: 0,
            picture: Picture::default(),
            background: Background::NONE,
        }
    }

    fn station(&mut self) -> Option<&mut Station> {
        match &mut self.source {
            Source::None | Source::Frames(_) => None,
            Source::Station(station) => Some(station),
            Source::File(file) => Some(&mut file.station),
            Source::Board(board) => board.station.as_mut(),
        }
    }

    fn said(&mut self, result: Result<(), String>) -> bool {
        self.text.clear();
        if let Err(sentence) = &result {
            self.text.extend(sentence.bytes());
        }
        result.is_ok()
    }

    pub(crate) fn words(&mut self) {
        let mut text = Answer::names().join(",");
        let besides: Vec<&str> = Verdicts::from_bits(u8::MAX).iter().map(Verdict::name).collect();
        text += &format!("\n{}", besides.join(","));
        // The page finds them by their number.
        let mut verdicts = Verdict::ALL;
        verdicts.sort_by_key(|verdict| *verdict as u8);
        for verdict in verdicts {
            text += &format!("\n{verdict}\t{}\t{}", verdict.usable(), verdict.reason());
        }
        self.text = text.into_bytes();
    }

    pub(crate) fn set(&mut self, value: f64) -> bool {
        let name = String::from_utf8_lossy(&self.inbox);
        self.settings.set(&name, value) || self.scene.set(&name, value)
    }

    pub(crate) fn start(&mut self, seed: u64) -> bool {
        self.scene.again(seed);
        (self.blocks, self.numbers) = (0, Vec::new());
        self.rest.clear();
        let started = Station::new(&self.settings).map(|station| {
            self.source = Source::Station(Box::new(station));
        });
        self.said(started.map_err(|sentence| format!("This cannot work: {sentence}.")))
    }

    pub(crate) fn simulate(&mut self, blocks: u32) {
        self.numbers.clear();
        let Source::Station(station) = &mut self.source else { return };
        for _ in 0..blocks {
            let (stamp, samples, truth) = self.scene.block(&self.settings);
            station.follow(&stamp, Some(&samples));
            let Some(measurement) = station.block(stamp, &samples) else { continue };
            let row = Answer {
                truth_hz: truth.hertz,
                truth_m: truth.range_m,
                truth_mps: truth.velocity_mps,
                ..station.answer(&measurement)
            };
            row.put(&mut self.numbers);
        }
    }

    pub(crate) fn floats(&mut self) {
        self.numbers.clear();
        let Source::Station(station) = &mut self.source else { return };
        let full = self.settings.full_scale();
        let (low, high) = self.settings.codes.rails();
        let floats = self.inbox.as_chunks().0.iter().map(|&float| f32::from_le_bytes(float));
        // A cast turns what is no number into 0.
        let code = |x: f32| (f64::from(x) * full).round().clamp(low.into(), high.into()) as i16;
        self.rest.extend(floats.map(|float| [code(float), 0]));
        let n = self.settings.n;
        let whole = self.rest.len() / n * n;
        for samples in self.rest.drain(..whole).as_slice().chunks(n) {
            let clock = u64::from(self.blocks) * n as u64;
            let stamp = Stamp { sequence: self.blocks, clock, ..Stamp::default() };
            self.blocks = self.blocks.wrapping_add(1);
            let Some(measurement) = station.block(stamp, samples) else { continue };
            station.answer(&measurement).put(&mut self.numbers);
        }
    }

    pub(crate) fn open(&mut self, name: usize) -> bool {
        let mut bytes = std::mem::take(&mut self.inbox);
        let contents = bytes.split_off(name.min(bytes.len()));
        let name = String::from_utf8_lossy(&bytes).into_owned();
        let settings = &mut self.settings;
        let opened = file::recording(&name, contents, settings)
            .and_then(|recording| Frames::of(recording, settings))
            .and_then(|frames| match frames {
                Ok(frames) => Ok((frames.assumed.clone(), Source::Frames(Box::new(frames)))),
                Err(recording) => File::of(recording, settings)
                    .map(|file| (file.assumed.clone(), Source::File(Box::new(file)))),
            });
        match opened {
            Err(sentence) => self.said(Err(sentence)),
            Ok((assumed, source)) => {
                (self.text, self.source) = (assumed.into_bytes(), source);
                true
            }
        }
    }

    pub(crate) fn read(&mut self, blocks: u32) -> bool {
        self.numbers.clear();
        for _ in 0..blocks {
            let rows = match &mut self.source {
                Source::File(file) => file.next_block().map(|row| row.map(|row| vec![row])),
                Source::Frames(frames) => frames.next_frame(),
                _ => return false,
            };
            match rows {
                Ok(Some(rows)) => rows.iter().for_each(|row| row.put(&mut self.numbers)),
                Ok(None) => {
                    self.said(Ok(()));
                    return false;
                }
                Err(sentence) => return self.said(Err(sentence)),
            }
        }
        true
    }

    pub(crate) fn hear(&mut self) {
        self.numbers.clear();
        if !matches!(self.source, Source::Board(_)) {
            self.source = Source::Board(Box::default());
        }
        let Source::Board(board) = &mut self.source else { return };
        for row in board.hear(&self.inbox, &mut self.settings) {
            row.put(&mut self.numbers);
        }
        self.text = board.words().into_bytes();
    }

    pub(crate) fn order(&mut self, count: u32) {
        let name = String::from_utf8_lossy(&self.inbox).into_owned();
        self.text = match &mut self.source {
            Source::Board(board) => board.order(&name, count.min(u16::MAX.into()) as u16),
            _ => Vec::new(),
        };
    }

    pub(crate) fn spectrum(&mut self) {
        self.numbers.clear();
        let Some(station) = self.station() else { return };
        let picture = station.picture();
        let Picture { first_hz, step_hz, floor_db, threshold_db, hertz, sigma_hz, tone_db, .. } =
            picture;
        self.numbers.extend([first_hz, step_hz, floor_db, threshold_db, hertz, sigma_hz, tone_db]);
        self.numbers.extend(&picture.bins_db);
        self.picture = picture;
    }

    pub(crate) fn map(&mut self) {
        self.numbers.clear();
        match &self.source {
            Source::Frames(frames) => self.numbers.extend(frames.map()),
            Source::Board(board) => self.numbers.extend(board.map()),
            _ => {}
        }
    }

    pub(crate) fn background(&mut self, which: u32) {
        self.numbers.clear();
        let Source::Frames(frames) = &mut self.source else { return };
        match which {
            0 => self.background = Background::NONE,
            1 => self.background = frames.still(),
            _ => {}
        }
        frames.subtract(self.background.clone()).iter().for_each(|row| row.put(&mut self.numbers));
    }

    pub(crate) fn shown(&mut self) {
        let mut bytes = std::mem::take(&mut self.text);
        bytes.clear();
        self.numbers.clear();
        let mut numbers = std::mem::take(&mut self.numbers);
        if let Some(station) = self.station() {
            station.shown(&mut bytes, &mut numbers);
        }
        self.numbers = numbers;
        self.text = bytes;
    }

    pub(crate) fn tones(&mut self) {
        self.numbers.clear();
        if let Source::Board(board) = &self.source {
            self.numbers.extend(board.tones());
        }
    }

    pub(crate) fn fitted(&mut self, low_hz: f64, high_hz: f64, steps: u32) {
        self.numbers.clear();
        let steps = steps.clamp(1, 4096) as usize;
        let n = self.settings.n;
        self.picture.fitted(n, low_hz, high_hz, steps, &mut self.numbers);
    }

    pub(crate) fn tracks(&mut self) {
        let mut numbers = std::mem::take(&mut self.numbers);
        numbers.clear();
        if let Some(station) = self.station() {
            station.tracks(Segment::Up, &mut numbers);
        }
        self.numbers = numbers;
    }

    pub(crate) fn swings(&mut self) {
        let Some(station) = self.station() else { return self.numbers.clear() };
        let numbers = station.swings().into_iter().flat_map(|swing| {
            let Swing { line, amplitude_m: [amplitude_m, sigma_m], velocity_mps } = swing;
            let (tone, [velocity_mps, sigma_mps]) = (line.tone, velocity_mps);
            let verdict = f64::from(tone.verdict as u8);
            let line = [tone.hertz(), tone.sigma_hertz()];
            [amplitude_m, sigma_m, line[0], line[1], velocity_mps, sigma_mps, verdict]
        });
        self.numbers = numbers.collect();
    }

    pub(crate) fn state(&mut self) {
        let Settings { n, iq, rate_hz, kind, .. } = self.settings;
        let full = self.settings.full_scale();
        let known = !matches!(&self.source, Source::File(file) if !file.knows_rate);
        let speed = if known { self.settings.speed() } else { 0.0 };
        self.numbers = vec![n as f64, iq.into(), rate_hz, f64::from(kind as u8), full];
        let row = if let Source::File(file) = &self.source { file.row } else { 0 };
        let frames = match &self.source {
            Source::Frames(_) => true,
            Source::Board(board) => board.heard.is_some(),
            _ => false,
        };
        let follows = self.station().is_some_and(|station| station.follows());
        self.numbers.extend([known.into(), speed, row as f64, frames.into(), follows.into()]);
        if let Source::Board(board) = &self.source {
            let counts = [board.listener.records, board.listener.missing, board.listener.bad];
            self.numbers.extend(counts.map(|count| count as f64));
            self.numbers.push(board.raw.into());
            self.numbers.push(board.heard.as_ref().map_or(0, |heard| heard.frames).into());
        }
    }
}

impl Default for Page {
    fn default() -> Self {
        Self::new()
    }
}

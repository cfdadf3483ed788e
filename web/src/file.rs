//! A recording that was dropped on the page, block by block as `picket analyze` takes it.

use crate::answer::Answer;
use crate::length::LENGTHS;
use crate::settings::Settings;
use crate::station::Station;
use crate::unfit::{Tally, Unfit};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Stamp;
use picket_recording::{Blocks, Options, Recording, RecordingError, Sample};
use std::path::Path;

/// An open recording and what measures it.
pub struct File {
    blocks: Blocks,
    settings: Settings,
    /// What measures it.
    pub station: Station,
    /// Whether the file or the user tells the rate; without one it is 1, and frequencies are in cycles per sample.
    pub knows_rate: bool,
    /// What was assumed, in a line; empty where nothing was.
    pub assumed: String,
    /// Samples of a record, if the recording has separate ones; 0 if not.
    pub row: usize,
    number: u32,
    tally: Tally,
}

impl File {
    /// A recording by blocks. The settings take its rate and kind, and of a row of records their length.
    ///
    /// # Errors
    /// It cannot be measured; the sentence says what to do.
    pub fn of(recording: Recording, settings: &mut Settings) -> Result<Self, String> {
        let knows_rate = recording.knows_rate();
        let assumed = recording.assumed().map(|assumed| on_the_page(&assumed)).unwrap_or_default();
        (settings.rate_hz, settings.iq) = (recording.rate_hz(), recording.iq());
        settings.of_file();
        // A block of each record of their own, where one fits.
        let row = recording.row().and_then(|row| usize::try_from(row).ok());
        let fits = row.and_then(|row| LENGTHS.into_iter().rfind(|&n| n <= row));
        let hop = row.filter(|_| fits.is_some());
        settings.n = fits.map_or(settings.n, |fits| settings.n.min(fits));
        // Between records of their own is a pause of unknown length.
        let displacement = settings.displacement && knows_rate && row.is_none();
        let station = Station::new(&Settings { displacement, ..*settings })?;
        let blocks = recording.blocks(settings.n, hop.unwrap_or(settings.n), 0);
        let (number, tally) = (0, Tally::default());
        let row = row.unwrap_or(0);
        Ok(File { blocks, settings: *settings, station, knows_rate, assumed, row, number, tally })
    }

    /// The answer to the next block or sum; `None` at the end.
    ///
    /// # Errors
    /// The recording is damaged from here on, or no block of it fits the codes.
    pub fn next_block(&mut self) -> Result<Option<Answer>, String> {
        let name = self.blocks.recording().path().display().to_string();
        let codes = self.settings.codes;
        loop {
            let block = self.blocks.next_block().map_err(|error| sentence(&name, &error))?;
            let Some((start, samples)) = block else {
                let none = self.tally.left_out() == self.tally.blocks;
                return if none { Err(self.tally.sentence(codes)) } else { Ok(None) };
            };
            let unfit = Unfit::of(samples, codes);
            self.tally.add(unfit);
            // Codes beyond the rails have a verdict of their own; what is less than a code is none.
            let code = |sample: &Sample| match unfit {
                Some(Unfit::Quiet) => [0; 2],
                _ => sample.code(),
            };
            let record: Vec<[i16; 2]> = samples.iter().map(code).collect();
            let gap = self.blocks.gap();
            let stamp = Stamp { sequence: self.number, clock: start, gap, ..Stamp::default() };
            self.number = self.number.wrapping_add(1);
            self.station.follow(&stamp, unfit.is_none().then_some(record.as_slice()));
            if let Some(measurement) = self.station.block(stamp, &record) {
                return Ok(Some(self.station.answer(&measurement)));
            }
        }
    }
}

impl Tally {
    /// What is to be done where every block was left out.
    pub fn sentence(&self, codes: Codes) -> String {
        let (low, high) = codes.rails();
        match self.most() {
            Unfit::Beyond => format!(
                "Samples lie beyond {low} to {high} in every block: choose wider codes, or a smaller scale."
            ),
            Unfit::Quiet => {
                "The samples are too small for integers: choose a larger scale.".to_owned()
            }
        }
    }
}

/// The recording in the bytes of a file of this name.
///
/// # Errors
/// It cannot be read; the sentence says what to do.
pub fn recording(name: &str, bytes: Vec<u8>, settings: &Settings) -> Result<Recording, String> {
    let recording = Recording::from_bytes(Path::new(name), bytes, options(settings))
        .map_err(|error| sentence(name, &error))?;
    match recording.clock().filter(|clock| clock.walk_s > 0.0) {
        None => Ok(recording),
        Some(clock) => {
            let share = 100.0 * clock.share(settings.n);
            Err(format!(
                "{name}: the samples are not even in time: over a block the rate is off by {share:.2} % and unknown, more than sigma covers. Sample by a timer, or type a rate to take them as even."
            ))
        }
    }
}

/// How a file is read, as `picket analyze` is told it by its options.
fn options(settings: &Settings) -> Options {
    let chosen = |channel: usize| (channel != 0).then_some(channel);
    let (channel, q) = settings.channel;
    Options {
        format: settings.format,
        rate_hz: (settings.file_rate_hz != 0.0).then_some(settings.file_rate_hz),
        iq: settings.iq,
        channel: chosen(channel).map(|channel| (channel, chosen(q))),
        scale: (settings.scale != 0.0).then_some(settings.scale),
        converter: Some(settings.converter),
        ..Options::default()
    }
}

/// What is wrong with a recording, and what to do about it on the page.
pub fn sentence(name: &str, error: &RecordingError) -> String {
    use RecordingError::*;
    match error {
        Empty(_) => format!("{name} holds no samples."),
        Unclear(_, []) => format!(
            "{name}: neither its name nor its first bytes show what it is. The page reads wav, csv and npy files; choose what raw numbers are under Format."
        ),
        Unclear(_, readings) => {
            let names: Vec<String> =
                readings.iter().map(|it| format!("{it:?}").to_lowercase()).collect();
            format!("{name} looks like {}: choose it under Format.", names.join(" or "))
        }
        OddSize(_, bytes, frame) => format!(
            "{name}: {bytes} bytes are not a whole number of {frame}-byte samples: the file is cut off, or not what its name says."
        ),
        Wav(_, what) => format!("{name} is not a readable wav file: {what}."),
        Truncated(_, said, held) => format!(
            "{name} is cut off: its header announces {said} bytes of samples, the file holds {held}. Copy it again."
        ),
        Channels(_, 2, false) => {
            format!(
                "{name} has two channels: choose one under Channel, or tick I/Q if that is what they are."
            )
        }
        Channels(_, channels, _) => {
            format!("{name} has {channels} channels: choose one under Channel, or two for I and Q.")
        }
        Rate(rate) => format!("A sample rate of {rate} Hz cannot be: type another."),
        Either(_) => format!(
            "{name} is text, and its name says numbers: choose csv under Format, or i16 if it is no text."
        ),
        Comma(_, line) => format!(
            "{name}: \"{line}\" may be one number or two columns: rewrite it with points or semicolons."
        ),
        Short(_, held, needed) => format!(
            "{name}: {held} samples are fewer than a block of {needed}: choose a smaller block."
        ),
        Line(_, line, what) => format!("{name}, line {line}: {what}."),
        Npy(_, what) => format!("{name} is not a readable npy file: {what}."),
        other => format!("{}.", on_the_page(&other.to_string())),
    }
}

/// A sentence of the reader in which options of a command line have the names of the page's fields.
pub fn on_the_page(words: &str) -> String {
    const NAMES: [(&str, &str); 17] = [
        ("--period-s says", "Period says"),
        ("--guard-s says", "Begins at says"),
        ("add --period-s", "type it under Period"),
        ("--velocity-mps says otherwise", "no bounds are told"),
        ("give a longer --chirp-s, or --n 64", "type a longer ramp"),
        ("narrow --velocity-mps, or ", ""),
        ("--axes", "axes"),
        ("by --channel", "under Channel"),
        ("by --column", "under Channel"),
        ("--channel chooses", "Channel chooses"),
        ("add --channels 2 --channel 1", "choose a channel under Channel"),
        ("add --rate HZ", "type a rate"),
        ("add --format", "choose under Format"),
        ("--format", "under Format"),
        ("--iq", "tick I/Q"),
        ("--channel", "Channel"),
        ("; --part chooses", ""),
    ];
    NAMES.iter().fold(words.to_owned(), |words, (option, field)| words.replace(option, field))
}

//! A recording that was dropped on the page, block by block as `picket analyze` takes it.

use crate::answer::Answer;
use crate::settings::{Kind, Settings};
use crate::station::Station;
use picket_dsp::acquire::sample::Stamp;
use picket_recording::{Blocks, Options, Recording, RecordingError, Sample};
use std::path::Path;

/// An open recording and what measures it.
pub struct File {
    blocks: Blocks,
    settings: Settings,
    /// What measures it.
    pub station: Station,
    number: u32,
}

impl File {
    /// Opens the bytes of a file of this name. The settings take the recording's rate and kind.
    ///
    /// # Errors
    /// It cannot be read or measured; the sentence says what to do.
    pub fn open(name: &str, bytes: Vec<u8>, settings: &mut Settings) -> Result<Self, String> {
        let chosen = |channel: usize| (channel != 0).then_some(channel);
        let (channel, q) = settings.channel;
        let options = Options {
            rate_hz: (settings.file_rate_hz != 0.0).then_some(settings.file_rate_hz),
            iq: settings.iq,
            channel: chosen(channel).map(|channel| (channel, chosen(q))),
            scale: None,
            ..Options::default()
        };
        let recording = Recording::from_bytes(Path::new(name), bytes, options)
            .map_err(|error| sentence(name, &error))?;
        if !recording.knows_rate() {
            return Err(format!(
                "{name} has no sample rate: type it under File, and drop it again."
            ));
        }
        (settings.rate_hz, settings.iq) = (recording.rate_hz(), recording.iq());
        settings.kind = Kind::Tone;
        let station = Station::new(settings)?;
        let blocks = recording.blocks(settings.n, settings.n, 0);
        Ok(File { blocks, settings: *settings, station, number: 0 })
    }

    /// The answer to the next block or sum; `None` at the end.
    ///
    /// # Errors
    /// The recording is damaged from here on, or its samples do not fit the codes.
    pub fn next_block(&mut self) -> Result<Option<Answer>, String> {
        let name = self.blocks.recording().path().display().to_string();
        loop {
            let block = self.blocks.next_block().map_err(|error| sentence(&name, &error))?;
            let Some((start, samples)) = block else { return Ok(None) };
            fits(samples, &self.settings)?;
            let codes: Vec<[i16; 2]> = samples.iter().map(Sample::code).collect();
            let stamp = Stamp { sequence: self.number, clock: start, ..Stamp::default() };
            self.number = self.number.wrapping_add(1);
            if let Some(measurement) = self.station.block(stamp, &codes) {
                return Ok(Some(self.station.answer(&measurement)));
            }
        }
    }
}

fn fits(samples: &[Sample], settings: &Settings) -> Result<(), String> {
    let (low, high) = settings.codes.rails();
    let beyond = |part: i16| part < low || part > high;
    if samples.iter().any(|sample| sample.code().into_iter().any(beyond)) {
        return Err(format!(
            "Samples lie beyond {low} to {high}: choose wider codes, or a smaller scale."
        ));
    }
    let value = |sample: &Sample| sample.value.re.abs().max(sample.value.im.abs());
    let largest = samples.iter().map(value).fold(0.0, f64::max);
    if largest > 0.0 && largest < 1.5 {
        return Err("The samples are too small for integers: choose a larger scale.".into());
    }
    Ok(())
}

/// What is wrong with a recording, and what to do about it on the page.
fn sentence(name: &str, error: &RecordingError) -> String {
    use RecordingError::*;
    match error {
        Empty(_) => format!("{name} holds no samples."),
        Unclear(_, []) => format!(
            "{name}: unknown format. The page reads wav, csv and npy files, and raw numbers named i16, cs16, cu8, f32 or cf32."
        ),
        Unclear(_, readings) => {
            let names: Vec<String> =
                readings.iter().map(|it| format!("{it:?}").to_lowercase()).collect();
            format!("{name} may hold numbers of several kinds: rename it .{}.", names.join(" or ."))
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
            "{name} is text, and its name says numbers: rename it .csv, or .i16 if it is none."
        ),
        Comma(_, line) => format!(
            "{name}: \"{line}\" may be one number or two columns: rewrite it with points or semicolons."
        ),
        Short(_, held, needed) => format!(
            "{name}: {held} samples are fewer than a block of {needed}: choose a smaller block."
        ),
        Line(_, line, what) => format!("{name}, line {line}: {what}."),
        Npy(_, what) => format!("{name} is not a readable npy file: {what}."),
        other => {
            let words = other.to_string().replace("by --channel", "under Channel");
            format!("{}.", words.replace("by --column", "under Channel"))
        }
    }
}

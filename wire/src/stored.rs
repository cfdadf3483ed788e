//! Settings as flash keeps them: fields with tags, so that programs of different times read each other's.
//!
//! ```text
//! version: u8, 128 | fields | zeros up to a word
//! field:             tag: u8, not 0 | length of the value: u8 | value
//! ```
//!
//! `FIELDS` says which tag is what, for [`encode`] and for [`decode`]. A field that is absent has the value that stands there for
//! ever, and one that has this value is left out: settings that use nothing new are those of an earlier program.
//!
//! A program that meets a tag beyond its own looks at its highest bit, [`CRITICAL`]. If it is set, records would mean something
//! else without the field, so the program refuses all. If it is clear, the program goes without the field, and [`encode`] hands it
//! on to the next page, for the program that knows it.
//!
//! Earlier programs have saved the layout of [`Settings::to_bytes`], versions 1 to 5, and one before it: [`decode`] reads these, too.
//! The page around the bytes has their checksum.

use crate::config::EncodingError;
use crate::settings::{Settings, WHOLE};
use crate::settings_error::SettingsError;
use heapless::Vec;

/// The longest stored settings, bytes, of which today's fields take 280 at most. The others are room for what later programs add.
pub const ROOM: usize = 384;

/// The bit of a tag without whose field records would mean something else.
pub const CRITICAL: u8 = 0x80;

/// The version of the layout.
const VERSION: u8 = 128;

/// The fields, as they follow each other behind the version in [`Settings::to_whole`]: tag, and value where the field is absent. Tags
/// count from 1 on. What is new is a line at the end. Tags, lengths and values never change: a field in another form is a new one.
const FIELDS: [(u8, &[u8]); 43] = [
    (CRITICAL | 1, &[0]),                     // drive
    (CRITICAL | 2, &[0]),                     // divider before the synthesiser
    (CRITICAL | 3, &[1]),                     // bits: start, uncorrected, tones, harmonics
    (CRITICAL | 4, &[0; 2]),                  // core's clock, MHz
    (CRITICAL | 5, &[0; 2]),                  // guard, samples
    (CRITICAL | 6, &1u16.to_le_bytes()),      // blocks a record
    (CRITICAL | 7, &[0; 4]),                  // DAC's low and high code
    (CRITICAL | 8, &[0; 2]),                  // slots
    (CRITICAL | 9, &[0; 8]),                  // synthesiser's crystal, Hz
    (CRITICAL | 10, &[0; 8]),                 // carrier at the bottom of a ramp, Hz
    (CRITICAL | 11, &[0; 4]),                 // clock's error, ppm
    (CRITICAL | 12, &[0; 4]),                 // range's offset, m
    (CRITICAL | 13, &1f32.to_le_bytes()),     // range's slope
    (CRITICAL | 14, &[0]),                    // bits: I/Q, a band, the less usual mixing
    (CRITICAL | 15, &[19]),                   // method
    (CRITICAL | 16, &[0]),                    // scene
    (CRITICAL | 17, &[0]),                    // shape of a chirp
    (CRITICAL | 18, &[16]),                   // bins that least squares reads
    (CRITICAL | 19, &[0]),                    // arithmetic and effort
    (CRITICAL | 20, &[0]),                    // tones followed
    (CRITICAL | 21, &[0]),                    // blocks from search to search
    (CRITICAL | 22, &[0, 0, 0xFF, 0x0F]),     // converter's lowest and highest code
    (CRITICAL | 23, &[0; 4]),                 // samples in a block: always there
    (CRITICAL | 24, &500e3f64.to_le_bytes()), // rate, Hz
    (CRITICAL | 25, &[0; 16]),                // ends of the band, Hz
    (CRITICAL | 26, &[0; 8]),                 // wavelength, m
    (CRITICAL | 27, &[0; 8]),                 // angle, rad, or bandwidth, Hz
    (CRITICAL | 28, &[0; 8]),                 // duration of a ramp, s
    (CRITICAL | 29, &1e-6f64.to_le_bytes()),  // probability of a false alarm
    (CRITICAL | 30, &0.05f32.to_le_bytes()),  // of earlier trackers
    (CRITICAL | 31, &[0; 4]),                 // of earlier trackers
    (CRITICAL | 32, &2f32.to_le_bytes()),     // rate of following, bins
    (CRITICAL | 33, &[0; 8]),                 // curvature of a sweep
    (CRITICAL | 34, &[0; 4]),                 // linewidth of the carrier, Hz
    (CRITICAL | 35, &[0; 4]),                 // bandwidth of its envelope, Hz
    (CRITICAL | 36, &[0; 4]),                 // mode; bit: a rate for the worst block
    (CRITICAL | 37, &[0; 4]),                 // blocks of a sum, hold-off of a burst
    (CRITICAL | 38, &[0; 4]),                 // drift of a sum, ratio of a burst
    (CRITICAL | 39, &[0; 4]),                 // least energy of a burst
    (CRITICAL | 40, &NONE),                   // least range, m
    (CRITICAL | 41, &NONE),                   // largest range, m
    (CRITICAL | 42, &NONE),                   // least velocity, m/s
    (CRITICAL | 43, &NONE),                   // largest velocity, m/s
];

/// The value of a bound that is not set.
const NONE: [u8; 8] = f64::NAN.to_le_bytes();

/// Each field's tag, place in all settings, and length.
// A bad index is an error of the compiler.
#[allow(clippy::indexing_slicing)]
const PLACES: [[u8; 3]; FIELDS.len()] = {
    let (mut places, mut at, mut row) = ([[0; 3]; FIELDS.len()], 1, 0);
    while row < FIELDS.len() {
        let (tag, absent) = FIELDS[row];
        assert!((tag & !CRITICAL) as usize == row + 1, "tags count from 1 on");
        places[row] = [tag, at, absent.len() as u8];
        at += absent.len() as u8;
        row += 1;
    }
    assert!(at as usize == Settings::BYTES, "the fields are all settings");
    places
};

/// All settings where every field is absent.
// A bad index is an error of the compiler.
#[allow(clippy::indexing_slicing)]
const ABSENT: [u8; Settings::BYTES] = {
    let (mut whole, mut row) = ([WHOLE; Settings::BYTES], 0);
    while row < FIELDS.len() {
        let (absent, [_, at, length]) = (FIELDS[row].1, PLACES[row]);
        let mut byte = 0;
        while byte < length {
            whole[(at + byte) as usize] = absent[byte as usize];
            byte += 1;
        }
        row += 1;
    }
    whole
};

/// The settings, for blocks of `n` samples, as flash keeps them: whole words. What was stored before hands on those of its fields that
/// this program does not know and may pass over, as far as they have room.
pub fn encode(settings: &Settings, n: usize, before: &[u8]) -> Vec<u8, ROOM> {
    // Today's fields have room: a test of the longest settings shows it.
    let mut stored = Vec::new();
    let _ = stored.push(VERSION);
    let whole = settings.to_whole(n);
    for &[tag, at, length] in &PLACES {
        let place = usize::from(at)..usize::from(at) + usize::from(length);
        let value = whole.get(place.clone()).unwrap_or_default();
        if Some(value) != ABSENT.get(place) {
            append(&mut stored, tag, value);
        }
    }
    for (tag, value) in Fields::of(before).into_iter().flatten().flatten() {
        if tag & CRITICAL == 0 && usize::from(tag) > PLACES.len() {
            append(&mut stored, tag, value);
        }
    }
    while !stored.len().is_multiple_of(4) && stored.push(0).is_ok() {}
    stored
}

/// Settings and the length of a block from the bytes of [`encode`], or of an earlier program. The board checks them further.
///
/// # Errors
/// The bytes are cut off or of another version, there is a critical field that this program does not know, or a field has an unknown
/// length or value.
pub fn decode(bytes: &[u8]) -> Result<(Settings, usize), SettingsError> {
    let Some(fields) = Fields::of(bytes) else { return positional(bytes) };
    let damaged = SettingsError::Encoding(EncodingError::Field);
    let mut whole = ABSENT;
    // Known fields stand in the table's order, each once.
    let mut from = 0;
    for field in fields {
        let (tag, value) = field.ok_or(damaged)?;
        match PLACES.get(usize::from(tag & !CRITICAL).wrapping_sub(1)) {
            Some(&[known, at, length])
                if (known, usize::from(length)) == (tag, value.len()) && at > from =>
            {
                from = at;
                let places = whole.iter_mut().skip(at.into());
                places.zip(value).for_each(|(place, byte)| *place = *byte);
            }
            Some(_) => return Err(damaged),
            None if tag & CRITICAL == 0 => {}
            None => return Err(SettingsError::Encoding(EncodingError::Version)),
        }
    }
    Settings::from_whole(&whole)
}

/// Appends a field if it has room.
fn append(stored: &mut Vec<u8, ROOM>, tag: u8, value: &[u8]) {
    if stored.len() + 2 + value.len() <= ROOM {
        let _ = stored.extend_from_slice(&[tag, value.len() as u8]);
        let _ = stored.extend_from_slice(value);
    }
}

/// The fields of stored settings that are still to read: each a tag and its value, or `None` where it is cut off.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// The fields of these settings; `None` if they are of another layout.
    fn of(bytes: &'a [u8]) -> Option<Self> {
        match bytes {
            [VERSION, fields @ ..] => Some(Self(fields)),
            _ => None,
        }
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Option<(u8, &'a [u8])>;

    fn next(&mut self) -> Option<Self::Item> {
        let (&tag, rest) = core::mem::take(&mut self.0).split_first()?;
        if tag == 0 {
            return None;
        }
        let field =
            rest.split_first().and_then(|(&length, rest)| rest.split_at_checked(length.into()));
        Some(field.map(|(value, rest)| {
            self.0 = rest;
            (tag, value)
        }))
    }
}

/// Settings as earlier programs have saved them, of version 5 at most.
fn positional(bytes: &[u8]) -> Result<(Settings, usize), SettingsError> {
    let version = SettingsError::Encoding(EncodingError::Version);
    let mut bytes = Vec::<u8, { Settings::MODED }>::from_slice(bytes).map_err(|_| version)?;
    of_the_first(&mut bytes);
    Settings::from_bytes(&bytes)
}

/// Turns settings of the first programs into those of version 1 as it has been since: their configuration had a number for the
/// converter's codes, and so the shape of a chirp, at most 2, where the later ones have what least squares reads, 4 or more.
fn of_the_first(bytes: &mut [u8]) {
    let first = bytes.first() == Some(&1);
    let config = bytes.get_mut(45..).and_then(<[u8]>::first_chunk_mut);
    let Some(config) = config.filter(|_| first) else { return };
    let &mut [codes, method, scene, shape, reach, how, most, refresh, 0, 0, 0] = config else {
        return;
    };
    let (low, high) = match codes {
        0 => (-0x800i16, 0x7FF),
        1 => (0, 0xFFF),
        2 => (i16::MIN, i16::MAX),
        _ => return,
    };
    if shape <= 2 {
        let ([a, b], [c, d]) = (low.to_le_bytes(), high.to_le_bytes());
        *config = [method, scene, shape, reach, how, most, refresh, a, b, c, d];
    }
}

//! Settings as words, in the form that flash and the memory between two programs keep.

use crate::storage::Payload;
use picket_wire::settings::Settings;

/// Length of the longest settings, words.
pub const WORDS: usize = Settings::BYTES.div_ceil(4);

/// Settings for blocks of `n` samples as words. Words beyond shorter settings are 0.
pub fn words(settings: &Settings, n: usize) -> [u32; WORDS] {
    let bytes = payload(settings, n);
    let mut words = [0; WORDS];
    let fields = bytes.as_chunks().0.iter().map(|&field| u32::from_le_bytes(field));
    words.iter_mut().zip(fields).for_each(|(place, word)| *place = word);
    words
}

/// Settings for blocks of `n` samples as flash keeps them: zeros fill the last word.
pub fn payload(settings: &Settings, n: usize) -> Payload {
    let mut payload = Payload::new();
    // The longest settings have room.
    let _ = payload.extend_from_slice(&settings.to_bytes(n));
    while !payload.len().is_multiple_of(4) && payload.push(0).is_ok() {}
    payload
}

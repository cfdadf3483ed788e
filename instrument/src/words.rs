//! Settings as words, in the form that the memory between two programs keeps.

use picket_wire::settings::Settings;

/// Length of the settings, words.
pub const WORDS: usize = Settings::BYTES / 4;

/// Settings for blocks of `n` samples as words. Words beyond shorter settings are 0.
pub fn words(settings: &Settings, n: usize) -> [u32; WORDS] {
    let bytes = settings.to_bytes(n);
    let mut words = [0; WORDS];
    let fields = bytes.as_chunks().0.iter().map(|&field| u32::from_le_bytes(field));
    words.iter_mut().zip(fields).for_each(|(place, word)| *place = word);
    words
}

//! Settings as words, as flash and the memory between two programs keep them.

use picket_wire::settings::Settings;

/// Length of the settings, words.
pub const WORDS: usize = Settings::BYTES / 4;

/// Settings for blocks of `n` samples as words. Those beyond shorter settings are 0.
pub fn words(settings: &Settings, n: usize) -> [u32; WORDS] {
    let bytes = settings.to_bytes(n);
    let mut words = [0; WORDS];
    let fields = bytes.as_chunks().0.iter().map(|&field| u32::from_le_bytes(field));
    words.iter_mut().zip(fields).for_each(|(place, word)| *place = word);
    words
}

/// The settings in these words, if they are for blocks of `N` samples.
// Compiled once for what the last program left and for the flash.
#[inline(never)]
pub fn settings<const N: usize>(words: &[u32; WORDS]) -> Option<Settings> {
    let mut bytes = [0; Settings::BYTES];
    let places = bytes.as_chunks_mut().0.iter_mut();
    places.zip(words).for_each(|(place, word)| *place = word.to_le_bytes());
    let (settings, n) = Settings::of_bytes(&bytes).ok()?;
    (n == N).then_some(settings)
}

//! Picket in a browser.
//!
//! The page calls the functions below. They take numbers, and bytes in an inbox; they leave numbers and text where the page
//! reads them. So the page needs no code but its own, and no tool but the compiler builds this.

pub mod answer;
pub mod board;
pub mod check;
#[path = "../../host/src/device.rs"]
pub mod device;
pub mod file;
pub mod frames;
pub mod heard;
#[path = "../../host/measure/src/length.rs"]
pub mod length;
#[path = "../../host/measure/src/analyze/moved.rs"]
pub mod moved;
pub mod page;
#[path = "../../host/measure/src/analyze/radar.rs"]
pub mod radar;
pub mod record;
pub mod row;
pub mod scene;
pub mod settings;
pub mod station;
#[path = "../../host/measure/src/analyze/unfit.rs"]
pub mod unfit;

use page::Page;
use picket_recording as recording;
use std::cell::RefCell;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::new(Page::new());
}

fn page<T>(work: impl FnOnce(&mut Page) -> T) -> T {
    PAGE.with_borrow_mut(work)
}

/// Reserves this many bytes for the page; returns their address.
#[unsafe(no_mangle)]
pub extern "C" fn picket_inbox(bytes: usize) -> *mut u8 {
    page(|page| {
        page.inbox.clear();
        page.inbox.resize(bytes, 0);
        page.inbox.as_mut_ptr()
    })
}

/// The numbers that the last call left: their address.
#[unsafe(no_mangle)]
pub extern "C" fn picket_numbers() -> *const f64 {
    page(|page| page.numbers.as_ptr())
}

/// How many they are.
#[unsafe(no_mangle)]
pub extern "C" fn picket_numbers_length() -> usize {
    page(|page| page.numbers.len())
}

/// The text or bytes that the last call left: their address.
#[unsafe(no_mangle)]
pub extern "C" fn picket_text() -> *const u8 {
    page(|page| page.text.as_ptr())
}

/// How many they are.
#[unsafe(no_mangle)]
pub extern "C" fn picket_text_length() -> usize {
    page(|page| page.text.len())
}

/// Leaves the names of an answer's numbers, what may apply beside a verdict, the verdicts and their reasons as text.
#[unsafe(no_mangle)]
pub extern "C" fn picket_words() {
    page(Page::words)
}

/// Sets the value whose name is in the inbox. 0 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn picket_set(value: f64) -> u32 {
    page(|page| page.set(value).into())
}

/// Begins to measure by what was set. 0 if that cannot work; the text says why.
#[unsafe(no_mangle)]
pub extern "C" fn picket_start(seed: u32) -> u32 {
    page(|page| page.start(seed.into()).into())
}

/// Measures this many blocks of the simulated scene; leaves their answers.
#[unsafe(no_mangle)]
pub extern "C" fn picket_simulate(blocks: u32) {
    page(|page| page.simulate(blocks))
}

/// Measures the floats in the inbox, -1 to 1, as they come; leaves the answers that they complete.
#[unsafe(no_mangle)]
pub extern "C" fn picket_floats() {
    page(Page::floats)
}

/// Opens the file in the inbox, whose name has so many bytes and comes first; the text says what was assumed of it. 0 if it cannot; the
/// text says why.
#[unsafe(no_mangle)]
pub extern "C" fn picket_open(name: usize) -> u32 {
    page(|page| page.open(name).into())
}

/// Measures this many blocks of the open file; leaves their answers. 0 at its end, and text if that is an error.
#[unsafe(no_mangle)]
pub extern "C" fn picket_read(blocks: u32) -> u32 {
    page(|page| page.read(blocks).into())
}

/// Hears the board's bytes in the inbox; leaves the answers in them, and what is known as text.
#[unsafe(no_mangle)]
pub extern "C" fn picket_hear() {
    page(Page::hear)
}

/// Leaves the bytes of the order whose name is in the inbox.
#[unsafe(no_mangle)]
pub extern "C" fn picket_order(count: u32) {
    page(|page| page.order(count))
}

/// Leaves the spectrum: first frequency, step, floor, threshold, tone, sigma, level, then the bins.
#[unsafe(no_mangle)]
pub extern "C" fn picket_spectrum() {
    page(Page::spectrum)
}

/// Leaves the map of the last frame of chirps, see [`frames::Frames::map`].
#[unsafe(no_mangle)]
pub extern "C" fn picket_map() {
    page(Page::map)
}

/// Subtracts from the frames of a recording nothing (0), what stands still in the last one (1), or what was subtracted before the recording was
/// opened again (2); leaves the answers of the last one anew.
#[unsafe(no_mangle)]
pub extern "C" fn picket_background(which: u32) {
    page(|page| page.background(which))
}

/// Leaves the samples of the block that the spectrum is of, two codes each, as bytes, and as numbers what the tones' module is
/// told of them.
#[unsafe(no_mangle)]
pub extern "C" fn picket_shown() {
    page(Page::shown)
}

/// Leaves the tones of a block that the board sent, see [`row`].
#[unsafe(no_mangle)]
pub extern "C" fn picket_tones() {
    page(Page::tones)
}

/// Leaves the fitted tone from one frequency to another, frequency and dB in turn.
#[unsafe(no_mangle)]
pub extern "C" fn picket_fitted(low_hz: f64, high_hz: f64, steps: u32) {
    page(|page| page.fitted(low_hz, high_hz, steps))
}

/// Leaves the held tracks: number, frequency, sigma, misses.
#[unsafe(no_mangle)]
pub extern "C" fn picket_tracks() {
    page(Page::tracks)
}

/// Leaves what swings in the displacement: of each swing amplitude, sigma, frequency, sigma, amplitude of the velocity, sigma, and the verdict's
/// number.
#[unsafe(no_mangle)]
pub extern "C" fn picket_swings() {
    page(Page::swings)
}

/// Leaves the settings in use: N, I/Q, rate, kind, full scale, whether the rate is known, metres per second of a hertz or 0, samples of a
/// record of its own or 0, whether targets of frames are measured, whether the displacement is followed; records, missing, damaged frames, raw blocks of a board.
#[unsafe(no_mangle)]
pub extern "C" fn picket_state() {
    page(Page::state)
}

/// The checksum of this many random blocks, for a comparison with other machines.
#[unsafe(no_mangle)]
pub extern "C" fn picket_checksum(fixed: u32, blocks: u32) -> u64 {
    check::checksum(fixed != 0, blocks).checksum
}

/// The checksum of a scene's samples, for the same comparison.
#[unsafe(no_mangle)]
pub extern "C" fn picket_scene_checksum() -> u64 {
    check::scene_checksum().unwrap_or_default()
}

//! All tones of a block, each with its sigma and its phase.
//!
//! The page's own module measures one tone of a block. This one is loaded when somebody asks for more, and takes up what the
//! other has measured.

#[path = "../../src/row.rs"]
pub mod row;

use picket::acquire::codes::Codes;
use picket::acquire::sample::{Iq, Real, Record, Stamp};
use picket::methods::registry::Method;
use picket::spectrum::Spectrum;
use picket::spectrum::peak::Band;
use picket::tone::arithmetic::Arithmetic;
use picket::tone::detection::{FALSE_ALARM, Threshold};
use picket::tone::fit::Reach;
use picket::tone::frequency::Frequency;
use picket::tone::lines::lines;
use picket::tone::measure::Options;
use picket::tone::{Tone, Verdict, Verdicts};
use std::cell::RefCell;

/// What the page says of a block, as numbers.
pub type Terms = [f64; 14];

/// The tones of a block, at most `most`, the strongest first: a [`row`](row::row) each. `terms` are the samples' number, 1 for
/// I/Q, the bits of a code (those from 0 as a negative number), the rate in Hz, the band's first and last bin, the count
/// of clipped samples, 1 behind a gap, then the block's tone: frequency and sigma in cycles per sample, signal-to-noise ratio,
/// amplitude, the verdict's number, the bits of what applies besides. None where they cannot work.
pub fn tones(terms: &Terms, samples: &[[i16; 2]], most: usize) -> Vec<f64> {
    // A cast saturates.
    match (terms[0] as usize, terms[1] != 0.0) {
        (1024, false) => of::<Real, 1024>(terms, samples, most),
        (2048, false) => of::<Real, 2048>(terms, samples, most),
        (4096, false) => of::<Real, 4096>(terms, samples, most),
        (1024, true) => of::<Iq, 1024>(terms, samples, most),
        (2048, true) => of::<Iq, 2048>(terms, samples, most),
        (4096, true) => of::<Iq, 4096>(terms, samples, most),
        _ => None,
    }
    .unwrap_or_default()
}

fn of<R: Record, const N: usize>(
    terms: &Terms,
    samples: &[[i16; 2]],
    most: usize,
) -> Option<Vec<f64>> {
    let &[
        _,
        _,
        bits,
        rate_hz,
        low,
        high,
        clipped,
        gap,
        frequency,
        sigma,
        snr,
        amplitude,
        verdict,
        also,
    ] = terms;
    let codes = Codes::of_bits(bits > 0.0, bits.abs() as u32)?;
    let band = Band::new(low as i32, high as i32);
    // As a plan has them. A whole configuration would bring its solvers along, and their size.
    let options = Options {
        method: Method::default().of_kind::<R>(),
        reach: Reach::default(),
        arithmetic: Arithmetic::default(),
        threshold: Threshold::new(band.width(), FALSE_ALARM).with_another(),
    };
    let tone = Tone {
        frequency: Frequency::of_bins(0, frequency, 1)?,
        sigma: sigma as f32,
        snr: snr as f32,
        amplitude: amplitude as f32,
        verdict: Verdict::from_u8(verdict as u8)?,
        also: Verdicts::of_bits(also as u8),
        ..Tone::default()
    };
    let mut parts = samples.iter().copied();
    let record = std::array::from_fn(|_| R::of_parts(parts.next().unwrap_or_default()));
    let mut spectrum = Box::new(Spectrum::<R, N>::new());
    spectrum.transform(&record, codes);
    let stamp = Stamp { gap: gap != 0.0, ..Stamp::default() };
    let found = lines(&spectrum, &tone, band, clipped as u32, &stamp, &options, most);
    Some(found.iter().flat_map(|tone| row::row(tone, rate_hz)).collect())
}

/// What goes in and what comes out.
#[derive(Default)]
struct Exchange {
    terms: Terms,
    samples: Vec<[i16; 2]>,
    numbers: Vec<f64>,
}

thread_local! {
    static EXCHANGE: RefCell<Exchange> = RefCell::default();
}

/// Room for the [`Terms`]: its address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_terms() -> *mut f64 {
    EXCHANGE.with_borrow_mut(|exchange| exchange.terms.as_mut_ptr())
}

/// Room for so many samples of two codes each: its address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_samples(count: usize) -> *mut i16 {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.samples.clear();
        exchange.samples.resize(count, [0; 2]);
        exchange.samples.as_mut_ptr().cast()
    })
}

/// Finds at most so many tones in those samples; gives how many numbers it leaves.
#[unsafe(no_mangle)]
pub extern "C" fn tones_find(most: usize) -> usize {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.numbers = tones(&exchange.terms, &exchange.samples, most);
        exchange.numbers.len()
    })
}

/// Those numbers: their address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_numbers() -> *const f64 {
    EXCHANGE.with_borrow(|exchange| exchange.numbers.as_ptr())
}

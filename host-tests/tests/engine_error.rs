//! What an engine adds to a frequency, measured by an exact transform beside it. That sigma has it is in the table of claims.

use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::bins::Bins;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::spectrum::neighbourhood::{Neighbourhood, Places};
use picket_dsp::spectrum::peak::{self, Band};
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::fit::{self, FitStart};
use picket_dsp::{Codes, F32, I32, Iq, Reach, Real};
use picket_host::simulate::{Kind, Signal, Width, codes, generator};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

const CODES: Codes = Codes::signed::<16>();
const SEED: u64 = 4;

/// The records of a cell.
fn records() -> u64 {
    if std::env::var_os("PICKET_LONG").is_some() { 2000 } else { 250 }
}

/// A record of a strong tone anywhere, eight bins or more from the ends, and its place in bins.
fn record<R: Kind>(n: usize, snr_db: f64, rng: &mut ChaCha8Rng) -> (f64, Vec<Complex<f64>>) {
    let end = if R::IQ { n as f64 } else { n as f64 / 2.0 };
    let bins = rng.random_range(8.0..end - 8.0);
    (bins, record_at::<R>(bins, n, snr_db, rng))
}

/// A record of a strong tone at this place in bins.
fn record_at<R: Kind>(bins: f64, n: usize, snr_db: f64, rng: &mut ChaCha8Rng) -> Vec<Complex<f64>> {
    let amplitude = rng.random_range(0.7..0.98) * 32_767.0;
    // The codes' rounding is a part of the noise.
    let noise = amplitude * amplitude / 2.0 / 10f64.powf(snr_db / 10.0);
    let added = (noise - 1.0 / 12.0).max(1e-6);
    let snr_db = 10.0 * (amplitude * amplitude / 2.0 / added).log10();
    let signal = Signal { width: Width::Codes(CODES), ..Signal::tone(bins, amplitude, snr_db) };
    signal.record::<R>(n, rng)
}

/// The engine's error over what [`Engine::error`] says, rms over records.
fn error_over_stated<R: Kind, E: Engine, const N: usize>() -> f64 {
    let transform = f64::forward(N);
    let mut spectrum = Box::new(Spectrum::<R, N, E>::new());
    let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
    let squares = (0..records()).map(|trial| {
        let (bins, mut exact) = record::<R>(N, 98.0, &mut generator(SEED, trial));
        let samples: [R::Sample; N] = codes::<R>(&exact).try_into().unwrap();
        spectrum.transform(&samples, CODES);
        let peak = peak::find(&spectrum.view(), band).unwrap().bin;
        let ours = {
            let mut places = Places::new();
            let near = Neighbourhood::read(&spectrum.view(), peak, &mut places);
            fit::fit_near::<R>()(&near, Arithmetic::Float, Reach::Sixteen, FitStart::Usual)
                .unwrap()
                .offset
        };
        transform.process(&mut exact);
        let course = FitStart::From(bins - f64::from(peak), 6);
        let around = Bins::<f64, R, _>::gather(N, peak, |k| exact[k]);
        let fit = fit::fit(&around, Reach::Sixteen, course).unwrap();
        (f64::from(ours) - fit.offset).powi(2)
    });
    let rms = (squares.sum::<f64>() / records() as f64).sqrt();
    let ratio = rms / f64::from(spectrum.view().error());
    println!("{}, N = {N}: {rms:.2e} bin, {ratio:.2} of what is stated", R::NAME);
    ratio
}

macro_rules! engines {
    ($($engine:ident $what:ident: $($n:literal)*;)*) => {$(
        #[test]
        fn $what() {
            $(
                for ratio in [
                    error_over_stated::<Real, $engine, $n>(),
                    error_over_stated::<Iq, $engine, $n>(),
                ] {
                    assert!((0.8..1.2).contains(&ratio), "N = {}: {ratio}", $n);
                }
            )*
        }
    )*};
}

engines! {
    I32 the_integer_engine_errs_as_stated: 256 512 1024 2048 4096;
    F32 the_float_engine_errs_as_stated: 256 512 1024 2048 4096;
}

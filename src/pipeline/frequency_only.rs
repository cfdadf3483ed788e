//! A frequency without a verdict, for a program that has no room for more.

use crate::acquire::codes::Codes;
use crate::acquire::sample::Record;
use crate::frequency::Frequency;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::{Engine, I32};
use crate::spectrum::layout::Layout;
use crate::spectrum::neighbourhood::{Neighbourhood, Places};
use crate::spectrum::peak::{self, Band};
use crate::spectrum::view::View;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::fit::{self, FitNear, FitStart, Reach};
use crate::tone::noise::ring;
use crate::tone::sigma::{sigma_bins, with_rounding};

/// The frequency of the strongest line of a record, without a verdict on its use.
///
/// A record of noise alone, a dead channel of I/Q, clipped samples, a second tone, a tone that moves or one within 1.5 bins of 0 Hz: each
/// gets a frequency and a sigma here, and both are wrong. For a record of one steady tone in noise both are right. A
/// [`Pipeline`](super::Pipeline) recognises these records, and takes some three times the program memory. The frequency equals a
/// pipeline's to the bit where the record is clean and the plan is [`Plan::tone`](crate::plan::Plan::tone).
///
/// The struct is all zeros at first, so that one in static memory takes no place in the program. It owns `4 N` bytes for real records,
/// `8 N` for I/Q.
///
/// ```
/// use picket_dsp::{Codes, FrequencyOnly, Real};
///
/// # let samples: [i16; 1024] =
/// #     core::array::from_fn(|n| (900.0 * (0.131 * n as f64).sin() + 4.0 * (7.1 * n as f64).sin()) as i16);
/// let mut only = FrequencyOnly::<Real, 1024>::new();
/// if let Some(line) = only.block(&samples, Codes::signed::<12>()) {
///     println!("{} Hz ± {} Hz", line.hertz(48e3), line.sigma_hertz(48e3));
/// #     assert!((line.hertz(48e3) - 0.131 / std::f64::consts::TAU * 48e3).abs() < 0.1);
/// }
/// ```
#[derive(Clone, Debug)]
pub struct FrequencyOnly<R: Record, const N: usize, E: Engine = I32> {
    spectrum: Spectrum<R, N, E>,
}

/// A frequency with the standard deviation that noise gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Unjudged {
    /// The frequency.
    pub frequency: Frequency,
    /// One standard deviation, in cycles per sample, if the record is one steady tone in noise.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma: f32,
}

impl Unjudged {
    /// The frequency in hertz, at a sample rate of `rate_hz`.
    pub fn hertz(&self, rate_hz: f64) -> f64 {
        self.frequency.hertz(rate_hz)
    }

    /// The sigma in hertz, at a sample rate of `rate_hz`.
    pub fn sigma_hertz(&self, rate_hz: f64) -> f64 {
        f64::from(self.sigma) * rate_hz
    }
}

impl<R: Record, const N: usize, E: Engine> FrequencyOnly<R, N, E> {
    /// An instance before its first record.
    pub const fn new() -> Self {
        Self { spectrum: Spectrum::new() }
    }

    /// The strongest line of one record; `None` if there is no line to fit, as in a record of one value.
    ///
    /// The fit is least squares over 17 bins, in the core's own arithmetic. Cost: one transform, one search, one fit.
    pub fn block(&mut self, samples: &[R::Sample; N], codes: Codes) -> Option<Unjudged> {
        self.spectrum.transform(samples, codes);
        only(&self.spectrum.view(), fit::fit_near::<R>())
    }
}

/// The strongest line of a spectrum. Compiled once for all kinds and lengths of records.
fn only(view: &View, fit_near: FitNear) -> Option<Unjudged> {
    let Layout { n, iq, .. } = *view.layout;
    let band = if iq { Band::iq(n) } else { Band::real(n) };
    let peak = peak::find(view, band)?.bin;
    let (reach, arithmetic) = (Reach::Eight, Arithmetic::from_core());
    let mut places = Places::new();
    let near = Neighbourhood::read(view, peak, &mut places);
    let fit = fit_near(&near, arithmetic, reach, FitStart::Usual)?;
    let noise = ring::beside(&near, &fit, arithmetic).noise.power;
    let unseen = near.engine_error * near.engine_error;
    let sigma = with_rounding(sigma_bins(&fit, n, noise), unseen, n);
    Some(Unjudged {
        frequency: Frequency::from_fixed(peak, fit.offset_in_fixed_point()?, n),
        sigma: sigma / n as f32,
    })
}

impl<R: Record, const N: usize, E: Engine> Default for FrequencyOnly<R, N, E> {
    fn default() -> Self {
        Self::new()
    }
}

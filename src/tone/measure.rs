//! From a spectrum and its peak to a tone with sigma and verdict.
//!
//! One fit of a tone to the bins around the peak gives offset, amplitude and residual ([`fit`]); a ring of bins beside them
//! gives the noise ([`ring`]). For a noise power of P per sample and the fit's information I, sigma is
//!
//! ```text
//! sqrt(N P / (2 I)) bins
//! ```
//!
//! The residual over the noise decides whether the line is one steady tone ([`judge`](super::judge)). Where it is not, the fit takes more
//! steps, then a drift beside the tone, then the joint fit of [`crate::model`], as far as the effort allows. The line must exceed the
//! noise, and the samples and the rest of the spectrum must look as a good front end makes them. All results are one [`Evidence`], which
//! decides the verdict.

use super::arithmetic::Arithmetic;
use super::clipped::part::Part;
use super::detection::Threshold;
use super::detector::stands_out;
use super::effort::Effort;
use super::evidence::{EDGE_BINS, Evidence, edge_bins};
use super::fit::{self, Fit, FitStart, Reach};
use super::frequency::Frequency;
use super::front_end::{Glance, Sight, lines, other_lines};
use super::image::mirrored;
use super::judge::{FitTest, Line, chosen, judge};
use super::noise::ring::{self, LocalNoise};
use super::noise::{Noise, ratio};
use super::observer::{Observer, Statistic, Step, Test};
use super::sigma::{self, CLIPPED, bound_bins, sigma_bins, with_rounding};
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Iq, Real, Record, Stamp};
use crate::carrier::Width;
use crate::math::scalar::Scalar;
use crate::methods::registry::Method;
use crate::model::block::joint;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::{Engine, RESIDUE};
use crate::spectrum::neighbourhood::{Neighbourhood, Places};
use crate::spectrum::peak::Peak;
use crate::tone::clipped::CensoredFit;
use crate::tone::fit::leaked::{Leakage, Nearest};
use crate::tone::{FrequencyDrift, Reasons, Tone};
use num_complex::Complex;

/// The parameters of a tone's measurement beside the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The method of estimation.
    pub method: Method,
    /// The number of bins on each side that least squares reads.
    pub reach: Reach,
    /// The arithmetic of least squares.
    pub arithmetic: Arithmetic,
    /// The detection threshold.
    pub threshold: Threshold,
    /// The effort spent on a line that is not a steady tone.
    pub effort: Effort,
    /// The effect of the carrier's own width.
    pub width: Width,
}

/// Measures the tone at `peak`, in a record of which `clipped` samples touch a rail of `codes`.
///
/// Least squares gives offset, amplitude and sigma from one fit. Any other method gives the offset alone: amplitude, noise and verdict come
/// from least squares, so that `good` has one meaning. Sigma is then the largest of three numbers: least squares' own sigma, the Cramer-Rao
/// bound times the method's efficiency, and the distance between the two answers, which includes the method's bias.
///
/// If more than 1 % of the samples clip, noise and sigma come from the other samples (see [`CensoredFit`]), whatever the method. The
/// censored fit costs one more pass over the samples.
pub fn measure<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    samples: &[R::Sample; N],
    peak: &Peak,
    codes: Codes,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
) -> Tone {
    let (mut tone, evidence) = weigh(spectrum, samples, peak, codes, clipped, stamp, options, ());
    tone.conclude(&evidence);
    tone
}

/// Measures as [`measure`] does, and leaves the verdict to a caller with more evidence: returns the tone, so far good, and the evidence.
#[expect(clippy::too_many_arguments, reason = "one more than measure, for who listens")]
pub(crate) fn weigh<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    samples: &[R::Sample; N],
    peak: &Peak,
    codes: Codes,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    observer: impl Observer,
) -> (Tone, Evidence) {
    /// No tone.
    const NO_TONE: (Tone, Evidence) = (Tone::ZERO, Evidence::NO_TONE);
    let arithmetic = options.arithmetic.available();
    let mut places = Places::new();
    let around = &Neighbourhood::read(spectrum, peak.bin, &mut places);
    // Asked within the closure, where a program of one arithmetic has a constant, so that it links one fit.
    let fitted = |reach, course| {
        fit::fit_near::<R, N>(around, options.arithmetic.available(), reach, course)
    };
    let method = options.method;
    let mut answer = None;
    if !method.is_least_squares() {
        // A checked plan has no method that its records or the program cannot use.
        let Ok(offset) = method.offset_target(spectrum, samples, peak.bin) else {
            return NO_TONE;
        };
        answer = Some(offset.to_num::<f32>());
    }
    // In place, because a fit would be copied.
    let Some(fit) = &mut fitted(options.reach, FitStart::Usual) else {
        return NO_TONE;
    };
    let ring = ring::beside::<R, N>(around, fit, arithmetic);
    let mut local_noise = ring;
    let clipped = clipped as f32 / N as f32;
    // In software floats a fit to few bins takes a quarter of a block's time.
    let may_refine = clipped <= CLIPPED && matches!(arithmetic, Arithmetic::Float);
    let nearest = || Nearest::from_neighbourhood(around);
    let mut leakage = Leakage::default();
    observer.hear(|| local_noise.edge());
    if local_noise.has_edge() {
        leakage = leakage_at_edge(&mut local_noise, may_refine.then(nearest).as_ref(), fit, N);
    }
    let noise = local_noise.noise.power;
    let from_end = around.from_end();
    let judged = |fit: &Fit<f32>, step| {
        observer.begin(step);
        judged(fit, N, from_end, &local_noise, clipped, stamp.segment.bends(), observer)
    };
    let mut judgement = judged(fit, Step::Usual);
    observer.judged(&judgement, true);
    // A line that is not a steady tone takes more steps to the fit's end. A clipped tone has harmonics, which no step lessens.
    if judgement.line != Line::Steady
        && clipped <= CLIPPED
        && let Some(more) =
            fitted(options.reach, FitStart::Further(fit.offset, options.effort.steps()))
    {
        *fit = more;
        judgement = judged(fit, Step::Further);
        observer.judged(&judgement, true);
        // A steady tone beside a drift is steady.
        if options.effort.fits_beside_slow()
            && judgement.line != Line::Steady
            && let Some(other) =
                fit::fit_beside_slow(spectrum, around, arithmetic, options.reach, fit, noise)
        {
            let beside_slow = judged(&other, Step::BesideDrift);
            observer.judged(&beside_slow, beside_slow.line < judgement.line);
            if beside_slow.line < judgement.line {
                judgement = match beside_slow.line {
                    Line::Steady => chosen(&other, N, &local_noise, beside_slow),
                    _ => beside_slow,
                };
                *fit = other;
            }
        }
    }
    let FitTest { line: class, variance_inflation } = judgement;
    let mut inflated = noise * variance_inflation;
    let mut censored = None;
    if clipped > CLIPPED {
        censored = CensoredFit::from_fit(Part::first::<R>(samples), codes, peak.bin, fit);
        // If the line is not a single tone, its residual counts.
        if class == Line::Steady {
            inflated = near_of(&censored, fit, N, clipped, inflated);
        }
    }
    let sigma = sigma_bins(fit, N, inflated + ring::unseen_rounding(around, &local_noise));
    let sigma =
        if clipped > CLIPPED { widened(&censored, sigma, inflated, clipped) } else { sigma };
    local_noise.loud = local_noise.loud.max(leakage.loud);
    // The factor by which the selection of a tone near the threshold widens sigma; none if the line is not detected.
    let mut selection = stands_out(spectrum, around, peak, fit, &local_noise, options, observer);
    let image = R::IQ && mirrored(around, fit, &local_noise.noise, observer);
    let mut sigma = sigma;
    if may_refine && class == Line::Unresolved {
        let refined = leakage.refined(&nearest(), noise, fit, sigma);
        observer.hear(|| Test {
            statistic: Statistic::Nearest,
            value: sigma / refined,
            limit: 1.0,
        });
        sigma = refined;
    }
    observer.fitted(peak.bin, fit, noise);
    let (mut class, mut reported_noise) =
        (class, censored.map_or(noise, |censored| censored.noise));
    // At effort `Full` alone.
    if class != Line::Steady
        && let (threshold, bends) = (options.threshold, stamp.segment.bends())
        && let Some((answer, noise)) = joint(around, fit, &ring, threshold, options.effort, bends)
    {
        observer.joint(&answer);
        if !answer.unresolved {
            class = if answer.moves { Line::Moving } else { Line::Steady };
            (fit.offset, fit.line) = (answer.offset, answer.line);
            (sigma, reported_noise, inflated) = (answer.variance.root(), noise, noise);
            selection = Some(selection.unwrap_or(1.0));
        }
    }
    // A record with another verdict needs no test of its front end.
    let check_front_end = selection.is_some()
        && class != Line::Unresolved
        && !image
        && clipped <= CLIPPED
        && edge_bins_at(R::IQ, N, peak.bin, fit.offset) >= EDGE_BINS;
    let front_end = check_front_end && {
        let unit = around.unit();
        let others = || peak.floor as f32 * (unit * unit);
        observer.hear(|| other_lines(others(), fit));
        let glance = Glance::from_search(spectrum, peak, codes, [unit, noise]);
        !glance.is_clear() && {
            let sight = Sight {
                n: N,
                iq: R::IQ,
                peak: peak.bin,
                fit,
                noise,
                others: others(),
                pairs: R::pairs(samples),
                codes,
                bin: &|k| in_codes(spectrum.bin(k), unit),
                // A cast saturates.
                lines: &|least| lines(spectrum, peak.bin, (least / (unit * unit)) as u64),
            };
            sight.is_faulty(glance, observer)
        }
    };
    let mut sigma = sigma * selection.unwrap_or(1.0);
    if let Some(offset) = answer {
        let snr = ratio::<f32, R>(N, fit.amplitude_squared::<R>(N), inflated);
        let theirs = method.efficiency() * bound_bins::<R>(N, snr);
        sigma = sigma.max(theirs).max((offset - fit.offset).abs());
        fit.offset = offset;
    }
    let seen = Seen {
        noise: reported_noise,
        line: class,
        clipped,
        image,
        front_end,
        gap: stamp.gap,
        weak: selection.is_none(),
        sigma,
        unseen: unseen(around.engine, &options.width, sigma, fit, N, reported_noise),
    };
    seen.tone::<R, N>(peak.bin, fit).unwrap_or(NO_TONE)
}

/// A bin in codes.
fn in_codes(Complex { re, im }: Complex<i32>, unit: f32) -> Complex<f32> {
    Complex::new(re as f32 * unit, im as f32 * unit)
}

/// The rise of the frequency of the tone at bin `peak` within the record; `None` if least squares finds no tone.
///
/// Cost: that of [`measure`] once more.
pub fn rise<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    options: &Options,
) -> Option<FrequencyDrift> {
    let mut places = Places::new();
    let near = Neighbourhood::read(spectrum, peak, &mut places);
    let fit = fit::fit_near::<R, N>(&near, Arithmetic::Float, options.reach, FitStart::Usual)?;
    let beside = ring::beside::<R, N>(&near, &fit, Arithmetic::Float);
    Some(FrequencyDrift::from_fit(&fit, N, beside.noise.power))
}

/// The line's class, and the factor by which its variance exceeds the variance that the noise causes.
///
/// For a clipped record, whose harmonics are not a movement, only whether the residual is too large.
fn judged(
    fit: &Fit<f32>,
    n: usize,
    from_end: i32,
    beside: &LocalNoise,
    clipped: f32,
    bends: bool,
    observer: impl Observer,
) -> FitTest {
    if clipped <= CLIPPED {
        return judge(fit, n, from_end, beside, bends, observer);
    }
    // Harmonics of a clipped tone may be on the louder side, and twice as strong at the tone.
    // Sigma includes them, see [`CensoredFit`].
    let noise = Noise { power: 2.0 * beside.loud, ..beside.noise };
    let variance_inflation = excess_over(fit, n, noise);
    observer.hear(|| Test {
        statistic: Statistic::ClippedResidual,
        value: fit.residual / (noise.power * expected(fit, n)),
        limit: excess_limit(fit.dof, noise),
    });
    let line = if variance_inflation > 1.0 { Line::Unresolved } else { Line::Steady };
    FitTest { line, variance_inflation }
}

/// The noise at an edge: the residual of the fit from five bins off, see [`LocalNoise::on_an_edge`], or the quieter side's noise if a line
/// makes the edge.
#[inline(never)]
fn leakage_at_edge(
    beside: &mut LocalNoise,
    nearest: Option<&Nearest>,
    fit: &Fit<f32>,
    n: usize,
) -> Leakage {
    /// Degrees of freedom of the bins five to eight off.
    const MIDDLE: f32 = 16.0;
    /// Another line leaks if a fit without the leakage leaves this many times less.
    const LEAKED: f32 = 6.0;
    let mut leakage = Leakage { loud: beside.loud, on_an_edge: true, nine: None };
    let Some(rest) = rest_from_five(fit, n, MIDDLE) else {
        return leakage;
    };
    leakage.nine = nearest.and_then(|nearest| nearest.nine(fit.offset));
    let leaks = leakage.nine.is_some_and(|nine| rest > LEAKED * nine.left);
    leakage.on_an_edge = !leaks;
    *beside = if leaks { beside.quieter(MIDDLE) } else { beside.on_an_edge(rest, MIDDLE) };
    leakage
}

/// The noise power per sample in a fit's residual from five bins off. `free`: degrees of freedom of bins 5 to 8.
fn rest_from_five(fit: &Fit<f32>, n: usize, free: f32) -> Option<f32> {
    /// Degrees of freedom of the bins beyond, in a fit that reaches them.
    const FAR: f32 = 32.0;
    /// The sum of 16 squares over the sum of 8 squares: noise exceeds this ratio in one block of a hundred (Fisher's distribution).
    const LINE: f32 = 11.0;
    if fit.dof < 31 {
        return None;
    }
    let [two, four, eight] = fit.rest.within;
    // If five bins off the residual is this much louder than three bins off, another line makes it, not noise.
    if eight - four > LINE * (four - two) {
        return None;
    }
    let (middle, all) = ((eight - four) / free, (fit.residual - four) / (free + FAR));
    // The edge may be among these bins. Then the nearer ones are louder, or the tone is on the
    // quiet side.
    let power = if middle > 1.5 * all { middle } else { all };
    Some(power * (2.0 / n as f32))
}

// Both are compiled once for all kinds and lengths of records.
#[inline(never)]
fn near_of(free: &Option<CensoredFit>, fit: &Fit<f32>, n: usize, clipped: f32, noise: f32) -> f32 {
    free.map_or(noise, |free| free.near(residual(fit, n), clipped))
}

#[inline(never)]
fn widened(free: &Option<CensoredFit>, sigma: f32, near: f32, clipped: f32) -> f32 {
    match free {
        Some(free) => free.widened(sigma, near),
        None => sigma::widened(sigma, clipped),
    }
}

/// The measurement's results beside the fit.
pub(super) struct Seen {
    /// Noise power per sample.
    pub noise: f32,
    /// The line's class.
    pub line: Line,
    /// The share of the samples that touch a rail.
    pub clipped: f32,
    /// An I/Q record has too strong a line at minus the frequency.
    pub image: bool,
    /// The lines are those of a faulty front end.
    pub front_end: bool,
    /// Samples are missing.
    pub gap: bool,
    /// The peak is below the detection threshold.
    pub weak: bool,
    /// Sigma in bins, of the noise alone.
    pub sigma: f32,
    /// The variance in squared bins that does not show as noise: the engine's error, and the effect of the tone's own width.
    pub unseen: f32,
}

/// The variance, in squared bins, that does not show as noise: the engine's error, and what the tone's own width adds to `sigma`. The fit's
/// residual may have widened `sigma` beyond the noise already.
#[inline(never)]
fn unseen(engine: f32, width: &Width, sigma: f32, fit: &Fit<f32>, n: usize, noise: f32) -> f32 {
    let engine = engine * engine;
    // In integers, because a core without an FPU does it in each block.
    if width.walk.to_bits() | width.envelope.to_bits() == 0 {
        return engine;
    }
    let alone = sigma_bins(fit, n, noise);
    engine + (width.of_block() - (sigma * sigma - alone * alone)).max(0.0)
}

impl Seen {
    /// The tone, good so far, and the evidence on it; `None` if the offset is not a number.
    pub(super) fn tone<R: Record, const N: usize>(
        &self,
        peak: i32,
        fit: &Fit<f32>,
    ) -> Option<(Tone, Evidence)> {
        self.tone_of(R::IQ, N, peak, fit)
    }

    // Quotients by the length are constants.
    #[inline(always)]
    fn tone_of(&self, iq: bool, n: usize, peak: i32, fit: &Fit<f32>) -> Option<(Tone, Evidence)> {
        let power =
            if iq { fit.amplitude_squared::<Iq>(n) } else { fit.amplitude_squared::<Real>(n) };
        let ratio = if iq { ratio::<f32, Iq> } else { ratio::<f32, Real> };
        let snr = ratio(n, power, self.noise);
        let evidence = Evidence {
            said: Reasons::NONE,
            found: true,
            // A line whose power is no more than the noise within it cannot be distinguished from noise.
            detected: !self.weak && snr > 0.0,
            line: self.line,
            image: self.image,
            front_end: self.front_end,
            gap: self.gap,
            clipped: self.clipped,
            edge_bins: edge_bins_at(iq, n, peak, fit.offset),
            sigma: self.sigma / n as f32,
            // Known from the samples, see [`block`].
            outside: false,
            beyond: 0,
        };
        let tone = Tone {
            frequency: Frequency::from_fixed(peak, fit.offset_in_fixed_point()?, n),
            sigma: with_rounding(self.sigma, self.unseen, n) / n as f32,
            snr,
            amplitude: power.root(),
            ..Tone::ZERO
        };
        Some((tone, evidence))
    }
}

/// [`edge_bins`] of a tone at an offset from its peak; infinite if the tone is far from any edge.
#[inline(always)]
fn edge_bins_at(iq: bool, n: usize, peak: i32, offset: f32) -> f32 {
    let half = n as i32 / 2;
    // An I/Q peak may count negative frequencies from 0 down or from N down.
    let peak = if iq && peak > half { peak.wrapping_sub(n as i32) } else { peak };
    if (4..half - 4).contains(&peak.abs()) {
        return f32::INFINITY;
    }
    edge_bins(iq, n, peak as f32 + offset)
}

/// The noise power per sample in a fit's own residual.
pub fn residual<T: Scalar>(fit: &Fit<T>, n: usize) -> T {
    fit.residual / expected(fit, n)
}

/// The residual in a fit's bins for noise of power 1 per sample: half the degrees of freedom times the power of a bin, `n`.
pub(super) fn expected<T: Scalar>(fit: &Fit<T>, n: usize) -> T {
    T::from_i32((n as i32 / 2).wrapping_mul(fit.dof.max(1) as i32))
}

/// The ratio of the residual to the noise power in a record of `n` samples, if less than one record in 10^6 reaches this ratio by chance;
/// otherwise 1. Above 1 the line is not a single tone: another is near, or its frequency moves.
///
/// The ratio of two noise estimates follows Fisher's distribution; its cube root is nearly normal
/// (Wilson and Hilferty 1931). The integer FFT itself leaves a share of the line.
pub fn excess_over<T: Scalar>(fit: &Fit<T>, n: usize, noise: Noise) -> T {
    let expected = T::new(noise.power.into()) * expected(fit, n);
    // No fit has enough degrees of freedom to make twice the noise improbable.
    if fit.residual <= expected + expected {
        return T::one();
    }
    let rest = fit.residual - T::new(RESIDUE) * fit.line.norm_sqr();
    let ratio = rest / expected;
    if ratio > T::new(excess_limit(fit.dof, noise).into()) { ratio } else { T::one() }
}

/// The ratio of a residual with these degrees of freedom to the noise power, exceeded by chance in one record of 10^6.
pub fn excess_limit(dof: u32, noise: Noise) -> f32 {
    /// A normal distribution exceeds this limit once in 3.5 million times; the cube root, whose tail is a little heavier, once in 10^6.
    const DEVIATIONS: f32 = 5.0;
    let dof = dof.max(1) as f32;
    let deviation = (2.0 / 9.0 * (1.0 / dof + 1.0 / noise.dof)).root();
    let root = 1.0 + DEVIATIONS * deviation;
    root * root * root
}

//! From the transform of a block to a tone with sigma and verdict: `with_evidence` takes the steps from the fit on of
//! [the crate's list](crate#how-a-block-becomes-a-tone).
//!
//! One fit of a tone to the bins around the peak gives offset, amplitude and residual ([`fit`]); a ring of bins beside them
//! gives the noise ([`ring`]). For a noise power of P per sample and the fit's information I, sigma is
//!
//! ```text
//! sqrt(s^2 N (v P + r) / (2 I) + u) bins
//! ```
//!
//! with v the factor of the judgement, r the part of the engine's rounding that the ring does not see, s the factor of a line near the
//! threshold, and u the engine's error, the carrier's width and the rounding of the frequency. A usual line has v = s = 1.
//!
//! The residual over the noise decides whether the line is one steady tone (`judge`). If it is not, the joint fit of [`crate::model`]
//! follows; with no rounds of effort, the fit takes more steps instead. The line must exceed the noise, and the samples and the rest of the
//! spectrum must be as a good front end makes them: a usual block ends at `QuickTest::is_clear`. All results are one [`Evidence`], and the
//! verdict is the highest severity that applies. Code that most blocks do not run is in `unusual`.

mod unusual;

use super::arithmetic::Arithmetic;
use super::clipped::CensoredFit;
use super::clipped::part::Part;
use super::detection::stands_out;
use super::evidence::{EDGE_BINS, Evidence, edge_bins};
use super::fit::{self, Fit, FitNear, FitStart};
use super::front_end::{edges, has_fault, is_full};
use super::image::mirrored;
use super::judge::{first_look, judge};
use super::line_class::{FitTest, LineClass};
use super::noise::ring::{self, LocalNoise};
use super::noise::{Noise, ratio};
use super::observer::{Step, Tap};
use super::options::Options;
use super::residual::{excess_limit, excess_over, expected};
use super::sigma::{CLIPPED, sigma_bins, with_rounding};
use super::statistic::{Statistic, Test};
use super::{FrequencyDrift, Reasons, Tone};
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Data, Stamp};
use crate::carrier::Width;
use crate::frequency::Frequency;
use crate::math::scalar::Scalar as _;
use crate::spectrum::layout::Layout;
use crate::spectrum::neighbourhood::{Neighbourhood, Places};
use crate::spectrum::peak::Peak;
use crate::spectrum::view::View;

/// Measures the tone at `peak`, in a record of which `clipped` samples touch a rail of `codes`.
///
/// Least squares gives offset, amplitude and sigma from one fit. Any other method gives the offset alone: amplitude, noise and verdict come
/// from least squares, so that `good` has one meaning. Sigma is then the largest of three numbers: least squares' own sigma, the Cramer-Rao
/// bound times the method's efficiency, and the distance between the two answers, which includes the method's bias.
///
/// If more than 1 % of the samples clip, noise and sigma come from the other samples (see [`CensoredFit`]), whatever the method. The
/// censored fit costs one more pass over the samples.
#[expect(clippy::too_many_arguments, reason = "benchmarks count it as one stage")]
pub fn measure(
    view: &View,
    fit_near: FitNear,
    data: Data,
    peak: &Peak,
    codes: Codes,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
) -> Tone {
    let (mut tone, evidence) =
        with_evidence(view, fit_near, data, peak, codes, clipped, stamp, options, ());
    tone.conclude(&evidence);
    tone
}

/// No tone.
pub(crate) const NO_TONE: (Tone, Evidence) = (Tone::ZERO, Evidence::NO_TONE);

/// Like [`measure`], but returns the evidence without a verdict, so that the caller can add to it; the tone is `good` so far.
#[expect(clippy::too_many_arguments, reason = "takes measure's arguments and an observer")]
#[inline(never)] // one with an observer, one without
pub(crate) fn with_evidence(
    view: &View,
    fit_near: FitNear,
    data: Data,
    peak: &Peak,
    codes: Codes,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    observer: impl Tap,
) -> (Tone, Evidence) {
    let Layout { n, iq, .. } = *view.layout;
    let arithmetic = options.arithmetic.available();
    let mut places = Places::new();
    let around = &Neighbourhood::read(view, peak.bin, &mut places);
    let mut by_method = None;
    if !options.method.is_least_squares() {
        // A checked plan has no method that its records or the program cannot use.
        let Ok(offset) = options.method.offset_target(view, data, peak.bin) else {
            return NO_TONE;
        };
        by_method = Some(offset.to_num::<f32>());
    }
    // Fit: changed in place, which saves a copy.
    let reach = options.reach;
    let Some(fit) = &mut fit_near(around, arithmetic, reach, FitStart::Usual) else {
        return NO_TONE;
    };
    // Noise. A step in the noise floor next to the tone is rare.
    let ring = ring::beside(around, fit, arithmetic);
    let clipped = clipped as f32 / n as f32;
    let mut beside = ring;
    observer.hear(|| beside.edge());
    let rounds = options.effort.available().rounds();
    if beside.has_edge() {
        unusual::at_edge(&mut beside, fit, n);
    }
    let noise = beside.noise.power;
    // Judgement. A clipped tone has harmonics, which are no change of the tone.
    let bends = stamp.segment.bends();
    let context = LineContext { n, from_end: around.from_end(), bends, rounds };
    let judged = |fit: &Fit<f32>, step| {
        observer.begin(step);
        let judgement = judge_unless_clipped(fit, &context, &beside, clipped, observer);
        observer.judged(&judgement, true);
        judgement
    };
    let mut judgement = judged(fit, Step::Usual);
    if context.rounds == 0 && judgement.line != LineClass::Steady && clipped <= CLIPPED {
        judgement = unusual::further(fit_near, around, options, fit, judgement, judged);
    }
    let FitTest { line: mut class, variance_inflation } = judgement;
    // Sigma, of a clipped record by its other samples.
    let mut inflated = noise * variance_inflation;
    let mut censored = None;
    if clipped > CLIPPED {
        censored = CensoredFit::from_fit(Part::first(data), codes, peak.bin, fit);
        // If the line is not a single tone, its residual counts.
        if class == LineClass::Steady {
            inflated = unusual::near_of(&censored, fit, n, clipped, inflated);
        }
    }
    let mut sigma = sigma_bins(fit, n, inflated);
    if clipped > CLIPPED {
        sigma = unusual::widened(&censored, sigma, inflated, clipped);
    }
    // Detection: the factor by which the selection of a tone near the threshold widens sigma; none if the line is not detected.
    beside.loud = beside.loud.max(ring.loud);
    let mut selection = stands_out(view, around, peak, fit, &beside, options, observer);
    let image = iq && mirrored(around, fit, &beside.noise, observer);
    observer.fitted(peak.bin, fit, noise);
    let mut joined = 0;
    let mut reported_noise = censored.map_or(noise, |censored| censored.noise);
    let mut quiet = None;
    if class == LineClass::Steady && ring.has_edge() && rounds > 0 && !bends && clipped <= CLIPPED {
        quiet = unusual::beside_a_line(&ring, fit, n);
    }
    let unsteady = class != LineClass::Steady || quiet.is_some();
    if unsteady
        && !(clipped > CLIPPED && unusual::has_harmonic_on_it(around, fit))
        && let Some(joint) = unusual::joint(
            around,
            fit,
            quiet.as_ref().unwrap_or(&ring),
            options,
            bends,
            clipped > CLIPPED,
            class,
            observer,
        )
    {
        (class, sigma) = (joint.class, joint.sigma);
        if clipped <= CLIPPED && is_full(view, data, peak, codes, around.unit(), fit) {
            class = LineClass::Unresolved;
        }
        if !iq {
            let edges = edges(data, peak.bin as f32 + fit.offset, n);
            sigma = (sigma * sigma + edges).root();
        }
        (inflated, joined) = (joint.noise, joint.joined);
        reported_noise = censored.map_or(joint.noise, |censored| censored.noise);
        if joint.found {
            selection = Some(selection.unwrap_or(1.0));
        }
    }
    // Front end. A record with another verdict needs no test of it.
    let front_end = selection.is_some()
        && class != LineClass::Unresolved
        && !image
        && clipped <= CLIPPED
        && edge_bins_at(iq, n, peak.bin, fit.offset) >= EDGE_BINS
        && has_fault(view, data, peak, codes, around.unit(), fit, noise, observer);
    // Verdict, by the evidence.
    sigma *= selection.unwrap_or(1.0);
    if let Some(offset) = by_method {
        sigma = unusual::by_method(iq, n, options.method, offset, fit, inflated, sigma);
    }
    let unseen = unseen(around.engine_error, &options.width, sigma, fit, n, reported_noise);
    let moving = class == LineClass::Moving;
    // A core without an FPU has no time for the rise of a steady line.
    let seen = bends && options.arithmetic.available() == Arithmetic::Float;
    let evidence = Evidence {
        said: Reasons::NONE,
        found: true,
        detected: selection.is_some(),
        line: class,
        joined,
        drift: (moving || seen).then(|| FrequencyDrift::from_fit(fit, n, noise)),
        image,
        front_end,
        gap: stamp.gap,
        // Both are the whole record's, see `Block`.
        outside: false,
        beyond: 0,
        clipped,
        edge_bins: f32::INFINITY,
        sigma: 0.0,
    };
    tone(view.layout, peak.bin, fit, reported_noise, [sigma, unseen], evidence).unwrap_or(NO_TONE)
}

/// The rise of the frequency of the tone at bin `peak` within the record; `None` if least squares finds no tone.
///
/// Cost: that of [`measure`] once more.
pub fn rise(view: &View, peak: i32, options: &Options) -> Option<FrequencyDrift> {
    let mut places = Places::new();
    let near = Neighbourhood::read(view, peak, &mut places);
    let fit = fit::fit_in_floats(&near, options.reach, FitStart::Usual)?;
    let beside = ring::beside_in_floats(&near, &fit);
    Some(FrequencyDrift::from_fit(&fit, near.n, beside.noise.power))
}

/// What the judgement of a line needs besides its fit.
struct LineContext {
    n: usize,
    from_end: i32,
    bends: bool,
    rounds: u8,
}

/// The line's class, and the factor by which its variance exceeds the variance that the noise causes. The first look alone decides if a joint
/// fit follows. A clipped record has harmonics, so only the size of its residual is tested.
fn judge_unless_clipped(
    fit: &Fit<f32>,
    &LineContext { n, from_end, bends, rounds }: &LineContext,
    beside: &LocalNoise,
    clipped: f32,
    observer: impl Tap,
) -> FitTest {
    if clipped <= CLIPPED {
        // On a ramp the close look separates the bend that a motion makes from everything else.
        return match rounds {
            1.. if !bends => first_look(fit, n, beside, observer),
            _ => judge(fit, n, from_end, beside, bends, observer),
        };
    }
    // Harmonics of a clipped tone may be on the louder side, and twice as strong at the tone.
    // Sigma includes them, see [`CensoredFit`].
    let noise = Noise { power: 2.0 * beside.loud, ..beside.noise };
    let variance_inflation = excess_over(fit, n, noise);
    observer.hear(|| {
        let ratio = fit.residual / (noise.power * expected(fit, n));
        Test::new(Statistic::ClippedResidual, ratio, excess_limit(fit.dof, noise))
    });
    let line = if variance_inflation > 1.0 { LineClass::Unresolved } else { LineClass::Steady };
    FitTest { line, variance_inflation }
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

/// The tone of a fit, good so far, with the evidence that follows from the fit; `None` if the offset is not a number. `noise` is the noise
/// power per sample, `sigma` the deviation in bins of the noise alone, `unseen` the variance in squared bins that does not show as noise.
#[inline(always)] // where the size is known at compile time, nothing is divided
pub(super) fn tone(
    &Layout { n, iq, .. }: &Layout,
    peak: i32,
    fit: &Fit<f32>,
    noise: f32,
    [sigma, unseen]: [f32; 2],
    evidence: Evidence,
) -> Option<(Tone, Evidence)> {
    let power = fit.amplitude_squared(iq, n);
    let snr = ratio(iq, n, power, noise);
    let evidence = Evidence {
        // A line whose power is no more than the noise within it cannot be distinguished from noise.
        detected: evidence.detected && snr > 0.0,
        edge_bins: edge_bins_at(iq, n, peak, fit.offset),
        sigma: sigma / n as f32,
        ..evidence
    };
    let tone = Tone {
        frequency: Frequency::from_fixed(peak, fit.offset_in_fixed_point()?, n),
        sigma: with_rounding(sigma, unseen, n) / n as f32,
        snr,
        amplitude: power.root(),
        ..Tone::ZERO
    };
    Some((tone, evidence))
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

//! The paths of a measurement that a usual block does not take: an edge of the noise, a line that is not a steady tone, a record that clips,
//! another method than least squares.

use crate::math::scalar::Scalar as _;
use crate::methods::registry::Method;
use crate::model::block;
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::spectrum::view::View;
use crate::tone::clipped::CensoredFit;
use crate::tone::close_judgement::chosen;
use crate::tone::fit::leaked::{Leakage, Nearest};
use crate::tone::fit::{self, Fit, FitNear, FitStart};
use crate::tone::line_class::{FitTest, LineClass};
use crate::tone::noise::ratio;
use crate::tone::noise::ring::LocalNoise;
use crate::tone::observer::{Step, Tap};
use crate::tone::options::Options;
use crate::tone::residual::residual;
use crate::tone::sigma::{self, bound_bins};

/// The noise at an edge: the residual of the fit from five bins off, see [`LocalNoise::on_an_edge`], or the quieter side's noise if a line
/// makes the edge.
#[inline(never)]
pub(super) fn at_edge(
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

/// A line that is no steady tone by the usual fit: the fit with more steps, then the fit with a drift beside the tone, if it is the better
/// one. `fit` becomes the last of these.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one place calls it")]
pub(super) fn further(
    view: &View,
    fit_near: FitNear,
    around: &Neighbourhood,
    options: &Options,
    beside: &LocalNoise,
    fit: &mut Fit<f32>,
    usual: FitTest,
    judged: impl Fn(&Fit<f32>, Step) -> FitTest,
    observer: impl Tap,
) -> FitTest {
    let (arithmetic, noise) = (options.arithmetic.available(), beside.noise.power);
    let (reach, course) = (options.reach, FitStart::Further(fit.offset, options.effort.steps()));
    let Some(more) = fit_near(around, arithmetic, reach, course) else {
        return usual;
    };
    *fit = more;
    let judgement = judged(fit, Step::Further);
    observer.judged(&judgement, true);
    // A steady tone beside a drift is steady.
    if options.effort.fits_beside_slow()
        && judgement.line != LineClass::Steady
        && let Some(other) = fit::fit_beside_slow(view, around, arithmetic, reach, fit, noise)
    {
        let beside_slow = judged(&other, Step::BesideDrift);
        let better = beside_slow.line < judgement.line;
        observer.judged(&beside_slow, better);
        if better {
            *fit = other;
            return match beside_slow.line {
                LineClass::Steady => chosen(fit, around.n, beside, beside_slow),
                _ => beside_slow,
            };
        }
    }
    judgement
}

/// The class of a line, its sigma and its noise by the joint fit, whose offset and amplitude `fit` takes over; `None` if the joint fit
/// does not resolve it, and at any effort but `Full`.
#[inline(always)]
pub(super) fn joint(
    around: &Neighbourhood,
    fit: &mut Fit<f32>,
    ring: &LocalNoise,
    options: &Options,
    bends: bool,
    observer: impl Tap,
) -> Option<(LineClass, f32, f32)> {
    let (threshold, effort) = (options.threshold, options.effort);
    let (answer, noise) = block::joint(around, fit, ring, threshold, effort, bends)?;
    observer.joint(&answer);
    if answer.unresolved {
        return None;
    }
    (fit.offset, fit.line) = (answer.offset, answer.line);
    let class = if answer.moves { LineClass::Moving } else { LineClass::Steady };
    Some((class, answer.variance.root(), noise))
}

/// Sigma of another method's offset, which `fit` takes over, see [`measure`](super::measure).
#[inline(always)]
pub(super) fn by_method(
    iq: bool,
    n: usize,
    method: Method,
    offset: f32,
    fit: &mut Fit<f32>,
    noise: f32,
    sigma: f32,
) -> f32 {
    let snr = ratio(iq, n, fit.amplitude_squared(iq, n), noise);
    let theirs = method.efficiency() * bound_bins(iq, n, snr);
    let sigma = sigma.max(theirs).max((offset - fit.offset).abs());
    fit.offset = offset;
    sigma
}

/// The noise power per sample near a tone that clips, whose bins have the power `noise`. Compiled once for all kinds and lengths of
/// records, as is [`widened`].
#[inline(never)]
pub(super) fn near_of(
    free: &Option<CensoredFit>,
    fit: &Fit<f32>,
    n: usize,
    clipped: f32,
    noise: f32,
) -> f32 {
    free.map_or(noise, |free| free.near(residual(fit, n), clipped))
}

/// Sigma of a tone that clips.
#[inline(never)]
pub(super) fn widened(free: &Option<CensoredFit>, sigma: f32, near: f32, clipped: f32) -> f32 {
    match free {
        Some(free) => free.widened(sigma, near),
        None => sigma::widened(sigma, clipped),
    }
}

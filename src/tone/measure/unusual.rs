//! The parts of a measurement that most blocks do not need: an edge of the noise, a line that is not a steady tone, a record that clips,
//! another method than least squares.

use crate::math::scalar::Scalar as _;
use crate::methods::registry::Method;
use crate::model::{Answer, Cause, block};
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::tone::clipped::CensoredFit;
use crate::tone::fit::{Fit, FitNear, FitStart};
use crate::tone::judge::first_look;
use crate::tone::line_class::{FitTest, LineClass};
use crate::tone::noise::ratio;
use crate::tone::noise::ring::LocalNoise;
use crate::tone::observer::{Step, Tap};
use crate::tone::options::Options;
use crate::tone::residual::residual;
use crate::tone::sigma::{self, bound_bins};

/// Degrees of freedom of the bins five to eight off.
const MIDDLE: f32 = 16.0;

/// The noise of the quieter side of an edge, if the line is not a steady tone in this noise: another line may make the edge.
#[inline(never)]
pub(super) fn beside_a_line(ring: &LocalNoise, fit: &Fit<f32>, n: usize) -> Option<LocalNoise> {
    let quiet = ring.quieter(MIDDLE);
    (first_look(fit, n, &quiet, ()).line != LineClass::Steady).then_some(quiet)
}

/// The noise at an edge: the residual of the fit from five bins off, see [`LocalNoise::on_an_edge`].
#[inline(never)]
pub(super) fn at_edge(beside: &mut LocalNoise, fit: &Fit<f32>, n: usize) {
    if let Some(rest) = rest_from_five(fit, n, MIDDLE) {
        *beside = beside.on_an_edge(rest, MIDDLE);
    }
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

/// A line that is not a steady tone by the usual fit, where no joint fit follows: the fit takes two more steps, and estimates its end by a
/// secant.
#[inline(always)]
pub(super) fn further(
    fit_near: FitNear,
    around: &Neighbourhood,
    options: &Options,
    fit: &mut Fit<f32>,
    usual: FitTest,
    judged: impl Fn(&Fit<f32>, Step) -> FitTest,
) -> FitTest {
    const STEPS: u32 = 2;
    let course = FitStart::Further(fit.offset, STEPS);
    match fit_near(around, options.arithmetic.available(), options.reach, course) {
        Some(more) => {
            *fit = more;
            judged(fit, Step::Further)
        }
        None => usual,
    }
}

/// A line by the joint fit.
pub(super) struct Explained {
    /// Its class.
    pub class: LineClass,
    /// Sigma, bins.
    pub sigma: f32,
    /// The noise power per sample.
    pub noise: f32,
    /// Whether the line exceeds this noise.
    pub found: bool,
    /// The causes that joined the fit, but for the bend of a ramp.
    pub joined: u8,
}

/// Whether a harmonic of a tone that clips folds onto the tone itself, where no fit can separate both: the next order to fold there is `k - 1` or
/// `k + 1` if `k` times the tone is a multiple of the rate.
pub(super) fn has_harmonic_on_it(around: &Neighbourhood, fit: &Fit<f32>) -> bool {
    /// Bins: half of what resolves two lines.
    const ON: f32 = 0.5;
    /// Weaker harmonics are below what clipping adds to sigma.
    const HIGHEST: i32 = 9;
    let n = around.n as i32;
    (1..=HIGHEST).any(|k| {
        // N is a power of two.
        let whole = (k.wrapping_mul(around.peak).wrapping_add(n / 2) & (n - 1)) - n / 2;
        (whole as f32 + k as f32 * fit.offset).abs() < ON
    })
}

/// The joint fit of a line that is not a steady tone; `fit` takes over its offset and amplitude. `None` if the effort has no rounds, or
/// nothing can be fitted.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one place calls it")]
pub(super) fn joint(
    around: &Neighbourhood,
    fit: &mut Fit<f32>,
    ring: &LocalNoise,
    options: &Options,
    bends: bool,
    clips: bool,
    class: LineClass,
    observer: impl Tap,
) -> Option<Explained> {
    let (threshold, effort) = (options.threshold, options.effort);
    let (answer, noise, found) = block::joint(around, fit, ring, threshold, effort, bends)?;
    observer.joint(&answer);
    // A harmonic of a clipped tone may be so near that no fit separates it from a change.
    if clips && (answer.unresolved || answer.moves) {
        return None;
    }
    // Where the tests resolve the line, their answer stands: on a ramp the close look knows a bend of any size.
    if answer.unresolved && class != LineClass::Unresolved {
        return None;
    }
    // The joint fit does not know all harmonics of a clipped tone, so sigma covers the distance to the answer of the usual fit.
    let apart = if clips { answer.offset - fit.offset } else { 0.0 };
    // The phase stays that of the usual fit.
    let grown = (answer.line.norm_sqr() / fit.line.norm_sqr()).root();
    (fit.offset, fit.line) = (answer.offset, fit.line * grown);
    // A carrier whose stated width explains the change may change in ways that no cause describes.
    let wide = answer.moves && answer.variance < options.width.of_block();
    let class = match answer {
        Answer { unresolved: true, .. } if !wide => LineClass::Unresolved,
        Answer { moves: true, .. } => LineClass::Moving,
        _ => LineClass::Steady,
    };
    // A motion bends the phase of a ramp's tone so far that it looks like other changes, too. They are not another line.
    let counts = |cause: Cause| !bends || matches!(cause, Cause::Line | Cause::Sidebands);
    let kept = Cause::ALL.into_iter().zip(answer.kept);
    let joined = kept.filter(|(cause, _)| counts(*cause)).map(|(_, count)| count).sum();
    // A line alone is detected by the tests that every line must pass.
    let found = found && answer.kept.iter().any(|count| *count > 0);
    let sigma = (answer.variance + apart * apart).root();
    Some(Explained { class, sigma, noise, found, joined })
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

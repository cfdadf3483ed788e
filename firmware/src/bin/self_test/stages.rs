//! The stages of a measurement, and the core's cycles in each.

use core::hint::black_box;
use cortex_m::peripheral::DWT;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Data, Real, Stamp, Statistics};
use picket_dsp::plan::Plan;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::peak::{self, Peak};
use picket_dsp::tone::Tone;
use picket_dsp::tone::fit::fit_near;
use picket_dsp::tone::measure::measure;
use picket_firmware::nucleo_f446re::N;

const CODES: Codes = Codes::unsigned::<12>();
const PLAN: Plan<Real, N> = Plan::tone(1.0, CODES);

/// A block and its intermediate results.
pub struct Work {
    pub samples: [i16; N],
    spectrum: Spectrum<Real, N>,
    clipped: u32,
    peak: Option<Peak>,
    pub tone: Option<Tone>,
}

impl Work {
    pub const fn new() -> Self {
        let samples = [0; N];
        Work { samples, spectrum: Spectrum::new(), clipped: 0, peak: None, tone: None }
    }
}

#[inline(never)]
fn transform(work: &mut Work) {
    work.clipped = Statistics::clipped(Data::of::<Real>(&work.samples), CODES);
    work.spectrum.transform(&work.samples, CODES);
}

#[inline(never)]
fn search(work: &mut Work) {
    work.peak = peak::find(&work.spectrum.view(), PLAN.band);
}

#[inline(never)]
fn estimate(work: &mut Work) {
    if let Some(peak) = &work.peak {
        let (stamp, options) = (Stamp::default(), &PLAN.options);
        let (spectrum, samples) = (&work.spectrum.view(), Data::of::<Real>(&work.samples));
        work.tone = Some(measure(
            spectrum,
            fit_near::<Real>(),
            samples,
            peak,
            CODES,
            work.clipped,
            &stamp,
            options,
        ));
    }
}

/// A stage of a measurement.
pub type Stage = fn(&mut Work);

/// The stages in their order, with their names.
pub const STAGES: [(&str, Stage); 3] =
    [("transform", transform), ("search", search), ("estimate", estimate)];

/// The cycles of a stage, without its call.
pub fn cycles(stage: Stage, work: &mut Work) -> u32 {
    fn nothing(_: &mut Work) {}
    let count = |stage: Stage, work: &mut Work| {
        cortex_m::interrupt::free(|_| {
            let before = DWT::cycle_count();
            black_box(stage)(work);
            DWT::cycle_count().wrapping_sub(before)
        })
    };
    let call = count(nothing, work);
    count(stage, work).saturating_sub(call)
}

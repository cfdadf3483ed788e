//! The firmware's way: the core's spectrum and pipeline.

use super::explained::{Explained, Notes};
use super::{Engine, Estimate, Frequencies, within};
use crate::estimator::{Estimator, reached};
use crate::recording::Sample;
use crate::simulate::{Kind, code};
use fixed::types::I2F30;
use picket_dsp::acquire::sample::{Data, Record, Stamp};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::{Plan, Terms};
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_dsp::spectrum::neighbourhood::{Neighbourhood, Places};
use picket_dsp::spectrum::{Spectrum, peak};
use picket_dsp::tone::Tone;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::evidence::Evidence;
use picket_dsp::tone::fit::{FitStart, fit_near};
use picket_dsp::tone::options::Options;
use picket_transform::num_complex::Complex;

/// An engine for `N` samples, a length of the integer FFT.
#[derive(Debug)]
pub(super) struct Target<R: Record, const N: usize> {
    plan: Plan<R, N>,
    spectrum: Box<Spectrum<R, N>>,
    /// A pipeline for each method that was asked for.
    pipelines: Vec<(Estimator, Box<Pipeline<R, N>>)>,
    sequence: u32,
}

impl<R: Kind, const N: usize> Target<R, N> {
    pub(super) fn boxed(terms: Terms) -> Result<Box<dyn Engine>, String> {
        let plan = Plan::from_terms(terms).map_err(|error| error.to_string())?;
        Ok(Box::new(Self {
            plan,
            spectrum: Box::new(Spectrum::new()),
            pipelines: Vec::new(),
            sequence: 0,
        }))
    }

    /// A pipeline by this method; `None` for one of the host's.
    fn pipeline(&self, estimator: Estimator) -> Option<Box<Pipeline<R, N>>> {
        let Estimator::Core { method, reach } = estimator else { return None };
        let options = Options { method, reach, ..self.plan.options };
        Some(Box::new(Pipeline::new(self.plan.with_options(options))))
    }

    /// What each method answers to a record.
    fn estimates(
        &mut self,
        samples: &[R::Sample; N],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        let stamp = Stamp { sequence: self.sequence, gap, ..Stamp::default() };
        self.sequence = self.sequence.wrapping_add(1);
        let mut measure = |&estimator: &Estimator| {
            if !self.pipelines.iter().any(|(known, _)| *known == estimator) {
                let new = self.pipeline(estimator).map(|pipeline| (estimator, pipeline));
                self.pipelines.extend(new);
            }
            let own = self.pipelines.iter_mut().find(|(known, _)| *known == estimator);
            own.map_or(Estimate::NOTHING, |(_, pipeline)| {
                estimate::<R, N>(&pipeline.block(&stamp, samples).tone)
            })
        };
        estimators.iter().map(&mut measure).collect()
    }

    fn offset(&self, estimator: Estimator, samples: &[R::Sample; N], peak: i32) -> f64 {
        let Estimator::Core { method, reach } = estimator else {
            return f64::NAN;
        };
        let fixed = self.plan.options.arithmetic == Arithmetic::Fixed;
        if fixed && estimator.least_squares() {
            let mut places = Places::new();
            let near = Neighbourhood::read(&self.spectrum.view(), peak, &mut places);
            let fit = fit_near::<R>()(&near, Arithmetic::Fixed, reach, FitStart::Usual);
            return fit.map_or(0.0, |fit| fit.offset.into());
        }
        let bins = Bins::<f32, R, Rectangular>::from_view(&self.spectrum.view(), peak);
        let offset = match reached(method, reach, &bins) {
            Some(offset) => offset.map(I2F30::saturating_from_num),
            None => method.offset_target(&self.spectrum.view(), Data::of::<R>(samples), peak),
        };
        offset.map_or(f64::NAN, |offset| offset.to_num())
    }
}

fn estimate<R: Record, const N: usize>(tone: &Tone) -> Estimate {
    Estimate {
        bins: within::<R>(tone.frequency.bins(N), N),
        sigma_bins: f64::from(tone.sigma) * N as f64,
        snr_db: f64::from(tone.snr_db()),
        verdict: tone.verdict,
        also: tone.also,
    }
}

/// The record as an array; what is missing reads zero.
fn block<R: Kind, const N: usize>(record: &[Complex<f64>]) -> [R::Sample; N] {
    array::<R, N, _>(record, |&value| value)
}

fn array<R: Kind, const N: usize, T>(
    record: &[T],
    value: impl Fn(&T) -> Complex<f64>,
) -> [R::Sample; N] {
    let mut samples = [R::Sample::default(); N];
    for (sample, x) in samples.iter_mut().zip(record) {
        *sample = code::<R>(value(x));
    }
    samples
}

impl<R: Kind, const N: usize> Frequencies for Target<R, N> {
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64> {
        let samples = block::<R, N>(record);
        self.spectrum.transform(&samples, self.plan.codes);
        let Some(peak) = peak::find(&self.spectrum.view(), self.plan.band) else {
            return vec![f64::NAN; estimators.len()];
        };
        let frequency =
            |&e| within::<R>(f64::from(peak.bin) + self.offset(e, &samples, peak.bin), N);
        estimators.iter().map(frequency).collect()
    }
}

impl<R: Kind, const N: usize> Engine for Target<R, N> {
    fn measure(
        &mut self,
        record: &[Complex<f64>],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        self.estimates(&block::<R, N>(record), estimators, gap)
    }

    fn measure_samples(
        &mut self,
        samples: &[Sample],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        self.estimates(&array::<R, N, _>(samples, |sample| sample.value), estimators, gap)
    }

    fn explain(&mut self, record: &[Complex<f64>], estimator: Estimator) -> Explained {
        let (samples, notes) = (block::<R, N>(record), Notes::default());
        let Some(mut pipeline) = self.pipeline(estimator) else {
            return Explained::of(notes, Estimate::NOTHING, Evidence::NO_TONE);
        };
        let (_, tone, evidence) = pipeline.explain(&Stamp::default(), &samples, &notes);
        Explained::of(notes, estimate::<R, N>(&tone), evidence)
    }
}

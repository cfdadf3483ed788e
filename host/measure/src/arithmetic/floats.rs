//! Floats of either width on an exact transform.

use super::explained::{Explained, Notes};
use super::{Engine, Estimate, within};
use crate::estimator::Estimator;
use crate::simulate::{Kind, codes};
use fixed::types::I0F32;
use picket_dsp::acquire::sample::{Data, Statistics};
use picket_dsp::math::scalar::Scalar;
use picket_dsp::plan::Terms;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_dsp::spectrum::peak::{Band, Peak, SKIRT, Search};
use picket_dsp::spectrum::view::STANDS_OUT;
use picket_dsp::tone::Reasons;
use picket_dsp::tone::clipped::CensoredFit;
use picket_dsp::tone::detection::{Relaxation, Threshold};
use picket_dsp::tone::evidence::{EDGE_BINS, Evidence, edge_bins};
use picket_dsp::tone::fit::{FitStart, Reach, fit};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::front_end::{Glance, Lines, Sight, counted, other_lines};
use picket_dsp::tone::image::mirrored_in_rest;
use picket_dsp::tone::judge::{FitTest, LineClass, from_end, judge};
use picket_dsp::tone::measure::{excess_limit, excess_over, residual};
use picket_dsp::tone::noise;
use picket_dsp::tone::noise::ring::{self, LocalNoise};
use picket_dsp::tone::observer::{Observer, Statistic, Step, Tap, Test};
use picket_dsp::tone::sigma::{CLIPPED, bound_bins, sigma_bins, widened};
use picket_transform::{Fft, Transform, num_complex::Complex};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;

/// An engine for any number of samples.
pub(super) struct Floats<T: Transform, R> {
    n: usize,
    plan: Terms,
    fft: Arc<dyn Fft<T>>,
    scratch: Vec<Complex<T>>,
    samples: Vec<Complex<T>>,
    spectrum: Vec<Complex<T>>,
    powers: Vec<T>,
    kind: PhantomData<R>,
}

impl<T: Transform, R> Debug for Floats<T, R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Floats({}, {:?})", self.n, self.plan)
    }
}

impl<T: Scalar + Transform, R: Kind> Floats<T, R> {
    pub(super) fn new(n: usize, plan: Terms) -> Self {
        let fft = T::forward(n);
        let scratch = vec![Complex::new(T::zero(), T::zero()); fft.get_inplace_scratch_len()];
        Floats {
            n,
            plan,
            fft,
            scratch,
            samples: Vec::new(),
            spectrum: Vec::new(),
            powers: Vec::new(),
            kind: PhantomData,
        }
    }

    fn transform(&mut self, record: &[Complex<f64>]) {
        self.samples.clear();
        self.samples.extend(record.iter().map(|x| Complex::new(T::new(x.re), T::new(x.im))));
        self.spectrum.clone_from(&self.samples);
        self.fft.process_with_scratch(&mut self.spectrum, &mut self.scratch);
        self.take_offset();
        self.powers.clear();
        self.powers.extend(self.spectrum.iter().map(|x| x.norm_sqr()));
    }

    /// Takes an I/Q converter's offset out of bin 0, as the core does beside a tone.
    fn take_offset(&mut self) {
        if let [offset, above, .., below] = self.spectrum.as_mut_slice()
            && R::IQ
            && offset.norm_sqr() > (above.norm_sqr() + below.norm_sqr()) * T::new(STANDS_OUT as f64)
        {
            *offset = (*above + *below) * T::new(0.5);
        }
    }

    /// The core's search, on powers scaled to the integers it takes.
    fn peak(&self) -> Option<(Peak, f64)> {
        let Band { low, high, .. } = self.plan.band;
        let power = |k: i32| self.powers[k.rem_euclid(self.n as i32) as usize].wide();
        let most = (low..=high).map(power).fold(0.0, f64::max);
        let unit = most / (1u64 << 40) as f64;
        if !(unit > 0.0 && unit.is_finite()) {
            return None;
        }
        let mut search = Search::new(self.plan.band);
        (low..=high).for_each(|k| search.push((power(k) / unit) as u64));
        let mut peak = search.finish()?;
        if R::IQ {
            // The skirt goes round the circle.
            let around = peak.bin - SKIRT..=peak.bin + SKIRT;
            for k in around.filter(|k| !(low..=high).contains(k)) {
                let turned = [k - self.n as i32, k + self.n as i32];
                if turned.iter().any(|&k| k != 0 && (low..=high).contains(&k)) {
                    peak.floor = peak.floor.saturating_sub((power(k) / unit) as u64);
                    peak.floor_bins = peak.floor_bins.saturating_sub(1);
                }
            }
        }
        Some((peak, unit))
    }

    /// The noise beside a tone that was taken out of the spectrum.
    fn ring(&self, peak: i32) -> LocalNoise {
        ring::from_rest(self.n, R::IQ, peak, |k| {
            let bin = |k: i32| self.spectrum[k.rem_euclid(self.n as i32) as usize];
            ((bin(k - 1) + bin(k + 1)) * T::new(0.5) - bin(k)).norm_sqr().wide() as f32
        })
    }

    fn bins(&self, peak: i32) -> Bins<T, R, Rectangular> {
        Bins::gather(self.n, peak, |k| self.spectrum[k])
    }

    fn frequency(
        &self,
        record: &[Complex<f64>],
        estimator: Estimator,
        peak: i32,
        bins: &Bins<T, R, Rectangular>,
    ) -> f64 {
        let found = match estimator {
            Estimator::Core { method, reach } => {
                Estimator::offset(method, reach, bins, &self.samples, &self.powers)
                    .map(|offset| f64::from(peak) + offset.wide())
            }
            Estimator::Host(reference) if R::IQ => reference.iq(record),
            Estimator::Host(reference) => {
                reference.real(&record.iter().map(|x| x.re).collect::<Vec<_>>())
            }
        };
        found.map_or(f64::NAN, |f| within::<R>(f, self.n))
    }

    /// What is known of the tone besides its frequency. The fitted tone is taken out of the record;
    /// what is left in the band is noise, but of a record that clips.
    fn seen(
        &mut self,
        record: &[Complex<f64>],
        peak: &Peak,
        unit: f64,
        observer: impl Tap,
    ) -> Seen {
        let samples = codes::<R>(record);
        let clipped = Statistics::from_samples(Data::of::<R>(&samples), self.plan.codes).clipped;
        let clipped = clipped as f32 / self.n as f32;
        let n = self.n as f64;
        let bins = self.bins(peak.bin);
        let Some(fit) = fit(&bins, Reach::Sixteen, FitStart::Usual) else {
            let share = if R::IQ { n } else { n / 2.0 };
            let amplitude2 = peak.power[1] as f64 * unit / (share * share);
            let noise = peak.floor as f64 * unit / f64::from(peak.floor_bins) / n;
            let snr = noise::ratio::<f64>(R::IQ, self.n, amplitude2, noise);
            let line = peak.power[1] as f32;
            return Seen {
                snr,
                clipped,
                line,
                near: noise,
                fit: None,
                free: None,
                ring: None,
                image: false,
                front_end: false,
            };
        };
        let whole = self.spectrum.clone();
        let tone = fit.tone::<R>(self.n);
        let tone = Complex::new(tone.re.wide(), tone.im.wide());
        let cycles = (f64::from(peak.bin) + fit.offset.wide()) / n;
        for (k, (rest, sample)) in self.spectrum.iter_mut().zip(&self.samples).enumerate() {
            let at = tone * f64::unit((cycles * k as f64).fract());
            *rest = Complex::new(
                T::new(sample.re.wide() - at.re),
                if R::IQ { T::new(sample.im.wide() - at.im) } else { T::zero() },
            );
        }
        self.fft.process_with_scratch(&mut self.spectrum, &mut self.scratch);
        self.take_offset();
        let ring = self.ring(peak.bin);
        let noise = f64::from(ring.noise.power);
        let single = fit.single();
        observer.fitted(peak.bin, &single, ring.noise.power);
        observer.begin(Step::Usual);
        let judgement = if clipped > CLIPPED {
            let variance_inflation = excess_over(&single, self.n, ring.noise);
            observer.hear(|| Test {
                statistic: Statistic::ClippedResidual,
                value: residual(&single, self.n) / ring.noise.power,
                limit: excess_limit(single.dof, ring.noise),
            });
            let line =
                if variance_inflation > 1.0 { LineClass::Unresolved } else { LineClass::Steady };
            FitTest { line, variance_inflation }
        } else {
            judge(&single, self.n, from_end(peak.bin, self.n, R::IQ), &ring, false, observer)
        };
        observer.judged(&judgement, true);
        let FitTest { line, variance_inflation } = judgement;
        let amplitude2 = fit.amplitude_squared(R::IQ, self.n).wide();
        let free = (clipped > CLIPPED).then(|| {
            let frequency = Frequency(I0F32::wrapping_from_num(cycles));
            let tone = Complex::new(tone.re as f32, tone.im as f32);
            let free = CensoredFit::from_record(
                Data::of::<R>(&samples),
                self.plan.codes,
                frequency,
                tone,
            )?;
            Some((frequency.bins(self.n) + f64::from(free.offset), free))
        });
        let free = free.flatten();
        let noise_here = free.map_or(noise, |(_, free)| free.noise.into());
        let rest = residual(&fit, self.n).wide() as f32;
        let near = free.map_or(noise, |(_, free)| free.near(rest, clipped).into());
        let near =
            if variance_inflation > 1.0 { noise * f64::from(variance_inflation) } else { near };
        let sigma = sigma_bins(&fit, self.n, T::new(near)).wide();
        let snr = noise::ratio::<f64>(R::IQ, self.n, amplitude2, noise_here);
        let power = (fit.line.norm_sqr().wide() / unit) as f32;
        let bin = |k: i32| self.spectrum[k.rem_euclid(self.n as i32) as usize];
        let rest = |k: i32| bin(k).norm_sqr().wide() as f32;
        let image =
            R::IQ && mirrored_in_rest(self.n, peak.bin, &single, &ring.noise, observer, rest);
        let bin = |k: i32| {
            let Complex { re, im } = whole[k.rem_euclid(self.n as i32) as usize];
            Complex::new(re.wide() as f32, im.wide() as f32)
        };
        let lines = |least: f32| {
            let ([first, count], cut) = counted(R::IQ, self.n, peak.bin);
            let mut lines = Lines::new(least);
            for k in first..first + count {
                let offset = R::IQ && k.rem_euclid(self.n as i32) == 0;
                lines.see(if offset { 0.0 } else { bin(k).norm_sqr() });
            }
            lines.count.saturating_sub(cut)
        };
        let sight = Sight {
            n: self.n,
            iq: R::IQ,
            peak: peak.bin,
            fit: &single,
            noise: ring.noise.power,
            others: (peak.floor as f64 * unit) as f32,
            pairs: R::pairs(&samples),
            codes: self.plan.codes,
            bin: &bin,
            lines: &lines,
        };
        let bins = peak.bin as f32 + single.offset;
        let looks = line != LineClass::Unresolved
            && !image
            && clipped <= CLIPPED
            && edge_bins(R::IQ, self.n, bins) >= EDGE_BINS;
        if looks {
            observer.hear(|| other_lines(sight.others, &single));
        }
        let front_end = looks && sight.is_faulty(Glance::ALL, observer);
        Seen {
            snr,
            clipped,
            line: power,
            near,
            fit: Some(Fitted { bins: cycles * n, sigma, line }),
            free,
            ring: Some(ring),
            image,
            front_end,
        }
    }
}

/// What is known of a tone besides its frequency.
struct Seen {
    /// Signal-to-noise ratio per sample.
    snr: f64,
    /// The share of the samples that touch a rail.
    clipped: f32,
    /// The power of the line, in units of the peak's.
    line: f32,
    /// The noise power per sample near the tone.
    near: f64,
    /// What least squares says.
    fit: Option<Fitted>,
    /// The noise beside the tone.
    ring: Option<LocalNoise>,
    /// Whether an I/Q record has as strong a line at minus the frequency.
    image: bool,
    /// Whether the lines are those of a faulty front end.
    front_end: bool,
    /// Of a record that clips: where its other samples see the tone, in bins, and how well.
    free: Option<(f64, CensoredFit)>,
}

/// What least squares says of a tone.
#[derive(Clone, Copy)]
struct Fitted {
    /// The frequency in bins.
    bins: f64,
    /// One standard deviation, in bins.
    sigma: f64,
    /// What the line is, by what the fit leaves in its own bins.
    line: LineClass,
}

/// A difference of frequencies in bins, of `n` samples, by the shorter way round.
fn wrapped(bins: f64, n: usize) -> f64 {
    let n = n as f64;
    (bins + n / 2.0).rem_euclid(n) - n / 2.0
}

impl Seen {
    /// One standard deviation of a frequency, in bins, of which noise alone would make `sigma`.
    fn sigma(&self, bins: f64, n: usize, sigma: f64) -> f64 {
        let Some((truth, free)) = self.free else {
            return sigma.hypot(widened(0.0, self.clipped).into());
        };
        let free = CensoredFit { offset: wrapped(truth - bins, n) as f32, ..free };
        free.widened(sigma as f32, self.near as f32).into()
    }
}

impl<T: Scalar + Transform, R: Kind> Engine for Floats<T, R> {
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64> {
        self.transform(record);
        let Some((peak, _)) = self.peak() else {
            return vec![f64::NAN; estimators.len()];
        };
        let bins = self.bins(peak.bin);
        estimators.iter().map(|&e| self.frequency(record, e, peak.bin, &bins)).collect()
    }

    fn measure(
        &mut self,
        record: &[Complex<f64>],
        estimators: &[Estimator],
        gap: bool,
    ) -> Vec<Estimate> {
        let measured = self.weigh(record, estimators, gap, ());
        measured.into_iter().map(|(estimate, _)| estimate).collect()
    }

    fn explain(&mut self, record: &[Complex<f64>], estimator: Estimator) -> Explained {
        let notes = Notes::default();
        let measured = self.weigh(record, &[estimator], false, &notes as &dyn Observer);
        let (estimate, evidence) =
            measured.first().copied().unwrap_or((Estimate::NOTHING, Evidence::NO_TONE));
        Explained::of(notes, estimate, evidence)
    }
}

impl<T: Scalar + Transform, R: Kind> Floats<T, R> {
    /// Every method's answer, and the evidence for its verdict.
    fn weigh(
        &mut self,
        record: &[Complex<f64>],
        estimators: &[Estimator],
        gap: bool,
        observer: impl Tap,
    ) -> Vec<(Estimate, Evidence)> {
        self.transform(record);
        let Some((peak, unit)) = self.peak() else {
            return vec![(Estimate::NOTHING, Evidence::NO_TONE); estimators.len()];
        };
        let bins = self.bins(peak.bin);
        let found: Vec<f64> =
            estimators.iter().map(|&e| self.frequency(record, e, peak.bin, &bins)).collect();
        let seen = self.seen(record, &peak, unit, observer);
        let bound = f64::from(bound_bins(R::IQ, self.n, seen.snr as f32));
        let detected = self.detects(&peak, unit, &seen, observer);
        let estimate = |(estimator, bins): (&Estimator, f64)| {
            // As in the core, see `picket_dsp::tone::measure`. Without a fit nobody knows what the line is.
            let theirs = f64::from(estimator.about().efficiency) * bound;
            let (sigma, line) = match seen.fit {
                Some(fit) if estimator.least_squares() => (fit.sigma, fit.line),
                Some(fit) => {
                    (fit.sigma.max(theirs).max(wrapped(bins - fit.bins, self.n).abs()), fit.line)
                }
                None => (theirs, LineClass::Unresolved),
            };
            let sigma_bins = seen.sigma(bins, self.n, sigma);
            let evidence = Evidence {
                said: Reasons::NONE,
                found: true,
                detected,
                line,
                drift: None,
                image: seen.image,
                front_end: detected && seen.front_end,
                gap,
                // Neither is looked for here.
                outside: false,
                beyond: 0,
                clipped: seen.clipped,
                edge_bins: edge_bins(R::IQ, self.n, bins as f32),
                sigma: (sigma_bins / self.n as f64) as f32,
            };
            let reasons = evidence.reasons();
            let estimate = Estimate {
                bins,
                sigma_bins,
                snr_db: 10.0 * seen.snr.log10(),
                verdict: reasons.verdict(),
                also: reasons.also(),
            };
            (estimate, evidence)
        };
        estimators.iter().zip(found).map(estimate).collect()
    }

    /// Whether the line stands out of the floor of its band, and of the noise beside it.
    fn detects(&self, peak: &Peak, unit: f64, seen: &Seen, observer: impl Tap) -> bool {
        let threshold = self.plan.options.threshold;
        let (line, threshold) = threshold.of_line(seen.line, peak, self.n, R::IQ);
        let has_floor = Threshold::has_floor(peak);
        if has_floor {
            observer.hear(|| Test {
                statistic: Statistic::Floor,
                value: line * peak.floor_bins as f32 / peak.floor as f32,
                limit: threshold.over(peak.floor_bins),
            });
        }
        let less = if has_floor { Relaxation::MOST } else { Relaxation::NOTHING };
        let power = (f64::from(line) * unit / self.n as f64) as f32;
        let beside = |ring: LocalNoise| {
            let limit = threshold.beside(ring.noise.dof, less);
            observer.exceeds(Statistic::Ring, power / ring.loud, limit)
        };
        threshold.detects_line(line, peak) && seen.ring.is_none_or(beside)
    }
}

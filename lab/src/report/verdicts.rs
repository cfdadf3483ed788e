//! A spectrum for each verdict: what a record looks like that gets it. The pictures of docs/trust.md.

use super::lab::{Lab, Section};
use super::lidar::transform;
use crate::arithmetic::{Arithmetic, Estimate, engine, whole};
use crate::estimator::Estimator;
use crate::impair::{Impairment, Setup};
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::simulate::{Kind, generator};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::tone::Verdict;
use picket_dsp::tone::fit::Reach;
use picket_transform::num_complex::Complex;
use std::f64::consts::TAU;

const N: usize = 1024;
const SEED: u64 = 5;
/// Nothing below is drawn, dB.
const FLOOR_DB: f64 = -110.0;

/// A record that gets a verdict.
#[derive(Debug)]
pub struct Example {
    /// The verdict's name.
    pub verdict: &'static str,
    /// The name of the picture's files.
    pub picture: &'static str,
    /// What the record is, for its title.
    what: &'static str,
    impair: &'static str,
    iq: bool,
    snr_db: f64,
    bins: f64,
    amplitude: Option<f64>,
    gap: bool,
    /// Bins that are drawn.
    shown: (i32, i32),
}

const PLAIN: Example = Example {
    verdict: "good",
    picture: "trust-good",
    what: "a pure tone, 30 dB",
    impair: "none",
    iq: false,
    snr_db: 30.0,
    bins: 100.3,
    amplitude: None,
    gap: false,
    shown: (80, 120),
};

/// One for each verdict, from best to worst, except for wrong codes, which no picture shows.
pub const EXAMPLES: [Example; 10] = [
    PLAIN,
    Example {
        verdict: "moving",
        picture: "trust-moving",
        what: "a tone that rises by half a bin, 30 dB",
        impair: "chirp:0.5",
        ..PLAIN
    },
    Example {
        verdict: "near-edge",
        picture: "trust-near-edge",
        what: "a tone beside 0 Hz, 30 dB",
        bins: 1.2,
        shown: (0, 40),
        ..PLAIN
    },
    Example {
        verdict: "clipped",
        picture: "trust-clipped",
        what: "a tone 3 dB beyond the rails, 50 dB",
        impair: "clip-converter:3",
        snr_db: 50.0,
        shown: (1, 511),
        ..PLAIN
    },
    Example {
        verdict: "unresolved",
        picture: "trust-unresolved",
        what: "a particle's burst on a pedestal, 30 dB",
        impair: "burst:deviation=0.1,pedestal=1",
        shown: (1, 120),
        ..PLAIN
    },
    Example {
        verdict: "image",
        picture: "trust-image",
        what: "I/Q, Q a sample late, 30 dB",
        impair: "iq-delay:1",
        iq: true,
        shown: (-150, 150),
        ..PLAIN
    },
    Example {
        verdict: "gap",
        picture: "trust-gap",
        what: "a pure tone, 30 dB, samples lost before the block",
        gap: true,
        ..PLAIN
    },
    Example {
        verdict: "weak",
        picture: "trust-weak",
        what: "a tone at -16 dB",
        snr_db: -16.0,
        shown: (1, 511),
        ..PLAIN
    },
    Example {
        verdict: "front-end",
        picture: "trust-front-end",
        what: "a tone 1 dB beyond the rails, whose codes wrap, 30 dB",
        impair: "wrap:1",
        shown: (1, 511),
        ..PLAIN
    },
    Example {
        verdict: "no-signal",
        picture: "trust-no-signal",
        what: "an input that is not connected: every code is 0",
        snr_db: f64::INFINITY,
        amplitude: Some(0.0),
        shown: (1, 511),
        ..PLAIN
    },
];

impl Example {
    /// What the firmware says of it, and its picture.
    pub fn picture(&self) -> Result<(Estimate, Chart), String> {
        with_kind!(self.iq, R => self.of::<R>())
    }

    fn of<R: Kind>(&self) -> Result<(Estimate, Chart), String> {
        let mut setup = Setup::new(N, self.snr_db);
        (setup.bins, setup.amplitude) = (Some((self.bins, self.bins)), self.amplitude);
        let impairment = Impairment::parse(self.impair)?.swap_remove(0);
        let record = impairment.record::<R>(&setup, &mut generator(SEED, 0)).samples;
        let mut engine = engine::<R>(Arithmetic::Target, N, whole::<R>(N, Codes::signed::<12>())?)?;
        let best = [Estimator::best(R::IQ, Reach::Sixteen)];
        let answer = engine.measure(&record, &best, self.gap)[0];
        let mut series = vec![Series::new("record", Style::Marked, 0, self.levels::<R>(&record))];
        if answer.verdict != Verdict::NoSignal {
            let pure = pure::<R>(&record, answer.bins);
            let left: Vec<_> = record.iter().zip(&pure).map(|(x, p)| x - p).collect();
            series.push(Series::new("pure tone", Style::Dashed, 6, self.levels::<R>(&pure)));
            series.push(Series::new("left over", Style::Marked, 1, self.levels::<R>(&left)));
        }
        if self.shown.1 - self.shown.0 > 200 {
            series
                .iter_mut()
                .filter(|s| s.style == Style::Marked)
                .for_each(|s| s.style = Style::Line);
        }
        let (low, high) = self.shown;
        let chart = Chart {
            name: self.picture,
            title: self.title(&answer),
            x: Axis::linear("bin", low.into(), high.into()),
            y: Axis::linear("level, dB of full scale", FLOOR_DB, 5.0),
            series,
        };
        Ok((answer, chart))
    }

    /// The verdict, once it is the one that the picture is of; what the record is; the answer.
    fn title(&self, answer: &Estimate) -> String {
        let word = match answer.verdict.name() == self.verdict {
            true => format!("{}: ", self.verdict),
            false => String::new(),
        };
        let said = match answer.verdict {
            Verdict::NoSignal => String::new(),
            _ => {
                let half = N as f64 / 2.0;
                let turns =
                    if self.iq { (answer.bins + half) % N as f64 - half } else { answer.bins };
                format!("; {turns:.4} ± {:.4} bins", answer.sigma_bins)
            }
        };
        format!("{word}{}{said}", self.what)
    }

    /// The levels of the bins that are shown.
    fn levels<R: Kind>(&self, record: &[Complex<f64>]) -> Vec<(f64, f64)> {
        let full = 2048.0 * N as f64 / if R::IQ { 1.0 } else { 2.0 };
        let spectrum = transform(record);
        let level =
            |k: i32| 20.0 * (spectrum[k.rem_euclid(N as i32) as usize].norm() / full).log10();
        // A tenth of a decibel is what can be seen.
        (self.shown.0..=self.shown.1)
            .map(|k| (k.into(), (10.0 * level(k).max(FLOOR_DB)).round() / 10.0))
            .collect()
    }
}

/// The tone of this frequency that leaves least of the record.
fn pure<R: Kind>(record: &[Complex<f64>], bins: f64) -> Vec<Complex<f64>> {
    let turn = |k: usize| Complex::from_polar(1.0, TAU * (bins * k as f64 / N as f64).fract());
    if R::IQ {
        let sum: Complex<f64> = record.iter().enumerate().map(|(k, x)| x * turn(k).conj()).sum();
        return (0..N).map(|k| turn(k) * sum / N as f64).collect();
    }
    let sum = |f: &dyn Fn(usize) -> f64| (0..N).map(f).sum::<f64>();
    let cc = sum(&|k| turn(k).re * turn(k).re);
    let ss = sum(&|k| turn(k).im * turn(k).im);
    let cs = sum(&|k| turn(k).re * turn(k).im);
    let xc = sum(&|k| record[k].re * turn(k).re);
    let xs = sum(&|k| record[k].re * turn(k).im);
    let determinant = cc * ss - cs * cs;
    let (a, b) = ((xc * ss - xs * cs) / determinant, (xs * cc - xc * cs) / determinant);
    (0..N).map(|k| Complex::new(a * turn(k).re + b * turn(k).im, 0.0)).collect()
}

/// Every verdict and a spectrum that gets it.
pub fn verdicts(_: &Lab) -> Result<Section, String> {
    let pictures: Result<Vec<_>, String> = EXAMPLES.iter().map(Example::picture).collect();
    Ok(Section {
        title: "What each verdict looks like",
        text: vec![
            "A seeded record for each, 1024 samples of 12 bits, and the pure tone of the frequency that the firmware answers, and \
             what is left over without it. docs/trust.md says what each verdict means and what to do."
                .into(),
        ],
        charts: pictures?.into_iter().map(|(_, chart)| chart).collect(),
        ..Section::default()
    })
}

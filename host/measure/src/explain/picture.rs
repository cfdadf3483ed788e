//! The bins around a peak, the fit, and its residual.

use crate::analyze::Explanation;
use crate::arithmetic::Fitted;
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use std::f64::consts::TAU;
use std::path::Path;

/// Bins on each side of the peak: those of the fit, and some of the ring's.
const AROUND: i32 = 24;

/// Draws an explained block, in dB of the codes' full scale.
pub fn draw(
    explanation: &Explanation,
    codes: Codes,
    picture: &Path,
    output: Output,
) -> Result<(), String> {
    let Explanation { answer, explained, samples, iq } = explanation;
    let Some(Fitted { peak, fit, noise }) = explained.fitted else {
        return Err("--plot: nothing was fitted in this block, so there is nothing to draw".into());
    };
    let n = samples.len();
    let tone = if *iq { fit.tone::<Iq>(n) } else { fit.tone::<Real>(n) };
    let tone = Complex::new(f64::from(tone.re), f64::from(tone.im));
    let cycles = (f64::from(peak) + f64::from(fit.offset)) / n as f64;
    let model: Vec<Complex<f64>> = (0..n)
        .map(|k| {
            let sample = tone * Complex::from_polar(1.0, TAU * (cycles * k as f64).fract());
            if *iq { sample } else { Complex::new(sample.re, 0.0) }
        })
        .collect();
    let left = samples.iter().zip(&model).map(|(sample, model)| sample - model).collect();
    let (low, high) = codes.rails();
    // A tone from rail to rail has 0 dB.
    let full = 0.5 * (f64::from(high) - f64::from(low)) * n as f64 * if *iq { 1.0 } else { 0.5 };
    // To a hundredth, so that every machine draws the same.
    let db = |power: f64| (1000.0 * (power / (full * full)).max(1e-20).log10()).round() / 100.0;
    let first = if *iq { peak - AROUND } else { (peak - AROUND).max(0) };
    let last = if *iq { peak + AROUND } else { (peak + AROUND).min(n as i32 / 2) };
    let spectrum = |samples: Vec<Complex<f64>>| -> Vec<(f64, f64)> {
        let mut bins = samples;
        f64::forward(n).process(&mut bins);
        let bin = |k: i32| bins[k.rem_euclid(n as i32) as usize].norm_sqr();
        (first..=last).map(|k| (f64::from(k), db(bin(k)))).collect()
    };
    let (seen, model, left) = (spectrum(samples.clone()), spectrum(model), spectrum(left));
    let level = db(f64::from(noise) * n as f64);
    let values = || [&seen, &left].into_iter().flatten().map(|&(_, y)| y).chain([level]);
    let bottom = values().fold(f64::INFINITY, f64::min).max(level - 20.0);
    let top = values().fold(f64::NEG_INFINITY, f64::max);
    let ends = [f64::from(first), f64::from(last)];
    let verdict = explained.estimate.verdict;
    let chart = Chart {
        name: "explained",
        title: format!("Block {}: {verdict}", answer.block),
        x: Axis::linear("bin", ends[0], ends[1]),
        y: Axis::linear("dB of full scale", bottom - 3.0, top + 5.0),
        series: vec![
            Series::new("the block's bins", Style::Marked, 0, seen),
            Series::new("the fitted tone", Style::Line, 2, model),
            Series::new("what the fit leaves", Style::Marked, 1, left),
            Series::new("noise beside the tone", Style::Dashed, 7, ends.map(|x| (x, level))),
        ],
    };
    chart.save(picture, output)
}

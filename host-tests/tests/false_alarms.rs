//! Noise alone, of several spectra, whose bins are drawn directly: how often it passes for a tone, over what is asked.

use host_tests::figures::hold;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::spectrum::peak::Band;
use picket_dsp::spectrum::view::Points;
use picket_dsp::tone::Verdict;
use picket_dsp::tone::threshold::Threshold;
use picket_simulator::Draw;
use rayon::prelude::*;
use std::cell::RefCell;

thread_local! {
    static BINS: RefCell<Vec<[f32; 2]>> = const { RefCell::new(Vec::new()) };
}

/// An engine whose bins are those that were drawn last, whatever the samples.
#[derive(Clone, Copy, Debug)]
struct Drawn;

impl Engine for Drawn {
    type Part = f32;
    const CENTRED: bool = false;

    fn transform<R: Record, const N: usize>(
        _pairs: &[[i16; 2]],
        _codes: Codes,
        points: &mut [[f32; 2]],
    ) -> i32 {
        BINS.with_borrow(|bins| points.copy_from_slice(bins));
        -8
    }

    // The points in floats of a real record are its bins.
    fn points(points: &[[f32; 2]]) -> Points<'_> {
        Points::Float(points)
    }
}

/// The power of noise in bin k of n/2.
#[derive(Clone, Copy, Debug)]
enum Shape {
    White,
    /// `1/k^power`.
    Falling(i32),
    /// White, and `(knee/k)^power` more.
    Knee(f64, i32),
    /// White, and a hump in the middle of the spectrum, of this width in bins and this power in decibels.
    Hump(f64, f64),
}

impl Shape {
    fn power(self, k: f64, half: f64) -> f64 {
        match self {
            Shape::White => 1.0,
            Shape::Falling(power) => k.powi(-power),
            Shape::Knee(knee, power) => 1.0 + (knee / k).powi(power),
            Shape::Hump(width, decibels) => {
                let away = (k - half / 2.0) / (width / 2.355);
                1.0 + 10f64.powf(decibels / 10.0) * (-0.5 * away * away).exp()
            }
        }
    }
}

/// The false alarms that are asked, and the blocks of noise in each cell.
const ASKED: f64 = 1e-3;
const BLOCKS: u64 = 40_000;
const SEED: u64 = 56;

/// The good blocks of noise over those asked.
fn alarms<R: Record, const N: usize>(shape: Shape, band_hz: Option<(f64, f64)>) -> f64 {
    let config =
        Config { band_hz, false_alarm: ASKED, ..Config::new(N as f64, Codes::signed::<16>()) };
    let plan = config.plan::<R, N>().unwrap();
    let half = N as f64 / 2.0;
    let power = |k: usize| {
        let k = k as f64;
        shape.power(if k > half { N as f64 - k } else { k }.max(0.5), half)
    };
    let count = if R::IQ { N } else { N / 2 };
    let most = (1..count).map(power).fold(0.0, f64::max);
    let sizes: Vec<f64> = (0..count).map(|k| 2e7 * (power(k) / most).sqrt()).collect();
    let streams = 100;
    let good: u64 = (0..streams)
        .into_par_iter()
        .map(|stream| {
            let mut draw = Draw::new(SEED, stream);
            // The tests of the front end alone read samples.
            let samples: [R::Sample; N] = std::array::from_fn(|_| {
                R::from_parts([0; 2].map(|_| draw.between(-3000.0, 3000.0) as i16))
            });
            let mut pipeline = Pipeline::<R, N, Drawn>::new(plan);
            let is_good = |_: &u64| {
                BINS.with_borrow_mut(|bins| {
                    bins.clear();
                    bins.extend(
                        sizes
                            .iter()
                            .map(|size| [0; 2].map(|_| (size * draw.normal()).trunc() as f32)),
                    );
                });
                pipeline.block(&Stamp::default(), &samples).tone.verdict == Verdict::Good
            };
            (0..BLOCKS / streams).filter(is_good).count() as u64
        })
        .sum();
    good as f64 / (ASKED * BLOCKS as f64)
}

/// The table of trust.md. White noise, and noise of any slope far from 0 Hz, raises no more than twice what is asked.
#[test]
fn noise_alone_is_a_tone_as_often_as_stated() {
    println!("seed {SEED}");
    let shapes = [
        ("white", Shape::White),
        ("1/f", Shape::Falling(1)),
        ("1/f^2", Shape::Falling(2)),
        ("1/f^3", Shape::Falling(3)),
        ("a knee", Shape::Knee(10.0, 2)),
        ("a wide hump", Shape::Hump(32.0, 10.0)),
        ("a narrow hump", Shape::Hump(8.0, 6.0)),
    ];
    for (name, shape) in shapes {
        let alarms = [
            alarms::<Real, 64>(shape, None),
            alarms::<Real, 1024>(shape, None),
            alarms::<Real, 1024>(shape, Some((100.0, 200.0))),
            alarms::<Iq, 256>(shape, None),
        ];
        hold(&format!("false alarms over those asked, {name}"), 0.1, &alarms);
        let [_, _, far, _] = alarms;
        // Three deviations of the count.
        let most = 2.0 + 3.0 * (2.0 / (ASKED * BLOCKS as f64)).sqrt();
        assert!(far <= most, "{name}: {far}");
        assert!(name != "white" || alarms.iter().all(|&alarms| alarms <= most), "{alarms:?}");
    }
}

/// The default thresholds, as docs/proofs.md has them.
#[test]
fn thresholds_are_those_of_the_document() {
    for (n, expected) in [(256usize, 20.34f32), (1024, 20.46), (4096, 21.55)] {
        let bins = Band::real(n).width();
        let t = Threshold::new(bins, 1e-6).over(bins - 17);
        println!("N {n}: T = {t:.2}");
        assert!((t - expected).abs() < 0.06);
    }
}

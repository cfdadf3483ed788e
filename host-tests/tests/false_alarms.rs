//! Noise of any smooth shape, whose bins are drawn directly: how often it passes for a tone, over what is asked.

use crate::signal::rng;
use host_tests::sized;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::spectrum::engine::{Engine, I32};
use picket_dsp::spectrum::scan::Scan;
use picket_dsp::tone::Verdict;
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use std::cell::RefCell;
use std::ops::RangeInclusive;

thread_local! {
    static BINS: RefCell<Vec<[i32; 2]>> = const { RefCell::new(Vec::new()) };
}

/// An engine whose bins are those that were drawn last, whatever the samples.
#[derive(Clone, Copy, Debug)]
struct Drawn;

impl Engine for Drawn {
    type Part = i32;
    const CENTRED: bool = false;

    fn error(n: usize, iq: bool) -> f32 {
        I32::error(n, iq)
    }

    fn transform<R: Record, const N: usize>(
        _pairs: &[[i16; 2]],
        _codes: Codes,
        points: &mut [[i32; 2]],
    ) -> i32 {
        BINS.with_borrow(|bins| points.copy_from_slice(bins));
        -8
    }

    fn bin<R: Record, const N: usize>(points: &[[i32; 2]], k: usize) -> [i32; 2] {
        points.get(k).copied().unwrap_or_default()
    }

    fn search<R: Record, const N: usize>(
        _points: &[[i32; 2]],
        _bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        None
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

/// The good blocks of noise over those asked: at most twice as many in any shape.
fn alarms<R: Record, const N: usize>(
    shape: Shape,
    band_hz: Option<(f64, f64)>,
    asked: f64,
    blocks: u64,
) {
    let seed = 56;
    let config =
        Config { band_hz, false_alarm: asked, ..Config::new(N as f64, Codes::signed::<16>()) };
    let plan = config.plan::<R, N>().unwrap();
    let half = N as f64 / 2.0;
    let power = |k: usize| {
        let k = k as f64;
        shape.power(if k > half { N as f64 - k } else { k }.max(0.5), half)
    };
    let count = if R::IQ { N } else { N / 2 };
    let most = (1..count).map(power).fold(0.0, f64::max);
    let sizes: Vec<f32> = (0..count).map(|k| 2e7 * (power(k) / most).sqrt() as f32).collect();
    let streams = 100;
    let good: u64 = (0..streams)
        .into_par_iter()
        .map(|stream| {
            let mut rng = rng(seed, stream);
            // The tests of the front end alone read samples.
            let samples: [R::Sample; N] = std::array::from_fn(|_| {
                R::from_parts([rng.random_range(-3000..3000), rng.random_range(-3000..3000)])
            });
            let mut pipeline = Pipeline::<R, N, Drawn>::new(plan);
            let is_good = |_: &u64| {
                BINS.with_borrow_mut(|bins| {
                    bins.clear();
                    bins.extend(sizes.iter().map(|size| {
                        [0; 2].map(|_| (size * rng.sample::<f32, _>(StandardNormal)) as i32)
                    }));
                });
                pipeline.block(&Stamp::default(), &samples).tone.verdict == Verdict::Good
            };
            (0..blocks / streams).filter(is_good).count() as u64
        })
        .sum();
    let expected = asked * blocks as f64;
    let kind = if R::IQ { "I/Q" } else { "real" };
    println!(
        "{kind} N {N}, {shape:?}, band {band_hz:?}, {blocks} blocks at {asked:e}, seed {seed}: {:.2} of those asked",
        good as f64 / expected
    );
    // Three deviations of the count.
    assert!(good as f64 <= 2.0 * expected + 3.0 * (2.0 * expected).sqrt());
}

#[test]
fn noise_that_falls_is_no_tone() {
    let blocks = sized(50_000, 1_000_000);
    for power in 1..=3 {
        let shape = Shape::Falling(power);
        alarms::<Real, 64>(shape, None, 1e-3, blocks);
        alarms::<Real, 64>(shape, Some((8.0, 24.0)), 1e-3, blocks);
        alarms::<Real, 1024>(shape, None, 1e-3, blocks);
        alarms::<Real, 1024>(shape, Some((3.4, 6.6)), 1e-3, blocks);
        alarms::<Real, 1024>(shape, Some((9.0, 93.0)), 1e-3, blocks);
        alarms::<Iq, 256>(shape, None, 1e-3, blocks);
    }
    alarms::<Real, 1024>(Shape::Knee(10.0, 2), None, 1e-3, blocks);
    alarms::<Real, 1024>(Shape::Knee(60.0, 3), Some((40.0, 300.0)), 1e-3, blocks);
    alarms::<Real, 64>(Shape::Falling(2), None, 1e-6, sized(1_000_000, 10_000_000));
}

#[test]
fn a_hump_of_noise_is_no_tone() {
    let blocks = sized(50_000, 1_000_000);
    for decibels in [6.0, 20.0] {
        for width in [32.0, 64.0] {
            alarms::<Real, 1024>(Shape::Hump(width, decibels), None, 1e-3, blocks);
        }
    }
    alarms::<Real, 1024>(Shape::Hump(16.0, 20.0), None, 1e-3, blocks);
    alarms::<Real, 1024>(Shape::White, None, 1e-3, blocks);
    alarms::<Real, 64>(Shape::White, None, 1e-3, blocks);
    alarms::<Iq, 256>(Shape::White, None, 1e-3, blocks);
}

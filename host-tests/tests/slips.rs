//! What no answer may be called: good without a sigma, good beside its band.

use crate::signal::{CODES, Kind as _, Line, amplitude, rng, sigma};
use picket::acquire::sample::{Iq, Real, Stamp};
use picket::config::Config;
use picket::estimate::method::Method;
use picket::pipeline::{Alternating, Pipeline};
use rand::RngExt;
use std::f64::consts::TAU;

/// A line up to two bins beyond an end of the band that is searched: none of it is more than half a bin outside and good.
#[test]
fn a_line_beyond_an_end_of_the_band_is_not_good() {
    const N: usize = 512;
    println!("seed 12");
    let (mut inside, mut outside) = (0, 0);
    for trial in 0..4000 {
        let mut rng = rng(12, trial);
        let low = rng.random_range(8..200_i32);
        let high = low + rng.random_range(1..40);
        let beyond = rng.random_range(0.0..2.0);
        let bins = if trial % 2 == 0 { f64::from(low) - beyond } else { f64::from(high) + beyond };
        let line = Line { bins, amplitude: amplitude(30.0), phase: rng.random_range(0.0..TAU) };
        let samples = Real::record::<N>(&mut rng, &[line], sigma(line.amplitude, 30.0));
        let mut config = Config::new(N as f64, CODES);
        config.band_hz = Some((f64::from(low), f64::from(high)));
        let plan = config.plan::<Real, N>().unwrap();
        let (low, high) = (plan.band.low, plan.band.high);
        let tone = Pipeline::<Real, N>::new(plan).block(Stamp::default(), &samples).tone;
        let found = tone.frequency.bins(N);
        let is_inside = found >= f64::from(low) - 0.5 && found <= f64::from(high) + 0.5;
        let good = tone.verdict == picket::Verdict::Good;
        assert!(is_inside || !good, "trial {trial}: {tone}, bin {found} of {low} to {high}");
        inside += u32::from(is_inside && good);
        outside += u32::from(!is_inside);
    }
    assert!(inside > 900 && outside > 100, "{inside} inside and good, {outside} outside");
}

/// By every method, of pairs by turns whose tone is at an end of the band or anywhere in it: no answer is good without a sigma.
#[test]
fn an_answer_without_a_sigma_is_not_good() {
    const N: usize = 256;
    println!("seed 13");
    let mut without = 0;
    for method in
        Method::ALL.iter().copied().filter(|method| Alternating::<N, { 2 * N }>::fits(*method))
    {
        let mut config = Config::new(1.0, CODES);
        config.method = method.of_kind::<Iq>();
        let Ok(plan) = config.plan::<Iq, N>() else { continue };
        let mut pipeline = Alternating::<N, { 2 * N }>::new(plan);
        for trial in 0..600 {
            let mut rng = rng(13, trial);
            let bins = rng.random_range(-3.0..3.0) + if trial % 2 == 0 { 126.0 } else { -126.0 };
            let phase = rng.random_range(0.0..TAU);
            let line = Line { bins, amplitude: 1000.0, phase };
            let snr_db = rng.random_range(-10.0..60.0);
            let mut pairs = Iq::record::<N>(&mut rng, &[line], sigma(1000.0, snr_db));
            let tone = pipeline.block(Stamp::default(), &mut pairs).tone;
            let known = tone.sigma < 1.0;
            assert!(
                known || tone.verdict >= picket::Verdict::Weak,
                "{} {line:?}: {tone}",
                method.name()
            );
            without += u32::from(!known);
        }
    }
    println!("{without} answers without a sigma");
}

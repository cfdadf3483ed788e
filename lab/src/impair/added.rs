//! What comes on top of the tone.

use super::scene::Scene;
use num_complex::Complex;
use rand::RngExt;
use std::f64::consts::TAU;

fn decibels(db: f64) -> f64 {
    10f64.powf(db / 20.0)
}

/// Adds a real waveform over the block, of full scale 1; to I and Q in random shares.
fn add(scene: &mut Scene, waveform: impl Fn(f64) -> f64) {
    let (shares, rail) = (scene.direction(), scene.rail);
    scene.add(|u| shares * (rail * waveform(u)));
}

/// A constant.
pub fn dc(scene: &mut Scene, v: &[f64]) {
    add(scene, |_| v[0]);
}

/// A slow sine.
pub fn hum(scene: &mut Scene, v: &[f64]) {
    let start = TAU * scene.share();
    add(scene, |u| v[1] * (TAU * v[0] * u + start).cos());
}

/// A straight line or a parabola.
pub fn drift(scene: &mut Scene, v: &[f64]) {
    add(scene, |u| {
        let x = 2.0 * u - 1.0;
        v[0] * if v[1] < 1.5 { x } else { 1.5 * x * x - 0.5 }
    });
}

/// The second harmonic and the third.
pub fn harmonics(scene: &mut Scene, v: &[f64]) {
    for order in [2.0, 3.0] {
        let start = TAU * scene.share();
        let level = scene.amplitude * decibels(v[0]);
        for k in 0..scene.n {
            let [i, q] = [0, 1].map(|part| {
                let angle = order * scene.angle(part, k) + start;
                Complex::from_polar(level * scene.gain[part][k], angle)
            });
            scene.added[k] += Complex::new(i.re, q.im);
        }
    }
}

/// A tone at `bins`, of `level` of the tone's amplitude, at the times at which `on` says yes.
fn tone(scene: &mut Scene, bins: f64, level: f64, on: impl Fn(f64) -> bool) {
    let (start, amplitude) = (TAU * scene.share(), scene.amplitude * level);
    scene.add(|u| {
        let angle = TAU * (bins * u).fract() + start;
        if on(u) { Complex::from_polar(amplitude, angle) } else { Complex::default() }
    });
}

/// A weaker tone on either side.
pub fn second_tone(scene: &mut Scene, v: &[f64]) {
    let bins = scene.nominal + v[0] * scene.sign();
    tone(scene, bins, decibels(v[1]), |_| true);
}

/// A tone anywhere in the band that lasts for a part of the block.
pub fn tone_burst(scene: &mut Scene, v: &[f64]) {
    let n = scene.n as f64;
    let place = scene.share();
    let bins = if scene.iq { n * (place - 0.5) } else { n / 2.0 * place };
    let from = scene.share() * (1.0 - v[0]);
    tone(scene, bins, decibels(v[1]), |u| (from..from + v[0]).contains(&u));
}

/// More noise in a part of the block, by its level against the tone.
pub fn noise_burst(scene: &mut Scene, v: &[f64]) {
    let from = scene.share() * (1.0 - v[0]);
    let sigma = scene.amplitude * decibels(v[1]) / 2f64.sqrt();
    for (k, u) in scene.times(0).enumerate() {
        if (from..from + v[0]).contains(&u) {
            let draw = Complex::new(scene.normal(), scene.normal());
            scene.added[k] += draw * sigma;
        }
    }
}

/// Single samples that stick out.
pub fn impulses(scene: &mut Scene, v: &[f64]) {
    for _ in 0..v[0].round() as usize {
        let at = scene.rng.random_range(0..scene.n);
        let (re, im) = (scene.sign(), scene.sign());
        scene.added[at] += Complex::new(re, im) * (v[1] * scene.rail);
    }
}

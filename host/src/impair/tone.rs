//! What changes the tone itself: its frequency, phase or level within the block.

use super::scene::Scene;
use std::f64::consts::{PI, TAU};

/// An even change of the frequency over the block, either way. The mean is that in the middle.
pub fn chirp(scene: &mut Scene, v: &[f64]) {
    let rate = v[0] * scene.sign();
    let middle = (scene.n as f64 - 1.0) / (2.0 * scene.n as f64);
    for (k, u) in scene.places().enumerate() {
        scene.phase[k] += PI * rate * (u - middle).powi(2);
    }
}

/// An amplitude that swings about its mean.
pub fn am(scene: &mut Scene, v: &[f64]) {
    let start = TAU * scene.share();
    let swing = |u: f64| 1.0 + v[0] * (TAU * v[1] * u + start).cos();
    scene.gain = scene.places().map(swing).collect();
}

/// A phase that wanders at random. The mean frequency is what takes it from its first value to its last.
pub fn phase_walk(scene: &mut Scene, v: &[f64]) {
    let step = v[0] / (scene.n as f64).sqrt();
    let mut walked = 0.0;
    for k in 0..scene.n {
        scene.phase[k] += walked;
        if k + 1 < scene.n {
            walked += step * scene.normal();
        }
    }
    let n = scene.n as f64;
    scene.shift = walked / TAU * n / (n - 1.0);
}

/// A phase that jumps once, anywhere, either way.
pub fn phase_jump(scene: &mut Scene, v: &[f64]) {
    let (jump, at) = (v[0] * scene.sign(), scene.share());
    for (k, u) in scene.places().enumerate() {
        scene.phase[k] += if u < at { 0.0 } else { jump };
    }
}

/// A frequency that changes once, anywhere, either way; the phase is continuous.
pub fn frequency_step(scene: &mut Scene, v: &[f64]) {
    let (step, at) = (v[0] * scene.sign(), scene.share());
    for (k, u) in scene.places().enumerate() {
        scene.phase[k] += TAU * step * (u - at).max(0.0);
    }
    scene.shift = step * (1.0 - at);
}

/// A tone that begins in the block.
pub fn start(scene: &mut Scene, v: &[f64]) {
    scene.gain = scene.places().map(|u| if u < v[0] { 0.0 } else { 1.0 }).collect();
}

/// A tone that dies away.
pub fn decay(scene: &mut Scene, v: &[f64]) {
    scene.gain = scene.places().map(|u| (-u / v[0]).exp()).collect();
}

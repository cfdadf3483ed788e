//! What changes the tone itself: its frequency, phase or level within the block.

use super::scene::Scene;
use num_complex::Complex;
use picket_simulator::Speckle;
use rand::RngExt;
use std::f64::consts::{PI, TAU};

/// An even change of the frequency over the block, either way. The mean is that in the middle.
pub fn chirp(scene: &mut Scene, v: &[f64]) {
    let rate = v[0] * scene.sign();
    let middle = (scene.n as f64 - 1.0) / (2.0 * scene.n as f64);
    scene.turn(|u| PI * rate * (u - middle).powi(2));
}

/// An amplitude that swings about its mean.
pub fn am(scene: &mut Scene, v: &[f64]) {
    let start = TAU * scene.share();
    scene.modulate(|u| 1.0 + v[0] * (TAU * v[1] * u + start).cos());
}

/// A phase that wanders at random. The mean frequency is what takes it from its first value to its last.
pub fn phase_walk(scene: &mut Scene, v: &[f64]) {
    scene.shift += scene.wander(v[0]);
}

/// A carrier whose line is Lorentzian. The true frequency is the carrier's, wherever the phase wandered in this block.
pub fn linewidth(scene: &mut Scene, v: &[f64]) {
    scene.wander((TAU * v[0]).sqrt());
}

/// A phase that jumps once, anywhere, either way.
pub fn phase_jump(scene: &mut Scene, v: &[f64]) {
    let (jump, at) = (v[0] * scene.sign(), scene.share());
    scene.turn(|u| if u < at { 0.0 } else { jump });
}

/// A frequency that changes once, anywhere, either way; the phase is continuous.
pub fn frequency_step(scene: &mut Scene, v: &[f64]) {
    let (step, at) = (v[0] * scene.sign(), scene.share());
    scene.turn(|u| TAU * step * (u - at).max(0.0));
    scene.shift += step * (1.0 - at);
}

/// A frequency that swings about the carrier. The mean is that over the block.
pub fn fm(scene: &mut Scene, v: &[f64]) {
    let (start, index) = (TAU * scene.share(), v[0] / v[1]);
    let angle = |u: f64| index * (TAU * v[1] * u + start).sin();
    scene.turn(angle);
    scene.shift += (angle(1.0) - angle(0.0)) / TAU;
}

/// A tone that begins in the block.
pub fn start(scene: &mut Scene, v: &[f64]) {
    scene.modulate(|u| if u < v[0] { 0.0 } else { 1.0 });
}

/// A tone that dies away.
pub fn decay(scene: &mut Scene, v: &[f64]) {
    scene.modulate(|u| (-u / v[0]).exp());
}

/// The envelope of a particle in a Gaussian beam, `deviation` blocks wide, at `distance` blocks from its middle.
fn crossing(distance: f64, deviation: f64) -> f64 {
    (-0.5 * (distance / deviation).powi(2)).exp()
}

/// One particle in a laser's fringes, with its middle anywhere in the block. The pedestal is the light without its fringes.
pub fn burst(scene: &mut Scene, v: &[f64]) {
    let (deviation, middle) = (v[0], scene.share());
    scene.modulate(|u| crossing(u - middle, deviation));
    let level = scene.direction() * (v[1] * scene.amplitude);
    scene.add(|u| level * crossing(u - middle, deviation));
}

/// Particles that come at random in a steady flow, each with a level and a phase of its own.
pub fn particles(scene: &mut Scene, v: &[f64]) {
    let (rate, deviation, span) = (v[0], v[1], scene.span());
    // Four deviations from its middle a particle has 3e-4 of its amplitude.
    let reach = 4.0 * deviation;
    let (mut middle, mut all) = (span.0 - reach, Vec::new());
    loop {
        middle -= (1.0 - scene.share()).ln() / rate;
        if middle > span.1 + reach {
            break;
        }
        // Particles are of different sizes, and cross the beam at different distances.
        let level = (-2.0 * scene.share()).exp();
        all.push((middle, Complex::from_polar(level, TAU * scene.share())));
    }
    let of = |u: f64| {
        move |&(middle, level): &(f64, Complex<f64>)| level * crossing(u - middle, deviation)
    };
    scene.envelop(|u| all.iter().map(of(u)).sum());
}

/// The envelope of a rough surface that moves across a beam.
pub fn speckle(scene: &mut Scene, v: &[f64]) {
    let (from, to) = scene.span();
    let speckle = Speckle::new(from, to, v[0], || scene.normal());
    scene.envelop(|u| {
        let [re, im] = speckle.at(u);
        Complex::new(re, im)
    });
}

/// The standard deviation of the time for which a blade hides the body, in times from one blade to the next.
const BLADE: f64 = 0.1;

/// Blades that pass before the body, and hide so much of it.
pub fn blades(scene: &mut Scene, v: &[f64]) {
    let start = scene.share();
    scene.modulate(|u| {
        let turned = v[1] * u + start;
        1.0 - v[0] * crossing(turned - turned.round(), BLADE)
    });
}

/// A tone that is on or off, bit by bit, at random.
pub fn keying(scene: &mut Scene, v: &[f64]) {
    let (count, start, span) = (v[0], scene.share(), scene.span());
    let bit = |u: f64| (count * u + start).floor();
    let first = bit(span.0);
    let bits = (0..=(bit(span.1) - first) as usize).map(|_| f64::from(scene.rng.random_bool(0.5)));
    let bits: Vec<f64> = bits.collect();
    scene.modulate(|u| bits[(bit(u) - first) as usize]);
}

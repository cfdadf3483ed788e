//! When samples are taken, and which ones come: clocks, lost and doubled samples.

use super::scene::Scene;
use rand::RngExt;

/// Samples that are missing in one place; what comes after moves up.
pub fn lost(scene: &mut Scene, v: &[f64]) {
    let from = scene.rng.random_range(1..scene.n);
    for instants in &mut scene.instants {
        instants[from..].iter_mut().for_each(|t| *t += v[0].round());
    }
}

/// A sample that comes again, this many times.
pub fn doubled(scene: &mut Scene, v: &[f64]) {
    scene.copies = Some((scene.rng.random_range(1..scene.n), v[0].round() as usize));
}

/// A clock that trembles.
pub fn jitter(scene: &mut Scene, v: &[f64]) {
    for k in 0..scene.n {
        let late = v[0] * scene.normal();
        scene.instants.iter_mut().for_each(|instants| instants[k] += late);
    }
}

/// Two converters in turn, one of them late.
pub fn skew(scene: &mut Scene, v: &[f64]) {
    for instants in &mut scene.instants {
        instants.iter_mut().skip(1).step_by(2).for_each(|t| *t += v[0]);
    }
}

/// Q is the signal of this many samples ago.
pub fn iq_delay(scene: &mut Scene, v: &[f64]) {
    scene.instants[1].iter_mut().for_each(|t| *t -= v[0]);
}

//! Noise that is not white: its power density over frequency. The power of all of it is what the ratio says.

use super::scene::Scene;

fn of(scene: &mut Scene, density: impl Fn(f64) -> f64 + 'static) {
    scene.density.push(Box::new(density));
}

/// Decibels that rise evenly over the band.
pub fn slope(scene: &mut Scene, v: &[f64]) {
    let (db, iq) = (v[0], scene.iq);
    of(scene, move |nu| 10f64.powf(db / 10.0 * if iq { nu + 0.5 } else { 2.0 * nu }));
}

/// A bump or a dent of Gaussian shape, in decibels, beside the tone on either side.
pub fn bump(scene: &mut Scene, v: &[f64]) {
    let n = scene.n as f64;
    let (db, width) = (v[0], v[1] / n);
    let centre = (scene.nominal + v[2] * scene.sign()) / n;
    of(scene, move |nu| {
        let x = (nu - centre) / width;
        10f64.powf(db / 10.0 * (-0.5 * x * x).exp())
    });
}

/// A power of one over the frequency.
pub fn flicker(scene: &mut Scene, v: &[f64]) {
    let power = v[0];
    of(scene, move |nu| nu.abs().powf(-power));
}

/// A filter of Butterworth's shape, its corner as a share of Nyquist's frequency.
pub fn low_pass(scene: &mut Scene, v: &[f64]) {
    let (corner, order) = (v[0] / 2.0, v[1]);
    of(scene, move |nu| 1.0 / (1.0 + (nu.abs() / corner).powf(2.0 * order)));
}

/// Sections of a resistor and a capacitor, one behind the other.
pub fn rc(scene: &mut Scene, v: &[f64]) {
    let (corner, sections) = (v[0] / 2.0, v[1]);
    of(scene, move |nu| (1.0 + (nu / corner).powi(2)).powf(-sections));
}

/// A band about the middle, Butterworth's shape of order 8 at both edges.
pub fn band_pass(scene: &mut Scene, v: &[f64]) {
    let (middle, half) = (v[0] / 2.0, v[1] / 4.0);
    of(scene, move |nu| 1.0 / (1.0 + ((nu.abs() - middle) / half).powi(16)));
}

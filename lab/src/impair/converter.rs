//! What amplifier and converter do to a voltage.

use super::scene::Scene;
use num_complex::Complex;

fn front(scene: &mut Scene, front: impl Fn(Complex<f64>) -> Complex<f64> + 'static) {
    scene.front.push(Box::new(front));
}

/// Adds a front end that changes I and Q alike.
fn each(scene: &mut Scene, part: impl Fn(f64) -> f64 + 'static) {
    front(scene, move |x| Complex::new(part(x.re), part(x.im)));
}

/// An amplifier that ends below the tone's crest, while the converter's rails are far.
pub fn clip_analogue(scene: &mut Scene, v: &[f64]) {
    let most = scene.amplitude * 10f64.powf(-v[0] / 20.0);
    each(scene, move |x| x.clamp(-most, most));
}

/// A tone beyond the converter's rails.
pub fn clip_converter(scene: &mut Scene, v: &[f64]) {
    scene.amplitude = scene.rail * 10f64.powf(v[0] / 20.0);
}

/// A characteristic that is bent: a bow and an S, together this many codes at most.
pub fn inl(scene: &mut Scene, v: &[f64]) {
    let (lsb, rail) = (v[0], scene.rail);
    each(scene, move |x| {
        let y = x / rail;
        x + lsb * (0.5 * (1.0 - y * y) + 1.3 * (y * y * y - y))
    });
}

/// The upper three bits weigh too much or too little: steps of this many codes at most.
pub fn steps(scene: &mut Scene, v: &[f64]) {
    let weights: [f64; 3] = std::array::from_fn(|_| v[0] * scene.sign());
    let rail = scene.rail;
    each(scene, move |x| {
        let code = ((x / rail + 1.0) * 4.0).floor().clamp(0.0, 7.0) as usize;
        let wrong = weights.iter().enumerate().filter(|(bit, _)| code >> (2 - bit) & 1 == 1);
        x + wrong.map(|(bit, weight)| weight / f64::from(1 << bit)).sum::<f64>()
    });
}

/// A tone of few codes without noise, which meets them anywhere.
pub fn quantise(scene: &mut Scene, v: &[f64]) {
    scene.amplitude = v[0];
    scene.silent = true;
    let offset = Complex::new(scene.share() - 0.5, scene.share() - 0.5);
    scene.added.iter_mut().for_each(|added| *added += offset);
}

/// Q is stronger.
pub fn iq_gain(scene: &mut Scene, v: &[f64]) {
    let gain = 10f64.powf(v[0] / 20.0);
    front(scene, move |x| Complex::new(x.re, x.im * gain));
}

/// Q is not at right angles.
pub fn iq_phase(scene: &mut Scene, v: &[f64]) {
    let (sin, cos) = v[0].to_radians().sin_cos();
    front(scene, move |x| Complex::new(x.re, x.im * cos + x.re * sin));
}

/// One part brings nothing.
pub fn iq_dead(scene: &mut Scene, v: &[f64]) {
    let q = v[0] > 0.5;
    front(scene, move |x| if q { Complex::new(x.re, 0.0) } else { Complex::new(0.0, x.im) });
}

//! What goes wrong behind the converter: in its codes, or on their way into memory.

use super::scene::Scene;
use num_complex::Complex;

/// What becomes of each code, of I and of Q alike.
fn codes(scene: &mut Scene, part: impl Fn(f64) -> f64 + 'static) {
    scene.digital.push(Box::new(move |x| Complex::new(part(x.re), part(x.im))));
}

/// A tone beyond the rails, whose codes go on at the other end.
pub fn wrap(scene: &mut Scene, v: &[f64]) {
    scene.amplitude = scene.rail * 10f64.powf(v[0] / 20.0);
    scene.wraps = true;
}

/// Two samples of a word change places.
pub fn swapped(scene: &mut Scene, _: &[f64]) {
    scene.swapped = true;
}

/// Codes that count from 0 and are read as signed ones, or the other way round: the upper half is below the lower one.
pub fn wrong_sign(scene: &mut Scene, _: &[f64]) {
    let rail = scene.rail;
    codes(scene, move |x| if x < 0.0 { x + rail } else { x - rail });
}

/// A line of the bus that is always low (0) or always high (1).
pub fn stuck_bit(scene: &mut Scene, v: &[f64]) {
    let (weight, high, rail) = (v[0].round().exp2(), v[1] > 0.5, scene.rail);
    codes(scene, move |x| {
        let offset = x + rail;
        let set = (offset / weight).floor().rem_euclid(2.0) >= 1.0;
        x + weight * (f64::from(u8::from(high)) - f64::from(u8::from(set)))
    });
}

/// At each change of the upper three bits this many codes never come: the last one before them stands for all.
pub fn missing_codes(scene: &mut Scene, v: &[f64]) {
    let (count, step) = (v[0].round(), scene.rail / 4.0);
    codes(scene, move |x| {
        let over = x.rem_euclid(step);
        if over < count && x > -4.0 * step { x - over - 1.0 } else { x }
    });
}

/// The end of the block is that of the block before: the buffer was read before it was full.
pub fn stale_buffer(scene: &mut Scene, v: &[f64]) {
    let n = scene.n;
    let from = ((1.0 - v[0]) * n as f64).round() as usize;
    for instants in &mut scene.instants {
        instants.iter_mut().skip(from).for_each(|t| *t -= n as f64);
    }
}

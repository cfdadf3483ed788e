//! Noise that is not white.

use crate::draw::Draw;
use crate::scene::Density;
use core::f64::consts::PI;

/// A density, drawn for a run: its factor at a frequency in hertz.
type Factor = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// Noise of unit variance in each part, with a density of its own.
pub(crate) struct Coloured {
    factors: Vec<Factor>,
    iq: bool,
    rate_hz: f64,
    /// The mean of the density over the band.
    mean: f64,
    /// Noise that is not taken yet.
    left: Vec<[f64; 2]>,
    /// Samples of a piece.
    length: usize,
}

/// A piece is so many times as long as what is taken of it: its ends, which meet, are far apart.
const PIECE: usize = 8;

impl Coloured {
    /// Noise for this many samples. `nominal_hz` is the frequency of the first tone.
    pub fn new(
        shape: &[Density],
        iq: bool,
        rate_hz: f64,
        samples: usize,
        nominal_hz: f64,
        draw: &mut Draw,
    ) -> Self {
        let factors =
            shape.iter().map(|density| factor(density, iq, rate_hz, nominal_hz, draw)).collect();
        let length = (PIECE * samples.clamp(64, 1 << 16)).next_power_of_two();
        let mut noise = Coloured { factors, iq, rate_hz, mean: 1.0, left: Vec::new(), length };
        let step = rate_hz / length as f64;
        let total: f64 =
            (0..length).map(|k| noise.density(noise.hertz(k).max(-0.5 * rate_hz), step)).sum();
        noise.mean = total / length as f64;
        noise
    }

    /// The frequency of a bin of a piece.
    fn hertz(&self, bin: usize) -> f64 {
        let share = bin as f64 / self.length as f64;
        self.rate_hz * if share < 0.5 { share } else { share - 1.0 }
    }

    /// The density at a frequency, on any scale. At 0 Hz it is that of the next bin.
    fn density(&self, hz: f64, step: f64) -> f64 {
        let hz = if hz == 0.0 { step } else { hz };
        let hz = if self.iq { hz } else { hz.abs() };
        self.factors.iter().map(|factor| factor(hz)).product()
    }

    /// The density at a frequency over that of white noise of the same power.
    pub fn at(&self, hz: f64) -> f64 {
        self.density(hz, self.rate_hz / self.length as f64) / self.mean
    }

    /// The next sample.
    pub fn next(&mut self, draw: &mut Draw) -> [f64; 2] {
        if let Some(sample) = self.left.pop() {
            return sample;
        }
        let scale = 1.0 / self.length as f64;
        let mut piece: Vec<[f64; 2]> = (0..self.length)
            .map(|k| {
                // The transform turns backwards.
                let level = libm::sqrt(self.at(-self.hertz(k)) * scale);
                [level * draw.normal(), level * draw.normal()]
            })
            .collect();
        transform(&mut piece);
        piece.truncate(self.length / PIECE);
        self.left = piece;
        self.left.pop().unwrap_or_default()
    }
}

fn factor(density: &Density, iq: bool, rate_hz: f64, nominal_hz: f64, draw: &mut Draw) -> Factor {
    let decibels = |db: f64| libm::exp10(db / 10.0);
    match density {
        Density::Slope { rise_db } => {
            let rise = rise_db.draw(draw);
            Box::new(move |hz| {
                let share = hz / rate_hz;
                decibels(rise * if iq { share + 0.5 } else { 2.0 * share })
            })
        }
        Density::Bump { level_db, width_hz, offset_hz, at_hz } => {
            let [level, width, offset] =
                [level_db, width_hz, offset_hz].map(|value| value.draw(draw));
            let middle = at_hz.as_ref().map_or(nominal_hz, |value| value.draw(draw)) + offset;
            Box::new(move |hz| {
                let x = (hz - middle) / width;
                decibels(level * libm::exp(-0.5 * (x * x)))
            })
        }
        Density::Flicker { power } => {
            let power = power.draw(draw);
            Box::new(move |hz| libm::pow(hz.abs() / rate_hz, -power))
        }
        Density::LowPass { corner_hz, order } => {
            let (corner, order) = (corner_hz.draw(draw), *order);
            Box::new(move |hz| 1.0 / (1.0 + libm::pow(hz.abs() / corner, 2.0 * order)))
        }
        Density::Rc { corner_hz, sections } => {
            let (corner, sections) = (corner_hz.draw(draw), *sections);
            Box::new(move |hz| libm::pow(1.0 + (hz / corner) * (hz / corner), -sections))
        }
        Density::BandPass { middle_hz, width_hz } => {
            let [middle, width] = [middle_hz, width_hz].map(|value| value.draw(draw));
            Box::new(move |hz| 1.0 / (1.0 + libm::pow((hz.abs() - middle) / (0.5 * width), 16.0)))
        }
        Density::Points { points, beside_tone } => {
            let from_hz = if *beside_tone { nominal_hz } else { 0.0 };
            let course = crate::value::Value::Over(points.clone()).course(draw);
            Box::new(move |hz| decibels(course.at(hz - from_hz)))
        }
    }
}

/// The transform of a power of two points, by Cooley and Tukey, in place. It is here, and no library's, because its result is then the same on
/// every machine: libraries take the sines that the machine has.
fn transform(data: &mut [[f64; 2]]) {
    let n = data.len();
    let bits = n.trailing_zeros();
    for index in 0..n {
        let other = index.reverse_bits() >> (usize::BITS - bits);
        if index < other {
            data.swap(index, other);
        }
    }
    let mut half = 1;
    while half < n {
        let turns: Vec<(f64, f64)> =
            (0..half).map(|k| libm::sincos(PI * k as f64 / half as f64)).collect();
        for block in data.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for ((a, b), (sin, cos)) in low.iter_mut().zip(high).zip(&turns) {
                let turned = [b[0] * cos - b[1] * sin, b[0] * sin + b[1] * cos];
                *b = [a[0] - turned[0], a[1] - turned[1]];
                *a = [a[0] + turned[0], a[1] + turned[1]];
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// Against the sum that defines it.
    #[test]
    fn the_transform_is_its_definition() {
        let mut draw = Draw::new(1, 0);
        let data: Vec<[f64; 2]> = (0..32).map(|_| [draw.normal(), draw.normal()]).collect();
        let mut fast = data.clone();
        transform(&mut fast);
        for (k, fast) in fast.iter().enumerate() {
            let mut sum = [0.0; 2];
            for (m, x) in data.iter().enumerate() {
                let (sin, cos) = libm::sincos(TAU * (k * m) as f64 / 32.0);
                sum = [sum[0] + x[0] * cos - x[1] * sin, sum[1] + x[0] * sin + x[1] * cos];
            }
            assert!((sum[0] - fast[0]).abs() + (sum[1] - fast[1]).abs() < 1e-12);
        }
    }
}

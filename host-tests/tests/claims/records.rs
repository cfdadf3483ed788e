//! Records of a tone with one thing wrong, from the physics of each.

use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// What is beside a steady tone in white noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scene {
    /// Nothing; the tone is within these shares of the rate, or of the bins.
    Clean,
    /// Nothing, with the tone at bins 4 to 12.
    Low,
    /// Another line of so many dB, so many bins off.
    Two { db: f64, bins: f64 },
    /// The phase jumps once.
    Jump(f64),
    /// The phase walks; its deviation after the record in radians.
    Walk(f64),
    /// The frequency rises by so many bins.
    Chirp(f64),
    /// The amplitude swings, by a share, so many times.
    Am { depth: f64, cycles: f64 },
    /// The phase swings by so many radians, so many times.
    Fm { radians: f64, cycles: f64 },
    /// The amplitude falls to 1/e in so many records.
    Decay(f64),
    /// The tone begins after this share of the record.
    From(f64),
    /// The tone is on for this share of the record, anywhere.
    On(f64),
    /// The tone is keyed on and off so many times a record.
    Keyed(f64),
    /// A Gaussian burst of this deviation in records, in the middle.
    Burst(f64),
    /// A Gaussian burst of this deviation in records, anywhere.
    BurstAnywhere(f64),
    /// A drift by this share of full scale; at low bins or not.
    Drift(f64, bool),
    /// Hum of .3 to 1.5 cycles, of this share of the amplitude; at low bins or not.
    Hum(f64, bool),
    /// Harmonics 2 and 3 of so many dB, with the tone near this share of the rate, or anywhere.
    Harmonics(f64, Option<f64>),
    /// The noise has this shape.
    Colour(Colour),
    /// So much of the samples is clipped; the tone near this share of the rate, or anywhere.
    Clipped(f64, Option<f64>),
    /// The tone exceeds the rails by this factor, and another line is beside it.
    ClippedTwo { over: f64, db: f64, bins: f64 },
    /// An I/Q offset, a share of full scale.
    Offset(f64),
}

/// The shape of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Colour {
    /// dB in an eighth of the rate, through the tone.
    Slope(f64),
    /// dB within a 16th of the rate on each side of the tone.
    Hump(f64),
    /// A filter of fourth order at this share of half the rate.
    Filtered(f64),
    /// Power as 1/f.
    Pink,
}

pub struct Taken {
    pub samples: Vec<[f64; 2]>,
    /// Bins.
    pub truth: f64,
    /// Of several lines as strong another one, which is as right.
    pub other: f64,
    /// The Cramer-Rao bound of the tone alone, bins.
    pub bound: f64,
}

const AMPLITUDE: f64 = 1000.0;

impl Scene {
    /// A record of n samples.
    pub fn record(self, rng: &mut ChaCha8Rng, n: usize, iq: bool, snr_db: f64) -> Taken {
        let length = n as f64;
        let mut anything = |low: f64, high: f64| rng.random_range(low..high);
        let near = |place: f64| (place * length - 3.0, place * length + 3.0);
        let (low, high) = match self {
            Scene::Low => (4.0, 12.0),
            Scene::Drift(_, true) | Scene::Hum(_, true) => (5.0, 20.0),
            Scene::Offset(_) => (2.0, 10.0),
            Scene::Harmonics(_, Some(place)) | Scene::Clipped(_, Some(place)) => near(place),
            Scene::Colour(Colour::Pink) => (0.02 * length, 0.1 * length),
            Scene::Colour(Colour::Filtered(share)) => {
                (0.04 * length, 0.2 * share.max(0.5) * 2.0 * length * 0.5)
            }
            Scene::Colour(_) => (0.1 * length, 0.4 * length),
            _ => (0.06 * length, 0.44 * length),
        };
        let mut f = anything(low, high);
        if iq && !matches!(self, Scene::Offset(_)) && anything(0.0, 1.0) < 0.5 {
            f = -f;
        }
        let [phase, other, third, at, part] = [(); 5].map(|()| anything(0.0, 1.0));
        let sign = if third < 0.5 { 1.0 } else { -1.0 };
        let turn = |turns: f64| {
            let (sin, cos) = (TAU * turns).sin_cos();
            Complex::new(cos, sin)
        };
        let amplitude = match self {
            Scene::Decay(_) => 1.8 * AMPLITUDE,
            Scene::Clipped(percent, _) => 2047.0 / (percent / 200.0 * std::f64::consts::PI).cos(),
            Scene::ClippedTwo { over, .. } => 2047.0 * over,
            _ => AMPLITUDE,
        };
        let deviation = amplitude * (0.5 / 10f64.powf(snr_db / 10.0)).sqrt();
        let noise = self.noise(rng, n, iq, f, deviation);
        let mut walk = 0.0;
        let samples = noise.into_iter().enumerate().map(|(i, noise)| {
            let u = i as f64 / length;
            let tone = turn(f * u + phase);
            let (mut x, mut extra) = (tone, Complex::new(0.0, 0.0));
            match self {
                Scene::Two { db, bins } | Scene::ClippedTwo { db, bins, .. } => {
                    extra = turn((f + sign * bins) * u + other) * 10f64.powf(db / 20.0);
                }
                Scene::Jump(radians) => {
                    if u >= 0.1 + 0.8 * at {
                        x *= turn(radians / TAU);
                    }
                }
                Scene::Walk(radians) => {
                    walk += rng.sample::<f64, _>(StandardNormal) * radians / length.sqrt();
                    x *= turn(walk / TAU);
                }
                Scene::Chirp(bins) => {
                    // About the middle of the samples.
                    let v = u - 0.5 + 0.5 / length;
                    x *= turn(bins * 0.5 * v * v);
                }
                Scene::Am { depth, cycles } => x *= 1.0 + depth * turn(cycles * u + other).re,
                Scene::Fm { radians, cycles } => {
                    x *= turn(radians / TAU * turn(cycles * u + other).re);
                }
                Scene::Decay(records) => x *= (-u / records).exp(),
                Scene::From(share) => x *= f64::from(u8::from(u >= share)),
                Scene::On(share) => {
                    let begin = at * (1.0 - share);
                    x *= f64::from(u8::from((begin..begin + share).contains(&u)));
                }
                Scene::Keyed(times) => x *= f64::from(u8::from((times * u + at).fract() < 0.5)),
                Scene::Burst(width) => x *= (-0.5 * ((u - 0.5) / width).powi(2)).exp(),
                Scene::BurstAnywhere(width) => x *= (-0.5 * ((u - at) / width).powi(2)).exp(),
                Scene::Drift(share, _) => extra.re = sign * share * 2048.0 / amplitude * (u - 0.5),
                Scene::Hum(share, _) => extra.re = share * turn((0.3 + 1.2 * part) * u + other).re,
                Scene::Harmonics(db, _) => {
                    let size = 10f64.powf(db / 20.0);
                    for (order, aside) in [(2.0, other), (3.0, at)] {
                        extra += turn(order * (f * u + phase) + aside) * size;
                    }
                }
                Scene::Offset(share) => extra = turn(other) * (share * 2048.0 / amplitude),
                Scene::Clean | Scene::Low | Scene::Colour(_) | Scene::Clipped(..) => {}
            }
            let x = (x + extra) * amplitude;
            [x.re + noise[0], x.im + noise[1]]
        });
        let samples = samples.collect();
        let power = 2.0 * (deviation * deviation + 1.0 / 12.0) / (amplitude * amplitude);
        let bound = (if iq { 6.0 } else { 12.0 } * power / (TAU * TAU * length)).sqrt();
        let other = match self {
            Scene::Two { db, bins } if db > -1.0 => f + sign * bins,
            // Without a carrier the sideband is the line.
            Scene::Fm { radians, cycles } if radians > 1.4 => f + cycles * sign,
            _ => f,
        };
        Taken { samples, truth: f, other, bound }
    }

    fn noise(
        self,
        rng: &mut ChaCha8Rng,
        n: usize,
        iq: bool,
        f: f64,
        deviation: f64,
    ) -> Vec<[f64; 2]> {
        let mut white =
            || Complex::new(rng.sample(StandardNormal), rng.sample(StandardNormal)) * deviation;
        let white: Vec<Complex<f64>> = (0..n).map(|_| white()).collect();
        let Scene::Colour(colour) = self else {
            return white.into_iter().map(|z: Complex<f64>| [z.re, z.im]).collect();
        };
        let mut bins = white;
        <f64 as Transform>::forward(n).process(&mut bins);
        let length = n as f64;
        for (k, bin) in bins.iter_mut().enumerate() {
            let k = if k > n / 2 { k as f64 - length } else { k as f64 };
            // A real record has the shape on both sides.
            let signed = if iq { k } else { k.abs() };
            let apart = signed - f;
            *bin *= match colour {
                Colour::Slope(db) => {
                    10f64.powf((apart / (length / 8.0)).clamp(-2.0, 2.0) * db / 20.0)
                }
                Colour::Hump(db) if apart.abs() < length / 16.0 => 10f64.powf(db / 20.0),
                Colour::Hump(_) => 1.0,
                Colour::Filtered(share) => {
                    1.0 / (1.0 + (k / (share * length / 2.0)).powi(8)).sqrt()
                }
                Colour::Pink => (k.abs().max(1.0) / (0.06 * length)).powf(-0.5),
            };
        }
        <f64 as Transform>::inverse(n).process(&mut bins);
        bins.into_iter().map(|z| [z.re / length, z.im / length]).collect()
    }

    /// A name for tables.
    pub fn group(self) -> &'static str {
        match self {
            Scene::Clean | Scene::Low => "clean",
            Scene::Two { bins, .. } if bins < 1.0 => "two lines < 1 bin",
            Scene::Two { bins, .. } if bins <= 2.0 => "two lines 1 to 2 bins",
            Scene::Two { .. } => "two lines 5, 10 bins",
            Scene::Jump(_) => "jump",
            Scene::Walk(_) => "walk",
            Scene::Chirp(_) => "chirp",
            Scene::Am { .. } => "am",
            Scene::Fm { .. } => "fm",
            Scene::Decay(_) => "decay",
            Scene::From(_) => "late start",
            Scene::On(_) => "on for a part",
            Scene::Keyed(_) => "keyed",
            Scene::Burst(_) => "burst in the middle",
            Scene::BurstAnywhere(_) => "burst anywhere",
            Scene::Drift(..) => "drift",
            Scene::Hum(..) => "hum",
            Scene::Harmonics(_, None) => "harmonics anywhere",
            Scene::Harmonics(..) => "harmonics at N/4, N/3",
            Scene::Colour(_) => "colour",
            Scene::Clipped(..) => "clipped",
            Scene::ClippedTwo { .. } => "clipped, two lines",
            Scene::Offset(_) => "offset",
        }
    }

    /// Every scene of the campaign for a kind of record.
    pub fn all(iq: bool) -> Vec<Self> {
        let mut all = vec![Scene::Clean];
        if !iq {
            all.push(Scene::Low);
        }
        for db in [0.0, -6.0, -20.0, -40.0] {
            all.extend(
                [0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 5.0, 10.0].map(|bins| Scene::Two { db, bins }),
            );
        }
        all.extend([0.01, 0.03, 0.1, 0.3, 1.0].map(Scene::Jump));
        all.extend([0.01, 0.03, 0.1, 0.3].map(Scene::Walk));
        all.extend([0.05, 0.1, 0.3, 0.5, 1.0, 3.0].map(Scene::Chirp));
        all.extend(
            [(0.1, 0.3), (0.1, 1.0), (0.3, 0.5), (0.3, 1.0), (0.5, 0.3), (0.5, 3.0), (0.5, 10.0)]
                .map(|(depth, cycles)| Scene::Am { depth, cycles }),
        );
        all.extend(
            [(0.1, 3.0), (0.5, 3.0), (0.5, 10.0), (1.5, 5.0)]
                .map(|(radians, cycles)| Scene::Fm { radians, cycles }),
        );
        all.extend([2.0, 1.0, 0.5, 0.2].map(Scene::Decay));
        all.extend([0.25, 0.5].map(Scene::From));
        all.extend([0.25, 0.5, 0.75].map(Scene::On));
        all.extend([2.0, 5.0].map(Scene::Keyed));
        all.extend([0.1, 0.2, 0.4].map(Scene::Burst));
        all.extend([0.1, 0.2].map(Scene::BurstAnywhere));
        all.extend([-10.0, 20.0].map(|db| Scene::Colour(Colour::Slope(db))));
        all.extend([-10.0, 6.0].map(|db| Scene::Colour(Colour::Hump(db))));
        all.extend([0.5, 0.25].map(|share| Scene::Colour(Colour::Filtered(share))));
        if iq {
            all.extend([0.01, 0.1].map(Scene::Offset));
        } else {
            all.push(Scene::Colour(Colour::Pink));
            for low in [true, false] {
                all.extend([0.01, 0.05, 0.2].map(|share| Scene::Drift(share, low)));
                all.extend([0.03, 0.3].map(|share| Scene::Hum(share, low)));
            }
            for place in [None, Some(1.0 / 4.0), Some(1.0 / 3.0)] {
                all.extend([-20.0, -40.0].map(|db| Scene::Harmonics(db, place)));
            }
            for place in [None, Some(1.0 / 4.0)] {
                all.push(Scene::Clipped(0.9, place));
            }
        }
        all.extend(
            [(1.1, -6.0, 8.3), (1.3, -20.0, 3.4), (2.0, -30.0, 1.8)]
                .map(|(over, db, bins)| Scene::ClippedTwo { over, db, bins }),
        );
        all
    }
}

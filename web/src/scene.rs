//! A simulated scene: a tone, a moving reflector or two before a radar, with what goes wrong in practice.
//!
//! A target moves evenly during a block, a radar's during a chirp: what the block is of is then known exactly.

use crate::random::Random;
use crate::settings::{Kind, Settings};
use picket_dsp::Mixing;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{SPEED_OF_LIGHT, Scene as Wave};
use picket_simulator::{Receiver, Sensor, Target};
use std::f64::consts::TAU;

/// The time of one swing at full motion, s.
const SWING_S: f64 = 8.0;
/// Levels at or below this are off, dB.
const OFF_DB: f64 = -80.0;

/// What the sliders say.
#[derive(Clone, Copy, Debug)]
struct Sliders {
    tone_hz: f64,
    velocity_mps: f64,
    range_m: f64,
    /// How fast it swings, 0 to 1; 0 stands or moves evenly.
    motion: f64,
    /// Signal-to-noise ratio per sample, dB.
    snr_db: f64,
    /// The tone's amplitude, dB of full scale; above 0 it clips.
    level_db: f64,
    /// Offset, a share of full scale.
    dc: f64,
    /// Mains of 50 Hz, dB of full scale.
    hum_db: f64,
    /// A second tone or target, dB of the first.
    second_db: f64,
    /// How far off: Hz, m/s or m.
    second_off: f64,
}

impl Default for Sliders {
    fn default() -> Self {
        Self {
            tone_hz: 1000.0,
            velocity_mps: 4.0,
            range_m: 12.0,
            motion: 0.0,
            snr_db: 20.0,
            level_db: -6.0,
            dc: 0.0,
            hum_db: OFF_DB,
            second_db: OFF_DB,
            second_off: 5.0,
        }
    }
}

/// What is true of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// The tone, Hz.
    pub hertz: f64,
    /// The velocity, m/s, where there is one.
    pub velocity_mps: f64,
    /// The range, m, where there is one.
    pub range_m: f64,
}

/// A scene that plays.
#[derive(Clone, Debug)]
pub struct Scene {
    sliders: Sliders,
    /// Blocks so far.
    blocks: u32,
    /// Angles of the first and the second tone and of the hum, in turns.
    turns: [f64; 3],
    /// Where the targets of a Doppler radar are, m.
    places_m: [f64; 2],
    /// What the reflections of a chirp add to the phases, turns.
    reflected: [f64; 2],
    /// The swing, radians.
    swing: f64,
    random: Random,
}

impl Scene {
    /// A scene from its start.
    pub fn new(seed: u64) -> Self {
        Scene {
            sliders: Sliders::default(),
            blocks: 0,
            turns: [0.0; 3],
            places_m: [10.0; 2],
            reflected: [0.0; 2],
            swing: 0.0,
            random: Random::new(seed),
        }
    }

    /// From its start again, with the sliders as they are.
    pub fn again(&mut self, seed: u64) {
        *self = Scene { sliders: self.sliders, ..Scene::new(seed) };
    }

    /// Moves a slider; false for an unknown name.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        let sliders = &mut self.sliders;
        let place = match name {
            "tone_hz" => &mut sliders.tone_hz,
            "velocity_mps" => &mut sliders.velocity_mps,
            "range_m" => &mut sliders.range_m,
            "motion" => &mut sliders.motion,
            "snr_db" => &mut sliders.snr_db,
            "level_db" => &mut sliders.level_db,
            "dc" => &mut sliders.dc,
            "hum_db" => &mut sliders.hum_db,
            "second_db" => &mut sliders.second_db,
            "second_off" => &mut sliders.second_off,
            _ => return false,
        };
        *place = value;
        true
    }

    /// The next block, its stamp and its truth.
    pub fn block(&mut self, settings: &Settings) -> (Stamp, Vec<[i16; 2]>, Truth) {
        let segments = settings.config().scene.segments();
        let index = self.blocks as usize % segments.len().max(1);
        let segment = segments.get(index).copied().unwrap_or(Segment::Continuous);
        let clock = u64::from(self.blocks) * settings.n as u64;
        let stamp = Stamp { sequence: self.blocks, clock, segment, gap: false };
        if index == 0 {
            self.swing += self.turn(settings, segments.len().max(1) as f64);
            self.reflected = [0; 2].map(|_| self.random.share());
        }
        self.blocks = self.blocks.wrapping_add(1);
        let sensor = self.sensor(settings);
        let levels = self.levels(settings);
        let (truth, echoes) = self.echoes(settings, &sensor, levels);
        let beat = echoes.first().map(|target| {
            let hertz = settings.rate_hz * sensor.beat(target, (0, index));
            if settings.iq { hertz } else { hertz.abs() }
        });
        let normal = || self.random.normal();
        let mut voltages = sensor.voltages(&echoes, (0, index), normal);
        let [first, second, hum] = levels;
        let tones = if echoes.is_empty() { [first, second] } else { [0.0; 2] };
        let lines = [
            (truth.hertz, tones[0]),
            (truth.hertz + self.sliders.second_off, tones[1]),
            (50.0, hum),
        ];
        for (turn, (hertz, level)) in self.turns.iter_mut().zip(lines) {
            turned(&mut voltages, turn, hertz / settings.rate_hz, level);
        }
        let samples = voltages.into_iter().map(|voltage| sensor.receiver.convert(voltage));
        (stamp, samples.collect(), Truth { hertz: beat.unwrap_or(truth.hertz), ..truth })
    }

    /// The swing's angle in so many blocks.
    fn turn(&self, settings: &Settings, blocks: f64) -> f64 {
        TAU * self.sliders.motion / SWING_S * blocks * settings.n as f64 / settings.rate_hz
    }

    /// Amplitudes of the first and the second tone or target and of the hum, codes.
    fn levels(&self, settings: &Settings) -> [f64; 3] {
        let Sliders { level_db, hum_db, second_db, .. } = self.sliders;
        let full = settings.full_scale();
        let power = |db: f64| if db <= OFF_DB { 0.0 } else { libm::exp10(db / 20.0) };
        let amplitude = full * libm::exp10(level_db / 20.0);
        [amplitude, amplitude * power(second_db), full * power(hum_db)]
    }

    /// What takes the samples. A tone has no wave.
    fn sensor(&self, settings: &Settings) -> Sensor {
        let full = settings.full_scale();
        let receiver = |mixing| {
            let receiver = Receiver::ideal(settings.rate_hz, settings.iq, mixing);
            let offset = [self.sliders.dc * full; 2];
            let receiver = Receiver { offset, codes: settings.codes, ..receiver };
            receiver.with_snr(self.levels(settings)[0], self.sliders.snr_db)
        };
        match settings.config().scene {
            Wave::Chirp(chirp) => Sensor::chirp(&chirp, receiver(chirp.mixing), settings.n, 0.0),
            Wave::Doppler { wavelength_m, mixing, .. } => {
                let carrier_hz = SPEED_OF_LIGHT / wavelength_m;
                Sensor::continuous(carrier_hz, receiver(mixing), settings.n)
            }
            _ => Sensor::continuous(0.0, receiver(Mixing::default()), settings.n),
        }
    }

    /// The truth but for the frequency of an echo, and the targets, the first one first.
    fn echoes(
        &mut self,
        settings: &Settings,
        sensor: &Sensor,
        [first, second, _]: [f64; 3],
    ) -> (Truth, Vec<Target<'static>>) {
        let Sliders { tone_hz, velocity_mps, range_m, motion, second_off, .. } = self.sliders;
        let (sin, cos) = libm::sincos(self.swing);
        let both = |mut targets: Vec<Target<'static>>| {
            targets.truncate(if second > 0.0 { 2 } else { 1 });
            targets
        };
        match settings.kind {
            Kind::Tone => {
                let hertz = tone_hz * (1.0 + 0.1 * motion.min(1.0) * sin);
                (Truth { hertz, ..Truth::default() }, Vec::new())
            }
            Kind::Doppler => {
                let velocity = velocity_mps * (1.0 + 0.3 * motion.min(1.0) * sin);
                let truth = Truth { velocity_mps: velocity, ..Truth::default() };
                let ([a, b], other) = (self.places_m, velocity + second_off);
                let targets =
                    vec![Target::moving(first, a, velocity), Target::moving(second, b, other)];
                let time_s = settings.n as f64 / settings.rate_hz;
                self.places_m = [a - velocity * time_s, b - other * time_s];
                (truth, both(targets))
            }
            Kind::Chirp => {
                let rate = TAU * motion / SWING_S;
                let reach = if rate > 0.0 { (velocity_mps / rate).min(0.4 * range_m) } else { 0.0 };
                let (range, velocity) = match rate > 0.0 {
                    true => (range_m - reach * sin, reach * rate * cos),
                    false => (range_m, velocity_mps),
                };
                let truth = Truth { velocity_mps: velocity, range_m: range, ..Truth::default() };
                let target = |level: f64, range: f64, velocity: f64, turns: f64| {
                    let begin_m = range + velocity * sensor.middle_s();
                    Target::moving(level, begin_m, velocity).turned(turns)
                };
                let [a, b] = self.reflected;
                let other = target(second, range_m + second_off, -0.5 * velocity_mps, b);
                (truth, both(vec![target(first, range, velocity, a), other]))
            }
        }
    }
}

/// Adds a line of so many turns a sample to voltages; `turn` is its angle.
fn turned(voltages: &mut [[f64; 2]], turn: &mut f64, step: f64, level: f64) {
    if level <= 0.0 {
        return;
    }
    for [i, q] in voltages {
        let (sin, cos) = libm::sincos(TAU * *turn);
        (*i, *q) = (*i + level * cos, *q + level * sin);
        let next = *turn + step;
        *turn = next - libm::floor(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station::station;
    use picket_dsp::pipeline::Outcome;
    use picket_dsp::tone::Verdict;

    /// The errors of so many good answers in units of their sigmas: of the tone, the velocity and the range.
    fn errors(settings: &Settings, sliders: &[(&str, f64)], blocks: usize) -> [Vec<f64>; 3] {
        let mut scene = Scene::new(1);
        assert!(sliders.iter().all(|&(name, value)| scene.set(name, value)));
        let mut station = station(settings).unwrap();
        let mut errors = [const { Vec::new() }; 3];
        for _ in 0..blocks {
            let (stamp, samples, truth) = scene.block(settings);
            let measurement = station.block(stamp, &samples).unwrap();
            let tone = measurement.tone;
            let Truth { hertz, velocity_mps, range_m } = truth;
            // The flat segment's beat passes 0 Hz where the target turns.
            let beside = hertz.abs() < 2.0 * settings.rate_hz / settings.n as f64;
            match tone.verdict {
                Verdict::Good => errors[0].push((tone.hertz() - hertz) / tone.sigma_hertz()),
                Verdict::NearEdge | Verdict::Weak => assert!(beside, "{tone}, {hertz} Hz"),
                _ => panic!("{tone}, {hertz} Hz"),
            }
            match measurement.result {
                Outcome::None => {}
                Outcome::Velocity(v) => {
                    errors[1]
                        .push((v.velocity.to_num::<f64>() - velocity_mps) / f64::from(v.sigma));
                }
                Outcome::Target(t) => {
                    let velocity = t.velocity.unwrap().to_num::<f64>() - velocity_mps;
                    errors[1].push(velocity / f64::from(t.sigma_velocity));
                    errors[2].push((t.range.to_num::<f64>() - range_m) / f64::from(t.sigma_range));
                }
            }
        }
        errors
    }

    /// Seed 1. 3000 squares of a normal number, or 1000: the mean spreads 2.6 %, or 4.5 %, and so half that the root.
    #[test]
    fn every_scene_is_right_within_its_sigmas() {
        let tone = Settings::default();
        let doppler = Settings { kind: Kind::Doppler, ..tone };
        let chirp = Settings { kind: Kind::Chirp, iq: true, rate_hz: 250e3, ..tone };
        let faint = ("level_db", -20.0);
        for (settings, sliders) in [
            (tone, vec![("tone_hz", 1000.3)]),
            (tone, vec![("tone_hz", 7000.1), ("motion", 0.5), ("snr_db", 0.0), faint]),
            (doppler, vec![("velocity_mps", 12.0), ("motion", 0.5), ("snr_db", 0.0), faint]),
            (chirp, vec![("range_m", 120.0), ("velocity_mps", 25.0), ("snr_db", -5.0), faint]),
            (
                chirp,
                vec![
                    ("range_m", 120.0),
                    ("velocity_mps", 25.0),
                    ("motion", 0.5),
                    ("snr_db", -5.0),
                    faint,
                ],
            ),
        ] {
            for errors in
                errors(&settings, &sliders, 3000).iter().filter(|errors| !errors.is_empty())
            {
                let count = errors.len() as f64;
                let rms = (errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
                let mean = errors.iter().sum::<f64>() / count;
                println!(
                    "{:?} {sliders:?}: {count} answers, mean {mean:.3}, rms {rms:.3}",
                    settings.kind
                );
                assert!((rms - 1.0).abs() < 4.0 / (2.0 * count).sqrt() + 0.03, "{rms}");
                assert!(mean.abs() < 4.0 / count.sqrt(), "{mean}");
            }
        }
    }
}

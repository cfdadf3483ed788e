//! A simulated scene: a tone, a moving reflector or two before a radar, with what goes wrong in practice.
//!
//! A target moves evenly during a block, a radar's during a chirp: what the block is of is then known exactly.

use crate::settings::{Kind, Settings};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{SPEED_OF_LIGHT, Scene as Wave};
use picket_dsp::solve::chirp::Mixing::RxConjTx;
use picket_simulator::scene::{Converter, Mixing, Noise, Receiver, Shape, Source};
use picket_simulator::scene::{Target, Tone, Waveform};
use picket_simulator::{Draw, Value};
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
    seed: u64,
    /// Blocks so far.
    blocks: u32,
    /// Phases of the first and the second tone and of the hum, turns.
    turns: [f64; 3],
    /// Where the targets of a Doppler radar are within half a wavelength, m: farther away their phases are the same.
    places_m: [f64; 2],
    /// What the reflections of a chirp add to the phases, turns.
    reflected: [f64; 2],
    /// The swing, radians.
    swing: f64,
}

impl Scene {
    /// A scene from its start.
    pub fn new(seed: u64) -> Self {
        Scene {
            sliders: Sliders::default(),
            seed,
            blocks: 0,
            turns: [0.0; 3],
            places_m: [0.0; 2],
            reflected: [0.0; 2],
            swing: 0.0,
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
            let mut draw = Draw::new(self.seed, self.blocks.into());
            self.reflected = [0; 2].map(|_| draw.share());
        }
        let trial = self.blocks.into();
        self.blocks = self.blocks.wrapping_add(1);
        let (mut truth, scene) = self.scene(settings);
        let n = settings.n;
        // Settings that cannot be measured have no samples.
        let Ok(mut run) = scene.run(trial) else { return (stamp, vec![[0; 2]; n], truth) };
        let hertz = run.truth(0, scene.start_s(index, n), n).frequency_hz;
        truth.hertz = if settings.iq { hertz } else { hertz.abs() };
        (stamp, run.record(index, n), truth)
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

    /// The scene of a block, and its truth except for the frequency. A chirp's has all segments of its waveform, the other one has the block alone.
    fn scene(&mut self, settings: &Settings) -> (Truth, picket_simulator::Scene) {
        let (rate_hz, n) = (settings.rate_hz, settings.n);
        let [first, second, hum] = self.levels(settings);
        let block_s = n as f64 / rate_hz;
        let full = settings.full_scale();
        let wave = settings.config().scene;
        let (low, high) = settings.codes.rails();
        let mut scene = picket_simulator::Scene {
            seed: self.seed,
            rate_hz,
            seconds: block_s,
            receiver: Receiver {
                iq: settings.iq,
                mixing: match wave {
                    Wave::Chirp(picket_dsp::Chirp { mixing: RxConjTx, .. })
                    | Wave::Doppler { mixing: RxConjTx, .. } => Mixing::RxConjTx,
                    _ => Mixing::TxConjRx,
                },
                offset: [0; 2].map(|_| (self.sliders.dc * full).into()),
                noise: Noise { snr_db: Some(self.sliders.snr_db.into()), ..Noise::default() },
                ..Receiver::default()
            },
            converter: Converter { rails: Some([low, high]), ..Converter::default() },
            ..picket_simulator::Scene::default()
        };
        match wave {
            Wave::Chirp(chirp) => {
                scene.seconds = 3.0 * chirp.duration_s;
                scene.waveform = Some(Waveform {
                    shape: Shape::Trapezoid,
                    carrier_hz: SPEED_OF_LIGHT / chirp.wavelength_m,
                    bandwidth_hz: chirp.bandwidth_hz,
                    ramp_s: chirp.duration_s,
                    guard_s: Some(chirp.guard_s),
                    samples: n,
                    ..Waveform::default()
                });
            }
            Wave::Doppler { wavelength_m, .. } => {
                let carrier_hz = SPEED_OF_LIGHT / wavelength_m;
                scene.waveform = Some(Waveform { carrier_hz, ..Waveform::default() });
            }
            _ => {}
        }
        let Sliders { tone_hz, velocity_mps, range_m, motion, second_off, .. } = self.sliders;
        let (sin, cos) = libm::sincos(self.swing);
        let target = |amplitude: f64, range_m: f64, velocity_mps: f64, turns: f64| {
            Source::Target(Target {
                range_m: range_m.into(),
                velocity_mps: velocity_mps.into(),
                amplitude: Some(amplitude.into()),
                phase_turns: turns.into(),
                ..Target::default()
            })
        };
        let mut truth = Truth::default();
        match settings.kind {
            Kind::Tone => {
                let hertz = tone_hz * (1.0 + 0.1 * motion.min(1.0) * sin);
                scene.sources.push(self.line(0, hertz, first, block_s));
                if second > 0.0 {
                    scene.sources.push(self.line(1, hertz + second_off, second, block_s));
                }
            }
            Kind::Doppler => {
                let velocity = velocity_mps * (1.0 + 0.3 * motion.min(1.0) * sin);
                truth.velocity_mps = velocity;
                let both = [(first, velocity), (second, velocity + second_off)];
                for ((level, velocity), place_m) in both.into_iter().zip(&mut self.places_m) {
                    if level > 0.0 {
                        scene.sources.push(target(level, *place_m, velocity, 0.0));
                    }
                    *place_m =
                        (*place_m - velocity * block_s).rem_euclid(0.5 * settings.wavelength_m);
                }
            }
            Kind::Chirp => {
                let rate = TAU * motion / SWING_S;
                let reach = if rate > 0.0 { (velocity_mps / rate).min(0.4 * range_m) } else { 0.0 };
                let (range, velocity) = match rate > 0.0 {
                    true => (range_m - reach * sin, reach * rate * cos),
                    false => (range_m, velocity_mps),
                };
                (truth.velocity_mps, truth.range_m) = (velocity, range);
                // The mean of the middles of the first and the last record: to that moment the range refers.
                let ends = [0, 2].map(|index| scene.start_s(index, n));
                let middle_s =
                    f64::midpoint(ends[0], ends[1]) + 0.5 * n.saturating_sub(1) as f64 / rate_hz;
                let mut push = |level: f64, range: f64, velocity: f64, turns: f64| {
                    let begin_m = (range + velocity * middle_s).max(0.0);
                    scene.sources.push(target(level, begin_m, velocity, turns));
                };
                let [a, b] = self.reflected;
                push(first, range, velocity, a);
                if second > 0.0 {
                    push(second, range_m + second_off, -0.5 * velocity_mps, b);
                }
            }
        }
        if hum > 0.0 {
            scene.sources.push(self.line(2, 50.0, hum, block_s));
        }
        (truth, scene)
    }

    /// A line that goes on from block to block.
    fn line(&mut self, number: usize, hertz: f64, amplitude: f64, block_s: f64) -> Source {
        let mut phase_turns = Value::default();
        if let Some(turns) = self.turns.get_mut(number) {
            phase_turns = (*turns).into();
            let next = *turns + hertz * block_s;
            *turns = next - libm::floor(next);
        }
        Source::Tone(Tone {
            frequency_hz: hertz.into(),
            amplitude: Some(amplitude.into()),
            phase_turns,
            ..Tone::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station::Station;
    use picket_dsp::pipeline::Outcome;
    use picket_dsp::tone::Verdict;

    /// The errors of this many good answers in units of their sigmas: of the tone, the velocity and the range.
    fn errors(settings: &Settings, sliders: &[(&str, f64)], blocks: usize) -> [Vec<f64>; 3] {
        let mut scene = Scene::new(1);
        assert!(sliders.iter().all(|&(name, value)| scene.set(name, value)));
        let mut station = Station::new(settings).unwrap();
        let (mut errors, mut moving) = ([const { Vec::new() }; 3], 0);
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
                // Noise looks like motion once in thousands of blocks; sigma covers that, too.
                Verdict::Moving => {
                    errors[0].push((tone.hertz() - hertz) / tone.sigma_hertz());
                    moving += 1;
                }
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
        assert!(moving * 1000 <= blocks, "{moving} of {blocks} steady tones move");
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

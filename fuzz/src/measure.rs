//! Whatever is set, and whatever the samples are, a measurement is a number.

use super::input::Input;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;
use picket_dsp::tracker::Tracker;
use picket_firmware::instrument::plan::Plan;
use picket_wire::follow::Follow;
use picket_wire::frame::Reader;
use picket_wire::settings::Settings;
use picket_wire::telemetry::{Health, Telemetry};

/// Samples in a block.
const N: usize = 64;

/// Settings to a running pipeline: others are adopted between the blocks.
pub fn pipeline(bytes: &[u8]) {
    let mut input = Input(bytes);
    let mut real = Pipeline::<Real, N>::new(picket_dsp::Plan::IDLE);
    let mut iq = Pipeline::<Iq, N>::new(picket_dsp::Plan::IDLE);
    for sequence in 0..2 {
        // A structure is as long as its settings: the others are the next input.
        let head = input.take::<6>();
        let length = usize::from(head[5]).min(Settings::BYTES);
        let mut bytes = head.to_vec();
        bytes.extend((0..length).map(|_| input.take::<1>()[0]));
        let Ok((settings, _)) = Settings::from_bytes(&bytes) else { return };
        let Ok(plan) = Plan::<N>::new(&settings, settings.config.rate_hz) else { return };
        let calibration = settings.calibration;
        for sequence in 2 * sequence..2 * sequence + 2 {
            let stamp = plan.timing.stamp(sequence, sequence == 2);
            let mut measurement = match plan.plan {
                picket_dsp::plan::EitherPlan::Real(plan) => {
                    if sequence % 2 == 0 {
                        real.set_plan(plan);
                    }
                    real.block(&stamp, &samples::<Real, N>(&mut input))
                }
                picket_dsp::plan::EitherPlan::Iq(plan) => {
                    if sequence % 2 == 0 {
                        iq.set_plan(plan);
                    }
                    iq.block(&stamp, &samples::<Iq, N>(&mut input))
                }
            };
            calibration.apply(&mut measurement);
            number(&measurement);
        }
    }
}

/// A configuration of random bits to a tracker and its pipeline, over several blocks.
pub fn tracker(bytes: &[u8]) {
    let mut input = Input(bytes);
    let config = config(&mut input);
    if input.byte() & 1 == 0 {
        follow::<Real>(&config, &mut input);
    } else {
        follow::<Iq>(&config, &mut input);
    }
}

/// The moment of a block: its sequence number may leave some out.
fn stamp(config: &Config, number: u32, input: &mut Input) -> Stamp {
    let segments = config.scene.segments();
    let phase = segments.get(number as usize % segments.len().max(1)).copied();
    Stamp {
        sequence: number.wrapping_add(input.byte().into()),
        clock: u64::from(number) * N as u64,
        segment: phase.unwrap_or(Segment::Continuous),
        gap: input.byte() & 1 != 0,
    }
}

fn follow<R: Record>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<R, N>() else { return };
    let mut tracker = Tracker::<R, N>::new(plan);
    for number in 0..8 {
        let stamp = stamp(config, number, input);
        let measurement = tracker.block(&stamp, &samples::<R, N>(input));
        self::number(&measurement);
        for track in tracker.tracks(stamp.segment) {
            assert!(track.tone.sigma >= 0.0 && !track.rate().is_nan(), "{track:?}");
        }
        let report = Follow::from_tracker(&tracker, &stamp).to_frame();
        let mut reader = Reader::default();
        let frame = report.iter().find_map(|&byte| reader.push(byte)).expect("a frame");
        assert!(Follow::from_frame(&frame.expect("a whole frame")).is_ok());
    }
}

/// A record: a tone of any frequency, amplitude and noise, or any bits.
pub(super) fn samples<R: Record, const N: usize>(input: &mut Input) -> [R::Sample; N] {
    let [kind, shift, frequency, phase] = input.take();
    if kind & 1 == 0 {
        return std::array::from_fn(|_| {
            let [a, b, c, d] = input.take();
            let bits = shift & 15;
            R::from_parts(
                [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])].map(|x| x >> bits),
            )
        });
    }
    let amplitude = f64::from(1u32 << (shift & 15));
    let cycles = f64::from(frequency) / 256.0 + f64::from(phase) / 65536.0;
    let mut noise = u32::from(phase) | 1;
    std::array::from_fn(|n| {
        noise ^= noise << 13;
        noise ^= noise >> 17;
        noise ^= noise << 5;
        let random = f64::from(noise >> 16) * f64::from(kind >> 1) / 65536.0;
        let (sin, cos) = (std::f64::consts::TAU * cycles * n as f64).sin_cos();
        R::from_parts([cos, sin].map(|part| (amplitude * part + random) as i16))
    })
}

pub(super) fn config(input: &mut Input) -> Config {
    let [method, reach, arithmetic, scene, most, refresh, low, high] = input.take();
    let codes = match low % 4 {
        0 => Codes::between(i16::from(low) << 7, i16::MAX - (i16::from(high) << 7)),
        1 => Some(Codes::unsigned::<12>()),
        2 => Some(Codes::signed::<16>()),
        _ => Codes::between(-i16::from(low), i16::from(high)),
    };
    let codes = codes.unwrap_or(Codes::signed::<16>());
    Config {
        rate_hz: input.number(),
        band_hz: (input.byte() & 1 != 0).then(|| (-input.number(), input.number())),
        method: Method::ALL[usize::from(method) % Method::ALL.len()],
        reach: [Reach::Four, Reach::Eight, Reach::Sixteen][usize::from(reach) % 3],
        arithmetic: [Arithmetic::Float, Arithmetic::Fixed][usize::from(arithmetic) % 2],
        effort: Effort::ALL[usize::from(arithmetic / 2) % Effort::ALL.len()],
        false_alarm: input.number(),
        scene: match scene % 3 {
            0 => Scene::Tone,
            1 => Scene::Doppler {
                wavelength_m: input.number(),
                angle_rad: input.number(),
                mixing: Mixing::ALL[usize::from(scene / 3) % 2],
            },
            _ => Scene::Chirp(Chirp {
                shape: [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth]
                    [usize::from(scene / 3) % 3],
                wavelength_m: input.number(),
                bandwidth_hz: input.number(),
                duration_s: input.number(),
                guard_s: input.number(),
                mixing: Mixing::ALL[usize::from(scene / 9) % 2],
                sweep_curvature: input.number(),
            }),
        },
        carrier: match input.byte() & 3 {
            0 => {
                Carrier { linewidth_hz: input.number() as f32, envelope_hz: input.number() as f32 }
            }
            _ => Carrier::default(),
        },
        following: Following { rate_bins: input.number() as f32, most, refresh },
        ..Config::new(1.0, codes)
    }
}

/// A measurement holds numbers, and comes back from its telemetry as it was.
fn number(measurement: &Measurement) {
    let tone = &measurement.tone;
    for value in [tone.sigma, tone.snr, tone.amplitude] {
        assert!(value >= 0.0, "{measurement:?}");
    }
    assert!(tone.is_consistent() && measurement.result.is_consistent(), "{measurement:?}");
    match &measurement.result {
        Outcome::None => {}
        Outcome::Velocity(velocity) => assert!(velocity.sigma >= 0.0, "{measurement:?}"),
        Outcome::Target(target) => {
            assert!(target.sigma_range >= 0.0 && target.sigma_velocity >= 0.0, "{measurement:?}");
        }
    }
    let record = Telemetry {
        measurement: *measurement,
        method: Method::default(),
        health: Health { lost: 0, faults: 0 },
        basis: None,
        uncertainty: None,
    };
    let mut reader = Reader::default();
    let frame = record.to_frame();
    let frame = frame.iter().find_map(|&byte| reader.push(byte)).expect("a frame");
    let told = Telemetry::from_frame(&frame.expect("a whole frame")).expect("telemetry of ours");
    assert_eq!(told, record);
}

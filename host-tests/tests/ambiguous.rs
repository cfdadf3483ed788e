//! What a chirp cannot decide is said: ghosts of two targets, exchanged pairs, the coupling of a sawtooth, the aliases of a sequence.
//! The records come from the phase of the transmitter, see `picket-simulator`.

use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::solve::sequence::Sequence;
use picket_dsp::{
    Ambiguity, Candidate, Chirp, Codes, Config, ConfigError, Decision, Iq, Mixing, Outcome,
    Pipeline, Real, Record, Scene, Segment, Shape, Stamp, Target, Usable, Verdict,
};
use picket_simulator::{Receiver, Target as Reflector, Waveform};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const N: usize = 1024;

/// A carrier, a sweep, a ramp's length and a rate; the ranges and the largest speed of its targets.
#[derive(Clone, Copy)]
struct Radar {
    carrier_hz: f64,
    bandwidth_hz: f64,
    duration_s: f64,
    rate_hz: f64,
    ranges_m: (f64, f64),
    speed_mps: f64,
}

/// 24, 77 and 122 GHz, and 1550 nm.
const RADARS: [Radar; 4] = [
    Radar { carrier_hz: 24e9, bandwidth_hz: 200e6, ..WIDE },
    Radar { carrier_hz: 77e9, bandwidth_hz: 300e6, ..WIDE },
    Radar {
        carrier_hz: 122e9,
        bandwidth_hz: 1e9,
        duration_s: 0.55e-3,
        rate_hz: 2e6,
        ranges_m: (5.0, 60.0),
        ..WIDE
    },
    Radar {
        carrier_hz: SPEED_OF_LIGHT / 1550e-9,
        bandwidth_hz: 1e9,
        duration_s: 10e-6,
        rate_hz: 250e6,
        ranges_m: (20.0, 60.0),
        speed_mps: 20.0,
    },
];

const WIDE: Radar = Radar {
    carrier_hz: 24e9,
    bandwidth_hz: 200e6,
    duration_s: 1.1e-3,
    rate_hz: 1e6,
    ranges_m: (10.0, 120.0),
    speed_mps: 50.0,
};

/// Where a target is and how it moves, and its level.
#[derive(Clone, Copy, Debug)]
struct Car {
    range_m: f64,
    velocity_mps: f64,
    db: f64,
}

/// What chirps are seen with.
#[derive(Clone, Copy)]
struct Seen {
    shape: Shape,
    mixing: Mixing,
    snr_db: f64,
    velocity_mps: Option<(f64, f64)>,
    chirps: usize,
}

const ONCE: Seen = Seen {
    shape: Shape::Triangle,
    mixing: Mixing::TxConjRx,
    snr_db: 20.0,
    velocity_mps: None,
    chirps: 1,
};

impl Radar {
    fn chirp(&self, shape: Shape, mixing: Mixing) -> Chirp {
        let Radar { carrier_hz, bandwidth_hz, duration_s, rate_hz, .. } = *self;
        Chirp {
            shape,
            wavelength_m: SPEED_OF_LIGHT / carrier_hz,
            bandwidth_hz,
            duration_s,
            guard_s: duration_s - N as f64 / rate_hz,
            mixing,
            sweep_curvature: 0.0,
        }
    }

    /// The answer to the last of some chirps, and the cars at the moment of its range; `None` if a ramp's beat is within three bins of 0 Hz or
    /// of half the rate.
    fn answer<R: Record>(
        &self,
        cars: &[Car],
        seen: Seen,
        rng: &mut ChaCha8Rng,
    ) -> Option<(Target, Vec<Car>)> {
        let Seen { shape, mixing, snr_db, velocity_mps, chirps } = seen;
        let chirp = self.chirp(shape, mixing);
        let codes = Codes::signed::<12>();
        let config =
            Config { scene: Scene::Chirp(chirp), velocity_mps, ..Config::new(self.rate_hz, codes) };
        let mut pipeline = Pipeline::<R, N>::new(config.plan().unwrap());
        let waveform = Waveform::chirp(&chirp, 0.0);
        let phases: Vec<f64> = cars.iter().map(|_| rng.random()).collect();
        let receiver = Receiver::ideal(self.rate_hz, R::IQ, mixing).with_snr(400.0, snr_db);
        let (segments, last_s) = (shape.segments(), (N as f64 - 1.0) / self.rate_hz);
        let period_s = segments.len() as f64 * self.duration_s;
        let (mut answer, mut at_an_edge) = (None, false);
        for lap in 0..chirps {
            let moved_s = lap as f64 * period_s;
            let there: Vec<Reflector> = cars
                .iter()
                .zip(&phases)
                .map(|(car, &cycles)| {
                    let range_m = car.range_m - car.velocity_mps * moved_s;
                    let amplitude = 400.0 * 10f64.powf(car.db / 20.0);
                    Reflector::moving(amplitude, range_m, car.velocity_mps).turned(cycles)
                })
                .collect();
            let mut middle_s = 0.0;
            for (index, &segment) in segments.iter().enumerate() {
                let from_s = waveform.start_s(index) + chirp.guard_s;
                middle_s += (from_s + 0.5 * last_s) / segments.len() as f64;
                for reflector in &there {
                    let delay = |t: f64| 2.0 * reflector.range_m(t) / SPEED_OF_LIGHT;
                    let cycles = |t: f64| waveform.cycles(t, delay(t));
                    let beat = (cycles(from_s + last_s) - cycles(from_s)).abs();
                    at_an_edge |= segment != Segment::Flat && beat < 3.0;
                    at_an_edge |= beat > N as f64 / 2.0 - 3.0;
                }
                let normal = || rng.sample(StandardNormal);
                let record = receiver.record(&waveform, &there, (0, from_s), N, normal);
                let samples: Vec<_> = record.into_iter().map(R::from_parts).collect();
                let stamp = Stamp {
                    segment,
                    sequence: (lap * segments.len() + index) as u32,
                    clock: ((moved_s + from_s) * self.rate_hz).round() as u64,
                    ..Stamp::default()
                };
                let samples = samples.as_slice().try_into().ok().unwrap();
                if let Outcome::Target(target) = pipeline.block(&stamp, samples).result {
                    answer = Some(target);
                }
            }
            if lap + 1 == chirps {
                let now = cars.iter().map(|car| Car {
                    range_m: car.range_m - car.velocity_mps * (moved_s + middle_s),
                    ..*car
                });
                return answer.filter(|_| !at_an_edge).map(|target| (target, now.collect()));
            }
        }
        None
    }

    fn car(&self, rng: &mut ChaCha8Rng) -> Car {
        Car {
            range_m: rng.random_range(self.ranges_m.0..self.ranges_m.1),
            velocity_mps: rng.random_range(-self.speed_mps..self.speed_mps),
            db: 0.0,
        }
    }

    /// A second target, half a cell to 60 cells off, in half of the cases nearly as fast.
    fn beside(&self, car: &Car, db: f64, rng: &mut ChaCha8Rng) -> Car {
        let cells = 0.5 * 120f64.powf(rng.random());
        let sign = if rng.random() { 1.0 } else { -1.0 };
        let velocity_mps = if rng.random() {
            car.velocity_mps + rng.random_range(-1.0..1.0)
        } else {
            rng.random_range(-self.speed_mps..self.speed_mps)
        };
        let cell_m = SPEED_OF_LIGHT / 2.0 / self.bandwidth_hz;
        Car { range_m: car.range_m + sign * cells * cell_m, velocity_mps, db }
    }
}

/// How far a target is from a car, in deviations: the larger of range and velocity.
fn off(target: &Target, car: &Car) -> f64 {
    let range = (target.range.to_num::<f64>() - car.range_m) / f64::from(target.sigma_range);
    let velocity = target.velocity.unwrap().to_num::<f64>() - car.velocity_mps;
    range.abs().max((velocity / f64::from(target.sigma_velocity)).abs())
}

fn usable(target: &Target) -> bool {
    target.verdict.usable() <= Usable::WithinSigma
}

/// The chirps of two targets: how many there are, how many are usable, and how many of these are more than five sigmas from both.
fn two<R: Record>(shape: Shape, seed: u64) -> [usize; 3] {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut counts = [0; 3];
    for radar in &RADARS {
        for (trial, db) in [0.0, -1.0, -3.0, -6.0].into_iter().cycle().enumerate().take(240) {
            let first = radar.car(rng);
            let cars = [first, radar.beside(&first, db, rng)];
            let mixing = Mixing::ALL[trial / 4 % 2];
            let snr_db = [10.0, 20.0, 30.0, 40.0][trial / 8 % 4];
            let seen = Seen { shape, mixing, snr_db, ..ONCE };
            let (near, far) = radar.ranges_m;
            if !(near..far).contains(&cars[1].range_m) {
                continue;
            }
            let Some((target, cars)) = radar.answer::<R>(&cars, seen, rng) else { continue };
            counts[0] += 1;
            if usable(&target) {
                counts[1] += 1;
                counts[2] += usize::from(cars.iter().all(|car| off(&target, car) > 5.0));
            }
        }
    }
    println!("{shape:?}, I/Q {}, seed {seed}: {counts:?} chirps, usable, wrong", R::IQ);
    counts
}

#[test]
fn two_targets_make_no_ghost() {
    let seen = [
        two::<Iq>(Shape::Triangle, 81),
        two::<Iq>(Shape::Trapezoid, 82),
        two::<Real>(Shape::Trapezoid, 83),
        two::<Real>(Shape::Triangle, 84),
    ];
    let [chirps, usable, wrong] = [0, 1, 2].map(|i| seen.iter().map(|s| s[i]).sum::<usize>());
    assert!(chirps > 2500 && usable > 1000);
    // Two in a thousand of these many, and twice the root of that number.
    assert!(
        wrong as f64 <= 0.002 * chirps as f64 + 2.0 * (0.002 * chirps as f64).sqrt(),
        "{wrong}"
    );
    // A real triangle's first chirp decides nothing.
    assert_eq!(seen[3][1], 0);
}

/// At most 1 % of one target's chirps are refused, and none is wrong.
#[test]
fn one_target_is_answered_as_before() {
    let rng = &mut ChaCha8Rng::seed_from_u64(85);
    let (mut chirps, mut refused, mut wrong) = (0, 0, 0);
    for radar in &RADARS {
        for trial in 0..120 {
            let car = radar.car(rng);
            let shape = [Shape::Trapezoid, Shape::Triangle][trial % 2];
            let mixing = Mixing::ALL[trial / 2 % 2];
            let snr_db = [10.0, 20.0, 30.0, 40.0][trial / 4 % 4];
            let seen = Seen { shape, mixing, snr_db, ..ONCE };
            let Some((target, cars)) = radar.answer::<Iq>(&[car], seen, rng) else { continue };
            chirps += 1;
            refused += usize::from(!usable(&target));
            wrong += usize::from(usable(&target) && off(&target, &cars[0]) > 5.0);
        }
    }
    println!("seed 85: {chirps} chirps, {refused} refused, {wrong} wrong");
    assert!(chirps > 400 && refused * 100 <= chirps && wrong == 0);
}

/// A real triangle lists both pairs. A bound of the velocity or the next chirp decides, and says so.
#[test]
fn an_exchange_is_decided_by_a_bound_or_by_the_next_chirp() {
    let rng = &mut ChaCha8Rng::seed_from_u64(86);
    let (mut chirps, mut decided) = (0, [0; 2]);
    for radar in &RADARS[..3] {
        for _ in 0..60 {
            let car = radar.car(rng);
            let Some((first, now)) = radar.answer::<Real>(&[car], ONCE, rng) else { continue };
            assert_eq!(first.verdict, Verdict::Ambiguous, "{first:?}");
            let right = |candidate: &Candidate| {
                let Candidate { range, velocity, .. } = *candidate;
                off(&Target { range, velocity: Some(velocity), ..first }, &now[0]) < 5.0
            };
            let candidates = first.ambiguity.candidates();
            assert!(candidates.len() == 2 && candidates.iter().any(right), "{first:?}");
            chirps += 1;
            let bound = Some((-radar.speed_mps, radar.speed_mps));
            for (by, seen, count) in [
                (Decision::Bound, Seen { velocity_mps: bound, ..ONCE }, 0),
                (Decision::LastChirp, Seen { chirps: 2, ..ONCE }, 1),
            ] {
                let Some((target, now)) = radar.answer::<Real>(&[car], seen, rng) else { continue };
                if target.ambiguity == Ambiguity::Decided(by) {
                    decided[count] += usize::from(usable(&target));
                    assert!(off(&target, &now[0]) < 5.0, "{target:?}");
                } else {
                    // The exchanged pair may keep to the bound, too.
                    assert_eq!(target.verdict, Verdict::Ambiguous, "{target:?}");
                }
            }
        }
    }
    println!("seed 86: {chirps} chirps, by bound and by the next chirp {decided:?}");
    assert!(chirps > 150 && decided.iter().all(|&count| 10 * count > 9 * chirps));
}

/// usable.md's first row: 77 GHz, 300 MHz in 100 us, I/Q, 18.3 m and 3.2 m/s.
#[test]
fn a_sawtooths_range_needs_a_bound_of_the_velocity() {
    let radar =
        Radar { carrier_hz: 77e9, bandwidth_hz: 300e6, duration_s: 110e-6, rate_hz: 10e6, ..WIDE };
    let car = Car { range_m: 18.3, velocity_mps: 3.2, db: 0.0 };
    let rng = &mut ChaCha8Rng::seed_from_u64(87);
    let seen = Seen { shape: Shape::Sawtooth, ..ONCE };
    let (target, _) = radar.answer::<Iq>(&[car], seen, rng).unwrap();
    assert_eq!((target.verdict, target.velocity), (Verdict::Ambiguous, None));
    assert_eq!(target.ambiguity, Ambiguity::Coupled);
    let bounded = Seen { velocity_mps: Some((-5.0, 5.0)), ..seen };
    let mut squares = 0.0;
    for trial in 0..200 {
        let car = Car { velocity_mps: -5.0 + 10.0 * (f64::from(trial) + 0.5) / 200.0, ..car };
        let (target, now) = radar.answer::<Iq>(&[car], bounded, rng).unwrap();
        assert!(usable(&target) && target.velocity.is_none(), "{target:?}");
        assert_eq!(target.ambiguity, Ambiguity::Decided(Decision::Bound));
        let off = (target.range.to_num::<f64>() - now[0].range_m) / f64::from(target.sigma_range);
        squares += off * off / 200.0;
    }
    // Over all speeds that are allowed sigma is the error.
    assert!((0.8..1.2).contains(&squares), "{squares}");
}

/// Row 8b: 77 GHz, up to 50 m/s, 40 dB: the beats move within each chirp, and the sequence goes on.
#[test]
fn a_sequence_of_beats_that_move_has_an_answer() {
    let radar =
        Radar { carrier_hz: 77e9, bandwidth_hz: 300e6, duration_s: 110e-6, rate_hz: 10e6, ..WIDE };
    let chirp = radar.chirp(Shape::Sawtooth, Mixing::TxConjRx);
    let equations = chirp.equations(radar.rate_hz, N, true).unwrap();
    let rng = &mut ChaCha8Rng::seed_from_u64(88);
    let (mut alone, mut ambiguous, mut wrong) = (0, 0, 0);
    for _ in 0..40 {
        let car = Car { range_m: rng.random_range(15.0..60.0), ..radar.car(rng) };
        let mut pipeline = Pipeline::<Iq, N>::new(
            Config::new(radar.rate_hz, Codes::signed::<12>()).plan().unwrap(),
        );
        let mut sequence = Sequence::new(&equations, 1100).unwrap();
        let receiver = Receiver::ideal(radar.rate_hz, true, chirp.mixing).with_snr(400.0, 40.0);
        let waveform = Waveform::chirp(&chirp, 0.0);
        let mut targets = heapless::Vec::new();
        for lap in 0..64u32 {
            let moved_s = f64::from(lap) * radar.duration_s;
            let range_m = car.range_m - car.velocity_mps * moved_s;
            let there = Reflector::moving(400.0, range_m, car.velocity_mps);
            let normal = || rng.sample(StandardNormal);
            let record = receiver.record(&waveform, &[there], (0, chirp.guard_s), N, normal);
            let samples = std::array::from_fn(|n| record[n]);
            let stamp = Stamp { clock: u64::from(lap) * 1100, sequence: lap, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &samples);
            let lines = pipeline.lines(&measurement, 1);
            targets = sequence.push(&stamp, lines.first().expect("a line"));
        }
        let near = |target: &Target| {
            (target.velocity.unwrap().to_num::<f64>() - car.velocity_mps).abs() < 1.0
        };
        let right = targets.iter().any(near);
        wrong += usize::from(!right);
        match targets.as_slice() {
            [target] => alone += usize::from(usable(target)),
            several => {
                ambiguous += usize::from(several.iter().all(|t| t.verdict == Verdict::Ambiguous));
            }
        }
    }
    println!("seed 88: {alone} alone, {ambiguous} ambiguous, {wrong} without the right one");
    assert!(alone + ambiguous == 40 && alone >= 20 && wrong == 0);
}

/// Ends that are not finite or in the wrong order are refused.
#[test]
fn a_bound_has_its_low_end_first() {
    let scene = Scene::Chirp(WIDE.chirp(Shape::Sawtooth, Mixing::TxConjRx));
    let config = Config { scene, ..Config::new(1e6, Codes::signed::<12>()) };
    for bound in [(5.0, -5.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        for config in [
            Config { velocity_mps: Some(bound), ..config },
            Config { range_m: Some(bound), ..config },
        ] {
            assert_eq!(config.plan::<Iq, N>(), Err(ConfigError::Bounds));
        }
    }
}

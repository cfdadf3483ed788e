//! Range and velocity of moving targets, from a simulated receiver's samples to the target: right within their sigmas, for both
//! mixings, real and I/Q, lidar and radar. The records come from the phase of the transmitter, see `picket-simulator`.

use crate::signal::*;
use host_tests::sized;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::{
    Candidate, Chirp, Codes, Config, Iq, Mixing, Outcome, Pipeline, Real, Record, Segment, Shape,
    Stamp, Target, Verdict,
};
use picket_simulator::{Receiver, Target as Reflector, Waveform};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A waveform and its receiver's rate, and the ranges that its band holds at 60 m/s, m.
#[derive(Clone, Copy, Debug)]
struct Radar {
    carrier_hz: f64,
    bandwidth_hz: f64,
    duration_s: f64,
    rate_hz: f64,
    ranges_m: (f64, f64),
}

/// A carrier in GHz, a bandwidth in MHz, a ramp in ms and a rate in MHz.
const fn radar(ghz: f64, mhz: f64, ms: f64, rate_mhz: f64, ranges_m: (f64, f64)) -> Radar {
    let (carrier_hz, bandwidth_hz) = (ghz * 1e9, mhz * 1e6);
    Radar { carrier_hz, bandwidth_hz, duration_s: ms * 1e-3, rate_hz: rate_mhz * 1e6, ranges_m }
}

const RADARS: [Radar; 8] = [
    radar(24.0, 200.0, 1.1, 1.0, (10.0, 120.0)),
    radar(77.0, 300.0, 1.1, 1.0, (10.0, 120.0)),
    radar(77.0, 1000.0, 0.275, 4.0, (5.0, 60.0)),
    radar(122.0, 1000.0, 0.55, 2.0, (5.0, 60.0)),
    radar(122.0, 4000.0, 0.55, 4.0, (2.0, 25.0)),
    radar(24.0, 200.0, 4.2, 0.25, (20.0, 120.0)),
    radar(122.0, 4000.0, 4.2, 0.25, (2.0, 10.0)),
    Radar {
        carrier_hz: SPEED_OF_LIGHT / 1550e-9,
        bandwidth_hz: 1e9,
        duration_s: 10e-6,
        rate_hz: 250e6,
        ranges_m: (20.0, 60.0),
    },
];

impl Radar {
    /// Its chirp, with the record at the end of each segment.
    fn chirp<const N: usize>(&self, shape: Shape, mixing: Mixing) -> Chirp {
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

    /// How far the frequency of a beat rises within a record, bins. The range changes by V T and the beat follows it, and so does the
    /// Doppler shift by as much.
    fn bend<const N: usize>(&self, velocity_mps: f64) -> f64 {
        let record_s = N as f64 / self.rate_hz;
        let slope = self.bandwidth_hz / self.duration_s;
        4.0 * slope * record_s * record_s * velocity_mps.abs() / SPEED_OF_LIGHT
    }
}

/// What a chirp should have shown.
struct Truth {
    range_m: f64,
    velocity_mps: f64,
    /// Whether a beat is within three bins of half the rate or a ramp's of 0, where no tone can be told from its image or from an offset.
    at_an_edge: bool,
}

/// One chirp from the transmitter to the target. `set` is the chirp that the pipeline is told.
fn solved<R: Record, const N: usize>(
    radar: &Radar,
    (sent, set): (&Chirp, &Chirp),
    snr_db: f64,
    (range_m, velocity_mps): (f64, f64),
    rng: &mut ChaCha8Rng,
) -> (Target, Truth) {
    let scene = picket_dsp::Scene::Chirp(*set);
    let config = Config { scene, ..Config::new(radar.rate_hz, Codes::signed::<12>()) };
    let mut pipeline = Pipeline::<R, N>::new(config.plan().unwrap());
    let waveform = Waveform::chirp(sent, 0.0);
    let amplitude = amplitude(snr_db);
    let mut reflector = Reflector::moving(amplitude, range_m, velocity_mps);
    reflector.cycles = rng.random_range(0.0..1.0);
    let receiver = Receiver::ideal(radar.rate_hz, R::IQ, sent.mixing).with_snr(amplitude, snr_db);
    let segments = sent.shape.segments();
    let last_s = (N as f64 - 1.0) / radar.rate_hz;
    let mut at_an_edge = false;
    let mut target = None;
    for (index, &segment) in segments.iter().enumerate() {
        let from_s = waveform.start_s(index) + sent.guard_s;
        let cycles = |t: f64| waveform.cycles(t, 2.0 * reflector.range_m(t) / SPEED_OF_LIGHT);
        let beat = cycles(from_s + last_s) - cycles(from_s);
        let ramp = segment != Segment::Flat;
        at_an_edge |= (ramp && beat.abs() < 3.0) || beat.abs() > N as f64 / 2.0 - 3.0;
        let normal = || rng.sample(StandardNormal);
        let record =
            receiver.record(&waveform, std::slice::from_ref(&reflector), (0, from_s), N, normal);
        let samples: Vec<_> = record.into_iter().map(R::from_parts).collect();
        let stamp = Stamp { sequence: index as u32, segment, ..Stamp::default() };
        let samples = samples.as_slice().try_into().unwrap();
        if let Outcome::Target(found) = pipeline.block(&stamp, samples).result {
            target = Some(found);
        }
    }
    let middle_s = waveform.start_s(segments.len() - 1) / 2.0 + sent.guard_s + last_s / 2.0;
    let truth = Truth { range_m: reflector.range_m(middle_s), velocity_mps, at_an_edge };
    (target.expect("a whole chirp"), truth)
}

/// Errors over sigma of a target's range and velocity.
fn errors(target: &Target, truth: &Truth) -> [f64; 2] {
    [
        (target.range.to_num::<f64>() - truth.range_m) / f64::from(target.sigma_range),
        (target.velocity.unwrap().to_num::<f64>() - truth.velocity_mps)
            / f64::from(target.sigma_velocity),
    ]
}

/// Counts of many chirps.
#[derive(Clone, Copy, Default)]
struct Counts {
    chirps: f64,
    /// Good, and good or moving.
    good: f64,
    usable: f64,
    /// Good or moving, and off by more than five sigmas.
    off: f64,
    squares: [f64; 2],
}

impl Counts {
    fn of(seen: impl Iterator<Item = (Target, Truth)>) -> Self {
        let mut counts = Counts::default();
        for (target, truth) in seen.filter(|(_, truth)| !truth.at_an_edge) {
            counts.chirps += 1.0;
            counts.good += f64::from(target.verdict == Verdict::Good);
            if target.verdict > Verdict::Moving {
                println!("{target:?} at {} m, {} m/s", truth.range_m, truth.velocity_mps);
            }
            if matches!(target.verdict, Verdict::Good | Verdict::Moving) {
                let errors = errors(&target, &truth);
                counts.usable += 1.0;
                counts.off += f64::from(errors.iter().any(|error| error.abs() > 5.0));
                for (square, error) in counts.squares.iter_mut().zip(errors) {
                    *square += error * error;
                }
            }
        }
        counts
    }

    fn add(&mut self, other: &Self) {
        self.chirps += other.chirps;
        self.good += other.good;
        self.usable += other.usable;
        self.off += other.off;
        self.squares.iter_mut().zip(other.squares).for_each(|(a, b)| *a += b);
    }

    /// Root mean squares of error over sigma, and their standard error.
    fn rms(&self) -> ([f64; 2], f64) {
        (self.squares.map(|sum| (sum / self.usable).sqrt()), (0.5 / self.usable).sqrt())
    }
}

/// Up to this bend in bins times the amplitude's ratio to the noise, a ramp's tone of 1024 samples is good; of others, in proportion to
/// the root of their number. Beyond, its bend is not small any more and the answer is `moving`, with a sigma that is too wide.
const STRAIGHT: f64 = 20.0;

/// A line whose frequency rises by more bins within the record is no line any more.
const STRONG: f64 = 2.0;

fn cells<R: Record, const N: usize>(radars: &[Radar], shape: Shape) -> [Counts; 2] {
    let kind = if R::IQ { "I/Q" } else { "real" };
    let mut all = [Counts::default(); 2];
    // A seed for each cell: the same noise in all of them would be one draw.
    let mut seeds = 71..;
    for radar in radars {
        for (velocity, snr_db, mixing) in
            [(0.5, 0.0), (12.0, 20.0), (60.0, 0.0), (60.0, 40.0), (12.0, 40.0)]
                .into_iter()
                .flat_map(|(velocity, snr_db)| Mixing::ALL.map(|mixing| (velocity, snr_db, mixing)))
        {
            let chirp = radar.chirp::<N>(shape, mixing);
            let one = |rng: &mut ChaCha8Rng| {
                let (near, far) = radar.ranges_m;
                let range = rng.random_range(near..far);
                let velocity = rng.random_range(-velocity..velocity);
                let (target, truth) =
                    solved::<R, N>(radar, (&chirp, &chirp), snr_db, (range, velocity), rng);
                let bent = radar.bend::<N>(velocity) * (N as f64 / 1024.0 * db(snr_db)).sqrt();
                (bent < STRAIGHT && radar.bend::<N>(velocity) < STRONG, target, truth)
            };
            let (straight, bent): (Vec<_>, Vec<_>) =
                trials(seeds.next().unwrap(), sized(40, 1000), one)
                    .into_iter()
                    .partition(|seen| seen.0);
            for (all, seen) in all.iter_mut().zip([straight, bent]) {
                let counts = Counts::of(seen.into_iter().map(|(_, target, truth)| (target, truth)));
                if counts.usable > 30.0 {
                    let ([range, v], error) = counts.rms();
                    let Counts { chirps, good, usable, off, .. } = counts;
                    println!(
                        "{kind} {N} {shape:?} {} {:.4e} Hz, {velocity} m/s, {snr_db} dB: {chirps} chirps, {good} good, {usable} usable, {off} off; rms {range:.2} (range), {v:.2} (velocity) +- {error:.2}",
                        mixing.name(),
                        radar.carrier_hz
                    );
                }
                all.add(&counts);
            }
        }
    }
    all
}

/// Seeds from 71 on. Good ones and moving ones of every radar together: the means are within what their number allows.
fn are_right([straight, bent]: [Counts; 2], kind: &str) {
    let ([range, velocity], error) = straight.rms();
    let (good, off) = (straight.good / straight.chirps, straight.off / straight.usable);
    println!(
        "{kind}: {} chirps, good {good:.4}, off {off:.4}, rms {range:.3} (range), {velocity:.3} (velocity)",
        straight.chirps
    );
    assert!(good >= 0.95 && off <= 0.002, "{kind}");
    for rms in [range, velocity] {
        assert!(rms > 0.85 - 3.0 * error && rms < 1.2 + 3.0 * error, "{kind}: {rms}");
        // All together are nearer to 1 than that.
        assert!((rms - 1.0).abs() < 0.06 + 3.0 * error, "{kind}: {rms}");
    }
    // Whose phase bends further is good or moving, never with too small a sigma, or not usable.
    if bent.usable > 100.0 {
        let ([range, velocity], error) = bent.rms();
        let off = bent.off / bent.usable;
        println!(
            "{kind}, bent: {} chirps, {} usable, off {off:.4}, rms {range:.3}, {velocity:.3}",
            bent.chirps, bent.usable
        );
        assert!(
            range.max(velocity) < 1.2 + 3.0 * error && off <= 0.002 + 2.0 / bent.usable,
            "{kind}"
        );
    }
}

#[test]
fn a_trapezoid_is_right_within_its_sigmas() {
    are_right(cells::<Iq, 1024>(&RADARS, Shape::Trapezoid), "I/Q trapezoid");
    are_right(cells::<Real, 1024>(&RADARS, Shape::Trapezoid), "real trapezoid");
}

#[test]
fn a_triangle_is_right_within_its_sigmas() {
    are_right(cells::<Iq, 1024>(&RADARS, Shape::Triangle), "I/Q triangle");
}

#[test]
fn chirps_of_other_lengths_are_right_within_their_sigmas() {
    // A ramp has as many bins per metre as 1024 samples at the rates above give: a quarter and four times as many samples.
    let with = |factor: f64| RADARS.map(|radar| Radar { rate_hz: radar.rate_hz * factor, ..radar });
    are_right(cells::<Iq, 256>(&with(0.25)[..1], Shape::Trapezoid), "I/Q trapezoid, 256");
    are_right(cells::<Iq, 4096>(&with(4.0)[..2], Shape::Trapezoid), "I/Q trapezoid, 4096");
    are_right(cells::<Real, 4096>(&with(4.0)[..2], Shape::Trapezoid), "real trapezoid, 4096");
}

/// A real triangle fits two targets; one of them is the true one, within its sigma.
#[test]
fn one_of_a_real_triangles_targets_is_right() {
    let radar = &RADARS[1];
    let chirp = radar.chirp::<1024>(Shape::Triangle, Mixing::TxConjRx);
    let seen = trials(72, sized(300, 3000), |rng| {
        let place = (rng.random_range(10.0..110.0), rng.random_range(-60.0..60.0));
        solved::<Real, 1024>(radar, (&chirp, &chirp), 10.0, place, rng)
    });
    let seen = seen.into_iter().map(|(target, truth)| {
        // A beat near 0 Hz or half of the rate is told before.
        if target.verdict != Verdict::Ambiguous {
            assert_eq!(target.verdict, Verdict::NearEdge, "{target:?}");
            return (target, truth);
        }
        let [a, b] = *target.ambiguity.candidates() else { panic!("{target:?}") };
        assert_eq!([a.odds, b.odds], [0.5; 2]);
        // Which of them is right is what the chirp does not tell.
        let verdict = Verdict::Good;
        let [target, other] = [a, b].map(|candidate| {
            let Candidate { range, velocity, .. } = candidate;
            Target { range, velocity: Some(velocity), verdict, ..target }
        });
        let off =
            |target: &Target| errors(target, &truth).map(f64::abs).into_iter().fold(0.0, f64::max);
        (if off(&other) < off(&target) { other } else { target }, truth)
    });
    are_right([Counts::of(seen), Counts::default()], "real triangle");
}

/// With the other mixing every range is negative, and no chirp is good.
#[test]
fn a_wrong_mixing_is_seen_in_every_chirp() {
    for shape in [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth] {
        for (radar, velocity) in [(&RADARS[0], 3.0), (&RADARS[1], 12.0), (&RADARS[7], 3.0)] {
            for mixing in Mixing::ALL {
                let sent = radar.chirp::<1024>(shape, mixing);
                let [other] = Mixing::ALL
                    .into_iter()
                    .filter(|&other| other != mixing)
                    .collect::<Vec<_>>()[..]
                else {
                    panic!("two mixings")
                };
                let set = Chirp { mixing: other, ..sent };
                let seen = trials(73, sized(30, 300), |rng| {
                    let place = (rng.random_range(30.0..60.0), velocity);
                    solved::<Iq, 1024>(radar, (&sent, &set), 10.0, place, rng).0
                });
                assert!(
                    seen.iter().all(|t| t.range < 0 && t.verdict >= Verdict::Unresolved),
                    "{shape:?} {mixing:?}"
                );
            }
        }
    }
}

/// 24 GHz, 200 MHz in 1.024 ms, 30 m and 3 m/s, at 20 dB: both mixings, with a trapezoid and with a triangle.
#[test]
fn a_walker_at_thirty_metres_is_there() {
    let radar = radar(24.0, 200.0, 1.024, 1.0, (30.0, 30.0));
    for shape in [Shape::Trapezoid, Shape::Triangle] {
        for mixing in Mixing::ALL {
            let chirp = radar.chirp::<1024>(shape, mixing);
            let (target, truth) =
                solved::<Iq, 1024>(&radar, (&chirp, &chirp), 20.0, (30.0, 3.0), &mut rng(74, 0));
            println!("{shape:?} {}: {target:?}", mixing.name());
            assert_eq!(target.verdict, Verdict::Good);
            assert!(errors(&target, &truth).iter().all(|error| error.abs() < 3.0));
            assert!((target.range.to_num::<f64>() - 30.0).abs() < 0.02);
            assert!((target.velocity.unwrap().to_num::<f64>() - 3.0).abs() < 0.05);
        }
    }
}

/// A ramp that is bent more than its configuration says moves both beats as no target does: what is usable is right. Told, it is usable.
#[test]
fn a_bend_of_the_sweep_that_is_not_told_is_seen() {
    const CURVATURE: f64 = 0.002;
    let seen = |radar: &Radar, shape: Shape, snr_db: f64, told: f64| {
        let straight = radar.chirp::<1024>(shape, Mixing::TxConjRx);
        let sent = Chirp { sweep_curvature: CURVATURE, ..straight };
        let set = Chirp { sweep_curvature: told, ..straight };
        let seen = trials(77, sized(60, 1000), |rng| {
            let (near, far) = radar.ranges_m;
            let place = (rng.random_range(near..far), rng.random_range(-12.0..12.0));
            solved::<Iq, 1024>(radar, (&sent, &set), snr_db, place, rng)
        });
        Counts::of(seen.into_iter())
    };
    let mut untold = Counts::default();
    let mut told = Counts::default();
    for radar in &RADARS[..4] {
        for shape in [Shape::Trapezoid, Shape::Triangle] {
            for snr_db in [-5.0, 0.0, 10.0, 20.0] {
                untold.add(&seen(radar, shape, snr_db, 0.0));
                told.add(&seen(radar, shape, snr_db, CURVATURE));
            }
        }
    }
    let Counts { chirps, usable, off, .. } = untold;
    println!("not told: {chirps} chirps, {usable} usable, {off} off");
    assert!(off <= 0.005 * usable + 1.0);
    let Counts { chirps, usable, off, .. } = told;
    println!("told: {chirps} chirps, {usable} usable, {off} off");
    assert!(usable >= 0.75 * chirps && off <= 0.002 * usable + 1.0);
}

/// A ramp that is bent by a share of its bandwidth: with the constant of the same name the range is right, without it it is off in
/// proportion to the range.
#[test]
fn a_nonlinear_sweep_is_calibrated_by_its_curvature() {
    const CURVATURE: f64 = 0.002;
    let radar = &RADARS[7];
    let straight = radar.chirp::<1024>(Shape::Trapezoid, Mixing::TxConjRx);
    let sent = Chirp { sweep_curvature: CURVATURE, ..straight };
    let seen = |set: Chirp| {
        trials(75, sized(200, 2000), |rng| {
            let place = (rng.random_range(20.0..60.0), rng.random_range(-20.0..20.0));
            solved::<Iq, 1024>(radar, (&sent, &set), 0.0, place, rng)
        })
    };
    are_right([Counts::of(seen(sent).into_iter()), Counts::default()], "bent sweep, told");
    // Without it a sawtooth's range is off by the slope halfway between the record's middle and where its echo left:
    // 1 + 4 e (1 - 2 x) of the mean slope. The mean delay is that of 40 m.
    let delay = 2.0 * 40.0 / SPEED_OF_LIGHT / radar.duration_s;
    let x = 1.0 - 0.5 * 1024.0 / (radar.rate_hz * radar.duration_s) - 0.5 * delay;
    let told = 4.0 * CURVATURE * (1.0 - 2.0 * x);
    let (sent, set) =
        (Chirp { shape: Shape::Sawtooth, ..sent }, Chirp { shape: Shape::Sawtooth, ..straight });
    let off = trials(76, 200, |rng| {
        let place = (rng.random_range(20.0..60.0), 0.0);
        let (target, truth) = solved::<Iq, 1024>(radar, (&sent, &set), 20.0, place, rng);
        target.range.to_num::<f64>() / truth.range_m - 1.0
    });
    let off = mean(off.iter().copied());
    println!(
        "not told, a sawtooth's ranges are off by {off:.6} of themselves, by the slope {told:.6}"
    );
    assert!((off - told).abs() < 0.01 * told.abs());
}

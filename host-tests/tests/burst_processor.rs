//! Bursts of a Gaussian envelope anywhere in a stream: found, measured to the bound of their envelope, and told from two at once.

use crate::signal::{CODES, db, quantise, ratio, rng, trials};
use host_tests::sized;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::Config;
use picket_dsp::{Burst, BurstProcessor, Codes, Iq, Real, Validation};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

/// One particle: middle and deviation in samples, frequency in cycles per sample, amplitude in codes.
#[derive(Clone, Copy, Debug)]
struct Particle {
    middle: f64,
    deviation: f64,
    cycles: f64,
    amplitude: f64,
    phase: f64,
    /// The level over the amplitude, by the time from the middle in deviations.
    envelope: Envelope,
}

type Envelope = fn(f64) -> f64;

fn gaussian(u: f64) -> f64 {
    (-0.5 * u * u).exp()
}

/// A stream of particles in noise of standard deviation `noise` in each part, each with a pedestal of `pedestal` times its amplitude.
fn stream<R: Record>(
    rng: &mut ChaCha8Rng,
    length: usize,
    particles: &[Particle],
    noise: f64,
    pedestal: f64,
) -> Vec<R::Sample> {
    let mut parts = vec![[0.0; 2]; length];
    for p in particles {
        let reach = 7.0 * p.deviation;
        let first = (p.middle - reach).max(0.0) as usize;
        let last = ((p.middle + reach).max(0.0) as usize).min(length);
        for (n, part) in parts.iter_mut().enumerate().take(last).skip(first) {
            let t = n as f64 - p.middle;
            let level = p.amplitude * (p.envelope)(t / p.deviation);
            let (sin, cos) = (TAU * p.cycles * t + p.phase).sin_cos();
            part[0] += level * (cos + pedestal);
            part[1] += level * sin;
        }
    }
    parts
        .into_iter()
        .map(|part| {
            let mut draw = |x: f64| quantise(x + noise * rng.sample::<f64, _>(StandardNormal));
            let i = draw(part[0]);
            R::from_parts([i, if R::IQ { draw(part[1]) } else { 0 }])
        })
        .collect()
}

/// The bound of the frequency with the envelope known, cycles per sample: the whole burst.
fn bound<R: Record>(p: &Particle, noise: f64) -> f64 {
    let sum = PI.sqrt() / 2.0 * p.deviation.powi(3);
    // A real tone's phase is half as well known as that of an I/Q tone in the same noise of each part.
    let tone = if R::IQ { 1.0 } else { 0.5 };
    1.0 / (TAU * p.amplitude / noise * (tone * sum).sqrt())
}

fn processed<R: Record, const N: usize>(
    samples: &[R::Sample],
) -> (Vec<Burst>, BurstProcessor<R, N>) {
    let plan = Config::new(1.0, CODES).plan::<R, N>().unwrap();
    let mut processor = BurstProcessor::<R, N>::new(plan);
    let mut bursts = Vec::new();
    for chunk in samples.chunks(777) {
        processor.push(chunk, |burst| bursts.push(*burst));
    }
    (bursts, processor)
}

/// Blocks of noise before a burst, which the detector learns the noise from, and blocks of the whole stream.
const BEFORE: f64 = 6.0;
const STREAM: f64 = 9.0;

/// A burst somewhere in a stream.
fn lone<R: Record, const N: usize>(rng: &mut ChaCha8Rng, deviation: f64) -> Particle {
    let n = N as f64;
    let cycles = rng.random_range(70.0 / 1024.0..440.0 / 1024.0);
    Particle {
        middle: n * rng.random_range(BEFORE..BEFORE + 1.0),
        deviation: deviation * n,
        cycles: if R::IQ && rng.random_bool(0.5) { -cycles } else { cycles },
        amplitude: 1000.0,
        phase: rng.random_range(0.0..TAU),
        envelope: gaussian,
    }
}

/// Found and valid, error over bound, (error / sigma)^2.
fn cell<R: Record, const N: usize>(deviation: f64, snr_db: f64, seed: u64, count: u64) -> [f64; 3] {
    let noise = 1000.0 * (0.5 / db(snr_db)).sqrt();
    // Four deviations of the noise and the burst do not clip.
    let scale = (2000.0 / (1300.0 + 4.0 * noise)).min(1.0);
    let seen = trials(seed, count, |rng| {
        let mut p = lone::<R, N>(rng, deviation);
        p.amplitude *= scale;
        let samples = stream::<R>(rng, (STREAM * N as f64) as usize, &[p], noise * scale, 0.3);
        let (bursts, _) = processed::<R, N>(&samples);
        let near = |burst: &&Burst| (burst.arrival - p.middle).abs() < 2.0 * p.deviation;
        bursts.iter().find(near).filter(|burst| burst.validation == Validation::Valid).map(
            |burst| {
                let error = burst.tone.frequency.cycles() - p.cycles;
                (error / bound::<R>(&p, noise * scale), error / f64::from(burst.tone.sigma))
            },
        )
    });
    let valid: Vec<(f64, f64)> = seen.iter().flatten().copied().collect();
    let ratios: Vec<(f64, f64)> = valid.iter().map(|v| (v.0 / 20.0, 1.0 / 20.0)).collect();
    let chi2 = valid.iter().map(|v| v.1 * v.1).sum::<f64>() / valid.len() as f64;
    [valid.len() as f64 / seen.len() as f64, ratio(&ratios).rms, chi2]
}

/// .05 to .35 records, 0 to 50 dB at the top; seeds 4400 on.
#[test]
fn bursts_are_found_and_measured_to_the_bound_of_their_envelope() {
    let mut seeds = 4400..;
    for deviation in [0.05, 0.1, 0.2, 0.35] {
        for snr_db in [0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0] {
            let count = sized(150, 2000);
            let real = cell::<Real, 1024>(deviation, snr_db, seeds.next().unwrap(), count);
            let iq = cell::<Iq, 1024>(deviation, snr_db, seeds.next().unwrap(), count);
            println!("sd {deviation}, {snr_db} dB: real {real:.3?}, I/Q {iq:.3?}");
            let chance = 3.0 * (2.0 / count as f64).sqrt();
            for [found, rms, chi2] in [real, iq] {
                // Of a hundred bursts one is taken for two particles.
                assert!(snr_db <= 5.0 || found >= 0.95, "{found}");
                assert!(rms < 1.25 * (1.0 + chance / 2.0), "{rms}");
                assert!((0.8 - chance..1.25 + chance).contains(&chi2), "{chi2}");
            }
        }
    }
}

/// Two particles within two deviations of each other, with frequencies that a turbulent flow of 10 % gives: flagged, or the tone is one of
/// theirs within five sigma. Seeds 4460 on.
#[test]
fn two_particles_at_once_are_flagged_or_right() {
    let mut seeds = 4460..;
    let (mut wrong, mut all) = (0.0, 0.0);
    for deviation in [0.05, 0.1, 0.2] {
        for snr_db in [10.0, 20.0, 30.0, 40.0] {
            let noise = 1000.0 * (0.5 / db(snr_db)).sqrt();
            let count = sized(150, 2000);
            let seen = trials(seeds.next().unwrap(), count, |rng| {
                let p = lone::<Real, 1024>(rng, deviation);
                let other = Particle {
                    middle: p.middle + p.deviation * rng.random_range(-2.0..2.0),
                    cycles: p.cycles * (1.0 + 0.1 * rng.sample::<f64, _>(StandardNormal)),
                    amplitude: p.amplitude * rng.random_range(0.2..1.0),
                    phase: rng.random_range(0.0..TAU),
                    ..p
                };
                let samples =
                    stream::<Real>(rng, (STREAM * 1024.0) as usize, &[p, other], noise, 0.0);
                let (bursts, _) = processed::<Real, 1024>(&samples);
                let near = |burst: &&Burst| (burst.arrival - p.middle).abs() < 4.0 * p.deviation;
                bursts.iter().filter(near).all(|burst| {
                    let off = |particle: &Particle| {
                        (burst.tone.frequency.cycles() - particle.cycles).abs()
                            > 5.0 * f64::from(burst.tone.sigma)
                    };
                    burst.validation != Validation::Valid || !(off(&p) && off(&other))
                })
            });
            let bad = seen.iter().filter(|&&fine| !fine).count() as f64;
            println!("sd {deviation}, {snr_db} dB: {:.3} wrong", bad / count as f64);
            (wrong, all) = (wrong + bad, all + count as f64);
        }
    }
    println!("{:.4} of all wrong", wrong / all);
    assert!(wrong / all < 0.03 + 3.0 * (0.03 / all).sqrt());
}

/// The bursts near a particle in its stream, with what else is in it: valid, valid and beyond five sigma, and the mean of (error / sigma)^2 of the
/// valid ones, each by particle.
fn told<R: Record>(
    snr_db: f64,
    pedestal: f64,
    seed: u64,
    particles: impl Fn(&mut ChaCha8Rng) -> Vec<Particle> + Sync,
) -> [f64; 3] {
    let noise = 500.0 * (0.5 / db(snr_db)).sqrt();
    let seen = trials(seed, sized(150, 2000), |rng| {
        let all = particles(rng);
        let samples = stream::<R>(rng, (STREAM * 1024.0) as usize, &all, noise, pedestal);
        let near = |burst: &&Burst| {
            (burst.arrival - all[0].middle).abs() < 4.0 * all[0].deviation.max(50.0)
                && burst.validation == Validation::Valid
        };
        let (bursts, _) = processed::<R, 1024>(&samples);
        bursts.iter().find(near).map(|burst| {
            (burst.tone.frequency.cycles() - all[0].cycles) / f64::from(burst.tone.sigma)
        })
    });
    let valid: Vec<f64> = seen.iter().flatten().copied().collect();
    let beyond = valid.iter().filter(|error| error.abs() > 5.0).count() as f64;
    let square = valid.iter().map(|error| error * error).sum::<f64>() / valid.len() as f64;
    [valid.len() as f64 / seen.len() as f64, beyond / seen.len() as f64, square]
}

/// A pulse that is on for .15 or .3 records, and an ultrasonic echo that rises within .02 records and decays within .1: each is one tone, and its
/// sigma holds. Seeds 4520 on.
#[test]
fn pulses_of_other_envelopes_are_valid() {
    fn pulses<R: Record>(seeds: &mut impl Iterator<Item = u64>) {
        let echo = |u: f64| if u < 0.0 { 0.0 } else { 1.6 * (1.0 - (-5.0 * u).exp()) * (-u).exp() };
        let flat = |u: f64| if u.abs() < 1.0 { 1.0 } else { 0.0 };
        let envelopes: [(&str, f64, Envelope); 3] =
            [("flat", 0.075, flat), ("flat", 0.15, flat), ("echo", 0.1, echo)];
        for (name, deviation, envelope) in envelopes {
            for snr_db in [6.0, 10.0, 20.0] {
                let [valid, beyond, square] =
                    told::<R>(snr_db, 0.0, seeds.next().unwrap(), |rng| {
                        vec![Particle {
                            envelope,
                            amplitude: 500.0,
                            ..lone::<R, 1024>(rng, deviation)
                        }]
                    });
                println!(
                    "I/Q {}, {name} {deviation}, {snr_db} dB: {valid:.3} valid, {beyond:.3} beyond 5 sigma, {square:.2}",
                    R::IQ
                );
                assert!(valid > 0.88 && beyond == 0.0 && (0.3..1.5).contains(&square));
            }
        }
    }
    let mut seeds = 4520..;
    pulses::<Real>(&mut seeds);
    pulses::<Iq>(&mut seeds);
}

/// A burst on a pedestal of three times its fringes; seeds 4540 on.
#[test]
fn a_pedestal_hides_no_burst() {
    for (seed, snr_db) in (4540..).zip([10.0, 20.0, 30.0]) {
        let [valid, beyond, square] = told::<Real>(snr_db, 3.0, seed, |rng| {
            vec![Particle { amplitude: 400.0, ..lone::<Real, 1024>(rng, 0.08) }]
        });
        println!("{snr_db} dB: {valid:.3} valid, {beyond:.3} beyond 5 sigma, {square:.2}");
        assert!(valid > 0.95 && beyond == 0.0 && (0.3..1.5).contains(&square));
    }
}

/// Two particles of one speed, whose bursts overlap: the sum of both is a tone whose phase turns in the middle. Three deviations apart and from 20 dB
/// on it is told; what is nearer or weaker looks like one particle of another speed. Seeds 4550 on.
#[test]
fn two_particles_of_one_speed() {
    let mut seeds = 4550..;
    for snr_db in [10.0, 20.0, 30.0] {
        for (apart, most) in [
            (1.0, [0.6, 0.35, 0.2]),
            (2.0, [0.45, 0.17, 0.06]),
            (3.0, [0.3, 0.03, 0.03]),
            (4.0, [0.03; 3]),
        ] {
            let [valid, beyond, _] = told::<Real>(snr_db, 0.0, seeds.next().unwrap(), |rng| {
                let p = Particle { amplitude: 500.0, ..lone::<Real, 1024>(rng, 0.08) };
                let middle = p.middle + apart * p.deviation;
                let (amplitude, phase) =
                    (p.amplitude * rng.random_range(0.5..1.0), rng.random_range(0.0..TAU));
                vec![p, Particle { middle, amplitude, phase, ..p }]
            });
            println!(
                "{apart} deviations apart, {snr_db} dB: {valid:.3} valid, {beyond:.3} beyond 5 sigma"
            );
            let most = match snr_db {
                10.0 => most[0],
                20.0 => most[1],
                _ => most[2],
            };
            assert!(beyond <= most);
        }
    }
}

/// At most one burst in 100,000 blocks of noise; seeds 4480 on.
#[test]
fn noise_has_no_bursts() {
    fn valid<R: Record, const N: usize>(seed: u64, blocks: usize) -> (usize, u32) {
        const PIECES: u64 = 20;
        let seen = trials(seed, PIECES, |rng| {
            let samples = stream::<R>(rng, blocks / PIECES as usize * N, &[], 200.0, 0.0);
            let (bursts, processor) = processed::<R, N>(&samples);
            let valid = bursts.iter().filter(|b| b.validation == Validation::Valid).count();
            (valid, processor.counters().bursts)
        });
        seen.iter().fold((0, 0), |sum, seen| (sum.0 + seen.0, sum.1 + seen.1))
    }
    for (name, (valid, cut), blocks) in [
        (
            "real, 1024",
            valid::<Real, 1024>(4480, sized(20_000, 400_000) as usize),
            sized(20_000, 400_000),
        ),
        (
            "real, 256",
            valid::<Real, 256>(4481, sized(40_000, 800_000) as usize),
            sized(40_000, 800_000),
        ),
        (
            "I/Q, 1024",
            valid::<Iq, 1024>(4482, sized(10_000, 200_000) as usize),
            sized(10_000, 200_000),
        ),
    ] {
        println!("{name}: {blocks} blocks, {cut} records cut, {valid} valid");
        assert!(valid as f64 <= 1e-5 * blocks as f64 + 3.0 * (1e-5 * blocks as f64).sqrt());
        // docs/signals.md: about one record in fifty, of 1,024 real samples.
        assert!((0.01..0.04).contains(&(f64::from(cut) / blocks as f64)), "{cut}");
    }
}

/// A turbulent flow of 10 %: particles arrive as their number in the flow and their speed say, and the mean that weighs each by its transit
/// time is the flow's. Seed 4490.
#[test]
fn the_mean_and_the_rms_of_a_turbulent_flow() {
    let seen = trials(4490, sized(8, 40), |rng| {
        let length = 1024 * 1500;
        let (mean, turbulence) = (0.15, 0.1);
        let mut particles = Vec::new();
        let mut at = 0.0f64;
        while at < length as f64 {
            at -= 6000.0 * rng.random_range(0.0f64..1.0).ln();
            let speed = loop {
                // Faster ones come more often.
                let speed = 1.0 + turbulence * rng.sample::<f64, _>(StandardNormal);
                if speed > 0.3 && rng.random_range(0.0..1.7) < speed {
                    break speed;
                }
            };
            particles.push(Particle {
                middle: at,
                deviation: 80.0 / speed,
                cycles: mean * speed,
                amplitude: rng.random_range(200.0..900.0),
                phase: rng.random_range(0.0..TAU),
                envelope: gaussian,
            });
        }
        let samples = stream::<Real>(rng, length, &particles, 30.0, 0.4);
        let (bursts, processor) = processed::<Real, 1024>(&samples);
        let valid: Vec<[f64; 2]> = bursts
            .iter()
            .filter(|b| b.validation == Validation::Valid)
            .map(|b| [f64::from(b.deviation), b.tone.frequency.cycles() / mean])
            .collect();
        assert!(processor.counters().lost < processor.counters().bursts);
        valid
    });
    let all: Vec<[f64; 2]> = seen.into_iter().flatten().collect();
    let weight: f64 = all.iter().map(|b| b[0]).sum();
    let mean = all.iter().map(|b| b[0] * b[1]).sum::<f64>() / weight;
    let rms = (all.iter().map(|b| b[0] * (b[1] - mean).powi(2)).sum::<f64>() / weight).sqrt();
    println!("{} bursts: mean {mean:.5}, rms {rms:.5}", all.len());
    // Chance adds 10 % over the root of the number of bursts, and the rms twice its own share.
    let chance = 3.0 / (all.len() as f64).sqrt();
    assert!((mean - 1.0).abs() < 0.003 + 0.1 * chance, "{mean}");
    assert!((rms / 0.1 - 1.0).abs() < 0.03 + 0.7 * chance, "{rms}");
}

/// Chunks of any length have equal bursts; none goes across a gap; unsigned codes; a steady tone is long.
#[test]
fn chunks_gaps_and_what_is_no_burst() {
    let mut rng = rng(4495, 0);
    let at = |middle: f64| Particle {
        middle,
        deviation: 100.0,
        cycles: 0.2,
        amplitude: 900.0,
        phase: 1.0,
        envelope: gaussian,
    };
    let particles: Vec<Particle> = (1..10).map(|k| at(5000.0 * f64::from(k))).collect();
    let samples = stream::<Real>(&mut rng, 50_000, &particles, 20.0, 0.0);
    let plan = Config::new(1.0, CODES).plan::<Real, 1024>().unwrap();
    let run = |samples: &[i16], chunk: usize| {
        let mut processor = BurstProcessor::<Real, 1024>::new(plan);
        let mut bursts = Vec::new();
        samples.chunks(chunk).for_each(|chunk| processor.push(chunk, |burst| bursts.push(*burst)));
        (bursts, *processor.counters())
    };
    let (whole, counters) = run(&samples, samples.len());
    assert_eq!((whole.len(), counters.lost, counters.samples), (9, 0, 50_000));
    assert!(counters.bursts >= 9 && counters.dead < 9 * 1024);
    for (burst, particle) in whole.iter().zip(&particles) {
        assert_eq!(burst.validation, Validation::Valid, "{burst:?}");
        assert!((burst.arrival - particle.middle).abs() < 2.0, "{burst:?}");
        assert!((f64::from(burst.deviation) / particle.deviation - 1.0).abs() < 0.03, "{burst:?}");
        assert!((f64::from(burst.tone.amplitude) / particle.amplitude - 1.0).abs() < 0.03);
    }
    for chunk in [1, 15, 16, 1000] {
        assert_eq!(run(&samples, chunk).0, whole, "chunks of {chunk}");
    }
    // That converter, with codes from 0 on.
    let raised: Vec<i16> = samples.iter().map(|x| x + 2048).collect();
    let unsigned = Config::new(1.0, Codes::unsigned::<12>()).plan::<Real, 1024>().unwrap();
    let mut processor = BurstProcessor::<Real, 1024>::new(unsigned);
    let mut bursts = Vec::new();
    processor.push(&raised, |burst| bursts.push(*burst));
    bursts.retain(|burst| burst.validation == Validation::Valid);
    assert_eq!(bursts.len(), 9);
    // A gap in the middle of the fourth burst, of 3,003 samples.
    let mut processor = BurstProcessor::<Real, 1024>::new(plan);
    let mut bursts = Vec::new();
    processor.push(&samples[..20_000], |burst| bursts.push(*burst));
    processor.lost(3003);
    processor.push(&samples[23_003..], |burst| bursts.push(*burst));
    bursts.retain(|burst| burst.validation == Validation::Valid);
    assert_eq!((bursts.len(), processor.counters().lost), (8, 1));
    for burst in &bursts {
        assert!(whole.iter().any(|other| (other.arrival - burst.arrival).abs() < 0.5));
    }
    // A tone that stays.
    let tone: Vec<i16> = (0..100_000).map(|n| (800.0 * (0.9 * n as f64).sin()) as i16).collect();
    let mut quiet = stream::<Real>(&mut rng, 8192, &[], 20.0, 0.0);
    quiet.extend(tone);
    let (bursts, counters) = run(&quiet, 4096);
    assert!(bursts.is_empty(), "{bursts:?}");
    assert!(counters.long > 0);
}

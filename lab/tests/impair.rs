//! Each impairment does what it says, measured on the samples.

use num_complex::Complex;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_host::simulate::{Kind, Width, generator};
use picket_lab::impair::{Impaired, Impairment, Setup, help};
use picket_transform::Transform;
use std::f64::consts::TAU;

const N: usize = 1024;
const SEED: u64 = 7;
const RAIL: f64 = 2048.0;

fn setup(snr_db: f64) -> Setup {
    let mut setup = Setup::new(N, snr_db);
    (setup.width, setup.amplitude) = (Width::Float, Some(1000.0));
    // One range for all, so that the tones of one trial lie in one place.
    setup.bins = Some((20.0, 250.0));
    setup
}

fn one(text: &str) -> Impairment {
    let all = Impairment::parse(text).unwrap();
    assert_eq!(all.len(), 1, "{text}");
    all.into_iter().next().unwrap()
}

/// The voltages of a record without noise, neither rounded nor clipped.
fn clean<R: Kind>(text: &str, trial: u64) -> Impaired {
    one(text).record::<R>(&setup(f64::INFINITY), &mut generator(SEED, trial))
}

/// What an impairment adds to the pure tone of the same trial.
fn added<R: Kind>(text: &str, trial: u64) -> Vec<Complex<f64>> {
    let pure = clean::<R>("none", trial);
    clean::<R>(text, trial).samples.iter().zip(&pure.samples).map(|(x, p)| x - p).collect()
}

/// The steps of the phase of an I/Q tone from sample to sample, in bins.
fn steps(samples: &[Complex<f64>]) -> Vec<f64> {
    samples.windows(2).map(|x| (x[1] * x[0].conj()).arg() / TAU * N as f64).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[track_caller]
fn near(measured: f64, stated: f64, tolerance: f64) {
    assert!((measured - stated).abs() <= tolerance, "{measured}, stated {stated}, +- {tolerance}");
}

#[test]
fn frequencies_change_as_stated() {
    for trial in 0..10 {
        let chirp = clean::<Iq>("chirp:0.3", trial);
        let found = steps(&chirp.samples);
        // From the first step to the last there are N - 2 samples.
        near((found[N - 2] - found[0]).abs(), 0.3 * (N - 2) as f64 / N as f64, 1e-6);
        near(mean(&found), chirp.bins, 1e-6);

        let step = clean::<Iq>("frequency-step:10", trial);
        let found = steps(&step.samples);
        // Continuous in phase: the mean over the samples there are is that over the block, except for its ends.
        near(mean(&found), step.bins, 10.0 * 2.0 / N as f64);
        near(found[0], step.nominal_bins, 1e-6);
        near((found[N - 2] - found[0]).abs(), 10.0, 1e-6);

        let jump = clean::<Iq>("phase-jump:0.3", trial);
        let found = steps(&jump.samples);
        let odd: Vec<f64> =
            found.iter().map(|s| s - jump.bins).filter(|s| s.abs() > 1e-6).collect();
        assert!(odd.len() <= 1, "{odd:?}");
        odd.iter().for_each(|step| near(step.abs(), 0.3 / TAU * N as f64, 1e-6));

        let walk = clean::<Iq>("phase-walk:0.3", trial);
        let found = steps(&walk.samples);
        // Half a sample before the first one and behind the last one it walks on.
        near(mean(&found), walk.bins, 5.0 * 0.3 / TAU / (N as f64).sqrt());
        let own: Vec<f64> =
            found.iter().map(|s| (s - walk.nominal_bins) * TAU / N as f64).collect();
        let total = own.iter().map(|s| s * s).sum::<f64>().sqrt();
        // A thousand squares of a normal number: the root of their mean is within 2.2 %, one sigma.
        near(total, 0.3, 0.3 * 0.1);
    }
}

#[test]
fn levels_change_as_stated() {
    let level = |text: &str| -> Vec<f64> {
        clean::<Iq>(text, 0).samples.iter().map(|x| x.norm() / 1000.0).collect()
    };
    let am = level("am:depth=0.5,cycles=1");
    near(am.iter().copied().fold(0.0, f64::max), 1.5, 1e-4);
    near(am.iter().copied().fold(9.0, f64::min), 0.5, 1e-4);
    let decay = level("decay:0.5");
    near((decay[N / 2] / decay[0]).ln(), -1.0, 1e-9);
    let start = level("start:0.2");
    assert_eq!(start.iter().filter(|x| **x == 0.0).count(), 205);
    near(start[205], 1.0, 1e-9);
}

/// The envelope of an I/Q tone, less the turns of its carrier.
fn envelope(text: &str, trial: u64) -> Vec<Complex<f64>> {
    let turns = clean::<Iq>("none", trial).samples;
    let record = clean::<Iq>(text, trial);
    near(record.bins, turns_of(trial), 1e-9);
    assert_eq!(record.nominal_bins, turns_of(trial), "{text}");
    record.samples.iter().zip(turns).map(|(x, turn)| x / turn).collect()
}

/// The carrier of a trial, bins.
fn turns_of(trial: u64) -> f64 {
    clean::<Iq>("none", trial).nominal_bins
}

/// The mean over trials, and over the block, of the envelope's power, and of its product with itself `lag` samples later.
fn correlation(text: &str, lag: usize, trials: u64) -> [f64; 2] {
    let (mut power, mut product) = (0.0, 0.0);
    for trial in 0..trials {
        let x = envelope(text, trial);
        power += x.iter().map(|x| x.norm_sqr()).sum::<f64>() / N as f64;
        let pairs = x.iter().zip(&x[lag..]);
        product += pairs.map(|(a, b)| (a.conj() * b).re).sum::<f64>() / (N - lag) as f64;
    }
    [power / trials as f64, product / trials as f64]
}

#[test]
fn particles_cross_as_stated() {
    for trial in 0..20 {
        // The logarithm of a Gaussian is a parabola.
        let burst: Vec<f64> =
            envelope("burst:deviation=0.2,pedestal=0", trial).iter().map(|x| x.re.ln()).collect();
        let bend = -1.0 / (0.2 * N as f64).powi(2);
        burst.windows(3).for_each(|x| near(x[2] - 2.0 * x[1] + x[0], bend, 1e-9));
        // Its middle is in the block.
        near(burst.iter().copied().fold(f64::MIN, f64::max), 0.0, 1e-4);
        // The pedestal has the same envelope, and the level of the tone times its own.
        let pure = clean::<Iq>("burst:deviation=0.2,pedestal=0", trial).samples;
        let with = clean::<Iq>("burst:deviation=0.2,pedestal=0.5", trial).samples;
        for ((with, pure), level) in with.iter().zip(pure).zip(burst) {
            near((with - pure).norm(), 500.0 * level.exp(), 1e-6);
        }
    }
    // Poisson: nobody within reach in exp(-rate (1 + 12 deviations)) of the blocks.
    let (count, reach) = (2000, 1.0_f64 + 12.0 * 0.01);
    let empty = |trial: &u64| {
        let record = clean::<Iq>("particles:rate=0.5,deviation=0.01", *trial);
        record.samples.iter().all(|x| x.norm() == 0.0)
    };
    let share = (0..count).filter(empty).count() as f64 / count as f64;
    near(share, (-0.5 * reach).exp(), 4.0 * (0.25 / count as f64).sqrt());
    // Campbell's theorem: the mean power is the rate times a particle's energy, whose level goes evenly over two nepers.
    let energy = (1.0 - (-4f64).exp()) / 4.0 * 0.05 * std::f64::consts::PI.sqrt();
    let [power, product] = correlation("particles:rate=4,deviation=0.05", 51, 1000);
    // A block has four particles: 1,000 blocks know their mean power to 3 %.
    near(power / (4.0 * energy), 1.0, 0.12);
    let lag = 51.0 / N as f64 / 0.05;
    near(product / power, (-lag * lag / 4.0).exp(), 0.03);
}

#[test]
fn carriers_have_the_width_that_is_stated() {
    // The autocorrelation of a Gaussian line, by its full width at half of its height.
    let stated = |bins: f64, lag: usize| {
        let angle = std::f64::consts::PI * bins * lag as f64 / N as f64;
        (-angle * angle / (4.0 * std::f64::consts::LN_2)).exp()
    };
    for (bins, lag) in [(0.3, 800), (1.0, 400), (5.0, 100)] {
        let [power, product] = correlation(&format!("speckle:{bins}"), lag, 1500);
        // Speckle's power scatters by its mean from block to block: 2.6 % of 1,500, one sigma.
        near(power, 1.0, 0.1);
        near(product / power, stated(bins, lag), 0.05);
    }
    let (mut ends, trials) = (0.0, 2000);
    for trial in 0..trials {
        let x = envelope("linewidth:0.03", trial);
        let own: Vec<f64> = x.windows(2).map(|x| (x[1] * x[0].conj()).arg()).collect();
        if trial < 10 {
            let variance = own.iter().map(|step| step * step).sum::<f64>() / own.len() as f64;
            // A mean of 1,023 squares is known to 4.4 %, one sigma.
            near(variance / (TAU * 0.03 / N as f64), 1.0, 0.2);
        }
        ends += own.iter().sum::<f64>().powi(2) / trials as f64;
    }
    // From the first sample to the last the variance is that of a block: known to 3 %.
    near(ends / (TAU * 0.03), 1.0, 0.12);
}

#[test]
fn modulation_is_what_is_stated() {
    for trial in 0..10 {
        let blades: Vec<f64> =
            envelope("blades:depth=0.5,count=8", trial).iter().map(|x| x.re).collect();
        near(blades.iter().copied().fold(9.0, f64::min), 0.5, 1e-3);
        near(blades.iter().copied().fold(0.0, f64::max), 1.0, 1e-4);
        // Eight times in the block the same.
        blades.iter().zip(&blades[N / 8..]).for_each(|(a, b)| near(*a, *b, 1e-9));
        // Lines at multiples of eight bins from the carrier, as strong above it as below.
        let mut lines: Vec<Complex<f64>> =
            blades.iter().map(|&x| Complex::new(x / N as f64, 0.0)).collect();
        f64::forward(N).process(&mut lines);
        for k in 1..N / 2 {
            near(lines[k].norm(), lines[N - k].norm(), 1e-9);
            assert!(lines[k].norm() < 1e-9 || k % 8 == 0, "{k}");
        }
        assert!(lines[8].norm() > 0.05, "{}", lines[8]);

        let fm = clean::<Iq>("fm:deviation=3,cycles=2.3", trial);
        let own: Vec<f64> = steps(&fm.samples).iter().map(|s| s - fm.nominal_bins).collect();
        near(own.iter().copied().fold(0.0, f64::max), 3.0, 1e-3);
        near(own.iter().copied().fold(0.0, f64::min), -3.0, 1e-3);
        // The mean over the samples is that over the block, except for half a sample at both ends.
        near(mean(&own), fm.bins - fm.nominal_bins, 3.0 * 2.0 / N as f64);
        let quarter = N as f64 / 2.3 / 4.0;
        let turned = own.iter().zip(&own[2 * quarter.round() as usize..]);
        // Half a cycle later it is as far to the other side; rounding to a sample is a third of it off at most.
        turned.for_each(|(a, b)| near(a + b, 0.0, 3.0 * TAU * 2.3 / N as f64));

        let keyed: Vec<f64> = envelope("keying:16", trial).iter().map(|x| x.norm()).collect();
        assert!(keyed.iter().all(|x| *x == 0.0 || (x - 1.0).abs() < 1e-9));
        let changes: Vec<usize> =
            (1..N).filter(|&k| (keyed[k] - keyed[k - 1]).abs() > 0.5).collect();
        assert!(changes.windows(2).all(|at| (at[1] - at[0]) % (N / 16) == 0), "{changes:?}");
        assert!(!changes.is_empty());
    }
    let on = (0..400)
        .map(|trial| envelope("keying:16", trial).iter().map(|x| x.norm()).sum::<f64>() / N as f64);
    // 6,400 bits: half of them within .6 %, one sigma.
    near(on.sum::<f64>() / 400.0, 0.5, 0.03);
}

/// The samples of a record without its tone, which has the same draws before them as `pure`.
fn beside<R: Kind>(pair: &str, pure: &str, trial: u64) -> Vec<f64> {
    let pure = clean::<R>(pure, trial).samples;
    clean::<R>(pair, trial).samples.iter().zip(pure).map(|(x, p)| (x - p).re).collect()
}

#[test]
fn a_pair_is_both() {
    for trial in 0..5 {
        // The source, then the mixer.
        let pair = clean::<Iq>("chirp:0.3+iq-gain:3", trial);
        let gain = 10f64.powf(0.15);
        let samples: Vec<_> =
            pair.samples.iter().map(|x| Complex::new(x.re, x.im / gain)).collect();
        let found = steps(&samples);
        near((found[N - 2] - found[0]).abs(), 0.3 * (N - 2) as f64 / N as f64, 1e-6);
        near(mean(&found), pair.bins, 1e-6);
        // Another signal, then the amplifier: the sum ends below the tone's crest.
        let limit = 1000.0 * 10f64.powf(-0.15);
        let both = "second-tone:offset=10,level-db=-6+clip-analogue:3";
        let (pair, sum) =
            (clean::<Real>(both, trial), clean::<Real>("second-tone:offset=10,level-db=-6", trial));
        for (x, sum) in pair.samples.iter().zip(&sum.samples) {
            near(x.re, sum.re.clamp(-limit, limit), 1e-9);
        }
        // Harmonics of a chirp drift by twice and by three times as much.
        let tone = clean::<Iq>("chirp:0.3", trial).samples;
        let both = clean::<Iq>("chirp:0.3+harmonics:-20", trial).samples;
        for order in [2, 3] {
            let turned = |t: &Complex<f64>| (t / t.norm()).powi(order).conj();
            let part: Complex<f64> = both.iter().zip(&tone).map(|(x, t)| (x - t) * turned(t)).sum();
            // The other harmonic leaks by 100 over pi times the bins between them.
            near(part.norm() / N as f64, 100.0, 2.0);
        }
        // Where samples are lost, those of a drift are lost, too.
        let line =
            beside::<Real>("lost:4+drift:fs=0.1,order=1", "lost:4+drift:fs=0,order=1", trial);
        let slopes: Vec<f64> = line.windows(2).map(|x| x[1] - x[0]).collect();
        let slope = 2.0 * 0.1 * RAIL / N as f64 * slopes[0].signum();
        let odd: Vec<f64> =
            slopes.iter().map(|s| s / slope).filter(|s| (s - 1.0).abs() > 1e-6).collect();
        assert!(odd.len() <= 1, "{odd:?}");
        odd.iter().for_each(|odd| near(*odd, 5.0, 1e-6));
        // A walk goes on over what is lost, however much.
        let walk = clean::<Iq>("lost:2000+phase-walk:0.3", trial);
        let own = steps(&walk.samples)[N - 2] - walk.nominal_bins;
        assert!(own.abs() > 1e-6, "{own}");
        // Factors of the level and of the noise's density multiply.
        let product = envelope("am:depth=0.5,cycles=1+start:0.5", trial);
        let swing = envelope("am:depth=0.5,cycles=1", trial);
        for (k, (x, swing)) in product.iter().zip(swing).enumerate() {
            near((x - if k < N / 2 { Complex::default() } else { swing }).norm(), 0.0, 1e-9);
        }
    }
    let (powers, stated, place) =
        density::<Real>("noise-slope:20+noise-notch:level-db=-20,width=10,offset=0");
    let level = |k: usize| 10.0 * mean(&powers[k - 2..k + 3]).log10();
    near(level(place as usize), 10.0 * stated.log10(), 1.2);
    near(level(470) - level(220), 20.0 * 250.0 / 512.0, 1.5);
}

/// Any two that fit together, either way round, are one record, and are read as they are printed.
#[test]
fn any_two_can_be_in_one_record() {
    let mut names: Vec<String> =
        [Impairment::all(), Impairment::signals(), Impairment::front_end()]
            .concat()
            .iter()
            .map(Impairment::name)
            .collect();
    names.dedup();
    let (mut fit, mut refused) = (0, 0);
    for (index, a) in names.iter().enumerate() {
        for b in &names[index..] {
            let Ok(pairs) = Impairment::parse(&format!("{a}+{b}")) else {
                refused += 1;
                continue;
            };
            let pair = pairs.into_iter().next_back().unwrap();
            assert_eq!(one(&pair.to_string()), pair);
            assert_eq!(pair.name(), format!("{a}+{b}"));
            let turned = pair.to_string();
            let (first, second) = turned.split_once(&format!("+{b}")).unwrap();
            let turned = one(&format!("{b}{second}+{first}"));
            let of = |pair: &Impairment| match pair.fits::<Real>() {
                true => pair.record::<Real>(&Setup::new(64, 20.0), &mut generator(SEED, 1)),
                false => pair.record::<Iq>(&Setup::new(64, 20.0), &mut generator(SEED, 1)),
            };
            let record = of(&pair);
            assert_eq!(record, of(&turned), "{pair}");
            assert!(record.bins.is_finite() && record.samples.len() == 64, "{pair}");
            let codes = |x: f64| (-2048.0..=2047.0).contains(&x) && x.fract() == 0.0;
            assert!(record.samples.iter().all(|x| codes(x.re) && codes(x.im)), "{pair}");
            fit += 1;
        }
    }
    println!("{fit} pairs, {refused} refused");
    // Each with itself and with nothing, three levels, rounding without noise with seven shapes of it, two of real records
    // or of I/Q.
    let count = names.len();
    assert_eq!(refused, count + (count - 1) + 3 + 7 + 4);
    assert_eq!(fit + refused, count * (count + 1) / 2);
}

#[test]
fn what_is_added_is_what_is_stated() {
    for trial in 0..5 {
        for x in added::<Real>("dc:0.05", trial) {
            near(x.re.abs(), 0.05 * RAIL, 1e-6);
        }
        for x in added::<Iq>("dc:0.05", trial) {
            near(x.norm(), 0.05 * RAIL, 1e-6);
        }
        let hum = added::<Real>("hum:cycles=2,fs=0.01", trial);
        let bin = |k: f64| -> Complex<f64> {
            let turn =
                |i: usize| Complex::from_polar(2.0 / N as f64, -TAU * k * i as f64 / N as f64);
            hum.iter().enumerate().map(|(i, x)| turn(i) * x.re).sum()
        };
        near(bin(2.0).norm(), 0.01 * RAIL, 1e-6);
        near(bin(1.0).norm(), 0.0, 1e-6);
        let line = added::<Real>("drift:fs=0.01,order=1", trial);
        near((line[N - 1] - line[0]).re.abs(), 2.0 * 0.01 * RAIL, 0.1);
        near((line[2] - line[1]).re, (line[1] - line[0]).re, 1e-9);
        let parabola = added::<Real>("drift:fs=0.01,order=2", trial);
        near(parabola[0].re.abs(), 0.01 * RAIL, 1e-6);
        near((parabola[N / 2] / parabola[0]).re, -0.5, 1e-3);

        let second = added::<Iq>("second-tone:offset=0.75,level-db=-20", trial);
        let found = steps(&second);
        let place = clean::<Iq>("none", trial).bins;
        near((mean(&found) - place).abs(), 0.75, 1e-6);
        second.iter().for_each(|x| near(x.norm(), 100.0, 1e-6));

        // The part of what is added that turns twice and three times as fast as the tone.
        let tone: Vec<_> =
            clean::<Iq>("none", trial).samples.iter().map(|x| x / x.norm()).collect();
        let harmonics = added::<Iq>("harmonics:-20", trial);
        for (order, level) in [(2, 100.0), (3, 100.0), (4, 0.0)] {
            let part: Complex<f64> =
                harmonics.iter().zip(&tone).map(|(x, t)| x * t.powi(order).conj()).sum();
            near(part.norm() / N as f64, level, 2.0);
        }

        let impulses = added::<Real>("impulses:count=5,fs=0.5", trial);
        let heights: Vec<f64> = impulses.iter().map(|x| x.re.abs()).filter(|x| *x > 0.0).collect();
        // Two may fall onto the same sample.
        assert!((3..=5).contains(&heights.len()), "{heights:?}");
        near(heights[0], 0.5 * RAIL, 1e-6);

        let burst = added::<Iq>("tone-burst:share=0.2,level-db=-6", trial);
        let on: Vec<usize> = (0..N).filter(|&k| burst[k].norm() > 0.0).collect();
        near(on.len() as f64, 0.2 * N as f64, 1.0);
        assert_eq!(on.last().unwrap() - on[0] + 1, on.len());
        near(burst[on[0]].norm(), 501.187, 1e-2);

        let burst = added::<Iq>("noise-burst:share=0.5,level-db=0", trial);
        let power = burst.iter().map(|x| x.norm_sqr()).sum::<f64>() / (0.5 * N as f64);
        // 512 samples: 4 % of spread.
        near(power / 1e6, 1.0, 0.2);
    }
}

#[test]
fn clocks_are_wrong_as_stated() {
    for trial in 0..5 {
        let pure = clean::<Iq>("none", trial);
        let lost = clean::<Iq>("lost:4", trial);
        let turns: Vec<f64> =
            steps(&lost.samples).iter().map(|s| (s - pure.bins).rem_euclid(N as f64)).collect();
        let odd: Vec<&f64> = turns.iter().filter(|x| **x > 1e-6 && N as f64 - **x > 1e-6).collect();
        assert_eq!(odd.len(), 1);
        near(*odd[0], (4.0 * pure.bins).rem_euclid(N as f64), 1e-6);

        let doubled = clean::<Iq>("doubled:4", trial).samples;
        let first = (1..N).find(|&k| doubled[k] == doubled[k - 1]).unwrap();
        let copies = (first..N).take_while(|&k| doubled[k] == doubled[k - 1]).count();
        assert_eq!(copies, 4.min(N - first));
        assert_eq!(doubled[..first], pure.samples[..first]);
        assert_eq!(doubled[first + copies..], pure.samples[first..N - copies]);

        let late = |samples: &[Complex<f64>]| -> Vec<f64> {
            let turn = |(x, p): (&Complex<f64>, &Complex<f64>)| (x * p.conj()).arg();
            let per_sample = TAU * pure.bins / N as f64;
            samples.iter().zip(&pure.samples).map(turn).map(|turn| turn / per_sample).collect()
        };
        let jitter = late(&clean::<Iq>("jitter:0.1", trial).samples);
        near(mean(&jitter.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt(), 0.1, 0.01);
        let skew = late(&clean::<Iq>("skew:0.2", trial).samples);
        for (k, late) in skew.iter().enumerate() {
            near(*late, if k % 2 == 1 { 0.2 } else { 0.0 }, 1e-6);
        }
        let delay = clean::<Iq>("iq-delay:1", trial).samples;
        delay.iter().zip(&pure.samples).for_each(|(x, p)| near(x.re, p.re, 1e-6));
        delay.iter().skip(1).zip(&pure.samples).for_each(|(x, p)| near(x.im, p.im, 1e-6));
    }
}

#[test]
fn converters_are_wrong_as_stated() {
    let largest = |samples: &[Complex<f64>]| samples.iter().map(|x| x.re.abs()).fold(0.0, f64::max);
    near(largest(&clean::<Real>("clip-analogue:3", 0).samples), 1000.0 * 10f64.powf(-0.15), 1e-6);
    // At the rails: where the cosine is beyond 1/1.122.
    let codes = Setup::new(N, f64::INFINITY);
    let over = one("clip-converter:1").record::<Real>(&codes, &mut generator(SEED, 0));
    let at_rails = over.samples.iter().filter(|x| x.re == 2047.0 || x.re == -2048.0).count();
    near(at_rails as f64 / N as f64, 2.0 * (10f64.powf(-0.05)).acos() / std::f64::consts::PI, 0.02);

    // An amplitude of 1000 codes is but half of the characteristic.
    let bend = added::<Real>("inl:16", 0);
    assert!((8.0..=16.0).contains(&largest(&bend)), "{}", largest(&bend));
    let steps = added::<Real>("steps:8", 0);
    for x in &steps {
        near(x.re, 2.0 * (x.re / 2.0).round(), 1e-6);
        assert!(x.re.abs() <= 14.0);
    }
    let mut values: Vec<i64> = steps.iter().map(|x| x.re.round() as i64).collect();
    values.sort_unstable();
    values.dedup();
    assert!((2..=4).contains(&values.len()), "{values:?}");

    let few = one("quantise:2").record::<Real>(&Setup::new(N, 10.0), &mut generator(SEED, 0));
    assert!(few.samples.iter().all(|x| x.re.fract() == 0.0 && x.re.abs() <= 3.0));
    assert!(!one("quantise:2").noisy());

    let pure = clean::<Iq>("none", 0).samples;
    for (x, p) in clean::<Iq>("iq-gain:3", 0).samples.iter().zip(&pure) {
        near(x.im, p.im * 10f64.powf(0.15), 1e-6);
        near(x.re, p.re, 1e-6);
    }
    let skewed = clean::<Iq>("iq-phase:20", 0).samples;
    let product: f64 = skewed.iter().map(|x| x.re * x.im).sum::<f64>() / (N as f64 / 2.0 * 1e6);
    near(product, 20f64.to_radians().sin(), 0.01);
    // Nothing: not even noise.
    let dead = one("iq-dead:1").record::<Iq>(&setup(0.0), &mut generator(SEED, 0)).samples;
    assert!(dead.iter().all(|x| x.im == 0.0) && dead.iter().any(|x| x.re != 0.0));
    let dead = one("iq-dead:0").record::<Iq>(&setup(0.0), &mut generator(SEED, 0)).samples;
    assert!(dead.iter().all(|x| x.re == 0.0) && dead.iter().any(|x| x.im != 0.0));
}

#[test]
fn codes_are_wrong_as_stated() {
    let of = |text: &str, amplitude: f64| -> Vec<f64> {
        let mut codes = Setup::new(N, f64::INFINITY);
        codes.amplitude = Some(amplitude);
        let samples = one(text).record::<Real>(&codes, &mut generator(SEED, 0)).samples;
        samples.iter().map(|x| x.re).collect()
    };
    let pure = of("none", 2000.0);
    for (x, p) in of("swapped", 2000.0).chunks(2).zip(pure.chunks(2)) {
        assert_eq!([x[1], x[0]], [p[0], p[1]]);
    }
    for (x, p) in of("wrong-sign", 2000.0).iter().zip(&pure) {
        assert_eq!((*p as i16 as u16 ^ 0x800) & 0xFFF, *x as i16 as u16 & 0xFFF);
    }
    for level in [0, 1] {
        for (x, p) in of(&format!("stuck-bit:bit=8,level={level}"), 2000.0).iter().zip(&pure) {
            assert_eq!(*x as i16, (*p as i16 & !0x100) | level << 8, "{p}");
        }
    }
    let missing = of("missing-codes:4", 2000.0);
    assert!(missing.iter().all(|x| x.rem_euclid(512.0) >= 4.0));
    let moved = missing.iter().zip(&pure).filter(|(x, p)| x != p);
    assert!(moved.clone().count() > 0);
    moved.for_each(|(x, p)| {
        assert!(p.rem_euclid(512.0) < 4.0 && (1.0..=4.0).contains(&(p - x)), "{p} {x}")
    });
    // Twice the rail: the codes of a converter that is twice as wide, less a whole number of its ranges.
    let wrapped = of("wrap:6.0206", 2000.0);
    let mut wide = Setup::new(N, f64::INFINITY);
    (wide.amplitude, wide.width) = (Some(4096.0), Width::Float);
    let wide = one("none").record::<Real>(&wide, &mut generator(SEED, 0)).samples;
    for (x, p) in wrapped.iter().zip(&wide) {
        assert!((-2048.0..2048.0).contains(x));
        let ranges = (p.re - x) / 4096.0;
        near(ranges, ranges.round(), 1.0 / 4096.0);
    }
    let carried = wrapped.iter().zip(&wide).filter(|(x, p)| (p.re - *x).abs() > 1.0).count();
    // Beyond half of its crest a sine is for two thirds of the time.
    near(carried as f64 / N as f64, 2.0 / 3.0, 0.05);
    // A tone goes on from where it was a block earlier.
    let (stale, whole) = (of("stale-buffer:0.25", 2000.0), clean::<Iq>("none", 0));
    assert_eq!(stale[..768], pure[..768]);
    assert_ne!(stale[768..], pure[768..]);
    let late = clean::<Iq>("stale-buffer:0.25", 0).samples;
    let turn = Complex::cis(-TAU * whole.bins);
    for (x, whole) in late.iter().zip(&whole.samples).skip(768) {
        near((x - whole * turn).norm(), 0.0, 1e-6);
    }
}

/// The power density of the noise of an impairment over bins, of white noise 1: 200 records through Hann's window, and
/// what they say of it at the tone.
fn density<R: Kind>(text: &str) -> (Vec<f64>, f64, f64) {
    let (noisy, silent) = (setup(10.0), setup(f64::INFINITY));
    let fft = f64::forward(N);
    let (mut powers, mut stated, mut place) = (vec![0.0; N], 0.0, 0.0);
    let trials = 200;
    for trial in 0..trials {
        // All tones in one place, so that what lies beside them does, too.
        let (mut noisy, mut silent) = (noisy.clone(), silent.clone());
        (noisy.bins, silent.bins) = (Some((128.0, 128.0)), Some((128.0, 128.0)));
        let with = one(text).record::<R>(&noisy, &mut generator(SEED, trial));
        let without = one(text).record::<R>(&silent, &mut generator(SEED, trial));
        let window = |k: usize| 1.0 - (TAU * k as f64 / N as f64).cos();
        let difference = with.samples.iter().zip(&without.samples).enumerate();
        let mut x: Vec<Complex<f64>> = difference.map(|(k, (x, y))| (x - y) * window(k)).collect();
        fft.process(&mut x);
        // 10 dB below 1000 codes: 1e6 / 20 in each part; Hann's window holds 3/2 of the power.
        let white = 1e6 / 20.0 * 1.5 * N as f64 * if R::IQ { 2.0 } else { 1.0 };
        powers
            .iter_mut()
            .zip(x)
            .for_each(|(p, x)| *p += x.norm_sqr() / white / f64::from(trials as u32));
        stated = 10f64.powf(1.0 - with.local_snr_db / 10.0);
        place = with.bins;
    }
    (powers, stated, place)
}

#[test]
fn noise_has_the_shape_that_is_stated() {
    // The mean over bins a..b, dB.
    let db = |powers: &[f64], a: usize, b: usize| 10.0 * mean(&powers[a..b]).log10();
    let of = |text: &str| {
        let (powers, stated, place) = density::<Real>(text);
        // All of it is what the ratio says; less so where few bins hold it.
        near(10.0 * mean(&powers).log10(), 0.0, 0.4);
        let k = place.round() as usize;
        // Twenty-one bins of 200 records: 2 %, and what the shape changes over them.
        near(db(&powers, k - 3, k + 4), 10.0 * stated.log10(), 0.6);
        powers
    };
    let white = of("none");
    near(db(&white, 100, 120), 0.0, 0.3);
    let slope = of("noise-slope:20");
    near(db(&slope, 450, 475) - db(&slope, 38, 63), 20.0 * 412.0 / 512.0, 0.5);
    let notch = of("noise-notch:level-db=-20,width=40,offset=0");
    near(db(&notch, 125, 132) - db(&notch, 400, 500), -20.0, 0.6);
    let hump = of("noise-hump:level-db=10,width=10,offset=0");
    near(db(&hump, 127, 130) - db(&hump, 400, 500), 10.0, 0.8);
    let flicker = of("noise-flicker:1");
    near(db(&flicker, 95, 106) - db(&flicker, 380, 421), 6.0, 0.5);
    let low = of("noise-low-pass:corner=0.5,order=8");
    near(db(&low, 30, 200), 3.0, 0.3);
    near(db(&low, 254, 259) - db(&low, 30, 200), -3.0, 0.6);
    assert!(db(&low, 400, 500) < -25.0, "{}", db(&low, 400, 500));
    let rc = of("noise-rc:corner=0.5,sections=2");
    near(db(&rc, 246, 267) - db(&rc, 3, 30), -6.0, 0.6);
    let band = of("noise-band-pass:middle=0.25,width=0.125");
    near(db(&band, 110, 146), 9.0, 0.5);
    assert!(db(&band, 300, 500) < -30.0 && db(&band, 10, 50) < -20.0);
    // Of I/Q the slope goes on through DC.
    let (slope, ..) = density::<Iq>("noise-slope:20");
    near(db(&slope, 380, 400) - db(&slope, 624, 644), 20.0 * 780.0 / 1024.0, 0.6);
}

#[test]
fn a_seed_gives_the_same_records_and_everything_is_different() {
    fn of<R: Kind>(impairment: &Impairment, trial: u64) -> Vec<Complex<f64>> {
        impairment.record::<R>(&Setup::new(256, 30.0), &mut generator(SEED, trial)).samples
    }
    let mut names = Vec::new();
    for impairment in [Impairment::all(), Impairment::signals(), Impairment::front_end()].concat() {
        let pair = |trial| match impairment.fits::<Real>() {
            true => (of::<Real>(&impairment, trial), of::<Real>(&one("none"), trial)),
            false => (of::<Iq>(&impairment, trial), of::<Iq>(&one("none"), trial)),
        };
        let label = format!("{}:{}", impairment.name(), impairment.label());
        assert_eq!(pair(3), pair(3), "{label}");
        assert_ne!(pair(3).0, pair(4).0, "{label}");
        assert_eq!(pair(3).0 == pair(3).1, impairment.name() == "none", "{label}");
        assert_eq!(pair(3).0.len(), 256);
        // What is printed is what is read.
        if !impairment.label().is_empty() {
            assert_eq!(one(&label), impairment);
        }
        names.push(impairment.name());
        assert!(help().contains(&format!("  {} ", impairment.name())), "{label}");
    }
    // Of I/Q tones, half turn backwards.
    let turns =
        |trial| one("none").record::<Iq>(&Setup::new(64, 30.0), &mut generator(SEED, trial)).bins;
    let backwards = (0..100).filter(|&trial| turns(trial) < 0.0).count();
    assert!((30..70).contains(&backwards), "{backwards}");
    // A generator goes on.
    let (mut rng, none) = (generator(SEED, 0), one("none"));
    let mut next = || none.record::<Real>(&Setup::new(64, 30.0), &mut rng).samples;
    assert_ne!(next(), next());
    names.dedup();
    for name in "dc hum drift harmonics clip-analogue clip-converter impulses lost doubled inl quantise chirp am phase-walk \
                 phase-jump frequency-step second-tone tone-burst noise-burst noise-slope noise-notch noise-hump noise-flicker \
                 noise-low-pass noise-band-pass start decay jitter skew iq-gain iq-phase iq-delay iq-dead steps wrap swapped wrong-sign stuck-bit missing-codes stale-buffer \
                 burst particles speckle linewidth blades fm keying"
        .split_whitespace()
    {
        assert!(names.iter().any(|other| other == name), "no {name}");
    }
}

#[test]
fn severities_as_they_are_typed() {
    let labels = |text: &str| -> Vec<String> {
        let all = Impairment::parse(text).unwrap();
        all.iter().map(|i| format!("{}:{}", i.name(), i.label())).collect()
    };
    assert_eq!(labels("chirp:0.3"), ["chirp:rate=0.3"]);
    assert_eq!(labels("chirp:rate-bins=0.3/1"), ["chirp:rate=0.3", "chirp:rate=1"]);
    assert_eq!(
        labels("hum:cycles=2,fs=0.1/0.2, dc:0.5"),
        ["hum:cycles=2,fs=0.1", "hum:cycles=2,fs=0.2", "dc:fs=0.5"]
    );
    assert_eq!(labels("second-tone").len(), 24);
    assert_eq!(
        labels("chirp:0.3 + hum:cycles=2,fs=0.1/1e-1"),
        ["chirp+hum:rate=0.3 + cycles=2,fs=0.1"; 2]
    );
    assert_eq!(
        labels("dc:1e+0,chirp:0.3/1+dc"),
        [
            "dc:fs=1",
            "chirp+dc:rate=0.3 + fs=0.01",
            "chirp+dc:rate=0.3 + fs=0.05",
            "chirp+dc:rate=1 + fs=0.01",
            "chirp+dc:rate=1 + fs=0.05"
        ]
    );
    let pair = one("second-tone:offset=0.5,level-db=-20+harmonics:-40");
    let keys: Vec<(String, f64)> = pair.severities().collect();
    let stated = [
        ("second_tone_offset_bins", 0.5),
        ("second_tone_level_db", -20.0),
        ("harmonics_level_db", -40.0),
    ];
    assert_eq!(keys, stated.map(|(key, value)| (key.to_owned(), value)));
    assert_eq!(labels("signals").len(), Impairment::signals().len());
    assert_eq!(labels("all").len(), Impairment::all().len());
    assert_eq!(labels("front-end").len(), Impairment::front_end().len());
    let wrong = |text: &str, says: &str| {
        let error = Impairment::parse(text).unwrap_err();
        assert!(error.contains(says) && error.lines().count() == 1, "{text}: {error}");
    };
    wrong("chrip", "no impairment \"chrip\"");
    wrong("", "no impairment");
    wrong("chirp,", "no impairment");
    wrong("chirp:fast", "rate=fast: give a number from 0");
    wrong("chirp:speed=1", "chirp has no \"speed\", but rate");
    wrong("chirp:nan", "give a number");
    wrong("dc:1.5", "from 0 to 1");
    wrong("none:1", "none has no severities");
    wrong("hum,rate=1", "hum has no \"rate\", but cycles, fs");
    wrong("all,rate=1", "no impairment \"rate=1\"");
    wrong("hum+", "no impairment \"\"");
    wrong("+hum", "no impairment \"\"");
    wrong("hum:cycles=2+fs=0.1", "no impairment \"fs=0.1\"");
    wrong("hum+dc+am", "two impairments at most");
    wrong("all+hum", "join two by their names");
    wrong("hum+front-end", "join two by their names");
    wrong("hum+hum", "a record has hum once");
    wrong("none+hum", "hum alone is the same");
    wrong("quantise+clip-converter", "both say how strong the tone is");
    wrong("noise-rc+quantise", "quantise has no noise");
    wrong("iq-gain+swapped", "swapped is of real records");
    wrong("second-tone:1/2/3/4/5/6/7/8/9/10+second-tone", "once");
    wrong(&format!("chirp:1{}+hum", "/1".repeat(3000)), "fewer values");
}

//! What no answer may be called: good without a sigma, good beside its band.

use crate::signal::{CODES, Kind as _, Line, amplitude, quantise, rng, sigma, trials};
use picket::acquire::sample::{Iq, Real, Stamp};
use picket::config::Config;
use picket::methods::registry::Method;
use picket::pipeline::{Alternating, Pipeline};
use picket::{Arithmetic, Usable};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// A line up to two bins beyond an end of the band that is searched: none of it is more than half a bin outside and good.
#[test]
fn a_line_beyond_an_end_of_the_band_is_not_good() {
    const N: usize = 512;
    println!("seed 12");
    let (mut inside, mut outside) = (0, 0);
    for trial in 0..4000 {
        let mut rng = rng(12, trial);
        let low = rng.random_range(8..200_i32);
        let high = low + rng.random_range(1..40);
        let beyond = rng.random_range(0.0..2.0);
        let bins = if trial % 2 == 0 { f64::from(low) - beyond } else { f64::from(high) + beyond };
        let line = Line { bins, amplitude: amplitude(30.0), phase: rng.random_range(0.0..TAU) };
        let samples = Real::record::<N>(&mut rng, &[line], sigma(line.amplitude, 30.0));
        let mut config = Config::new(N as f64, CODES);
        config.band_hz = Some((f64::from(low), f64::from(high)));
        let plan = config.plan::<Real, N>().unwrap();
        let (low, high) = (plan.band.low, plan.band.high);
        let tone = Pipeline::<Real, N>::new(plan).block(Stamp::default(), &samples).tone;
        let found = tone.frequency.bins(N);
        let is_inside = found >= f64::from(low) - 0.5 && found <= f64::from(high) + 0.5;
        let good = tone.verdict == picket::Verdict::Good;
        assert!(is_inside || !good, "trial {trial}: {tone}, bin {found} of {low} to {high}");
        inside += u32::from(is_inside && good);
        outside += u32::from(!is_inside);
    }
    assert!(inside > 900 && outside > 100, "{inside} inside and good, {outside} outside");
}

/// By every method, of pairs by turns whose tone is at an end of the band or anywhere in it: no answer is good without a sigma.
#[test]
fn an_answer_without_a_sigma_is_not_good() {
    const N: usize = 256;
    println!("seed 13");
    let mut without = 0;
    for method in
        Method::ALL.iter().copied().filter(|method| Alternating::<N, { 2 * N }>::fits(*method))
    {
        let mut config = Config::new(1.0, CODES);
        config.method = method.of_kind::<Iq>();
        let Ok(plan) = config.plan::<Iq, N>() else { continue };
        let mut pipeline = Alternating::<N, { 2 * N }>::new(plan);
        for trial in 0..600 {
            let mut rng = rng(13, trial);
            let bins = rng.random_range(-3.0..3.0) + if trial % 2 == 0 { 126.0 } else { -126.0 };
            let phase = rng.random_range(0.0..TAU);
            let line = Line { bins, amplitude: 1000.0, phase };
            let snr_db = rng.random_range(-10.0..60.0);
            let mut pairs = Iq::record::<N>(&mut rng, &[line], sigma(1000.0, snr_db));
            let tone = pipeline.block(Stamp::default(), &mut pairs).tone;
            let known = tone.sigma < 1.0;
            assert!(
                known || tone.verdict >= picket::Verdict::Weak,
                "{} {line:?}: {tone}",
                method.name()
            );
            without += u32::from(!known);
        }
    }
    println!("{without} answers without a sigma");
}

/// A record's lines and the frequency in bins that an answer is about: none where the band has nothing but noise.
struct Drawn {
    name: &'static str,
    lines: Vec<Line>,
    truth: Option<f64>,
}

/// A steady tone, one beside the band of bins 60 to 180, one with sidebands, and two tones.
fn drawn(rng: &mut ChaCha8Rng, snr_db: f64) -> [Drawn; 4] {
    let place = rng.random_range(70.0..170.0);
    let outside =
        if rng.random() { rng.random_range(20.0..50.0) } else { rng.random_range(190.0..230.0) };
    let (cycles, apart) = (rng.random_range(0.5..1.5), rng.random_range(1.5..6.5));
    let mut line = |bins: f64, share: f64| Line {
        bins,
        amplitude: share * amplitude(snr_db),
        phase: rng.random_range(0.0..TAU),
    };
    [
        Drawn { name: "steady", lines: vec![line(place, 0.9)], truth: Some(place) },
        Drawn { name: "beside the band", lines: vec![line(outside, 0.9)], truth: None },
        Drawn {
            name: "with sidebands",
            lines: vec![line(place, 0.6), line(place + cycles, 0.15), line(place - cycles, 0.15)],
            truth: Some(place),
        },
        Drawn {
            name: "two tones",
            lines: vec![line(place, 0.6), line(place + apart, 0.3)],
            truth: Some(place),
        },
    ]
}

/// How many answers of a method are usable and more than five sigma off, of a thousand.
fn usable_and_wrong<R: crate::signal::Kind>(method: Method) -> Option<[(&'static str, u32); 4]> {
    const N: usize = 512;
    let mut config = Config::new(N as f64, CODES);
    config.band_hz = Some((60.0, 180.0));
    config.method = method;
    let plan = config.plan::<R, N>().ok()?;
    let wrong = trials(17, 1000, |rng| {
        let snr_db = rng.random_range(0.0..50.0);
        drawn(rng, snr_db).map(|Drawn { name, lines, truth }| {
            let samples = R::record::<N>(rng, &lines, sigma(amplitude(snr_db), snr_db));
            let tone = Pipeline::<R, N>::new(plan).block(Stamp::default(), &samples).tone;
            let usable = tone.verdict.usable() <= Usable::WithinSigma;
            let off = |truth: f64| {
                (tone.frequency.bins(N) - truth).abs() > 5.0 * f64::from(tone.sigma) * N as f64
            };
            (name, u32::from(usable && truth.is_none_or(off)))
        })
    });
    Some([0, 1, 2, 3].map(|case| {
        let of_case = wrong.iter().map(|cases| cases[case]);
        (wrong[0][case].0, of_case.map(|(_, wrong)| wrong).sum())
    }))
}

/// No method's answers are usable and wrong more often than those of least squares, but for chance: five of a thousand.
fn as_least_squares<R: crate::signal::Kind>() -> usize {
    let least = usable_and_wrong::<R>(Method::LeastSquaresReal.of_kind::<R>()).unwrap();
    println!("least squares: {least:?} of 1000");
    assert!(least.iter().all(|&(_, wrong)| wrong <= 15), "{least:?}");
    let methods = Method::ALL.iter().copied();
    let found: Vec<_> = methods
        .filter_map(|method| Some((method.name(), usable_and_wrong::<R>(method)?)))
        .collect();
    found.iter().for_each(|(name, cases)| println!("{name}: {cases:?} of 1000"));
    for (name, cases) in &found {
        let most = least.iter().map(|&(_, wrong)| wrong + 5);
        assert!(cases.iter().zip(most).all(|(&(_, wrong), most)| wrong <= most), "{name}");
    }
    found.len()
}

#[test]
fn good_means_one_thing_whatever_the_method() {
    let methods = as_least_squares::<Real>() + as_least_squares::<Iq>();
    assert!(methods > 10, "{methods}");
}

/// How a record of one tone changes over its time.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Bins over the record.
    rise: f64,
    /// A swing's share of the level, and its cycles.
    swing: (f64, f64),
    /// When the tone begins and for how long it is there, of the record.
    on: (f64, f64),
}

impl Change {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let mut change = Self { rise: 0.0, swing: (0.0, 0.0), on: (0.0, 1.0) };
        match rng.random_range(0..4) {
            0 => change.rise = rng.random_range(-3.0..3.0),
            1 => change.swing = (rng.random_range(0.0..0.95), rng.random_range(0.3..2.0)),
            2 => {
                let length = rng.random_range(0.2..1.0);
                change.on = (rng.random_range(0.0..=1.0 - length), length);
            }
            _ => {}
        }
        change
    }
}

/// How many records of real tones, and of those that are usable how many are not when the record runs backwards, or when every
/// second sample is negated, which turns the spectrum round; the last where the tone is away from both ends and near one.
#[derive(Clone, Copy, Debug, Default)]
struct Symmetric {
    usable: u32,
    backwards: u32,
    turned: u32,
    turned_near_an_end: u32,
}

/// Nearer to 0 Hz than this a drift may disturb a tone, and near half the rate nothing does: see `least_squares::slow` and
/// `noise::ring`.
const DRIFT: f64 = 48.5;

/// Steady tones, or others as well, at -5 to 60 dB anywhere from bin 3 on.
fn symmetric<const N: usize>(arithmetic: Arithmetic, steady: bool, seed: u64) -> Symmetric {
    let config = Config { arithmetic, ..Config::new(1.0, CODES) };
    let plan = config.plan::<Real, N>().unwrap();
    let seen = trials(seed, 2500, |rng| {
        let nyquist = N as f64 / 2.0;
        let bins = rng.random_range(3.0..nyquist - 3.0);
        let change = Change::draw(rng);
        let Change { rise, swing: (depth, cycles), on: (start, length) } =
            if steady { Change { rise: 0.0, swing: (0.0, 0.0), on: (0.0, 1.0) } } else { change };
        let snr_db = rng.random_range(-5.0..60.0);
        let (phase, swung) = (rng.random_range(0.0..TAU), rng.random_range(0.0..TAU));
        let amplitude = rng.random_range(0.2..0.95) * amplitude(snr_db);
        let noise = sigma(amplitude, snr_db);
        let record: [i16; N] = std::array::from_fn(|n| {
            let t = n as f64 / N as f64;
            let level = (1.0 + depth * (TAU * cycles * t + swung).sin()) / (1.0 + depth);
            let level = if (start..start + length).contains(&t) { level } else { 0.0 };
            let tone = (TAU * (bins + rise * (t - 0.5) / 2.0) * t + phase).cos();
            let sample = amplitude * level * tone + noise * rng.sample::<f64, _>(StandardNormal);
            // The lowest code has no negative.
            quantise(sample).max(-2047)
        });
        let backwards = std::array::from_fn(|n| record[N - 1 - n]);
        let turned = std::array::from_fn(|n| if n % 2 == 0 { record[n] } else { -record[n] });
        let mut pipeline = Pipeline::<Real, N>::new(plan);
        let [it, backwards, turned] = [record, backwards, turned].map(|samples| {
            let verdict = pipeline.block(Stamp::default(), &samples).tone.verdict;
            verdict.usable() <= Usable::WithinSigma
        });
        let near = bins.min(nyquist - bins) < DRIFT;
        [it, it != backwards, it != turned && !near, it != turned && near]
    });
    let count = |index: usize| seen.iter().filter(|seen| seen[index]).count() as u32;
    let [usable, backwards, turned, turned_near_an_end] = [0, 1, 2, 3].map(count);
    Symmetric { usable, backwards, turned, turned_near_an_end }
}

/// Of 40,000 records.
#[test]
fn a_verdict_does_not_depend_on_the_direction_of_time_or_of_the_spectrum() {
    println!("seeds 14 and 15");
    for steady in [true, false] {
        for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
            for seed in [14, 15] {
                let short = symmetric::<256>(arithmetic, steady, seed);
                let long = symmetric::<1024>(arithmetic, steady, seed);
                println!("steady {steady}, {arithmetic:?}: N = 256 {short:?}, N = 1024 {long:?}");
                for Symmetric { usable, backwards, turned, turned_near_an_end } in [short, long] {
                    // Steady ones at the threshold, where a rounding decides; of others it decides between moving and unresolved.
                    let (most, near) = if steady { (2, 0) } else { (4, 20) };
                    assert!(usable >= if steady { 2450 } else { 1950 }, "{usable}");
                    assert!(backwards + turned <= most && turned_near_an_end <= near);
                }
            }
        }
    }
}

/// A record's mirror in the plane of I and Q, and what becomes of its frequency's sign: none of them adds or takes away anything.
type Mirror = (&'static str, fn([i16; 2]) -> [i16; 2], f64);

const MIRRORS: [Mirror; 4] = [
    ("negated", |[i, q]| [-i, -q], 1.0),
    ("a quarter turn on", |[i, q]| [-q, i], 1.0),
    ("conjugated", |[i, q]| [i, -q], -1.0),
    ("I and Q exchanged", |[i, q]| [q, i], -1.0),
];

/// How many of 2,500 records, steady or not, change between usable and not as they are mirrored; and the most sigmas by which an answer
/// moves that is usable in both. No sample of them comes near the rails.
fn mirrored<R: crate::signal::Kind, const N: usize>(
    arithmetic: Arithmetic,
    of: impl Fn(R::Sample) -> R::Sample + Sync,
    sign: f64,
) -> (u32, f64) {
    let config = Config { arithmetic, ..Config::new(1.0, CODES) };
    let plan = config.plan::<R, N>().unwrap();
    let seen = trials(18, 2500, |rng| {
        let half = N as f64 / 2.0;
        let low = if R::IQ { -half + 3.0 } else { 3.0 };
        let mut line = |share: f64| {
            let bins = rng.random_range(low..half - 3.0);
            Line { bins, amplitude: share, phase: rng.random_range(0.0..TAU) }
        };
        // One tone in four has another beside it, nearby as often as not.
        let (first, mut second) = (line(300.0), line(100.0));
        let (two, near) = (rng.random_range(0..4) == 0, rng.random_range(0..2) == 0);
        if near {
            second.bins = first.bins + rng.random_range(0.3..3.0);
        }
        let lines = if two { vec![first, second] } else { vec![first] };
        let noise = sigma(300.0, rng.random_range(-5.0..50.0));
        let samples = R::record::<N>(rng, &lines, noise);
        let mut pipeline = Pipeline::<R, N>::new(plan);
        let [it, other] = [samples, samples.map(&of)]
            .map(|samples| pipeline.block(Stamp::default(), &samples).tone);
        let [usable, still] = [it, other].map(|tone| tone.verdict.usable() <= Usable::WithinSigma);
        let moved = other.frequency.cycles() - sign * it.frequency.cycles();
        let moved = (moved - moved.round()).abs() / f64::from(it.sigma.max(other.sigma));
        (usable != still, if usable && still { moved } else { 0.0 })
    });
    let changed = seen.iter().filter(|(changed, _)| *changed).count() as u32;
    (changed, seen.iter().map(|&(_, moved)| moved).fold(0.0, f64::max))
}

/// Real and I/Q records of 256 and 1024 samples, by both arithmetics.
#[test]
fn a_mirrored_record_has_the_mirrored_answer() {
    println!("seed 18");
    for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
        let negated = |sample: i16| -sample;
        let mut found = vec![
            ("negated, real", mirrored::<Real, 256>(arithmetic, negated, 1.0)),
            ("negated, real", mirrored::<Real, 1024>(arithmetic, negated, 1.0)),
        ];
        for (name, of, sign) in MIRRORS {
            found.push((name, mirrored::<Iq, 256>(arithmetic, of, sign)));
            found.push((name, mirrored::<Iq, 1024>(arithmetic, of, sign)));
        }
        for (name, (changed, moved)) in found {
            println!(
                "{arithmetic:?}, {name}: {changed} of 2500 change, by {moved:.3} sigma at most"
            );
            assert!(changed == 0 && moved < 0.01, "{name}: {changed}, {moved}");
        }
    }
}

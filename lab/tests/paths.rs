//! Every way from a record to a verdict gives the same one, whatever is wrong with the record.

use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::config::Following;
use picket_dsp::tone::effort::Effort;
use picket_dsp::{
    Codes, Config, Pipeline, Plan, Reach, Segment, Stamp, Tone, Tracker, Usable, Verdict,
};
use picket_host::arithmetic::{Arithmetic, engine, whole};
use picket_host::estimator::Estimator;
use picket_host::simulate::{Kind, Signal, Width, codes, generator};
use picket_lab::impair::{Impairment, Setup};
use picket_lab::sweep::full_amplitude;

const N: usize = 1024;
const CODES: Codes = Codes::signed::<12>();
const SEED: u64 = 21;

/// A plan that follows this many tones, and searches one block in `refresh` whole.
fn following<R: Kind>(most: u8, refresh: u8) -> Plan<R, N> {
    let following = Following { most, refresh, ..Following::default() };
    Config { following, ..config() }.plan().unwrap()
}

/// By the first look, which all ways have: the joint fit is the block's alone.
fn config() -> Config {
    Config { effort: Effort::LOOK, ..Config::new(1.0, CODES) }
}

fn record<R: Kind>(samples: &[num_complex::Complex<f64>]) -> [R::Sample; N] {
    codes::<R>(samples).try_into().unwrap()
}

/// The verdict of the one among these tones that the block's own is; `None` if none is.
fn of<'a>(tone: &Tone, mut tones: impl Iterator<Item = &'a Tone>) -> Option<Verdict> {
    let near = |other: &&Tone| other.frequency.beyond(tone.frequency).abs() * (N as f32) < 1.0;
    tones.find(near).map(|tone| tone.verdict)
}

/// What became of one kind of record on the ways that see less than a block does.
#[derive(Debug, Default)]
struct Seen {
    images: u32,
    /// Locked, and another verdict than the block's.
    locked: u32,
    other_locked: u32,
}

fn every_way<R: Kind>(snr_db: f64, seen: &mut Seen) {
    let plain = config().plan::<R, N>().unwrap();
    let setup = Setup::new(N, snr_db);
    let all = [Impairment::all(), Impairment::signals()].concat();
    for impairment in all.into_iter().filter(Impairment::fits::<R>) {
        for trial in 0..4 {
            let impaired = impairment.record::<R>(&setup, &mut generator(SEED, trial));
            let samples = record::<R>(&impaired.samples);
            let what = format!(
                "{} {} {}, {snr_db} dB, trial {trial}",
                R::NAME,
                impairment.name(),
                impairment.label()
            );
            let mut pipeline = Pipeline::<R, N>::new(plain);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let block = measurement.tone;
            // Of several lines each is judged less the others: what those did to it is gone, and nothing else.
            let agrees = |verdict: Verdict, several: bool| {
                let cured =
                    [Verdict::Moving, Verdict::Unresolved, Verdict::Weak].contains(&block.verdict);
                verdict == block.verdict || several && cured && verdict < block.verdict
            };
            for most in [1, 4] {
                let lines = pipeline.lines(&measurement, most);
                // A burst's pedestal is stronger than its tone, and lines are sought from bin 4 on.
                let Some(verdict) = of(&block, lines.iter().map(|phasor| &phasor.tone)) else {
                    assert!(block.frequency.bins(N).abs() < 4.0, "{what}: {block} is no line");
                    continue;
                };
                assert!(
                    agrees(verdict, lines.len() > 1),
                    "{what}: {block}, {verdict} of {most} lines"
                );
                let mut tracker = Tracker::<R, N>::new(following(most as u8, 0));
                tracker.block(&Stamp::default(), &samples);
                let tracks = tracker.tracks(Segment::Continuous);
                let followed = of(&block, tracks.iter().map(|track| &track.tone));
                if block.verdict.usable() == Usable::No {
                    continue;
                }
                // A line as wide as the spectrum is in no track.
                let Some(verdict) = followed else {
                    assert!(
                        lines.len() > 1 || block.sigma > 0.1,
                        "{what}: {block} is not followed"
                    );
                    continue;
                };
                assert!(
                    agrees(verdict, tracks.len() > 1),
                    "{what}: {block}, {verdict} of {most} tracks"
                );
            }
            // Which order a lone line has is a question of its own.
            let harmonic = pipeline.harmonic(&measurement, 1).map(|harmonic| harmonic.tone);
            if let Some(verdict) = harmonic.and_then(|tone| of(&block, [tone].iter())) {
                let order = verdict == Verdict::Unresolved && block.verdict < verdict;
                assert!(
                    order || agrees(verdict, true),
                    "{what}: {block}, {verdict} of its harmonics"
                );
            }
            seen.images += u32::from(block.verdict == Verdict::Image);
            // A lock sees the bins of its tone, and what moves or halves its power.
            let mut tracker = Tracker::<R, N>::new(following(1, 200));
            let amplitude = 0.6 * full_amplitude(Width::Codes(CODES), snr_db);
            for sequence in 0..4 {
                let tone = Signal::tone(impaired.nominal_bins, amplitude, snr_db);
                let mut rng = generator(SEED + 1, 10 * trial + u64::from(sequence));
                let samples = record::<R>(&tone.record::<R>(N, &mut rng));
                tracker.block(&Stamp { sequence, ..Stamp::default() }, &samples);
            }
            let found = tracker.block(&Stamp { sequence: 4, ..Stamp::default() }, &samples).tone;
            let locked = tracker.is_locked(Segment::Continuous);
            assert!(locked || agrees(found.verdict, false), "{what}: {block}, {found} unlocked");
            if impairment.name() == "iq-dead" {
                assert_eq!(found.verdict, Verdict::Image, "{what}");
            }
            seen.locked += u32::from(locked);
            seen.other_locked += u32::from(locked && found.verdict != block.verdict);
        }
    }
}

#[test]
fn every_way_gives_the_same_verdict() {
    println!("seed {SEED}");
    let mut seen = [Seen::default(), Seen::default()];
    for snr_db in [10.0, 30.0, 50.0] {
        every_way::<Real>(snr_db, &mut seen[0]);
        every_way::<Iq>(snr_db, &mut seen[1]);
    }
    println!("{seen:#?}");
    for Seen { images, locked, other_locked } in seen {
        // A line, hum, noise and an image that lie farther off.
        assert!(100 * other_locked <= 11 * locked, "{other_locked} of {locked}");
        println!("{images} images");
    }
}

/// Where an offset would hide a tone of I/Q, every arithmetic says so, and beside that place none does.
#[test]
fn every_arithmetic_knows_the_offsets_place() {
    for arithmetic in Arithmetic::ALL {
        let mut engine = engine::<Iq>(arithmetic, N, whole::<Iq>(N, CODES).unwrap()).unwrap();
        for bins in [-3.1, -1.8, -1.3, -0.7, 0.6, 1.2, 1.75, 2.6] {
            let record = Signal::tone(bins, 300.0, 30.0).record::<Iq>(N, &mut generator(SEED, 0));
            let estimates =
                engine.measure(&record, &[Estimator::best(true, Reach::Sixteen)], false);
            let near = estimates[0].verdict == Verdict::NearEdge;
            assert_eq!(near, bins.abs() < 1.5, "{arithmetic:?}, {bins} bins: {:?}", estimates[0]);
        }
    }
}

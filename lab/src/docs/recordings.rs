//! The answers of methods on other people's recordings in `host-tests/data`, and their references.

use crate::analyze::{self, Analysis, Answer};
use crate::arithmetic::{Arithmetic, Estimate, engine, whole};
use crate::estimator::parse;
use crate::exact::{Numbers, frequencies};
use crate::recording::{Options, Recording};
use crate::toolchain::workspace;
use num_complex::Complex;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::{Codes, Config, Reach, Real, Verdict};
use std::path::{Path, PathBuf};

/// A figure of some methods on a recording.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The recording, the figure and its unit.
    pub figure: &'static str,
    /// The options of `picket analyze`.
    pub options: &'static str,
    /// What the source says.
    pub reference: &'static str,
    /// Each method's.
    pub rows: Vec<Row>,
}

/// A method's figure, in the figure's unit.
#[derive(Clone, Debug)]
pub struct Row {
    /// The method.
    pub method: &'static str,
    /// What it answered.
    pub value: f64,
    /// What it should have.
    pub reference: f64,
    /// How far off it may be.
    pub tolerance: f64,
}

impl Shown {
    /// Its row of the table.
    pub fn line(&self) -> String {
        let found: Vec<String> =
            self.rows.iter().map(|row| format!("{} {:.2}", row.method, row.value)).collect();
        let Shown { figure, options, reference, .. } = self;
        format!("| {figure} | `{options}` | {reference} | {} |", found.join("; "))
    }
}

/// A recording of `host-tests/data`.
pub fn data(name: &str) -> PathBuf {
    workspace().join("host-tests/data").join(name)
}

fn analysis(rate_hz: Option<f64>, n: usize, methods: &str) -> Result<Analysis, String> {
    Ok(Analysis {
        read: Options { rate_hz, ..Options::default() },
        n: Some(n),
        estimators: Some(parse(methods, Reach::Sixteen)?),
        ..Analysis::new(Codes::signed::<16>(), Arithmetic::Target)
    })
}

fn answers(name: &str, analysis: &Analysis) -> Result<Vec<Answer>, String> {
    let mut answers = Vec::new();
    analyze::run(&data(name), analysis, |answer| answers.push(answer), |_| ())
        .map_err(|error| error.to_string())?;
    Ok(answers)
}

fn of<'a>(answers: &'a [Answer], method: &str) -> impl Iterator<Item = &'a Answer> {
    answers.iter().filter(move |answer| answer.method == method)
}

fn hertz(answer: &Answer) -> f64 {
    answer.frequency_hz.unwrap_or(f64::NAN)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The first sample of each frame of a reference track, and a column's value.
pub fn track(name: &str, column: usize) -> Result<Vec<(f64, f64)>, String> {
    let read = |path: &Path| std::fs::read_to_string(path);
    let text = read(&data(name)).map_err(|error| format!("{name}: {error}"))?;
    let number = |line: &str, column: usize| line.split(',').nth(column)?.parse::<f64>().ok();
    let rows = text.lines().skip(1).map(|line| Some((number(line, 0)?, number(line, column)?)));
    rows.collect::<Option<_>>().ok_or_else(|| format!("{name}: a row without numbers"))
}

/// The figures of all recordings.
///
/// # Errors
/// A recording of `host-tests/data` is not there, or is not what it was.
pub fn all() -> Result<Vec<Shown>, String> {
    Ok([vec![mains()?], vehicles()?, vec![away()?, ice()?], targets()?].concat())
}

/// The samples of a frame of the mains' track.
const FRAME: usize = 3200;

/// The frequency of the mains about a sample: a third of the third harmonic, between the middles of two frames.
pub fn mains_hz(track: &[(f64, f64)], sample: f64) -> Option<f64> {
    let middle = |frame: &(f64, f64)| frame.0 + 0.5 * FRAME as f64;
    track.windows(2).find_map(|pair| {
        let [from, to] = [&pair[0], &pair[1]];
        let share = (sample - middle(from)) / (middle(to) - middle(from));
        (0.0..1.0).contains(&share).then_some(from.1 + (to.1 - from.1) * share)
    })
}

/// The mains in frames of the track's length, which the library does not have: by the methods in 64-bit floats.
fn mains() -> Result<Shown, String> {
    let name = "mains50_092_ref.wav";
    let truth = track("mains50_092_ref_track.csv", 1)?;
    let mut recording =
        Recording::open(&data(name), Options::default()).map_err(|error| error.to_string())?;
    let mut samples = Vec::new();
    recording.fill(&mut samples, usize::MAX).map_err(|error| error.to_string())?;
    let methods = ["grandke", "candan-hann", "least-squares-real"];
    let estimators = parse(&methods.join(","), Reach::Sixteen)?;
    let mut exact =
        frequencies::<Real>(Numbers::F64, FRAME, whole::<Real>(FRAME, Codes::signed::<16>())?)?;
    let bin_hz = recording.rate_hz() / FRAME as f64;
    let mut errors = Vec::new();
    for (frame, (_, truth)) in samples.chunks_exact(FRAME).zip(&truth) {
        let values: Vec<Complex<f64>> = frame.iter().map(|sample| sample.value).collect();
        let found = exact.frequencies(&values, &estimators);
        errors.push(found.into_iter().map(|bins| bins * bin_hz - truth).collect::<Vec<_>>());
    }
    let row = |(index, method): (usize, &'static str)| {
        let of_method = errors.iter().filter_map(|errors| errors.get(index));
        let square = mean(of_method.map(|error| error * error));
        let tolerance = if method == "least-squares-real" { 2.0 } else { 0.3 };
        Row { method, value: 1e3 * square.sqrt(), reference: 0.0, tolerance }
    };
    Ok(Shown {
        figure: "50 Hz mains, rms difference from the track, mHz",
        options: "3200 samples in f64",
        reference: "third harmonic / 3",
        rows: methods.into_iter().enumerate().map(row).collect(),
    })
}

/// The piece in the repository begins so long after its source, whose times are in these tables.
pub const VEHICLES_BEGIN_S: f64 = 8.192;

fn vehicles() -> Result<Vec<Shown>, String> {
    let methods = ["least-squares-real", "grandke"];
    let mut plan = analysis(Some(48000.0), 4096, &methods.join(","))?;
    plan.hop = Some(1024);
    plan.band_hz = Some((300.0, 2500.0));
    let both = answers("cw24_car_moto_towards_i16_48000.bin", &plan)?;
    // The authors' angle has the cosine 0.9930.
    let kmh = SPEED_OF_LIGHT / 24e9 / 2.0 / 0.9930 * 3.6;
    let shown = |(figure, reference, from, to, truth)| {
        let row = |method| {
            let during = |answer: &&Answer| {
                let time_s = answer.time_s.map(|time_s| time_s + VEHICLES_BEGIN_S);
                time_s.is_some_and(|time_s| (from..to).contains(&time_s))
            };
            let speeds = of(&both, method).filter(during).map(|answer| kmh * hertz(answer));
            let value = median(speeds.collect());
            Row { method, value, reference: truth, tolerance: 0.01 * truth }
        };
        Shown {
            figure,
            options: "--rate 48000 --n 4096 --hop 1024 --band 300:2500",
            reference,
            rows: methods.map(row).into(),
        }
    };
    let each: [(_, _, f64, f64, f64); 2] = [
        ("car, median speed, km/h", "47.06 km/h", 10.5, 11.2, 47.06),
        ("motorcycle, median speed, km/h", "33.44 km/h", 16.75, 17.05, 33.44),
    ];
    Ok(each.map(shown).into())
}

/// The first sample of the piece in the repository, in its source.
const AWAY_BEGINS: f64 = 280_576.0;

fn away() -> Result<Shown, String> {
    let truth = track("cw24_car_away_ref_track.csv", 2)?;
    let methods = ["least-squares-real", "grandke"];
    let mut plan = analysis(None, 4096, &methods.join(","))?;
    plan.hop = Some(2048);
    plan.band_hz = Some((300.0, 3600.0));
    let away = answers("cw24_car_away.wav", &plan)?;
    let row = |method| {
        // Where the car is not seen, least squares says weak: 10 of 64 frames.
        let best = of(&away, "least-squares-real");
        let seen = of(&away, method).zip(best).filter(|(_, best)| best.verdict != "weak");
        let seen = seen.map(|(answer, _)| answer);
        let differences = seen.filter_map(|answer| {
            let time_s = answer.time_s?;
            let start = time_s * 44100.0 - 2048.0;
            let (_, track_hz) = truth.iter().find(|frame| (frame.0 - start).abs() < 1.0)?;
            let during = (12.0..15.0).contains(&(time_s + AWAY_BEGINS / 44100.0));
            during.then(|| (hertz(answer) - track_hz).powi(2))
        });
        let differences: Vec<f64> = differences.collect();
        let value = mean(differences.iter().copied()).sqrt();
        // Fewer frames than were seen would flatter it.
        let value = if differences.len() >= 54 { value } else { f64::NAN };
        Row { method, value, reference: 0.0, tolerance: 4.0 }
    };
    Ok(Shown {
        figure: "car going away, 12 to 15 s, frames not weak, rms difference from the track, Hz",
        options: "--n 4096 --hop 2048 --band 300:3600",
        reference: "1648 to 1662 Hz",
        rows: methods.map(row).into(),
    })
}

/// The ice radar's chirps of 40,001 samples, of which 32,768 are taken, each eight of them as one: the beats are of less than a hundredth
/// of the rate.
fn ice() -> Result<Shown, String> {
    const CHIRP: usize = 40_001;
    const BEGIN: usize = 4000;
    const TAKEN: usize = 1 << 15;
    const EACH: usize = 8;
    const N: usize = TAKEN / EACH;
    const RATE_HZ: f64 = 40e3 / EACH as f64;
    let name = "fmcw_apres_5x40001_i16_40000.bin";
    let bytes = std::fs::read(data(name)).map_err(|error| format!("{name}: {error}"))?;
    let samples: Vec<f64> =
        bytes.as_chunks().0.iter().map(|&two| i16::from_le_bytes(two).into()).collect();
    let methods = ["grandke", "candan-hann", "least-squares-real"];
    let estimators = parse(&methods.join(","), Reach::Sixteen)?;
    let band_hz = Some((20.0, 200.0));
    let config = Config { band_hz, ..Config::new(RATE_HZ, Codes::signed::<16>()) };
    let plan = config.terms::<Real>(N).map_err(|error| error.to_string())?;
    let mut engine = engine::<Real>(Arithmetic::Target, N, plan)?;
    let mut found = Vec::new();
    for chirp in samples.chunks_exact(CHIRP) {
        let eight = |eight: &[f64]| Complex::new(eight.iter().sum::<f64>() / EACH as f64, 0.0);
        let record: Vec<_> = chirp[BEGIN..BEGIN + TAKEN].chunks_exact(EACH).map(eight).collect();
        let answers = engine.measure(&record, &estimators, false);
        // Several returns a bin apart: the reference's Blackman window tells more of them apart than Hann's, and a fit of one tone says
        // that there is more than one.
        if answers.last().is_none_or(|answer| answer.verdict != Verdict::Unresolved) {
            return Err("an answer on ice is not unresolved".into());
        }
        found.push(answers);
    }
    let row = |(index, method): (usize, &'static str)| {
        let hz = found.iter().filter_map(|answers: &Vec<Estimate>| answers.get(index));
        let value = mean(hz.map(|answer| answer.bins * RATE_HZ / N as f64));
        let tolerance = if method == "least-squares-real" { 1.3 } else { 0.5 };
        Row { method, value, reference: 55.03, tolerance }
    };
    Ok(Shown {
        figure: "ice radar, eight samples as one, mean of 5 chirps, Hz",
        options: "--rate 5000 --n 4096 --band 20:200",
        reference: "55.03 Hz, sd 0.09",
        rows: methods.into_iter().enumerate().map(row).collect(),
    })
}

/// Two ranges before a 122 GHz radar, in cycles of its 64 I/Q samples.
fn targets() -> Result<Vec<Shown>, String> {
    let methods = ["least-squares", "z-rife", "fesa", "grandke"];
    let mut all = Vec::new();
    for (name, figure, reference, truth) in [
        ("fmcw_sirad122_target30cm.csv", "122 GHz radar, target at 30 cm, cycles", "-7.98", -7.98),
        (
            "fmcw_sirad122_target60cm.csv",
            "122 GHz radar, target at 60 cm, cycles",
            "about -15.0",
            -15.0,
        ),
    ] {
        let mut plan = analysis(Some(64.0), 64, &methods.join(","))?;
        plan.read.iq = true;
        plan.band_hz = Some((-32.0, -4.0));
        let found = answers(name, &plan)?;
        let row = |method| {
            let value = of(&found, method).next().map_or(f64::NAN, hertz);
            // One cycle on a record of 64 with a stronger line nearby: FESA's autocorrelation sees both.
            let tolerance = if method == "fesa" { 1.1 } else { 0.3 };
            Row { method, value, reference: truth, tolerance }
        };
        let options = "--rate 64 --n 64 --iq --band -32:-4";
        all.push(Shown { figure, options, reference, rows: methods.map(row).into() });
    }
    Ok(all)
}

//! What methods answer on the recordings of other people in `host-tests/data`, beside their references.

use crate::analyze::{self, Analysis, Answer};
use crate::arithmetic::Arithmetic;
use crate::estimator::parse;
use crate::recording::Options;
use crate::toolchain::workspace;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::tone::fit::Reach;
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
        ..Analysis::new(Codes::signed::<16>(), Arithmetic::F64)
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
fn track(name: &str, column: usize) -> Result<Vec<(f64, f64)>, String> {
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

fn mains() -> Result<Shown, String> {
    let truth = track("mains50_092_ref_track.csv", 1)?;
    let methods = ["grandke", "candan-hann", "least-squares-real"];
    let answers = answers("mains50_092_ref.wav", &analysis(None, 3200, &methods.join(","))?)?;
    let row = |method| {
        let errors = of(&answers, method).zip(&truth);
        let square = mean(errors.map(|(answer, truth)| (hertz(answer) - truth.1).powi(2)));
        let tolerance = if method == "least-squares-real" { 2.0 } else { 0.3 };
        Row { method, value: 1e3 * square.sqrt(), reference: 0.0, tolerance }
    };
    Ok(Shown {
        figure: "50 Hz mains, rms difference from the track, mHz",
        options: "--n 3200",
        reference: "third harmonic / 3",
        rows: methods.map(row).into(),
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
        // Where the car is not seen, the analyser says weak: 10 of 64 frames.
        let seen = of(&away, method).filter(|answer| answer.verdict != "weak");
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

fn ice() -> Result<Shown, String> {
    let methods = ["grandke", "candan-hann", "least-squares-real"];
    let mut plan = analysis(Some(40000.0), 32000, &methods.join(","))?;
    plan.hop = Some(40001);
    plan.skip = 4000;
    plan.band_hz = Some((20.0, 200.0));
    let ice = answers("fmcw_apres_5x40001_i16_40000.bin", &plan)?;
    // Several returns a bin apart: the reference's Blackman window tells more of them apart than Hann's, and a fit of one tone says that
    // there is more than one.
    if of(&ice, "least-squares-real").any(|answer| answer.verdict != "unresolved") {
        return Err("an answer on ice is not unresolved".into());
    }
    let row = |method| {
        let value = mean(of(&ice, method).map(hertz));
        let tolerance = if method == "least-squares-real" { 1.3 } else { 0.5 };
        Row { method, value, reference: 55.03, tolerance }
    };
    Ok(Shown {
        figure: "ice radar, mean of 5 chirps, Hz",
        options: "--rate 40000 --n 32000 --hop 40001 --skip 4000 --band 20:200",
        reference: "55.03 Hz, sd 0.09",
        rows: methods.map(row).into(),
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

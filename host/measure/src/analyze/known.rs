//! The calibration of a radar by a target at rest at a known range.

use super::Style;
use super::cut::{self, Cut};
use super::radar::Radar;
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::cli::{self, print_line};
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::{views, with_record};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::tone::lines::MOST;
use picket_dsp::{Chirp, ToneWithPhase};
use picket_transform::num_complex::Complex;
use picket_wire::view;
use serde_json::{Value, json};
use std::path::Path;

/// A range with one standard deviation, as a user types it: 1.000 or 1.000:0.0001.
///
/// # Errors
/// It is no positive range, or its standard deviation is negative.
pub fn parse(text: &str) -> Result<(f64, f64), String> {
    let wrong = || "give metres, with one standard deviation behind a colon: 1.000:0.0001".into();
    let (range, sigma) = text.split_once(':').unwrap_or((text, "0"));
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
    number(range).filter(|range| *range > 0.0).zip(number(sigma)).ok_or_else(wrong)
}

/// Measures the strongest tone of each rising ramp of `file`.
///
/// # Errors
/// The recording cannot be read, or none of its tones may be used.
pub fn run(
    file: &Path,
    cut: &Cut,
    n: Option<usize>,
    (radar, told): (&Radar, &Told),
    known: (f64, f64),
) -> Result<(Calibration, usize, Tally), String> {
    let recording = Recording::open(file, cut.read).map_err(super::text)?;
    if !recording.knows_rate() {
        return Err("ranges need the sample rate: add --rate HZ".into());
    }
    let ramps = radar.ramps(&recording, n, told.period_s, cut.read.axes.is_some())?;
    cut::assumed(file, &recording);
    let chirp = radar.chirp(recording.rate_hz(), &ramps, told.guard_s, told.curvature);
    let place = (ramps.hop, cut.skip + ramps.skip as u64);
    with_record!(recording.iq(), ramps.n, R, N => calibrate::<R, N>(recording, (cut, place), &chirp, known))
}

fn calibrate<R: Kind, const N: usize>(
    recording: Recording,
    (cut, (hop, skip)): (&Cut, (usize, u64)),
    chirp: &Chirp,
    (known_m, sigma_m): (f64, f64),
) -> Result<(Calibration, usize, Tally), String> {
    let rate_hz = recording.rate_hz();
    let config =
        Config { band_hz: cut.band_hz, reach: cut.reach, ..Config::new(rate_hz, cut.codes) };
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(super::text)?));
    let ranging = PhaseRanging::new(chirp, rate_hz, N, R::IQ, Calibration::default());
    let ranging = ranging.map_err(super::text)?;
    let mut blocks = recording.blocks(N, hop, skip);
    let segments = chirp.shape.segments();
    let (mut lines, mut tally) = (Vec::<ToneWithPhase>::new(), Tally::default());
    for place in 0.. {
        let Some((_, samples)) = blocks.next_block().map_err(super::text)? else { break };
        if segments.get(place % segments.len().max(1)) != Some(&Segment::Up) {
            continue;
        }
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        tally.add(unfit);
        if unfit.is_none() && !blocks.gap() {
            let measurement = pipeline.block(&Stamp::default(), &record::<R, N>(&values));
            lines.extend(pipeline.lines(&measurement, MOST).first());
        }
    }
    tally.check(cut.codes)?;
    let known = ranging.calibrate_all(&lines, known_m, sigma_m as f32);
    let known = known.ok_or(
        "no ramp has a tone that may be used: is the target the strongest one, and at rest?",
    )?;
    Ok((known, lines.len(), tally))
}

/// Prints a calibration, and keeps it where that is asked for.
///
/// # Errors
/// The file cannot be written.
pub fn tell(
    known: &Calibration,
    (range_m, sigma_m): (f64, f64),
    ramps: usize,
    style: Style,
    save: Option<&Path>,
) -> Result<(), String> {
    let mut all = views::object(&view::Calibration::from(known));
    all.insert("known_m".into(), json!(range_m));
    all.insert("sigma_known_m".into(), json!(sigma_m));
    all.insert("ramps".into(), json!(ramps));
    let all = Value::Object(all).to_string();
    if let Some(path) = save {
        let wrong = |error: std::io::Error| format!("{}: {error}", cli::name(path));
        std::fs::write(path, all.clone() + "\n").map_err(wrong)?;
    }
    match style {
        Style::Text => {
            let Calibration { phase_rad, sigma_phase_rad, offset_m, sigma_offset_m, .. } = known;
            print_line(&format!(
                "by {ramps} ramps: a target at 0 m has the phase {phase_rad:.4} +- {sigma_phase_rad:.4} rad, and its frequency shows \
                 {:.3} +- {:.3} mm",
                1e3 * offset_m,
                1e3 * sigma_offset_m
            ));
            match save {
                Some(path) => print_line(&format!(
                    "saved: --calibration {}",
                    cli::quoted(&path.display().to_string())
                )),
                None => print_line("--save FILE keeps it for --calibration"),
            }
        }
        Style::Json | Style::Csv => print_line(&all),
    }
    Ok(())
}

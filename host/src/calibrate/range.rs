//! The phase at 0 m and the range's offset of a board's radar, from a target at rest at a known distance; with a second distance the slope of
//! its sweep.

use super::{CalibrateError, Heard, Options, Talk, collect};
use crate::analyze::known::{First, Known, Records};
use crate::cli::print_line;
use crate::device::Said;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::config::{Following, Scene};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::tone::Usable;
use picket_dsp::{Chirp, ToneWithPhase, Verdict};
use picket_wire::settings::{Calibration, Mode, Settings};
use serde_json::{Map, Value, json};
use std::time::SystemTime;

/// Measures, prints the result, and saves it on request.
pub fn run(talk: &mut Talk, options: &Options, range: (f64, f64)) -> Result<(), CalibrateError> {
    let first = options.first.as_deref().map(First::read).transpose();
    let first = first.map_err(CalibrateError::Line)?;
    let live = talk.source.listens();
    let own = if live { talk.settings()? } else { None };
    // Phases come with all tones of a block, which a board sends if it is asked for more than one.
    let asked = match own {
        Some((settings, n)) => {
            suits(&settings)?;
            with_phases(&settings).map(|asked| (asked, n))
        }
        None => None,
    };
    if let Some((asked, n)) = asked {
        talk.send(&asked, n, false)?;
    }
    if live {
        talk.orders.renew(&mut talk.source);
    }
    let measured = measure(talk, options, range, first.as_ref());
    let back = own.filter(|_| asked.is_some() && !(options.save && measured.is_ok()));
    if let Some((settings, n)) = back {
        talk.send(&settings, n, false)?;
    }
    let (heard, known) = measured?;
    let (settings, n) = own.unwrap_or((heard.settings, heard.n));
    let after = corrected(&settings, &known, range, first.is_some());
    let mut all = known.json();
    let Calibration { range_offset_m, range_slope, .. } = after.calibration;
    all.insert("range_offset_m".into(), json!(range_offset_m));
    all.insert("range_slope".into(), json!(range_slope));
    beside(&mut all, options, live);
    if let Some(file) = &options.to {
        let text = format!("{}\n", Value::Object(all.clone()));
        options.output.write(file, text.as_bytes()).map_err(CalibrateError::Line)?;
    }
    if !options.json {
        known.lines().iter().for_each(|line| print_line(line));
        let before = settings.calibration;
        print_line(&format!(
            "range_offset_m {} before, {range_offset_m:.6} now; range_slope {} before, {range_slope:.6} now",
            before.range_offset_m, before.range_slope
        ));
    }
    if options.save {
        talk.send(&after, n, true)?;
    }
    if options.json {
        all.insert("saved".into(), json!(options.save));
        print_line(&Value::Object(all).to_string());
        return Ok(());
    }
    match (&options.to, options.save) {
        (Some(file), _) => {
            let name = crate::cli::quoted(&file.display().to_string());
            print_line(&format!("saved: analyze --calibration {name}"));
        }
        (None, _) => print_line("--to FILE keeps it, with the phase, for analyze --calibration"),
    }
    match options.save {
        true => print_line("set and saved"),
        false if live => {
            print_line("--save sets the offset and the slope, and keeps them over a reset")
        }
        false => {}
    }
    Ok(())
}

/// Listens, and calibrates.
fn measure(
    talk: &mut Talk,
    options: &Options,
    range: (f64, f64),
    first: Option<&First>,
) -> Result<(Heard, Known), CalibrateError> {
    let (mut ramps, mut rate_hz, mut records) = (Vec::<(f64, ToneWithPhase)>::new(), 0.0, 0);
    let heard = collect(talk, options, &suits, &mut |said| match said {
        None => (ramps, records) = (Vec::new(), 0),
        Some(Said::Telemetry(record)) => {
            rate_hz = record.measurement.tone.rate_hz;
            records += 1;
        }
        Some(Said::ChirpFrame(frame)) => {
            rate_hz = frame.rate_hz;
            records += 1;
        }
        Some(Said::Lines(lines)) if lines.segment == Segment::Up => {
            ramps.extend(lines.tones.first().map(|line| (rate_hz, *line)));
        }
        Some(Said::Found(found)) if found.place == 0 => ramps.push((rate_hz, found.found.line)),
        Some(_) => {}
    })?;
    let Heard { settings, n, seconds, .. } = heard;
    // A record that was on its way is of the settings before.
    ramps.retain(|(rate_hz, _)| heard.is_of_it(*rate_hz));
    let ramps: Vec<ToneWithPhase> = ramps.into_iter().map(|(_, line)| line).collect();
    if ramps.is_empty() {
        let block = n as f64 / settings.config.rate_hz;
        return Err(match records {
            0 => CalibrateError::Silent { seconds, block },
            _ if with_phases(&settings).is_some() => CalibrateError::NoPhase,
            ramps => CalibrateError::Unclear { ramps, verdict: Verdict::Unresolved },
        });
    }
    let usable = |line: &ToneWithPhase| line.tone.verdict.usable() <= Usable::WithinSigma;
    if !ramps.iter().any(usable) {
        let count = |verdict| ramps.iter().filter(|line| line.tone.verdict == verdict).count();
        let most = ramps.iter().map(|line| line.tone.verdict);
        let verdict = most.max_by_key(|&verdict| count(verdict)).unwrap_or_default();
        return Err(CalibrateError::Unclear { ramps: ramps.len(), verdict });
    }
    let Scene::Chirp(chirp) = &settings.config.scene else { return Err(CalibrateError::NoChirp) };
    let radar = Records { chirp, rate_hz: settings.config.rate_hz, n, iq: settings.iq };
    let known = Known::of(&radar, &ramps, range, first).map_err(CalibrateError::Line)?;
    Ok((heard, known))
}

/// Whether a board with these settings measures a range.
fn suits(settings: &Settings) -> Result<(), CalibrateError> {
    match settings.config.scene {
        Scene::Chirp(Chirp { .. }) if settings.start => Ok(()),
        Scene::Chirp(_) => Err(CalibrateError::Stopped),
        _ => Err(CalibrateError::NoChirp),
    }
}

/// The settings by which a board tells the phases of its tones, where it does not yet. Frames always have them.
fn with_phases(settings: &Settings) -> Option<Settings> {
    let lacks = settings.mode == Mode::Blocks && settings.further() == 0;
    let following = Following { most: 0, ..settings.config.following };
    let config = picket_dsp::Config { following, ..settings.config };
    lacks.then_some(Settings { most: 2, config, ..*settings })
}

/// The settings with what the target tells.
fn corrected(settings: &Settings, known: &Known, (known_m, _): (f64, f64), two: bool) -> Settings {
    let found = known.calibration;
    let offset_m = f64::from(found.offset_m);
    let slope = match two {
        true => 1.0 / (1.0 + 1e-6 * f64::from(found.slope_ppm)),
        false => f64::from(settings.calibration.range_slope),
    };
    // By two distances the offset is one of ranges that the slope has corrected.
    let offset = if two { -offset_m } else { known_m - slope * (known_m + offset_m) };
    let calibration = Calibration {
        range_offset_m: offset as f32,
        range_slope: slope as f32,
        ..settings.calibration
    };
    let uncertainty = settings.uncertainty.map(|before| Uncertainty {
        range_offset_m: found.sigma_offset_m,
        phase_rad: found.sigma_phase_rad,
        slope_ppm: if two { found.sigma_slope_ppm } else { before.slope_ppm },
        ..before
    });
    Settings { calibration, uncertainty, ..*settings }
}

/// When and how warm it was made: of a recording nobody knows when.
fn beside(all: &mut Map<String, Value>, options: &Options, live: bool) {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    if let Ok(since) = since
        && live
    {
        all.insert("unix_s".into(), json!(since.as_secs()));
    }
    if let Some(celsius) = options.celsius {
        all.insert("celsius".into(), json!(celsius));
    }
}

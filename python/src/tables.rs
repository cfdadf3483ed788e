//! Rows of numbers, one for each answer. Their columns are those of `picket_dsp/_tables.py`.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use picket_dsp::acquire::sample::Segment;
use picket_dsp::fixed::types::I32F32;
use picket_dsp::pipeline::Outcome;
use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Candidate};
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::track::{State, Track};
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::{Measurement, Tone, Validation};
use picket_wire::layout::{Field, Form};
use picket_wire::view::{self, View};
use pyo3::prelude::*;

/// Rows of this many columns as an array.
pub fn table<'py, const COLUMNS: usize>(
    py: Python<'py>,
    rows: Vec<[f64; COLUMNS]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = (rows.len(), COLUMNS);
    let array = Array2::from_shape_vec(shape, rows.into_flattened()).map_err(crate::wrong)?;
    Ok(array.into_pyarray(py))
}

/// The numbers of a tone, as [`columns`] has their names.
pub type ToneRow = [f64; TONE];
pub const TONE: usize = view::Tone::COUNT - 1;

pub fn tone(tone: &Tone) -> ToneRow {
    let (mut row, mut next) = ([f64::NAN; TONE], 0);
    view::Tone::from_tone(tone, 0).each("", &mut |name, value| {
        if column(name).is_some() {
            row[next] = if name == "snr" { tone.snr_db().into() } else { value };
            next += 1;
        }
    });
    row
}

/// The column of a tone's number: a ratio is shown in dB, and `clipped` belongs to a block.
fn column(name: &'static str) -> Option<&'static str> {
    match name {
        "clipped" => None,
        "snr" => Some("snr_db"),
        name => Some(name),
    }
}

/// The names of a tone's numbers.
#[pyfunction]
pub fn columns() -> Vec<&'static str> {
    let mut names = Vec::new();
    view::Tone::default().each("", &mut |name, _| names.extend(column(name)));
    names
}

/// The names of the numbers from 0 on in a list of the protocol: verdict, segment, state, validation, ambiguity.
#[pyfunction]
pub fn names(list: &str) -> PyResult<Vec<&'static str>> {
    let forms = [Segment::FORM, State::FORM, Validation::FORM, Ambiguity::FORM];
    let of = forms.into_iter().find_map(|form| named(form, list));
    let of = of.ok_or_else(|| crate::wrong(format!("no list of names {list}")))?;
    Ok((0..=u8::MAX).map_while(of).collect())
}

/// The names of this list, where a form has them.
fn named(form: Form, list: &str) -> Option<fn(u8) -> Option<&'static str>> {
    match form {
        Form::Name(name, of) => (name == list).then_some(of),
        Form::Structure(structure) => {
            structure.fields.iter().find_map(|field| named(field.form, list))
        }
        _ => None,
    }
}

/// Phase and its sigma, radians.
pub fn phase(phasor: Option<&ToneWithPhase>) -> [f64; 2] {
    phasor.map_or([f64::NAN; 2], |phasor| [phasor.phase.into(), phasor.sigma_phase.into()])
}

/// Verdict, ambiguity, range, velocity, their sigmas, then range, velocity and odds of each candidate; NaN for what is not there.
pub type TargetRow = [f64; TARGET];
pub const TARGET: usize = 6 + 3 * CANDIDATES;

pub fn target(target: &Target) -> TargetRow {
    let mut row = [f64::NAN; TARGET];
    let head = [
        f64::from(target.verdict as u8),
        target.ambiguity.number().into(),
        target.range.to_num(),
        target.velocity.map_or(f64::NAN, I32F32::to_num),
        target.sigma_range.into(),
        target.sigma_velocity.into(),
    ];
    row[..6].copy_from_slice(&head);
    for (place, candidate) in row[6..].chunks_exact_mut(3).zip(target.ambiguity.candidates()) {
        let Candidate { range, velocity, odds } = *candidate;
        place.copy_from_slice(&[range.to_num(), velocity.to_num(), odds.into()]);
    }
    row
}

pub fn outcome(outcome: &Outcome) -> TargetRow {
    match outcome {
        Outcome::None => [f64::NAN; TARGET],
        Outcome::Velocity(seen) => {
            let mut row = [f64::NAN; TARGET];
            (row[0], row[1]) = (f64::from(seen.verdict as u8), 0.0);
            (row[3], row[5]) = (seen.velocity.to_num(), f64::from(seen.sigma));
            row
        }
        Outcome::Target(seen) => target(seen),
    }
}

/// The first sample's number, whether samples are missing before it, the segment, samples at a rail, the tone, phase and its sigma,
/// the outcome.
pub type BlockRow = [f64; BLOCK];
pub const BLOCK: usize = 4 + TONE + 2 + TARGET;

pub fn block(measurement: &Measurement, phasor: Option<&ToneWithPhase>) -> BlockRow {
    let Measurement { stamp, clipped, tone: seen, result } = measurement;
    let head = [
        stamp.clock as f64,
        f64::from(u8::from(stamp.gap)),
        f64::from(stamp.segment as u8),
        (*clipped).into(),
    ];
    joined([&head, &tone(seen), &phase(phasor), &outcome(result)])
}

/// The block's first sample, number, state, age, misses, rate in hertz per block, and the tone.
pub type TrackRow = [f64; 6 + TONE];

pub fn track(clock: u64, track: &Track, rate_hz: f64) -> TrackRow {
    let seen = Tone { rate_hz, ..track.tone };
    let head = [
        clock as f64,
        track.number.into(),
        f64::from(track.state as u8),
        track.age.into(),
        track.misses.into(),
        f64::from(track.rate()) * rate_hz,
    ];
    joined([&head, &tone(&seen)])
}

/// Columns side by side; they must be as many as the row has.
pub fn joined<const PARTS: usize, const COLUMNS: usize>(parts: [&[f64]; PARTS]) -> [f64; COLUMNS] {
    let mut row = [f64::NAN; COLUMNS];
    assert_eq!(parts.iter().map(|part| part.len()).sum::<usize>(), COLUMNS, "columns of a row");
    row.iter_mut().zip(parts.into_iter().flatten()).for_each(|(place, &value)| *place = value);
    row
}

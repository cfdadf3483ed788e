//! Records of a scene from its physics, with the truth.

use crate::tables::table;
use crate::terms::{self, SceneTerms};
use crate::wrong;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use picket_dsp::Scene;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_simulator::scene::{self, Converter, Noise, Receiver, Source, Waveform};
use picket_simulator::{Run, Value};
use pyo3::prelude::*;

/// Words, and rows of the truth.
type Simulated<'py> = (Bound<'py, PyArray1<i16>>, Bound<'py, PyArray2<f64>>);

/// The words of this many records of a run, I and Q in turn.
fn words(run: &mut Run, records: usize, n: usize) -> Vec<i16> {
    let channels = if run.scene().receiver.iq { 2 } else { 1 };
    let mut words = Vec::with_capacity(records * n * channels);
    for index in 0..records {
        words.extend(run.record(index, n).iter().flat_map(|code| code.iter().take(channels)));
    }
    words
}

/// The records that fit into a scene, of `n` samples where it does not say how many: its words, whether they are of I and Q, their
/// number in a record, and a row for each record and source, and for each particle: record, source, time, frequency, amplitude, range
/// and velocity, NaN where there is none.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn whole<'py>(
    py: Python<'py>,
    json: &str,
    n: usize,
    seed: Option<u64>,
) -> PyResult<(Bound<'py, PyArray1<i16>>, bool, usize, Bound<'py, PyArray2<f64>>)> {
    let mut scene = picket_simulator::Scene::from_json(json).map_err(wrong)?;
    scene.seed = seed.unwrap_or(scene.seed);
    let gated = scene.waveform.as_ref().filter(|waveform| waveform.guard_s.is_some());
    let n = gated.map_or(n, |waveform| waveform.samples);
    let work = || {
        let mut run = scene.run(0)?;
        let records = scene.records(n);
        if records == 0 {
            return Err(format!("no record of {n} samples fits into the scene: give more seconds"));
        }
        let codes = words(&mut run, records, n);
        let mut truth = Vec::new();
        for index in 0..records {
            let start_s = scene.start_s(index, n);
            let end_s = start_s + n as f64 / scene.rate_hz;
            for (number, source) in scene.sources.iter().enumerate() {
                let place = [index as f64, number as f64];
                let mut row = |row: [f64; 5]| {
                    let [time, hertz, amplitude, range, velocity] = row;
                    truth.push([place[0], place[1], time, hertz, amplitude, range, velocity]);
                };
                if let Source::Particles(of) = source {
                    let inside = |time_s: f64| (start_s..end_s).contains(&time_s);
                    for passed in run.particles(number).iter().filter(|of| inside(of.middle_s)) {
                        let hertz = passed.velocity_mps / of.fringe_m + of.shift_hz;
                        let amplitude = passed.amplitude * run.gain(hertz);
                        row([passed.middle_s, hertz, amplitude, f64::NAN, passed.velocity_mps]);
                    }
                    continue;
                }
                let told = run.truth(number, start_s, n);
                let amplitude = told.amplitude * run.gain(told.frequency_hz);
                let [range, velocity] =
                    [told.range_m, told.velocity_mps].map(|x| x.unwrap_or(f64::NAN));
                row([told.time_s, told.frequency_hz, amplitude, range, velocity]);
            }
        }
        Ok((codes, truth))
    };
    let (codes, truth) = py.detach(work).map_err(wrong)?;
    Ok((codes.into_pyarray(py), scene.receiver.iq, n, table(py, truth)?))
}

/// What a sensor of the library sends, and the cosine of the angle at which its targets move.
fn waveform(scene: &Scene, n: usize, period_s: f64) -> Option<(Waveform, f64)> {
    Some(match *scene {
        Scene::Chirp(chirp) => (Waveform::from_chirp(&chirp, n, period_s), 1.0),
        Scene::Doppler { wavelength_m, angle_rad, .. } => {
            let carrier_hz = SPEED_OF_LIGHT / wavelength_m;
            (Waveform { carrier_hz, ..Waveform::default() }, angle_rad.cos())
        }
        _ => return None,
    })
}

/// Words of this many blocks, and a row for each block and target: its block, its target, its beat in hertz, its range at the middle of
/// the record.
#[pyfunction]
#[pyo3(signature = (scene, n, rate_hz, blocks, targets, noise, iq, low, high, seed, period_s))]
#[allow(clippy::too_many_arguments)]
pub fn simulate<'py>(
    py: Python<'py>,
    scene: SceneTerms,
    n: usize,
    rate_hz: f64,
    blocks: u32,
    targets: Vec<(f64, f64, f64)>,
    noise: f64,
    iq: bool,
    low: i16,
    high: i16,
    seed: u64,
    period_s: f64,
) -> PyResult<Simulated<'py>> {
    terms::codes(low, high).map_err(wrong)?;
    let mixing = terms::mixing(scene.8).map_err(wrong)?.into();
    let sensor = terms::scene(&scene).map_err(wrong)?;
    let (waveform, along) =
        waveform(&sensor, n, period_s).ok_or_else(|| wrong("give a scene: Doppler or Chirp"))?;
    let segments = match &sensor {
        Scene::Chirp(chirp) => chirp.shape.segments().len(),
        _ => 1,
    };
    let records = blocks as usize;
    let source = |&(range_m, velocity_mps, amplitude): &(f64, f64, f64)| {
        Source::Target(scene::Target {
            range_m: range_m.into(),
            velocity_mps: (along * velocity_mps).into(),
            amplitude: Some(amplitude.into()),
            phase_turns: Value::Fixed(0.0),
            ..scene::Target::default()
        })
    };
    let scene = picket_simulator::Scene {
        seed,
        rate_hz,
        // That of the samples: pauses are no part of them.
        seconds: (records * n) as f64 / rate_hz,
        waveform: Some(waveform),
        sources: targets.iter().map(source).collect(),
        receiver: Receiver {
            iq,
            mixing,
            noise: Noise { rms: Some(noise.into()), ..Noise::default() },
            ..Receiver::default()
        },
        converter: Converter { rails: Some([low, high]), ..Converter::default() },
        ..picket_simulator::Scene::default()
    };
    let work = || {
        let mut run = scene.run(0)?;
        let codes = words(&mut run, records, n);
        let mut truth = Vec::with_capacity(records * targets.len());
        for block in 0..records {
            let start_s = scene.start_s(block, n);
            // The middle of the waveform's repetition, to which a chirp's range refers.
            let first = block / segments * segments;
            let ends = [first, first + segments - 1].map(|index| scene.start_s(index, n));
            let middle_s =
                f64::midpoint(ends[0], ends[1]) + 0.5 * n.saturating_sub(1) as f64 / rate_hz;
            for (index, &(range_m, velocity_mps, _)) in targets.iter().enumerate() {
                let beat_hz = run.truth(index, start_s, n).frequency_hz;
                let range_m = range_m - along * velocity_mps * middle_s;
                truth.push([block as f64, index as f64, beat_hz, range_m]);
            }
        }
        Ok::<_, String>((codes, truth))
    };
    let (codes, truth) = py.detach(work).map_err(wrong)?;
    Ok((codes.into_pyarray(py), table(py, truth)?))
}

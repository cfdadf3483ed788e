//! Records of a radar, a lidar or a velocimeter from its physics, with the truth beside them.

use crate::tables::table;
use crate::terms::{self, SceneTerms};
use crate::wrong;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use picket_dsp::Scene;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_simulator::{Receiver, Sensor, Target};
use pyo3::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Words of so many blocks, and a row for each block and target: its block, its target, its beat in cycles per sample, its range at
/// the middle of the record.
#[pyfunction]
#[pyo3(signature = (scene, n, rate_hz, blocks, targets, noise, iq, low, high, seed, period_s))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
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
) -> PyResult<(Bound<'py, PyArray1<i16>>, Bound<'py, PyArray2<f64>>)> {
    let codes = terms::codes(low, high).map_err(wrong)?;
    let mixing = terms::mixing(scene.8).map_err(wrong)?;
    let receiver = Receiver { noise, codes, ..Receiver::ideal(rate_hz, iq, mixing) };
    let (along, sensor) = match terms::scene(&scene).map_err(wrong)? {
        Scene::Chirp(chirp) => (None, Sensor::chirp(&chirp, receiver, n, period_s)),
        Scene::Doppler { wavelength_m, angle_rad, .. } => {
            // A target moves at this angle to the beam.
            let sensor = Sensor::continuous(SPEED_OF_LIGHT / wavelength_m, receiver, n);
            (Some(angle_rad.cos()), sensor)
        }
        _ => return Err(wrong("give a scene: Doppler or Chirp")),
    };
    let work = || {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
        let (mut words, mut truth) = (Vec::new(), Vec::new());
        let segments = sensor.segments() as u32;
        for block in 0..blocks {
            let lap = if along.is_none() { u64::from(block / segments) } else { 0 };
            let at = (lap, (block % segments) as usize);
            // A continuous wave has one record: the targets move on instead.
            let since_s = along.map_or(0.0, |_| f64::from(block) * n as f64 / rate_hz);
            let here: Vec<Target> = targets
                .iter()
                .map(|&(range_m, velocity_mps, amplitude)| {
                    let velocity_mps = velocity_mps * along.unwrap_or(1.0);
                    let range_m = range_m - velocity_mps * since_s;
                    Target::moving(amplitude, range_m, velocity_mps)
                })
                .collect();
            for [i, q] in sensor.record(&here, at, &mut normal) {
                words.push(i);
                words.extend(iq.then_some(q));
            }
            for (index, target) in here.iter().enumerate() {
                let begin_s = if lap == 0 { 0.0 } else { lap as f64 * sensor.waveform.period_s() };
                let middle_s = begin_s + sensor.middle_s();
                truth.push([
                    f64::from(block),
                    index as f64,
                    sensor.beat(target, at) * rate_hz,
                    target.range_m(middle_s),
                ]);
            }
        }
        (words, truth)
    };
    let (words, truth) = py.detach(work);
    Ok((words.into_pyarray(py), table(py, truth)?))
}

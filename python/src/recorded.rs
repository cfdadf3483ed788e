//! The contents of files: samples, and a board's telemetry.

use crate::tables::{self, joined, table};
use crate::terms;
use crate::wrong;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use picket_recording::{Format, Options, Recording, Sample};
use picket_wire::frame::{Kind, Reader};
use picket_wire::telemetry::Telemetry;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The words of a recording, I and Q in turn, its rate in hertz, whether it is I/Q, and the numbers of the samples that are missing.
#[pyfunction]
#[pyo3(signature = (path, low, high, format, rate_hz, iq, scale, channel, decimal_comma))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn recording<'py>(
    py: Python<'py>,
    path: PathBuf,
    low: i16,
    high: i16,
    format: Option<&str>,
    rate_hz: Option<f64>,
    iq: bool,
    scale: Option<f64>,
    channel: Option<(usize, Option<usize>)>,
    decimal_comma: bool,
) -> PyResult<(Bound<'py, PyArray1<i16>>, Option<f64>, bool, Vec<u64>)> {
    let codes = terms::codes(low, high).map_err(wrong)?;
    if scale.is_some_and(|scale| !(scale > 0.0 && scale.is_finite())) {
        return Err(wrong("scale must be a positive number"));
    }
    let format = format.map(named).transpose().map_err(wrong)?;
    let options =
        Options { format, rate_hz, iq, scale, channel, decimal_comma, ..Options::default() };
    let read = || -> Result<_, String> {
        let text = |error: picket_recording::RecordingError| error.to_string();
        let mut recording = Recording::open(&path, options).map_err(text)?;
        let rate_hz = recording.knows_rate().then(|| recording.rate_hz());
        let iq = recording.iq();
        let (mut words, mut missing, mut sample) = (Vec::new(), Vec::new(), Vec::with_capacity(1));
        let (low, high) = codes.rails();
        for number in 0u64.. {
            let missed = recording.missed();
            sample.clear();
            recording.fill(&mut sample, 1).map_err(text)?;
            let Some([re, im]) = sample.first().map(Sample::code) else { break };
            missing.extend((recording.missed() > missed).then_some(number));
            if !(low..=high).contains(&re) || iq && !(low..=high).contains(&im) {
                return Err(format!("samples exceed {low}..{high}: give codes=16, or scale"));
            }
            words.push(re);
            words.extend(iq.then_some(im));
        }
        if words.is_empty() {
            return Err(format!("{} holds no samples", path.display()));
        }
        Ok((words, rate_hz, iq, missing))
    };
    let (words, rate_hz, iq, missing) = py.detach(read).map_err(wrong)?;
    Ok((words.into_pyarray(py), rate_hz, iq, missing))
}

/// The formats by their names, as the command line has them.
const FORMATS: [(&str, Format); 21] = [
    ("wav", Format::Wav),
    ("flac", Format::Flac),
    ("i8", Format::I8),
    ("u8", Format::U8),
    ("i16", Format::I16),
    ("u16", Format::U16),
    ("i32", Format::I32),
    ("f32", Format::F32),
    ("f64", Format::F64),
    ("cs8", Format::Cs8),
    ("cu8", Format::Cu8),
    ("cs16", Format::Cs16),
    ("iiqq", Format::Iiqq),
    ("cf32", Format::Cf32),
    ("cf64", Format::Cf64),
    ("npy", Format::Npy),
    ("npz", Format::Npz),
    ("mat", Format::Mat),
    ("hdf5", Format::Hdf5),
    ("sigmf", Format::Sigmf),
    ("csv", Format::Csv),
];

/// The format of this name.
fn named(name: &str) -> Result<Format, String> {
    let known = FORMATS.iter().find(|(known, _)| *known == name).map(|(_, format)| *format);
    known.ok_or_else(|| {
        let names: Vec<&str> = FORMATS.iter().map(|(name, _)| *name).collect();
        format!("there is no format {name}: {}", names.join(", "))
    })
}

/// The measurements in a board's bytes: sequence, blocks lost, faults, and the columns of a block. Beside them the number of frames
/// that were damaged.
#[pyfunction]
pub fn telemetry<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<(Bound<'py, PyArray2<f64>>, u64)> {
    let (mut rows, mut bad): (Vec<[f64; 3 + tables::BLOCK]>, u64) = (Vec::new(), 0);
    let mut reader = Reader::default();
    for &byte in bytes {
        match reader.push(byte) {
            None => {}
            Some(Ok(frame)) if frame.kind == Kind::Telemetry => match Telemetry::from_frame(&frame)
            {
                Ok(Telemetry { measurement, health, .. }) => {
                    let head = [
                        f64::from(measurement.stamp.sequence),
                        health.lost.into(),
                        health.faults.into(),
                    ];
                    rows.push(joined([&head, &tables::block(&measurement, None)]));
                }
                Err(_) => bad += 1,
            },
            Some(Ok(_)) => {}
            Some(Err(_)) => bad += 1,
        }
    }
    Ok((table(py, rows)?, bad))
}

//! Picket for Python: numbers in, rows of numbers out. `picket_dsp/__init__.py` gives them their names and types.

mod blocks;
mod bursts;
mod explain;
mod frames;
mod native;
mod phases;
mod recorded;
mod simulated;
mod sums;
mod tables;
mod terms;
mod tracks;
mod views;

use picket_dsp::{Method, Verdict};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// An error of a value, in one line.
pub(crate) fn wrong(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A verdict's number, its name, the number and the name of what it may be used for, and its sentence.
type VerdictRow = (u8, &'static str, u8, &'static str, &'static str);

/// Every verdict, from best to worst.
#[pyfunction]
fn verdicts() -> Vec<VerdictRow> {
    let row = |verdict: &Verdict| {
        let usable = verdict.usable();
        (*verdict as u8, verdict.name(), usable as u8, usable.name(), verdict.reason())
    };
    Verdict::ALL.iter().map(row).collect()
}

/// Every method: its name, the records that it is right for ("real", "iq" or "both"), and its sentence.
#[pyfunction]
fn methods() -> Vec<(&'static str, &'static str, &'static str)> {
    let row = |method: &Method| {
        let about = method.about();
        (about.name, about.records.name(), about.doc)
    };
    Method::ALL.iter().map(row).collect()
}

/// The names in a set of verdicts, the most severe first.
#[pyfunction]
fn verdicts_in(bits: u8) -> Vec<&'static str> {
    picket_dsp::Verdicts::from_bits(bits).iter().map(Verdict::name).collect()
}

#[pymodule]
fn _picket(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<native::Native>()?;
    module.add_function(wrap_pyfunction!(verdicts, module)?)?;
    module.add_function(wrap_pyfunction!(verdicts_in, module)?)?;
    module.add_function(wrap_pyfunction!(methods, module)?)?;
    module.add_function(wrap_pyfunction!(tables::columns, module)?)?;
    module.add_function(wrap_pyfunction!(tables::names, module)?)?;
    module.add_function(wrap_pyfunction!(views::view_columns, module)?)?;
    module.add_function(wrap_pyfunction!(views::budgets, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::recording, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::telemetry, module)?)?;
    module.add_function(wrap_pyfunction!(simulated::whole, module)?)?;
    module.add_function(wrap_pyfunction!(simulated::simulate, module)?)
}

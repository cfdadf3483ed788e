//! Rows whose columns are those of a view: `picket_wire::view` describes them.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_wire::view::{self, View};
use pyo3::prelude::*;

/// A row of numbers.
pub type Row = Vec<f64>;

/// Numbers with their names, as Python gives them.
pub type Told = Vec<(String, f64)>;

/// Appends a view's columns.
pub fn put<V: View>(row: &mut Row, view: &V) {
    view::columns(view, &mut |column| {
        row.push(if column.name == "snr" { 10.0 * column.value.log10() } else { column.value });
    });
}

/// Rows as an array of so many columns.
pub fn table(py: Python<'_>, rows: Vec<Row>, columns: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shape = (rows.len(), columns);
    let array = Array2::from_shape_vec(shape, rows.concat()).map_err(crate::wrong)?;
    Ok(array.into_pyarray(py))
}

fn of<V: View>() -> Vec<String> {
    let mut names = Vec::new();
    view::columns(&V::default(), &mut |column| {
        names.push(if column.name == "snr" { "snr_db".into() } else { column.name.to_owned() });
    });
    names
}

/// The columns of a view by its name.
pub fn columns(name: &str) -> Option<Vec<String>> {
    Some(match name {
        "frame_target" => of::<view::FrameTarget>(),
        "target" => of::<view::Target>(),
        "phase_range" => of::<view::PhaseRange>(),
        "displacement" => of::<view::Displacement>(),
        "budget" => of::<view::Budget>(),
        "uncertainty" => of::<view::Uncertainty>(),
        "calibration" => of::<view::Calibration>(),
        _ => return None,
    })
}

/// The names of a view's numbers.
#[pyfunction]
pub fn view_columns(name: &str) -> PyResult<Vec<String>> {
    columns(name).ok_or_else(|| crate::wrong(format!("no view {name}")))
}

/// A view of what Python gives.
pub fn told<V: View>(numbers: &Told) -> PyResult<V> {
    let mut view = V::default();
    for (name, value) in numbers {
        if !view.set("", name, *value) {
            return Err(crate::wrong(format!("there is no {name}")));
        }
    }
    Ok(view)
}

/// The standard deviations of what is not known.
pub fn uncertainty(numbers: &Told) -> PyResult<Uncertainty> {
    let known = Uncertainty::from(&told::<view::Uncertainty>(numbers)?);
    match known.is_valid() {
        true => Ok(known),
        false => Err(crate::wrong("uncertainty: each standard deviation is finite, 0 or more")),
    }
}

/// A budget for each row of range, velocity, their sigmas, and of a range by phase half a wavelength (NaN elsewhere).
#[pyfunction]
pub fn budgets(
    py: Python<'_>,
    rows: Vec<[f64; 5]>,
    known: Told,
    angle_rad: f32,
    blocks: u32,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    use picket_dsp::Target;
    use picket_dsp::fixed::types::I32F32;
    let known = uncertainty(&known)?;
    let fixed = |x: f64| if x.is_finite() { I32F32::checked_from_num(x) } else { None };
    let budget = |&[range, velocity, sigma_range, sigma_velocity, half_wave]: &[f64; 5]| {
        let target = Target {
            range: fixed(range).unwrap_or_default(),
            velocity: fixed(velocity),
            sigma_range: sigma_range as f32,
            sigma_velocity: sigma_velocity as f32,
            ..Target::default()
        };
        let all = match half_wave.is_nan() {
            true => known.of_target(&target, angle_rad),
            false => known.of_range_by_phase(&target, 2.0 * half_wave as f32),
        };
        let mut row = Row::new();
        put(&mut row, &view::Budget::from_budget(&all.of_mean(blocks)));
        row
    };
    let columns = of::<view::Budget>().len();
    table(py, rows.iter().map(budget).collect(), columns)
}

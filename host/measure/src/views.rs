//! Answers and settings as JSON, by their one description (`picket_wire::view`).

use picket_dsp::solve::candidates::Ambiguity;
use picket_dsp::solve::candidates::Candidates;
use picket_dsp::{Verdict, Verdicts};
use picket_wire::view::{Column, View, columns};
use serde_json::{Map, Value, json};

/// A view as a JSON object: its columns, and of a list's elements an object each. Numbers that are none are left out.
pub fn object<V: View>(view: &V) -> Map<String, Value> {
    let mut object = Map::new();
    columns(view, &mut |Column { name, element, value }| match element {
        _ if !value.is_finite() => {}
        Some((list, number, field)) => {
            let all = object.entry(list).or_insert_with(|| json!([]));
            let Some(all) = all.as_array_mut() else { return };
            if all.len() <= number {
                all.push(json!({}));
            }
            if let Some(of) = all.last_mut() {
                of[field] = json!(value);
            }
        }
        None => {
            let (name, shown) = shown(name, value);
            if shown != json!([]) {
                object.insert(name, shown);
            }
        }
    });
    object
}

/// A number as JSON shows it.
fn shown(name: &str, value: f64) -> (String, Value) {
    let of = match name {
        "verdict" | "tone_verdict" => json!(Verdict::from_u8(value as u8).map(Verdict::name)),
        "also" => {
            let also = Verdicts::from_bits(value as u8);
            json!(also.iter().map(Verdict::name).collect::<Vec<_>>())
        }
        "ambiguity" => {
            let known = Ambiguity::from_number(value as u8, Candidates::default());
            json!(known.map(|known| known.name()))
        }
        "sure" => json!(value != 0.0),
        "snr" => return ("snr_db".into(), json!(10.0 * value.log10())),
        _ => json!(value),
    };
    (name.to_owned(), of)
}

/// A view as the cells of a table, each with its name behind `before`; a number that is none is empty.
pub fn cells<V: View>(view: &V, before: &str) -> Vec<(String, String)> {
    let mut cells = Vec::new();
    columns(view, &mut |Column { name, value, .. }| {
        let (name, value) = match !value.is_finite() {
            true => (name.to_owned(), Value::Null),
            false => shown(name, value),
        };
        let text = match &value {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            Value::Array(all) => {
                let all: Vec<&str> = all.iter().filter_map(Value::as_str).collect();
                all.join(" ")
            }
            other => other.to_string(),
        };
        cells.push((format!("{before}{name}"), text));
    });
    cells
}

/// The names of a view's numbers.
pub fn names<V: View>() -> Vec<String> {
    let mut names = Vec::new();
    columns(&V::default(), &mut |column| names.push(column.name.to_owned()));
    names
}

/// A view of numbers by their names; those that are not there are 0.
///
/// # Errors
/// A name that the view does not have, in one line with those that it has.
pub fn told<'a, V: View>(numbers: impl IntoIterator<Item = (&'a str, f64)>) -> Result<V, String> {
    let mut view = V::default();
    for (name, value) in numbers {
        if !view.set("", name, value) {
            return Err(format!("there is no {name}: choose of {}", names::<V>().join(", ")));
        }
    }
    Ok(view)
}

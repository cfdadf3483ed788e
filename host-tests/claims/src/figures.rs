//! `figures.json`: what emulated boards, built programs and long campaigns were measured to take. Tests hold it, and `lab docs`
//! writes the documents' tables from it.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

/// Another release of the compiler may order instructions otherwise: so far a figure may be off.
const MARGIN: f64 = 0.02;

/// Panics unless the file has these figures by this name, each within 2 % or `unit`, which is that of the last digit that is printed.
/// With `PICKET_WRITE_FIGURES` it writes them.
pub fn hold(name: &str, unit: f64, measured: &[f64]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../figures.json");
    // Tests run beside each other, in more than one process.
    let file = File::open(&path).unwrap();
    file.lock().unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let mut all: BTreeMap<String, Value> = serde_json::from_str(&text).unwrap();
    println!("{name}: {measured:?}");
    if std::env::var_os("PICKET_WRITE_FIGURES").is_some() {
        let rounded = measured.iter().map(|figure| (figure / unit).round() * unit);
        // No digits beyond the unit's.
        let printed = rounded.map(|figure| format!("{figure:.6}").parse::<f64>().unwrap());
        all.insert(name.to_owned(), printed.collect());
        let lines: Vec<String> =
            all.iter().map(|(name, figures)| format!("  \"{name}\": {figures}")).collect();
        return fs::write(&path, format!("{{\n{}\n}}\n", lines.join(",\n"))).unwrap();
    }
    let stated = all.get(name).and_then(Value::as_array);
    let stated: Vec<f64> = stated.into_iter().flatten().filter_map(Value::as_f64).collect();
    let near = |(stated, measured): (&f64, &f64)| {
        (stated - measured).abs() <= (MARGIN * measured.abs()).max(unit)
    };
    let held = stated.len() == measured.len() && stated.iter().zip(measured).all(near);
    assert!(
        held,
        "{name}: measured {measured:?}, and host-tests/figures.json has {stated:?}: with PICKET_WRITE_FIGURES=1 this test writes them, then `lab docs`"
    );
}

/// Whether the long form of a test is asked for: the variable `PICKET_LONG` is set.
pub fn long() -> bool {
    std::env::var_os("PICKET_LONG").is_some()
}

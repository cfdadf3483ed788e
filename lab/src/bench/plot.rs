//! The counts over the record length, as a drawing.

use super::Row;
use crate::plot::chart::{Axis, Chart, Series, Style};

/// Instructions a sample over N on `core`: of our transform with search and of our measurement, of the others' transforms.
pub fn chart(rows: &[Row], core: &str) -> Chart {
    let wanted = |row: &&Row| match row.engine.as_str() {
        name if name.starts_with("picket") => row.stage == "fft_peak" || row.stage == "measurement",
        _ => row.stage == "fft",
    };
    let chosen: Vec<&Row> = rows.iter().filter(|row| row.core == core).filter(wanted).collect();
    let each = |row: &Row| row.instructions as f64 / row.n as f64;
    let most = chosen.iter().map(|row| each(row)).fold(10.0, f64::max);
    let mut names: Vec<(&str, &str)> = Vec::new();
    for row in &chosen {
        let name = (row.engine.as_str(), row.stage.as_str());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let series = names.iter().enumerate().map(|(colour, &(engine, stage))| {
        let same = chosen.iter().filter(|row| row.engine == engine && row.stage == stage);
        let points = same.map(|row| (row.n as f64, each(row)));
        Series::new(format!("{engine}, {stage}"), Style::Marked, colour, points)
    });
    Chart {
        name: "bench-target",
        title: format!("Instructions a sample, emulated Cortex-{core}"),
        x: Axis::log("samples in a record", 60.0, 4400.0),
        y: Axis::linear("instructions / sample", 0.0, most * 1.05),
        series: series.collect(),
    }
}

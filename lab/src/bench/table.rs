//! The counts for people.

use super::{Row, locked, precision, several};
use comfy_table::{CellAlignment, Table, presets};

/// All rows of one core and length, or more of them.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header([
        "core", "N", "engine", "stage", "median", "95 %", "worst", "clipped", "found", "clipped",
        "cycles", "RAM B", "tables B", "0 dBFS", "-40 dBFS",
    ]);
    for row in rows {
        let number = |value: Option<u64>| value.map_or(String::new(), |value| value.to_string());
        let ratio = |value: Option<f64>| value.map_or(String::new(), |db| format!("{db:.1} dB"));
        let quoted = if row.source == "measured" { "" } else { " *" };
        table.add_row([
            row.core.to_string(),
            row.n.to_string(),
            format!("{}{quoted}", row.engine),
            row.stage.clone(),
            row.median.to_string(),
            number(row.most_of_95),
            number(row.worst),
            number(row.worst_clipped),
            number(row.found[0]),
            number(row.found[1]),
            cycles(row),
            number(row.ram_bytes),
            number(row.table_bytes),
            ratio(row.snr_0_db),
            ratio(row.snr_m40_db),
        ]);
    }
    for column in table.column_iter_mut().skip(4) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The median, or the range where there is no model of the core.
fn cycles(row: &Row) -> String {
    match (row.median_cycles, row.model_cycles) {
        (Some(median), _) => median.to_string(),
        (None, Some([low, high])) => {
            format!("{:.1}-{:.1} k", low as f64 / 1000.0, high as f64 / 1000.0)
        }
        (None, None) => String::new(),
    }
}

/// The stages of blocks that a tracker follows.
pub fn locked(rows: &[locked::Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["core", "stage", "mean", "most", "blocks"]);
    for row in rows {
        let numbers = [row.mean, row.most, row.blocks as u64].map(|number| number.to_string());
        table.add_row([row.core, row.stage].map(str::to_owned).into_iter().chain(numbers));
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The further tones of blocks.
pub fn several(rows: &[several::Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["core", "tones", "measurement", "phase", "all tones"]);
    for row in rows {
        let numbers = [row.whole, row.phase, row.lines].map(|number| number.to_string());
        let names = [row.core.to_owned(), row.tones.to_string()];
        table.add_row(names.into_iter().chain(numbers));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Cycles and errors of tones.
pub fn precision(points: &[precision::Point]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    let errors = precision::SNR_DB.map(|snr_db| format!("error / bound, {snr_db} dB"));
    let names = ["core", "N", "program", "cycles"].map(str::to_owned);
    table.set_header(names.into_iter().chain(errors));
    for point in points {
        let numbers = [point.core.to_owned(), point.n.to_string()];
        let what = [point.program.clone(), point.cycles.to_string()];
        let errors = point.errors.map(|error| format!("{error:.2}"));
        table.add_row(numbers.into_iter().chain(what).chain(errors));
    }
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

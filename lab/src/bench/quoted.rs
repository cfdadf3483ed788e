//! Figures of others that are not measured in the same run.

use super::{Core, Row};
use serde_json::Value;

/// Where they are from.
pub const SOURCE: &str =
    "counted with gcc 12 on the same emulated cores, in another run than this one";

/// Rows of CMSIS-DSP as `lab bench --json` prints them: `PICKET_WRITE_FIGURES=1 cargo test --test all cmsis` writes them anew.
pub const CMSIS: &str = include_str!("../../cmsis/figures.jsonl");

/// The rows of CMSIS-DSP on this core for records of `n` samples.
pub fn rows(core: &Core, n: usize) -> Vec<Row> {
    let rows = CMSIS.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    rows.filter(|row| row["core"] == core.name && row["n"] == n)
        .filter_map(|row| {
            let [engine, stage] = [row["engine"].as_str()?, row["stage"].as_str()?];
            let cycles = &row["model_cycles"];
            Some(Row {
                ram_bytes: row["ram_bytes"].as_u64(),
                table_bytes: row["table_bytes"].as_u64(),
                snr_0_db: row["snr_0_db"].as_f64(),
                snr_m40_db: row["snr_m40_db"].as_f64(),
                median_cycles: row["median_cycles"].as_u64(),
                model_cycles: cycles[0].as_u64().zip(cycles[1].as_u64()).map(|(a, b)| [a, b]),
                source: SOURCE,
                ..Row::new(core.name, engine, n, stage, row["instructions"].as_u64()?)
            })
        })
        .collect()
}

/// The memory that a rival's transform works in, in bytes.
pub fn ram(engine: &str, n: usize) -> Option<u64> {
    let n = n as u64;
    match engine {
        "microfft" => Some(4 * n),
        "fixed-fft" => Some(2 * n + 4 * (n / 2 + 1)),
        "fixed-dsp-q15" => Some(2 * n + 4 * n),
        "fixed-dsp-q31" => Some(4 * n + 8 * n),
        _ => None,
    }
}

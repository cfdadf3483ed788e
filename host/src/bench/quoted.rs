//! Figures of others that are not measured in the same run.

use super::Row;

/// Where the figures of CMSIS-DSP are from.
pub const SOURCE: &str =
    "quoted: CMSIS-DSP 1.17, gcc -O3, counted on the same emulated M4F for this project's design";

/// CMSIS-DSP on a real record: what is called, its stage, instructions at N = 256, 1024, 4096, bytes of memory and of tables
/// at 1024, and the ratio to the error in dB of a full-scale tone and of one 40 dB below.
type Quoted = (&'static str, &'static str, [u64; 3], [u64; 2], [f64; 2]);

const CMSIS: [Quoted; 4] = [
    ("cmsis-q15", "fft", [9_882, 44_610, 198_991], [6 << 10, 35 << 10], [52.7, 13.4]),
    // arm_cmplx_mag_squared_q15 and arm_max_q15 on top: the bin's index and no more.
    ("cmsis-q15", "fft_peak", [11_448, 50_784, 223_597], [6 << 10, 35 << 10], [52.7, 13.4]),
    ("cmsis-q31", "fft", [19_196, 87_304, 391_705], [12 << 10, 70 << 10], [145.0, 105.0]),
    ("cmsis-f32", "fft", [11_331, 44_685, 229_520], [8 << 10, 9 << 10], [141.0, 142.0]),
];

/// The rows of CMSIS-DSP for records of `n` samples.
pub fn rows(n: usize) -> Vec<Row> {
    let Some(place) = [256, 1024, 4096].iter().position(|&length| length == n) else {
        return Vec::new();
    };
    let known = |value: u64| (n == 1024).then_some(value);
    let row = |&(engine, stage, instructions, [ram, table], snr): &Quoted| Row {
        core: "M4F",
        engine: engine.into(),
        n,
        stage: stage.into(),
        instructions: instructions[place],
        median: instructions[place],
        worst: None,
        worst_clipped: None,
        ram_bytes: known(ram),
        table_bytes: known(table),
        code_bytes: None,
        snr_0_db: (n == 1024).then_some(snr[0]),
        snr_m40_db: (n == 1024).then_some(snr[1]),
        median_cycles: None,
        model_cycles: None,
        source: SOURCE,
    };
    CMSIS.iter().map(row).collect()
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

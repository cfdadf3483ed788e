//! Figures of others that are not measured in the same run.

use super::Row;

/// Where the figures of CMSIS-DSP are from.
pub const SOURCE: &str = "quoted: CMSIS-DSP 1.17, gcc -O3, with its vector functions (MVE) on the M55, counted on the same \
     emulated cores for this project's design";

/// CMSIS-DSP on a real record: what is called, its stage, instructions at N = 256, 1024, 4096; and where known bytes of memory
/// and of tables at 1024, and the ratio to the error in dB of a full-scale tone and of one 40 dB below.
type Quoted = (&'static str, &'static str, [u64; 3], Option<([u64; 2], [f64; 2])>);

// With fft_peak, its squared magnitudes and their largest on top: the bin's index and no more.
const Q15: Option<([u64; 2], [f64; 2])> = Some(([6 << 10, 35 << 10], [52.7, 13.4]));
const CMSIS: [Quoted; 4] = [
    ("cmsis-q15", "fft", [9_882, 44_610, 198_991], Q15),
    ("cmsis-q15", "fft_peak", [11_448, 50_784, 223_597], Q15),
    ("cmsis-q31", "fft", [19_196, 87_304, 391_705], Some(([12 << 10, 70 << 10], [145.0, 105.0]))),
    ("cmsis-f32", "fft", [11_331, 44_685, 229_520], Some(([8 << 10, 9 << 10], [141.0, 142.0]))),
];
const CMSIS_MVE: [Quoted; 4] = [
    ("cmsis-q15", "fft", [2_288, 9_149, 39_266], None),
    ("cmsis-q15", "fft_peak", [2_790, 10_995, 46_488], None),
    ("cmsis-q31", "fft", [4_014, 17_022, 74_441], None),
    ("cmsis-q31", "fft_peak", [4_933, 20_533, 88_320], None),
];

/// The rows of CMSIS-DSP on this core for records of `n` samples.
pub fn rows(core: &'static str, n: usize) -> Vec<Row> {
    let quoted = match core {
        "M4F" => CMSIS,
        "M55" => CMSIS_MVE,
        _ => return Vec::new(),
    };
    let Some(place) = [256, 1024, 4096].iter().position(|&length| length == n) else {
        return Vec::new();
    };
    let row = |&(engine, stage, instructions, known): &Quoted| Row {
        core,
        engine: engine.into(),
        n,
        stage: stage.into(),
        instructions: instructions[place],
        median: instructions[place],
        worst: None,
        worst_clipped: None,
        ram_bytes: known.filter(|_| n == 1024).map(|([ram, _], _)| ram),
        table_bytes: known.filter(|_| n == 1024).map(|([_, table], _)| table),
        code_bytes: None,
        snr_0_db: known.filter(|_| n == 1024).map(|(_, snr)| snr[0]),
        snr_m40_db: known.filter(|_| n == 1024).map(|(_, snr)| snr[1]),
        model_cycles: None,
        source: SOURCE,
    };
    quoted.iter().map(row).collect()
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

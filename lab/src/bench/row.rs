//! A line of the table of counts.

use serde::Serialize;

/// A line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The core's name.
    pub core: &'static str,
    /// Whose code.
    pub engine: String,
    /// Samples in a record.
    pub n: usize,
    /// What was counted.
    pub stage: String,
    /// Executed instructions: the median.
    pub instructions: u64,
    /// The median once more, beside the next two.
    pub median: u64,
    /// What 95 of 100 records without a sample at a rail take at the most.
    pub most_of_95: Option<u64>,
    /// The most over all records without a sample at a rail.
    pub worst: Option<u64>,
    /// The most over the records with samples at a rail.
    pub worst_clipped: Option<u64>,
    /// The most that a search over signals found, without a sample at a rail and with: see [`worst`](super::worst).
    pub found: [Option<u64>; 2],
    /// Work memory with the record, in bytes; for a measurement the whole pipeline with two records.
    pub ram_bytes: Option<u64>,
    /// Tables, in bytes.
    pub table_bytes: Option<u64>,
    /// How far the error is below a full-scale tone, in dB.
    pub snr_0_db: Option<f64>,
    /// How far the error is below a tone of -40 dBFS, in dB.
    pub snr_m40_db: Option<f64>,
    /// Modelled cycles, see [`cycles`](super::cycles): the median, of a part of the records.
    pub median_cycles: Option<u64>,
    /// From the model to what published measurements were above it, see [`range`](super::cycles::range); without a table see
    /// [`rough`](super::cycles::rough).
    pub model_cycles: Option<[u64; 2]>,
    /// "measured" in this run, or where the figure is from.
    pub source: &'static str,
}

impl Row {
    /// A row of which no more is known than the instructions, measured in this run.
    pub fn new(core: &'static str, engine: &str, n: usize, stage: &str, instructions: u64) -> Self {
        Self {
            core,
            engine: engine.into(),
            n,
            stage: stage.into(),
            instructions,
            median: instructions,
            most_of_95: None,
            worst: None,
            worst_clipped: None,
            found: [None; 2],
            ram_bytes: None,
            table_bytes: None,
            snr_0_db: None,
            snr_m40_db: None,
            median_cycles: None,
            model_cycles: None,
            source: "measured",
        }
    }
}

//! The fundamental of each block of a recording, from its harmonics.

use super::Style;
use crate::cli::print_line;
use picket_dsp::tone::harmonic::Harmonic;
use serde::Serialize;

/// A block's fundamental. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Fundamental {
    /// The block's number.
    pub block: u64,
    /// The time of the block's middle.
    pub time_s: f64,
    /// Its frequency; negative ones exist for I/Q.
    pub frequency_hz: f64,
    /// One standard deviation of it.
    pub sigma_hz: f64,
    /// Signal-to-noise ratio per sample of all its lines together.
    pub snr_db: f64,
    /// The orders that were seen: 1 is the fundamental itself.
    pub orders: Vec<u32>,
    /// Whether it may be used.
    pub verdict: &'static str,
}

impl Fundamental {
    /// The fundamental of a block.
    pub fn from_harmonic(block: u64, time_s: f64, harmonic: &Harmonic) -> Self {
        let tone = &harmonic.tone;
        Self {
            block,
            time_s,
            frequency_hz: tone.hertz(),
            sigma_hz: tone.sigma_hertz(),
            snr_db: tone.snr_db().into(),
            orders: harmonic.seen().collect(),
            verdict: tone.verdict.name(),
        }
    }

    /// Prints it.
    pub fn print(&self, style: Style) {
        let Self { block, time_s, frequency_hz, sigma_hz, snr_db, verdict, .. } = self;
        match style {
            Style::Json => print_line(&serde_json::to_string(self).unwrap_or_default()),
            // No comma: a column is a column.
            Style::Csv => print_line(&format!(
                "{block},{time_s},{frequency_hz},{sigma_hz},{snr_db},{},{verdict}",
                listed(&self.orders, " ")
            )),
            Style::Text => print_line(&format!(
                "{block:>8} {time_s:>11.4} {frequency_hz:>16.6} {sigma_hz:>12.6} {snr_db:>7.1}  {verdict:<11} {}",
                listed(&self.orders, ", ")
            )),
        }
    }
}

/// Orders as people and spreadsheets read them.
pub fn listed(orders: &[u32], between: &str) -> String {
    let orders: Vec<String> = orders.iter().map(u32::to_string).collect();
    orders.join(between)
}

/// Prints the headings of the fundamentals.
pub fn print_heading(style: Style) {
    match style {
        Style::Json => {}
        Style::Csv => print_line("block,time_s,frequency_hz,sigma_hz,snr_db,orders,verdict"),
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>16} {:>12} {:>7}  {:<11} orders",
            "block", "time s", "frequency Hz", "sigma Hz", "SNR dB", "verdict"
        )),
    }
}

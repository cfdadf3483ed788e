//! The fundamental of a block's harmonics as a line, for people and for programs.

use super::Style;
use super::line::{Reading, segment};
use crate::analyze::fundamental::listed;
use picket_wire::fundamental as wire;
use serde::Serialize;

/// A fundamental's fields, units in their names.
#[derive(Debug, Serialize)]
pub struct Fundamental {
    fundamental: bool,
    sequence: u32,
    segment: &'static str,
    #[serde(flatten)]
    reading: Reading,
    orders: Vec<u32>,
    verdict: &'static str,
}

impl Fundamental {
    /// Converts the fundamental that a device reports, to hertz if the sample rate is known.
    pub fn from_harmonic(found: &wire::Fundamental, rate_hz: Option<f64>) -> Self {
        let harmonic = &found.harmonic;
        Self {
            fundamental: true,
            sequence: found.sequence,
            segment: segment(found.segment),
            reading: Reading::of(&harmonic.tone, rate_hz),
            orders: harmonic.seen().collect(),
            verdict: harmonic.tone.verdict.name(),
        }
    }

    /// Its lines in this style.
    pub fn written(&self, style: Style) -> Vec<String> {
        match style {
            Style::Jsonl => vec![self.json()],
            Style::Teleplot => self.teleplot(),
            Style::Csv => vec![self.csv()],
            Style::Table => vec![self.table()],
        }
    }

    fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Comma-separated values: "fundamental" is in the place of a line's number.
    fn csv(&self) -> String {
        self.reading.csv_below(self.sequence, self.segment, self.verdict, "fundamental,,")
    }

    /// A row of the table.
    fn table(&self) -> String {
        let (orders, verdict) = (listed(&self.orders, ", "), self.verdict);
        let more = format!("orders {orders}  {verdict}");
        self.reading.table_below("fundamental", &more)
    }

    /// Teleplot's lines.
    fn teleplot(&self) -> Vec<String> {
        let hertz = self.reading.frequency_hz;
        hertz.iter().map(|hertz| format!(">fundamental_hz:{hertz}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::line::CSV;
    use picket_dsp::tone::harmonic::Harmonic;
    use picket_dsp::tone::{Tone, Verdict};

    #[test]
    fn people_and_programs_read_the_same() {
        let tone = Tone { snr: 100.0, verdict: Verdict::Good, ..Tone::default() };
        let harmonic = Harmonic { tone, orders: 0b10110 };
        let found = wire::Fundamental { sequence: 7, harmonic, ..wire::Fundamental::default() };
        let found = Fundamental::from_harmonic(&found, Some(1e3));
        assert_eq!(found.csv().matches(',').count(), CSV.matches(',').count());
        let json: serde_json::Value = serde_json::from_str(&found.json()).unwrap();
        assert_eq!(json["orders"], serde_json::json!([2, 3, 5]));
        assert_eq!((&json["fundamental"], &json["sequence"]), (&true.into(), &7.into()));
        assert_eq!((&json["snr_db"], &json["verdict"]), (&20.0.into(), &"good".into()));
        assert!(found.table().contains("orders 2, 3, 5  good"), "{}", found.table());
        assert_eq!(found.teleplot(), [">fundamental_hz:0"]);
    }
}

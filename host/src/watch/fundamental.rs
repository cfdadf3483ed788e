//! The fundamental of a block's harmonics as a line, for people and for programs.

use super::Style;
use super::line::{Reading, Scale, segment};
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
    /// That of a device.
    pub fn of(found: &wire::Fundamental, scale: &Scale) -> Self {
        let harmonic = &found.harmonic;
        Self {
            fundamental: true,
            sequence: found.sequence,
            segment: segment(found.segment),
            reading: Reading::of(&harmonic.tone, scale),
            orders: (1..=32).filter(|order| harmonic.orders >> (order - 1) & 1 == 1).collect(),
            verdict: harmonic.tone.verdict.name(),
        }
    }

    fn orders(&self, between: &str) -> String {
        let orders: Vec<String> = self.orders.iter().map(u32::to_string).collect();
        orders.join(between)
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

    /// Comma-separated values, empty where only a block has one: a fundamental is in the place of a line's
    /// number.
    fn csv(&self) -> String {
        let f = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
        let Reading { frequency_hz, sigma_hz, snr_db, amplitude_codes, .. } = self.reading;
        format!(
            "{},,{},,{},{},{snr_db},{amplitude_codes},,{},,,,,,,,,fundamental,,",
            self.sequence,
            self.segment,
            f(frequency_hz),
            f(sigma_hz),
            self.verdict,
        )
    }

    /// A row of the table.
    fn table(&self) -> String {
        let Reading { frequency_hz, frequency_cycles_per_sample, sigma_hz, snr_db, .. } =
            self.reading;
        let hertz = frequency_hz.unwrap_or(frequency_cycles_per_sample);
        let sigma = sigma_hz.map_or("-".into(), |sigma| format!("{sigma:.4}"));
        let (orders, verdict) = (self.orders(", "), self.verdict);
        format!(
            "{:>17} {hertz:>16.4} {sigma:>13} {snr_db:7.1}  orders {orders}  {verdict}",
            "fundamental"
        )
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
    use picket::estimate::harmonic::Harmonic;
    use picket::estimate::tone::{Tone, Verdict};

    #[test]
    fn people_and_programs_read_the_same() {
        let tone = Tone { snr: 100.0, verdict: Verdict::Good, ..Tone::default() };
        let harmonic = Harmonic { tone, orders: 0b10110 };
        let found = wire::Fundamental { sequence: 7, harmonic, ..wire::Fundamental::default() };
        let scale = Scale { rate_hz: Some(1e3), ..Scale::default() };
        let found = Fundamental::of(&found, &scale);
        assert_eq!(found.csv().matches(',').count(), CSV.matches(',').count());
        let json: serde_json::Value = serde_json::from_str(&found.json()).unwrap();
        assert_eq!(json["orders"], serde_json::json!([2, 3, 5]));
        assert_eq!((&json["fundamental"], &json["sequence"]), (&true.into(), &7.into()));
        assert_eq!((&json["snr_db"], &json["verdict"]), (&20.0.into(), &"good".into()));
        assert!(found.table().contains("orders 2, 3, 5  good"), "{}", found.table());
        assert_eq!(found.teleplot(), [">fundamental_hz:0"]);
    }
}

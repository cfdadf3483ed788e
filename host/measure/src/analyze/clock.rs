//! The converter's clock, by a recording of a tone whose frequency is known.

use super::{Answer, Style};
use crate::cli::print_line;
use picket_dsp::tone::Verdict;
use serde::Serialize;

/// The answers of a tone of this frequency, Hz.
#[derive(Clone, Debug)]
pub struct Reference {
    hz: f64,
    /// Frequencies and sigmas of the good answers.
    good: Vec<(f64, f64)>,
}

/// By how much the clock is off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockError {
    /// The tone's frequency.
    pub reference_hz: f64,
    /// Its measured one, over all good blocks.
    pub measured_hz: f64,
    /// By how many millionths the samples come faster than the stated rate.
    pub clock_ppm: f64,
    /// One standard deviation of it.
    pub sigma_clock_ppm: f64,
    /// Good blocks.
    pub blocks: usize,
}

impl Reference {
    /// A tone of this frequency.
    pub const fn new(hz: f64) -> Self {
        Self { hz, good: Vec::new() }
    }

    /// Takes an answer.
    pub fn add(&mut self, answer: &Answer) {
        let good = answer.verdict == Verdict::Good.name();
        self.good.extend(answer.frequency_hz.zip(answer.sigma_hz).filter(|_| good));
    }

    /// The clock's error: the mean of all good answers, weighed by their sigmas, whose scatter widens its own where it is larger.
    ///
    /// # Errors
    /// There is no good answer, or none near the reference.
    pub fn error(&self) -> Result<ClockError, String> {
        let Self { hz, good } = self;
        let weight = |sigma: f64| sigma.max(1e-12 * hz).powi(-2);
        let total: f64 = good.iter().map(|it| weight(it.1)).sum();
        let mean = good.iter().map(|it| it.0.abs() * weight(it.1)).sum::<f64>() / total;
        if good.is_empty() {
            return Err("no block is good: the clock error cannot be measured".into());
        }
        if (mean / hz - 1.0).abs() > 0.05 {
            return Err(format!(
                "the tone is at {mean:.6} Hz, and the reference at {hz} Hz: add --band around the reference, or the --rate"
            ));
        }
        let squares: f64 = good.iter().map(|it| (it.0.abs() - mean).powi(2) * weight(it.1)).sum();
        let scatter =
            if good.len() > 1 { (squares / (good.len() - 1) as f64).max(1.0) } else { 1.0 };
        let sigma = (scatter / total).sqrt();
        Ok(ClockError {
            reference_hz: *hz,
            measured_hz: mean,
            clock_ppm: 1e6 * (hz / mean - 1.0),
            sigma_clock_ppm: 1e6 * sigma / mean,
            blocks: good.len(),
        })
    }
}

impl ClockError {
    /// Prints it.
    pub fn print(&self, style: Style) {
        let Self { reference_hz, measured_hz, clock_ppm, sigma_clock_ppm, blocks } = self;
        match style {
            Style::Json => print_line(&serde_json::to_string(self).unwrap_or_default()),
            Style::Csv => {}
            Style::Text => print_line(&format!(
                "clock error: {clock_ppm:+.4} +- {sigma_clock_ppm:.4} ppm, by {measured_hz:.6} Hz for {reference_hz} Hz in {blocks} blocks"
            )),
        }
    }
}

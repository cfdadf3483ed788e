//! The sentences about a recording.

use super::nature::Nature;
use super::trial::Of;
use super::{Spectral, Survey};
use crate::recording::Levels;

impl Survey {
    /// The lines for a person; `command` is what was typed of the file and how it is read.
    pub fn text(&self, command: &str) -> String {
        let Levels { low, high, mean, rms, step, clipped, .. } = self.levels;
        let [low, high, mean] = [low, high, mean].map(|code| self.scaling.number(code));
        let (rms, step) = (rms / self.scaling.factor, step.map(|step| step / self.scaling.factor));
        let kind = if self.iq { "I/Q" } else { "real" };
        let seconds = self.samples as f64 / self.rate_hz;
        let mut text = match self.knows_rate {
            true => format!(
                "rate      {} Hz, {kind}, {} samples looked at ({seconds:.4} s)\n",
                self.rate_hz, self.samples
            ),
            false => format!(
                "rate      unknown: frequencies are in cycles per sample, --rate HZ gives hertz; {kind}, {} samples looked at\n",
                self.samples
            ),
        };
        if self.missed > 0 {
            text += &format!("missing   {} samples have no number\n", self.missed);
        }
        text += &format!(
            "values    {} to {}, mean {}, rms without it {}",
            digits(low),
            digits(high),
            digits(mean),
            digits(rms)
        );
        text += &match step {
            Some(step) => {
                let bits = ((high - low) / step + 1.0).log2().ceil().max(1.0);
                format!("; in steps of {}: {bits} bits are used\n", plain(step))
            }
            None => "\n".into(),
        };
        text += &match clipped > 0.0 {
            true => format!(
                "clipped   {:.2} % of the samples lie at either end: lower the gain\n",
                100.0 * clipped
            ),
            false => "clipped   no\n".into(),
        };
        text += &match self.hum_hz {
            Some(hum) => format!("hum       {hum} Hz is among the lines\n"),
            None => "hum       none seen\n".into(),
        };
        text += &format!("kind      {}\n", self.finding.nature.text());
        if self.lines.is_empty() {
            text += "lines     none stands where it is";
            text += match self.finding.held {
                Some(_) => "\n",
                None => "; --plot FILE.svg draws the spectrum\n",
            };
            return text + &self.advice(command);
        }
        let unit = if self.knows_rate { "Hz" } else { "c/sample" };
        text += &format!(
            "lines     {:>16} {:>13} {:>18}  verdict\n",
            format!("frequency {unit}"),
            format!("sigma {unit}"),
            "dB over the floor"
        );
        for line in &self.lines {
            let Spectral { frequency_hz, sigma_hz, above_db, verdict } = line;
            let more = if self.knows_rate { 0 } else { 4 };
            text += &format!(
                "          {frequency_hz:16.0$} {sigma_hz:13.1$} {above_db:18.1}  {verdict}\n",
                4 + more,
                6 + more
            );
        }
        text + &self.advice(command)
    }

    /// What was tried, and what to type.
    fn advice(&self, command: &str) -> String {
        let Some(proposal) = self.proposal() else {
            return match self.finding.nature {
                Nature::Noise => String::new(),
                _ => "try       nothing that was tried gave answers that agree with each other\n"
                    .into(),
            };
        };
        let mut text = String::new();
        if let Some((way, share, shots)) = &self.finding.held {
            let mut sigmas: Vec<f64> = shots.iter().map(|shot| shot.sigma_hz).collect();
            sigmas.sort_by(f64::total_cmp);
            let sigma = sigmas.get(sigmas.len() / 2).copied().unwrap_or(f64::NAN);
            let unit = if self.knows_rate { "Hz" } else { "cycles per sample" };
            let (held, what) = match way.of {
                Of::Track => ("tracked in", "blocks"),
                Of::Blocks => ("good in", "blocks"),
                Of::Bursts => ("valid are", "bursts"),
            };
            text += &format!(
                "tried     {held} {:.0} % of {} {what}, to {} {unit}\n",
                100.0 * share,
                (shots.len() as f64 / share).round(),
                digits(sigma)
            );
        }
        text + &format!("try       picket analyze {command} {proposal}\n")
    }
}

/// A whole number as it is, another with four digits and more.
fn plain(value: f64) -> String {
    let whole = (value - value.round()).abs() < 1e-9 * value.abs();
    if whole { value.round().to_string() } else { digits(value) }
}

/// Four digits and more.
fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let before = value.abs().max(1e-9).log10().floor();
    format!("{value:.*}", (3.0 - before).clamp(0.0, 12.0) as usize)
}

//! The sentences about a recording.

use super::nature::Nature;
use super::trial::{Of, Shot};
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
        let assumed = self.assumed.as_ref().map(|assumed| format!("read      {assumed}\n"));
        let mut text = assumed.unwrap_or_default();
        text += &match self.knows_rate {
            true => format!(
                "rate      {} Hz, {kind}, {} samples looked at ({seconds:.4} s)\n",
                self.rate(),
                self.samples
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
        if let Some(chirps) = self.frame {
            text += &format!(
                "chirps    {chirps} together: --chirp-s S --bandwidth-hz HZ --carrier-hz HZ gives their targets (docs/signals.md)\n"
            );
        }
        text += &format!("kind      {}\n", self.finding.nature.text());
        if self.lines.is_empty() {
            text += "lines     no steady line\n";
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
            let Spectral { frequency_hz, sigma_hz, above_db, verdict, .. } = line;
            let more = if self.knows_rate { 0 } else { 4 };
            text += &format!(
                "          {frequency_hz:16.0$} {sigma_hz:13.1$} {above_db:18.1}  {verdict}\n",
                4 + more,
                6 + more
            );
        }
        text + &self.advice(command)
    }

    /// The rate with the digits that it has.
    fn rate(&self) -> String {
        match self.clock.filter(|clock| clock.sigma_hz > 0.0) {
            Some(clock) => with_sigma(clock.rate_hz, clock.sigma_hz),
            None => {
                format!("{:.11e}", self.rate_hz).parse::<f64>().unwrap_or(self.rate_hz).to_string()
            }
        }
    }

    /// What was tried, and what to type.
    fn advice(&self, command: &str) -> String {
        let note = self.finding.note.as_ref().map(|note| format!("note      {note}\n"));
        let note = note.unwrap_or_default();
        let Some(proposal) = self.proposal() else {
            if let Some(why) = self.uneven(self.record()) {
                return format!("try       nothing: {why}\n");
            }
            return match self.finding.nature {
                Nature::Noise | Nature::Silence => String::new(),
                _ => {
                    note + "try       nothing that was tried gave answers that agree with each other\n"
                }
            };
        };
        let mut text = note;
        if let Some((way, share, shots)) = &self.finding.held {
            let sigma = |shot: &Shot| self.with_rate(shot.hz, shot.sigma_hz, way.n);
            let mut sigmas: Vec<f64> = shots.iter().map(sigma).collect();
            sigmas.sort_by(f64::total_cmp);
            let sigma = sigmas.get(sigmas.len() / 2).copied().unwrap_or(f64::NAN);
            let unit = if self.knows_rate { "Hz" } else { "cycles per sample" };
            let (held, what) = match way.of {
                Of::Track => ("followed", "blocks"),
                Of::Blocks => ("good", "blocks"),
                Of::Harmonics(_) => ("good", "blocks"),
                Of::Bursts => ("valid", "bursts"),
            };
            let tried = if *share > 0.0 {
                let all = (shots.len() as f64 / share).round();
                format!("{:.0} % of {all} {what} are {held}", 100.0 * share)
            } else {
                format!("{} {what} answer this, none of them {held}", shots.len())
            };
            text += &format!(
                "tried     with the command below {tried}, sigma {} {unit} (median)\n",
                digits(sigma)
            );
        }
        text + &format!("try       picket analyze {command} {proposal}\n")
    }
}

/// A value and its sigma, with two digits of sigma.
fn with_sigma(value: f64, sigma: f64) -> String {
    let after = (1.0 - sigma.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.after$} +- {sigma:.after$}")
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

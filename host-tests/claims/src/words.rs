//! What is asked, in words.

use crate::limit::{Asked, Event, Judged};
use std::fmt::{self, Display, Formatter};

/// A measured value without a limit.
pub const ANYTHING: f64 = 1e9;

impl Asked {
    /// Whether it has a limit: without one it is measured only.
    pub const fn is_limited(&self) -> bool {
        match *self {
            Asked::Share { least, most, .. } => least > 0.0 || most < 1.0,
            Asked::Square { most, .. }
            | Asked::ByPhase { most, .. }
            | Asked::OverBound { most, .. }
            | Asked::Rms { most }
            | Asked::Snr { most_db: most }
            | Asked::Sigma { most } => most < ANYTHING,
        }
    }

    /// What was seen of it.
    pub fn seen(&self, judged: &Judged) -> String {
        let Judged { value, of, .. } = judged;
        match self {
            Asked::Share { .. } => format!("{:.0} of {of}", value * *of as f64),
            _ => format!("{value:.5} of {of}"),
        }
    }
}

/// A number with four decimals at most.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn percent(share: f64) -> String {
    short(100.0 * share)
}

impl Display for Asked {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let which = |quantity, first, second| if quantity == 0 { first } else { second };
        match *self {
            Asked::Share { of, most: 0.0, .. } => write!(f, "never {of}"),
            Asked::Share { of, least: 1.0, .. } => write!(f, "always {of}"),
            Asked::Share { of, least: 0.0, most } => {
                write!(f, "{of}: at most {} %", percent(most))
            }
            Asked::Share { of, least, most: 1.0 } => {
                write!(f, "{of}: at least {} %", percent(least))
            }
            Asked::Share { of, least, most } => {
                write!(f, "{of}: {} to {} %", percent(least), percent(most))
            }
            Asked::Square { quantity, least, most } => {
                let of = which(quantity, "", " of the second quantity");
                write!(f, "mean of (error / sigma)^2{of}: ")?;
                match least {
                    0.0 => write!(f, "at most {}", short(most)),
                    _ => write!(f, "{} to {}", short(least), short(most)),
                }
            }
            Asked::ByPhase { least, most } => {
                write!(f, "mean of (error / sigma)^2 by phase: {} to {}", short(least), short(most))
            }
            Asked::OverBound { quantity, most } => {
                let of = which(quantity, "error", "error of the phase");
                write!(f, "rms {of} over its bound: at most {}", short(most))
            }
            Asked::Rms { most } => write!(f, "rms error: at most {} bins", short(most)),
            Asked::Snr { most_db } => write!(f, "mean SNR: within {most_db} dB"),
            Asked::Sigma { most } => write!(f, "median sigma over the bound: at most {most}"),
        }
    }
}

impl Display for Event {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match *self {
            Event::Usable => f.write_str("usable"),
            Event::Refused => f.write_str("not usable"),
            Event::Good => f.write_str("`good`"),
            Event::Is(verdicts) => {
                let names: Vec<String> =
                    verdicts.iter().map(|verdict| format!("`{}`", verdict.name())).collect();
                f.write_str(&names.join(" or "))
            }
            Event::Off(sigmas) => write!(f, "{sigmas} sigma off, of the usable"),
            Event::FirstOff(sigmas) => {
                write!(f, "frequency or range {sigmas} sigma off, of the usable")
            }
            Event::Wrong(sigmas) => write!(f, "usable and {sigmas} sigma off"),
            Event::GoodOff(sigmas) => write!(f, "`good` and {sigmas} sigma off"),
            Event::RefusedThoughRight => f.write_str("not usable though right"),
            Event::Within(sigmas) => write!(f, "within {sigmas} sigma, of the usable"),
            Event::SnrWithin(db) => write!(f, "SNR within {db} dB, of the usable"),
            Event::Elsewhere => f.write_str("of another line"),
            Event::Unlisted(sigmas) => {
                write!(f, "`ambiguous` without a candidate within {sigmas} sigma")
            }
            Event::Found => f.write_str("found"),
            Event::RightNumber => f.write_str("an answer for each source, and no other"),
            Event::More => f.write_str("an answer without a source"),
            Event::MoreGood => f.write_str("a `good` answer without a source"),
            Event::LevelOff(share) => {
                write!(f, "amplitude {} % off, of the usable", percent(share))
            }
            Event::Identities(most) => write!(f, "more than {most} tracks"),
            Event::Late(blocks) => write!(f, "held after more than {blocks} blocks"),
            Event::Lost => f.write_str("lost after it was held"),
            Event::Exchanged => f.write_str("held by another track in the end"),
            Event::Sure => f.write_str("sure of the cycle, of the usable"),
            Event::OtherCycle => f.write_str("another cycle, of the sure"),
            Event::NotAmong(sigmas) => {
                write!(f, "no candidate within {sigmas} sigma, of those not sure")
            }
            Event::Cut => f.write_str("cut out as a burst"),
        }
    }
}

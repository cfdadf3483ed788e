//! Progress of work that takes longer than a second, for a person at a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on stderr that counts to `total`; invisible where stderr is no terminal.
pub fn bar(total: u64, unit: &'static str) -> ProgressBar {
    let template = format!("{{bar:40}} {{pos}} of {{len}} {unit}, {{eta}} left");
    let style = ProgressStyle::with_template(&template).unwrap_or(ProgressStyle::default_bar());
    ProgressBar::new(total).with_style(style)
}

/// A count on stderr, where the total is not known beforehand; invisible where stderr is no terminal.
pub fn count(unit: &'static str) -> ProgressBar {
    let template = format!("{{human_pos}} {unit}, {{elapsed}}");
    let style = ProgressStyle::with_template(&template).unwrap_or(ProgressStyle::default_bar());
    ProgressBar::no_length().with_style(style)
}

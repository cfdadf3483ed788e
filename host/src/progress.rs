//! Progress of work that takes longer than a second, for a person at a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on stderr that counts to `total`; invisible where stderr is no terminal.
pub fn bar(total: u64, unit: &'static str) -> ProgressBar {
    let template = format!("{{bar:40}} {{pos}} of {{len}} {unit}, {{eta}} left");
    let style = ProgressStyle::with_template(&template).unwrap_or(ProgressStyle::default_bar());
    ProgressBar::new(total).with_style(style)
}

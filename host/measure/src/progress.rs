//! Progress of work that takes longer than a second, for a person at a terminal.

pub use indicatif::ProgressBar;
use indicatif::ProgressStyle;
use std::time::Duration;

/// A bar on stderr that counts to `total`; invisible where stderr is no terminal.
pub fn bar(total: u64, unit: &'static str) -> ProgressBar {
    let template = format!("{{bar:40}} {{pos}} of {{len}} {unit}, {{eta}} left");
    let style = ProgressStyle::with_template(&template).unwrap_or(ProgressStyle::default_bar());
    ProgressBar::new(total).with_style(style)
}

/// A bar on stderr for the steps of `what`, whose number is still to come; invisible where stderr is no terminal.
pub fn steps(what: &str) -> ProgressBar {
    let template = "{msg} {wide_bar} {pos} of {len} steps, {elapsed}";
    let style = ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar());
    let bar = ProgressBar::new(1).with_style(style).with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A bar on stderr for bytes of `what` that are downloaded, with their rate; invisible where stderr is no terminal.
pub fn bytes(total: u64, what: &str) -> ProgressBar {
    let template = "{msg} {wide_bar} {decimal_bytes} of {decimal_total_bytes}, {decimal_bytes_per_sec}, {eta} left";
    let style = ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar());
    let bar = ProgressBar::new(total).with_style(style).with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A count on stderr, where the total is not known beforehand; invisible where stderr is no terminal.
pub fn count(unit: &'static str) -> ProgressBar {
    let template = format!("{{human_pos}} {unit}, {{elapsed}}");
    let style = ProgressStyle::with_template(&template).unwrap_or(ProgressStyle::default_bar());
    ProgressBar::no_length().with_style(style)
}

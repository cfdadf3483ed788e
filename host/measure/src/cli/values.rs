//! Values as a user types them.

use std::ops::RangeInclusive;
use std::path::PathBuf;

/// A number of the command line.
pub fn number(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "give a number".into())
}

/// A frequency of the command line, hertz: 48000, 48k, 2.5M or 24G.
pub fn hertz(text: &str) -> Result<f64, String> {
    let units = [("k", 1e3), ("M", 1e6), ("G", 1e9)];
    let of = |&(unit, factor): &(&str, f64)| Some((text.strip_suffix(unit)?, factor));
    let (digits, factor) = units.iter().find_map(of).unwrap_or((text, 1.0));
    let number: Result<f64, _> = digits.parse();
    number.map(|number| number * factor).map_err(|_| "give hertz: 48000, 48k or 1M".into())
}

/// Sizes of what is given in units: sums and quotients of them have a meaning, and light is among the frequencies.
pub const MAGNITUDES: RangeInclusive<f64> = 1e-18..=1e18;

/// A frequency above 0.
pub fn positive_hertz(text: &str) -> Result<f64, String> {
    let wrong = || "give a positive number of hertz: 48000, 48k or 1M".into();
    hertz(text).ok().filter(|hz| MAGNITUDES.contains(hz)).ok_or_else(wrong)
}

/// A count from 1 to `MOST`: what is counted takes memory.
pub fn count<const MOST: usize>(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MOST).contains(count));
    count.ok_or_else(|| format!("give at least 1 and at most {MOST}"))
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = number(text).ok().filter(|number| MAGNITUDES.contains(number));
    number.ok_or_else(|| "give a positive number, 1e-18 to 1e18".into())
}

/// The file of a picture: its name decides its kind.
pub fn picture(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|suffix| suffix == "svg" || suffix == "png");
    known.then_some(path).ok_or_else(|| "name the picture .svg or .png".into())
}

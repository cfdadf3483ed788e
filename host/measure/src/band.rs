//! `--band LO:HI`.

/// The band that a user typed, in hertz, low end first.
pub fn parse(text: &str) -> Result<(f64, f64), String> {
    let ends =
        text.split_once(':').and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    let ends = ends.filter(|&(low, high): &(f64, f64)| low <= high);
    ends.ok_or_else(|| "give two frequencies in hertz, low end first: LO:HI, as 300:2500".into())
}

/// A band between two bins holds nothing that could be searched.
pub fn holds_a_bin(
    band_hz: Option<(f64, f64)>,
    rate_hz: f64,
    n: usize,
    iq: bool,
) -> Result<(), String> {
    let Some((low, high)) = band_hz else { return Ok(()) };
    let bin_hz = rate_hz / n as f64;
    let lowest = if iq { -rate_hz / 2.0 } else { 0.0 };
    // A band outside of the spectrum is reported elsewhere.
    if high < lowest || low > rate_hz / 2.0 || (low / bin_hz).ceil() <= (high / bin_hz).floor() {
        return Ok(());
    }
    Err(format!(
        "--band {low}:{high} lies between two bins, which are {bin_hz:.6} Hz apart at N = {n}: widen it, or choose a larger --n"
    ))
}

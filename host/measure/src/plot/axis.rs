//! An axis of a chart: where values lie, and which have a label.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::prelude::Ranged;

/// A quantity along one side of a chart.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is, and its unit.
    pub label: &'static str,
    /// The ends.
    pub range: (f64, f64),
    /// Whether equal steps are equal ratios.
    pub log: bool,
}

impl Axis {
    /// An axis with equal differences at equal distances.
    pub const fn linear(label: &'static str, from: f64, to: f64) -> Self {
        Axis { label, range: (from, to), log: false }
    }

    /// An axis with equal ratios at equal distances.
    pub const fn log(label: &'static str, from: f64, to: f64) -> Self {
        Axis { label, range: (from, to), log: true }
    }

    /// Where a value lies.
    pub fn place(&self, value: f64) -> f64 {
        if self.log { value.log10() } else { value }
    }

    /// Whether a value lies on it. Another, or none, is not drawn.
    pub fn holds(&self, value: f64) -> bool {
        (self.range.0..=self.range.1).contains(&value)
    }

    /// Values worth a label: `count` or so.
    fn ticks(&self, count: usize) -> Vec<f64> {
        let (low, high) = self.range;
        if self.log {
            let (from, to) = (low.log10().floor() as i32, high.log10().ceil() as i32);
            let every = ((to - from) / (count as i32 - 1).max(1)).max(1);
            let steps: &[f64] = if to - from <= 3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let decades = (from..=to).filter(|decade| decade % every == 0);
            let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
            return all.filter(|x| *x >= low * 0.999 && *x <= high * 1.001).collect();
        }
        let rough = (high - low) / count as f64;
        let unit = 10f64.powf(rough.log10().floor());
        let step = unit
            * [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().find(|s| s * unit >= rough).unwrap_or(10.0);
        let (from, to) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        (from..=to).map(|k| k as f64 * step).collect()
    }
}

/// Plotters asks where values lie, in places from `Axis::place`, and for the ticks.
impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, pixels: (i32, i32)) -> i32 {
        let (low, high) = (self.place(self.range.0), self.place(self.range.1));
        let share = (place - low) / (high - low);
        pixels.0 + (share * f64::from(pixels.1 - pixels.0)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        self.ticks(hint.bold_points()).into_iter().map(|value| self.place(value)).collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.place(self.range.0)..self.place(self.range.1)
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, place: &f64) -> String {
        label(*place, self)
    }
}

/// A tick's label, from its place on the axis.
fn label(place: f64, axis: &Axis) -> String {
    let value = if axis.log { 10f64.powf(place) } else { place };
    let size = value.abs();
    if !axis.log && size < 1e-12 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').into()
        } else {
            text
        }
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            Axis::linear("", -10.0, 60.0).ticks(8),
            [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]
        );
        assert_eq!(Axis::linear("", -0.5, 0.5).ticks(8).len(), 5);
        assert_eq!(Axis::log("", 0.9, 30.0).ticks(8), [1.0, 2.0, 5.0, 10.0, 20.0]);
        let decades = Axis::log("", 1e-6, 1.0).ticks(8);
        assert_eq!(decades.len(), 7);
        assert!(decades.iter().all(|x| (1e-6..=1.001).contains(x)));
    }

    #[test]
    fn labels_are_short() {
        let (linear, log) = (Axis::linear("", 0.0, 1.0), Axis::log("", 0.1, 1.0));
        assert_eq!(label(0.25, &linear), "0.25");
        assert_eq!(label(-20.0, &linear), "-20");
        assert_eq!(label(-6.0, &log), "1e-6");
        assert_eq!(label(3.0, &log), "1000");
    }
}

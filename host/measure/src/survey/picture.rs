//! A recording as a picture: what was measured, over the spectrogram, or the spectrum if no way was consistent.

use super::Survey;
use super::nature::TRIED;
use super::trial::{Shot, Way};
use crate::analyze::cut::Cut;
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::{recording, spectrogram};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::tone::fit::Reach;
use std::path::Path;

/// Points of the drawn spectrum: each is the strongest of its bins.
const POINTS: usize = 800;
/// Answers with error bars that a picture can show.
const BARS: usize = 300;

impl Survey {
    /// Draws the recording, which was read by these options.
    pub fn draw(
        &self,
        file: &Path,
        read: recording::Options,
        picture: (&Path, Output),
    ) -> Result<(), String> {
        match &self.finding.held {
            Some((way, _, shots)) if !shots.is_empty() => {
                self.answers(file, read, (way, shots), picture)
            }
            _ => self.spectrum(file, picture),
        }
    }

    /// The answers of a way with their sigmas, over the spectrogram of what they were tried on.
    fn answers(
        &self,
        file: &Path,
        read: recording::Options,
        (way, shots): (&Way, &[Shot]),
        (picture, output): (&Path, Output),
    ) -> Result<(), String> {
        let end = self.samples.min(TRIED);
        let n = way.n;
        let cut = Cut {
            read,
            n,
            hop: (end / 720).clamp(n / 4, n).max(1),
            skip: 0,
            band_hz: Some(self.seen_hz(way, shots)),
            codes: Codes::signed::<16>(),
            reach: Reach::Sixteen,
            width: Default::default(),
        };
        let field = spectrogram::field(file, &cut, Some(end as u64))?;
        let each = shots.len().div_ceil(BARS);
        let some = || shots.iter().step_by(each);
        let label = match each {
            1 => "answers and sigma".to_owned(),
            each => format!("one of {each} answers"),
        };
        let points = some().map(|shot| (shot.middle / self.rate_hz, shot.hz));
        let answers = Series::new(label, Style::Points, 1, points);
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let chart = Chart {
            name: "answers",
            title: format!("{name}, N = {n}"),
            x: Axis::linear("time, s", field.x.0, field.x.1),
            y: Axis::linear("frequency, Hz", field.y.0, field.y.1),
            series: vec![answers.with_errors(some().map(|shot| shot.sigma_hz))],
        };
        chart.save_over(Some(&field), picture, output)
    }

    /// The band of the answers, and some bins around.
    fn seen_hz(&self, way: &Way, shots: &[Shot]) -> (f64, f64) {
        let hz = || shots.iter().map(|shot| shot.hz);
        let (low, high) =
            (hz().fold(f64::INFINITY, f64::min), hz().fold(f64::NEG_INFINITY, f64::max));
        let margin = (0.3 * (high - low)).max(12.0 * self.rate_hz / way.n as f64);
        let half = self.rate_hz / 2.0;
        ((low - margin).max(if self.iq { -half } else { 0.0 }), (high + margin).min(half))
    }

    /// The spectrum with its floor.
    fn spectrum(&self, file: &Path, (picture, output): (&Path, Output)) -> Result<(), String> {
        let bottom = self.power.iter().map(|p| p.2).fold(f64::INFINITY, f64::min);
        let top = self.power.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let (bottom, top) = ((bottom / 10.0).floor() * 10.0 - 10.0, (top / 10.0).ceil() * 10.0);
        let together = self.power.len().div_ceil(POINTS);
        let points = |value: fn(&(f64, f64, f64)) -> f64| {
            self.power.chunks(together).map(move |bins| {
                let highest = bins.iter().map(value).fold(bottom, f64::max);
                (bins[0].0, highest)
            })
        };
        let half = self.rate_hz / 2.0;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let marks = self.lines.iter().map(|line| {
            let nearest = self.power.iter().min_by(|a, b| {
                (a.0 - line.frequency_hz).abs().total_cmp(&(b.0 - line.frequency_hz).abs())
            });
            (line.frequency_hz, nearest.map_or(bottom, |point| point.1))
        });
        let chart = Chart {
            name: "spectrum",
            title: format!("Spectrum of {name}, N = {}", self.n),
            x: Axis::linear("frequency, Hz", if self.iq { -half } else { 0.0 }, half),
            y: Axis::linear("dB of a full-scale sine", bottom, top),
            series: vec![
                Series::new("spectrum", Style::Line, 0, points(|p| p.1)),
                Series::new("floor", Style::Dashed, 1, points(|p| p.2)),
                Series::new("lines", Style::Points, 2, marks),
            ],
        };
        chart.save(picture, output)
    }
}

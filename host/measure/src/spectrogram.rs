//! The tracks of a recording, drawn over its spectrogram.

use crate::analyze::cut::Cut;
use crate::follow::{Sighting, Trail};
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::plot::field::{Field, SHADES};
use crate::recording::Recording;
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use std::f64::consts::TAU;
use std::path::Path;

/// Cells side by side and above each other, at most.
const COLUMNS: usize = 360;
const ROWS: usize = 160;

/// Tracks with a line in the legend, the longest; the others share one.
const NAMED: usize = 6;

/// The lightest shade is so far above the median of all cells in dB, the darkest so far above that.
const LIGHTEST_DB: f64 = 6.0;
const SPAN_DB: f64 = 34.0;

/// Draws what [`crate::follow::run`] found in `file`.
pub fn draw(
    file: &Path,
    cut: &Cut,
    sightings: &[Sighting],
    trails: &[Trail],
    (picture, output): (&Path, Output),
) -> Result<(), String> {
    let field = field(file, cut, None)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let chart = Chart {
        name: "tracks",
        title: format!("Tracks in {name}, N = {}", cut.n),
        x: Axis::linear("time, s", field.x.0, field.x.1),
        y: Axis::linear("frequency, Hz", field.y.0, field.y.1),
        series: series(sightings, trails),
    };
    chart.save_over(Some(&field), picture, output)
}

/// The longest tracks in the order of their numbers, then all others.
fn series(sightings: &[Sighting], trails: &[Trail]) -> Vec<Series> {
    let mut longest: Vec<&Trail> = trails.iter().collect();
    longest.sort_by_key(|trail| std::cmp::Reverse(trail.blocks));
    let (named, others) = longest.split_at(longest.len().min(NAMED));
    let mut named = named.to_vec();
    named.sort_by_key(|trail| trail.track);
    // Colours 6 and 7 of the chart are greys and browns.
    let points = |trail: &Trail| -> Vec<(f64, f64)> {
        let own = sightings.iter().filter(|sighting| sighting.track == trail.track);
        own.map(|sighting| (sighting.time_s, sighting.frequency_hz)).collect()
    };
    let mut series: Vec<Series> = named
        .iter()
        .enumerate()
        .map(|(colour, trail)| {
            let label =
                format!("track {}: {:.1} to {:.1} s", trail.track, trail.from_s, trail.to_s);
            Series::new(label, Style::Line, COLOURS[colour % NAMED], points(trail))
        })
        .collect();
    if !others.is_empty() {
        let label = format!("{} shorter tracks", others.len());
        let all = others.iter().flat_map(|trail| points(trail));
        series.push(Series::new(label, Style::Points, 7, all));
    }
    series
}

/// The chart's colours, those that differ most first.
const COLOURS: [usize; NAMED] = [1, 0, 2, 3, 4, 5];

/// The spectrogram in the band that was searched, through Hann's window, of the whole file or of this many samples: each cell is the
/// strongest of its bins.
pub fn field(file: &Path, cut: &Cut, most: Option<u64>) -> Result<Field, String> {
    let text = |error: crate::recording::RecordingError| error.to_string();
    let recording = Recording::open(file, cut.read).map_err(text)?;
    let (n, rate_hz, iq) = (cut.n, recording.rate_hz(), recording.iq());
    let half = rate_hz / 2.0;
    let (low, high) = cut.band_hz.unwrap_or((if iq { -half } else { 0.0 }, half));
    let bin = |hertz: f64| (hertz * n as f64 / rate_hz).round() as i64;
    let bins = (bin(low)..=bin(high)).collect::<Vec<_>>();
    let rows = bins.len().min(ROWS);
    let transform = f64::forward(n);
    let window = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    let mut blocks = recording.blocks(n, cut.hop, cut.skip);
    let mut powers = Vec::new();
    let mut end = 0;
    while let Some((start, samples)) = blocks.next_block().map_err(text)? {
        let mean = samples.iter().map(|s| s.value).sum::<Complex<f64>>() / n as f64;
        let windowed = samples.iter().enumerate().map(|(k, s)| (s.value - mean) * window(k));
        let mut spectrum: Vec<Complex<f64>> = windowed.collect();
        transform.process(&mut spectrum);
        let power = |k: &i64| spectrum[k.rem_euclid(n as i64) as usize].norm_sqr();
        let cells = (0..rows).map(|row| {
            let cell = &bins[row * bins.len() / rows..(row + 1) * bins.len() / rows];
            cell.iter().map(power).fold(0.0, f64::max)
        });
        powers.extend(cells.map(|power| 10.0 * (power + 1e-12).log10()));
        end = start + cut.hop as u64;
        if most.is_some_and(|most| end + n as u64 > most) {
            break;
        }
    }
    let powers = narrowed(&powers, rows);
    let time = |sample: u64| sample as f64 / rate_hz;
    Ok(Field {
        x: (time(cut.skip), time(end.max(cut.skip + 1))),
        y: (low, high),
        rows,
        shades: shades(&powers),
    })
}

/// No more columns than the picture has: several become their strongest.
fn narrowed(powers: &[f64], rows: usize) -> Vec<f64> {
    let columns: Vec<&[f64]> = powers.chunks_exact(rows.max(1)).collect();
    let count = columns.len().min(COLUMNS);
    let column = |index: usize| {
        let several = &columns[index * columns.len() / count..(index + 1) * columns.len() / count];
        (0..rows).map(move |row| several.iter().map(|c| c[row]).fold(f64::MIN, f64::max))
    };
    (0..count).flat_map(column).collect()
}

fn shades(powers: &[f64]) -> Vec<u8> {
    let mut sorted = powers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let shade = |power: &f64| {
        let share = (power - median - LIGHTEST_DB) / SPAN_DB;
        // A cast saturates below.
        (share * f64::from(SHADES)).min(f64::from(SHADES - 1)) as u8
    };
    powers.iter().map(shade).collect()
}

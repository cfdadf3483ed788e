//! A drive as a person looks at it: a table and two plots.

use super::{Row, Summary};
use crate::demo::answer::Answer;
use crate::demo::measure::N;
use crate::demo::options::Options;
use crate::demo::table::table;
use crate::demo::{DemoError, said};
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::drive::{CYCLE_S, CYCLES, Scene};
use comfy_table::{Cell, CellAlignment};
use picket_dsp::tone::Verdict;
use std::path::{Path, PathBuf};

/// The drive's last lines, as a person reads them.
pub(super) fn text(summary: &Summary) -> String {
    let numbers: Vec<_> = summary.numbers.iter().map(u16::to_string).collect();
    format!(
        "tracked in {} of {} chirps, as number {}\n\
           good but off by 2 m or 1 m/s   chirp alone {}, tracked {}\n\
           range rms                      chirp alone {:.2} cm, tracked {:.2} cm\n\
           velocity rms                   chirp alone {:.2} cm/s, tracked {:.2} cm/s\n",
        summary.tracked,
        summary.chirps,
        numbers.join(", then "),
        summary.single_wrong,
        summary.tracked_wrong,
        100.0 * summary.single_rms_range_m,
        100.0 * summary.tracked_rms_range_m,
        100.0 * summary.single_rms_velocity_mps,
        100.0 * summary.tracked_rms_velocity_mps
    )
}

pub(super) fn print(rows: &[Row], summary: &Summary, options: &Options) {
    outln!(
        "A drive before a 77 GHz radar: 303 MHz in 1.01 ms, 12 bits at 1.024 MS/s, N = {N} per ramp, 20 chirps a second, seed {}\n",
        options.seed
    );
    let mut table = table(&[
        "time s",
        "SNR dB",
        "true m",
        "m/s",
        "chirp alone m",
        "m/s",
        "verdict",
        "tracked m",
        "+-",
        "m/s",
        "+-",
        "verdict",
    ]);
    let answer = |answer: &Option<Answer>, sigmas: bool| -> Vec<String> {
        let Some(a) = answer else {
            return vec!["-".into(); if sigmas { 5 } else { 3 }];
        };
        let verdict = a.verdict.to_string();
        if sigmas {
            vec![
                format!("{:.3}", a.range_m),
                format!("{:.3}", a.sigma_range_m),
                format!("{:.3}", a.velocity_mps),
                format!("{:.3}", a.sigma_velocity_mps),
                verdict,
            ]
        } else {
            vec![format!("{:.3}", a.range_m), format!("{:.3}", a.velocity_mps), verdict]
        }
    };
    for row in rows.iter().step_by(20) {
        let mut cells = vec![
            format!("{:.1}", row.time_s),
            row.snr_db.map_or("none".into(), |snr| format!("{snr:.1}")),
            format!("{:.3}", row.truth_range_m),
            format!("{:.3}", row.truth_velocity_mps),
        ];
        cells.extend(answer(&row.single, false));
        cells.extend(answer(&row.tracked, true));
        let right = |cell: String| Cell::new(cell).set_alignment(CellAlignment::Right);
        table.add_row(cells.into_iter().map(right));
    }
    outln!("{}\n", table.trim_fmt());
    out!("{}", text(summary));
}

/// Draws the ranges to `file` and the velocities beside it.
pub(super) fn draw(rows: &[Row], file: &Path, output: Output) -> Result<(), DemoError> {
    let single = |take: fn(&Answer) -> f64| {
        rows.iter()
            .filter_map(move |row| {
                row.single
                    .as_ref()
                    .filter(|a| a.verdict != Verdict::Weak.name())
                    .map(|a| (row.time_s, take(a)))
            })
            .collect::<Vec<_>>()
    };
    let tracked = |take: fn(&Answer) -> f64| {
        let all = rows.iter().flat_map(|row| row.targets.iter().map(move |t| (row.time_s, t.1)));
        all.map(move |(time, answer)| (time, take(&answer))).collect::<Vec<_>>()
    };
    let other: Vec<_> = rows
        .iter()
        .filter_map(|row| {
            Scene::at(row.time_s).other.map(|(range, speed)| (row.time_s, range, speed))
        })
        .collect();
    let end = CYCLES as f64 * CYCLE_S;
    let ranges = Chart {
        name: "drive-range",
        title: "A drive at 77 GHz: range".into(),
        x: Axis::linear("time, s", 0.0, end),
        y: Axis::linear("range, m", 0.0, 200.0),
        series: vec![
            Series::new("chirp alone, not weak", Style::Points, 6, single(|a| a.range_m)),
            Series::new("tracked", Style::Points, 0, tracked(|a| a.range_m)),
            Series::new("truth", Style::Line, 1, rows.iter().map(|r| (r.time_s, r.truth_range_m))),
            Series::new("truth, another car", Style::Dashed, 2, other.iter().map(|o| (o.0, o.1))),
        ],
    };
    let velocities = Chart {
        name: "drive-velocity",
        title: "A drive at 77 GHz: velocity".into(),
        y: Axis::linear("velocity towards the radar, m/s", -16.0, 16.0),
        series: vec![
            Series::new("chirp alone, not weak", Style::Points, 6, single(|a| a.velocity_mps)),
            Series::new("tracked", Style::Points, 0, tracked(|a| a.velocity_mps)),
            Series::new(
                "truth",
                Style::Line,
                1,
                rows.iter().map(|r| (r.time_s, r.truth_velocity_mps)),
            ),
            Series::new("truth, another car", Style::Dashed, 2, other.iter().map(|o| (o.0, o.2))),
        ],
        ..ranges.clone()
    };
    save_both(&ranges, &velocities, file, output)
}

/// Saves one chart to `file` and the one of velocities beside it.
pub(in crate::demo) fn save_both(
    chart: &Chart,
    velocities: &Chart,
    file: &Path,
    output: Output,
) -> Result<(), DemoError> {
    chart.save(file, output).map_err(said)?;
    velocities.save(&beside(file), output).map_err(said)
}

/// Whether both can be saved.
pub(in crate::demo) fn check_both(file: &Path, output: Output) -> Result<(), DemoError> {
    output.check(file, &[]).and_then(|()| output.check(&beside(file), &[])).map_err(said)
}

/// The file of velocities.
fn beside(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let suffix = file.extension().unwrap_or_default().to_string_lossy().into_owned();
    file.with_file_name(format!("{stem}-velocity.{suffix}"))
}

//! `lab report`: the figures and tables of both papers and our own, computed again: one page, and every picture
//! as a file.

pub mod command;
pub mod count;
mod direction;
mod impaired;
pub mod lab;
mod lidar;
pub mod limits;
mod operations;
mod outcomes;
pub mod over_snr;
pub mod page;
mod rough;
mod targets;
mod velocimeter;
pub mod verdicts;

use crate::output::Output;
use crate::progress;
use lab::{Check, Lab, Section};
use std::fs;
use std::path::Path;

/// The seed by default.
pub const SEED: u64 = 2026;

/// A part: what makes it, and how many sweeps it runs.
type Part = (fn(&Lab) -> Result<Section, String>, u64);

/// The parts, in the order of the page.
const PARTS: [Part; 16] = [
    (over_snr::over_snr, over_snr::OVER_SNR),
    (verdicts::verdicts, 0),
    (impaired::impaired, impaired::IMPAIRED),
    (limits::ratios, limits::RATIOS),
    (limits::image_floors, limits::IMAGE_FLOORS),
    (limits::outliers, limits::OUTLIERS),
    (limits::fixed_point, limits::FIXED_POINT),
    (lidar::spectrum, 0),
    (operations::operations, 0),
    (lidar::across_a_bin, lidar::ACROSS_A_BIN),
    (targets::targets, targets::TARGETS),
    (direction::direction, direction::DIRECTION),
    (velocimeter::crossings, velocimeter::CROSSINGS),
    (velocimeter::three_ratios, velocimeter::THREE_RATIOS),
    (velocimeter::turntable, velocimeter::TURNTABLE),
    (rough::rough, rough::ROUGH),
];

/// Computes everything and writes `report.html` and each picture as SVG and PNG into `folder`. Gives what was checked.
pub fn write(folder: &Path, output: Output, quick: bool, seed: u64) -> Result<Vec<Check>, String> {
    output.check_folder(folder)?;
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let bar = progress::bar(PARTS.iter().map(|part| part.1).sum(), "sweeps");
    let lab = Lab { quick, seed, bar };
    let sections: Vec<Section> =
        PARTS.iter().map(|(part, _)| part(&lab)).collect::<Result<_, _>>()?;
    lab.bar.finish_and_clear();
    let save = |name: String, bytes: Vec<u8>| output.write(&folder.join(name), &bytes);
    for chart in sections.iter().flat_map(|section| &section.charts) {
        save(format!("{}.svg", chart.name), chart.svg()?.into())?;
        save(format!("{}.png", chart.name), chart.png()?)?;
    }
    for outcomes in sections.iter().filter_map(|section| section.outcomes.as_ref()) {
        save(format!("{}.svg", outcomes.name), outcomes.svg()?.into())?;
        save(format!("{}.png", outcomes.name), outcomes.png()?)?;
    }
    save("report.html".into(), page::page(&sections, &lab)?.into())?;
    Ok(sections.into_iter().flat_map(|section| section.checks).collect())
}

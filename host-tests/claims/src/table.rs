//! The one runner: all cases in parallel, one table.

use crate::case::Case;
use crate::figures::long;
use crate::limit::{Asked, Judged};
use crate::measure::trial;
use crate::rows;
use crate::seen::Trial;
use rayon::prelude::*;

/// A number of the environment.
fn set(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// A seed of its own for each label up to its first `|`, by FNV-1a: cases that differ in what is behind it have the same records.
fn seed(label: &str) -> u64 {
    let own = set("PICKET_SEED").map_or(0, |text| text.parse().unwrap_or(0));
    let label = label.split('|').next().unwrap_or(label);
    label.bytes().fold(0xCBF2_9CE4_8422_2325 ^ own, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    })
}

/// Runs the cases and prints a row for each thing that is asked of each. Gives what was seen, in their order; the test fails if
/// something is not as it was asked.
///
/// # Panics
/// Something is not as it was asked, or a scene cannot be.
pub fn hold(cases: Vec<Case>) -> Vec<Vec<f64>> {
    hold_together("", cases, &[])
}

/// The same, and what must come out of the trials of all of the cases together.
///
/// # Panics
/// See [`hold`].
pub fn hold_together(label: &str, cases: Vec<Case>, together: &[Asked]) -> Vec<Vec<f64>> {
    let only = set("PICKET_CLAIM");
    let longer = if long() { 10 } else { 1 };
    let chosen = |case: &Case| only.as_ref().is_none_or(|text| case.label.contains(text.as_str()));
    let run = |mut case: Case| {
        if !chosen(&case) {
            return ((case.label, Vec::new()), Vec::new());
        }
        case.scene.seed = seed(&case.label);
        case.trials *= longer;
        let trials: Vec<Trial> =
            (0..case.trials).into_par_iter().map(|number| trial(&case, number)).collect();
        ((case.label, judged(&case.asked, &trials)), trials)
    };
    let (mut rows, trials): (Vec<Row>, Vec<Vec<Trial>>) = cases.into_par_iter().map(run).unzip();
    let all = trials.concat();
    if !all.is_empty() && !together.is_empty() {
        rows.push((label.to_owned(), judged(together, &all)));
    }
    let mut failed = String::new();
    for (label, of) in &rows {
        for (asked, judged) in of {
            let mark = if judged.holds { "  " } else { "!!" };
            let line = format!("{mark} {label:64} {asked:48} {}\n", asked.seen(judged));
            print!("{line}");
            if !judged.holds {
                failed += &line;
            }
        }
    }
    assert!(failed.is_empty(), "not as asked:\n{failed}");
    // Of other records or of some of the cases there is no table.
    if only.is_none() && set("PICKET_SEED").is_none() {
        rows::hold(&rows);
    }
    rows.iter().map(|(_, of)| of.iter().map(|(_, judged)| judged.value).collect()).collect()
}

/// A case's label, and what came of each thing that is asked of it.
pub(crate) type Row = (String, Vec<(Asked, Judged)>);

fn judged(asked: &[Asked], trials: &[Trial]) -> Vec<(Asked, Judged)> {
    asked.iter().map(|asked| (*asked, asked.judge(trials))).collect()
}

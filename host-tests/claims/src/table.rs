//! The one runner: all cases in parallel, one table.

use crate::case::Case;
use crate::figures::long;
use crate::limit::{Asked, Judged};
use crate::measure::trial;
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
            return (String::new(), Vec::new(), Vec::new());
        }
        case.scene.seed = seed(&case.label);
        case.trials *= longer;
        let trials: Vec<Trial> =
            (0..case.trials).into_par_iter().map(|number| trial(&case, number)).collect();
        let (text, values) = judged(&case.label, &case.asked, &trials);
        (text, values, trials)
    };
    let rows: Vec<(String, Vec<f64>, Vec<Trial>)> = cases.into_par_iter().map(run).collect();
    let mut text: String = rows.iter().map(|(text, ..)| text.as_str()).collect();
    let (mut values, mut all) = (Vec::new(), Vec::new());
    for (_, of_row, trials) in rows {
        values.push(of_row);
        all.extend(trials);
    }
    if !all.is_empty() && !together.is_empty() {
        let (of_all, of_together) = judged(label, together, &all);
        text += &of_all;
        values.push(of_together);
    }
    print!("{text}");
    let failed: Vec<&str> = text.lines().filter(|line| line.starts_with("!!")).collect();
    assert!(failed.is_empty(), "not as asked:\n{}", failed.join("\n"));
    values
}

/// A line for each thing that is asked, and the values.
fn judged(label: &str, asked: &[Asked], trials: &[Trial]) -> (String, Vec<f64>) {
    let judged: Vec<Judged> = asked.iter().map(|asked| asked.judge(trials)).collect();
    let line = |Judged { asked, seen, holds, .. }: &Judged| {
        let mark = if *holds { "  " } else { "!!" };
        format!("{mark} {label:64} {asked:36} {seen}\n")
    };
    (judged.iter().map(line).collect(), judged.iter().map(|judged| judged.value).collect())
}

//! Five kinds of recordings of `survey.rs`, by name: the command that `picket analyze FILE` proposes gives usable answers, 95 % of them within
//! three sigma, or `analyze` says that it does not know. `PICKET_TYPED_SEED` gives others.

use crate::cli::seed;
use crate::survey::{Outcome, folder, outcome};
use picket_simulator::Draw;

/// Recordings of each.
const DRAWN: usize = 4;

/// None is wrong; gives how many are right.
fn right(kind: &str, snr_db: Option<f64>) -> usize {
    let folder = folder(&format!("five-{kind}"));
    let mut draw = Draw::new(seed(45), 0);
    let outcomes: Vec<Outcome> =
        (0..DRAWN).map(|index| outcome(&folder, index, kind, snr_db, &mut draw)).collect();
    println!("{kind}: {outcomes:?}");
    assert!(!outcomes.contains(&Outcome::Wrong), "{kind}: {outcomes:?}");
    outcomes.iter().filter(|&&outcome| outcome == Outcome::Right).count()
}

#[test]
fn an_accelerating_target() {
    assert_eq!(right("accelerating", Some(26.0)), DRAWN);
}

#[test]
fn a_walker_before_an_hb100_with_mains_hum() {
    assert!(right("walker", None) > 0);
}

#[test]
fn bursts() {
    assert_eq!(right("bursts", None), DRAWN);
}

#[test]
fn fmcw() {
    assert_eq!(right("chirps", None), DRAWN);
}

#[test]
fn slow_fm() {
    assert_eq!(right("slow-fm", None), DRAWN);
}

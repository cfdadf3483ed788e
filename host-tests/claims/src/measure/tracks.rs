//! Tracks from block to block.

use super::against::Against;
use super::samples;
use crate::case::Case;
use crate::seen::{Seen, Trial};
use picket_dsp::solve::track::{State, Track};
use picket_dsp::{Record, Segment, Stamp, Tracker, Usable};
use picket_simulator::Run;
use std::collections::BTreeSet;

pub(super) fn trial<R: Record, const N: usize>(
    case: &Case,
    run: &mut Run,
    tracker: &mut Tracker<R, N>,
    settled: usize,
    more: usize,
) -> Trial {
    let mut trial = Trial::default();
    let mut numbers = BTreeSet::new();
    let mut first = None;
    for block in 0..settled + more {
        let samples = samples::<R, N>(run, block);
        let stamp = Stamp { sequence: block as u32, ..Stamp::default() };
        tracker.block(&stamp, &samples);
        if block < settled {
            continue;
        }
        let against = Against::new::<R>(case, run, block);
        let held = tracker.tracks(Segment::Continuous).iter();
        let held: Vec<&Track> = held.filter(|track| track.state == State::Held).collect();
        if held.is_empty() {
            trial.seen.push(Seen::NOTHING);
        }
        trial.seen.extend(held.iter().map(|track| against.tone(&track.tone)));
        let usable = held.iter().filter(|track| track.tone.verdict.usable() <= Usable::WithinSigma);
        numbers.extend(usable.map(|track| track.number));
        let holder = |source| {
            let near = |track: &&&Track| against.error(&track.tone, source).abs() < 1.5;
            held.iter().find(near).map(|track| track.number)
        };
        let holders: Vec<Option<u32>> = (0..against.lines.len()).map(holder).collect();
        match (holders.iter().all(Option::is_some), trial.held_after) {
            (true, None) => trial.held_after = Some(block + 1 - settled),
            (false, Some(_)) => trial.lost = true,
            _ => {}
        }
        let began = first.get_or_insert_with(|| holders.clone());
        trial.exchanged = holders.contains(&None) || *began != holders;
    }
    trial.identities = numbers.len();
    trial
}

//! What bounds each target of a frame of chirps, and why its verdict is what it is.

use super::Options;
use crate::analyze::chirps::{self, Finding};
use crate::analyze::frames::Found;
use crate::analyze::ranges;
use crate::cli::{self, decimals, figures};
use picket_dsp::frame::FramePlan;
use picket_dsp::solve::candidates::{Ambiguity, Decision};
use picket_dsp::solve::uncertainty::{Budget, Source, Uncertainty};
use picket_dsp::{Candidate, Verdict};
use serde_json::{Value, json};
use std::fmt::Write;
use std::process::ExitCode;

/// Two targets that are nearer than this in both directions, in cells, are not told apart.
const CROWDED: f32 = 2.0;
/// A fit reads so many cells on each side: what is nearer is taken out of them as well as it is known.
const READ: f32 = 16.0;

/// Measures the frames as `picket analyze` does, and explains one.
pub fn run(options: &Options, frame: u64) -> Result<ExitCode, String> {
    let Some(radar) = options.chirps.radar(&options.input) else {
        return Err("a frame needs --chirp-s, --bandwidth-hz and --carrier-hz".into());
    };
    let told = &options.told;
    if told.known_m.is_some() || told.displacement || told.trigger.is_some() || told.find_ramps {
        return Err(
            "--known-m, --displacement, --trigger and --find-ramps are options of picket analyze"
                .into(),
        );
    }
    let (cut, input) = (options.input.cut()?, &options.input);
    let mut all = Vec::new();
    let mut sink = |finding: &Finding| {
        if let Finding::Frame(found) = finding
            && found.frame == frame
        {
            all.push((**found).clone());
        }
    };
    let (tally, framed) = chirps::run(&input.file, &cut, input.n, &radar, told, &mut sink)?;
    if !framed {
        return Err("these chirps are measured one by one: add --chirps 64, of a sawtooth".into());
    }
    if frame >= tally.blocks {
        return Err(format!("the recording has {} frames, counted from 0", tally.blocks));
    }
    let targets: Vec<Explained> = (0..all.len()).map(|place| Explained::of(&all, place)).collect();
    if options.json {
        let targets: Vec<Value> = targets.iter().map(Explained::object).collect();
        cli::print_line(&json!({"frame": frame, "targets": targets}).to_string());
        return Ok(ExitCode::SUCCESS);
    }
    if targets.is_empty() {
        cli::print_line(&format!(
            "frame {frame}: no target; noise alone shows one in a frame of {:.0}",
            1.0 / limit(radar.false_alarm)
        ));
    }
    let least = limit(radar.false_alarm);
    targets.iter().for_each(|target| cli::print(&target.text(least)));
    Ok(ExitCode::SUCCESS)
}

/// The probability of a false alarm in a frame.
fn limit(told: Option<f64>) -> f64 {
    told.unwrap_or(1e-6)
}

/// Another target of the frame.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    number: usize,
    /// Distance in cells of the beat, and of the turn from chirp to chirp.
    cells: [f32; 2],
}

impl Neighbour {
    fn apart(&self) -> f32 {
        self.cells[0].max(self.cells[1])
    }
}

/// A target with what stands beside it.
#[derive(Debug)]
struct Explained<'a> {
    number: usize,
    found: &'a Found,
    budget: Budget,
    neighbours: Vec<Neighbour>,
    /// The amplitude of the loudest target of the frame.
    louder: f32,
}

/// What a louder target makes, see `picket_dsp::frame`.
const GHOST: &str = "a louder target may make it, as a harmonic or as one of two sidebands; or ";

impl<'a> Explained<'a> {
    fn of(all: &'a [Found], place: usize) -> Self {
        let found = &all[place];
        let cells = |other: &Found| {
            let plan = found.plan.as_ref()?;
            Some(apart(found, other, plan))
        };
        let mut neighbours: Vec<Neighbour> = all
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != place)
            .filter_map(|(other, found)| {
                Some(Neighbour { number: other + 1, cells: cells(found)? })
            })
            .filter(|neighbour| neighbour.apart() <= READ)
            .collect();
        neighbours.sort_by(|a, b| a.apart().total_cmp(&b.apart()));
        let noise = || Uncertainty::default().of_target(&found.found.target, 0.0);
        let budget = found.budget.unwrap_or_else(noise);
        let louder = all.iter().map(|found| found.found.line.tone.amplitude).fold(0.0, f32::max);
        Self { number: place + 1, found, budget, neighbours, louder }
    }

    /// Each reason of the target's verdict, and what it is here.
    fn reasons(&self) -> Vec<(Verdict, String)> {
        let seen = &self.found.found;
        let mut all = vec![seen.target.verdict, seen.line.tone.verdict];
        all.extend(seen.line.tone.also.iter());
        let mut told: Vec<Verdict> = Vec::new();
        for verdict in all {
            let plain = verdict == Verdict::Good && seen.target.verdict != Verdict::Good;
            if !plain && !told.contains(&verdict) {
                told.push(verdict);
            }
        }
        told.into_iter().map(|verdict| (verdict, self.reason(verdict))).collect()
    }

    fn reason(&self, verdict: Verdict) -> String {
        let target = &self.found.found.target;
        match (verdict, target.ambiguity) {
            (Verdict::Unresolved, _) => self.unresolved(),
            (Verdict::Ambiguous, Ambiguity::Several(candidates)) => format!(
                "{} velocities fit, and none has odds of 10000 to 1: narrow --velocity-mps, or settle it by a frame of another period.",
                candidates.iter().count()
            ),
            _ => verdict.reason().to_owned(),
        }
    }

    /// What makes a target unresolved.
    fn unresolved(&self) -> String {
        let target = &self.found.found.target;
        if let Some(near) = self.neighbours.first().filter(|near| near.apart() < CROWDED) {
            return format!(
                "target {} is {:.1} cells away, and two echoes within {CROWDED} cells are not told apart: more bandwidth, or a longer frame.",
                near.number,
                near.apart()
            );
        }
        if target.range < 0 {
            return "its range is below 0 m: no alias of the velocity has a place, or --mixing is the other one.".into();
        }
        let level = self.found.found.line.tone.amplitude;
        let ghost = if self.louder > 4.0 * level { GHOST } else { "" };
        format!(
            "{ghost}its place is beyond the bounds, or the fit of one echo leaves more than noise: another echo in its cell, or one that is no point."
        )
    }

    /// How the velocity was chosen among its aliases.
    fn aliases(&self) -> String {
        let target = &self.found.found.target;
        let [metres, speed] =
            [target.sigma_range, target.sigma_velocity].map(|sigma| decimals(sigma.into()));
        match target.ambiguity {
            Ambiguity::Decided(Decision::Bound) => {
                "  velocity: one alias is within the bounds\n".into()
            }
            Ambiguity::Several(candidates) => {
                let mut text = "  velocity: these aliases fit\n".to_owned();
                for Candidate { range, velocity, odds } in candidates.iter() {
                    let _ = writeln!(
                        text,
                        "    {range:.metres$} m, {velocity:.speed$} m/s: {:.2} %",
                        100.0 * odds
                    );
                }
                text
            }
            _ => "  velocity: its own movement in the frame decides between the aliases\n".into(),
        }
    }

    fn text(&self, least: f64) -> String {
        let Found { frame, found: seen, phase, .. } = self.found;
        let target = &seen.target;
        let [all_range, all_velocity] = self.budget.total().map(f64::from);
        let [range, of_range] = figures(target.range.to_num(), all_range);
        let velocity = target.velocity.unwrap_or_default().to_num();
        let [velocity, of_velocity] = figures(velocity, all_velocity);
        let mut text = format!(
            "frame {frame}, target {}: {range} ± {of_range} m, {velocity} ± {of_velocity} m/s, SNR {:.1} dB, {}\n",
            self.number,
            seen.line.tone.snr_db(),
            target.verdict
        );
        for (verdict, reason) in self.reasons() {
            let _ = writeln!(text, "  {verdict}: {reason} Usable: {}.", verdict.usable());
        }
        let _ = writeln!(
            text,
            "  {:<13} {:>10} {:>6} {:>13} {:>6}",
            "error by", "range m", "share", "velocity m/s", "share"
        );
        let whole = [all_range, all_velocity];
        let row = |name: &str, part: [f32; 2]| {
            let mut row = format!("  {name:<13}");
            for ((part, whole), width) in part.into_iter().zip(whole).zip([10, 13]) {
                let part = f64::from(part);
                let share = 100.0 * (part / whole.max(f64::MIN_POSITIVE)).powi(2);
                let _ = match part > 0.0 {
                    true => write!(row, " {part:>width$.2e} {share:>4.0} %"),
                    false => write!(row, " {:>width$} {:>6}", "-", "-"),
                };
            }
            row + "\n"
        };
        for part in &self.budget.parts {
            if part.source == Source::Noise || part.range > 0.0 || part.velocity > 0.0 {
                text += &row(part.source.name(), [part.range, part.velocity]);
            }
        }
        match self.found.budget {
            Some(_) => text += &row("all", self.budget.total()),
            None => text += "  what is not known of the radar comes on top: --uncertainty\n",
        }
        let tens = f64::from(seen.ln_chance) / std::f64::consts::LN_10;
        let _ = writeln!(
            text,
            "  noise alone shows such a target in a share of 1e{tens:.0} of the frames; at most {least:e} was asked"
        );
        text += &self.aliases();
        for near in &self.neighbours {
            let _ = writeln!(
                text,
                "  fitted together with target {}, {:.1} cells of range and {:.1} of velocity away",
                near.number, near.cells[0], near.cells[1]
            );
        }
        if let Some((answer, _)) = phase {
            let _ = match answer.is_sure() {
                true => {
                    let [range, sigma] = figures(answer.range.to_num(), answer.uncertainty.into());
                    writeln!(
                        text,
                        "  by phase: {range} ± {sigma} m, odds of the cycle {:.1e}",
                        answer.odds
                    )
                }
                false => writeln!(text, "{}", ranges::by_phase_of(answer).trim_start_matches('\n')),
            };
        }
        text + "\n"
    }

    fn object(&self) -> Value {
        let mut all = ranges::object(self.found);
        let neighbours = self.neighbours.iter().map(|near| {
            let [range, velocity] = near.cells;
            json!({"target": near.number, "range_cells": range, "velocity_cells": velocity})
        });
        let reasons = self.reasons().into_iter().map(|(verdict, reason)| {
            json!({"verdict": verdict.name(), "reason": reason, "usable": verdict.usable().name()})
        });
        all.insert("target".into(), json!(self.number));
        all.insert("neighbours".into(), neighbours.collect());
        all.insert("reasons".into(), reasons.collect());
        Value::Object(all)
    }
}

/// The distance between two targets in cells, of the beat and of the turn from chirp to chirp.
fn apart(one: &Found, other: &Found, plan: &FramePlan) -> [f32; 2] {
    let beats = [one, other].map(|it| it.found.line.tone.frequency.cycles_f32());
    let speeds =
        [one, other].map(|it| it.found.target.velocity.unwrap_or_default().to_num::<f32>());
    let turns = (speeds[0] - speeds[1]) / plan.alias_mps();
    let turns = turns - turns.round();
    [(beats[0] - beats[1]).abs() * plan.record() as f32, turns.abs() * plan.chirps() as f32]
}

//! The targets of frames of chirps as lines, for people and for programs: those that `picket analyze` prints.

use super::Style;
use super::line::{Told, WRONG_RATE};
use super::settings::from_answer;
use crate::analyze::chirps::Finding;
use crate::analyze::{Style as Printed, frames, ranges};
use crate::cli::print_line;
use crate::device::Said;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_wire::chirp_frame::{ChirpFrame, Found};
use serde::Serialize;

/// The frame whose targets come.
#[derive(Debug, Default)]
pub(super) struct Frames {
    frame: Option<ChirpFrame>,
    /// What is not known of the sensor, by its settings.
    uncertainty: Option<Uncertainty>,
    /// What stands above the targets that is written: of targets with their whole error, or of others.
    heading: Option<bool>,
}

impl Frames {
    /// Shows a frame.
    pub(super) fn frame(&mut self, frame: &ChirpFrame, style: Style) {
        self.frame = Some(*frame);
        match style {
            Style::Jsonl => print_line(&object(frame)),
            Style::Table if frame.targets == 0 => {
                print_line(&format!("{:>8} no target", frame.number));
            }
            Style::Teleplot => {
                print_line(&format!(">targets:{}", frame.targets));
                print_line(&format!(">passed:{}", frame.passed));
            }
            Style::Table | Style::Csv => {}
        }
    }

    /// Takes the settings.
    pub(super) fn hear(&mut self, said: &Said) {
        if let Said::Answer(_, Ok(body)) = said
            && let Some((settings, _)) = from_answer(body)
        {
            self.uncertainty = settings.uncertainty;
        }
    }

    /// Shows a target, and whether its rate is wrong. One whose frame was lost on the line is not shown.
    pub(super) fn target(&mut self, found: &Found, wrong_rate: bool, style: Style) {
        let Some(frame) = self.frame.filter(|frame| frame.number == found.frame) else { return };
        let style = match style {
            Style::Table => Printed::Text,
            Style::Csv => Printed::Csv,
            Style::Jsonl => Printed::Json,
            Style::Teleplot => {
                let (target, number) = (&found.found.target, found.place + 1);
                let velocity = target.velocity.unwrap_or_default();
                print_line(&format!(">target_{number}_m:{}", target.range));
                return print_line(&format!(">target_{number}_mps:{velocity}"));
            }
        };
        // A table's columns stay.
        let uncertainty = match (style, self.heading) {
            (Printed::Csv, Some(whole)) => whole.then(|| self.uncertainty.unwrap_or_default()),
            _ => self.uncertainty,
        };
        let budget = uncertainty.map(|known| known.of_target(&found.found.target, 0.0));
        let finding = Finding::Frame(Box::new(frames::Found {
            frame: frame.number.into(),
            chirp: frame.stamp.sequence.into(),
            found: found.found,
            budget,
            phase: None,
            also: wrong_rate.then_some(WRONG_RATE),
            plan: None,
        }));
        if self.heading.replace(budget.is_some()) != Some(budget.is_some()) {
            ranges::print_heading(&finding, style);
        }
        ranges::print(&finding, style);
    }
}

/// A frame as JSON.
#[derive(Serialize)]
struct Object {
    chirp_frame: bool,
    frame: u32,
    chirp: u32,
    time_s: f64,
    chirps: u16,
    passed: u32,
    clipped: u32,
    targets: u8,
    search_s: f32,
    rate_hz: f64,
    period_s: f64,
    lost: u32,
    faults: u32,
    #[serde(flatten)]
    told: Option<Told>,
}

fn object(frame: &ChirpFrame) -> String {
    let &ChirpFrame { number, stamp, chirps, passed, clipped, targets, rate_hz, period_s, .. } =
        frame;
    let object = Object {
        chirp_frame: true,
        frame: number,
        chirp: stamp.sequence,
        time_s: stamp.clock as f64 / rate_hz,
        chirps,
        passed,
        clipped,
        targets,
        search_s: frame.search_s,
        rate_hz,
        period_s,
        lost: frame.health.lost,
        faults: frame.health.faults,
        told: frame.basis.map(Told::of),
    };
    serde_json::to_string(&object).unwrap_or_default()
}

//! The whole error of the target that a design is for.

use super::sheet::{Design, Row};
use picket_dsp::Target;
use picket_dsp::fixed::types::I32F32;
use picket_dsp::solve::uncertainty::{Budget, Uncertainty};
use picket_measure::views;
use picket_wire::view;
use serde_json::{Value, json};

/// Blocks of the mean that is shown beside one block.
const MEAN: u32 = 100;

/// The parts of the error at a range and a velocity.
pub struct Whole {
    n: usize,
    target: Target,
    budget: Budget,
}

impl Whole {
    /// For the longest block of a design.
    pub fn of(
        design: &Design,
        known: &Uncertainty,
        [range, velocity]: [Option<f64>; 2],
    ) -> Option<Self> {
        let row: &Row = design.rows.last()?;
        let fixed = |x: f64| I32F32::checked_from_num(x);
        let target = Target {
            range: fixed(range.unwrap_or(0.0))?,
            velocity: Some(fixed(velocity.unwrap_or(0.0))?),
            sigma_range: row.sigma_m.unwrap_or(0.0) as f32,
            sigma_velocity: row.sigma_mps as f32,
            ..Target::default()
        };
        Some(Self { n: row.n, target, budget: known.of_target(&target, 0.0) })
    }

    /// As an object of JSON.
    pub fn json(&self) -> Value {
        let mut all = views::object(&view::Budget::from_budget(&self.budget));
        all.insert("n".into(), json!(self.n));
        json!({ "budget": all })
    }

    /// As lines for people.
    pub fn text(&self) -> String {
        let Self { n, target, budget } = self;
        let velocity = target.velocity.unwrap_or_default();
        let mut text = format!(
            "the whole error at {:.3} m and {velocity:.3} m/s, one standard deviation, N = {n}\n{:>24} {:>14} {:>14}\n",
            target.range, "", "range m", "velocity m/s"
        );
        let mut line = |name: &str, [range, velocity]: [f32; 2]| {
            text += &format!("{name:>24} {range:>14.3e} {velocity:>14.3e}\n");
        };
        for part in budget.parts.iter().filter(|part| part.range > 0.0 || part.velocity > 0.0) {
            line(part.source.name(), [part.range, part.velocity]);
        }
        line("all", budget.total());
        line(&format!("all, mean of {MEAN} blocks"), budget.of_mean(MEAN).total());
        text
    }
}

#[cfg(test)]
mod tests {
    use super::super::sheet::Question;
    use super::*;

    #[test]
    fn a_mean_lessens_the_noise_alone() {
        let question = Question {
            wavelength_m: 0.0125,
            rate_hz: Some(200e3),
            snr_db: 10.0,
            chirp: Some((200e6, 5e-3)),
            range_m: Some(30.0),
            ..Question::default()
        };
        let design = Design::of(question).unwrap();
        let known = Uncertainty { slope_ppm: 100.0, ..Uncertainty::default() };
        let whole = Whole::of(&design, &known, [Some(30.0), None]).unwrap();
        let slope = whole.json()["budget"]["slope_range_m"].as_f64().unwrap();
        assert!((slope - 3e-3).abs() < 1e-6, "{slope}");
        assert!(whole.budget.of_mean(1_000_000).total()[0] > 0.99 * 3e-3);
        assert!(whole.text().contains("slope") && !whole.text().contains("carrier"));
    }
}

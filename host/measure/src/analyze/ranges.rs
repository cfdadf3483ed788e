//! Targets of chirps and of frames as lines.

use super::Style;
use super::chirps::{Finding, Found};
use super::frames;
use crate::cli::{decimals, figures, print_line};
use crate::views;
use picket_dsp::Candidate;
use picket_dsp::solve::phase_range::PhaseRange;
use picket_dsp::tone::verdict::Verdict;
use picket_wire::view;
use serde_json::{Map, Value, json};

/// Prints what stands above the targets.
pub fn print_heading(finding: &Finding, style: Style) {
    match (finding, style) {
        (_, Style::Json) => {}
        (Finding::Chirp(_), _) => chirps_heading(style),
        (Finding::Frame(found), Style::Csv) => {
            let names: Vec<String> = cells(found).into_iter().map(|it| it.0).collect();
            print_line(&names.join(","));
        }
        (Finding::Frame(found), Style::Text) => {
            let sigma = if found.budget.is_some() { "+- all" } else { "sigma" };
            let phase = match found.phase {
                Some(_) => format!(" {:>14} {sigma:>10}", "by phase m"),
                None => String::new(),
            };
            print_line(&format!(
                "{:>8} {:>12} {sigma:>10}{phase} {:>13} {sigma:>10} {:>7}  verdict",
                "frame", "range m", "velocity m/s", "SNR dB"
            ));
        }
    }
}

/// Prints a target.
pub fn print(finding: &Finding, style: Style) {
    match (finding, style) {
        (Finding::Chirp(found), _) => print_chirp(found, style),
        (Finding::Frame(found), Style::Json) => {
            print_line(&Value::Object(object(found)).to_string())
        }
        (Finding::Frame(found), Style::Csv) => {
            let values: Vec<String> = cells(found).into_iter().map(|it| it.1).collect();
            print_line(&values.join(","));
        }
        (Finding::Frame(found), Style::Text) => print_line(&text(found)),
    }
}
fn chirps_heading(style: Style) {
    match style {
        Style::Json => {}
        Style::Csv => print_line(
            "chirp,time_s,frequency_hz,sigma_hz,range_m,sigma_range_m,velocity_mps,sigma_velocity_mps,snr_db,verdict",
        ),
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>14} {:>10} {:>12} {:>10} {:>13} {:>10} {:>7}  verdict",
            "chirp",
            "time s",
            "beat Hz",
            "sigma",
            "range m",
            "sigma",
            "velocity m/s",
            "sigma",
            "SNR dB"
        )),
    }
}

fn print_chirp(found: &Found, style: Style) {
    let Found { chirp, time_s, frequency_hz, sigma_hz, range_m, sigma_range_m, .. } = found;
    let Found { velocity_mps, sigma_velocity_mps, snr_db, verdict, .. } = found;
    match style {
        Style::Json => print_line(&serde_json::to_string(found).unwrap_or_default()),
        Style::Csv => {
            let [velocity, sigma] = [velocity_mps, sigma_velocity_mps]
                .map(|x| x.map_or(String::new(), |x| x.to_string()));
            print_line(&format!(
                "{chirp},{time_s},{frequency_hz},{sigma_hz},{range_m},{sigma_range_m},{velocity},{sigma},{snr_db},{verdict}"
            ));
        }
        Style::Text => {
            let [velocity, sigma] = match (velocity_mps, sigma_velocity_mps) {
                (Some(velocity), Some(sigma)) => figures(*velocity, *sigma),
                _ => ["-".into(), "-".into()],
            };
            let [beat, sigma_beat] = figures(*frequency_hz, *sigma_hz);
            let [range, sigma_range] = figures(*range_m, *sigma_range_m);
            print_line(&format!(
                "{chirp:>8} {time_s:>11.7} {beat:>14} {sigma_beat:>10} {range:>12} {sigma_range:>10} {velocity:>13} {sigma:>10} {snr_db:>7.1}  {verdict}"
            ));
        }
    }
}

/// A frame's target as JSON.
pub fn object(found: &frames::Found) -> Map<String, Value> {
    let mut all = Map::from_iter([
        ("frame".to_owned(), json!(found.frame)),
        ("chirp".to_owned(), json!(found.chirp)),
    ]);
    all.extend(views::object(&view::FrameTarget::from_found(&found.found)));
    if let Some(reason) = found.also
        && let Some(reasons) = all.entry("also").or_insert_with(|| json!([])).as_array_mut()
    {
        reasons.push(json!(reason));
    }
    if let Some(budget) = &found.budget {
        all.insert("budget".into(), views::object(&view::Budget::from_budget(budget)).into());
    }
    if let Some((answer, budget)) = &found.phase {
        let mut phase = views::object(&view::PhaseRange::from_answer(answer));
        if let Some(budget) = budget {
            phase.insert("budget".into(), views::object(&view::Budget::from_budget(budget)).into());
        }
        all.insert("phase".into(), phase.into());
    }
    all
}

/// A frame's target as names and values, the same names for each.
fn cells(found: &frames::Found) -> Vec<(String, String)> {
    let mut all = vec![
        ("frame".to_owned(), found.frame.to_string()),
        ("chirp".to_owned(), found.chirp.to_string()),
    ];
    all.extend(views::cells(&view::FrameTarget::from_found(&found.found), ""));
    if let Some(reason) = found.also
        && let Some((_, reasons)) = all.iter_mut().find(|(name, _)| name == "also")
    {
        *reasons = format!("{reasons} {reason}").trim_start().to_owned();
    }
    if let Some(budget) = &found.budget {
        all.extend(views::cells(&view::Budget::from_budget(budget), "budget_"));
    }
    if let Some((answer, budget)) = &found.phase {
        all.extend(views::cells(&view::PhaseRange::from_answer(answer), "phase_"));
        if let Some(budget) = budget {
            all.extend(views::cells(&view::Budget::from_budget(budget), "phase_budget_"));
        }
    }
    all
}

/// A frame's target for people: its numbers, then what else it may be, a line each.
fn text(found: &frames::Found) -> String {
    let frames::Found { frame, found: seen, budget, phase, .. } = found;
    let target = &seen.target;
    let [sigma_range, sigma_velocity] =
        budget.map_or([target.sigma_range, target.sigma_velocity], |budget| budget.total());
    let by_phase = phase.as_ref().map_or(String::new(), |(answer, budget)| {
        let sigma = budget.map_or(answer.uncertainty, |budget| budget.total()[0]);
        match answer.is_sure() {
            true => {
                let [range, sigma] = figures(answer.range.to_num(), sigma.into());
                format!(" {range:>14} {sigma:>10}")
            }
            false => format!(" {:>14} {:>10}", "-", "-"),
        }
    });
    let also = seen.line.tone.also.iter().filter(|verdict| *verdict != target.verdict);
    let own = [target.verdict, seen.line.tone.verdict];
    let mut verdicts = vec![own[0].name()];
    verdicts.extend((own[1] != own[0] && own[1] != Verdict::Good).then(|| own[1].name()));
    verdicts.extend(also.map(Verdict::name));
    verdicts.extend(found.also);
    let velocity = target.velocity.unwrap_or_default().to_num();
    let [sigma_range, sigma_velocity] = [sigma_range, sigma_velocity].map(f64::from);
    let [range, of_range] = figures(target.range.to_num(), sigma_range);
    let [velocity, of_velocity] = figures(velocity, sigma_velocity);
    let mut text = format!(
        "{frame:>8} {range:>12} {of_range:>10}{by_phase} {velocity:>13} {of_velocity:>10} {:>7.1}  {}",
        seen.line.tone.snr_db(),
        verdicts.join(", ")
    );
    let [metres, speed] = [sigma_range, sigma_velocity].map(decimals);
    for Candidate { range, velocity, odds } in target.ambiguity.candidates() {
        let odds = 100.0 * odds;
        text +=
            &format!("\n{:>8} {range:>12.metres$} m, {velocity:.speed$} m/s ({odds:.1} %)", "or");
    }
    if let Some((answer, _)) = phase.as_ref().filter(|(answer, _)| !answer.is_sure()) {
        text += &by_phase_of(answer);
    }
    text
}

/// The ranges that a phase leaves, the most probable first.
pub fn by_phase_of(answer: &PhaseRange) -> String {
    let all: Vec<_> = answer.candidates().collect();
    let shown = all
        .iter()
        .take(SHOWN)
        .map(|candidate| format!("{:.7} m ({:.1} %)", candidate.range, 100.0 * candidate.odds));
    let shown: Vec<String> = shown.collect();
    let more = match all.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    match shown.is_empty() {
        true => format!("\n{:>8} the tone has no range by phase", ""),
        false => format!("\n{:>8} by phase: {}{more}", "", shown.join(", ")),
    }
}

/// Candidates of a range by phase that people see.
const SHOWN: usize = 3;

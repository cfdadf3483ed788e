//! The causes of a joint fit, as rows of the table: the probability of each, and which joined the fit.

use super::rows::Row;
use picket_dsp::model::{Answer, Cause, Joined};

/// What a joint fit says: how probable it is that nothing more is there, and each cause, in its last round; then what followed.
pub fn rows(answer: &Answer) -> Vec<Row> {
    let row = |test, about, value, followed| Row {
        test,
        about,
        fit: Some("joint"),
        value,
        limit: None,
        unit: "",
        fired: false,
        decides: false,
        followed,
    };
    let [nothing, weights @ ..] = &answer.weights;
    let mut rows = vec![row(
        "nothing-more",
        "how probable it is that there is nothing else",
        Some(f64::from(*nothing)),
        "-".to_owned(),
    )];
    let joined: Vec<Joined> = answer.joined.into_iter().flatten().collect();
    for (cause, weight) in Cause::ALL.into_iter().zip(weights) {
        let rounds = (0..joined.len()).filter(|&round| joined[round].cause == cause);
        let rounds: Vec<String> = rounds.map(|round| round_of(&joined, round, answer)).collect();
        let followed = if rounds.is_empty() { "-".to_owned() } else { rounds.join("; ") };
        rows.push(row(cause.name(), about(cause), Some(f64::from(*weight)), followed));
    }
    let followed = match (answer.unresolved, answer.moves) {
        (true, _) => "the joint fit leaves too much: unresolved",
        (false, true) => "one tone that changes: moving",
        (false, false) => "one steady tone, and the causes that joined",
    };
    rows.push(Row {
        fired: answer.unresolved || answer.moves,
        decides: true,
        ..row("joint-fit", "result of the joint fit", None, followed.to_owned())
    });
    rows
}

/// What a round's cause did: its odds over nothing more, and sigma before and after.
fn round_of(joined: &[Joined], round: usize, answer: &Answer) -> String {
    let Joined { odds, sigma, .. } = joined[round];
    let then = joined.get(round + 1).map_or(answer.variance.sqrt(), |next| next.sigma);
    let powers = odds * std::f32::consts::LOG10_E;
    format!("joined in round {}: odds 1e{powers:.0}, sigma {sigma:.5} to {then:.5} bins", round + 1)
}

const fn about(cause: Cause) -> &'static str {
    match cause {
        Cause::Level => "how probable a further change of the level is",
        Cause::Bend => "how probable a further bend of the phase is, as in a sweep",
        Cause::Wander => "how probable a further phase that wanders or jumps is",
        Cause::Line => "how probable a further line is",
        Cause::Sidebands => "how probable two further lines as far below as above are",
    }
}

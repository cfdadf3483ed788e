//! The causes of a joint fit, as rows of the table: the probability of each, and which joined the fit.

use super::rows::Row;
use picket_dsp::model::{Answer, Cause};

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
    for ((cause, weight), kept) in Cause::ALL.into_iter().zip(weights).zip(answer.kept) {
        let followed = match kept {
            0 => "-".to_owned(),
            1 => "joined the fit".to_owned(),
            count => format!("joined the fit {count} times"),
        };
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

const fn about(cause: Cause) -> &'static str {
    match cause {
        Cause::Level => "how probable a further change of the level is",
        Cause::Bend => "how probable a further bend of the phase is, as in a sweep",
        Cause::Wander => "how probable a further phase that wanders or jumps is",
        Cause::Line => "how probable a further line is",
        Cause::Sidebands => "how probable two further lines as far below as above are",
    }
}

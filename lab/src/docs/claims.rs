//! The table of claims: `host-tests/claims.json`, which the tests write.

use super::figures::{head, row, whole};
use super::{Table, figures};
use serde_json::Value;

pub(super) const TABLES: &[Table] = &[Table::new("docs/claims.md", "rows", rows)];

/// A test's name as a sentence.
fn sentence(name: &str) -> String {
    let text = name.replace('_', " ");
    let (first, rest) = text.split_at(text.len().min(1));
    first.to_uppercase() + rest
}

/// A heading for each file of tests, and for each test its name, its command and its rows.
fn rows(_: &Table) -> Result<Vec<String>, String> {
    let all = figures::read("claims.json")?;
    let all = all.as_object().ok_or("claims.json has no tests")?;
    let (mut lines, mut last) = (Vec::new(), "");
    for (test, rows) in all {
        let (file, name) = test.split_once("::").ok_or("a test without a file")?;
        if file != last {
            lines.extend([format!("## {}", sentence(file)), String::new()]);
            last = file;
        }
        lines.extend([format!("**{}** (`{name}`)", sentence(name)), String::new()]);
        lines.extend(head("| claim | asked | cases | answers | seen |"));
        for of in rows.as_array().into_iter().flatten() {
            lines.push(cells(of).ok_or_else(|| format!("claims.json: {test}: {of}"))?);
        }
        lines.push(String::new());
    }
    lines.pop();
    Ok(lines)
}

fn cells(of: &Value) -> Option<String> {
    let text = |key: &str| of[key].as_str().map(|text| text.replace('|', ""));
    let count = |key: &str| of[key].as_f64().map(whole);
    let seen: Vec<f64> = of["seen"].as_array()?.iter().filter_map(Value::as_f64).collect();
    let seen = match *seen {
        [hits] => whole(hits),
        [least, most] if least == most => format!("{most}"),
        [least, most] => format!("{least} to {most}"),
        _ => return None,
    };
    Some(row([text("claim")?, text("asked")?, count("cases")?, count("of")?, seen]))
}

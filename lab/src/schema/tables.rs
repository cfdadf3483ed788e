//! The tables of `docs/protocol.md`.

use super::{Found, last};
use picket_wire::layout::{Form, Place, Structure};
use picket_wire::schema::{RECORDS, SETTINGS};

/// A table for each record, then for each structure that answers consist of.
pub fn answers() -> Vec<String> {
    let (answers, _) = structures();
    let mut lines = Vec::new();
    for structure in answers {
        let kind = RECORDS.iter().find(|(_, form)| is(form, structure));
        let kind = kind.map_or(String::new(), |(kind, _)| format!(" (kind {})", *kind as u8));
        lines.extend(table(structure, &kind));
    }
    lines.extend(choices(false));
    lines.pop();
    lines
}

/// The structures of settings, which answers do not have.
pub fn settings() -> Vec<String> {
    let (_, settings) = structures();
    let mut lines: Vec<String> =
        settings.into_iter().flat_map(|structure| table(structure, "")).collect();
    lines.extend(choices(true));
    lines.pop();
    lines
}

/// The names behind numbers.
pub fn names() -> Vec<String> {
    let mut lines = vec!["| name | numbers |".to_owned(), "|---|---|".to_owned()];
    for (name, numbers) in Found::all().names {
        let all: Vec<String> =
            numbers.iter().map(|(number, name)| format!("{number} {name}")).collect();
        lines.push(format!("| {name} | {} |", all.join(", ")));
    }
    lines
}

fn is(form: &Form, structure: &Structure) -> bool {
    matches!(form, Form::Structure(of) if of.name == structure.name)
}

/// The structures of answers, and those of settings.
fn structures() -> (Vec<&'static Structure>, Vec<&'static Structure>) {
    let all = Found::all().structures;
    let first = all.iter().position(|structure| is(&SETTINGS, structure)).unwrap_or(all.len());
    let (answers, settings) = all.split_at(first);
    (answers.to_vec(), settings.to_vec())
}

/// The table of a structure: its name and meaning, and a row for each field.
fn table(structure: &Structure, kind: &str) -> Vec<String> {
    let head = format!("**{}**{kind}: {}", last(structure.name), lower(structure.doc.trim()));
    let mut lines = vec![head, String::new()];
    lines.extend(rows(structure.fields));
    lines.push(String::new());
    lines
}

fn rows(fields: &[Place]) -> Vec<String> {
    let head = ["| field | form | meaning |".to_owned(), "|---|---|---|".to_owned()];
    let row = |place: &Place| {
        let absent = match place.absent {
            "" => String::new(),
            absent => format!(" Where it is absent: {absent}."),
        };
        format!("| {} | {} | {}{absent} |", place.name, spelt(&place.form), place.doc.trim())
    };
    head.into_iter().chain(fields.iter().map(row)).collect()
}

/// The choices: those of settings, or the others.
fn choices(of_settings: bool) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, cases) in Found::all().choices {
        if (name != "Outcome") != of_settings {
            continue;
        }
        lines.extend([format!("**{name}**, one of:"), String::new()]);
        lines.extend(["| number | case | fields |".to_owned(), "|---|---|---|".to_owned()]);
        for case in cases {
            let field = |place: &Place| {
                format!("{} {}: {}", place.name, spelt(&place.form), lower(place.doc.trim()))
            };
            let fields: Vec<String> = case.fields.iter().map(field).collect();
            let fields = match &case.inner {
                Some(inner) => format!("those of {}", spelt(inner)),
                None if fields.is_empty() => "none".to_owned(),
                None => fields.join(" "),
            };
            lines.push(format!("| {} | {} | {fields} |", case.number, case.name));
        }
        lines.push(String::new());
    }
    lines
}

fn spelt(form: &Form) -> String {
    match form {
        Form::Number(number) => (*number).to_owned(),
        Form::Name(name, _) => format!("u8, {name}"),
        Form::Structure(structure) => last(structure.name).to_owned(),
        Form::Choice(name, _) => (*name).to_owned(),
        Form::List(inner, most) => format!("list of {}, at most {most}", spelt(inner)),
        Form::Array(inner, count) => format!("{count} {}", spelt(inner)),
        Form::Option(inner) => format!("option of {}", spelt(inner)),
    }
}

fn lower(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.clone().next()) {
        // An abbreviation stays as it is.
        (Some(_), Some(second)) if second.is_uppercase() => text.to_owned(),
        (Some(first), _) => first.to_lowercase().chain(letters).collect(),
        _ => String::new(),
    }
}

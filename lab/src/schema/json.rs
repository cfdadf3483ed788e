//! `docs/schema.json`: for programs that read a board.

use super::{Found, last};
use picket_wire::layout::{Form, Place, VERSION};
use picket_wire::schema::{RECORDS, SETTINGS};
use serde_json::{Map, Value, json};

/// The schema as text, a record, structure or list of names a line.
pub fn text() -> String {
    let found = Found::all();
    let records = RECORDS.iter().map(|(kind, of)| {
        (format!("{}", *kind as u8), json!({ "name": format!("{kind:?}"), "form": form(of) }))
    });
    let structures = found.structures.iter().map(|structure| {
        let of = json!({ "doc": structure.doc.trim(), "fields": fields(structure.fields) });
        (last(structure.name).to_owned(), of)
    });
    let choices = found.choices.iter().map(|(name, cases)| {
        let case = |case: &picket_wire::layout::Case| {
            let mut of = json!({ "number": case.number, "name": case.name });
            match &case.inner {
                Some(inner) => of["form"] = form(inner),
                None => of["fields"] = fields(case.fields),
            }
            of
        };
        ((*name).to_owned(), cases.iter().map(case).collect())
    });
    let names = found.names.iter().map(|(name, names)| {
        let names = names.iter().map(|(number, name)| (number.to_string(), json!(name)));
        ((*name).to_owned(), Value::Object(names.collect()))
    });
    let groups = [
        ("records", group(records)),
        ("settings", form(&SETTINGS).to_string()),
        ("structures", group(structures)),
        ("choices", group(choices)),
        ("names", group(names)),
    ];
    let groups = groups.map(|(name, text)| format!(" {}: {text}", json!(name)));
    format!("{{\n \"version\": {VERSION},\n{}\n}}\n", groups.join(",\n"))
}

fn group(all: impl Iterator<Item = (String, Value)>) -> String {
    let lines: Vec<String> = all.map(|(name, of)| format!("  {}: {of}", json!(name))).collect();
    format!("{{\n{}\n }}", lines.join(",\n"))
}

fn fields(fields: &[Place]) -> Value {
    let field = |place: &Place| {
        let mut of =
            json!({ "name": place.name, "form": form(&place.form), "doc": place.doc.trim() });
        if !place.absent.is_empty() {
            of["absent"] = json!(place.absent);
        }
        of
    };
    fields.iter().map(field).collect()
}

/// A number's type as text, or an object with one key that says what the value is.
fn form(of: &Form) -> Value {
    let one = |key: &str, value: Value| Value::Object(Map::from_iter([(key.to_owned(), value)]));
    match of {
        Form::Number(number) => json!(number),
        Form::Name(name, _) => one("name", json!(name)),
        Form::Structure(structure) => one("structure", json!(last(structure.name))),
        Form::Choice(name, _) => one("choice", json!(name)),
        Form::List(inner, _) => one("list", form(inner)),
        Form::Array(inner, count) => one("array", json!([form(inner), count])),
        Form::Option(inner) => one("option", form(inner)),
    }
}

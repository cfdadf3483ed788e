//! The structures and constants of `c/include/picket.h`.

use picket_dsp::Verdict;
use picket_wire::layout::{Form, Structure};
use picket_wire::view::{CONSTANTS, Constant, VIEWS};

/// The structures that a program fills; the others come out.
const GIVEN: [&str; 9] = [
    "picket_config",
    "picket_scene",
    "picket_following",
    "picket_accumulating",
    "picket_trigger",
    "picket_framing",
    "picket_calibration",
    "picket_uncertainty",
    "picket_stamp",
];

/// The header with its made parts as they are now.
///
/// # Errors
/// The header lacks a marker.
pub fn text(before: &str) -> Result<String, String> {
    let text = replaced(before, "verdicts", &verdicts())?;
    let text = replaced(&text, "structures out", &structures(|name| !GIVEN.contains(&name)))?;
    replaced(&text, "structures in", &structures(|name| GIVEN.contains(&name)))
}

/// The text with these lines between a marker and the end after it.
fn replaced(text: &str, name: &str, lines: &str) -> Result<String, String> {
    let marker = format!("/* made by lab schema: {name} */\n");
    let missing = || format!("there is no {}", marker.trim());
    let (head, rest) = text.split_once(&marker).ok_or_else(missing)?;
    let (_, tail) = rest.split_once("/* end */").ok_or_else(missing)?;
    Ok(format!("{head}{marker}{lines}/* end */{tail}"))
}

fn structures(is_here: impl Fn(&str) -> bool) -> String {
    let mut text = String::new();
    for view in VIEWS {
        let Form::Structure(structure) = view else { continue };
        if is_here(structure.name) {
            text += &typedef(structure);
            let beside = CONSTANTS.iter().filter(|(of, _)| *of == structure.name);
            beside.for_each(|(_, constants)| text += &list(constants));
            text += "\n";
        }
    }
    text.trim_end().to_owned() + "\n"
}

fn typedef(Structure { name, doc, fields }: &Structure) -> String {
    let mut text = format!("/* {} */\ntypedef struct {name} {{\n", doc.trim());
    for field in *fields {
        let (kind, count) = spelt(&field.form);
        let told = match field.doc.trim() {
            "0" if field.name == "reserved" => String::new(),
            doc => format!(" /* {doc} */"),
        };
        text += &format!("    {kind} {}{count};{told}\n", field.name);
    }
    text + &format!("}} {name};\n")
}

/// A form's type in C, and what stands behind the field's name.
fn spelt(form: &Form) -> (String, String) {
    let kind = match form {
        Form::Number("f64") => "double",
        Form::Number("f32") => "float",
        Form::Number(number) => {
            let (sign, bits) = number.split_at(1);
            return (format!("{}int{bits}_t", if sign == "u" { "u" } else { "" }), String::new());
        }
        Form::Structure(structure) => structure.name,
        Form::Array(of, count) => return (spelt(of).0, format!("[{count}]")),
        // Views have no other forms.
        _ => "void",
    };
    (kind.to_owned(), String::new())
}

fn list(constants: &[Constant<'_>]) -> String {
    let mut text = "enum {\n".to_owned();
    for (index, Constant { name, value, doc }) in constants.iter().enumerate() {
        let comma = if index + 1 < constants.len() { "," } else { "" };
        let told = if doc.is_empty() { String::new() } else { format!(" /* {doc} */") };
        text += &format!("    {name} = {value}{comma}{told}\n");
    }
    text + "};\n"
}

fn verdicts() -> String {
    let severity = Verdict::ALL.map(Verdict::name).join(", ");
    let mut all = Verdict::ALL;
    all.sort_by_key(|verdict| *verdict as u8);
    let names =
        all.map(|verdict| format!("PICKET_{}", verdict.name().to_uppercase().replace('-', "_")));
    let constants: Vec<Constant> = all
        .iter()
        .zip(&names)
        .map(|(verdict, name)| Constant { name, value: *verdict as u8, doc: verdict.reason() })
        .collect();
    let order =
        format!("/* What is known against a number. The order of severity is: {severity}. */\n");
    order + &list(&constants)
}

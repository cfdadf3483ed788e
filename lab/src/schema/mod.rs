//! `lab schema`: the files that are written from the single description of answers and settings in `wire/`, or compared with it.

mod header;
mod json;
pub mod tables;

use crate::{cli, toolchain};
use clap::Args;
use picket_wire::layout::{Case, Form, Place, Structure};
use std::fs;
use std::process::ExitCode;

/// Writes what is made of the description of answers and settings: docs/schema.json, and structures and constants of picket.h. With --check compares it;
/// the exit code is 1 if it differs.
#[derive(Args, Debug)]
pub struct Options {
    /// Compares and writes nothing
    #[arg(long)]
    check: bool,
}

/// A file, and the text that belongs there instead of this one.
type Made = (&'static str, fn(&str) -> Result<String, String>);

const FILES: [Made; 2] =
    [("docs/schema.json", |_| Ok(json::text())), ("c/include/picket.h", header::text)];

/// Writes or compares the files.
///
/// # Errors
/// A file cannot be read or written, or lacks its markers.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let mut code = ExitCode::SUCCESS;
    for (name, made) in FILES {
        let path = toolchain::workspace().join(name);
        let told = |error: std::io::Error| format!("{name}: {error}");
        let before =
            if path.exists() { fs::read_to_string(&path).map_err(told)? } else { String::new() };
        let after = made(&before).map_err(|error| format!("{name}: {error}"))?;
        if after == before {
            continue;
        }
        if options.check {
            cli::print_line(&format!("{name} differs: `lab schema` writes it"));
            code = ExitCode::FAILURE;
        } else {
            fs::write(&path, after).map_err(told)?;
            cli::print_line(&format!("{name} written"));
        }
    }
    Ok(code)
}

/// The last part of a type's path, as Rust spells it.
pub(crate) fn last(path: &str) -> &str {
    path.rsplit([':', ' ']).next().unwrap_or(path)
}

/// What occurs within a layout: each structure, each choice and each list of names, where it is met first.
#[derive(Default)]
pub(crate) struct Found {
    pub structures: Vec<&'static Structure>,
    pub choices: Vec<(&'static str, &'static [Case])>,
    pub names: Vec<(&'static str, Vec<(u8, &'static str)>)>,
}

impl Found {
    /// What occurs in all layouts.
    pub fn all() -> Self {
        let mut found = Self::default();
        for (_, form) in picket_wire::schema::RECORDS {
            found.visit(&form);
        }
        found.visit(&picket_wire::schema::SETTINGS);
        found
    }

    fn visit(&mut self, form: &Form) {
        match *form {
            Form::Number(_) => {}
            Form::Name(name, of) => {
                if self.names.iter().all(|(known, _)| *known != name) {
                    let names = (0..=u8::MAX).filter_map(|number| Some((number, of(number)?)));
                    self.names.push((name, names.collect()));
                }
            }
            Form::Structure(structure) => {
                if self.structures.iter().all(|known| known.name != structure.name) {
                    self.structures.push(structure);
                    self.fields(structure.fields);
                }
            }
            Form::Choice(name, cases) => {
                if self.choices.iter().all(|(known, _)| *known != name) {
                    self.choices.push((name, cases));
                    for case in cases {
                        self.fields(case.fields);
                        case.inner.iter().for_each(|inner| self.visit(inner));
                    }
                }
            }
            Form::List(form, _) | Form::Array(form, _) | Form::Option(form) => self.visit(form),
        }
    }

    fn fields(&mut self, fields: &[Place]) {
        fields.iter().for_each(|place| self.visit(&place.form));
    }
}

//! What a missing or failing tool is called, in one line.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a tool could not be had or did not do its work.
#[derive(Debug)]
#[non_exhaustive]
pub enum ToolError {
    /// A tool is missing and cannot be had from here.
    Missing {
        /// What is missing.
        what: String,
        /// The command that mends it.
        command: String,
        /// The cause, where it is known.
        reason: Option<String>,
    },
    /// The sources that this program was built from are gone: firmware is built from them.
    Sources(PathBuf),
    /// The compiler or linker failed.
    Build {
        /// The image.
        bin: String,
        /// What cargo printed.
        output: String,
    },
    /// A file could not be read or written, a program not started.
    Io {
        /// The file or program.
        what: String,
        /// The system's answer.
        source: io::Error,
    },
    /// A file may not be replaced, or not be written: why, in a line.
    Unwritten(String),
}

impl ToolError {
    /// Both, as one line with every cause once. Of other errors the first.
    pub(super) fn and(self, other: ToolError) -> ToolError {
        match (self, other) {
            (
                ToolError::Missing { what, command, reason },
                ToolError::Missing { what: more, command: then, reason: why },
            ) => {
                let reason = match (reason, why) {
                    (Some(reason), Some(why)) if reason != why => Some(format!("{reason}; {why}")),
                    (reason, why) => reason.or(why),
                };
                let what = together(&what, &more, ", ", usize::MAX);
                let command = together(&command, &then, " && ", 3);
                ToolError::Missing { what, command, reason }
            }
            (ToolError::Missing { .. }, other) => other,
            (first, _) => first,
        }
    }
}

/// Two lists as one, each entry once. Entries with the same first words, so many, are one: a command with the words of both.
fn together(list: &str, more: &str, between: &str, words: usize) -> String {
    let mut entries: Vec<Vec<&str>> = Vec::new();
    for entry in list.split(between).chain(more.split(between)) {
        let new: Vec<&str> = entry.split(' ').collect();
        let begins = |known: &&mut Vec<&str>| known.iter().take(words).eq(new.iter().take(words));
        match entries.iter_mut().find(begins) {
            Some(known) => {
                let others: Vec<&str> =
                    new.into_iter().skip(words).filter(|word| !known.contains(word)).collect();
                known.extend(others);
            }
            None => entries.push(new),
        }
    }
    let entries: Vec<String> = entries.iter().map(|words| words.join(" ")).collect();
    entries.join(between)
}

impl fmt::Display for ToolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ToolError::Missing { what, command, reason } => {
                write!(f, "{what} cannot be had")?;
                reason.iter().try_for_each(|reason| write!(f, " ({reason})"))?;
                write!(f, ": type `{command}`")
            }
            ToolError::Sources(place) => write!(
                f,
                "firmware and page are built from the sources, but {} has none any more: clone the repository again and type `cargo install --locked --path host` in it",
                place.display()
            ),
            ToolError::Build { bin, output } => {
                let first = output.lines().find(|line| line.starts_with("error"));
                write!(f, "the image {bin} does not build: {}", first.unwrap_or(output.trim()))
            }
            ToolError::Io { what, source } => write!(f, "{what}: {source}"),
            ToolError::Unwritten(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for ToolError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            ToolError::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// Attaches the name of a file or program to the system's answer.
pub fn io_error(what: impl fmt::Display) -> impl FnOnce(io::Error) -> ToolError {
    move |source| ToolError::Io { what: what.to_string(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(what: &str, command: &str, reason: Option<&str>) -> ToolError {
        let reason = reason.map(str::to_owned);
        ToolError::Missing { what: what.into(), command: command.into(), reason }
    }

    #[test]
    fn what_is_missing_is_told_together() {
        let all = [
            missing("Rust", "rustup target add thumbv6m-none-eabi", Some("no network")),
            missing("Rust", "rustup target add thumbv7m-none-eabi", Some("no network")),
            missing("an emulator", "sudo apt-get install qemu-system-arm", Some("no network")),
            missing("a browser", "sudo apt-get install chromium", Some("no network")),
            missing("an emulator", "sudo apt-get install qemu-system-arm", None),
        ];
        let ToolError::Missing { what, command, reason } =
            all.into_iter().reduce(ToolError::and).unwrap()
        else {
            panic!()
        };
        assert_eq!(what, "Rust, an emulator, a browser");
        assert_eq!(
            command,
            "rustup target add thumbv6m-none-eabi thumbv7m-none-eabi && sudo apt-get install qemu-system-arm chromium"
        );
        assert_eq!(reason.as_deref(), Some("no network"));
    }

    #[test]
    fn what_is_wrong_comes_before_what_is_missing() {
        let wrong = ToolError::Unwritten("a full disk".into());
        let error = missing("x", "y", None).and(wrong);
        assert!(matches!(error, ToolError::Unwritten(_)));
    }
}

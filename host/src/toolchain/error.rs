//! What a missing or failing tool is called, in one line.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a tool could not be had or did not do its work.
#[derive(Debug)]
#[non_exhaustive]
pub enum ToolError {
    /// A tool is missing and may not be installed from here.
    Missing {
        /// What is missing.
        what: String,
        /// The command that installs it.
        command: String,
        /// What went wrong when it was tried, if it was.
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

impl fmt::Display for ToolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ToolError::Missing { what, command, reason } => {
                write!(f, "{what} is missing: type `{command}`")?;
                reason.iter().try_for_each(|reason| write!(f, " ({reason})"))
            }
            ToolError::Sources(place) => write!(
                f,
                "firmware and page are built from the sources, and {} has none any more: clone the repository again and type `cargo install --locked --path host` in it",
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

/// Whether a cargo that failed so could not get packages. One that must not ask the registry names `--offline`; but so does one whose
/// lock file is behind its package, as a cure.
pub fn lacks_packages(output: &str) -> bool {
    const OFFLINE: [&str; 4] =
        ["failed to download", "Could not resolve host", "Couldn't resolve host", "--offline"];
    let behind = output.contains("because --locked was passed");
    !behind && OFFLINE.iter().any(|why| output.contains(why))
}

//! What a command needs beside this program: it gets all of it, or says what is missing, before the first step that takes long.

use super::error::ToolError;
use super::programs::{browser, program};
use super::python::python;
use super::route::route;
use super::{Target, page};

/// One of the things that a command needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// What builds images for a core.
    Core(Target),
    /// What builds for a target of this name.
    Triple(&'static str),
    /// What builds the page.
    Page,
    /// The emulator of Cortex-M.
    Emulator,
    /// A program of this name.
    Program(&'static str),
    /// Node.js, and npm, which gets the packages of scripts.
    Node,
    /// A browser.
    Browser,
    /// Python with venv.
    Python,
}

impl Need {
    fn had(self) -> Result<(), ToolError> {
        match self {
            Need::Core(target) => route(target.triple()).map(drop),
            Need::Triple(triple) => route(triple).map(drop),
            Need::Page => route(page::TRIPLE).map(drop),
            Need::Emulator => program("qemu-system-arm").map(drop),
            Need::Program(name) => program(name).map(drop),
            Need::Node => ["node", "npm"].into_iter().try_for_each(|name| program(name).map(drop)),
            Need::Browser => browser().map(drop),
            Need::Python => python().map(drop),
        }
    }
}

/// Gets all of these where they are not at hand.
///
/// # Errors
/// What cannot be had: one error for all of it.
pub fn have(needs: &[Need]) -> Result<(), ToolError> {
    let failures = needs.iter().filter_map(|need| need.had().err());
    failures.reduce(ToolError::and).map_or(Ok(()), Err)
}

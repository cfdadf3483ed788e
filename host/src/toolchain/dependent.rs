//! Builds programs outside the workspace, as a stranger's that depends on the library by path.

use super::error::{ToolError, io_error};
use super::process::{Show, capture, cargo, locked};
use super::route::{Route, route};
use super::{dependents, target_dir};
use std::fs;
use std::path::PathBuf;

/// A program in `dependents/`.
#[derive(Clone, Copy, Debug)]
pub struct Dependent {
    /// Its folder; its package is `picket-on-` and this.
    pub name: &'static str,
    /// The target's name, as rustc knows it.
    pub triple: &'static str,
}

impl Dependent {
    /// Builds and links the program by the versions in its `Cargo.lock`, with these arguments of the compiler for its own code alone.
    /// Returns the file.
    ///
    /// # Errors
    /// A tool is missing, or the program does not build.
    pub fn build(&self, arguments: &[&str]) -> Result<PathBuf, ToolError> {
        self.cargo(
            &[&["rustc", "--locked", "--release", "--"], arguments].concat(),
            arguments.is_empty(),
        )?;
        let package = format!("picket-on-{}", self.name);
        let file = match self.triple.starts_with("wasm") {
            true => format!("{}.wasm", package.replace('-', "_")),
            false => package,
        };
        Ok(self.directory()?.join(self.triple).join("release").join(file))
    }

    /// Checks that the library builds for this target, with these features of its own.
    ///
    /// # Errors
    /// A tool is missing, or it does not build.
    pub fn check_library(triple: &'static str, features: &str) -> Result<(), ToolError> {
        let library = Self { name: "", triple };
        library.cargo(&["check", "--package", "picket-dsp", "--features", features], false)
    }

    /// Where it and the others are built.
    fn directory(&self) -> Result<PathBuf, ToolError> {
        Ok(target_dir().join("dependents").join(route(self.triple)?.directory()))
    }

    fn cargo(&self, arguments: &[&str], seen: bool) -> Result<(), ToolError> {
        let route = route(self.triple)?;
        let directory = self.directory()?;
        fs::create_dir_all(&directory).map_err(io_error(directory.display()))?;
        let _lock = locked(&directory.join("build.lock"))?;
        let mut command = cargo();
        if !self.name.is_empty() {
            command.current_dir(dependents().join(self.name));
        }
        route.lead(&mut command, self.triple);
        let (before, after) = arguments.split_at(1);
        command.args(before).args(["--target", self.triple, "--target-dir"]).arg(&directory);
        if matches!(route, Route::Source { .. }) {
            command.arg("-Zbuild-std=core");
        }
        command.args(after);
        let bin = if self.name.is_empty() { self.triple } else { self.name };
        let what = format!("building {bin}");
        let show = if seen { Show::Steps(&what) } else { Show::Nothing };
        let (ok, output) = capture(command, show)?;
        if ok { Ok(()) } else { Err(ToolError::Build { bin: bin.into(), output }) }
    }
}

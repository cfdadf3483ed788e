//! Scripts for Node.js, each folder with one package, which npm gets once by its lock file.

use super::error::{ToolError, io_error};
use super::process::locked;
use super::programs::program;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const LOCK: &str = "package-lock.json";

fn missing(what: &str, command: &str, reason: Option<String>) -> ToolError {
    ToolError::Missing { what: what.into(), command: command.into(), reason }
}

/// The program that runs scripts.
///
/// # Errors
/// There is none.
pub fn node() -> Result<PathBuf, ToolError> {
    program("node")
}

/// The folder of these scripts with their package, ready to run: a copy of the folder `source`, kept at `folder`.
///
/// # Errors
/// Node.js, npm or the package cannot be had.
pub(crate) fn scripts(
    source: &Path,
    files: &[&str],
    package: &str,
    folder: PathBuf,
) -> Result<PathBuf, ToolError> {
    let npm = program("npm")?;
    fs::create_dir_all(&folder).map_err(io_error(folder.display()))?;
    let _lock = locked(&folder.join("scripts.lock"))?;
    let read = |path: PathBuf| fs::read(&path).ok();
    let manifest = folder.join("node_modules").join(package).join("package.json");
    let installed = manifest.is_file() && read(folder.join(LOCK)) == read(source.join(LOCK));
    for name in files.iter().chain(&["package.json", LOCK]) {
        let (from, to) = (source.join(name), folder.join(name));
        let text = fs::read(&from).map_err(io_error(from.display()))?;
        // What is the same stays: another process may be reading it.
        if read(to.clone()).as_ref() != Some(&text) {
            fs::write(&to, text).map_err(io_error(to.display()))?;
        }
    }
    if !installed {
        let mut npm = Command::new(npm);
        npm.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"]).current_dir(&folder);
        let output = npm.stdin(Stdio::null()).output().map_err(io_error("npm"))?;
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            let line = errors
                .lines()
                .find(|line| line.starts_with("npm error"))
                .unwrap_or("npm ci failed");
            // So that the next run tries again.
            let _ = fs::remove_file(folder.join(LOCK));
            let command = format!("cd {} && npm ci", folder.display());
            return Err(missing(package, &command, Some(line.into())));
        }
    }
    Ok(folder)
}

//! What the system's package manager can install.

use super::error::{ToolError, io_error};
use super::firmware_dir;
use super::process::{ask, locked, on_path};
use std::fs::{self, File};
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user has agreed to every installation before it is asked for.
static AGREED: AtomicBool = AtomicBool::new(false);
/// The variable that agrees, too: tests have no options.
const AGREES: &str = "PICKET_YES";

/// Agrees to every installation.
pub fn agree(yes: bool) {
    AGREED.store(yes, Ordering::Relaxed);
}

/// Whether the user wants this: by an option, by the variable, or by an answer on the terminal.
fn agreed(command: &str) -> bool {
    if AGREED.load(Ordering::Relaxed) || std::env::var_os(AGREES).is_some_and(|yes| yes == "1") {
        return true;
    }
    let asks = io::stdin().is_terminal() && io::stderr().is_terminal();
    let mut answer = String::new();
    asks && {
        eprint!("toolchain: {command}? [y/N] ");
        io::stdin().read_line(&mut answer).is_ok() && says_yes(&answer)
    }
}

fn says_yes(answer: &str) -> bool {
    ["y", "yes"].contains(&answer.trim().to_ascii_lowercase().as_str())
}

/// Installs packages, as root only, where the user agrees, and never at the price of removing a package.
pub(super) fn install(what: &str, packages: &[&str]) -> Result<(), ToolError> {
    let refused = |reason: &str| missing(what, packages, Some(reason.into()));
    if !is_root() {
        return Err(refused("only root may install it"));
    }
    if !agreed(&format!("apt-get install {}", packages.join(" "))) {
        return Err(refused("nobody agreed to install it (--yes or PICKET_YES=1 does)"));
    }
    let _lock = prepared(&refused)?;
    eprintln!("toolchain: apt-get install {}", packages.join(" "));
    let install = ["install", "--yes", "--no-remove", "--no-install-recommends"];
    apt(&[&install[..], packages].concat(), None, refused).map(drop)
}

/// Downloads a package and all of those it needs that are not installed, into a directory; gives their files.
pub(super) fn download(package: &str, into: &Path) -> Result<Vec<PathBuf>, ToolError> {
    let refused = |reason: &str| missing(package, &[package], Some(reason.into()));
    let _lock = prepared(&refused)?;
    // A simulation tells what belongs to it, whatever could be installed beside it.
    let simulate = ["install", "--simulate", "--no-install-recommends", package];
    let plan = apt(&simulate, None, refused)?;
    let names: Vec<&str> =
        plan.lines().filter_map(|line| line.strip_prefix("Inst ")?.split(' ').next()).collect();
    apt(&[&["download"][..], &names].concat(), Some(into), refused)?;
    let files = fs::read_dir(into).map_err(io_error(into.display()))?;
    let files = files.filter_map(|file| Some(file.ok()?.path()));
    Ok(files.filter(|path| path.extension().is_some_and(|e| e == "deb")).collect())
}

/// One process at a time, with fresh lists where they may be fetched.
fn prepared(refused: &impl Fn(&str) -> ToolError) -> Result<File, ToolError> {
    if on_path("apt-get").is_none() {
        return Err(refused("there is no apt-get to get it with"));
    }
    let directory = firmware_dir();
    fs::create_dir_all(&directory).map_err(io_error(directory.display()))?;
    let lock = locked(&directory.join("apt.lock"))?;
    static UPDATED: AtomicBool = AtomicBool::new(false);
    if is_root() && !UPDATED.swap(true, Ordering::Relaxed) {
        // A failed update is no reason to stop: the lists at hand may do.
        let _ = apt(&["update"], None, refused);
    }
    Ok(lock)
}

/// Runs `apt-get`; gives what it prints.
fn apt(
    arguments: &[&str],
    directory: Option<&Path>,
    refused: impl Fn(&str) -> ToolError,
) -> Result<String, ToolError> {
    let mut command = Command::new("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive").env("LC_ALL", "C").stdin(Stdio::null());
    command.args(["-qq", "-o", "DPkg::Lock::Timeout=300"]).args(arguments);
    if let Some(directory) = directory {
        command.current_dir(directory);
    }
    let output = command.output().map_err(io_error("apt-get"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    let last = errors.lines().rev().find(|line| line.starts_with("E:"));
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(refused(last.unwrap_or("apt-get failed"))),
    }
}

/// The error that names the command which installs these packages.
pub(super) fn missing(what: &str, packages: &[&str], reason: Option<String>) -> ToolError {
    let sudo = if is_root() { "" } else { "sudo " };
    let packages = packages.join(" ");
    let command = format!("{sudo}apt-get update && {sudo}apt-get install --no-remove {packages}");
    ToolError::Missing { what: what.into(), command, reason }
}

fn is_root() -> bool {
    ask(Path::new("id"), &["-u"]).is_some_and(|id| id == "0")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_tool_names_the_command() {
        let error = missing("qemu-system-arm", &["qemu-system-arm"], Some("no root".into()));
        let text = error.to_string();
        assert!(text.contains("apt-get install --no-remove qemu-system-arm"), "{text}");
        assert!(!text.contains('\n'), "{text}");
    }

    #[test]
    fn only_a_yes_is_one() {
        for (answer, yes) in [
            ("y\n", true),
            ("Yes\n", true),
            ("", false),
            ("\n", false),
            ("n\n", false),
            ("yesterday", false),
        ] {
            assert_eq!(says_yes(answer), yes, "{answer:?}");
        }
    }
}

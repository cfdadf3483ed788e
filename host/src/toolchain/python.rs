//! Python: environments of our own, so that nothing of the user's is changed, and the wheel.

use super::apt;
use super::error::{ToolError, io_error};
use super::process::{Show, capture, cargo, locked, on_path};
use super::{target_dir, workspace};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What builds the wheel: as `python/pyproject.toml` asks for it.
const MATURIN: &str = "maturin>=1.9,<2";

/// The oldest Python.
const OLDEST: &str = "import sys, venv; sys.exit(sys.version_info < (3, 10))";

/// What to type for the lack of it.
fn missing(reason: Option<String>) -> ToolError {
    apt::missing("Python 3.10 or later with venv", &["python3", "python3-venv"], reason)
}

/// The machine's own Python, for which the module is built.
pub(super) fn python() -> Result<PathBuf, ToolError> {
    let python = on_path("python3").ok_or_else(|| missing(None))?;
    let mut command = Command::new(&python);
    command.args(["-c", OLDEST]);
    match capture(command, Show::Nothing)?.0 {
        true => Ok(python),
        false => Err(missing(Some(format!("{} is older, or has no venv", python.display())))),
    }
}

/// A fresh environment with these packages, by pip. Its programs lie in the folder that is returned.
///
/// # Errors
/// There is no Python with pip, it is too old, or the packages cannot be had.
pub fn environment(place: &Path, packages: &[&str]) -> Result<PathBuf, ToolError> {
    let python = python()?;
    let programs = place.join("bin");
    if !programs.join("pip").is_file() {
        let mut command = Command::new(&python);
        command.args(["-m", "venv"]).arg(place);
        let (ok, output) = capture(command, Show::Nothing)?;
        if !ok {
            return Err(missing(output.lines().last().map(str::to_owned)));
        }
    }
    if !packages.is_empty() {
        let mut command = Command::new(programs.join("pip"));
        command.args(["install", "--quiet", "--disable-pip-version-check"]).args(packages);
        let (ok, output) = capture(command, Show::Nothing)?;
        if !ok {
            let what = packages.join(" ");
            let command = format!("pip install {what}");
            let reason = output.lines().last().map(str::to_owned);
            return Err(ToolError::Missing { what, command, reason });
        }
    }
    Ok(programs)
}

/// Builds the wheel into a folder. Returns its file.
///
/// # Errors
/// Python or maturin cannot be had, or the wheel does not build.
pub fn build_wheel(out: &Path) -> Result<PathBuf, ToolError> {
    let home = target_dir().join("wheel");
    fs::create_dir_all(&home).map_err(io_error(home.display()))?;
    let _lock = locked(&home.join("build.lock"))?;
    let programs = environment(&home.join("maturin"), &[MATURIN])?;
    let fresh = home.join("fresh");
    let _ = fs::remove_dir_all(&fresh);
    let mut command = cargo();
    let steer = command.get_envs().map(|(name, _)| name.to_owned()).collect::<Vec<_>>();
    command = Command::new(programs.join("maturin"));
    for name in steer {
        command.env_remove(name);
    }
    command.current_dir(workspace().join("python")).env("CARGO_TARGET_DIR", &home);
    command.args(["build", "--locked", "--out"]).arg(&fresh);
    let (ok, output) = capture(command, Show::Steps("building the wheel"))?;
    if !ok {
        return Err(ToolError::Build { bin: "of the wheel".into(), output });
    }
    let built = fs::read_dir(&fresh).map_err(io_error(fresh.display()))?;
    let mut built = built.filter_map(|entry| Some(entry.ok()?.path()));
    let wheel = built.find(|path| path.extension().is_some_and(|end| end == "whl"));
    let Some((wheel, name)) = wheel.as_ref().and_then(|path| Some((path, path.file_name()?)))
    else {
        return Err(ToolError::Build { bin: "of the wheel".into(), output });
    };
    fs::create_dir_all(out).map_err(io_error(out.display()))?;
    let to = out.join(name);
    fs::copy(wheel, &to).map_err(io_error(to.display()))?;
    Ok(to)
}

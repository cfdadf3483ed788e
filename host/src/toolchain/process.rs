//! Other programs: found, asked, run to their end.

use super::error::{ToolError, io_error};
use super::workspace;
use crate::end::Owned;
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where a program is, if it is on the path.
pub(crate) fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|directory| directory.join(name)).find(|file| file.is_file())
}

/// What a program prints in the workspace, trimmed; `None` if it fails.
pub(super) fn ask(program: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(workspace()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().into())
}

/// An exclusive lock on a file, freed when dropped.
pub(super) fn locked(path: &Path) -> Result<File, ToolError> {
    let file = File::create(path).map_err(io_error(path.display()))?;
    file.lock().map_err(io_error(path.display()))?;
    Ok(file)
}

/// Cargo, without the environment by which an outer cargo would steer it.
pub(super) fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(workspace());
    for (name, _) in std::env::vars_os() {
        if inherited(&name) {
            command.env_remove(name);
        }
    }
    command
}

/// True for variables that cargo or rustc set or obey, but for those that say where packages come
/// from.
fn inherited(name: &OsString) -> bool {
    const KEPT: [&str; 6] = ["HOME", "HTTP_", "NET_", "REGISTR", "SOURCE_", "TERM_"];
    const COMPILER: [&str; 6] = [
        "RUSTC",
        "RUSTC_WRAPPER",
        "RUSTC_WORKSPACE_WRAPPER",
        "RUSTC_BOOTSTRAP",
        "RUSTFLAGS",
        "RUSTDOCFLAGS",
    ];
    let Some(name) = name.to_str() else {
        return false;
    };
    match name.strip_prefix("CARGO_") {
        Some(rest) => !KEPT.iter().any(|kept| rest.starts_with(kept)),
        None => name == "CARGO" || COMPILER.contains(&name),
    }
}

/// Runs a command to its end. Returns whether it succeeded and all it printed; `echo` also passes
/// its stderr on as it comes.
pub(super) fn capture(mut command: Command, echo: bool) -> Result<(bool, String), ToolError> {
    let name = command.get_program().to_string_lossy().into_owned();
    command.stdin(Stdio::null());
    let mut child =
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(io_error(&name))?;
    let stderr = child.stderr.take();
    let child = Owned::new(child);
    let mut output = String::new();
    if let Some(stderr) = stderr {
        for line in BufReader::new(stderr).split(b'\n') {
            let line = line.map_err(io_error(&name))?;
            let line = String::from_utf8_lossy(&line);
            if echo {
                let _ = writeln!(io::stderr(), "{line}");
            }
            output.push_str(&line);
            output.push('\n');
        }
    }
    let status = child.wait().map_err(io_error(&name))?;
    Ok((status.success(), output))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outer_cargo_does_not_steer_the_inner_one() {
        for name in ["CARGO", "CARGO_PKG_NAME", "CARGO_TARGET_DIR", "RUSTFLAGS", "RUSTC"] {
            assert!(inherited(&name.into()), "{name}");
        }
        for name in ["CARGO_HOME", "CARGO_NET_OFFLINE", "CARGO_REGISTRIES_X_INDEX", "RUSTUP_HOME"] {
            assert!(!inherited(&name.into()), "{name}");
        }
    }
}

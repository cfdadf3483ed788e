//! Other programs: found, asked, run to their end.

use super::error::{ToolError, io_error};
use super::workspace;
use crate::end::Owned;
use crate::progress;
use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::io::{self, BufReader, IsTerminal, Read, Write};
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

/// An exclusive lock on a file, freed when dropped. A caller that has to wait prints so: a build or a download may take minutes.
pub(super) fn locked(path: &Path) -> Result<File, ToolError> {
    let file = File::create(path).map_err(io_error(path.display()))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            eprintln!("toolchain: waiting for another picket");
            file.lock().map_err(io_error(path.display()))?;
        }
        Err(TryLockError::Error(error)) => return Err(io_error(path.display())(error)),
    }
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

/// True for variables that cargo or rustc set or obey, except for those that say where packages come
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

/// What a person sees of a program while it runs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Show<'a> {
    /// Nothing.
    Nothing,
    /// What it prints on stderr, as it comes.
    Lines,
    /// Cargo's steps as a bar behind these words, where stderr is a terminal; what cargo printed, if it fails.
    Steps(&'a str),
}

/// Runs a command to its end. Returns whether it succeeded and all it printed on stderr.
pub(super) fn capture(mut command: Command, show: Show) -> Result<(bool, String), ToolError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let bar = match show {
        Show::Steps(what) if io::stderr().is_terminal() => {
            // Into a pipe cargo draws its bar only if told to, and how wide.
            command.env("CARGO_TERM_PROGRESS_WHEN", "always");
            command.env("CARGO_TERM_PROGRESS_WIDTH", "80");
            Some(progress::steps(what))
        }
        _ => None,
    };
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let child = Owned::start(command).map_err(|error| not_started(&name, error))?;
    let stderr = child.stderr();
    let mut output = String::new();
    for line in stderr.into_iter().flat_map(lines) {
        let line = line.map_err(io_error(&name))?;
        match (steps(&line), &bar) {
            (Some((done, all)), Some(bar)) => {
                bar.set_length(all);
                bar.set_position(done);
                continue;
            }
            (Some(_), None) => continue,
            (None, _) => {}
        }
        if matches!(show, Show::Lines) {
            let _ = writeln!(io::stderr(), "{line}");
        }
        output.push_str(&line);
        output.push('\n');
    }
    let status = child.wait().map_err(io_error(&name))?;
    if let Some(bar) = bar {
        bar.finish_and_clear();
        if !status.success() {
            let _ = io::stderr().write_all(output.as_bytes());
        }
    }
    Ok((status.success(), output))
}

/// A program that does not start is one that is not there; cargo's place is known.
fn not_started(name: &str, error: io::Error) -> ToolError {
    match error.kind() {
        io::ErrorKind::NotFound if name == "cargo" => {
            io_error("firmware is built by cargo, which https://rustup.rs installs")(error)
        }
        _ => io_error(name)(error),
    }
}

/// Lines as they come; those of cargo's bar end with a carriage return.
fn lines(pipe: impl Read) -> impl Iterator<Item = io::Result<String>> {
    let mut bytes = BufReader::new(pipe).bytes();
    std::iter::from_fn(move || {
        let mut line = Vec::new();
        loop {
            match bytes.next() {
                None if line.is_empty() => return None,
                None | Some(Ok(b'\n' | b'\r')) => break,
                Some(Ok(byte)) => line.push(byte),
                Some(Err(error)) => return Some(Err(error)),
            }
        }
        Some(Ok(String::from_utf8_lossy(&line).into_owned()))
    })
}

/// The steps that cargo has done, of how many: "Building [=>  ] 7/24: fixed" are 7 of 24.
fn steps(line: &str) -> Option<(u64, u64)> {
    let (_, rest) = line.split_once("Building [")?;
    let (_, rest) = rest.split_once("] ")?;
    let (done, all) = rest.split(':').next()?.trim().split_once('/')?;
    Some((done.parse().ok()?, all.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cargos_bar_is_read() {
        assert_eq!(steps("    Building [=====>     ] 7/24: fixed(build.rs), libm"), Some((7, 24)));
        assert_eq!(steps("\u{1b}[K    Building [>     ] 0/1: x"), Some((0, 1)));
        assert_eq!(steps("   Compiling fixed v1.31.0"), None);
        let text: &[u8] =
            b"   Compiling a\n  Building [> ] 0/2: a\r  Building [=> ] 1/2: b\r   Compiling b\n";
        let seen: Vec<_> = lines(text).map(|line| steps(&line.unwrap())).collect();
        assert_eq!(seen, [None, Some((0, 2)), Some((1, 2)), None]);
    }

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

//! Which of the two ways leads to a target on this machine.

use super::error::ToolError;
use super::process::{Show, ask, capture, on_path};
use super::programs::RUST;
use super::workspace;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

/// How a target is built.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Route {
    /// The toolchain at hand has the target's library.
    Installed,
    /// `core` is built from the source of this compiler, and linked by this linker.
    Source { rustc: PathBuf, linker: PathBuf },
}

impl Route {
    /// A directory of its own, so that one way's products do not displace the other's.
    pub(super) fn directory(&self) -> &'static str {
        match self {
            Route::Installed => "installed",
            Route::Source { .. } => "source",
        }
    }

    /// Has cargo go this way to a target. True where `core` is to be built, too.
    pub(super) fn lead(&self, command: &mut Command, triple: &str) -> bool {
        let Route::Source { rustc, linker } = self else { return false };
        let name = triple.to_uppercase().replace(['-', '.'], "_");
        command.env("RUSTC", rustc).env("RUSTC_BOOTSTRAP", "1");
        command.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
        true
    }
}

/// The way to a target, decided once in a process and printed in one line.
pub(super) fn route(triple: &'static str) -> Result<Route, ToolError> {
    static CHOSEN: Mutex<Option<HashMap<&'static str, Route>>> = Mutex::new(None);
    let mut chosen = CHOSEN.lock().unwrap_or_else(PoisonError::into_inner);
    let chosen = chosen.get_or_insert_default();
    if let Some(route) = chosen.get(triple) {
        return Ok(route.clone());
    }
    if !workspace().join("firmware/Cargo.toml").is_file() {
        return Err(ToolError::Sources(workspace().into()));
    }
    let route = choose(triple)?;
    if !chosen.values().any(|other| *other == route) {
        match &route {
            Route::Installed => eprintln!("toolchain: the installed target {triple}"),
            Route::Source { rustc, linker } => eprintln!(
                "toolchain: core from source by {}, linked by {}",
                rustc.display(),
                linker.display()
            ),
        }
    }
    chosen.insert(triple, route.clone());
    Ok(route)
}

fn choose(triple: &str) -> Result<Route, ToolError> {
    let library = Path::new("lib/rustlib").join(triple).join("lib");
    let sysroot = sysroot(Path::new("rustc"));
    let has =
        |sysroot: &Option<PathBuf>| sysroot.as_ref().is_some_and(|s| s.join(&library).exists());
    if has(&sysroot) || (rustup_may_install() && rustup_add(triple) && has(&sysroot)) {
        return Ok(Route::Installed);
    }
    if let Some((rustc, linker)) = source_compiler().zip(linker(triple)) {
        return Ok(Route::Source { rustc, linker });
    }
    let unpacked = |name| RUST.program(name).map_err(|error| with_rustup(error, triple));
    let rustc = unpacked("rustc")?;
    if !has_source(&rustc) {
        let reason = "the package's compiler is too old, or without its source";
        return Err(with_rustup(RUST.missing(reason.into()), triple));
    }
    let linker = unpacked(if is_web(triple) { "wasm-ld" } else { "ld.lld" })?;
    Ok(Route::Source { rustc, linker })
}

const LINKERS: [&str; 2] = ["rust-lld", "ld.lld"];
/// The linker's names when it links for WebAssembly.
const WEB_LINKERS: [&str; 2] = ["rust-lld", "wasm-ld"];
const OLDEST: (u32, u32) = (1, 95);

fn is_web(triple: &str) -> bool {
    triple.starts_with("wasm")
}

fn rustup_may_install() -> bool {
    std::env::var_os("RUSTUP_AUTO_INSTALL").is_none_or(|value| value != "0")
}

fn rustup_add(triple: &str) -> bool {
    let Some(rustup) = on_path("rustup") else {
        return false;
    };
    eprintln!("toolchain: rustup target add {triple}");
    let mut command = Command::new(rustup);
    command.args(["--quiet", "target", "add", triple]).current_dir(workspace());
    capture(command, Show::Nothing).is_ok_and(|(ok, _)| ok)
}

/// A compiler new enough that has the source of its library: the usual one, or the system's.
fn source_compiler() -> Option<PathBuf> {
    let candidates = [on_path("rustc"), Some(PathBuf::from("/usr/bin/rustc"))];
    candidates.into_iter().flatten().find(|rustc| has_source(rustc))
}

fn has_source(rustc: &Path) -> bool {
    version(rustc).is_some_and(|version| version >= OLDEST)
        && sysroot(rustc).is_some_and(|s| s.join("lib/rustlib/src/rust/library/core").exists())
}

fn linker(triple: &str) -> Option<PathBuf> {
    let names = if is_web(triple) { WEB_LINKERS } else { LINKERS };
    let host = ask(Path::new("rustc"), &["--print", "host-tuple"]);
    let bundled = sysroot(Path::new("rustc"))
        .zip(host)
        .map(|(sysroot, host)| sysroot.join("lib/rustlib").join(host).join("bin/rust-lld"))
        .filter(|path| path.exists());
    bundled.or_else(|| names.iter().find_map(|name| on_path(name)))
}

/// "rustc 1.96.0 (...)" -> (1, 96)
fn version(rustc: &Path) -> Option<(u32, u32)> {
    let text = ask(rustc, &["--version"])?;
    let mut numbers = text.split(' ').nth(1)?.split('.').map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

fn sysroot(rustc: &Path) -> Option<PathBuf> {
    ask(rustc, &["--print", "sysroot"]).map(PathBuf::from)
}

/// Where rustup is in use, the shorter way to mend it is rustup's.
fn with_rustup(error: ToolError, triple: &str) -> ToolError {
    match error {
        ToolError::Missing { what, reason, .. } if on_path("rustup").is_some() => {
            ToolError::Missing { what, command: format!("rustup target add {triple}"), reason }
        }
        error => error,
    }
}

//! Builds the page's module: the library for WebAssembly, with the standard library around it.

use super::error::{ToolError, io_error};
use super::process::{Show, capture, cargo, locked};
use super::route::{Route, route};
use super::target_dir;
use std::fs;
use std::path::PathBuf;

const TRIPLE: &str = "wasm32-unknown-unknown";

/// Where the page and what belongs to it is built: `target/web`.
pub fn directory() -> PathBuf {
    target_dir().join("web")
}

/// Builds `picket.wasm`; gives its path.
///
/// # Errors
/// A tool is missing, or it does not build.
pub fn build_page() -> Result<PathBuf, ToolError> {
    let route = route(TRIPLE)?;
    let target = directory().join("build").join(route.directory());
    fs::create_dir_all(&target).map_err(io_error(target.display()))?;
    let _lock = locked(&target.join("build.lock"))?;
    let mut command = cargo();
    route.lead(&mut command, TRIPLE);
    command.args([
        "rustc",
        "--locked",
        "--package",
        "picket-web",
        "--lib",
        "--crate-type",
        "cdylib",
    ]);
    command.args(["--profile", "web", "--target", TRIPLE, "--target-dir"]).arg(&target);
    if matches!(route, Route::Source { .. }) {
        command.arg("-Zbuild-std=std,panic_abort");
    }
    // Addresses as short as they are: 5 % of the file.
    command.args(["--", "-Clink-arg=--compress-relocations"]);
    let (ok, output) = capture(command, Show::Steps("building the page"))?;
    match ok {
        true => Ok(target.join(TRIPLE).join("web/picket_web.wasm")),
        false => Err(ToolError::Build { bin: "picket.wasm".into(), output }),
    }
}

//! Builds the page's module: the library for WebAssembly, with the standard library around it.

use super::error::{ToolError, io_error};
use super::process::{Show, capture, cargo, locked};
use super::route::{Route, route};
use super::target_dir;
use std::fs;
use std::path::{Path, PathBuf};

/// The page's target.
pub(super) const TRIPLE: &str = "wasm32-unknown-unknown";

/// Where the page and what belongs to it is built: `target/web`.
pub fn directory() -> PathBuf {
    target_dir().join("web")
}

/// The packages that the modules are.
const PACKAGES: [&str; 2] = ["picket-web", "picket-tones"];

/// Builds the modules; gives their paths.
///
/// # Errors
/// A tool is missing, or it does not build.
pub fn build_page() -> Result<[PathBuf; 2], ToolError> {
    let route = route(TRIPLE)?;
    let target = directory().join("build").join(route.directory());
    fs::create_dir_all(&target).map_err(io_error(target.display()))?;
    let _lock = locked(&target.join("build.lock"))?;
    for package in PACKAGES {
        build(package, &route, &target)?;
    }
    let module = |package: &str| target.join(TRIPLE).join("web").join(package.replace('-', "_"));
    Ok(PACKAGES.map(|package| module(package).with_extension("wasm")))
}

fn build(package: &str, route: &Route, target: &Path) -> Result<(), ToolError> {
    let mut command = cargo();
    route.lead(&mut command, TRIPLE);
    command.args(["rustc", "--locked", "--package", package, "--lib", "--crate-type", "cdylib"]);
    command.args(["--profile", "web", "--target", TRIPLE, "--target-dir"]).arg(target);
    if matches!(route, Route::Source { .. }) {
        // What is built anyway is built small: 1 % of the page.
        command.args(["-Zbuild-std=std,panic_abort", "-Zbuild-std-features=optimize_for_size"]);
    }
    // Addresses as short as they are: 5 % of the file.
    command.args(["--", "-Clink-arg=--compress-relocations"]);
    let (ok, output) = capture(command, Show::Steps("building the page"))?;
    match ok {
        true => Ok(()),
        false => Err(ToolError::Build { bin: package.into(), output }),
    }
}

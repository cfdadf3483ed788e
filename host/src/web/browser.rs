//! A browser without a window that opens the page: for pictures of it, and for its tests.

use crate::end::Owned;
use crate::toolchain::{ToolError, io_error, on_path, page_directory, workspace};
use std::ffi::OsStr;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The scripts, and what they drive the browser by.
const FILES: [&str; 6] =
    ["package.json", "package-lock.json", "browser.mjs", "pictures.mjs", "page.mjs", "bits.mjs"];
const BROWSERS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

fn missing(what: &str, command: &str, reason: Option<String>) -> ToolError {
    ToolError::Missing { what: what.into(), command: command.into(), reason }
}

/// The program that runs scripts.
///
/// # Errors
/// There is none.
pub fn node() -> Result<PathBuf, ToolError> {
    on_path("node").ok_or_else(|| missing("node", "apt-get install nodejs npm", None))
}

/// Where the scripts are, with playwright-core, which npm gets once.
fn prepared() -> Result<PathBuf, ToolError> {
    node()?;
    if on_path("npm").is_none() {
        return Err(missing("npm", "apt-get install npm", None));
    }
    let folder = page_directory().join("browser");
    fs::create_dir_all(&folder).map_err(io_error(folder.display()))?;
    let source = workspace().join("web/browser");
    let read = |path: PathBuf| fs::read(&path).ok();
    let installed = folder.join("node_modules/playwright-core/package.json").is_file()
        && read(folder.join(FILES[1])) == read(source.join(FILES[1]));
    for name in FILES {
        let from = source.join(name);
        fs::copy(&from, folder.join(name)).map_err(io_error(from.display()))?;
    }
    if !installed {
        let mut npm = Command::new("npm");
        npm.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"]).current_dir(&folder);
        let output = npm.stdin(Stdio::null()).output().map_err(io_error("npm"))?;
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            let line = errors
                .lines()
                .find(|line| line.starts_with("npm error"))
                .unwrap_or("npm ci failed");
            let command = format!("cd {} && npm ci", folder.display());
            return Err(missing("playwright-core", &command, Some(line.into())));
        }
    }
    Ok(folder)
}

/// The browser.
///
/// # Errors
/// There is none.
pub fn browser() -> Result<PathBuf, ToolError> {
    let found = BROWSERS.iter().find_map(|name| on_path(name));
    found.ok_or_else(|| missing("chromium", "apt-get install chromium", None))
}

/// Runs one of the scripts with these arguments, after the browser's path; gives what it prints.
///
/// # Errors
/// A tool is missing, or the script fails: the error has what it said.
pub fn script(name: &str, arguments: &[&OsStr]) -> Result<String, ToolError> {
    let browser = browser()?;
    let folder = prepared()?;
    let mut command = Command::new("node");
    command.arg(folder.join(name)).arg(browser).args(arguments).stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    // It ends with this program, and its browser with it.
    let child = Owned::start(command).map_err(io_error("node"))?;
    let (stdout, stderr) = (child.stdout(), child.stderr());
    let said = |mut pipe: Box<dyn Read + Send>| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            let _ = pipe.read_to_end(&mut bytes);
            String::from_utf8_lossy(&bytes).into_owned()
        })
    };
    let output = stdout.map(|pipe| said(Box::new(pipe)));
    let errors = stderr.map(|pipe| said(Box::new(pipe)));
    let text = |thread: Option<std::thread::JoinHandle<String>>| {
        thread.and_then(|thread| thread.join().ok()).unwrap_or_default()
    };
    let (output, errors) = (text(output), text(errors));
    match child.wait().map_err(io_error("node"))?.success() {
        true => Ok(output),
        false => Err(ToolError::Build { bin: name.into(), output: format!("{output}{errors}") }),
    }
}

/// Draws the pictures of the page at this address into a folder; gives their names, a line each.
///
/// # Errors
/// See [`script`].
pub fn pictures(address: &str, folder: &Path) -> Result<String, ToolError> {
    fs::create_dir_all(folder).map_err(io_error(folder.display()))?;
    let folder = fs::canonicalize(folder).map_err(io_error(folder.display()))?;
    script("pictures.mjs", &[address.as_ref(), folder.as_os_str()])
}

//! A browser without a window that opens the page: for pictures of it, and for its tests.

use crate::end::Owned;
use crate::output::Output;
use crate::toolchain::{ToolError, io_error, page_directory, scripts, workspace};
pub use crate::toolchain::{browser, node};
use std::ffi::OsStr;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The scripts, and what they drive the browser by.
const FILES: [&str; 4] = ["browser.mjs", "pictures.mjs", "page.mjs", "bits.mjs"];

/// Where the scripts are, with playwright-core.
pub(super) fn prepared() -> Result<PathBuf, ToolError> {
    let folder = page_directory().join("browser");
    scripts(&workspace().join("web/browser"), &FILES, "playwright-core", folder)
}

/// Runs one of the scripts with these arguments, after the browser's path; gives what it prints.
///
/// # Errors
/// A tool is missing, or the script fails: the error has what it said.
pub fn script(name: &str, arguments: &[&OsStr]) -> Result<String, ToolError> {
    let browser = browser()?;
    let folder = prepared()?;
    let mut command = Command::new(node()?);
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

/// Draws the pictures of the page at this address into a folder; gives their names.
///
/// # Errors
/// The errors of [`script`], and a picture that exists.
pub fn pictures(address: &str, folder: &Path, output: Output) -> Result<Vec<String>, ToolError> {
    fs::create_dir_all(folder).map_err(io_error(folder.display()))?;
    let drawn = tempfile::tempdir().map_err(io_error("the temporary directory"))?;
    let names = script("pictures.mjs", &[address.as_ref(), drawn.path().as_os_str()])?;
    let keep = |name: &str| {
        let from = drawn.path().join(name);
        let bytes = fs::read(&from).map_err(io_error(from.display()))?;
        let to = folder.join(name);
        output.write(&to, &bytes).map_err(ToolError::Unwritten)?;
        Ok(to.display().to_string())
    };
    names.lines().map(keep).collect()
}

//! The one place that decides how firmware is built, and with what it is run.
//!
//! Two ways lead to a thumb target: the standard library that rustup installs for it, or `core`
//! built from source by a compiler whose source is at hand (rustup's `rust-src`, or Debian's
//! `rustc-web` and `rust-web-src`). What is missing is installed when that is allowed
//! (`RUSTUP_AUTO_INSTALL=0` forbids rustup, apt-get needs root); otherwise the error names the
//! command to type.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};

/// A core that firmware is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// Cortex-M0 and M0+.
    M0,
    /// Cortex-M3.
    M3,
    /// Cortex-M4F and M7F: DSP extension and single-precision FPU.
    M4f,
    /// Cortex-M33 with FPU.
    M33,
}

impl Target {
    /// The name that rustc knows.
    pub const fn triple(self) -> &'static str {
        match self {
            Target::M0 => "thumbv6m-none-eabi",
            Target::M3 => "thumbv7m-none-eabi",
            Target::M4f => "thumbv7em-none-eabihf",
            Target::M33 => "thumbv8m.main-none-eabihf",
        }
    }
}

/// How the compiler optimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Profile {
    /// For speed: opt-level 3.
    #[default]
    Release,
    /// For size: opt-level "z".
    Size,
}

impl Profile {
    /// Cargo's name of the profile.
    pub const fn name(self) -> &'static str {
        match self {
            Profile::Release => "release",
            Profile::Size => "size",
        }
    }
}

/// A firmware image to build.
#[derive(Clone, Debug)]
pub struct Firmware<'a> {
    /// The image: a binary of the package `picket`.
    pub bin: &'a str,
    /// The core.
    pub target: Target,
    /// Features of the package.
    pub features: &'a [&'a str],
    /// Speed or size.
    pub profile: Profile,
}

/// Why a tool could not be had or did not do its work.
#[derive(Debug)]
#[non_exhaustive]
pub enum ToolError {
    /// A tool is missing and may not be installed from here.
    Missing {
        /// What is missing.
        what: String,
        /// The command that installs it.
        command: String,
        /// What went wrong when it was tried, if it was.
        reason: Option<String>,
    },
    /// The compiler or linker failed.
    Build {
        /// The image.
        bin: String,
        /// What cargo printed.
        output: String,
    },
    /// A file could not be read or written, a program not started.
    Io {
        /// The file or program.
        what: String,
        /// The system's answer.
        source: io::Error,
    },
}

impl fmt::Display for ToolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ToolError::Missing { what, command, reason } => {
                write!(f, "{what} is missing: type `{command}`")?;
                reason.iter().try_for_each(|reason| write!(f, " ({reason})"))
            }
            ToolError::Build { bin, output } => {
                let first = output.lines().find(|line| line.starts_with("error"));
                write!(f, "the image {bin} does not build: {}", first.unwrap_or(output.trim()))
            }
            ToolError::Io { what, source } => write!(f, "{what}: {source}"),
        }
    }
}

impl std::error::Error for ToolError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            ToolError::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// Attaches the name of a file or program to the system's answer.
pub(crate) fn io_error(what: impl fmt::Display) -> impl FnOnce(io::Error) -> ToolError {
    move |source| ToolError::Io { what: what.to_string(), source }
}

/// The workspace's root.
pub fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Where firmware and what belongs to it is built: `target/firmware`.
pub fn firmware_dir() -> PathBuf {
    let base = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    workspace().join(base.unwrap_or_else(|| "target".into())).join("firmware")
}

/// How a target is built.
#[derive(Clone, Debug, PartialEq)]
enum Route {
    /// The toolchain at hand has the target's library.
    Installed,
    /// `core` is built from the source of this compiler, and linked by this linker.
    Source { rustc: PathBuf, linker: PathBuf },
}

impl Route {
    /// A directory of its own, so that one way's products do not displace the other's.
    fn directory(&self) -> &'static str {
        match self {
            Route::Installed => "installed",
            Route::Source { .. } => "source",
        }
    }
}

impl Firmware<'_> {
    /// Builds the image; what is missing is installed first when that is allowed. Cargo's output
    /// goes to stderr when that is a terminal. Returns the ELF file, which no other combination
    /// of features overwrites.
    pub fn build(&self) -> Result<PathBuf, ToolError> {
        self.run(io::stderr().is_terminal())
    }

    /// As [`Firmware::build`], but prints nothing of cargo's: for images meant to fail.
    pub fn build_quietly(&self) -> Result<PathBuf, ToolError> {
        self.run(false)
    }

    fn run(&self, echo: bool) -> Result<PathBuf, ToolError> {
        let route = route(self.target)?;
        let directory = firmware_dir().join(route.directory());
        let images = directory.join("images");
        fs::create_dir_all(&images).map_err(io_error(images.display()))?;
        // Another process may build the same binary with other features: the copy belongs to the
        // build, so both happen under one lock.
        let _lock = locked(&directory.join("build.lock"))?;
        let mut command = cargo();
        command.args(["build", "--package", "picket", "--bin", self.bin]);
        command.args(["--target", self.target.triple(), "--profile", self.profile.name()]);
        command.args(["--features", &self.features.join(","), "--target-dir"]).arg(&directory);
        if self.features.contains(&"log") {
            command.env("DEFMT_LOG", "info");
        }
        if let Route::Source { rustc, linker } = &route {
            let name = self.target.triple().to_uppercase().replace(['-', '.'], "_");
            command.env("RUSTC", rustc).env("RUSTC_BOOTSTRAP", "1").arg("-Zbuild-std=core");
            command.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
        }
        let (ok, output) = capture(command, echo)?;
        if !ok {
            return Err(ToolError::Build { bin: self.bin.into(), output });
        }
        let built = directory.join(self.target.triple()).join(self.profile.name()).join(self.bin);
        let image = images.join(self.image_name());
        fs::copy(&built, &image).map_err(io_error(built.display()))?;
        Ok(image)
    }

    fn image_name(&self) -> String {
        let parts = [self.bin, self.target.triple(), self.profile.name(), &self.features.join("+")];
        format!("{}.elf", parts.join("-"))
    }
}

/// Lints the library and these images with these features for a target; warnings are errors.
pub fn lint(target: Target, images: &[&str], features: &[&str]) -> Result<(), ToolError> {
    let route = route(target)?;
    let directory = firmware_dir().join("lint").join(route.directory());
    let mut command = cargo();
    match &route {
        Route::Installed => {
            command.arg("clippy");
        }
        Route::Source { rustc, .. } => {
            // Clippy must be of the compiler's own version: cargo's would be rustup's.
            command.arg("check").env("RUSTC", rustc).env("RUSTC_BOOTSTRAP", "1");
            command.env("RUSTC_WORKSPACE_WRAPPER", clippy_driver(rustc)?);
            command.env("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__").arg("-Zbuild-std=core");
        }
    }
    command.args(["--quiet", "--package", "picket", "--lib"]);
    for image in images {
        command.args(["--bin", image]);
    }
    command.args(["--features", &features.join(","), "--target", target.triple()]);
    command.arg("--target-dir").arg(&directory);
    if route == Route::Installed {
        command.args(["--", "-D", "warnings"]);
    }
    let (ok, output) = capture(command, true)?;
    let bin = format!("{} ({})", target.triple(), features.join(", "));
    if ok { Ok(()) } else { Err(ToolError::Build { bin, output }) }
}

/// The lint driver that belongs to a compiler.
fn clippy_driver(rustc: &Path) -> Result<PathBuf, ToolError> {
    const PACKAGE: &str = "rust-web-clippy";
    let driver = rustc.with_file_name("clippy-driver");
    if !driver.exists() {
        apt_install("the lint driver", &[PACKAGE])?;
    }
    if driver.exists() { Ok(driver) } else { Err(missing("the lint driver", &[PACKAGE], None)) }
}

/// The path of `qemu-system-arm`; installs it when that is allowed.
pub fn qemu() -> Result<PathBuf, ToolError> {
    static FOUND: OnceLock<PathBuf> = OnceLock::new();
    const NAME: &str = "qemu-system-arm";
    if let Some(path) = FOUND.get() {
        return Ok(path.clone());
    }
    let found = match on_path(NAME) {
        Some(path) => path,
        None => {
            apt_install("the emulator qemu-system-arm", &[NAME])?;
            on_path(NAME).ok_or_else(|| missing("qemu-system-arm", &[NAME], None))?
        }
    };
    Ok(FOUND.get_or_init(|| found).clone())
}

/// The way to a target, decided once in a process and told in one line.
fn route(target: Target) -> Result<Route, ToolError> {
    static CHOSEN: Mutex<Option<HashMap<Target, Route>>> = Mutex::new(None);
    let mut chosen = CHOSEN.lock().unwrap_or_else(PoisonError::into_inner);
    let chosen = chosen.get_or_insert_default();
    if let Some(route) = chosen.get(&target) {
        return Ok(route.clone());
    }
    let route = choose(target)?;
    if !chosen.values().any(|other| *other == route) {
        match &route {
            Route::Installed => eprintln!("toolchain: the installed target {}", target.triple()),
            Route::Source { rustc, linker } => eprintln!(
                "toolchain: core from source by {}, linked by {}",
                rustc.display(),
                linker.display()
            ),
        }
    }
    chosen.insert(target, route.clone());
    Ok(route)
}

fn choose(target: Target) -> Result<Route, ToolError> {
    let library = Path::new("lib/rustlib").join(target.triple()).join("lib");
    let sysroot = sysroot(Path::new("rustc"));
    let has =
        |sysroot: &Option<PathBuf>| sysroot.as_ref().is_some_and(|s| s.join(&library).exists());
    if has(&sysroot) || (rustup_may_install() && rustup_add(target) && has(&sysroot)) {
        return Ok(Route::Installed);
    }
    let rustc = match source_compiler() {
        Some(rustc) => rustc,
        None => {
            let what = format!("Rust for {}", target.triple());
            apt_install(&what, &RUST_PACKAGES).map_err(|error| with_rustup(error, target))?;
            source_compiler()
                .ok_or_else(|| with_rustup(missing(&what, &RUST_PACKAGES, None), target))?
        }
    };
    let linker = match linker() {
        Some(linker) => linker,
        None => {
            apt_install("a linker for firmware", &[LINKER_PACKAGE])?;
            linker().ok_or_else(|| missing("a linker for firmware", &[LINKER_PACKAGE], None))?
        }
    };
    Ok(Route::Source { rustc, linker })
}

/// Debian 12's compiler, its source and a linker (security suite).
const RUST_PACKAGES: [&str; 3] = ["rustc-web", "rust-web-src", LINKER_PACKAGE];
const LINKER_PACKAGE: &str = "lld-22";
const LINKERS: [&str; 3] = ["rust-lld", "ld.lld-22", "ld.lld"];
const OLDEST: (u32, u32) = (1, 95);

fn rustup_may_install() -> bool {
    std::env::var_os("RUSTUP_AUTO_INSTALL").is_none_or(|value| value != "0")
}

fn rustup_add(target: Target) -> bool {
    let Some(rustup) = on_path("rustup") else {
        return false;
    };
    eprintln!("toolchain: rustup target add {}", target.triple());
    let mut command = Command::new(rustup);
    command.args(["--quiet", "target", "add", target.triple()]).current_dir(workspace());
    capture(command, false).is_ok_and(|(ok, _)| ok)
}

/// A compiler new enough that has the source of its library: the usual one, or the system's.
fn source_compiler() -> Option<PathBuf> {
    let candidates = [on_path("rustc"), Some(PathBuf::from("/usr/bin/rustc"))];
    candidates.into_iter().flatten().find(|rustc| {
        version(rustc).is_some_and(|version| version >= OLDEST)
            && sysroot(rustc).is_some_and(|s| s.join("lib/rustlib/src/rust/library/core").exists())
    })
}

fn linker() -> Option<PathBuf> {
    let host = ask(Path::new("rustc"), &["--print", "host-tuple"]);
    let bundled = sysroot(Path::new("rustc"))
        .zip(host)
        .map(|(sysroot, host)| sysroot.join("lib/rustlib").join(host).join("bin/rust-lld"))
        .filter(|path| path.exists());
    bundled.or_else(|| LINKERS.iter().find_map(|name| on_path(name)))
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

/// What a program prints in the workspace, trimmed; `None` if it fails.
fn ask(program: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(workspace()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().into())
}

pub(crate) fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|directory| directory.join(name)).find(|file| file.is_file())
}

fn missing(what: &str, packages: &[&str], reason: Option<String>) -> ToolError {
    let sudo = if is_root() { "" } else { "sudo " };
    let packages = packages.join(" ");
    let command = format!("{sudo}apt-get update && {sudo}apt-get install --no-remove {packages}");
    ToolError::Missing { what: what.into(), command, reason }
}

/// Where rustup is in use, the shorter way to mend it is rustup's.
fn with_rustup(error: ToolError, target: Target) -> ToolError {
    match error {
        ToolError::Missing { what, command, reason } if on_path("rustup").is_some() => {
            let command = format!("rustup target add {}` or `{command}", target.triple());
            ToolError::Missing { what, command, reason }
        }
        error => error,
    }
}

fn is_root() -> bool {
    ask(Path::new("id"), &["-u"]).is_some_and(|id| id == "0")
}

/// Installs packages by apt-get, as root only, one process at a time, and never at the price of
/// removing a package.
fn apt_install(what: &str, packages: &[&str]) -> Result<(), ToolError> {
    let refused = |reason: &str| missing(what, packages, Some(reason.into()));
    let apt =
        on_path("apt-get").ok_or_else(|| refused("there is no apt-get to install it with"))?;
    if !is_root() {
        return Err(refused("only root may install it"));
    }
    let directory = firmware_dir();
    fs::create_dir_all(&directory).map_err(io_error(directory.display()))?;
    let _lock = locked(&directory.join("apt.lock"))?;
    eprintln!("toolchain: apt-get install {}", packages.join(" "));
    let apt = |arguments: &[&str]| {
        let mut command = Command::new(&apt);
        command.args(["-qq", "-o", "DPkg::Lock::Timeout=300"]).args(arguments);
        capture(command, false)
    };
    // A failed update is no reason to stop: the lists at hand may do.
    apt(&["update"])?;
    let install = ["install", "--yes", "--no-remove", "--no-install-recommends"];
    let (ok, output) = apt(&[&install[..], packages].concat())?;
    let last = output.lines().rev().find(|line| line.starts_with("E:"));
    if ok { Ok(()) } else { Err(refused(last.unwrap_or("apt-get failed"))) }
}

/// An exclusive lock on a file, freed when dropped.
fn locked(path: &Path) -> Result<File, ToolError> {
    let file = File::create(path).map_err(io_error(path.display()))?;
    file.lock().map_err(io_error(path.display()))?;
    Ok(file)
}

/// Cargo, without the environment by which an outer cargo would steer it.
fn cargo() -> Command {
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
fn capture(mut command: Command, echo: bool) -> Result<(bool, String), ToolError> {
    let name = command.get_program().to_string_lossy().into_owned();
    command.env("DEBIAN_FRONTEND", "noninteractive").stdin(Stdio::null());
    let mut child =
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(io_error(&name))?;
    let mut output = String::new();
    if let Some(stderr) = child.stderr.take() {
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

    #[test]
    fn a_missing_tool_names_the_command() {
        let error = missing("qemu-system-arm", &["qemu-system-arm"], Some("no root".into()));
        let text = error.to_string();
        assert!(text.contains("apt-get install --no-remove qemu-system-arm"), "{text}");
        assert!(!text.contains('\n'), "{text}");
    }
}

//! Builds and lints firmware images.

use super::apt;
use super::error::{ToolError, io_error};
use super::process::{Show, capture, cargo, locked};
use super::route::{Route, route};
use super::{Profile, Target, firmware_dir};
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A firmware image to build.
#[derive(Clone, Debug)]
pub struct Firmware<'a> {
    /// The image: a binary of the package `picket-firmware`.
    pub bin: &'a str,
    /// The core.
    pub target: Target,
    /// Features of the package.
    pub features: &'a [&'a str],
    /// Speed or size.
    pub profile: Profile,
}

impl Firmware<'_> {
    /// Builds the image; what is missing is downloaded first. Stderr has a bar of cargo's steps where it is
    /// a terminal, else a line where it will take long. Returns the ELF file, which no other combination of features overwrites.
    pub fn build(&self) -> Result<PathBuf, ToolError> {
        self.run(true, &[])
    }

    /// Builds like [`Firmware::build`], with other images that differ in nothing but their name: cargo links them on all
    /// of the host's cores at once, and finds them ready when they are needed.
    pub fn build_beside(&self, others: &[&str]) -> Result<PathBuf, ToolError> {
        self.run(true, others)
    }

    /// Builds like [`Firmware::build`], but without a bar: for images meant to fail.
    pub fn build_quietly(&self) -> Result<PathBuf, ToolError> {
        self.run(false, &[])
    }

    fn run(&self, seen: bool, others: &[&str]) -> Result<PathBuf, ToolError> {
        let route = route(self.target.triple())?;
        let directory = firmware_dir().join(route.directory());
        let images = directory.join("images");
        fs::create_dir_all(&images).map_err(io_error(images.display()))?;
        // Another process may build the same binary with other features: the copy belongs to the
        // build, so both happen under one lock.
        let _lock = locked(&directory.join("build.lock"))?;
        let image = images.join(self.image_name());
        let core = self.target.name();
        let bar = seen && io::stderr().is_terminal();
        if !bar && !image.exists() {
            eprintln!(
                "toolchain: building {} for {core}: the first image of a core takes a minute",
                self.bin
            );
        }
        let mut command = build(&directory, &[self.target])?;
        command.args(["--bin", self.bin]).args(others.iter().flat_map(|bin| ["--bin", bin]));
        for (package, level) in self.profile.for_size() {
            let set = format!("profile.release.package.{package}.opt-level={level}");
            command.args(["--config", &set]);
        }
        command.args(["--features", &self.features.join(",")]);
        if ["frequency_only", "single"].contains(&self.bin) {
            // What a user who has nothing to choose builds.
            command.arg("--no-default-features");
        }
        if ["log", "defmt"].iter().any(|logs| self.features.contains(logs)) {
            command.env("DEFMT_LOG", "info");
        }
        let what = format!("building {}", self.bin);
        let show = if seen { Show::Steps(&what) } else { Show::Nothing };
        let (ok, output) = capture(command, show)?;
        if !ok {
            return Err(ToolError::Build { bin: self.bin.into(), output });
        }
        let built = directory.join(self.target.triple()).join("release").join(self.bin);
        // Another test may be running the image: it keeps the file that it has opened.
        let copy = image.with_extension("part");
        fs::copy(&built, &copy).map_err(io_error(built.display()))?;
        fs::rename(&copy, &image).map_err(io_error(image.display()))?;
        Ok(image)
    }

    fn image_name(&self) -> String {
        let parts = [self.bin, self.target.name(), self.profile.name(), &self.features.join("+")];
        format!("{}.elf", parts.join("-"))
    }
}

/// Compiles what images with these features take of other packages, for several cores at once: most of it is a few packages one
/// after the other, which leave the host's other cores idle. A core that only its flags tell from another waits for its first
/// image. Building an image reports what is missing for it.
pub fn prepare(targets: &[Target], features: &[&str]) -> Result<(), ToolError> {
    let targets: Vec<Target> = targets.iter().copied().filter(|t| t.cpu().is_none()).collect();
    let routes =
        targets.iter().map(|target| route(target.triple())).collect::<Result<Vec<_>, _>>()?;
    let Some(way) = routes.first().map(Route::directory) else { return Ok(()) };
    if routes.iter().any(|route| route.directory() != way) {
        return Ok(());
    }
    let directory = firmware_dir().join(way);
    fs::create_dir_all(&directory).map_err(io_error(directory.display()))?;
    let _lock = locked(&directory.join("build.lock"))?;
    // By way of an image, since what only an image takes is compiled for its linker alone: the smallest.
    let mut command = build(&directory, &targets)?;
    command.args(["--bin", "frequency_only", "--features", &features.join(",")]);
    let (ok, output) = capture(command, Show::Steps("building what images share"))?;
    if ok { Ok(()) } else { Err(ToolError::Build { bin: "frequency_only".into(), output }) }
}

/// Cargo's command that builds the firmware for these cores, which are reached by one way, in a directory.
fn build(directory: &Path, targets: &[Target]) -> Result<Command, ToolError> {
    let mut command = cargo();
    command
        .args(["build", "--package", "picket-firmware", "--release", "--target-dir"])
        .arg(directory);
    let mut from_source = false;
    for &target in targets {
        command.args(["--target", target.triple()]);
        target.tell(&mut command);
        from_source |= route(target.triple())?.lead(&mut command, target.triple());
    }
    if from_source {
        command.arg("-Zbuild-std=core");
    }
    Ok(command)
}

/// Lints the library and these images with these features for a target; warnings are errors.
pub fn lint(target: Target, images: &[&str], features: &[&str]) -> Result<(), ToolError> {
    let route = route(target.triple())?;
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
    command.args(["--quiet", "--package", "picket-firmware", "--lib"]);
    for image in images {
        command.args(["--bin", image]);
    }
    command.args(["--features", &features.join(","), "--target", target.triple()]);
    command.arg("--target-dir").arg(&directory);
    target.tell(&mut command);
    if target.cpu().is_some() {
        // LLVM 22 breaks down at `core` for the Cortex-M55 without optimisation.
        command.arg("--release");
    }
    if route == Route::Installed {
        command.args(["--", "-D", "warnings"]);
    }
    let (ok, output) = capture(command, Show::Lines)?;
    let bin = format!("{} ({})", target.name(), features.join(", "));
    if ok { Ok(()) } else { Err(ToolError::Build { bin, output }) }
}

/// The lint driver that belongs to a compiler.
fn clippy_driver(rustc: &Path) -> Result<PathBuf, ToolError> {
    let driver = rustc.with_file_name("clippy-driver");
    if driver.exists() {
        Ok(driver)
    } else {
        Err(apt::missing("the lint driver", &["rust-web-clippy"], None))
    }
}

//! Builds the archives for C: the crate `picket-c` for a core, sealed, so that a program sees the header's symbols and no others.

use super::error::{ToolError, io_error};
use super::process::{Show, capture, cargo, locked};
use super::programs::program;
use super::route::route;
use super::{Need, target_dir};
use object::read::archive::ArchiveFile;
use object::{Object, ObjectSymbol};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An archive for a core and an ABI for floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Archive {
    /// The name of its own folder of products.
    pub name: &'static str,
    /// The target's name, as rustc knows it; `None` for the machine at hand.
    triple: Option<&'static str>,
    /// Flags for the compiler besides the target.
    flags: &'static str,
}

/// The Cortex-M0 and M0+.
pub const M0: Archive = Archive { name: "m0plus", triple: Some("thumbv6m-none-eabi"), flags: "" };
/// The Cortex-M3.
pub const M3: Archive = Archive { name: "m3", triple: Some("thumbv7m-none-eabi"), flags: "" };
/// The Cortex-M4 with its floating-point unit, floats in its registers.
pub const M4F: Archive =
    Archive { name: "m4f-hard", triple: Some("thumbv7em-none-eabihf"), flags: "" };
/// The Cortex-M4 with or without it, floats in integer registers.
pub const M4: Archive =
    Archive { name: "m4f-soft", triple: Some("thumbv7em-none-eabi"), flags: "" };
/// The Cortex-M7, floats in its registers. Some M7 have no double precision, so none is used: the bits are the same.
pub const M7F: Archive = Archive {
    name: "m7-hard",
    triple: Some("thumbv7em-none-eabihf"),
    flags: "-Ctarget-cpu=cortex-m7\x1f-Ctarget-feature=-fp64",
};
/// The Cortex-M7, floats in integer registers.
pub const M7: Archive = Archive {
    name: "m7-soft",
    triple: Some("thumbv7em-none-eabi"),
    flags: "-Ctarget-cpu=cortex-m7",
};
/// The Cortex-M33 with its floating-point unit and DSP extension, floats in its registers.
pub const M33F: Archive = Archive {
    name: "m33-hard",
    triple: Some("thumbv8m.main-none-eabihf"),
    flags: "-Ctarget-cpu=cortex-m33",
};
/// The Cortex-M33 with its DSP extension, floats in integer registers.
pub const M33: Archive = Archive {
    name: "m33-soft",
    triple: Some("thumbv8m.main-none-eabi"),
    flags: "-Ctarget-cpu=cortex-m33",
};
/// The machine at hand.
pub const HOST: Archive = Archive { name: "host", triple: None, flags: "" };

/// How the names of the binutils for Cortex-M begin.
const CROSS: &str = "arm-none-eabi-";

/// What the archives are sealed with.
const BINUTILS: [&str; 3] = ["ld", "objcopy", "ar"];

/// What a compiler calls by itself, and every library of C has.
const OF_THE_SYSTEM: [&str; 4] = ["memcmp", "memcpy", "memmove", "memset"];

impl Archive {
    /// What it is built with.
    pub fn needs(&self) -> Vec<Need> {
        let Some(triple) = self.triple else {
            return BINUTILS.map(Need::Program).into();
        };
        let binutils = ["arm-none-eabi-ld", "arm-none-eabi-objcopy", "arm-none-eabi-ar"];
        [&[Need::Triple(triple)], &binutils.map(Need::Program)[..]].concat()
    }

    /// Builds and seals the archive. Returns its file.
    ///
    /// # Errors
    /// A tool is missing, or it does not build.
    pub fn build(&self) -> Result<PathBuf, ToolError> {
        let way = self.triple.map(route).transpose()?;
        let directory = target_dir().join("c").join(self.name);
        fs::create_dir_all(&directory).map_err(io_error(directory.display()))?;
        let _lock = locked(&directory.join("build.lock"))?;
        let mut command = cargo();
        command.args(["build", "--package", "picket-c", "--release", "--target-dir"]);
        command.arg(&directory).args(["--config", "profile.release.debug=false"]);
        let mut built = directory.clone();
        if let (Some(triple), Some(way)) = (self.triple, &way) {
            if way.lead(&mut command, triple) {
                command.arg("-Zbuild-std=core");
            }
            command.args(["--target", triple]);
            built.push(triple);
        }
        if !self.flags.is_empty() {
            command.env("CARGO_ENCODED_RUSTFLAGS", self.flags);
        }
        let what = format!("building the archive {}", self.name);
        let (ok, output) = capture(command, Show::Steps(&what))?;
        if !ok {
            return Err(ToolError::Build { bin: what, output });
        }
        built.extend(["release", "libpicket_c.a"]);
        let sealed = directory.join("libpicket.a");
        self.seal(&built, &sealed)?;
        Ok(sealed)
    }

    /// Makes one object of an archive, whose only symbols are the public ones, and an archive of that: the compiler's own `memcpy` and
    /// arithmetic of doubles stay inside, or they would take the place of the program's.
    fn seal(&self, from: &Path, to: &Path) -> Result<(), ToolError> {
        let names = public(from)?;
        let [whole, object, keep] =
            ["whole.o", "picket.o", "public.txt"].map(|name| to.with_file_name(name));
        fs::write(&keep, names.join("\n") + "\n").map_err(io_error(keep.display()))?;
        let mut link = self.tool("ld")?;
        link.args(["-r", "--gc-sections", "-o"]).arg(&whole);
        link.args(names.iter().map(|name| format!("--undefined={name}"))).arg(from);
        run(link)?;
        let mut copy = self.tool("objcopy")?;
        copy.arg(format!("--keep-global-symbols={}", keep.display())).arg("--strip-debug");
        // Bitcode, at which the index of some binutils ends empty.
        copy.args(["--remove-section=.llvmbc", "--remove-section=.llvmcmd"]);
        run_on(copy, &[&whole, &object])?;
        let part = to.with_extension("part");
        let _ = fs::remove_file(&part);
        let mut pack = self.tool("ar")?;
        pack.arg("rcsD");
        run_on(pack, &[&part, &object])?;
        let mut missing = undefined(&object)?;
        // A system has these; a core without one has the compiler's own, sealed in.
        missing.retain(|name| self.triple.is_some() || !OF_THE_SYSTEM.contains(&name.as_str()));
        if !missing.is_empty() {
            let output = format!("error: the archive is not whole: {}", missing.join(", "));
            return Err(ToolError::Build { bin: self.name.into(), output });
        }
        fs::rename(&part, to).map_err(io_error(to.display()))
    }

    /// One of the binutils for this archive's machine.
    fn tool(&self, name: &str) -> Result<Command, ToolError> {
        // Those of the machine at hand come with the C compiler, which Rust itself links by.
        let prefix = if self.triple.is_some() { CROSS } else { "" };
        program(&format!("{prefix}{name}")).map(Command::new)
    }
}

fn run(command: Command) -> Result<(), ToolError> {
    let bin = command.get_program().to_string_lossy().into_owned();
    match capture(command, Show::Nothing)? {
        (true, _) => Ok(()),
        (false, output) => Err(ToolError::Build { bin, output }),
    }
}

fn run_on(mut command: Command, files: &[&Path]) -> Result<(), ToolError> {
    command.args(files);
    run(command)
}

fn unread(file: &Path) -> impl Fn(object::Error) -> ToolError + '_ {
    |error| io_error(file.display())(std::io::Error::other(error))
}

/// The symbols that an archive's objects define and that begin as the header's do.
fn public(archive: &Path) -> Result<Vec<String>, ToolError> {
    let mut names = symbols(archive)?;
    names.retain(|name| name.starts_with("picket_"));
    Ok(names)
}

/// All symbols that the objects of an archive show to a linker, in order.
///
/// # Errors
/// It is no archive of objects.
pub fn symbols(archive: &Path) -> Result<Vec<String>, ToolError> {
    let bytes = fs::read(archive).map_err(io_error(archive.display()))?;
    let unread = unread(archive);
    let mut names = Vec::new();
    for member in ArchiveFile::parse(&*bytes).map_err(&unread)?.members() {
        let data = member.and_then(|member| member.data(&*bytes)).map_err(&unread)?;
        let file = object::File::parse(data).map_err(&unread)?;
        let shown = file.symbols().filter(|symbol| symbol.is_global() && symbol.is_definition());
        names.extend(shown.filter_map(|symbol| symbol.name().ok().map(str::to_owned)));
    }
    names.sort();
    names.dedup();
    Ok(names)
}

/// What an object asks of others.
fn undefined(object: &Path) -> Result<Vec<String>, ToolError> {
    let bytes = fs::read(object).map_err(io_error(object.display()))?;
    let file = object::File::parse(&*bytes).map_err(unread(object))?;
    let asked = file.symbols().filter(|symbol| symbol.is_undefined());
    let names = asked.filter_map(|symbol| symbol.name().ok().map(str::to_owned));
    Ok(names.filter(|name| !name.is_empty()).collect())
}

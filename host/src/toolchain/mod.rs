//! The one place that decides how firmware is built, and with what it is run.
//!
//! Two ways lead to a thumb target: the standard library that rustup installs for it, or `core`
//! built from source by a compiler whose source is at hand (rustup's `rust-src`, or Debian's
//! `rustc-web` and `rust-web-src`). Rustup adds a target that is missing, unless `RUSTUP_AUTO_INSTALL=0` forbids it; every other
//! program that is missing is unpacked from its Debian packages into a folder of ours (`unpacked.rs`). Nothing is installed, and
//! nobody is asked; what cannot be had is an error that names the cause and the command to type.

mod apt;
pub mod archive;
mod cache;
mod cmsis;
mod dependent;
mod error;
mod image;
mod needs;
mod node;
mod page;
mod process;
mod programs;
mod python;
mod route;
mod unpacked;

pub use cmsis::cmsis;
pub use dependent::Dependent;
pub use error::ToolError;
pub use error::io_error;
pub use image::{Firmware, lint, prepare};
pub use needs::{Need, have};
pub use node::node;
pub(crate) use node::scripts;
pub use page::{build_page, directory as page_directory};
pub(crate) use process::on_path;
pub use programs::{browser, program, qemu, qemu_riscv32};
pub use python::{build_wheel, environment};

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

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
    /// Cortex-M55: Helium beside that.
    M55,
}

impl Target {
    /// Every core.
    pub const ALL: [Self; 5] = [Target::M4f, Target::M3, Target::M33, Target::M0, Target::M55];

    /// The name that rustc knows.
    pub const fn triple(self) -> &'static str {
        match self {
            Target::M0 => "thumbv6m-none-eabi",
            Target::M3 => "thumbv7m-none-eabi",
            Target::M4f => "thumbv7em-none-eabihf",
            Target::M33 | Target::M55 => "thumbv8m.main-none-eabihf",
        }
    }

    /// What its images are called by.
    pub const fn name(self) -> &'static str {
        match self.cpu() {
            Some(cpu) => cpu,
            None => self.triple(),
        }
    }

    /// The core's name for the compiler, where the triple does not say all. For the others cargo's configuration does.
    const fn cpu(self) -> Option<&'static str> {
        match self {
            Target::M55 => Some("cortex-m55"),
            _ => None,
        }
    }

    /// Tells the compiler which core it is.
    fn tell(self, command: &mut Command) {
        if let Some(cpu) = self.cpu() {
            command.env("CARGO_ENCODED_RUSTFLAGS", format!("-Ctarget-cpu={cpu}"));
        }
    }
}

/// How the compiler optimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Profile {
    /// For speed: opt-level 3.
    #[default]
    Release,
    /// For size: opt-level "z", for our own code and the elementary functions. What an image takes of other packages it takes as
    /// generic functions, which are compiled with ours: they are compiled once for both.
    Size,
    /// Between them: opt-level 2 for the same packages, and "s" for those of them that no block is measured with.
    Balanced,
}

impl Profile {
    /// The name that people read.
    pub const fn name(self) -> &'static str {
        match self {
            Profile::Release => "release",
            Profile::Size => "size",
            Profile::Balanced => "balanced",
        }
    }

    /// The packages that are compiled at another opt-level than 3, each with its own.
    const fn for_size(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Profile::Release => &[],
            Profile::Size => &[
                ("picket-dsp", "'z'"),
                ("picket-firmware", "'z'"),
                ("picket-instrument", "'z'"),
                ("picket-wire", "'z'"),
                ("libm", "'z'"),
            ],
            Profile::Balanced => &[
                ("picket-dsp", "2"),
                ("picket-firmware", "2"),
                ("picket-instrument", "'s'"),
                ("picket-wire", "'s'"),
                ("libm", "'s'"),
            ],
        }
    }
}

/// The workspace's root: the clone that `cargo run` was called in, else the one that the program lies in, else the one around the
/// current folder, and for an installed program the one that it was built from. A copy of a clone or a renamed one is a clone of its own.
pub fn workspace() -> &'static Path {
    static ROOT: OnceLock<PathBuf> = OnceLock::new();
    ROOT.get_or_init(|| {
        let cargo = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
        let program = std::env::current_exe().ok();
        let here = std::env::current_dir().ok();
        let built = Path::new(env!("CARGO_MANIFEST_DIR"));
        [cargo, program, here]
            .into_iter()
            .flatten()
            .find_map(|place| clone_around(&place))
            .unwrap_or_else(|| built.parent().unwrap_or(built).to_owned())
    })
}

/// The clone that a place lies in.
fn clone_around(place: &Path) -> Option<PathBuf> {
    let parts = ["Cargo.toml", "host/Cargo.toml", "firmware/Cargo.toml", "web/page/index.html"];
    let is_clone = |folder: &&Path| parts.iter().all(|part| folder.join(part).is_file());
    place.ancestors().find(is_clone).map(Path::to_owned)
}

/// The programs outside the workspace that depend on the library as a stranger's would.
pub fn dependents() -> PathBuf {
    workspace().join("dependents")
}

/// Cargo's own folder for what it builds: `CARGO_TARGET_DIR`, else the one that this program was built in, else `target` in the
/// workspace. A relative path is that of the folder that cargo was called in, which a test does not see: so the program comes first.
fn target_dir() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let told = std::env::var_os("CARGO_TARGET_DIR").filter(|folder| !folder.is_empty());
        let told = told.map(PathBuf::from);
        let built = || std::env::current_exe().ok().and_then(|program| tagged(&program));
        match told {
            Some(folder) if folder.is_absolute() => folder,
            Some(folder) => built().or_else(|| std::path::absolute(&folder).ok()).unwrap_or(folder),
            None => built().unwrap_or_else(|| workspace().join("target")),
        }
    })
}

/// The folder around a program that cargo has marked as its own.
fn tagged(program: &Path) -> Option<PathBuf> {
    program.ancestors().find(|folder| folder.join("CACHEDIR.TAG").is_file()).map(Path::to_owned)
}

/// Where firmware and what belongs to it is built: `target/firmware`.
pub fn firmware_dir() -> PathBuf {
    target_dir().join("firmware")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_lies_in_the_folder_that_it_was_built_in() {
        let target = tempfile::tempdir().unwrap();
        let program = target.path().join("debug/deps/test");
        std::fs::create_dir_all(program.parent().unwrap()).unwrap();
        assert_ne!(tagged(&program).as_deref(), Some(target.path()));
        std::fs::write(target.path().join("CACHEDIR.TAG"), "").unwrap();
        assert_eq!(tagged(&program).as_deref(), Some(target.path()));
    }
}

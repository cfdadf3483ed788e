//! `picket c`: the library for C and C++, as a folder that CMake, Arduino, PlatformIO and Zephyr take as it is.

use crate::toolchain::archive::{Archive, HOST, M0, M3, M4, M4F, M7, M7F, M33, M33F};
use crate::toolchain::{Need, ToolError, have, io_error, workspace};
use clap::{Args, ValueEnum};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Builds the library for C and C++: header, archives, examples, and files for CMake, Arduino, PlatformIO and Zephyr.
#[derive(Args, Debug)]
pub struct Options {
    /// The cores, separated by commas; host is this machine
    #[arg(long, value_enum, value_delimiter = ',', required = true)]
    core: Vec<Core>,
    /// The folder to write; archives of other cores stay in it
    #[arg(long, value_name = "DIR", default_value = "dist/picket")]
    out: PathBuf,
}

/// A core that a program in C is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Core {
    /// Cortex-M0 and M0+
    M0plus,
    /// Cortex-M3
    M3,
    /// Cortex-M4 with floating-point unit; both ABIs, of which the soft one serves an M4 without the unit
    M4f,
    /// Cortex-M33 with DSP extension; both ABIs
    M33,
    /// Cortex-M7; both ABIs
    M7,
    /// This machine
    Host,
}

/// The folders of Arduino's rule for precompiled libraries: the board's `build.mcu`, and below it the floating-point unit and ABI that
/// are in its flags. What serves several of them is copied.
pub type Places = (Archive, &'static [&'static str]);

impl Core {
    /// Its archives, and where they lie in the package's `src`.
    pub const fn places(self) -> &'static [Places] {
        match self {
            Core::M0plus => &[(M0, &["cortex-m0plus", "cortex-m0"])],
            Core::M3 => &[(M3, &["cortex-m3"])],
            Core::M4f => &[
                (M4F, &["cortex-m4/fpv4-sp-d16-hard"]),
                (M4, &["cortex-m4", "cortex-m4/fpv4-sp-d16-softfp"]),
            ],
            Core::M33 => &[
                (M33F, &["cortex-m33/fpv5-sp-d16-hard"]),
                (M33, &["cortex-m33", "cortex-m33/fpv5-sp-d16-softfp"]),
            ],
            // PJRC's name of the Teensy 4's chip is the last of the first.
            Core::M7 => &[
                (
                    M7F,
                    &[
                        "cortex-m7/fpv5-d16-hard",
                        "cortex-m7/fpv5-sp-d16-hard",
                        "imxrt1062/fpv5-d16-hard",
                    ],
                ),
                (M7, &["cortex-m7", "cortex-m7/fpv5-d16-softfp"]),
            ],
            Core::Host => &[(HOST, &["host"])],
        }
    }
}

/// Builds and writes the package.
pub fn run(options: &Options) -> Result<ExitCode, ToolError> {
    let places: Vec<Places> = options.core.iter().flat_map(|core| core.places()).copied().collect();
    let needs: Vec<Need> = places.iter().flat_map(|(archive, _)| archive.needs()).collect();
    have(&needs)?;
    package(&places, &options.out)?;
    outln!("{}", options.out.display());
    Ok(ExitCode::SUCCESS)
}

/// Writes the package with these archives into a folder.
///
/// # Errors
/// A tool is missing, an archive does not build, or the folder cannot be written.
pub fn package(archives: &[Places], out: &Path) -> Result<(), ToolError> {
    let crate_of_c = workspace().join("c");
    copy(&crate_of_c.join("package"), out)?;
    copy(&crate_of_c.join("include"), &out.join("src"))?;
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&workspace().join(licence), &out.join(licence))?;
    }
    for &(archive, places) in archives {
        let built = archive.build()?;
        for place in places {
            copy(&built, &out.join("src").join(place).join("libpicket.a"))?;
        }
    }
    Ok(())
}

/// Copies a file or a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> Result<(), ToolError> {
    if !from.is_dir() {
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder).map_err(io_error(folder.display()))?;
        }
        return fs::copy(from, to).map(drop).map_err(io_error(to.display()));
    }
    for entry in fs::read_dir(from).map_err(io_error(from.display()))? {
        let entry = entry.map_err(io_error(from.display()))?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}

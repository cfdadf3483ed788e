//! `picket c`: the library for C and C++, as a folder that CMake, Arduino, PlatformIO and Zephyr take as it is.

use crate::toolchain::archive::{Archive, HOST, M0, M3, M4, M4F, M7, M7F, M33, M33F};
use crate::toolchain::{Need, ToolError, have, io_error, workspace};
use clap::{Args, ValueEnum};
use flate2::Compression;
use flate2::write::DeflateEncoder;
use rawzip::{CompressionMethod, ZipArchiveWriter};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Builds the library for C and C++: header, archives, examples, and files for CMake, Arduino, PlatformIO and Zephyr.
#[derive(Args, Debug)]
pub struct Options {
    /// The cores, separated by commas; host is this machine
    #[arg(long, value_enum, value_delimiter = ',', required_unless_present = "arduino")]
    core: Vec<Core>,
    /// For the boards of the Arduino sketch (Teensy 4, Pico, Pico 2, Nano 33 BLE), and a .zip for "Add .ZIP Library" beside the folder
    #[arg(long)]
    arduino: bool,
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
    /// The cores of the boards that the Arduino sketch names.
    pub const ARDUINO: [Self; 4] = [Self::M0plus, Self::M4f, Self::M33, Self::M7];

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
    let boards: &[Core] = if options.arduino { &Core::ARDUINO } else { &[] };
    let cores =
        options.core.iter().chain(boards.iter().filter(|core| !options.core.contains(core)));
    let places: Vec<Places> = cores.flat_map(|core| core.places()).copied().collect();
    let needs: Vec<Need> = places.iter().flat_map(|(archive, _)| archive.needs()).collect();
    have(&needs)?;
    package(&places, &options.out)?;
    if options.arduino {
        let file = options.out.with_extension("zip");
        pack(&options.out, &file).map_err(io::Error::other).map_err(io_error(file.display()))?;
        outln!("{}: Sketch, Include Library, Add .ZIP Library", file.display());
    } else {
        outln!("{}", options.out.display());
    }
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

/// Packs a folder as Arduino takes a library: all that is in it, below one folder.
fn pack(folder: &Path, file: &Path) -> Result<(), rawzip::Error> {
    let mut archive = ZipArchiveWriter::new(BufWriter::new(fs::File::create(file)?));
    let mut folders = vec![folder.to_path_buf()];
    while let Some(within) = folders.pop() {
        for entry in fs::read_dir(within)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = Path::new("Picket").join(path.strip_prefix(folder).unwrap_or(&path));
            let method = CompressionMethod::DEFLATE;
            let name = name.to_string_lossy();
            let (mut entry, config) =
                archive.new_file(&*name).compression_method(method).start()?;
            let encoder = DeflateEncoder::new(&mut entry, Compression::default());
            let mut packed = config.wrap(encoder);
            packed.write_all(&fs::read(&path)?)?;
            let (encoder, descriptor) = packed.finish()?;
            encoder.finish()?;
            entry.finish(descriptor)?;
        }
    }
    archive.finish()?.flush()?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use rawzip::ZipArchive;

    #[test]
    fn a_library_for_arduino_is_one_folder_with_everything_in_it() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("dist/picket");
        copy(&workspace().join("c/package"), &folder).unwrap();
        let file = place.path().join("picket.zip");
        pack(&folder, &file).unwrap();
        let bytes = fs::read(&file).unwrap();
        let archive = ZipArchive::from_slice(&bytes).unwrap();
        let names: Vec<String> = archive
            .entries()
            .map(|entry| String::from_utf8_lossy(entry.unwrap().file_path().as_ref()).into_owned())
            .collect();
        assert!(names.iter().all(|name| name.starts_with("Picket/")), "{names:?}");
        for wanted in ["Picket/library.properties", "Picket/examples/doppler/doppler.ino"] {
            assert!(names.iter().any(|name| name == wanted), "{wanted}: {names:?}");
        }
    }
}

//! How much machine code a measurement of one record length takes.

use super::Core;
use crate::emulator::{Footprint, RunError};
use crate::toolchain::{Firmware, Profile, io_error};
use object::{Object, ObjectSymbol, SymbolKind};
use std::fs;
use std::io;
use std::path::Path;

/// The modules of a measurement by least squares, as they appear in the names of functions.
const MODULES: [&str; 9] = [
    "8spectrum",
    "6scalar",
    "4tone7measure",
    "4tone5noise",
    "4tone9detection",
    "4tone9frequency",
    "4tone5sigma",
    "4tone3fit4real",
    "4tone3fit10fit_points",
];

/// What the names of functions contain that take an engine, in whatever module.
const ENGINE: &str = "8spectrum6engine";

/// Bytes of the functions of transform, search and estimate for real records of `n` samples in an image that has them
/// for every length: those of these modules, less those for another length or for I/Q records.
pub fn code(elf: &Path, n: usize) -> Result<u64, RunError> {
    let bytes = fs::read(elf).map_err(io_error(elf.display()))?;
    let file = object::File::parse(&*bytes)
        .map_err(|error| io_error(elf.display())(io::Error::other(error)))?;
    // Constants in a function's name are hexadecimal: the record's length beside its kind, else the transform's.
    let record = format!("6sample4RealKj{n:x}_");
    let own = format!("Kj{:x}_", n / 2);
    let lengths = [32, 64, 128, 256, 512, 1024, 2048, 4096].map(|m| format!("Kj{m:x}_"));
    let wanted = |name: &str| {
        let right = if name.contains("6sample4RealKj") {
            name.contains(&record)
        } else {
            name.contains(&own) || !lengths.iter().any(|other| name.contains(other))
        };
        let place = name.replace(ENGINE, "");
        right && !name.contains("6sample2Iq") && MODULES.iter().any(|module| place.contains(module))
    };
    let functions = file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text);
    Ok(functions.filter(|symbol| symbol.name().is_ok_and(wanted)).map(|symbol| symbol.size()).sum())
}

/// Bytes of program memory, code and tables, of an image that measures real records of 1,024 samples by the default method and
/// does nothing else, in the arithmetic of its core alone, built for size: its start-up and its vector table are counted, too. The image `frequency_only` answers
/// without a verdict, `single` with one.
pub fn program_memory(core: &Core, bin: &'static str) -> Result<u64, RunError> {
    let features = &["cores"];
    let image = Firmware { bin, target: core.target, features, profile: Profile::Size };
    Ok(Footprint::from_elf(&image.build()?)?.flash)
}

//! The images of both boards in a folder, with a page for somebody who has no Rust.

use super::{FlashError, Image, Kind, build};
use crate::output::Output;
use crate::pico;
use crate::toolchain::io_error;
use crc::{CRC_32_ISO_HDLC, Crc};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The page's name.
const PAGE: &str = "FLASHING.txt";

/// What each file is for.
const FILES: [&str; 3] = [
    "NUCLEO-F446RE: the usual image",
    "NUCLEO-F446RE: sets the chip's brown-out level, once; otherwise the usual one",
    "Raspberry Pi Pico",
];

/// Builds every image into a folder, and writes the page. Returns the page.
pub fn pack(folder: &Path, output: Output) -> Result<String, FlashError> {
    output.check_folder(folder).map_err(FlashError::Folder)?;
    fs::create_dir_all(folder).map_err(io_error(folder.display()))?;
    let mut images = Vec::new();
    for kind in [Kind::Usual, Kind::BrownOut] {
        images.push(build(kind)?);
    }
    images.push(pico::flash::build()?);
    let mut rows = Vec::new();
    for image in &images {
        let bytes = fs::read(&image.binary).map_err(io_error(image.binary.display()))?;
        let name = image.binary.file_name().unwrap_or_default();
        let to = folder.join(name);
        output.write(&to, &bytes).map_err(FlashError::Folder)?;
        rows.push((name.to_string_lossy().into_owned(), bytes));
    }
    let page = page(&rows, &images);
    output.write(&folder.join(PAGE), page.as_bytes()).map_err(FlashError::Folder)?;
    Ok(page)
}

fn page(rows: &[(String, Vec<u8>)], images: &[Image]) -> String {
    let mut page =
        format!("Picket {}: images to flash without Rust\n\n", env!("CARGO_PKG_VERSION"));
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let _ = writeln!(page, "{:22} {:>7}  {:8}  {:8}  for", "file", "bytes", "CRC-32", "program");
    for (((name, bytes), image), what) in rows.iter().zip(images).zip(FILES) {
        let (length, sum, program) = (bytes.len(), crc.checksum(bytes), image.program);
        let _ = writeln!(page, "{name:22} {length:7}  {sum:08x}  {program:08x}  {what}");
    }
    page + include_str!("flashing.txt")
}

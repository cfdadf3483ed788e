//! The Pico's image on its way to the board: a file that its drive takes.

use super::{FLASH, binary, usb_image};
use crate::emulator::{Footprint, RunError};
use crate::flash::{Board, FlashError, Image, drive};
use crate::toolchain::{firmware_dir, io_error};
use crc::{CRC_32_ISO_HDLC, Crc};
use object::{Object, ObjectSection};
use std::path::{Path, PathBuf};

/// Flash and RAM that the image may take. The chip has 2 MiB and 264 KiB; the stack needs 12 KiB.
pub const BUDGET: Footprint = Footprint { flash: 256 << 10, ram: 252 << 10 };

/// What the image takes: what runs from SRAM is stored in flash, too.
pub fn footprint(elf: &Path) -> Result<Footprint, RunError> {
    let mut footprint = Footprint::from_elf(elf)?;
    let data = std::fs::read(elf).map_err(io_error(elf.display()))?;
    let file = object::File::parse(&*data)
        .map_err(|error| io_error(elf.display())(std::io::Error::other(error)))?;
    footprint.ram += file.section_by_name(".hot").map_or(0, |section| section.size());
    Ok(footprint)
}

/// Builds the image, and the file for its drive.
pub fn build() -> Result<Image, FlashError> {
    let elf = usb_image()?;
    let bytes = binary(&elf)?;
    let path = firmware_dir().join("picket-pico.uf2");
    std::fs::write(&path, uf2(&bytes)).map_err(io_error(path.display()))?;
    let program = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes);
    Ok(Image { footprint: footprint(&elf)?, budget: BUDGET, program, elf, binary: path })
}

/// The image in blocks of UF2, each with 256 bytes and their address: Microsoft's format, with the number of the RP2040's family.
pub fn uf2(binary: &[u8]) -> Vec<u8> {
    const FAMILY: u32 = 0xE48B_FF56;
    const PAGE: usize = 256;
    let count = binary.len().div_ceil(PAGE) as u32;
    let mut blocks = Vec::new();
    for (number, page) in (0u32..).zip(binary.chunks(PAGE)) {
        let mut block = [0; 512];
        let address = FLASH + number * PAGE as u32;
        // Two magic numbers, a family follows, address, length, number and count, the family; the page; a third magic number.
        let head = [0x0A32_4655, 0x9E5D_5157, 0x2000, address, PAGE as u32, number, count, FAMILY];
        let words = block.as_chunks_mut().0.iter_mut();
        words.zip(head).for_each(|(place, word)| *place = word.to_le_bytes());
        // What follows the image in its last page stays erased.
        block[32..32 + PAGE].fill(0xFF);
        block[32..32 + page.len()].copy_from_slice(page);
        block[508..].copy_from_slice(&0x0AB1_6F30u32.to_le_bytes());
        blocks.extend_from_slice(&block);
    }
    blocks
}

/// Copies the file to the board's drive; gives the drive.
pub fn write(image: &Image) -> Result<PathBuf, FlashError> {
    let drive = drive::find(Board::Pico);
    let drive = drive.ok_or_else(|| FlashError::NoDrive(image.binary.clone()))?;
    drive::copy(Board::Pico, &image.binary, &drive)?;
    Ok(drive)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Read back by the format's rules.
    #[test]
    fn a_file_of_blocks_holds_the_image() {
        let image: Vec<u8> = (0..1000u32).map(|n| (n * 7) as u8).collect();
        let blocks = uf2(&image);
        assert_eq!(blocks.len(), 4 * 512);
        let mut flash = vec![0; 1024];
        for block in blocks.chunks_exact(512) {
            let word = |at: usize| u32::from_le_bytes(block[at..at + 4].try_into().unwrap());
            assert_eq!([word(0), word(4), word(508)], [0x0A32_4655, 0x9E5D_5157, 0x0AB1_6F30]);
            assert_eq!([word(8), word(16), word(24), word(28)], [0x2000, 256, 4, 0xE48B_FF56]);
            let at = (word(12) - FLASH) as usize;
            assert_eq!(at, 256 * word(20) as usize);
            flash[at..at + 256].copy_from_slice(&block[32..288]);
        }
        assert_eq!(flash[..1000], image);
        assert!(flash[1000..].iter().all(|&byte| byte == 0xFF));
    }

    #[test]
    fn a_drive_that_is_missing_is_told() {
        let missing = FlashError::NoDrive("picket.uf2".into()).to_string();
        assert!(missing.contains("BOOTSEL") && !missing.contains('\n'), "{missing}");
    }
}

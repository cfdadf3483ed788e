//! Settings in any flash that has a driver by `embedded-storage`.

use crate::storage::{PAGE, Page, Storage};
use core::cell::RefCell;
use embedded_storage::nor_flash::NorFlash;

/// Two pages of a flash. A word takes the smallest unit that the flash writes, 4 bytes or more, so a page takes 67 units and is erased as a
/// whole.
#[derive(Debug)]
pub struct Pages<F> {
    flash: RefCell<F>,
    at: [u32; 2],
}

impl<F: NorFlash> Pages<F> {
    /// Bytes from a word to the next.
    const STRIDE: usize = if F::WRITE_SIZE > 4 { F::WRITE_SIZE } else { 4 };
    /// Bytes of a page, which the flash can erase.
    pub const BYTES: usize = (PAGE * Self::STRIDE).next_multiple_of(F::ERASE_SIZE);

    /// The pages at these two offsets, multiples of the unit that the flash erases.
    pub const fn new(flash: F, at: [u32; 2]) -> Self {
        const { assert!(F::WRITE_SIZE <= 32 && Self::STRIDE.is_multiple_of(F::WRITE_SIZE)) };
        Self { flash: RefCell::new(flash), at }
    }

    fn of(&self, page: Page) -> u32 {
        let [a, b] = self.at;
        match page {
            Page::A => a,
            Page::B => b,
        }
    }
}

impl<F: NorFlash> Storage for Pages<F> {
    type Error = F::Error;

    fn read(&self, page: Page, index: usize) -> u32 {
        let (mut bytes, at) = ([0xFF; 4], self.of(page) + (index * Self::STRIDE) as u32);
        // A word that cannot be read does not belong to a whole page: the page's checksum fails.
        let read = self.flash.try_borrow_mut().map(|mut flash| flash.read(at, &mut bytes));
        if matches!(read, Ok(Ok(()))) { u32::from_le_bytes(bytes) } else { u32::MAX }
    }

    fn erase(&mut self, page: Page) -> Result<(), F::Error> {
        let at = self.of(page);
        self.flash.get_mut().erase(at, at + Self::BYTES as u32)
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), F::Error> {
        let at = self.of(page) + (index * Self::STRIDE) as u32;
        let mut bytes = [0xFF; 32];
        if let Some(place) = bytes.first_chunk_mut() {
            *place = word.to_le_bytes();
        }
        self.flash.get_mut().write(at, bytes.get(..Self::STRIDE).unwrap_or(&[]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::{Payload, ROOM, load, save};
    use core::convert::Infallible;
    use embedded_storage::nor_flash::{ErrorType, ReadNorFlash};
    use std::vec::Vec;

    /// Flash that writes `UNIT` bytes at once, each once after an erasure of 4 KB.
    struct Chip<const UNIT: usize>(Vec<u8>);

    impl<const UNIT: usize> ErrorType for Chip<UNIT> {
        type Error = Infallible;
    }

    impl<const UNIT: usize> ReadNorFlash for Chip<UNIT> {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
            bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            self.0.len()
        }
    }

    impl<const UNIT: usize> NorFlash for Chip<UNIT> {
        const WRITE_SIZE: usize = UNIT;
        const ERASE_SIZE: usize = 4096;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
            assert_eq!((from % 4096, to % 4096), (0, 0));
            self.0[from as usize..to as usize].fill(0xFF);
            Ok(())
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
            assert_eq!((offset as usize % UNIT, bytes.len() % UNIT), (0, 0));
            let place = &mut self.0[offset as usize..][..bytes.len()];
            assert!(place.iter().all(|&byte| byte == 0xFF), "written twice");
            place.copy_from_slice(bytes);
            Ok(())
        }
    }

    /// Saves in turn, and finds the newest page after each save. Memory around the pages does not change.
    fn turns<const UNIT: usize>() {
        let mut pages = Pages::new(Chip::<UNIT>(std::vec![0xA5; 16384]), [4096, 8192]);
        assert_eq!(load(&pages), None);
        for value in 1..6 {
            let payload = Payload::from([value; 4 * ROOM]);
            save(&mut pages, &payload).unwrap();
            let (_, sequence, saved) = load(&pages).unwrap();
            assert_eq!((sequence, saved), (u32::from(value) - 1, payload));
        }
        let bytes = pages.flash.into_inner().0;
        assert!(bytes[..4096].iter().chain(&bytes[12288..]).all(|&byte| byte == 0xA5));
    }

    #[test]
    fn settings_lie_in_flash_of_any_unit() {
        turns::<1>();
        turns::<4>();
        turns::<8>();
        turns::<32>();
    }
}

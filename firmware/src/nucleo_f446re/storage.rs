//! The last two sectors of flash as pages for settings, and the program's own checksum.

use super::registers::{flash, put, wait};
use crate::instrument::storage::{Page, Storage};
use core::ptr::{read_volatile, write_volatile};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// Sectors 6 and 7, 128 KiB each (RM 3.3, table 4); memory.x keeps the program below.
const PAGES: [(usize, u32); 2] = [(0x0804_0000, 6), (0x0806_0000, 7)];
/// Words of a page that may be touched.
const WORDS: usize = 256;

/// The flash controller.
#[derive(Debug)]
pub struct Flash;

/// The controller did not finish, or reports an error (FLASH_SR).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused(pub u32);

/// FLASH_CR (RM 3.8.4): PG 0, SER 1, SNB 6:3, PSIZE 9:8 = 2 words, STRT 16, LOCK 31.
const WORDWISE: u32 = 2 << 8;
/// FLASH_SR (RM 3.8.3): BSY 16, errors 8:4 and 1.
const BUSY: u32 = 1 << 16;
const ERRORS: u32 = 0x1F2;

impl Flash {
    fn place(page: Page) -> (usize, u32) {
        let [a, b] = PAGES;
        match page {
            Page::A => a,
            Page::B => b,
        }
    }

    /// Does `work` with the controller unlocked.
    fn unlocked(&mut self, control: u32, work: impl FnOnce()) -> Result<(), Refused> {
        const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
        // The core stands still while flash is busy, so few questions pass in 2 s; the watchdog bounds the rest.
        let ready = || wait(|| flash().sr().read().bits() & BUSY == 0);
        if !ready() {
            return Err(Refused(BUSY));
        }
        KEYS.iter().for_each(|&key| {
            put!(flash().keyr(), key);
        });
        put!(flash().sr(), ERRORS);
        put!(flash().cr(), control);
        work();
        let done = ready();
        let errors = flash().sr().read().bits() & ERRORS;
        put!(flash().cr(), 1 << 31);
        if done && errors == 0 { Ok(()) } else { Err(Refused(errors)) }
    }
}

impl Storage for Flash {
    type Error = Refused;

    fn read(&self, page: Page, index: usize) -> u32 {
        let (address, _) = Self::place(page);
        let index = index.min(WORDS);
        // SAFETY: the chip has flash there, which the linker does not use; any word is valid.
        unsafe { read_volatile(core::ptr::with_exposed_provenance::<u32>(address + 4 * index)) }
    }

    fn erase(&mut self, page: Page) -> Result<(), Refused> {
        let (_, sector) = Self::place(page);
        let control = WORDWISE | 1 << 1 | sector << 3;
        let done = self.unlocked(control, || {
            put!(flash().cr(), control | 1 << 16);
        });
        // DCEN 10, DCRST 12: the data cache may hold what was there (RM 3.4.2).
        let access = flash().acr().read().bits();
        put!(flash().acr(), access & !(1 << 10));
        put!(flash().acr(), access & !(1 << 10) | 1 << 12);
        put!(flash().acr(), access);
        done
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), Refused> {
        let (address, _) = Self::place(page);
        if index >= WORDS {
            return Err(Refused(0));
        }
        self.unlocked(WORDWISE | 1, || {
            // SAFETY: the place is erased flash of the page, unlocked for writing words; nothing else refers to it.
            unsafe {
                write_volatile(core::ptr::with_exposed_provenance_mut(address + 4 * index), word);
            }
            cortex_m::asm::dsb();
        })
    }
}

/// The program's checksum: CRC-32 of its parts in flash one after the other (vector table, code, constants, initial values), as its
/// file has them. What lies between them for alignment depends on the tool that wrote it.
pub fn program() -> u32 {
    unsafe extern "C" {
        static __stext: u32;
        static __etext: u32;
        static __srodata: u32;
        static __erodata: u32;
        static __sidata: u32;
        static __sdata: u32;
        static __edata: u32;
    }
    const START: usize = 0x0800_0000;
    const VECTORS: usize = 4 * (16 + super::vectors::LINES);
    let values = (&raw const __edata as usize).wrapping_sub(&raw const __sdata as usize);
    let stored = &raw const __sidata as usize;
    let parts = [
        (START, START + VECTORS),
        (&raw const __stext as usize, &raw const __etext as usize),
        (&raw const __srodata as usize, &raw const __erodata as usize),
        (stored, stored.wrapping_add(values)),
    ];
    let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    for (from, to) in parts {
        for address in (from..to).map(core::ptr::with_exposed_provenance) {
            // SAFETY: the program lies there; reading it changes nothing.
            digest.update(&[unsafe { read_volatile::<u8>(address) }]);
        }
    }
    digest.finalize()
}

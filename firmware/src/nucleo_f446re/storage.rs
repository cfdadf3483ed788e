//! Settings in two sectors of flash behind the vector table, and the program's own checksum.

use super::registers::flash;
use super::start::within;
use super::words::guard::LONGEST_MS;
use crate::instrument::checksum;
use crate::instrument::storage::{Page, Storage};
use core::ptr::{read_volatile, write_volatile};

/// Sectors 1 and 2, 16 KiB each (RM 3.3, table 4), whose erasure takes a quarter of that of the large ones: memory.x keeps the program
/// out of them.
const PAGES: [(usize, u8); 2] = [(0x0800_4000, 1), (0x0800_8000, 2)];
/// Words of a page in use.
const WORDS: usize = 256;

/// The flash controller.
#[derive(Debug, Default)]
pub struct Flash;

/// The controller did not finish, or reported an error; the word is FLASH_SR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused(pub u32);

/// FLASH_SR (RM 3.8.3): BSY 16, errors 8:4 and 1.
const BUSY: u32 = 1 << 16;
const ERRORS: u32 = 0x1F2;

impl Flash {
    fn place(page: Page) -> (usize, u8) {
        let [a, b] = PAGES;
        match page {
            Page::A => a,
            Page::B => b,
        }
    }

    /// Runs `work` with the controller unlocked, and waits for its end.
    fn unlocked(&mut self, work: impl FnOnce()) -> Result<(), Refused> {
        const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
        // The core stalls while flash is busy, unless the executed code is in its cache. Either way the timer goes on.
        let ready = || within(LONGEST_MS + 200, || !flash().sr().read().bsy().bit());
        if !ready() {
            return Err(Refused(BUSY));
        }
        KEYS.iter().for_each(|&key| {
            flash().keyr().write(|w| w.set(key));
        });
        flash().sr().write(|w| {
            w.operr().clear().wrperr().clear().pgaerr().clear();
            w.pgperr().clear().pgserr().clear().rderr().clear()
        });
        work();
        let done = ready();
        let errors = flash().sr().read().bits() & ERRORS;
        flash().cr().write(|w| w.lock().locked());
        if done && errors == 0 { Ok(()) } else { Err(Refused(errors)) }
    }
}

impl Storage for Flash {
    type Error = Refused;

    fn read(&self, page: Page, index: usize) -> u32 {
        let (address, _) = Self::place(page);
        let index = index.min(WORDS);
        // SAFETY: the chip has flash at this address, which the linker does not use. Any word is
        // valid.
        unsafe { read_volatile(core::ptr::with_exposed_provenance::<u32>(address + 4 * index)) }
    }

    fn erase(&mut self, page: Page) -> Result<(), Refused> {
        let (_, sector) = Self::place(page);
        let done = self.unlocked(|| {
            flash().cr().write(|w| {
                // SAFETY: the chip has a sector of this number.
                unsafe { w.snb().bits(sector) };
                w.psize().psize32().ser().sector_erase().lock().unlocked()
            });
            flash().cr().modify(|_, w| w.strt().start());
        });
        // The data cache may hold the old words (RM 3.4.2).
        flash().acr().modify(|_, w| w.dcen().disabled());
        flash().acr().modify(|_, w| w.dcrst().reset());
        flash().acr().modify(|_, w| w.dcrst().no_reset().dcen().enabled());
        done
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), Refused> {
        let (address, _) = Self::place(page);
        if index >= WORDS {
            return Err(Refused(0));
        }
        self.unlocked(|| {
            flash().cr().write(|w| w.psize().psize32().pg().program().lock().unlocked());
            // SAFETY: the address is erased flash of the page, unlocked for writing words; nothing
            // else refers to it.
            unsafe {
                write_volatile(core::ptr::with_exposed_provenance_mut(address + 4 * index), word);
            }
            cortex_m::asm::dsb();
        })
    }
}

/// The program's CRC-32, over its parts in flash in the order of its file: vector table, code, constants, initial values. The checksum
/// skips the padding between them, which depends on the tool that wrote the file.
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
        START..START + VECTORS,
        &raw const __stext as usize..&raw const __etext as usize,
        &raw const __srodata as usize..&raw const __erodata as usize,
        stored..stored.wrapping_add(values),
    ];
    // SAFETY: the linker's script puts the program there, and reading changes nothing.
    unsafe { checksum::of_memory(parts) }
}

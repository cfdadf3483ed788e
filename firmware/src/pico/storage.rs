//! Settings in the last two sectors of flash, and the program's own checksum.

use crate::instrument::checksum;
use crate::instrument::storage::{Page, Storage};
use core::ptr::{read_volatile, with_exposed_provenance};
use rp2040_hal::rom_data;

/// The address at which flash is read.
const START: usize = 0x1000_0000;
/// Bytes of a sector, and of a page, the smallest unit of writing.
const SECTOR: usize = 4096;
const PAGE: usize = 256;
/// The last two sectors of 2 MiB; pico.x keeps the program below.
const PLACES: [usize; 2] = [(2 << 20) - 2 * SECTOR, (2 << 20) - SECTOR];
/// Words of a sector in use.
const WORDS: usize = 256;

/// The flash.
#[derive(Debug, Default)]
pub struct Flash;

/// There is no such place, or the ROM has no such function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

const fn place(page: Page) -> usize {
    let [a, b] = PLACES;
    match page {
        Page::A => a,
        Page::B => b,
    }
}

/// An operation on flash.
enum Work<'a> {
    Erase,
    Write(&'a [u8; PAGE]),
}

/// The second boot stage, as memory to run it from: 252 bytes and their checksum.
type Stage = [u32; PAGE / 4];

/// Runs an operation by the ROM's functions, with interrupts off, since flash cannot be read meanwhile. A sector takes 0.4 s at most, a
/// page 3 ms (W25Q16JV, 9.6). This function lies in SRAM, like the whole module, and calls nothing in flash while flash cannot be read.
#[inline(never)]
fn work(offset: usize, work: &Work<'_>) {
    let mut stage: Stage = [0; PAGE / 4];
    for (index, word) in stage.iter_mut().enumerate() {
        let address = with_exposed_provenance::<u32>(START + 4 * index);
        // SAFETY: flash begins with this stage, and reading changes nothing.
        *word = unsafe { read_volatile(address) };
    }
    let connect = rom_data::connect_internal_flash::ptr();
    let exit = rom_data::flash_exit_xip::ptr();
    let erase = rom_data::flash_range_erase::ptr();
    let write = rom_data::flash_range_program::ptr();
    let flush = rom_data::flash_flush_cache::ptr();
    // SAFETY: a Thumb function of the size of `stage`, which returns where it was called from (DS
    // 2.8.1.3.1).
    let enter: extern "C" fn() =
        unsafe { core::mem::transmute(stage.as_ptr().expose_provenance() | 1) };
    let address = offset as u32;
    cortex_m::interrupt::free(|_| {
        // SAFETY: the order is the data sheet's (DS 2.8.3.1.3). Interrupts are off, the other core
        // sleeps in ROM, and nothing is read from flash until `enter` has made it readable.
        unsafe {
            connect();
            exit();
            match work {
                Work::Erase => erase(address, SECTOR, SECTOR as u32, 0x20),
                Work::Write(bytes) => write(address, bytes.as_ptr(), PAGE),
            }
            flush();
        }
        enter();
    });
}

impl Storage for Flash {
    type Error = Refused;

    fn read(&self, page: Page, index: usize) -> u32 {
        let address = START + place(page) + 4 * index.min(WORDS);
        // SAFETY: the chip has flash at this address, which the linker does not use. Any word is valid.
        unsafe { read_volatile(with_exposed_provenance::<u32>(address)) }
    }

    fn erase(&mut self, page: Page) -> Result<(), Refused> {
        work(place(page), &Work::Erase);
        Ok(())
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), Refused> {
        if index >= WORDS {
            return Err(Refused);
        }
        // Ones leave the old bits unchanged.
        let mut bytes = [0xFF; PAGE];
        let words = bytes.as_chunks_mut::<4>().0;
        *words.get_mut(index % (PAGE / 4)).ok_or(Refused)? = word.to_le_bytes();
        work(place(page) + 4 * index / PAGE * PAGE, &Work::Write(&bytes));
        Ok(())
    }
}

/// The program's CRC-32, over flash from its start to the image's end.
pub fn program() -> u32 {
    unsafe extern "C" {
        static __image_end: u32;
    }
    // SAFETY: the linker's script puts the program there, and reading changes nothing.
    unsafe { checksum::of_memory(core::iter::once(START..&raw const __image_end as usize)) }
}

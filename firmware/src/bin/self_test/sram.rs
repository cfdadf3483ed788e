//! A second copy of the program's code in SRAM, to compare the speed of the two memories.
//!
//! The code reaches its own functions by distances, so the copy calls itself. What it knows by address,
//! such as constants, is still read from flash.

use core::cell::UnsafeCell;

/// Room for the code, bytes.
const ROOM: usize = 64 << 10;

#[repr(C, align(32))]
struct Place(UnsafeCell<[u32; ROOM / 4]>);

// SAFETY: only `Copy::make` writes it, before anything executes there, and nothing else reads it.
unsafe impl Sync for Place {}

#[unsafe(link_section = ".uninit.code")]
static PLACE: Place = Place(UnsafeCell::new([0; ROOM / 4]));

/// The copy.
pub struct Copy {
    from: usize,
    to: usize,
}

impl Copy {
    /// Copies the code; `None` if there is no room for it.
    pub fn make() -> Option<Self> {
        unsafe extern "C" {
            static __stext: u32;
            static __etext: u32;
        }
        // Loops and tables lie as they did in their lines of 32 bytes.
        let from = (&raw const __stext as usize) & !31;
        let words = (&raw const __etext as usize).saturating_sub(from).div_ceil(4);
        if words > ROOM / 4 {
            return None;
        }
        let to = PLACE.0.get().cast::<u32>();
        for index in 0..words {
            // SAFETY: the code lies at these addresses of flash; the place has room, checked above,
            // and nobody else refers to it.
            unsafe {
                let word =
                    core::ptr::with_exposed_provenance::<u32>(from + 4 * index).read_volatile();
                to.add(index).write_volatile(word);
            }
        }
        // The copy is in memory before it is executed.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        Some(Copy { from, to: to.expose_provenance() })
    }

    /// The same function in the copy.
    pub fn of<T>(&self, function: fn(&mut T)) -> fn(&mut T) {
        let place = (function as usize).wrapping_sub(self.from).wrapping_add(self.to);
        // SAFETY: the function's code lies there as well, word by word at the same distances.
        unsafe { core::mem::transmute::<usize, fn(&mut T)>(place) }
    }
}

//! The stack that a program has used.

use core::ptr::read_volatile;

/// What the start-up code writes below the stack.
const PAINT: u32 = 0xCCCC_CCCC;

/// The lowest word of the stack that is known to have been in use.
#[derive(Clone, Copy, Debug)]
pub struct Stack(usize);

impl Stack {
    /// The most words with the start-up code's paint below the last used one: an array in a frame that the program has not written.
    const WINDOW: usize = 512;

    /// A stack whose use is not yet known.
    pub fn unknown() -> Self {
        unsafe extern "C" {
            static mut _stack_start: u32;
        }
        Stack(&raw const _stack_start as usize)
    }

    /// The room for the stack, bytes.
    pub fn room() -> u32 {
        unsafe extern "C" {
            static mut _stack_start: u32;
            static mut _stack_end: u32;
        }
        (&raw const _stack_start as usize).saturating_sub(&raw const _stack_end as usize) as u32
    }

    /// The largest stack so far, bytes, however much of its frames the program has left unwritten. Cost: a read for each free word.
    pub fn used() -> u32 {
        unsafe extern "C" {
            static mut _stack_start: u32;
            static mut _stack_end: u32;
        }
        let (top, bottom) = (&raw const _stack_start as usize, &raw const _stack_end as usize);
        // SAFETY: each address lies between the two ends of the stack, and is only read.
        let word = |place: &usize| unsafe {
            read_volatile(core::ptr::with_exposed_provenance::<u32>(*place))
        };
        let free = (bottom..top).step_by(4).take_while(|place| word(place) == PAINT).count();
        top.saturating_sub(bottom).saturating_sub(4 * free) as u32
    }

    /// The largest stack so far, bytes. Cost: some reads for each word of growth, and a window.
    pub fn high_water(&mut self) -> u32 {
        unsafe extern "C" {
            static mut _stack_start: u32;
            static mut _stack_end: u32;
        }
        let (top, bottom) = (&raw const _stack_start as usize, &raw const _stack_end as usize);
        let mut clean = 0;
        let mut place = self.0;
        while clean < Self::WINDOW && place > bottom.saturating_add(4) {
            place -= 4;
            // SAFETY: the address lies between the two ends of the stack, and is only read.
            let word = unsafe { read_volatile(core::ptr::with_exposed_provenance::<u32>(place)) };
            clean += 1;
            if word != PAINT {
                (self.0, clean) = (place, 0);
            }
        }
        top.saturating_sub(self.0) as u32
    }
}

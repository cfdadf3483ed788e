//! What outlives a reset, how a program ends, and how much stack it used.

use crate::control::settings::Settings;
use crate::report::boot::LastEnd;
use core::arch::naked_asm;
use core::cell::UnsafeCell;
use core::ptr::{read_volatile, write_volatile};
use cortex_m::peripheral::SCB;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// Words of the settings.
pub const WORDS: usize = Settings::BYTES / 4;

/// What is handed from one program to the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Legacy {
    /// How the last one ended.
    pub last: LastEnd,
    /// The settings it is to use, as it was told through the serial port.
    pub settings: Option<[u32; WORDS]>,
}

const MAGIC: u32 = 0x5049_434B;
/// Magic, last end, whether there are settings, settings, CRC.
const LENGTH: usize = 1 + 4 + 1 + WORDS + 1;

/// Memory that the start-up code leaves as it is.
#[repr(transparent)]
struct Retained(UnsafeCell<[u32; LENGTH]>);

// SAFETY: it is accessed word by word and volatile, by the main loop before anything else runs, and by whoever ends the program.
unsafe impl Sync for Retained {}

#[unsafe(link_section = ".uninit.retained")]
static RETAINED: Retained = Retained(UnsafeCell::new([0; LENGTH]));

impl Retained {
    fn words(&self) -> [u32; LENGTH] {
        let mut words = [0; LENGTH];
        let first = self.0.get().cast::<u32>();
        for (index, word) in words.iter_mut().enumerate() {
            // SAFETY: within the array; memory of the chip is always something.
            *word = unsafe { read_volatile(first.add(index)) };
        }
        words
    }

    fn keep(&self, words: &[u32; LENGTH]) {
        let first = self.0.get().cast::<u32>();
        for (index, &word) in words.iter().enumerate() {
            // SAFETY: within the array, which nothing else refers to.
            unsafe { write_volatile(first.add(index), word) };
        }
    }
}

fn checksum(words: &[u32]) -> u32 {
    let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    words.iter().for_each(|word| digest.update(&word.to_le_bytes()));
    digest.finalize()
}

impl Legacy {
    /// Takes what the last program left; nothing after power-on.
    pub fn take() -> Self {
        let words = RETAINED.words();
        RETAINED.keep(&[0; LENGTH]);
        let Some((&crc, body)) = words.split_last() else { return Self::default() };
        let Some((&[MAGIC, kind, pc, a, b, some], settings)) = body.split_first_chunk() else {
            return Self::default();
        };
        if crc != checksum(body) {
            return Self::default();
        }
        let settings = settings.first_chunk().filter(|_| some != 0).copied();
        Legacy { last: LastEnd { kind, pc, more: [a, b] }, settings }
    }

    /// Leaves this to the next program, and starts it.
    pub fn leave(self) -> ! {
        let LastEnd { kind, pc, more: [a, b] } = self.last;
        let head = [MAGIC, kind, pc, a, b, u32::from(self.settings.is_some())];
        let body = head.into_iter().chain(self.settings.unwrap_or([0; WORDS]));
        let mut words = [0; LENGTH];
        words.iter_mut().zip(body).for_each(|(place, word)| *place = word);
        if let Some((last, body)) = words.split_last_mut() {
            *last = checksum(body);
        }
        RETAINED.keep(&words);
        SCB::sys_reset()
    }
}

/// An interrupt that nobody expects.
pub extern "C" fn unexpected() {
    // SAFETY: the system control block is always there, and reading ICSR changes nothing.
    let number = unsafe { (*SCB::PTR).icsr.read() } & 0x1FF;
    end(LastEnd { kind: 2, pc: 0, more: [number, 0] })
}

fn end(last: LastEnd) -> ! {
    Legacy { last, settings: None }.leave()
}

/// A fault hands the stack with the interrupted program's registers over.
// SAFETY: this is the name by which cortex-m-rt's vector table knows the handler, and it does not return.
#[unsafe(no_mangle)]
#[unsafe(naked)]
extern "C" fn HardFault() -> ! {
    naked_asm!("mrs r0, msp", "b {}", sym hard_fault)
}

/// # Safety
/// `frame` must be what the core stacked: eight words.
unsafe extern "C" fn hard_fault(frame: *const u32) -> ! {
    // The configurable faults' status (CFSR).
    const CFSR: *const u32 = 0xE000_ED28 as *const u32;
    // SAFETY: the caller vouches for the frame, of which lr is word 5 and pc word 6; the register is always there.
    let [lr, pc, cfsr] =
        unsafe { [read_volatile(frame.add(5)), read_volatile(frame.add(6)), read_volatile(CFSR)] };
    end(LastEnd { kind: 1, pc, more: [lr, cfsr] })
}

/// Calls a function that does not exist: the image links only if the optimiser finds no way to a panic.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn picket_can_panic() -> !;
    }
    // SAFETY: there is no such function: an image in which this call can be reached does not link.
    unsafe { picket_can_panic() }
}

/// The lowest word of the stack that is known to have been in use.
#[derive(Clone, Copy, Debug)]
pub struct Stack(usize);

impl Stack {
    /// Words without the start-up code's paint that may lie below the last one without it: a frame's array that nobody has written.
    const WINDOW: usize = 512;

    /// Nothing known.
    pub fn unknown() -> Self {
        unsafe extern "C" {
            static mut _stack_start: u32;
        }
        Stack(&raw const _stack_start as usize)
    }

    /// Bytes of stack that were ever in use. Cost: some reads for each word of growth, and a window.
    pub fn high_water(&mut self) -> u32 {
        unsafe extern "C" {
            static mut _stack_start: u32;
            static mut _stack_end: u32;
        }
        const PAINT: u32 = 0xCCCC_CCCC;
        let (top, bottom) = (&raw const _stack_start as usize, &raw const _stack_end as usize);
        let mut clean = 0;
        let mut place = self.0;
        while clean < Self::WINDOW && place > bottom.saturating_add(4) {
            place -= 4;
            // SAFETY: between the two ends of the stack, and only read.
            let word = unsafe { read_volatile(core::ptr::with_exposed_provenance::<u32>(place)) };
            clean += 1;
            if word != PAINT {
                (self.0, clean) = (place, 0);
            }
        }
        top.saturating_sub(self.0) as u32
    }
}

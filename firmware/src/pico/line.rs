//! UART0: a ring that a DMA channel empties; and what came from the hosts, here and at the other port. The program never waits for the line. A frame without
//! room is dropped whole and counted.

use super::converter::busy;
use super::inbox::Inbox;
use super::registers::{control, dma, enable, failed, put, uart};
use super::start::within;
use super::words::{OUT_BITS, TRANSMIT};
use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::interrupt::{Mutex, free};
use rp2040_hal::pac;
use static_cell::ConstStaticCell;

/// Room for bytes to the host: 20 records.
const OUT: usize = 1 << OUT_BITS;

/// The bytes to the host, aligned to their number: the channel's address wraps there.
#[repr(C, align(2048))]
struct Ring([u8; OUT]);
const _: () = assert!(size_of::<Ring>() == align_of::<Ring>());

/// Bytes written to the ring, and bytes given to the channel; modulo 2^32.
static WRITTEN: AtomicU32 = AtomicU32::new(0);
static TOLD: AtomicU32 = AtomicU32::new(0);
/// The ports with hosts: this one, and USB.
const PORTS: usize = if cfg!(feature = "usb") { 2 } else { 1 };
const OWN: usize = 0;
#[cfg(feature = "usb")]
const USB: usize = 1;

static INBOX: Mutex<RefCell<Inbox<PORTS>>> = Mutex::new(RefCell::new(Inbox::new()));

fn inbox<T>(work: impl FnOnce(&mut Inbox<PORTS>) -> T) -> Option<T> {
    free(|token| INBOX.borrow(token).try_borrow_mut().ok().map(|mut inbox| work(&mut inbox)))
}

/// The main loop's ends.
pub struct Serial {
    ring: &'static mut [u8; OUT],
    /// Bytes that had left the ring at the last look; modulo 2^32.
    left: u32,
}

/// Adds to a count that is written in one place only.
fn add(count: &AtomicU32, more: u32) {
    count.store(count.load(Relaxed).wrapping_add(more), Relaxed);
}

/// Puts bytes into a ring to which `written` bytes were written before. It begins again where it ends.
pub fn put_in<const OUT: usize>(ring: &mut [u8; OUT], written: u32, bytes: &[u8]) {
    let (before, after) = ring.split_at_mut(written as usize % OUT);
    let (first, rest) = bytes.split_at(bytes.len().min(after.len()));
    for (places, bytes) in [(after, first), (before, rest)] {
        if let Some(places) = places.get_mut(..bytes.len()) {
            places.copy_from_slice(bytes);
        }
    }
}

impl Serial {
    /// Sets up channel and queue of a running port; `None` at the second call.
    pub fn start() -> Option<Self> {
        static RING: ConstStaticCell<Ring> = ConstStaticCell::new(Ring([0; OUT]));
        let ring = &mut RING.try_take()?.0;
        let channel = dma().ch(TRANSMIT);
        put!(channel.ch_read_addr(), ring.as_ptr().expose_provenance() as u32);
        put!(channel.ch_write_addr(), uart().uartdr().as_ptr() as u32);
        set();
        put!(dma().inte1(), 1 << TRANSMIT);
        uart().uartdmacr().write(|w| w.txdmae().set_bit());
        // An interrupt at four bytes received, and after a pause.
        // SAFETY: the levels have this number (DS 4.2.8).
        uart().uartifls().write(|w| unsafe { w.rxiflsel().bits(0).txiflsel().bits(0) });
        uart().uartimsc().write(|w| w.rtim().set_bit().rxim().set_bit());
        enable(pac::Interrupt::DMA_IRQ_1);
        enable(pac::Interrupt::UART0_IRQ);
        Some(Self { ring, left: 0 })
    }

    /// Whether there is room for this many bytes.
    pub fn has_room(&self, bytes: usize) -> bool {
        OUT.saturating_sub(unsent() as usize) >= bytes
    }

    /// Sends a frame whole and returns true, or drops it and returns false.
    pub fn send(&mut self, frame: &[u8]) -> bool {
        if !self.has_room(frame.len()) {
            return false;
        }
        put_in(self.ring, WRITTEN.load(Relaxed), frame);
        // The barrier puts the bytes in memory before the channel reads them.
        cortex_m::asm::dmb();
        add(&WRITTEN, frame.len() as u32);
        tell();
        true
    }

    /// Whether bytes wait and none has left since the last call.
    pub fn stalled(&mut self) -> bool {
        let waiting = unsent();
        let left = WRITTEN.load(Relaxed).wrapping_sub(waiting);
        waiting > 0 && core::mem::replace(&mut self.left, left) == left
    }

    /// The next byte of a whole frame from a host; `None` if none waits.
    pub fn receive(&mut self) -> Option<u8> {
        inbox(Inbox::take)?
    }

    /// Waits, within bounded time, until the line has sent everything. Called before a reset.
    pub fn flush(&mut self) {
        // The ring alone takes 23 ms. The port is busy until the last bit is out.
        let _ = within(100, || unsent() == 0 && uart().uartfr().read().busy().bit_is_clear());
        #[cfg(feature = "usb")]
        super::usb::flush();
    }
}

/// Bytes in the ring.
fn unsent() -> u32 {
    free(|_| {
        let left = dma().ch(TRANSMIT).ch_trans_count().read().bits();
        WRITTEN.load(Relaxed).wrapping_sub(TOLD.load(Relaxed)).wrapping_add(left)
    })
}

/// Sets the channel that feeds the port: bytes from the ring. Its end starts nothing.
fn set() {
    dma().ch(TRANSMIT).ch_al1_ctrl().write(|w| {
        let w = control(w, TRANSMIT).incr_read().set_bit().treq_sel().uart0_tx();
        // SAFETY: the ring has 2^OUT_BITS bytes, and is aligned to them.
        unsafe { w.ring_size().bits(OUT_BITS) }
    });
}

/// Gives the channel the bytes written since it started, unless it runs.
fn tell() {
    free(|_| {
        let channel = dma().ch(TRANSMIT);
        let more = WRITTEN.load(Relaxed).wrapping_sub(TOLD.load(Relaxed));
        if busy(TRANSMIT) || more == 0 {
            return;
        }
        if failed(TRANSMIT) {
            set();
        }
        add(&TOLD, more);
        // The channel's address is where the last transfer ended.
        put!(channel.ch_al1_trans_count_trig(), more);
    });
}

/// Handles the interrupt of the channel: the channel is at its end.
pub extern "C" fn sent() {
    put!(dma().ints1(), 1 << TRANSMIT);
    tell();
}

/// Whether a byte from a host can be taken. The loop must not sleep then.
pub fn waiting() -> bool {
    inbox(|inbox| inbox.due()) == Some(true)
}

/// Whether a program has the port over USB open.
pub fn usb_open() -> bool {
    #[cfg(feature = "usb")]
    return super::usb::open();
    #[cfg(not(feature = "usb"))]
    false
}

/// Takes bytes of the host at USB.
#[cfg(feature = "usb")]
pub fn hear(bytes: impl Iterator<Item = u8>) {
    inbox(|inbox| bytes.for_each(|byte| inbox.put(USB, byte)));
}

/// Handles the interrupt of the port: bytes were received.
pub extern "C" fn received() {
    inbox(|inbox| {
        // The port's own queue has 32 places.
        for _ in 0..32 {
            if uart().uartfr().read().rxfe().bit_is_set() {
                break;
            }
            inbox.put(OWN, uart().uartdr().read().bits() as u8);
        }
        uart().uarticr().write(|w| {
            w.oeic().clear_bit_by_one().beic().clear_bit_by_one().peic().clear_bit_by_one();
            w.feic().clear_bit_by_one().rtic().clear_bit_by_one().rxic().clear_bit_by_one()
        });
    });
}

//! USART2: two queues and an interrupt. The program never waits for the line. A frame without room is dropped whole and counted.

use super::registers::{enable, usart2};
use super::start::within;
use super::words::serial::{BAUD, divider};
use core::cell::RefCell;
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::NVIC;
use heapless::spsc::{Consumer, Producer, Queue};
use picket_dsp::acquire::queue::{put as enqueue, take as dequeue};
use static_cell::ConstStaticCell;
use stm32f4::stm32f446 as pac;

/// Room for bytes to the host: half a second of telemetry at the default rate, longer than any
/// pause of the host.
const OUT: usize = 3072;
/// Room for bytes from the host: two of the largest frames.
const IN: usize = 512;

/// Bytes in the queue to the host and in the queue from it. An entering byte is counted before it enters, a leaving one after it left.
static OUTWARD: AtomicUsize = AtomicUsize::new(0);
static INWARD: AtomicUsize = AtomicUsize::new(0);

/// The interrupt's ends of the two queues.
struct Line {
    out: Consumer<'static, u8>,
    into: Producer<'static, u8>,
}

static LINE: Mutex<RefCell<Option<Line>>> = Mutex::new(RefCell::new(None));

/// The main loop's ends of the two queues.
pub struct Serial {
    out: Producer<'static, u8>,
    into: Consumer<'static, u8>,
    /// Bytes that entered the queue to the host, and bytes that had left it at the last look; modulo 2^32.
    entered: u32,
    left: u32,
}

impl Serial {
    /// Sets up the port; `None` at the second call.
    pub fn start(bus_hz: u32) -> Option<Self> {
        static TO_HOST: ConstStaticCell<Queue<u8, OUT>> = ConstStaticCell::new(Queue::new());
        static FROM_HOST: ConstStaticCell<Queue<u8, IN>> = ConstStaticCell::new(Queue::new());
        let (out, line_out) = TO_HOST.try_take()?.split();
        let (line_into, into) = FROM_HOST.try_take()?.split();
        free(|token| {
            if let Ok(mut line) = LINE.borrow(token).try_borrow_mut() {
                *line = Some(Line { out: line_out, into: line_into });
            }
        });
        // SAFETY: the register is this number of cycles, whole ones and sixteenths of 16.
        usart2().brr().write(|w| unsafe { w.bits(divider(bus_hz, BAUD)) });
        listen(false);
        enable(pac::Interrupt::USART2);
        Some(Self { out, into, entered: 0, left: 0 })
    }

    /// Whether there is room for this many bytes.
    pub fn has_room(&self, bytes: usize) -> bool {
        (OUT - 1).saturating_sub(OUTWARD.load(Relaxed)) >= bytes
    }

    /// Sends a frame whole and returns true, or drops it and returns false.
    #[inline(never)] // once in an image, not for each kind of frame
    pub fn send(&mut self, frame: &[u8]) -> bool {
        if !self.has_room(frame.len()) {
            return false;
        }
        OUTWARD.fetch_add(frame.len(), Relaxed);
        self.entered = self.entered.wrapping_add(frame.len() as u32);
        for &byte in frame {
            // There is room: only the interrupt takes bytes, and so makes more room.
            let _ = enqueue(&mut self.out, byte);
        }
        NVIC::pend(pac::Interrupt::USART2);
        true
    }

    /// Whether bytes wait and none has left since the last call.
    pub fn stalled(&mut self) -> bool {
        let waiting = OUTWARD.load(Relaxed) as u32;
        let left = self.entered.wrapping_sub(waiting);
        waiting > 0 && core::mem::replace(&mut self.left, left) == left
    }

    /// The next byte from the host; `None` if none waits.
    pub fn receive(&mut self) -> Option<u8> {
        let byte = dequeue(&mut self.into)?;
        INWARD.fetch_sub(1, Relaxed);
        Some(byte)
    }

    /// Waits, within bounded time, until the line has sent everything. Called before a reset.
    pub fn flush(&mut self) {
        // The queue alone takes 33 ms.
        let _ = within(100, || {
            NVIC::pend(pac::Interrupt::USART2);
            // The last bit is out.
            OUTWARD.load(Relaxed) == 0 && usart2().sr().read().tc().bit()
        });
    }
}

/// Enables the port, with 8 bits, no parity and 16 samples a bit. A received byte interrupts; so does an empty transmit register, if it is
/// to be `filled`.
fn listen(filled: bool) {
    usart2().cr1().write(|w| {
        w.ue().enabled().te().enabled().re().enabled().rxneie().enabled().txeie().bit(filled)
    });
}

/// Whether a byte from the host waits. The loop must not sleep then.
pub fn waiting() -> bool {
    INWARD.load(Relaxed) > 0
}

/// Handles the interrupt: a byte was received, the transmit register is empty, or the main loop has bytes to send.
pub extern "C" fn serve() {
    free(|token| {
        if let Ok(mut line) = LINE.borrow(token).try_borrow_mut()
            && let Some(line) = line.as_mut()
        {
            line.serve();
        }
    });
}

impl Line {
    /// Bytes in one interrupt: the hardware's register takes two, QEMU's any number.
    const BURST: usize = 64;

    fn serve(&mut self) {
        for _ in 0..Self::BURST {
            let seen = usart2().sr().read();
            let received = seen.rxne().bit();
            if !(received || seen.ore().bit() || seen.nf().bit() || seen.fe().bit()) {
                break;
            }
            // Reading clears the flags. A byte without room spoils its frame, which is then
            // refused.
            let byte = usart2().dr().read().bits() as u8;
            if received && enqueue(&mut self.into, byte).is_ok() {
                INWARD.fetch_add(1, Relaxed);
            }
        }
        for _ in 0..Self::BURST {
            if !usart2().sr().read().txe().bit() {
                break;
            }
            let Some(byte) = dequeue(&mut self.out) else { break };
            OUTWARD.fetch_sub(1, Relaxed);
            usart2().dr().write(|w| w.dr().set(byte.into()));
        }
        let more = self.out.ready();
        listen(more);
        // QEMU 7.2 has no interrupt for an empty register, and its register is always empty.
        if more && usart2().sr().read().txe().bit() {
            NVIC::pend(pac::Interrupt::USART2);
        }
    }
}

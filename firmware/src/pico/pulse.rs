//! The sync input at GP13: a rise opens the gate for exactly the samples of one chirp, without the core.
//!
//! Each channel writes one word and starts the next channel, except for two, which a wrap starts:
//!
//! ```text
//! GP13 rises: slice 6 wraps   -> the converter's divider restarts, converter on, slice 7 on
//! last sample: slice 7 wraps  -> converter off, slice 7 off, rises meanwhile, slice 6 waits for the next one
//! ```

use super::converter::{busy, off, rest};
use super::elapsed::Pulsed;
use super::registers::{adc, dma, io, pads, put, pwm, single, wait};
use super::waveform::Count;
use super::words::{CORE_CYCLES, LINKS, PLACES, Words};
use core::sync::atomic::{AtomicU32, Ordering};
use rp2040_hal::pac::dma::ch::ch_al1_ctrl::TREQ_SEL_A::{self, PERMANENT, PWM_WRAP6, PWM_WRAP7};

/// The slice that counts rises of GP13. Slice 7 counts a chirp.
const RISES: usize = 6;
const GATE: usize = 7;
/// Slice 6 before the wrap of the next rise.
const READY: u32 = 0xFFFF;

/// Lets slice 6 count the rises of its B input, so that it does not drive this pin (DS 4.5.3).
fn count_rises() {
    pwm().ch(RISES).csr().write(|w| w.divmode().rise());
}

/// A ring that a channel writes to.
#[repr(align(64))]
struct Ring([AtomicU32; PLACES]);

impl Ring {
    const fn new() -> Self {
        const { assert!(size_of::<Self>() == 64) };
        Self([const { AtomicU32::new(0) }; PLACES])
    }

    fn address(&self) -> u32 {
        self.0.as_ptr().expose_provenance() as u32
    }

    fn at(&self, place: usize) -> u32 {
        self.0.get(place % PLACES).map_or(0, |word| word.load(Ordering::Relaxed))
    }
}

/// The rises during each chirp that is over.
static MEANWHILE: Ring = Ring::new();

/// The words that the channels write: the converter's divider, which then begins again (DS 4.9.6); the converter on, slices 6 and 7, the
/// converter off, slice 6, ready.
static DIVIDER: AtomicU32 = AtomicU32::new(0);
static CONVERTER_ON: AtomicU32 = AtomicU32::new(0);
static BOTH_SLICES: AtomicU32 = AtomicU32::new(1 << RISES | 1 << GATE);
static CONVERTER_OFF: AtomicU32 = AtomicU32::new(1);
static ONE_SLICE: AtomicU32 = AtomicU32::new(1 << RISES);
static WAITING: AtomicU32 = AtomicU32::new(READY);

fn address(word: &AtomicU32) -> u32 {
    word.as_ptr().expose_provenance() as u32
}

/// Sets up the channel of one link, which waits for a request, writes one word, and starts the next channel.
fn link<const CHANNEL: usize>(next: usize, request: TREQ_SEL_A, read: u32, write: u32) {
    let channel = dma().ch(CHANNEL);
    put!(channel.ch_read_addr(), read);
    put!(channel.ch_write_addr(), write);
    put!(channel.ch_trans_count(), 1);
    channel.ch_al1_ctrl().write(|w| {
        let w = single(w, next).treq_sel().variant(request);
        if CHANNEL == LINKS[5] {
            // SAFETY: the ring has 2^6 bytes, and is aligned to them.
            unsafe { w.incr_write().set_bit().ring_sel().set_bit().ring_size().bits(6) }
        } else {
            w
        }
    });
}

/// The sync input.
pub struct Pulse {
    gate: Count,
    /// Whether the input waits for rises or lets a chirp through.
    armed: bool,
    /// Chirps whose end was seen, from the last arming on.
    seen: usize,
    /// Rises without a chirp that are not yet counted.
    vain: u32,
    /// Chirps over at the last call of [`Pulse::opened`].
    told: usize,
}

impl Pulse {
    /// A gate that lets a chirp through.
    pub fn new(gate: Count, words: &Words) -> Self {
        DIVIDER.store(words.divider(), Ordering::Relaxed);
        CONVERTER_ON.store(words.start(), Ordering::Relaxed);
        count_rises();
        // As after a reset, an input with a pull-down.
        pads().gpio(13).reset();
        io().gpio(13).gpio_ctrl().write(|w| w.funcsel().pwm());
        Self { gate, armed: false, seen: 0, vain: 0, told: 0 }
    }

    /// Waits for a rise. The converter's queue and the channels of the slots must be ready.
    pub fn arm(&mut self) {
        let (rises, gate) = (pwm().ch(RISES), pwm().ch(GATE));
        self.vain = self.vain.saturating_add(standing());
        pwm().en().reset();
        // Undivided, to the highest count.
        rises.div().reset();
        rises.top().reset();
        rises.cc().reset();
        count_rises();
        put!(rises.ctr(), READY);
        put!(gate.div(), self.gate.divider);
        put!(gate.top(), self.gate.top);
        gate.cc().reset();
        gate.csr().reset();
        gate.ctr().reset();
        let on = pwm().en().as_ptr() as u32;
        let converter = adc().cs().as_ptr() as u32;
        let count = rises.ctr().as_ptr() as u32;
        let divider = adc().div().as_ptr() as u32;
        link::<{ LINKS[0] }>(LINKS[1], PWM_WRAP6, address(&DIVIDER), divider);
        link::<{ LINKS[1] }>(LINKS[2], PERMANENT, address(&CONVERTER_ON), converter);
        link::<{ LINKS[2] }>(LINKS[3], PERMANENT, address(&BOTH_SLICES), on);
        link::<{ LINKS[3] }>(LINKS[4], PWM_WRAP7, address(&CONVERTER_OFF), converter);
        link::<{ LINKS[4] }>(LINKS[5], PERMANENT, address(&ONE_SLICE), on);
        link::<{ LINKS[5] }>(LINKS[6], PERMANENT, count, MEANWHILE.address());
        link::<{ LINKS[6] }>(LINKS[0], PERMANENT, address(&WAITING), count);
        // Requests of an earlier chirp.
        dma().ch3_dbg_ctdreq().reset();
        dma().ch8_dbg_ctdreq().reset();
        (self.seen, self.armed) = (0, true);
        put!(dma().multi_chan_trigger(), 1 << LINKS[0]);
        pwm().en().write(|w| w.ch6().set_bit());
    }

    /// Stops, so that no rise starts the converter; rises are still counted. Returns whether a chirp was open.
    pub fn stop(&mut self, pulsed: &mut Pulsed) -> bool {
        let open = self.look(pulsed).is_some();
        self.armed = false;
        off::<{ LINKS[0] }>();
        off::<{ LINKS[1] }>();
        off::<{ LINKS[2] }>();
        off::<{ LINKS[3] }>();
        off::<{ LINKS[4] }>();
        off::<{ LINKS[5] }>();
        off::<{ LINKS[6] }>();
        put!(dma().chan_abort(), LINKS.iter().fold(0, |mask, link| mask | 1 << link));
        rest::<{ LINKS[0] }>();
        rest::<{ LINKS[1] }>();
        rest::<{ LINKS[2] }>();
        rest::<{ LINKS[3] }>();
        rest::<{ LINKS[4] }>();
        rest::<{ LINKS[5] }>();
        rest::<{ LINKS[6] }>();
        pwm().en().write(|w| w.ch6().set_bit());
        self.vain = self.vain.saturating_add(standing());
        open
    }

    /// Waits again if a rise came in the moment between slice 6 being ready and its channel. Some
    /// microseconds are enough to open the gate.
    pub fn watch(&mut self) {
        let deaf = || {
            let closed = pwm().ch(GATE).csr().read().en().bit_is_clear();
            busy(LINKS[0]) && closed && pwm().ch(RISES).ctr().read().bits() != READY
        };
        if self.armed && deaf() {
            cortex_m::asm::delay(1_000);
            if deaf() {
                self.vain = self.vain.saturating_add(standing()).saturating_add(1);
                put!(pwm().ch(RISES).ctr(), READY);
            }
        }
    }

    /// Whether a chirp was open since the last call: slice 6 counts on from its rise to its end.
    pub fn opened(&mut self) -> bool {
        let over = over();
        let closed = core::mem::replace(&mut self.told, over) != over;
        closed || pwm().ch(RISES).ctr().read().bits() & READY != READY
    }

    /// Reports the chirps that are over since the last call, and the pulses in vain. Returns the converter's cycles since a chirp was
    /// opened, if it is not over.
    pub fn look(&mut self, pulsed: &mut Pulsed) -> Option<u32> {
        pulsed.miss(core::mem::take(&mut self.vain));
        if !self.armed {
            return None;
        }
        let mut seen = (self.seen, None);
        // At a chirp's first and last moment the channels need some cycles to agree.
        let _ = wait(|| {
            let (before, open) = (over(), self.open());
            seen = (before, open);
            over() == before && (open.is_some() || busy(LINKS[0]))
        });
        let (over, open) = seen;
        for _ in 0..over.wrapping_sub(self.seen) % PLACES {
            pulsed.close(MEANWHILE.at(self.seen));
            self.seen = self.seen.wrapping_add(1);
        }
        open
    }

    /// The converter's cycles since the gate was opened, if it is open.
    fn open(&self) -> Option<u32> {
        let gate = pwm().ch(GATE);
        let count = gate.ctr().read().bits().wrapping_mul(self.gate.divider >> 4);
        let opened = gate.csr().read().en().bit_is_set();
        // The channel that ends the chirp still waits.
        (opened && busy(LINKS[3])).then_some(count / CORE_CYCLES)
    }
}

/// Chirps that are over, of the last 16.
fn over() -> usize {
    let next = dma().ch(LINKS[5]).ch_write_addr().read().bits();
    next.wrapping_sub(MEANWHILE.address()) as usize / size_of::<u32>() % PLACES
}

/// Rises since a chirp was opened, or since the last call; counting begins again.
fn standing() -> u32 {
    let rises = pwm().ch(RISES).ctr();
    let count = rises.read().bits() & READY;
    rises.reset();
    if count == READY { 0 } else { count }
}

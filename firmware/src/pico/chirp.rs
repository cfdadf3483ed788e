//! The chirp at GP14 and its sync pulse at GP12: two slices of the PWM, and a channel that plays the
//! levels round and round.

use super::converter::{off, rest};
use super::registers::{control, dma, put, pwm, single};
use super::waveform::{Count, PLACES, Waveform};
use super::words::{PLAYED, REWOUND};
use core::sync::atomic::{AtomicU32, Ordering};
use static_cell::ConstStaticCell;

/// The slices of the sync pulse and of the chirp.
const SYNC: usize = 6;
const RAMP: usize = 7;

/// The levels' address, which a channel reads at the end of each chirp.
static FIRST: AtomicU32 = AtomicU32::new(0);

/// Sets a slice, which then stands at its start.
fn set(slice: usize, count: Count, level: u32) {
    let slice = pwm().ch(slice);
    slice.csr().reset();
    put!(slice.div(), count.divider);
    put!(slice.top(), count.top);
    slice.ctr().reset();
    put!(slice.cc(), level);
}

/// Plays equal pulses in the chirp's place, again and again; at a level above the count the output is high.
pub fn pulses(count: Count, level: u32) {
    set(RAMP, count, level);
    pwm().ch(RAMP).csr().write(|w| w.en().set_bit());
}

/// A chirp that can be played.
pub struct Chirp {
    levels: &'static [u16],
    count: Count,
    sync: Option<(Count, u32)>,
}

impl Chirp {
    /// Computes the levels. `None` at the second call.
    pub fn new(wave: &Waveform) -> Option<Self> {
        static TABLE: ConstStaticCell<[u16; PLACES]> = ConstStaticCell::new([0; PLACES]);
        let levels = wave.fill(TABLE.try_take()?);
        FIRST.store(levels.as_ptr().expose_provenance() as u32, Ordering::Relaxed);
        Some(Self { levels, count: wave.count(), sync: wave.sync() })
    }

    /// Stops, with both outputs low: a slice that stands takes over a level at once.
    pub fn stop(&self) {
        pwm().en().reset();
        for slice in [SYNC, RAMP] {
            pwm().ch(slice).ctr().reset();
            pwm().ch(slice).cc().reset();
        }
        off::<PLAYED>();
        off::<REWOUND>();
        put!(dma().chan_abort(), 1 << PLAYED | 1 << REWOUND);
        rest::<PLAYED>();
        rest::<REWOUND>();
    }

    /// Returns to the start of a chirp, and stands there.
    pub fn rewind(&self) {
        let sync = self.sync.unwrap_or_default();
        let before = self.levels.len().saturating_sub(2);
        let first = self.levels.get(before).copied().unwrap_or(0);
        for (slice, (count, level)) in [(SYNC, sync), (RAMP, (self.count, first.into()))] {
            set(slice, count, level);
        }
        let (played, rewound) = (dma().ch(PLAYED), dma().ch(REWOUND));
        // Requests of an earlier chirp.
        dma().ch3_dbg_ctdreq().reset();
        put!(played.ch_write_addr(), pwm().ch(RAMP).cc().as_ptr() as u32);
        put!(played.ch_trans_count(), self.levels.len() as u32);
        // A half word for each period of slice 7. The end starts the channel that rewinds.
        played.ch_al1_ctrl().write(|w| {
            let w = control(w, REWOUND).high_priority().set_bit();
            w.incr_read().set_bit().data_size().size_halfword().treq_sel().pwm_wrap7()
        });
        put!(rewound.ch_read_addr(), FIRST.as_ptr().expose_provenance() as u32);
        put!(rewound.ch_write_addr(), played.ch_al3_read_addr_trig().as_ptr() as u32);
        put!(rewound.ch_trans_count(), 1);
        rewound.ch_al1_ctrl().write(|w| single(w, REWOUND));
        // The rewinding channel gives the playing one its address, and starts it.
        put!(dma().multi_chan_trigger(), 1 << REWOUND);
    }

    /// Starts both slices at once. Call it with interrupts masked: the second level must be there when the first sample ends.
    pub fn run(&self) {
        pwm().en().write(|w| w.ch7().set_bit().ch6().bit(self.sync.is_some()));
        let second = self.levels.last().copied().unwrap_or(0);
        put!(pwm().ch(RAMP).cc(), second.into());
    }
}

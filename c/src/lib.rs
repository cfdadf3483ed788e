//! Picket for C and C++: pipelines in the caller's memory, behind `include/picket.h`, which says what each call does.
//!
//! Nothing is allocated, nothing is global, and every misuse that a pointer or a number shows is answered by a status, with
//! nothing written. The archive that `cargo picket c` makes of this has no symbols but those of the header.
#![cfg_attr(panic = "abort", no_std)]

#[macro_use]
mod words;
mod door;
mod frames;
mod memory;
mod status;
mod types;

use crate::door::{Bursts, Follower, Meter, Sum};
use crate::frames::Framed;
use crate::memory::Slot;
use crate::status::Status;
use crate::types::{
    CAccumulated, CAccumulating, CBurst, CConfig, CCounts, CFollowing, CLine, CMeasurement, CScene,
    CStamp, CTarget, CTone, CTrack, CTrigger,
};
use core::mem::size_of;

/// No panic can be reached, or the archive would ask for a function that does not exist.
#[cfg(panic = "abort")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn picket_can_panic() -> !;
    }
    // SAFETY: it is never linked.
    unsafe { picket_can_panic() }
}

/// Parts of a sample.
const fn parts<R: picket_dsp::Record>() -> usize {
    if R::IQ { 2 } else { 1 }
}

/// The calls for records of a kind and a length, by the names that the header gives them.
macro_rules! door {
    ($module:ident, $kind:ident, $n:literal, $name:literal) => {
        mod $module {
            use super::*;

            type Memory = *mut Slot<Meter<picket_dsp::$kind, $n>>;
            type Adder = *mut Slot<Sum<picket_dsp::$kind, $n>>;
            type Tracker = *mut Slot<Follower<picket_dsp::$kind, $n>>;
            type Stream = *mut Slot<Bursts<picket_dsp::$kind, $n>>;

            /// Words of 16 bits in a record.
            const WORDS: usize = $n * parts::<picket_dsp::$kind>();

            // `picket.h` reserves so much.
            const _: () = assert!(
                size() <= 4 * WORDS + 1280
                    && tracker_size() <= 4 * WORDS + 9216
                    && accumulator_size() <= 8 * WORDS + 256
                    && bursts_size() <= 10 * WORDS + 2560
            );

            /// Bytes of a pipeline's memory.
            #[unsafe(export_name = concat!($name, "_size"))]
            const extern "C" fn size() -> usize {
                size_of::<Slot<Meter<picket_dsp::$kind, $n>>>()
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_init"))]
            unsafe extern "C" fn init(
                memory: Memory,
                config: *const CConfig,
                scene: *const CScene,
            ) -> i32 {
                // SAFETY: as the header asks of the caller, here and below.
                Status::from(unsafe { Meter::init(memory, config, scene) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_init_tone"))]
            unsafe extern "C" fn init_tone(
                memory: Memory,
                rate_hz: f64,
                low_code: i16,
                high_code: i16,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Meter::init_tone(memory, rate_hz, low_code, high_code) })
                    as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_block"))]
            unsafe extern "C" fn block(
                memory: Memory,
                samples: *const i16,
                count: usize,
                tone: *mut CTone,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Meter::block(memory, samples, count, tone) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_measure"))]
            unsafe extern "C" fn measure(
                memory: Memory,
                stamp: *const CStamp,
                samples: *const i16,
                count: usize,
                measurement: *mut CMeasurement,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Meter::measure(memory, stamp, samples, count, measurement) })
                    as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_lines"))]
            unsafe extern "C" fn lines(
                memory: Memory,
                lines: *mut CLine,
                room: usize,
                found: *mut usize,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Meter::lines(memory, lines, room, found) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_harmonics"))]
            unsafe extern "C" fn harmonics(
                memory: Memory,
                order: u32,
                fundamental: *mut CTone,
                orders: *mut u32,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Meter::harmonics(memory, order, fundamental, orders) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_frame_push"))]
            unsafe extern "C" fn frame_push(
                frame: *mut Slot<Framed>,
                memory: *const Slot<Meter<picket_dsp::$kind, $n>>,
                complete: *mut u8,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Meter::frame(memory, frame, complete) }) as i32
            }

            /// Bytes of a tracker's memory.
            #[unsafe(export_name = concat!($name, "_tracker_size"))]
            const extern "C" fn tracker_size() -> usize {
                size_of::<Slot<Follower<picket_dsp::$kind, $n>>>()
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_tracker_init"))]
            unsafe extern "C" fn tracker_init(
                memory: Tracker,
                config: *const CConfig,
                scene: *const CScene,
                following: *const CFollowing,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Follower::init(memory, config, scene, following) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_track"))]
            unsafe extern "C" fn track(
                memory: Tracker,
                stamp: *const CStamp,
                samples: *const i16,
                count: usize,
                measurement: *mut CMeasurement,
                tracks: *mut CTrack,
                room: usize,
                found: *mut usize,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe {
                    Follower::track(memory, stamp, samples, count, measurement, tracks, room, found)
                }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_targets"))]
            unsafe extern "C" fn targets(
                memory: Tracker,
                targets: *mut CTarget,
                room: usize,
                found: *mut usize,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Follower::targets(memory, targets, room, found) }) as i32
            }

            /// Bytes of an accumulator's memory.
            #[unsafe(export_name = concat!($name, "_accumulator_size"))]
            const extern "C" fn accumulator_size() -> usize {
                size_of::<Slot<Sum<picket_dsp::$kind, $n>>>()
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_accumulator_init"))]
            unsafe extern "C" fn accumulator_init(
                memory: Adder,
                terms: *const CAccumulating,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Sum::init(memory, terms) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_accumulate"))]
            unsafe extern "C" fn accumulate(
                memory: Adder,
                meter: *const Slot<Meter<picket_dsp::$kind, $n>>,
                accumulated: *mut CAccumulated,
                complete: *mut u8,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Sum::add(memory, meter, accumulated, complete) }) as i32
            }

            /// Bytes of a burst processor's memory.
            #[unsafe(export_name = concat!($name, "_bursts_size"))]
            const extern "C" fn bursts_size() -> usize {
                size_of::<Slot<Bursts<picket_dsp::$kind, $n>>>()
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_bursts_init"))]
            unsafe extern "C" fn bursts_init(
                memory: Stream,
                config: *const CConfig,
                trigger: *const CTrigger,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Bursts::init(memory, config, trigger) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_bursts_push"))]
            unsafe extern "C" fn bursts_push(
                memory: Stream,
                samples: *const i16,
                count: usize,
                bursts: *mut CBurst,
                room: usize,
                found: *mut usize,
            ) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Bursts::push(memory, samples, count, bursts, room, found) })
                    as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_bursts_lost"))]
            unsafe extern "C" fn bursts_lost(memory: Stream, samples: u64) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Bursts::lost(memory, samples) }) as i32
            }

            /// # Safety
            /// As the header says.
            #[unsafe(export_name = concat!($name, "_bursts_counts"))]
            unsafe extern "C" fn bursts_counts(memory: Stream, counts: *mut CCounts) -> i32 {
                // SAFETY: as above.
                Status::from(unsafe { Bursts::counts(memory, counts) }) as i32
            }
        }
    };
}

door!(real64, Real, 64, "picket_real64");
door!(real128, Real, 128, "picket_real128");
door!(real256, Real, 256, "picket_real256");
door!(real512, Real, 512, "picket_real512");
door!(real1024, Real, 1024, "picket_real1024");
door!(real2048, Real, 2048, "picket_real2048");
door!(real4096, Real, 4096, "picket_real4096");
door!(iq64, Iq, 64, "picket_iq64");
door!(iq128, Iq, 128, "picket_iq128");
door!(iq256, Iq, 256, "picket_iq256");
door!(iq512, Iq, 512, "picket_iq512");
door!(iq1024, Iq, 1024, "picket_iq1024");
door!(iq2048, Iq, 2048, "picket_iq2048");
door!(iq4096, Iq, 4096, "picket_iq4096");

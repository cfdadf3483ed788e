//! Transforms. [`integer`] is the default and defines the target's arithmetic. Cores with the DSP extension run this arithmetic in the
//! loops of `kernel_dsp`, cores with Helium in the loops of `kernel_mve`, Armv6-M in the loops of `kernel_thumb1`. `float`, with the
//! feature `microfft`, calls another crate.

#[cfg(any(dsp, short_products))]
pub(crate) mod assembly;
#[cfg(feature = "microfft")]
pub mod float;
pub mod integer;
#[cfg(dsp)]
pub mod kernel_dsp;
#[cfg(mve)]
pub mod kernel_mve;
#[cfg(short_products)]
pub mod kernel_thumb1;
pub mod twiddle;

#[cfg(not(any(dsp, short_products)))]
pub(super) use super::scan::real as scan;
#[cfg(not(any(dsp, short_products)))]
use integer as engine;
#[cfg(dsp)]
use kernel_dsp as engine;
#[cfg(short_products)]
use kernel_thumb1 as engine;

#[cfg(all(any(dsp, short_products), not(mve)))]
pub(super) use engine::scan;
#[cfg(not(mve))]
use engine::transform as kernel;
pub(super) use engine::{window, window_finely};
use integer::{Pair, Point};
#[cfg(mve)]
pub(super) use kernel_mve::scan;
#[cfg(mve)]
use kernel_mve::transform as kernel;

macro_rules! by_length {
    ($($length:literal $name:ident $portable:ident)*) => {
        $(
            // Not generic, so that it is compiled here and not in every program.
            #[inline(never)]
            pub(super) fn $name(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
                kernel::<$length>(pairs, bits, points)
            }

            pub(super) fn $portable(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
                integer::transform::<$length>(pairs, bits, points)
            }
        )*

        /// A transform of `length` points, by its kernels. A program that knows the length when it is compiled links no other.
        #[inline(always)]
        pub(super) fn transform(length: usize, pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
            match length {
                $($length => $name(pairs, bits, points),)*
                _ => 0,
            }
        }

        /// [`transform`] by its definition in portable code.
        #[inline(always)]
        pub(super) fn transform_portably(length: usize, pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
            match length {
                $($length => $portable(pairs, bits, points),)*
                _ => 0,
            }
        }
    };
}

by_length! {
    32 points_32 portable_32
    64 points_64 portable_64
    128 points_128 portable_128
    256 points_256 portable_256
    512 points_512 portable_512
    1024 points_1024 portable_1024
    2048 points_2048 portable_2048
    4096 points_4096 portable_4096
}

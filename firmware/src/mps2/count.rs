//! Counts instructions. They drive the emulated time, so a timer counts them, and the host knows the number of instructions in a tick.

use super::{Timer, Uart, figure};
use core::arch::asm;
use core::hint::black_box;
use core::sync::atomic::{Ordering, compiler_fence};

/// Reports the ticks of `work`, less the ticks of reading the timer. The timer must run free.
#[inline(always)]
pub fn count<T>(name: &str, work: impl FnOnce() -> T) -> T {
    let (ticks, result) = measured(work);
    figure(Uart::ONE, name, ticks.into());
    result
}

/// The ticks of `work`, less the ticks of reading the timer, and its result.
#[inline(always)]
pub fn measured<T>(work: impl FnOnce() -> T) -> (u32, T) {
    let empty = ticks(|| ()).0;
    let (ticks, result) = ticks(work);
    (ticks.wrapping_sub(empty), result)
}

#[inline(always)]
fn ticks<T>(work: impl FnOnce() -> T) -> (u32, T) {
    let start = Timer::ONE.elapsed();
    compiler_fence(Ordering::SeqCst);
    // SAFETY: a register is copied to itself. No compiler writes this instruction: a trace of the
    // program shows by it where work begins.
    unsafe { asm!("mov r8, r8") };
    let result = black_box(work());
    // SAFETY: another register is copied to itself, where work ends.
    unsafe { asm!("mov r9, r9") };
    compiler_fence(Ordering::SeqCst);
    (Timer::ONE.elapsed().wrapping_sub(start), result)
}

/// Marsaglia's xorshift, for random blocks that are not stored.
#[derive(Clone, Copy, Debug)]
pub struct Random(pub u32);

impl Random {
    /// The next 32 bits.
    pub fn draw(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
}

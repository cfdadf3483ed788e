//! The timers of the MPS2 boards.

use super::Register;

peripheral! {
    /// A timer that counts down at the system's clock.
    Timer, TimerBlock { control, value, reload, interrupt },
    ZERO = 0x5000_0000, 0, 0x4000_0000;
    ONE = 0x5000_1000, 0, 0x4000_1000;
}

/// The system's clock, Hz, which the timers count.
pub const CLOCK_HZ: u32 = if cfg!(an505) { 20_000_000 } else { 25_000_000 };

/// The interrupt of [`Timer::ZERO`].
pub const TIMER_IRQ: usize = if cfg!(an505) { 3 } else { 8 };

impl Timer {
    /// Interrupts every `ticks` from now on.
    pub fn start(self, ticks: u32) {
        let timer = self.registers();
        timer.control.write(0);
        timer.reload.write(ticks.saturating_sub(1));
        timer.value.write(ticks.saturating_sub(1));
        timer.interrupt.write(1);
        timer.control.write(0b1001);
    }

    /// Lets its interrupt through.
    pub fn enable(self) {
        super::enable(TIMER_IRQ);
    }

    /// Stops the timer.
    pub fn stop(self) {
        self.registers().control.write(0);
        self.clear();
    }

    /// Whether the timer runs.
    pub fn running(self) -> bool {
        self.registers().control.read() & 1 != 0
    }

    /// Clears the interrupt.
    pub fn clear(self) {
        self.registers().interrupt.write(1);
    }

    /// Counts down from the top, without interrupts.
    pub fn run_free(self) {
        let timer = self.registers();
        timer.control.write(0);
        timer.reload.write(u32::MAX);
        timer.value.write(u32::MAX);
        timer.control.write(1);
    }

    /// Ticks since [`Timer::run_free`], modulo 2^32.
    pub fn elapsed(self) -> u32 {
        u32::MAX.wrapping_sub(self.registers().value.read())
    }
}

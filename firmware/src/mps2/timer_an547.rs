//! The timer on AN547, whose own timers are of another kind: the core's timer, SysTick.

use super::Register;

peripheral! {
    /// The core's timer of 24 bits, which counts down at the core's clock of 32 MHz.
    Timer, TimerBlock { control, reload, value },
    ZERO = 0, 0xE000_E010, 0;
    ONE = 0, 0xE000_E010, 0;
}

/// The core's clock, Hz, which the timer counts.
pub const CLOCK_HZ: u32 = 32_000_000;

impl Timer {
    /// The largest count.
    const TOP: u32 = (1 << 24) - 1;

    /// Does nothing: the timer's interrupt is an exception, which is never masked.
    pub fn enable(self) {}

    /// Interrupts every `ticks` from now on, or every half a second if that is longer than the timer
    /// counts.
    pub fn start(self, ticks: u32) {
        let timer = self.registers();
        timer.reload.write(ticks.saturating_sub(1).min(Self::TOP));
        timer.value.write(0);
        timer.control.write(0b111);
    }

    /// Stops the timer.
    pub fn stop(self) {
        self.registers().control.write(0);
    }

    /// Whether the timer runs.
    pub fn running(self) -> bool {
        self.registers().control.read() & 1 != 0
    }

    /// Does nothing: the exception has no flag to clear.
    pub fn clear(self) {}

    /// Counts down from the top, without interrupts.
    pub fn run_free(self) {
        let timer = self.registers();
        timer.reload.write(Self::TOP);
        timer.value.write(0);
        timer.control.write(0b101);
    }

    /// 256ths of a tick since [`Timer::run_free`], modulo 2^32.
    pub fn elapsed(self) -> u32 {
        Self::TOP.wrapping_sub(self.registers().value.read()) << 8
    }
}

//! What counts on AN547, whose timers are of another kind: the core's own timer, SysTick.

use super::Register;

peripheral! {
    /// The core's timer of 24 bits, which counts down at the core's clock of 32 MHz.
    Timer, TimerBlock { control, reload, value },
    ONE = 0, 0xE000_E010, 0;
}

impl Timer {
    /// The largest number.
    const TOP: u32 = (1 << 24) - 1;

    /// Counts down from the top, without interrupts.
    pub fn run_free(self) {
        let timer = self.registers();
        timer.reload.write(Self::TOP);
        timer.value.write(0);
        timer.control.write(0b101);
    }

    /// Interrupts every `ticks` until it is stopped.
    pub fn interrupt_after(self, ticks: u32) {
        let timer = self.registers();
        timer.reload.write(ticks & Self::TOP);
        timer.value.write(0);
        timer.control.write(0b111);
    }

    /// Stops the timer.
    pub fn stop(self) {
        self.registers().control.write(0);
    }

    /// 256ths of a tick since [`Timer::run_free`], modulo 2^32.
    pub fn elapsed(self) -> u32 {
        Self::TOP.wrapping_sub(self.registers().value.read()) << 8
    }
}

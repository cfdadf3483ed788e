//! From reset to running clocks, timer and watchdog.

use super::registers::{enable, psm, put, resets, timer, watchdog};
use super::words::{CORE_MHZ, CRYSTAL_HZ, RESET_ALL, WATCHDOG_LOAD, causes as causes_of};
use picket_wire::boot::Causes;
use rp2040_hal::clocks::ClocksManager;
use rp2040_hal::fugit::{HertzU32, RateExtU32};
use rp2040_hal::pac;
use rp2040_hal::pac::vreg_and_chip_reset::vreg::VSEL_A;
use rp2040_hal::pll::common_configs::PLL_USB_48MHZ;
use rp2040_hal::pll::{Locked, PLLConfig, PhaseLockedLoop, PhaseLockedLoopDevice};
use rp2040_hal::vreg::set_voltage;
use rp2040_hal::xosc::{CrystalOscillator, Stable};

/// Resets the whole chip if only the core was reset, as a debugger or the core itself does: channels, converter and USB would run on. Call
/// this function first: afterwards the last program's memory is still there.
pub fn whole() {
    // Only this program takes the DMA controller out of its reset.
    if resets().reset_done().read().dma().bit_is_set() {
        put!(psm().wdsel(), RESET_ALL);
        watchdog().ctrl().write(|w| w.trigger().set_bit());
        // The reset comes within cycles.
        cortex_m::asm::delay(10_000);
    }
}

/// The causes of the chip's reset.
pub fn causes() -> Causes {
    // SAFETY: the chip has this register, and reading changes nothing (DS 2.12.7, CHIP_RESET).
    let chip = unsafe { (0x4006_4008 as *const u32).read_volatile() };
    causes_of(watchdog().reason().read().bits(), chip)
}

/// The core's clock.
const SYSTEM: PLLConfig = PLLConfig {
    vco_freq: HertzU32::MHz(10 * CORE_MHZ as u32),
    refdiv: 1,
    post_div1: 5,
    post_div2: 2,
};

/// Tries many times; `None` if it gave up. The crystal takes some milliseconds of a core at 6 MHz.
fn patiently<T, E>(mut ask: impl FnMut() -> Result<T, E>) -> Option<T> {
    (0..200_000).find_map(|_| ask().ok())
}

/// The crystal, running.
fn crystal(device: pac::XOSC) -> Option<CrystalOscillator<Stable>> {
    // The board's crystal is a slow one: 64 ms, as its own software development kit waits.
    let started = CrystalOscillator::new(device).initialize(CRYSTAL_HZ.Hz(), 64).ok()?;
    let token = patiently(|| started.await_stabilization())?;
    Some(started.get_stable(token))
}

/// A multiplier, running.
fn multiplied<D: PhaseLockedLoopDevice>(
    device: D,
    config: PLLConfig,
    resets: &mut pac::RESETS,
) -> Option<PhaseLockedLoop<Locked, D>> {
    let started = PhaseLockedLoop::new(device, CRYSTAL_HZ.Hz(), config).ok()?.initialize(resets);
    let token = patiently(|| started.await_lock())?;
    Some(started.get_locked(token))
}

/// The core's voltage for its clock: 1.15 V. The data sheet's 1.10 V are for at most 133 MHz.
pub fn voltage(regulator: &mut pac::VREG_AND_CHIP_RESET) {
    set_voltage(regulator, VSEL_A::VOLTAGE1_15);
    // ROK 12: the output is in regulation; it takes less than a millisecond.
    let _ = patiently(|| regulator.vreg().read().rok().bit().then_some(()).ok_or(()));
}

/// Starts watchdog and clocks. `None` if the crystal or a multiplier does not come: there is no
/// sample clock without them, and the watchdog starts the chip again.
pub fn clocks(
    sources: (pac::XOSC, pac::PLL_SYS, pac::PLL_USB),
    tree: pac::CLOCKS,
    resets: &mut pac::RESETS,
) -> Option<ClocksManager> {
    watch();
    let xosc = crystal(sources.0)?;
    let mut clocks = ClocksManager::new(tree);
    // The clocks leave the multipliers before these change, as they have left them after a reset.
    let system = multiplied(sources.1, SYSTEM, resets)?;
    let usb = multiplied(sources.2, PLL_USB_48MHZ, resets)?;
    clocks.init_default(&xosc, &system, &usb).ok()?;
    Some(clocks)
}

/// Starts the watchdog; it counts microseconds of the reference clock, twice each (RP2040-E1).
fn watch() {
    // A tick in 12 cycles of the crystal, or of the slower oscillator before it.
    // SAFETY: the field takes this number of cycles.
    watchdog()
        .tick()
        .write(|w| unsafe { w.enable().set_bit().cycles().bits((CRYSTAL_HZ / 1_000_000) as u16) });
    put!(psm().wdsel(), RESET_ALL);
    feed();
    // As after a reset, it pauses while a debugger holds the core.
    watchdog().ctrl().write(|w| w.enable().set_bit());
}

/// Feeds the watchdog.
pub fn feed() {
    put!(watchdog().load(), WATCHDOG_LOAD);
}

/// Microseconds between two wakes of a core that nothing else wakes.
const WAKE: u32 = 100_000;

/// Starts the timer's alarm, which wakes the core. The timer itself counts since the clocks run.
pub fn alarm() {
    wake();
    timer().inte().write(|w| w.alarm_0().set_bit());
    enable(pac::Interrupt::TIMER_IRQ_0);
}

/// Handles the alarm's interrupt, which only wakes the core: sets the next alarm.
pub extern "C" fn wake() {
    timer().intr().write(|w| w.alarm_0().clear_bit_by_one());
    put!(timer().alarm0(), ticks().wrapping_add(WAKE));
}

/// Microseconds since the start, modulo 2^32.
pub fn ticks() -> u32 {
    timer().timerawl().read().bits()
}

/// Waits until `ready`, for at most this many milliseconds; false if it gave up.
#[must_use]
pub fn within(milliseconds: u32, mut ready: impl FnMut() -> bool) -> bool {
    let begun = ticks();
    while ticks().wrapping_sub(begun) < 1_000 * milliseconds {
        if ready() {
            return true;
        }
    }
    ready()
}

//! The instrument on QEMU's lm3s6965evb: a timer, a serial port, and a computed tone in place of a converter.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::{Peripherals, syst::SystClkSource};
use cortex_m_rt::{entry, exception};
use heapless::Deque;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Blocks, Counters};
use picket_dsp::{Iq, Pipeline, Real};
use picket_firmware::instrument::{Instrument, plan::Plan, storage::NoStorage};
use picket_firmware::{
    board::{Board, Clocks, Port},
    sampler::Sampler,
    slot::Slot,
};
use picket_wire::{boot::Clock, settings::Settings, settings_error::SettingsError};

/// Samples in a block.
const N: usize = 256;
const CORE_HZ: u32 = 12_500_000;
static SAMPLER: Sampler<N> = Sampler::new();
static TICKS: AtomicU32 = AtomicU32::new(0);

/// The sample clock: it counts, and takes a sample.
#[exception]
fn SysTick() {
    // A pointer that each sample turns by twice the arc sine of a quarter, `y` by half of that ahead.
    static mut POINTER: [i32; 2] = [1000 << 16, 0];
    let [x, y] = POINTER;
    *x -= *y >> 1;
    *y += *x >> 1;
    TICKS.fetch_add(1, Relaxed);
    SAMPLER.push([*x, (*y - (*x >> 2)) / 31 * 32].map(|part| (2048 + (part >> 16)) as u16));
}

/// The sample clock's period nearest to the wanted one, in cycles of the core: 100 to 5000 samples a second.
fn period(settings: &Settings) -> u32 {
    let wanted = f64::from(CORE_HZ) / settings.config.rate_hz;
    ((wanted + 0.5) as u32).clamp(CORE_HZ / 5000, CORE_HZ / 100)
}

struct Skeleton {
    rate_hz: u32,
    /// What waits for the line.
    out: Deque<u8, 2048>,
}

/// UART0, a PL011: data at 0, flags at 0x18 with BUSY 3, RXFE 4 and TXFF 5, LCRH at 0x2C, CTL at 0x30.
const UART: *mut u32 = 0x4000_C000 as *mut u32;

fn uart_is(flag: u32) -> bool {
    // SAFETY: the register is there, and reading it changes nothing.
    unsafe { UART.byte_add(0x18).read_volatile() & 1 << flag != 0 }
}

impl Skeleton {
    /// Gives the line what it takes; true if all is gone.
    fn pump(&mut self) -> bool {
        while !uart_is(5)
            && let Some(byte) = self.out.pop_front()
        {
            // SAFETY: the register is there, and sends what is written to it.
            unsafe { UART.write_volatile(byte.into()) };
        }
        self.out.is_empty()
    }
}

impl Port<N, N> for Skeleton {
    const NAME: &'static str = "skeleton";
    const CODES: Codes = Codes::unsigned::<12>();
    type Words = ();
    type Storage = NoStorage;
    type Slots = Blocks<'static, Slot<N>>;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, ()), SettingsError> {
        Ok((Plan::undriven(settings, f64::from(CORE_HZ) / f64::from(period(settings)))?, ()))
    }

    fn counters(&self) -> Counters {
        SAMPLER.counters()
    }

    fn ticks(&self) -> u32 {
        TICKS.load(Relaxed)
    }

    fn has_room(&self, bytes: usize) -> bool {
        self.out.capacity() - self.out.len() >= bytes
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        self.has_room(frame.len()) && frame.iter().all(|&byte| self.out.push_back(byte).is_ok())
    }
}

impl Board<N, N> for Skeleton {
    fn start(settings: &Settings) -> Option<Self> {
        let (mut timer, period) = (Peripherals::take()?.SYST, period(settings));
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(period - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        // SAFETY: the registers are there: 8 bits with queues of 16 bytes; on, both ways.
        unsafe {
            UART.byte_add(0x2C).write_volatile(0x70);
            UART.byte_add(0x30).write_volatile(0x301);
        }
        Some(Self { rate_hz: CORE_HZ / period, out: Deque::new() })
    }

    fn clocks(&self) -> Clocks {
        Clocks { source: Clock::External, core_hz: CORE_HZ, ticks_hz: self.rate_hz }
    }

    fn sample(&mut self, plan: &Plan<N>, (): &()) -> Option<Blocks<'static, Slot<N>>> {
        SAMPLER.start(plan.settings.iq, plan.timing)
    }

    fn receive(&mut self) -> Option<u8> {
        // SAFETY: the register is there, and a byte waits in it.
        (!uart_is(4)).then(|| unsafe { UART.read_volatile() } as u8)
    }

    fn flush(&mut self) {
        let _ = (0..CORE_HZ).any(|_| self.pump() && !uart_is(3));
    }

    fn sleep(&mut self, blocks: Option<&Blocks<'static, Slot<N>>>) {
        // A block that ends just now is seen at the next sample.
        if self.pump() && uart_is(4) && !blocks.is_some_and(Blocks::waiting) {
            cortex_m::asm::wfi();
        }
    }
}

picket_firmware::no_interrupts!(44);

#[entry]
fn main() -> ! {
    let meters = picket_firmware::meters!(Pipeline<Real, N>, Pipeline<Iq, N>);
    if let Some(instrument) = Instrument::<Skeleton, N, N, _, _>::start(meters) {
        instrument.run()
    }
    loop {}
}

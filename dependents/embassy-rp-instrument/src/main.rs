//! The whole instrument on a Pico by Embassy: telemetry, commands and settings over the serial port on GPIO 0 and 1, and settings in
//! flash. GPIO 26 is sampled at 20 kHz.
#![no_std]
#![no_main]

use core::cell::Cell;
use cortex_m::singleton;
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_futures::select::{Either3, select3};
use embassy_rp::adc::{Adc, Config, InterruptHandler};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::pac::{self, dma::vals::TreqSel};
use embassy_rp::peripherals::{DMA_CH0, FLASH, UART0};
use embassy_rp::uart::{self, BufferedInterruptHandler, BufferedUart, BufferedUartTx};
use embassy_rp::watchdog::Watchdog;
use embassy_rp::{adc, bind_interrupts, clocks, dma, gpio};
use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embassy_sync::channel::Channel;
use embassy_sync::pipe::Pipe;
use embassy_time::{Duration, Instant, TICK_HZ, Timer};
use embedded_io_async::{Read, Write};
use panic_halt as _;
use picket_dsp::acquire::frontend::{Block, Counters, Timing};
use picket_dsp::{Codes, Pipeline, Real};
use picket_instrument::{
    Clocks, End, Instrument, Port, Slots, Start, crashes::Crashes, nor::Pages,
};
use picket_instrument::{meter::Meters, plan::Plan, slot::Slot, words::words};
use picket_wire::boot::Clock;
use picket_wire::{settings::Settings, settings_error::SettingsError};

bind_interrupts!(struct Irqs {
    ADC_IRQ_FIFO => InterruptHandler;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
    UART0_IRQ => BufferedInterruptHandler<UART0>;
});

/// Samples in a block.
const N: usize = 1024;
/// The converter's clock is 48 MHz after the HAL's start; a sample comes every 2399 + 1 of its cycles.
const DIVIDER: u16 = 2399;
const RATE_HZ: f64 = 48e6 / 2400.0;

/// What waits for the line, and the task that sends it.
static LINE: Pipe<CriticalSectionRawMutex, 2048> = Pipe::new();

#[embassy_executor::task]
async fn send(mut line: BufferedUartTx) {
    let mut bytes = [0; 64];
    loop {
        let length = LINE.read(&mut bytes).await;
        let _ = line.write_all(&bytes[..length]).await;
    }
}

/// Tasks that interrupt a measurement.
static URGENT: InterruptExecutor = InterruptExecutor::new();

#[cortex_m_rt::interrupt]
fn SWI_IRQ_1() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { URGENT.on_interrupt() }
}

/// Blocks for the instrument, memory for the next ones, and the task that fills it.
static FULL: Channel<CriticalSectionRawMutex, Block<Slot<N>>, 2> = Channel::new();
static EMPTY: Channel<CriticalSectionRawMutex, Slot<N>, 2> = Channel::new();
static COUNTERS: Mutex<CriticalSectionRawMutex, Cell<Option<Counters>>> =
    Mutex::new(Cell::new(None));

/// The HAL's own reading stops the converter behind each chunk. Here it runs on: four samples wait, 200 us, until the next transfer
/// takes them.
#[embassy_executor::task]
async fn sample(mut dma: dma::Channel<'static>, mut slot: Slot<N>) {
    let adc = pac::ADC;
    let (mut counters, mut gap) = (Counters::default(), false);
    adc.fcs().write(|w| {
        w.set_en(true);
        w.set_dreq_en(true);
        w.set_thresh(1);
    });
    adc.div().write(|w| w.set_int(DIVIDER));
    adc.cs().modify(|w| w.set_start_many(true));
    loop {
        let words = slot.samples_mut::<Real, N>(0).as_mut_slice() as *mut [i16] as *mut [u16];
        // SAFETY: nobody else has the slot until the transfer has ended, and the converter's register may be read at any time.
        unsafe { dma.read(adc.fifo().as_ptr().cast(), words, TreqSel::ADC, false) }.await;
        let whole = !adc.fcs().read().over();
        adc.fcs().modify(|w| w.set_over(true));
        let stamp = Timing::continuous(N as u32).stamp(counters.filled().into(), gap);
        if !whole {
            // Samples found no room. Nobody knows how many are missing: one block at least.
            counters.broken += 1;
        } else if let Ok(next) = EMPTY.try_receive() {
            counters.blocks += 1;
            let slot = core::mem::replace(&mut slot, next);
            let _ = FULL.try_send(Block { stamp, counters, slot });
        } else {
            counters.overruns += 1;
        }
        let last = COUNTERS.lock(|last| last.replace(Some(counters))).unwrap_or_default();
        gap = counters.lost() != last.lost();
    }
}

type Store = Pages<Flash<'static, FLASH, Blocking, { 2 << 20 }>>;

struct Pico {
    watchdog: Watchdog,
}

/// The memory of a block goes to the task that fills it.
struct Empty;

impl Slots<N> for Empty {
    fn release(&mut self, slot: Slot<N>) {
        let _ = EMPTY.try_send(slot);
    }
}

impl Port<N, N> for Pico {
    const NAME: &'static str = "pico-embassy";
    const CODES: Codes = Codes::unsigned::<12>();
    type Words = ();
    type Storage = Store;
    type Slots = Empty;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, ()), SettingsError> {
        if settings.iq {
            return Err(SettingsError::Iq);
        }
        Ok((Plan::undriven(settings, RATE_HZ)?, ()))
    }

    fn counters(&self) -> Counters {
        COUNTERS.lock(Cell::get).unwrap_or_default()
    }

    fn ticks(&self) -> u32 {
        Instant::now().as_ticks() as u32
    }

    fn has_room(&self, bytes: usize) -> bool {
        LINE.free_capacity() >= bytes
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        self.has_room(frame.len()) && LINE.try_write(frame).is_ok()
    }

    fn feed(&mut self) {
        self.watchdog.feed(BITE);
    }
}

/// The watchdog bites so long after it was fed.
const BITE: Duration = Duration::from_secs(4);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let mut serial = uart::Config::default();
    serial.baudrate = 921_600;
    let Some([first, others @ ..]) = singleton!(: [[u32; N]; 3] = [[0; N]; 3]) else { return };
    let Some([tx, rx]) = singleton!(: [[u8; 256]; 2] = [[0; 256]; 2]) else { return };
    let line = BufferedUart::new(p.UART0, p.PIN_0, p.PIN_1, Irqs, tx, rx, serial);
    let (line, mut host) = line.split();
    let Ok(task) = send(line) else { return };
    spawner.spawn(task);
    // They live as long as the converter runs.
    let _adc = Adc::new(p.ADC, Irqs, Config::default());
    let _pin = adc::Channel::new_pin(p.PIN_26, gpio::Pull::None);
    others.iter_mut().for_each(|words| drop(EMPTY.try_send(Slot::new(words))));
    interrupt::SWI_IRQ_1.set_priority(Priority::P2);
    let urgent = URGENT.start(interrupt::SWI_IRQ_1);
    let Ok(task) = sample(dma::Channel::new(p.DMA_CH0, Irqs), Slot::new(first)) else { return };
    urgent.spawn(task);
    let mut port = Pico { watchdog: Watchdog::new(p.WATCHDOG) };
    port.watchdog.start(BITE);
    let mut storage = Pages::new(Flash::new_blocking(p.FLASH), [0x1F_E000, 0x1F_F000]);
    let ticks_hz = TICK_HZ as u32;
    let clocks = Clocks { source: Clock::External, core_hz: clocks::clk_sys_freq(), ticks_hz };
    // One converter: no pairs.
    let mut meters = Meters::<Pipeline<Real, N>, ()>::IDLE;
    let (mut left, mut saves, mut bytes) = (None, 0, [0; 64]);
    loop {
        // An instrument, from its start to the order that ends it.
        let start = Start::new::<N>(left, &storage, Crashes::default());
        let start = Start { saves, clocks, ..start };
        let made = Instrument::new(&port, start, storage, &mut meters);
        let Some((mut instrument, ())) = made else { return };
        let measures = instrument.plan().settings.start;
        instrument.begin(&mut port, measures.then_some(Empty));
        let end = loop {
            let tick = Timer::after_millis(100);
            match select3(host.read(&mut bytes), FULL.receive(), tick).await {
                Either3::First(Ok(length)) => {
                    if let Some(end) = instrument.on_bytes(&mut port, &bytes[..length]) {
                        break end;
                    }
                }
                Either3::Second(block) if measures => instrument.on_block(&mut port, block),
                Either3::Second(block) => Empty.release(block.slot),
                _ => {}
            }
            instrument.poll(&mut port);
        };
        saves = instrument.saves();
        storage = instrument.into_storage();
        left = match end {
            End::Restart(settings) => Some(words(&settings, N)),
            End::Reboot => None,
        };
    }
}

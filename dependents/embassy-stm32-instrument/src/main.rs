//! The whole instrument on a NUCLEO-F446RE by Embassy: telemetry, commands and settings over the probe's serial port, and settings in
//! flash. PA0 is sampled at 16 kHz.
#![no_std]
#![no_main]

use core::cell::Cell;
use cortex_m::singleton;
use embassy_executor::Spawner;
use embassy_futures::select::{Either3, select3};
use embassy_stm32::adc::{Adc, AdcChannel, CONTINUOUS, Exten, RingBufferedAdc, SampleTime};
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::usart::{BufferedInterruptHandler, BufferedUart, BufferedUartTx, Config};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, dma, peripherals};
use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embassy_sync::channel::Channel;
use embassy_sync::pipe::Pipe;
use embassy_time::{Instant, TICK_HZ, Timer};
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
    DMA2_STREAM0 => dma::InterruptHandler<peripherals::DMA2_CH0>;
    USART2 => BufferedInterruptHandler<peripherals::USART2>;
});

/// Samples in a block.
const N: usize = 1024;
/// The converter's clock is 8 MHz after the HAL's start; a conversion takes 480 + 12 of its cycles.
const RATE_HZ: f64 = 8e6 / 492.0;

/// What waits for the line, and the task that sends it.
static LINE: Pipe<CriticalSectionRawMutex, 2048> = Pipe::new();

#[embassy_executor::task]
async fn send(mut line: BufferedUartTx<'static>) {
    let mut bytes = [0; 64];
    loop {
        let length = LINE.read(&mut bytes).await;
        let _ = line.write_all(&bytes[..length]).await;
    }
}

/// Blocks for the instrument, memory for the next ones, and the task that fills it.
static FULL: Channel<CriticalSectionRawMutex, Block<Slot<N>>, 2> = Channel::new();
static EMPTY: Channel<CriticalSectionRawMutex, Slot<N>, 2> = Channel::new();
static COUNTERS: Mutex<CriticalSectionRawMutex, Cell<Option<Counters>>> =
    Mutex::new(Cell::new(None));

#[embassy_executor::task]
async fn sample(mut adc: RingBufferedAdc<'static, peripherals::ADC1>) {
    let (mut words, mut counters, mut gap) = ([0u16; N], Counters::default(), false);
    loop {
        let whole = adc.read(&mut words).await.is_ok();
        let stamp = Timing::continuous(N as u32).stamp(counters.filled().into(), gap);
        if !whole {
            // The converter overran the ring. Nobody knows how many samples are missing: one block at least.
            counters.broken += 1;
        } else if let Ok(mut slot) = EMPTY.try_receive() {
            counters.blocks += 1;
            let samples = slot.samples_mut::<Real, N>(0);
            samples.iter_mut().zip(words).for_each(|(sample, word)| *sample = word as i16);
            let _ = FULL.try_send(Block { stamp, counters, slot });
        } else {
            counters.overruns += 1;
        }
        let last = COUNTERS.lock(|last| last.replace(Some(counters))).unwrap_or_default();
        gap = counters.lost() != last.lost();
    }
}

struct Nucleo {
    watchdog: IndependentWatchdog<'static, peripherals::IWDG>,
}

/// The memory of a block goes to the task that fills it.
struct Empty;

impl Slots<N> for Empty {
    fn release(&mut self, slot: Slot<N>) {
        let _ = EMPTY.try_send(slot);
    }
}

impl Port<N, N> for Nucleo {
    const NAME: &'static str = "nucleo-embassy";
    const CODES: Codes = Codes::unsigned::<12>();
    type Words = ();
    type Storage = Pages<Flash<'static, Blocking>>;
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
        self.watchdog.pet();
    }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_stm32::init(Default::default());
    let mut serial = Config::default();
    serial.baudrate = 921_600;
    let Some(memory) = singleton!(: [[u32; N]; 2] = [[0; N]; 2]) else { return };
    let Some([tx, rx]) = singleton!(: [[u8; 256]; 2] = [[0; 256]; 2]) else { return };
    let Some(adc_data) = singleton!(: [u16; 2 * N] = [0; 2 * N]) else { return };
    let Ok(line) = BufferedUart::new(p.USART2, p.PA3, p.PA2, tx, rx, Irqs, serial) else { return };
    let (line, mut host) = line.split();
    let Ok(task) = send(line) else { return };
    spawner.spawn(task);
    let adc = Adc::new(p.ADC1).into_ring_buffered(
        p.DMA2_CH0,
        adc_data,
        Irqs,
        [(p.PA0.degrade_adc(), SampleTime::CYCLES480)].into_iter(),
        CONTINUOUS,
        Exten::DISABLED,
    );
    let Ok(task) = sample(adc) else { return };
    spawner.spawn(task);
    memory.iter_mut().for_each(|words| drop(EMPTY.try_send(Slot::new(words))));
    let mut port = Nucleo { watchdog: IndependentWatchdog::new(p.IWDG, 4_000_000) };
    port.watchdog.unleash();
    let mut storage = Pages::new(Flash::new_blocking(p.FLASH), [0x4_0000, 0x6_0000]);
    let ticks_hz = TICK_HZ as u32;
    let clocks = Clocks { source: Clock::Internal, core_hz: 16_000_000, ticks_hz };
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

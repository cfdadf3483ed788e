//! What stands around the chip: signals at its inputs, its outputs' edges, and what it must not do.

use rsemu::core::device::{Device, DeviceClass, RealizeCtx, ResetKind, SinkPin};
use rsemu::core::props::Props;
use rsemu::core::sched::{AccessKind, LazyHandle};
use rsemu::core::wire::{Level, WireId, WireSink, WireSource};
use rsemu::core::{Registry, Result};
use rsemu::machine::validate::{ClassSchema, PortDir};
use rsemu::machine::{Bindings, Instance};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What is at a converter's input.
#[derive(Clone, Debug)]
pub enum Input {
    /// These codes, one a conversion, again and again from the converter's start on.
    Table(Vec<u16>),
    /// The DAC's output, by a wire.
    Dac,
    /// Ticks of the second bus since the last rise at D3, divided by this.
    SincePulse(u64),
}

/// Everything that is around the chip.
#[derive(Debug, Default)]
pub struct Bench {
    /// The inputs of channels 0 and 1.
    pub inputs: [Option<Input>; 2],
    /// The DAC's output, codes.
    pub dac: u16,
    /// The last rise at D3, in ticks of the second bus.
    pub pulse: u64,
    /// Edges at D6: ticks of the second bus, and whether it rose.
    pub edges: Vec<(u64, bool)>,
    /// What the DAC put out: ticks of the first bus, and the code.
    pub codes: Vec<(u64, u16)>,
    /// Whether the DAC's codes are kept.
    pub keep: bool,
    /// Rules of the manual that the program broke, and how often.
    pub broken: BTreeMap<&'static str, u32>,
}

static BENCH: Mutex<Option<Bench>> = Mutex::new(None);
/// The watchdog's oscillator is at a timer's input, divided by this; 0 for not at all, since its edges cost time.
pub static OSCILLATOR: AtomicU64 = AtomicU64::new(0);
/// The watchdog bit.
pub static BITTEN: AtomicBool = AtomicBool::new(false);

/// Works with the bench.
pub fn bench<T>(work: impl FnOnce(&mut Bench) -> T) -> T {
    work(lock(&BENCH).get_or_insert_default())
}

/// Notes that the program broke a rule.
pub fn broken(rule: &'static str) {
    bench(|bench| *bench.broken.entry(rule).or_default() += 1);
}

pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A device's place in time, as the scheduler wants it: without locks.
#[derive(Debug, Default)]
pub struct Time {
    handle: Mutex<Option<LazyHandle>>,
    pub tick: AtomicU64,
    pub next: AtomicU64,
}

impl Time {
    pub fn new() -> Self {
        Self { next: AtomicU64::new(u64::MAX), ..Self::default() }
    }

    /// Brings the device to the present.
    pub fn sync(&self) {
        let handle = lock(&self.handle).clone();
        if let Some(handle) = handle {
            let _ = handle.sync(AccessKind::Guest);
        }
    }

    pub fn attach(&self, handle: LazyHandle) {
        *lock(&self.handle) = Some(handle);
    }

    pub fn now(&self) -> u64 {
        self.tick.load(SeqCst)
    }

    pub fn next(&self) -> Option<u64> {
        Some(self.next.load(SeqCst)).filter(|next| *next != u64::MAX)
    }
}

/// The pins D3 and D6, and the watchdog's line.
#[derive(Debug)]
struct Wires {
    shared: Arc<Shared>,
    pins: Mutex<Vec<Arc<Pin>>>,
}

#[derive(Debug)]
struct Shared {
    time: Time,
    soft: Mutex<Option<WireSource>>,
    nmi: Mutex<Option<WireSource>>,
}

#[derive(Debug)]
struct Pin {
    shared: Arc<Shared>,
    line: u32,
}

const NAMES: [&str; 3] = ["d3", "d6", "reset"];
static SOFT: Mutex<Option<Arc<Shared>>> = Mutex::new(None);

/// Tells the clock controller of a reset by software.
pub fn soft_reset() {
    let shared = lock(&SOFT).clone();
    let source = shared.and_then(|shared| lock(&shared.soft).clone());
    if let Some(source) = source {
        source.set(Level::High);
        source.set(Level::Low);
    }
}

/// The clock security system's line to the core.
pub fn nmi(level: Level) {
    let shared = lock(&SOFT).clone();
    if let Some(source) = shared.and_then(|shared| lock(&shared.nmi).clone()) {
        source.set(level);
    }
}

impl WireSink for Pin {
    fn set_level(&self, _: WireId, _: u32, level: Level) {
        self.shared.time.sync();
        let (now, high) = (self.shared.time.now(), level == Level::High);
        match self.line {
            0 if high => bench(|bench| bench.pulse = now),
            0 => {}
            1 => bench(|bench| {
                if bench.edges.last().is_none_or(|(_, last)| *last != high) {
                    bench.edges.push((now, high));
                }
            }),
            _ if high => BITTEN.store(true, SeqCst),
            _ => {}
        }
    }
}

impl Device for Wires {
    fn class(&self) -> &'static DeviceClass {
        &CLASS
    }

    fn realize(&self, _: &mut RealizeCtx<'_>) -> Result<()> {
        *lock(&SOFT) = Some(self.shared.clone());
        Ok(())
    }

    fn reset(&self, _: ResetKind) {}

    fn sink(&self, port: &str, _: &[WireId]) -> Option<SinkPin> {
        let line = NAMES.iter().position(|name| *name == port)? as u32;
        let pin = Arc::new(Pin { shared: self.shared.clone(), line });
        lock(&self.pins).push(pin.clone());
        Some(SinkPin { sink: pin, line })
    }

    fn connect(&self, port: &str, source: WireSource) -> Result<()> {
        let place = if port == "nmi" { &self.shared.nmi } else { &self.shared.soft };
        *lock(place) = Some(source);
        Ok(())
    }

    fn is_lazy(&self) -> bool {
        true
    }

    fn current_tick(&self) -> u64 {
        self.shared.time.now()
    }

    fn advance_to(&self, tick: u64) {
        self.shared.time.tick.fetch_max(tick, SeqCst);
    }

    fn next_event_tick(&self) -> Option<u64> {
        None
    }

    fn attach_lazy(&self, handle: LazyHandle) {
        self.shared.time.attach(handle);
    }
}

impl Instance for Wires {}

fn wires(_: &Props) -> Wires {
    let shared =
        Arc::new(Shared { time: Time::new(), soft: Mutex::new(None), nmi: Mutex::new(None) });
    Wires { shared, pins: Mutex::new(Vec::new()) }
}

static CLASS: DeviceClass = DeviceClass {
    name: "bench.wires",
    version: 1,
    summary: "pins of the board",
    properties: &[],
    construct: |props| Ok(Box::new(wires(props))),
};

pub fn add(registry: &mut Registry, bindings: &mut Bindings) -> Result<ClassSchema> {
    registry.add(&CLASS)?;
    bindings.bind(CLASS.name, |props| Ok(Arc::new(wires(props))))?;
    let schema = ClassSchema::new(CLASS.name).port("soft", PortDir::Out).port("nmi", PortDir::Out);
    Ok(NAMES.iter().fold(schema, |schema, name| schema.port(*name, PortDir::In)))
}

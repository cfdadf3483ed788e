//! A clock as edges at a timer's input: one each tick of this device, while it is on.

use crate::bench::{OSCILLATOR, Time, lock};
use rsemu::core::device::{Device, DeviceClass, RealizeCtx, ResetKind, SinkPin};
use rsemu::core::props::Props;
use rsemu::core::sched::LazyHandle;
use rsemu::core::wire::{Level, WireId, WireSink, WireSource};
use rsemu::core::{Registry, Result};
use rsemu::machine::validate::{ClassSchema, PortDir};
use rsemu::machine::{Bindings, Instance};
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

#[derive(Debug)]
struct Pulses {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    time: Time,
    high: AtomicBool,
    /// Whether a line turns it on and off; else the bench does.
    switched: AtomicBool,
    out: Mutex<Option<WireSource>>,
}

const NEVER: u64 = u64::MAX;

impl Shared {
    /// Ticks from edge to edge.
    fn every(&self) -> u64 {
        if self.switched.load(SeqCst) { 1 } else { OSCILLATOR.load(SeqCst).max(1) }
    }

    fn turn(&self, on: bool) {
        let next = if on { self.time.now() + self.every() } else { NEVER };
        self.time.next.store(next, SeqCst);
    }
}

impl WireSink for Shared {
    fn set_level(&self, _: WireId, _: u32, level: Level) {
        self.time.sync();
        self.turn(level == Level::High);
    }
}

impl Device for Pulses {
    fn class(&self) -> &'static DeviceClass {
        &CLASS
    }

    fn realize(&self, _: &mut RealizeCtx<'_>) -> Result<()> {
        Ok(())
    }

    fn reset(&self, _: ResetKind) {
        self.shared.turn(!self.shared.switched.load(SeqCst) && OSCILLATOR.load(SeqCst) > 0);
    }

    fn sink(&self, _: &str, _: &[WireId]) -> Option<SinkPin> {
        self.shared.switched.store(true, SeqCst);
        Some(SinkPin { sink: self.shared.clone(), line: 0 })
    }

    fn connect(&self, _: &str, source: WireSource) -> Result<()> {
        *lock(&self.shared.out) = Some(source);
        Ok(())
    }

    fn is_lazy(&self) -> bool {
        true
    }

    fn current_tick(&self) -> u64 {
        self.shared.time.now()
    }

    fn advance_to(&self, tick: u64) {
        let shared = &self.shared;
        shared.time.tick.fetch_max(tick, SeqCst);
        if shared.time.next.load(SeqCst) > tick {
            return;
        }
        shared.turn(true);
        let high = !shared.high.fetch_xor(true, SeqCst);
        let out = lock(&shared.out).clone();
        if let Some(out) = out {
            out.set(Level::from_bool(high));
        }
    }

    fn next_event_tick(&self) -> Option<u64> {
        self.shared.time.next()
    }

    fn attach_lazy(&self, handle: LazyHandle) {
        self.shared.time.attach(handle);
    }
}

impl Instance for Pulses {}

fn pulses(_: &Props) -> Pulses {
    let shared = Shared {
        time: Time::new(),
        high: AtomicBool::new(false),
        switched: AtomicBool::new(false),
        out: Mutex::new(None),
    };
    Pulses { shared: Arc::new(shared) }
}

static CLASS: DeviceClass = DeviceClass {
    name: "bench.pulses",
    version: 1,
    summary: "a clock as edges",
    properties: &[],
    construct: |props| Ok(Box::new(pulses(props))),
};

pub fn add(registry: &mut Registry, bindings: &mut Bindings) -> Result<ClassSchema> {
    registry.add(&CLASS)?;
    bindings.bind(CLASS.name, |props| Ok(Arc::new(pulses(props))))?;
    Ok(ClassSchema::new(CLASS.name).port("out", PortDir::Out).port("on", PortDir::In))
}

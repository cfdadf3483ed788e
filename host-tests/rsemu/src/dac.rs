//! The first channel of the converter to analog as RM0390 describes it in chapter 14, read apart from the firmware's own code.
//!
//! | rule | section |
//! |---|---|
//! | without a trigger a written code appears at once | 14.3.4 |
//! | with TEN a trigger moves DHR to the output; TSEL 5 is TIM4_TRGO | 14.3.4, 14.3.6 |
//! | with DMAEN each trigger requests the next code | 14.3.7 |
//! | a trigger before the last request was served is an underrun: DMAUDR, and no request until it is cleared | 14.3.7 |
//! | DMAUDR is cleared by a one | 14.5.14 |
//! | with the output buffer (BOFF 0) the output stays 0.2 V from the rails | data sheet, DAC characteristics |

use crate::bench::{Time, bench, broken, lock};
use rsemu::core::device::{Device, DeviceClass, RealizeCtx, ResetKind, SinkPin};
use rsemu::core::error::BusError;
use rsemu::core::props::Props;
use rsemu::core::sched::LazyHandle;
use rsemu::core::space::{AccessConstraints, MemAttrs, MemOps, MemResult, Region, RegionRef};
use rsemu::core::value::{Endian, Width};
use rsemu::core::wire::{Level, WireId, WireSink, WireSource};
use rsemu::core::{Registry, Result};
use rsemu::machine::validate::{ClassSchema, PortDir};
use rsemu::machine::{Bindings, Instance};
use std::sync::atomic::Ordering::SeqCst;
use std::sync::{Arc, Mutex};

const EN: u32 = 1;
const BOFF: u32 = 1 << 1;
const TEN: u32 = 1 << 2;
const DMAEN: u32 = 1 << 12;
const UNDERRUN: u32 = 1 << 13;
/// 0.2 V of 3.3 V, in codes.
const RAIL: u32 = 248;

#[derive(Debug, Default)]
struct State {
    control: u32,
    held: u32,
    out: u32,
    status: u32,
    /// A request that was not served yet.
    asked: bool,
}

#[derive(Debug)]
struct Shared {
    state: Mutex<State>,
    time: Time,
    dma: Mutex<Option<WireSource>>,
}

impl Shared {
    fn put_out(&self, state: &mut State) {
        state.out = state.held;
        let volts = match state.control & BOFF {
            0 => state.out.clamp(RAIL, 4095 - RAIL),
            _ => state.out,
        };
        bench(|bench| {
            bench.dac = volts as u16;
            if bench.keep {
                bench.codes.push((self.time.now(), state.out as u16));
            }
        });
    }

    fn write(&self, offset: u64, word: u32) {
        let mut state = lock(&self.state);
        match offset {
            0x00 => {
                state.control = word;
                if word & DMAEN == 0 {
                    state.asked = false;
                }
            }
            0x08 => {
                state.held = word & 0xFFF;
                state.asked = false;
                if state.control & (EN | TEN) == EN {
                    self.put_out(&mut state);
                }
            }
            0x34 => state.status &= !word,
            _ => {}
        }
    }
}

static OURS: Mutex<Option<Arc<Shared>>> = Mutex::new(None);

/// Has the converter find its code not served in time.
pub fn underrun() {
    let shared = lock(&OURS).clone();
    if let Some(shared) = shared {
        lock(&shared.state).status |= UNDERRUN;
    }
}

#[derive(Debug)]
struct Registers(Arc<Shared>);

impl MemOps for Registers {
    fn read(&self, offset: u64, dst: &mut [u8], _: MemAttrs) -> MemResult {
        let state = lock(&self.0.state);
        let word = match offset & !3 {
            0x00 => state.control,
            0x08 => state.held,
            0x2C => state.out,
            0x34 => state.status,
            _ => 0,
        };
        dst.iter_mut().zip(word.to_le_bytes()).for_each(|(place, byte)| *place = byte);
        Ok(())
    }

    fn write(&self, offset: u64, src: &[u8], _: MemAttrs) -> MemResult {
        self.0.time.sync();
        let word = match *src {
            [a, b] => u32::from_le_bytes([a, b, 0, 0]),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => return Err(BusError::BadAccess),
        };
        self.0.write(offset, word);
        Ok(())
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::word(Width::U32, Endian::Little).with_widths(Width::U16, Width::U32)
    }
}

impl WireSink for Shared {
    fn set_level(&self, _: WireId, _: u32, level: Level) {
        if level != Level::High {
            return;
        }
        self.time.sync();
        let request = {
            let mut state = lock(&self.state);
            if state.control & (EN | TEN) != EN | TEN || state.control >> 3 & 7 != 5 {
                return;
            }
            self.put_out(&mut state);
            let wanted = state.control & DMAEN != 0 && state.status & UNDERRUN == 0;
            if wanted && state.asked {
                state.status |= UNDERRUN;
                broken("14.3.7: a code is not served before the next trigger");
            }
            let request = wanted && !state.asked;
            state.asked |= request;
            request
        };
        let line = lock(&self.dma).clone();
        if let (Some(line), true) = (line, request) {
            line.set(Level::High);
            line.set(Level::Low);
        }
    }
}

#[derive(Debug)]
struct Dac {
    shared: Arc<Shared>,
    region: RegionRef,
}

impl Device for Dac {
    fn class(&self) -> &'static DeviceClass {
        &CLASS
    }

    fn realize(&self, _: &mut RealizeCtx<'_>) -> Result<()> {
        *lock(&OURS) = Some(self.shared.clone());
        Ok(())
    }

    fn reset(&self, _: ResetKind) {
        *lock(&self.shared.state) = State::default();
    }

    fn region(&self, _: &str) -> Option<RegionRef> {
        Some(self.region.clone())
    }

    fn sink(&self, _: &str, _: &[WireId]) -> Option<SinkPin> {
        Some(SinkPin { sink: self.shared.clone(), line: 0 })
    }

    fn connect(&self, _: &str, source: WireSource) -> Result<()> {
        *lock(&self.shared.dma) = Some(source);
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

impl Instance for Dac {}

fn dac(_: &Props) -> Dac {
    let shared = Arc::new(Shared {
        state: Mutex::new(State::default()),
        time: Time::new(),
        dma: Mutex::new(None),
    });
    let region = Arc::new(Region::io("dac", 0x400, Arc::new(Registers(shared.clone()))));
    Dac { shared, region }
}

static CLASS: DeviceClass = DeviceClass {
    name: "bench.dac",
    version: 1,
    summary: "DAC channel 1 of an STM32F446",
    properties: &[],
    construct: |props| Ok(Box::new(dac(props))),
};

pub fn add(registry: &mut Registry, bindings: &mut Bindings) -> Result<ClassSchema> {
    registry.add(&CLASS)?;
    bindings.bind(CLASS.name, |props| Ok(Arc::new(dac(props))))?;
    Ok(ClassSchema::new(CLASS.name).region("").port("dma", PortDir::Out).port("tim4", PortDir::In))
}

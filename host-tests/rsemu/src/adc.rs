//! Two converters as RM0390 describes them in chapter 13, read apart from the firmware's own code: regular conversions of one
//! channel, alone or both in step, by an external trigger or one after the other, fetched by DMA.
//!
//! | rule | section |
//! |---|---|
//! | ADON powers a converter; it is stable 3 us later (data sheet, t_STAB) | 13.3.1 |
//! | a conversion takes the sampling time and 12 cycles of ADCCLK | 13.5 |
//! | ADCCLK is PCLK2 by ADCPRE: 2, 4, 6, 8 | 13.13.16 |
//! | EXTEN 1 takes rises, EXTSEL 8 is TIM3_TRGO; a trigger while converting is lost | 13.6, 13.13.3 |
//! | CONT starts the next conversion at the end of the last | 13.3.5 |
//! | EOC rises at the end; a read of the data clears it | 13.13.1 |
//! | DMA requests one transfer at each end while DDS is set | 13.8.1 |
//! | with DMA, data not fetched at the next end is an overrun: OVR, no request and no trigger until OVR is cleared | 13.8.1 |
//! | after an overrun requests come again once the bit that asks for them was "written to 0, then to 1" | 13.8.1 |
//! | MULTI 6 starts both by ADC1's trigger; the results are halves of CDR, requested by CCR.DMA 2 in one word | 13.9.2 |
//! | OVRIE raises the interrupt while OVR is set | 13.11 |

use crate::bench::{Input, Time, bench, broken, lock};
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
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

const SR_EOC: u32 = 1 << 1;
const SR_STRT: u32 = 1 << 4;
const SR_OVR: u32 = 1 << 5;
const CR1_EOCIE: u32 = 1 << 5;
const CR1_OVRIE: u32 = 1 << 26;
const CR2_ADON: u32 = 1;
const CR2_CONT: u32 = 1 << 1;
const CR2_DMA: u32 = 1 << 8;
const CR2_DDS: u32 = 1 << 9;
const CR2_SWSTART: u32 = 1 << 30;
const SAMPLING: [u64; 8] = [3, 15, 28, 56, 84, 112, 144, 480];
const NEVER: u64 = u64::MAX;

#[derive(Clone, Copy, Debug)]
struct Unit {
    /// SR to DR at their offsets divided by 4.
    words: [u32; 20],
    /// The end of the conversion under way.
    ends: u64,
    /// When it was powered.
    powered: u64,
    /// Conversions since then.
    count: usize,
}

const SR: usize = 0;
const CR1: usize = 1;
const CR2: usize = 2;
const SMPR2: usize = 4;
const SQR3: usize = 13;
const DR: usize = 19;

impl Unit {
    const RESET: Self = Self { words: [0; 20], ends: NEVER, powered: 0, count: 0 };

    fn on(&self) -> bool {
        self.words[CR2] & CR2_ADON != 0
    }

    fn channel(&self) -> usize {
        (self.words[SQR3] & 31) as usize
    }

    /// PCLK2 cycles of a conversion.
    fn duration(&self, common: u32) -> u64 {
        let code = self.words[SMPR2] >> (3 * self.channel().min(9)) & 7;
        (SAMPLING[code as usize] + 12) * u64::from(2 * (1 + (common >> 16 & 3)))
    }

    fn sample(&mut self, now: u64) -> u16 {
        let (channel, count) = (self.channel(), self.count);
        self.count += 1;
        bench(|bench| match bench.inputs.get(channel).and_then(Option::as_ref) {
            Some(Input::Table(codes)) => codes[count % codes.len()],
            Some(Input::Dac) => bench.dac,
            Some(Input::SincePulse(scale)) => ((now - bench.pulse) / scale).min(4095) as u16,
            None => 2048,
        })
    }
}

#[derive(Debug)]
struct State {
    units: [Unit; 2],
    /// CCR.
    common: u32,
    /// An overrun has ended the requests.
    mute: bool,
}

impl State {
    const RESET: Self = Self { units: [Unit::RESET; 2], common: 0, mute: false };

    fn dual(&self) -> bool {
        self.common & 31 == 6
    }

    /// Starts a conversion, of both converters where they go in step.
    fn start(&mut self, now: u64) {
        let common = self.common;
        let both = if self.dual() { 2 } else { 1 };
        for unit in &mut self.units[..both] {
            if !unit.on() {
                broken("13.9: a converter in step is off");
                continue;
            }
            unit.ends = now + unit.duration(common);
            unit.words[SR] |= SR_STRT;
        }
    }

    fn trigger(&mut self, now: u64, clock_hz: u64) {
        let unit = &self.units[0];
        let cr2 = unit.words[CR2];
        if !unit.on() || cr2 >> 28 & 3 != 1 || cr2 >> 24 & 15 != 8 || unit.words[SR] & SR_OVR != 0 {
            return;
        }
        if MISSES.load(SeqCst) > 0 {
            MISSES.fetch_sub(1, SeqCst);
            return;
        }
        if unit.ends != NEVER && cr2 & CR2_CONT != 0 {
            // The conversions follow each other by themselves.
            return;
        }
        if unit.ends != NEVER {
            broken("13.6: a trigger comes while a conversion is under way");
            return;
        }
        if (now - unit.powered) * 1_000_000 < 3 * clock_hz {
            broken("13.3.1: a conversion starts before the converter is stable");
        }
        self.start(now);
    }

    /// Ends what is due. Returns whether data is requested.
    fn end(&mut self, now: u64) -> bool {
        let dual = self.dual();
        let mut ended = [false; 2];
        for (unit, ended) in self.units.iter_mut().zip(&mut ended) {
            if unit.ends > now {
                continue;
            }
            let end = unit.ends;
            unit.ends = NEVER;
            *ended = true;
            let fetched = dual || unit.words[CR2] & CR2_DMA != 0;
            let sample = unit.sample(end);
            if fetched && unit.words[SR] & SR_EOC != 0 {
                unit.words[SR] |= SR_OVR;
                continue;
            }
            unit.words[DR] = u32::from(sample);
            unit.words[SR] |= SR_EOC;
        }
        let overrun = self.units.iter().any(|unit| unit.words[SR] & SR_OVR != 0);
        self.mute |= overrun;
        let first = &self.units[0];
        if ended[0] && first.words[CR2] & CR2_CONT != 0 && !overrun {
            self.start(now);
        }
        let wanted = match dual {
            true => self.common >> 14 & 3 == 2 && self.common >> 13 & 1 == 1,
            false => self.units[0].words[CR2] & (CR2_DMA | CR2_DDS) == CR2_DMA | CR2_DDS,
        };
        if ended[0] && wanted && self.mute && !overrun {
            broken("13.8.1: after an overrun the bit for requests was not written to 0, then to 1");
        }
        ended[0] && wanted && !self.mute
    }

    fn next(&self) -> u64 {
        self.units.iter().map(|unit| unit.ends).min().unwrap_or(NEVER)
    }

    fn interrupts(&self) -> bool {
        self.units.iter().any(|unit| {
            let [sr, cr1, ..] = unit.words;
            sr & SR_OVR != 0 && cr1 & CR1_OVRIE != 0 || sr & SR_EOC != 0 && cr1 & CR1_EOCIE != 0
        })
    }
}

static OURS: Mutex<Option<Arc<Shared>>> = Mutex::new(None);
/// Triggers that the first converter will not see.
static MISSES: AtomicU32 = AtomicU32::new(0);

/// Has the first converter miss its next trigger.
pub fn miss() {
    MISSES.fetch_add(1, SeqCst);
}

/// Has the first converter find its last result not fetched.
pub fn overrun() {
    let shared = lock(&OURS).clone();
    if let Some(shared) = shared {
        shared.work(|state| {
            state.units[0].words[SR] |= SR_OVR;
            state.units[0].ends = NEVER;
            state.mute = true;
            ((), false)
        });
    }
}

#[derive(Debug)]
struct Shared {
    state: Mutex<State>,
    time: Time,
    irq: Mutex<Option<WireSource>>,
    dma: Mutex<Option<WireSource>>,
}

impl Shared {
    /// Works with the registers, then drives the lines.
    fn work<T>(&self, work: impl FnOnce(&mut State) -> (T, bool)) -> T {
        let (result, request, irq) = {
            let mut state = lock(&self.state);
            let (result, request) = work(&mut state);
            self.time.next.store(state.next(), SeqCst);
            (result, request, state.interrupts())
        };
        let line = lock(&self.irq).clone();
        if let Some(line) = line {
            line.set(Level::from_bool(irq));
        }
        let line = lock(&self.dma).clone();
        if let (Some(line), true) = (line, request) {
            line.set(Level::High);
            line.set(Level::Low);
        }
        result
    }

    fn advance(&self, tick: u64) {
        self.work(|state| {
            let mut request = false;
            while state.next() <= tick {
                request |= state.end(state.next());
            }
            self.time.tick.fetch_max(tick, SeqCst);
            ((), request)
        });
    }

    fn read(&self, offset: usize, debug: bool) -> u32 {
        self.work(|state| {
            let word = match (offset, offset / 0x100) {
                (0x300, _) => {
                    state.units[0].words[SR] & 0x3F | (state.units[1].words[SR] & 0x3F) << 8
                }
                (0x304, _) => state.common,
                (0x308, _) => {
                    let [first, second] = state.units.map(|unit| unit.words[DR]);
                    if !debug {
                        state.units.iter_mut().for_each(|unit| unit.words[SR] &= !SR_EOC);
                    }
                    second << 16 | first
                }
                (_, unit @ 0..2) => {
                    let unit = &mut state.units[unit];
                    let index = offset % 0x100 / 4;
                    if index == DR && !debug {
                        unit.words[SR] &= !SR_EOC;
                    }
                    unit.words.get(index).copied().unwrap_or(0)
                }
                _ => 0,
            };
            (word, false)
        })
    }

    fn write(&self, offset: usize, word: u32) {
        let now = self.time.now();
        self.work(|state| {
            match (offset, offset / 0x100) {
                (0x304, _) => {
                    state.mute &= !state.dual() || word >> 14 & 3 != 0;
                    state.common = word;
                }
                (_, unit @ 0..2) => {
                    let index = offset % 0x100 / 4;
                    let taken_back = (unit, index) == (0, CR2) && word & CR2_DMA == 0;
                    state.mute &= state.dual() || !taken_back;
                    let unit = &mut state.units[unit];
                    let before = unit.words[index.min(DR)];
                    match index {
                        // Flags are cleared by a zero.
                        SR => unit.words[SR] &= word,
                        CR1 => unit.words[CR1] = word,
                        CR2 => {
                            unit.words[CR2] = word & !CR2_SWSTART;
                            if word & CR2_ADON == 0 {
                                unit.ends = NEVER;
                            } else if before & CR2_ADON == 0 {
                                (unit.powered, unit.count) = (now, 0);
                            }
                        }
                        index if index < DR => unit.words[index] = word,
                        _ => {}
                    }
                    if index == CR2 && word & CR2_SWSTART != 0 {
                        state.start(now);
                    }
                }
                _ => {}
            }
            ((), false)
        });
    }
}

/// The register block, which its region holds.
#[derive(Debug)]
struct Registers(Arc<Shared>);

impl MemOps for Registers {
    fn read(&self, offset: u64, dst: &mut [u8], attrs: MemAttrs) -> MemResult {
        if !attrs.debug {
            self.0.time.sync();
        }
        let word = self.0.read((offset & !3) as usize, attrs.debug) >> (8 * (offset & 3));
        dst.iter_mut().zip(word.to_le_bytes()).for_each(|(place, byte)| *place = byte);
        Ok(())
    }

    fn write(&self, offset: u64, src: &[u8], _: MemAttrs) -> MemResult {
        self.0.time.sync();
        let word = <[u8; 4]>::try_from(src).map_err(|_| BusError::BadAccess)?;
        self.0.write(offset as usize, u32::from_le_bytes(word));
        Ok(())
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::word(Width::U32, Endian::Little).with_widths(Width::U16, Width::U32)
    }
}

impl WireSink for Shared {
    fn set_level(&self, _: WireId, _: u32, level: Level) {
        if level == Level::High {
            self.time.sync();
            let now = self.time.now();
            // 90 MHz at most.
            self.work(|state| (state.trigger(now, 90_000_000), false));
        }
    }
}

#[derive(Debug)]
struct Adc {
    shared: Arc<Shared>,
    region: RegionRef,
}

impl Device for Adc {
    fn class(&self) -> &'static DeviceClass {
        &CLASS
    }

    fn realize(&self, _: &mut RealizeCtx<'_>) -> Result<()> {
        *lock(&OURS) = Some(self.shared.clone());
        Ok(())
    }

    fn reset(&self, _: ResetKind) {
        self.shared.work(|state| {
            *state = State::RESET;
            ((), false)
        });
    }

    fn region(&self, _: &str) -> Option<RegionRef> {
        Some(self.region.clone())
    }

    fn sink(&self, _: &str, _: &[WireId]) -> Option<SinkPin> {
        Some(SinkPin { sink: self.shared.clone(), line: 0 })
    }

    fn connect(&self, port: &str, source: WireSource) -> Result<()> {
        let place = if port == "irq" { &self.shared.irq } else { &self.shared.dma };
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
        self.shared.advance(tick);
    }

    fn next_event_tick(&self) -> Option<u64> {
        self.shared.time.next()
    }

    fn attach_lazy(&self, handle: LazyHandle) {
        self.shared.time.attach(handle);
    }
}

impl Instance for Adc {}

fn adc(_: &Props) -> Adc {
    let shared = Arc::new(Shared {
        state: Mutex::new(State::RESET),
        time: Time::new(),
        irq: Mutex::new(None),
        dma: Mutex::new(None),
    });
    let region = Arc::new(Region::io("adc", 0x400, Arc::new(Registers(shared.clone()))));
    Adc { shared, region }
}

static CLASS: DeviceClass = DeviceClass {
    name: "bench.adc",
    version: 1,
    summary: "ADC1 and ADC2 of an STM32F446",
    properties: &[],
    construct: |props| Ok(Box::new(adc(props))),
};

pub fn add(registry: &mut Registry, bindings: &mut Bindings) -> Result<ClassSchema> {
    registry.add(&CLASS)?;
    bindings.bind(CLASS.name, |props| Ok(Arc::new(adc(props))))?;
    Ok(ClassSchema::new(CLASS.name)
        .region("")
        .port("irq", PortDir::Out)
        .port("dma", PortDir::Out)
        .port("tim3", PortDir::In))
}

//! A NUCLEO-F446RE that is ordered by lines: `picket-on-rsemu IMAGE`, then on stdin
//!
//! ```text
//! erase MS            a sector's erasure takes this long (before `power`)
//! stall 0|1           whether the core stands still while flash is busy: it runs from flash, or from the cache
//! quantum US          time passes in steps of this, 10 otherwise: for boards that sleep (before `power`)
//! lsi HZ              the watchdog's oscillator (before `power`)
//! hse HZ              the probe's clock; 0 without power: it does not come, and while it runs: it fails (RM 6.2.7)
//! oscillator DIVIDER  what divides the watchdog's oscillator at TIM5's input; 0, as it is before, for none (before `power`)
//! options WORD        what FLASH_OPTCR holds, 0x0FFFAAE1 otherwise (before `power`); what the program changes stays over `power`
//! line CHARACTERS     the serial line takes so many a second, 92160 otherwise (before `power`)
//! power               off and on: flash is kept, memory is lost
//! run US              lets time pass, in steps of 10: `say HEX` for what the board sends, `reset US CAUSE` for each reset, then `at US`
//! hear HEX            the host sends bytes
//! read ADDRESS, write ADDRESS WORD
//! load ADDRESS FILE   writes a file into flash, while the power is off
//! input CHANNEL table FILE | dac | pulse SCALE | none
//! keep 0|1            whether the DAC's codes are kept
//! transmitter 0|1     whether the serial port sends
//! overrun             the converter's result was not fetched in time
//! miss                the converter does not see its next trigger
//! underrun            the DAC's code was not fetched in time
//! codes, edges, broken
//! ```
//!
//! Each order is answered by one line at least; the last one begins with `ok`.

mod adc;
mod bench;
mod dac;
mod pulses;

use bench::{BITTEN, Input, OSCILLATOR, bench, nmi};
use rsemu::core::clock::GlobalTime;
use rsemu::core::device::ResetKind;
use rsemu::core::space::MemAttrs;
use rsemu::core::value::Width;
use rsemu::core::wire::Level;
use rsemu::host::chardev::{CharPort, ports};
use rsemu::machine::{Machine, catalog};
use std::error::Error;
use std::fs;
use std::io::{BufRead, Write, stdin, stdout};
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;

type Fallible<T> = Result<T, Box<dyn Error>>;

const FLASH: u64 = 0x0800_0000;
const SIZE: usize = 512 << 10;
/// FLASH_SR and its bit BSY.
const FLASH_SR: u64 = 0x4002_3C0C;
const BUSY: u32 = 1 << 16;
/// FLASH_OPTCR, and its bits OPTLOCK and OPTSTRT.
const FLASH_OPTCR: u64 = 0x4002_3C14;
const OPTLOCK: u32 = 1;
const OPTSTRT: u32 = 1 << 1;
/// RCC_CR, with RCC_CFGR two words behind, and its bits.
const RCC_CR: u64 = 0x4002_3800;
const HSEON: u32 = 1 << 16;
const CSSON: u32 = 1 << 19;
const PLLON: u32 = 1 << 24;
/// The longest piece of time without a look at the flash and the reset lines, us.
const SLICE: u64 = 50;
/// Time passes in multiples of this, us: a deadline within one of the scheduler's rounds would let events fall together.
const QUANTUM: u64 = 10;

struct Board {
    machine: Option<(Machine, Arc<CharPort>)>,
    flash: Vec<u8>,
    erase_ms: u64,
    lsi_hz: u64,
    hse_hz: u64,
    /// The option word.
    options: u32,
    /// Characters that the serial line takes in a second.
    line: u64,
    stall: bool,
    now: u64,
    quantum: u64,
    /// When the power came.
    powered: u64,
    resets: u32,
}

impl Board {
    fn machine(&mut self) -> Fallible<&mut Machine> {
        Ok(&mut self.machine.as_mut().ok_or("the power is off")?.0)
    }

    fn peek(&mut self, address: u64) -> Fallible<u32> {
        let space = self.machine()?.space("mem").ok_or("no space")?.clone();
        Ok(space.read(address, Width::U32, MemAttrs::DEBUG).map_err(|e| format!("{e:?}"))? as u32)
    }

    /// Keeps what flash holds, an erasure or a word under way half done.
    fn off(&mut self) -> Fallible<()> {
        if self.machine.is_none() {
            return Ok(());
        }
        for at in (0..SIZE).step_by(4) {
            let word = self.peek(FLASH + at as u64)?;
            self.flash[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        let (status, control) = (self.peek(FLASH_SR)?, self.peek(FLASH_SR + 4)?);
        // A sector that was being erased: some bits are ones already.
        if status & BUSY != 0 && control & 1 << 1 != 0 {
            // Four sectors of 16 KiB, one of 64, three of 128 (RM 3.3, table 4).
            let (at, length) = match (control >> 3 & 15) as usize {
                sector @ 0..4 => (0x4000 * sector, 0x4000),
                4 => (0x10000, 0x10000),
                sector => (0x20000 * (sector - 4), 0x20000),
            };
            for (n, byte) in self.flash[at..at + length].iter_mut().enumerate() {
                *byte |= (n as u32)
                    .wrapping_mul(0x9E37_79B9)
                    .wrapping_add(self.now as u32)
                    .to_le_bytes()[3];
            }
        }
        self.options = self.peek(FLASH_OPTCR)? & !OPTSTRT | OPTLOCK;
        self.machine = None;
        Ok(())
    }

    fn power(&mut self) -> Fallible<()> {
        self.off()?;
        let text = include_str!("../nucleo.machine");
        let text = text.replace("ERASE", &(self.erase_ms * self.hse_hz / 1_000).to_string());
        let text = text.replace("HSE", &self.hse_hz.to_string());
        let text = text
            .replace("LSI", &self.lsi_hz.to_string())
            .replace("LINE", &self.line.to_string())
            .replace("OPTR", &format!("{:#x}", self.options));
        let mut registry = catalog::registry()?;
        let mut options = catalog::build_options()?;
        for add in [adc::add, dac::add, bench::add, pulses::add] {
            let schema = add(&mut registry, &mut options.bindings)?;
            options.classes.insert(schema);
        }
        options.realize.media.insert("firmware", self.flash.clone());
        options.realize.scheduler.quantum = GlobalTime::from_nanos(self.quantum * 1_000);
        let machine = rsemu::machine::build("nucleo", &text, &registry, &options)?;
        let port = ports::open(&options.realize.hosts, "console")?;
        rsemu::HELD.store(false, SeqCst);
        rsemu::RESET.store(false, SeqCst);
        BITTEN.store(false, SeqCst);
        self.machine = Some((machine, port));
        self.powered = self.now;
        // Memory holds anything after power-on.
        let space = self.machine()?.space("mem").ok_or("no space")?.clone();
        for n in 0..0x8000u64 {
            let word = (n + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
            space
                .write(0x2000_0000 + 4 * n, Width::U32, word, MemAttrs::DEBUG)
                .map_err(|e| format!("{e:?}"))?;
        }
        Ok(())
    }

    /// The probe's clock fails: it and what multiplies it stop, the core goes on by HSI and is told, if CSSON asked for it; else
    /// it stands.
    fn fail(&mut self) -> Fallible<()> {
        rsemu::NO_HSE.store(true, SeqCst);
        let control = self.peek(RCC_CR)?;
        if control & CSSON == 0 {
            rsemu::HELD.store(true, SeqCst);
            return Ok(());
        }
        let choice = self.peek(RCC_CR + 8)?;
        let space = self.machine()?.space("mem").ok_or("no space")?.clone();
        for (place, word) in
            [(RCC_CR + 8, choice & !3), (RCC_CR, control & !(HSEON | PLLON | CSSON))]
        {
            space
                .write(place, Width::U32, word.into(), MemAttrs::DEFAULT)
                .map_err(|e| format!("{e:?}"))?;
        }
        nmi(Level::High);
        self.run(SLICE)?;
        nmi(Level::Low);
        Ok(())
    }

    fn run(&mut self, microseconds: u64) -> Fallible<()> {
        let end = self.now + microseconds.next_multiple_of(self.quantum);
        while self.now < end {
            let step = SLICE.max(self.quantum).min(end - self.now);
            self.now += step;
            let deadline = GlobalTime::from_nanos((self.now - self.powered) * 1_000);
            self.machine()?.run_until(deadline)?;
            let busy = self.stall && self.peek(FLASH_SR)? & BUSY != 0;
            rsemu::HELD.store(busy, SeqCst);
            let soft = rsemu::RESET.swap(false, SeqCst);
            if soft | BITTEN.swap(false, SeqCst) {
                self.resets += 1;
                println!("reset {} {}", self.now, if soft { "software" } else { "watchdog" });
                self.machine()?.reset(ResetKind::Warm);
                if soft {
                    bench::soft_reset();
                }
            }
        }
        let said = self.machine.as_ref().map(|(_, port)| port.drain()).unwrap_or_default();
        if !said.is_empty() {
            println!("say {}", hex(&said));
        }
        println!("at {}", self.now);
        Ok(())
    }

    fn order(&mut self, line: &str) -> Fallible<()> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["erase", ms] => self.erase_ms = ms.parse()?,
            ["lsi", hz] => self.lsi_hz = hz.parse()?,
            ["hse", "0"] if self.machine.is_some() => self.fail()?,
            ["hse", "0"] => rsemu::NO_HSE.store(true, SeqCst),
            ["hse", hz] => {
                self.hse_hz = hz.parse()?;
                rsemu::NO_HSE.store(false, SeqCst);
            }
            ["options", word] => self.options = number(word)? as u32,
            ["line", characters] => self.line = characters.parse()?,
            ["oscillator", divider] => OSCILLATOR.store(divider.parse()?, SeqCst),
            ["quantum", us] => self.quantum = us.parse()?,
            ["stall", on] => self.stall = on == "1",
            ["power"] => self.power()?,
            ["off"] => self.off()?,
            ["run", us] => self.run(us.parse()?)?,
            ["hear", bytes] => {
                let port = &self.machine.as_ref().ok_or("the power is off")?.1;
                port.feed(&bytes_of(bytes)?);
            }
            ["read", address] => println!("word {}", self.peek(number(address)?)?),
            ["write", address, word] => {
                let space = self.machine()?.space("mem").ok_or("no space")?.clone();
                space
                    .write(number(address)?, Width::U32, number(word)?, MemAttrs::DEFAULT)
                    .map_err(|e| format!("{e:?}"))?;
            }
            ["load", address, file] => {
                self.off()?;
                let at = (number(address)? - FLASH) as usize;
                let bytes = fs::read(file)?;
                self.flash[at..at + bytes.len()].copy_from_slice(&bytes);
            }
            ["input", channel, ref what @ ..] => {
                let input = match what {
                    ["table", file] => {
                        let codes = fs::read(file)?;
                        let codes = codes.chunks_exact(2).map(|c| u16::from_le_bytes([c[0], c[1]]));
                        Some(Input::Table(codes.collect()))
                    }
                    ["dac"] => Some(Input::Dac),
                    ["pulse", scale] => Some(Input::SincePulse(scale.parse()?)),
                    _ => None,
                };
                let channel: usize = channel.parse()?;
                bench(|bench| bench.inputs[channel] = input);
            }
            ["keep", on] => bench(|bench| {
                bench.keep = on == "1";
                bench.codes.clear();
            }),
            ["transmitter", on] => rsemu::MUTE.store(on == "0", SeqCst),
            ["overrun"] => adc::overrun(),
            ["miss"] => adc::miss(),
            ["underrun"] => dac::underrun(),
            ["codes"] => {
                let codes = bench(|bench| std::mem::take(&mut bench.codes));
                let text: Vec<String> =
                    codes.iter().map(|(at, code)| format!("{at}:{code}")).collect();
                println!("codes {}", text.join(" "));
            }
            ["edges"] => {
                let edges = bench(|bench| std::mem::take(&mut bench.edges));
                let text: Vec<String> =
                    edges.iter().map(|(at, rise)| format!("{at}:{}", u8::from(*rise))).collect();
                println!("edges {}", text.join(" "));
            }
            ["broken"] => {
                let broken = bench(|bench| std::mem::take(&mut bench.broken));
                broken.iter().for_each(|(rule, count)| println!("rule {count} {rule}"));
            }
            _ => return Err(format!("no such order: {line}").into()),
        }
        Ok(())
    }
}

fn number(text: &str) -> Fallible<u64> {
    let digits = text.strip_prefix("0x").ok_or("numbers begin with 0x")?;
    Ok(u64::from_str_radix(digits, 16)?)
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes_of(hex: &str) -> Fallible<Vec<u8>> {
    (0..hex.len()).step_by(2).map(|at| Ok(u8::from_str_radix(&hex[at..at + 2], 16)?)).collect()
}

fn main() -> Fallible<()> {
    let image = std::env::args().nth(1).ok_or("picket-on-rsemu IMAGE")?;
    let mut flash = fs::read(image)?;
    flash.resize(SIZE, 0xFF);
    let mut board = Board {
        machine: None,
        flash,
        erase_ms: 1_000,
        lsi_hz: 32_000,
        hse_hz: 8_000_000,
        options: 0x0FFF_AAE1,
        line: 92_160,
        stall: true,
        now: 0,
        quantum: QUANTUM,
        powered: 0,
        resets: 0,
    };
    for line in stdin().lock().lines() {
        match board.order(&line?) {
            Ok(()) => println!("ok"),
            Err(error) => println!("ok error {error}"),
        }
        stdout().flush()?;
    }
    Ok(())
}

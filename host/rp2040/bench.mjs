// A Pico on a bench: `node bench.mjs IMAGE.bin` takes orders, a line each, and answers each with lines and `ok`.
import { closeSync, openSync, readFileSync, writeSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { chip, FLASH } from './chip.mjs';
import { faults } from './faults.mjs';
import { Host } from './usb.mjs';

const flash = new Uint8Array(16 << 20).fill(0xff);
flash.set(readFileSync(process.argv[2]));
let sram = new Uint8Array(264 << 10);
let mcu = null;
/** Nanoseconds before the last reset. */
let before = 0;
let samples = new Int16Array([2048]);
/** Inputs that have a code of their own in each sample. */
let inputs = 1;
/** The next sample. */
let next = 0;
/** Whether the converter's input is wired to the chirp's output, through a filter of no time. */
let wired = false;
/** Whether it is wired there without a filter: it reads the output's high or low. */
let jumper = false;
/** How many times as long as it should the converter takes for a sample. */
let slow = 1;
/** The codes of the temperature's sensor in turn: 0.706 V of 3.3 V at 27 C. */
const SENSOR = [876, 877, 875, 877];
/** Whether it reads how many conversions came before since its start; `null` if not. */
let count = null;
/** The sync output's rises and falls, in ns. */
let edges = [];
/** When the sync input rose last, and the time from there to the converter's start: the least and the most, ns. */
let rose = NaN;
let delays = [Infinity, -Infinity];
/** Bytes of a block. */
let size = 2048;
let said = [];
/** What came by USB. */
let usb = [];
const host = new Host();
host.onData = (bytes) => usb.push(...bytes);
let again = null;
let blocks = null;
/** How often the converter was started. */
let starts = 0;
/** The last start after which a sample found no place. */
let over = -1;
let figures;

const now = () => before + (mcu ? mcu.clock.nanos : 0);

function zero() {
  figures = { at: now(), cycles: 0, idle: 0, instructions: 0, entries: 0, frames: 0, level: 0, overruns: 0, over: 0, taken: 0 };
}
zero();

function plug(reason) {
  if (mcu) {
    before += mcu.clock.nanos;
    sram = mcu.sram;
    flash.set(mcu.flash);
  }
  mcu = chip(flash, sram, reason);
  again = null;
  mcu.onSent = (byte) => {
    said.push(byte);
    if (byte === 0) figures.frames++;
  };
  const watchdog = mcu.peripherals[0x40058];
  watchdog.onWatchdogTrigger = () => {
    again ??= watchdog.reason;
    // It would go on at this very moment for ever.
    watchdog.timer.enable = false;
    watchdog.alarm.enable = false;
  };
  // The core asks for its own reset by AIRCR.
  const { ppb } = mcu;
  const write = ppb.writeUint32.bind(ppb);
  ppb.writeUint32 = (offset, value) => {
    if (offset === 0xd0c) again ??= value & 4 ? 'core' : null;
    else write(offset, value);
  };
  host.attach(mcu);
  mcu.gpio[12].addListener((state) => edges.push([state === 1 ? 1 : 0, now()]));
  convert();
  watch();
}

/** What lies at an input of the converter: the samples in turn, or the chirp's level of 4096. */
function input(channel) {
  if (channel === 4) return SENSOR[figures.taken % SENSOR.length];
  if (count !== null) return count++ & 0xfff;
  if (jumper) {
    const { alarmA, timer } = mcu.pwm.channels[7];
    return timer.counter < alarmA.target ? 4095 : 0;
  }
  if (wired) {
    const { alarmA, timer } = mcu.pwm.channels[7];
    return Math.min(Math.floor((4096 * alarmA.target) / (timer.top + 1)), 4095);
  }
  const sample = samples[inputs * next + Math.min(channel, inputs - 1)];
  next = (next + 1) % (samples.length / inputs);
  return sample;
}

/** The converter takes its input where a conversion begins; what it does to its queue is watched. */
function convert() {
  const { adc } = mcu;
  adc.onADCRead = (channel) => {
    adc.currentChannel = channel;
    adc.channelValues[channel] = input(channel);
    figures.taken++;
    adc.sampleAlarm.schedule(2000 * slow);
  };
  const wait = adc.multiShotAlarm.schedule.bind(adc.multiShotAlarm);
  adc.multiShotAlarm.schedule = (nanos) => wait(nanos * slow);
  const write = adc.writeUint32.bind(adc);
  adc.writeUint32 = (offset, value) => {
    // START_MANY.
    if (offset === 0 && value & ~adc.cs & 8) {
      starts++;
      if (count !== null) count = 0;
      const delay = now() - rose;
      delays = [Math.min(delays[0], delay), Math.max(delays[1], delay)];
    }
    write(offset, value);
  };
  const complete = adc.completeADCRead.bind(adc);
  adc.completeADCRead = (value, error) => {
    // The conversion under way when the board stops the converter may find none: it is thrown away.
    if (adc.fifo.full && adc.fcs & 1 && adc.cs & 8) {
      figures.overruns++;
      if (over !== starts) figures.over++;
      over = starts;
    }
    complete(value, error);
    figures.level = Math.max(figures.level, adc.fifo.itemCount);
  };
}

/** Blocks as the two channels complete them, with the moment, into a file. */
function watch() {
  for (const channel of mcu.dma.channels.slice(0, 2)) {
    const transfer = channel.transfer;
    channel.transferAlarm.callback = () => {
      const last = channel.transCount === 1;
      transfer();
      if (last && blocks !== null) {
        // The address is behind the last sample; the guard is before the block.
        const end = channel.writeAddr & 0xfffff;
        const head = Buffer.alloc(16);
        head.writeDoubleLE(now());
        head.writeDoubleLE(starts, 8);
        writeSync(blocks, head);
        writeSync(blocks, mcu.sram.subarray(end - size, end));
      }
    };
  }
}

/** Restarts the chip where it asked for it. A core that resets itself keeps the rest of the chip as it is. */
function restart() {
  const held = again === 'core' ? mcu.peripherals[0x4000c].reset : 0x1ffffff;
  plug(again === 'core' ? mcu.peripherals[0x40058].reason : again);
  mcu.peripherals[0x4000c].reset = held;
  console.log(`reset ${Math.round(now() / 1e3)}`);
}

/** Lets time pass until `done`. */
function run(done) {
  while (!done()) {
    const { core, clock } = mcu;
    const cycle = 1e9 / mcu.clkSys;
    // A millisecond, or until something happens that is for this loop.
    const end = clock.nanos + 1e6;
    const change = mcu.clkSys;
    while (clock.nanosCounter < end && again === null && mcu.clkSys === change && !done()) {
      for (let burst = 0; burst < 64; burst++) {
        if (core.waiting) {
          const next = Math.max(clock.nanosToNextAlarm, 0);
          clock.tick(next);
          figures.idle += next;
          break;
        }
        let cycles = core.executeInstruction() + mcu.late;
        figures.entries += mcu.late / 15;
        mcu.late = 0;
        figures.instructions++;
        figures.cycles += cycles;
        const time = clock.nanosCounter + cycles * cycle;
        if (mcu.pause) {
          clock.tick(mcu.pause);
          mcu.pause = 0;
        } else if (clock.nextAlarm && clock.nextAlarm.nanos <= time) {
          clock.tick(time - clock.nanosCounter);
        } else {
          clock.nanosCounter = time;
        }
        if (again !== null) break;
      }
    }
    if (again !== null) restart();
  }
}

const orders = {
  power() {
    sram.fill(0xa5);
    if (mcu) mcu.sram.fill(0xa5);
    plug(0);
  },
  /** For so many inputs, whose codes of the same moment stand side by side. */
  samples(file, side) {
    const bytes = readFileSync(file);
    samples = new Int16Array(bytes.buffer, bytes.byteOffset, bytes.length >> 1);
    inputs = Number(side);
    count = null;
    next = 0;
    wired = jumper = false;
  },
  /** Each conversion reads how many came before it since the converter's start. */
  count() {
    count = 0;
  },
  /** GP14 to GP26. */
  wire() {
    wired = true;
  },
  /** GP14 to GP26 by a wire alone. */
  jumper() {
    jumper = true;
  },
  /** The converter's clock is so many times too slow. */
  slow(times) {
    slow = Number(times);
  },
  /** The sync output's edges since the last asking: `edge 1 NS`, `edge 0 NS`. */
  edges() {
    for (const [level, nanos] of edges) console.log(`edge ${level} ${nanos}`);
    edges = [];
  },
  /** The sync input rises, and falls a microsecond later. */
  rise() {
    const pin = mcu.gpio[13];
    rose = now();
    pin.setInputValue(true);
    mcu.clock.createAlarm(() => pin.setInputValue(false)).schedule(1e3);
  },
  /** From a rise to the start, ns: `delays LEAST MOST`. */
  delays() {
    console.log(`delays ${delays.join(' ')}`);
    delays = [Infinity, -Infinity];
  },
  load(address, file) {
    flash.set(readFileSync(file), Number(address) - FLASH);
  },
  run(microseconds) {
    const end = now() + 1e3 * Number(microseconds);
    run(() => now() >= end);
  },
  frames(count, milliseconds) {
    const [wanted, end] = [figures.frames + Number(count), now() + 1e6 * Number(milliseconds)];
    run(() => figures.frames >= wanted || now() >= end);
  },
  hear(hex) {
    mcu.hear(Buffer.from(hex, 'hex'));
  },
  /** `plug`, `unplug`, `open 1`, `open 0`, `read 1`, `read 0`, `hear HEX` at the USB socket. */
  usb(what, word) {
    host[what](what === 'hear' ? Buffer.from(word, 'hex') : word === '1');
  },
  read(address) {
    console.log(`word ${mcu.readUint32(Number(address)) >>> 0}`);
  },
  write(address, word) {
    mcu.writeUint32(Number(address), Number(word));
  },
  blocks(file, bytes) {
    if (blocks !== null) closeSync(blocks);
    blocks = openSync(file, 'w');
    size = Number(bytes);
  },
  fault(kind, microseconds) {
    faults[kind](mcu, 1e3 * Number(microseconds));
  },
  zero,
  figures() {
    const nanos = now() - figures.at;
    console.log(`figures ${JSON.stringify({ ...figures, nanos, clkSys: mcu.clkSys, baud: mcu.uart[0].baudRate })}`);
  },
};

for await (const line of createInterface({ input: process.stdin })) {
  const [order, ...words] = line.trim().split(' ');
  let failure = '';
  try {
    orders[order](...words);
  } catch (error) {
    failure = ` ${String(error.stack).split('\n').slice(0, 3).join(' | ')}`;
  }
  if (said.length > 0) console.log(`say ${Buffer.from(said).toString('hex')}`);
  if (usb.length > 0) console.log(`usb ${Buffer.from(usb).toString('hex')}`);
  [said, usb] = [[], []];
  console.log(`at ${Math.round(now() / 1e3)}`);
  console.log(`ok${failure}`);
}

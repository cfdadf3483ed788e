// An RP2040 with what rp2040js lacks or has otherwise than the chip, each in a function of its own that says so. docs/pico.md lists
// them; host-tests/tests/pico.rs shows each on the emulator as it comes.
import { corrected } from './correct.mjs';

const { ConsoleLogger, LogLevel, RP2040 } = await corrected();

export const FLASH = 0x10000000;
const SRAM = 0x20000000;

/** A chip after a reset with these contents of its memories, and why it was reset (WATCHDOG_REASON). */
export function chip(flash, sram, reason) {
  const mcu = new RP2040();
  mcu.logger = new ConsoleLogger(LogLevel.Error, true);
  mcu.flash.set(flash);
  mcu.sram.set(sram);
  mcu.peripherals[0x40058].reason = reason;
  resets(mcu);
  power(mcu);
  exceptions(mcu);
  serial(mcu);
  aborts(mcu);
  wraps(mcu);
  turns(mcu);
  rises(mcu);
  rom(mcu);
  boot(mcu);
  return mcu;
}

/** RESETS: after a reset the subsystems are held; the emulator's never are. */
export function resets(mcu) {
  const block = mcu.peripherals[0x4000c];
  block.reset = 0x1ffffff;
  const read = block.readUint32.bind(block);
  block.readUint32 = (offset) => (offset === 8 ? ~block.reset & 0x1ffffff : read(offset));
}

/** The core's regulator at 1.10 V, and CHIP_RESET: power-on. The emulator has neither. */
function power(mcu) {
  const block = mcu.peripherals[0x40064];
  // EN 0, VSEL 7:4, ROK 12 (DS 2.10.6).
  let regulator = 0xb1;
  block.readUint32 = (offset) => [regulator | (1 << 12), 0, 1 << 8][offset >> 2] ?? 0;
  block.writeUint32 = (offset, value) => {
    if (offset === 0) regulator = value & 0xf3;
  };
  // SYSINFO: a chip B2, which has no RP2040-E5.
  mcu.peripherals[0x40000].readUint32 = (offset) => (offset === 0 ? 0x20002927 : 0);
}

/**
 * An exception's entry takes 15 cycles (Cortex-M0+ TRM, 3.4.1), not none; and the handler's address has no bit 0, which the emulator
 * leaves in the program counter, so that tables beside the handler's code are read from the wrong place.
 */
function exceptions(mcu) {
  const enter = mcu.core.exceptionEntry.bind(mcu.core);
  mcu.entries = 0;
  mcu.late = 0;
  mcu.core.exceptionEntry = (number) => {
    mcu.entries++;
    mcu.late += 15;
    enter(number);
    mcu.core.PC &= ~1;
  };
}

/** UART0 at its rate, with its queue of 32 bytes both ways; the emulator's sends at once. `onSent` gets the bytes, `hear` takes them. */
function serial(mcu) {
  const uart = mcu.uart[0];
  const waiting = [];
  const coming = [];
  const TX = 20;
  const byte = () => (10 * 1e9) / (uart.baudRate || 921600);
  const [write, read] = [uart.writeUint32.bind(uart), uart.readUint32.bind(uart)];
  const out = mcu.clock.createAlarm(() => {
    mcu.onSent?.(waiting.shift());
    if (waiting.length > 0) out.schedule(byte());
    mcu.dma.setDREQ(TX);
  });
  const into = mcu.clock.createAlarm(() => {
    uart.feedByte(coming.shift());
    if (coming.length > 0) into.schedule(byte());
  });
  uart.writeUint32 = (offset, value) => {
    if (offset !== 0) return write(offset, value);
    waiting.push(value & 0xff);
    if (waiting.length === 1) out.schedule(byte());
    if (waiting.length >= 32) mcu.dma.clearDREQ(TX);
  };
  uart.readUint32 = (offset) => {
    if (offset !== 0x18) return read(offset);
    // BUSY 3, TXFF 5, TXFE 7.
    const flags = (waiting.length > 0 ? 1 << 3 : 1 << 7) | (waiting.length >= 32 ? 1 << 5 : 0);
    return (read(offset) & ~(1 << 7)) | flags;
  };
  mcu.hear = (bytes) => {
    if (coming.length === 0 && bytes.length > 0) into.schedule(byte());
    coming.push(...bytes);
  };
}

/** CHAN_ABORT reads what is still being aborted: nothing. */
function aborts(mcu) {
  const read = mcu.dma.readUint32.bind(mcu.dma);
  mcu.dma.readUint32 = (offset) => (offset === 0x444 ? 0 : read(offset));
}

/** A wrap of the PWM asks for one transfer; the emulator's asks for ever. */
function wraps(mcu) {
  const { dma, pwm } = mcu;
  const wrap = pwm.channelInterrupt.bind(pwm);
  pwm.channelInterrupt = (slice) => {
    wrap(slice);
    dma.clearDREQ(24 + slice);
  };
}

/** In round robin the converter goes on to the next input; the emulator's stays at the first one. */
function turns(mcu) {
  const { adc } = mcu;
  Object.defineProperty(adc, 'activeChannel', {
    get: () => (adc.cs >> 12) & 7,
    set: (channel) => (adc.cs = (adc.cs & ~(7 << 12)) | (channel << 12)),
  });
}

/** A slice of the PWM that counts the rises of its B input; the emulator's pins tell it of none, and it does not wrap. */
function rises(mcu) {
  const { pwm } = mcu;
  pwm.gpioOnInput = (pin) => {
    for (const slice of pwm.channels.filter(({ pinB1, pinB2 }) => pin === pinB1 || pin === pinB2)) {
      const level = slice.gpioBValue;
      const rise = level && !slice.lastBValue;
      slice.lastBValue = level;
      if (!rise || !(slice.csr & 1) || slice.divMode !== 2) continue;
      if (slice.timer.counter < slice.timer.top) {
        slice.timer.advance(1);
      } else {
        slice.timer.set(0);
        slice.wrap();
      }
    }
  };
}

/** The boot ROM's functions for the flash: a look-up by their two letters, and each a breakpoint that does here what it does there. */
function rom(mcu) {
  const LOOKUP = 0x100;
  const names = ['IF', 'EX', 'RE', 'RP', 'FC', 'CX'];
  const half = (address, value) => {
    const word = mcu.bootrom[address >> 2];
    const shift = 8 * (address & 2);
    mcu.bootrom[address >> 2] = ((word & ~(0xffff << shift)) | (value << shift)) >>> 0;
  };
  half(0x14, 0x80);
  half(0x18, LOOKUP | 1);
  for (let index = 0; index <= names.length; index++) {
    // bkpt, bx lr
    half(LOOKUP + 4 * index, 0xbe00 | (0x40 + index));
    half(LOOKUP + 4 * index + 2, 0x4770);
  }
  const core = mcu.core;
  mcu.onBreak = (code) => {
    const [a, b, c] = core.registers;
    if (code === 0x40) {
      const name = String.fromCharCode(b & 0xff, b >> 8);
      core.registers[0] = names.includes(name) ? (LOOKUP + 4 * (names.indexOf(name) + 1)) | 1 : 0;
    } else if (names[code - 0x41] === 'RE') {
      mcu.flash.fill(0xff, a, a + b);
      mcu.pause = 45e6;
    } else if (names[code - 0x41] === 'RP') {
      for (let i = 0; i < c; i++) mcu.flash[a + i] &= mcu.readUint8(b + i);
      mcu.pause = 0.4e6;
    } else if (code < 0x40 || code > 0x40 + names.length) {
      throw new Error(`breakpoint ${code} at ${core.PC.toString(16)}`);
    }
  };
}

/** As the ROM does: the second stage is copied to the end of SRAM and called; it finds the program's vectors. */
function boot(mcu) {
  const core = mcu.core;
  const place = 0x41f00;
  mcu.sram.set(mcu.flash.subarray(0, 252), place);
  core.SP = SRAM + place;
  core.LR = 0;
  core.PC = SRAM + place;
  core.PM = false;
}

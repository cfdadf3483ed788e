// What the emulator, as npm got it, does otherwise than the chip: a line for each, `name true` while it does.
import { ConsoleLogger, LogLevel, RP2040, USBCDC } from 'rp2040js';

const make = () => {
  const mcu = new RP2040();
  mcu.logger = new ConsoleLogger(LogLevel.Error, false);
  return mcu;
};
const [ADC, DMA, RESETS, UART] = [0x4004c000, 0x50000000, 0x4000c000, 0x40034000];
const [DPRAM, USB] = [0x50100000, 0x50110000];
const tell = (name, otherwise) => console.log(`${name} ${otherwise}`);

/** Runs instructions from the start of SRAM. */
const run = (mcu, opcodes, registers, carry) => {
  const { core } = mcu;
  opcodes.forEach((opcode, index) => mcu.writeUint16(0x20000000 + 2 * index, opcode));
  core.PC = 0x20000000;
  core.SP = 0x20040000;
  registers.forEach((value, index) => (core.registers[index] = value));
  core.C = carry;
  for (let index = 0; index < opcodes.length; index++) core.executeInstruction();
  return core;
};

// adcs r0, r1: 0x7fffffff + 0 + 1 overflows.
tell('adcs', run(make(), [0x4148], [0x7fffffff, 0], true).V !== true);
// sbcs r0, r1: 0 - 0x7fffffff - 1 does not.
tell('sbcs', run(make(), [0x4188], [0, 0x7fffffff], false).V !== false);
{
  const mcu = make();
  const { core } = mcu;
  // A handler with `movs r0, #1`.
  mcu.writeUint16(0x20000100, 0x2001);
  mcu.writeUint32(0x20000000 + 4 * 27, 0x20000101);
  core.VTOR = 0x20000000;
  core.PC = 0x20000200;
  core.SP = 0x20040000;
  core.enabledInterrupts = 1 << 11;
  mcu.setInterrupt(11, true);
  const cycles = core.executeInstruction();
  tell('exception-entry-takes-no-cycles', cycles === 1);
  tell('bit-0-stays-in-the-program-counter', (core.PC & 1) === 1);
}
{
  const mcu = make();
  const { core } = mcu;
  // cpsid i, nop, nop, wfi, with an interrupt before the second nop.
  [0xb672, 0xbf00, 0xbf00, 0xbf30].forEach((opcode, index) => mcu.writeUint16(0x20000200 + 2 * index, opcode));
  mcu.writeUint32(0x20000000 + 4 * 27, 0x20000101);
  core.VTOR = 0x20000000;
  core.PC = 0x20000200;
  core.SP = 0x20040000;
  core.enabledInterrupts = 1 << 11;
  core.executeInstruction();
  core.executeInstruction();
  mcu.setInterrupt(11, true);
  core.executeInstruction();
  core.executeInstruction();
  tell('wfi-sleeps-over-what-is-pending', core.waiting);
}
tell('resets-are-always-done', make().readUint32(RESETS + 8) === 0x1ffffff);
tell('abort-reads-ones', make().readUint32(DMA + 0x444) >>> 0 !== 0);
{
  const mcu = make();
  let sent = 0;
  mcu.uart[0].onByte = () => sent++;
  for (let byte = 0; byte < 100; byte++) mcu.writeUint32(UART, byte);
  tell('uart-has-no-rate', sent === 100);
}
{
  const mcu = make();
  const channels = [];
  mcu.adc.onADCRead = (channel) => {
    channels.push(channel);
    mcu.adc.sampleAlarm.schedule(2000);
  };
  mcu.writeUint32(ADC, 1 | 8 | (3 << 16));
  mcu.clock.tick(20000);
  tell('round-robin-stays', !channels.includes(1));
}
{
  const mcu = make();
  mcu.adc.completeADCRead(5, true);
  mcu.writeUint32(ADC, 1 | (1 << 10));
  tell('err-sticky-stays', (mcu.readUint32(ADC) & (1 << 10)) !== 0);
}
{
  const mcu = make();
  mcu.writeUint32(ADC + 8, (1 << 24) | 1);
  mcu.adc.completeADCRead(7, false);
  mcu.writeUint32(ADC + 8, (1 << 24) | 1 | 8);
  tell('dreq-of-a-waiting-sample-is-missing', !mcu.dma.dreq[36]);
}
{
  const mcu = make();
  // X / Y = 1 / 250 of 125 MHz: a request in 2 us.
  mcu.writeUint32(DMA + 0x420, (1 << 16) | 250);
  tell('pacing-timers-are-inverted', mcu.dma.getTimer(59) !== 2);
}
{
  const mcu = make();
  const PWM = 0x40050000;
  // Slice 0 with a period of 100 cycles and a level of 50, in the output's hands.
  mcu.writeUint32(0x40014004, 4);
  mcu.writeUint32(PWM + 0x10, 99);
  mcu.writeUint32(PWM + 0xc, 50);
  mcu.writeUint32(PWM, 1);
  tell('pwm-starts-without-a-pulse', mcu.gpio[0].value !== 1);
  mcu.clock.tick(1000);
  tell('pwm-asks-for-ever', mcu.dma.dreq[24] === true);
}
{
  const mcu = make();
  const PWM = 0x40050000;
  // Slice 6 counts the rises of GP13.
  mcu.writeUint32(0x4001406c, 4);
  mcu.writeUint32(PWM + 6 * 0x14, (2 << 4) | 1);
  mcu.gpio[13].setInputValue(false);
  mcu.gpio[13].setInputValue(true);
  tell('pwm-counts-no-rises', mcu.readUint32(PWM + 6 * 0x14 + 8) === 0);
}
{
  const mcu = make();
  mcu.usbCtrl.sieStatus |= 1 << 4;
  mcu.writeUint32(USB + 0x50, 1 << 4);
  tell('usb-stays-suspended', (mcu.readUint32(USB + 0x50) & (1 << 4)) !== 0);
}
{
  const mcu = make();
  // FULL, AVAILABLE, 5 bytes for a host that has not asked.
  mcu.writeUint32(DPRAM + 0x88, (1 << 15) | (1 << 10) | 5);
  tell('usb-takes-a-packet-at-once', (mcu.readUint32(DPRAM + 0x88) & (1 << 10)) === 0);
}
{
  const mcu = make();
  const host = new USBCDC(mcu.usbCtrl);
  let answered = 0;
  mcu.usbCtrl.endpointReadDone = () => answered++;
  host.outEndpoint = 2;
  mcu.usbCtrl.onEndpointRead(2, 64);
  host.cdcSetControlLineState();
  tell('usb-host-answers-with-nothing', answered === 1);
  tell('usb-host-asks-the-device', mcu.readUint8(DPRAM) === 0x20);
}

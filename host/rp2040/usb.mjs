// A host at the board's USB socket, by the emulator's own (`USBCDC`): a cable, a program that opens the port, reads and writes it.
import { corrected } from './correct.mjs';

const { USBCDC } = await corrected();
const [SOF_RD, SIE_STATUS, SUSPENDED, AVAILABLE] = [0x48, 0x50, 1 << 4, 1 << 10];
/** INTR, DEV_SOF: a frame has begun; reading its number clears it. */
const DEV_SOF = 1 << 17;
/** A frame lasts so long, ns, and in its last part a packet to the host may hang the controller for ever (RP2040-E15). */
const [FRAME, CRITICAL] = [1e6, 800e3];
/** A packet of 64 bytes with what is around it takes so long, ns. */
const PACKET = 60e3;

export class Host {
  plugged = false;
  reads = true;
  /** Packets that the device gave within the critical part of a frame, and all. */
  late = 0;
  given = 0;
  /** Gets the bytes that the board sends. */
  onData = () => {};

  /** A new chip at the same socket. */
  attach(mcu) {
    this.usb = mcu.usbCtrl;
    this.clock = mcu.clock;
    this.held = [];
    this.asked = null;
    mend(this.usb);
    this.take();
    this.frames();
    this.usb.onUSBEnabled = () => this.plugged && this.usb.resetDevice();
    if (this.plugged) this.enumerate();
  }

  /** The host's end of a cable that is in: it configures the device and opens its port. */
  enumerate() {
    const { usb } = this;
    const cdc = new USBCDC(usb);
    this.cdc = cdc;
    usb.onUSBEnabled = () => this.plugged && usb.resetDevice();
    // To the interface (CDC PSTN 6.3.12); its own is to the device.
    cdc.cdcSetControlLineState = (state = 3) => {
      cdc.initialized = true;
      usb.sendSetupPacket(Uint8Array.of(0x21, 0x22, state, 0, 0, 0, 0, 0));
    };
    cdc.onSerialData = (bytes) => this.onData(bytes);
    // Its own answers a device that can take bytes with none, again and again.
    usb.onEndpointRead = (endpoint, size) => {
      // Before it is known which endpoint that is.
      if (endpoint !== 0) this.asked = size;
      this.give();
    };
  }

  plug() {
    this.plugged = true;
    if (!this.usb) return;
    this.held = [];
    this.asked = null;
    this.enumerate();
    // A device that has not started yet is reset when it has.
    if (this.usb.mainCtrl & 1) this.usb.resetDevice();
  }

  /** The bus is silent: after 3 ms the device finds itself suspended. */
  unplug() {
    this.plugged = false;
    const { usb } = this;
    usb.onEndpointWrite = usb.onResetReceived = usb.onEndpointRead = undefined;
    const silent = this.clock.createAlarm(() => {
      if (this.plugged) return;
      usb.sieStatus |= SUSPENDED;
      usb.sieStatusUpdated();
    });
    silent.schedule(3e6);
  }

  open(yes) {
    this.cdc.cdcSetControlLineState(yes ? 3 : 0);
  }

  /** A program that reads, or does not: packets then stay with the device. */
  read(yes) {
    this.reads = yes;
    if (yes) this.collect();
  }

  hear(bytes) {
    for (const byte of bytes) this.cdc.sendSerialByte(byte);
    this.give();
  }

  give() {
    const { cdc, usb, asked } = this;
    if (asked === null || cdc.txFIFO.empty || !this.plugged) return;
    this.asked = null;
    const bytes = new Uint8Array(Math.min(asked, cdc.txFIFO.itemCount));
    for (let i = 0; i < bytes.length; i++) bytes[i] = cdc.txFIFO.pull();
    usb.endpointReadDone(cdc.outEndpoint, bytes);
  }

  /** The host begins a frame each millisecond. */
  frames() {
    const { usb, clock } = this;
    const alarm = clock.createAlarm(() => {
      this.began = clock.nanos;
      if (this.plugged && usb.mainCtrl & 1) {
        usb.sofFrameNumber = (usb.sofFrameNumber + 1) & 0x7ff;
        usb.intRaw |= DEV_SOF;
        usb.checkInterrupts();
      }
      alarm.schedule(FRAME);
    });
    this.began = clock.nanos;
    alarm.schedule(FRAME);
  }

  /** `late COUNT OF`: packets within the critical part of a frame. */
  count() {
    console.log(`late ${this.late} ${this.given}`);
  }

  /** Packets to the host take their time, and a host that reads; the emulator takes each at once. */
  take() {
    const { usb } = this;
    const update = usb.DPRAMUpdated.bind(usb);
    usb.DPRAMUpdated = (offset, value) => {
      const sends = offset > 0x84 && offset <= 0xfc && !(offset & 4) && value & AVAILABLE;
      if (!sends) return update(offset, value);
      this.given++;
      if (this.plugged && this.clock.nanos - this.began > CRITICAL) this.late++;
      const packet = () => {
        // The device has sent nothing if the memory was cleared meanwhile.
        const now = usb.rp2040.usbDPRAMView.getUint32(offset, true);
        if (now & AVAILABLE) update(offset, now);
      };
      this.held.push(packet);
      this.collect();
    };
  }

  collect() {
    if (!this.reads || !this.plugged) return;
    for (const packet of this.held.splice(0)) this.clock.createAlarm(() => (this.plugged ? packet() : this.held.push(packet))).schedule(PACKET);
  }
}

/** SUSPENDED is cleared by a one (DS 4.1.4); the emulator keeps it for ever. Reading the frame's number clears DEV_SOF. */
function mend(usb) {
  const read = usb.readUint32.bind(usb);
  usb.readUint32 = (offset) => {
    if (offset === SOF_RD) {
      usb.intRaw &= ~DEV_SOF;
      usb.checkInterrupts();
    }
    return read(offset);
  };
  const write = usb.writeUint32.bind(usb);
  usb.writeUint32 = (offset, value) => {
    if (offset === SIE_STATUS && usb.rawWriteValue & SUSPENDED) usb.sieStatus &= ~SUSPENDED;
    write(offset, value);
  };
}

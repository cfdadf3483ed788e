// Where samples come from. Each source gives rows as they become due, and says in a sentence what is wrong.

/** The simulated scene, as fast as its samples would come. */
export class Simulated {
  constructor(core) {
    this.core = core;
    this.due = 1;
    const { n, rate } = core.state();
    this.block = n / rate;
  }

  advance(seconds) {
    // A page that was hidden does not catch up.
    this.due += Math.min(seconds, 0.1) / this.block;
    const blocks = Math.floor(this.due);
    this.due -= blocks;
    return this.core.simulate(blocks);
  }

  stop() {}
}

/** Particles in a laser's fringes: the burst processor's answers, and the samples around each for its spectrum. */
export class Particles {
  constructor(core, finder, sliders) {
    [this.core, this.finder, this.sliders] = [core, finder, sliders];
    [this.due, this.bursts] = [0, 0];
    this.nothing = Object.fromEntries(core.names.map((name) => [name, NaN]));
    finder.flow();
  }

  advance(seconds) {
    this.due += Math.min(seconds, 0.1) * this.core.state().rate;
    const samples = Math.floor(this.due);
    this.due -= samples;
    const { around, bursts } = this.finder.flowed(this.sliders, samples);
    if (around.length === this.core.state().n) this.core.floats(around);
    return bursts.map((burst) => ({ ...this.nothing, ...burst, block: this.bursts++, segment: 0, gap: 0, clipped: 0, also: 0, outcome_verdict: burst.verdict }));
  }

  stop() {}
}

/** A recording: as fast as it can be measured, a slice in each frame. */
export class Recording {
  constructor(core, name, contents, told, pour) {
    this.core = core;
    this.told = told;
    this.pour = pour;
    this.name = name;
    Object.assign(this, core.open(name, contents));
    this.more = !this.wrong;
    this.blocks = 0;
  }

  advance() {
    const rows = [];
    const until = performance.now() + 6;
    while (this.more && performance.now() < until) {
      // Blocks between two rows of the waterfall: the longer the recording, the more.
      const step = this.core.read(2 ** Math.min(8, Math.floor(this.blocks / 500)));
      rows.push(...step.rows);
      if (step.rows.length) this.pour(step.rows.at(-1));
      this.more = step.more;
      this.blocks += step.rows.length;
      if (!step.more) this.told(step.wrong, this.blocks);
    }
    return rows;
  }

  stop() {}
}

/** The microphone. */
export class Microphone {
  constructor(core, told) {
    this.core = core;
    this.told = told;
    this.chunks = [];
  }

  /** Asks for it; gives its sample rate, or what is wrong. */
  async listen() {
    if (!navigator.mediaDevices?.getUserMedia) return { wrong: "This browser does not give this page a microphone: open it on localhost or by https." };
    const audio = { echoCancellation: false, noiseSuppression: false, autoGainControl: false };
    try {
      this.stream = await navigator.mediaDevices.getUserMedia({ audio });
    } catch (error) {
      return { wrong: error.name === "NotFoundError" ? "There is no microphone." : "The microphone was not allowed." };
    }
    this.context = new AudioContext();
    await this.context.audioWorklet.addModule("microphone.js");
    const node = new AudioWorkletNode(this.context, "chunks", { numberOfOutputs: 0 });
    node.port.onmessage = ({ data }) => { if (this.chunks.length < 4000) this.chunks.push(data); };
    this.context.createMediaStreamSource(this.stream).connect(node);
    await this.context.resume();
    return { rate: this.context.sampleRate };
  }

  advance() {
    return this.chunks.splice(0).flatMap((chunk) => this.core.floats(chunk));
  }

  stop() {
    this.stream?.getTracks().forEach((track) => track.stop());
    this.context?.close();
  }
}

/** A board on a serial port. */
export class Board {
  constructor(core, told) {
    this.core = core;
    this.told = told;
    this.pieces = [];
    this.known = [];
    this.asked = -Infinity;
  }

  /** Asks for the port and opens it; gives what is wrong. */
  async connect() {
    if (!navigator.serial) return "This browser has no Web Serial: open the page in Chrome, Edge or Opera on a computer.";
    try {
      this.port = await navigator.serial.requestPort();
    } catch {
      return "No port was chosen.";
    }
    try {
      await this.port.open({ baudRate: 921600, bufferSize: 65536 });
    } catch {
      return "The port does not open: is another program, such as picket watch, using it?";
    }
    this.listen();
    await this.order("identify");
    await this.askSettings();
    return "";
  }

  async listen() {
    this.reader = this.port.readable.getReader();
    try {
      for (;;) {
        const { value, done } = await this.reader.read();
        if (done) break;
        this.pieces.push(value);
      }
      if (!this.stopped) this.told("The board has sent everything.");
    } catch {
      if (!this.stopped) this.told("The board is unplugged: plug it in again, and connect.");
    }
  }

  /** It may be deaf for a while: it is asked again after a second. */
  async askSettings() {
    if (performance.now() - this.asked < 1000) return;
    this.asked = performance.now();
    await this.order("settings");
  }

  async order(name, count = 1) {
    if (!this.port?.writable) return;
    const writer = this.port.writable.getWriter();
    await writer.write(this.core.order(name, count)).catch(() => {});
    writer.releaseLock();
  }

  advance() {
    const rows = [];
    for (const piece of this.pieces.splice(0)) {
      const heard = this.core.hear(piece);
      rows.push(...heard.rows);
      this.known = heard.known;
    }
    // It has started anew, or tells of another rate.
    if (this.known.some(([name]) => name === "settings")) this.askSettings();
    return rows;
  }

  async stop() {
    this.stopped = true;
    await this.reader?.cancel().catch(() => {});
    this.reader?.releaseLock();
    await this.port?.close().catch(() => {});
  }
}

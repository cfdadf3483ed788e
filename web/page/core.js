// The library, compiled to WebAssembly: numbers and bytes go in, rows of numbers and text come out.

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** Loads the module. `bytes` of it may be given, for whom has no `fetch`. */
export async function load(bytes) {
  const compiled = bytes ? await WebAssembly.compile(bytes) : await compile("picket.wasm");
  return new Core(compiled);
}

export async function compile(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
  // Not every static host names the type that streaming wants.
  return WebAssembly.compile(await answer.arrayBuffer());
}

const TRACK = ["number", "hertz", "sigma", "misses"];
const TONE = ["hertz", "sigma", "amplitude", "phase", "sigma_phase", "snr_db", "verdict"];

const TARGET = ["range_m", "sigma_range_m", "velocity_mps", "sigma_velocity_mps", "covariance", "map_m", "map_mps", "snr_db", "verdict"];

const SWING = ["amplitude_m", "sigma_m", "hertz", "sigma", "velocity_mps", "sigma_mps", "verdict"];

// A checksum in hexadecimal digits.
const digits = (sum) => BigInt.asUintN(64, sum).toString(16).padStart(16, "0");

/** Rows of numbers, one behind the other, as objects with these names. */
export function objects(numbers, names) {
  const rows = [];
  for (let at = 0; at < numbers.length; at += names.length) {
    rows.push(Object.fromEntries(names.map((name, index) => [name, numbers[at + index]])));
  }
  return rows;
}

export const tones = (numbers) => objects(numbers, TONE);

export class Core {
  constructor(module) {
    this.module = module;
    this.fresh();
    this.exports.picket_words();
    const [names, besides, ...verdicts] = this.text().split("\n");
    this.names = names.split(",");
    this.besides = besides.split(",");
    this.verdicts = verdicts.map((line) => {
      const [name, usable, reason] = line.split("\t");
      return { name, usable, reason };
    });
  }

  /** A new instance: nothing of an old one is left. */
  fresh() {
    this.exports = new WebAssembly.Instance(this.module, {}).exports;
  }

  put(...parts) {
    const length = parts.reduce((sum, part) => sum + part.length, 0);
    let at = this.exports.picket_inbox(length);
    for (const part of parts) {
      new Uint8Array(this.exports.memory.buffer, at, part.length).set(part);
      at += part.length;
    }
  }

  /** The numbers that the last call left; they are copied. */
  numbers() {
    const { picket_numbers, picket_numbers_length, memory } = this.exports;
    return new Float64Array(memory.buffer, picket_numbers(), picket_numbers_length()).slice();
  }

  bytes() {
    const { picket_text, picket_text_length, memory } = this.exports;
    return new Uint8Array(memory.buffer, picket_text(), picket_text_length()).slice();
  }

  text() {
    return decoder.decode(this.bytes());
  }

  /** The rows that the last call left, as objects with the library's names. */
  rows() {
    return objects(this.numbers(), this.names);
  }

  set(name, value) {
    this.put(encoder.encode(name));
    return this.exports.picket_set(value) !== 0;
  }

  /** Begins to measure. Returns what is wrong, or nothing. */
  start(seed = 1) {
    return this.exports.picket_start(seed) ? "" : this.text();
  }

  simulate(blocks) {
    this.exports.picket_simulate(blocks);
    return this.rows();
  }

  floats(samples) {
    this.put(new Uint8Array(samples.buffer, samples.byteOffset, samples.byteLength));
    this.exports.picket_floats();
    return this.rows();
  }

  /** Opens a file: what is wrong, or what was assumed of it. */
  open(name, contents) {
    const title = encoder.encode(name);
    this.put(title, contents);
    const opened = this.exports.picket_open(title.length) !== 0;
    return { wrong: opened ? "" : this.text(), assumed: opened ? this.text() : "" };
  }

  /** The next rows of the open file, whether there are more, and what is wrong, if anything is. */
  read(blocks) {
    const more = this.exports.picket_read(blocks) !== 0;
    return { rows: this.rows(), more, wrong: more ? "" : this.text() };
  }

  /** Hears a board's bytes: the rows in them, and what is known of the board. */
  hear(bytes) {
    this.put(bytes);
    this.exports.picket_hear();
    const known = this.text().split("\n").filter(Boolean).map((line) => line.split("\t"));
    return { rows: this.rows(), known };
  }

  order(name, count = 0) {
    this.put(encoder.encode(name));
    this.exports.picket_order(count);
    return this.bytes();
  }

  spectrum() {
    this.exports.picket_spectrum();
    const [first, step, floor, threshold, hertz, sigma, level, ...bins] = this.numbers();
    return bins.length ? { first, step, floor, threshold, hertz, sigma, level, bins } : null;
  }

  /** The map of the last frame of chirps and its targets; nothing where there is none. */
  map() {
    this.exports.picket_map();
    const numbers = this.numbers();
    if (!numbers.length) return null;
    const [frame, chirps, bins, range, rangeStep, velocity, velocityStep, shift, share, count] = numbers;
    let at = 10;
    const take = (length) => numbers.subarray(at, at += length);
    const targets = Array.from({ length: count }, () => {
      const [target] = objects(take(TARGET.length), TARGET);
      const [aliases] = take(1);
      return { ...target, aliases: objects(take(2 * aliases), ["velocity", "odds"]) };
    });
    return { frame, chirps, bins, range, rangeStep, velocity, velocityStep, shift, share, targets, decibels: numbers.subarray(at) };
  }

  /** Subtracts nothing (0), what stands still in the last frame (1), or what was subtracted before the file was opened again (2); gives that
   * frame's rows anew. */
  background(which) {
    this.exports.picket_background(which);
    return this.rows();
  }

  /** The samples that the spectrum is of, and what is known of them: for the tones' module. */
  shown() {
    this.exports.picket_shown();
    return { samples: this.bytes(), terms: this.numbers() };
  }

  /** The tones that a board told of a block. */
  told() {
    this.exports.picket_tones();
    return tones(this.numbers());
  }

  /** The fitted tone between two frequencies: [frequencies, dB]. */
  fitted(low, high, steps) {
    this.exports.picket_fitted(low, high, steps);
    const numbers = this.numbers();
    const column = (side) => Array.from(numbers.filter((_, index) => index % 2 === side));
    return [column(0), column(1)];
  }

  tracks() {
    this.exports.picket_tracks();
    return objects(this.numbers(), TRACK);
  }

  /** What swings in the displacement. */
  swings() {
    this.exports.picket_swings();
    return objects(this.numbers(), SWING);
  }

  state() {
    this.exports.picket_state();
    const [n, iq, rate, kind, full, known, speed, row, frames, follows, records = 0, missing = 0, bad = 0, raw = 0, heard = 0] = this.numbers();
    return { n, iq: iq !== 0, rate, kind, full, known: known !== 0, speed, row, frames: frames !== 0, follows: follows !== 0, records, missing, bad, raw, heard };
  }

  checksum(fixed, blocks) {
    return digits(this.exports.picket_checksum(fixed ? 1 : 0, blocks));
  }

  sceneChecksum() {
    return digits(this.exports.picket_scene_checksum());
  }
}

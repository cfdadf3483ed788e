// All tones of a block, and the tests behind its verdict. Their module is loaded when somebody asks for either.
import { compile, objects, tones } from "./core.js";
import { SIGNS, figure, rank, signed } from "./words.js";

const decoder = new TextDecoder();

export class Tones {
  constructor(module) {
    this.exports = new WebAssembly.Instance(module, {}).exports;
  }

  static async load() {
    return new Tones(await compile("tones.wasm"));
  }

  put({ samples, terms }) {
    const { memory, tones_samples, tones_terms } = this.exports;
    const at = tones_samples(samples.length / 4);
    new Uint8Array(memory.buffer, at, samples.length).set(samples);
    new Float64Array(memory.buffer, tones_terms(), terms.length).set(terms);
  }

  /** So many numbers that the last call left. */
  numbers(count) {
    return new Float64Array(this.exports.memory.buffer, this.exports.tones_numbers(), count);
  }

  /** The tones of the block that the spectrum is of, at most so many, the strongest first. */
  find(block, most) {
    if (!block.terms.length) return [];
    this.put(block);
    return tones(this.numbers(this.exports.tones_find(most)));
  }

  /** The verdict on that block and the tests behind it, in their order; nothing where there is no block. */
  explain(block) {
    if (!block.terms.length) return null;
    this.put(block);
    const numbers = this.numbers(this.exports.tones_explain());
    const [verdict, ...lines] = this.text().split("\n");
    const tests = lines.map((line, index) => {
      const [test, about, fit, unit, outcome, followed] = line.split("\t");
      return { test, about, fit, unit, outcome, followed, value: numbers[2 * index], limit: numbers[2 * index + 1] };
    });
    return { verdict, tests };
  }

  /** Begins a flow of particles. */
  flow(seed = 1) {
    this.exports.tones_flow_begin(seed);
    this.exports.tones_validations();
    this.validations = this.text().split("\n");
  }

  /** Lets it flow for so many samples: the bursts that are complete, and the samples around the last of them. */
  flowed(sliders, samples) {
    const { memory, tones_terms, tones_flow, tones_text, tones_text_length } = this.exports;
    new Float64Array(memory.buffer, tones_terms(), FLOW.length).set(FLOW.map((name) => sliders[name]));
    const count = tones_flow(samples);
    const floats = new Float32Array(memory.buffer.slice(tones_text(), tones_text() + tones_text_length()));
    const bursts = objects(this.numbers(BURST.length * count), BURST);
    return { around: floats, bursts: bursts.map((burst) => ({ ...burst, validation: this.validations[burst.validation] })) };
  }

  text() {
    const { memory, tones_text, tones_text_length } = this.exports;
    return decoder.decode(new Uint8Array(memory.buffer, tones_text(), tones_text_length()));
  }

  /** What a rate, a length and a level give: rows for every length, in words and as numbers; or why there are none. */
  design(question) {
    const { memory, tones_terms, tones_design } = this.exports;
    new Float64Array(memory.buffer, tones_terms(), ASKED.length).set(ASKED.map((name) => question[name] || 0));
    const count = tones_design();
    const text = this.text();
    if (!count) return { wrong: text };
    const lines = text.split("\n");
    const [chosen, settings, ...rest] = lines;
    const [head, ...rows] = rest.slice(0, count + 1).map((line) => line.split("\t"));
    const lengths = objects(this.numbers(LENGTH.length * count), LENGTH);
    return { chosen: chosen === "" ? -1 : Number(chosen), settings, head, rows, lengths, sentences: rest.slice(count + 1) };
  }
}

/** What a question to the design's sheet holds, in the order of `tones_design`. */
const ASKED = ["wavelength_m", "rate_hz", "n", "snr_db", "iq", "bandwidth_hz", "chirp_s", "velocity_mps", "range_m", "sigma_mps", "sigma_m"];
/** What a flow of particles is set by, in the order of `tones_flow`, and what is told of a burst. */
const FLOW = ["flow_mps", "turbulence", "particles_hz", "burst_snr_db", "level_db"];
const BURST = ["time_s", "frequency_hz", "sigma_hz", "snr_db", "amplitude_codes", "transit_s", "verdict", "velocity_mps", "sigma_velocity_mps", "truth_mps", "validation"];
const LENGTH = ["n", "block_s", "resolution_mps", "sigma_mps", "resolution_m", "sigma_m"];

/** A row of the table of tones: `full` is the amplitude of a sine from rail to rail. */
export function row(tone, full, verdicts) {
  const verdict = verdicts[tone.verdict];
  const { name, reason } = verdict;
  const level = 20 * Math.log10(tone.amplitude / full);
  const words = [
    ["frequency", figure(tone.hertz, tone.sigma).join(" \u00b1 ")],
    ["level", `${signed(level.toFixed(1))} dB`],
    ["phase", figure(tone.phase, tone.sigma_phase).join(" \u00b1 ")],
    [`said ${rank(verdict)}`, `${SIGNS[name]} ${name}`],
  ];
  const made = document.createElement("tr");
  made.title = reason;
  made.append(...words.map(([className, textContent]) => Object.assign(document.createElement("td"), { className, textContent })));
  return made;
}

const OUTCOMES = { fired: "\u2717", passed: "\u2713", "-": "\u00b7" };

/** A row of the table of tests. */
export function testRow({ test, about, fit, unit, outcome, followed, value, limit }) {
  const number = (x) => (Number.isFinite(x) ? `${signed(x.toFixed(2))} ${unit}`.trim() : "");
  const cell = (tag, className, ...parts) => {
    const made = Object.assign(document.createElement(tag), { className });
    made.append(...parts);
    return made;
  };
  const said = outcome === "-" ? "" : `${outcome}: `;
  const made = cell("tr", outcome === "-" ? "path" : outcome,
    cell("td", "about", cell("span", "", about), cell("code", "", fit ? `${test} (${fit} fit)` : test)),
    cell("td", "number", number(value)),
    cell("td", "number", number(limit)),
    cell("td", "followed", `${OUTCOMES[outcome]} ${said}${followed === "-" ? "" : followed}`.replace(/: $/, "")));
  return made;
}

// All tones of a block, and the tests behind its verdict. Their module is loaded when somebody asks for either.
import { compile, tones } from "./core.js";
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
    const { memory, tones_explain, tones_text, tones_text_length } = this.exports;
    const numbers = this.numbers(tones_explain());
    const bytes = new Uint8Array(memory.buffer, tones_text(), tones_text_length());
    const [verdict, ...lines] = decoder.decode(bytes).split("\n");
    const tests = lines.map((line, index) => {
      const [test, about, fit, unit, outcome, followed] = line.split("\t");
      return { test, about, fit, unit, outcome, followed, value: numbers[2 * index], limit: numbers[2 * index + 1] };
    });
    return { verdict, tests };
  }
}

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

// All tones of a block. The module that finds them is loaded when somebody asks for more than one.
import { compile, tones } from "./core.js";
import { SIGNS, figure, rank, signed } from "./words.js";

export class Tones {
  constructor(module) {
    this.exports = new WebAssembly.Instance(module, {}).exports;
  }

  static async load() {
    return new Tones(await compile("tones.wasm"));
  }

  /** The tones of the block that the spectrum is of, at most so many, the strongest first. */
  find({ samples, terms }, most) {
    if (!terms.length) return [];
    const { memory, tones_samples, tones_terms, tones_find, tones_numbers } = this.exports;
    const at = tones_samples(samples.length / 4);
    new Uint8Array(memory.buffer, at, samples.length).set(samples);
    new Float64Array(memory.buffer, tones_terms(), terms.length).set(terms);
    const count = tones_find(most);
    return tones(new Float64Array(memory.buffer, tones_numbers(), count));
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

// Which rate and length a radar or a laser needs: what `picket design` prints, by the same code.
import { DesignChart } from "./charts.js";
import { make } from "./controls.js";

const SPEED_OF_LIGHT = 299_792_458;
const WAVES = [["GHz", (x) => SPEED_OF_LIGHT / (x * 1e9)], ["mm", (x) => x * 1e-3], ["nm", (x) => x * 1e-9]];
const LENGTHS = ["64", "128", "256", "512", "1024", "2048", "4096"];

/** The fields: their names, what they hold at first, and how many of the library's unit one of theirs is. */
const FIELDS = [
  { name: "rate_hz", label: "Rate, Hz", hint: "as needed" },
  { name: "snr_db", label: "Signal to noise, dB", value: 10, any: true },
  { name: "velocity_mps", label: "Fastest target, m/s", value: 10 },
  { name: "sigma_mps", label: "Wanted sigma, m/s", value: 0.01, hint: "any" },
  { name: "bandwidth_hz", label: "Chirp, MHz", scale: 1e6, hint: "none" },
  { name: "chirp_s", label: "Its ramp, ms", scale: 1e-3, hint: "none" },
  { name: "range_m", label: "Farthest target, m", hint: "none" },
  { name: "sigma_m", label: "Wanted sigma, m", hint: "any" },
];

/** Digits of an axis that has one for each factor of ten. */
const round = (value) => String(Number(value.toPrecision(3)));

export class Design {
  constructor(finder) {
    this.finder = finder;
    this.place = (id) => document.getElementById(`design-${id}`);
    this.chart = new DesignChart(this.place("chart"));
    this.draw();
    this.answer();
  }

  draw() {
    const field = (name, label, ...inputs) => make("div", { className: "field" }, make("label", { htmlFor: `design-${name}`, textContent: label }), ...inputs);
    const changed = (input) => {
      input.addEventListener("input", () => this.answer());
      return input;
    };
    const number = ({ name, value = "", hint = "", any }) =>
      changed(make("input", { type: "number", id: `design-${name}`, inputMode: "decimal", step: "any", value, placeholder: hint, ...(any ? {} : { min: 0 }) }));
    const select = (name, options) =>
      changed(make("select", { id: `design-${name}` }, ...options.map(([value, text]) => make("option", { value, textContent: text }))));
    const unit = select("unit", WAVES.map(([name], index) => [index, name]));
    unit.ariaLabel = "Unit of the carrier or wavelength";
    const tick = changed(make("input", { type: "checkbox", id: "design-iq" }));
    this.place("form").replaceChildren(
      field("wave", "Radar or laser", make("div", { className: "pair" }, number({ name: "wave", value: 24.125 }), unit)),
      ...FIELDS.map((options) => field(options.name, options.label, number(options))),
      field("n", "Block", select("n", [["", "all lengths"], ...LENGTHS.map((n) => [n, `${n} samples`])])),
      field("iq", "I/Q", tick),
    );
  }

  /** What is asked, in the library's units. */
  question() {
    const value = (name) => Number(this.place(name).value) || 0;
    const wave = value("wave");
    const question = { n: value("n"), iq: Number(this.place("iq").checked), wavelength_m: wave > 0 ? WAVES[value("unit")][1](wave) : 0 };
    for (const { name, scale = 1 } of FIELDS) question[name] = value(name) * scale;
    return question;
  }

  answer() {
    const question = this.question();
    const half = (question.bandwidth_hz > 0) !== (question.chirp_s > 0);
    const wrong = !(question.wavelength_m > 0) ? "the carrier or the wavelength is missing"
      : half ? "a chirp needs a bandwidth and the duration of its ramp"
      : !question.chirp_s && (question.range_m || question.sigma_m) ? "ranges need a chirp" : "";
    const found = wrong ? { wrong } : this.finder.design(question);
    const { chosen = -1, settings = "", head = [], rows = [], lengths = [], sentences = [] } = found;
    this.place("wrong").textContent = found.wrong ? `${found.wrong[0].toUpperCase()}${found.wrong.slice(1)}.` : "";
    this.place("wrong").hidden = !found.wrong;
    this.place("sentences").replaceChildren(...sentences.map((textContent) => make("li", { textContent: `${textContent}.` })));
    this.place("chosen").hidden = !settings;
    this.place("settings").textContent = settings;
    const table = this.place("table");
    table.hidden = !rows.length;
    // What is asked for comes first, in view on a phone, too.
    const rank = (name) => (name.startsWith("sigma") ? 2 : name === "N" ? 0 : name.startsWith("block") ? 1 : 3);
    const order = head.map((_, index) => index).sort((a, b) => rank(head[a]) - rank(head[b]));
    const cellOf = (tag, cells) => (index) => {
      const made = make(tag, { textContent: cells[index] });
      made.dataset.column = index;
      return made;
    };
    table.tHead.rows[0].replaceChildren(...order.map(cellOf("th", head)).map((made) => Object.assign(made, { scope: "col" })));
    table.tBodies[0].replaceChildren(...rows.map((cells, index) => {
      const [first, ...others] = order;
      const name = Object.assign(cellOf("th", cells)(first), { scope: "row" });
      const row = make("tr", { className: index === chosen ? "chosen" : "" }, name, ...others.map(cellOf("td", cells)));
      if (index === chosen) row.firstChild.append(make("span", { textContent: " \u2713", title: "the shortest that reaches the wanted sigma" }));
      return row;
    }));
    const range = question.chirp_s > 0 && !question.velocity_mps;
    const [bin, sigma, unit] = range ? ["resolution_m", "sigma_m", "m"] : ["resolution_mps", "sigma_mps", "m/s"];
    this.place("title").textContent = `Resolution and sigma of the ${range ? "range" : "velocity"}, ${unit}, over the block's time`;
    this.chart.show(lengths.map((row) => [1e3 * row.block_s, row[bin], row[sigma]]), question[range ? "sigma_m" : "sigma_mps"], chosen);
    const first = lengths[0];
    const last = lengths.at(-1);
    if (!last) this.chart.describe("There is no answer");
    else this.chart.describe(`From ${round(1e3 * first.block_s)} to ${round(1e3 * last.block_s)} ms the bin falls from ${round(first[bin])} to ${round(last[bin])} ${unit}, and sigma from ${round(first[sigma])} to ${round(last[sigma])} ${unit}`);
  }
}

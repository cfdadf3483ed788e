// The sliders and fields: what they are called, how far they go, and the library's names for them.
import { signed, units } from "./words.js";

const OFF = -80;
const decibels = (value) => (value <= OFF ? "off" : `${signed(String(value))} dB`);
const unit = (name, places = 0) => (value) => `${signed(value.toFixed(places))} ${name}`;

/** Scenes: their settings, and the sliders that mean something in them. */
export const SCENES = [
  {
    id: "chirp", name: "FMCW radar", kind: 2,
    settings: { rate_hz: 250e3, iq: 1, mixing: 0, wavelength_m: 0.0125, bandwidth_hz: 200e6 },
    sliders: { range_m: 120, velocity_mps: 25, motion: 0.5, snr_db: -5, level_db: -20, second_db: OFF, second_off: 60 },
    second: { label: "Further off by", words: unit("m", 1), min: -100, max: 200, step: 1 },
  },
  {
    id: "doppler", name: "Doppler radar", kind: 1,
    settings: { rate_hz: 48e3, iq: 0, mixing: 1, wavelength_m: 0.0125, bandwidth_hz: 200e6 },
    sliders: { velocity_mps: 12, motion: 0.5, snr_db: 0, level_db: -16, second_db: OFF, second_off: 8 },
    second: { label: "Faster by", words: unit("m/s", 1), min: -30, max: 60, step: 0.5 },
  },
  {
    id: "tone", name: "A tone", kind: 0,
    settings: { rate_hz: 48e3, iq: 0, mixing: 0, wavelength_m: 0.0125, bandwidth_hz: 200e6 },
    sliders: { tone_hz: 1000.3, motion: 0, snr_db: 20, second_db: OFF, second_off: 400 },
    second: { label: "Higher by", words: unit("Hz"), min: -1000, max: 8000, step: 1 },
  },
  {
    id: "bursts", name: "Laser velocimeter", kind: 3,
    settings: { rate_hz: 200e3, iq: 0, mixing: 0, wavelength_m: 0.0125, bandwidth_hz: 200e6 },
    sliders: { flow_mps: 0.05, turbulence: 0.05, particles_hz: 20, burst_snr_db: 20, level_db: -14 },
  },
];

const SLIDERS = [
  { name: "flow_mps", label: "Flow", min: 0.01, max: 0.15, step: 0.005, words: unit("m/s", 3), kinds: [3] },
  { name: "turbulence", label: "Turbulence", min: 0, max: 0.3, step: 0.01, words: (value) => unit("%")(100 * value), kinds: [3] },
  { name: "particles_hz", label: "Particles", min: 1, max: 200, step: 1, words: unit("a second"), kinds: [3] },
  { name: "burst_snr_db", label: "Signal to noise", min: -5, max: 40, step: 1, words: unit("dB"), kinds: [3] },
  { name: "tone_hz", label: "Tone", min: 20, max: 23900, step: 0.1, words: unit("Hz", 1), kinds: [0] },
  { name: "range_m", label: "Range", min: 1, max: 300, step: 0.5, words: unit("m", 1), kinds: [2] },
  { name: "velocity_mps", label: "Velocity", min: -40, max: 40, step: 0.1, words: unit("m/s", 1), kinds: [1, 2] },
  { name: "motion", label: "Motion", min: 0, max: 3, step: 0.1, words: (value) => (value ? value.toFixed(1) : "still"), kinds: [0, 1, 2] },
  { name: "snr_db", label: "Signal to noise", min: -25, max: 60, step: 1, words: unit("dB"), kinds: [0, 1, 2] },
  { name: "level_db", label: "Level", min: -60, max: 20, step: 0.5, words: (value) => `${signed(value.toFixed(1))} dBFS`, kinds: [0, 1, 2, 3], value: -6 },
  { name: "dc", label: "DC offset", min: -1, max: 1, step: 0.01, words: (value) => unit("%")(100 * value), kinds: [0, 1, 2], value: 0 },
  { name: "hum_db", label: "50 Hz hum", min: OFF, max: 0, step: 1, words: decibels, kinds: [0, 1, 2], value: OFF },
  { name: "second_db", label: "Second line", min: OFF, max: 6, step: 1, words: decibels, kinds: [0, 1, 2] },
  { name: "second_off", kinds: [0, 1, 2] },
];

export function make(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function slider(options, value, changed) {
  const { name, label, min, max, step, words } = options;
  const input = make("input", { type: "range", id: name, min, max, step });
  input.value = value;
  const output = make("output", { htmlFor: name });
  const show = () => {
    output.textContent = words(Number(input.value));
    input.setAttribute("aria-valuetext", output.textContent);
  };
  show();
  input.addEventListener("input", () => { show(); changed(name, Number(input.value)); });
  return make("div", { className: "field" }, make("label", { htmlFor: name, textContent: label }), input, output);
}

/** The form of the scene. `changed` hears a slider; `chosen` hears another scene. */
export function sceneForm(form, scene, changed, chosen) {
  const select = make("select", { id: "scene" }, ...SCENES.map(({ id, name }) => make("option", { value: id, textContent: name })));
  select.value = scene.id;
  select.addEventListener("change", () => chosen(SCENES.find(({ id }) => id === select.value)));
  const first = make("div", { className: "field" }, make("label", { htmlFor: "scene", textContent: "Scene" }), select);
  const sliders = SLIDERS.filter(({ kinds }) => kinds.includes(scene.kind)).map((options) => {
    const shown = options.name === "second_off" ? { ...options, ...scene.second } : options;
    const value = scene.sliders[options.name] ?? options.value;
    changed(options.name, value);
    return slider(shown, value, changed);
  });
  form.replaceChildren(first, ...sliders);
}

const LENGTHS = [64, 128, 256, 512, 1024, 2048, 4096];
const CODES = [["12", "12 bits, signed"], ["-12", "12 bits, from 0"], ["14", "14 bits, signed"], ["16", "16 bits, signed"]];
const FILE_CODES = [16, 14, 12, 10, 8].flatMap((bits) => [[String(bits), `${bits} bits, signed`], [String(-bits), `${bits} bits, from 0`]]);

const MIXINGS = [["0", "tx-conj-rx"], ["1", "rx-conj-tx"]];
const MIXING = "Which signal an I/Q receiver conjugates. To check it, move a hand towards the antenna: if the velocity is negative, choose the other one.";

const SUMS = [["1", "each block"], ["10", "10 blocks"], ["100", "100 blocks"]];

const TONES = [["1", "the strongest"], ["2", "up to two, with phase"], ["4", "up to four, with phase"]];

const field = (name, label, ...inputs) => make("div", { className: "field" }, make("label", { htmlFor: name, textContent: label }), ...inputs);

/** What makes fields and selections of `values`, which are settings by the library's names. */
function inputs(values, changed) {
  // `scale` is one of the field's units in the library's.
  const number = (name, properties = {}, scale = 1) => {
    const input = make("input", { type: "number", id: name, inputMode: "decimal", min: 0, step: "any", ...properties });
    if (values[name]) input.value = Number((values[name] / scale).toPrecision(12));
    input.addEventListener("change", () => changed(name, Number(input.value) * scale));
    return input;
  };
  const select = (name, options, id = name) => {
    const input = make("select", { id }, ...options.map(([value, text]) => make("option", { value, textContent: text })));
    input.value = String(values[name]);
    input.addEventListener("change", () => changed(name, Number(input.value)));
    return input;
  };
  return { number, select };
}

/** In the order of the module. */
const FORMATS = ["i8", "u8", "i16", "u16", "i32", "f32", "f64", "I/Q of i8", "I/Q of u8", "I/Q of i16", "I I Q Q of i16", "I/Q of f32", "csv", "npy"];

/** What a file does not tell of itself, beside its answer. */
export function askForm(form, values, changed) {
  const { number, select } = inputs(values, changed);
  form.replaceChildren(
    field("file_rate_hz", "Rate, Hz", number("file_rate_hz", { placeholder: "as the file says" })),
    field("bits", "Codes", select("bits", FILE_CODES)),
    field("carrier_hz", "Carrier, GHz", number("carrier_hz", { placeholder: "for speeds" }, 1e9)),
    field("mixing", "Mixing", select("mixing", [["-1", "the usual one"], ...MIXINGS])),
    field("format", "Format", select("format", [["0", "as the file shows"], ...FORMATS.map((name, index) => [String(index + 1), name])])),
    make("details", { id: "ramps" }, make("summary", { textContent: "Chirps of an FMCW radar" }),
      field("file_bandwidth_hz", "Sweep, MHz", number("file_bandwidth_hz", {}, 1e6)),
      field("chirp_s", "Ramp, \u00b5s", number("chirp_s", {}, 1e-6)),
      field("period_s", "Period, \u00b5s", number("period_s", { placeholder: "one behind the other" }, 1e-6)),
      field("guard_s", "Begins at, \u00b5s", number("guard_s", { placeholder: "of the ramp" }, 1e-6)),
      field("chirps", "Chirps", select("chirps", [["0", "as many as there are"], ...[8, 16, 32, 64, 128, 256].map((count) => [String(count), `${count} a frame`])])),
      field("velocity_low_mps", "Speeds, m/s", make("div", { className: "pair" }, number("velocity_low_mps", { min: "", placeholder: "from" }), "\u2013",
        number("velocity_high_mps", { min: "", placeholder: "to", ariaLabel: "Speeds, m/s, upper end" }))),
    ),
  );
}

/** The form of the instrument: `values` are its settings by the library's names. */
export function instrumentForm(form, source, values, changed) {
  const { number, select } = inputs(values, changed);
  const tick = make("input", { type: "checkbox", id: "iq", checked: Boolean(values.iq) });
  tick.addEventListener("change", () => changed("iq", Number(tick.checked)));
  const way = make("input", { type: "checkbox", id: "displacement", checked: Boolean(values.displacement) });
  way.addEventListener("change", () => changed("displacement", Number(way.checked)));
  const parts = [
    field("n", "Block", select("n", LENGTHS.map((n) => [String(n), `${n} samples`]))),
    source === "microphone" || source === "file" ? "" : field("bits", "Codes", select("bits", CODES)),
    source === "microphone" ? "" : field("iq", "I/Q", tick),
    source === "scene" ? make("div", { className: "field", title: MIXING }, make("label", { htmlFor: "mixing", textContent: "Mixing" }), select("mixing", MIXINGS)) : "",
    source === "scene" ? make("p", { className: "quiet", id: "mixing-hint", textContent: MIXING }) : "",
    field("band_low_hz", `Band, ${units.known ? "Hz" : "cycles"}`, make("div", { className: "pair" }, number("band_low_hz", { placeholder: "from", min: "" }), "\u2013",
      number("band_high_hz", { placeholder: "to", min: "", ariaLabel: "Band, upper end" }))),
    field("sum", "Answer of", select("sum", SUMS)),
    source === "scene" || source === "file" ? field("displacement", "Displacement", way) : "",
    field("tones-most", "Tones", select("tones", TONES, "tones-most")),
    source === "file" ? field("channel", "Channel", make("div", { className: "pair" }, number("channel", { min: 1, step: 1, placeholder: "only" }), "Q",
      number("channel_q", { min: 1, step: 1, placeholder: "none", ariaLabel: "Channel of Q" }))) : "",
    source === "file" ? field("scale", "Scale", number("scale", { placeholder: "by the numbers" })) : "",
  ];
  form.replaceChildren(...parts.filter(Boolean));
}

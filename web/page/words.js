// Numbers and verdicts as people read them.

/** The digits behind the point that sigma permits: two of its own. */
export function digits(sigma) {
  if (!(sigma > 0)) return 3;
  return Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
}

/** A number and its sigma with the same digits: ["1000.198", "0.010"]. */
export function figure(value, sigma) {
  const places = digits(sigma);
  return [signed(value.toFixed(places)), sigma.toFixed(places)];
}

/** With a true minus, and no sign before zeros. */
export function signed(text) {
  return /^-[0.]*$/.test(text) ? text.slice(1) : text.replace("-", "\u2212");
}

/** A sign that is told from the others without colour. */
export const SIGNS = {
  good: "\u2713",
  moving: "\u2197",
  "near-edge": "\u25e8",
  clipped: "\u2912",
  unresolved: "\u2225",
  image: "\u21c4",
  gap: "\u2026",
  weak: "\u223f",
  ambiguous: "\u2442",
  "front-end": "\u21af",
  "no-signal": "\u2205",
  "wrong-codes": "\u2260",
  coasting: "\u21e2",
};

/** What an answer may be used for, by the library's word; of one that may be used without a thought nothing is said. */
export const USES = {
  "within sigma": "use it within its sigma",
  "without its sign": "use it without its sign",
  "as a rough value": "use it as a rough value",
  no: "do not use it",
};

/** How far a number may be trusted: use it, use it with care, do not. */
export function rank(verdict) {
  return { yes: "good", no: "bad" }[verdict.usable] ?? "care";
}

/** The digits behind the point that steps such as 25, 2.5 or 0.05 need. */
export function places(step) {
  let count = 0;
  while (count < 9 && Math.abs(step * 10 ** count - Math.round(step * 10 ** count)) > 1e-6 * step * 10 ** count) count += 1;
  return count;
}

/** What frequencies and times are in: hertz and seconds, or samples where nothing tells the rate; charts in m/s where a hertz has a speed. */
export const units = {
  known: true,
  speed: 0,
  get frequency() { return this.known ? "Hz" : "cycles per sample"; },
  get time() { return this.known ? "s" : "samples"; },
};

/** Where a frequency is in a chart. */
export const place = (hertz) => (units.speed ? hertz * units.speed : hertz);

/** A spectrum by the places of its bins, from the lowest on, and its tone. */
export function placed(spectrum) {
  if (!spectrum || !units.speed) return spectrum;
  const { first, step, hertz, sigma, bins } = spectrum;
  const last = first + step * (bins.length - 1);
  const back = units.speed < 0;
  return {
    ...spectrum, first: place(back ? last : first), step: Math.abs(place(step)), hertz: place(hertz), sigma: Math.abs(place(sigma)),
    bins: back ? bins.toReversed() : bins,
  };
}

/** Tones or tracks by their places. */
export const placedAll = (all) => all.map((one) => ({ ...one, hertz: place(one.hertz), sigma: Math.abs(place(one.sigma)) }));

/** A place with its unit, for axes that reach so far: 18.2 kHz. Cycles per sample have none. */
export function along(value, step, most) {
  if (units.speed) return `${signed(value.toFixed(places(step)))} m/s`;
  if (!units.known) return signed(value.toFixed(places(step)));
  const [scale, unit] = most >= 1e6 ? [1e6, "MHz"] : most >= 8e3 ? [1e3, "kHz"] : [1, "Hz"];
  return `${signed((value / scale).toFixed(places(step / scale)))} ${unit}`;
}

/** The note nearest to a frequency, and how far off in cents. */
export function note(value) {
  const names = ["C", "C\u266f", "D", "D\u266f", "E", "F", "F\u266f", "G", "G\u266f", "A", "A\u266f", "B"];
  const key = 69 + 12 * Math.log2(value / 440);
  const near = Math.round(key);
  return { name: `${names[((near % 12) + 12) % 12]}${Math.floor(near / 12) - 1}`, cents: 100 * (key - near) };
}

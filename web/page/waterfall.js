// Spectra over time, the newest on top, with the tracks over them.
import { colour } from "./charts.js";
import { along, units } from "./words.js";

const WIDTH = 720;
const HEIGHT = 240;

/** Cividis (Nunez, Anderton and Renslow 2018) at nine places: as bright to the colour-blind as to others. */
const SHADES = [
  [0, 32, 76], [0, 50, 110], [60, 77, 110], [93, 101, 113], [124, 123, 120], [156, 148, 117], [190, 175, 105], [225, 204, 85], [255, 233, 69],
];

function shade(share) {
  const place = Math.min(0.9999, Math.max(0, share)) * (SHADES.length - 1);
  const [low, high] = [SHADES[Math.floor(place)], SHADES[Math.floor(place) + 1]];
  return low.map((part, index) => part + (high[index] - part) * (place % 1));
}

export const TABLE = Array.from({ length: 256 }, (_, index) => shade(index / 255));

export class Waterfall {
  constructor(place) {
    this.canvas = place.querySelector("canvas");
    this.ticks = place.querySelector(".ticks");
    this.canvas.width = WIDTH;
    this.canvas.height = HEIGHT;
    this.context = this.canvas.getContext("2d");
    this.line = this.context.createImageData(WIDTH, 1);
    this.clear();
  }

  clear() {
    this.context.fillStyle = `rgb(${SHADES[0].join(",")})`;
    this.context.fillRect(0, 0, WIDTH, HEIGHT);
    this.times = [];
    this.ticks.replaceChildren();
  }

  /** A row: the spectrum, the held tracks, the time. */
  add(spectrum, tracks, time) {
    const { context, line } = this;
    context.drawImage(this.canvas, 0, 0, WIDTH, HEIGHT - 1, 0, 1, WIDTH, HEIGHT - 1);
    const { bins, floor } = spectrum;
    for (let x = 0; x < WIDTH; x += 1) {
      // The strongest of the bins of a column, or the nearest.
      const from = Math.floor(x * bins.length / WIDTH);
      const to = Math.max(from + 1, Math.floor((x + 1) * bins.length / WIDTH));
      let most = bins[from];
      for (let k = from + 1; k < to; k += 1) most = Math.max(most, bins[k]);
      const [r, g, b] = TABLE[Math.min(255, Math.max(0, Math.round((most - floor + 2) * 6)))];
      line.data.set([r, g, b, 255], 4 * x);
    }
    context.putImageData(line, 0, 0);
    const span = spectrum.step * (bins.length - bins.length % 2);
    context.fillStyle = colour("track");
    for (const track of tracks) {
      const x = (track.hertz - spectrum.first) / span * WIDTH;
      if (track.misses === 0) context.fillRect(Math.round(x) - 1, 0, 3, 1);
    }
    this.times.unshift(time);
    this.times.length = Math.min(this.times.length, HEIGHT);
    this.label(spectrum.first, span);
  }

  /** What is there fills the picture: of a short recording that has ended. */
  fill() {
    const rows = this.times.length;
    if (!rows || rows >= HEIGHT) return;
    this.context.imageSmoothingEnabled = false;
    this.context.drawImage(this.canvas, 0, 0, WIDTH, rows, 0, 0, WIDTH, HEIGHT);
    const times = this.times;
    this.times = Array.from({ length: HEIGHT }, (_, row) => times[Math.floor(row * rows / HEIGHT)]);
    this.label(...this.span);
  }

  label(first, span) {
    this.span = [first, span];
    const tags = [];
    const most = Math.max(Math.abs(first), first + span);
    const unit = !units.known ? span / 4 : units.speed ? 10 ** Math.floor(Math.log10(span / 40)) : most >= 8e3 ? 1e3 : 1;
    for (let place = 0; place <= 4; place += 1) {
      const name = ["x", place === 4 ? "last" : ""].join(" ").trim();
      tags.push([name, `left:${25 * place}%`, along(Math.round((first + span * place / 4) / unit) * unit, unit, most)]);
    }
    for (const row of [60, 120, 180]) {
      const past = this.times[0] - this.times[row];
      if (past > 0) tags.push(["t", `top:${row / HEIGHT * 90}%`, units.known ? `${past.toFixed(1)} s ago` : `${past.toFixed(0)} samples ago`]);
    }
    const words = JSON.stringify(tags);
    if (words === this.words) return;
    this.words = words;
    this.ticks.replaceChildren(...tags.map(([name, style, text]) => {
      const tag = document.createElement("li");
      tag.className = name;
      tag.style.cssText = style;
      tag.textContent = text;
      return tag;
    }));
  }
}

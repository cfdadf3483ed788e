// The map of a frame of chirps, velocity over range, with the targets' sigmas as ellipses.
import { colour } from "./charts.js";
import { make } from "./controls.js";
import { SIGNS, figure, places, rank, signed } from "./words.js";
import { TABLE } from "./waterfall.js";

/** An ellipse's longer half is at least so many pixels, magnified by a power of ten where sigma is less. */
const VISIBLE = 7;

/** A step of 1, 2 or 5 that divides a span into about so many parts. */
function stepOf(span, parts) {
  const power = 10 ** Math.floor(Math.log10(span / parts));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= span / parts);
}

/** The half axes of one sigma in pixels and the angle of the longer one. */
function ellipse({ sigma_range_m, sigma_velocity_mps, covariance }, across, up) {
  const [x, y, both] = [(sigma_range_m * across) ** 2, (sigma_velocity_mps * up) ** 2, -covariance * across * up];
  const [middle, reach] = [(x + y) / 2, Math.hypot((x - y) / 2, both)];
  return { a: Math.sqrt(middle + reach), b: Math.sqrt(Math.max(0, middle - reach)), angle: 0.5 * Math.atan2(2 * both, x - y) };
}

export class FrameMap {
  constructor() {
    const $ = (id) => document.getElementById(id);
    [this.box, this.title, this.key, this.table, this.button, this.said] = ["map", "map-title", "map-key", "targets", "background", "background-said"].map($);
    this.canvas = this.box.querySelector("canvas");
    new ResizeObserver(() => this.map && this.draw()).observe(this.box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.map && this.draw());
  }

  clear() {
    this.map = null;
    this.button.hidden = true;
    this.said.textContent = "";
    this.box.querySelectorAll(".label").forEach((label) => label.remove());
    this.canvas.getContext("2d").clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.table.tBodies[0].replaceChildren();
  }

  show(map, verdicts) {
    [this.map, this.verdicts] = [map, verdicts];
    this.draw();
    this.say();
    this.list();
  }

  draw() {
    const { chirps, bins, range, rangeStep, velocity, velocityStep, shift, decibels, targets } = this.map;
    const ratio = devicePixelRatio;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    [this.canvas.width, this.canvas.height] = [width * ratio, height * ratio];
    const ends = [range - rangeStep / 2, range + rangeStep * (bins - 0.5)].sort((a, b) => a - b);
    const spans = [velocity - velocityStep / 2, velocity + velocityStep * (chirps - 0.5)].sort((a, b) => a - b);
    const [across, up] = [width / (ends[1] - ends[0]), height / (spans[1] - spans[0])];
    const x = (metres) => (metres - ends[0]) * across;
    const y = (speed) => (spans[1] - speed) * up;
    const sorted = Float64Array.from(decibels).sort();
    const [floor, top] = [sorted[sorted.length >> 1], sorted.at(-1)];
    // A line of the picture for each velocity, moved by what this one adds to the range.
    const line = new OffscreenCanvas(bins, 1);
    const inside = line.getContext("2d");
    const context = this.canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.imageSmoothingEnabled = false;
    context.fillStyle = `rgb(${TABLE[0].join(",")})`;
    context.fillRect(0, 0, width, height);
    const image = inside.createImageData(bins, 1);
    for (let row = 0; row < chirps && decibels.length; row += 1) {
      for (let bin = 0; bin < bins; bin += 1) {
        const share = (decibels[row * bins + bin] - floor + 3) / Math.max(20, top - floor + 3);
        const place = rangeStep > 0 ? bin : bins - 1 - bin;
        image.data.set([...TABLE[Math.min(255, Math.max(0, Math.round(255 * share)))], 255], 4 * place);
      }
      inside.putImageData(image, 0, 0);
      const speed = velocity + row * velocityStep;
      const [upper, lower] = [y(speed + Math.abs(velocityStep) / 2), y(speed - Math.abs(velocityStep) / 2)];
      context.drawImage(line, x(ends[0] + shift * speed), upper, width, lower - upper + 0.5);
    }
    const shapes = targets.map((target) => ellipse(target, across, up)).filter(({ a }) => a > 0);
    const least = Math.max(...shapes.map(({ a }) => a), 0);
    const factor = least > 0 && least < VISIBLE ? 10 ** Math.ceil(Math.log10(VISIBLE / least)) : 1;
    const labels = [];
    targets.forEach((target, index) => {
      const [left, high] = [x(target.map_m), y(target.map_mps)];
      const { a, b, angle } = ellipse(target, across, up);
      context.setLineDash(this.verdicts[target.verdict].name === "good" ? [] : [4, 3]);
      context.beginPath();
      context.ellipse(left, high, Math.min(a * factor, 4 * width), Math.min(b * factor, 4 * width), angle, 0, 2 * Math.PI);
      context.moveTo(left - 3, high);
      context.lineTo(left + 3, high);
      context.moveTo(left, high - 3);
      context.lineTo(left, high + 3);
      // Dark below, so that it stands out of bright cells, too.
      for (const [style, thick] of [["#000c", 5], [colour("track"), 2]]) {
        [context.strokeStyle, context.lineWidth] = [style, thick];
        context.stroke();
      }
      labels.push(["label target", left + 10, high - 12, String(index + 1)]);
    });
    const ticks = (low, high, parts, put) => {
      const step = stepOf(high - low, parts);
      for (let value = Math.ceil(low / step) * step; value <= high; value += step) put(value, signed(value.toFixed(places(step))));
    };
    ticks(...ends, width / 60, (value, text) => labels.push(["label x", x(value), height + 7, `${text} m`]));
    ticks(...spans, height / 44, (value, text) => labels.push(["label y", -7, y(value), `${text} m/s`]));
    this.box.querySelectorAll(".label").forEach((label) => label.remove());
    const { offsetLeft, offsetTop } = this.canvas;
    for (const [className, left, high, textContent] of labels) {
      const label = make("span", { className, textContent });
      [label.style.left, label.style.top] = [`${offsetLeft + left}px`, `${offsetTop + high}px`];
      this.box.append(label);
    }
    this.title.textContent = `Range and velocity, frame ${this.map.frame}`;
    const count = `${targets.length} target${targets.length === 1 ? "" : "s"}`;
    this.key.textContent = factor > 1 ? `\u00b1 sigma, drawn ${factor.toLocaleString("en-GB")} times as large` : "\u00b1 sigma";
    this.canvas.setAttribute("aria-label", `Map of velocity over range, ${count}, which are listed below`);
  }

  /** What is subtracted. A mean over chirps of noise alone has a share of one by their number: of twice that, half is noise. */
  say() {
    const { share, chirps, decibels } = this.map;
    const on = Number.isFinite(share);
    const percent = (part) => `${(100 * part).toFixed(1)} %`;
    const little = share < 2 / chirps ? ` Noise alone would have ${percent(1 / chirps)}: there is little to subtract.` : "";
    const words = on ? `Less the background of frame ${this.recorded}, ${percent(share)} of its power.${little}` : "";
    if (this.said.textContent !== words) this.said.textContent = words;
    this.button.hidden = !decibels.length;
    this.button.setAttribute("aria-pressed", on);
  }

  list() {
    const cell = (name, className, textContent) => make(name, { className, textContent });
    this.table.tBodies[0].replaceChildren(...this.map.targets.map((target, index) => {
      const verdict = this.verdicts[target.verdict];
      const both = (value, sigma) => figure(value, sigma).join(" \u00b1 ");
      const aliases = target.aliases.map(({ velocity, odds }) => `${signed(velocity.toFixed(2))} (${odds > 0.1 ? Math.round(100 * odds) : (100 * odds).toPrecision(2)} %)`);
      const row = make("tr", { title: verdict.reason },
        Object.assign(cell("th", "", String(index + 1)), { scope: "row" }),
        cell("td", "number", both(target.range_m, target.sigma_range_m)),
        cell("td", "number", both(target.velocity_mps, target.sigma_velocity_mps)),
        cell("td", "number", signed(target.snr_db.toFixed(1))),
        cell("td", `said ${rank(verdict)}`, `${SIGNS[verdict.name]} ${verdict.name}`),
        cell("td", "", aliases.join(", ") || "none"));
      return row;
    }));
  }
}

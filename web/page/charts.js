// Charts by uPlot. Their labels are text of the page, so that they can be read out, enlarged and copied.
import { along, place, places, signed, units } from "./words.js";

/* global uPlot */

export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Writes the labels of a chart's axes beside it. */
function label(chart) {
  const ratio = devicePixelRatio;
  const spare = new Map([...chart.root.querySelectorAll(".label")].map((old) => [old.dataset.key, old]));
  chart.axes.forEach((axis, index) => {
    const scale = chart.scales[axis.scale];
    const splits = (axis._splits ?? []).filter((value) => value >= scale.min && value <= scale.max);
    const all = axis._splits ?? [];
    const step = all.length > 1 ? all[1] - all[0] : Math.abs(all[0] ?? 0);
    const most = Math.max(Math.abs(scale.min), Math.abs(scale.max));
    for (const value of splits) {
      const text = axis.words(value, step, most);
      if (!text) continue;
      const key = `${index} ${text}`;
      const tag = spare.get(key) ?? chart.root.appendChild(document.createElement("span"));
      spare.delete(key);
      tag.dataset.key = key;
      if (tag.textContent !== text) tag.textContent = text;
      const at = chart.valToPos(value, axis.scale);
      const { left, top, height } = chart.bbox;
      if (index === 0) {
        tag.className = "label x";
        tag.style.left = `${left / ratio + at}px`;
        tag.style.top = `${(top + height) / ratio + 7}px`;
      } else {
        tag.className = "label y";
        tag.style.left = `${left / ratio - 7}px`;
        tag.style.top = `${top / ratio + at}px`;
      }
    }
  });
  spare.forEach((old) => old.remove());
}

const plain = (value, step) => signed(value.toFixed(places(step)));

/** A length in the unit that suits the axis. */
export function length(value, step, most) {
  const [scale, unit] = most < 1e-3 ? [1e6, "\u00b5m"] : most < 1 ? [1e3, "mm"] : [1, "m"];
  return `${plain(value * scale, step * scale)} ${unit}`;
}

function axes(words, left) {
  const grid = { stroke: colour("rule"), width: 1 };
  const silent = { values: (_, splits) => splits.map(() => ""), grid, ticks: { show: false } };
  const [x, y] = words;
  return [
    { ...silent, scale: "x", size: 24, space: 90, words: x },
    { ...silent, scale: "y", size: left, space: 34, words: y },
  ];
}

/** A chart in its place, as wide and high as that; made anew when the colours change. */
class Chart {
  constructor(box, name, options) {
    this.box = box;
    this.name = name;
    this.options = options;
    this.data = null;
    this.make();
    new ResizeObserver(() => this.fit()).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.make());
  }

  make() {
    this.chart?.destroy();
    const { clientWidth: width, clientHeight: height } = this.box;
    const options = this.options();
    this.chart = new uPlot({
      width: width || 300,
      height: height || 200,
      legend: { show: false },
      cursor: { show: false },
      ...options,
      hooks: { drawAxes: [label], ...options.hooks },
    }, this.data ?? options.series.map(() => []), this.box);
    this.describe(this.name);
  }

  /** What the picture shows, for whom it is read out. Its labels are text beside it. */
  describe(name) {
    this.name = name;
    const picture = this.chart.root.querySelector("canvas");
    picture.setAttribute("role", "img");
    picture.setAttribute("aria-label", name);
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (width && height) this.chart.setSize({ width, height });
  }

  set(data) {
    this.data = data;
    this.chart.setData(data);
    this.empty("");
  }

  /** Words in the place of a picture. */
  empty(words) {
    let tag = this.box.querySelector(".empty");
    if (!words) return void tag?.remove();
    tag ??= this.box.appendChild(Object.assign(document.createElement("p"), { className: "empty" }));
    if (tag.textContent !== words) {
      tag.textContent = words;
      this.chart.setData(this.chart.series.map(() => []));
    }
  }
}

/** A vertical band about the tone, at least two pixels wide. */
function sigma(chart, { hertz: at, sigma: width }, fill) {
  const { ctx, bbox } = chart;
  const [low, high] = [at - width, at + width].map((value) => chart.valToPos(value, "x", true));
  const thick = Math.max(high - low, 2 * devicePixelRatio);
  const left = (low + high - thick) / 2;
  if (left + thick < bbox.left || left > bbox.left + bbox.width) return;
  ctx.save();
  ctx.fillStyle = fill;
  ctx.fillRect(left, bbox.top, thick, bbox.height);
  ctx.restore();
}

export class SpectrumChart extends Chart {
  constructor(box) {
    let shown = [];
    const view = { low: -130, high: 5 };
    super(box, "Spectrum of the block", () => ({
      scales: { x: { time: false }, y: { range: () => [view.low, view.high] } },
      axes: axes([along, (value) => `${plain(value, 1)} dB`], 58),
      series: [
        {},
        { stroke: colour("line"), width: 1.5, points: { show: false } },
        { stroke: colour("floor"), width: 1.5, dash: [7, 5], points: { show: false } },
        { stroke: colour("threshold"), width: 1.5, dash: [2, 4], points: { show: false } },
      ],
      hooks: { drawSeries: [(chart, index) => index === 1 && shown.forEach((tone) => sigma(chart, tone, `${colour("fit")}99`))] },
    }));
    // All tones of the block, or the one that is measured.
    this.show = (spectrum, tone, tones) => {
      // The scale follows the floor and the highest bin in steps, so that it does not flicker.
      const top = Math.max(spectrum.threshold, ...spectrum.bins) + 3;
      if (top > view.high || top < view.high - 16) view.high = Math.ceil((top + 4) / 10) * 10;
      if (Math.abs(spectrum.floor - 25 - view.low) > 8) view.low = Math.round((spectrum.floor - 25) / 10) * 10;
      shown = tones.length ? tones : tone ? [spectrum] : [];
      const x = spectrum.bins.map((_, index) => spectrum.first + index * spectrum.step);
      const ends = (value) => x.map((_, index) => (index === 0 || index === x.length - 1 ? value : undefined));
      this.set([x, spectrum.bins, ends(spectrum.floor), ends(spectrum.threshold)].map((column, index) =>
        index < 2 ? column : column.map((value) => (value === undefined ? null : value))));
    };
    // Two points make a level.
    this.options = ((options) => () => {
      const made = options();
      made.series.slice(2).forEach((series) => { series.spanGaps = true; });
      return made;
    })(this.options);
    this.make();
  }
}

export class ZoomChart extends Chart {
  constructor(box) {
    let shown = null;
    let range = [-100, 0];
    super(box, "Bins around the tone, and the tone that was fitted to them", () => ({
      scales: { x: { time: false }, y: { range: () => range } },
      axes: axes([along, (value) => `${plain(value, 1)} dB`], 58),
      series: [
        {},
        { stroke: colour("fit"), width: 2, points: { show: false }, spanGaps: true },
        { stroke: colour("line"), width: 0, points: { show: true, size: 8, fill: colour("line"), width: 0 }, paths: () => null },
        { stroke: colour("floor"), width: 1.5, dash: [7, 5], points: { show: false }, spanGaps: true },
      ],
      hooks: { drawSeries: [(chart, index) => index === 1 && shown && sigma(chart, shown, `${colour("line")}66`)] },
    }));
    this.show = (core, spectrum) => {
      shown = spectrum;
      const reach = 7 * spectrum.step;
      const [low, high] = [spectrum.hertz - reach, spectrum.hertz + reach];
      const hertz = (at) => at / place(1);
      const [at, level] = core.fitted(hertz(low), hertz(high), 280);
      const fitted = [at.map(place), level];
      const first = Math.max(0, Math.ceil((low - spectrum.first) / spectrum.step));
      const last = Math.min(spectrum.bins.length - 1, Math.floor((high - spectrum.first) / spectrum.step));
      const places = Array.from({ length: Math.max(0, last - first + 1) }, (_, index) => first + index);
      const bins = [places.map((k) => spectrum.first + k * spectrum.step), places.map((k) => spectrum.bins[k])];
      const bottom = Math.min(spectrum.floor - 10, spectrum.level - 30);
      const next = [Math.floor(bottom / 10) * 10, Math.ceil((spectrum.level + 3) / 10) * 10];
      if (Math.abs(next[0] - range[0]) >= 10 || next[1] !== range[1]) range = next;
      this.set(uPlot.join([fitted, bins, [[low, high], [spectrum.floor, spectrum.floor]]]));
    };
  }
}

/** Bin and sigma of each length over the time of its block, and the wanted sigma; both scales have factors of ten. */
export class DesignChart extends Chart {
  constructor(box) {
    const powers = (value) => (Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9 ? signed(String(Number(value.toPrecision(1)))) : "");
    let chosen = -1;
    super(box, "Resolution and sigma of each length", () => {
      const points = { show: true, size: 8 };
      const made = axes([(value) => powers(value) && `${powers(value)} ms`, powers], 74);
      // Between two powers of ten are eight lines, which have no words.
      made.forEach((axis) => { axis.space = 24; axis.filter = undefined; });
      return {
        scales: { x: { time: false, distr: 3 }, y: { distr: 3 } },
        axes: made,
        series: [
          {},
          { stroke: colour("line"), width: 1.5, points: { ...points, fill: colour("line") } },
          { stroke: colour("fit"), width: 2, points: { ...points, fill: colour("fit") } },
          { stroke: colour("truth"), width: 1.5, dash: [6, 4], points: { show: false } },
        ],
        hooks: {
          draw: [(chart) => {
            const [x, y] = [chart.data[0][chosen], chart.data[2][chosen]];
            if (!(x > 0)) return;
            const { ctx } = chart;
            ctx.save();
            ctx.setLineDash([]);
            ctx.strokeStyle = colour("fit");
            ctx.lineWidth = 2 * devicePixelRatio;
            ctx.beginPath();
            ctx.arc(chart.valToPos(x, "x", true), chart.valToPos(y, "y", true), 9 * devicePixelRatio, 0, 2 * Math.PI);
            ctx.stroke();
            ctx.restore();
          }],
        },
      };
    });
    this.show = (rows, wanted, index) => {
      chosen = index;
      if (!rows.length) return this.empty("There is no answer.");
      const columns = [0, 1, 2].map((column) => rows.map((row) => row[column]));
      this.set([...columns, rows.map(() => (wanted > 0 ? wanted : null))]);
    };
  }
}

/** A quantity over time with its sigma as a band, and the truth where it is known. */
export class TimeChart extends Chart {
  constructor(box, words = plain) {
    const view = { low: 0, high: 1 };
    super(box, "The answer over time, with sigma", () => ({
      scales: { x: { time: false }, y: { range: () => [view.low, view.high] } },
      axes: axes([(value, step) => `${plain(value, step)}${units.known ? " s" : ""}`, words], 74),
      series: [
        {},
        { stroke: "transparent", points: { show: false } },
        { stroke: "transparent", points: { show: false } },
        { stroke: colour("truth"), width: 1.5, dash: [6, 4], points: { show: false } },
        { stroke: colour("line"), width: 1.5, points: { show: false } },
      ],
      bands: [{ series: [2, 1], fill: colour("band") }],
    }));
    this.view = view;
    this.points = [[], [], [], [], []];
  }

  clear() {
    this.points = [[], [], [], [], []];
    this.set(this.points);
  }

  add(time, value, sigma, truth, most) {
    const usable = Number.isFinite(value) && Number.isFinite(sigma);
    const row = usable ? [time, value - sigma, value + sigma, truth, value] : [time, null, null, null, null];
    if (this.points[0].length && time <= this.points[0].at(-1)) this.points = [[], [], [], [], []];
    row.forEach((number, index) => {
      this.points[index].push(Number.isNaN(number) ? null : number);
      if (this.points[index].length > most) this.points[index].splice(0, this.points[index].length - most);
    });
  }

  /** Takes the newest point back. */
  back() {
    this.points.forEach((column) => column.pop());
  }

  show() {
    const [, low, high, truth] = this.points;
    // Outliers that a verdict flags do not set the scale: nine tenths of the points do.
    const usual = (column, share) => {
      const sorted = column.filter((value) => value !== null).sort((a, b) => a - b);
      return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
    };
    let bottom = Math.min(usual(low, 0.02) ?? 0, usual(truth, 0) ?? Infinity);
    let top = Math.max(usual(high, 0.98) ?? 1, usual(truth, 1) ?? -Infinity);
    const widest = (usual(high.map((value, index) => (value === null ? null : value - low[index])), 0.5) ?? 0) * 3;
    const middle = (bottom + top) / 2;
    const half = Math.max((top - bottom) / 2 * 1.12, widest, Math.abs(middle) * 1e-9, 1e-9);
    [this.view.low, this.view.high] = [middle - half, middle + half];
    this.set(this.points);
  }
}

// Answers as files: a table, JSON lines as `picket analyze --json` prints them, a picture.

function offer(name, contents, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(contents instanceof Blob ? contents : new Blob([contents], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** What applies beside a verdict: a bit each, the most severe first. */
const besides = (core, bits) => core.besides.filter((_, place) => (bits >> (core.besides.length - 1 - place)) & 1);

const finite = (value) => (Number.isFinite(value) ? value : null);

export function table(core, rows) {
  const { names, verdicts } = core;
  const said = (name, value) => {
    if (name === "also") return besides(core, value).join(" ");
    return name.endsWith("verdict") ? verdicts[value]?.name ?? "" : finite(value) ?? "";
  };
  const lines = rows.map((row) => names.map((name) => said(name, row[name])).join(","));
  offer("picket.csv", [names.join(","), ...lines, ""].join("\n"), "text/csv");
}

/** The targets of frames, by the names that `picket analyze --json` has for them. */
function frameLines(core, rows) {
  const names = ["range_m", "sigma_range_m", "velocity_mps", "sigma_velocity_mps", "snr_db"];
  const line = (row) => ({ frame: row.block, chirp: row.clock, ...Object.fromEntries(names.map((name) => [name, finite(row[name])])), verdict: core.verdicts[row.outcome_verdict].name });
  return rows.map((row) => `${JSON.stringify(line(row))}\n`).join("");
}

export function jsonLines(core, rows) {
  const { iq, speed, frames, known } = core.state();
  if (frames) return offer("picket.jsonl", frameLines(core, rows), "application/x-ndjson");
  const lines = rows.map((row) => JSON.stringify({
    block: row.block,
    ...(known ? { time_s: finite(row.time_s) } : {}),
    method: iq ? "least-squares" : "least-squares-real",
    bins: finite(row.bins),
    frequency_hz: known ? finite(row.frequency_hz) : null,
    sigma_hz: known ? finite(row.sigma_hz) : null,
    ...(known ? {} : { cycles_per_sample: finite(row.frequency_hz), sigma_cycles_per_sample: finite(row.sigma_hz) }),
    sigma_bins: finite(row.sigma_bins),
    snr_db: finite(row.snr_db),
    verdict: core.verdicts[row.verdict].name,
    ...(speed ? { speed_mps: finite(row.frequency_hz * speed), sigma_speed_mps: finite(row.sigma_hz * Math.abs(speed)) } : {}),
    ...(row.also ? { also: besides(core, row.also) } : {}),
  }));
  lines.push(JSON.stringify({ summary: true, blocks: rows.length }));
  offer("picket.jsonl", `${lines.join("\n")}\n`, "application/x-ndjson");
}

/** Draws the page's answer and charts, and the text over them. */
export async function picture() {
  const main = document.querySelector("main");
  const frame = main.getBoundingClientRect();
  const ratio = Math.max(2, devicePixelRatio);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [frame.width * ratio, frame.height * ratio];
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.translate(-frame.left, -frame.top);
  const ground = (element) => {
    const { backgroundColor } = getComputedStyle(element);
    const { left, top, width, height } = element.getBoundingClientRect();
    context.fillStyle = backgroundColor;
    context.fillRect(left, top, width, height);
  };
  ground(document.body);
  const parts = main.querySelectorAll("figure, #answer, #verdict");
  for (const part of parts) if (part.checkVisibility()) ground(part);
  for (const drawn of main.querySelectorAll("figure canvas")) {
    const { left, top, width, height } = drawn.getBoundingClientRect();
    if (width && height) context.drawImage(drawn, left, top, width, height);
  }
  for (const item of main.querySelectorAll(".key li")) {
    if (!item.checkVisibility()) continue;
    const mark = getComputedStyle(item, "::before");
    const { left, top, height } = item.getBoundingClientRect();
    const thick = Math.max(parseFloat(mark.borderTopWidth), parseFloat(mark.height));
    context.fillStyle = parseFloat(mark.borderTopWidth) > 0 ? mark.borderTopColor : mark.backgroundColor;
    const dashes = { dashed: [5, 3], dotted: [2, 2] }[mark.borderTopStyle] ?? [parseFloat(mark.width), 1];
    for (let at = 0; at < parseFloat(mark.width); at += dashes[0] + dashes[1]) {
      context.fillRect(left + at, top + height / 2 - thick / 2, dashes[0], thick);
    }
  }
  const texts = document.createTreeWalker(main, NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  while (texts.nextNode()) {
    const node = texts.currentNode;
    const element = node.parentElement;
    if (!element.closest("figure, #answer") || !node.data.trim() || !element.checkVisibility()) continue;
    const style = getComputedStyle(element);
    context.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    context.fillStyle = style.color;
    context.textBaseline = "middle";
    // Lines that the page has broken are broken here, too.
    const words = node.data.split(/(?<=\s)/);
    let at = 0;
    for (const word of words) {
      range.setStart(node, at);
      range.setEnd(node, at += word.length);
      const { left, top, height } = range.getBoundingClientRect();
      if (height) context.fillText(word.trimEnd(), left, top + height / 2);
    }
  }
  offer("picket.png", await new Promise((done) => canvas.toBlob(done, "image/png")));
}

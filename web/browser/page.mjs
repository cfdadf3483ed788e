// What the page does, as a test sees it: node page.mjs BROWSER ADDRESS INPUTS
// INPUTS is a folder of recordings and sessions. Each scenario prints one line of JSON.
import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { DESKTOP, PHONE, launch, open, rest, slide } from "./browser.mjs";

const [inputs] = rest;
const tell = (name, said) => console.log(JSON.stringify({ name, ...said }));
const input = (name) => readFileSync(join(inputs, name));

/** The words of the answer, as they stand at one moment. */
const answer = (page) => page.evaluate(() => {
  const text = (selector, within = document) => within.querySelector(selector)?.textContent ?? "";
  const figures = [...document.querySelectorAll("#figures .figure")].map((box) => ({
    name: text(".name", box), value: text(".value", box), unit: text(".unit", box), sigma: text(".sigma", box),
  }));
  const counters = [...document.querySelectorAll("#counters dd")].map((tag) => [tag.dataset.counter, tag.textContent]);
  return {
    figures, truth: text("#truth"), word: text("#word"), reason: text("#reason"),
    notice: document.querySelector("#notice").hidden ? "" : text("#notice"), counters: Object.fromEntries(counters),
  };
});

/** Waits until the page has drawn all that it has: its digits change five times a second. */
async function drawn(page) {
  await page.waitForTimeout(300);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** The answer as soon as it is as wanted, or what it is in the end. */
async function until(page, wanted) {
  for (let tries = 0; tries < 40; tries += 1) {
    const said = await answer(page);
    if (wanted(said)) return said;
    await page.waitForTimeout(250);
  }
  return answer(page);
}

/** The rows of the table of tones, each the words of its cells. */
const tones = (page) => page.evaluate(() => {
  const table = document.querySelector("#tones");
  return table.hidden ? [] : [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent));
});

async function readings(page, count) {
  const seen = [];
  let last = "";
  for (let tries = 0; seen.length < count && tries < 40 * count; tries += 1) {
    const said = await answer(page);
    const words = JSON.stringify(said.figures);
    if (words !== last && said.figures.length) seen.push(said);
    last = words;
    await page.waitForTimeout(50);
  }
  return seen;
}

/** What a press makes the page save. */
async function saved(page, button) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(`#${button}`)]);
  return readFileSync(await download.path());
}

async function measured(page) {
  await page.waitForFunction(() => / (blocks|targets) measured$|^Nothing/.test(document.querySelector("#file-name").textContent));
  await drawn(page);
}

/** Acts, and waits for what is measured then: what was measured before is not read again. */
async function measuredAfter(page, act) {
  await page.evaluate(() => { document.querySelector("#file-name").textContent = ""; });
  await act();
  await measured(page);
}

/** Drops a file on the page as a person does; it may have another name there. */
const drop = (page, name, title = name) => page.evaluate(([title, base64]) => {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], title));
  document.querySelector("main").dispatchEvent(new DragEvent("drop", { bubbles: true, cancelable: true, dataTransfer }));
}, [title, input(name).toString("base64")]);

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** What hinders people with a screen reader, a keyboard or weak eyes, by the rules of axe: in the light and in the dark. */
async function hindrances(page, place) {
  const found = [];
  await page.evaluate(AXE);
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    await drawn(page);
    // Colours that still change are none of the page's.
    await page.evaluate(() => Promise.allSettled(document.getAnimations().map(({ finished }) => finished)));
    const { violations, passes } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
    const rows = violations.map(({ id, nodes }) => [id, nodes.map(({ target, failureSummary }) => `${target}: ${failureSummary}`)]);
    found.push({ place, colorScheme, rules: passes.length, violations: rows });
  }
  return found;
}

/** A serial port that plays these bytes in pieces and keeps what is written. */
const serial = (bytes) => (page) => page.addInitScript((base64) => {
  const played = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  window.written = [];
  const port = {
    async open({ baudRate }) {
      window.baud = baudRate;
      let at = 0;
      port.readable = new ReadableStream({
        async pull(controller) {
          await new Promise((done) => setTimeout(done, 5));
          window.played = at >= played.length;
          if (window.played) return new Promise(() => {});
          controller.enqueue(played.slice(at, at += 97));
        },
      });
      port.writable = new WritableStream({ write(chunk) { window.written.push(...chunk); } });
    },
    async close() {},
  };
  Object.defineProperty(navigator, "serial", { value: { requestPort: async () => port } });
}, bytes.toString("base64"));

const browser = await launch();

async function scenes() {
  const begun = performance.now();
  const { page, errors, context } = await open(browser);
  const first = performance.now() - begun;
  const seen = { chirp: await readings(page, 16) };
  const ratio = Number(await page.locator("#frame").getAttribute("data-ratio"));
  const frame = await page.locator("#frame").textContent();
  for (const scene of ["doppler", "tone"]) {
    await page.selectOption("#scene", scene);
    seen[scene] = await readings(page, 8);
  }
  await slide(page, "level_db", 6);
  // The tracks of before take some blocks to give way.
  const clipped = await until(page, ({ word }) => word === "clipped");
  await slide(page, "level_db", -6);
  await slide(page, "snr_db", -25);
  const weak = await until(page, ({ word }) => word === "weak" || word === "no-signal");
  tell("scenes", { errors, first, seen, ratio, frame, clipped, weak });
  await context.close();
}

/** Particles in a laser's fringes: the answers of the burst processor. */
async function bursts() {
  const { page, errors, context } = await open(browser);
  await page.selectOption("#scene", "bursts");
  await until(page, ({ figures }) => figures.some(({ name }) => name.startsWith("Burst, ")));
  const seen = await readings(page, 12);
  const instrument = await page.locator("#instrument").isVisible();
  const found = await hindrances(page, "bursts");
  await page.click("#verdict");
  const { notice } = await until(page, (said) => said.notice);
  // Another scene takes its place.
  await page.selectOption("#scene", "tone");
  const after = await until(page, ({ word, figures }) => word === "good" && figures[0]?.name === "Frequency");
  tell("bursts", { errors, seen, instrument, found, told: notice, after });
  await context.close();
}

/** A chirp and a tone by blocks of each length. */
async function lengths() {
  const { page, errors, context } = await open(browser);
  const seen = { chirp: [], tone: [] };
  const offered = await page.evaluate(() => [...document.querySelectorAll("#n option")].map(({ value }) => Number(value)));
  for (const [scene, name] of [["chirp", "Range"], ["tone", "Frequency"]]) {
    await page.selectOption("#scene", scene);
    for (const n of offered) {
      await page.selectOption("#n", String(n));
      seen[scene].push(await until(page, ({ word, figures, truth }) => word === "good" && figures[0]?.name === name && truth));
    }
  }
  tell("lengths", { errors, offered, seen });
  await context.close();
}

/** A tone 20 dB below the noise of a sample: a block alone, and the sum of a hundred. */
async function sums() {
  const { page, errors, context } = await open(browser);
  await page.selectOption("#scene", "tone");
  // The noise is ten times as large, and must not clip.
  await slide(page, "level_db", -30);
  await slide(page, "snr_db", -20);
  const alone = await until(page, ({ word }) => word === "weak" || word === "no-signal");
  await page.selectOption("#sum", "100");
  const sum = await until(page, ({ word }) => word === "good");
  const found = await hindrances(page, "sums");
  await page.click("#verdict");
  const { notice } = await until(page, (said) => said.notice);
  // No chirp is added up: that is told, and nothing else is measured.
  await page.selectOption("#scene", "chirp");
  const chirp = await until(page, (said) => said.notice.startsWith("This cannot work"));
  tell("sums", { errors, alone, sum, found, told: notice, chirp });
  await context.close();
}

/** The sheet of rates and lengths, as it answers several questions. */
async function design() {
  const { page, errors, context } = await open(browser);
  await page.keyboard.press("5");
  await page.waitForSelector("#design-table tbody tr");
  const asked = [];
  const ask = async (fields) => {
    for (const [name, value] of Object.entries(fields)) {
      if (name === "iq") await page.setChecked("#design-iq", value);
      else if (["n", "unit"].includes(name)) await page.selectOption(`#design-${name}`, value);
      else await slide(page, `design-${name}`, value);
    }
    asked.push(await page.evaluate(() => {
      const text = (id) => document.querySelector(`#design-${id}`).textContent;
      const shown = (id) => document.querySelector(`#design-${id}`).checkVisibility();
      const table = document.querySelector("#design-table");
      const cells = (row) => [...row.cells].sort((a, b) => a.dataset.column - b.dataset.column).map((cell) => cell.firstChild.textContent);
      return {
        wrong: shown("wrong") ? text("wrong") : "", settings: shown("chosen") ? text("settings") : "",
        head: cells(table.tHead.rows[0]), rows: [...table.tBodies[0].rows].map(cells),
        chosen: [...table.tBodies[0].rows].findIndex((row) => row.className === "chosen"),
        sentences: [...document.querySelectorAll("#design-sentences li")].map((line) => line.textContent),
        picture: document.querySelector("#design-chart canvas").ariaLabel, title: text("title"),
      };
    }));
  };
  await ask({});
  const found = await hindrances(page, "design");
  await ask({ sigma_mps: 0.002 });
  await ask({ sigma_mps: "", snr_db: -5, n: "1024", iq: true });
  await ask({ wave: 1550, unit: "2", velocity_mps: 0.1, n: "", iq: false });
  await ask({ wave: 24, unit: "0", velocity_mps: "", bandwidth_hz: 200, chirp_s: 5, rate_hz: 200000, snr_db: 12, sigma_m: 0.01 });
  found.push(...await hindrances(page, "design of a chirp"));
  // What cannot be answered is said.
  await ask({ chirp_s: "" });
  await ask({ bandwidth_hz: "", sigma_m: "", rate_hz: "" });
  await ask({ velocity_mps: 50, rate_hz: 1000 });
  await ask({ rate_hz: "", sigma_mps: 1e-9 });
  await ask({ wave: "" });
  found.push(...await hindrances(page, "no design"));
  const widths = [];
  for (const width of [1280, 390]) {
    await page.setViewportSize({ width, height: 844 });
    await drawn(page);
    widths.push([width, await page.evaluate(() => document.documentElement.scrollWidth)]);
  }
  // On a phone a wanted sigma is seen without scrolling to the side.
  await ask({ wave: 24.125, n: "", sigma_mps: 0.01, velocity_mps: 10, snr_db: 10 });
  const sigma = await page.evaluate(() => {
    const head = [...document.querySelectorAll("#design-table thead th")].find(({ textContent }) => textContent === "sigma m/s");
    return head.getBoundingClientRect().right;
  });
  asked.pop();
  // The others are as before.
  await page.click("#tab-scene");
  const after = await until(page, ({ word }) => word === "good");
  tell("design", { errors, asked, found, widths, sigma, after });
  await context.close();
}

async function hands() {
  const { page, errors, context } = await open(browser, PHONE);
  const widths = [];
  for (const key of ["2", "3", "4", "5", "1"]) {
    await page.keyboard.press(key);
    const chosen = await page.locator("[aria-selected=true]").textContent();
    widths.push([chosen, await page.evaluate(() => document.documentElement.scrollWidth)]);
  }
  await page.waitForFunction(() => document.querySelector("#figures .value"));
  const [answerTop, controlsTop, chartTop] = await page.evaluate(() => ["answer", "controls", "spectrum-figure"].map((id) => document.getElementById(id).getBoundingClientRect().top));
  await page.keyboard.press("Space");
  await drawn(page);
  const held = [await answer(page), (await page.waitForTimeout(500), await answer(page))].map(({ counters }) => counters.blocks);
  await page.keyboard.press("Space");
  const moved = (await until(page, ({ counters }) => counters.blocks !== held[1])).counters.blocks;
  // Every control can be reached and has a name.
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select")]
    .filter((tag) => tag.checkVisibility() && !(tag.textContent.trim() || tag.labels?.length || tag.ariaLabel)).map((tag) => tag.id));
  // The times beside the waterfall come as it fills.
  let labels = 0;
  for (let tries = 0; labels < 20 && tries < 40; tries += 1) {
    labels = await page.evaluate(() => document.querySelectorAll(".chart .label, .ticks li").length);
    await page.waitForTimeout(250);
  }
  const png = (await saved(page, "png")).subarray(0, 8).toString("hex");
  await page.emulateMedia({ colorScheme: "dark" });
  await drawn(page);
  const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  tell("hands", { errors, tops: [answerTop, controlsTop, chartTop], widths, held, moved, nameless, labels, png, ground });
  await context.close();
}

/** Whether a control is in view before anything is scrolled. */
const inView = (page, name) => page.locator(`#${name}`).evaluate((tag) => {
  const { top, bottom, height } = tag.getBoundingClientRect();
  return scrollY === 0 && height > 0 && top >= 0 && bottom <= innerHeight;
});

/** Without a mouse, and without eyes. */
async function access() {
  const { page, errors, context } = await open(browser, DESKTOP, serial(input("session.bin")));
  const found = [];
  const look = async (place) => found.push(...await hindrances(page, place));
  // Whoever listens is not drowned: the times between two sentences.
  await page.evaluate(() => {
    window.told = [];
    new MutationObserver(() => {
      const words = document.querySelector("#said").textContent;
      if (words) window.told.push([performance.now(), words]);
    }).observe(document.querySelector("#said"), { childList: true, characterData: true, subtree: true });
  });
  await look("chirp");
  // A quick machine is done with the look before the first sentence is read out.
  await page.waitForFunction(() => window.told.length);
  await page.selectOption("#scene", "doppler");
  await look("doppler");
  await page.selectOption("#scene", "tone");
  await page.selectOption("#tones-most", "4");
  await page.waitForFunction(() => document.querySelectorAll("#tones tbody tr").length);
  await look("tone");
  await slide(page, "snr_db", -25);
  const weak = await until(page, ({ word }) => word === "weak" || word === "no-signal");
  const order = await page.evaluate(() => {
    const [reason, figures] = ["#reason", "#figures"].map((name) => document.querySelector(name));
    return reason.compareDocumentPosition(figures) & Node.DOCUMENT_POSITION_FOLLOWING;
  });
  const digits = await page.evaluate(() => {
    const colour = (name) => getComputedStyle(document.querySelector(name)).color;
    return [colour(".figure .value"), colour(".figure .name"), colour("#word")];
  });
  await page.waitForTimeout(1500);
  await look("weak");
  // The arrows go through the sources, round and back; each is looked at.
  await page.focus("#tab-scene");
  const walked = [];
  for (const key of ["ArrowLeft", "ArrowRight", "ArrowRight", "ArrowRight", "ArrowRight", "End", "Home"]) {
    await page.keyboard.press(key);
    const chosen = await page.evaluate(() => [document.activeElement.id, document.querySelector("[aria-selected=true]").id, document.querySelectorAll("[role=tab][tabindex='0']").length]);
    walked.push(chosen);
    if (key === "ArrowRight") await look(chosen[0]);
  }
  await page.keyboard.press("2");
  await drop(page, "bad-short.wav");
  await measured(page);
  await look("a file that cannot be read");
  await drop(page, "good-tone.wav");
  await measured(page);
  await look("a file");
  await page.keyboard.press("4");
  await page.click("#connect");
  await page.waitForFunction(() => window.played);
  await drawn(page);
  await look("a board");
  const charts = await page.evaluate(() => [...document.querySelectorAll("figure")].filter((figure) => figure.checkVisibility()).map((figure) => {
    const [picture] = figure.querySelectorAll("canvas");
    return [picture.getAttribute("role"), picture.ariaLabel];
  }));
  const told = await page.evaluate(() => window.told);
  await context.close();
  // On a phone what begins a measurement is in view.
  const phone = await open(browser, PHONE);
  const begins = [];
  for (const [key, name] of [["2", "open"], ["3", "listen"], ["4", "connect"]]) {
    await phone.page.keyboard.press(key);
    await drawn(phone.page);
    begins.push([name, await inView(phone.page, name)]);
  }
  found.push(...await hindrances(phone.page, "a phone"));
  await phone.context.close();
  tell("access", { errors: [...errors, ...phone.errors], found, weak, order, digits, walked, charts, told, begins });
}

/** The tests behind a verdict as the page shows them, and its sentence above them. */
const why = (page) => page.evaluate(() => ({
  answer: document.querySelector("#why-answer").textContent,
  tests: [...document.querySelector("#tests").tBodies[0].rows].map((row) => {
    const [about, value, limit, followed] = row.cells;
    return [...about.children].map((part) => part.textContent).concat([value.textContent, limit.textContent, followed.textContent]);
  }),
}));

/** A press on the verdict explains it, and holds the page still meanwhile. */
async function explained() {
  const { page, errors, context } = await open(browser);
  const blocks = async () => (await answer(page)).counters.blocks;
  await page.click("#verdict");
  await page.waitForSelector("#why:not([hidden])");
  const chirp = await why(page);
  await page.waitForTimeout(300);
  const held = [await blocks(), (await page.waitForTimeout(500), await blocks())];
  const focus = [await page.evaluate(() => document.activeElement.id)];
  const found = await hindrances(page, "the tests behind a verdict");
  await page.keyboard.press("Escape");
  focus.push(await page.evaluate(() => document.activeElement.id));
  const moved = (await until(page, ({ counters }) => counters.blocks !== held[1])).counters.blocks;
  const files = [];
  await page.keyboard.press("2");
  for (const name of ["good-tone.wav", "good-iq.i16", "bad-silence.wav"]) {
    await slide(page, "file_rate_hz", name.endsWith(".wav") ? "" : 48000);
    if (name.includes("iq")) await page.check("#iq");
    else await page.uncheck("#iq");
    await measuredAfter(page, () => drop(page, name));
    await page.click("#verdict");
    await page.waitForSelector("#why:not([hidden])");
    files.push({ file: name, ...await why(page) });
    await page.click("#why-close");
  }
  // Without a block there is nothing to explain.
  await page.keyboard.press("3");
  await page.click("#verdict");
  const { notice } = await until(page, (said) => said.notice);
  tell("explained", { errors, chirp, held, moved, focus, found, files, notice });
  await context.close();
}

/** A file's name is text, whatever it says. */
async function strange() {
  const { page, errors, context } = await open(browser);
  const title = `<img src=x onerror="window.struck = true">`;
  const images = await page.locator("img").count();
  const seen = [];
  await page.keyboard.press("2");
  for (const name of ["good-tone.wav", "bad-short.wav", "bad-name.xyz"]) {
    await measuredAfter(page, () => drop(page, name, title));
    seen.push([await page.locator("#file-name").textContent(), (await answer(page)).notice]);
  }
  await page.waitForTimeout(200);
  const struck = await page.evaluate(() => Boolean(window.struck));
  tell("strange", { errors, title, seen, struck, images: [images, await page.locator("img").count()] });
  await context.close();
}

async function files() {
  const { page, errors, context } = await open(browser);
  for (const name of readdirSync(inputs).filter((file) => file.startsWith("good-"))) {
    await page.keyboard.press("2");
    await slide(page, "file_rate_hz", name.endsWith(".wav") ? "" : 48000);
    if (name.includes("iq")) await page.check("#iq");
    else await page.uncheck("#iq");
    await measuredAfter(page, () => drop(page, name));
    tell("file", { errors, file: name, ...await answer(page), json: (await saved(page, "json")).toString() });
  }
  await page.uncheck("#iq");
  await slide(page, "file_rate_hz", "");
  for (const name of readdirSync(inputs).filter((file) => file.startsWith("bad-"))) {
    await measuredAfter(page, () => page.setInputFiles("#file", { name, mimeType: "", buffer: input(name) }));
    tell("bad", { errors, file: name, ...await answer(page) });
  }
  // Nothing is broken by any of them.
  await page.keyboard.press("1");
  const [after] = await readings(page, 1);
  tell("after", { errors, ...after });
  await context.close();
}

/** Files that do not tell their rate or their codes: measured at once, and again as each is typed beside the answer. */
async function bare() {
  const { page, errors, context } = await open(browser);
  await page.keyboard.press("2");
  const told = [["bare.i16", {}], ["bare.i16", { file_rate_hz: 48000 }], ["bare-adc.u16", { bits: -12 }], ["bare.dat", { format: 6 }], ["bare.i16", { file_rate_hz: 48000, carrier_hz: 24.125 }]];
  for (const [file, fields] of told) {
    for (const [name, value] of Object.entries({ file_rate_hz: "", carrier_hz: "", bits: 16, format: 0 })) await slide(page, name, value);
    await measuredAfter(page, () => drop(page, file));
    for (const [name, value] of Object.entries(fields)) {
      await measuredAfter(page, () => slide(page, name, value));
    }
    const asked = await page.evaluate(() => {
      const [said, rate] = ["#asked", "#file_rate_hz"].map((name) => document.querySelector(name));
      return [said.checkVisibility() ? said.textContent : "", rate.closest("#answer") !== null, rate.checkVisibility(), document.querySelector("#spectrum-title").textContent,
        [...document.querySelectorAll("#spectrum .label.x")].at(-1)?.textContent ?? ""];
    });
    const found = Object.keys(fields).length ? [] : await hindrances(page, "a file without a rate");
    tell("bare", { errors, file, fields, asked, found, ...await answer(page), json: (await saved(page, "json")).toString() });
  }
  await context.close();
}

/** The displacement of a target before a Doppler radar, which is followed once that is wanted. */
async function displaced() {
  const { page, errors, context } = await open(browser);
  await page.keyboard.press("2");
  await page.check("#iq");
  await measuredAfter(page, () => drop(page, "swing-iq.i16"));
  const shown = () => page.evaluate(() => ["#displacement", "#way-figure"].map((name) => document.querySelector(name).checkVisibility()));
  const offered = [await shown()];
  for (const [name, value] of [["file_rate_hz", 48000], ["carrier_hz", 24]]) await measuredAfter(page, () => slide(page, name, value));
  offered.push(await shown());
  await measuredAfter(page, () => page.check("#displacement"));
  offered.push(await shown());
  const [title, swings, chart] = await page.evaluate(() => [
    document.querySelector("#way-title").textContent, [...document.querySelector("#swings").tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent)),
    document.querySelector("#way canvas").ariaLabel,
  ]);
  const csv = (await saved(page, "csv")).toString();
  const json = (await saved(page, "json")).toString();
  const found = await hindrances(page, "a displacement");
  await page.setViewportSize({ width: 390, height: 844 });
  await drawn(page);
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  // A sum has no phase.
  await measuredAfter(page, () => page.selectOption("#sum", "10"));
  offered.push(await shown());
  tell("displaced", { errors, file: "swing-iq.i16", offered, title, swings, chart, csv, json, found, width, ...await answer(page) });
  await context.close();
}

/** The map of a frame and the table of its targets. */
const map = (page) => page.evaluate(() => ({
  file: document.querySelector("#file-name").textContent, map: document.querySelector("#map canvas").ariaLabel, key: document.querySelector("#map-key").textContent,
  title: document.querySelector("#map-title").textContent,
  button: document.querySelector("#background").checkVisibility(), background: document.querySelector("#background-said").textContent,
  spectrum: document.querySelector("#spectrum-figure").checkVisibility(), labels: [...document.querySelectorAll("#map .label")].map((label) => label.textContent),
  targets: [...document.querySelector("#targets").tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent)),
}));

/** A cube of chirps: records at first, and frames of targets once the radar is typed beside the answer. */
async function frames() {
  const { page, errors, context } = await open(browser);
  await page.keyboard.press("2");
  await drop(page, "cube.npy");
  await measured(page);
  const asked = await page.locator("#asked").textContent();
  const before = await answer(page);
  const radar = { file_rate_hz: 2560000, carrier_hz: 77, file_bandwidth_hz: 306, guard_s: 2, period_s: 120, velocity_low_mps: -8, velocity_high_mps: 8, chirp_s: 102 };
  for (const [name, value] of Object.entries(radar)) {
    await measuredAfter(page, () => slide(page, name, value));
  }
  const seen = await map(page);
  const found = await hindrances(page, "frames");
  const json = (await saved(page, "json")).toString();
  await page.click("#verdict");
  const { notice } = await until(page, (said) => said.notice);
  // By its key and by its button.
  await measuredAfter(page, () => page.keyboard.press("b"));
  const beside = { ...await map(page), json: (await saved(page, "json")).toString() };
  await measuredAfter(page, () => page.click("#background"));
  const whole = await map(page);
  await measuredAfter(page, () => page.click("#background"));
  // Without bounds a velocity has aliases.
  for (const name of ["velocity_low_mps", "velocity_high_mps"]) await slide(page, name, "");
  await measured(page);
  await page.waitForFunction(() => / targets measured$/.test(document.querySelector("#file-name").textContent));
  await drawn(page);
  const open_ = await map(page);
  await page.setViewportSize({ width: 390, height: 844 });
  await drawn(page);
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  // Another source takes its place.
  await page.keyboard.press("1");
  const after = await until(page, ({ word }) => word === "good");
  tell("frames", { errors, asked, before, seen, found, json, told: notice, beside, whole, aliases: open_, width, after });
  await context.close();
}

/** Of a recording with two channels: either of them, both as I and Q, at another rate. */
async function choices() {
  const { page, errors, context } = await open(browser);
  await page.keyboard.press("2");
  await drop(page, "two-channels.wav");
  await measured(page);
  const { notice } = await answer(page);
  for (const [channel, q, rate] of [[2, "", ""], [1, "", 96000], [2, 1, ""]]) {
    for (const [name, value] of [["channel", channel], ["channel_q", q], ["file_rate_hz", rate]]) {
      await measuredAfter(page, () => slide(page, name, value));
    }
    const told = await page.locator("#file_rate_hz").getAttribute("placeholder");
    tell("choice", { errors, file: "two-channels.wav", channel, q, rate, told, wrong: notice, ...await answer(page), json: (await saved(page, "json")).toString() });
  }
  await context.close();
}

/** All tones of a block: two of a scene, then those of a recording's last block. */
async function several() {
  const { page, errors, context } = await open(browser);
  await page.selectOption("#scene", "tone");
  await slide(page, "second_db", -10);
  const alone = await tones(page);
  await page.selectOption("#tones-most", "4");
  const seen = [];
  for (let tries = 0; seen.length < 8 && tries < 200; tries += 1) {
    const rows = await tones(page);
    if (rows.length && JSON.stringify(rows) !== JSON.stringify(seen.at(-1))) seen.push(rows);
    await page.waitForTimeout(50);
  }
  await page.keyboard.press("2");
  await page.selectOption("#tones-most", "2");
  await drop(page, "good-tone.wav");
  await measured(page);
  tell("several", { errors, alone, seen, file: await tones(page) });
  await context.close();
}

/** Of two files dropped one after the other the second is shown, though the first takes longer to read. */
async function hasty() {
  const { page, errors, context } = await open(browser);
  await page.keyboard.press("2");
  await page.evaluate(() => {
    const read = File.prototype.arrayBuffer;
    File.prototype.arrayBuffer = async function arrayBuffer() {
      if (this.name.startsWith("bad-")) await new Promise((done) => setTimeout(done, 500));
      return read.call(this);
    };
  });
  await drop(page, "bad-silence.wav");
  await drop(page, "good-tone.wav");
  await page.waitForTimeout(1000);
  await measured(page);
  const shown = await page.locator("#file-name").textContent();
  // The same when another source is chosen meanwhile.
  await drop(page, "bad-silence.wav");
  await page.keyboard.press("1");
  await page.waitForTimeout(1000);
  const before = (await answer(page)).counters.blocks;
  const later = await until(page, ({ counters }) => counters.blocks !== before);
  tell("hasty", { errors, shown, counts: [before, later.counters.blocks], ...later });
  await context.close();
}

/** A board that gathers frames of chirps: the map that it keeps has no powers. */
async function framed(name) {
  const { page, errors, context } = await open(browser, DESKTOP, serial(input(name)));
  await page.keyboard.press("4");
  await page.click("#connect");
  await page.waitForFunction(() => window.played);
  await drawn(page);
  const found = await hindrances(page, "a board's frames");
  const known = await page.locator("#known").innerText();
  const json = (await saved(page, "json")).toString();
  if (process.env.PICKET_PICTURES) await page.screenshot({ path: join(process.env.PICKET_PICTURES, `${name}.png`), fullPage: true });
  tell("framed", { errors, session: name, known, found, json, seen: await map(page), ...await answer(page) });
  await context.close();
}

async function board(name) {
  const { page, errors, context } = await open(browser, DESKTOP, serial(input(name)));
  await page.keyboard.press("4");
  await page.click("#connect");
  await page.waitForFunction(() => window.played);
  await drawn(page);
  const asked = await page.evaluate(() => window.written.length);
  await page.click("[data-order=capture]");
  await page.waitForFunction((length) => window.written.length > length, asked);
  const known = await page.locator("#known").innerText();
  const [written, baud] = await page.evaluate(() => [window.written, window.baud]);
  const csv = name.startsWith("session") ? (await saved(page, "csv")).toString() : "";
  tell("board", { errors, session: name, known, tones: await tones(page), written, baud, csv, ...await answer(page) });
  await context.close();
}

/** A Pico's drive, which is a folder of the browser's own: what is written there, and what is refused. */
async function written() {
  const { page, errors, context } = await open(browser, DESKTOP, (page) => page.addInitScript(() => {
    window.showDirectoryPicker = async () => {
      if (window.refused) throw new DOMException("no", window.refused);
      return navigator.storage.getDirectory();
    };
  }));
  await page.keyboard.press("4");
  const image = input("picket-pico.uf2");
  const changed = (at, byte) => Object.assign(Buffer.from(image), { [at]: byte });
  const choose = (buffer) => page.setInputFiles("#uf2", { name: "picket-pico.uf2", mimeType: "", buffer });
  const said = [];
  const write = async () => {
    await page.click("#write");
    await page.waitForFunction(() => !document.querySelector("#write").disabled);
    said.push(await page.locator("#image-said").textContent());
  };
  const describe = (text) => page.evaluate(async (text) => {
    const drive = await navigator.storage.getDirectory();
    const file = await (await drive.getFileHandle("INFO_UF2.TXT", { create: true })).createWritable();
    await file.write(text);
    await file.close();
  }, text);
  const closed = await page.locator("#write").isDisabled();
  // Cut in a block, then between two; another family; a magic number; then drives that are none.
  for (const buffer of [image.subarray(0, 700), image.subarray(0, 512), changed(28, 0), changed(512 + 508, 0)]) {
    await choose(buffer);
    await write();
  }
  await choose(image);
  for (const refused of ["AbortError", "SecurityError"]) {
    await page.evaluate((refused) => { window.refused = refused; }, refused);
    await write();
  }
  await page.evaluate(() => { window.refused = ""; });
  await write();
  await describe("UF2 Bootloader v3.0\r\nModel: another\r\nBoard-ID: SAMD21\r\n");
  await write();
  const files = () => page.evaluate(async () => {
    const found = {};
    for await (const [name, handle] of (await navigator.storage.getDirectory()).entries()) found[name] = [...new Uint8Array(await (await handle.getFile()).arrayBuffer())];
    return found;
  });
  const before = Object.keys(await files());
  await describe("UF2 Bootloader v3.0\r\nModel: Raspberry Pi RP2\r\nBoard-ID: RPI-RP2\r\n");
  await write();
  const kept = (await files())["picket-pico.uf2"];
  // The drive goes away with the last block.
  await page.evaluate(() => { FileSystemWritableFileStream.prototype.close = async () => { throw new DOMException("gone", "InvalidStateError"); }; });
  await write();
  if (process.env.PICKET_PICTURES) await page.screenshot({ path: join(process.env.PICKET_PICTURES, "written.png") });
  const found = await hindrances(page, "a Pico's drive");
  await page.evaluate(() => { delete window.showDirectoryPicker; window.showDirectoryPicker = undefined; });
  await write();
  tell("written", { errors, closed, said, before, same: Buffer.from(kept).equals(image), found });
  await context.close();
}

async function microphone() {
  const { page, errors, context } = await open(browser, { ...DESKTOP, permissions: ["microphone"] });
  await page.keyboard.press("3");
  await page.click("#listen");
  await page.waitForFunction(() => Number(document.querySelector("[data-counter=blocks]")?.textContent) > 3);
  tell("microphone", { errors, ...await answer(page) });
  await context.close();
}

// Frames are timed while nothing else runs; the others share the time that they wait.
await scenes();
await Promise.all([hands(), files(), hasty(), several(), board("session.bin"), board("stranger.bin"), framed("frames.bin"), framed("frames-none.bin"), written(), microphone()]);
await Promise.all([access(), explained(), strange(), choices(), bare(), displaced(), frames()]);
await Promise.all([bursts(), design(), sums(), lengths()]);
await browser.close();

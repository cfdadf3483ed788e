// The page: a source gives rows, the newest is shown, and charts follow.
import { load } from "./core.js";
import { SpectrumChart, TimeChart, ZoomChart, length } from "./charts.js";
import { FrameMap } from "./map.js";
import { Waterfall } from "./waterfall.js";
import { SCENES, askForm, instrumentForm, make, sceneForm } from "./controls.js";
import { Board, Microphone, Particles, Recording, Simulated } from "./sources.js";
import { jsonLines, picture, table } from "./save.js";
import { Design } from "./design.js";
import { write } from "./write.js";
import { Tones, row as toneRow, testRow } from "./tones.js";
import { SIGNS, USES, along, figure, note, placed, placedAll, rank, signed, units } from "./words.js";

const $ = (id) => document.getElementById(id);
const KEPT = 200_000;
const HISTORY = 900;
const SOUND_MPS = 343;

const page = {
  core: null, source: null, turn: 0, name: "scene", paused: false, scene: SCENES[0], rows: [], kind: 2,
  counts: {}, spoken: 0, spokenWord: "", pictured: null, poured: 0, reference: 0, last: 0, shown: 0, times: [], drawn: -1,
  values: {
    scene: { n: 1024, bits: 12, iq: 1, mixing: 0, sum: 1, displacement: 0, tones: 1, band_low_hz: 0, band_high_hz: 0 },
    file: { n: 1024, bits: 16, iq: 0, sum: 1, displacement: 0, tones: 1, band_low_hz: 0, band_high_hz: 0, file_rate_hz: 0, carrier_hz: 0, mixing: -1, file_bandwidth_hz: 0, chirp_s: 0, period_s: 0, guard_s: 0, chirps: 0, velocity_low_mps: 0, velocity_high_mps: 0, format: 0, scale: 0, channel: 0, channel_q: 0 },
    microphone: { n: 4096, bits: 16, iq: 0, sum: 1, tones: 1, band_low_hz: 40, band_high_hz: 6000 },
    board: { n: 1024, bits: -12, iq: 0, band_low_hz: 0, band_high_hz: 0 },
  },
};
const charts = {};

function notice(sentence) {
  $("notice").textContent = sentence;
  $("notice").hidden = !sentence;
}

function setAll(settings) {
  for (const [name, value] of Object.entries(settings)) page.core.set(name, value);
}

/** Forgets what was shown, and what was explained of it. */
function forget() {
  unexplain();
  [units.known, units.speed] = [true, 0];
  $("asked").hidden = true;
  page.rows = [];
  page.counts = { blocks: 0, good: 0, gaps: 0, clipped: 0 };
  [page.drawn, page.shown, page.target, page.ramp, page.pictured] = [-1, 0, null, null, null];
  page.spokenWord = "";
  $("said").textContent = "";
  $("answer").classList.remove("unusable");
  charts.waterfall.clear();
  charts.map.clear();
  inFrames(false);
  charts.first.clear();
  charts.second.clear();
  charts.way.clear();
  listSwings([]);
  for (const chart of [charts.spectrum, charts.zoom]) chart.empty("No samples yet.");
  $("figures").replaceChildren();
  $("truth").hidden = true;
  $("truth").textContent = "";
  listTones([]);
  verdict(null);
  counters();
  titles();
}

/** Shows the map of frames of chirps, or the spectra of blocks. */
function inFrames(frames) {
  [page.frames, page.latest] = [frames, -1];
  document.body.toggleAttribute("data-frames", frames);
  $("map-figure").hidden = !frames;
}

/** Has the library measure by the settings of the source in use, from the start. */
function restart() {
  setAll({ displacement: 0, ...page.values[page.name], kind: 0, carrier_hz: 0, file_bandwidth_hz: 0, chirp_s: 0, format: 0, scale: 0, file_rate_hz: 0 });
  if (page.name === "scene") setAll({ ...page.scene.settings, iq: page.values.scene.iq, mixing: page.values.scene.mixing, kind: bursts() ? 0 : page.scene.kind });
  // A short ramp is no steeper than one of 1024 samples: the beats of far targets would lie beyond half the rate.
  if (page.name === "scene") page.core.set("bandwidth_hz", page.scene.settings.bandwidth_hz * Math.min(1, page.values.scene.n / 1024));
  if (bursts()) setAll({ n: 1024, bits: 12, iq: 0, band_low_hz: 0, band_high_hz: 0 });
  if (page.name === "file") setAll(page.values.file);
  if (page.name === "microphone" && page.rate) page.core.set("rate_hz", page.rate);
  forget();
  const wrong = page.core.start(1);
  notice(wrong);
  measureIn();
  return !wrong;
}

/** Begins another source. What an earlier one still waits for then comes too late: `late()` tells it. */
function begin() {
  const turn = page.turn += 1;
  return () => turn !== page.turn;
}

const tabs = () => [...document.querySelectorAll("[data-source]")];

async function choose(name) {
  begin();
  page.source?.stop();
  [page.source, page.name] = [null, name];
  document.body.dataset.chosen = name;
  $("design").hidden = name !== "design";
  for (const tab of tabs()) {
    tab.setAttribute("aria-selected", tab.dataset.source === name);
    tab.tabIndex = tab.dataset.source === name ? 0 : -1;
  }
  $("controls").setAttribute("aria-labelledby", `tab-${name}`);
  $("side").dataset.chosen = name;
  notice("");
  if (name === "design") return design();
  for (const form of document.querySelectorAll("[data-for]")) form.hidden = !form.dataset.for.split(" ").includes(name);
  const changed = (setting, value) => {
    page.values[name][setting] = value;
    if (setting === "tones") return void several();
    if (name === "file" && page.file) void drop(page.file);
    else if (restart() && name === "scene") page.source = new Simulated(page.core);
  };
  instrumentForm($("instrument-form"), name, page.values[name], changed);
  if (name === "file") askForm($("ask"), page.values.file, changed);
  else $("ask").replaceChildren();
  restart();
  if (name === "scene") simulate(page.scene);
  if (name === "file" && page.file) await drop(page.file);
}

/** The sheet on which a rate and a length are chosen; its calculation is loaded with it. */
async function design() {
  forget();
  const found = await finder();
  if (found && page.name === "design") page.design ??= new Design(found);
}

function simulate(scene) {
  page.scene = scene;
  [page.values.scene.iq, page.values.scene.mixing] = [scene.settings.iq, scene.settings.mixing];
  const tick = $("iq");
  if (tick) tick.checked = Boolean(scene.settings.iq);
  if ($("mixing")) $("mixing").value = String(scene.settings.mixing);
  page.flow = {};
  sceneForm($("scene-form"), scene, (name, value) => { page.flow[name] = value; page.core.set(name, value); }, simulate);
  // A burst has a record of its own length, and one tone.
  $("instrument").hidden = bursts();
  document.body.dataset.scene = scene.id;
  const late = begin();
  page.source = null;
  if (!restart()) return;
  if (!bursts()) page.source = new Simulated(page.core);
  else finder().then((found) => { if (found && !late()) page.source = new Particles(page.core, found, page.flow); });
}

/** Whether an answer is of more than one block. */
const summed = () => page.values[page.name]?.sum > 1;

/** Whether the scene is one of bursts. */
const bursts = () => page.name === "scene" && page.scene.kind === 3;

async function drop(file, still) {
  if (page.name !== "file") {
    page.file = file;
    return choose("file");
  }
  page.file = file;
  const late = begin();
  restart();
  const contents = new Uint8Array(await file.arrayBuffer());
  if (late()) return;
  const told = (wrong, blocks) => {
    notice(wrong);
    charts.waterfall.fill();
    $("file-name").textContent = `${file.name}: ${blocks} ${page.frames ? "targets" : "blocks"} measured`;
  };
  const recording = new Recording(page.core, file.name, contents, told, (row) => pour(page.core.spectrum(), row));
  if (recording.wrong) {
    $("file-name").textContent = "Nothing was measured.";
    return notice(recording.wrong);
  }
  $("file-name").textContent = file.name;
  const { rate, known, iq, row, frames } = page.core.state();
  inFrames(frames);
  if (row > 0) $("ramps").open = true;
  $("file_rate_hz").placeholder = known ? `${rate}, as the file says` : "the file tells none";
  const lone = row > 0 ? `It holds records of ${row} samples each. If they are chirps, the carrier, the sweep and its time${known ? "" : ", with the rate,"} give ranges and velocities.` : "";
  const said = [known ? "" : "The file does not tell its sample rate: frequencies are in cycles per sample.", lone, recording.assumed && `Assumed: ${recording.assumed}.`];
  $("asked").textContent = said.filter(Boolean).join(" ");
  $("asked").hidden = !$("asked").textContent;
  $("mixing").closest(".field").hidden = !(iq && page.values.file.carrier_hz);
  measureIn();
  if (still) page.core.background(2);
  page.source = recording;
}

async function listen() {
  const late = begin();
  page.source?.stop();
  const microphone = new Microphone(page.core);
  const { rate, wrong } = await microphone.listen();
  if (late()) return microphone.stop();
  if (wrong) return notice(wrong);
  page.rate = rate;
  if (restart()) page.source = microphone;
}

async function connect() {
  const late = begin();
  await page.source?.stop();
  if (late()) return;
  page.core.fresh();
  restart();
  page.core.hear(new Uint8Array());
  const board = new Board(page.core, notice);
  const wrong = await board.connect();
  if (late()) return board.stop();
  if (wrong) return notice(wrong);
  page.source = board;
}

/** Writes the chosen image to a Pico's drive. */
async function flash() {
  $("write").disabled = true;
  $("image-said").textContent = "Choose the drive RPI-RP2.";
  $("image-said").textContent = await write($("uf2").files[0]);
  $("write").disabled = false;
}

/** Loads what finds more than one tone and explains a verdict, once that is wanted. */
async function finder() {
  page.finder ??= await Tones.load().catch((error) => void notice(`This failed: ${error.message}.`));
  return page.finder;
}

async function several() {
  page.shown = 0;
  if (page.values[page.name].tones > 1) await finder();
}

/** Which of a chirp's segments a block is. */
const SEGMENTS = ["", ", rising ramp", ", flat segment", ", falling ramp"];

/** Explains the verdict on the block that is drawn; the page holds still until that is closed. */
async function explain() {
  if (!$("why").hidden) return unexplain();
  if (bursts()) return notice("A burst is judged as a whole: its validation is shown below the answer. Choose another scene to see the tests behind a verdict.");
  if (summed()) return notice("A sum is judged as a whole: by how rarely noise alone has such a line. Let each block have its answer to see the tests behind a verdict.");
  if (page.frames) return notice("A frame's target is judged as a whole: by its fits over samples and over chirps, and by how rarely noise alone has one.");
  const turn = page.turn;
  const held = page.paused;
  pause(true);
  const found = await finder();
  const explained = turn === page.turn ? found?.explain(page.core.shown()) : null;
  const row = page.rows.findLast(({ segment }) => segment <= 1);
  if (!explained || !row) {
    pause(held);
    if (found && turn === page.turn) notice(page.name === "board" ? "The board sends answers, not samples. Capture a block to have it explained." : "There is no block to explain yet.");
    return;
  }
  page.held = held;
  const { reason, usable } = page.core.verdicts.find(({ name }) => name === explained.verdict);
  const block = page.name === "board" ? "The captured block" : `Block ${row.block}${SEGMENTS[row.segment]}`;
  const measured = page.name === "board" || !(row.sigma_hz > 0) ? "" : ` ${figure(row.frequency_hz, row.sigma_hz).join(" \u00b1 ")} ${units.frequency},`;
  $("why-answer").textContent = `${block}:${measured} ${explained.verdict}. ${reason} Usable: ${usable}.`;
  $("tests").tBodies[0].replaceChildren(...explained.tests.map(testRow));
  $("why").hidden = false;
  $("verdict").setAttribute("aria-expanded", true);
  // The digits follow five times a second: they are those of the block that is explained.
  page.shown = 0;
  draw(performance.now());
  $("why").focus({ preventScroll: true });
}

function unexplain() {
  if ($("why").hidden) return;
  const inside = $("why").contains(document.activeElement);
  $("why").hidden = true;
  $("verdict").setAttribute("aria-expanded", false);
  if (inside) $("verdict").focus();
  pause(page.held && page.paused);
}

/** The tones of the newest block: a board tells its own. */
function tonesNow() {
  if (page.name === "board") return page.core.told();
  const most = page.values[page.name].tones;
  return page.finder && most > 1 && !summed() ? page.finder.find(page.core.shown(), most) : [];
}

/** The tones as a table. */
function listTones(tones) {
  const { full } = page.core.state();
  $("tones").hidden = !tones.length;
  $("tones").tBodies[0].replaceChildren(...tones.map((tone) => toneRow(tone, full, page.core.verdicts)));
}

/** What swings in the displacement as a table, the strongest first. */
function listSwings(swings) {
  $("swings").parentElement.hidden = !swings.length;
  $("swings").tBodies[0].replaceChildren(...swings.map((swing) => {
    const verdict = page.core.verdicts[swing.verdict];
    const both = (value, sigma, scale = 1) => figure(scale * value, scale * sigma).join(" \u00b1 ");
    return make("tr", { title: verdict.reason },
      make("td", {}, both(swing.hertz, swing.sigma)), make("td", {}, both(swing.amplitude_m, swing.sigma_m, 1e6)), make("td", {}, both(swing.velocity_mps, swing.sigma_mps, 1e6)),
      make("td", { className: `said ${rank(verdict)}` }, `${SIGNS[verdict.name]} ${verdict.name}`));
  }));
}

/** The verdict's word, sign, colour and reason. */
function verdict(number) {
  const said = page.core.verdicts[number];
  $("verdict").className = said ? rank(said) : "none";
  $("sign").textContent = said ? SIGNS[said.name] : "";
  $("word").textContent = said?.name ?? "no answer yet";
  $("use").textContent = said && said.usable !== "yes" ? USES[said.usable] : "";
  $("reason").textContent = said?.reason ?? "No block has been measured yet.";
  $("answer").classList.toggle("unusable", said?.usable === "no");
}

/** The answer for whom it is read out: a new verdict after a second at the earliest, new digits after five. */
function speak(now) {
  const word = $("word").textContent;
  if (now - page.spoken < (word === page.spokenWord ? 5000 : 1000)) return;
  const part = (box, name) => box.querySelector(`.${name}`).textContent;
  const figures = [...document.querySelectorAll("#figures .figure:not(.small)")];
  const read = figures.map((box) => `${part(box, "name")} ${part(box, "value")} ${part(box, "sigma")}`).join(", ");
  const usable = !$("answer").classList.contains("unusable");
  const said = usable ? `${word}: ${read}` : `Not usable, ${word}: ${$("reason").textContent}`;
  [page.spoken, page.spokenWord] = [now, word];
  if ($("said").textContent !== said) $("said").textContent = said;
  describe();
}

/** The names of the charts, with what can be read from them. */
function describe() {
  const { spectrum, tones, seen } = page.pictured ?? {};
  if (spectrum) {
    const plain = units.known && !units.speed;
    const at = (value) => (plain ? along(Math.round(value), 1, Math.abs(value)) : `${along(value, units.speed ? 0.01 : 1e-4)}${units.known ? "" : ` ${units.frequency}`}`);
    const last = spectrum.first + spectrum.step * (spectrum.bins.length - 1);
    const places = (tones.length ? tones : seen ? [spectrum] : []).map((tone) => at(tone.hertz));
    const lines = places.length ? `lines at ${places.join(", ")}` : "no line";
    const above = Math.round(Math.max(...spectrum.bins) - spectrum.floor);
    charts.spectrum.describe(`Spectrum of the block from ${at(spectrum.first)} to ${at(last)}: ${lines}, the strongest bin ${above} dB above the noise floor`);
    charts.zoom.describe(seen ? `Bins around the tone at ${at(spectrum.hertz)}, and the tone that was fitted to them` : "There is no line");
  }
  charts.first.describe(`${$("first-title").textContent}, over time, with sigma`);
  if (page.follows) charts.way.describe(`${$("way-title").textContent}, over time, with sigma`);
  charts.second.describe(`${$("second-title").textContent}, over time, with sigma`);
}

/** A value with its sigma, and beside it the whole error where the settings tell what is not known of the sensor. */
function figureOf(name, value, sigma, unit, small, whole) {
  const known = Number.isFinite(value) && sigma > 0;
  const [digits, spread] = known ? figure(value, sigma) : ["\u2013", ""];
  const all = known && whole > 0 ? `, \u00b1 ${figure(value, whole)[1]} ${unit} in all` : "";
  return boxOf(name, digits, unit, spread && `\u00b1 ${spread} ${unit}${all}`, small);
}

function boxOf(name, digits, unit, spread, small) {
  const box = document.createElement("div");
  box.className = small ? "figure small" : "figure";
  const parts = [["name", name], ["value", digits], ["unit", unit], ["sigma", spread]];
  for (const [part, text] of parts) {
    const tag = document.createElement("span");
    tag.className = part;
    tag.textContent = text;
    if (part === "value" && text.length > 10) tag.classList.add("long");
    box.append(tag);
  }
  return box;
}

/** The newest answer in figures. */
function show(row) {
  const nothing = page.core.verdicts[row.verdict].name === "no-signal";
  const own = (value) => (nothing ? NaN : value);
  // Of a chirp the beat of the rising ramp, as it is drawn.
  const ramp = page.ramp ?? row;
  const tone = [own(ramp.frequency_hz), ramp.sigma_hz];
  const target = page.target;
  const outcome = Number.isFinite(target?.outcome_verdict) ? target.outcome_verdict : row.verdict;
  const usable = page.core.verdicts[outcome].usable !== "no";
  const figures = [];
  const truths = [];
  const truth = (known, value, sigma, unit) => {
    if (!Number.isFinite(known) || !(sigma > 0)) return;
    // Of an answer that is not to be used it does not matter how far it is off.
    const off = usable ? ` (${signed(((value - known) / sigma).toFixed(2))} sigma off)` : "";
    truths.push(`${signed(known.toFixed(Math.min(9, figure(value, sigma)[1].length - 1)))} ${unit}${off}`);
  };
  if (target && Number.isFinite(target.range_m)) {
    figures.push(figureOf("Range", target.range_m, target.sigma_range_m, "m", false, target.uncertainty_range_m));
    truth(target.truth_m, target.range_m, target.sigma_range_m, "m");
  }
  if (target && Number.isFinite(target.velocity_mps)) {
    figures.push(figureOf("Velocity", target.velocity_mps, target.sigma_velocity_mps, "m/s", false, target.uncertainty_velocity_mps));
    truth(target.truth_mps, target.velocity_mps, target.sigma_velocity_mps, "m/s");
  }
  figures.push(figureOf(page.frames ? "Beat" : ramp.segment ? "Beat of the rising ramp" : "Frequency", ...tone, units.frequency, Boolean(target), units.frequency === "Hz" ? ramp.uncertainty_hz : NaN));
  if (!target) truth(ramp.truth_hz, ...tone, "Hz");
  if (row.validation) figures.push(boxOf(`Burst, ${row.validation}`, `${(1e3 * row.transit_s).toFixed(2)}`, "ms in the beams", "", true));
  if (page.name === "microphone" && !nothing) {
    const { name, cents } = note(row.frequency_hz);
    figures.push(figureOf(`Note ${name}, off by`, cents, row.sigma_hz / row.frequency_hz * 1731, "cents", true));
    if (page.reference) {
      const speed = SOUND_MPS * (row.frequency_hz - page.reference) / row.frequency_hz;
      figures.push(figureOf("Speed towards you", speed, SOUND_MPS * row.sigma_hz / row.frequency_hz, "m/s", true));
    }
  }
  $("caution").hidden = !(target && target.range_m < 0);
  $("figures").replaceChildren(...figures);
  $("truth").hidden = !truths.length;
  $("truth").textContent = truths.length ? `Truth ${truths.join(", ")}` : "";
  verdict(outcome);
}

function count(row) {
  page.counts.blocks += 1;
  page.counts.good += Number((page.frames ? row.outcome_verdict : row.verdict) === 0);
  page.counts.gaps += Number(row.gap === 1);
  page.counts.clipped += row.clipped;
  if (Number.isFinite(row.lost)) [page.counts.lost, page.counts.faults] = [row.lost, row.faults];
}

function counters() {
  const { blocks, good, gaps, clipped, lost = 0, faults = 0 } = page.counts;
  const { missing, bad, raw } = page.core.state();
  const share = blocks ? `${Math.round(100 * good / blocks)} %` : "\u2013";
  const list = [[bursts() ? "bursts" : page.frames ? "targets" : "blocks", blocks], ["good", share], ["clipped", clipped, clipped > 0], ["gaps", gaps, gaps > 0]];
  if (page.name === "board") {
    list.push(["lost", lost, lost > 0], ["faults", faults, faults > 0], ["missing", missing, missing > 0], ["bad frames", bad, bad > 0], ["raw blocks", raw]);
  }
  $("counters").replaceChildren(...list.map(([name, value, raised]) => {
    const box = document.createElement("div");
    box.className = raised ? "raised" : "";
    const [term, said] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, said.textContent] = [name, typeof value === "number" ? value.toLocaleString("en-GB") : value];
    said.dataset.counter = name;
    box.append(term, said);
    return box;
  }));
}

/** Rows into figures, charts and the table. */
function take(rows) {
  for (const row of rows) {
    count(row);
    // Of a frame the strongest target, which comes first.
    if (page.frames && row.block === page.latest) continue;
    page.latest = row.block;
    if (row.segment <= 1) page.ramp = row;
    if (Number.isFinite(row.outcome_verdict)) page.target = row;
    const usable = (verdict, value) => (page.core.verdicts[verdict]?.usable === "no" ? NaN : value);
    const point = (chart, value, sigma, truth, verdict) => chart.add(row.time_s, usable(verdict, value), sigma, truth, HISTORY);
    if (Number.isFinite(row.range_m)) {
      point(charts.first, row.range_m, row.sigma_range_m, row.truth_m, row.outcome_verdict);
      point(charts.second, row.velocity_mps, row.sigma_velocity_mps, row.truth_mps, row.outcome_verdict);
    } else if (Number.isFinite(row.velocity_mps)) {
      point(charts.first, row.velocity_mps, row.sigma_velocity_mps, row.truth_mps, row.outcome_verdict);
    } else if (row.segment === 0) {
      point(charts.first, row.frequency_hz, row.sigma_hz, row.truth_hz, row.verdict);
    }
    // A new start comes with a block whose turns are not sure, which breaks the line.
    const sure = ["yes", "within sigma"].includes(page.core.verdicts[row.displacement_verdict]?.usable);
    if (page.follows) charts.way.add(row.time_s, sure ? row.displacement_m : NaN, row.sigma_displacement_m, NaN, HISTORY);
  }
  page.rows.push(...rows);
  if (page.rows.length > KEPT) page.rows.splice(0, page.rows.length - KEPT);
}

/** Subtracts the background of the frame that is shown, or ends that: of this frame and those to come, or once all were measured, of all. */
function background() {
  const shown = page.frames && page.core.map();
  if (!shown?.decibels.length) return;
  const still = !Number.isFinite(shown.share);
  if (still) charts.map.recorded = shown.frame;
  const rows = page.core.background(still ? 1 : 0);
  if (!page.source.more) {
    pause(false);
    return void drop(page.file, still);
  }
  if (page.latest === shown.frame) [charts.first, charts.second].forEach((chart) => chart.back());
  page.rows = page.rows.filter(({ block }) => block !== shown.frame);
  page.latest = page.rows.at(-1)?.block ?? -1;
  page.counts = { blocks: 0, good: 0, gaps: 0, clipped: 0 };
  page.rows.forEach(count);
  take(rows);
  page.shown = 0;
  draw(performance.now());
}

/** Has figures and charts in what the source tells: hertz or cycles per sample, and speeds where there is a carrier. */
function measureIn() {
  const { known, speed, iq, row, follows } = page.core.state();
  [units.known, units.speed, page.follows] = [known, speed, follows];
  if ($("displacement")) $("displacement").closest(".field").hidden = !speed || row > 0 || summed();
  $("way-figure").hidden = !follows;
  // Real samples of a continuous wave do not show the direction.
  $("way-title").textContent = `Displacement${iq ? "" : ", of unknown sign"}`;
  titles();
}

function titles() {
  const target = page.target;
  const two = Boolean(target && Number.isFinite(target.range_m));
  document.querySelector("main").classList.toggle("two", two);
  // One frame has no course.
  const lone = page.frames && !(page.latest > 0);
  $("first-figure").hidden = lone;
  $("second-figure").hidden = !two || lone;
  $("first-title").textContent = two ? "Range, m" : target ? "Velocity, m/s" : `Frequency, ${units.frequency}`;
  for (const name of ["Spectrum", "Line", "Waterfall"]) {
    $(`${name === "Line" ? "zoom" : name.toLowerCase()}-title`).textContent = units.known ? name : `${name}, ${units.frequency}`;
  }
  $("tones-unit").textContent = units.known ? "Hz" : "cycles";
  $("second-title").textContent = "Velocity, m/s";
}

function pour(spectrum, row) {
  if (!spectrum) return;
  charts.waterfall.add(placed(spectrum), placedAll(page.core.tracks()), row.time_s);
}

/** The map of the newest frame and its targets. */
function drawFrame(now) {
  if (now - page.shown <= 200) return void (page.drawn = page.shown < Infinity ? -1 : page.drawn);
  page.shown = now;
  if (page.name === "board") measureIn();
  const map = page.core.map();
  if (map) charts.map.show(map, page.core.verdicts);
  else if (page.name === "board") page.drawn = -1;
  titles();
  charts.first.show();
  charts.second.show();
  if (page.target) show(page.target);
  if (map && !map.targets.length) {
    $("figures").replaceChildren();
    verdict(null);
    [$("word").textContent, $("reason").textContent] = ["no target", "Nothing in the frame stands out of the noise."];
  }
  speak(now);
  counters();
  known();
  frameTime();
}

function draw(now) {
  if (page.frames) return drawFrame(now);
  const row = page.rows.at(-1);
  let spectrum = page.core.spectrum();
  // A burst has a frequency of its own: its envelope is the weight.
  if (spectrum && bursts()) spectrum = { ...spectrum, hertz: row.frequency_hz, sigma: row.sigma_hz };
  const raw = page.name !== "board" || page.core.state().raw > 0;
  const tones = tonesNow();
  if (spectrum && raw) {
    const seen = page.core.verdicts[row.verdict].name !== "no-signal" && Number.isFinite(spectrum.hertz) && spectrum.sigma > 0;
    const there = placed(spectrum);
    charts.spectrum.show(there, seen, placedAll(tones));
    page.pictured = { spectrum: there, tones: placedAll(tones), seen };
    if (bursts()) charts.zoom.empty("A burst has no steady line.");
    else if (seen) charts.zoom.show(page.core, there);
    else charts.zoom.empty("There is no line.");
    // Thirty rows a second: eight seconds are in sight. A recording pours its own.
    if (page.name !== "file" && now - page.poured > 30) {
      page.poured = now;
      pour(spectrum, row);
    }
  } else if (page.name === "board") {
    for (const chart of [charts.spectrum, charts.zoom]) chart.empty("The board sends answers, not samples. Capture a block to see its spectrum.");
  }
  if (page.name === "board") measureIn();
  titles();
  charts.first.show();
  if (page.target) charts.second.show();
  if (page.follows) charts.way.show();
  // Digits that change faster than five times a second cannot be read.
  if (now - page.shown > 200) {
    page.shown = now;
    show(row);
    speak(now);
    listTones(tones);
    if (page.follows) listSwings(page.core.swings());
    counters();
    known();
    frameTime();
  }
}

function known() {
  if (!(page.source instanceof Board)) return;
  $("known").replaceChildren(...page.source.known.flatMap(([name, words]) => [
    Object.assign(document.createElement("dt"), { textContent: name }),
    Object.assign(document.createElement("dd"), { textContent: words }),
  ]));
}

function frameTime() {
  const sorted = [...page.times].sort((a, b) => a - b);
  const median = sorted[sorted.length >> 1] ?? 0;
  $("frame").textContent = `A frame takes ${median.toFixed(1)} ms of its ${(1000 / 60).toFixed(1)}.`;
  $("frame").dataset.ratio = (median * 60 / 1000).toFixed(4);
}

function frame(now) {
  const seconds = Math.min(0.25, (now - page.last) / 1000);
  page.last = now;
  const begun = performance.now();
  if (!page.paused && page.source) {
    try {
      const rows = page.source.advance(seconds);
      const { frames, raw, heard } = page.core.state();
      if (page.name === "board" && frames !== page.frames) inFrames(frames);
      if (rows.length) take(rows);
      else if (page.name === "board") { known(); counters(); listTones(tonesNow()); }
      if (rows.length || raw + heard !== page.drawn) {
        page.drawn = raw + heard;
        if (page.rows.length || page.frames) draw(now);
        page.times.push(performance.now() - begun);
        if (page.times.length > 120) page.times.shift();
      }
      if (!rows.length && page.source.more === false && (page.rows.length || page.frames) && page.shown !== Infinity) {
        page.shown = 0;
        draw(now);
        page.shown = Infinity;
        // What a recording ends with is read out, too.
        page.spokenWord = "";
        setTimeout(() => speak(performance.now()), 1000);
      }
    } catch (error) {
      // An instance that has stopped stays so.
      console.error(error);
      page.source.stop();
      page.source = null;
      page.core.fresh();
      notice("This stopped the measurement. Choose a source to start again.");
    }
  }
  requestAnimationFrame(frame);
}

function pause(held = !page.paused) {
  page.paused = held;
  // What goes on is no longer what was explained.
  if (!page.paused) unexplain();
  $("pause").setAttribute("aria-pressed", page.paused);
  $("pause").querySelector("span").textContent = page.paused ? "Go on" : "Pause";
}

function listenToPeople() {
  for (const tab of tabs()) tab.addEventListener("click", () => choose(tab.dataset.source));
  $("sources").addEventListener("keydown", (event) => {
    const all = tabs();
    const at = all.indexOf(document.activeElement);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: all.length - 1 }[event.key];
    if (at < 0 || to === undefined) return;
    event.preventDefault();
    const next = all[(to + all.length) % all.length];
    next.focus();
    choose(next.dataset.source);
  });
  for (const button of document.querySelectorAll("[data-order]")) button.addEventListener("click", () => page.source?.order?.(button.dataset.order));
  for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
  const presses = {
    pause: () => pause(), background, connect, listen, write: flash, verdict: explain, "why-close": unexplain, png: picture, csv: () => table(page.core, page.rows), json: () => jsonLines(page.core, page.rows),
    take: () => {
      page.reference = page.rows.at(-1)?.frequency_hz ?? 0;
      $("reference").textContent = page.reference ? `Reference ${page.reference.toFixed(1)} Hz` : "Listen first.";
    },
  };
  for (const [id, press] of Object.entries(presses)) $(id).addEventListener("click", press);
  $("open").addEventListener("click", () => $("file").click());
  $("file").addEventListener("change", ({ target }) => target.files[0] && drop(target.files[0]));
  $("image").addEventListener("click", () => $("uf2").click());
  $("uf2").addEventListener("change", ({ target }) => {
    $("write").disabled = !target.files.length;
    if (target.files.length) $("image-said").textContent = `${target.files[0].name}: hold BOOTSEL while you plug the Pico in, then write.`;
  });
  addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("dragging"); });
  addEventListener("dragleave", () => document.body.classList.remove("dragging"));
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dragging");
    if (event.dataTransfer.files[0]) drop(event.dataTransfer.files[0]);
  });
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") unexplain();
    const typing = event.target.matches("input, select, textarea");
    if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    const names = ["scene", "file", "microphone", "board", "design"];
    if (page.name === "design" && !"12345".includes(event.key)) return;
    if (event.key === " " && !event.target.matches("button")) { event.preventDefault(); pause(); }
    else if (names[event.key - 1]) choose(names[event.key - 1]);
    else if (event.key === "b") background();
    else if (event.key === "p") picture();
    else if (event.key === "c") table(page.core, page.rows);
    else if (event.key === "j") jsonLines(page.core, page.rows);
  });
}

try {
  page.core = await load();
  charts.spectrum = new SpectrumChart($("spectrum"));
  charts.zoom = new ZoomChart($("zoom"));
  charts.waterfall = new Waterfall($("waterfall"));
  charts.first = new TimeChart($("first"));
  charts.second = new TimeChart($("second"));
  charts.way = new TimeChart($("way"), length);
  charts.map = new FrameMap();
  listenToPeople();
  choose("scene");
  requestAnimationFrame(frame);
} catch (error) {
  console.error(error);
  notice(location.protocol === "file:" ? "Open this page from a server: cargo picket web is one." : `The page could not start: ${error.message}.`);
}

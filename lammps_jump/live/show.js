"use strict";
// The page of a live flow: what is drawn, curves, sliders and keys. The flow itself is in the thread of worker.js.

// Seconds of flow between two points of a curve; of more points every second is kept.
const POINT_EVERY = 0.05;
const MOST_POINTS = 1000;
// Milliseconds between two drawings of the curves.
const CURVES_EVERY = 400;
// A pace above this counts as real time.
const REAL = 0.97;

const byClass = (name) => document.querySelector("." + name);
const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
const live = { frame: null, drawn: 0, pictures: [], asked: [], since: -1, curvesAt: 0, every: POINT_EVERY };

async function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

// ---- the flow as the drawing modules take it: a run of one instant ----

function runNow({ ids, x, y, u, v, shade, time, poses }) {
  const count = ids.length, { about } = live.head;
  live.zeros = live.zeros && live.zeros.length >= count ? live.zeros : new Uint16Array(2 * count);
  live.order = live.order && live.order.length >= count ? live.order : Uint32Array.from({ length: 2 * count }, (_, k) => k);
  for (const wall of about.walls) {
    if (!wall.about) continue;
    [wall.x, wall.y, wall.angle] = poses[about.numbers[wall.name]].map((part) => [part]);
  }
  return {
    ...about, discs: count, ids, x, y, u, v, shade, disc: live.order, first: live.zeros, life: live.zeros,
    times: [time], start: [0, count], most: live.order.length, sequent: [null], walls: about.walls,
  };
}

function begin(frame) {
  const element = document.getElementById("flow"), p = playerOf(element, runNow(frame));
  live.p = p;
  joinViews();
  listenToPointer(p);
  for (const name of ["out", "in"]) part(p, name).addEventListener("click", () => zoomByKey(p, name === "in" ? 1.5 : 1 / 1.5));
  part(p, "whole").addEventListener("click", () => showWhole(p));
  part(p, "colour").addEventListener("change", () => { p.colour = part(p, "colour").value; draw(p); });
  new ResizeObserver(() => layOutBoth()).observe(element);
  darkness.addEventListener("change", layOutBoth);
  layOut(p);
  showRecorded(true);
  for (const name of ["play", "step", "again", "download"]) byClass(name).disabled = false;
  return p;
}

function show() {
  const { frame } = live;
  if (!frame) return;
  live.frame = null;
  const p = live.p || begin(frame);
  if (p.found.x.length < (p.run.seam ? 4 : 2) * frame.ids.length) p.found = roomFor(runNow(frame));
  Object.assign(p, { run: runNow(frame), time: frame.time });
  live.last = frame;  // the clock that a picture draws is of this frame
  if (follows(p)) showHome(p);
  else draw(p);
  live.drawn++;
  showRecorded();
  addPoints(frame);
  tellState(frame);
  live.worker.postMessage({ act: "shown" });
}

// What view.js calls for the clock of a picture.
function showClock(p) {
  const { last } = live;
  if (!last || p !== live.p) return;
  const pace = last.pace === null || !last.playing ? "" : last.pace >= REAL ? ", real time" : `, ${last.pace.toPrecision(2)} of real time`;
  const clock = `t = ${(live.head.time + p.time).toFixed(3)} s, step ${last.step - live.head.start}${pace}`;
  byClass("clock").textContent = clock;
}

function tellState(frame) {
  byClass("play").textContent = frame.playing ? "Pause" : "Play";
  say("told", frame.wrong || (frame.full ? "A table of the case is full: walls and inflow stay as they are. Begin again from the start." : ""));
  const changed = frame.changed.map((name) => live.head.sliders.find((one) => one.name === name).label).join(", ");
  say("changed", changed && `Not in a downloaded case: ${changed}, changed while the flow ran. Begin again from the start, and it is.`);
}

function say(name, text) {
  if (byClass(name).textContent !== text) byClass(name).textContent = text;
}

// ---- curves ----

function addPoints({ time, forces, playing }) {
  if (time < live.since) clearPoints();
  if (time >= live.since + live.every) addPoint(time, forces);
  if (playing && performance.now() - live.curvesAt < CURVES_EVERY) return;  // a flow that pauses shows all of them
  live.curvesAt = performance.now();
  document.dispatchEvent(new Event("curves"));
}

function addPoint(time, forces) {
  live.since = time;
  const add = (line, value) => { line.x.push(live.head.time + time); line.y.push(value); };
  if (forces) linesOf("force").forEach((line, k) => add(line, forces[live.head.forces[k]][0] / 1000));
  const [front] = linesOf("front");
  add(front, frontOf(live.p));
  linesOf("depth").forEach((line) => add(line, depthOf(live.p)));
  if (front.x.length > MOST_POINTS) thinPoints();
}

// The lines of a chart that the page goes on with; none where it has no such chart.
function linesOf(name) {
  const chart = live.head.charts[name];
  return chart ? pageData.curves[chart.number].panels[0].lines.slice(0, chart.own) : [];
}

function eachLine(act) {
  for (const name of Object.keys(live.head.charts)) linesOf(name).forEach(act);
}

function clearPoints() {
  live.since = -1;
  live.every = POINT_EVERY;
  eachLine((line) => Object.assign(line, { x: [], y: [] }));
}

function thinPoints() {
  live.every *= 2;
  eachLine((line) => { for (const name of ["x", "y"]) line[name] = line[name].filter((_, k) => k % 2 === 0); });
}

// Place of the front of a jump: where the mass depth first comes to its level; else of the discs. Null: there is none.
function frontOf(p) {
  const { low, width } = p.run.bins, { level } = live.head.front;
  if (level === null || !p.deep) {
    const own = p.found.x.slice(0, p.found.own).sort();
    return own.length ? own[Math.floor(0.98 * (own.length - 1))] : null;
  }
  const k = p.depth.findIndex((depth) => depth >= level);
  if (k < 0) return null;
  const share = k > 0 ? (level - p.depth[k - 1]) / (p.depth[k] - p.depth[k - 1]) : 0.5;
  return low + (k - 0.5 + share) * width;
}

// Mass depth where the page has a curve of it, m; null beyond the bins.
function depthOf(p) {
  const { low, width } = p.run.bins;
  return p.depth[Math.floor((live.head.depthAt - low) / width)] ?? null;
}

// ---- the run as it was recorded, next to it ----

// What view.js draws of a run of the page, but for what is shown of it.
function playerOf(element, run) {
  const canvas = element.querySelector("canvas"), share = run.share ?? 1;
  return {
    element, canvas, run, index: 0, context: canvas.getContext("2d", { alpha: false, willReadFrequently: true }), colour: "speed",
    pointers: new Map(), picked: null, pinned: false, time: run.times[0], deep: run.gravity.some((part) => part !== 0),
    grown: share < 0.5 ? 1 / Math.sqrt(share) : 1, found: roomFor(run), depth: new Float64Array(run.bins.count), digits: 3,
  };
}

// Both drawings have the same axes and colours; curves of the recorded one are computed once.
function joinViews() {
  const element = document.getElementById("was");
  if (!element || live.was) return;
  const run = runOf(0), { about } = live.head;
  live.was = playerOf(element, run);
  run.fastest = about.fastest = Math.max(run.fastest, about.fastest);
  element.hidden = false;
  for (const name of ["front", "depth"]) if (live.head.charts[name]) findRecorded(name === "front" ? frontOf : depthOf, name);
}

function findRecorded(of, name) {
  const { was } = live, { number, own } = live.head.charts[name], line = pageData.curves[number].panels[0].lines[own];
  Object.assign(line, { x: was.run.times, y: was.run.times.map((time) => {
    massDepth(was.run, discsAt(was.run, time, was.found), was.depth);
    return of(was);
  }) });
}

// The recorded run at the time of the flow, in the same view; its last frame where the flow has gone on for longer.
function showRecorded(again = false) {
  const { was, p, head } = live;
  if (!was) return;
  const { times } = was.run, end = times[times.length - 1], time = head.time + p.time;
  was.time = Math.min(Math.max(time, times[0]), end);
  const { x, y, scale } = p.view, seen = JSON.stringify([x, y, scale, p.sized.width, p.high]);
  Object.assign(was.run, { seen: p.run.seen, bed: p.run.bed });
  if (part(p, "colour").value === "speed" || was.run.radii.length > 1) was.colour = p.colour;
  say("was-told", time > end ? `The run as it was recorded, at its end, t = ${short(end)} s:` : "The run as it was recorded, at the same time:");
  if (again || seen !== live.seen) {
    live.seen = seen;
    was.view = { x, y, scale };
    layOut(was);
  } else draw(was);
}

function layOutBoth() {
  layOut(live.p);
  showRecorded(true);
}

// ---- what the flow begins with ----

// Begin with another of the starts that the page has; the sliders stay where they are, as far as it has them.
async function beginWith(number) {
  play(false);
  const name = number ? String(number) : "", [image, head] = await Promise.all(["image" + name, "head" + name].map(unpacked));
  const { again, charts } = live.head;
  live.head = { ...JSON.parse(new TextDecoder().decode(head)), again, charts };
  if (live.was) live.head.about.fastest = live.was.run.fastest;
  for (const key of ["zeros", "order", "last"]) live[key] = null;
  clearPoints();
  live.drawn = 0;
  live.worker.terminate();
  for (const slider of document.querySelectorAll(".axis")) slider.disabled = !sliderOf(slider);
  startWorker(image);
  if (!still) play(true);
}

function startWorker(image) {
  live.worker = new Worker(workerUrl());
  live.worker.onmessage = hear;
  live.worker.onerror = (event) => say("told", `The page cannot compute here: ${event.message}.`);
  live.worker.postMessage({ act: "begin", module: live.core, image, head: live.head, values: live.p ? valuesNow() : undefined });
  if (live.p) for (const [name, value] of Object.entries(valuesNow())) live.worker.postMessage({ act: "want", name, value });
}

// ---- sliders, buttons and keys ----

// What the head of this start tells of a slider.
function sliderOf(slider) {
  return live.head.sliders.find(({ name }) => name === slider.dataset.name);
}

function startSliders() {
  for (const slider of document.querySelectorAll(".axis")) {
    const one = sliderOf(slider), { name, kind, unit } = one;
    if (kind !== "number") slider.step = one.step;
    slider.value = kind === "number" ? one.stops.findIndex(({ value }) => value === one.value) : one.value;
    const value = () => (kind === "number" ? nearestStop(sliderOf(slider), one.stops[slider.value].value) : Number(slider.value));
    const tellValue = () => {
      const text = `${short(value())} ${unit}`.trim();
      slider.parentElement.querySelector("output").textContent = text;
      slider.setAttribute("aria-valuetext", text);
    };
    slider.addEventListener("input", () => {
      tellValue();
      live.worker.postMessage({ act: "want", name, value: value() });
    });
    live.values = { ...live.values, [name]: value };
    tellValue();
  }
}

// The value of a number that is nearest of those that a start has.
function nearestStop({ stops }, wanted) {
  return stops.map(({ value }) => value).reduce((a, b) => (Math.abs(b - wanted) < Math.abs(a - wanted) ? b : a));
}

// The present values of the sliders, of those that this start has.
function valuesNow() {
  return Object.fromEntries(live.head.sliders.map(({ name }) => [name, live.values[name]()]));
}

function play(on) {
  live.worker.postMessage({ act: "play", on });
  if (live.last) Object.assign(live.last, { playing: on });
  byClass("play").textContent = on ? "Pause" : "Play";
}

function oneStep() {
  play(false);
  live.worker.postMessage({ act: "step", steps: 1 });
}

// From the start: walls and inflow go to where their sliders are, numbers of the case are those of theirs at once.
function again() {
  clearPoints();
  const values = valuesNow();
  live.worker.postMessage({ act: "again", values });
  for (const [name, value] of Object.entries(values)) live.worker.postMessage({ act: "want", name, value });
}

function key(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, summary, .axis")) return;
  if (event.key === " " && event.target.closest("button, a")) return;
  const acts = {
    " ": () => play(byClass("play").textContent === "Play"),
    ".": oneStep,
    "+": () => zoomByKey(live.p, 1.5),
    "-": () => zoomByKey(live.p, 1 / 1.5),
    0: () => showWhole(live.p),
  };
  if (!acts[event.key] || !live.p) return;
  event.preventDefault();
  acts[event.key]();
}

function startButtons() {
  byClass("play").addEventListener("click", () => play(byClass("play").textContent === "Play"));
  byClass("step").addEventListener("click", oneStep);
  byClass("again").addEventListener("click", again);
  if (byClass("verify")) byClass("verify").addEventListener("click", verify);
  byClass("download").addEventListener("click", async () => save(caseText(live.head, await asked("tables"))));
  document.addEventListener("keydown", key);
  document.addEventListener("visibilitychange", () => { if (document.hidden) play(false); });
}

// ---- the case of this flow ----

// What the thread answers to a question: its tables, or its state.
function asked(act) {
  return new Promise((resolve) => {
    live.asked.push([act, resolve]);
    live.worker.postMessage({ act });
  });
}

function save(text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/yaml" }));
  link.download = `${live.head.name}_live.yaml`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// ---- computing a run again, in a thread of its own ----

async function verify() {
  const { again } = live.head, worker = new Worker(workerUrl()), button = byClass("verify");
  const end = (text) => { say("verified", text); worker.terminate(); button.disabled = false; };
  button.disabled = true;
  play(false);
  worker.onmessage = ({ data: { verified, failed } }) => {
    if (failed) end(failed);
    else if (!verified.done) say("verified", `Step ${verified.step} of ${again.steps}.`);
    else if (verified.far) end(farText(verified.far));
    else if (verified.parts) end(partedText(verified.parts));
    else end(sameText(again));
  };
  const [core, image] = await Promise.all(["core", "image-again"].map(unpacked));
  worker.postMessage({ act: "verify", module: core, image, head: live.head });
}

function sameText({ checks, digits, steps }) {
  const states = checks.filter(([, , state]) => state).length;
  return `The same ${steps.toLocaleString("en")} steps, to the last bit: the end${states ? ` and the states at ${states} times` : ""}; ` +
    `${checks.length} frames to the ${digits} digits of the dump.`;
}

function timeOf(step) {
  return ((step - live.head.start) * live.head.again.timeStep).toFixed(4);
}

function partedText({ step, wrong, state }) {
  const at = `at step ${step}, t = ${timeOf(step)} s`;
  if (wrong) return `It ended ${at}: ${wrong}.`;
  return `They part: the first ${state ? "state" : "frame"} that differs is ${at}. The stored run is of another version, or was changed.`;
}

// Of a run of LAMMPS: how far its discs are from those that were computed here, and why.
function farText({ found, wrong }) {
  const rows = found.map(({ step, most, median, alone }) => (
    `t = ${timeOf(step)} s: ${most === null ? "none in both" : `${most.toPrecision(2)} (median ${median.toPrecision(2)})`}` +
    (alone ? `, ${alone} not in both` : "")));
  return `Largest distance of a disc from where the run has it, in diameters: ${rows.join("; ")}. LAMMPS sums in another order than the ` +
    `native engine of this page; contacts amplify the last digits.${wrong ? ` It ended then: ${wrong}.` : ""}`;
}

// ---- the page ----

function workerUrl() {
  live.url ??= URL.createObjectURL(new Blob([COMPUTING], { type: "text/javascript" }));
  return live.url;
}

function hear({ data }) {
  if (data.failed) return say("told", data.failed);
  const question = live.asked.findIndex(([act]) => act in data);
  if (question >= 0) {
    const [[act, resolve]] = live.asked.splice(question, 1);
    return resolve(data[act]);
  }
  live.frame = data;
  if (document.hidden) return show();
  return requestAnimationFrame(show);
}

// The start that a page begins with: on a phone the one with fewer discs, where there is one.
async function firstStart() {
  const list = byClass("begin"), heads = await Promise.all(Array.from(list ? list.options : [0], (_, k) => unpacked("head" + (k || ""))));
  const read = heads.map((head) => JSON.parse(new TextDecoder().decode(head)));
  const few = matchMedia("(pointer: coarse) and (max-width: 40rem)").matches ? read.findIndex((head) => head.few) : -1;
  const { again, charts } = read[0], number = Number(document.documentElement.dataset.begin ?? Math.max(0, few));
  if (list) {
    list.value = String(number);
    list.addEventListener("change", () => beginWith(Number(list.value)));
  }
  live.head = { ...read[number], again, charts };
  return number;
}

async function start() {
  const number = await firstStart(), [core, image] = await Promise.all(["core", "image" + (number || "")].map(unpacked));
  live.core = core;
  clearPoints(); // each line has points of its own
  startSliders();
  startButtons();
  startWorker(image);
  if (!still) play(true);
}

// A page in a frame tells what holds the frame how high it is.
if (parent !== window) {
  const tellHeight = () => parent.postMessage({ height: Math.ceil(document.body.getBoundingClientRect().height) }, "*");
  new ResizeObserver(tellHeight).observe(document.body);
}

start().catch((error) => say("told", `The page cannot compute here: ${error.message}.`));

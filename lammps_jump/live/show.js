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
  const element = document.getElementById("flow"), canvas = element.querySelector("canvas");
  const run = runNow(frame), p = {
    element, canvas, index: 0, context: canvas.getContext("2d", { alpha: false, willReadFrequently: true }), colour: "speed",
    pointers: new Map(), run, picked: null, pinned: false, time: frame.time, deep: run.gravity.some((part) => part !== 0),
    grown: 1, found: roomFor(run), depth: new Float64Array(run.bins.count), digits: 3,
  };
  live.p = p;
  listenToPointer(p);
  for (const name of ["out", "in"]) part(p, name).addEventListener("click", () => zoomByKey(p, name === "in" ? 1.5 : 1 / 1.5));
  part(p, "whole").addEventListener("click", () => showWhole(p));
  part(p, "colour").addEventListener("change", () => { p.colour = part(p, "colour").value; draw(p); });
  new ResizeObserver(() => layOut(p)).observe(element);
  darkness.addEventListener("change", () => layOut(p));
  layOut(p);
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
  if (follows(p)) showHome(p);
  else draw(p);
  live.last = frame;
  live.drawn++;
  addPoints(frame);
  tellState(frame);
  live.worker.postMessage({ act: "shown" });
}

// What view.js calls for the clock of a picture.
function showClock() {
  const { last } = live;
  if (!last) return;
  const pace = last.pace === null || !last.playing ? "" : last.pace >= REAL ? ", real time" : `, ${last.pace.toPrecision(2)} of real time`;
  const clock = `t = ${live.p.time.toFixed(3)} s, step ${last.step - live.head.start}${pace}`;
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

function addPoints({ time, forces }) {
  if (time < live.since) clearPoints();
  if (time < live.since + live.every) return;
  live.since = time;
  const [front] = pageData.curves.slice(-1), felt = pageData.curves.length > 1 ? pageData.curves[0].panels[0].lines : [];
  const add = (line, value) => { line.x.push(time); line.y.push(value); };
  if (forces) felt.forEach((line, k) => add(line, forces[live.head.forces[k]][0] / 1000));
  add(front.panels[0].lines[0], frontNow());
  if (front.panels[0].lines[0].x.length > MOST_POINTS) thinPoints();
  if (performance.now() - live.curvesAt < CURVES_EVERY) return;
  live.curvesAt = performance.now();
  document.dispatchEvent(new Event("curves"));
}

function eachLine(act) {
  for (const chart of pageData.curves) for (const line of chart.panels[0].lines) act(line);
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
function frontNow() {
  const { p, head } = live, { low, width } = p.run.bins, { level } = head.front;
  if (level === null || !p.deep) {
    const own = p.found.x.slice(0, p.found.own).sort();
    return own.length ? own[Math.floor(0.98 * (own.length - 1))] : null;
  }
  const k = p.depth.findIndex((depth) => depth >= level);
  if (k < 0) return null;
  const share = k > 0 ? (level - p.depth[k - 1]) / (p.depth[k] - p.depth[k - 1]) : 0.5;
  return low + (k - 0.5 + share) * width;
}

// ---- sliders, buttons and keys ----

function startSliders() {
  for (const slider of document.querySelectorAll(".axis")) {
    const one = live.head.sliders.find(({ name }) => name === slider.dataset.name);
    if (one.kind !== "number") slider.step = one.step;
    slider.value = one.kind === "number" ? one.stops.findIndex(({ value }) => value === one.value) : one.value;
    const value = () => (one.kind === "number" ? one.stops[slider.value].value : Number(slider.value));
    const tellValue = () => {
      const text = `${short(value())} ${one.unit}`.trim();
      slider.parentElement.querySelector("output").textContent = text;
      slider.setAttribute("aria-valuetext", text);
    };
    slider.addEventListener("input", () => {
      tellValue();
      live.worker.postMessage({ act: "want", name: one.name, value: value() });
    });
    live.values = { ...live.values, [one.name]: value };
    tellValue();
  }
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

// From the start: walls and inflow go to where their sliders stand, numbers of the case are those of theirs at once.
function again() {
  clearPoints();
  const values = Object.fromEntries(live.head.sliders.map(({ name }) => [name, live.values[name]()]));
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
    else if (verified.parts) end(partedText(verified.parts));
    else end(`The same: ${again.checks.length} frames to the ${again.digits} digits of the dump, and the end of ${again.steps} steps to the last bit.`);
  };
  const [core, image] = await Promise.all(["core", "image-again"].map(unpacked));
  worker.postMessage({ act: "verify", module: core, image, head: live.head });
}

function partedText({ step, wrong }) {
  const at = `at step ${step}, t = ${((step - live.head.start) * live.head.again.timeStep).toFixed(4)} s`;
  return wrong ? `It ended ${at}: ${wrong}.` : `They part: the first frame that differs is ${at}. The stored run is of another version, or was changed.`;
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

async function start() {
  const [core, image, head] = await Promise.all(["core", "image", "head"].map(unpacked));
  live.head = JSON.parse(new TextDecoder().decode(head));
  live.worker = new Worker(workerUrl());
  live.worker.onmessage = hear;
  live.worker.onerror = (event) => say("told", `The page cannot compute here: ${event.message}.`);
  clearPoints(); // each line has points of its own
  startSliders();
  startButtons();
  live.worker.postMessage({ act: "begin", module: core, image, head: live.head });
  if (!still) play(true);
}

start().catch((error) => say("told", `The page cannot compute here: ${error.message}.`));

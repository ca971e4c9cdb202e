"use strict";
// The player: time, buttons and keys of the canvas that view.js draws; pointer.js has its pointer.
// All players and curves of a page share one time through events on the document: "seek" (s) and "play" (on, rate) are
// sent to the players, "time" (s) is sent by the first one.

const LONGEST = 1000;
const FRAMES_A_SECOND = 10;
const HALF = 0.5;

const players = [];
const still = matchMedia("(prefers-reduced-motion: reduce)");

function tell(name, detail) {
  document.dispatchEvent(new CustomEvent(name, { detail }));
}

// ---- start ----

function startPlayer(element, index) {
  const canvas = element.querySelector("canvas"), list = element.querySelector(".run");
  const p = {
    element, canvas, index, context: canvas.getContext("2d", { alpha: false, willReadFrequently: true }),
    playing: false, rate: 1, colour: "speed", pointers: new Map(),
  };
  takeRun(p, list ? list.value : index);
  p.time = p.run.times[0];
  if (list) list.addEventListener("change", () => { takeRun(p, list.value); layOut(p); });
  players.push(p);
  element.hidden = false;
  for (const folded of document.querySelectorAll("details.still")) folded.open = false;
  setUp(p);
  return p;
}

// Show a run of the page, at the time that is shown.
function takeRun(p, number) {
  const run = runOf(number);
  const { times, share } = run, timed = run.unit === "s", bar = part(p, "time");
  Object.assign(p, {
    run, picked: null, pinned: false, end: times[times.length - 1], digits: timed ? 2 : 0,
    deep: run.gravity.some((part) => part !== 0), // without gravity there is no depth
    pace: timed ? 1 : FRAMES_A_SECOND * (times[1] - times[0] || 1), // steps have no duration
    grown: share < HALF ? 1 / Math.sqrt(share) : 1, // few discs represent the area of all
    oldest: oldest(run), found: roomFor(run), depth: new Float64Array(run.bins.count),
  });
  p.time = Math.min(p.time, p.end);
  bar.min = times[0];
  bar.max = p.end;
  offerColours(p);
  offerThings(p);
  showForce(p);
  part(p, "thin").hidden = share === 1;
  part(p, "thin").textContent = "There are too many discs for a page: " +
    (p.colour === "packing" ? "it shows the share of area that they cover. In other colours " : "") +
    `${short(100 * share)} % of them are shown` + (p.grown > 1 ? ", each as large as all that it stands for." : ".");
}

function setUp(p) {
  listenToButtons(p);
  listenToPointer(p);
  listenToEvents(p);
  new ResizeObserver(() => layOut(p)).observe(p.element);
  darkness.addEventListener("change", () => layOut(p));
  layOut(p);
}

function offerColours(p) {
  const { radii, first } = p.run;
  const map = p.run.map && p.run.map.name, list = part(p, "colour");
  const useful = { speed: true, size: radii.length > 1, age: first.some((frame) => frame > 0), [map]: true };
  for (const option of list.options) option.hidden = option.disabled = !useful[option.value];
  list.value = p.colour = map === "packing" ? map : useful[p.colour] ? p.colour : "speed";
}

// ---- time ----

function setTime(p, time) {
  const now = Math.min(Math.max(time, p.run.times[0]), p.end);
  if (now === p.time && p.drawnAt === now) return;
  p.time = p.drawnAt = now;
  if (follows(p)) showHome(p);
  else draw(p);
  if (p.index === 0) tell("time", now);
}

function setPlaying(p, on) {
  if (on && !p.playing) {
    if (p.time >= p.end) setTime(p, p.run.times[0]);
    p.last = null;
    requestAnimationFrame((now) => advance(p, now));
  }
  p.playing = on;
  part(p, "play").textContent = on ? "Pause" : "Play";
}

function advance(p, now) {
  if (!p.playing) return;
  const passed = p.last === null ? 0 : Math.min(now - p.last, LONGEST); // a hidden page is not drawn for a while
  setTime(p, p.time + passed / 1000 * p.rate * p.pace);
  p.last = now;
  if (p.time >= p.end) return finish(p);
  requestAnimationFrame((next) => advance(p, next));
}

function finish(p) {
  setPlaying(p, false);
  if (p.film) p.film.stop();
}

// So many stored frames on or back.
function step(p, frames) {
  const { times } = p.run, frame = frameBefore(times, p.time);
  const back = frames < 0 && p.time > times[frame] ? 1 : 0;
  const goal = Math.min(Math.max(frame + frames + back, 0), times.length - 1);
  tell("play", { on: false });
  tell("seek", times[goal]);
}

function showClock(p) {
  const clock = `${p.time.toFixed(p.digits)} / ${p.end.toFixed(p.digits)} ${p.run.unit}`;
  part(p, "clock").textContent = clock;
  const bar = part(p, "time"), first = p.run.times[0];
  bar.value = p.time;
  bar.style.setProperty("--done", `${100 * (p.time - first) / (p.end - first || 1)}%`);
  bar.setAttribute("aria-valuetext", clock);
}

// ---- buttons and keys ----

function listenToButtons(p) {
  const on = (name, event, act) => part(p, name).addEventListener(event, act);
  on("time", "input", () => tell("seek", Number(part(p, "time").value)));
  on("play", "click", () => tell("play", { on: !p.playing }));
  on("back", "click", () => step(p, -1));
  on("on", "click", () => step(p, 1));
  on("rate", "change", () => tell("play", { on: p.playing, rate: Number(part(p, "rate").value) }));
  on("colour", "change", () => { p.colour = part(p, "colour").value; draw(p); });
  on("thing", "change", () => pin(p, p.things[part(p, "thing").value] || null));
  on("out", "click", () => keepingPlace(p, () => zoomByKey(p, 1 / 1.5)));
  on("in", "click", () => keepingPlace(p, () => zoomByKey(p, 1.5)));
  on("whole", "click", () => keepingPlace(p, () => showWhole(p)));
  on("save", "click", () => savePicture(p));
  part(p, "film").hidden = !filmKind(p);
  on("film", "click", () => (p.film ? p.film.stop() : saveFilm(p)));
  if (p.index === 0) document.addEventListener("keydown", (event) => key(p, event));
}

// The buttons stay under the pointer where the drawing above them changes its height.
function keepingPlace(p, act) {
  const before = p.sized.height;
  act();
  window.scrollBy(0, p.sized.height - before);
}

function listenToEvents(p) {
  document.addEventListener("seek", ({ detail }) => setTime(p, detail));
  document.addEventListener("play", ({ detail }) => {
    p.rate = detail.rate || p.rate;
    part(p, "rate").value = p.rate;
    setPlaying(p, detail.on);
  });
}

function key(p, event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, textarea, summary, .axis")) return;
  if (event.key === " " && event.target.closest("button")) return;
  const focused = players.filter(({ element }) => element.contains(document.activeElement));
  const each = (act) => () => (focused.length ? focused : players).forEach(act);
  const shift = event.shiftKey ? 60 : 0, move = (right, down) => each((one) => moveView(one, right, down));
  const acts = {
    " ": () => tell("play", { on: !p.playing }),
    ArrowLeft: shift ? move(shift, 0) : () => step(p, -1),
    ArrowRight: shift ? move(-shift, 0) : () => step(p, 1),
    ArrowUp: shift && move(0, shift),
    ArrowDown: shift && move(0, -shift),
    Home: () => tell("seek", p.run.times[0]),
    End: () => tell("seek", p.end),
    "+": each((one) => zoomByKey(one, 1.5)),
    "-": each((one) => zoomByKey(one, 1 / 1.5)),
    0: each(showWhole),
    Enter: event.target === focused[0]?.canvas && (() => pinMiddle(focused[0])),
    Escape: players.some(({ pinned }) => pinned) && each((one) => pin(one, null)),
  };
  if (!acts[event.key]) return;
  event.preventDefault();
  acts[event.key]();
}

// ---- films ----

// The kind of film that the browser records, if any.
function filmKind(p) {
  if (!p.canvas.captureStream || !window.MediaRecorder) return "";
  return ["video/mp4", "video/webm"].find((kind) => MediaRecorder.isTypeSupported(kind)) || "";
}

// Play from here and record it, to the end or until the button is pressed again.
function saveFilm(p) {
  const kind = filmKind(p), parts = [];
  p.film = new MediaRecorder(p.canvas.captureStream(30), { mimeType: kind, videoBitsPerSecond: 8e6 });
  p.film.ondataavailable = ({ data }) => parts.push(data);
  p.film.onstop = () => {
    p.film = null;
    part(p, "film").textContent = "Save film";
    setPlaying(p, false);
    save(p, new Blob(parts, { type: kind }), kind.slice(6));
  };
  part(p, "film").textContent = "Stop and save";
  p.film.start();
  tell("play", { on: true });
}

// ---- the page ----

function startPlayers() {
  document.querySelectorAll(".player").forEach(startPlayer);
  if (players.length && !still.matches) tell("play", { on: true });
}

startPlayers();

"use strict";
// Pointer of the canvas that view.js draws: moving and zooming what is shown, values of what is pointed at, the force on
// what is clicked against time; the picture.

const PICKED_WITHIN = 14;
// Pixels around the outline of a wall, or an open line, that belong to it.
const BESIDE_WALL = 6;

function listenToPointer(p) {
  const { canvas } = p;
  canvas.addEventListener("pointerdown", (event) => pointerDown(p, event));
  canvas.addEventListener("pointermove", (event) => pointerMove(p, event));
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointerUp(p, event));
  canvas.addEventListener("pointerleave", () => p.pinned || pick(p, null));
  canvas.addEventListener("wheel", (event) => wheel(p, event), { passive: false });
}

function pointerDown(p, event) {
  p.canvas.setPointerCapture(event.pointerId);
  p.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
  p.dragged = false;
}

function pointerMove(p, event) {
  const before = p.pointers.get(event.pointerId), now = [event.offsetX, event.offsetY];
  if (!before) return p.pinned || pick(p, thingUnder(p, now, (wall) => wall.body || wall.force));
  if (!p.dragged && Math.hypot(now[0] - before[0], now[1] - before[1]) < 4) return undefined;
  p.dragged = true;
  const other = [...p.pointers].find(([id]) => id !== event.pointerId);
  p.pointers.set(event.pointerId, now);
  if (other) return pinch(p, before, now, other[1]);
  return moveView(p, now[0] - before[0], now[1] - before[1]);
}

function pinch(p, before, now, other) {
  const apart = (a) => Math.max(10, Math.hypot(a[0] - other[0], a[1] - other[1]));
  zoom(p, apart(now) / apart(before), ...placeOf(p, [(now[0] + other[0]) / 2, (now[1] + other[1]) / 2]));
}

function pointerUp(p, event) {
  if (p.pointers.delete(event.pointerId) && !p.dragged) {
    const thing = thingUnder(p, [event.offsetX, event.offsetY]);
    pin(p, p.pinned && thing === p.picked ? null : thing);
  }
}

// Keep a thing picked and show the force on it against time; null lets go of what was.
function pin(p, thing) {
  p.pinned = thing !== null;
  pick(p, thing);
  showForce(p);
}

// By the keyboard: the thing in the middle of the view, else the disc that is nearest to it.
function pinMiddle(p) {
  const middle = [MARGIN.left + p.wide / 2, MARGIN.legend + p.high / 2], thing = thingUnder(p, middle);
  pin(p, thing === null ? discUnder(p, middle, Infinity) : thing);
}

// The wheel zooms with Ctrl, or where the drawing has the focus; else the page moves.
function wheel(p, event) {
  if (!event.ctrlKey && document.activeElement !== p.canvas) return;
  event.preventDefault();
  zoom(p, Math.exp(-event.deltaY / 300), ...placeOf(p, [event.offsetX, event.offsetY]));
}

// Place in metres of a point of the canvas.
function placeOf(p, [left, top]) {
  const { view } = p;
  return [view.x + (left - MARGIN.left - p.wide / 2) / view.scale, view.y - (top - MARGIN.legend - p.high / 2) / view.scale];
}

// Number of the disc under a point, else the wall there, of some walls, else the disc close by; null where there is none.
function thingUnder(p, point, some = () => true) {
  const disc = discUnder(p, point, 0);
  if (disc !== null) return disc;
  const wall = wallUnder(p, point, some);
  return wall === null ? discUnder(p, point) : wall;
}

// Walls and gates that are there now, and have a name.
function wallsNow(p) {
  return [...p.run.walls, ...p.run.gates.filter((gate) => p.time < gate.until)].filter(({ name }) => name);
}

// The wall under a point, a body or one that moves before one at rest; null where there is none.
function wallUnder(p, point, some) {
  if (point[1] > MARGIN.legend + p.high) return null;
  const [x, y] = placeOf(p, point), reach = BESIDE_WALL / p.view.scale;
  const odd = (ring) => ring.filter(([x1, y1], k) => {
    const [x0, y0] = ring[(k || ring.length) - 1];
    return y0 > y !== y1 > y && x < x0 + (x1 - x0) * (y - y0) / (y1 - y0);
  }).length % 2;
  const away = ([x0, y0], [x1, y1]) => {
    const long = (x1 - x0) ** 2 + (y1 - y0) ** 2 || 1;
    const share = Math.min(1, Math.max(0, ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / long));
    return Math.hypot(x0 + share * (x1 - x0) - x, y0 + share * (y1 - y0) - y);
  };
  const beside = (points) => points.some((end, k) => k && away(points[k - 1], end) < reach);
  const holds = (wall) => {
    const rings = wall.outlines.map((ring) => placed(p, wall, ring));
    return rings.filter(odd).length % 2 !== Number(wall.hollow) || rings.some((ring) => beside([...ring, ring[0]])) ||
      wall.lines.some((line) => beside(placed(p, wall, line)));
  };
  const there = wallsNow(p).filter((wall) => some(wall) && holds(wall));
  return there.find((wall) => wall.body) || there.find((wall) => wall.about) || there.find((wall) => wall.force) || there[0] || null;
}

// Number of the disc under a point, or so many pixels from it; null where there is none.
function discUnder(p, point, within = PICKED_WITHIN) {
  if (point[1] > MARGIN.legend + p.high || p.colour === "packing") return null;
  const [x, y] = placeOf(p, point), { found } = p;
  let best = null, least = within / p.view.scale;
  for (let k = 0; k < found.count; k++) {
    const beyond = Math.hypot(found.x[k] - x, found.y[k] - y) - radiusOf(p, k);
    if (beyond < least) [best, least] = [found.disc[k], beyond];
  }
  return best;
}

function pick(p, thing) {
  if (thing === p.picked) return;
  p.picked = thing;
  draw(p);
}

// Values of the disc or the body that is pointed at.
function showPicked(p) {
  const tip = part(p, "tip"), { found } = p;
  if (p.picked && p.picked.outlines) return p.picked.body ? showBody(p, tip, p.picked) : showWall(p, tip, p.picked);
  const k = p.picked === null ? -1 : found.disc.subarray(0, found.count).indexOf(p.picked);
  tip.hidden = k < 0;
  if (k < 0) return undefined;
  const speed = Math.hypot(found.u[k], found.v[k]);
  tip.textContent = `disc ${p.run.ids[p.picked]}\nx ${place(found.x[k])}, y ${place(found.y[k])} m\n` +
    `${place(speed)} m/s (${place(found.u[k])}, ${place(found.v[k])})\ndiameter ${short(2 * radiusOf(p, k) / p.grown)} m` +
    (p.run.map && p.run.map.name === "pressure" ? `\npressure around it ${short(mapValue(p, k))} Pa` : "");
  return placeTip(p, tip, MARGIN.left + column(p, found.x[k]), MARGIN.legend + row(p, found.y[k]), radiusOf(p, k) * p.view.scale);
}

// Two decimals, no -0.00.
function place(value) {
  return (Number(value.toFixed(2)) || 0).toFixed(2).replace("-", "\u2212");
}

// Name, mass, speed and force of the discs of a body, what is known of them, near its centre or the edge of the view.
function showBody(p, tip, wall) {
  const { mass, centre, vx, vy, fx, fy } = wall.body, [[x, y]] = placed(p, wall, [centre]);
  const within = (value, low, size) => Math.min(Math.max(value, low), low + size);
  const pair = (across, up, show, unit) => {
    const [u, v] = [across, up].map((way) => wayNow(p, way));
    return u === null || v === null ? "" : `\n${show(Math.hypot(u, v))} ${unit} (${show(u)}, ${show(v)})`;
  };
  tip.hidden = false;
  tip.textContent = `${wall.name}\nmass ${short(mass)} kg/m` + pair(vx, vy, place, "m/s") +
    pair(fx, fy, short, "N/m").replace("\n", "\nforce of the discs ");
  placeTip(p, tip, within(MARGIN.left + column(p, x), MARGIN.left, p.wide), within(MARGIN.legend + row(p, y), MARGIN.legend, p.high), halfWide(p, wall));
}

// Name of a wall and the force of the discs on it now, next to the middle of what is seen of it.
function showWall(p, tip, wall) {
  const force = forceNow(p, wall), [x, y] = middleOf(p, wall);
  tip.hidden = false;
  tip.textContent = wall.name + (force ? `\nforce of the discs ${short(Math.hypot(...force))} N/m (${force.map(short).join(", ")})` : "");
  placeTip(p, tip, MARGIN.left + column(p, x), MARGIN.legend + row(p, y), halfWide(p, wall));
}

// Half of the width of what is pinned, in pixels, where that leaves room next to it: its arrow stays in sight.
function halfWide(p, wall) {
  if (!p.pinned) return 0;
  const places = [...wall.outlines, ...wall.lines].flatMap((part) => placed(p, wall, part)).map(([x]) => x);
  const half = (Math.max(...places) - Math.min(...places)) / 2 * p.view.scale;
  return half < p.wide / 6 ? half : 0;
}

// Middle of what is seen of a wall, m; that of a body is its centre.
function middleOf(p, wall) {
  if (wall.body) return placed(p, wall, [wall.body.centre])[0];
  const points = [...wall.outlines, ...wall.lines].flatMap((part) => placed(p, wall, part));
  return [[p.view.x, p.wide], [p.view.y, p.high]].map(([middle, size], axis) => {
    const half = size / p.view.scale / 2, places = points.map((point) => point[axis]);
    const cut = (value) => Math.min(Math.max(value, middle - half), middle + half);
    return (cut(Math.min(...places)) + cut(Math.max(...places))) / 2;
  });
}

// Force of the discs on a wall now, N/m: between the rows of its record; null where it is not known.
function forceNow(p, { force }) {
  const { time } = force || { time: [] }, last = time.length - 1;
  if (last < 0 || p.time < time[0] || p.time > time[last]) return null;
  const k = frameBefore(time, p.time), share = k < last ? (p.time - time[k]) / (time[k + 1] - time[k] || 1) : 0;
  return ["fx", "fy"].map((way) => force[way][k] + share * (force[way][Math.min(k + 1, last)] - force[way][k]));
}

// ---- the force on what is clicked, against time ----

// Offer the walls and bodies of a run, for those who do not point.
function offerThings(p) {
  const list = part(p, "thing");
  if (!list) return;
  list.length = 1;
  p.things = [...p.run.walls, ...p.run.gates].filter(({ name }) => name);
  p.things.forEach(({ name }, k) => list.add(new Option(name, k)));
  list.hidden = !p.things.length;
}

// The curve of the force on what is pinned, and how it was measured, or why there is none.
function showForce(p) {
  const figure = part(p, "felt"), note = part(p, "told"), list = part(p, "thing");
  if (!figure) return;
  const thing = p.pinned ? p.picked : null, whole = thing !== null && thing.outlines;
  list.value = whole ? String(p.things.indexOf(thing)) : "";
  const { what = "", lines, said = "" } = thing === null ? {} : whole ? forceOnWall(p, thing) : forceOnDisc(p, thing);
  figure.hidden = !lines;
  note.hidden = !said;
  note.textContent = said;
  if (!lines) return;
  const title = `Force on ${what}`, first = !figure.chart;
  const panel = { y: `Force [${lines.unit}]`, lines: lines.all, levels: [], marks: [], solids: [], xlim: [null, null], ylim: [null, null], height: 1 };
  figure.chart = { title, caption: title, x: p.run.unit === "s" ? "Time [s]" : "Step", time: true, window: null, panels: [panel] };
  figure.dataset.curve = `felt${p.index}`;
  figure.classList.add("curve");
  figure.querySelector("figcaption").firstChild.data = title;
  if (first) document.dispatchEvent(new CustomEvent("curves", { detail: figure }));
  else figure.dispatchEvent(new Event("numbers"));
}

// Lines along x and y of forces (N/m), in a unit that suits the largest; `error` is that of both.
function linesOf(x, fx, fy, error = null) {
  const most = Math.max(...[...fx, ...fy].filter((value) => value !== null).map(Math.abs), 0), kilo = most >= 1000;
  const shown = (values) => values.map((value) => (value === null ? null : value / (kilo ? 1000 : 1)));
  const line = (label, values, look) => ({ label, look, x, y: shown(values), ...(error && { error: shown(error) }) });
  return { unit: kilo ? "kN/m" : "N/m", all: [line("along x", fx, "first"), line("along y, upwards", fy, "second")] };
}

// Force on a wall or body: of its record, else at the frames.
function forceOnWall(p, wall) {
  const { name, force, body } = wall, { times } = p.run, what = `${name}, of the discs`;
  if (force) {
    const rows = force.taken === 1 ? "" : ` (${force.taken} rows of its record)`;
    return { what, lines: linesOf(force.time, force.fx, force.fy), said: `Means over ${short(force.each)} s${rows}, every step counted.` };
  }
  if (body && body.fx) {
    return { what, lines: linesOf(times, body.fx, body.fy), said: "At the frames; each is the mean over the time up to a row of its record." };
  }
  const why = p.run.grows ? "The run goes on: the force on walls is shown here when it has ended" :
    "No force on it was recorded: name it in probes.forces of the case, and run that again";
  return { said: `${name}: ${why}.` };
}

// Sum of the contacts of a disc, N/m: of the change of its velocity from frame to frame less gravity, in the middle between
// both. The page has velocities to half a quantum; the error is that of two of them.
function forceOnDisc(p, disc) {
  const { times, start, gravity, qv, ids, first, life, radii, shade, density, area, fixed, unit } = p.run, id = ids[disc];
  const without = (why) => ({ said: `Disc ${id}: ${why}.` });
  if (fixed && id >= fixed[0] && id <= fixed[1]) return without("it is held, and the page has no force on discs that do not move");
  if (!density || unit !== "s") return without("the page has no mass or no time to take its force from");
  if (life[disc] < 2) return without("it is in one frame alone, and its force is taken from two");
  const mass = density * area * radii[shade[disc]] ** 2, found = { x: [], fx: [], fy: [], error: [] };
  const rowIn = (frame) => {
    let low = start[frame], high = start[frame + 1] - 1;
    while (low < high) { const middle = (low + high) >> 1; if (p.run.disc[middle] < disc) low = middle + 1; else high = middle; }
    return low;
  };
  for (let k = first[disc]; k < first[disc] + life[disc] - 1; k++) {
    const long = times[k + 1] - times[k], [a, b] = [rowIn(k), rowIn(k + 1)];
    found.x.push((times[k] + times[k + 1]) / 2);
    found.fx.push(mass * ((p.run.u[b] - p.run.u[a]) * qv / long - gravity[0]));
    found.fy.push(mass * ((p.run.v[b] - p.run.v[a]) * qv / long - gravity[1]));
    found.error.push(p.run.grows ? 0 : mass * qv / Math.sqrt(6) / long);
  }
  const said = "Sum of its contacts: mass times the change of its velocity between two frames, less its weight. What happens within " +
    "a frame is in the mean alone. The page rounds velocities; the band is two standard errors of that.";
  return { what: `disc ${id}, of its contacts`, lines: linesOf(found.x, found.fx, found.fy, found.error), said };
}

// A number that is known at some frames, now: straight between them, null where it is not known.
function wayNow(p, way) {
  if (!way) return null;
  const { times } = p.run, k = frameBefore(times, p.time), share = (p.time - times[k]) / (times[k + 1] - times[k]);
  if (way[k] === null || !(share > 0)) return way[k];
  return way[k + 1] === null ? null : way[k] + share * (way[k + 1] - way[k]);
}

// Right of the disc, or left of it where there is no room; not beyond the edge of the player.
function placeTip(p, tip, x, y, radius) {
  const right = x + radius + 12, left = x - radius - 12 - tip.offsetWidth;
  tip.hidden = x < MARGIN.left || x > MARGIN.left + p.wide || y < MARGIN.legend || y > MARGIN.legend + p.high;
  tip.style.left = `${right + tip.offsetWidth > p.sized.width ? Math.max(0, left) : right}px`;
  tip.style.top = `${Math.max(0, y - tip.offsetHeight / 2)}px`;
}

// ---- the picture ----

function save(p, blob, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${p.run.name}_${p.time.toFixed(p.digits)}${p.run.unit}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function savePicture(p) {
  p.canvas.toBlob((blob) => save(p, blob, "png"));
}

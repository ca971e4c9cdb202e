"use strict";
// Pointer of the canvas that view.js draws: moving and zooming what is shown, values of what is pointed at; its picture.

const PICKED_WITHIN = 14;

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
  if (!before) return p.pinned || pick(p, thingUnder(p, now));
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
    p.pinned = thing !== null && !(p.pinned && thing === p.picked);
    pick(p, thing);
  }
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

// Number of the disc under a point, else the body there; null where there is neither.
function thingUnder(p, point) {
  const disc = discUnder(p, point);
  return disc === null ? bodyUnder(p, point) : disc;
}

// The wall that is the body under a point; null where there is none.
function bodyUnder(p, point) {
  if (point[1] > MARGIN.legend + p.high) return null;
  const [x, y] = placeOf(p, point);
  const odd = (ring) => ring.filter(([x1, y1], k) => {
    const [x0, y0] = ring[(k || ring.length) - 1];
    return y0 > y !== y1 > y && x < x0 + (x1 - x0) * (y - y0) / (y1 - y0);
  }).length % 2;
  return p.run.walls.find((wall) => wall.body && wall.outlines.some((ring) => odd(placed(p, wall, ring)))) || null;
}

// Number of the disc under a point, or close by; null where there is none.
function discUnder(p, point) {
  if (point[1] > MARGIN.legend + p.high || p.colour === "packing") return null;
  const [x, y] = placeOf(p, point), { found } = p;
  let best = null, least = PICKED_WITHIN / p.view.scale;
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
  if (p.picked && p.picked.body) return showBody(p, tip, p.picked);
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

// Name, mass, speed and force of the discs of a body, what is known of them, beside its centre or the edge of the view.
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
  placeTip(p, tip, within(MARGIN.left + column(p, x), MARGIN.left, p.wide), within(MARGIN.legend + row(p, y), MARGIN.legend, p.high), 0);
}

// A number that is known at some frames, now: straight between them, null where it is not known.
function wayNow(p, way) {
  if (!way) return null;
  const { times } = p.run, k = frameBefore(times, p.time), share = (p.time - times[k]) / (times[k + 1] - times[k]);
  if (way[k] === null || !(share > 0)) return way[k];
  return way[k + 1] === null ? null : way[k] + share * (way[k + 1] - way[k]);
}

// Right of the disc, or left of it where there is no room.
function placeTip(p, tip, x, y, radius) {
  const right = x + radius + 12, left = x - radius - 12 - tip.offsetWidth;
  tip.hidden = x < MARGIN.left || x > MARGIN.left + p.wide || y < MARGIN.legend || y > MARGIN.legend + p.high;
  tip.style.left = `${right + tip.offsetWidth > p.sized.width ? left : right}px`;
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

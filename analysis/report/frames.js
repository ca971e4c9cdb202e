"use strict";
// Frames of a run: unpacked from the text that analysis/report/frames.py writes, and the discs at any instant.

// Letters that frames.py does not use: a browser changes them, or they may end a script.
const LEFT_OUT = [0, 10, 13, 60];
const BASE = 128 - LEFT_OUT.length, LEAST = BASE ** 3;
const DIGITS = Uint8Array.from({ length: 128 }, (_, letter) => letter - LEFT_OUT.filter((one) => one < letter).length);
// Adaptive bits of a context, contexts of a kind of numbers, and columns of the table of discs.
const SLOTS = 32, OF_A_KIND = 32, COLUMNS = 8;
const UNREST = 8;
const UNKNOWN = -(2 ** 30);

// Players and curves of the page. Long lists of numbers are separate, in the order of the data: see page.py.
function readData() {
  const next = numbers(document.getElementById("numbers").textContent, 1);
  let whole = 0, step = 0;
  const one = (decimals) => {
    step = next(32 - Math.clz32(Math.abs(step)));
    whole += step;
    if (whole === UNKNOWN) return null;
    return decimals < 0 ? whole * 10 ** -decimals : whole / 10 ** decimals;
  };
  return JSON.parse(document.getElementById("data").textContent, (_, value) => (
    value && value.decimals !== undefined ? Array.from({ length: value.count }, () => one(value.decimals)) : value));
}

// A run of the page: packed in it, or one that grows and holds its rows itself.
function runOf(number) {
  const header = pageData.players[number];
  return header.grows ? header : unpackFrames(header, document.getElementById("frames" + number).textContent);
}

// All rows (a disc in a frame) as whole numbers, from the header of a player and its packed text.
function unpackFrames(header, text) {
  const { discs, rows, times } = header, next = numbers(text, 4 + COLUMNS + 1);
  const run = {
    ...header,
    ids: new Float64Array(discs), first: new Uint16Array(discs), life: new Uint16Array(discs),
    entryX: new Int32Array(discs), entryY: new Int32Array(discs), shade: new Uint8Array(discs),
    entryU: new Int8Array(discs), entryV: new Int8Array(discs),
    start: new Uint32Array(times.length + 1), disc: new Uint32Array(rows),
    x: new Int32Array(rows), y: new Int32Array(rows), u: new Int8Array(rows), v: new Int8Array(rows),
  };
  const columns = [run.ids, run.first, run.life, run.entryX, run.entryY, run.shade, run.entryU, run.entryV];
  for (let disc = 0; disc < discs; disc++) {
    columns.forEach((column, k) => { column[disc] = (disc ? column[disc - 1] : 0) + next(OF_A_KIND * (4 + k)); });
  }
  placeRows(run, next);
  if (run.map) readMap(run, next);
  run.most = mostRows(run.start);
  return run;
}

// A function that takes whole numbers from text, each in its context: see frames.py for the format.
function numbers(text, kinds) {
  const odds = new Uint16Array(kinds * OF_A_KIND * SLOTS).fill(2048);
  let at = 0, code = 0, range = BASE ** 4;
  const digit = () => DIGITS[text.charCodeAt(at++)];
  const shrink = (start, size, step) => {
    code -= start * step;
    for (range = size * step; range < LEAST; range *= BASE) code = code * BASE + digit();
  };
  for (let k = 0; k < 4; k++) code = code * BASE + digit();
  return (context) => {
    let slot = SLOTS * context, value = 1, left = 0;
    for (;; left++, slot++) {
      const ones = odds[slot], step = range >> 12;
      if (code >= ones * step) {
        odds[slot] -= ones >> 5;
        shrink(ones, 4096 - ones, step);
        break;
      }
      odds[slot] += (4096 - ones) >> 5;
      shrink(0, ones, step);
    }
    if (!left) return 0;
    while (left) {
      const bits = Math.min(left, 8), step = range >> bits, part = Math.floor(code / step);
      shrink(part, 1, step);
      value = value * 2 ** bits + part;
      left -= bits;
    }
    return value % 2 ? (1 - value) / 2 : value / 2;
  };
}

// Fill in positions, velocities and discs of all rows, frame by frame: see frames.py for the format.
function placeRows(run, next) {
  const { times, first, life, x, y, u, v } = run;
  const before = new Int32Array(run.discs), unrest = new Int32Array(run.discs).fill(UNREST);
  let row = 0;
  for (let frame = 0; frame < times.length; frame++) {
    run.start[frame] = row;
    const share = frame ? run.qv * (times[frame] - times[frame - 1]) / run.q / 2 : 0;
    for (let disc = 0; disc < run.discs; disc++) {
      const age = frame - first[disc];
      if (age < 0 || age >= life[disc]) continue;
      if (age === 0) {
        [x[row], y[row], u[row], v[row]] = [run.entryX[disc], run.entryY[disc], run.entryU[disc], run.entryV[disc]];
      } else {
        const old = before[disc];
        let felt = unrest[disc];
        const told = (part) => {
          const value = next(OF_A_KIND * part + 32 - Math.clz32(felt)), size = Math.abs(value);
          felt += part < 2 ? 2 * size : size >> 1;
          return value;
        };
        u[row] = u[old] + told(0);
        v[row] = v[old] + told(1);
        x[row] = x[old] + Math.floor((u[old] + u[row]) * share + 0.5) + told(2);
        y[row] = y[old] + Math.floor((v[old] + v[row]) * share + 0.5) + told(3);
        unrest[disc] = (felt - unrest[disc]) >> 1;
      }
      run.disc[row] = disc;
      before[disc] = row++;
    }
  }
  run.start[times.length] = row;
}

// Fill in the numbers of the map, frame by frame, and its largest value but for the highest 0.5 % above 0.
function readMap(run, next) {
  const { counts: [columns, rows], unit, power } = run.map, cells = columns * rows, often = new Uint32Array(256);
  run.levels = new Uint8Array(cells * run.times.length);
  for (let k = 0; k < run.levels.length; k++) {
    const before = k < cells ? 0 : run.levels[k - cells];
    run.levels[k] = before + next(OF_A_KIND * (4 + COLUMNS) + 32 - Math.clz32(before));
    often[run.levels[k]]++;
  }
  let top = 255, above = 0;
  const all = run.levels.length - often[0];
  while (top > 1 && (above += often[top]) <= 0.005 * all) top--;
  run.map.top = unit * top ** power;
}

// The values of the map at an instant, cell by cell from below.
function mapAt(run, time) {
  const { counts: [columns, rows], unit, power } = run.map, cells = columns * rows, { times, levels } = run;
  const frame = frameBefore(times, time), later = Math.min(frame + 1, times.length - 1);
  const s = later > frame ? (time - times[frame]) / (times[later] - times[frame]) : 0;
  const value = (k) => unit * levels[k] ** power;
  return Float64Array.from({ length: cells }, (_, k) => (1 - s) * value(frame * cells + k) + s * value(later * cells + k));
}

// A value at a place, from the four cells around it.
function valueAt({ low, sides, counts: [columns, rows] }, values, x, y) {
  const left = (x - low[0]) / sides[0] - 0.5, below = (y - low[1]) / sides[1] - 0.5;
  let sum = 0;
  for (const i of [Math.floor(left), Math.floor(left) + 1]) {
    for (const j of [Math.floor(below), Math.floor(below) + 1]) {
      const inside = i >= 0 && j >= 0 && i < columns && j < rows;
      if (inside) sum += (1 - Math.abs(left - i)) * (1 - Math.abs(below - j)) * values[j * columns + i];
    }
  }
  return sum;
}

function mostRows(start) {
  let most = 0;
  for (let k = 1; k < start.length; k++) most = Math.max(most, start[k] - start[k - 1]);
  return most;
}

// Room for the discs of one instant and their images: places (m), velocities (m/s), numbers of the discs.
function roomFor(run) {
  const size = (run.seam ? 4 : 2) * run.most, [x, y, u, v] = [0, 1, 2, 3].map(() => new Float64Array(size));
  return { count: 0, own: 0, x, y, u, v, disc: new Uint32Array(size) };
}

// Last frame at or before a time.
function frameBefore(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

// The discs at an instant, into `found`. At a stored time they are the stored ones; between two, each moves on the
// cubic through both places with both velocities. A disc that comes or goes between them moves on straight, or falls.
// The first `own` of `count` are the discs; the others are images of those that lie across the seam of a channel.
function discsAt(run, time, found) {
  const frame = frameBefore(run.times, time), t0 = run.times[frame], t1 = run.times[frame + 1];
  const s = time > t0 && t1 > t0 ? (time - t0) / (t1 - t0) : 0;
  const stop = run.start[frame + 1], end = s ? run.start[frame + 2] : stop;
  let a = run.start[frame], b = stop;
  found.count = 0;
  while (a < stop || b < end) {
    const left = a < stop ? run.disc[a] : Infinity, right = b < end ? run.disc[b] : Infinity;
    if (!s) stored(run, a++, found);
    else if (left === right) between(run, a++, b++, s, t1 - t0, found);
    else if (left < right) leaving(run, a++, time - t0, found);
    else entering(run, b++, t1 - time, found);
  }
  found.own = found.count;
  if (run.seam) addImages(run, found);
  return found;
}

// Put the discs into a periodic channel, and an image of each that lies across its seam at the other end.
function addImages({ seam: [low, high], radii, shade }, found) {
  const period = high - low, { x, y, u, v, disc, own } = found;
  for (let k = 0; k < own; k++) {
    if (x[k] < low || x[k] > high) x[k] -= period * Math.floor((x[k] - low) / period);
    const r = radii[shade[disc[k]]];
    if (x[k] - r < low) put(found, disc[k], x[k] + period, y[k], u[k], v[k]);
    if (x[k] + r > high) put(found, disc[k], x[k] - period, y[k], u[k], v[k]);
  }
}

function put(found, disc, x, y, u, v) {
  const k = found.count++;
  found.disc[k] = disc;
  found.x[k] = x;
  found.y[k] = y;
  found.u[k] = u;
  found.v[k] = v;
}

function stored(run, row, found) {
  const { q, qv } = run;
  put(found, run.disc[row], run.x[row] * q, run.y[row] * q, run.u[row] * qv, run.v[row] * qv);
}

function between(run, a, b, s, step, found) {
  const { q, qv, x, y, u, v } = run, r = 1 - s;
  const fromA = r * r * (1 + 2 * s) * q, fromB = s * s * (3 - 2 * s) * q;
  const slopeA = s * r * r * step * qv, slopeB = -s * s * r * step * qv;
  put(found, run.disc[a],
    fromA * x[a] + fromB * (x[b] + around(run, a, b, step)) + slopeA * u[a] + slopeB * u[b],
    fromA * y[a] + fromB * y[b] + slopeA * v[a] + slopeB * v[b],
    (r * u[a] + s * u[b]) * qv, (r * v[a] + s * v[b]) * qv);
}

// What takes x of a disc in the later of two rows to where it has gone over the seam of a channel, in q.
function around({ seam, q, qv, x, u }, a, b, step) {
  if (!seam) return 0;
  const period = (seam[1] - seam[0]) / q;
  return period * Math.round(((u[a] + u[b]) / 2 * step * qv / q - (x[b] - x[a])) / period);
}

// A disc that is in no later frame falls on until it is beyond an outlet.
function leaving(run, row, since, found) {
  const [gx, gy] = run.gravity, u = run.u[row] * run.qv, v = run.v[row] * run.qv;
  const x = run.x[row] * run.q + (u + gx * since / 2) * since;
  const y = run.y[row] * run.q + (v + gy * since / 2) * since;
  const gone = ([axis, at, side]) => ((axis === "x" ? x : y) > at) === (side === "above");
  if (run.outlets.length && !run.outlets.some(gone)) put(found, run.disc[row], x, y, u + gx * since, v + gy * since);
}

// A disc that is in no earlier frame comes straight from an inlet.
function entering(run, row, until, found) {
  const u = run.u[row] * run.qv, v = run.v[row] * run.qv;
  const x = run.x[row] * run.q - u * until, y = run.y[row] * run.q - v * until;
  const inside = ([at, sign]) => sign * (x - at) >= 0;
  if (run.inlets.some(inside)) put(found, run.disc[row], x, y, u, v);
}

// Mass depth of each bin at an instant, m: the share of each disc's area that lies in the bin counts. Discs come and go
// with their centres: what they have beyond an inlet or an outlet at an end of the bins is folded back. Discs of rough
// beds do not count. (profiles.nc has means from turn to turn of an inlet's rows.)
function massDepth(run, found, depth) {
  const { low, width, count } = run.bins, scale = run.area / run.share / width;
  const [first, last] = run.fixed || [1, 0], [begin, end] = openEnds(run);
  const add = (x, r) => {
    let bin = Math.max(Math.floor((x - r - low) / width), -1), done = 0;
    for (; done < 1 && bin < count; bin++) {
      const upto = leftShare((low + (bin + 1) * width - x) / r);
      if (bin >= 0) depth[bin] += scale * r * r * (upto - done);
      done = upto;
    }
  };
  depth.fill(0);
  for (let k = 0; k < found.count; k++) {
    const id = run.ids[found.disc[k]];
    if (id >= first && id <= last) continue;
    const r = run.radii[run.shade[found.disc[k]]], x = found.x[k];
    if (x < begin || x > end) continue;
    add(x, r);
    if (x - r < begin) add(2 * begin - x, r);
    if (x + r > end) add(2 * end - x, r);
  }
  return depth;
}

// Planes at the ends of the bins at which discs come or go, m; infinite where there is none.
function openEnds(run) {
  const { low, width, count } = run.bins, high = low + width * count, near = (x, at) => Math.abs(x - at) < 1e-6 * width;
  const planes = [...run.inlets.map(([at, sign]) => [at, sign > 0])];
  for (const [axis, at, side] of run.outlets) if (axis === "x") planes.push([at, side === "below"]);
  const there = (at, inward) => planes.some(([x, right]) => near(x, at) && right === inward);
  return [there(low, true) ? low : -Infinity, there(high, false) ? high : Infinity];
}

// Share of the area of a unit disc left of x = a.
function leftShare(a) {
  if (a <= -1) return 0;
  return a >= 1 ? 1 : 0.5 + (a * Math.sqrt(1 - a * a) + Math.asin(a)) / Math.PI;
}

const pageData = readData();

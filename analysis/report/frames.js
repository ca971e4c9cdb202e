"use strict";
// Frames of a run: unpacked from the text that analysis/report/frames.py writes, and the discs at any instant.

// All rows (a disc in a frame) as whole numbers, from the header of a player and its packed text.
async function unpackFrames(header, text) {
  const take = taker(await inflate(text));
  const { discs, rows, times } = header;
  const ids = summed(take(Uint32Array, discs));
  const run = {
    ...header, ids,
    first: take(Uint16Array, discs), life: take(Uint16Array, discs),
    entryX: take(Int32Array, discs), entryY: take(Int32Array, discs),
    shade: header.radii.length > 1 ? take(Uint8Array, discs) : new Uint8Array(discs),
    start: new Uint32Array(times.length + 1), disc: new Uint32Array(rows),
    x: new Int32Array(rows), y: new Int32Array(rows),
  };
  const late = rows - discs;
  const left = [0, 1, 2, 3].map(() => take(Uint8Array, late));
  run.u = take(Int8Array, rows);
  run.v = take(Int8Array, rows);
  placeRows(run, left);
  run.most = mostRows(run.start);
  return run;
}

// Bytes of deflated base64.
async function inflate(text) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let k = 0; k < packed.length; k++) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Response(stream).arrayBuffer();
}

// A function that takes arrays from a buffer, one after the other.
function taker(buffer) {
  let at = 0;
  return (kind, count) => {
    const found = new kind(buffer, at, count);
    at += found.byteLength;
    return found;
  };
}

function summed(differences) {
  for (let k = 1; k < differences.length; k++) differences[k] += differences[k - 1];
  return differences;
}

// Fill in positions, velocities and discs of all rows, frame by frame: see the Python file for the format.
function placeRows(run, [lowX, highX, lowY, highY]) {
  const { times, first, life, x, y, u, v } = run;
  const before = new Int32Array(run.discs);
  let row = 0, late = 0;
  for (let frame = 0; frame < times.length; frame++) {
    run.start[frame] = row;
    const share = frame ? run.qv * (times[frame] - times[frame - 1]) / run.q / 2 : 0;
    for (let disc = 0; disc < run.discs; disc++) {
      const age = frame - first[disc];
      if (age < 0 || age >= life[disc]) continue;
      const old = before[disc];
      if (age === 0) {
        x[row] = run.entryX[disc];
        y[row] = run.entryY[disc];
      } else {
        u[row] += u[old]; // modulo 256, as stored
        v[row] += v[old];
        x[row] = x[old] + Math.floor((u[old] + u[row]) * share + 0.5) + unzigzag(lowX[late] + 256 * highX[late]);
        y[row] = y[old] + Math.floor((v[old] + v[row]) * share + 0.5) + unzigzag(lowY[late] + 256 * highY[late]);
        late++;
      }
      run.disc[row] = disc;
      before[disc] = row++;
    }
  }
  run.start[times.length] = row;
}

function unzigzag(code) {
  return code & 1 ? -(code + 1) / 2 : code / 2;
}

function mostRows(start) {
  let most = 0;
  for (let k = 1; k < start.length; k++) most = Math.max(most, start[k] - start[k - 1]);
  return most;
}

// Room for the discs of one instant: places (m), velocities (m/s), numbers of the discs.
function roomFor(run) {
  const [x, y, u, v] = [0, 1, 2, 3].map(() => new Float64Array(2 * run.most));
  return { count: 0, x, y, u, v, disc: new Uint32Array(2 * run.most) };
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
  return found;
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
    fromA * x[a] + fromB * x[b] + slopeA * u[a] + slopeB * u[b],
    fromA * y[a] + fromB * y[b] + slopeA * v[a] + slopeB * v[b],
    (r * u[a] + s * u[b]) * qv, (r * v[a] + s * v[b]) * qv);
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

// Mass depth of each bin at an instant, m: the share of each disc's area that lies in the bin counts, as in profiles.nc.
function massDepth(run, found, depth) {
  const { low, width, count } = run.bins, scale = run.area / run.share / width;
  depth.fill(0);
  for (let k = 0; k < found.count; k++) {
    const r = run.radii[run.shade[found.disc[k]]], x = found.x[k], mass = scale * r * r;
    let bin = Math.max(Math.floor((x - r - low) / width), -1), done = 0;
    for (; done < 1 && bin < count; bin++) {
      const upto = leftShare((low + (bin + 1) * width - x) / r);
      if (bin >= 0) depth[bin] += mass * (upto - done);
      done = upto;
    }
  }
  return depth;
}

// Share of the area of a unit disc left of x = a.
function leftShare(a) {
  if (a <= -1) return 0;
  return a >= 1 ? 1 : 0.5 + (a * Math.sqrt(1 - a * a) + Math.asin(a)) / Math.PI;
}

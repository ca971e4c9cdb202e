"use strict";
// A run that grows: the rows of its frames, as the player has them, with room for more.

// Rows that there is room for at first.
const ROOM = 1 << 16;
const WORDS = 6;

class Growing {
  // About the run, as `about` of the server has it.
  constructor(about) {
    Object.assign(this, {
      grows: true, times: [], start: [0], ids: [], first: [], life: [], shade: [], most: 0, rows: 0, discs: 0, known: new Map(),
    });
    this.room(ROOM);
    this.about(about);
  }

  about(about) {
    Object.assign(this, about);
  }

  // Room for so many rows; those that are there are kept.
  room(rows) {
    for (const [name, kind] of [["disc", Uint32Array], ["x", Int32Array], ["y", Int32Array], ["u", Float32Array], ["v", Float32Array]]) {
      const wider = new kind(rows);
      if (this[name]) wider.set(this[name]);
      this[name] = wider;
    }
  }

  // Take in frames as the server sends them.
  add(buffer) {
    const view = new DataView(buffer);
    for (let at = 0; at < buffer.byteLength;) {
      const time = view.getFloat64(at, true), count = view.getInt32(at + 8, true);
      this.frame(time, count, buffer, at + 16);
      at += 16 + 4 * WORDS * count;
    }
  }

  frame(time, count, buffer, at) {
    const column = (kind, k) => new kind(buffer, at + 4 * k * count, count);
    const [ids, x, y, shade] = [0, 1, 2, 5].map((k) => column(Int32Array, k)), [u, v] = [3, 4].map((k) => column(Float32Array, k));
    while (this.rows + count > this.x.length) this.room(2 * this.x.length);
    const now = this.times.length, order = Array.from(ids, (id, k) => [this.number(id, shade[k], now), k]);
    if (order.some(([disc], k) => k && disc < order[k - 1][0])) order.sort(([a], [b]) => a - b);
    for (const [disc, k] of order) {
      const row = this.rows++;
      this.disc[row] = disc;
      [this.x[row], this.y[row], this.u[row], this.v[row]] = [x[k], y[k], u[k], v[k]];
      this.life[disc] = now - this.first[disc] + 1;
      this.shade[disc] = shade[k]; // an inlet gives a disc its size in flight
    }
    this.times.push(time);
    this.start.push(this.rows);
    this.most = Math.max(this.most, count);
  }

  // Number of a disc, by its id; one that is new gets the next.
  number(id, shade, frame) {
    if (!this.known.has(id)) {
      this.known.set(id, this.discs++);
      this.ids.push(id);
      this.first.push(frame);
      this.life.push(1);
      this.shade.push(shade);
    }
    return this.known.get(id);
  }
}

// Show in a player what has been added to its run; the newest instant, if that was shown before.
function showGrowth(p, seen) {
  const { run } = p, newest = p.time >= p.end, [first, last] = [run.times[0], run.times[run.times.length - 1]];
  Object.assign(p, { end: last, oldest: oldest(run), found: roomFor(run) });
  Object.assign(part(p, "time"), { min: first, max: last });
  offerColours(p);
  if (JSON.stringify(seen) !== JSON.stringify(run.seen)) layOut(p);
  if (newest && !p.playing) setTime(p, last);
  else draw(p);
}

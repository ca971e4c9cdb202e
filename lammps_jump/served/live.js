"use strict";
// A run that grows: the rows of its frames, as the player has them, with room for more.

// Rows that there is room for at first.
const ROOM = 1 << 16;
const WORDS = 6;
// Of gaps between frames that come: how many are remembered, the longest one that counts and the first one that is
// expected, ms; how much slower than the longest of them the picture moves, so that it seldom stops.
const GAPS = 5, LONGEST_GAP = 4000, FIRST_GAP = 400, SLOWER = 1.1;
// Milliseconds between pictures of a run that grows: the run needs the processor, too.
const DRAWN_EVERY = 45;

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

// The time that is shown of a run that grows. Frames come in bursts, and the picture goes on evenly between them: it
// moves on to the newest frame so that it is there when the next one is to be expected.
class Following {
  constructor(time) {
    Object.assign(this, { from: time, to: time, begun: 0, lasts: 0, gaps: [], arrived: null, shown: time });
  }

  // Frames up to a time (s) have come, at an instant (ms).
  arrive(now, end) {
    if (this.arrived !== null) this.gaps = [...this.gaps, Math.min(now - this.arrived, LONGEST_GAP)].slice(-GAPS);
    const lasts = this.gaps.length ? SLOWER * Math.max(...this.gaps) : FIRST_GAP;
    Object.assign(this, { from: this.at(now), to: end, begun: now, lasts, arrived: now });
  }

  // The time to be shown at an instant; it never goes back, nor beyond the newest frame.
  at(now) {
    const share = this.lasts ? Math.min(Math.max((now - this.begun) / this.lasts, 0), 1) : 1;
    const time = share < 1 ? this.from + share * (this.to - this.from) : this.to;
    return (this.shown = Math.max(this.shown, Math.min(time, this.to)));
  }

  get isThere() {
    return this.shown >= this.to;
  }
}

function isFollowing(p) {
  return Boolean(p.following) && !p.playing;
}

// Show the newest of a player's run from now on, until its reader goes elsewhere.
function followNewest(p) {
  p.following = new Following(p.end);
  setTime(p, p.end);
  document.addEventListener("seek", ({ detail }) => { p.following = detail >= p.end ? new Following(p.end) : null; });
  document.addEventListener("play", ({ detail }) => { if (detail.on) p.following = null; });
  let drawn = 0;
  const turn = (now) => {
    if (!p.following && !p.playing && p.time >= p.end) p.following = new Following(p.end);
    if (isFollowing(p) && now - drawn >= DRAWN_EVERY && !(p.following.isThere && p.time === p.following.to)) {
      drawn = now;
      setTime(p, p.following.at(now));
    }
    requestAnimationFrame(turn);
  };
  requestAnimationFrame(turn);
}

// Go on with the newest of another run of a player, which may have begun anew.
function goOnFollowing(p, now) {
  if (p.following.shown > p.end) p.following = new Following(p.end);
  else p.following.arrive(now, p.end);
  p.time = p.following.shown;
}

// Show in a player what has been added to its run, at an instant (ms).
function showGrowth(p, seen, now) {
  const { run } = p, [first, last] = [run.times[0], run.times[run.times.length - 1]];
  Object.assign(p, { end: last, oldest: oldest(run), found: roomFor(run) });
  Object.assign(part(p, "time"), { min: first, max: last });
  offerColours(p);
  if (JSON.stringify(seen) !== JSON.stringify(run.seen)) layOut(p);
  if (!isFollowing(p)) return void draw(p);
  if (still.matches) setTime(p, (p.following = new Following(last)).shown);
  else p.following.arrive(now, last);
}

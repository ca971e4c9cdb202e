"use strict";
// What sliders do, as tables of a case: rows of a wall's motion and of an inflow, and what the core makes of them.
// The arithmetic is that of scene/tracks.py and physics/inlet.py, operation by operation: tests compare the bits.

const TRACK = { begin: 0, x: 1, y: 6, angle: 11 };
const HALVINGS = 60;
// Steps of the core before a time at which a move may begin: it looks a step ahead.
const AHEAD = 3;

// A wall's table of motion, rows [t, x, y, turn in degrees], as a track of the core (TableMotion.corners, track_of).
class WallMoves {
  constructor(width) {
    this.width = width;
    this.rows = [[0, 0, 0, 0]];
    this.velocity = [0, 0, 0];
    this.corners = [{ time: 0, change: [-0, -0, -0] }];
    this.track = [this.trackRow(0)];
  }

  get last() { return this.rows[this.rows.length - 1]; }

  add(row) {
    const before = this.last, way = [1, 2, 3].map((k) => (row[k] - before[k]) / (row[0] - before[0]));
    const next = [way[0], way[1], way[2] * (Math.PI / 180)], place = this.corners.length - 1;
    this.corners[place] = { time: before[0], change: next.map((part, k) => part - this.velocity[k]) };
    this.corners.push({ time: row[0], change: next.map((part) => -part) });
    this.velocity = next;
    this.rows.push(row);
    this.track[place] = this.trackRow(place);
    this.track.push(this.trackRow(place + 1));
  }

  trackRow(number) {
    const found = new Float64Array(this.width), begin = this.corners[number].time;
    found[TRACK.begin] = begin;
    for (let k = 0; k <= number; k++) {
      const { time, change } = this.corners[k], since = begin - time;
      [TRACK.x, TRACK.y, TRACK.angle].forEach((at, axis) => {
        found[at] += change[axis] * since;
        found[at + 1] += change[axis];
      });
    }
    return found;
  }

  flat() {
    const found = new Float64Array(this.width * this.track.length);
    this.track.forEach((row, k) => found.set(row, k * this.width));
    return found;
  }
}

// An inflow against time of one depth, rows [t, depth, speed], as steps and speeds of discs (Hydrograph, entries_of_rows).
class InflowMoves {
  // `about`: depth, speed, shares and factors of the rows, mean square of a diameter (m^2), time step (s), step of t = 0.
  constructor(about) {
    Object.assign(this, about);
    this.rows = [[0, this.depth, this.speed]];
    this.sums = [0];
    this.turns = this.shares.map(() => ({ steps: [], speeds: [] }));
    this.begun = this.shares.map(() => [{ phase: 0, carried: 0 }]);
    this.owed = this.shares.map(() => 0);
    this.known = 0;
  }

  get last() { return this.rows[this.rows.length - 1]; }

  // Discharge (m^2) from the first row to the second, over a time.
  part(h0, h1, u0, u1) { return (2 * h0 * u0 + h0 * u1 + h1 * u0 + 2 * h1 * u1) / 6; }

  // A row after all discs that are known.
  add(row) {
    const [t0, h0, u0] = this.last, [t1, h1, u1] = row;
    const before = this.sums[this.sums.length - 1];
    this.sums.push(before + (t1 - t0) * this.part(h0, h1, u0, u1));
    const carried = this.sums[this.sums.length - 1];
    this.begun.forEach((pieces, k) => {
      const piece = pieces[pieces.length - 1];
      pieces.push({ phase: piece.phase + this.shares[k] * (carried - piece.carried) / this.meanSquare, carried });
    });
    this.rows.push(row);
  }

  rowBefore(time) {
    let low = 0, high = this.rows.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.rows[middle][0] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // A column of the table at a time, as numpy.interp has it.
  value(time, column) {
    const k = this.rowBefore(time), [at, next] = [this.rows[k], this.rows[k + 1]];
    if (!next || time <= at[0]) return at[column];
    return (next[column] - at[column]) / (next[0] - at[0]) * (time - at[0]) + at[column];
  }

  carried(time) {
    const k = this.rowBefore(time), [t0, h0, u0] = this.rows[k];
    return this.sums[k] + (time - t0) * this.part(h0, this.value(time, 1), u0, this.value(time, 2));
  }

  // Time between two at which so much has come in.
  timeOf(wanted, low, high) {
    for (let k = 0; k < HALVINGS; k++) {
      const middle = 0.5 * (low + high);
      if (this.carried(middle) >= wanted) high = middle;
      else low = middle;
    }
    return high;
  }

  // Find the discs up to a time; nothing before it changes any more.
  upto(time) {
    this.turns.forEach((turns, k) => {
      for (;;) {
        const owed = this.owed[k] + 0.5, pieces = this.begun[k];
        let piece = pieces.length - 1;
        while (piece > 0 && !(pieces[piece].phase < owed)) piece--;
        const wanted = pieces[piece].carried + (owed - pieces[piece].phase) * this.meanSquare / this.shares[k];
        const end = piece + 1 < pieces.length ? this.rows[piece + 1][0] : time;
        if (end > time || !(this.carried(end) >= wanted)) break;
        const at = this.timeOf(wanted, this.rows[piece][0], end);
        const step = this.start + Math.max(1, Math.ceil(at / this.timeStep - 1e-9));
        if ((step - this.start) * this.timeStep > time) break; // its speed is that of the next row
        this.owed[k]++;
        if (step === turns.steps[turns.steps.length - 1]) continue;
        turns.steps.push(step);
        turns.speeds.push(this.value((step - this.start) * this.timeStep, 2) * this.relative[k] * this.factors[k]);
      }
    });
    this.known = time;
  }
}

// Sliders against time: at each tick they add to the tables what happens up to the next one.
class Moves {
  constructor(core, head) {
    Object.assign(this, { core, head, tick: 1, wanted: {}, changed: [], full: false });
    this.walls = new Map();
    for (const one of head.sliders) {
      this.wanted[one.name] = one.value;
      if (one.kind === "wall" && !this.walls.has(one.wall)) this.walls.set(one.wall, new WallMoves(head.trackWidth));
    }
    this.tracks = core.tracks();
    this.inflow = head.inflow && new InflowMoves(head.inflow);
    this.numbers = Object.fromEntries(head.sliders.filter((one) => one.kind === "number").map((one) => [one.name, one.value]));
    if (this.inflow) this.letIn(1);
  }

  time(tick) { return Number((tick * this.head.tick).toFixed(9)); }

  // Last step before a tick, at which its rows have to be there.
  stepOf(tick) { return this.head.start + Math.floor(this.time(tick) / this.head.timeStep) - AHEAD; }

  // Step up to `target`, and let ticks come on the way; a sentence where the core went no further.
  run(target) {
    while (this.core.step < target) {
      const due = this.stepOf(this.tick), stop = Math.min(target, due);
      if (stop > this.core.step) {
        const wrong = this.core.run(stop);
        if (wrong) return wrong;
      }
      if (this.core.step >= due) this.happen();
    }
    return "";
  }

  happen() {
    const now = this.time(this.tick), next = this.time(this.tick + 1);
    this.moveWalls(now, next);
    if (this.inflow) {
      this.turnInflow(now, next);
      this.letIn(this.tick + 1);
    }
    this.tick++;
  }

  moveWalls(now, next) {
    let moved = false;
    for (const [wall, moves] of this.walls) {
      const here = moves.last, there = [next, here[1], here[2], here[3]];
      for (const one of this.head.sliders) {
        if (one.kind === "wall" && one.wall === wall) there[1 + one.axis] = this.towards(one, here[1 + one.axis], next - now);
      }
      if (there.slice(1).every((part, k) => part === here[k + 1])) continue;
      if (moves.rows.length + 2 > this.head.mostRows) {
        this.full = true;
        continue;
      }
      if (here[0] < now) moves.add([now, here[1], here[2], here[3]]);
      moves.add(there);
      this.tracks[wall] = moves.flat();
      moved = true;
    }
    if (moved) this.core.setTracks(this.tracks);
  }

  // Where a slider has come to after some time, at its rate, in millionths.
  towards(one, here, seconds) {
    const most = one.rate * seconds, way = Math.min(most, Math.max(-most, this.wanted[one.name] - here));
    return Number((here + way).toFixed(6)) + 0;
  }

  turnInflow(now, next) {
    const slider = this.head.sliders.find((one) => one.kind === "inflow"), moves = this.inflow, here = moves.last;
    if (!slider) return;
    const discharge = this.towards(slider, Number((here[2] * here[1]).toFixed(6)), next - now);
    const speed = this.wanted[slider.name] === slider.value && discharge === slider.value ? moves.speed : Number((discharge / here[1]).toFixed(6));
    if (speed === here[2]) return;
    if (moves.rows.length + 2 > this.head.mostTimes) {
      this.full = true;
      return;
    }
    if (here[0] < now) moves.add([now, here[1], here[2]]);
    moves.add([next, here[1], speed]);
  }

  // Discs that enter up to a tick: what comes after it is not known yet.
  letIn(tick) {
    this.inflow.upto(this.time(tick));
    this.core.setTurns(this.inflow.turns);
  }

  want(name, value) {
    this.wanted[name] = value;
    const one = this.head.sliders.find((slider) => slider.name === name);
    if (one.kind !== "number" || this.numbers[name] === value) return;
    this.core.write(one.stops.find((stop) => stop.value === value).words);
    this.numbers[name] = value;
    if (!this.changed.includes(name)) this.changed.push(name);
  }

  // Begin with numbers other than those of the case: what the first forces make of them too, where that is known.
  beginWith(values) {
    const others = this.head.sliders.filter((one) => one.kind === "number" && values[one.name] !== one.value);
    for (const one of others) {
      const stop = one.stops.find(({ value }) => value === values[one.name]);
      this.core.write(others.length === 1 && stop.start ? stop.start : stop.words);
      this.wanted[one.name] = this.numbers[one.name] = stop.value;
      if (others.length > 1 || !stop.start) this.changed.push(one.name);
    }
    this.begun = { ...this.numbers };
  }

  // What the case of this flow has in addition to that of the page.
  tables() {
    return {
      walls: [...this.walls].map(([wall, { rows }]) => [wall, rows]), inflow: this.inflow && this.inflow.rows,
      numbers: this.begun || {}, changed: this.changed, step: this.core.step,
    };
  }
}

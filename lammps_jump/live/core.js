"use strict";
// The core in a page: an image of a scene (engines/native/image.py) is put into its memory, and stepped there.

const IMAGE_HEAD = 48;
const IMAGE_LINE = 64;
// What a system call answers that is not there: ENOSYS of WASI.
const NOT_THERE = 52;
// Why the core stops before the step that was requested: RunEnd of core/columns.py.
const ENDS = ["", "a disc has left the domain, or a wall has come to the seam", "discs overlap too much",
  "a disc touches more others than it can remember"];

class LiveCore {
  // `head`: places of the fields of the structs of the core, and what page.py tells of the scene.
  constructor(module, image, head) {
    const imports = {};
    for (const one of WebAssembly.Module.imports(module)) (imports[one.module] ??= {})[one.name] = () => NOT_THERE;
    // how long lists take is measured, and reported to nobody here
    Object.assign(imports.wasi_snapshot_preview1 || {}, { clock_time_get: (clock, precision, place) => this.set64(place, performance.now()) });
    this.core = new WebAssembly.Instance(module, imports).exports;
    this.core._initialize();
    this.head = head;
    this.place(image);
    const word = this.room(IMAGE_LINE);
    this.bytes(word, 2).set([49, 0]); // "1": one thread
    this.partition = this.core.jump_partition(word);
    this.set("events", "window_steps", 0); // forces are read at each picture
  }

  set64(place, milliseconds) {
    this.view.setBigInt64(place, BigInt(Math.round(1e6 * milliseconds)), true);
    return 0;
  }

  room(bytes) {
    const place = this.core.aligned_alloc(IMAGE_LINE, Math.ceil(bytes / IMAGE_LINE + 1) * IMAGE_LINE);
    if (!place) throw new Error("there is not enough memory");
    return place;
  }

  // Put an image into memory; its pointers are places in it.
  place(image) {
    const view = new DataView(image), word = (k) => Number(view.getBigInt64(8 * k, true));
    const [size, pointers] = [word(2), word(3)], base = this.room(size);
    this.bytes(base, size).set(new Uint8Array(image, IMAGE_HEAD + 8 * pointers, size));
    const memory = this.view;
    for (let k = 0; k < pointers; k++) {
      const place = base + word(6 + k);
      memory.setUint32(place, memory.getUint32(place, true) + base, true);
    }
    this.base = base;
    this.structs = { state: base + word(4), events: base + word(5) };
  }

  // Memory moves where it grows: views of it are made anew.
  get view() { return new DataView(this.core.memory.buffer); }
  bytes(place, count) { return new Uint8Array(this.core.memory.buffer, place, count); }
  reals(place, count) { return new Float64Array(this.core.memory.buffer, place, count); }
  wholes(place, count) { return new BigInt64Array(this.core.memory.buffer, place, count); }

  at(struct, field) { return this.structs[struct] + this.head.fields[struct][field]; }
  get(struct, field) { return Number(this.view.getBigInt64(this.at(struct, field), true)); }
  set(struct, field, value) { this.view.setBigInt64(this.at(struct, field), BigInt(value), true); }
  pointer(struct, field) { return this.view.getUint32(this.at(struct, field), true); }
  setPointer(struct, field, place) { this.view.setUint32(this.at(struct, field), place, true); }

  get step() { return this.get("events", "step"); }
  get count() { return this.get("state", "n"); }

  // A column of the discs, in the order of the core; null where the scene has none.
  column(name) {
    const place = this.pointer("state", name);
    if (!place) return null;
    return name === "ids" ? this.wholes(place, this.count) : this.reals(place, this.count);
  }

  // Step up to `target`; a sentence where the core went no further.
  run(target) {
    const end = Number(this.core.jump_run(this.structs.state, this.structs.events, this.partition, BigInt(target)));
    this.core.jump_forget_windows(this.partition);
    return ENDS[end];
  }

  // Write numbers at places of the image: [place, number] each.
  write(words) {
    const memory = this.view;
    for (const [place, number] of words) memory.setFloat64(this.base + place, number, true);
  }

  // Tracks of all walls, one list of rows each, in place of those that the image has.
  setTracks(tracks) {
    const width = this.head.trackWidth, rows = tracks.reduce((sum, track) => sum + track.length / width, 0);
    if (!(rows <= this.trackRoom)) {
      this.trackRoom = 2 * rows + 64;
      this.setPointer("state", "track", this.room(8 * width * this.trackRoom));
    }
    const first = this.wholes(this.pointer("state", "track_first"), tracks.length + 1);
    let row = 0;
    tracks.forEach((track, wall) => {
      first[wall] = BigInt(row);
      this.reals(this.pointer("state", "track") + 8 * width * row, track.length).set(track);
      row += track.length / width;
    });
    first[tracks.length] = BigInt(row);
  }

  // The present tracks of the walls.
  tracks() {
    const width = this.head.trackWidth, walls = this.get("state", "walls");
    if (!this.pointer("state", "track_first")) return [];
    const first = this.wholes(this.pointer("state", "track_first"), walls + 1);
    const ends = Array.from(first, Number);
    return Array.from({ length: walls }, (_, wall) => (
      this.reals(this.pointer("state", "track") + 8 * width * ends[wall], width * (ends[wall + 1] - ends[wall])).slice()));
  }

  // Steps and speeds of the discs that each row of the inlet lets in, in place of those of the image.
  setTurns(turns) {
    const { size, first_turn: first, turns: counts } = this.head.fields.inlet;
    const all = turns.reduce((sum, one) => sum + one.steps.length, 0);
    if (!(all <= this.turnRoom)) {
      this.turnRoom = 2 * all + 1024;
      this.setPointer("events", "turn_step", this.room(8 * this.turnRoom));
      this.setPointer("events", "turn_speed", this.room(8 * this.turnRoom));
    }
    const memory = this.view, inlets = this.pointer("events", "inlet");
    const steps = this.wholes(this.pointer("events", "turn_step"), all), speeds = this.reals(this.pointer("events", "turn_speed"), all);
    let begin = 0;
    turns.forEach((one, row) => {
      one.steps.forEach((step, k) => { steps[begin + k] = BigInt(step); });
      speeds.set(one.speeds, begin);
      memory.setBigInt64(inlets + size * row + first, BigInt(begin), true);
      memory.setBigInt64(inlets + size * row + counts, BigInt(one.steps.length), true);
      begin += one.steps.length;
    });
  }

  // Steps and speeds of the image.
  turns() {
    const { size, first_turn: first, turns: counts } = this.head.fields.inlet, memory = this.view;
    const inlets = this.pointer("events", "inlet"), word = (row, at) => Number(memory.getBigInt64(inlets + size * row + at, true));
    return Array.from({ length: this.get("events", "inlets") }, (_, row) => ({
      steps: Array.from(this.wholes(this.pointer("events", "turn_step") + 8 * word(row, first), word(row, counts)), Number),
      speeds: this.reals(this.pointer("events", "turn_speed") + 8 * word(row, first), word(row, counts)).slice(),
    }));
  }

  // Sums over steps of the force on each wall, N/m: x and y.
  forces() {
    const walls = this.get("state", "walls"), parts = [this.pointer("state", "wall_sum"), this.pointer("events", "window_sum")];
    const [a, b] = parts.map((place) => this.reals(place, 4 * walls));
    return Array.from({ length: walls }, (_, wall) => [a[4 * wall] + b[4 * wall], a[4 * wall + 1] + b[4 * wall + 1]]);
  }

  // Pose of each wall: x, y (m) and turn (rad) from where the case has it.
  poses() {
    const place = this.pointer("state", "placed"), width = this.head.placedWidth, walls = this.get("state", "walls");
    return Array.from({ length: walls }, (_, wall) => (place ? Array.from(this.reals(place + 8 * width * wall, 3)) : [0, 0, 0]));
  }

  // Step, ids, places and velocities (m, m/s) of all discs as they are in memory, for who compares bits.
  state() {
    const columns = ["ids", "x", "y", "vx", "vy", "fx", "fy", "omega"].map((name) => this.column(name)).filter(Boolean);
    const found = new Uint8Array(16 + 8 * columns.length * this.count), view = new DataView(found.buffer);
    view.setBigInt64(0, BigInt(this.step), true);
    view.setBigInt64(8, BigInt(this.count), true);
    columns.forEach((column, k) => found.set(new Uint8Array(column.buffer, column.byteOffset, column.byteLength), 16 + 8 * k * this.count));
    return found;
  }
}

"use strict";
// The thread that computes: it steps the core at most in real time, and sends a picture where the page has shown the last.

// Milliseconds of computing between two looks at messages, and over which the pace is measured.
const SLICE = 12;
const PACE_OVER = 700;
// Steps that are tried at first; later as many as a slice has time for.
const FIRST_STEPS = 20;

const flow = { playing: false, shown: true, chunk: FIRST_STEPS, lead: 0, felt: null };

function begin(values) {
  const { module, image, head } = flow;
  flow.core = new LiveCore(module, image, head);
  flow.moves = new Moves(flow.core, head);
  if (values) {
    const own = Object.fromEntries(head.sliders.map((one) => [one.name, one.kind === "number" ? values[one.name] : one.value]));
    flow.moves.beginWith(own);
  }
  Object.assign(flow, { wrong: "", felt: null, paces: [], lead: 0, clock: performance.now() });
  picture();
  clearTimeout(flow.timer);
  if (flow.playing) slice();
}

// One slice: as many steps as real time asks for, or as there is time for.
function slice() {
  if (!flow.playing || flow.wrong) return;
  const now = performance.now(), { core, head } = flow, dt = head.timeStep;
  flow.lead = Math.min(flow.lead + (now - flow.clock) / 1000, 0.05); // seconds of flow that are due
  flow.clock = now;
  const due = Math.min(Math.floor(flow.lead / dt), head.target - core.step);
  let done = 0;
  while (done < due && performance.now() - now < SLICE) {
    const steps = Math.min(flow.chunk, due - done), before = performance.now();
    go(steps);
    const took = performance.now() - before;
    done += steps;
    if (took > 0) flow.chunk = Math.max(1, Math.min(4 * flow.chunk, Math.round(flow.chunk * SLICE / 2 / took)));
    if (flow.wrong) break;
  }
  flow.lead = Math.max(0, flow.lead - done * dt);
  flow.paces.push([now, done * dt]);
  while (flow.paces.length > 2 && now - flow.paces[0][0] > PACE_OVER) flow.paces.shift();
  if (core.step >= head.target) flow.wrong = `The page knows this flow up to t = ${(head.target - head.start) * dt} s. Begin again from the start.`;
  if (flow.shown || flow.wrong) picture();
  flow.timer = setTimeout(slice, done < due ? 0 : 4);
}

function go(steps) {
  const said = flow.moves.run(flow.core.step + steps);
  if (said) flow.wrong = `The flow ended: ${said}.`;
}

// Seconds of flow in a second of real time.
function pace() {
  const { paces } = flow, long = paces.length > 1 ? paces[paces.length - 1][0] - paces[0][0] : 0;
  return long > 0 ? 1000 * paces.slice(1).reduce((sum, [, part]) => sum + part, 0) / long : null;
}

// Send the discs as they are now.
function picture() {
  const { core, head, moves } = flow, { radii } = head.about, count = core.count;
  const single = (name) => Float32Array.from(core.column(name)), ids = Float64Array.from(core.column("ids"), Number);
  const radius = core.column("radius"), wide = radii[radii.length - 1] - radii[0];
  const shade = new Uint8Array(count);
  if (radius && wide > 0) radius.forEach((r, k) => { shade[k] = Math.round((r - radii[0]) / wide * (radii.length - 1)); });
  const [x, y, u, v] = ["x", "y", "vx", "vy"].map(single), forces = core.forces(), step = core.step;
  const steps = flow.felt ? step - flow.felt.step : 0;
  const mean = steps > 0 ? forces.map(([fx, fy], k) => [(fx - flow.felt.forces[k][0]) / steps, (fy - flow.felt.forces[k][1]) / steps]) : null;
  if (steps !== 0) flow.felt = { step, forces };
  if (!flow.felt) flow.felt = { step, forces };
  flow.shown = false;
  postMessage({
    step, time: (step - head.start) * head.timeStep, ids, x, y, u, v, shade, poses: core.poses(), forces: mean, pace: pace(),
    wrong: flow.wrong, full: moves.full, changed: moves.changed, playing: flow.playing && !flow.wrong,
  }, [ids, x, y, u, v, shade].map((one) => one.buffer));
}

const ACTS = {
  begin: async ({ module, image, head, values }) => {
    Object.assign(flow, { module: await WebAssembly.compile(module), image, head });
    begin(values);
  },
  again: ({ values }) => begin(values),
  play: ({ on }) => {
    if (!on && flow.playing) setTimeout(picture); // the last word: it is not playing
    clearTimeout(flow.timer);
    Object.assign(flow, { playing: on, clock: performance.now(), paces: [], lead: 0 });
    if (on) slice();
  },
  step: ({ steps }) => { if (!flow.wrong) go(steps); picture(); },
  want: ({ name, value }) => flow.moves.want(name, value),
  shown: () => { flow.shown = true; },
  tables: () => postMessage({ tables: flow.moves.tables() }),
  verify: async ({ module, image, head }) => {
    const core = new LiveCore(await WebAssembly.compile(module), image, head);
    const tell = (step) => postMessage({ verified: { step } });
    if (head.again.frames) return postMessage({ verified: { done: true, far: howFar(core, head.again, tell) } });
    return postMessage({ verified: { done: true, parts: await computeAgain(core, head.again, tell) } });
  },
  state: () => postMessage({ state: flow.core.state() }),
};

// Acts follow each other: the first one waits for the core to be compiled.
let acted = Promise.resolve();
onmessage = ({ data }) => {
  acted = acted.then(() => ACTS[data.act](data)).catch((error) => {
    flow.wrong = `The page cannot compute here: ${error.message}.`;
    postMessage({ failed: flow.wrong });
  });
};

"use strict";
// A finished run, computed again from its start and held against what was stored of it: see page.py.

// Milliseconds of computing between two words of progress.
const TOLD_EVERY = 250;

async function digest(columns) {
  const whole = new Float64Array(columns.reduce((sum, one) => sum + one.length, 0));
  let at = 0;
  for (const one of columns) {
    for (const value of one) whole[at++] = value + 0; // no minus zero
  }
  const found = new Uint8Array(await crypto.subtle.digest("SHA-256", whole));
  return Array.from(found, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

// Columns of the discs in the order of their ids; without those of rough beds where `fixed` names them.
function columnsOf(core, names, fixed) {
  const ids = Array.from(core.column("ids"), Number), [first, last] = fixed || [1, 0];
  const order = ids.map((_, k) => k).filter((k) => ids[k] < first || ids[k] > last).sort((a, b) => ids[a] - ids[b]);
  return [order.map((k) => ids[k]), ...names.map((name) => { const one = core.column(name); return order.map((k) => one[k]); })];
}

// Steps a core, with words of progress.
function stepper(core, tell) {
  let told = performance.now(), chunk = 50;
  return (step) => {
    while (core.step < step) {
      const before = performance.now(), wrong = core.run(Math.min(step, core.step + chunk)), took = performance.now() - before;
      if (wrong) return wrong;
      chunk = Math.max(1, Math.min(2 * chunk, Math.round(chunk * TOLD_EVERY / Math.max(took, 1))));
      if (performance.now() - told < TOLD_EVERY) continue;
      told = performance.now();
      tell(core.step);
    }
    return "";
  };
}

// Hash of the whole state, as engines/native/state.py has it.
function fingerprint(core) {
  return digest(columnsOf(core, ["x", "y", "vx", "vy", ...(core.column("omega") ? ["omega"] : [])]));
}

// Compute the run again; `tell` hears steps done. The first place where it parts, or null.
async function computeAgain(core, { checks, end, digits, steps, fixed }, tell) {
  const rounded = (values) => values.map((value) => Number(value.toPrecision(digits))), goTo = stepper(core, tell);
  for (const [step, hash, state] of checks) {
    const wrong = goTo(step), [ids, ...places] = columnsOf(core, ["x", "y"]);
    if (wrong || await digest([ids, ...places.map(rounded)]) !== hash) return { step, wrong };
    if (state && await fingerprint(core) !== state) return { step, wrong, state };
  }
  const wrong = goTo(steps);
  if (wrong || await digest(columnsOf(core, ["x", "y", "vx", "vy"], fixed)) !== end) return { step: steps, wrong };
  return null;
}

// Compute a run of LAMMPS again: for each of its frames the largest and the median distance of its discs, in diameters,
// and how many are in one of the two alone.
function howFar(core, { frames, diameter, period }, tell) {
  const goTo = stepper(core, tell), found = [];
  const array = (text, Kind) => new Kind(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
  for (const frame of frames) {
    const wrong = goTo(frame.step);
    if (wrong) return { found, wrong };
    const ids = array(frame.ids, Int32Array), x = array(frame.x, Float64Array), y = array(frame.y, Float64Array);
    const [own, ownX, ownY] = columnsOf(core, ["x", "y"]), place = new Map(own.map((id, k) => [id, k])), far = [];
    ids.forEach((id, k) => {
      const there = place.get(id);
      if (there === undefined) return;
      let across = ownX[there] - x[k];
      if (period) across -= period * Math.round(across / period);
      far.push(Math.hypot(across, ownY[there] - y[k]) / diameter);
    });
    far.sort((a, b) => a - b);
    found.push({ step: frame.step, most: far[far.length - 1] ?? null, median: far[far.length >> 1] ?? null, alone: ids.length - far.length });
  }
  return { found, wrong: "" };
}

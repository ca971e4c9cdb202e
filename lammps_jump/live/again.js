"use strict";
// A finished run, computed again from its start and held against what was stored of it: see again.py.

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

// Compute the run again; `tell` hears steps done. The first place where it parts, or null.
async function computeAgain(core, { checks, end, digits, steps, fixed }, tell) {
  const rounded = (values) => values.map((value) => Number(value.toPrecision(digits)));
  let told = performance.now(), chunk = 50;
  const goTo = async (step) => {
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
  for (const [step, hash] of checks) {
    const wrong = await goTo(step), [ids, ...places] = columnsOf(core, ["x", "y"]);
    if (wrong || await digest([ids, ...places.map(rounded)]) !== hash) return { step, wrong };
  }
  const wrong = await goTo(steps);
  if (wrong || await digest(columnsOf(core, ["x", "y", "vx", "vy"], fixed)) !== end) return { step: steps, wrong };
  return null;
}

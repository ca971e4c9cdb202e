"use strict";
// The case of a flow, with the tables that moves.js has made of its sliders.

// The case whose native run has the numbers of this flow up to now, as YAML.
function caseText(head, { walls, inflow, numbers, step, changed }) {
  const own = structuredClone(head.case);
  for (const [number, rows] of walls) {
    own.walls.find(({ name }) => name === head.walls[number]).motion.points = rows;
  }
  if (inflow) own.inflow.table = inflow;
  for (const one of head.sliders) {
    if (one.kind !== "number" || !(one.name in numbers) || numbers[one.name] === one.value) continue;
    const path = one.path.split("."), last = path.pop();
    path.reduce((group, key) => group[key], own)[last] = numbers[one.name];
  }
  own.run.duration = Math.max(1, Math.ceil((step - head.start) * head.timeStep / head.frame)) * head.frame;
  if (own.analysis && own.analysis.window && own.analysis.window[1] > own.run.duration) delete own.analysis.window;
  const left = changed.length ? `# Not in it: ${changed.join(", ")}, changed while the flow ran.\n` : "";
  return `# A flow of a live page up to step ${step}: a run of it has the same numbers to the last bit.\n${left}${yamlOf(own)}`;
}

// Plain data as YAML: a line a field, and a line an item of a list of groups; all else is JSON, which is YAML too.
function yamlOf(data) {
  const lines = [];
  for (const [name, value] of Object.entries(data)) {
    if (Array.isArray(value) && value.some((item) => item && typeof item === "object" && !Array.isArray(item))) {
      lines.push(`${name}:`, ...value.map((item) => `  - ${flowYaml(item)}`));
    } else {
      lines.push(`${name}: ${flowYaml(value)}`);
    }
  }
  return lines.join("\n") + "\n";
}

// A number without a point before its exponent is a text in YAML.
function flowYaml(value) {
  if (Array.isArray(value)) return `[${value.map(flowYaml).join(", ")}]`;
  if (value && typeof value === "object") {
    return `{${Object.entries(value).map(([name, one]) => `${JSON.stringify(name)}: ${flowYaml(one)}`).join(", ")}}`;
  }
  if (typeof value === "number") return String(value).replace(/^(-?\d+)e/, "$1.0e");
  return JSON.stringify(value);
}

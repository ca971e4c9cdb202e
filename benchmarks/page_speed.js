// SPDX-License-Identifier: GPL-2.0-or-later
// Steps an image of a scene in node as a page does: page_speed.js CORE IMAGE FIELDS, behind live/core.js. For each line, a number of steps,
// one of JSON: processor seconds, and the step that was reached.
const { readFileSync } = require("node:fs");
const [code, image, fields] = process.argv.slice(2).map((file) => readFileSync(file));
const module_ = new WebAssembly.Module(code);
const core = new LiveCore(module_, image.buffer.slice(image.byteOffset, image.byteOffset + image.length), { fields: JSON.parse(fields) });
require("node:readline").createInterface({ input: process.stdin }).on("line", (line) => {
  const before = process.cpuUsage(), wrong = core.run(core.step + Number(line)), { user, system } = process.cpuUsage(before);
  console.log(JSON.stringify({ seconds: (user + system) / 1e6, step: core.step, wrong }));
});

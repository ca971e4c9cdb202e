// SPDX-License-Identifier: GPL-2.0-or-later
// Steps a flow in node by the scripts of a live page, with sliders moved at given steps: host.mjs JOB
import { readFileSync, writeFileSync } from "node:fs";
import vm from "node:vm";

const job = JSON.parse(readFileSync(process.argv[2], "utf8"));
const page = vm.createContext({ WebAssembly, performance, structuredClone, console });
for (const file of job.scripts) vm.runInContext(readFileSync(file, "utf8"), page, { filename: file });
const image = readFileSync(job.image), module = await WebAssembly.compile(readFileSync(job.core));
Object.assign(page, { module, image: new Uint8Array(image).buffer, head: JSON.parse(readFileSync(job.head, "utf8")) });
vm.runInContext("var core = new LiveCore(module, image, head), moves = new Moves(core, head);", page);
if (job.begin) vm.runInContext(`moves.beginWith(${JSON.stringify(job.begin)})`, page);
let wrong = "";
for (const [step, name, value] of [...job.moves, [job.until]]) {
  const begun = process.cpuUsage();
  wrong ||= vm.runInContext(`moves.run(${step})`, page);
  job.spent = (job.spent || 0) + process.cpuUsage(begun).user * 1e-6;
  if (name) vm.runInContext(`moves.want(${JSON.stringify(name)}, ${value})`, page);
}
writeFileSync(job.out, vm.runInContext("core.state()", page));
writeFileSync(`${job.out}.yaml`, vm.runInContext("caseText(head, moves.tables())", page));
writeFileSync(`${job.out}.json`, JSON.stringify({ wrong, spent: job.spent, tables: vm.runInContext("moves.tables()", page) }));

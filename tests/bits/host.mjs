// SPDX-License-Identifier: GPL-2.0-or-later
// Runs host.cpp, compiled for WebAssembly, in node: host.mjs PROGRAM IMAGE STEP OUT
import { readFile } from "node:fs/promises";
import { dirname } from "node:path";
import { WASI } from "node:wasi";

const [program, image, step, out] = process.argv.slice(2);
const folders = Object.fromEntries([image, out].map((file) => [dirname(file), dirname(file)]));
const wasi = new WASI({ version: "preview1", args: ["host", image, step, out], preopens: folders });
const module = await WebAssembly.compile(await readFile(program));
process.exitCode = wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject()));

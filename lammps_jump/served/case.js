"use strict";
// The page of a case: the text goes to the server, which tells what it means, and to the file.

const SAVE_AFTER = 500;
const LOOK_AGAIN = 1000;
// A look at a text that is out of date is left after so long.
const LEAVE_AFTER = 1000;
// Pixels of a drawing at least; a narrower screen moves over it.
const LEAST = 480;

const editor = new Editor(), places = new Places(editor);
new Drawn(editor, places);
const file = { key: null, name: "", saved: null, busy: false, timer: null, conflict: null };
const open = { notes: false };
const looks = { number: 0, since: null, timer: null, page: Math.random().toString(36).slice(2) };
let looked = null;

// ---- what the text means ----

// Look at the text, and again while it has changed meanwhile. A look that takes long is left for one at a newer text.
async function look() {
  clearTimeout(looks.timer);
  if (looks.since !== null && performance.now() - looks.since < LEAVE_AFTER) {
    looks.timer = setTimeout(look, LEAVE_AFTER);
    return;
  }
  if (looked === editor.text) return;
  const number = ++looks.number, { page } = looks;
  while (looked !== editor.text) {
    const text = looked = editor.text, wide = Math.max(LEAST, Math.floor(byId("drawing").clientWidth));
    looks.since = performance.now();
    const { ok, status, data } = await ask("look", { text, wide, page });
    if (number !== looks.number) return;
    if (!status) say(data.refused);
    else if (!ok) wrong({ text: data.refused });
    else if (data.error) wrong(data.error);
    else right(data, text);
    tellAll("drawn", { text });
  }
  looks.since = null;
}

function wrong({ line, text }) {
  const box = byId("error");
  box.replaceChildren();
  if (line) {
    const link = made("button", { type: "button", class: "link" }, `Line ${line}`);
    link.addEventListener("click", () => editor.goTo(line));
    box.append(link, ": ");
  }
  box.append(text);
  editor.mark(line || 1);
  document.body.classList.add("stale");
}

function right(found, text) {
  byId("error").replaceChildren();
  editor.mark(null);
  document.body.classList.remove("stale");
  places.show(found, text);
  byId("name").textContent = [found.name, found.description].filter(Boolean).join(": ");
  document.title = `${found.name}: lammps-jump`;
  const list = (texts) => made("ul", {}, ...texts.map((one) => made("li", {}, one)));
  const doubts = made("div", { class: "warn" }, made("b", {}, "Doubtful"), list(found.doubtful));
  const notes = made("details", { open: open.notes }, made("summary", {}, "Notes"), list(found.notes));
  notes.addEventListener("toggle", () => { open.notes = notes.open; });
  byId("doubtful").replaceChildren(...(found.doubtful.length ? [doubts] : []), ...(found.notes.length ? [notes] : []));
  byId("derived").replaceChildren(...found.derived.map(([title, rows]) => {
    const cells = rows.map(([label, value, unit]) => made("tr", {}, made("th", { scope: "row" }, label),
      made("td", { class: "n" }, value.replace(/^-/, "\u2212")), made("td", {}, unit)));
    return made("div", {}, made("h3", {}, title), made("div", { class: "scroll" }, made("table", {}, ...cells)));
  }));
}

// ---- the file ----

function say(text) {
  byId("state").textContent = text;
}

async function save() {
  clearTimeout(file.timer);
  if (file.busy || file.conflict || editor.text === file.saved) return;
  file.busy = true;
  const text = editor.text, { ok, status, data } = await ask("save", { text, key: file.key }, true);
  file.busy = false;
  if (ok || (status === 409 && data.text === text)) {
    Object.assign(file, { key: data.key, saved: text });
    say("Saved");
  } else if (status === 409) {
    differs(data);
  } else {
    say(`Not saved: ${data.refused}`);
    file.timer = setTimeout(save, 4 * SAVE_AFTER);
    return;
  }
  if (editor.text !== file.saved) later();
}

function later() {
  clearTimeout(file.timer);
  if (editor.text !== file.saved && !file.conflict) say("Not saved yet");
  file.timer = setTimeout(save, SAVE_AFTER);
}

// Another program has changed the file, and this text too is another one.
function differs(other) {
  file.conflict = other;
  byId("notice").hidden = false;
  byId("notice").firstElementChild.textContent =
    `${file.name} was changed by another program. This text is not saved; which one is to stay?`;
  say("Not saved");
}

function settle(keep) {
  const { text, key } = file.conflict;
  Object.assign(file, { conflict: null, key, saved: text });
  byId("notice").hidden = true;
  if (keep) save();
  else editor.replace(text);
  byId("text").focus();
}

// See whether another program, or another page, has changed the file.
async function watch() {
  const { ok, ended, data } = await ask(`file?key=${file.key || ""}`);
  if (!ok) return say(ended ?
    "The program that serves this page has ended. What is not saved stays here as long as the page is open." : data.refused);
  offerRun(data.run);
  file.largest = data.largest;
  if (data.text === null || file.busy || file.conflict || data.key === file.key) return undefined;
  const first = file.saved === null;
  if (!first && editor.text !== file.saved) return differs(data);
  Object.assign(file, { key: data.key, name: data.name, saved: data.text });
  if (first) editor.begin(data.text);
  else editor.replace(data.text);
  say(first ? data.name : `${data.name} was changed by another program: this is its text`);
  return look();
}

// ---- the run ----

function offerRun(run) {
  file.run = run;
  byId("go").disabled = !run || Boolean(run.why);
  byId("run-why").textContent = (run && run.why) || "";
  byId("go").textContent = run && run.number !== null ? "Show the run" : "Run";
  byId("run-act").querySelector("code").textContent = run ? run.command : "";
}

async function go() {
  await save();
  if (editor.text !== file.saved) return;
  byId("go").disabled = true;
  const { ok, data } = await ask("run", { key: file.key });
  byId("go").disabled = false;
  byId("run-error").textContent = ok ? "" : data.refused;
  if (ok) showRun(data.number);
}

document.addEventListener("text", () => { look(); later(); });
document.addEventListener("dropped", save);
document.addEventListener("visibilitychange", () => document.hidden && save());
addEventListener("beforeunload", (event) => {
  const lost = file.conflict || packed({ text: editor.text, key: file.key }).length >= KEPT;
  if (lost && file.saved !== null && editor.text !== file.saved) event.preventDefault();
});
document.addEventListener("keydown", (event) => {
  const command = event.ctrlKey || event.metaKey;
  if (command && event.key === "s") { event.preventDefault(); save(); }
  if (command && event.key === "Enter" && !byId("go").disabled) { event.preventDefault(); go(); }
});
byId("go").addEventListener("click", go);
byId("take").addEventListener("click", () => settle(false));
byId("keep").addEventListener("click", () => settle(true));
let wide = 0;
new ResizeObserver(() => {
  const now = Math.floor(byId("drawing").clientWidth);
  if (Math.abs(now - wide) > 8 && file.saved !== null) { looked = null; look(); }
  wide = now;
}).observe(byId("drawing"));
again(LOOK_AGAIN, watch);

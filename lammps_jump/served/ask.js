"use strict";
// Questions to the server, and small helpers of all pages.

// Bytes of all that a browser sends for pages that are closed; it has 64 KiB.
const KEPT = 60000;
const OWN = document.currentScript.src;

const byId = (name) => document.getElementById(name);

function tellAll(name, detail) {
  document.dispatchEvent(new CustomEvent(name, { detail }));
}

// An element with its text and parts.
function made(tag, attributes = {}, ...parts) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in element && typeof value !== "string") element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...parts);
  return element;
}

const packed = (sent) => new TextEncoder().encode(JSON.stringify(sent));

// What the server answers: { ok, status, data }. Without an answer, status is 0, and `ended` tells whether it is gone.
// What is `kept` is sent also where the page is closed meanwhile, if it is short enough.
async function ask(path, sent, kept = false) {
  const body = sent === undefined ? null : packed(sent);
  const how = body ? { method: "POST", headers: { "Content-Type": "application/json" }, body } : {};
  for (const keepalive of kept && body.length < KEPT ? [true, false] : [false]) {
    try {
      const reply = await fetch(path, { cache: "no-store", keepalive, ...how });
      const data = reply.headers.get("Content-Type") === "application/json" ? await reply.json() : await reply.arrayBuffer();
      return { ok: reply.ok, status: reply.status, data };
    } catch {
      // the browser had no room to keep it, or the line was cut
    }
  }
  const ended = await fetch(OWN, { cache: "no-store" }).then(() => false, () => true);
  const refused = ended ? "the program that serves this page has ended" : "the answer was cut off; try again";
  return { ok: false, status: 0, ended, data: { refused } };
}

// The page of a run within this one, as high as it is.
function showRun(number) {
  const frame = made("iframe", { id: "run", src: `run/${number}/`, title: "The run" });
  frame.addEventListener("load", () => {
    const { body } = frame.contentDocument;
    new ResizeObserver(() => { frame.style.height = `${body.offsetHeight + 4}px`; }).observe(body);
  });
  byId("run-place").replaceChildren(frame);
}

// Do something again and again, so many milliseconds (a number, or what a function tells) after it has ended, while the
// page is seen.
function again(milliseconds, act) {
  const pause = typeof milliseconds === "function" ? milliseconds : () => milliseconds;
  const turn = async () => {
    if (!document.hidden) await act();
    setTimeout(turn, pause());
  };
  turn();
}

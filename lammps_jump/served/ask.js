"use strict";
// Questions to the server, and small helpers of all pages.

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

// What the server answers: { ok, status, data }. Where it does not answer, status is 0.
async function ask(path, sent) {
  const how = sent === undefined ? {} : {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(sent),
    keepalive: JSON.stringify(sent).length < 60000, // also where the page is closed meanwhile
  };
  try {
    const reply = await fetch(path, { cache: "no-store", ...how });
    const data = reply.headers.get("Content-Type") === "application/json" ? await reply.json() : await reply.arrayBuffer();
    return { ok: reply.ok, status: reply.status, data };
  } catch {
    return { ok: false, status: 0, data: { refused: "the program that serves this page has ended" } };
  }
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

// Do something again and again, so many milliseconds after it has ended, while the page is seen.
function again(milliseconds, act) {
  const turn = async () => {
    if (!document.hidden) await act();
    setTimeout(turn, milliseconds);
  };
  turn();
}

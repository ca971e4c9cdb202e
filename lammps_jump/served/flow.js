"use strict";
// The flow of the text, live within the page: set up again from the start where the text has become another case.

const FLOW_AFTER = 700;
const flowing = { text: null, timer: null, page: Math.random().toString(36).slice(2) };

function flowState(text) {
  byId("flow-state").textContent = text;
}

function flowLater() {
  clearTimeout(flowing.timer);
  flowing.timer = setTimeout(flowNow, FLOW_AFTER);
}

// The live page of the text; the one before stays until the next is there.
async function flowNow() {
  if (!byId("flow").checked || flowing.text === editor.text || document.body.classList.contains("stale")) return;
  const text = flowing.text = editor.text;
  flowState("The case is being set up.");
  const { ok, data } = await ask("flow", { text, page: flowing.page });
  if (!byId("flow").checked || text !== flowing.text || data.left) return;
  flowState(ok ? "" : data.refused);
  if (ok) byId("flow-place").replaceChildren(made("iframe", { src: data.at, title: "The flow, live" }));
}

byId("flow").addEventListener("change", () => {
  flowing.text = null;
  flowState("");
  if (byId("flow").checked) flowNow();
  else byId("flow-place").replaceChildren();
});
document.addEventListener("drawn", flowLater);

"use strict";
// A live page that goes on from a moment of the run. It is unpacked into a frame of this page when a reader presses a button.
// Its recorded frames are those of the player of this page.

(() => {
  // Pixels of the edges of the frame, with room for what is rounded.
  const EDGES = 4;
  const box = document.querySelector(".differently"), place = document.querySelector(".live-place");
  const buttons = [...box.querySelectorAll(".moment")], moments = buttons.map((one) => Number(one.dataset.time));
  const told = (text) => { document.querySelector(".told-live").textContent = text; };
  let text = null, frame = null;

  async function unpacked() {
    const bytes = Uint8Array.from(atob(document.getElementById("live-page").textContent), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  async function begin(number) {
    tell("play", { on: false });
    tell("seek", moments[number]);
    text ??= await unpacked();
    const frames = document.getElementById("frames0").textContent;
    frame = document.createElement("iframe");
    frame.title = `The flow from t = ${moments[number]} s on, live`;
    frame.srcdoc = text.replace('id="frames0">', () => `id="frames0">${frames}`)
      .replace("<html ", () => `<html data-begin="${number}" `);
    place.replaceChildren(frame);
    frame.scrollIntoView({ block: "start" });
  }

  function beginAt(number) {
    begin(number).catch((error) => told(`The flow cannot run here: ${error.message}.`));
  }

  buttons.forEach((one, number) => one.addEventListener("click", () => beginAt(number)));
  box.querySelector(".here").addEventListener("click", () => {
    const now = players[0].time + 1e-9, before = moments.map((moment, k) => (moment <= now ? k : -1)).filter((k) => k >= 0);
    const latest = before.reduce((a, b) => (moments[b] > moments[a] ? b : a), before[0]);
    if (latest === undefined) told(`The page can go on from t = ${Math.min(...moments)} s at the earliest: seek there.`);
    else beginAt(latest);
  });
  addEventListener("message", ({ source, data }) => {
    if (frame && source === frame.contentWindow && data && Number.isFinite(data.height)) frame.style.height = `${data.height + EDGES}px`;
  });
})();

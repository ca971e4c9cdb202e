"use strict";
// The page of a run: asks the server what is new, and shows it.

// Milliseconds after an answer until the next question: of a run that goes on, of another one, and of curves.
const ASK_SOON = 60, ASK_AGAIN = 400, CURVES_AGAIN = 1000;
const WORDS_OF = {
  none: "There is no run yet", starting: "The run begins", running: "The run goes on", complete: "The run is complete",
  interrupted: "The run was stopped and can go on", failed: "The run failed", refused: "The command was refused",
  unchecked: "The run has ended; its analysis has not", damaged: "What the run wrote is damaged",
};

const OWN_NAME = Math.random().toString(36).slice(2);

let growing = null, shownOf = null, shownCurves = "", status = "none", curvesOf = "";

async function refresh() {
  const { ok, data } = await ask("state");
  if (!ok) return void (byId("error").textContent = data.refused);
  showState(data);
  if (data.about) await showFrames(data);
  return data.more ? refresh() : undefined;
}

// Curves take longer than frames, and are requested separately where there are new frames.
async function refreshCurves() {
  const now = growing ? `${shownOf} ${growing.times.length} ${status}` : "";
  if (now === curvesOf) return;
  curvesOf = now;
  const { ok, data } = await ask("curves");
  if (ok) showCurves(data);
}

function showState(data) {
  status = data.status;
  byId("error").textContent = ["failed", "refused"].includes(data.status) ? data.message : data.trouble || "";
  byId("name").textContent = data.name ? [data.name, data.description].filter(Boolean).join(": ") : data.folder;
  document.title = `${data.name || data.folder}: lammps-jump`;
  const at = data.reached ? `, ${data.reached}` : "";
  const writer = data.status === "running" && !data.own ? `; ${data.message} writes it` : "";
  const said = `${WORDS_OF[data.status] || data.status}${at}${writer}. ${data.folder}`;
  if (byId("state").textContent !== said) byId("state").textContent = said;
  byId("progress").hidden = ["complete", "damaged", "failed", "refused"].includes(data.status);
  byId("progress").value = data.time && data.duration ? data.time / data.duration : 0;
  for (const [name, command] of [["stop", data.stop], ["go-on", data.own ? null : data.go_on], ["report", data.report],
    ["differently", data.differently]]) {
    byId(name).parentElement.hidden = !command;
    byId(name).parentElement.querySelector("code").textContent = command || "";
  }
  byId("told").hidden = !data.log.length;
  byId("log").textContent = [`$ ${data.command}`, ...data.log].join("\n");
}

async function showFrames(data) {
  if (shownOf !== data.about.of) {
    growing = new Growing(data.about);
    shownOf = data.about.of;
  }
  const seen = players.length ? players[0].run.seen : null, before = growing.times.length;
  growing.about(data.about);
  while (growing.times.length < data.frames) {
    const { ok, data: buffer } = await ask(`frames?first=${growing.times.length}&of=${shownOf}`);
    if (!ok || !buffer.byteLength) break;
    growing.add(buffer);
  }
  if (growing.times.length === before || !growing.rows) return;
  if (!players.length) return begin();
  const [p] = players;
  if (p.run !== growing) {
    pageData.players[0] = growing;
    const newest = isFollowing(p);
    takeRun(p, 0);
    if (newest) goOnFollowing(p, performance.now());
    layOut(p);
  } else {
    showGrowth(p, seen, performance.now());
  }
  tellAll("frames", growing.times.length);
}

// The first frame: the player of the report, on a run that grows.
function begin() {
  pageData.players = [growing];
  byId("shown").replaceChildren(byId("player").content.cloneNode(true));
  const p = startPlayer(byId("shown").querySelector(".player"), 0);
  followNewest(p);
  tellAll("frames", growing.times.length);
}

function showCurves(curves) {
  const absent = curves.filter((one) => one.absent).map((one) => `${one.title}: ${one.absent}.`).join(" ");
  byId("absent").textContent = absent;
  const shown = curves.filter((one) => one.chart), now = JSON.stringify(shown);
  if (now === shownCurves) return;
  shownCurves = now;
  pageData.curves.splice(0, pageData.curves.length, ...shown.map((one) => one.chart));
  const box = byId("curves");
  if ([...box.children].map((one) => one.dataset.key).join() !== shown.map((one) => one.key).join()) {
    box.replaceChildren(...shown.map((one, number) => {
      const place = made("div", {}, made("figure", { class: "curve", "data-curve": String(number) }, made("figcaption", {}, one.title)));
      place.dataset.key = one.key;
      return place;
    }));
  }
  tellAll("curves");
}

async function act(name) {
  byId(name).disabled = true;
  const { ok, data } = await ask(name, {});
  byId(name).disabled = false;
  if (!ok) byId("error").textContent = data.refused;
  await refresh();
}

// The run from the instant that is shown on, in a frame: a live page, which tells how high it is.
async function differently() {
  const state = (text) => { byId("differently-state").textContent = text; };
  if (!players.length) return state("There is no frame yet.");
  tell("play", { on: false });
  byId("differently").disabled = true;
  state("The flow is being set up.");
  const { ok, data } = await ask("differently", { time: players[0].time, page: OWN_NAME });
  byId("differently").disabled = false;
  state(ok ? "" : data.refused);
  if (!ok) return undefined;
  const frame = made("iframe", { src: data.at, title: "The flow from here on, live" });
  addEventListener("message", ({ source, data: told }) => {
    if (source === frame.contentWindow && told && Number.isFinite(told.height)) frame.style.height = `${told.height + 4}px`;
  });
  byId("differently-place").replaceChildren(frame);
  return frame.scrollIntoView({ block: "start" });
}

byId("differently").addEventListener("click", differently);
byId("stop").addEventListener("click", () => act("stop"));
byId("go-on").addEventListener("click", () => act("go-on"));
again(() => (["starting", "running"].includes(status) ? ASK_SOON : ASK_AGAIN), refresh);
again(() => CURVES_AGAIN, refreshCurves);

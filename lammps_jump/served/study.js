"use strict";
// The page of a study: its table as it fills, and its runs, one of which is shown below. `study` tells the rest of the page.

const ASK_AGAIN = 1500;
let shown = "", chosen = null;

async function refresh() {
  const { ok, data } = await ask("state");
  byId("error").textContent = ok ? "" : data.refused;
  if (!ok) return;
  const over = data.runs.filter(({ stage }) => ["done", "failed"].includes(stage)).length;
  byId("progress").value = over / Math.max(1, data.runs.length);
  byId("progress").parentElement.hidden = over === data.runs.length;
  const said = `${data.status}. ${data.folder}`;
  if (byId("state").textContent !== said) byId("state").textContent = said;
  if (JSON.stringify(data) === shown) return;
  shown = JSON.stringify(data);
  byId("name").textContent = [data.name, data.description].filter(Boolean).join(": ");
  document.title = `${data.name}: study`;
  byId("command").textContent = data.command;
  fill(byId("table"), data.columns, data.rows.map((row) => row.map(String)));
  byId("doubts").replaceChildren(...(data.doubts.length ? [made("div", { class: "warn" }, made("b", {}, "What to know"),
    made("ul", {}, ...data.doubts.map((one) => made("li", {}, one))))] : []));
  fill(byId("runs"), ["", "point", "seed", "state", ""], data.runs.map((run) => [look(run), run.point, String(run.seed), run.stage, run.message]));
  tellAll("study", data);
}

function fill(table, columns, rows) {
  const focused = document.activeElement?.dataset?.number;
  const head = made("tr", {}, ...columns.map((one) => made("th", { scope: "col" }, one)));
  table.replaceChildren(...(rows.length ? [head] : []), ...rows.map((row) => made("tr", {}, ...row.map((one) => made("td", {}, one)))));
  if (focused !== undefined) table.querySelector(`[data-number="${focused}"]`)?.focus();
}

function look(run) {
  const button = made("button", { type: "button", "aria-pressed": String(run.number === chosen),
    "aria-label": `Show the run at ${run.point}, seed ${run.seed}`, disabled: run.stage === "waiting" }, "Show");
  button.dataset.number = run.number;
  button.addEventListener("click", () => choose(run.number));
  return button;
}

// Show a run of the study.
function choose(number) {
  chosen = number;
  for (const one of document.querySelectorAll("#runs button")) one.setAttribute("aria-pressed", String(Number(one.dataset.number) === number));
  showRun(number);
  tellAll("chosen", number);
}

again(ASK_AGAIN, refresh);

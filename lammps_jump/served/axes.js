"use strict";
// Sliders over the axes of a study: together they choose the finished run that is shown. A run that is chosen moves them.

let axes = [], among = [], begun = false;

const sliders = () => [...document.querySelectorAll("#sliders .axis")];
const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

function tellValues() {
  sliders().forEach((slider, axis) => {
    slider.parentElement.querySelector("output").textContent = axes[axis].shown[slider.value];
    slider.setAttribute("aria-valuetext", axes[axis].shown[slider.value]);
  });
}

// The finished run at the sliders; where there is none the one before stays, and the page says so.
function moved() {
  tellValues();
  const at = sliders().map((slider) => Number(slider.value)), gone = byId("sliders").querySelector(".gone");
  const here = among.filter(({ stage, place }) => stage === "done" && same(place, at.map((one, axis) => axes[axis].values[one])));
  gone.hidden = here.length > 0;
  gone.textContent = here.length ? "" : `No finished run at ${at.map((one, axis) => axes[axis].shown[one]).join(", ")}.`;
  if (here.length && !here.some(({ number }) => number === chosen)) choose(here[0].number);
}

// The sliders go to the run that is shown.
function follow(number) {
  const run = among.find((one) => one.number === number);
  if (!run) return;
  sliders().forEach((slider, axis) => { slider.value = axes[axis].values.findIndex((value) => same(value, run.place[axis])); });
  tellValues();
  byId("sliders").querySelector(".gone").hidden = true;
}

function build() {
  byId("sliders").className = "axes";
  byId("sliders").replaceChildren(...axes.map(({ label, values }) => {
    const slider = made("input", { type: "range", class: "axis", min: "0", max: String(values.length - 1), step: "1",
      value: String(Math.floor(values.length / 2)) });
    slider.addEventListener("input", moved);
    return made("label", {}, made("span", {}, label), slider, made("output"));
  }), made("p", { class: "small gone", role: "status", hidden: true }));
  tellValues();
}

document.addEventListener("study", ({ detail }) => {
  among = detail.runs;
  if (!same(axes, detail.axes)) {
    axes = detail.axes;
    build();
    follow(chosen);
  }
  if (!axes.length) return;
  const done = among.filter(({ stage }) => stage === "done");
  if (!begun && chosen === null && done.length) choose(done[Math.floor(done.length / 2)].number);
  else if (!byId("sliders").querySelector(".gone").hidden) moved(); // it may have ended now
  begun ||= done.length > 0;
});
document.addEventListener("chosen", ({ detail }) => axes.length && follow(detail));

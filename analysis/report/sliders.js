"use strict";
// Sliders over the axes of a study. Together they choose the run that the player shows, with its numbers and curves.

function startSliders(p) {
  const box = part(p, "axes");
  if (!box) return;
  const places = JSON.parse(box.dataset.places), list = part(p, "run"), gone = part(p, "gone");
  const sliders = [...box.querySelectorAll(".axis")], first = Number(list.options[0].value);
  const named = (slider) => JSON.parse(slider.dataset.values)[slider.value];

  function tellValues() {
    for (const slider of sliders) {
      slider.parentElement.querySelector("output").textContent = named(slider);
      slider.setAttribute("aria-valuetext", named(slider));
    }
  }

  // The run at the sliders; where there is none the one before stays, and the page says so.
  function moved() {
    tellValues();
    const wanted = sliders.map((slider) => Number(slider.value));
    const number = places.findIndex((place) => place.every((value, axis) => value === wanted[axis]));
    gone.hidden = number >= 0;
    gone.textContent = number >= 0 ? "" : `No finished run with frames at ${sliders.map(named).join(", ")}.`;
    if (number < 0 || list.value === String(first + number)) return;
    list.value = first + number;
    list.dispatchEvent(new Event("change"));
  }

  function shown() {
    const number = Number(list.value) - first;
    sliders.forEach((slider, axis) => { slider.value = places[number][axis]; });
    tellValues();
    gone.hidden = true;
    for (const side of document.querySelectorAll(".of-run")) side.hidden = side.dataset.run !== list.value;
  }

  for (const slider of sliders) slider.addEventListener("input", moved);
  list.addEventListener("change", shown);
  shown();
}

players.forEach(startSliders);

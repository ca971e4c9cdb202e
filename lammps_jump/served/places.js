"use strict";
// The drawing, and the dots on it that can be dragged. A dot knows where its numbers are in the text of the drawing.

// Pixels between the ends of what is drawn, at least.
const LEAST_DRAWN = 5;

class Places {
  constructor(editor) {
    this.editor = editor;
    this.box = byId("drawing");
    this.chosen = "";
    this.box.addEventListener("keydown", (event) => this.key(event));
    document.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, (event) => this.drop(event));
  }

  // Show a drawing of a text, as the server made it.
  show(found, text) {
    const focused = this.box.contains(document.activeElement);
    Object.assign(this, { found, text });
    const drawn = new DOMParser().parseFromString(found.drawing, "image/svg+xml").documentElement;
    this.dots = found.places.map((place, index) => this.dot(place, index));
    this.box.replaceChildren(document.importNode(drawn, true), ...this.dots.filter(Boolean));
    this.enter(focused);
  }

  get inside() {
    const { x, y } = this.found.view;
    return (place) => (place.x === null || (place.x >= x[0] && place.x <= x[1])) &&
      (place.y === null || (place.y >= y[0] && place.y <= y[1]));
  }

  // A button where a place is; null where it is not in sight.
  dot(place, index) {
    if (!this.inside(place)) return null;
    const { left, top, x, y, scale } = this.found.view;
    const across = place.x === null ? "all-x" : place.y === null ? "all-y" : "";
    const button = made("button", { type: "button", class: `dot ${across}`, tabindex: "-1", title: place.name,
      "aria-label": `${place.name}: ${this.told(place)}`, "aria-describedby": "how" });
    button.style.left = `${left + ((place.x ?? x[1] - 12 / scale) - x[0]) * scale}px`;
    button.style.top = `${top + (y[1] - (place.y ?? y[1] - 10 / scale)) * scale}px`;
    if (place.y === null) button.style.setProperty("--long", `${(y[1] - y[0]) * scale - 10}px`);
    button.addEventListener("pointerdown", (event) => this.take(event, index));
    button.addEventListener("focus", () => this.choose(index));
    return button;
  }

  told(place) {
    const side = (name, value) => (value === null ? [] : [`${name} ${Number(value.toPrecision(6))} m`]);
    return [...side("x", place.x), ...side("y", place.y)].join(", ").replaceAll("-", "\u2212");
  }

  // One dot can be entered by Tab: the one that was used last.
  enter(focused) {
    const known = this.found.places.findIndex((place, index) => place.name === this.chosen && this.dots[index]);
    const index = known >= 0 ? known : this.dots.findIndex(Boolean);
    if (index < 0) return;
    this.dots[index].tabIndex = 0;
    if (focused) this.dots[index].focus({ preventScroll: true });
  }

  choose(index) {
    this.dots.forEach((one, k) => { if (one) one.tabIndex = k === index ? 0 : -1; });
    this.chosen = this.found.places[index].name;
    byId("where").textContent = `${this.chosen}: ${this.told(this.found.places[index])}`;
  }

  // The text with a place moved from where the drawing of a text has it, m.
  moved({ found, text, index }, dx, dy, fine) {
    const place = found.places[index], changes = new Map();
    if (place.radius_of) {
      const [x, y] = place.radius_of, radius = Math.hypot(place.x + dx - x, place.y + dy - y);
      changes.set(place.along_x[0], radius);
    } else {
      for (const one of place.along_x) changes.set(one, found.numbers[one].value + dx);
      for (const one of place.along_y) changes.set(one, found.numbers[one].value + dy);
    }
    const sorted = [...changes].sort(([a], [b]) => found.numbers[b].start - found.numbers[a].start);
    let made = text;
    for (const [one, value] of sorted) {
      const { start, end, unit, value: before } = found.numbers[one];
      if (value === before) continue;
      made = made.slice(0, start) + this.written(value / unit, fine / unit) + made.slice(end);
    }
    return made;
  }

  // A number with as many decimals as the step has.
  written(value, step) {
    const decimals = Math.min(9, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    return String(Number(value.toFixed(decimals)) || 0);
  }

  // The power of ten that is at most a pixel.
  get fine() {
    return 10 ** Math.floor(Math.log10(1 / this.found.view.scale));
  }

  take(event, index) {
    if (event.button !== 0 || this.editor.text !== this.text) return; // the drawing is of another text
    event.preventDefault();
    event.target.focus({ preventScroll: true });
    this.editor.hold();
    this.held = { found: this.found, text: this.text, index, x: event.clientX, y: event.clientY, id: event.pointerId };
    document.body.classList.add("dragging");
  }

  move(event) {
    const { held } = this;
    if (!held || event.pointerId !== held.id) return;
    const { scale } = held.found.view, fine = 10 ** Math.floor(Math.log10(1 / scale));
    this.editor.replace(this.moved(held, (event.clientX - held.x) / scale, (held.y - event.clientY) / scale, fine));
  }

  drop(event) {
    if (!this.held || event.pointerId !== this.held.id) return;
    if (event.type === "pointercancel") this.editor.replace(this.held.text);
    this.held = null;
    this.editor.release();
    document.body.classList.remove("dragging");
    tellAll("dropped");
  }

  key(event) {
    const index = this.dots ? this.dots.indexOf(event.target) : -1;
    if (index < 0 || event.ctrlKey || event.metaKey) return;
    const turn = { PageDown: 1, PageUp: -1 }[event.key];
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!turn && !way) return;
    event.preventDefault();
    if (turn) {
      const there = this.dots.map((one, k) => (one ? k : -1)).filter((k) => k >= 0), at = there.indexOf(index);
      this.dots[there[(at + turn + there.length) % there.length]].focus();
    } else if (this.editor.text === this.text) {
      const step = this.fine * (event.shiftKey ? 100 : event.altKey ? 1 : 10);
      this.editor.hold();
      this.editor.replace(this.moved({ found: this.found, text: this.text, index }, way[0] * step, way[1] * step, step));
      this.editor.release();
    }
  }
}

// What a button above the drawing draws into the case: from where the pointer goes down to where it is let go.
class Drawn {
  constructor(editor, places) {
    Object.assign(this, { editor, places, what: "", begun: null });
    this.box = byId("drawing");
    this.buttons = [...document.querySelectorAll("#tools button")];
    for (const button of this.buttons) {
      // a key gives a click without a count
      button.addEventListener("click", ({ detail }) => (detail ? this.choose(button.value) : this.middle(button.value)));
    }
    this.box.addEventListener("pointerdown", (event) => this.begin(event), true);
    document.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, (event) => this.end(event));
    document.addEventListener("keydown", ({ key }) => key === "Escape" && this.choose(""));
  }

  // Take a tool, or put it away where it is in hand.
  choose(what) {
    this.what = what === this.what ? "" : what;
    this.buttons.forEach((one) => one.setAttribute("aria-pressed", String(one.value === this.what)));
    this.box.classList.toggle("drawn-on", Boolean(this.what));
    this.begun = null;
    this.sketch(null);
  }

  get svg() {
    return this.box.querySelector("svg");
  }

  // Pixels of the drawing under the pointer.
  at({ clientX, clientY }) {
    const { left, top } = this.svg.getBoundingClientRect();
    return [clientX - left, clientY - top];
  }

  // Place in the case of a point of the drawing, m, in steps of a pixel or less.
  placeOf([across, down]) {
    const { left, top, x, y, scale } = this.places.found.view, { fine } = this.places;
    return [x[0] + (across - left) / scale, y[1] - (down - top) / scale].map((one) => Number(this.places.written(one, fine)));
  }

  begin(event) {
    if (!this.what || event.button !== 0 || this.editor.text !== this.places.text || !this.svg) return;
    event.preventDefault();
    event.stopPropagation(); // the dots are not taken meanwhile
    this.begun = { id: event.pointerId, from: this.at(event) };
  }

  move(event) {
    if (this.begun && event.pointerId === this.begun.id) this.sketch(this.begun.from, this.at(event));
  }

  end(event) {
    if (!this.begun || event.pointerId !== this.begun.id) return;
    const { from } = this.begun, to = this.at(event), { what } = this;
    this.begun = null;
    this.sketch(null);
    if (event.type === "pointercancel" || Math.hypot(to[0] - from[0], to[1] - from[1]) < LEAST_DRAWN) return;
    this.choose("");
    this.add(what, [from, to]);
  }

  // The shape in the middle of the drawing, for who has no pointer: its dots are moved by keys then.
  middle(what) {
    const { left, top, x, y, scale } = this.places.found.view;
    const [wide, high] = [(x[1] - x[0]) * scale, (y[1] - y[0]) * scale], half = Math.min(wide, high) / 10;
    const [across, down] = [left + wide / 2, top + high / 2];
    this.add(what, what.endsWith("circle") ? [[across, down], [across + half, down]] :
      [[across - half, down + half], [across + half, down - half]]);
  }

  async add(what, ends) {
    const points = ends.map((one) => this.placeOf(one));
    let text, reply;
    do {
      ({ text } = this.editor);
      reply = await ask("shape", { text, what, points });
    } while (this.editor.text !== text); // typed meanwhile
    if (!reply.ok) return void (byId("where").textContent = reply.data.refused);
    this.editor.release();
    this.editor.replace(reply.data.text);
    this.editor.release();
    return tellAll("dropped");
  }

  // What is being drawn, as a dashed line; null: nothing.
  sketch(from, to) {
    this.shape?.remove();
    this.shape = null;
    if (!from) return;
    const [[x0, y0], [x1, y1]] = [from, to], kind = this.what.split(" ").pop();
    const [tag, numbers] = {
      line: ["line", { x1: x0, y1: y0, x2: x1, y2: y1 }],
      circle: ["circle", { cx: x0, cy: y0, r: Math.hypot(x1 - x0, y1 - y0) }],
    }[kind] || ["rect", { x: Math.min(x0, x1), y: Math.min(y0, y1), width: Math.abs(x1 - x0), height: Math.abs(y1 - y0) }];
    this.shape = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries({ ...numbers, class: "being-drawn" })) this.shape.setAttribute(name, value);
    this.svg.append(this.shape);
  }
}

"use strict";
// Curves and bars as SVG, from the described numbers of the page. A curve over time shows the time of the player
// (event "time" of the document, seconds), and a click on it asks for another one (event "seek").
(() => {
  const NARROWEST = 76, LETTER = 7.2, RIGHT = 14, TOP = 10, GAP = 18, BELOW = 40, STEP = 74;
  const charts = pageData.curves;
  const fixed = (value, digits) => (Number(value.toFixed(digits)) || 0).toFixed(digits).replace("-", "\u2212");  // no -0.0
  const text = (value) => (value === 0 ? "0" : String(Number(value.toPrecision(4)))).replace("-", "\u2212");

  function add(parent, name, attributes = {}, content = "") {
    const svg = ["svg", "g", "path", "line", "rect", "text", "circle", "clipPath", "polygon"].includes(name);
    const made = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (content) made.textContent = content;
    parent.append(made);
    return made;
  }

  // Round numbers from low to high, about `count` of them.
  function ticks(low, high, count) {
    const raw = (high - low) / Math.max(1, count), unit = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((times) => times * unit >= raw) * unit, found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    return found;
  }

  // [lowest, highest] of finite numbers and of those requested, a little wider where nothing is.
  function range(values, asked, margin) {
    let low = Infinity, high = -Infinity;
    for (const value of values) if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); }
    if (!(high >= low)) { low = 0; high = 1; }
    const wide = margin * (high - low) || (high > low ? 0 : 0.5 * Math.abs(high) || 1);
    return [asked[0] ?? low - wide, asked[1] ?? high + wide];
  }

  // Index of the number in a rising list that is nearest.
  function nearest(list, value) {
    let low = 0, high = list.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (list[middle] < value) low = middle; else high = middle; }
    return value - list[low] < list[high] - value ? low : high;
  }

  // Put a label where it hides no other one: at the first of some places that is free, else nowhere.
  function putLabel(svg, attributes, content, places, taken) {
    const made = add(svg, "text", attributes, content);
    for (const place of places) {
      for (const [key, value] of Object.entries(place)) made.setAttribute(key, value);
      const { x, y, width, height } = made.getBBox();
      const free = taken.every((box) => x > box.x + box.width || x + width < box.x || y > box.y + box.height || y + height < box.y);
      if (!free || x < 0 || x + width > svg.width.baseVal.value) continue;
      taken.push({ x, y, width, height });
      return;
    }
    made.remove();
  }

  const path = (points) => points.map((part) => "M" + part.map(([x, y]) => x.toFixed(1) + "," + y.toFixed(1)).join("L")).join("");

  // Stretches without a gap.
  function pieces(x, y) {
    const found = [[]];
    x.forEach((place, i) => {
      if (place !== null && y[i] !== null) found[found.length - 1].push([place, y[i], i]);
      else if (found[found.length - 1].length) found.push([]);
    });
    return found.filter((part) => part.length);
  }

  function save(name, columns) {
    const cell = (value) => `"${String(value ?? "").replace(/^[=+@\t-]/, "'$&").replace(/"/g, '""')}"`;
    const rows = [columns.map(([head]) => cell(head))];
    for (let i = 0; i < Math.max(...columns.map(([, values]) => values.length)); i++) {
      rows.push(columns.map(([, values]) => values[i] ?? ""));
    }
    const url = URL.createObjectURL(new Blob([rows.map((row) => row.join(",")).join("\n") + "\n"], { type: "text/csv" }));
    const link = add(document.body, "a", { href: url, download: name.replace(/[^\w]+/g, "_") + ".csv" });
    link.click();
    link.remove();
    URL.revokeObjectURL(url);
  }

  function columns(chart) {
    if (chart.bars) return [["", chart.bars.map(([label]) => label)], [chart.x, chart.bars.map(([, value]) => value)]];
    const found = [];
    for (const panel of chart.panels) {
      let before = null;
      for (const line of panel.lines) {
        if (line.x !== before) found.push([panel.x || chart.x, line.x]);
        found.push([[panel.y, line.label].filter(Boolean).join(": "), line.y]);
        if (line.error) found.push([`${line.label}: standard error`, line.error]);
        before = line.x;
      }
    }
    return found;
  }

  function legend(figure, panel) {
    const list = add(figure, "ul", { class: "legend" });
    return panel.lines.map((line) => {
      if (!line.label) return null;
      const item = add(list, "li"), sample = add(item, "svg", { width: 26, height: 10, "aria-hidden": "true" });
      if (line.look === "measured") add(sample, "circle", { class: "measured", cx: 13, cy: 5, r: 3 });
      else add(sample, "path", { class: "curve-line " + line.look, d: "M1,5H25" });
      add(item, "span", {}, line.label);
      return add(item, "b");
    });
  }

  // what the axes of a panel span
  function spans(chart, panel) {
    const known = (one) => one.lines.flatMap((line) => line.x.filter((x, i) => line.y[i] !== null));
    const xs = panel.x ? known(panel) : chart.panels.flatMap(known);
    const ys = panel.lines.filter((line) => !["faint", "dots"].includes(line.look) || panel.lines.length === 1)
      .flatMap((line) => line.error ? line.y.flatMap((y, i) => y === null ? [] : [y - 2 * (line.error[i] ?? 0), y + 2 * (line.error[i] ?? 0)]) : line.y);
    const first = chart.time && !panel.x ? Math.min(0, ...xs.filter((x) => x !== null)) : null;
    const [x0, x1] = range(xs, [panel.xlim[0] ?? first, panel.xlim[1]], 0), [y0, y1] = range(ys.concat(panel.levels.map(([, value]) => value)), panel.ylim, 0.05);
    return { x0, x1, y0, y1 };
  }

  const upTicks = ({ y0, y1 }, height) => ticks(y0, y1, (height - TOP) / 36);

  // room left of a panel for its numbers and for the lines of its name
  function leftOf(panel, span, height) {
    const long = Math.max(0, ...upTicks(span, height).map((y) => text(y).length)), lines = panel.y.split("\n").length;
    return Math.max(NARROWEST, 16 * lines + LETTER * long + 14);
  }

  // where a panel is in its figure: X and Y give the place of a value
  function scales(span, left, width, height) {
    const { x0, x1, y0, y1 } = span;
    const right = width - RIGHT, X = (x) => left + (x - x0) / (x1 - x0) * (right - left), Y = (y) => height - (y - y0) / (y1 - y0) * (height - TOP);
    return { ...span, left, right, height, X, Y };
  }

  function drawAxes(svg, chart, panel, at, own) {
    const { x0, x1, left, right, height, X, Y } = at;
    if (chart.window && !panel.x) {
      const [from, to] = chart.window.map((x) => Math.min(right, Math.max(left, X(x))));
      add(svg, "rect", { class: "stretch", x: from, y: TOP, width: to - from, height: height - TOP });
    }
    for (const y of upTicks(at, height)) {
      add(svg, "line", { class: y === 0 ? "zero" : "grid", x1: left, x2: right, y1: Y(y), y2: Y(y) });
      add(svg, "text", { x: left - 7, y: Y(y) + 4, "text-anchor": "end" }, text(y));
    }
    for (const x of ticks(x0, x1, (right - left) / STEP)) {
      add(svg, "line", { class: "grid", x1: X(x), x2: X(x), y1: TOP, y2: height });
      if (own) add(svg, "text", { x: X(x), y: height + 16, "text-anchor": "middle" }, text(x));
    }
    if (own) add(svg, "text", { class: "name", x: (left + right) / 2, y: height + 34, "text-anchor": "middle" }, panel.x || chart.x);
    const middle = (height + TOP) / 2;
    panel.y.split("\n").forEach((part, i, all) => {
      add(svg, "text", { class: "name", transform: `translate(${(all.length > 1 ? 11 : 16) + 16 * i} ${middle}) rotate(-90)`, "text-anchor": "middle" }, part);
    });
  }

  function drawLevels(svg, inside, panel, at) {
    const { left, right, height, X, Y } = at, taken = [], rows = [11, 25, 39, 53];
    for (const [title, value] of panel.levels) {
      add(inside, "line", { class: "curve-line theory", x1: left, x2: right, y1: Y(value), y2: Y(value) });
      const heights = Y(value) < TOP + 16 ? [14] : [-4, 14];
      const places = heights.flatMap((by) => [[left + 5, "start"], [right - 5, "end"]].map(([x, side]) => ({ x, y: Y(value) + by, "text-anchor": side })));
      putLabel(svg, { class: "theory" }, title, places, taken);
    }
    for (const [title, value] of panel.marks) {
      add(inside, "line", { class: "mark", x1: X(value), x2: X(value), y1: TOP, y2: height });
      const places = rows.flatMap((by) => [[4, "start"], [-4, "end"]].map(([side, anchor]) => ({ x: X(value) + side, y: TOP + by, "text-anchor": anchor })));
      putLabel(svg, {}, title, places, taken);
    }
  }

  function drawLine(inside, line, { X, Y }) {
    const parts = pieces(line.x, line.y);
    if (["measured", "dots"].includes(line.look)) {
      for (const [x, y] of parts.flat()) add(inside, "circle", { class: line.look, cx: X(x), cy: Y(y), r: line.look === "dots" ? 1 : 3.2 });
      return;
    }
    if (line.error) {
      const band = pieces(line.x, line.y.map((y, i) => line.error[i] === null ? null : y));
      const edges = band.map((part) => [...part.map(([x, y, i]) => [X(x), Y(y + 2 * line.error[i])]), ...part.reverse().map(([x, y, i]) => [X(x), Y(y - 2 * line.error[i])])]);
      add(inside, "path", { class: "band " + line.look, d: path(edges) });
    }
    add(inside, "path", { class: "curve-line " + line.look, d: path(parts.map((part) => part.map(([x, y]) => [X(x), Y(y)]))) });
  }

  function drawPanel(figure, chart, { panel, span, height, last }, left, name, width) {
    const values = legend(figure, panel), own = panel.x || last, below = own ? BELOW : GAP;
    const label = [panel.y, panel.x || chart.x].join(", ") + ": " + panel.lines.map((line) => line.label).join(", ");
    const svg = add(figure, "svg", { width, height: height + below, role: "img", "aria-label": label });
    const at = scales(span, left, width, height), { x0, x1, right, X, Y } = at;
    add(add(svg, "clipPath", { id: name }), "rect", { x: left, y: TOP, width: right - left, height: height - TOP });
    drawAxes(svg, chart, panel, at, own);
    const inside = add(svg, "g", { "clip-path": `url(#${name})` });
    for (const solid of panel.solids) add(inside, "polygon", { class: "wall", points: solid.map(([x, y]) => X(x) + "," + Y(y)).join(" ") });
    drawLevels(svg, inside, panel, at);
    for (const line of panel.lines) drawLine(inside, line, at);
    const now = add(svg, "line", { class: "now", y1: TOP, y2: height, visibility: "hidden" });
    const cursor = add(svg, "line", { class: "cursor", y1: TOP, y2: height, visibility: "hidden" });
    const put = (line, x) => {
      const seen = x !== null && x >= x0 && x <= x1;
      line.setAttribute("visibility", seen ? "visible" : "hidden");
      if (seen) { line.setAttribute("x1", X(x)); line.setAttribute("x2", X(x)); }
    };
    const place = (event) => x0 + (event.clientX - svg.getBoundingClientRect().left - left) / (right - left) * (x1 - x0);
    const tell = (x) => {
      put(cursor, x);
      panel.lines.forEach((line, i) => {
        if (!values[i]) return;
        const k = x === null ? -1 : nearest(line.x, x), inReach = k >= 0 && x >= Math.min(...line.x) - (x1 - x0) / 50 && x <= Math.max(...line.x) + (x1 - x0) / 50;
        const known = inReach && line.y[k] !== null;
        values[i].textContent = known ? text(line.y[k]) : "";
      });
    };
    return { svg, put: (x) => put(now, x), tell, place, own: panel.x, inside: (x) => Math.min(x1, Math.max(x0, x)) };
  }

  function drawBars(figure, chart, width) {
    const narrow = width < 480, rows = chart.bars.length, high = narrow ? 42 : 24, above = narrow ? 18 : 0, half = Math.max(...chart.bars.map(([, value]) => Math.abs(value)), 1e-12);
    const label = narrow ? 0 : Math.min(260, width / 2), middle = (label + width) / 2, unit = ((width - label) / 2 - 44) / half;
    const svg = add(figure, "svg", { width, height: rows * high + BELOW - 12, role: "img", "aria-label": chart.title });
    chart.bars.forEach(([name, value], i) => {
      const y = i * high + above, long = Math.abs(value) * unit, side = value < 0 ? -1 : 1;
      add(svg, "text", narrow ? { x: 0, y: y - 4 } : { x: label - 8, y: y + 16, "text-anchor": "end" }, name);
      add(svg, "rect", { class: i === rows - 1 ? "bar sum" : "bar", x: middle - (value < 0 ? long : 0), y: y + 4, width: long, height: 16 });
      add(svg, "text", { x: middle + side * (long + 5), y: y + 16, "text-anchor": value < 0 ? "end" : "start" }, (value < 0 ? "" : "+") + fixed(value, 1));
    });
    add(svg, "line", { class: "zero", x1: middle, x2: middle, y1: 0, y2: rows * high });
    add(svg, "text", { class: "name", x: width, y: rows * high + 18, "text-anchor": "end" }, chart.x);
  }

  function draw(body, chart, number, width) {
    body.replaceChildren();
    if (chart.title.toLowerCase() !== chart.caption.toLowerCase()) add(body, "p", { class: "small" }, chart.title);
    if (chart.bars) return drawBars(body, chart, width);
    const most = Math.max(...chart.panels.map((panel) => panel.height)), single = chart.panels.length === 1;
    const plots = chart.panels.map((panel, i) => ({
      panel, span: spans(chart, panel), last: i === chart.panels.length - 1,
      height: Math.max(100, (single ? 250 : 200) * panel.height / most),
    }));
    const left = Math.max(...plots.map(({ panel, span, height }) => leftOf(panel, span, height)));
    const panels = plots.map((plot, i) => drawPanel(body, chart, plot, left, `clip-${number}-${i}`, width));
    for (const panel of panels) {
      const same = panel.own ? [panel] : panels;
      panel.svg.addEventListener("pointermove", (event) => same.forEach((one) => one.tell(one.inside(panel.place(event)))));
      panel.svg.addEventListener("pointerleave", () => same.forEach((one) => one.tell(null)));
      if (chart.time) panel.svg.addEventListener("click", (event) => {
        document.dispatchEvent(new CustomEvent("seek", { detail: panel.inside(panel.place(event)) }));
      });
    }
    return panels;
  }

  const linked = [];
  let shownTime = null;

  function setUp(figure) {
    const number = figure.dataset.curve, caption = figure.querySelector("figcaption"), title = caption.textContent;
    let chart, width = 0, panels = [];
    const take = () => {
      chart = figure.chart || charts[number]; // the player has its own
      for (const panel of chart.panels || []) for (const line of panel.lines) line.x ??= panel.lines[0].x;
      chart.caption = figure.chart ? chart.caption : title;
      width = 0;
    };
    take();
    figure.classList.add("drawn");
    if (chart.time) figure.classList.add("timed");
    add(caption, "button", { type: "button" }, "CSV").addEventListener("click", () => save(chart.caption, columns(chart)));
    const body = add(figure, "div");
    const fit = () => {
      const now = Math.floor(figure.clientWidth);
      if (!now || now === width) return;
      width = now;
      panels = draw(body, chart, number, width) || [];
      if (chart.time && shownTime !== null) panels.forEach((panel) => panel.put(shownTime));
    };
    fit();
    new ResizeObserver(fit).observe(figure);
    if (chart.time) linked.push((seconds) => panels.forEach((panel) => panel.put(seconds)));
    figure.addEventListener("numbers", () => { take(); fit(); });
  }

  const figures = () => document.querySelectorAll("figure.curve");
  figures().forEach(setUp);
  document.addEventListener("time", ({ detail }) => {
    shownTime = detail;
    linked.forEach((show) => show(detail));
  });
  // A run that goes on has new numbers for its figures, and new figures; a player makes one on demand.
  document.addEventListener("curves", ({ detail }) => (detail ? [detail] : figures()).forEach((figure) => (
    figure.classList.contains("drawn") ? figure.dispatchEvent(new Event("numbers")) : setUp(figure))));
})();

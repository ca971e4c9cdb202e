"use strict";
// What the player shows and how it is drawn: one canvas with the discs, their axes and the depth below them.

const MARGIN = { left: 44, right: 2, legend: 30, caption: 50, depth: 104, axis: 24 };
const NARROW = 640;
const TALLEST = 460;
const LOWEST = 90;
// Height of the discs that a narrow screen zooms in for.
const SHOWN = 150;
const GROWN = 330;
const NARROWEST = 420;
// A disc is shown at most as large, in pixels.
const CLOSEST = 90;
// Pixels of the band behind an open line.
const BAND = 7;
const darkness = matchMedia("(prefers-color-scheme: dark)");
const COLOURS = {
  speed: { label: "speed", unit: "m/s", of: (p, k) => Math.hypot(p.found.u[k], p.found.v[k]) },
  size: { label: "diameter", unit: "m", of: (p, k) => 2 * radiusOf(p, k) / p.grown },
  pressure: { label: "pressure", unit: "Pa", root: true, of: (p, k) => mapValue(p, k) },
  packing: { label: "packing", unit: "" },
  age: { label: "time since it came in", of: (p, k) => p.time - p.run.times[p.run.first[p.found.disc[k]]] },
};

function part(p, name) {
  return p.element.querySelector("." + name);
}

// ---- what is shown: p.view has the centre (m), the scale (pixels a metre), and what sets both again for another size ----

function layOut(p) {
  const width = Math.max(240, p.element.clientWidth), [[x0, x1], [y0, y1]] = p.run.seen;
  const room = width - MARGIN.left - MARGIN.right, narrow = width < NARROW;
  p.whole = Math.min(room / (x1 - x0), TALLEST / (y1 - y0));
  const closer = Math.max(2 * p.whole, Math.min(4 * p.whole, SHOWN / (y1 - y0)));
  p.home = narrow ? Math.min(closer, TALLEST / (y1 - y0)) : p.whole;
  p.wide = Math.min(room, Math.max(NARROWEST, p.whole * (x1 - x0)));
  p.dots = Math.min(3, Math.max(1, window.devicePixelRatio || 1));
  p.sized = { width, height: 0 };
  takeColours(p);
  if (!p.view || p.view.again) (p.view ? p.view.again : showHome)(p);
  else moveView(p, 0, 0);
}

// A closer view of a long channel gets more height.
function fitHeight(p) {
  const [low, high] = p.run.seen[1], least = Math.max(LOWEST, p.home * (high - low));
  p.high = Math.round(Math.min(Math.max(least, p.view.scale * (high - low)), Math.max(least, GROWN)));
  const height = MARGIN.legend + p.high + (p.deep ? MARGIN.caption + MARGIN.depth : 0) + MARGIN.axis;
  if (height === p.sized.height) return;
  p.sized.height = height;
  p.canvas.width = Math.round(p.sized.width * p.dots);
  p.canvas.height = Math.round(height * p.dots);
  p.canvas.style.height = height + "px";
  p.painter = new Painter(Math.round(p.wide * p.dots), Math.round(p.high * p.dots));
}

function takeColours(p) {
  const style = getComputedStyle(document.documentElement);
  p.ink = {};
  for (const name of ["paper", "ink", "faint", "line", "solid", "edge", "main", "theory"]) {
    p.ink[name] = style.getPropertyValue("--" + name).trim();
  }
  p.colours = colourScale(darkness.matches);
  p.pixels = asPixels(p.colours);
}

// The whole flow; on a narrow screen the half around the front, which is followed.
function showHome(p) {
  const [[x0, x1], [y0, y1]] = p.run.seen;
  const x = p.home > p.whole ? frontPlace(p)[0] : (x0 + x1) / 2;
  p.view = { x, y: (y0 + y1) / 2, scale: p.home, again: showHome };
  moveView(p, 0, 0);
}

function follows(p) {
  return p.view.again === showHome && p.home > p.whole;
}

// Place of the front now, and mean height of the discs there. Bélanger's line begins at the front of a jump; where no
// jump is found, it is that of the nearest frame with one; without any, the front of the discs.
function frontPlace(p) {
  const { sequent, times, seen: [[x0, x1], [y0, y1]] } = p.run, now = frameBefore(times, p.time);
  discsAt(p.run, p.time, p.found);
  const { count, x, y } = p.found, lines = sequent.map((line, k) => [Math.abs(k - now), line]).filter(([, line]) => line);
  let front = (x0 + x1) / 2;
  if (lines.length) front = lines.reduce((a, b) => (b[0] < a[0] ? b : a))[1][0];
  else if (p.deep && count) front = Float64Array.from(x.subarray(0, count)).sort()[Math.floor(0.98 * (count - 1))];
  let sum = 0, near = 0;
  for (let k = 0; k < count; k++) if (Math.abs(x[k] - front) < 0.05 * (x1 - x0)) { sum += y[k]; near++; }
  return [Math.min(Math.max(front, x0), x1), near ? sum / near : (y0 + y1) / 2];
}

// The buttons and keys zoom on the front, until the view is moved by hand.
function zoomByKey(p, factor) {
  if (factor > 1 && !p.view.hand) [p.view.x, p.view.y] = frontPlace(p);
  zoom(p, factor);
}

function showWhole(p) {
  const [[x0, x1], [y0, y1]] = p.run.seen;
  p.view = { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale: p.whole, again: showWhole };
  moveView(p, 0, 0);
}

function zoom(p, factor, x = p.view.x, y = p.view.y) {
  const hand = p.view.hand || x !== p.view.x;
  const smallest = 2 * p.run.radii[0];
  const scale = Math.min(Math.max(p.view.scale * factor, p.whole), Math.max(p.whole, CLOSEST / smallest));
  const kept = p.view.scale / scale;
  p.view = { x: x + (p.view.x - x) * kept, y: y + (p.view.y - y) * kept, scale, hand };
  moveView(p, 0, 0);
}

// Move what is shown by pixels, within what there is.
function moveView(p, right, down) {
  const { view, run } = p;
  fitHeight(p);
  view.x = within(view.x - right / view.scale, run.seen[0], p.wide / view.scale / 2);
  view.y = within(view.y + down / view.scale, run.seen[1], p.high / view.scale / 2, true);
  if (right || down) Object.assign(view, { again: null, hand: true });
  paintBackground(p);
  draw(p);
}

// A centre so that half a window lies within two ends; where it does not fit, in the middle or on the lower end.
function within(value, [low, high], half, onLower = false) {
  if (low + half >= high - half) return onLower ? low + half : (low + high) / 2;
  return Math.min(Math.max(value, low + half), high - half);
}

function column(p, x) {
  return (x - p.view.x) * p.view.scale + p.wide / 2;
}

function row(p, y) {
  return (p.view.y - y) * p.view.scale + p.high / 2;
}

// ---- drawing ----

// Value of the map where a disc is.
function mapValue(p, k) {
  return valueAt(p.run.map, p.values, p.found.x[k], p.found.y[k]);
}

// Paper and walls as pixels: each picture starts from them.
function paintBackground(p) {
  const canvas = document.createElement("canvas");
  canvas.width = p.painter.image.width;
  canvas.height = p.painter.image.height;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.scale(p.dots, p.dots);
  context.fillStyle = p.ink.paper;
  context.fillRect(0, 0, p.wide, p.high);
  const solid = new Path2D();
  const fixed = p.run.walls.filter((wall) => !wall.about);
  for (const wall of fixed) solid.addPath(wallPath(p, wall));
  context.strokeStyle = p.ink.edge; // the solids cover the lines between them
  context.lineWidth = 2;
  context.stroke(solid);
  context.fillStyle = p.ink.solid;
  for (const wall of fixed) context.fill(wallPath(p, wall), "evenodd");
  for (const wall of fixed) drawLines(p, wall, context);
  p.background = new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
}

// Points of a wall where they are now.
function placed(p, wall, points) {
  if (!wall.about) return points;
  const [ox, oy] = wall.about, [dx, dy, angle] = ["x", "y", "angle"].map((way) => alongWay(p, wall[way]));
  const c = Math.cos(angle), s = Math.sin(angle);
  return points.map(([x, y]) => [ox + dx + c * (x - ox) - s * (y - oy), oy + dy + s * (x - ox) + c * (y - oy)]);
}

// A number that is given at each frame, now: cubic between frames, with mean slopes.
function alongWay(p, way) {
  const { times } = p.run, k = frameBefore(times, p.time), long = times[k + 1] - times[k];
  if (!(long > 0) || p.time <= times[k]) return way[k];
  const slope = (i) => {
    const a = Math.max(i - 1, 0), b = Math.min(i + 1, times.length - 1);
    return (way[b] - way[a]) / (times[b] - times[a]) * long;
  };
  const s = (p.time - times[k]) / long, before = slope(k), after = slope(k + 1), rise = way[k + 1] - way[k];
  return way[k] + s * (before + s * (3 * rise - 2 * before - after + s * (before + after - 2 * rise)));
}

// Add lines through points to a path.
function trace(p, path, points) {
  points.forEach(([x, y], k) => (k ? path.lineTo(column(p, x), row(p, y)) : path.moveTo(column(p, x), row(p, y))));
}

// The solid of a wall, by the even-odd rule; of a hollow one, all that is outside it.
function wallPath(p, wall) {
  const path = new Path2D();
  for (const points of wall.outlines) {
    trace(p, path, placed(p, wall, points));
    path.closePath();
  }
  if (wall.hollow) path.rect(-10, p.high + 10, p.wide + 20, -p.high - 20);
  return path;
}

// Open lines, with a band on the side without discs.
function drawLines(p, wall, context) {
  for (const given of wall.lines) {
    const points = placed(p, wall, given), band = new Path2D(), line = new Path2D();
    for (let k = 1; k < points.length; k++) {
      const [[x0, y0], [x1, y1]] = [points[k - 1], points[k]];
      const aside = BAND / 2 / p.view.scale / (Math.hypot(x1 - x0, y1 - y0) || 1), dx = (y1 - y0) * aside, dy = (x0 - x1) * aside;
      for (const [x, y] of [[x0, y0], [x1, y1]]) band.lineTo(column(p, x + dx), row(p, y + dy));
    }
    trace(p, line, points);
    Object.assign(context, { lineJoin: "round", lineWidth: BAND, strokeStyle: p.ink.solid });
    context.stroke(band);
    Object.assign(context, { lineWidth: 2, strokeStyle: p.ink.edge });
    context.stroke(line);
  }
}

function draw(p) {
  discsAt(p.run, p.time, p.found);
  if (p.run.map && (p.colour === p.run.map.name || p.picked !== null)) p.values = mapAt(p.run, p.time);
  const { context } = p;
  context.setTransform(p.dots, 0, 0, p.dots, 0, 0);
  context.fillStyle = p.ink.paper;
  context.fillRect(0, 0, p.sized.width, p.sized.height);
  drawDiscs(p);
  drawLegend(p);
  drawHeights(p);
  if (p.deep) drawDepth(p);
  drawDistances(p, p.sized.height - MARGIN.axis);
  showClock(p);
  showPicked(p);
}

// Radius of a disc as it is drawn, m.
function radiusOf(p, k) {
  return p.grown * p.run.radii[p.run.shade[p.found.disc[k]]];
}

// Lower and upper end of the colours.
function colourRange(p) {
  const { radii } = p.run;
  if (p.colour === "size") return [2 * radii[0], 2 * radii[radii.length - 1]];
  if (p.colour === "pressure" || p.colour === "packing") return [0, p.run.map.top];
  return p.colour === "age" ? [0, p.oldest] : [0, p.run.fastest];
}

// Longest stay of a disc that came in, s.
function oldest(run) {
  const { times, first, life } = run;
  let most = 0;
  for (let k = 0; k < run.discs; k++) {
    if (first[k]) most = Math.max(most, times[first[k] + life[k] - 1] - times[first[k]]);
  }
  return most;
}

function shadeOf(value, low, high, root) {
  const share = (value - low) / (high - low || 1);
  return Math.min(SHADES - 1, Math.max(0, Math.floor((root ? Math.sqrt(share) : share) * SHADES)));
}

// The map as a picture, in place of discs.
function drawMap(p, high) {
  const { counts: [columns, rows], low, sides: [wide, tall] } = p.run.map, { scale } = p.view, canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  const painter = new Painter(columns, rows), top = low[1] + rows * tall;
  p.values.forEach((value, k) => {
    const pixel = (rows - 1 - Math.floor(k / columns)) * columns + k % columns;
    if (value) painter.pixels[pixel] = p.pixels[shadeOf(value, 0, high)];
  });
  canvas.getContext("2d").putImageData(painter.image, 0, 0);
  p.context.drawImage(canvas, column(p, low[0]), row(p, top), columns * wide * scale, rows * tall * scale);
  p.context.fillStyle = p.ink.solid;
  for (const wall of p.run.walls) p.context.fill(wallPath(p, wall), "evenodd");
}

function drawDiscs(p) {
  const { painter, found, dots } = p, [low, high] = colourRange(p), large = [], { of, root } = COLOURS[p.colour];
  painter.pixels.set(p.background);
  for (let k = 0; of && k < found.count; k++) {
    const radius = radiusOf(p, k) * p.view.scale, x = column(p, found.x[k]), y = row(p, found.y[k]);
    if (x < -radius || y < -radius || x > p.wide + radius || y > p.high + radius) continue;
    const shade = shadeOf(of(p, k), low, high, root);
    if (radius * dots > LARGEST_STAMP) large.push([x, y, radius, shade]);
    else painter.paint(x * dots, y * dots, radius * dots, p.pixels[shade]);
  }
  p.context.putImageData(painter.image, Math.round(MARGIN.left * dots), Math.round(MARGIN.legend * dots));
  inDiscs(p, () => {
    if (!of) drawMap(p, high);
    for (const wall of p.run.walls) if (wall.about) drawMoving(p, wall);
    for (const gate of p.run.gates) if (p.time < gate.until) drawGate(p, gate);
    for (const disc of large) drawLarge(p, ...disc);
    if (p.picked !== null && p.picked.outlines) drawPickedWall(p, p.picked);
    else if (p.picked !== null) drawRing(p);
  });
}

// Draw within the frame of the discs.
function inDiscs(p, drawing) {
  const { context } = p;
  context.save();
  context.translate(MARGIN.left, MARGIN.legend);
  context.beginPath();
  context.rect(0, 0, p.wide, p.high);
  context.clip();
  drawing();
  context.restore();
}

function drawMoving(p, wall) {
  const path = wallPath(p, wall);
  Object.assign(p.context, { fillStyle: p.ink.solid, strokeStyle: p.ink.edge, lineWidth: 2 });
  p.context.stroke(path);
  p.context.fill(path, "evenodd");
  drawLines(p, wall, p.context);
}

function drawGate(p, gate) {
  const path = wallPath(p, gate);
  p.context.fillStyle = p.context.strokeStyle = p.ink.edge;
  p.context.lineWidth = 3;
  p.context.fill(path, "evenodd");
  p.context.stroke(path);
  drawLines(p, gate, p.context);
}

function drawLarge(p, x, y, radius, shade) {
  p.context.fillStyle = `rgb(${p.colours[shade]})`;
  p.context.beginPath();
  p.context.arc(x, y, radius - 0.6, 0, 2 * Math.PI);
  p.context.fill();
}

// The outline of a wall that is picked, and the force of the discs on it now as an arrow: the largest is a third of the
// height of the drawing.
function drawPickedWall(p, wall) {
  Object.assign(p.context, { strokeStyle: p.ink.theory, fillStyle: p.ink.theory, lineWidth: 2, lineJoin: "round" });
  const line = new Path2D(), force = wall.outlines ? forceNow(p, wall) : null;
  for (const points of wall.lines) trace(p, line, placed(p, wall, points));
  p.context.stroke(wallPath(p, wall));
  p.context.stroke(line);
  if (!force || !Math.hypot(...force)) return;
  wall.most ??= wall.force.time.reduce((most, _, k) => Math.max(most, Math.hypot(wall.force.fx[k], wall.force.fy[k])), 0);
  const [x, y] = middleOf(p, wall), at = [column(p, x), row(p, y)], scale = p.high / 3 / wall.most;
  drawArrow(p, at, [at[0] + force[0] * scale, at[1] - force[1] * scale]);
}

function drawArrow({ context }, [x0, y0], [x1, y1]) {
  const long = Math.hypot(x1 - x0, y1 - y0), head = Math.min(10, long / 2), c = (x1 - x0) / long, s = (y1 - y0) / long;
  context.lineWidth = 3;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1 - c * head, y1 - s * head);
  context.stroke();
  context.beginPath();
  context.moveTo(x1, y1);
  for (const side of [-0.6, 0.6]) context.lineTo(x1 - head * (c + side * s), y1 - head * (s - side * c));
  context.fill();
}

function drawRing(p) {
  const k = p.found.disc.subarray(0, p.found.count).indexOf(p.picked);
  if (k < 0) return;
  p.context.strokeStyle = p.ink.theory;
  p.context.lineWidth = 2;
  p.context.beginPath();
  p.context.arc(column(p, p.found.x[k]), row(p, p.found.y[k]), radiusOf(p, k) * p.view.scale + 2, 0, 2 * Math.PI);
  p.context.stroke();
}

const TEXT = 12.5;  // pixels

function textWidth(p, text, size = TEXT) {
  p.context.font = `${size}px system-ui, sans-serif`;
  return p.context.measureText(text).width;
}

function write(p, text, x, y, { colour = p.ink.ink, align = "left", size = TEXT } = {}) {
  const wide = textWidth(p, text, size);
  p.context.fillStyle = colour;
  p.context.textAlign = align;
  p.context.textBaseline = "middle";
  p.context.fillText(text, x, y);
  return wide;
}

// Colours on the left, scale bar on the right.
function drawLegend(p) {
  const { context } = p, wide = Math.min(150, p.wide / 4), [low, high] = colourRange(p);
  for (let k = 0; k < wide; k++) {
    context.fillStyle = `rgb(${p.colours[Math.floor(k / wide * SHADES)]})`;
    context.fillRect(MARGIN.left + k, 4, 1.5, 9);
  }
  const { label, unit = p.run.unit, root } = COLOURS[p.colour];
  const how = root && p.wide > NARROW - 100 ? ", colours by its root" : "";
  write(p, `${label} ${short(low)} to ${short(high)} ${unit}${how}`, MARGIN.left + wide + 8, 9);
  drawScaleBar(p);
}

function drawScaleBar(p) {
  const metres = niceStep(p.wide / p.view.scale / 8), long = metres * p.view.scale;
  const right = MARGIN.left + p.wide - 0.5, { context } = p;
  context.strokeStyle = p.ink.ink;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(right - long, 5);
  context.lineTo(right - long, 12);
  context.lineTo(right, 12);
  context.lineTo(right, 5);
  context.stroke();
  write(p, `${short(metres)} m`, right - long - 6, 9, { align: "right" });
}

// Heights in metres left of the discs.
function drawHeights(p) {
  const low = p.view.y - p.high / p.view.scale / 2, high = p.view.y + p.high / p.view.scale / 2;
  for (const y of ticks(low, high, p.high / 42)) {
    const at = MARGIN.legend + row(p, y);
    tickMark(p, MARGIN.left - 4, at, MARGIN.left, at);
    write(p, short(y), MARGIN.left - 8, at, { align: "right", colour: p.ink.faint });
  }
}

function tickMark(p, ...[x0, y0, x1, y1]) {
  const { context } = p;
  context.strokeStyle = p.ink.faint;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

// Depth of this instant over the same distance as the discs, and Bélanger's.
function drawDepth(p) {
  const bottom = p.sized.height - MARGIN.axis, most = (p.run.seen[1][1] - p.run.bed) || 1, line = sequentNow(p);
  const height = (depth) => bottom - depth / most * MARGIN.depth;
  const wide = write(p, "Depth by mass at this instant [m]", MARGIN.left, bottom - MARGIN.depth - 28);
  if (line && p.wide > NARROW - 100) {
    const text = "dashed: Bélanger, from depth and velocity before the front at this instant";
    write(p, text, MARGIN.left + wide + 12, bottom - MARGIN.depth - 28, { colour: p.ink.faint });
  }
  for (const depth of ticks(0, most, 4)) {
    drawLine(p, [[MARGIN.left, height(depth)], [MARGIN.left + p.wide, height(depth)]], depth ? p.ink.line : p.ink.edge, 1);
    write(p, short(depth), MARGIN.left - 8, height(depth), { align: "right", colour: p.ink.faint });
  }
  inPlot(p, bottom, () => {
    drawBlocks(p, height);
    drawProfile(p, height);
    if (line) drawSequent(p, line, height);
  });
}

function drawLine(p, points, colour, width, dash = []) {
  const { context } = p;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineJoin = "round";
  context.setLineDash(dash);
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

function inPlot(p, bottom, drawing) {
  const { context } = p;
  context.save();
  context.beginPath();
  context.rect(MARGIN.left, bottom - MARGIN.depth - 18, p.wide, MARGIN.depth + 18);
  context.clip();
  drawing();
  context.restore();
}

// Walls that rise from the bed, to find the place of a sill again.
function drawBlocks(p, height) {
  p.context.fillStyle = p.ink.solid;
  for (const wall of p.run.walls) {
    if (wall.hollow) continue;
    p.context.beginPath();
    for (const part of [...wall.outlines, ...wall.lines.map(downToBed(p))]) {
      placed(p, wall, part).forEach(([x, y], k) => {
        const at = [MARGIN.left + column(p, x), height(Math.max(0, y - p.run.bed))];
        if (k) p.context.lineTo(...at);
        else p.context.moveTo(...at);
      });
    }
    p.context.fill("evenodd");
  }
}

// The polygon between an open line and the bed.
function downToBed(p) {
  return (points) => [[points[0][0], p.run.bed], ...points, [points[points.length - 1][0], p.run.bed]];
}

function drawProfile(p, height) {
  massDepth(p.run, p.found, p.depth);
  const { low, width } = p.run.bins;
  const points = Array.from(p.depth, (depth, k) => [MARGIN.left + column(p, low + (k + 0.5) * width), height(depth)]);
  drawLine(p, points, p.ink.main, 2);
}

// Bélanger's line of the last frame: from (m), to (m), depth (m); null where there is no jump.
function sequentNow(p) {
  return p.run.sequent[frameBefore(p.run.times, p.time)];
}

function drawSequent(p, [from, to, depth], height) {
  const x0 = MARGIN.left + column(p, from), x1 = MARGIN.left + column(p, to), y = height(depth);
  drawLine(p, [[x0, y], [x1, y]], p.ink.theory, 1.5, [5, 4]);
  const left = Math.min(x0, x1), right = Math.min(Math.max(x0, x1), MARGIN.left + p.wide);
  // before the front, where the stream is low; above the line where there is no room; short where the page is narrow
  const number = `${depth.toFixed(2)} m`, end = MARGIN.left + p.wide;
  const label = [`Bélanger at this instant ${number}`, `Bélanger ${number}`].find((one) => textWidth(p, one) < 0.6 * p.wide) || number;
  const wide = textWidth(p, label), before = left - 8 - wide > MARGIN.left;
  const x = before ? left - 8 : Math.min(Math.max(right, MARGIN.left + wide + 4), end);
  write(p, label, x, y - (before ? 0 : 10), { align: "right", colour: p.ink.theory });
}

// From the right, so that the unit has its room: a label stays within the picture, and one without room is left out.
function drawDistances(p, bottom) {
  const half = p.wide / p.view.scale / 2, end = MARGIN.left + p.wide;
  let room = Infinity;
  ticks(p.view.x - half, p.view.x + half, p.wide / 70).reverse().forEach((x, k) => {
    const at = MARGIN.left + column(p, x), label = short(x) + (k ? "" : " m"), wide = textWidth(p, label);
    const right = Math.min(at + wide / 2, end);
    tickMark(p, at, bottom, at, bottom + 4);
    if (right > room) return;
    write(p, label, right, bottom + 14, { align: "right", colour: p.ink.faint });
    room = right - wide - 6;
  });
}

// ---- numbers ----

// 1, 2 or 5 times a power of ten: the largest that is not above a value.
function niceStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((k) => k * power <= value * (1 + 1e-9)) * power;
}

// About so many round numbers between two.
function ticks(low, high, count) {
  const step = niceStep((high - low) / Math.max(1, count) * 1.6), first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.max(0, Math.floor(high / step + 1e-9) - first + 1) }, (_, k) => (first + k) * step);
}

// A number in at most three digits, with a true minus sign.
function short(value) {
  return String(Number(value.toPrecision(3))).replace("-", "\u2212");
}

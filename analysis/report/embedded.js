"use strict";
// A page in the frame of a notebook: it sends what holds the frame its time and height, and goes to a requested time.

document.addEventListener("time", ({ detail }) => parent.postMessage({ time: detail }, "*"));
addEventListener("message", ({ source, data }) => {
  if (source === parent && data && Number.isFinite(data.seek)) tell("seek", data.seek);
});
new ResizeObserver(() => parent.postMessage({ height: document.documentElement.offsetHeight }, "*")).observe(document.body);

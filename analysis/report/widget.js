// The player in a cell of a notebook: its page in a frame without rights of the notebook. The page tells its time and its height.

const EVERY = 100; // milliseconds between two times sent to Python

function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.title = model.get("title");
  frame.setAttribute("sandbox", "allow-scripts allow-downloads");
  Object.assign(frame.style, { width: "100%", height: "480px", border: "0", display: "block" });
  let last = 0, waiting = null;

  function tellTime() {
    [last, waiting] = [Date.now(), null];
    model.save_changes();
  }

  function hear(event) {
    if (event.source !== frame.contentWindow) return;
    const { height, time } = event.data;
    if (Number.isFinite(height)) frame.style.height = `${Math.ceil(height)}px`;
    if (!Number.isFinite(time)) return;
    model.set("time", time);
    waiting ??= setTimeout(tellTime, Math.max(0, last + EVERY - Date.now()));
  }

  const seek = (message) => frame.contentWindow.postMessage(message, "*");
  addEventListener("message", hear);
  model.on("msg:custom", seek);
  frame.srcdoc = model.get("page");
  el.append(frame);
  return () => {
    removeEventListener("message", hear);
    model.off("msg:custom", seek);
    clearTimeout(waiting);
  };
}

export default { render };

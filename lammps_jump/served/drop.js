"use strict";
// A drawing that is dropped on the page of a case, or chosen by its button: its walls come into the text, as one change.

let dropped = null;

function base64(blob) {
  return new Promise((done, fail) => {
    const reader = new FileReader();
    reader.addEventListener("load", () => done(reader.result.slice(reader.result.indexOf(",") + 1)));
    reader.addEventListener("error", () => fail(reader.error));
    reader.readAsDataURL(blob);
  });
}

function tellImport(wrong, ...parts) {
  byId("imported").className = wrong ? "wrong" : "";
  byId("imported").replaceChildren(...parts);
  byId("imported").scrollIntoView({ block: "nearest" });
}

// The drawing of a file, with what stands in the field of the scale.
async function importDrawing(scale) {
  byId("scale-act").hidden = true;
  if (dropped.size > file.largest) {
    tellImport(true, `${dropped.name}: has ${(dropped.size / 1e6).toFixed(1)} MB; the page takes up to ${file.largest / 1e6} MB, ` +
      "and lammps-jump import more");
    return;
  }
  let coded, text, reply;
  try {
    coded = await base64(dropped);
  } catch {
    tellImport(true, `${dropped.name}: cannot be read`);
    return;
  }
  do {
    text = editor.text;
    reply = await ask("drawing", { text, name: dropped.name, data: coded, scale });
  } while (editor.text !== text); // typed meanwhile
  const { ok, data } = reply;
  if (!ok) {
    tellImport(true, data.refused);
    byId("scale-act").hidden = !data.scale;
    if (data.scale) byId("scale").focus();
    return;
  }
  editor.release();
  editor.replace(data.text);
  editor.release();
  const list = made("ul", {}, ...[...data.added, ...data.notes.map((one) => `Note: ${one}`)].map((one) => made("li", {}, one)));
  tellImport(false, `Walls of ${dropped.name}; Undo takes them away. The same: `, made("code", {}, data.command), list);
}

function take(files) {
  if (files.length > 1) {
    tellImport(true, `${files.length} files: one drawing at a time`);
  } else if (files.length) {
    [dropped] = files;
    importDrawing("");
  }
}

document.addEventListener("dragover", (event) => {
  if (!event.dataTransfer.types.includes("Files")) return;
  event.preventDefault();
  event.dataTransfer.dropEffect = "copy";
});
document.addEventListener("drop", (event) => {
  if (!event.dataTransfer.types.includes("Files")) return;
  event.preventDefault();
  take(event.dataTransfer.files);
});
byId("import").addEventListener("click", () => byId("drawn-file").click());
byId("drawn-file").addEventListener("change", ({ target }) => {
  take([...target.files]);
  target.value = ""; // the same file may come again
});
byId("scale-go").addEventListener("click", () => importDrawing(byId("scale").value));
byId("scale").addEventListener("keydown", (event) => event.key === "Enter" && importDrawing(byId("scale").value));

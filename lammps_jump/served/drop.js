"use strict";
// A drawing that is dropped on the page of a case, or chosen by its button: its walls come into the text, as one change.

let dropped = null, taken = null;

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

// The drawing of a file, with the content of the field of the scale.
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
  taken = { name: dropped.name, text: editor.text, note: made("span"), there: true };
  tellImport(false, taken.note, "The same: ", made("code", {}, data.command), list);
  followUndo();
}

// What Undo and Redo do to the walls that came last; they may be in the text, or be taken away again.
function followUndo() {
  if (!taken) return;
  const redo = editor.future.includes(taken.text);
  if (editor.text === taken.text || editor.past.includes(taken.text)) taken.there = true;
  else if (redo || !editor.past.length) taken.there = false;
  const away = `The walls of ${taken.name} are taken away again${redo ? "; Redo brings them back" : ""}. `;
  const words = taken.there ? `Walls of ${taken.name}; Undo takes them away. ` : away;
  if (taken.note.textContent !== words) taken.note.textContent = words;
}

document.addEventListener("text", followUndo);

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

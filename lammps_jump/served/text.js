"use strict";
// The text of the case: a plain field, which every screen reader knows, with numbers of lines and the mark of an error.

class Editor {
  constructor() {
    this.field = byId("text");
    this.past = [];
    this.future = [];
    this.error = null;
    this.field.addEventListener("input", () => this.changed());
    this.field.addEventListener("scroll", () => this.follow());
    this.field.addEventListener("keydown", (event) => this.key(event));
    byId("undo").addEventListener("click", () => this.back());
    byId("redo").addEventListener("click", () => this.forth());
    new ResizeObserver(() => this.follow()).observe(this.field);
  }

  get text() {
    return this.field.value;
  }

  // Begin with a text; what was before is gone.
  begin(text) {
    this.past = [];
    this.future = [];
    this.show(text);
  }

  // Another text in the place of this one, which undo brings back.
  replace(text) {
    if (text === this.text) return;
    this.remember();
    this.show(text);
    this.tell();
  }

  show(text) {
    const { selectionStart, selectionEnd, scrollTop, scrollLeft } = this.field;
    this.before = this.field.value = text;
    this.field.setSelectionRange(selectionStart, selectionEnd);
    Object.assign(this.field, { scrollTop, scrollLeft });
    this.number();
  }

  // Keep the text before a change; letters that follow each other closely are one change.
  remember() {
    const now = performance.now();
    if (!this.past.length || this.past[this.past.length - 1] !== this.before) {
      if (!(now - this.typed < 600)) this.past.push(this.before);
    }
    this.typed = now;
    this.future = [];
    if (this.past.length > 500) this.past.shift();
  }

  // Hold all that comes until `release` as one change.
  hold() {
    this.typed = -Infinity;
    this.remember();
    this.typed = Infinity;
  }

  release() {
    this.typed = -Infinity;
  }

  changed() {
    this.remember();
    this.before = this.text;
    this.number();
    this.tell();
  }

  tell() {
    byId("undo").disabled = !this.past.length;
    byId("redo").disabled = !this.future.length;
    tellAll("text", this.text);
  }

  back() {
    if (!this.past.length) return;
    this.future.push(this.text);
    this.show(this.past.pop());
    this.release();
    this.tell();
  }

  forth() {
    if (!this.future.length) return;
    this.past.push(this.text);
    this.show(this.future.pop());
    this.release();
    this.tell();
  }

  key(event) {
    const name = event.key.toLowerCase(), command = (event.ctrlKey || event.metaKey) && !event.altKey;
    if (command && name === "z") event.preventDefault(), event.shiftKey ? this.forth() : this.back();
    else if (command && name === "y") event.preventDefault(), this.forth();
    else if (name === "enter" && !command && !event.isComposing) event.preventDefault(), this.newLine();
  }

  // A new line begins below the words of this one.
  newLine() {
    const { selectionStart, selectionEnd } = this.field, before = this.text.slice(0, selectionStart);
    const [indent] = /^[ ]*(?:- )?/.exec(before.slice(before.lastIndexOf("\n") + 1));
    this.field.setRangeText("\n" + " ".repeat(indent.length), selectionStart, selectionEnd, "end");
    this.changed();
  }

  // Numbers of lines, the one with an error marked.
  number() {
    const count = this.text.split("\n").length, gutter = byId("gutter");
    while (gutter.childElementCount > count) gutter.lastChild.remove();
    while (gutter.childElementCount < count) gutter.append(made("div", {}, String(gutter.childElementCount + 1)));
    this.mark(this.error);
  }

  mark(line) {
    this.error = line;
    const gutter = byId("gutter");
    gutter.querySelectorAll(".wrong").forEach((one) => one.classList.remove("wrong"));
    if (line) gutter.children[line - 1]?.classList.add("wrong");
    this.field.setAttribute("aria-invalid", String(line !== null));
    this.follow();
  }

  get height() {
    return parseFloat(getComputedStyle(this.field).lineHeight);
  }

  // Numbers and mark go where the text goes.
  follow() {
    byId("gutter").style.transform = `translateY(${-this.field.scrollTop}px)`;
    const strip = byId("strip");
    strip.hidden = !this.error;
    if (this.error) strip.style.transform = `translateY(${(this.error - 1) * this.height - this.field.scrollTop}px)`;
  }

  goTo(line) {
    const lines = this.text.split("\n"), start = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
    this.field.focus();
    this.field.setSelectionRange(start, start + (lines[line - 1] || "").length);
    this.field.scrollTop = Math.max(0, (line - 4) * this.height);
  }
}

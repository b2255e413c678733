"use strict";
// A table that is sorted by any column and filtered by text. `place`, `filter` and `shown` are ids of elements; `columns`
// have a name, a `key` to sort by and where it is not what is shown a `text`, or a `draw` that makes a node; `isNumber`
// stands right; `kind` is the cell's class, `title` says more. `keeps` may leave rows out, `text` is what is searched,
// `choose` is what a click or Enter does.
concord.Table = class {
  constructor(options) {
    Object.assign(this, { keeps: () => true, choose: null, noun: "rows" }, options);
    this.table = document.getElementById(this.place);
    this.body = this.table.querySelector("tbody");
    this.head = this.table.querySelector("thead tr");
    this.filterBox = document.getElementById(this.filter);
    this.shownBox = document.getElementById(this.shown);
    this.sorted = { column: -1, descending: false };
    this.rows = [];
    this.lines = new Map();
    if (this.filterBox) this.filterBox.addEventListener("input", () => this.show());
    this.columns.forEach(({ name, isNumber }, k) => {
      const button = concord.element("button", { type: "button", text: name });
      button.addEventListener("click", () => this.sort(k));
      this.head.append(concord.element("th", { class: isNumber ? "number" : "", scope: "col" }, button));
    });
  }

  load(rows) {
    this.rows = rows;
    this.show();
  }

  sort(column) {
    this.sorted = { column, descending: this.sorted.column === column ? !this.sorted.descending : false };
    [...this.head.children].forEach((cell, k) => {
      if (k === column) cell.setAttribute("aria-sort", this.sorted.descending ? "descending" : "ascending");
      else cell.removeAttribute("aria-sort");
    });
    this.show();
  }

  ordered() {
    const wanted = this.filterBox ? this.filterBox.value.toLowerCase().split(/\s+/).filter(Boolean) : [];
    const rows = this.rows.filter((r) => {
      if (!this.keeps(r)) return false;
      const text = wanted.length ? this.text(r).toLowerCase() : "";
      return wanted.every((word) => text.includes(word));
    });
    if (this.sorted.column < 0) return rows;
    const key = this.columns[this.sorted.column].key;
    const sign = this.sorted.descending ? -1 : 1;
    return rows.sort((one, other) => {
      const [a, b] = [key(one), key(other)];
      if (a === null || b === null) return (a === null) - (b === null);
      return sign * (typeof a === "number" ? a - b : String(a).localeCompare(String(b)));
    });
  }

  cellOf(r, { key, text, draw, isNumber, kind, title }) {
    const cell = concord.element("td", { class: (kind ? kind(r) : "") + (isNumber ? " number" : "") });
    if (draw) cell.append(draw(r));
    else cell.textContent = text ? text(r) : key(r);
    const more = title ? title(r) : "";
    if (more) cell.title = more;
    return cell;
  }

  lineOf(r) {
    const line = concord.element("tr", {}, ...this.columns.map((column) => this.cellOf(r, column)));
    this.lines.set(r, line);
    if (!this.choose) return line;
    line.tabIndex = 0;
    line.addEventListener("click", () => this.choose(r));
    line.addEventListener("keydown", (event) => {
      const next = { ArrowDown: line.nextSibling, ArrowUp: line.previousSibling }[event.key];
      if (event.key === "Enter") this.choose(r);
      if (!next) return;
      event.preventDefault();
      next.focus();
    });
    return line;
  }

  show() {
    const rows = this.ordered();
    this.lines.clear();
    this.body.replaceChildren(...rows.map((r) => this.lineOf(r)));
    this.mark(this.marked);
    if (this.shownBox) this.shownBox.textContent = `${rows.length} of ${this.rows.length} ${this.noun}`;
  }

  /** Marks the line of a row, if it is shown. */
  mark(r) {
    for (const line of this.lines.values()) line.removeAttribute("aria-current");
    this.marked = r;
    if (this.lines.has(r)) this.lines.get(r).setAttribute("aria-current", "true");
  }
};

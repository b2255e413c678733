"use strict";
// The table of components: sorted by any column, filtered by text and by verdict.
concord.Table = class {
  constructor(choose) {
    this.choose = choose;
    this.head = document.querySelector("#table thead tr");
    this.body = document.querySelector("#table tbody");
    this.filter = document.getElementById("filter");
    this.onlyRed = document.getElementById("only-red");
    this.sorted = { column: -1, descending: false };
    this.columns = [
      ["of", (r) => r.of], ["on", (r) => r.on], ["component", (r) => r.component],
      ["scale", (r) => r.row.scale, (r) => concord.short(r.row.scale) + " " + r.row.unit, true],
      ["from", (r) => r.row.scale_from],
      ["same state", (r) => r.row.digits[0], (r) => concord.digits(r.row.digits[0]), true],
      ["resolvable", (r) => r.row.resolvable[0], (r) => concord.digits(r.row.resolvable[0]), true],
      ["same run", (r) => r.row.digits[1], (r) => concord.digits(r.row.digits[1]), true],
      ["refined", (r) => r.row.digits[2], (r) => concord.digits(r.row.digits[2]), true],
      ["need", (r) => r.row.need[0], (r) => r.row.need.join(" / "), true],
      ["unique in", (r) => r.unique, (r) => r.uniqueText, true],
      ["verdict", (r) => r.row.verdict],
    ];
    this.filter.addEventListener("input", () => this.show());
    this.onlyRed.addEventListener("change", () => this.show());
    this.columns.forEach(([name, , , isNumber], k) => {
      const button = concord.element("button", { type: "button", text: name });
      button.addEventListener("click", () => this.sort(k));
      this.head.append(concord.element("th", { class: isNumber ? "number" : "", scope: "col" }, button));
    });
  }

  load(machine) {
    this.rows = machine.rows.map((row) => {
      const owner = concord.ownerOf(machine.machine, row);
      const all = row.states.judged + row.states.not_unique;
      return {
        row, of: (row.kind === "element" ? "" : "joint ") + owner.name, on: concord.bodyOf(machine.machine, owner, row.side),
        component: concord.components[row.component], unique: all > 0 ? row.states.judged / all : 0,
        uniqueText: all > 0 ? `${row.states.judged} of ${all}` : "-",
      };
    });
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
    const wanted = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    const rows = this.rows.filter((r) => {
      if (this.onlyRed.checked && r.row.verdict !== "differ") return false;
      const text = `${r.of} ${r.on} ${r.component} ${r.row.verdict}`.toLowerCase();
      return wanted.every((word) => text.includes(word));
    });
    if (this.sorted.column < 0) return rows;
    const key = this.columns[this.sorted.column][1];
    const sign = this.sorted.descending ? -1 : 1;
    return rows.sort((one, other) => {
      const [a, b] = [key(one), key(other)];
      if (a === null || b === null) return (a === null) - (b === null);
      return sign * (typeof a === "number" ? a - b : String(a).localeCompare(String(b)));
    });
  }

  show() {
    const rows = this.ordered();
    this.body.replaceChildren(...rows.map((r) => {
      const line = concord.element("tr", { tabindex: "0" });
      for (const [name, key, text, isNumber] of this.columns) {
        const kind = name === "verdict" ? (r.row.verdict === "not judged" ? "open" : r.row.verdict) : isNumber ? "number" : "";
        line.append(concord.element("td", { class: kind, text: text ? text(r) : key(r) }));
      }
      if (r.row.because) line.lastChild.title = "need lowered: " + r.row.because;
      const take = () => this.choose(r.row.kind, r.row.owner, r.row.side);
      line.addEventListener("click", take);
      line.addEventListener("keydown", (event) => { if (event.key === "Enter") take(); });
      return line;
    }));
    document.getElementById("shown").textContent = `${rows.length} of ${this.rows.length} components`;
  }
};

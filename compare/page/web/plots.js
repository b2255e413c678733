"use strict";
// Six components of one wrench by both solvers, and below each the difference on a logarithmic scale.
concord.Plots = class {
  constructor(hover) {
    this.hover = hover;
    this.charts = document.getElementById("charts");
    this.made = [];
    this.width = 0;
    new ResizeObserver(() => {
      if (Math.abs(this.charts.clientWidth - this.width) > 8) this.draw();
    }).observe(this.charts);
  }

  load(machine) {
    this.machine = machine;
    this.runs = machine.runs;
  }

  show(kind, owner, side) {
    this.chosen = { kind, owner, side };
    this.draw();
  }

  rowOf(component) {
    const { kind, owner, side } = this.chosen;
    return this.machine.rows.find((r) => r.kind === kind && r.owner === owner && r.side === side && r.component === component);
  }

  /** What a reference says of this component, in parts of `power`; empty where none does. */
  referenceOf(component, power) {
    const { kind, owner, side } = this.chosen;
    const isOfIt = (r) => r.curve && r.curve.kind === kind && r.curve.owner === owner && r.curve.side === side && r.curve.component === component;
    const rows = (this.machine.reference || []).filter(isOfIt);
    return rows.flatMap(({ curve }) => curve.t.map((t, k) => [t, curve.values[k] / power]));
  }

  /** Draws points as rings over a plot. */
  static drawRings(plot, points) {
    const pen = plot.ctx;
    const { left, top, width, height } = plot.bbox;
    pen.save();
    pen.setLineDash([]);
    pen.strokeStyle = concord.colour("--open");
    pen.lineWidth = 1.5 * devicePixelRatio;
    for (const [t, value] of points) {
      const [x, y] = [plot.valToPos(t, "x", true), plot.valToPos(value, "y", true)];
      if (x < left || x > left + width || y < top || y > top + height) continue;
      pen.beginPath();
      pen.arc(x, y, 3.5 * devicePixelRatio, 0, 2 * Math.PI);
      pen.stroke();
    }
    pen.restore();
  }

  /** What a component of this unit is drawn against where it is next to nothing: the joint's largest scale. */
  scaleOf(component) {
    const { kind, owner, side } = this.chosen;
    const isKin = (r) => r.kind === kind && r.owner === owner && r.side === side && (r.component < 3) === (component < 3);
    return this.machine.rows.filter(isKin).reduce((most, r) => Math.max(most, r.scale), 0);
  }

  draw() {
    for (const plot of this.made) plot.destroy();
    this.made = [];
    this.charts.replaceChildren();
    this.width = this.charts.clientWidth;
    if (!this.chosen) return;
    if (!this.runs) {
      this.charts.append(concord.element("p", { text: "No solver finished a run: there is nothing to draw." }));
      return;
    }
    const { kind, owner, side } = this.chosen;
    const curves = (kind === "element" ? this.runs.elements : this.runs.joints)[owner][side];
    curves.forEach((curve, component) => this.addChart(curve, component));
  }

  addChart(curve, component) {
    const row = this.rowOf(component);
    const unit = component < 3 ? "N" : "N m";
    const verdict = row ? row.verdict : "carries nothing";
    const kind = row ? (verdict === "not judged" ? "open" : verdict) : "";
    const box = concord.element("div", { class: "chart" }, concord.element("h3", {},
      concord.element("span", { text: `${concord.components[component]} [${unit}]` }),
      concord.element("span", { class: kind, text: row ? `${verdict}${row.digits[1] === null ? "" : ", " + concord.digits(row.digits[1]) + " digits"}` : verdict })));
    this.charts.append(box);
    if (row && row.unique === false) {
      box.append(concord.element("p", { text: "Not unique: infinitely many values hold the machine together alike, and none of them is drawn." }));
      return;
    }
    if (!curve) {
      box.append(concord.element("p", { text: "Zero throughout." }));
      return;
    }
    const values = concord.element("p", { class: "values" });
    const t = this.runs.t;
    const a = concord.numbers(curve.a);
    const b = concord.numbers(curve.b);
    const width = box.clientWidth - 18;
    const lines = [{}, { stroke: concord.colour("--one"), width: 1.6 }, { stroke: concord.colour("--two"), width: 1.6, dash: [6, 5] }];
    // What is round-off beside the joint's load is drawn as the straight line that it is, in the load's scale.
    const size = this.scaleOf(component);
    // The library's axes do not go below 1e-16: such loads are drawn in parts of a power of ten.
    const largest = (values) => (values || []).reduce((most, value) => Math.max(most, Math.abs(value) || 0), size);
    const most = Math.max(largest(a), largest(b));
    const exponent = most > 0 && most < 1e-9 ? Math.floor(Math.log10(most)) : 0;
    const power = 10 ** exponent;
    const data = [t, ...[a, b].map((values) => (values ? Array.from(values, (value) => value / power) : t.map(() => null)))];
    if (exponent !== 0) box.append(concord.element("p", { class: "values", text: `in 1e${exponent} ${unit}` }));
    const isFlat = (least, most) => !(most - least > Math.max(1e-300, 1e-12 * Math.max(size / power, Math.abs(least), Math.abs(most))));
    const rings = this.referenceOf(component, power);
    const range = (u, lowest, highest) => {
      const least = rings.reduce((so, [, value]) => Math.min(so, value), lowest);
      const most = rings.reduce((so, [, value]) => Math.max(so, value), highest);
      return isFlat(least, most) ? [least - (size / power || 1), most + (size / power || 1)] : uPlot.rangeNum(least, most, 0.1, true);
    };
    const options = this.optionsOf(width, 150, lines, { y: { range } }, (at) => {
      values.textContent = at === null ? "" : `t = ${concord.short(t[at])} s: ${concord.short(a && a[at])}, ${concord.short(b && b[at])} ${unit}`;
    });
    if (rings.length) options.hooks.draw = [(u) => concord.Plots.drawRings(u, rings)];
    this.made.push(new uPlot(options, data.map((column) => Array.from(column)), box));
    box.append(values);
    if (curve.d) this.addDifference(box, width, concord.numbers(curve.d), row, unit);
  }

  addDifference(box, width, d, row, unit) {
    const t = this.runs.thinned ? this.runs.t.filter((_, k) => k % 2 === 0) : this.runs.t;
    const largest = d.reduce((most, value) => Math.max(most, value || 0), 0);
    const floor = row && row.scale > 0 ? row.scale * 1e-17 : Math.max(1e-300, 1e-4 * largest);
    // Exponents on a linear scale: the library's logarithmic one does not go below 1e-16.
    const sizes = Array.from(d, (value) => (Number.isNaN(value) ? null : Math.log10(Math.max(value, floor))));
    // Results of older programs do not hold the scale of the run itself.
    const scale = row && row.scales ? row.scales[1] : row && row.scale;
    const need = scale > 0 ? scale * 10 ** -row.need[1] : null;
    const lines = [{}, { stroke: concord.colour("--ink"), width: 1.2 }, { stroke: concord.colour("--bad"), width: 1, dash: [2, 3] }];
    box.append(concord.element("p", { class: "values", text: `|difference| [${unit}]` + (need === null ? "" : `, need of the same run ${concord.short(need)}`) }));
    const scales = { y: { range: (u, least, most) => [Math.floor(least - 0.2), Math.ceil(most + 0.2)] } };
    const options = this.optionsOf(width, 110, lines, scales, null);
    options.axes[1].values = (u, ticks) => ticks.map((v) => (Number.isInteger(v) ? `1e${v}` : ""));
    options.axes[1].incrs = [1, 2, 3, 5, 10, 20, 50, 100];
    options.axes[1].space = 18;
    this.made.push(new uPlot(options, [Array.from(t), sizes, t.map(() => (need === null ? null : Math.log10(need)))], box));
  }

  optionsOf(width, height, series, scales, tell) {
    return concord.plotOptions(width, height, series, scales, "time", (u) => {
      if (tell) tell(u.cursor.idx === undefined ? null : u.cursor.idx);
      if (this.isMoved || u.cursor.idx === null || u.cursor.idx === undefined || u.cursor.left < 0) return;
      this.hover(u.data[0][u.cursor.idx]);
    });
  }

  /** Puts the cursor of all plots at a time, without telling the view. */
  mark(t) {
    this.isMoved = true;
    for (const plot of this.made) plot.setCursor({ left: plot.valToPos(t, "x"), top: 10 }, true, false);
    this.isMoved = false;
  }
};

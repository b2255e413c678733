"use strict";
// A case over the nights: small lines for the table, plots for the chosen case.

/** A line of `values` over the nights; `steps` are marked. The span is at least `least`, so that luck is no mountain. */
concord.spark = function (values, least, steps, says) {
  const make = (name, attributes) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  };
  const [width, height, edge] = [96, 20, 3];
  const picture = make("svg", { class: "spark", width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": says });
  const known = values.filter((value) => value !== null);
  if (known.length === 0) return picture;
  const middle = (Math.min(...known) + Math.max(...known)) / 2;
  const half = Math.max(least, Math.max(...known) - Math.min(...known)) / 2 || 1;
  const x = (k) => (values.length < 2 ? width / 2 : edge + (width - 2 * edge) * k / (values.length - 1));
  const y = (value) => height / 2 - (height / 2 - edge) * (value - middle) / half;
  for (const step of steps) {
    const at = ((x(step.night) + x(step.before)) / 2).toFixed(1);
    picture.append(make("line", { x1: at, x2: at, y1: 1, y2: height - 1, class: concord.kindOfTurn(step.what) }));
  }
  let path = "";
  let last = null;
  values.forEach((value, k) => {
    if (value === null) return;
    path += `${last === null || values[k - 1] === null ? "M" : "L"}${x(k).toFixed(1)} ${y(value).toFixed(1)}`;
    last = k;
  });
  picture.append(make("path", { d: path }), make("circle", { cx: x(last).toFixed(1), cy: y(values[last]).toFixed(1), r: 2 }));
  return picture;
};

/** "bad", "good" or "open". */
concord.kindOfTurn = (what) => ({ red: "bad", worse: "bad", gone: "bad", flaky: "bad", better: "good", "no baseline": "open", changed: "open", "known red": "open" }[what] || "quiet");

/** "night 12, 2026-11-22, 3f97bf0c1a2b" */
concord.nightWords = (night) => `night ${night.id}, ${night.started.slice(0, 10)}, ${night.commit}`;

/** Plots of the chosen case over the nights. */
concord.TrendPlots = class {
  constructor(nights) {
    this.nights = nights;
    this.charts = document.getElementById("charts");
    this.made = [];
    this.width = 0;
    new ResizeObserver(() => {
      if (Math.abs(this.charts.clientWidth - this.width) > 8) this.draw();
    }).observe(this.charts);
  }

  show(one) {
    this.one = one;
    this.draw();
  }

  draw() {
    for (const plot of this.made) plot.destroy();
    this.made = [];
    this.charts.replaceChildren();
    this.width = this.charts.clientWidth;
    if (!this.one) return;
    const trend = this.one.trend;
    const line = (name, values, colour, kind, dash) => ({ name, values, colour, kind, dash });
    const pair = (values) => [line("cartesian", values[0], "--one", "one"), line("relative", values[1], "--two", "two")];
    this.add("Worst digits", [line("same state", trend.same_state, "--one", "one"), line("resolvable", trend.resolvable, "--quiet", "four", [4, 4]),
      line("same run", trend.same_run, "--two", "two"), line("refined", trend.refined, "--good", "three")], 1);
    this.add("Evaluations", pair(trend.evaluations), 1);
    this.add("Steps", pair(trend.steps), 1);
    this.add("Wall time [s], not judged", [line("wall time", trend.wall_s, "--quiet", "four")], 0.1);
  }

  /** A plot, unless there is nothing in it. `least`: span of the axis. */
  add(title, lines, least) {
    const there = lines.filter((line) => line.values.some((value) => value !== null));
    if (there.length === 0) return;
    const keys = concord.element("p", { class: "keys" }, ...there.map((line) =>
      concord.element("span", { class: line.kind, text: `${line.dash ? "\u2505" : "\u2501"} ${line.name}` })));
    const box = concord.element("div", { class: "chart" }, concord.element("h3", { text: title }), keys);
    const values = concord.element("p", { class: "values" });
    this.charts.append(box);
    const count = this.nights.length;
    const scales = {
      x: { range: [-0.5, count - 0.5] },
      y: { range: (u, low, high) => (high - low < least ? [(low + high - least) / 2, (low + high + least) / 2] : uPlot.rangeNum(low, high, 0.1, true)) },
    };
    const series = [{}, ...there.map((line) => ({ stroke: concord.colour(line.colour), width: 1.6, dash: line.dash, points: { show: count < 40, size: 5 } }))];
    const options = concord.plotOptions(box.clientWidth - 18, 160, series, scales, "night", (u) => {
      const at = u.cursor.idx;
      const isThere = at !== null && at !== undefined && u.cursor.left >= 0;
      values.textContent = isThere ? `${concord.nightWords(this.nights[at])}: ${there.map((line) => `${line.name} ${concord.tellNumber(line.values[at])}`).join(", ")}` : "";
    });
    options.axes[0].values = (u, ticks) => ticks.map((k) => (this.nights[k] ? String(this.nights[k].id) : ""));
    options.axes[0].incrs = [1, 2, 5, 10, 20, 50, 100, 200, 500];
    options.hooks.draw = [(u) => this.drawSteps(u)];
    this.made.push(new uPlot(options, [this.nights.map((_, k) => k), ...there.map((line) => line.values)], box));
    box.append(values);
  }

  /** A dotted line between the night before a step and the night after it. */
  drawSteps(u) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.setLineDash([3, 4]);
    ctx.lineWidth = devicePixelRatio;
    for (const step of this.one.steps) {
      const at = u.valToPos((step.night + step.before) / 2, "x", true);
      if (at < bbox.left || at > bbox.left + bbox.width) continue;
      ctx.strokeStyle = concord.colour(concord.kindOfTurn(step.what) === "good" ? "--good" : "--bad");
      ctx.beginPath();
      ctx.moveTo(at, bbox.top);
      ctx.lineTo(at, bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.restore();
  }

  /** Puts the cursor of all plots at a night. */
  mark(night) {
    for (const plot of this.made) plot.setCursor({ left: plot.valToPos(night, "x"), top: 10 }, true, false);
  }
};

/** Whole numbers as they are, others with two decimals; "-" of what is not known. */
concord.tellNumber = (value) => (value === null || value === undefined ? "-" : Number.isInteger(value) ? String(value) : value.toFixed(2));

"use strict";
// What explains a verdict: who is to blame, equations or motions, a reference, a third opinion.
(function () {
  const make = concord.element;
  const sized = (value, unit) => (value === null || value === undefined ? "-" : `${value.toExponential(2)} ${unit}`.trim());

  function tableOf(columns, rows) {
    const head = make("tr", {}, ...columns.map((text) => make("th", { scope: "col", text })));
    const lines = rows.map((cells) => make("tr", {}, ...cells.map((cell, k) => (k === 0 ? make("th", { scope: "row", text: cell }) : make("td", { text: cell, class: cell === "differ" ? "differ" : "" })))));
    return make("div", { class: "scroll" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...lines)));
  }

  /** A table of lines of texts, the head first; `right` says which columns stand right. */
  concord.printedTable = function ({ lines, right }) {
    const kind = (text, k) => (right[k] ? "number" : "") + (text === "agree" || text === "differ" ? " " + text : "");
    const cells = (line, name) => line.map((text, k) => make(name, { class: kind(text, k), text }));
    return make("div", { class: "scroll" }, make("table", {}, make("thead", {}, make("tr", {}, ...cells(lines[0], "th"))),
      make("tbody", {}, ...lines.slice(1).map((line) => make("tr", {}, ...cells(line, "td"))))));
  };

  /** The sentence below the findings; nothing where nobody is to blame. */
  concord.blame = function (machine) {
    const told = machine.attribution || {};
    if (!told.solver) return [];
    const who = { none: "neither solver, but the statement", both: "what both solvers share" }[told.solver] || told.solver;
    const closed = told.closed_digits === undefined ? "" : ` With this place put right the difference closes by ${concord.digits(told.closed_digits)} digits.`;
    return [make("p", { id: "blame" }, make("strong", { text: `To blame: ${who}, at ${told.place}, in the term \u201c${told.term}\u201d` }), `: ${told.because}.${closed}`)];
  };

  function equationsOrMotions(table) {
    if (!table) return [];
    const { formulation, integration, unit, curves } = table;
    return [make("h2", { text: "Equations or motions" }),
            make("p", { class: "quiet", text: `Largest difference of ${table.of}, over ${table.samples} samples` }),
            tableOf(["", "cartesian", "relative"],
                    [["between both solvers' equations, on the motion of", sized(formulation.cartesian_motion, unit), sized(formulation.relative_motion, unit)],
                     ["between both motions, by the equations of", sized(integration.cartesian_equations, unit), sized(integration.relative_equations, unit)],
                     ["peak of each on its own motion", ...curves.peak.map((value) => sized(value, unit))],
                     ["time of the peak", ...curves.t_peak.map((value) => sized(value, "s"))]]),
            make("p", { class: "quiet", text: `RMS over range ${sized(curves.rms_over_range, "")}; Sprague-Geers: magnitude ${sized(curves.magnitude, "")}, phase ${sized(curves.phase, "")}, combined ${sized(curves.combined, "")}` })];
  }

  function reference(rows) {
    if (!(rows || []).length) return [];
    return [make("h2", { text: "Against the reference" }),
            tableOf(["of", "component", "peak", "error", "cartesian is off by", "relative is off by", "verdict"],
                    rows.map((r) => [r.of, r.component, ...[r.peak, r.stated_error, r.cartesian_off, r.relative_off].map((value) => sized(value, r.unit === "1" ? "" : r.unit)), r.word]))];
  }

  function thirdOpinion(third) {
    if (!third) return [];
    const title = make("h2", { text: `Third opinion: ${third.name}` });
    if (third.not_expressible) return [title, make("p", { class: "quiet", text: `It cannot express this machine: ${third.not_expressible}` })];
    return [title, make("p", { class: "quiet", text: `It answered in ${third.states} states, and could not in ${third.failed}. Digits:` }),
            tableOf(["of", "component", "with cartesian", "with relative", "between both", "need", "off"],
                    third.rows.map((r) => [r.of, r.component, concord.digits(r.cartesian_digits), concord.digits(r.relative_digits), concord.digits(r.between_digits), concord.short(r.need), r.off]))];
  }

  concord.explanations = (machine) => {
    const told = machine.attribution || {};
    return [...equationsOrMotions(told.two_by_two), ...reference(machine.reference), ...thirdOpinion(machine.third_opinion)];
  };

  /** Notes but those that the explanations say in full. */
  concord.notesBesideExplanations = function (machine) {
    const told = machine.attribution || {};
    const isSaid = (note) => (told.solver && note.startsWith("to blame: ")) || (told.two_by_two && note.startsWith("the difference of "));
    return (machine.notes || []).filter((note) => !isSaid(note));
  };

  /** The first curve of a reference that differs; null where there is none. */
  concord.redCurve = (rows) => ((rows || []).find((row) => row.verdict === "differ" && row.curve) || { curve: null }).curve;

  /** The red row that misses its need by most digits, in the states or in a run; null where none is red. */
  concord.farthestBelowNeed = function (rows) {
    const missing = (row) => Math.max(...row.digits.map((digits, rung) => (digits === null ? -Infinity : row.need[rung] - digits)));
    const red = rows.filter((row) => row.verdict === "differ");
    return red.reduce((worst, row) => (worst === null || missing(row) > missing(worst) ? row : worst), null);
  };
})();

"use strict";
// Puts the parts of a machine's page together.
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const find = (id) => document.getElementById(id);

  function showVerdict(machine) {
    const sentence = find("sentence");
    sentence.textContent = machine.sentence;
    sentence.className = machine.outcome;
    find("rungs").replaceChildren(...(machine.rungs || []).map((rung) => {
      const digits = rung.digits === null || rung.digits === undefined ? "" : ` ${concord.digits(rung.digits)} digits`;
      const less = rung.passed_with_less ? `: ${rung.passed_with_less}` : "";
      const horizon = rung.horizon_s && !less ? `, judged up to ${concord.short(rung.horizon_s)} s` : "";
      return concord.element("li", { class: rung.passed ? "yes" : "no", text: rung.name + digits + less + horizon });
    }));
    const said = find("messages");
    said.replaceChildren();
    const findings = (machine.findings || []).map((f) => (f.symptom ? `${f.what}: ${f.symptom}` : f.what));
    if (findings.length) said.append(concord.list(findings, "finding"));
    if ((machine.failures || []).length) said.append(concord.list(machine.failures, "finding"));
    said.append(...concord.blame(machine));
    const notes = concord.notesBesideExplanations(machine);
    if (notes.length) said.append(concord.list(notes, "note"));
    const explained = concord.explanations(machine);
    find("explanations").hidden = explained.length === 0;
    find("explanations").replaceChildren(...explained);
  }

  function showSolvers(machine) {
    const rows = [
      ["integrator", (s) => s.integrator], ["cut joints", (s) => s.cut_joints.join(", ") || "none"],
      ["constraints of rank", (s) => `${s.constraints} of rank ${s.rank}`], ["degrees of freedom", (s) => s.degrees_of_freedom],
      ["steps, evaluations", (s) => `${s.steps}, ${s.evaluations}`],
      ["audit", (s) => (s.audit_digits === null ? "-" : `${concord.digits(s.audit_digits)} digits; ${s.audit_worst}`)],
      ["energy drift", (s) => s.energy_drift || "-"],
      ["largest misfit of constraints", (s) => concord.short(s.max_constraint)],
    ];
    const head = concord.element("tr", {}, concord.element("th", { text: "" }), ...machine.solvers.map((s) => concord.element("th", { scope: "col", text: s.name })));
    const lines = rows.map(([name, value]) => concord.element("tr", {}, concord.element("th", { scope: "row", text: name }), ...machine.solvers.map((s) => concord.element("td", { text: String(value(s)) }))));
    find("solver-table").replaceChildren(concord.element("table", {}, concord.element("thead", {}, head), concord.element("tbody", {}, ...lines)));
  }

  /** From what the verdict was made; results of older programs do not say it. */
  function showProvenance({ file, program, run }) {
    const said = file ? [`Model ${file.name} (FNV-1a ${file.fnv1a})`, `judged by ${program}`, `rtol ${run.rtol}`, `until ${run.until} s`, `seed ${run.seed}`] : [];
    find("provenance").textContent = said.join(", ");
  }

  /** Tables as they are printed: forces of the run, and the pose at the start. */
  function showTold(machine) {
    find("told").replaceChildren(...(machine.told || []).flatMap((one) => [
      concord.element("h2", { text: one.title }), ...one.tables.map((table) => concord.printedTable(table)),
      ...one.words.map((text) => concord.element("p", { text })),
    ]));
  }

  const scene = new concord.Scene((t) => { showTime(t); plots.mark(t); });
  const plots = new concord.Plots((t) => { scene.stop(); scene.t = t; scene.draw(); showTime(t); });
  const table = new concord.Table({
    place: "table", filter: "filter", shown: "shown", noun: "components", columns: concord.componentColumns,
    keeps: (r) => !find("only-red").checked || r.row.verdict === "differ",
    text: (r) => `${r.of} ${r.on} ${r.component} ${r.row.verdict}`,
    choose: (r) => choose(r.row.kind, r.row.owner, r.row.side),
  });
  find("only-red").addEventListener("change", () => table.show());
  let machine = null;

  function showTime(t) {
    find("now").textContent = `t = ${concord.short(t)} s`;
    find("time").value = scene.end > scene.start ? String(1000 * (t - scene.start) / (scene.end - scene.start)) : "0";
  }

  function choose(kind, owner, side) {
    scene.chosen = { kind, owner };
    find("owner").value = `${kind} ${owner}`;
    const item = (kind === "element" ? machine.machine.elements : machine.machine.joints)[owner];
    find("side").replaceChildren(...[0, 1].map((k) => concord.element("option", { value: String(k), text: concord.bodyOf(machine.machine, item, k) })));
    find("side").value = String(side);
    find("plotted").textContent = `${kind} ${item.name} on ${concord.bodyOf(machine.machine, item, side)}`;
    plots.show(kind, owner, side);
    scene.draw();
  }

  function aboutPlots() {
    const runs = machine.runs;
    if (!runs) return "";
    const frame = "Components in the frame of the side. Solid: " + machine.solvers[0].name + ", dashed: " + machine.solvers[1].name + ".";
    const rings = (machine.reference || []).some((r) => r.curve) ? " Rings: the reference." : "";
    return frame + rings + (runs.thinned ? ` ${runs.samples} samples are drawn as the least and the largest of each of ${runs.bins} bins.` : "");
  }

  function load(k) {
    machine = data.machines[k];
    showVerdict(machine);
    const isThere = Boolean(machine.machine);
    for (const id of ["picture", "told", "components", "solvers"]) find(id).hidden = !isThere;
    if (!isThere) return;
    showSolvers(machine);
    showProvenance(machine);
    showTold(machine);
    plots.load(machine);
    table.load(concord.componentRows(machine));
    scene.load(machine);
    const items = machine.machine.joints.map((joint, i) => [`joint ${i}`, `joint ${joint.name} (${joint.type})`])
      .concat(machine.machine.elements.map((element, i) => [`element ${i}`, `${element.type} ${element.name}`]));
    find("owner").replaceChildren(...items.map(([value, text]) => concord.element("option", { value, text })));
    find("about-plots").replaceChildren(aboutPlots(), concord.element("span", { class: "by-hand", text: machine.runs ? " Drag to zoom in time, double-click to zoom out." : "" }));
    find("legend").replaceChildren(
      concord.element("span", { class: "one", text: "\u2501 " + machine.solvers[0].name }), "  ",
      concord.element("span", { class: "two", text: "\u2505 " + machine.solvers[1].name }), "  ",
      concord.element("span", { class: "load", text: "\u2192 reaction on the child" }),
      scene.largest > 0 ? `, longest ${concord.short(scene.largest)} N` : "");
    const red = concord.farthestBelowNeed(machine.rows) || concord.redCurve(machine.reference) || machine.rows[0];
    if (red) choose(red.kind, red.owner, red.side);
    showTime(scene.t);
  }

  find("choice").append(concord.element("label", {}, "Machine ", concord.element("select", { id: "machine" })));
  find("machine").replaceChildren(...data.machines.map((one, k) => concord.element("option", { value: String(k), text: `${one.model}: ${one.outcome}` })));
  find("choice").hidden = data.machines.length < 2;
  find("machine").addEventListener("change", (event) => load(Number(event.target.value)));
  find("owner").addEventListener("change", (event) => { const [kind, owner] = event.target.value.split(" "); choose(kind, Number(owner), 1); });
  find("side").addEventListener("change", (event) => { const [kind, owner] = find("owner").value.split(" "); choose(kind, Number(owner), Number(event.target.value)); });
  find("play").addEventListener("click", () => scene.toggle());
  find("fit").addEventListener("click", () => scene.fit());
  find("time").addEventListener("input", (event) => { scene.stop(); scene.go(scene.start + (scene.end - scene.start) * Number(event.target.value) / 1000); });
  for (const id of ["show-loads", "show-both", "show-names"]) find(id).addEventListener("change", () => scene.draw());
  concord.followTheme(() => { plots.draw(); scene.draw(); });
  find("made").textContent = data.made;
  const worst = data.machines.findIndex((one) => one.outcome !== "agree");
  find("machine").value = String(Math.max(0, worst));
  load(Math.max(0, worst));
})();

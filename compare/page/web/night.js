"use strict";
// Puts the parts of a night's page together.
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const find = (id) => document.getElementById(id);
  const turns = ["red", "worse", "gone", "no baseline", "changed", "flaky", "known red", "better", "new"];
  const both = (pair) => (pair[0] || pair[1] ? `${pair[0]} / ${pair[1]}` : "-");
  const more = (change) => (change.component ? change.component + (change.more > 0 ? ` and ${change.more} more` : "") : "-");
  const measured = (change) => `${change.component ? more(change) + ", " : ""}${change.measure}: ${change.was || "-"} \u2192 ${change.is}`;
  const firstTurn = (r) => (r.changes.length ? turns.indexOf(r.changes[0].what) : turns.length);
  const isKnown = (r) => r.changes.some((change) => change.what === "known red");
  const kindOfCase = (r) => (r.ending === "agree" ? "agree" : isKnown(r) ? "open" : "differ");
  let wanted = null;  // the one turn that is shown

  const plots = new concord.TrendPlots(data.nights);
  const cases = data.cases;
  const byName = new Map(cases.map((one) => [one.id, one]));
  cases.forEach((one) => { one.changes = []; });
  data.changes.forEach((change) => { if (byName.has(change.case)) byName.get(change.case).changes.push(change); });

  /** What a case's small line shows: of the rungs that there are the one nearest to its need, mostly the same run. */
  function digitsOf(one) {
    for (const rung of ["same_run", "same_state", "refined"]) {
      if (one.trend[rung].some((value) => value !== null)) return { name: rung.replace("_", " "), values: one.trend[rung] };
    }
    return { name: "digits", values: [] };
  }
  const costOf = (one) => one.trend.evaluations[0].map((value, k) => (value === null ? null : value + one.trend.evaluations[1][k]));
  const isDigits = (step) => ["same state", "same run", "refined", "ending"].includes(step.measure);
  function changeOver(values) {
    const known = values.filter((value) => value !== null);
    return known.length ? known[known.length - 1] - known[0] : null;
  }
  function says(name, values) {
    const known = values.filter((value) => value !== null);
    return known.length ? `${name} over ${known.length} nights: ${concord.tellNumber(known[0])} to ${concord.tellNumber(known[known.length - 1])}` : "nothing";
  }
  function sparkOfDigits(one) {
    const { name, values } = digitsOf(one);
    return concord.spark(values, 1, one.steps.filter(isDigits), says(name, values));
  }
  function sparkOfCost(one) {
    const values = costOf(one);
    const largest = Math.max(0, ...values);
    if (largest === 0) return "-";
    return concord.spark(values, 0.15 * largest, one.steps.filter((step) => step.measure.startsWith("evaluations")), says("evaluations", values));
  }

  const table = new concord.Table({
    place: "table", filter: "filter", shown: "shown", noun: "cases",
    keeps: (r) => (!find("only-red").checked || r.code !== 0) && (!find("only-changed").checked || r.changes.length > 0),
    text: (r) => `${r.id} ${r.work} ${r.ending} ${r.past}`,
    choose: (r) => { choose(r); show(); },
    columns: [
      { name: "case", key: (r) => r.id, kind: () => "name" },
      { name: "ending", key: (r) => r.ending, kind: kindOfCase },
      { name: "past", key: firstTurn, text: (r) => r.past, kind: (r) => (r.changes.length ? concord.kindOfTurn(r.past) : "quiet") },
      { name: "digits by night", key: (r) => changeOver(digitsOf(r).values), draw: sparkOfDigits },
      { name: "same state", key: (r) => r.worst[0], text: (r) => concord.digits(r.worst[0]), isNumber: true },
      { name: "resolvable", key: (r) => r.resolvable, text: (r) => concord.digits(r.resolvable), isNumber: true },
      { name: "same run", key: (r) => r.worst[1], text: (r) => concord.digits(r.worst[1]), isNumber: true },
      { name: "refined", key: (r) => r.worst[2], text: (r) => concord.digits(r.worst[2]), isNumber: true },
      { name: "cost by night", key: (r) => changeOver(costOf(r)), draw: sparkOfCost },
      { name: "evaluations", key: (r) => r.evaluations[0] + r.evaluations[1], text: (r) => both(r.evaluations), isNumber: true },
      { name: "steps", key: (r) => r.steps_taken[0] + r.steps_taken[1], text: (r) => both(r.steps_taken), isNumber: true },
      { name: "judged", key: (r) => r.judged, text: (r) => `${r.judged} of ${r.total}`, isNumber: true },
      { name: "wall [s]", key: (r) => r.wall_s, text: (r) => r.wall_s.toFixed(2), isNumber: true, kind: () => "quiet" },
      { name: "work", key: (r) => r.work },
    ],
  });
  for (const id of ["only-red", "only-changed"]) find(id).addEventListener("change", () => table.show());

  const changes = new concord.Table({
    place: "changes", filter: "change-filter", shown: "changes-shown", noun: "changes",
    keeps: (r) => wanted === null || r.what === wanted,
    text: (r) => `${r.what} ${r.case} ${r.component} ${r.measure} ${r.was} ${r.is}`,
    choose: (r) => { if (byName.has(r.case)) { choose(byName.get(r.case)); show(); } },
    columns: [
      { name: "what", key: (r) => turns.indexOf(r.what), text: (r) => r.what, kind: (r) => concord.kindOfTurn(r.what) },
      { name: "case", key: (r) => r.case, kind: () => "name" }, { name: "component", key: (r) => r.component, text: more },
      { name: "measure", key: (r) => r.measure }, { name: "was", key: (r) => r.was || "-" }, { name: "is", key: (r) => r.is },
      { name: "against", key: (r) => r.against || "-" },
    ],
  });

  const nights = new concord.Table({
    place: "nights",
    choose: (r) => plots.mark(r.at),
    columns: [
      { name: "night", key: (r) => r.night.id, isNumber: true }, { name: "started, UTC", key: (r) => r.night.started },
      { name: "commit", key: (r) => r.night.commit },
      { name: "ending", key: (r) => r.ending, kind: (r) => (r.ending === "agree" ? "agree" : "differ") },
      { name: "same state", key: (r) => r.same_state, text: (r) => concord.digits(r.same_state), isNumber: true },
      { name: "resolvable", key: (r) => r.resolvable, text: (r) => concord.digits(r.resolvable), isNumber: true },
      { name: "same run", key: (r) => r.same_run, text: (r) => concord.digits(r.same_run), isNumber: true },
      { name: "refined", key: (r) => r.refined, text: (r) => concord.digits(r.refined), isNumber: true },
      { name: "evaluations", key: (r) => r.evaluations[0] + r.evaluations[1], text: (r) => both(r.evaluations), isNumber: true },
      { name: "steps", key: (r) => r.steps[0] + r.steps[1], text: (r) => both(r.steps), isNumber: true },
      { name: "wall [s]", key: (r) => r.wall_s, text: (r) => r.wall_s.toFixed(2), isNumber: true, kind: () => "quiet" },
      { name: "compiler", key: (r) => r.night.compiler }, { name: "machine", key: (r) => r.night.machine },
    ],
  });

  function nightsOf(one) {
    const rows = [];
    one.trend.ending.forEach((ending, at) => {
      if (ending === null) return;
      const row = { at, night: data.nights[at], ending, evaluations: one.trend.evaluations.map((v) => v[at]), steps: one.trend.steps.map((v) => v[at]) };
      for (const key of ["same_state", "resolvable", "same_run", "refined", "wall_s"]) row[key] = one.trend[key][at];
      rows.push(row);
    });
    return rows.reverse();
  }

  function markedList(items) {
    return concord.element("ul", {}, ...items.map(([what, text]) => concord.element("li", { class: concord.kindOfTurn(what), text })));
  }

  function stepWords(step) {
    return `${step.what} in night ${data.nights[step.night].id}: ${measured(step)}; commit ${data.nights[step.before].commit} before, ${data.nights[step.night].commit} after`;
  }

  function choose(one) {
    table.mark(one);
    find("case-name").textContent = one.id;
    find("case-says").textContent = `${one.work}: ${one.ending}, ${one.judged} of ${one.total} components judged${one.integrators[0] ? `; integrators ${one.integrators.join(" and ")}` : ""}`;
    find("case-page").hidden = !one.page;
    if (one.page) find("case-page").href = one.page;
    find("case-words").textContent = one.words;
    find("case-words").className = one.ending === "agree" ? "told" : "";
    find("case-changes").replaceChildren(...(one.changes.length ? [markedList(one.changes.map((c) => [c.what, `${c.what}${c.against ? ", against " + c.against : ""}: ${measured(c)}`]))] : []));
    find("about-plots").textContent = data.nights.length < 2 ? "There is one night: no trend yet."
      : "Over the nights; a dotted line stands between two nights where something changed by more than the suite allows. Drag to zoom, double-click to zoom out.";
    plots.show(one);
    find("about-steps").textContent = one.steps.length ? "Steps from night to night" : "No steps from night to night";
    const left = one.steps_left_out ? [["new", `and ${one.steps_left_out} earlier ones`]] : [];
    find("case-steps").replaceChildren(...(one.steps.length ? [markedList([...one.steps].reverse().map((step) => [step.what, stepWords(step)]).concat(left))] : []));
    nights.load(nightsOf(one));
  }

  /** Goes to the chosen case. */
  function show() {
    find("case-name").focus({ preventScroll: true });
    find("one").scrollIntoView({ behavior: matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth" });
  }

  /** Which cases stepped between the last two nights. */
  function sinceTheNightBefore() {
    if (data.nights.length < 2) return [];
    const now = data.nights.length - 1;
    const stepped = cases.filter((one) => one.steps.some((step) => step.night === now && step.before === now - 1)).map((one) => one.id);
    const shown = stepped.slice(0, 12).join(", ") + (stepped.length > 12 ? ` and ${stepped.length - 12} more` : "");
    const said = stepped.length ? `${stepped.length} of ${cases.length} cases changed by more than the suite allows: ${shown}` : "of the cases that both nights ran, none changed by more than the suite allows";
    return [`Since the night before (${concord.nightWords(data.nights[now - 1])}): ${said}.`];
  }

  function showTurns() {
    find("turns").replaceChildren(...turns.filter((what) => data.turns[what]).map((what) => {
      const button = concord.element("button", { type: "button", class: concord.kindOfTurn(what), "aria-pressed": String(wanted === what), text: `${data.turns[what]} ${what}` });
      button.addEventListener("click", () => {
        wanted = wanted === what ? null : what;
        showTurns();
        changes.show();
        [...find("turns").querySelectorAll("button")].find((one) => one.textContent.endsWith(what)).focus();
      });
      return concord.element("li", {}, button);
    }));
  }

  find("choice").textContent = `night ${data.night.id} of ${data.title}, ${data.night.started} UTC`;
  find("sentence").textContent = data.sentence;
  find("sentence").className = data.outcome;
  find("messages").append(concord.list(sinceTheNightBefore().concat(data.notes), "note"));
  find("changed").hidden = data.changes.length === 0;
  concord.followTheme(() => plots.draw());
  showTurns();
  changes.load(data.changes);
  table.load([...cases]);
  find("one").hidden = cases.length === 0;
  const first = cases.find((one) => one.code !== 0) || cases.find((one) => one.changes.length) || cases[0];
  if (first) choose(first);
  find("made").textContent = data.made;
})();

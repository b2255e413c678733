"use strict";
// The table of a machine's components.

/** Joint or force element of a row, and the body on which the wrench acts. */
concord.ownerOf = (machine, row) => (row.kind === "element" ? machine.elements : machine.joints)[row.owner];
concord.bodyOf = function (machine, owner, side) {
  const end = side === 0 ? owner.parent : owner.child;
  return end ? machine.bodies[end.body].name : "nothing";
};

concord.componentRows = (machine) => machine.rows.map((row) => {
  const owner = concord.ownerOf(machine.machine, row);
  const all = row.states.judged + row.states.not_unique;
  return {
    row, of: (row.kind === "element" ? "" : "joint ") + owner.name, on: concord.bodyOf(machine.machine, owner, row.side),
    component: concord.components[row.component], unique: all > 0 ? row.states.judged / all : 0,
    uniqueText: all > 0 ? `${row.states.judged} of ${all}` : "-",
  };
});

concord.componentColumns = [
  { name: "of", key: (r) => r.of }, { name: "on", key: (r) => r.on }, { name: "component", key: (r) => r.component },
  { name: "scale", key: (r) => r.row.scale, text: (r) => concord.short(r.row.scale) + " " + r.row.unit, isNumber: true },
  { name: "from", key: (r) => r.row.scale_from },
  { name: "same state", key: (r) => r.row.digits[0], text: (r) => concord.digits(r.row.digits[0]), isNumber: true },
  { name: "resolvable", key: (r) => r.row.resolvable[0], text: (r) => concord.digits(r.row.resolvable[0]), isNumber: true },
  { name: "same run", key: (r) => r.row.digits[1], text: (r) => concord.digits(r.row.digits[1]), isNumber: true },
  { name: "refined", key: (r) => r.row.digits[2], text: (r) => concord.digits(r.row.digits[2]), isNumber: true },
  { name: "need", key: (r) => r.row.need[0], text: (r) => r.row.need.join(" / "), isNumber: true },
  { name: "unique in", key: (r) => r.unique, text: (r) => r.uniqueText, isNumber: true },
  { name: "verdict", key: (r) => r.row.verdict, text: (r) => (r.row.said || r.row.verdict) + (r.row.because ? " (need lowered)" : ""), kind: (r) => (r.row.verdict === "not judged" ? "open" : r.row.verdict),
    title: (r) => (r.row.because ? "need lowered: " + r.row.because : "") },
];

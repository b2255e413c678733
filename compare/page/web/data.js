"use strict";
// Numbers and names of the page's data.
const concord = {};

/** IEEE single precision, little-endian, in base64. */
concord.numbers = function (text) {
  if (!text) return null;
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  const values = new Float64Array(bytes.length / 4);
  for (let k = 0; k < values.length; ++k) values[k] = view.getFloat32(4 * k, true);
  return values;
};

concord.components = ["F_x", "F_y", "F_z", "T_x", "T_y", "T_z"];

concord.element = function (name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key === "text") made.textContent = value;
    else if (key === "class") made.className = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
};

/** "12.9"; "-" of what is not known. */
concord.digits = (value) => (value === null || value === undefined ? "-" : value.toFixed(1));

/** Four significant digits, as short as they can be. */
concord.short = function (value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(4)));
};

/** The same for the marks of an axis. */
concord.tick = (value) => (value !== 0 && (Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3) ? String(Number(value.toPrecision(3)).toExponential()) : String(Number(value.toPrecision(6))));

/** Joint or force element of a row, and the body on which the wrench acts. */
concord.ownerOf = (machine, row) => (row.kind === "element" ? machine.elements : machine.joints)[row.owner];
concord.bodyOf = function (machine, owner, side) {
  const end = side === 0 ? owner.parent : owner.child;
  return end ? machine.bodies[end.body].name : "nothing";
};

concord.colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

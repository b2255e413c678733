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

concord.list = (items, kind) => concord.element("ul", { class: kind }, ...items.map((text) => concord.element("li", { text })));

/** "12.9"; "-" of what is not known. Rounded down: what is shown never claims more than what is. */
concord.digits = (value) => (value === null || value === undefined ? "-" : (Math.floor(value * 10) / 10).toFixed(1));

/** Four significant digits, as short as they can be. */
concord.short = function (value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(4)));
};

/** The same for the marks of an axis. */
concord.tick = (value) => (value !== 0 && (Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3) ? String(Number(value.toPrecision(3)).toExponential()) : String(Number(value.toPrecision(6))));

concord.colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Dark or light: the system's choice, until the reader makes another one; light on paper. `redraw` after each change. */
concord.followTheme = function (redraw) {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = null;
  function show(isDark) {
    const theme = isDark ? "dark" : "light";
    if (root.dataset.theme === theme) return;
    root.dataset.theme = theme;
    redraw();
  }
  const wanted = () => (chosen === null ? system.matches : chosen);
  show(wanted());
  system.addEventListener("change", () => show(wanted()));
  window.addEventListener("beforeprint", () => show(false));
  window.addEventListener("afterprint", () => show(wanted()));
  document.getElementById("theme").addEventListener("click", () => {
    chosen = root.dataset.theme !== "dark";
    show(chosen);
  });
};

/** What all plots have in common; `moved` is called with the plot when its cursor moves. */
concord.plotOptions = function (width, height, series, scales, key, moved) {
  const axis = { stroke: concord.colour("--quiet"), grid: { stroke: concord.colour("--line"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };
  return {
    width: Math.max(120, width), height, series, legend: { show: false },
    scales: { ...scales, x: { time: false, ...scales.x } },
    axes: [{ ...axis, size: 24, values: (u, ticks) => ticks.map(concord.short) },
           { ...axis, size: 58, values: (u, ticks) => ticks.map((v) => (v === null ? "" : concord.tick(v))) }],
    cursor: { sync: { key }, y: false, points: { size: 5 }, drag: { x: true, y: false } },
    hooks: { setCursor: [moved] },
  };
};

"use strict";
// Vectors, and the poses of a machine between the frames of the data.
concord.rotation = function (p) {
  const [w, x, y, z] = p;
  return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
          2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
};
concord.times = (A, v) => [A[0] * v[0] + A[1] * v[1] + A[2] * v[2], A[3] * v[0] + A[4] * v[1] + A[5] * v[2], A[6] * v[0] + A[7] * v[1] + A[8] * v[2]];
concord.plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
concord.minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
concord.scaled = (s, a) => [s * a[0], s * a[1], s * a[2]];
concord.dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
concord.cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
concord.unit = (a) => { const n = Math.sqrt(concord.dot(a, a)); return n > 0 ? concord.scaled(1 / n, a) : [0, 0, 1]; };

/** The box around some points. */
concord.Extent = class {
  constructor() {
    this.least = [Infinity, Infinity, Infinity];
    this.most = [-Infinity, -Infinity, -Infinity];
  }

  take(point) { point.forEach((v, k) => { this.least[k] = Math.min(this.least[k], v); this.most[k] = Math.max(this.most[k], v); }); }
  isEmpty() { return !(this.most[0] >= this.least[0]); }
  centre() { return this.least.map((v, k) => (v + this.most[k]) / 2); }
  reach() { return this.isEmpty() ? 0 : Math.hypot(...this.least.map((v, k) => (this.most[k] - v) / 2)); }
};

/** Poses of one solver between the frames of the data. */
concord.Poses = class {
  constructor(frames, run) {
    this.t = frames.t;
    this.modes = frames.modes;
    this.r = concord.numbers(run.r);
    this.p = concord.numbers(run.p);
    this.a = concord.numbers(run.a);
    this.loads = { joint: concord.numbers(run.joints), element: concord.numbers(run.elements) };
    this.n = this.t.length;
    this.bodies = this.r.length / (3 * this.n);
  }

  /** Place of a time between frames: the frame before, and the share of the next one. */
  at(t) {
    let low = 0;
    let high = this.n - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.t[middle] <= t) low = middle; else high = middle;
    }
    const span = this.t[high] - this.t[low];
    return { low, high, share: span > 0 ? Math.min(1, Math.max(0, (t - this.t[low]) / span)) : 0 };
  }

  mix(values, width, first, count, where) {
    const mixed = [];
    for (let k = 0; k < count; ++k) {
      const one = values[where.low * width + first + k];
      mixed.push(one + where.share * (values[where.high * width + first + k] - one));
    }
    return mixed;
  }

  /** Place, rotation and modal coordinates of a body of the machine; ground is body 0. */
  body(i, where) {
    if (i === 0) return { r: [0, 0, 0], A: [1, 0, 0, 0, 1, 0, 0, 0, 1], a: [] };
    const k = i - 1;
    const p = this.mix(this.p, 4 * this.bodies, 4 * k, 4, where);
    const size = Math.hypot(...p) || 1;
    const a = this.a ? this.mix(this.a, this.modes * this.bodies, this.modes * k, this.modes, where) : [];
    return { r: this.mix(this.r, 3 * this.bodies, 3 * k, 3, where), A: concord.rotation(p.map((c) => c / size)), a: a.map((v) => (Number.isNaN(v) ? 0 : v)) };
  }

  /** Wrench on the child in global axes. */
  load(kind, item, where) {
    const values = this.loads[kind];
    return this.mix(values, values.length / this.n, 6 * item, 6, where);
  }
};

/** Two directions across a third. */
concord.across = function (axis) {
  const other = Math.abs(axis[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0];
  const u = concord.unit(concord.cross(axis, other));
  return [u, concord.cross(axis, u)];
};
concord.distance = (a, b) => { const d = concord.minus(a, b); return Math.sqrt(concord.dot(d, d)); };
concord.column = (A, k) => [A[k], A[3 + k], A[6 + k]];
concord.transposed = (A) => [A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]];

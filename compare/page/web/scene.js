"use strict";
// The machine in motion, drawn on a canvas: bodies as boxes and rods, joints as symbols, wrenches as arrows; both
// solvers' poses laid over each other.
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
  join(other) { if (!other.isEmpty()) { this.take(other.least); this.take(other.most); } }
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

concord.Scene = class {
  constructor(tell) {
    this.tell = tell;
    this.canvas = document.getElementById("scene");
    this.pen = this.canvas.getContext("2d");
    this.t = 0;
    this.playing = false;
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  load(machine) {
    this.stop();
    this.machine = machine.machine;
    this.poses = [null, null];
    if (machine.runs) {
      this.poses = machine.runs.frames.runs.map((run) => (run ? new concord.Poses(machine.runs.frames, run) : null));
      const times = machine.runs.frames.t;
      this.start = times[0];
      this.end = times[times.length - 1];
    } else {
      this.start = this.end = 0;
    }
    this.t = this.start;
    this.chosen = null;
    const g = this.machine.gravity;
    this.up = concord.dot(g, g) > 0 ? concord.unit(concord.scaled(-1, g)) : [0, 0, 1];
    this.largest = this.largestForce();
    this.fit();
  }

  largestForce() {
    let most = 0;
    for (const poses of this.poses.filter(Boolean)) {
      const values = poses.loads.joint || [];
      for (let k = 0; k + 5 < values.length; k += 6) most = Math.max(most, Math.hypot(values[k], values[k + 1], values[k + 2]));
    }
    return most;
  }

  /** Looks at all places that bodies and joints reach; follows a machine that travels farther than it is large. */
  fit() {
    this.boxSize = 0;
    const points = this.extents();
    this.boxSize = 0.4 * (points.all.reach() || 1);
    const { all, largest } = this.extents();
    if (all.isEmpty()) { all.take([-1, -1, -1]); all.take([1, 1, 1]); }
    this.centre = all.centre();
    this.reach = Math.max(1e-12, all.reach());
    this.follows = largest > 0 && this.reach > 3 * largest;
    if (this.follows) this.reach = 1.2 * largest;
    this.azimuth = 0.7;
    this.elevation = 0.45;
    this.zoom = 1;
    this.draw();
  }

  /** What the machine reaches over the run, with ground's ends, and how large it is itself at most. */
  extents() {
    const all = new concord.Extent();
    let largest = 0;
    const poses = this.poses.find(Boolean);
    const steps = poses ? Math.min(40, poses.n) : 0;
    for (let s = 0; s < steps; ++s) {
      const where = poses.at(this.start + (this.end - this.start) * s / Math.max(1, steps - 1));
      const bodies = this.machine.bodies.map((_, i) => poses.body(i, where));
      const extent = this.extentOf(bodies);
      largest = Math.max(largest, extent.reach());
      all.join(extent);
      this.ends().forEach((end) => { if (end.body === 0) all.take(this.pointOf(bodies[0], end)); });
    }
    return { all, largest };
  }

  /** Of the bodies themselves in one pose, without ground. */
  extentOf(bodies) {
    const extent = new concord.Extent();
    this.machine.bodies.forEach((body, i) => {
      if (i === 0) return;
      extent.take(this.inSpace(bodies[i], body.center));
      if (this.hasBox(body)) this.corners(bodies[i], body).forEach((corner) => extent.take(corner));
    });
    this.ends().forEach((end) => { if (end.body > 0) extent.take(this.pointOf(bodies[end.body], end)); });
    return extent;
  }

  ends() {
    return [...this.machine.joints, ...this.machine.elements].flatMap((item) => [item.parent, item.child]).filter(Boolean);
  }

  inSpace(pose, point) { return concord.plus(pose.r, concord.times(pose.A, point)); }

  deformed(pose, point, modes) {
    const m = modes.length / 3;
    return point.map((v, row) => { for (let k = 0; k < m; ++k) v += modes[row * m + k] * (pose.a[k] || 0); return v; });
  }

  pointOf(pose, end) { return this.inSpace(pose, this.deformed(pose, end.point, end.modes)); }

  camera() {
    const side = Math.abs(this.up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    const e1 = concord.unit(concord.cross(side, this.up));
    const e2 = concord.cross(this.up, e1);
    const [ca, sa, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    const toward = concord.plus(concord.scaled(ce * ca, e1), concord.plus(concord.scaled(ce * sa, e2), concord.scaled(se, this.up)));
    const right = concord.unit(concord.cross(this.up, toward));
    return { right, above: concord.cross(toward, right), toward };
  }

  project(point) {
    const from = concord.minus(point, this.centre);
    const size = Math.min(this.width, this.height) * 0.55 * this.zoom / this.reach;
    return [this.width / 2 + size * concord.dot(from, this.eye.right), this.height / 2 - size * concord.dot(from, this.eye.above), concord.dot(from, this.eye.toward)];
  }

  line(points, colour, width, dash) {
    const pen = this.pen;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.setLineDash(dash || []);
    pen.beginPath();
    points.forEach((point, k) => { const [x, y] = this.project(point); if (k === 0) pen.moveTo(x, y); else pen.lineTo(x, y); });
    pen.stroke();
    pen.setLineDash([]);
  }

  draw() {
    if (!this.machine) return;
    const ratio = window.devicePixelRatio || 1;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    if (this.width === 0) return;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, this.width, this.height);
    this.eye = this.camera();
    this.drawAxes();
    const both = document.getElementById("show-both").checked;
    const first = this.poses[0] || this.poses[1];
    if (!first) return;
    const where = first.at(this.t);
    const bodies = this.machine.bodies.map((_, i) => first.body(i, where));
    if (this.follows) this.centre = this.extentOf(bodies).centre();
    this.drawBodies(bodies, concord.colour("--one"), concord.colour("--body"), null);
    if (both && this.poses[0] && this.poses[1]) {
      const other = this.poses[1].at(this.t);
      this.drawBodies(this.machine.bodies.map((_, i) => this.poses[1].body(i, other)), concord.colour("--two"), null, [5, 5]);
    }
    this.drawElements(bodies);
    this.drawJoints(bodies);
    if (document.getElementById("show-loads").checked) this.drawLoads(bodies, first, where);
    if (document.getElementById("show-names").checked) this.drawNames(bodies);
  }

  drawBodies(poses, edge, face, dash) {
    this.machine.bodies.forEach((body, i) => {
      if (i === 0) return;
      const pose = poses[i];
      const centre = this.inSpace(pose, body.center);
      for (const item of this.machine.joints) {
        for (const end of [item.parent, item.child]) {
          if (end && end.body === i && !body.points) this.line([centre, this.pointOf(pose, end)], edge, 2, dash);
        }
      }
      if (body.points && body.points.length > 1) {
        this.line(body.points.map((p) => this.inSpace(pose, this.deformed(pose, p.point, p.modes))), edge, 4, dash);
      } else if (this.hasBox(body)) {
        this.drawBox(pose, body, edge, face, dash);
      }
    });
  }

  hasBox(body) { return Boolean(body.box) && !(body.points && body.points.length > 1); }

  /** Of the box of even density with the body's inertia; no larger than a part of the picture. */
  corners(pose, body) {
    const { axes, half } = body.box;
    const shrink = Math.min(1, this.boxSize / Math.max(...half, 1e-300));
    return Array.from({ length: 8 }, (_, k) => {
      const s = [k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1].map((sign, d) => sign * half[d] * shrink);
      return this.inSpace(pose, concord.plus(body.center, concord.times(axes, s)));
    });
  }

  drawBox(pose, body, edge, face, dash) {
    const corners = this.corners(pose, body);
    const faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    for (const f of faces) {
      const outline = [...f, f[0]].map((k) => corners[k]);
      if (face) {
        this.pen.fillStyle = face;
        this.pen.beginPath();
        outline.forEach((p, k) => { const [x, y] = this.project(p); if (k === 0) this.pen.moveTo(x, y); else this.pen.lineTo(x, y); });
        this.pen.fill();
      }
      this.line(outline, edge, 1, dash);
    }
  }

  drawElements(bodies) {
    for (const item of this.machine.elements) {
      const ends = [item.parent, item.child].filter(Boolean).map((end) => this.pointOf(bodies[end.body], end));
      if (ends.length === 2) this.line(ends, concord.colour("--open"), 1.5, [2, 3]);
    }
  }

  /** A symbol by type: discs turn, balls are round, crosses are universal, squares weld, bars slide. */
  drawJoints(bodies) {
    this.machine.joints.forEach((joint, k) => {
      const parent = bodies[joint.parent.body];
      const child = bodies[joint.child.body];
      const at = this.pointOf(child, joint.child);
      const [x, y] = this.project(at);
      const isChosen = this.chosen && this.chosen.kind === "joint" && this.chosen.owner === k;
      const pen = this.pen;
      const axis = (end, pose, place) => concord.times(pose.A, [end.frame[place], end.frame[3 + place], end.frame[6 + place]]);
      const length = 0.09 * this.reach / this.zoom;
      const bar = (direction, width) => this.line([concord.minus(at, concord.scaled(length, direction)), concord.plus(at, concord.scaled(length, direction))], pen.strokeStyle, width);
      pen.strokeStyle = pen.fillStyle = concord.colour(isChosen ? "--bad" : "--joint");
      const size = isChosen ? 6 : 4.5;
      const type = joint.type;
      if (/revolute|cylindrical|screw|translational/.test(type)) bar(axis(joint.child, child, 2), type === "translational" ? 4 : 2);
      if (/universal/.test(type)) { bar(axis(joint.parent, parent, 0), 2); bar(axis(joint.child, child, 1), 2); }
      if (/distance|_spherical/.test(type)) this.line([this.pointOf(parent, joint.parent), at], pen.strokeStyle, 1.5);
      pen.lineWidth = 1.8;
      pen.beginPath();
      if (type === "weld") pen.rect(x - size, y - size, 2 * size, 2 * size);
      else pen.arc(x, y, size, 0, 2 * Math.PI);
      if (/spherical|free|ball/.test(type)) pen.stroke(); else pen.fill();
    });
  }

  arrow(from, vector, colour, width) {
    const to = concord.plus(from, vector);
    this.line([from, to], colour, width);
    const [x0, y0] = this.project(from);
    const [x1, y1] = this.project(to);
    const size = Math.hypot(x1 - x0, y1 - y0);
    if (size < 3) return;
    const [u, v] = [(x1 - x0) / size, (y1 - y0) / size];
    const head = Math.min(9, size / 2);
    this.pen.fillStyle = colour;
    this.pen.beginPath();
    this.pen.moveTo(x1, y1);
    this.pen.lineTo(x1 - head * u + head * 0.45 * v, y1 - head * v - head * 0.45 * u);
    this.pen.lineTo(x1 - head * u - head * 0.45 * v, y1 - head * v + head * 0.45 * u);
    this.pen.fill();
  }

  drawLoads(bodies, poses, where) {
    if (!(this.largest > 0)) return;
    this.machine.joints.forEach((joint, k) => {
      const load = poses.load("joint", k, where);
      const isChosen = this.chosen && this.chosen.kind === "joint" && this.chosen.owner === k;
      const at = this.pointOf(bodies[joint.child.body], joint.child);
      this.arrow(at, concord.scaled(0.55 * this.reach / this.largest, load.slice(0, 3)), concord.colour("--load"), isChosen ? 3.5 : 2);
    });
  }

  drawNames(bodies) {
    const pen = this.pen;
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = concord.colour("--ink");
    this.machine.bodies.forEach((body, i) => {
      if (i === 0) return;
      const [x, y] = this.project(this.inSpace(bodies[i], body.center));
      pen.fillText(body.name, x + 8, y - 6);
    });
    this.machine.joints.forEach((joint) => {
      const [x, y] = this.project(this.pointOf(bodies[joint.child.body], joint.child));
      pen.fillText(joint.name, x + 8, y + 14);
    });
  }

  drawAxes() {
    const at = [34, this.height - 30];
    ["x", "y", "z"].forEach((name, k) => {
      const e = [0, 0, 0];
      e[k] = 1;
      const [u, v] = [22 * concord.dot(e, this.eye.right), -22 * concord.dot(e, this.eye.above)];
      const pen = this.pen;
      pen.strokeStyle = pen.fillStyle = concord.colour("--quiet");
      pen.lineWidth = 1.4;
      pen.beginPath();
      pen.moveTo(...at);
      pen.lineTo(at[0] + u, at[1] + v);
      pen.stroke();
      pen.font = "11px system-ui, sans-serif";
      pen.fillText(name, at[0] + 1.3 * u - 3, at[1] + 1.3 * v + 4);
    });
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation + elevation));
    this.draw();
  }

  listen() {
    const held = new Map();
    this.canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, event);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) return;
      if (held.size === 2) {
        const other = [...held.values()].find((one) => one.pointerId !== event.pointerId);
        const gap = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
        this.zoom = Math.max(0.05, Math.min(50, this.zoom * gap(event) / Math.max(1, gap(before))));
        this.draw();
      } else {
        this.turn(-0.008 * (event.clientX - before.clientX), 0.008 * (event.clientY - before.clientY));
      }
      held.set(event.pointerId, event);
    });
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, (event) => held.delete(event.pointerId));
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom = Math.max(0.05, Math.min(50, this.zoom * Math.exp(-0.0012 * event.deltaY)));
      this.draw();
    }, { passive: false });
    this.canvas.addEventListener("keydown", (event) => this.press(event));
  }

  press(event) {
    const step = (this.end - this.start) / 200;
    const keys = {
      ArrowLeft: () => this.turn(-0.1, 0), ArrowRight: () => this.turn(0.1, 0), ArrowUp: () => this.turn(0, 0.1), ArrowDown: () => this.turn(0, -0.1),
      "+": () => { this.zoom *= 1.15; this.draw(); }, "=": () => { this.zoom *= 1.15; this.draw(); }, "-": () => { this.zoom /= 1.15; this.draw(); },
      " ": () => this.toggle(), ",": () => this.go(this.t - step), ".": () => this.go(this.t + step), Home: () => this.fit(),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  }

  go(t) {
    this.t = Math.max(this.start, Math.min(this.end, t));
    this.draw();
    this.tell(this.t);
  }

  toggle() { if (this.playing) this.stop(); else this.play(); }

  stop() {
    this.playing = false;
    document.getElementById("play").textContent = "Play";
  }

  play() {
    if (!(this.end > this.start)) return;
    this.playing = true;
    document.getElementById("play").textContent = "Pause";
    if (this.t >= this.end) this.t = this.start;
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const t = this.t + Number(document.getElementById("speed").value) * (now - last) / 1000;
      last = now;
      this.go(t);
      if (this.t >= this.end) this.stop(); else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
};

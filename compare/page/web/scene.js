"use strict";
// The machine in motion on a canvas: both solvers' poses laid over each other, reactions as arrows, and a camera that
// mouse, touch and keys turn.
concord.Scene = class {
  constructor(tell) {
    this.tell = tell;
    this.canvas = document.getElementById("scene");
    this.painter = new concord.Painter(this.canvas.getContext("2d"));
    this.t = 0;
    this.playing = false;
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  load(machine) {
    this.stop();
    this.machine = machine.machine;
    this.runs = [null, null];
    this.start = this.end = 0;
    if (machine.runs) {
      this.runs = machine.runs.frames.runs.map((run) => (run ? new concord.Poses(machine.runs.frames, run) : null));
      const times = machine.runs.frames.t;
      this.start = times[0];
      this.end = times[times.length - 1];
    }
    this.first = this.runs[0] || this.runs[1];
    this.t = this.start;
    this.chosen = null;
    const g = this.machine.gravity;
    this.up = concord.dot(g, g) > 0 ? concord.unit(concord.scaled(-1, g)) : [0, 0, 1];
    this.across = concord.across(this.up).map((way) => concord.scaled(-1, way));  // seen so that x points to the right
    this.picture = new concord.Picture(this.machine, this.first);
    this.open = this.machine.joints.map((_, k) => machine.rows.filter((r) => r.kind === "joint" && r.owner === k && r.side === 1 && r.component < 3 && r.unique === false).map((r) => r.component));
    this.largest = this.largestForce();
    this.fit();
  }

  largestForce() {
    if (!this.first) return 0;
    return this.first.t.reduce((most, t) => {
      const where = this.first.at(t);
      const bodies = this.picture.posesAt(where);
      return this.machine.joints.reduce((so, _, k) => Math.max(so, Math.hypot(...this.uniqueForce(this.first, bodies, k, where))), most);
    }, 0);
  }

  /** Looks across the plane of a planar machine, else from a side and above; at all that the run reaches, or, of a
   *  machine that travels farther than it is large, at the machine. */
  fit() {
    this.look();
    const size = this.picture.size;
    const travel = new concord.Extent();
    const frames = this.picture.samples.map((where) => ({ where, bodies: this.picture.posesAt(where) }));
    frames.forEach(({ bodies }) => this.picture.places(bodies).forEach((p) => travel.take(p)));
    this.follows = travel.reach() > 3 * size;
    const eye = this.camera();
    const box = { least: [0, 0], most: [0, 0] };
    const take = (point, k) => [eye.right, eye.above].forEach((way, c) => {
      const value = concord.dot(way, point);
      box.least[c] = k === 0 ? value : Math.min(box.least[c], value);
      box.most[c] = k === 0 ? value : Math.max(box.most[c], value);
    });
    const shown = this.follows ? frames.slice(0, 1) : frames;
    const points = shown.flatMap(({ where, bodies }) => [...this.picture.outline(bodies), ...this.arrows(bodies, where).map(([from, force]) => concord.plus(from, force))]);
    (points.length ? points : [[-size, -size, -size], [size, size, size]]).forEach(take);
    const depth = points.length ? points.reduce((sum, p) => sum + concord.dot(p, eye.toward), 0) / points.length : 0;
    const middle = [0, 1].map((c) => (box.least[c] + box.most[c]) / 2);
    this.centre = concord.plus(concord.scaled(middle[0], eye.right), concord.plus(concord.scaled(middle[1], eye.above), concord.scaled(depth, eye.toward)));
    this.half = [0, 1].map((c) => (box.most[c] - box.least[c]) / 2 + 3 * this.picture.width);
    this.zoom = 1;
    this.draw();
  }

  look() {
    const n = this.picture.normal();
    [this.azimuth, this.elevation] = [0.7, 0.45];
    if (!n) return;
    const [e1, e2] = this.across;
    const lift = concord.dot(n, this.up);
    if (Math.abs(lift) > 0.999) {
      this.elevation = Math.PI / 2;
      this.azimuth = Math.atan2(-e1[0], e2[0]);  // x to the right
      return;
    }
    this.azimuth = Math.atan2(concord.dot(n, e2), concord.dot(n, e1));
    this.elevation = Math.asin(lift);
    const right = this.camera().right;
    const leading = right.reduce((best, v, k) => (Math.abs(v) > Math.abs(right[best]) + 1e-6 ? k : best), 0);
    if (right[leading] < 0) [this.azimuth, this.elevation] = [this.azimuth + Math.PI, -this.elevation];
  }

  camera() {
    const [e1, e2] = this.across;
    const [ca, sa, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    const toward = concord.plus(concord.scaled(ce * ca, e1), concord.plus(concord.scaled(ce * sa, e2), concord.scaled(se, this.up)));
    const right = concord.plus(concord.scaled(-sa, e1), concord.scaled(ca, e2));
    return { right, above: concord.cross(toward, right), toward };
  }

  /** The force on a joint's child without what is one of many: components that are not unique. */
  uniqueForce(poses, bodies, k, where) {
    const force = poses.load("joint", k, where).slice(0, 3).map((v) => v || 0);
    return this.open[k].reduce((left, axis) => {
      const way = this.picture.axisOf(bodies, this.machine.joints[k].child, axis);
      return concord.minus(left, concord.scaled(concord.dot(left, way), way));
    }, force);
  }

  /** Where reactions act on children, and the forces in metres of the picture. */
  arrows(bodies, where) {
    if (!(this.largest > 0)) return [];
    return this.machine.joints.map((joint, k) => {
      const force = this.uniqueForce(this.first, bodies, k, where);
      return [this.picture.pointOf(bodies, joint.child), concord.scaled(0.45 * this.picture.size / this.largest, force)];
    });
  }

  draw() {
    if (!this.machine) return;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const pen = this.painter.pen;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const where = this.first && this.first.at(this.t);
    const bodies = this.first && this.picture.posesAt(where);
    if (this.follows) this.centre = this.middleOf(bodies);
    const margin = 34;
    const scale = Math.min((width / 2 - margin) / this.half[0], (height / 2 - margin) / this.half[1]);
    this.painter.aim(this.camera(), this.centre, this.zoom * scale, width, height);
    if (bodies) this.drawMachine(bodies, where);
    this.drawAxes(height);
  }

  middleOf(bodies) {
    const extent = new concord.Extent();
    this.picture.places(bodies).forEach((p) => extent.take(p));
    return extent.centre();
  }

  drawMachine(bodies, where) {
    this.picture.draw(this.painter, bodies, this.chosen);
    if (document.getElementById("show-both").checked && this.runs[0] && this.runs[1]) {
      this.picture.drawOver(this.painter, this.picture.posesAt(this.runs[1].at(this.t), this.runs[1]), concord.colour("--two"));
    }
    if (document.getElementById("show-loads").checked) {
      this.arrows(bodies, where).forEach(([from, force], k) => {
        const isChosen = this.chosen && this.chosen.kind === "joint" && this.chosen.owner === k;
        this.painter.arrow(from, force, concord.colour("--load"), isChosen ? 3.5 : 2);
      });
    }
    if (document.getElementById("show-names").checked) this.drawNames(bodies);
  }

  drawNames(bodies) {
    const pen = this.painter.pen;
    const write = (name, at, right, below) => {
      const [x, y] = this.painter.place(at);
      pen.fillText(name, x + right, y + below);
    };
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = concord.colour("--ink");
    this.machine.bodies.forEach((body, i) => { if (i > 0) write(body.name, this.picture.inSpace(bodies[i], body.center), 8, -8); });
    this.machine.joints.forEach((joint) => write(joint.name, this.picture.pointOf(bodies, joint.child), 10, 18));
  }

  drawAxes(height) {
    const at = [34, height - 30];
    const pen = this.painter.pen;
    ["x", "y", "z"].forEach((name, k) => {
      const e = [0, 0, 0];
      e[k] = 1;
      const [u, v] = [22 * concord.dot(e, this.painter.right), -22 * concord.dot(e, this.painter.above)];
      if (Math.hypot(u, v) < 2) return;  // toward the reader
      pen.fillStyle = concord.colour("--quiet");
      pen.beginPath();
      pen.moveTo(...at);
      pen.lineTo(at[0] + u, at[1] + v);
      this.painter.stroke(concord.colour("--quiet"), 1.4);
      pen.font = "11px system-ui, sans-serif";
      pen.fillText(name, at[0] + 1.3 * u - 3, at[1] + 1.3 * v + 4);
    });
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + elevation));
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

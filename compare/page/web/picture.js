"use strict";
// The machine as an engineer draws it: links as rods between their joints, pins, slides, wheels, springs, beams along
// their nodes, ground hatched, the road.
concord.Picture = class {
  constructor(machine, poses) {
    this.machine = machine;
    this.poses = poses;
    this.slides = /^(translational|cylindrical)$/;
    this.samples = poses ? Array.from({ length: Math.min(60, poses.n) }, (_, k, n = Math.min(60, poses.n)) =>
      poses.at(poses.t[0] + (poses.t[poses.n - 1] - poses.t[0]) * k / Math.max(1, n - 1))) : [];
    this.tires = machine.elements.filter((item) => item.type === "tire");
    this.size = this.sizeOfMachine();
    this.width = 0.035 * this.size;
    this.shapes = machine.bodies.map((body, i) => (i === 0 ? null : this.shapeOf(body, i)));
    this.travels = machine.joints.map((joint) => (this.slides.test(joint.type) ? this.travelOf(joint) : null));
  }

  posesAt(where, poses = this.poses) { return this.machine.bodies.map((_, i) => poses.body(i, where)); }
  inSpace(pose, point) { return concord.plus(pose.r, concord.times(pose.A, point)); }

  deformed(pose, point, modes) {
    const m = modes.length / 3;
    return point.map((v, row) => { for (let k = 0; k < m; ++k) v += modes[row * m + k] * (pose.a[k] || 0); return v; });
  }

  pointOf(bodies, end) { return this.inSpace(bodies[end.body], this.deformed(bodies[end.body], end.point, end.modes)); }
  axisOf(bodies, end, k) { return concord.times(bodies[end.body].A, concord.column(end.frame, k)); }

  /** Ends of joints and of elements that hang between two bodies. */
  ends() {
    const pairs = this.machine.elements.filter((item) => item.parent && item.child);
    return [...this.machine.joints, ...pairs].flatMap((item) => [item.parent, item.child]);
  }

  /** Half of the largest diagonal that the machine itself has in a pose. */
  sizeOfMachine() {
    let most = 0;
    for (const where of this.samples.filter((_, k) => k % 10 === 0)) {
      const extent = new concord.Extent();
      this.places(this.posesAt(where)).forEach((p) => extent.take(p));
      most = Math.max(most, extent.reach());
    }
    if (most > 0) return most;
    return Math.max(1e-9, ...this.machine.bodies.map((body) => (body.box ? Math.hypot(...body.box.half) : 0)), this.machine.length || 0);
  }

  /** Mass centres, ends on bodies and rims of wheels. */
  places(bodies) {
    const all = [];
    this.machine.bodies.forEach((body, i) => { if (i > 0) all.push(this.inSpace(bodies[i], body.center)); });
    this.ends().forEach((end) => { if (end.body > 0) all.push(this.pointOf(bodies, end)); });
    this.tires.forEach((tire) => {
      const at = this.pointOf(bodies, tire.child);
      [0, 1, 2].forEach((k) => [-1, 1].forEach((s) => { const e = [0, 0, 0]; e[k] = s * tire.radius; all.push(concord.plus(at, e)); }));
    });
    return all;
  }

  /** All that is drawn in a pose, for the picture's frame. */
  outline(bodies) {
    const all = this.places(bodies);
    this.machine.bodies.forEach((body, i) => { if (this.shapes[i] && this.shapes[i].box) all.push(...this.corners(bodies[i], body)); });
    this.ends().forEach((end) => { if (end.body === 0) all.push(this.pointOf(bodies, end)); });
    return all;
  }

  /** What a body is drawn as: `points` between which rods lie, `beam` nodes, `box` of its inertia, `wheel`. */
  shapeOf(body, i) {
    const beam = this.nodesInLine(body.points || []);
    if (beam) return { beam, arms: this.armsOf(beam, i) };
    if (this.tires.some((tire) => tire.child.body === i)) return { wheel: true, points: this.pointsOf(i) };
    const points = this.pointsOf(i);
    const slides = this.machine.joints.some((joint) => this.slides.test(joint.type) && (joint.parent.body === i || joint.child.body === i));
    const far = 0.04 * this.size;
    const off = points.length < 2 ? Infinity : this.offRods(points, body.center);
    if (points.length === 0 || (points.length === 1 && concord.distance(points[0].point, body.center) < far)) return { box: Boolean(body.box) && !slides, points: [] };
    const reach = points.reduce((most, p) => Math.max(most, concord.distance(p.point, points[0].point)), 0);
    const inCylinder = this.machine.joints.some((joint) => this.slides.test(joint.type) && joint.parent.body * joint.child.body > 0 && (joint.parent.body === i || joint.child.body === i));
    const isBob = !inCylinder && (points.length < 2 || (points.length === 2 && off > 0.2 * reach));
    return { points: isBob ? [...points, { point: body.center, modes: [] }] : points, bob: isBob && points.length < 2, box: false };
  }

  /** Nodes of a body that is long and thin, from end to end; null of another one. */
  nodesInLine(nodes) {
    if (nodes.length < 2) return null;
    const farthest = (from) => nodes.reduce((most, node) => (concord.distance(node.point, from) > concord.distance(most, from) ? node.point : most), from);
    const first = farthest(nodes[0].point);
    const last = farthest(first);
    const length = concord.distance(first, last);
    const along = concord.unit(concord.minus(last, first));
    const place = (node) => concord.dot(concord.minus(node.point, first), along);
    const isOff = (node) => concord.distance(node.point, concord.plus(first, concord.scaled(place(node), along))) > 0.1 * length;
    if (!(length > 0) || nodes.some(isOff)) return null;
    return [...nodes].sort((a, b) => place(a) - place(b));
  }

  /** Ends that stand off a beam, each with the node from which its arm leads there. */
  armsOf(nodes, i) {
    const nearest = (at) => nodes.reduce((best, node) => (concord.distance(node.point, at) < concord.distance(best.point, at) ? node : best));
    return this.pointsOf(i).map((end) => [nearest(end.point), end]).filter(([node, end]) => concord.distance(node.point, end.point) > 0.01 * this.size);
  }

  /** Different ends on a body. */
  pointsOf(i) {
    const kept = [];
    for (const end of this.ends()) {
      if (end.body === i && !kept.some((p) => concord.distance(p.point, end.point) < 0.02 * this.size)) kept.push(end);
    }
    return kept;
  }

  /** Distance of a point from the rod between two ends, or from the middle of more. */
  offRods(points, at) {
    const [a, b] = [points[0].point, points[1].point];
    const way = concord.minus(b, a);
    const share = Math.max(0, Math.min(1, concord.dot(concord.minus(at, a), way) / Math.max(1e-300, concord.dot(way, way))));
    return concord.distance(at, concord.plus(a, concord.scaled(share, way)));
  }

  /** How far a slide goes: along z of the parent's frame. */
  travelOf(joint) {
    const travel = { least: Infinity, most: -Infinity };
    for (const where of this.samples) {
      const bodies = this.posesAt(where);
      const s = concord.dot(concord.minus(this.pointOf(bodies, joint.child), this.pointOf(bodies, joint.parent)), this.axisOf(bodies, joint.parent, 2));
      travel.least = Math.min(travel.least, s);
      travel.most = Math.max(travel.most, s);
    }
    return travel;
  }

  /** The normal of the plane in which a planar machine moves, or null. */
  normal() {
    if (this.samples.length < 1) return null;
    const start = this.posesAt(this.samples[0]);
    const turning = this.machine.joints.find((joint) => /^(revolute|planar)/.test(joint.type));
    if (!turning) return null;
    const n = this.axisOf(start, turning.parent, 2);
    const inBodies = start.map((pose) => concord.times(concord.transposed(pose.A), n));
    const isPlanar = this.samples.every((where) => this.posesAt(where).every((pose, i) =>
      concord.distance(concord.times(pose.A, inBodies[i]), n) < 1e-3 && Math.abs(concord.dot(concord.minus(pose.r, start[i].r), n)) < 1e-3 * this.size));
    if (!isPlanar) return null;
    // A machine that only stands still, or turns about one axis alone, is planar too; a tree of hinges in space is not.
    const pins = this.machine.joints.filter((joint) => joint.type === "revolute");
    return pins.every((joint) => Math.abs(concord.dot(this.axisOf(start, joint.parent, 2), n)) > 0.999) ? n : null;
  }

  /** Of the box of even density with the body's inertia; no larger than a part of the machine. */
  corners(pose, body) {
    const { axes, half } = body.box;
    const shrink = Math.min(1, 0.4 * this.size / Math.max(...half, 1e-300));
    return Array.from({ length: 8 }, (_, k) => {
      const s = [k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1].map((sign, d) => sign * half[d] * shrink);
      return this.inSpace(pose, concord.plus(body.center, concord.times(axes, s)));
    });
  }

  /** Bodies have hues of their own. */
  coloursOf(i) {
    const isDark = document.documentElement.dataset.theme === "dark";
    const hue = [212, 32, 130, 285, 55, 178, 340][(i - 1) % 7];
    return { face: `hsl(${hue} ${isDark ? "30% 42%" : "42% 76%"})`, edge: concord.colour("--one") };
  }

  draw(painter, bodies, chosen) {
    this.drawRoad(painter, bodies);
    this.machine.bodies.forEach((body, i) => { if (i > 0) this.drawBody(painter, bodies, body, i); });
    this.machine.elements.forEach((item) => this.drawElement(painter, bodies, item));
    this.machine.joints.forEach((joint, k) => this.drawJoint(painter, bodies, joint, k, chosen && chosen.kind === "joint" && chosen.owner === k));
    painter.flush();
  }

  drawBody(painter, bodies, body, i) {
    const colours = this.coloursOf(i);
    const shape = this.shapes[i];
    const pose = bodies[i];
    if (shape.beam) {
      painter.rod(this.alongNodes(pose, shape.beam), this.width, colours);
      shape.arms.forEach((arm) => painter.rod(this.alongNodes(pose, arm), 0.6 * this.width, colours));
      return;
    }
    if (shape.box) this.drawBox(painter, this.corners(pose, body), colours);
    const points = this.cornersOf(pose, shape);
    if (points.length === 3) painter.face(points, colours, -this.width);
    this.rodsBetween(points).forEach((rod) => painter.rod(rod, (points.length > 2 ? 0.8 : 1) * this.width, colours));
    if (shape.bob) painter.ball(points[points.length - 1], 1.6 * this.width, colours, this.width);
    this.tires.filter((tire) => tire.child.body === i).forEach((tire) => {
      painter.disc(this.pointOf(bodies, tire.child), this.axisOf(bodies, tire.child, 1), tire.radius, 0.2 * tire.radius, this.axisOf(bodies, tire.child, 0), colours);
    });
  }

  cornersOf(pose, shape) { return shape.points.map((p) => this.inSpace(pose, this.deformed(pose, p.point, p.modes))); }

  /** A rod, the sides of a triangle, or a star. */
  rodsBetween(points) {
    if (points.length < 2) return [];
    if (points.length === 2) return [points];
    if (points.length === 3) return points.map((p, k) => [p, points[(k + 1) % 3]]);
    const middle = concord.scaled(1 / points.length, points.reduce(concord.plus));
    return points.map((p) => [middle, p]);
  }

  alongNodes(pose, nodes) { return nodes.map((p) => this.inSpace(pose, this.deformed(pose, p.point, p.modes))); }

  drawBox(painter, corners, colours) {
    for (const f of [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]) {
      painter.face(f.map((k) => corners[k]), colours);
    }
  }

  /** The other solver's bodies as dashed lines over the first one's. */
  drawOver(painter, bodies, colour) {
    this.machine.bodies.forEach((body, i) => {
      if (i === 0) return;
      const shape = this.shapes[i];
      const lines = shape.beam ? [this.alongNodes(bodies[i], shape.beam)] : this.rodsBetween(this.cornersOf(bodies[i], shape));
      lines.forEach((points) => painter.line(points, colour, 1.4, [5, 5]));
      if (shape.box) { const c = this.corners(bodies[i], body); painter.line([0, 1, 3, 2, 0, 4, 5, 7, 6, 4].map((k) => c[k]), colour, 1.2, [5, 5]); }
    });
  }

  drawElement(painter, bodies, item) {
    const colour = concord.colour("--open");
    const ends = [item.parent, item.child].filter(Boolean).map((end) => this.pointOf(bodies, end));
    if (item.type === "line_spring") painter.coil(ends[0], ends[1], 0.7 * this.width, colour);
    else if (item.type === "turn_spring") painter.spiral(ends[0], this.axisOf(bodies, item.parent, 2), 2.2 * this.width, colour);
    else if (item.type === "bushing") painter.ball(ends[1], 1.1 * this.width, { face: "transparent", edge: colour }, 2 * this.width, 6);
    if (item.type === "line_spring" && item.parent.body * item.child.body === 0) {
      painter.add([ends[item.parent.body === 0 ? 0 : 1]], 0, () => painter.stand(ends[item.parent.body === 0 ? 0 : 1], concord.colour("--quiet")));
    }
  }

  /** Pins as short bars along their axes, balls, slides with what they slide along, squares that weld, crosses. */
  drawJoint(painter, bodies, joint, k, isChosen) {
    const edge = concord.colour(isChosen ? "--bad" : "--joint");
    const colours = { face: concord.colour("--paper"), edge };
    const [from, at] = [this.pointOf(bodies, joint.parent), this.pointOf(bodies, joint.child)];
    const near = 2 * this.width;
    const bar = (end, axis) => painter.rod([-1, 1].map((s) => concord.plus(at, concord.scaled(s * 1.5 * this.width, this.axisOf(bodies, end, axis)))), 0.8 * this.width, colours, near);
    const ground = joint.parent.body === 0 ? from : joint.child.body === 0 ? at : null;
    if (this.slides.test(joint.type)) { this.drawSlide(painter, bodies, joint, this.travels[k], colours); return; }
    if (ground && joint.type !== "free") painter.add([ground], -near, () => painter.stand(ground, concord.colour("--quiet")));
    if (concord.distance(from, at) > this.width && joint.type !== "free") painter.rod([from, at], 0.5 * this.width, colours);
    if (/revolute|screw/.test(joint.type)) bar(joint.child, 2);
    else if (/universal/.test(joint.type)) { bar(joint.parent, 0); bar(joint.child, 1); }
    else if (joint.type === "weld") painter.rod([at, concord.plus(at, concord.scaled(0.01 * this.width, this.axisOf(bodies, joint.child, 0)))], 1.2 * this.width, colours, near);
    else if (joint.type !== "free") painter.ball(at, 0.7 * this.width, colours, near);
  }

  /** A sleeve on its guide; between two bodies that move, a cylinder with its piston rod. */
  drawSlide(painter, bodies, joint, travel, colours) {
    const isTurned = joint.child.body === 0;
    const guide = isTurned ? joint.child : joint.parent;
    const [base, rider] = [this.pointOf(bodies, guide), this.pointOf(bodies, isTurned ? joint.parent : joint.child)];
    const z = concord.scaled(isTurned ? -1 : 1, this.axisOf(bodies, guide, 2));
    const along = (s) => concord.plus(base, concord.scaled(s, z));
    const block = 2.2 * this.width;
    if (guide.body === 0) {
      const ends = [along(travel.least - 1.6 * block), along(travel.most + 1.6 * block)];
      painter.add(ends, -2 * this.width, () => {
        painter.line(ends, concord.colour("--quiet"), 1.2);
        painter.hatch(painter.place(ends[0]), painter.place(ends[1]), concord.colour("--quiet"));
      });
      painter.rod([-1, 1].map((s) => concord.plus(rider, concord.scaled(0.6 * s * block, z))), 1.9 * this.width, { face: this.coloursOf(isTurned ? joint.parent.body : joint.child.body).face, edge: colours.edge }, this.width);
      return;
    }
    const closest = travel.least > 0 ? travel.least : travel.most < 0 ? travel.most : 0;
    if (Math.abs(closest) < 1.5 * block) {
      painter.rod([-1, 1].map((s) => concord.plus(rider, concord.scaled(0.6 * s * block, z))), 1.9 * this.width, colours, this.width);
      return;
    }
    painter.rod([base, rider], 0.5 * this.width, { face: this.coloursOf(joint.child.body).face, edge: colours.edge });
    painter.rod([base, along(0.9 * closest)], 1.5 * this.width, { face: this.coloursOf(guide.body).face, edge: colours.edge }, this.width);
  }

  /** A strip below the wheels; level beyond the profile's ends. */
  drawRoad(painter, bodies) {
    const tires = this.tires.filter((tire) => tire.road);
    if (tires.length === 0) return;
    const profile = tires[0].road;
    const radius = Math.max(...tires.map((tire) => tire.radius));
    const centres = tires.map((tire) => this.pointOf(bodies, tire.child));
    const [least, most] = [Math.min(...centres.map((c) => c[0])) - 2.5 * radius, Math.max(...centres.map((c) => c[0])) + 2.5 * radius];
    const sides = [Math.min(...centres.map((c) => c[1])) - radius, Math.max(...centres.map((c) => c[1])) + radius];
    const height = (x) => {
      const after = profile.findIndex((p) => p[0] > x);
      if (after === 0) return profile[0][1];
      if (after < 0) return profile[profile.length - 1][1];
      const [[x0, h0], [x1, h1]] = [profile[after - 1], profile[after]];
      return h0 + (h1 - h0) * (x - x0) / (x1 - x0);
    };
    const xs = [least, ...profile.map((p) => p[0]).filter((x) => x > least && x < most), most];
    const [left, right] = sides.map((y) => xs.map((x) => [x, y, height(x)]));
    painter.trace([...left, ...right.reverse()], true);
    painter.pen.fillStyle = concord.colour("--body");
    painter.pen.fill();
    painter.stroke(concord.colour("--quiet"), 1.2);
  }
};

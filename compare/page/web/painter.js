"use strict";
// Shapes in space on a canvas: what is farther away is drawn first. Places are in metres of the machine's space; widths
// are in metres, too, unless they are lines.
concord.Painter = class {
  constructor(pen) {
    this.pen = pen;
    this.pieces = [];
  }

  /** Looks along -toward; `scale` pixels a metre, `centre` in the middle of the picture. */
  aim({ right, above, toward }, centre, scale, width, height) {
    Object.assign(this, { right, above, toward, centre, scale, width, height });
  }

  place(point) {
    const from = concord.minus(point, this.centre);
    return [this.width / 2 + this.scale * concord.dot(from, this.right), this.height / 2 - this.scale * concord.dot(from, this.above)];
  }

  depth(points) {
    return points.reduce((sum, p) => sum + concord.dot(concord.minus(p, this.centre), this.toward), 0) / points.length;
  }

  /** Remembers what is to be drawn; `nearer` than its points lie, in metres. */
  add(points, nearer, paint) { this.pieces.push({ depth: this.depth(points) + nearer, paint }); }

  flush() {
    this.pieces.sort((a, b) => a.depth - b.depth).forEach((piece) => piece.paint());
    this.pieces = [];
  }

  trace(points, isClosed) {
    this.pen.beginPath();
    points.forEach((point, k) => { const [x, y] = this.place(point); if (k === 0) this.pen.moveTo(x, y); else this.pen.lineTo(x, y); });
    if (isClosed) this.pen.closePath();
    else this.pen.lineTo(this.place(points[points.length - 1])[0] + 0.02, this.place(points[points.length - 1])[1]);  // a dot, of what is seen end on
  }

  stroke(colour, width, dash) {
    Object.assign(this.pen, { strokeStyle: colour, lineWidth: width, lineCap: "round", lineJoin: "round" });
    this.pen.setLineDash(dash || []);
    this.pen.stroke();
    this.pen.setLineDash([]);
  }

  /** A line, at once; its width in pixels. */
  line(points, colour, width, dash) {
    this.trace(points);
    this.stroke(colour, width, dash);
  }

  /** A round bar along points. */
  rod(points, width, { face, edge }, nearer = 0) {
    this.add(points, nearer, () => {
      const thick = Math.max(2, width * this.scale);
      this.line(points, edge, thick + 2);
      this.line(points, face, thick);
    });
  }

  face(points, { face, edge }, nearer = 0) {
    this.add(points, nearer, () => {
      this.trace(points, true);
      this.pen.fillStyle = face;
      this.pen.fill();
      this.stroke(edge, 1);
    });
  }

  /** A ball; its radius in pixels is at least `least`. */
  ball(at, radius, { face, edge }, nearer = 0, least = 3) {
    this.add([at], nearer, () => {
      const [x, y] = this.place(at);
      this.pen.beginPath();
      this.pen.arc(x, y, Math.max(least, radius * this.scale), 0, 2 * Math.PI);
      this.pen.fillStyle = face;
      this.pen.fill();
      this.stroke(edge, 1.4);
    });
  }

  circle(at, axis, radius, count = 36) {
    const [u, v] = concord.across(axis);
    return Array.from({ length: count }, (_, k) => {
      const angle = 2 * Math.PI * k / count;
      return concord.plus(at, concord.plus(concord.scaled(radius * Math.cos(angle), u), concord.scaled(radius * Math.sin(angle), v)));
    });
  }

  /** A wheel: two rims, what lies between them, and a spoke along `mark` that shows how it turns. */
  disc(at, axis, radius, half, mark, colours) {
    const [near, far] = [half, -half].map((side) => concord.plus(at, concord.scaled(side * (concord.dot(axis, this.toward) < 0 ? -1 : 1), axis)));
    const rims = [this.circle(far, axis, radius), this.circle(near, axis, radius)];
    this.add([at], -radius / 2, () => {
      const across = concord.unit(concord.cross(axis, this.toward));  // where the outline leaves the rims
      const side = [[far, 1], [near, 1], [near, -1], [far, -1]].map(([c, s]) => concord.plus(c, concord.scaled(s * radius, across)));
      const paint = (points, isOutlined) => {
        this.trace(points, true);
        this.pen.fillStyle = colours.face;
        this.pen.fill();
        if (isOutlined) this.stroke(colours.edge, 1.2);
      };
      paint(rims[0], true);
      paint(side, false);
      this.line(side.slice(0, 2), colours.edge, 1.2);
      this.line(side.slice(2), colours.edge, 1.2);
      paint(rims[1], true);
      this.line([near, concord.plus(near, concord.scaled(0.8 * radius, mark))], colours.edge, 1.2);
    });
  }

  /** A coil spring between two points. */
  coil(from, to, radius, colour) {
    const way = concord.minus(to, from);
    const axis = concord.unit(way);
    const [u, v] = concord.across(axis);
    const [turns, steps] = [7, 7 * 14];
    const points = [from];
    for (let k = 0; k <= steps; ++k) {
      const share = k / steps;
      const angle = 2 * Math.PI * turns * share;
      const off = concord.plus(concord.scaled(radius * Math.cos(angle), u), concord.scaled(radius * Math.sin(angle), v));
      points.push(concord.plus(concord.plus(from, concord.scaled(0.12 + 0.76 * share, way)), off));
    }
    points.push(to);
    this.add([from, to], 0, () => this.line(points, colour, 1.4));
  }

  /** A spiral spring about an axis. */
  spiral(at, axis, radius, colour) {
    const [u, v] = concord.across(axis);
    const points = Array.from({ length: 61 }, (_, k) => {
      const angle = 2 * Math.PI * 3 * k / 60;
      const r = radius * (0.25 + 0.75 * k / 60);
      return concord.plus(at, concord.plus(concord.scaled(r * Math.cos(angle), u), concord.scaled(r * Math.sin(angle), v)));
    });
    this.add([at], 0, () => this.line(points, colour, 1.4));
  }

  arrow(from, vector, colour, width) {
    const to = concord.plus(from, vector);
    this.line([from, to], colour, width);
    const [[x0, y0], [x1, y1]] = [this.place(from), this.place(to)];
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

  /** Ground below a point: a stand on hatching. */
  stand(at, colour) {
    const [x, y] = this.place(at);
    this.pen.beginPath();
    this.pen.moveTo(x - 9, y + 14);
    this.pen.lineTo(x, y);
    this.pen.lineTo(x + 9, y + 14);
    this.stroke(colour, 1.2);
    this.hatch([x - 13, y + 14], [x + 13, y + 14], colour);
  }

  /** Ground beneath a line on the screen. */
  hatch([x0, y0], [x1, y1], colour) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length < 1) return;
    const [u, v] = x1 < x0 ? [(x0 - x1) / length, (y0 - y1) / length] : [(x1 - x0) / length, (y1 - y0) / length];
    const [x, y] = x1 < x0 ? [x1, y1] : [x0, y0];
    this.pen.beginPath();
    this.pen.moveTo(x, y);
    this.pen.lineTo(x + length * u, y + length * v);
    for (let s = 5; s <= length; s += 6) {
      this.pen.moveTo(x + s * u, y + s * v);
      this.pen.lineTo(x + (s - 5) * u - 5 * v, y + (s - 5) * v + 5 * u);
    }
    this.stroke(colour, 1.1);
  }
};

// Many points above the axes of uPlot: painted dot by dot into the pixels of its canvas, some 10⁷ dots a second, and what lies above
// them.

// Where a point is that is not in the plot, and pixels around it that dots at its edge reach.
const OUT = -1e6;
const PAD = 16;

class Cloud {
  constructor() {
    // A chart of uPlot, and what it shows: see Scatter.show.
    this.chart = null;
    this.state = null;
    // What is selected, in the values of the axes.
    this.box = null;
    // Rows: at which the keyboard stands, and the one shown as a design.
    this.near = -1;
    this.pinned = -1;
  }

  // After uPlot has drawn all of its own: the places of the points, and its grid as pixels on which dots are blended.
  drawn() {
    const { ctx, bbox, width } = this.chart;
    this.ratio = ctx.canvas.width / width;
    this.place();
    this.pale = null;
    this.back = null;
    if (!onPaper) {
      const [left, top] = [Math.round(bbox.left) - PAD, Math.round(bbox.top) - PAD];
      const copy = new OffscreenCanvas(Math.round(bbox.width) + 2 * PAD, Math.round(bbox.height) + 2 * PAD);
      const c = copy.getContext("2d", { willReadFrequently: true });
      c.fillStyle = themeColor("--card");
      c.fillRect(0, 0, copy.width, copy.height);
      c.drawImage(ctx.canvas, -left, -top);
      this.back = c.getImageData(0, 0, copy.width, copy.height);
      this.pixels = new ImageData(copy.width, copy.height);
    }
    this.paint();
  }

  // In pixels of the page, from the corner of the plot; what is outside is far away.
  place() {
    const { x: { values: x }, y: { values: y } } = this.state;
    const n = x.length;
    if (!this.px || this.px.length !== n) {
      this.px = new Float32Array(n);
      this.py = new Float32Array(n);
      this.order = mixedOrder(n);
    }
    const [atX, atY] = [this.at("x"), this.at("y")];
    const [width, height] = [this.chart.bbox.width / this.ratio, this.chart.bbox.height / this.ratio];
    for (let i = 0; i < n; i += 1) {
      const a = atX(x[i]);
      const b = atY(y[i]);
      const inside = a >= -1 && a <= width + 1 && b >= -1 && b <= height + 1;
      this.px[i] = inside ? a : OUT;
      this.py[i] = inside ? b : OUT;
    }
  }
  at(axis) {
    return (value) => this.chart.valToPos(value, axis);
  }

  // The dots, unless they are as they were, and what lies above.
  paint(dots = true) {
    if (!this.chart || !this.px) return;
    const { ctx: c, bbox } = this.chart;
    const [left, top, width, height] = [bbox.left, bbox.top, bbox.width, bbox.height].map(Math.round);
    if (this.back) {
      if (dots) this.paintDots();
      c.putImageData(this.pixels, left - PAD, top - PAD, PAD, PAD, width, height);
    }
    c.save();
    c.beginPath();
    c.rect(left, top, width, height);
    c.clip();
    c.translate(left, top);
    c.scale(this.ratio, this.ratio);
    if (!this.back) this.paintForPaper(c);
    const ink = themeColor("--ink");
    this.paintNyquist(c);
    if (this.state.front.length > 0) this.paintFront(c, ink);
    this.paintMarks(c, ink);
    for (const [row, wide] of [[this.pinned, 2.5], [this.near, 1.5]]) {
      if (row < 0 || this.px[row] === OUT) continue;
      c.strokeStyle = ink;
      c.lineWidth = wide;
      ring(c, this.px[row], this.py[row], 8);
    }
    c.restore();
  }

  stamp() {
    const { count } = this.state;
    const radius = (count > 30000 ? 1.5 : count > 8000 ? 1.9 : count > 2000 ? 2.4 : count > 300 ? 3.2 : 4.5) * this.ratio;
    return discOf(radius, count > 8000 ? 0.75 : 0.85, this.pixels.width);
  }
  // Dots that are not selected stay as they are while a box is drawn: they are painted once and kept.
  paintPale() {
    if (this.pale || !this.back) return;
    const { order, px, state: { shown } } = this;
    const stamp = this.stamp();
    const color = paleDot();
    this.pale = Uint8Array.from(this.back.data);
    for (const i of order) if (shown[i] && px[i] !== OUT) this.blend(this.pale, stamp, i, color);
  }
  paintDots() {
    const { order, px, state: { selected, color } } = this;
    const stamp = this.stamp();
    const bytes = new Uint8Array(this.pixels.data.buffer);
    if (this.box) this.paintPale();
    bytes.set(this.box ? this.pale : this.back.data);
    for (const i of order) if (selected[i] && px[i] !== OUT) this.blend(bytes, stamp, i, color.table[color.codes[i]]);
  }

  blend(bytes, stamp, i, rgb) {
    const { ratio, px, py } = this;
    const [r, g, b] = rgb;
    const at = 4 * ((Math.round(py[i] * ratio) + PAD) * this.pixels.width + Math.round(px[i] * ratio) + PAD);
    for (let k = 0; k < stamp.length; k += 2) {
      const p = at + stamp[k];
      const a = stamp[k + 1];
      bytes[p] += ((r - bytes[p]) * a) >> 8;
      bytes[p + 1] += ((g - bytes[p + 1]) * a) >> 8;
      bytes[p + 2] += ((b - bytes[p + 2]) * a) >> 8;
    }
  }

  // For paper, browsers take what is drawn while they ask for it, as few shapes.
  paintForPaper(c) {
    const { shown, selected, color, count } = this.state;
    const size = count > 8000 ? 2 : count > 300 ? 3.2 : 6;
    const paths = new Map();
    const put = (key, i) => {
      if (!paths.has(key)) paths.set(key, new Path2D());
      paths.get(key).rect(this.px[i] - size / 2, this.py[i] - size / 2, size, size);
    };
    if (this.box) for (const i of this.order) if (shown[i] && !selected[i] && this.px[i] !== OUT) put(css(paleDot()), i);
    for (const i of this.order) if (selected[i] && this.px[i] !== OUT) put(css(color.table[color.codes[i]]), i);
    c.globalAlpha = 0.8;
    for (const [key, path] of paths) {
      c.fillStyle = key;
      c.fill(path, "nonzero");
    }
    c.globalAlpha = 1;
    if (!this.box) return;
    const { left, top, width, height } = this.chart.select;
    c.strokeStyle = themeColor("--accent");
    c.strokeRect(left, top, width, height);
  }

  // Finer detail than the sensor samples lies beyond this line.
  paintNyquist(c) {
    const { nyquist } = this.state;
    const [width, height] = [this.chart.bbox.width / this.ratio, this.chart.bbox.height / this.ratio];
    c.strokeStyle = themeColor("--soft");
    c.fillStyle = themeColor("--soft");
    c.font = FONT;
    c.setLineDash([6, 4]);
    c.beginPath();
    for (const axis of ["x", "y"]) {
      if (!nyquist[axis]) continue;
      const at = this.at(axis)(nyquist[axis]);
      if (axis === "x") {
        line(c, at, 0, at, height);
        c.textAlign = at > width - 70 ? "right" : "left";
        c.fillText("Nyquist", at + (at > width - 70 ? -6 : 6), 12);
      } else {
        line(c, 0, at, width, at);
        c.textAlign = "right";
        c.fillText("Nyquist", width - 6, at > 20 ? at - 6 : at + 14);
      }
    }
    c.stroke();
    c.setLineDash([]);
  }

  // Staircase of the Pareto front; dominated trials lie behind it. Trials beyond the Nyquist frequency are crossed out.
  paintFront(c, ink) {
    const { x, y, front, beyond } = this.state;
    const [atX, atY] = [this.at("x"), this.at("y")];
    const places = front.map((row) => [atX(x.values[row]), atY(y.values[row])]);
    c.strokeStyle = ink;
    c.lineWidth = 1.6;
    c.beginPath();
    places.forEach(([a, b], i) => {
      if (i > 0) c.lineTo(places[i - 1][0], b);
      else c.moveTo(a, b);
      c.lineTo(a, b);
    });
    c.stroke();
    places.forEach(([a, b], i) => {
      ring(c, a, b, 4.6);
      if (!beyond(front[i])) return;
      c.beginPath();
      line(c, a - 7, b - 7, a + 7, b + 7);
      line(c, a - 7, b + 7, a + 7, b - 7);
      c.stroke();
    });
  }

  // Above all dots: large, in the colours of dots, outlined.
  paintMarks(c, ink) {
    const { shown, selected, color, marks } = this.state;
    const card = themeColor("--card");
    const pale = css(paleDot());
    const size = this.chart.width < 500 ? 0.75 : 1;
    marks.forEach(({ rows }, i) => {
      const path = new Path2D(symbolOf(i));
      for (const row of rows) {
        if (!shown[row] || this.px[row] === OUT) continue;
        c.save();
        c.translate(this.px[row], this.py[row]);
        c.scale(size, size);
        c.lineJoin = "round";
        c.strokeStyle = card;
        c.lineWidth = 4.5;
        c.stroke(path);
        c.fillStyle = selected[row] ? css(color.table[color.codes[row]]) : pale;
        c.fill(path);
        c.strokeStyle = ink;
        c.lineWidth = 1.8;
        c.stroke(path);
        c.restore();
      }
    });
  }
}

// Symbols of marks, in the order of those of figures: circle, triangle, star, diamond, triangle on its tip.
const MARK_RADIUS = 8;
function symbolOf(place) {
  const r = MARK_RADIUS;
  const corners = (radii, from) => radii.map((radius, i) => {
    const turn = (2 * Math.PI * (i / radii.length)) + from;
    return `${i ? "L" : "M"}${(radius * Math.sin(turn)).toFixed(2)} ${(-radius * Math.cos(turn)).toFixed(2)}`;
  }).join("") + "Z";
  const star = Array.from({ length: 10 }, (_, i) => (i % 2 ? 0.5 : 1.3) * r);
  return [
    `M${-0.85 * r} 0a${0.85 * r} ${0.85 * r} 0 1 0 ${1.7 * r} 0a${0.85 * r} ${0.85 * r} 0 1 0 ${-1.7 * r} 0Z`,
    corners([1.2 * r, 1.2 * r, 1.2 * r], 0), corners(star, 0), corners([1.15 * r, 1.15 * r, 1.15 * r, 1.15 * r], 0), corners([1.2 * r, 1.2 * r, 1.2 * r], Math.PI),
  ][place % 5];
}

function line(c, x0, y0, x1, y1) {
  c.moveTo(x0, y0);
  c.lineTo(x1, y1);
}
function ring(c, x, y, radius) {
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.stroke();
}
// What is not selected.
function paleDot() {
  return isDark() ? [64, 67, 74] : [214, 216, 220];
}
// A mixed order, the same each time, so that no group hides the rest.
function mixedOrder(n) {
  const order = new Uint32Array(n);
  for (let i = 0; i < n; i += 1) order[i] = i;
  let state = 0x9e3779b9;
  for (let i = n - 1; i > 0; i -= 1) {
    state = Math.imul(state ^ (state >>> 15), 0x85ebca6b) + 0x6d2b79f5 | 0;
    const k = (state >>> 0) % (i + 1);
    [order[i], order[k]] = [order[k], order[i]];
  }
  return order;
}
// The pixels of a disc with soft edges in rows of `wide`: offset in bytes, coverage of 256, one after the other.
function discOf(radius, opacity, wide) {
  const out = [];
  const reach = Math.ceil(radius + 0.5);
  for (let dy = -reach; dy <= reach; dy += 1) {
    for (let dx = -reach; dx <= reach; dx += 1) {
      const a = Math.min(1, Math.max(0, radius + 0.5 - Math.hypot(dx, dy))) * opacity;
      if (a > 0.02) out.push(4 * (dy * wide + dx), Math.round(256 * a));
    }
  }
  return Int32Array.from(out);
}

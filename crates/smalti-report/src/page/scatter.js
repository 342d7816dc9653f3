// A scatter plot of many points: painted dot by dot into the pixels of a canvas, some 10⁷ dots a second.

const MARGIN = { left: 62, right: 16, top: 14, bottom: 50 };

// Symbols of marks, in the order of those of figures: circle, triangle, star, diamond, triangle on its tip.
const MARK_RADIUS = 8;
function symbolOf(place) {
  const r = MARK_RADIUS;
  const ring = (radii, from) => radii.map((radius, i) => {
    const turn = (2 * Math.PI * (i / radii.length)) + from;
    return `${i ? "L" : "M"}${(radius * Math.sin(turn)).toFixed(2)} ${(-radius * Math.cos(turn)).toFixed(2)}`;
  }).join("") + "Z";
  const star = Array.from({ length: 10 }, (_, i) => (i % 2 ? 0.5 : 1.3) * r);
  return [
    `M${-0.85 * r} 0a${0.85 * r} ${0.85 * r} 0 1 0 ${1.7 * r} 0a${0.85 * r} ${0.85 * r} 0 1 0 ${-1.7 * r} 0Z`,
    ring([1.2 * r, 1.2 * r, 1.2 * r], 0), ring(star, 0), ring([1.15 * r, 1.15 * r, 1.15 * r, 1.15 * r], 0), ring([1.2 * r, 1.2 * r, 1.2 * r], Math.PI),
  ][place % 5];
}

class Scatter {
  // `on`: { brush(box or null), point(row, how) }.
  constructor(on) {
    this.on = on;
    this.dots = make("canvas");
    this.over = make("canvas", {
      tabindex: "0", role: "application", "aria-roledescription": "scatter plot", "aria-describedby": "scatter-help",
    });
    this.tip = make("div", { class: "tip", hidden: true });
    this.plane = make("div", { class: "plane" }, this.dots, this.over, this.tip);
    this.legend = make("div", { class: "legend" });
    this.element = make("div", { class: "scatter" }, this.plane, this.legend);
    this.state = null;
    this.box = null;
    // Rows: below the mouse, at which the keyboard stands, and the one shown as a design.
    this.hover = -1;
    this.near = -1;
    this.pinned = -1;
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.plane);
  }

  // `state`: { x, y (columns), log: {x, y}, ends: {x, y}, shown, selected (masks), color: {codes, table}, front (rows), marks
  // ([{rows}], each with a symbol), count }.
  show(state) {
    this.state = state;
    if (this.width) this.redraw();
    else this.resize();
  }

  resize() {
    const { width, height } = this.plane.getBoundingClientRect();
    if (width < 10 || onPaper || (width === this.width && height === this.height)) return;
    this.ratio = Math.min(2, window.devicePixelRatio || 1);
    for (const canvas of [this.dots, this.over]) {
      canvas.width = Math.round(width * this.ratio);
      canvas.height = Math.round(height * this.ratio);
    }
    this.width = width;
    this.height = height;
    this.redraw();
  }

  // Everything anew: axes, places of all points, dots.
  redraw() {
    if (!this.state || !this.width) return;
    const { x, y, log, ends } = this.state;
    this.sx = scaleOf(...ends.x, log.x, MARGIN.left, this.width - MARGIN.right);
    this.sy = scaleOf(...ends.y, log.y, this.height - MARGIN.bottom, MARGIN.top);
    this.place(x.values, y.values);
    this.paintBack();
    this.paintDots();
    this.paintOver();
  }

  place(x, y) {
    const n = x.length;
    if (!this.px || this.px.length !== n) {
      this.px = new Float32Array(n);
      this.py = new Float32Array(n);
      this.order = mixedOrder(n);
    }
    const out = -1e6;
    for (let i = 0; i < n; i += 1) {
      const a = this.sx.at(x[i]);
      const b = this.sy.at(y[i]);
      const inside = a >= MARGIN.left - 1 && a <= this.width - MARGIN.right + 1 && b >= MARGIN.top - 1 && b <= this.height - MARGIN.bottom + 1;
      this.px[i] = inside ? a : out;
      this.py[i] = inside ? b : out;
    }
  }

  // Grid and background, kept as pixels on which dots are blended.
  paintBack() {
    const { width, height } = this.dots;
    const canvas = new OffscreenCanvas(width, height);
    const c = canvas.getContext("2d", { willReadFrequently: true });
    c.scale(this.ratio, this.ratio);
    c.fillStyle = themeColor("--card");
    c.fillRect(0, 0, this.width, this.height);
    c.strokeStyle = themeColor("--faint");
    c.beginPath();
    for (const v of this.ticksX()) line(c, this.sx.at(v), MARGIN.top, this.sx.at(v), this.height - MARGIN.bottom);
    for (const v of this.ticksY()) line(c, MARGIN.left, this.sy.at(v), this.width - MARGIN.right, this.sy.at(v));
    c.stroke();
    this.back = c.getImageData(0, 0, width, height);
    this.pixels = new ImageData(width, height);
    this.pixels.data.set(this.back.data);
    this.pale = null;
  }
  ticksX() { return ticksOf(this.sx, Math.max(3, this.width / 90)); }
  ticksY() { return ticksOf(this.sy, Math.max(3, this.height / 50)); }

  // Dots that are not selected stay as they are while a box is drawn: they are painted once and kept.
  paintDots() {
    const { shown, selected, color, count } = this.state;
    const radius = (count > 30000 ? 1.5 : count > 8000 ? 1.9 : count > 2000 ? 2.4 : count > 300 ? 3.2 : 4.5) * this.ratio;
    const stamp = discOf(radius, count > 8000 ? 0.75 : 0.85, this.pixels.width);
    const { order, px } = this;
    const bytes = new Uint8Array(this.pixels.data.buffer);
    if (this.box) {
      if (!this.pale) {
        this.pale = Uint8Array.from(this.back.data);
        const pale = paleDot();
        for (const i of order) if (shown[i] && px[i] > 0) this.blend(this.pale, stamp, i, pale);
      }
      bytes.set(this.pale);
    } else bytes.set(this.back.data);
    for (const i of order) if (selected[i] && px[i] > 0) this.blend(bytes, stamp, i, color.table[color.codes[i]]);
    this.dots.getContext("2d").putImageData(this.pixels, 0, 0);
  }

  // For paper, browsers take what is drawn while they ask for it, as few shapes; and one canvas hides the one below.
  paintForPaper(c) {
    const { shown, selected, color, count } = this.state;
    const size = count > 8000 ? 2 : count > 300 ? 3.2 : 6;
    const paths = new Map();
    const put = (key, i) => {
      if (!paths.has(key)) paths.set(key, new Path2D());
      paths.get(key).rect(this.px[i] - size / 2, this.py[i] - size / 2, size, size);
    };
    if (this.box) for (const i of this.order) if (shown[i] && !selected[i] && this.px[i] > 0) put(css(paleDot()), i);
    for (const i of this.order) if (selected[i] && this.px[i] > 0) put(css(color.table[color.codes[i]]), i);
    c.strokeStyle = themeColor("--faint");
    c.strokeRect(MARGIN.left, MARGIN.top, this.width - MARGIN.left - MARGIN.right, this.height - MARGIN.top - MARGIN.bottom);
    c.globalAlpha = 0.8;
    for (const [key, path] of paths) {
      c.fillStyle = key;
      c.fill(path, "nonzero");
    }
    c.globalAlpha = 1;
  }

  blend(bytes, stamp, i, rgb) {
    const { ratio, px, py } = this;
    const [r, g, b] = rgb;
    const at = 4 * (Math.round(py[i] * ratio) * this.pixels.width + Math.round(px[i] * ratio));
    for (let k = 0; k < stamp.length; k += 2) {
      const p = at + stamp[k];
      const a = stamp[k + 1];
      bytes[p] += ((r - bytes[p]) * a) >> 8;
      bytes[p + 1] += ((g - bytes[p + 1]) * a) >> 8;
      bytes[p + 2] += ((b - bytes[p + 2]) * a) >> 8;
    }
  }

  paintOver() {
    if (!this.sx) return;
    const c = this.over.getContext("2d");
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    if (onPaper) this.paintForPaper(c);
    const [ink, soft, accent] = ["--ink", "--soft", "--accent"].map(themeColor);
    const { x, y, front } = this.state;
    const bottom = this.height - MARGIN.bottom;
    c.font = "12px system-ui, sans-serif";
    c.fillStyle = soft;
    c.textAlign = "center";
    for (const v of this.ticksX()) c.fillText(tickText(v), this.sx.at(v), bottom + 18);
    c.textAlign = "right";
    for (const v of this.ticksY()) c.fillText(tickText(v), MARGIN.left - 8, this.sy.at(v) + 4);
    c.fillStyle = ink;
    c.font = "600 13px system-ui, sans-serif";
    c.textAlign = "center";
    c.fillText(withUnit(x) + hint(x, "x"), (MARGIN.left + this.width - MARGIN.right) / 2, bottom + 40);
    c.save();
    c.translate(16, (MARGIN.top + bottom) / 2);
    c.rotate(-Math.PI / 2);
    c.fillText(withUnit(y) + hint(y, "y"), 0, 0);
    c.restore();
    c.save();
    c.beginPath();
    c.rect(MARGIN.left, MARGIN.top, this.width - MARGIN.left - MARGIN.right, bottom - MARGIN.top);
    c.clip();
    if (front.length > 0) this.paintFront(c, front, ink);
    this.paintMarks(c, ink);
    if (this.box) {
      const [a, b, w, h] = this.boxPixels();
      c.fillStyle = accent;
      c.globalAlpha = 0.1;
      c.fillRect(a, b, w, h);
      c.globalAlpha = 1;
      c.strokeStyle = accent;
      c.lineWidth = 1.5;
      c.strokeRect(a, b, w, h);
    }
    for (const [row, width] of [[this.pinned, 2.5], [this.near, 1.5], [this.hover, 1.5]]) {
      if (row < 0 || this.px[row] < 0) continue;
      c.strokeStyle = ink;
      c.lineWidth = width;
      c.beginPath();
      c.arc(this.px[row], this.py[row], 8, 0, 2 * Math.PI);
      c.stroke();
    }
    c.restore();
  }

  // Steps between the points of the front: what it beats lies behind them.
  paintFront(c, front, ink) {
    const { x, y } = this.state;
    c.strokeStyle = ink;
    c.lineWidth = 1.6;
    c.beginPath();
    front.forEach((row, i) => {
      const [a, b] = [this.sx.at(x.values[row]), this.sy.at(y.values[row])];
      if (i > 0) c.lineTo(this.sx.at(x.values[front[i - 1]]), b);
      if (i === 0) c.moveTo(a, b);
      c.lineTo(a, b);
    });
    c.stroke();
    for (const row of front) {
      c.beginPath();
      c.arc(this.sx.at(x.values[row]), this.sy.at(y.values[row]), 4.6, 0, 2 * Math.PI);
      c.stroke();
    }
  }

  // Above all dots: large, in the colours of dots, outlined.
  paintMarks(c, ink) {
    const { shown, selected, color, marks } = this.state;
    const card = themeColor("--card");
    const pale = css(paleDot());
    const size = this.width < 500 ? 0.75 : 1;
    marks.forEach(({ rows }, i) => {
      const path = new Path2D(symbolOf(i));
      for (const row of rows) {
        if (!shown[row] || this.px[row] < 0) continue;
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

  boxPixels() {
    const [x0, x1] = this.box.x.map(this.sx.at);
    const [y1, y0] = this.box.y.map(this.sy.at);
    return [x0, y0, x1 - x0, y1 - y0];
  }
  setBox(box) {
    this.box = box;
    this.on.brush(box);
  }
  setPinned(row) {
    this.pinned = row;
    this.paintOver();
  }

  nearest(x, y, reach) {
    let best = -1;
    let least = reach * reach;
    const { shown, marks } = this.state;
    // A mark covers the dots below it.
    let under = MARK_RADIUS * MARK_RADIUS;
    for (const { rows } of marks) {
      for (const row of rows) {
        if (!shown[row]) continue;
        const d = (this.px[row] - x) ** 2 + (this.py[row] - y) ** 2;
        if (d <= under) {
          under = d;
          best = row;
        }
      }
    }
    if (best >= 0) return best;
    for (let i = 0; i < this.px.length; i += 1) {
      if (!shown[i] || this.px[i] < 0) continue;
      const d = (this.px[i] - x) ** 2 + (this.py[i] - y) ** 2;
      if (d < least) {
        least = d;
        best = i;
      }
    }
    return best;
  }

  // The next point in a direction: near, and rather ahead than aside.
  ahead(from, dx, dy) {
    let best = -1;
    let least = Infinity;
    const { selected } = this.state;
    for (let i = 0; i < this.px.length; i += 1) {
      if (!selected[i] || this.px[i] < 0 || i === from) continue;
      const [a, b] = [this.px[i] - this.px[from], this.py[i] - this.py[from]];
      const along = a * dx + b * dy;
      const aside = Math.abs(a * dy - b * dx);
      if (along <= 0.5 || aside > 2 * along) continue;
      const d = along + 2 * aside;
      if (d < least) {
        least = d;
        best = i;
      }
    }
    return best;
  }

  walk(row) {
    if (row < 0) return;
    this.near = row;
    this.paintOver();
    this.tell(row);
    this.on.point(row, "walk");
  }

  tell(row) {
    this.tip.hidden = row < 0;
    if (row < 0) return;
    this.tip.textContent = this.state.words(row);
    const left = this.px[row] + (this.px[row] > this.width / 2 ? -this.tip.offsetWidth - 14 : 14);
    this.tip.style.left = `${left}px`;
    this.tip.style.top = `${Math.max(4, this.py[row] - this.tip.offsetHeight / 2)}px`;
  }

  listen() {
    const at = (event) => {
      const r = this.over.getBoundingClientRect();
      return [event.clientX - r.left, event.clientY - r.top];
    };
    let from = null;
    let last = null;
    let asked = false;
    this.over.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      from = at(event);
      this.over.setPointerCapture(event.pointerId);
    });
    this.over.addEventListener("pointermove", (event) => {
      last = at(event);
      if (asked) return;
      asked = true;
      requestAnimationFrame(() => {
        asked = false;
        if (!this.state) return;
        if (from && this.dragged(from, last)) {
          this.hover = -1;
          this.tell(-1);
          this.setBox(this.boxOf(from, last));
        } else if (!from && last) {
          this.hover = this.nearest(...last, 18);
          this.tell(this.hover >= 0 ? this.hover : this.near);
          this.paintOver();
        }
      });
    });
    this.over.addEventListener("pointerup", (event) => {
      if (!from) return;
      const to = at(event);
      if (this.dragged(from, to)) this.setBox(this.boxOf(from, to));
      else {
        const row = this.nearest(...to, 24);
        if (row >= 0) this.on.point(row, "choose");
        else if (this.box) this.setBox(null);
      }
      from = null;
    });
    this.over.addEventListener("pointercancel", () => { from = null; });
    this.over.addEventListener("pointerleave", () => {
      last = null;
      this.hover = -1;
      this.tell(this.near);
      if (this.state) this.paintOver();
    });
    this.over.addEventListener("blur", () => {
      this.near = -1;
      this.tell(-1);
      this.paintOver();
    });
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    this.over.addEventListener("keydown", (event) => {
      if (!this.state || event.ctrlKey || event.altKey || event.metaKey) return;
      const start = this.near >= 0 ? this.near : this.pinned;
      const inView = start >= 0 && this.px[start] > 0;
      if (arrows[event.key]) {
        this.walk(inView ? this.ahead(start, ...arrows[event.key]) : this.nearest(this.width / 2, this.height / 2, Infinity));
      } else if (event.key === "Home") this.walk(this.state.front[0] ?? -1);
      else if (event.key === "End") this.walk(this.state.front.at(-1) ?? -1);
      else if ((event.key === "Enter" || event.key === " ") && this.near >= 0) this.on.point(this.near, "choose");
      else if (event.key === "Escape") this.setBox(null);
      else return;
      event.preventDefault();
    });
  }
  dragged([a, b], [c, d]) {
    return Math.abs(a - c) > 4 || Math.abs(b - d) > 4;
  }
  boxOf([a, b], [c, d]) {
    const within = (p, low, high) => Math.min(high, Math.max(low, p));
    const xs = [a, c].map((p) => this.sx.value(within(p, MARGIN.left, this.width - MARGIN.right)));
    const ys = [b, d].map((p) => this.sy.value(within(p, MARGIN.top, this.height - MARGIN.bottom)));
    return { x: [Math.min(...xs), Math.max(...xs)], y: [Math.min(...ys), Math.max(...ys)] };
  }
}

function line(c, x0, y0, x1, y1) {
  c.moveTo(x0, y0);
  c.lineTo(x1, y1);
}
// What is not selected.
function paleDot() {
  return isDark() ? [64, 67, 74] : [214, 216, 220];
}
function hint(column, axis) {
  if (!column.better) return "";
  const up = column.better === "higher";
  return axis === "x" ? (up ? "  (better →)" : "  (← better)") : up ? "  (better →)" : "  (← better)";
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
// Rows that no other kept row beats in both columns, by rising x; none where a column has no better end.
function frontOf(x, y, keep) {
  if (!x.better || !y.better || x === y) return [];
  const [sx, sy] = [x, y].map((c) => (c.better === "higher" ? -1 : 1));
  const rows = [];
  for (let i = 0; i < keep.length; i += 1) if (keep[i] && Number.isFinite(x.values[i]) && Number.isFinite(y.values[i])) rows.push(i);
  rows.sort((a, b) => sx * (x.values[a] - x.values[b]) || sy * (y.values[a] - y.values[b]));
  const front = [];
  let best = Infinity;
  for (const row of rows) {
    const v = sy * y.values[row];
    if (v < best) {
      best = v;
      front.push(row);
    }
  }
  return front.sort((a, b) => x.values[a] - x.values[b]);
}

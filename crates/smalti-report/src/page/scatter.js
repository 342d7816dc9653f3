// A scatter plot of many points. Axes, sizes, pointer and rectangle are uPlot's; dots are painted by cloud.js. The nearest point, the
// walk by keys and fingers are what is left.

class Scatter extends Cloud {
  // `on`: { brush(box or null), point(row, how) }.
  constructor(on) {
    super();
    this.on = on;
    this.tip = make("div", { class: "tip", hidden: true });
    this.plane = make("div", { class: "plane" });
    this.legend = make("div", { class: "legend" });
    this.element = make("div", { class: "scatter" }, this.plane, this.legend);
    this.words = "";
    // The row below the pointer.
    this.hover = -1;
    new ResizeObserver(() => {
      const size = sizeOf(this.plane);
      if (!this.chart && this.state) this.show(this.state);
      else if (this.chart && size && (size.width !== this.chart.width || size.height !== this.chart.height)) {
        this.chart.batch(() => this.chart.setSize(size));
      }
    }).observe(this.plane);
  }

  // `state`: { x, y (columns), log: {x, y}, ends: {x, y}, shown, selected (masks), color: {codes, table}, front (rows), beyond(row),
  // nyquist: {x, y}, marks ([{rows}], each with a symbol), words(row), count }.
  show(state) {
    this.state = state;
    const { x, y, log } = state;
    const kind = [x.name, y.name, log.x, log.y].join();
    if (this.chart && kind === this.kind) {
      this.chart.batch((u) => {
        for (const axis of ["x", "y"]) u.setScale(axis, { min: state.ends[axis][0], max: state.ends[axis][1] });
      });
    } else this.build(kind);
    this.showBox();
  }

  build(kind) {
    const size = sizeOf(this.plane);
    if (!size) return;
    this.chart?.destroy();
    this.kind = kind;
    const { x, y, log } = this.state;
    const scale = (axis) => ({ time: false, auto: false, distr: log[axis] ? 3 : 1, range: () => this.state.ends[axis] });
    const axis = (which, side) => axisOf({
      scale: which, side, label: (u) => labelOf(u, which, this.state[which], log[which]), labelSize: 24, labelGap: 2, size: widthOf(side), splits: log[which] ? decades : null,
      space: side === 2 ? 64 : 36, font: FONT, labelFont: `600 13px ${FONT_FAMILY}`,
    });
    const press = (down) => (u, target, handle) => (event) => {
      if (event.button !== 0) return;
      this.pressed = down;
      if (down) this.paintPale();
      handle(event);
      // A click that trembles takes uPlot's rectangle away.
      if (!down) this.showBox();
    };
    this.chart = new uPlot({
      ...size, mode: 2, padding: [14, 16, 2, 4], legend: { show: false }, scales: { x: scale("x"), y: scale("y") }, axes: [axis("x", 2), axis("y", 3)],
      series: [null, { auto: false, facets: [{ scale: "x" }, { scale: "y" }], paths: () => null, points: { show: false } }],
      cursor: {
        x: false, y: false, drag: { x: true, y: true, setScale: false, dist: 4 }, bind: { mousedown: press(true), mouseup: press(false), dblclick: () => null },
        points: { size: 18, width: 1.5, stroke: "var(--ink)", fill: "transparent" }, dataIdx: (u) => this.below(u),
      },
      hooks: { draw: [() => this.drawn()], setCursor: [() => this.moved()], setSelect: [() => this.brushed()], setSize: [() => this.showBox()] },
    }, [null, [x.values, y.values]], this.plane);
    this.over = this.chart.over;
    fill(this.over, {
      tabindex: "0", role: "application", "aria-roledescription": "scatter plot", "aria-describedby": "scatter-help", "aria-label": this.words,
    }, [this.tip]);
    this.listen(this.over);
    this.chart.batch(() => {});
  }

  name(words) {
    this.words = words;
    this.over?.setAttribute("aria-label", words);
  }

  setBox(box) {
    this.box = box;
    this.showBox();
    this.on.brush(box);
  }
  showBox() {
    if (!this.chart) return;
    const none = { left: 0, top: 0, width: 0, height: 0 };
    if (!this.box) return this.chart.setSelect(none, false);
    const within = (p, most) => Math.min(most, Math.max(0, p));
    const [x0, x1] = this.box.x.map((v) => within(this.at("x")(v), this.over.clientWidth));
    const [y1, y0] = this.box.y.map((v) => within(this.at("y")(v), this.over.clientHeight));
    this.chart.setSelect({ left: x0, top: y0, width: x1 - x0, height: y1 - y0 }, false);
  }
  setPinned(row) {
    this.pinned = row;
    this.paint(false);
  }

  // What uPlot's rectangle encloses now; it may move several times a frame.
  brushed() {
    const { left, top, width, height } = this.chart.select;
    if (width === 0 && height === 0) return;
    const value = (axis, p) => this.chart.posToVal(p, axis);
    this.box = { x: [value("x", left), value("x", left + width)], y: [value("y", top + height), value("y", top)] };
    this.on.brush(this.box);
  }
  moved() {
    if (this.isDragged()) {
      this.tell(-1);
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => {
        this.asked = false;
        if (this.isDragged()) this.brushed();
      });
    } else this.tell(this.chart.cursor.left >= 0 && this.hover >= 0 ? this.hover : this.near);
  }
  // Before the first drag, uPlot's own mark of one is set.
  isDragged() {
    const { drag } = this.chart.cursor;
    return this.pressed && (drag._x || drag._y);
  }
  below({ cursor: { left, top } }) {
    this.hover = this.isDragged() ? -1 : this.nearest(left, top, 18);
    return this.hover < 0 ? null : this.hover;
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
      if (!shown[i] || this.px[i] === OUT) continue;
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
      if (!selected[i] || this.px[i] === OUT || i === from) continue;
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
    this.paint(false);
    this.tell(row);
    this.on.point(row, "walk");
  }

  tell(row) {
    this.tip.hidden = row < 0;
    if (row < 0) return;
    this.tip.textContent = this.state.words(row);
    const left = this.px[row] + (this.px[row] > this.over.clientWidth / 2 ? -this.tip.offsetWidth - 14 : 14);
    this.tip.style.left = `${left}px`;
    this.tip.style.top = `${Math.max(4, this.py[row] - this.tip.offsetHeight / 2)}px`;
  }

  listen(over) {
    over.addEventListener("click", (event) => {
      const row = this.nearest(event.offsetX, event.offsetY, 24);
      if (row >= 0) this.on.point(row, "choose");
      else if (this.box) this.setBox(null);
    });
    over.addEventListener("blur", () => {
      this.near = -1;
      this.tell(-1);
      this.paint(false);
    });
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    over.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const start = this.near >= 0 ? this.near : this.pinned;
      const inView = start >= 0 && this.px[start] !== OUT;
      if (arrows[event.key]) {
        this.walk(inView ? this.ahead(start, ...arrows[event.key]) : this.nearest(over.clientWidth / 2, over.clientHeight / 2, Infinity));
      } else if (event.key === "Home") this.walk(this.state.front[0] ?? -1);
      else if (event.key === "End") this.walk(this.state.front.at(-1) ?? -1);
      else if ((event.key === "Enter" || event.key === " ") && this.near >= 0) this.on.point(this.near, "choose");
      else if (event.key === "Escape") this.setBox(null);
      else return;
      event.preventDefault();
    });
    // uPlot knows the mouse alone: a finger that moves across is one.
    let from = null;
    let pressed = false;
    const send = (type, { clientX, clientY }) => over.dispatchEvent(new MouseEvent(type, { bubbles: true, clientX, clientY, movementX: 1 }));
    over.addEventListener("pointerdown", (event) => { from = event.pointerType === "mouse" ? null : event; });
    over.addEventListener("pointermove", (event) => {
      if (!from || (!pressed && Math.abs(event.clientX - from.clientX) < 8)) return;
      if (!pressed) send("mousedown", from);
      pressed = true;
      send("mousemove", event);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      over.addEventListener(end, (event) => {
        if (pressed) send("mouseup", event);
        pressed = false;
        from = null;
      });
    }
  }
}

// What an axis is called, as far as there is room.
function labelOf({ ctx, bbox }, axis, column, log) {
  const better = column.better && (column.better === "higher" ? "better →" : "← better");
  const notes = [[log && "logarithmic", better], [log && "log", better], [log && "log"]].map((n) => n.filter(Boolean).join(", "));
  const labels = notes.map((n) => (n ? `${withUnit(column)}  (${n})` : withUnit(column)));
  const room = axis === "x" ? bbox.width : bbox.height;
  return labels.find((label) => ctx.measureText(label).width <= room) ?? labels.at(-1);
}

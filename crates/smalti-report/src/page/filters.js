// Which designs are shown: by number of colours, words (processing, conditions, mosaic), marks, and ranges of any number.

// Words of a column that get a box each; of more there is a list.
const MAX_BOXES = 8;

class Filters {
  constructor(designs, changed) {
    this.designs = designs;
    this.changed = changed;
    this.keep = new Uint8Array(designs.count).fill(1);
    this.groups = [];
    this.ranges = [];
    this.element = make("details", { class: "filters no-print", open: !matchMedia("(max-width: 1100px)").matches }, make("summary", {}, "Filter"));
    this.addNumbersOfColors();
    designs.words.filter((w) => w.words.length > 1).forEach((w) => this.addWords(w));
    this.addMarks();
    this.addRanges();
  }

  box(words, color, many, change) {
    const input = make("input", { type: "checkbox", change });
    const chip = color ? make("i") : null;
    const paint = () => { if (chip) chip.style.background = color(); };
    paint();
    themeListeners.push(paint);
    return [input, make("label", { class: "box" }, input, chip, make("span", {}, words), many === null ? null : make("span", { class: "many" }, many.toLocaleString("en")))];
  }

  addBoxes(legend, entries, codes) {
    const off = new Set();
    const boxes = entries.map(({ code, words, color, many }) => {
      const [input, label] = this.box(words, color, many, () => {
        if (input.checked) off.delete(code);
        else off.add(code);
        this.update();
      });
      input.checked = true;
      return [input, label];
    });
    this.element.append(make("fieldset", {}, make("legend", {}, legend), ...boxes.map(([, label]) => label)));
    this.groups.push({ passes: (i) => !off.has(codes[i]), idle: () => off.size === 0, reset: () => { off.clear(); boxes.forEach(([input]) => { input.checked = true; }); } });
  }

  addNumbersOfColors() {
    const counts = new Map();
    this.designs.colors.forEach((n) => counts.set(n, (counts.get(n) || 0) + 1));
    const entries = [...counts].sort(([a], [b]) => a - b).map(([code, many]) => ({ code, many, words: `${code} colours`, color: () => css(colorOfCount(code)) }));
    if (entries.length > 1) this.addBoxes("Number of colours", entries, this.designs.colors);
  }

  addWords(column) {
    const counts = new Array(column.words.length).fill(0);
    column.codes.forEach((code) => { counts[code] += 1; });
    const entries = column.words.map((words, code) => ({ code, words: words || "(none)", many: counts[code] }));
    if (entries.length <= MAX_BOXES) {
      this.addBoxes(column.label, entries, column.codes);
      return;
    }
    let wanted = -1;
    const select = make("select", { "aria-label": column.label, change: () => { wanted = Number(select.value); this.update(); } },
      make("option", { value: "-1" }, `all ${entries.length}`), ...entries.map((e) => make("option", { value: e.code }, e.words)));
    this.element.append(make("fieldset", {}, make("legend", {}, column.label), select));
    this.groups.push({ passes: (i) => wanted < 0 || column.codes[i] === wanted, idle: () => wanted < 0, reset: () => { wanted = -1; select.value = "-1"; } });
  }

  addMarks() {
    const { front, pictures } = this.designs;
    const marks = [["on the Pareto front of ΔE, MTF50 and noise", (i) => front[i] === 1]];
    if (pictures.size) marks.push(["with pictures by the simulator itself", (i) => pictures.has(i)]);
    const wanted = new Set();
    const boxes = marks.map(([words, passes]) => {
      const [input, label] = this.box(words, null, null, () => {
        if (input.checked) wanted.add(passes);
        else wanted.delete(passes);
        this.update();
      });
      return [input, label];
    });
    this.element.append(make("fieldset", {}, make("legend", {}, "Only"), ...boxes.map(([, label]) => label)));
    this.groups.push({
      passes: (i) => { for (const f of wanted) if (!f(i)) return false; return true; },
      idle: () => wanted.size === 0, reset: () => { wanted.clear(); boxes.forEach(([input]) => { input.checked = false; }); },
    });
  }

  addRanges() {
    this.rangeList = make("div");
    this.element.append(make("fieldset", {}, make("legend", {}, "Ranges"), this.rangeList,
      make("div", { class: "buttons" }, make("button", { type: "button", click: () => this.addRange() }, "Add a range"),
        make("button", { type: "button", click: () => this.reset() }, "Reset filters"))));
  }

  addRange(column = this.designs.columns[1] || this.designs.columns[0], low = "", high = "") {
    const range = { column, low, high };
    const select = columnSelect(this.designs.columns, column, "Column of the range", () => {
      range.column = this.designs.columns[Number(select.value)];
      hint();
      this.update();
    });
    const ends = ["low", "high"].map((end) => {
      const input = make("input", { type: "number", step: "any", "aria-label": end === "low" ? "At least" : "At most", value: range[end], input: () => {
        range[end] = input.value;
        this.update();
      } });
      return input;
    });
    const hint = () => {
      const found = extent(range.column.values);
      ends.forEach((input, i) => { input.placeholder = Number.isFinite(found[i]) ? shown(found[i]) : ""; });
    };
    const remove = make("button", { type: "button", "aria-label": "Remove the range", click: () => {
      this.ranges = this.ranges.filter((r) => r !== range);
      element.remove();
      this.update();
    } }, "×");
    const element = make("div", { class: "range" }, select, ...ends, remove);
    hint();
    this.rangeList.append(element);
    this.ranges.push(range);
    this.update();
  }

  reset() {
    this.groups.forEach((g) => g.reset());
    this.ranges = [];
    this.rangeList.replaceChildren();
    this.update();
  }

  update() {
    const groups = this.groups.filter((g) => !g.idle());
    const ranges = this.ranges.filter((r) => r.low !== "" || r.high !== "").map((r) => [r.column.values, r.low === "" ? -Infinity : Number(r.low), r.high === "" ? Infinity : Number(r.high)]);
    for (let i = 0; i < this.keep.length; i += 1) {
      this.keep[i] = groups.every((g) => g.passes(i)) && ranges.every(([v, low, high]) => v[i] >= low && v[i] <= high) ? 1 : 0;
    }
    this.changed();
  }
}

// A list of columns: figures first, then what the filters have.
function columnSelect(columns, chosen, label, change) {
  const option = (c) => make("option", { value: columns.indexOf(c), selected: c === chosen }, withUnit(c));
  const part = (words, some) => (some.length ? make("optgroup", { label: words }, ...some.map(option)) : null);
  return make("select", { "aria-label": label, change }, part("Figures", columns.filter((c) => !c.parameter)), part("Filters", columns.filter((c) => c.parameter)));
}

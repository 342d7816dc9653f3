// Which trials are shown: by number of colours, words (processing, conditions, mosaic), marks, and ranges of any number.

// Words of a column that get a box each; of more there is a list.
const MAX_BOXES = 8;

class Filters {
  constructor(trials, changed) {
    this.trials = trials;
    this.changed = changed;
    this.keep = new Uint8Array(trials.count).fill(1);
    this.groups = [];
    this.ranges = [];
    this.element = make("details", { class: "filters no-print", open: !matchMedia("(max-width: 1100px)").matches }, make("summary", {}, "Filter"));
    this.addNumbersOfColors();
    trials.words.filter((w) => w.words.length > 1).forEach((w) => this.addWords(w));
    this.addMarks();
    this.addRanges();
  }

  // Boxes, at first all checked or none. From the set of the codes of boxes that were changed, `passes` makes the test of a row.
  addBoxes(legend, entries, checked, passes) {
    const changed = new Set();
    const inputs = [];
    const labels = entries.map(({ code, words, color, many }) => {
      const input = make("input", { type: "checkbox", change: () => {
        if (input.checked === checked) changed.delete(code);
        else changed.add(code);
        this.update();
      } });
      input.checked = checked;
      inputs.push(input);
      const chip = color ? make("i") : null;
      const paint = () => { if (chip) chip.style.background = color(); };
      paint();
      themeListeners.push(paint);
      return make("label", { class: "box" }, input, chip, make("span", {}, words), many === undefined ? null : make("span", { class: "many" }, many.toLocaleString("en")));
    });
    this.element.append(make("fieldset", {}, make("legend", {}, legend), ...labels));
    this.groups.push({ passes: passes(changed), idle: () => changed.size === 0, reset: () => { changed.clear(); inputs.forEach((input) => { input.checked = checked; }); } });
  }

  addNumbersOfColors() {
    const { colors } = this.trials;
    const counts = new Map();
    colors.forEach((n) => counts.set(n, (counts.get(n) || 0) + 1));
    const entries = [...counts].sort(([a], [b]) => a - b).map(([code, many]) => ({ code, many, words: `${code} colours`, color: () => css(colorOfCount(code)) }));
    if (entries.length > 1) this.addBoxes("Number of colours", entries, true, (off) => (i) => !off.has(colors[i]));
  }

  addWords(column) {
    const { codes } = column;
    const counts = new Array(column.words.length).fill(0);
    codes.forEach((code) => { counts[code] += 1; });
    const entries = column.words.map((words, code) => ({ code, words: words || "(none)", many: counts[code] }));
    if (entries.length <= MAX_BOXES) {
      this.addBoxes(column.label, entries, true, (off) => (i) => !off.has(codes[i]));
      return;
    }
    let wanted = -1;
    const select = make("select", { "aria-label": column.label, change: () => { wanted = Number(select.value); this.update(); } },
      make("option", { value: "-1" }, `all ${entries.length}`), ...entries.map((e) => make("option", { value: e.code }, e.words)));
    this.element.append(make("fieldset", {}, make("legend", {}, column.label), select));
    this.groups.push({ passes: (i) => wanted < 0 || codes[i] === wanted, idle: () => wanted < 0, reset: () => { wanted = -1; select.value = "-1"; } });
  }

  addMarks() {
    const { front, pictures } = this.trials;
    const marks = [{ words: "on the Pareto front of ΔE, MTF50 and noise", code: (i) => front[i] === 1 }];
    if (pictures.size) marks.push({ words: "with embedded pictures", code: (i) => pictures.has(i) });
    this.addBoxes("Only", marks, false, (wanted) => (i) => { for (const passes of wanted) if (!passes(i)) return false; return true; });
  }

  addRanges() {
    this.rangeList = make("div");
    this.element.append(make("fieldset", {}, make("legend", {}, "Ranges"), this.rangeList,
      make("div", { class: "buttons" }, make("button", { type: "button", click: () => this.addRange() }, "Add a range"),
        make("button", { type: "button", click: () => this.reset() }, "Reset filters"))));
  }

  addRange() {
    const range = { column: this.trials.columns[1] || this.trials.columns[0], low: "", high: "" };
    const select = columnSelect(this.trials.columns, range.column, "Column of the range", () => {
      range.column = this.trials.columns[Number(select.value)];
      hint();
      this.update();
    });
    const ends = ["low", "high"].map((end) => make("input", { type: "number", step: "any", "aria-label": end === "low" ? "At least" : "At most", value: "", input: ({ target }) => {
      range[end] = target.value;
      this.update();
    } }));
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

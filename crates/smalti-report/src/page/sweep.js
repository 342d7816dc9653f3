// The page of a study: puts scatter, filters, histograms, design and selection together.

async function startSweep(data) {
  const trials = readTrials(data, await unpackCurves(data.filters.curves));
  const isVaried = (values) => { const [low, high] = extent(values); return low < high; };
  const varied = trials.columns.filter((c) => c.parameter || c.name === "colors" || isVaried(c.values));
  const first = (...names) => names.map((name) => varied.find((c) => c.name === name)).find(Boolean);
  const some = varied.filter((c) => !c.parameter && c.name !== "colors");
  const ways = [
    { label: "Number of colours", column: null, words: null },
    ...trials.words.filter((w) => w.words.length > 1 && w.words.length <= MAX_BOXES).map((w) => ({ label: w.label, words: w })),
    ...varied.filter((c) => c.name !== "colors").map((c) => ({ label: withUnit(c), column: c })),
  ];
  const view = {
    x: first("mtf50_cy_per_mm") || some[0] || trials.columns[0],
    y: first("delta_e_76") || some[1] || some[0] || trials.columns[0],
    color: ways[0], whole: false, zoom: null, front: true, log: {},
  };

  const selected = new Uint8Array(trials.count);
  const panel = make("section", { class: "design", tabindex: "-1", "aria-label": "Design" });
  const count = make("output", { "aria-live": "polite" });
  const scatter = new Scatter({ brush: onBrush, point: onPoint });
  const filters = new Filters(trials, onFilters);
  const histograms = [first("delta_e_76"), first("mtf50_cy_per_mm"), first("luminance_noise_percent"), first("aliasing_percent") || first("mean_fwhm_nm")]
    .filter(Boolean).map((c) => new Histogram(c));
  const clear = make("button", { type: "button", click: () => scatter.setBox(null) }, "Clear selection");
  const zoom = make("button", { type: "button", click: () => {
    view.zoom = view.zoom ? null : scatter.box;
    if (view.zoom) scatter.setBox(null);
    else show();
  } }, "Zoom to selection");
  const save = make("button", { type: "button", class: "primary", click: () => saveCsv(trials, selected) }, "Download CSV");
  const bestShown = make("div");
  // The best trials of the table are to be seen, wherever they are.
  const best = Array.from(document.querySelectorAll("#best tr.marked button[data-row]"), (button) => Number(button.dataset.row));
  // So are those with marks.
  const markOf = new Map();
  for (const mark of trials.marks) {
    for (const row of mark.rows) {
      best.push(row);
      markOf.set(row, [mark.study, mark.name].filter(Boolean).join(": "));
    }
  }

  const explorer = document.getElementById("explorer");
  explorer.replaceChildren(controls(), filters.element,
    make("div", { class: "plot" }, scatter.element,
      make("div", { class: "selection no-print" }, count, zoom, clear, save),
      make("p", { class: "help", id: "scatter-help" },
        "Drag to select; click a point to see its trial. Keyboard: the arrow keys move between points; Home and End select the ends of the Pareto front; Enter shows the trial; Escape clears the selection.")),
    panel,
    make("div", { class: "below" }, make("div", { class: "histograms" }, ...histograms.map((h) => h.element)), bestShown));

  document.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-row]");
    if (!button) return;
    choose(Number(button.dataset.row));
    panel.focus();
    panel.scrollIntoView({ block: "nearest" });
  });

  // The tables of the page get mosaics in colour.
  for (const button of document.querySelectorAll("#best button[data-row]")) {
    const tile = smallTile(trials, Number(button.dataset.row));
    if (tile) button.closest("tr").querySelector("code")?.before(tile);
  }
  onFilters();
  themeListeners.push(() => {
    show();
    if (scatter.pinned >= 0) choose(scatter.pinned);
  });
  const start = [...trials.pictures.keys()][0] ?? scatter.state.front[0] ?? 0;
  choose(start);

  function controls() {
    const axis = (which, label) => make("label", {}, label, columnSelect(varied, view[which], label, (event) => {
      view[which] = varied[Number(event.target.value)];
      delete view.log[which];
      view.zoom = null;
      scatter.box = null;
      onFilters();
    }));
    const color = make("label", {}, "Colour by", make("select", { change: (event) => { view.color = ways[Number(event.target.value)]; show(); } },
      ...ways.map((w, i) => make("option", { value: i }, w.label))));
    const check = (words, value, change) => {
      const input = make("input", { type: "checkbox", change: () => change(input.checked) });
      input.checked = value;
      return make("label", { class: "check" }, input, words);
    };
    return make("div", { class: "controls no-print" }, axis("x", "Horizontal axis"), axis("y", "Vertical axis"), color,
      check("Pareto front", true, (on) => { view.front = on; show(); }),
      check("Show outliers", false, (on) => { view.whole = on; view.zoom = null; show(); }));
  }

  // Filters and axes decide what is shown, the box what of it is selected.
  function onFilters() {
    select();
    histograms.forEach((h) => h.prepare(filters.keep));
    show();
  }
  function onBrush() {
    performance.mark("smalti-brush");
    select();
    if (!view.zoom || scatter.box) scatter.state.selected = selected;
    if (scatter.box) scatter.paint();
    else show();
    tellSelection();
    performance.measure("smalti-brush", "smalti-brush");
  }
  function select() {
    const { keep } = filters;
    const { box } = scatter;
    const [x, y] = [view.x.values, view.y.values];
    for (let i = 0; i < keep.length; i += 1) {
      selected[i] = keep[i] && (!box || (x[i] >= box.x[0] && x[i] <= box.x[1] && y[i] >= box.y[0] && y[i] <= box.y[1])) ? 1 : 0;
    }
  }
  function show() {
    const ends = view.zoom || { x: endsOf(view.x.values, filters.keep, view.whole, best), y: endsOf(view.y.values, filters.keep, view.whole, best) };
    const log = {};
    const padded = {};
    for (const axis of ["x", "y"]) {
      const [low, high] = ends[axis];
      log[axis] = view[axis].better === "lower" && low > 0 && high > 6 * low;
      const margin = 0.03 * (high - low);
      padded[axis] = view.zoom ? [low, high] : log[axis] ? [low / 1.1, high * 1.1] : [low - margin, high + margin];
    }
    if (log.y && !view.zoom && !view.whole) padded.y[1] = Math.max(padded.y[1], 1.1 * extent(view.y.values, filters.keep)[1]);
    let many = 0;
    for (let i = 0; i < filters.keep.length; i += 1) many += filters.keep[i];
    const front = view.front ? frontOf(view.x, view.y, filters.keep) : [];
    scatter.show({
      x: view.x, y: view.y, log, ends: padded, shown: filters.keep, selected, count: many,
      color: colorsOf(), front, marks: trials.marks, words: tipOf, beyond: (row) => isBeyondNyquist(trials, row), nyquist: nyquistIn(padded),
    });
    scatter.legend.append(...legendOfMarks(), ...legendOfNyquist(front));
    tellSelection();
  }
  function tipOf(row) {
    const lines = [`Trial ${trials.number[row]}, ${trials.colors[row]} colours`];
    if (markOf.has(row)) lines.push(markOf.get(row));
    if (trials.condition) lines.push(trials.condition.words[trials.section[row]]);
    for (const c of [view.x, view.y]) lines.push(`${c.label} ${shown(c.values[row])}`);
    if (view.color.column) lines.push(`${view.color.column.label} ${shown(view.color.column.values[row])}`);
    if (isBeyondNyquist(trials, row)) lines.push("MTF50 beyond Nyquist");
    else if (isPlateau(trials, row)) lines.push("MTF50 of a plateau");
    return lines.join("\n");
  }
  function colorsOf() {
    const { column, words } = view.color;
    if (!column) {
      const codes = words ? words.codes : trials.colors;
      const present = new Set();
      for (let i = 0; i < codes.length; i += 1) if (filters.keep[i]) present.add(codes[i]);
      const table = Array.from({ length: 256 }, (_, i) => (words ? category(i) : colorOfCount(i)));
      scatter.legend.replaceChildren(...[...present].sort((a, b) => a - b).map((code) => {
        const chip = make("i");
        chip.style.background = css(table[code]);
        return make("span", { class: "chip" }, chip, words ? words.words[code] || "(none)" : `${code} colours`);
      }));
      return { codes, table };
    }
    const [low, high] = quantiles(column.values, filters.keep, [0.005, 0.98]);
    const codes = Uint8Array.from(column.values, (v) => (Number.isNaN(v) ? 0 : Math.min(255, Math.max(0, Math.round((255 * (v - low)) / (high - low || 1))))));
    const table = Array.from({ length: 256 }, (_, i) => viridis(i / 255));
    const bar = make("canvas", { width: 256, height: 1, "aria-hidden": "true" });
    const c = bar.getContext("2d");
    table.forEach((rgb, i) => { c.fillStyle = css(rgb); c.fillRect(i, 0, 1, 1); });
    scatter.legend.replaceChildren(make("span", {}, withUnit(column)), make("span", {}, shown(low)), bar, make("span", {}, shown(high)));
    return { codes, table };
  }
  // The symbols of the trials that are marked, by study.
  function legendOfMarks() {
    const entries = trials.marks.map((mark, i) => [mark, i]).filter(([mark]) => mark.rows.some((row) => filters.keep[row]));
    return [...new Set(entries.map(([mark]) => mark.study))].map((study) => make("span", { class: "marks" },
      ...entries.filter(([mark]) => mark.study === study).flatMap(([mark, i], k) => {
        const symbol = draw("svg", { viewBox: "-9 -9 18 18", "aria-hidden": "true" }, draw("path", { d: symbolOf(i) }));
        return [mark.name && k === 0 ? make("b", {}, study) : null, make("span", { class: "chip" }, symbol, mark.name || study)];
      })));
  }

  // Where the axes pass what the sensor samples, if all trials have the same sensor.
  function nyquistIn(ends) {
    const within = (axis) => {
      const limits = new Set(data.sections.map((_, section) => nyquistOf(trials, view[axis], section)));
      const [limit] = limits;
      return limits.size === 1 && limit > ends[axis][0] && limit < ends[axis][1] ? limit : null;
    };
    return { x: within("x"), y: within("y") };
  }
  function legendOfNyquist(front) {
    const beyond = front.filter((row) => isBeyondNyquist(trials, row));
    if (beyond.length === 0) return [];
    const unseen = beyond.filter((row) => scatter.px?.[row] === OUT).length;
    const symbol = draw("svg", { viewBox: "-9 -9 18 18", "aria-hidden": "true" }, draw("path", { d: "M-7 -7L7 7M-7 7L7 -7" }));
    return [make("span", { class: "beyond" }, make("span", { class: "chip" }, symbol,
      `MTF50 beyond the sensor's Nyquist frequency, so aliased: ${beyond.length} of ${front.length} on the front${unseen > 0 ? `, ${unseen === beyond.length ? "all" : unseen} outside the plot` : ""}`))];
  }

  function tellSelection() {
    const { keep } = filters;
    let [all, some, inView] = [0, 0, 0];
    for (let i = 0; i < keep.length; i += 1) {
      all += keep[i];
      some += selected[i];
      if (selected[i] && scatter.px && scatter.px[i] !== OUT) inView += 1;
    }
    const of = (n) => n.toLocaleString("en");
    let words = scatter.box ? `${of(some)} of ${of(all)} trials selected` : `${of(all)} trials`;
    if (scatter.px && inView < some) words += `, ${of(some - inView)} of them outside the plot or without figures`;
    if (count.textContent !== words) count.textContent = words;
    const axis = (which) => `${withUnit(view[which])}${scatter.state.log[which] ? " (logarithmic)" : ""}`;
    scatter.name(`${axis("y")} against ${axis("x")}. ${words}.`);
    clear.disabled = !scatter.box;
    zoom.disabled = !scatter.box && !view.zoom;
    zoom.textContent = view.zoom ? "Zoom out" : "Zoom to selection";
    save.disabled = some === 0;
    histograms.forEach((h) => h.show(selected, scatter.box !== null));
    showBest();
  }
  function showBest() {
    const by = view.y.better ? view.y : view.x;
    const sign = by.better === "higher" ? -1 : 1;
    const rows = [];
    const worst = () => sign * by.values[rows[rows.length - 1]];
    for (let i = 0; i < selected.length; i += 1) {
      const v = sign * by.values[i];
      if (!selected[i] || Number.isNaN(v) || (rows.length === 8 && v >= worst())) continue;
      rows.push(i);
      rows.sort((a, b) => sign * (by.values[a] - by.values[b]));
      rows.length = Math.min(8, rows.length);
    }
    const columns = [...new Set([view.x, view.y, ...histograms.map((h) => h.column)])].filter((c) => c.name !== "colors");
    const cell = (v) => make("td", { class: "number" }, v);
    bestShown.replaceChildren(make("div", { class: "scrolls", tabindex: "0", role: "region", "aria-label": "Best of the selection" }, tableOf(
      `${scatter.box ? "Best of the selection" : "Best of those shown"}, by ${by.label}`, ["Mosaic", ...(trials.condition ? [trials.condition.label] : [])], ["Trial", "Colours", ...columns.map(withUnit)],
      rows.map((row) => make("tr", {}, make("td", {}, smallTile(trials, row)), trials.condition ? make("td", {}, trials.condition.words[trials.section[row]]) : null,
        make("th", { scope: "row", class: "number" }, make("button", { class: "design", type: "button", "data-row": row }, String(trials.number[row]))),
        cell(trials.colors[row]), ...columns.map((c) => cell(shown(c.values[row]))))))));
  }
  function onPoint(row, how) {
    if (how === "choose") choose(row);
    else count.textContent = tipOf(row).split("\n").join(", ");
  }
  function choose(row) {
    scatter.setPinned(row);
    showTrial(trials, row, panel);
    panel.setAttribute("aria-label", `Trial ${trials.number[row]}`);
  }
}

// Text of a table as programs read it; what a spreadsheet would take for a formula is not.
function csvText(text) {
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}
function csvOf(trials, selected) {
  const numbers = trials.columns.filter((c) => !c.parameter && c.name !== "colors");
  const head = ["study", "trial", "colors", ...trials.words.map((w) => w.name), ...numbers.map((c) => c.name), "center_nm", "fwhm_nm", "peak"];
  const number = (v) => (Number.isFinite(v) ? String(Number(v.toPrecision(7))) : Number.isNaN(v) ? "" : String(v));
  const lines = [head.map(csvText).join(",")];
  for (let i = 0; i < trials.count; i += 1) {
    if (!selected[i]) continue;
    const list = (values) => Array.from(values.subarray(trials.start[i], trials.start[i + 1]), number).join(" ");
    lines.push([
      csvText(trials.data.studies[trials.data.sections[trials.section[i]].study].name), trials.number[i], trials.colors[i],
      ...trials.words.map((w) => csvText(w.words[w.codes[i]])), ...numbers.map((c) => number(c.values[i])),
      list(trials.center), list(trials.fwhm), list(trials.peak),
    ].join(","));
  }
  return `${lines.join("\n")}\n`;
}
function saveCsv(trials, selected) {
  const url = URL.createObjectURL(new Blob([csvOf(trials, selected)], { type: "text/csv" }));
  make("a", { href: url, download: "trials.csv" }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

startSweep(JSON.parse(document.getElementById("sweep").textContent));

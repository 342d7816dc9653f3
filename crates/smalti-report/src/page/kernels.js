// Kernels of learned pipelines, by clipped channels, position, level and texture (learned.rs packs them).

// Letters for where kernels come from, none for those learned.
const ORIGIN_MARKS = ["", "I", "T", "S", "N", "L"];

// From blue over white to orange for −1 to 1, as in the pictures of kernels.
function diverging(value) {
  const end = value < 0 ? [33, 102, 171] : [230, 97, 0];
  return `rgb(${end.map((e) => Math.round(255 + Math.min(1, Math.abs(value)) * (e - 255))).join(" ")})`;
}

function startKernels(data) {
  if (!data) return;
  const { learned } = JSON.parse(data.textContent);
  for (const place of document.querySelectorAll(".kernels[data-learned]")) {
    const of = learned[Number(place.dataset.learned)];
    if (of) showKernels(place, of);
  }
}

function showKernels(place, of) {
  const taps = of.side * of.side;
  const [textures, outputs] = [of.textures.length, of.outputs.length];
  const unpacked = of.clipped.map(() => null);
  // Of the middle level the texture: dark and flat ones are little but means.
  const middle = () => Math.floor(part().levels.length / 2);
  const state = { clipped: 0, position: 0, level: 0, texture: Math.min(1, textures - 1) };
  const part = () => of.clipped[state.clipped];
  const columns = () => (unpacked[state.clipped] ??= Object.fromEntries(["count", "origin", "scale", "weight", "offset"].map((name) => [name, unpack(part()[name])])));
  const indexOf = (position, level, texture) => (position * part().levels.length + level) * textures + texture;
  state.level = middle();

  const named = (p) => `row ${p.row}, column ${p.col}: ${of.channels[p.channel]}`;
  const position = make("select", { change: () => set({ position: Number(position.value) }) }, of.positions.map((p, i) => make("option", { value: i }, named(p))));
  const texture = make("select", { change: () => set({ texture: Number(texture.value) }) }, of.textures.map((t, i) => make("option", { value: i }, t)));
  const clips = (c) => (c.channels.length ? c.channels.join(", ") : "none");
  const clipped = make("select", { change: () => { state.clipped = Number(clipped.value); set({ level: middle() }); } }, of.clipped.map((c, i) => make("option", { value: i }, clips(c))));
  const level = make("input", { type: "range", min: 0, "aria-label": "Level", input: () => set({ level: Number(level.value) }) });
  const levelName = make("span");
  const about = make("p", { class: "about-class", "aria-live": "polite" });
  const drawings = make("div", { class: "drawings" });
  const numbers = make("div");
  const counts = make("div", { class: "scrolls counts", tabindex: 0, role: "region", "aria-label": "Patches of each class" });
  place.append(
    make("div", { class: "choices no-print" }, make("label", {}, "Position", position), make("label", {}, "Texture", texture), of.clipped.length > 1 ? make("label", {}, "Clipped channels", clipped) : null, make("label", { class: "level" }, levelName, level)),
    make("div", { class: "classes" },
      make("div", {}, about, drawings,
        make("p", { class: "help" }, "Orange: positive weights, blue: negative, relative to the largest of the kernel. Frames have the colours of the filters."),
        make("details", {}, make("summary", {}, "The weights as numbers"), numbers)),
      counts));

  function set(change) {
    Object.assign(state, change);
    show();
  }
  const counted = (n) => (n >= 1e6 ? `${(n / 1e6).toFixed(1)} M` : n >= 1e4 ? `${Math.round(n / 1e3)} k` : String(n));

  function kernel(index, output, p) {
    const at = (index * outputs + output) * taps;
    const scale = columns().scale[index * outputs + output];
    const cells = [];
    const weights = [];
    for (let tap = 0; tap < taps; tap += 1) {
      const share = columns().weight[at + tap] / of.steps;
      weights.push(share * scale);
      const [x, y] = [tap % of.side, Math.floor(tap / of.side)];
      cells.push(
        draw("rect", { x: x + 0.03, y: y + 0.03, width: 0.94, height: 0.94, fill: of.colors[p.taps[tap]] ?? "#888" }),
        draw("rect", { x: x + 0.12, y: y + 0.12, width: 0.76, height: 0.76, fill: diverging(share) }));
    }
    const name = of.outputs[output];
    const text = `Kernel of ${name}: largest weight ${shown(scale)}, sum ${shown(weights.reduce((a, b) => a + b, 0))}`;
    return {
      name, weights, offset: columns().offset[index * outputs + output],
      element: make("figure", {}, draw("svg", { viewBox: `0 0 ${of.side} ${of.side}`, role: "img", "aria-label": text }, ...cells), make("figcaption", {}, make("b", {}, name), ` largest ${shown(scale)}`)),
    };
  }

  function show() {
    const p = of.positions[state.position];
    const index = indexOf(state.position, state.level, state.texture);
    position.value = state.position;
    texture.value = state.texture;
    level.max = part().levels.length - 1;
    level.value = state.level;
    const here = `level ${part().levels[state.level]} of ${of.level_count}`;
    level.setAttribute("aria-valuetext", here);
    const bright = Number(Number(part().middles[state.position][state.level]).toPrecision(2));
    levelName.textContent = `Level ${part().levels[state.level]} of ${of.level_count}, about ${bright} % of white`;
    const from = columns().origin[index];
    about.replaceChildren(
      `${columns().count[index].toLocaleString("en")} patches in training. Kernels: `,
      make("b", { class: from === 0 ? "own" : "borrowed" }, from === 0 ? of.origins[from] : `fallback: ${of.origins[from]}`), ".");
    const kernels = of.outputs.map((_, output) => kernel(index, output, p));
    drawings.replaceChildren(...kernels.map((k) => k.element));
    const rows = [];
    for (let tap = 0; tap < taps; tap += 1) {
      const where = `${Math.floor(tap / of.side) + 1}, ${(tap % of.side) + 1} (${of.channels[p.taps[tap]]})`;
      rows.push(make("tr", {}, make("th", { scope: "row" }, where), ...kernels.map((k) => make("td", { class: "number" }, shown(k.weights[tap])))));
    }
    rows.push(make("tr", {}, make("th", { scope: "row" }, "offset"), ...kernels.map((k) => make("td", { class: "number" }, shown(k.offset)))));
    numbers.replaceChildren(make("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "Weights" },
      tableOf(`Weights at ${named(p)}, ${here}, ${of.textures[state.texture]}`, ["Row, column"], kernels.map((k) => k.name), rows)));
    showCounts(p);
  }

  function showCounts(p) {
    const { levels } = part();
    const most = columns().count.reduce((a, b) => Math.max(a, b), 1);
    const used = new Set();
    const cell = (l, t) => {
      const index = indexOf(state.position, l, t);
      const [n, origin] = [columns().count[index], columns().origin[index]];
      if (origin > 0) used.add(origin);
      const here = l === state.level && t === state.texture;
      const bar = draw("svg", { class: "bar-of", viewBox: "0 0 100 4", preserveAspectRatio: "none", "aria-hidden": true },
        draw("rect", { width: n > 0 ? Math.max(2, (100 * Math.log1p(n)) / Math.log1p(most)) : 0, height: 4 }));
      return make("td", { class: `number${origin > 0 ? " borrowed" : ""}${here ? " here" : ""}`, "aria-current": here ? "true" : null, click: () => set({ level: l, texture: t }) },
        counted(n), origin > 0 ? make("sup", { title: of.origins[origin] }, ORIGIN_MARKS[origin] ?? "?") : null, bar);
    };
    const rows = levels.map((l, i) => make("tr", {}, make("th", { scope: "row" }, String(l)), ...of.textures.map((_, t) => cell(i, t))));
    const scroll = counts.scrollTop;
    counts.replaceChildren(
      tableOf(`Patches of each class at ${named(p)}`, ["Level"], of.textures, rows),
      make("p", { class: "help" },
        used.size ? `Fallbacks: ${[...used].sort().map((o) => `${ORIGIN_MARKS[o]} ${of.origins[o]}`).join(", ")}. ` : "All kernels are learned. ",
        "A click shows a class.",
        state.clipped > 0 ? " For clipped channels, only levels with training data are shown." : "",
        levels.length < part().met ? ` ${levels.length} of ${part().met} levels are on this page.` : ""));
    counts.scrollTop = scroll;
  }
  show();
}

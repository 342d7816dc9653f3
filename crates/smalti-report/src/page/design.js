// One design: its spectra, its mosaic, its figures, its pictures.

// Transmittance of a filter, in wavelengths from `first_nm` in steps of `step_nm`; null where the page does not hold it.
function curveOf({ curves, used }, at) {
  const block = curves.blocks[Math.floor(used[at] / curves.in_block)];
  if (!block) return null;
  const row = used[at] % curves.in_block;
  return Array.from(block.subarray(row * curves.count, (row + 1) * curves.count), (code) => code / curves.steps);
}
function colorOf({ filterColors, used }, at) {
  return rgbOf(filterColors[used[at]]);
}
function filtersOf(trials, row) {
  const filters = [];
  for (let at = trials.start[row]; at < trials.start[row + 1]; at += 1) {
    const color = colorOf(trials, at);
    filters.push({
      letter: letter(at - trials.start[row]), center: trials.center[at], fwhm: trials.fwhm[at], peak: trials.peak[at], curve: curveOf(trials, at),
      color: css(color), line: css(isDark() ? color.map((v) => Math.round(v + (255 - v) * 0.35)) : color),
    });
  }
  return filters;
}

function spectraOf({ curves, scale }, filters) {
  const [left, bottom, width, height] = [30, 150, 340, 132];
  const x = (nm) => left + ((nm - 380) / 340) * width;
  const top = Math.max(1, ...filters.map((f) => f.peak || 0));
  const y = (t) => bottom - (t / top) * height;
  const words = filters.map((f) => `${f.letter} at ${shown(f.center)} nm, ${shown(f.fwhm)} nm wide, peak ${shown(f.peak)}`);
  const svg = draw("svg", { viewBox: "0 0 380 188", role: "img" }, draw("title", {}, "Spectra of the filters"), draw("desc", {}, words.join("; ")));
  for (const t of [0, 0.5, 1]) {
    svg.append(draw("path", { class: "axis", d: `M${left} ${y(t)}h${width}` }), draw("text", { class: "tick", x: left - 5, y: y(t) + 4, "text-anchor": "end" }, String(t)));
  }
  // The colours of the wavelengths below, so that one sees where a filter lies.
  scale.colors.forEach((color, i) => {
    svg.append(draw("rect", { x: x(scale.first_nm + i * scale.step_nm), y: bottom + 1, width: width / scale.colors.length + 0.4, height: 5, fill: css(rgbOf(color)) }));
  });
  for (let nm = 400; nm <= 700; nm += 50) svg.append(draw("text", { class: "tick", x: x(nm), y: bottom + 20, "text-anchor": "middle" }, String(nm)));
  svg.append(draw("text", { class: "tick", x: left + width / 2, y: bottom + 33, "text-anchor": "middle" }, "Wavelength, nm"));
  const at = (i) => x(curves.first_nm + i * curves.step_nm);
  for (const f of filters.filter((one) => one.curve)) {
    const path = f.curve.map((t, i) => `${i ? "L" : "M"}${at(i).toFixed(1)} ${y(t).toFixed(1)}`).join("");
    svg.append(draw("path", { class: "filter", d: `${path}V${bottom}H${left}Z`, fill: f.color, stroke: "none" }), draw("path", { class: "filter", d: path, fill: "none", stroke: f.line }));
    const peak = f.curve.indexOf(Math.max(...f.curve));
    svg.append(draw("text", { class: "letter", x: at(peak), y: Math.max(11, y(f.curve[peak]) - 4), fill: f.line, "text-anchor": "middle" }, f.letter));
  }
  return svg;
}

// One period, framed, with half a period around it.
function tileOf(tile, filters) {
  const rows = tile.split("/").map((row) => [...row].map((c) => c.charCodeAt(0) - 97));
  const [down, across] = [rows.length, rows[0].length];
  const around = Math.max(down, across) > 8 ? 0 : 1;
  const svg = draw("svg", { viewBox: `${-around - 0.1} ${-around - 0.1} ${across + 2 * around + 0.2} ${down + 2 * around + 0.2}`, role: "img" },
    draw("title", {}, "Mosaic"), draw("desc", {}, `Rows of one period: ${tile.toUpperCase().split("/").join(", ")}`));
  for (let r = -around; r < down + around; r += 1) {
    for (let c = -around; c < across + around; c += 1) {
      const filter = filters[rows[(r + down) % down][(c + across) % across]];
      const inside = r >= 0 && r < down && c >= 0 && c < across;
      svg.append(draw("rect", { class: "cell", x: c, y: r, width: 1, height: 1, fill: filter ? filter.color : "#808080", opacity: inside ? 1 : 0.4 }));
      if (inside && filter && across <= 12) {
        svg.append(draw("text", { x: c + 0.5, y: r + 0.64, "font-size": 0.4, "font-weight": 650, "text-anchor": "middle", fill: "#fff" }, filter.letter));
      }
    }
  }
  if (around) svg.append(draw("rect", { class: "frame", x: 0, y: 0, width: across, height: down }));
  return svg;
}

// One period without letters, for tables.
function smallTile(trials, row) {
  const tile = trials.tile ? trials.tile.words[trials.tile.codes[row]] : "";
  if (!tile) return null;
  const rows = tile.split("/");
  return draw("svg", { class: "tile", viewBox: `0 0 ${rows[0].length} ${rows.length}`, "aria-hidden": "true", "shape-rendering": "crispEdges" },
    ...rows.flatMap((cells, y) => [...cells].map((c, x) => draw("rect", { x, y, width: 1, height: 1, fill: css(colorOf(trials, trials.start[row] + c.charCodeAt(0) - 97)) }))));
}

// The frequency beyond which the sensor of a section samples nothing, in the unit of a column of resolution; none of others.
function nyquistOf(trials, column, section) {
  if (column.name === "mtf50_cy_per_px") return 0.5;
  return column.name === "mtf50_cy_per_mm" ? trials.data.sections[section].nyquist_cy_per_mm : null;
}
function isBeyond(trials, column, row) {
  return column.values[row] > (nyquistOf(trials, column, trials.section[row]) ?? Infinity);
}
function isBeyondNyquist(trials, row) {
  return trials.columns.some((column) => isBeyond(trials, column, row));
}
// The edge response of such a trial stays near one half or rises again, so that a small change moves MTF50 far.
function isPlateau(trials, row) {
  const { reliability } = trials;
  return reliability?.words[reliability.codes[row]] === "plateau";
}
function markOf(trials, column, row) {
  if (isBeyond(trials, column, row)) return " beyond Nyquist";
  return column.name.startsWith("mtf50_") && isPlateau(trials, row) ? " of a plateau" : null;
}

// How many in a hundred of the trials with as many colours are worse.
function rankOf(trials, column, row) {
  if (!column.better || !Number.isFinite(column.values[row])) return "";
  let [worse, all] = [0, 0];
  for (let i = 0; i < trials.count; i += 1) {
    if (trials.colors[i] !== trials.colors[row] || trials.section[i] !== trials.section[row] || !Number.isFinite(column.values[i])) continue;
    all += 1;
    // What no reader tells apart is equal.
    const ahead = (column.better === "higher" ? 1 : -1) * (column.values[row] - column.values[i]);
    if (ahead > 1e-4 * Math.abs(column.values[row])) worse += 1;
  }
  return all > 1 ? `${Math.floor((100 * worse) / (all - 1))} %` : "";
}
function figuresOf(trials, row) {
  const table = make("table", {}, make("caption", { class: "hidden-text" }, "Figures of the trial"),
    make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "Figure"), make("th", { scope: "col", class: "number" }, "Value"),
      make("th", { scope: "col", class: "number", title: "of the trials with as many colours" }, "Better than"))));
  const body = make("tbody");
  for (const column of trials.columns.filter((c) => !c.parameter && c.name !== "colors" && Number.isFinite(c.values[row]))) {
    const mark = markOf(trials, column, row);
    body.append(make("tr", { title: column.doc }, make("th", { scope: "row" }, column.label, mark ? make("span", { class: "beyond" }, mark) : null),
      make("td", { class: "number" }, shown(column.values[row]), make("span", { class: "unit" }, column.unit.replace("cycles", "cy").replace("pixel", "px"))),
      make("td", { class: "number" }, rankOf(trials, column, row))));
  }
  table.append(body);
  return table;
}
function filterTable(filters) {
  const head = ["nm", "Centre", "FWHM", "Peak"];
  return make("table", {}, make("caption", { class: "hidden-text" }, "Filters of the design"),
    make("thead", {}, make("tr", {}, ...head.map((t, i) => make("th", { scope: "col", class: i ? "number" : "" }, t)))),
    make("tbody", {}, ...filters.map((f) => {
      const swatch = make("i", { class: "swatch" });
      swatch.style.background = f.color;
      return make("tr", {}, make("th", { scope: "row" }, swatch, f.letter), ...[f.center, f.fwhm, f.peak].map((v) => make("td", { class: "number" }, shown(v))));
    })));
}

// A picture that is enlarged by a click; `copy` makes it a second time, for that.
function enlargeable(picture, words, copy) {
  const enlarge = () => {
    const dialog = make("dialog", { "aria-label": words }, copy(),
      make("form", { method: "dialog" }, make("span", {}, words), make("button", {}, "Close")));
    dialog.addEventListener("close", () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
  };
  return make("button", { type: "button", click: enlarge, "aria-haspopup": "dialog" }, picture);
}
function embedded({ src, width, height }, words) {
  const image = (alt) => make("img", { src, width, height, alt });
  return enlargeable(image(words), words, () => image(""));
}
// A canvas that is drawn a little later; `done` is told when it is, `failed` why it cannot be.
function drawnHere(trials, row, which, words, done, failed) {
  const { rows, cols } = drawnOf(trials, row).light.scenes[which].light.planes;
  const canvas = () => make("canvas", { width: cols, height: rows, role: "img", "aria-label": words });
  const shown = canvas();
  trials.simulator ??= new Simulator(trials);
  trials.simulator.draw(row, which, PICTURES[which].isNoisy, () => shown.isConnected).then((picture) => {
    if (!picture) return;
    shown.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(picture.rgba.buffer), cols, rows), 0, 0);
    shown.dataset.drawn = picture.ms.toFixed(1);
    done();
  }).catch(failed);
  return enlargeable(shown, words, () => {
    const copy = canvas();
    copy.getContext("2d").drawImage(shown, 0, 0);
    return copy;
  });
}
const PICTURES = [
  { words: "Zone plate, pixel for pixel, without noise", name: "exact", isNoisy: false },
  { words: "Dead leaves, with all noise", name: "", isNoisy: true },
];
function picturesOf(trials, row, number) {
  const both = (picture) => make("div", { class: "pictures" }, PICTURES.map(({ words, name }, which) =>
    make("figure", { class: name }, picture(which, `${words}, trial ${number}`), make("figcaption", {}, words))));
  const say = (words) => make("p", { class: "none" }, words);
  const command = () => commandOf(trials, row, `--picture ${number} -o trial-${number}.html`);
  const own = trials.pictures.get(row);
  if (own) return [both((which, words) => embedded([own.zone_plate, own.scene][which], words))];
  const drawn = drawnOf(trials, row);
  if (drawn.none) return [say(`The page has no pictures of this trial: ${drawn.none}.${drawn.is_elsewhere ? " This command makes a page with them:" : ""}`), drawn.is_elsewhere ? command() : null];
  const place = make("div");
  const failed = (error) => place.replaceChildren(say(`The page could not draw its pictures: ${error.message}. This command makes a page with them:`), command());
  const about = "Computed in this page; identical to the picture of `smalti report --picture`.";
  const state = make("p", { class: "none", role: "status" }, drawn.is_learned ? "Learning the pipeline of this trial …" : "Drawing …");
  const done = () => { state.textContent = about; };
  place.append(both((which, words) => drawnHere(trials, row, which, words, done, failed)), state);
  return [place];
}
function drawnOf(trials, row) {
  return trials.data.sections[trials.section[row]].drawn;
}
function commandOf(trials, row, options) {
  const study = trials.data.studies[trials.data.sections[trials.section[row]].study];
  return make("div", { class: "copyable" }, make("pre", { tabindex: "0" }, `smalti report ${study.dir} ${options}`),
    make("button", { type: "button", "data-copy": true }, "Copy command"));
}

function showTrial(trials, row, panel) {
  const filters = filtersOf(trials, row);
  const number = trials.number[row];
  const words = trials.words.filter((w) => ![trials.tile, trials.reliability].includes(w) && w.words[w.codes[row]]).map((w) => w.words[w.codes[row]]);
  const tile = trials.tile ? trials.tile.words[trials.tile.codes[row]] : "";
  panel.replaceChildren(
    make("h3", {}, `Trial ${number}`),
    make("p", { class: "sub" }, [`${trials.colors[row]} colours`, ...words, trials.front[row] ? "on the Pareto front" : null].filter(Boolean).join(" · ")),
    spectraOf(trials, filters),
    make("div", { class: "halves" },
      make("div", {}, make("h4", {}, "Mosaic"), tile ? tileOf(tile, filters) : null),
      make("div", {}, make("h4", {}, "Filters"), filterTable(filters))),
    make("h4", {}, "Figures"), figuresOf(trials, row),
    make("h4", {}, "Pictures"), ...picturesOf(trials, row, number).filter(Boolean),
    make("h4", {}, "As a camera for other commands"), commandOf(trials, row, `--camera ${number} > trial-${number}.toml`),
  );
  if (filters.some((f) => !f.curve)) {
    const why = trials.curves.blocks.length ? "The page has no spectra of some filters: it would be too large." : "This browser cannot decompress the spectra of the filters.";
    panel.append(make("p", { class: "none" }, why));
  }
}

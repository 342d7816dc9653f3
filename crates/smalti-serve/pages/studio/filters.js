// @ts-check
// The filters: their curves with handles, and the numbers of the one that is selected.
import { announce, byId, draw, make, message, setOptions, tell, tellRange, textScale } from "./dom.js";
import { letters, withFilter } from "./design.js";
import { filterOfCsv } from "./files.js";
import { drawnAxes, drawnCurves, frameOf, spectrum } from "./filter-plot.js";
import { FIRST_NM, LAST_NM, SHAPES, drawnOver, handlesOf, likeShape, pigmentsText, shapeOf } from "./shapes.js";
import { THICKEST, THINNEST, baseOf, editedShape, ofThickness, thicknessHandles, thicknessOf } from "./thickness.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./engine.js").Curves} Curves */
/** @typedef {import("./engine.js").Engine} Engine */

const DRAWN_STEP_NM = 5;
/** Where the sensitivity of silicon ends, nm. */
const SILICON_NM = 1100;
/** Half of the side of a handle. */
const HANDLE = 8;

/** The value of a curve at a wavelength, on a line between its samples. @param {number[]} xs @param {number[]} ys @param {number} x */
function valueAt(xs, ys, x) {
  if (x <= xs[0]) return ys[0];
  for (let i = 1; i < xs.length; i += 1) {
    if (x <= xs[i]) return ys[i - 1] + (ys[i] - ys[i - 1]) * (x - xs[i - 1]) / (xs[i] - xs[i - 1]);
  }
  return ys[ys.length - 1];
}

/**
 * Sets up plot and fields. `curves` has the curves of the design, once they are known.
 * @param {Store} store @param {Engine} engine @param {() => Curves | undefined} curves
 * @returns {{ show: () => void, take: (name: string, text: string) => void }}
 */
export function setUpFilters(store, engine, curves) {
  const { catalogue } = engine;
  const place = byId("plot", HTMLDivElement);
  const panel = byId("filter", HTMLDivElement);
  /** @type {import("./filter-plot.js").Kind} */
  let kind = "transmittance";
  let isDrawing = false;
  let cursorNm = 550;
  let frame = frameOf(440, 230, 1);
  const x = (/** @type {number} */ nm) => frame.x(nm);
  const y = (/** @type {number} */ value) => frame.y(value);
  const svg = draw("svg", { role: "group", "aria-label": "Curves of the filters over wavelength, 380 to 780 nm" });
  place.append(svg);

  const [back, lines, front] = [draw("g", { "aria-hidden": "true" }), draw("g", { "aria-hidden": "true" }), draw("g")];
  svg.append(spectrum("spectrum"), back, lines, front);

  const filter = () => store.camera.sensor.cfa.filters[store.selected];
  const channel = () => curves()?.channels.find((c) => c.letter === store.selected);
  const at = (/** @type {number} */ nm) => {
    const [all, own] = [curves(), channel()];
    return all && own ? valueAt(all.wavelengths_nm, own.transmittance, nm) : 0;
  };
  /** @param {import("./design.js").Filter} to @param {string} what @param {string} [key] */
  const change = (to, what, key) => store.change(withFilter(store.camera, store.selected, to), `${what} of ${store.selected}`, key);

  function showLines() {
    const all = curves();
    if (!all) return;
    const dragged = handles().map(({ nm, value }) => ({ left: x(nm) - HANDLE, right: x(nm) + HANDLE, top: y(value) - HANDLE, bottom: y(value) + HANDLE }));
    lines.replaceChildren(...drawnCurves(frame, all, kind, store.selected, dragged));
  }

  /** The curves of built-in filters by name, once they are known; those of filters that are not known everywhere end with the plot, or with the simulation. @type {Map<string, import("./thickness.js").Samples>} */
  const builtin = new Map();
  /** @param {string} name */
  async function readBuiltin(name) {
    const curve = async (/** @type {number} */ first, /** @type {number} */ step, /** @type {number} */ last) => {
      const [values] = await engine.transmittances([{ builtin: name }], [first, step, last]);
      return { start_nm: first, step_nm: step, values };
    };
    const nm = curves()?.wavelengths_nm ?? [400, 410, 700];
    builtin.set(name, await curve(FIRST_NM, DRAWN_STEP_NM, SILICON_NM).catch(() => curve(FIRST_NM, DRAWN_STEP_NM, LAST_NM)).catch(() => curve(nm[0], nm[1] - nm[0], nm[nm.length - 1])));
    if (baseOf(filter()).builtin === name) showHandles();
  }
  /** The built-in filters whose curves were asked for. @type {Set<string>} */
  const asked = new Set();
  /** The curve that the selected filter has with its own thickness; `undefined` until it is known. @returns {import("./thickness.js").Samples | undefined} */
  function ownCurve() {
    const base = baseOf(filter());
    if (shapeOf(base) === "samples") return base.samples;
    const name = /** @type {string} */ (base.builtin);
    if (!asked.has(name)) readBuiltin(name).catch(() => {});
    asked.add(name);
    return builtin.get(name);
  }
  /** The points of the selected filter that are dragged. */
  function handles() {
    if (kind !== "transmittance") return [];
    if (editedShape(filter()) !== "builtin") return handlesOf(filter(), at, cursorNm);
    const curve = ownCurve();
    return curve ? thicknessHandles(filter(), curve) : [];
  }
  /** @type {number | undefined} */
  let held;
  function showHandles() {
    const all = handles();
    while (front.children.length > all.length) front.lastElementChild?.remove();
    all.forEach((handle, i) => {
      let mark = front.children[i];
      if (!mark) {
        mark = draw("g", { class: "handle", role: "slider", tabindex: 0 }, draw("circle", { class: "reach", r: 14 }), draw("circle", { class: "dot", r: 6.5 }));
        listen(/** @type {SVGGElement} */ (mark), i);
        front.append(mark);
      }
      const nm = Math.min(Math.max(handle.nm, FIRST_NM), LAST_NM);
      mark.setAttribute("transform", `translate(${x(nm).toFixed(1)} ${y(handle.value).toFixed(1)})`);
      mark.setAttribute("aria-label", `${store.selected}: ${handle.label}`);
      const [least, most, now] = handle.isLevel ? [0, 100, handle.value * 100] : [300, 1100, handle.nm];
      mark.setAttribute("aria-orientation", handle.isLevel ? "vertical" : "horizontal");
      mark.setAttribute("aria-valuemin", String(least));
      mark.setAttribute("aria-valuemax", String(most));
      mark.setAttribute("aria-valuenow", String(Math.round(now)));
      mark.setAttribute("aria-valuetext", handle.said ?? `${Number(handle.nm.toFixed(1))} nm, ${Math.round(handle.value * 100)} %`);
      mark.querySelector(".dot")?.setAttribute("fill", channel()?.color ?? "#888888");
    });
  }

  /** @param {PointerEvent} event @returns {[number, number]} */
  function point(event) {
    const box = svg.getBoundingClientRect();
    const { width, height, margin } = frame;
    const [px, py] = [(event.clientX - box.left) * width / box.width, (event.clientY - box.top) * height / box.height];
    const nm = FIRST_NM + (px - margin.left) / (width - margin.left - margin.right) * (LAST_NM - FIRST_NM);
    return [nm, Math.min(Math.max((height - margin.bottom - py) / (height - margin.top - margin.bottom), 0), 1)];
  }

  /** @param {SVGGElement} mark @param {number} index */
  function listen(mark, index) {
    let drags = 0;
    mark.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || isDrawing) return;
      event.preventDefault();
      event.stopPropagation();
      mark.focus();
      mark.setPointerCapture(event.pointerId);
      held = index;
      drags += 1;
    });
    mark.addEventListener("pointermove", (event) => {
      if (held !== index || !mark.hasPointerCapture(event.pointerId)) return;
      const handle = handles()[index];
      if (handle) change(handle.set(...point(event)), handle.label.toLowerCase(), `drag ${index} ${drags}`);
    });
    mark.addEventListener("lostpointercapture", () => {
      held = undefined;
      store.end();
    });
    mark.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 10 : 1;
      const move = /** @type {Record<string, [number, number]>} */ ({ ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step / 100], ArrowDown: [0, -step / 100] })[event.key];
      const handle = handles()[index];
      if (!move || !handle) return;
      event.preventDefault();
      if (editedShape(filter()) === "samples" && move[0] !== 0) {
        cursorNm = Math.min(Math.max(handle.nm + Math.sign(move[0]) * filter().samples.step_nm, FIRST_NM), LAST_NM);
        showHandles();
        return;
      }
      change(handle.set(handle.nm + move[0], handle.value + move[1]), handle.label.toLowerCase(), `keys ${store.selected} ${index}`);
    });
  }

  /** The curve of the selected filter as samples. @returns {import("./design.js").Filter | undefined} */
  function asSamples() {
    if (shapeOf(filter()) === "samples") return { samples: filter().samples };
    if (!channel()) return undefined;
    const values = Array.from({ length: (LAST_NM - FIRST_NM) / DRAWN_STEP_NM + 1 }, (_, i) => Number(Math.min(Math.max(at(FIRST_NM + i * DRAWN_STEP_NM), 0), 1).toFixed(4)));
    return { samples: { start_nm: FIRST_NM, step_nm: DRAWN_STEP_NM, values } };
  }

  let strokes = 0;
  /** @type {[number, number] | undefined} */
  let last;
  svg.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    const [nm, value] = point(event);
    if (!isDrawing) {
      // The nearest curve becomes the selected one.
      const all = curves();
      if (!all) return;
      const distance = (/** @type {Curves["channels"][number]} */ c) => Math.abs(valueAt(all.wavelengths_nm, c[kind], nm) - value);
      const nearest = all.channels.reduce((a, b) => (distance(b) < distance(a) ? b : a));
      if (distance(nearest) < 0.08) store.select(nearest.letter);
      return;
    }
    event.preventDefault();
    svg.setPointerCapture(event.pointerId);
    strokes += 1;
    last = [nm, value];
  });
  svg.addEventListener("pointermove", (event) => {
    if (!isDrawing || !last || !svg.hasPointerCapture(event.pointerId)) return;
    const samples = asSamples()?.samples;
    if (!samples) return;
    const to = point(event);
    change(drawnOver(samples, last, to), "the drawn curve", `drawn ${strokes}`);
    [last, cursorNm] = [to, to[0]];
  });
  svg.addEventListener("lostpointercapture", () => {
    last = undefined;
    store.end();
  });

  for (const button of document.querySelectorAll("[data-curve]")) {
    button.addEventListener("click", () => {
      kind = /** @type {typeof kind} */ (/** @type {HTMLElement} */ (button).dataset.curve);
      for (const other of document.querySelectorAll("[data-curve]")) other.setAttribute("aria-pressed", String(other === button));
      showLines();
      showHandles();
    });
  }

  /** The place, the width and the peak of the selected filter. */
  function extent() {
    const [all, own] = [curves(), channel()];
    if (!all || !own) return { center: 550, fwhm: 80, peak: 0.9 };
    const top = Math.max(...own.transmittance);
    const inside = all.wavelengths_nm.filter((_, i) => own.transmittance[i] >= top / 2);
    return { center: (inside[0] + inside[inside.length - 1]) / 2, fwhm: Math.max(inside[inside.length - 1] - inside[0], 10), peak: top };
  }

  /** @param {string} shape */
  function toShape(shape) {
    if (shape === "samples") {
      const samples = asSamples();
      if (samples) change(samples, "the shape");
    } else change(shape === "builtin" ? { builtin: catalogue.filters[0] } : likeShape(shape, extent()), "the shape");
  }

  /** The fields that are shown: they are made anew only for another filter or shape, so that the focus stays. */
  let shown = "";
  /** @type {(() => void)[]} */
  let refreshers = [];

  /** @param {import("./shapes.js").Parameter} parameter @param {() => number} get @param {(value: number) => import("./design.js").Filter} set */
  function number({ key, label, title, isWide, unit, min, max, step }, get, set) {
    const input = make("input", { type: "number", min, max, step: "any", "data-parameter": key, input: () => {
      const value = input.valueAsNumber;
      if (Number.isFinite(value) && value >= min && value <= max) change(set(value), label.toLowerCase(), `field ${store.selected} ${key}`);
    }, change: () => {
      if (!(input.valueAsNumber >= min && input.valueAsNumber <= max)) tellRange(label, min, max, unit);
      store.end();
    }, blur: () => { input.value = shownNow(); }, keydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
      event.preventDefault();
      const by = (event.key === "ArrowUp" ? 1 : -1) * step * (event.shiftKey ? 10 : 1);
      change(set(Number(Math.min(Math.max(get() + by, min), max).toFixed(4))), label.toLowerCase(), `field ${store.selected} ${key}`);
      input.value = String(get());
    } });
    const shownNow = () => String(Number(get().toFixed(4)));
    refreshers.push(() => { if (store.jumps || document.activeElement !== input) input.value = shownNow(); });
    return make("label", { class: `field number${isWide ? " wide" : ""}`, title }, make("span", {}, label), make("span", { class: "unit" }, input, unit));
  }

  function fields() {
    const shape = editedShape(filter());
    const own = () => baseOf(filter())[shape];
    /** @type {HTMLElement[]} */
    const rows = (SHAPES[shape]?.parameters ?? []).map((p) => number(p, () => own()[p.key] ?? (p.key === "leakage" ? 0 : 1), (value) => ({ [shape]: { ...own(), [p.key]: value } })));
    if (shape === "flat") rows.push(number({ key: "flat", label: "Transmittance", unit: "", min: 0, max: 1, step: 0.01 }, own, (value) => ({ flat: value })));
    if (shape === "dye") {
      own().bands.forEach((/** @type {any} */ _, /** @type {number} */ i) => {
        const of = (/** @type {string} */ key, /** @type {string} */ label, /** @type {string} */ unit, /** @type {number} */ min, /** @type {number} */ max, /** @type {number} */ step, title = "") =>
          number({ key: `${key} ${i}`, label: `${label} ${i + 1}`, title: title || undefined, isWide: title !== "", unit, min, max, step }, () => own().bands[i][key],
            (value) => ({ dye: { ...own(), bands: own().bands.map((/** @type {any} */ b, /** @type {number} */ j) => (j === i ? { ...b, [key]: value } : b)) } }));
        rows.push(of("center_nm", "Band", "nm", 300, 1100, 0.5), of("fwhm_nm", "Width", "nm", 1, 400, 0.5), of("absorbance", "Peak absorbance", "", 0, 20, 0.01, "Proportional to the thickness of the layer"));
      });
    }
    if (shape === "builtin") {
      const select = make("select", { change: () => change({ builtin: select.value }, "the curve") });
      // Bands of multispectral mosaics are built in without being listed.
      refreshers.push(() => setOptions(select, [...new Set([...catalogue.filters, own()])].map((name) => /** @type {[string, string]} */ ([name, name])), own()));
      rows.push(make("label", { class: "field number" }, make("span", {}, "Curve"), select));
    }
    if (shape === "builtin" || shape === "samples") {
      const title = "Relative to the curve as it is built in, drawn or read. Absorbance is proportional to thickness (Beer–Lambert law)";
      rows.push(number({ key: "thickness", label: "Relative thickness", title, unit: "×", min: THINNEST, max: THICKEST, step: 0.05 }, () => thicknessOf(filter()), (value) => {
        const curve = ownCurve();
        return curve ? ofThickness(baseOf(filter()), curve, value) : filter();
      }));
    }
    if (shape === "samples") {
      const layers = make("p", { class: "wide hint" });
      refreshers.push(() => { layers.textContent = pigmentsText(channel()?.pigments ?? null); });
      rows.push(layers);
    }
    return rows;
  }

  function showPanel() {
    const shape = editedShape(filter());
    const key = JSON.stringify([store.selected, shape, filter().dye?.bands.length, letters(store.camera)]);
    if (key !== shown) {
      shown = key;
      refreshers = [];
      const select = make("select", { "aria-label": `Shape of filter ${store.selected}`, change: () => toShape(select.value) },
        ...Object.entries(SHAPES).map(([value, { name }]) => make("option", { value }, name)));
      select.value = shape;
      const pencil = make("button", { type: "button", "aria-pressed": String(isDrawing), title: "Draw the curve with the pointer", click: () => {
        isDrawing = !isDrawing;
        pencil.setAttribute("aria-pressed", String(isDrawing));
        place.toggleAttribute("data-drawing", isDrawing);
        if (isDrawing) announce("Draw over the plot. With the keyboard, choose the shape Drawn and move its point.");
      } }, "Draw");
      const lock = make("input", { type: "checkbox", change: () => store.toggleLock(store.lockedFilters, store.selected) });
      refreshers.push(() => { lock.checked = store.lockedFilters.has(store.selected); });
      panel.replaceChildren(
        make("div", { class: "filter-head" }, make("span", { class: "which" }, `Filter ${store.selected}`), select, pencil, make("label", { class: "check", title: "Improve and Global search keep the curve and the cells of this filter" }, lock, "Lock")),
        make("div", { class: "fields" }, ...fields()),
      );
    }
    for (const refresh of refreshers) refresh();
  }

  function show() {
    showLines();
    showHandles();
    showPanel();
  }
  new ResizeObserver(() => {
    frame = frameOf(Math.max(place.clientWidth, 200), Math.max(place.clientHeight, 120), textScale());
    svg.setAttribute("viewBox", `0 0 ${frame.width} ${frame.height}`);
    back.replaceChildren(...drawnAxes(frame, "spectrum"));
    show();
  }).observe(place);
  store.on(["design", "view"], show);

  return {
    show,
    take(name, text) {
      try {
        const { filter: taken, isPercent } = filterOfCsv(text);
        change(taken, `the curve ${name}`);
        tell(`Filter ${store.selected} has the curve of ${name}${isPercent ? ", read as percent" : ""}.`);
      } catch (error) {
        tell(`${name}: ${message(error)}`, "trouble");
      }
    },
  };
}

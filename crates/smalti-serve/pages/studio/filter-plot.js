// @ts-check
// The drawing of the curves of filters over wavelength, on the page and in its reports.
import { draw } from "./dom.js";
import { placeLabels } from "./labels.js";
import { FIRST_NM, LAST_NM } from "./shapes.js";

/** @typedef {import("./engine.js").Curves} Curves */
/** What is drawn of a filter: its transmittance, or electrons per photon behind lens and infrared cut. @typedef {"transmittance" | "quantum_efficiency"} Kind */
/** The place of the curves: its size, and the coordinates of a wavelength in nm and of a value. @typedef {{ width: number, height: number, scale: number, margin: { left: number, right: number, top: number, bottom: number }, x: (nm: number) => number, y: (value: number) => number }} Frame */

/** The colours of the axis of wavelengths, a hint and no measurement. */
const SPECTRUM = [[380, "#45307a"], [420, "#4036a8"], [460, "#2a62c9"], [490, "#1f9fb5"], [520, "#3fae4a"], [560, "#a8b93a"], [585, "#e0b22e"], [610, "#e5792b"], [650, "#d03a2b"], [780, "#5a1414"]];

/** @param {number} width @param {number} height @param {number} scale The size of text, relative to the usual one. @returns {Frame} */
export function frameOf(width, height, scale) {
  const margin = { left: 34 * scale, right: 10, top: 10, bottom: 30 * scale };
  return {
    width, height, scale, margin,
    x: (nm) => margin.left + (nm - FIRST_NM) / (LAST_NM - FIRST_NM) * (width - margin.left - margin.right),
    y: (value) => height - margin.bottom - value * (height - margin.top - margin.bottom),
  };
}

/** The gradient of the axis of wavelengths. @param {string} id Its name within the document. */
export const spectrum = (id) => draw("defs", {}, draw("linearGradient", { id }, ...SPECTRUM.map(([nm, color]) =>
  draw("stop", { offset: (Number(nm) - FIRST_NM) / (LAST_NM - FIRST_NM), "stop-color": color }))));

/** The axes. @param {Frame} frame @param {string} id The name of the gradient. @returns {SVGElement[]} */
export function drawnAxes({ width, height, margin, x, y }, id) {
  const ticks = [400, 500, 600, 700];
  const levels = [0, 0.25, 0.5, 0.75, 1];
  return [
    ...levels.map((v) => draw("line", { class: v === 0 ? "axis" : "rule", x1: margin.left, x2: width - margin.right, y1: y(v), y2: y(v) })),
    ...levels.filter((v) => v * 2 % 1 === 0).map((v) => draw("text", { class: "tick", x: margin.left - 7, y: y(v) + 4, "text-anchor": "end" }, v === 0.5 ? "0.5" : String(v))),
    draw("rect", { x: x(FIRST_NM), y: y(0) + 2, width: x(LAST_NM) - x(FIRST_NM), height: 5, rx: 2.5, fill: `url(#${id})` }),
    ...ticks.map((nm) => draw("text", { class: "tick", x: x(nm), y: height - 7, "text-anchor": "middle" }, String(nm))),
    draw("text", { class: "tick", x: width - margin.right, y: height - 7, "text-anchor": "end" }, "nm"),
  ];
}

/**
 * The light, the lens and the curves of the filters with their letters.
 * @param {Frame} frame @param {Curves} curves @param {Kind} kind @param {string} [selected] The filter that is emphasised.
 * @param {import("./labels.js").Box[]} [taken] Where no letter stands. @returns {SVGElement[]}
 */
export function drawnCurves({ width, margin, scale, x, y }, curves, kind, selected, taken = []) {
  const xs = curves.wavelengths_nm;
  const path = (/** @type {number[]} */ ys) => xs.map((nm, i) => `${i === 0 ? "M" : "L"}${x(nm).toFixed(1)} ${y(Math.max(ys[i], 0)).toFixed(1)}`).join("");
  const area = `${path(curves.light.map((v) => v * 0.96))}L${x(xs[xs.length - 1])} ${y(0)}L${x(xs[0])} ${y(0)}Z`;
  const order = [...curves.channels].sort((a, b) => Number(a.letter === selected) - Number(b.letter === selected));
  const pointsOf = (/** @type {number[]} */ ys) => xs.map((nm, i) => /** @type {[number, number]} */ ([x(nm), y(Math.max(ys[i], 0))]));
  const others = [curves.lens_transmittance, ...(kind === "quantum_efficiency" ? [curves.sensor_quantum_efficiency] : [])].map(pointsOf);
  const placed = placeLabels([...order].reverse().map((c) => ({ letter: c.letter, points: pointsOf(c[kind]) })), others, taken,
    { left: margin.left, right: width - 2, top: 0, bottom: y(0) }, scale);
  return [
    draw("path", { class: "lamp", d: area }),
    draw("path", { class: "lens", d: path(curves.lens_transmittance) }),
    ...(kind === "quantum_efficiency" ? [draw("path", { class: "silicon", d: path(curves.sensor_quantum_efficiency) })] : []),
    ...order.flatMap((c) => {
      const d = path(c[kind]);
      const isSelected = c.letter === selected;
      return [draw("path", { class: "casing", d, "stroke-width": isSelected ? 5.5 : 3.6 }), draw("path", { class: "curve", d, stroke: c.color, "stroke-width": isSelected ? 3.4 : 1.8 })];
    }),
    ...[...placed].map(([letter, [px, py]]) =>
      draw("text", { class: `letter${letter === selected ? " selected" : ""}`, x: px.toFixed(1), y: py.toFixed(1), "text-anchor": "middle", "dominant-baseline": "central" }, letter)),
  ];
}

// @ts-check
// The drawing of expected figures over luminance, on the page and in its reports.
import { draw } from "./dom.js";
import { text } from "./numbers.js";
import { LUMINANCES } from "./work.js";

/** @typedef {import("./engine.js").Expected} Expected */
/** @typedef {Exclude<keyof Expected, "luminance_cd_m2" | "time_s">} Figure */
/** Expected figures of a design and of the pinned one, and the luminance of the picture, cd/m². @typedef {{ own: Expected[], pin: Expected[], luminance: number }} OverLight */
/**
 * The greatest luminance without noticeable clipping of the design, `undefined` until it is known, and of the pinned one, cd/m²; and the share of the samples that may clip, percent.
 * @typedef {{ own: number | undefined, pin: number, most: number }} Clips
 */

/** What the figures are called. @type {Record<Figure, string>} */
export const FIGURES = { cpsnr_db: "CPSNR, dB", delta_e_2000: "ΔE2000", scielab: "S-CIELAB", detail_db: "Detail, dB" };

/** Whether there is a curve of a figure. @param {OverLight} over @param {Figure} key */
export const hasCurve = (over, key) => [...over.own, ...over.pin].some((e) => Number.isFinite(e[key]));

/** What is said of clipping. @param {Clips} clips */
export function clippingText({ own, pin, most }) {
  const [darkest, brightest] = [LUMINANCES[0], LUMINANCES[LUMINANCES.length - 1]];
  const shown = (/** @type {number} */ limit) => (limit < darkest ? "all" : limit >= brightest ? "none" : `${Number(limit.toPrecision(3))} cd/m²`);
  const start = "Expected figures do not include clipping";
  const [much, ofPin] = [`more than ${most} % of the samples clip`, shown(pin) === shown(own ?? Infinity) ? "" : "the pinned design"];
  const pinned = ofPin && `; ${ofPin}: ${{ all: "at every one", none: "at none" }[shown(pin)] ?? `above ${shown(pin)}`}`;
  if (own === undefined) return `${start}.`;
  if (own < darkest) return `${start}: at every luminance shown (dotted${pinned}), ${much}.`;
  if (own < brightest) return `${start}: above ${shown(own)} (dotted${pinned}), ${much}.`;
  if (!ofPin) return `${start}. Up to ${brightest} cd/m², at most ${most} % of the samples of this scene clip.`;
  return `${start}: more than ${most} % of the samples of ${ofPin} clip ${shown(pin) === "all" ? "at every luminance shown" : `above ${shown(pin)}`} (dotted).`;
}

/**
 * The curves of a figure, dotted where the design clips, and what they show in words.
 * @param {{ width: number, height: number, scale: number }} size `scale` is the size of text, relative to the usual one.
 * @param {OverLight} over @param {Clips} clips @param {Figure} key @returns {{ drawn: SVGElement[], label: string }}
 */
export function lightPlot({ width, height, scale }, over, clips, key) {
  const all = [...over.own, ...over.pin].map((e) => e[key]).filter(Number.isFinite);
  const margin = { left: 36 * scale, right: 18 * scale, top: 10, bottom: 24 * scale };
  const [low, high] = nice(Math.min(...all), Math.max(...all));
  const [begin, end] = [over.own[0], over.own[over.own.length - 1]];
  const [first, last] = [begin, end].map((e) => Math.log10(e.luminance_cd_m2));
  const x = (/** @type {number} */ luminance) => margin.left + (Math.log10(luminance) - first) / (last - first) * (width - margin.left - margin.right);
  const y = (/** @type {number} */ v) => height - margin.bottom - (v - low) / (high - low) * (height - margin.top - margin.bottom);
  const path = (/** @type {[number, number][]} */ points) => points.map(([px, py], i) => `${i === 0 ? "M" : "L"}${px.toFixed(1)} ${py.toFixed(1)}`).join("");
  /** @param {string} kind @param {Expected[]} curve @param {number} limit */
  const curve = (kind, curve, limit) => {
    const points = curve.map((e) => /** @type {[number, number]} */ ([x(e.luminance_cd_m2), y(e[key])]));
    const [sound, clipped] = cut(points, limit > 0 ? x(limit) : -Infinity);
    return [...(clipped.length > 1 ? [draw("path", { class: `${kind} clips`, d: path(clipped) })] : []), ...(sound.length > 1 ? [draw("path", { class: kind, d: path(sound) })] : [])];
  };
  const decades = Array.from({ length: Math.round(last - first) + 1 }, (_, i) => 10 ** (Math.round(first) + i));
  const drawn = [
    ...[low, (low + high) / 2, high].flatMap((v) => [
      draw("line", { class: "rule", x1: margin.left, x2: width - margin.right, y1: y(v), y2: y(v) }),
      draw("text", { class: "tick", x: margin.left - 6, y: y(v) + 4, "text-anchor": "end" }, text(v, (high - low) % 2 === 0 ? 0 : 1)),
    ]),
    ...decades.map((d) => draw("text", { class: "tick", x: x(d), y: height - 7, "text-anchor": "middle" }, String(Number(d.toPrecision(1))))),
    draw("line", { class: "here", x1: x(over.luminance), x2: x(over.luminance), y1: margin.top, y2: height - margin.bottom }),
    ...curve("pinned", over.pin, clips.pin),
    ...curve("own", over.own, clips.own ?? Infinity),
  ];
  const ends = `from ${text(begin[key], 1)} at ${begin.luminance_cd_m2} cd/m² to ${text(end[key], 1)} at ${end.luminance_cd_m2} cd/m²`;
  return { drawn, label: `Expected ${FIGURES[key]} over luminance, ${ends}. ${clippingText(clips)}` };
}

/**
 * A line in two: up to a place and beyond it, which share the point there.
 * @param {[number, number][]} points @param {number} at @returns {[[number, number][], [number, number][]]}
 */
function cut(points, at) {
  const after = points.findIndex(([x]) => x > at);
  if (after < 0) return [points, []];
  if (after === 0) return [[], points];
  const [[x0, y0], [x1, y1]] = [points[after - 1], points[after]];
  const middle = /** @type {[number, number]} */ ([at, y0 + (y1 - y0) * (at - x0) / (x1 - x0)]);
  return [[...points.slice(0, after), middle], [middle, ...points.slice(after)]];
}

/** Round numbers around a range. @param {number} low @param {number} high @returns {[number, number]} */
function nice(low, high) {
  const span = Math.max(high - low, 0.5);
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100].find((s) => span / s <= 6) ?? 200;
  return [Math.floor(low / step) * step, Math.max(Math.ceil(high / step) * step, Math.floor(low / step) * step + step)];
}

// @ts-check
// The thickness of a filter. Its absorbance is proportional to it (Beer–Lambert law): T(t) = c (T / c)^t, with the transmittance c without any absorbance, as the
// library has it for filters that deviate (`Deviation`). A camera file states no thickness, so that a filter of another one is a curve in samples.
import { shapeOf } from "./shapes.js";

/** @typedef {import("./design.js").Filter} Filter */
/** @typedef {{ start_nm: number, step_nm: number, values: number[] }} Samples */

/** The thinnest and the thickest layer, relative to that of the filter. */
export const [THINNEST, THICKEST] = [0.25, 4];
/** Transmittance without any absorbance, as of the pigments of searches; of a filter that transmits more, its largest one. */
const CLEAR = 0.95;
/** The wavelengths at which a handle may lie, nm. */
const [FIRST_NM, LAST_NM] = [400, 700];

/** Filters of another thickness than the one that they were made from. A filter is an object that never changes, also in the history. @type {WeakMap<object, { of: Filter, thickness: number }>} */
const made = new WeakMap();

/** The filter from which one of another thickness was made; itself, if it was not made so. @param {Filter} filter @returns {Filter} */
export const baseOf = (filter) => made.get(filter)?.of ?? filter;
/** The thickness relative to that filter. @param {Filter} filter */
export const thicknessOf = (filter) => made.get(filter)?.thickness ?? 1;
/** The shape that is edited. @param {Filter} filter */
export const editedShape = (filter) => shapeOf(baseOf(filter));

/** @param {Samples} samples */
const clearOf = ({ values }) => values.reduce((a, b) => Math.max(a, b), CLEAR);

/** A filter of another thickness. @param {Filter} base @param {Samples} samples Its curve. @param {number} thickness @returns {Filter} */
export function ofThickness(base, samples, thickness) {
  const t = Math.round(Math.min(Math.max(thickness, THINNEST), THICKEST) * 100) / 100;
  if (t === 1) return base;
  const clear = clearOf(samples);
  const filter = { samples: { ...samples, values: samples.values.map((v) => Number((clear * (Math.max(v, 0) / clear) ** t).toFixed(6))) } };
  made.set(filter, { of: base, thickness: t });
  return filter;
}

/**
 * The handle that changes the thickness, on the curve where it changes most: where a layer of thickness 1 transmits a share of 1/e. A curve that absorbs nowhere has none.
 * @param {Filter} filter @param {Samples} samples The curve of its base. @returns {import("./shapes.js").Handle[]}
 */
export function thicknessHandles(filter, samples) {
  const clear = clearOf(samples);
  const off = (/** @type {number} */ v) => Math.abs(v / clear - 1 / Math.E);
  const all = samples.values.map((value, i) => ({ value, nm: samples.start_nm + i * samples.step_nm })).filter(({ nm }) => nm >= FIRST_NM && nm <= LAST_NM);
  const usable = all.filter(({ value }) => value > 0.02 * clear && value < 0.98 * clear);
  if (usable.length === 0) return [];
  const { value, nm } = usable.reduce((a, b) => (off(b.value) < off(a.value) ? b : a));
  const share = Math.log(value / clear);
  const now = thicknessOf(filter);
  return [{
    label: "Relative thickness", nm, value: clear * Math.exp(now * share), isLevel: true, said: `${now} times as thick`,
    set: (_, y) => ofThickness(baseOf(filter), samples, Math.log(Math.max(y, 1e-4) / clear) / share),
  }];
}

/** The same filters as objects that are known already, where they are equal: what is known of their thickness stays. @param {Record<string, Filter>} filters @param {Record<string, Filter>} known */
export const keptEqual = (filters, known) => Object.fromEntries(Object.entries(filters).map(([letter, filter]) =>
  [letter, JSON.stringify(filter) === JSON.stringify(known[letter]) ? known[letter] : filter]));

/** Comments of a camera file on the filters that have another thickness. @param {Record<string, Filter>} filters */
export function thicknessComments(filters) {
  const changed = Object.entries(filters).filter(([, filter]) => thicknessOf(filter) !== 1);
  return changed.map(([letter, filter]) =>
    `# sensor.cfa.filters.${letter}: ${baseOf(filter).builtin ?? "a drawn curve"} at ${thicknessOf(filter)} times its thickness (Beer–Lambert law), in samples.\n`).join("");
}

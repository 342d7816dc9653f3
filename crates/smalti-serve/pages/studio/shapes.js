// @ts-check
// The shapes of filters: their numbers as fields, and the handles that change them. The curves themselves come from the engine.

/** @typedef {import("./design.js").Filter} Filter */
/** A number of a shape; with `isWide`, its long name has a line of its own. @typedef {{ key: string, label: string, title?: string, isWide?: boolean, unit: string, min: number, max: number, step: number }} Parameter */
/** A point that is dragged; `set` gives the filter with the point elsewhere. With `isLevel` it moves only up and down; `said` is what it says instead of its place. @typedef {{ label: string, nm: number, value: number, isLevel?: boolean, said?: string, set: (nm: number, value: number) => Filter }} Handle */

/** The wavelengths of the plot, nm. */
export const [FIRST_NM, LAST_NM] = [380, 780];
/** Half of the width at half maximum of a Gaussian, in standard deviations. */
const HALF_WIDTH = Math.sqrt(2 * Math.LN2);

const nm = (/** @type {string} */ key, /** @type {string} */ label, min = 300, max = 1100) => ({ key, label, unit: "nm", min, max, step: 0.5 });
const width = (/** @type {string} */ key, /** @type {string} */ label, min = 1) => nm(key, label, min, 400);
const peak = { key: "peak", label: "Peak", unit: "", min: 0, max: 1, step: 0.01 };

/** @type {Record<string, { name: string, parameters: Parameter[] }>} */
export const SHAPES = {
  gaussian: { name: "Gaussian", parameters: [nm("center_nm", "Centre"), width("sigma_nm", "Sigma"), peak] },
  raised_cosine: { name: "Raised cosine", parameters: [nm("center_nm", "Centre"), width("fwhm_nm", "Width"), peak] },
  butterworth: { name: "Flat top", parameters: [nm("center_nm", "Centre"), width("fwhm_nm", "Width"), { key: "order", label: "Order", unit: "", min: 1, max: 20, step: 1 }, peak] },
  box: { name: "Box", parameters: [nm("low_nm", "From"), nm("high_nm", "To"), peak] },
  long_pass: { name: "Long-pass", parameters: [nm("edge_nm", "Edge"), width("width_nm", "Edge width", 0.5), peak] },
  short_pass: { name: "Short-pass", parameters: [nm("edge_nm", "Edge"), width("width_nm", "Edge width", 0.5), peak] },
  flat: { name: "Flat", parameters: [] },
  dye: { name: "Dye", parameters: [peak, { key: "leakage", label: "Leakage", unit: "", min: 0, max: 1, step: 0.005 }] },
  builtin: { name: "Built-in", parameters: [] },
  samples: { name: "Drawn", parameters: [] },
};

/** @param {Filter} filter */
export const shapeOf = (filter) => Object.keys(filter)[0];

/** The pigments of a filter in words, nothing if none make it. @param {import("./engine.js").Layer[] | null} pigments */
export function pigmentsText(pigments) {
  if (!pigments) return "";
  if (pigments.length === 0) return "Clear: no pigment.";
  const thickness = (/** @type {number} */ t) => (t < 0.01 ? t.toPrecision(1) : t.toFixed(2));
  return `Pigments: ${pigments.map((p) => `${thickness(p.thickness)} × ${p.name}`).join(" + ")}. A thickness of 1 is that of the built-in filter.`;
}

/** A curve in words. @param {Filter} filter */
export function curveText(filter) {
  const shape = shapeOf(filter);
  const p = filter[shape];
  const { name, parameters } = SHAPES[shape] ?? { name: shape, parameters: [] };
  if (shape === "builtin") return `Built-in curve ${p}`;
  if (shape === "flat") return `${name}, transmittance ${p}`;
  if (shape === "samples") return `Curve in ${p.values.length} samples from ${p.start_nm} nm in steps of ${p.step_nm} nm`;
  const stated = parameters.filter(({ key }) => p[key] !== undefined).map(({ key, label, unit }) => `${label.toLowerCase()} ${p[key]}${unit && ` ${unit}`}`);
  const bands = (p.bands ?? []).map((/** @type {any} */ b) => `band ${b.center_nm} nm, width ${b.fwhm_nm} nm, peak absorbance ${b.absorbance}`);
  return [name, ...stated, ...bands].join(", ");
}

const clamp = (/** @type {number} */ x, /** @type {number} */ low, /** @type {number} */ high) => Math.min(Math.max(x, low), high);
const round = (/** @type {number} */ x, /** @type {number} */ step) => Number((Math.round(x / step) * step).toFixed(4));
const toNm = (/** @type {number} */ x) => round(clamp(x, 300, 1100), 0.5);
const toWidth = (/** @type {number} */ x, least = 1) => round(clamp(x, least, 400), 0.5);
const toShare = (/** @type {number} */ x) => round(clamp(x, 0, 1), 0.01);

/** A filter of another shape, about as wide and in the same place. @param {string} shape @param {{ center: number, fwhm: number, peak: number }} like @returns {Filter} */
export function likeShape(shape, { center, fwhm, peak: top }) {
  const [center_nm, fwhm_nm, most] = [toNm(center), toWidth(clamp(fwhm, 5, 300)), toShare(top)];
  switch (shape) {
    case "gaussian": return { gaussian: { center_nm, sigma_nm: toWidth(fwhm_nm / 2 / HALF_WIDTH), peak: most } };
    case "raised_cosine": return { raised_cosine: { center_nm, fwhm_nm, peak: most } };
    case "butterworth": return { butterworth: { center_nm, fwhm_nm, order: 3, peak: most } };
    case "box": return { box: { low_nm: toNm(center - fwhm_nm / 2), high_nm: toNm(center + fwhm_nm / 2), peak: most } };
    case "long_pass": return { long_pass: { edge_nm: toNm(center - fwhm_nm / 2), width_nm: 8, peak: most } };
    case "short_pass": return { short_pass: { edge_nm: toNm(center + fwhm_nm / 2), width_nm: 8, peak: most } };
    case "flat": return { flat: most };
    default: return { dye: { bands: [{ center_nm, fwhm_nm: 80, absorbance: 1.5 }], peak: 0.95, leakage: 0 } };
  }
}

/** @param {Filter} filter @param {(nm: number) => number} at The curve, for the height of handles on it. @param {number} cursorNm Of drawn curves. @returns {Handle[]} */
export function handlesOf(filter, at, cursorNm) {
  const shape = shapeOf(filter);
  const p = filter[shape];
  const top = p.peak ?? 1;
  const changed = (/** @type {Record<string, any>} */ values) => ({ [shape]: { ...p, ...values } });
  switch (shape) {
    case "gaussian":
      return [
        { label: "Centre and peak", nm: p.center_nm, value: top, set: (x, y) => changed({ center_nm: toNm(x), peak: toShare(y) }) },
        ...sides(p.center_nm, p.sigma_nm * HALF_WIDTH, top, (half) => changed({ sigma_nm: toWidth(half / HALF_WIDTH) })),
      ];
    case "raised_cosine": case "butterworth":
      return [
        { label: "Centre and peak", nm: p.center_nm, value: top, set: (x, y) => changed({ center_nm: toNm(x), peak: toShare(y) }) },
        ...sides(p.center_nm, p.fwhm_nm / 2, top, (half) => changed({ fwhm_nm: toWidth(2 * half) })),
      ];
    case "box": {
      const half = (p.high_nm - p.low_nm) / 2;
      return [
        { label: "Centre and peak", nm: p.low_nm + half, value: top, set: (x, y) => changed({ low_nm: toNm(x - half), high_nm: toNm(x + half), peak: toShare(y) }) },
        { label: "Lower edge", nm: p.low_nm, value: top / 2, set: (x) => changed({ low_nm: toNm(Math.min(x, p.high_nm - 1)) }) },
        { label: "Upper edge", nm: p.high_nm, value: top / 2, set: (x) => changed({ high_nm: toNm(Math.max(x, p.low_nm + 1)) }) },
      ];
    }
    case "long_pass": case "short_pass": {
      const side = shape === "long_pass" ? 1 : -1;
      const far = clamp(p.edge_nm + side * 110, FIRST_NM + 10, LAST_NM - 10);
      return [
        { label: "Edge", nm: p.edge_nm, value: top / 2, set: (x) => changed({ edge_nm: toNm(x) }) },
        // The logistic curve is at 90 % after 2.2 widths.
        { label: "Edge width", nm: p.edge_nm + side * 2.2 * p.width_nm, value: 0.9 * top, set: (x) => changed({ width_nm: toWidth(side * (x - p.edge_nm) / 2.2, 0.5) }) },
        { label: "Peak", nm: far, value: top, isLevel: true, set: (_, y) => changed({ peak: Math.max(toShare(y), 0.01) }) },
      ];
    }
    case "flat":
      return [{ label: "Transmittance", nm: 580, value: p, isLevel: true, set: (_, y) => ({ flat: toShare(y) }) }];
    case "dye":
      return p.bands.map((/** @type {any} */ band, /** @type {number} */ i) => {
        const height = at(band.center_nm);
        return {
          label: `Absorption band ${i + 1}, centre and absorbance`, nm: band.center_nm, value: height,
          // A band is deeper the lower its handle is dragged.
          set: (/** @type {number} */ x, /** @type {number} */ y) => changed({ bands: p.bands.map((/** @type {any} */ b, /** @type {number} */ j) => (j === i
            ? { ...b, center_nm: toNm(x), absorbance: round(clamp(b.absorbance - 1.5 * (y - height), 0.02, 10), 0.01) } : b)) }),
        };
      });
    case "samples": {
      const i = Math.round(clamp((cursorNm - p.start_nm) / p.step_nm, 0, p.values.length - 1));
      return [{ label: "Point of the curve", nm: p.start_nm + i * p.step_nm, value: p.values[i], isLevel: true, set: (_, y) => changed({ values: p.values.map((/** @type {number} */ v, /** @type {number} */ j) => (j === i ? toShare(y) : v)) }) }];
    }
    default: return [];
  }
}

/** The handles at half of the peak. @param {number} center @param {number} half @param {number} top @param {(half: number) => Filter} set @returns {Handle[]} */
function sides(center, half, top, set) {
  return [-1, 1].map((side) => ({ label: side < 0 ? "Width, short wavelengths" : "Width, long wavelengths", nm: center + side * half, value: top / 2, set: (x) => set(Math.max(side * (x - center), 1)) }));
}

/** A curve that is drawn over a part of another, from one point to the next. @param {{ start_nm: number, step_nm: number, values: number[] }} samples @param {[number, number]} from @param {[number, number]} to @returns {Filter} */
export function drawnOver(samples, from, to) {
  const [[x0, y0], [x1, y1]] = from[0] <= to[0] ? [from, to] : [to, from];
  const { start_nm, step_nm } = samples;
  const values = samples.values.map((v, i) => {
    const x = start_nm + i * step_nm;
    if (x < x0 - step_nm / 2 || x > x1 + step_nm / 2) return v;
    return toShare(x1 > x0 ? y0 + (y1 - y0) * clamp((x - x0) / (x1 - x0), 0, 1) : to[1]);
  });
  return { samples: { ...samples, values } };
}

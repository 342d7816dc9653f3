// @ts-check
// Of which pigments a filter is made. The search of the library states curves; those of its family "pigments" are layers of a few pigments by the Beer–Lambert law
// (`Pigments` of the library), so that the absorbance of a curve is the sum of theirs, each times its thickness.

/** @typedef {import("./engine.js").Engine} Engine */
/** A pigment in a filter, and its thickness relative to the built-in filter. @typedef {{ name: string, thickness: number }} Layer */

/** The pigments, the transmittance without any, and the largest absorbance of one, as searches of the library have them. */
const NAMES = ["pigment/R", "pigment/G", "pigment/B", "pigment/C", "pigment/M", "pigment/Y"];
const [CLEAR, MOST_ABSORBANCE] = [0.95, 7];
/** A filter is one of pigments if its transmittance differs by less everywhere. */
const APART = 0.005;
/** Thinner layers are none. */
const THINNEST = 0.005;

/** The solution of normal equations; `undefined` where they have none. @param {number[][]} rows Each with its right-hand side at the end. @returns {number[] | undefined} */
function solved(rows) {
  const n = rows.length;
  const m = rows.map((row) => [...row]);
  for (let i = 0; i < n; i += 1) {
    const best = m.slice(i).reduce((a, row, k) => (Math.abs(row[i]) > Math.abs(m[a][i]) ? i + k : a), i);
    [m[i], m[best]] = [m[best], m[i]];
    if (Math.abs(m[i][i]) < 1e-12) return undefined;
    for (let k = 0; k < n; k += 1) {
      if (k === i) continue;
      const by = m[k][i] / m[i][i];
      for (let j = i; j <= n; j += 1) m[k][j] -= by * m[i][j];
    }
  }
  return m.map((row, i) => row[n] / row[i]);
}

/**
 * The layers of a filter: of the fewest pigments that make its curve; `undefined` if none do.
 * @param {number[]} transmittance @param {number[][]} library The transmittances of the pigments at the same wavelengths. @returns {Layer[] | undefined}
 */
export function layersOf(transmittance, library) {
  const absorbances = library.map((curve) => {
    const most = Math.max(...curve);
    return curve.map((v) => Math.min(-Math.log(v / most), MOST_ABSORBANCE));
  });
  const wanted = transmittance.map((v) => -Math.log(Math.max(v, 1e-9) / CLEAR));
  // A difference of absorbance changes the transmittance in proportion to it.
  const weights = transmittance.map((v) => v * v);
  const product = (/** @type {number[]} */ a, /** @type {number[]} */ b) => weights.reduce((sum, w, i) => sum + w * a[i] * b[i], 0);
  const sets = Array.from({ length: 1 << library.length }, (_, bits) => library.flatMap((_, k) => (bits >> k & 1 ? [k] : [])));
  /** @type {{ count: number, error: number, layers: Layer[] } | undefined} */
  let best;
  for (const set of sets.sort((a, b) => a.length - b.length)) {
    if (best && set.length > best.count) break;
    const thicknesses = solved(set.map((k) => [...set.map((j) => product(absorbances[k], absorbances[j])), product(absorbances[k], wanted)]));
    if (!thicknesses || thicknesses.some((d) => d < THINNEST)) continue;
    const made = transmittance.map((_, i) => CLEAR * Math.exp(-set.reduce((sum, k, n) => sum + thicknesses[n] * absorbances[k][i], 0)));
    const error = Math.max(...made.map((v, i) => Math.abs(v - transmittance[i])));
    if (error < APART && error < (best?.error ?? Infinity)) best = { count: set.length, error, layers: set.map((k, n) => ({ name: NAMES[k], thickness: thicknesses[n] })) };
  }
  return best?.layers;
}

/** Layers in words. @param {Layer[]} layers */
export function layersText(layers) {
  if (layers.length === 0) return "Clear: no pigment.";
  return `Pigments: ${layers.map(({ name, thickness }) => `${thickness.toFixed(2)} × ${name}`).join(" + ")}. A thickness of 1 is that of the built-in filter.`;
}

/** The pigments at some wavelengths. */
export class PigmentLibrary {
  /** @type {Map<string, number[][]>} */ #known = new Map();
  /** @type {Engine} */ #engine;

  /** @param {Engine} engine */
  constructor(engine) {
    this.#engine = engine;
  }

  /**
   * Their transmittances; `undefined` until they are known, which `told` hears of.
   * @param {number[]} nm @param {() => void} told @returns {number[][] | undefined}
   */
  at(nm, told) {
    const grid = /** @type {[number, number, number]} */ ([nm[0], nm[1] - nm[0], nm[nm.length - 1]]);
    const key = grid.join();
    const known = this.#known.get(key);
    if (known) return known.length > 0 ? known : undefined;
    // Empty while it is asked for, and where the pigments are not known at these wavelengths.
    this.#known.set(key, []);
    this.#engine.transmittances(NAMES.map((builtin) => ({ builtin })), grid).then((curves) => {
      this.#known.set(key, curves);
      told();
    }, () => {});
    return undefined;
  }
}

// @ts-check
// The light behind lenses. That of the camera with which the page began came with the page; that of every other lens and pixel geometry is
// gathered in a worker of its own, from the same sources, and kept.

/** @typedef {import("./engine.js").Design} Design */
/** What light is of: the training scene with the targets, statistics over the training scenes, or a scene. @typedef {"training" | "statistics" | { scene: string }} LightOf */

/** The name of the lens whose light came with the page. */
export const START = "";
/** Lenses whose light is kept, about 10 MB each. */
const KEPT = 6;

/** A value with the keys of its objects in order, without those that are not stated. @param {any} value @returns {any} */
function ordered(value) {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return value;
  const stated = Object.entries(value).filter(([, v]) => v !== undefined && v !== null);
  return Object.fromEntries(stated.sort(([a], [b]) => (a < b ? -1 : 1)).map(([k, v]) => [k, ordered(v)]));
}

/** The keys of a design that the light on bare pixels depends on, as text. @param {Design} design */
function textOf(design) {
  const { transmittance, ir_cut, ...optics } = design.optics ?? {};
  const { pitch_um, fill_factor } = design.sensor?.pixel ?? {};
  return JSON.stringify(ordered({ optics, pitch_um, fill_factor }));
}

export class Lights {
  /** @type {Design} */ #start;
  /** @type {(of: LightOf, design: Design) => Promise<ArrayBuffer>} */ #gather;
  /** Light by the name of its lens and what it is of. @type {Map<string, Map<string, { bytes: Promise<ArrayBuffer>, isThere: boolean }>>} */
  #kept = new Map();

  /**
   * @param {Design} start The camera whose light came with the page.
   * @param {(of: LightOf, design: Design) => Promise<ArrayBuffer>} gather
   */
  constructor(start, gather) {
    this.#start = start;
    this.#gather = gather;
  }

  /** The name of the lens of a design. @param {Design} design */
  lens(design) {
    const text = textOf(design);
    return text === textOf(this.#start) ? START : text;
  }

  /** Whether some light need not be waited for. @param {Design} design @param {LightOf} of */
  has(design, of) {
    return this.#kept.get(this.lens(design))?.get(JSON.stringify(of))?.isThere ?? false;
  }

  /** The light of a lens as a file, gathered once. @param {Design} design @param {LightOf} of @returns {Promise<ArrayBuffer>} */
  get(design, of) {
    const lens = this.lens(design);
    const kept = this.#kept.get(lens) ?? new Map();
    // The lens used last is the last one.
    this.#kept.delete(lens);
    this.#kept.set(lens, kept);
    for (const oldest of [...this.#kept.keys()].slice(0, -KEPT)) this.#kept.delete(oldest);
    const key = JSON.stringify(of);
    const known = kept.get(key);
    if (known) return known.bytes;
    // What belongs to no lens is that of the camera with which the page began, so that the same lens has the same light.
    const { transmittance, ir_cut } = this.#start.optics ?? {};
    const { pitch_um, fill_factor } = design.sensor?.pixel ?? {};
    const start = this.#start;
    const pixel = { ...start.sensor?.pixel, ...(pitch_um === undefined ? {} : { pitch_um }), ...(fill_factor === undefined ? {} : { fill_factor }) };
    const camera = { ...start, optics: { ...design.optics, transmittance, ir_cut }, sensor: { ...start.sensor, pixel } };
    const made = { bytes: this.#gather(of, camera), isThere: false };
    made.bytes.then(() => { made.isThere = true; }, () => kept.delete(key));
    kept.set(key, made);
    return made.bytes;
  }
}

// @ts-check
// Where a design comes from: the camera that was opened, with a mosaic of the catalogue. The engine gives the filters, which are those of `CAMERA@MOSAIC` of the
// command; filters that were changed on the page take the place of those of the camera.
import { withValue } from "./design.js";

/** @typedef {import("./design.js").Camera} Camera */
/** @typedef {import("./design.js").Filter} Filter */
/** @typedef {import("./engine.js").Design} Design */
/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").ColorArray} ColorArray */
/**
 * Where a design comes from: the camera that was opened, and what was given of it, with the mosaic that was chosen last, as a camera in full and as an array for the
 * engine. `changed` has the filters that were changed before that mosaic was chosen, as the engine states them.
 * @typedef {{ base: Design, camera: Camera, given: ColorArray, changed: object[] }} Origin
 */

/** What is added to the name of a camera that was changed. */
const CHANGED = "-changed";

/** @param {unknown} a @param {unknown} b */
const isEqual = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** A design with its tile in letters and its filters in full, which the page can change. @param {Engine} engine @param {Design} design @returns {Promise<Camera>} */
export async function inFull(engine, design) {
  const { pattern, filters } = await engine.inFull(design.sensor?.cfa ?? {});
  return withArray(design, pattern, filters);
}

/** A design whose tile is in letters, with its filters in the order of the page. @param {Design} design @returns {Camera} */
export const inOrder = (design) => withArray(design, /** @type {string[]} */ (design.sensor?.cfa?.pattern), design.sensor?.cfa?.filters ?? {});

/** @param {Design} design @param {string[]} pattern @param {Record<string, Filter>} filters @returns {Camera} */
function withArray(design, pattern, filters) {
  // In the order in which the mosaic shows them; those that it does not have follow.
  const order = [...new Set([...pattern.join(""), ...Object.keys(filters)])].filter((letter) => letter in filters);
  const ordered = Object.fromEntries(order.map((letter) => [letter, filters[letter]]));
  return /** @type {any} */ (withValue(withValue(design, ["sensor", "cfa", "pattern"], pattern), ["sensor", "cfa", "filters"], ordered));
}

/** A camera that is opened. @param {Engine} engine @param {Design} design @returns {Promise<Origin>} */
export const originOf = async (engine, design) => ({ base: design, camera: await inFull(engine, design), given: design.sensor?.cfa ?? {}, changed: [] });

/**
 * A design with a mosaic of the catalogue. Its filters are those that `CAMERA@MOSAIC` has for the camera that was opened. Filters that were changed by hand replace
 * those of the same kind; sensor, lens and a name that was given by hand stay. `missing` has the letters for which a camera with curves of its own has no filter: it cannot
 * have this mosaic.
 * @param {Engine} engine @param {Camera} camera @param {Origin} origin @param {string} mosaic
 * @returns {Promise<{ camera: Camera, origin: Origin } | { missing: string[] }>}
 */
export async function withMosaic(engine, camera, origin, mosaic) {
  const { base } = origin;
  const found = await engine.mosaic({ base: base.sensor?.cfa ?? {}, given: origin.given, changed: origin.changed, array: camera.sensor.cfa, mosaic });
  if ("missing" in found) return found;
  const { given, in_full, array, changed, is_own } = found;
  const first = (base.name ?? "").replace(/@([^@]+)$/, (end, last) => (engine.catalogue.cfas.some((c) => c.name === last) ? "" : end));
  const plain = (/** @type {Design} */ design) => /** @type {Design} */ (withValue(design, ["sensor", "cfa", "mixtures"], undefined));
  const made = withArray({ ...plain(base), name: is_own ? base.name : `${first}@${mosaic}` }, in_full.pattern, in_full.filters);
  const next = withArray(plain(camera), array.pattern, array.filters);
  const isNamed = camera.name !== origin.camera.name;
  return { camera: { ...next, name: isNamed ? camera.name : made.name }, origin: { base, camera: made, given, changed } };
}

/** A design under the name with which it is saved: a camera that was changed, and was not given a name, is no longer that camera. @param {Camera} camera @param {Origin} origin @returns {Camera} */
export function named(camera, origin) {
  const isAsGiven = camera.name !== origin.camera.name || isEqual(camera, origin.camera);
  return isAsGiven || camera.name.endsWith(CHANGED) ? camera : { ...camera, name: `${camera.name}${CHANGED}` };
}

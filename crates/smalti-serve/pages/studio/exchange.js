// @ts-check
// A camera with another mosaic. The filters are those of `CAMERA@MOSAIC` of the command (`CfaDescription::with_mosaic_of` of the library), with which the tests
// of the page compare them. Filters that were changed on the page take the place of those of the camera.
import { withValue } from "./design.js";

/** @typedef {import("./design.js").Camera} Camera */
/** @typedef {import("./design.js").Filter} Filter */
/** @typedef {import("./engine.js").Design} Design */
/** @typedef {import("./engine.js").Engine["catalogue"]} Catalogue */
/** A filter by its letter and its kind: the name of its generic form, `undefined` where only the letter tells it. @typedef {{ letter: string, filter: Filter, kind: string | undefined }} Own */
/**
 * Where a design comes from: the camera that was opened, and what was given of it, with the mosaic that was chosen last. `kinds` has the kind of each filter that
 * was given. `changed` has the filters that were changed before that mosaic was chosen.
 * @typedef {{ base: Design, camera: Camera, kinds: Record<string, string | undefined>, changed: Own[] }} Origin
 */

/** The kinds that a letter alone does not tell. */
const GENERIC = ["red", "green", "blue", "cyan", "magenta", "yellow", "emerald", "white", "infrared"];
/** What is added to the name of a camera that was changed. */
const CHANGED = "-changed";

/** @param {unknown} a @param {unknown} b */
const isEqual = (a, b) => JSON.stringify(a) === JSON.stringify(b);
/** The kind of a built-in filter: its name, without the infrared that it leaks; clear and white are one kind. @param {string} name */
const kindOf = (name) => name.replace(/\+infrared$/, "").replace(/^clear$/, "white");
/** Whether two filters have the same curve by their names. @param {Filter} a @param {Filter} b */
const isSame = (a, b) => isEqual(a, b) || [a, b].every(({ builtin }) => builtin === "clear" || builtin === "white");

/**
 * The mosaic of the catalogue that a design has: by its name, or by its lines if they and all filters are those of the catalogue.
 * @param {Catalogue} catalogue @param {Design} design
 */
function mosaicOf({ cfas }, { sensor }) {
  const { pattern = "bayer", filters = {} } = sensor?.cfa ?? {};
  if (typeof pattern === "string") {
    const found = cfas.find(({ name, aliases }) => name === pattern || aliases?.includes(pattern));
    if (!found) throw new Error(`sensor.cfa.pattern is "${pattern}"; expected the name of a mosaic of the catalogue, or its lines in letters`);
    return found;
  }
  const isOf = (/** @type {Record<string, Filter>} */ own) => Object.keys(own).length === Object.keys(filters).length && Object.entries(own).every(([l, f]) => filters[l] && isSame(f, filters[l]));
  return cfas.find(({ tile, filters: own }) => isEqual(tile, pattern) && isOf(own));
}

/** The filters of a design, those of the catalogue included. @param {Catalogue} catalogue @param {Design} design @returns {Own[]} */
function ownFilters(catalogue, design) {
  const stated = /** @type {Record<string, any>} */ (design.sensor?.cfa?.filters ?? {});
  const defaults = /** @type {Record<string, any>} */ (mosaicOf(catalogue, design)?.filters ?? {});
  const named = Object.entries(defaults).map(([letter, filter]) => ({ letter, filter: stated[letter] ?? filter, kind: kindOf(filter.builtin) }));
  const others = Object.entries(stated).filter(([letter]) => !(letter in defaults)).map(([letter, filter]) => {
    const kind = kindOf(filter.builtin ?? "");
    return { letter, filter, kind: GENERIC.includes(kind) ? kind : undefined };
  });
  return [...named, ...others];
}

/** That of some filters which serves a letter: one of the same letter, unless it is of another kind; else one of the same kind. @param {Own[]} all @param {string} letter @param {string | undefined} kind */
const serving = (all, letter, kind) =>
  all.find((own) => own.letter === letter && (own.kind === undefined || kind === undefined || own.kind === kind)) ?? all.find((own) => kind !== undefined && own.kind === kind);

/** A design with its tile in letters and its filters in full, which the page can change. @param {Catalogue} catalogue @param {Design} design @returns {Camera} */
export function inFull(catalogue, design) {
  const cfa = design.sensor?.cfa ?? {};
  const isNamed = cfa.pattern === undefined || typeof cfa.pattern === "string";
  const known = isNamed ? mosaicOf(catalogue, design) : undefined;
  const pattern = known ? known.tile : /** @type {string[]} */ (cfa.pattern);
  return withArray(design, pattern, { ...known?.filters, ...cfa.filters });
}

/** @param {Design} design @param {string[]} pattern @param {Record<string, Filter>} filters @returns {Camera} */
function withArray(design, pattern, filters) {
  // In the order in which the mosaic shows them; those that it does not have follow.
  const order = [...new Set([...pattern.join(""), ...Object.keys(filters)])].filter((letter) => letter in filters);
  const ordered = Object.fromEntries(order.map((letter) => [letter, filters[letter]]));
  return /** @type {any} */ (withValue(withValue(design, ["sensor", "cfa", "pattern"], pattern), ["sensor", "cfa", "filters"], ordered));
}

/** A camera that is opened. @param {Catalogue} catalogue @param {Design} design @returns {Origin} */
export function originOf(catalogue, design) {
  const kinds = Object.fromEntries(ownFilters(catalogue, design).map(({ letter, kind }) => [letter, kind]));
  return { base: design, camera: inFull(catalogue, design), kinds, changed: [] };
}

/**
 * A design with another mosaic of the catalogue. Its filters are those that `CAMERA@MOSAIC` has for the camera that was opened. Filters that were changed by hand replace
 * those of the same kind; sensor, lens and a name that was given by hand stay. `missing` has the letters for which a camera with curves of its own has no filter: it cannot
 * have this mosaic.
 * @param {Catalogue} catalogue @param {Camera} camera @param {Origin} origin @param {Catalogue["cfas"][number]} mosaic
 * @returns {{ camera: Camera, origin: Origin, missing: string[] }}
 */
export function withMosaic(catalogue, camera, origin, { name, tile, filters }) {
  const { base } = origin;
  const own = ownFilters(catalogue, base);
  const isGeneric = own.every(({ filter, kind }) => filter.builtin !== undefined && kind === kindOf(filter.builtin));
  const before = origin.camera.sensor.cfa.filters;
  const now = Object.entries(camera.sensor.cfa.filters).filter(([letter]) => letter in before);
  const isOlder = (/** @type {Own} */ { letter, kind }) => !now.some(([l]) => (kind === undefined ? l === letter : origin.kinds[l] === kind));
  const changed = [
    ...now.filter(([letter, filter]) => !isEqual(filter, before[letter])).map(([letter, filter]) => ({ letter, filter, kind: origin.kinds[letter] })),
    ...origin.changed.filter(isOlder),
  ];
  /** @type {Record<string, string>} */
  const kinds = {};
  /** @type {[Record<string, Filter>, Record<string, Filter>]} */
  const [given, kept] = [{}, {}];
  /** @type {string[]} */
  const missing = [];
  for (const [letter, filter] of Object.entries(/** @type {Record<string, any>} */ (filters))) {
    kinds[letter] = kindOf(filter.builtin);
    const found = serving(own, letter, kinds[letter])?.filter;
    const byHand = serving(changed, letter, kinds[letter])?.filter;
    if (!found && !byHand && !isGeneric) missing.push(letter);
    given[letter] = found && !isSame(found, filter) ? found : filter;
    kept[letter] = byHand ?? given[letter];
  }
  const isOwn = mosaicOf(catalogue, base)?.name === name;
  const first = (base.name ?? "").replace(/@([^@]+)$/, (end, last) => (catalogue.cfas.some((c) => c.name === last) ? "" : end));
  const plain = /** @type {Design} */ (withValue(base, ["sensor", "cfa", "mixtures"], undefined));
  const made = withArray({ ...plain, name: isOwn ? base.name : `${first}@${name}` }, tile, given);
  const isNamed = camera.name !== origin.camera.name;
  const next = withArray(/** @type {Design} */ (withValue(camera, ["sensor", "cfa", "mixtures"], undefined)), tile, kept);
  return { camera: { ...next, name: isNamed ? camera.name : made.name }, origin: { base, camera: made, kinds, changed }, missing };
}

/** A design under the name with which it is saved: a camera that was changed, and was not given a name, is no longer that camera. @param {Camera} camera @param {Origin} origin @returns {Camera} */
export function named(camera, origin) {
  const isAsGiven = camera.name !== origin.camera.name || isEqual(camera, origin.camera);
  return isAsGiven || camera.name.endsWith(CHANGED) ? camera : { ...camera, name: `${camera.name}${CHANGED}` };
}

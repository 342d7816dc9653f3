// @ts-check
// The order of work: first the picture of the latest change, then its scores, then what it is compared with. Newer changes interrupt.

import { withAllFilters } from "./design.js";

/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").Picture} Picture */
/** @typedef {import("./engine.js").Scores} Scores */
/** @typedef {import("./engine.js").Expected} Expected */
/** @typedef {import("./design.js").Camera} Camera */
/** What is shown. @typedef {{ camera: Camera, pinned: Camera | undefined, scene: string, luminance: number, family: import("./engine.js").Family }} Wanted */
/** What of the picture is looked at: the pinned one, the map of differences from the reference, and that from the pinned one. @typedef {{ pin: boolean, map: boolean, pinMap: boolean }} Seen */
/** What goes on beside each other. @typedef {"pictures" | "figures"} Loop */
/**
 * Where results go. A picture without scores comes first, unless the map of differences is looked at; the same with scores follows. The pinned picture is
 * `undefined` while none is known for the scene and the light. `clipping` has the luminance beyond which each design clips the scene noticeably. `waits` says whose light is being gathered, for a picture or for figures. `worked` follows the first
 * result of a loop, `done` the last results of both.
 * @typedef {{
 *   picture: (picture: Picture, wanted: Wanted) => void, pinned: (picture: Picture | undefined, wanted: Wanted) => void,
 *   pinMap: (difference: Float32Array | undefined, of: Picture) => void, curves: (curves: import("./engine.js").Curves, wanted: Wanted) => void, clipping: (own: number, pinned: number) => void,
 *   figures: (own: Scores, pinned: Scores | undefined, wanted: Wanted) => void, overLight: (own: Expected[], pinned: Expected[], luminance: number) => void, done: () => void,
 *   worked: (loop: Loop) => void, failed: (loop: Loop, error: unknown) => void, waits: (design: Camera | undefined, isForPicture: boolean) => void,
 * }} Results
 */

/** Scores are computed when no change came for this time, ms, */
const PAUSE_MS = 120;
/** and not as soon as the picture is there: a pointer that moves on must be heard first. */
const PAUSE_AFTER_PICTURE_MS = 40;
/** The light of the curves, cd/m². */
export const LUMINANCES = Array.from({ length: 9 }, (_, i) => 10 ** (-1 + i / 2));

/** The last results for a text that says what they are of. @template T */
class Last {
  /** @type {{ key: string, value: T } | undefined} */ #kept;

  /** @param {string} key */
  has(key) { return this.#kept?.key === key; }

  /** @param {string} key @param {() => Promise<T | null>} make @returns {Promise<T | null>} */
  async get(key, make) {
    if (this.#kept?.key === key) return this.#kept.value;
    const value = await make();
    if (value !== null) this.#kept = { key, value };
    return value;
  }
}

/** @param {Engine} engine @param {() => Wanted} wanted @param {() => Seen} seen @param {Results} results */
export function setUpWork(engine, wanted, seen, results) {
  let version = 0;
  let changedAt = 0;
  /** The version of the last results of each loop. @type {Record<Loop, number>} */
  const done = { pictures: -1, figures: -1 };
  /** Ends what waits for the light of an older version. */
  let renew = () => {};
  /** @type {Promise<void>} */
  let renewed = new Promise((resolve) => { renew = resolve; });
  /** @type {Last<Picture>} */ const pinPicture = new Last();
  /** @type {Last<Float32Array>} */ const pinMap = new Last();
  /** @type {Last<number>} */ const pinClipping = new Last();
  /** @type {Last<Scores>} */ const pinFigures = new Last();
  let showFirst = () => {};
  /** Resolves once the first picture is shown or has failed. @type {Promise<void>} */
  const firstShown = new Promise((resolve) => { showFirst = resolve; });
  /** Loops at work. @type {Set<Loop>} */
  const busy = new Set();

  /**
   * Runs `work` for the latest version until none is newer. It answers whether it has all results: another request may have taken the place of one of its own.
   * @param {Loop} name @param {(isOld: () => boolean) => Promise<boolean>} work
   */
  async function loop(name, work) {
    if (busy.has(name)) return;
    busy.add(name);
    for (let mine = -1; mine !== version;) {
      mine = version;
      const isOld = () => version !== mine;
      try {
        const isComplete = await work(isOld);
        if (isOld()) continue;
        if (!isComplete) {
          mine = -1;
          continue;
        }
        done[name] = mine;
        if (done.pictures === done.figures) results.done();
      } catch (error) {
        if (name === "pictures") showFirst();
        if (!isOld()) results.failed(name, error);
      }
    }
    busy.delete(name);
  }

  /**
   * Waits for light that must be gathered, or for a newer version.
   * @param {Camera} design @param {import("./engine.js").LightOf[]} all @param {() => boolean} isOld
   */
  async function light(design, all, isOld) {
    if (engine.hasLight(design, all)) return;
    const isForPicture = all[0] !== "statistics";
    results.waits(design, isForPicture);
    await Promise.race([engine.light(design, all), renewed]);
    if (!isOld()) results.waits(undefined, isForPicture);
  }

  /** Waits until no change came for some time, or for a newer version, which must not wait. */
  function pause() {
    const rest = Math.max(changedAt + PAUSE_MS - performance.now(), PAUSE_AFTER_PICTURE_MS);
    return Promise.race([new Promise((resolve) => { setTimeout(resolve, rest); }), renewed]);
  }

  /** @param {() => boolean} isOld */
  async function pictures(isOld) {
    const now = wanted();
    const { camera, pinned, scene, luminance } = now;
    const request = { design: camera, scene, luminance };
    await light(camera, ["training", { scene }], isOld);
    if (isOld()) return false;
    results.waits(undefined, true);
    const first = await engine.draw({ ...request, measure: seen().map });
    if (!first) return false;
    results.worked("pictures");
    results.picture(first, now);
    showFirst();
    const pinKey = JSON.stringify([pinned, scene, luminance]);
    if (!pinPicture.has(pinKey)) results.pinned(undefined, now);
    const showPin = async () => {
      if (pinned) await light(pinned, ["training", { scene }], isOld);
      if (isOld()) return false;
      const picture = pinned && await pinPicture.get(pinKey, () => engine.draw({ design: pinned, scene, luminance, measure: true }));
      if (isOld() || picture === null) return false;
      results.pinned(picture, now);
      return true;
    };
    const mapKey = JSON.stringify([camera, pinKey]);
    if (!pinMap.has(mapKey)) results.pinMap(undefined, first);
    if (isOld()) return false;
    if (seen().pinMap && pinned) {
      await light(pinned, ["training", { scene }], isOld);
      if (isOld()) return false;
      const map = await pinMap.get(mapKey, () => engine.difference(camera, pinned, scene, luminance));
      if (isOld() || map === null) return false;
      results.pinMap(map, first);
    }
    if (seen().pin && !pinPicture.has(pinKey)) await showPin();
    if (isOld()) return false;
    await pause();
    if (isOld()) return false;
    const measured = first.scores ? first : await engine.draw({ ...request, measure: true });
    if (isOld()) return false;
    if (!measured) return false;
    results.picture(measured, now);
    if (!(await showPin())) return false;
    const own = await engine.clipping(camera, scene);
    const before = pinned && await pinClipping.get(JSON.stringify([pinned, scene]), () => engine.clipping(pinned, scene));
    if (isOld()) return false;
    results.clipping(own, before ?? Infinity);
    return true;
  }

  /** @param {() => boolean} isOld */
  async function figures(isOld) {
    const now = wanted();
    const { camera, pinned, luminance, family } = now;
    results.curves(await engine.curves(withAllFilters(camera)), now);
    if (isOld()) return false;
    // The first picture comes before figures and their light, which use the same processors.
    await Promise.race([firstShown, renewed]);
    if (isOld()) return false;
    const waiting = [camera, pinned].filter((design) => design && !engine.hasLight(design, ["statistics"]));
    if (waiting.length > 0) {
      // The figures of the array alone need no light.
      const array = await engine.scores(camera, [], { family });
      if (!array || isOld()) return false;
      results.figures(array, pinned && await engine.scores(pinned, []) || undefined, now);
      results.overLight([], [], luminance);
      // After the light of the picture.
      for (const design of waiting) if (design && !isOld()) await light(design, ["statistics"], isOld);
      if (isOld()) return false;
    }
    const own = await engine.scores(camera, [luminance, ...LUMINANCES], { family });
    if (!own || isOld()) return false;
    const before = pinned && await pinFigures.get(JSON.stringify([pinned, luminance]), () => engine.scores(pinned, [luminance, ...LUMINANCES]));
    if (before === null || isOld()) return false;
    results.worked("figures");
    results.figures(own, before, now);
    results.overLight(own.expected.slice(1), before?.expected.slice(1) ?? [], luminance);
    return true;
  }

  /** Computes what is shown anew. */
  return () => {
    version += 1;
    changedAt = performance.now();
    renew();
    renewed = new Promise((resolve) => { renew = resolve; });
    loop("pictures", pictures);
    loop("figures", figures);
  };
}

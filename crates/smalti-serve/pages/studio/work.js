// @ts-check
// The order of work: first the picture of the latest change, then its scores, then what it is compared with. Newer changes interrupt.

/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").Picture} Picture */
/** @typedef {import("./engine.js").Scores} Scores */
/** @typedef {import("./engine.js").Expected} Expected */
/** @typedef {import("./design.js").Camera} Camera */
/** What is shown. @typedef {{ camera: Camera, pinned: Camera | undefined, scene: string, luminance: number, family: import("./engine.js").Family }} Wanted */
/**
 * Where results go. A picture without scores comes first, the same with scores follows. `waits` says whose light is being gathered, for a picture or for figures.
 * @typedef {{
 *   picture: (picture: Picture, wanted: Wanted) => void, pinned: (picture: Picture | undefined) => void, curves: (curves: import("./engine.js").Curves) => void,
 *   figures: (own: Scores, pinned: Scores | undefined) => void, overLight: (own: Expected[], pinned: Expected[]) => void, done: () => void, failed: (error: unknown) => void,
 *   waits: (design: Camera | undefined, isForPicture: boolean) => void,
 * }} Results
 */

/** Scores are computed when no change came for this time, ms. */
const PAUSE_MS = 120;
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

/** @param {Engine} engine @param {() => Wanted} wanted @param {() => boolean} isPinSeen @param {Results} results */
export function setUpWork(engine, wanted, isPinSeen, results) {
  let version = 0;
  /** Ends what waits for the light of an older version. */
  let renew = () => {};
  /** @type {Promise<void>} */
  let renewed = new Promise((resolve) => { renew = resolve; });
  /** @type {Last<Picture>} */ const pinPicture = new Last();
  /** @type {Last<Scores>} */ const pinFigures = new Last();
  /** Loops at work. @type {Set<string>} */
  const busy = new Set();

  /** Runs `work` for the latest version until none is newer. @param {string} name @param {(isOld: () => boolean) => Promise<void>} work */
  async function loop(name, work) {
    if (busy.has(name)) return;
    busy.add(name);
    for (let done = -1; done !== version;) {
      done = version;
      const mine = version;
      try {
        await work(() => version !== mine);
      } catch (error) {
        if (version === mine) results.failed(error);
      }
    }
    busy.delete(name);
  }

  /**
   * Waits for light that must be gathered, or for a newer version.
   * @param {Camera} design @param {import("./engine.js").LightOf[]} all @param {() => boolean} isOld
   */
  async function light(design, all, isOld) {
    const gathered = engine.light(design, all);
    if (!gathered) return;
    const isForPicture = all[0] !== "statistics";
    results.waits(design, isForPicture);
    await Promise.race([gathered, renewed]);
    if (!isOld()) results.waits(undefined, isForPicture);
  }

  const pause = () => new Promise((resolve) => { setTimeout(resolve, PAUSE_MS); });

  /** @param {() => boolean} isOld */
  async function pictures(isOld) {
    const now = wanted();
    const { camera, pinned, scene, luminance } = now;
    const request = { design: camera, scene, luminance };
    await light(camera, ["training", { scene }], isOld);
    if (isOld()) return;
    results.waits(undefined, true);
    const first = await engine.draw(request);
    if (first) results.picture(first, now);
    const pinKey = JSON.stringify([pinned, scene, luminance]);
    const showPin = async () => {
      if (pinned) await light(pinned, ["training", { scene }], isOld);
      if (isOld()) return;
      const picture = pinned && await pinPicture.get(pinKey, () => engine.draw({ design: pinned, scene, luminance, measure: true }));
      if (!isOld() && picture !== null) results.pinned(picture);
    };
    if (isOld()) return;
    if (isPinSeen() && !pinPicture.has(pinKey)) await showPin();
    await pause();
    if (isOld()) return;
    const measured = await engine.draw({ ...request, measure: true });
    if (isOld()) return;
    if (measured) results.picture(measured, now);
    await showPin();
    if (!isOld()) results.done();
  }

  /** @param {() => boolean} isOld */
  async function figures(isOld) {
    const { camera, pinned, luminance, family } = wanted();
    results.curves(await engine.curves(camera));
    if (isOld()) return;
    const all = engine.light(camera, ["statistics"]) || (pinned && engine.light(pinned, ["statistics"]));
    if (all) {
      // The figures of the array alone need no light.
      const array = await engine.scores(camera, [], { family });
      if (!array || isOld()) return;
      results.figures(array, pinned && await engine.scores(pinned, []) || undefined);
      results.overLight([], []);
      // After the light of the picture.
      for (const design of [camera, pinned]) if (design && !isOld()) await light(design, ["statistics"], isOld);
      if (isOld()) return;
    }
    const own = await engine.scores(camera, [luminance, ...LUMINANCES], { family });
    if (!own || isOld()) return;
    const before = pinned && await pinFigures.get(JSON.stringify([pinned, luminance]), () => engine.scores(pinned, [luminance, ...LUMINANCES]));
    results.figures(own, before ?? undefined);
    results.overLight(own.expected.slice(1), before?.expected.slice(1) ?? []);
  }

  /** Computes what is shown anew. */
  return () => {
    version += 1;
    renew();
    renewed = new Promise((resolve) => { renew = resolve; });
    loop("pictures", pictures);
    loop("figures", figures);
  };
}

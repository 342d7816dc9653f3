// @ts-check
// Where a design begins to clip a scene. Expected figures describe no clipped samples, and statistics of light do not tell their share; pictures do.

/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./design.js").Camera} Camera */

/** Share of the samples from which on a design clips noticeably, percent: that of the warning. */
export const CLIPS_PERCENT = 1;
/** The least luminance of the slider, in decades, and its steps. */
const [FIRST, STEP, STEPS] = [-1, 0.05, 80];
/** Results that are kept. */
const KEPT = 16;
/** A change soon after another one is not waited for, ms. */
const PAUSE_MS = 200;

/** A luminance of the slider, cd/m². @param {number} step */
const luminanceAt = (step) => Number((10 ** (FIRST + step * STEP)).toPrecision(3));

export class Clipping {
  /** @type {Engine} */ #engine;
  /** @type {Map<string, number>} */ #known = new Map();
  #version = 0;

  /** @param {Engine} engine */
  constructor(engine) {
    this.#engine = engine;
  }

  /** Ends what is at work: the design or the scene has changed. */
  stop() {
    this.#version += 1;
  }

  /**
   * The greatest luminance of the slider at which each design clips at most 1 % of the samples of a scene, cd/m²: 0 if it clips more at all of them, infinite if at none.
   * `undefined` once `stop` was called. The share rises with the luminance, or stays where the exposure is automatic.
   * @param {Camera[]} cameras @param {string} scene @returns {Promise<number[] | undefined>}
   */
  async of(cameras, scene) {
    this.stop();
    const mine = this.#version;
    const found = [];
    for (const camera of cameras) {
      const key = JSON.stringify([camera, scene]);
      let limit = this.#known.get(key);
      if (limit === undefined) {
        await new Promise((resolve) => { setTimeout(resolve, PAUSE_MS); });
        limit = await this.#search(camera, scene, () => this.#version !== mine);
        if (limit === undefined) return undefined;
        this.#known.set(key, limit);
        for (const oldest of [...this.#known.keys()].slice(0, -KEPT)) this.#known.delete(oldest);
      }
      found.push(limit);
    }
    return this.#version === mine ? found : undefined;
  }

  /** @param {Camera} camera @param {string} scene @param {() => boolean} isOld @returns {Promise<number | undefined>} */
  async #search(camera, scene, isOld) {
    const clips = async (/** @type {number} */ step) => await this.#engine.saturated(camera, scene, luminanceAt(step)) > CLIPS_PERCENT;
    if (isOld()) return undefined;
    if (!(await clips(STEPS))) return isOld() ? undefined : Infinity;
    // It does not clip at the first one, and clips at the last one.
    let [below, above] = [-1, STEPS];
    while (above - below > 1) {
      if (isOld()) return undefined;
      const middle = (below + above) >> 1;
      if (await clips(middle)) above = middle;
      else below = middle;
    }
    return below < 0 ? 0 : luminanceAt(below);
  }
}
